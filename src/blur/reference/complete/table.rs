//! Colours by world normal: what a frame shows of a surface where it is turned some way. Of places that neither frame shows
//! nothing else is known.
//!
//! All sums and means are whole numbers, so that their order does not matter and a device has the same.

use std::collections::BTreeMap;

use crate::blur::params::{BINS, LARGEST_SCALE, SIDE, UNITS};
use crate::blur::reference::visible::{Colour, Frame, Surface};

/// The largest channel in units.
const MOST: u32 = UNITS as u32 - 1;

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
    let place = |c: f64| (((c * 0.5 + 0.5) * f64::from(SIDE)) as u32).min(SIDE - 1);
    Some((place(y) * SIDE + place(x)) as usize)
}

/// The scale of pixels: the least power of two that no channel of any of them, alpha included, is above, 1 to 16. Channels
/// that are not finite do not count; those above 16 are clamped, so that a highlight does not take the others' accuracy.
pub fn scale<'a>(pixels: impl IntoIterator<Item = &'a [f32; 4]>) -> f32 {
    let finite = pixels.into_iter().flatten().filter(|c| c.is_finite());
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
    let mut side = SIDE as usize;
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

/// A bin's value from the level above, which has `side` bins a side.
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

/// Colours of one frame by normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    filled: BTreeMap<u32, Vec<[u32; 4]>>,
    /// The scale of both images.
    scale: f32,
}

/// A pixel that teaches.
pub(super) struct Lesson {
    /// Its place on screen.
    pub pixel: usize,
    /// The surface that it sees.
    pub surface: u32,
    /// The mesh's triangle.
    pub base: u32,
    /// Barycentric coordinates there.
    pub weights: [f64; 3],
    bin: usize,
    colour: [u32; 4],
}

/// The pixels of a frame that teach: those of which all four neighbours that there are on screen see the same surface, so
/// that borders and what is mixed there do not. By the normal at their centre.
pub(super) fn lessons(surface: &Surface, frame: &Frame, scale: f32) -> Vec<Lesson> {
    let lesson = |pixel: usize| {
        let (base, weights) = frame.place(pixel)?;
        let bin = bin(frame.normal(surface, base, weights))?;
        let own = surface.surfaces[base as usize];
        Some(Lesson { pixel, surface: own, base, weights, bin, colour: quantised(frame.image[pixel], scale) })
    };
    let inner = (0..frame.image.len()).filter(|pixel| is_inner(surface, frame, *pixel));
    inner.filter_map(lesson).collect()
}

impl Table {
    /// Learns from the inner pixels of both frames, those of which all four neighbours that there are on screen see the
    /// same surface: of each bin the mean of the colours that `frame` shows there; where it shows none, of those that
    /// `other` does, for a light that stays makes a normal look the same; then [`filled`]. Colours are [`quantised`] by the
    /// [`scale`] of what both images show of the mesh, the larger of the two.
    pub fn learn(surface: &Surface, frame: &Frame, other: &Frame) -> Table {
        let scale = scale(frame.shown()).max(scale(other.shown()));
        let mut surfaces: BTreeMap<u32, [Vec<Sum>; 2]> = BTreeMap::new();
        for (k, frame) in [frame, other].into_iter().enumerate() {
            for Lesson { surface: own, bin, colour, .. } in lessons(surface, frame, scale) {
                let sums = surfaces.entry(own).or_insert_with(|| [(); 2].map(|()| vec![Sum::default(); BINS as usize]));
                sums[k][bin].add(colour);
            }
        }
        let means = |[own, other]: &[Vec<Sum>; 2]| {
            let mean = |place: usize| own[place].mean().or_else(|| other[place].mean());
            filled(&(0..BINS as usize).map(mean).collect::<Vec<_>>())
        };
        Table { filled: surfaces.iter().filter_map(|(surface, sums)| Some((*surface, means(sums)?))).collect(), scale }
    }

    /// A surface's colour in this frame at a normal; none where neither frame shows it.
    pub fn typical(&self, surface: u32, normal: [f64; 3]) -> Option<Colour> {
        let units = self.filled.get(&surface)?[bin(normal)?];
        Some(units.map(|units| f64::from(units) * f64::from(self.scale / UNITS)))
    }
}

/// Whether a pixel and its neighbours on screen see one surface.
fn is_inner(surface: &Surface, frame: &Frame, pixel: usize) -> bool {
    let [width, height] = frame.seen.size.map(|side| side as usize);
    let seen = |pixel: usize| frame.seen.seen[pixel].checked_sub(1).map(|base| surface.surfaces[base as usize]);
    let (x, y, own) = (pixel % width, pixel / width, seen(pixel));
    own.is_some()
        && (x == 0 || seen(pixel - 1) == own)
        && (x + 1 == width || seen(pixel + 1) == own)
        && (y == 0 || seen(pixel - width) == own)
        && (y + 1 == height || seen(pixel + width) == own)
}
