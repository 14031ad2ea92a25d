//! Colours by world normal: what a frame that hides a place shows of the same object where it is turned the same way.
//!
//! All sums and means are whole numbers, so that their order does not matter and a device has the same.

use std::collections::BTreeMap;

use crate::blur::reference::visible::{Colour, Frame, Surface};

/// Bins along each side of the octahedral map.
pub const SIDE: usize = 32;
/// Bins of an object.
pub const BINS: usize = SIDE * SIDE;
/// Units of a channel, of the frame's scale.
const UNITS: f32 = 65_536.0;
/// The largest scale.
const LARGEST_SCALE: f32 = 16.0;
/// The largest channel in units.
const MOST: u32 = 65_535;

/// The bin of a normal of any length: x and y of the octahedral map, from 0 to 1, times [`SIDE`], rounded down; the bin
/// of (x, y) is `y * SIDE + x`. None where the normal is 0 or not finite.
///
/// The map: n / (|x| + |y| + |z|); where z < 0, x and y become (1 - |y|) sign x and (1 - |x|) sign y, with sign 0 = 1;
/// then half of x and y plus a half.
pub fn bin(normal: [f64; 3]) -> Option<usize> {
    let length: f64 = normal.iter().map(|c| c.abs()).sum();
    if !length.is_finite() || length <= 0.0 {
        return None;
    }
    let [x, y, z] = normal.map(|c| c / length);
    let sign = |c: f64| if c < 0.0 { -1.0 } else { 1.0 };
    let [x, y] = if z < 0.0 { [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)] } else { [x, y] };
    let place = |c: f64| (((c * 0.5 + 0.5) * SIDE as f64) as usize).min(SIDE - 1);
    Some(place(y) * SIDE + place(x))
}

/// The scale of an image: the least power of two that no channel of any pixel, alpha included, is above, 1 to 16. Channels
/// that are not finite do not count; those above 16 are clamped, so that a highlight does not take the others' accuracy.
pub fn scale(image: &[[f32; 4]]) -> f32 {
    let finite = image.iter().flatten().filter(|c| c.is_finite());
    let most = finite.fold(1.0_f32, |most, c| most.max(*c));
    let mut scale = 1.0;
    while scale < most.min(LARGEST_SCALE) {
        scale *= 2.0;
    }
    scale
}

/// Channels in units of 1/65536 of `scale`, rounded, 0 to 65535; 0 where they are not a number. In f32.
pub fn quantised(colour: [f32; 4], scale: f32) -> [u32; 4] {
    // `as` is 0 for what is not a number or below 0.
    colour.map(|c| ((c * (UNITS / scale) + 0.5) as u32).min(MOST))
}

/// Sums over the pixels of a bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sum {
    /// Pixels.
    pub count: u32,
    /// Their [`quantised`] channels.
    pub channels: [u64; 4],
}

impl Sum {
    fn add(&mut self, colour: [u32; 4]) {
        self.count += 1;
        (0..4).for_each(|i| self.channels[i] += u64::from(colour[i]));
    }

    /// The mean, halves rounded up; none of nothing.
    pub fn mean(&self) -> Option<[u32; 4]> {
        let count = u64::from(self.count);
        (count > 0).then(|| self.channels.map(|sum| ((sum + count / 2) / count) as u32))
    }
}

/// Fills bins that are empty by push and pull: each level has half as many bins a side as the one below, and of each the
/// mean of its up to four children that are not empty, each counted once. From the last level, of one bin, back: a bin
/// that is empty gets 9, 3, 3 and 1 sixteenths of the four nearest bins of the level above: its parent, the ones beside
/// it in x and in y on the child's side, and the one in both. Beside the border lies what the octahedron has there:
/// (-1, y) and (n, y) are (0, n - 1 - y) and (n - 1, n - 1 - y), and so for y, x first. Means are rounded, halves up. None
/// if all are empty.
pub fn filled(bins: &[Option<[u32; 4]>]) -> Option<Vec<[u32; 4]>> {
    let mut levels = vec![bins.to_vec()];
    let mut side = SIDE;
    while side > 1 {
        side /= 2;
        let below = &levels[levels.len() - 1];
        let parent = |place: usize| {
            let (x, y) = (2 * (place % side), 2 * (place / side));
            let children = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            let mut sum = Sum::default();
            children.iter().filter_map(|(x, y)| below[y * 2 * side + x]).for_each(|child| sum.add(child));
            sum.mean()
        };
        levels.push((0..side * side).map(parent).collect());
    }
    let mut above = vec![levels.pop()?[0]?];
    while let Some(level) = levels.pop() {
        let fill = |(place, own): (usize, &Option<[u32; 4]>)| own.unwrap_or_else(|| pushed(&above, side, place));
        let next = level.iter().enumerate().map(fill).collect();
        above = next;
        side *= 2;
    }
    Some(above)
}

/// What a bin gets from the level above, which has `side` bins a side.
fn pushed(above: &[[u32; 4]], side: usize, place: usize) -> [u32; 4] {
    let (x, y) = ((place % (2 * side)) as i32, (place / (2 * side)) as i32);
    let beside = |c: i32| c / 2 + 2 * (c % 2) - 1;
    let at = |x: i32, y: i32| {
        let (last, inside) = (side as i32 - 1, 0..side as i32);
        let (x, y) = if inside.contains(&x) { (x, y) } else { (x.clamp(0, last), last - y) };
        let (x, y) = if inside.contains(&y) { (x, y) } else { (last - x, y.clamp(0, last)) };
        above[y as usize * side + x as usize]
    };
    let (own, in_x) = (at(x / 2, y / 2), at(beside(x), y / 2));
    let (in_y, in_both) = (at(x / 2, beside(y)), at(beside(x), beside(y)));
    std::array::from_fn(|i| (9 * own[i] + 3 * in_x[i] + 3 * in_y[i] + in_both[i] + 8) / 16)
}

/// What is learnt of an object in the frame that hides places of it, and in the other one.
#[derive(Clone, Debug, PartialEq)]
pub struct Learnt {
    /// Of each bin: colours that the frame shows at normals of the bin.
    pub shown: Vec<Sum>,
    /// Colours that the other frame shows at normals of the bin.
    pub shown_by_other: Vec<Sum>,
    /// Colours that the other frame shows of the places of those pixels of the frame that both show, by the normals there
    /// in the other frame.
    pub paired: Vec<Sum>,
    /// Over places that both frames show: the sum of products of how far their colours are from [`Table::typical`] and
    /// from [`Table::reference`]; the sum of squares of the latter.
    pub products: [i64; 2],
    /// Over the same places and red, green and blue: the sum of how far the colour in this frame is from its prediction,
    /// and from the colour in the other frame.
    pub errors: [u64; 2],
}

/// Colours of one frame (*this*), learnt for places that only the other one shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What is learnt of each object that either frame shows.
    pub objects: BTreeMap<u32, Learnt>,
    filled: BTreeMap<u32, Filled>,
    /// The scale of both images.
    scale: f32,
}

#[derive(Clone, Debug, PartialEq)]
struct Filled {
    typical: Vec<[u32; 4]>,
    reference: Vec<[u32; 4]>,
}

/// A place that both frames show.
struct Pair {
    object: u32,
    bins: [usize; 2],
    colours: [[u32; 4]; 2],
}

/// A pixel that teaches.
struct Lesson {
    object: u32,
    base: u32,
    weights: [f64; 3],
    bin: usize,
    colour: [u32; 4],
}

/// The pixels of a frame that teach: those of which all four neighbours that there are on screen see the same object, so
/// that borders and what is mixed there do not. By the normal at their centre.
fn lessons(surface: &Surface, frame: &Frame, scale: f32) -> Vec<Lesson> {
    let lesson = |pixel: usize| {
        let (base, weights) = frame.place(pixel)?;
        let bin = bin(frame.normal(surface, base, weights))?;
        let object = surface.objects[base as usize];
        Some(Lesson { object, base, weights, bin, colour: quantised(frame.image[pixel], scale) })
    };
    let inner = (0..frame.image.len()).filter(|pixel| is_inner(surface, frame, *pixel));
    inner.filter_map(lesson).collect()
}

impl Table {
    /// Learns from the inner pixels of both frames, those of which all four neighbours that there are on screen see the
    /// same object. Colours are [`quantised`] by the [`scale`] of both images, the larger of the two.
    ///
    /// 1. [`Learnt::shown`] and [`Learnt::shown_by_other`]: of each inner pixel its colour, by the normal at its centre.
    /// 2. [`Learnt::paired`]: of each inner pixel of `frame` whose place the other frame shows too ([`Frame::look_up`]) the
    ///    colour found there, by the normal there.
    /// 3. *Typical* colours: the means of `shown`, where it is empty of `shown_by_other`, [`filled`]. *Reference* colours:
    ///    the means of `paired`, where it is empty of `shown_by_other`, there of `shown`, [`filled`]. A light that stays
    ///    makes a normal look the same in both frames, so the other one's colour at the normal itself is better than this
    ///    one's at another normal.
    /// 4. [`Learnt::products`]: again of each pixel of 2, how far its colour in this frame is from the typical one, d, and
    ///    that in the other from the reference, e, in units; sums over red, green and blue of d e and of e e. 61 bits hold
    ///    those of 2^26 pixels.
    /// 5. [`Learnt::errors`]: once more of each pixel of 2, how far its colour is from the prediction in whole units, typical
    ///    + ((256 share * e + 128) >> 8), and from that in the other frame.
    pub fn learn(surface: &Surface, frame: &Frame, other: &Frame) -> Table {
        let scale = scale(frame.image).max(scale(other.image));
        let none = || vec![Sum::default(); BINS];
        let nothing =
            || Learnt { shown: none(), shown_by_other: none(), paired: none(), products: [0; 2], errors: [0; 2] };
        let mut objects: BTreeMap<u32, Learnt> = BTreeMap::new();
        for Lesson { object, bin, colour, .. } in lessons(surface, other, scale) {
            objects.entry(object).or_insert_with(nothing).shown_by_other[bin].add(colour);
        }
        let mut pairs = Vec::new();
        for Lesson { object, base, weights, bin: own, colour } in lessons(surface, frame, scale) {
            let learnt = objects.entry(object).or_insert_with(nothing);
            learnt.shown[own].add(colour);
            let look = other.look_up(surface, base, weights).known();
            let Some((there, seen)) = bin(other.normal(surface, base, weights)).zip(look) else { continue };
            let seen = quantised(seen.map(|c| c as f32), scale);
            learnt.paired[there].add(seen);
            pairs.push(Pair { object, bins: [own, there], colours: [colour, seen] });
        }
        let filled = objects.iter().filter_map(|(object, learnt)| Some((*object, learnt.filled()?))).collect();
        let mut table = Table { objects, filled, scale };
        pairs.iter().for_each(|pair| table.compare(pair));
        let predicted: Vec<i64> = table.objects.values().map(Learnt::share_in_256).collect();
        let shares: BTreeMap<u32, i64> = table.objects.keys().copied().zip(predicted).collect();
        pairs.iter().for_each(|pair| table.judge(pair, shares[&pair.object]));
        table
    }

    /// How far the colours of a pair are from the typical and the reference one, in red, green and blue.
    fn apart(&self, pair: &Pair) -> [[i64; 2]; 3] {
        let Some(filled) = self.filled.get(&pair.object) else { return [[0; 2]; 3] };
        let means = [filled.typical[pair.bins[0]], filled.reference[pair.bins[1]]];
        let apart = |k: usize, i: usize| i64::from(pair.colours[k][i]) - i64::from(means[k][i]);
        [0, 1, 2].map(|i| [apart(0, i), apart(1, i)])
    }

    fn compare(&mut self, pair: &Pair) {
        let apart = self.apart(pair);
        let Some(learnt) = self.objects.get_mut(&pair.object) else { return };
        for [d, e] in apart {
            learnt.products[0] += d * e;
            learnt.products[1] += e * e;
        }
    }

    fn judge(&mut self, pair: &Pair, share: i64) {
        let apart = self.apart(pair);
        let Some(learnt) = self.objects.get_mut(&pair.object) else { return };
        for (i, [d, e]) in apart.into_iter().enumerate() {
            learnt.errors[0] += (d - ((share * e + 128) >> 8)).unsigned_abs();
            learnt.errors[1] += u64::from(pair.colours[0][i].abs_diff(pair.colours[1][i]));
        }
    }

    fn colour(&self, units: [u32; 4]) -> Colour {
        units.map(|units| f64::from(units) * f64::from(self.scale / UNITS))
    }

    /// What an object looks like in this frame at a normal; none where neither frame shows it.
    pub fn typical(&self, object: u32, normal: [f64; 3]) -> Option<Colour> {
        Some(self.colour(self.filled.get(&object)?.typical[bin(normal)?]))
    }

    /// What places of an object that this frame shows look like in the other frame at a normal there.
    pub fn reference(&self, object: u32, other_normal: [f64; 3]) -> Option<Colour> {
        Some(self.colour(self.filled.get(&object)?.reference[bin(other_normal)?]))
    }

    /// The colour in this frame of a place that only the other frame shows, in colour `known`: what is typical of its
    /// normal in this frame, plus [`Learnt::share`] of how far `known` is from the reference of its normal in the other
    /// one. That carries texture and shadow over, as far as they have been seen to stay. Channels are clamped to 0 to the
    /// scale, alpha to 0 to 1. None where the place has no normal, and of an object of which the other frame's colours are
    /// nearer than predictions where both are known ([`Learnt::errors`]).
    pub fn predict(&self, object: u32, normal: [f64; 3], other_normal: [f64; 3], known: Colour) -> Option<Colour> {
        let (typical, reference) = (self.typical(object, normal)?, self.reference(object, other_normal)?);
        let learnt = self.objects.get(&object)?;
        if learnt.errors[0] > learnt.errors[1] {
            return None;
        }
        let share = learnt.share();
        let most = f64::from(self.scale);
        let [r, g, b, a] = std::array::from_fn(|i| typical[i] + share * (known[i] - reference[i]));
        Some([r.clamp(0.0, most), g.clamp(0.0, most), b.clamp(0.0, most), a.clamp(0.0, 1.0)])
    }
}

impl Learnt {
    /// How much of a departure from the reference stays from one frame to the other: the least-squares slope, clamped to 0
    /// to 1; 1 where nothing departs, for then nothing is known of texture but that it belongs to the surface.
    pub fn share(&self) -> f64 {
        self.share_in_256() as f64 / 256.0
    }

    /// The share in whole 1/256, halves rounded up.
    fn share_in_256(&self) -> i64 {
        let [product, square] = self.products;
        let share = if square == 0 { 1.0 } else { (product as f64 / square as f64).clamp(0.0, 1.0) };
        (share * 256.0 + 0.5) as i64
    }

    fn filled(&self) -> Option<Filled> {
        let first = |lists: &[&Vec<Sum>]| {
            let mean = |place: usize| lists.iter().find_map(|list| list[place].mean());
            filled(&(0..BINS).map(mean).collect::<Vec<_>>())
        };
        let typical = first(&[&self.shown, &self.shown_by_other])?;
        Some(Filled { typical, reference: first(&[&self.paired, &self.shown_by_other, &self.shown])? })
    }
}

/// Whether a pixel and its neighbours on screen see one object.
fn is_inner(surface: &Surface, frame: &Frame, pixel: usize) -> bool {
    let [width, height] = frame.seen.size.map(|side| side as usize);
    let object = |pixel: usize| frame.seen.seen[pixel].checked_sub(1).map(|base| surface.objects[base as usize]);
    let (x, y, own) = (pixel % width, pixel / width, object(pixel));
    own.is_some()
        && (x == 0 || object(pixel - 1) == own)
        && (x + 1 == width || object(pixel + 1) == own)
        && (y == 0 || object(pixel - width) == own)
        && (y + 1 == height || object(pixel + width) == own)
}
