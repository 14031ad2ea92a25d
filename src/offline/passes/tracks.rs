//! Where the points of a grid are in the frames around theirs.

use super::grid::Grid;
use super::sheets::{Sheets, share_of};
use crate::blur::mesh::Lists;
use crate::io::passes::PassFrame;

/// The most that the depth of a place may change in a frame, as a share of it.
const DEPTH_CHANGE: f32 = 0.1;
/// Vectors of pixels at a border that are this far from what those further inside say, in pixels, are mixed of two surfaces.
const MIXED: f32 = 0.5;
/// How far apart vectors of one place may be, as two frames have them, in pixels.
const SAME_WAY: f32 = 2.0;
/// Rounds in which the frame after is searched for a place.
const ROUNDS: usize = 4;
/// How far from the place a search may end, in pixels.
const FOUND: f32 = 0.5;
/// How far apart, as a share of depth, what is hidden lies behind what hides it at least: more than the blur's tolerance.
const BEHIND: f32 = 0.005;
/// Rounds in which what is known of a bend spreads to points of which nothing is.
const SPREAD: usize = 64;

/// A vector in pixels.
type Vector = [f32; 2];

/// A frame, and what is found of it once.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) frame: PassFrame,
    pub(super) sheets: Sheets,
    pub(super) movers: Vec<bool>,
}

/// Of frames i - 1, i, i + 1 and i + 2, those that there are.
pub(super) type Around<'a> = [Option<&'a Seen>; 4];

/// A place of a surface.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Vector,
    id: u32,
    /// [`share_of`] its depth.
    share: f32,
    /// The vector from there to where it is in the frame after, if that is known.
    on: Option<Vector>,
}

/// What a frame says of a place.
#[derive(Clone, Copy, Debug)]
struct Found {
    previous: Vector,
    share: f32,
}

/// Places of points: x, y in pixels and [`share_of`] depth.
pub(super) type Places = Vec<[f32; 3]>;

/// The same in frames i - 1 to i + 2.
pub(super) type Poses = [Places; 4];

fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

fn less(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn length(a: Vector) -> f32 {
    (a[0] * a[0] + a[1] * a[1]).sqrt()
}

impl Seen {
    /// Of what was read of a frame.
    pub(super) fn new(mut frame: PassFrame) -> Seen {
        let mut sheets = Sheets::new(&frame);
        frame.previous = unmixed(&sheets, &frame.previous);
        frame.next = frame.next.map(|next| unmixed(&sheets, &next));
        sheets.tear(&frame.previous);
        let movers = sheets.movers(&frame);
        Seen { frame, sheets, movers }
    }

    /// Every other pixel of every other row.
    pub(super) fn halved(&self) -> Seen {
        let [width, height] = self.sheets.size;
        let places: Vec<usize> =
            (0..height).step_by(2).flat_map(|y| (0..width).step_by(2).map(move |x| y * width + x)).collect();
        let PassFrame { depth, id, previous, next, .. } = &self.frame;
        let half = |vectors: &Vec<Vector>| places.iter().map(|at| vectors[*at].map(|c| 0.5 * c)).collect();
        Seen::new(PassFrame {
            size: self.frame.size.map(|side| side.div_ceil(2)),
            depth: places.iter().map(|at| depth[*at]).collect(),
            id: places.iter().map(|at| id[*at]).collect(),
            previous: half(previous),
            next: next.as_ref().map(half),
        })
    }

    /// What a place of a surface is at: the mean of the four pixels around that are of it, by their distance. Where the frame knows
    /// where its pixels go, those that go elsewhere are of another surface.
    fn look(&self, Place { at, id, share, on }: Place) -> Option<Found> {
        let way = self.frame.next.as_ref().zip(on);
        let goes = |pixel: usize| way.is_none_or(|(next, on)| length(less(next[pixel], on)) <= SAME_WAY);
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        self.taps(at, |pixel, weight| {
            let own = share_of(self.frame.depth[pixel]);
            if self.frame.id[pixel] == id && (own - share).abs() <= DEPTH_CHANGE && goes(pixel) {
                let [x, y] = self.frame.previous[pixel];
                [x, y, own].into_iter().zip(&mut sum).for_each(|(value, sum)| *sum += weight * value);
                weights += weight;
            }
        });
        let [x, y, share] = sum.map(|sum| sum / weights);
        (weights > 0.0).then_some(Found { previous: [x, y], share })
    }

    /// Calls `tap` with the four pixels around a place, as far as they are in the picture, and their bilinear weights.
    fn taps(&self, [x, y]: Vector, mut tap: impl FnMut(usize, f32)) {
        let [width, height] = self.frame.size.map(|side| side as f32);
        let (left, above) = ((x - 0.5).floor(), (y - 0.5).floor());
        for (right, below) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (column, row) = (left + right, above + below);
            if (0.0..width).contains(&column) && (0.0..height).contains(&row) {
                let weight = (1.0 - (x - 0.5 - column).abs()) * (1.0 - (y - 0.5 - row).abs());
                tap(row as usize * width as usize + column as usize, weight.max(1e-6));
            }
        }
    }

    /// The least [`share_of`] depth that is seen around a place; infinite off the picture and where nothing is.
    pub(super) fn nearest(&self, at: Vector) -> f32 {
        let mut least = f32::INFINITY;
        self.taps(at, |pixel, _| least = least.min(share_of(self.frame.depth[pixel])));
        least
    }
}

/// A mask with the pixels that its own are joined to.
pub(super) fn widened(sheets: &Sheets, mask: &[bool]) -> Vec<bool> {
    let mut wider = mask.to_vec();
    for pixel in (0..mask.len()).filter(|pixel| mask[*pixel]) {
        sheets.beside(pixel).into_iter().flatten().for_each(|other| wider[other] = true);
    }
    wider
}

/// Vectors of which those at borders, where they are mixed with what is beyond, are what those further inside say.
fn unmixed(sheets: &Sheets, vectors: &[Vector]) -> Vec<Vector> {
    let is_border = |pixel: usize| sheets.beside(pixel).contains(&None);
    let inner = |pixel: usize, place: usize| sheets.beside(pixel)[place].filter(|other| !is_border(*other));
    let own = |pixel: usize| {
        if !(sheets.is_seen(pixel) && is_border(pixel)) {
            return vectors[pixel];
        }
        let inside = (0..4).filter_map(|place| {
            let near = inner(pixel, place)?;
            let far = inner(near, place).map_or(vectors[near], |far| vectors[far]);
            Some(add(vectors[near], less(vectors[near], far)))
        });
        let (sum, count) = inside.fold(([0.0; 2], 0), |(sum, count), vector| (add(sum, vector), count + 1));
        let mean = sum.map(|c| c / count.max(1) as f32);
        if count > 0 && length(less(mean, vectors[pixel])) > MIXED { mean } else { vectors[pixel] }
    };
    (0..vectors.len()).map(own).collect()
}

/// Whether frame i + 1 begins a new shot: most of what it shows was not where its vectors say.
pub(super) fn is_cut(before: &Seen, after: &Seen) -> bool {
    // Some of the pixels say it.
    const STEP: usize = 4;
    let [width, height] = after.sheets.size;
    let pixels = (0..height).step_by(STEP).flat_map(|y| (0..width).step_by(STEP).map(move |x| [x, y]));
    let (mut lost, mut all) = (0, 0);
    for [x, y] in pixels {
        let pixel = y * width + x;
        let at = add([x as f32 + 0.5, y as f32 + 0.5], after.frame.previous[pixel]);
        let is_inside = [0, 1].iter().all(|axis| (0.0..after.sheets.size[*axis] as f32).contains(&at[*axis]));
        if after.sheets.is_seen(pixel) && is_inside {
            let place = Place { at, id: after.frame.id[pixel], share: share_of(after.frame.depth[pixel]), on: None };
            all += 1;
            lost += usize::from(before.look(place).is_none());
        }
    }
    4 * lost > 3 * all
}

/// Points of a grid of frame i + 1's pixels.
pub(super) struct Next {
    fields: Fields,
    /// Places in frame i.
    pub(super) earlier: Vec<[f32; 3]>,
    /// How much farther a point moves from frame i - 1 to i, and from i + 1 to i + 2, than between these; none where nothing
    /// shows it.
    bends: [Vec<Option<Vector>>; 2],
}

impl Next {
    pub(super) fn new(grid: &Grid, previous: &Seen, own: &Seen, after: Option<&Seen>) -> Next {
        let fields = Fields::new(grid, &own.frame, &own.sheets);
        let Fields { corners, ids, back, on } = &fields;
        let count = corners.len();
        let mut earlier = Vec::with_capacity(count);
        let mut bends = [Vec::with_capacity(count), Vec::with_capacity(count)];
        for (i, ([x, y, share], back)) in corners.iter().zip(back).enumerate() {
            let place = Place { at: [*x, *y], id: ids[i], share: *share, on: None };
            let before = Place { at: add(place.at, *back), on: Some(back.map(|c| -c)), ..place };
            let found = previous.look(before).filter(|found| {
                // Who does not know where things go may have found another one: none changes its way so much.
                on.is_some() || length(less(found.previous, *back)) <= length(*back) + SAME_WAY
            });
            earlier.push([before.at[0], before.at[1], found.map_or(*share, |found| found.share)]);
            bends[0].push(found.map(|found| less(found.previous, *back)));
            let step = match on {
                Some(on) => Some(on[i]),
                None => after.and_then(|after| ahead(after, place, *back)),
            };
            bends[1].push(step.map(|step| add(step, *back)));
        }
        Next { fields, earlier, bends }
    }

    /// Objects of the points.
    pub(super) fn ids(&self) -> &[u32] {
        &self.fields.ids
    }

    /// Their places. `neighbours`: of points.
    pub(super) fn poses(self, neighbours: &Lists) -> Poses {
        let Next { fields: Fields { corners, back, .. }, earlier, bends } = self;
        let [first, last] = bends.map(|bends| spread(bends, neighbours));
        let beyond = |from: &[[f32; 3]], bends: &[Vector], sign: f32| -> Vec<[f32; 3]> {
            let steps = back.iter().zip(bends).map(|(back, bend)| add(back.map(|c| sign * c), *bend));
            from.iter().zip(steps).map(|([x, y, share], [dx, dy])| [x + dx, y + dy, *share]).collect()
        };
        let (before, after) = (beyond(&earlier, &first, 1.0), beyond(&corners, &last, -1.0));
        [before, earlier, corners, after]
    }
}

/// Places of points of a grid of frame i's pixels that frame i + 1 hides, and their objects.
pub(super) fn of_hidden(grid: &Grid, own: &Seen, next: &Seen) -> (Poses, Vec<u32>) {
    let Fields { corners, ids, back, on } = Fields::new(grid, &own.frame, &own.sheets);
    let steps = on.unwrap_or_else(|| reversed(&back));
    let later = behind(moved(&corners, &steps), next);
    let after = moved(&later, &steps);
    ([moved(&corners, &back), corners, later, after], ids)
}

/// Places of points of a grid of what goes on below frame i + 1's pixels, and their objects.
pub(super) fn of_below(grid: &Grid, frame: &PassFrame, sheets: &Sheets, own: &Seen) -> (Poses, Vec<u32>) {
    let Fields { corners, ids, back, on } = Fields::new(grid, frame, sheets);
    let corners = behind(corners, own);
    let earlier = moved(&corners, &back);
    let before = moved(&earlier, &back);
    let after = moved(&corners, &on.unwrap_or_else(|| reversed(&back)));
    ([before, earlier, corners, after], ids)
}

fn moved(places: &[[f32; 3]], by: &[Vector]) -> Vec<[f32; 3]> {
    places.iter().zip(by).map(|([x, y, share], by)| [x + by[0], y + by[1], *share]).collect()
}

fn reversed(vectors: &[Vector]) -> Vec<Vector> {
    vectors.iter().map(|vector| vector.map(|c| -c)).collect()
}

/// Places that lie behind what a frame shows there.
fn behind(mut places: Vec<[f32; 3]>, of: &Seen) -> Vec<[f32; 3]> {
    for [x, y, share] in &mut places {
        let hides = of.nearest([*x, *y]);
        *share = if hides.is_finite() { share.max(hides + BEHIND) } else { *share };
    }
    places
}

/// What points have of the frame whose pixels they are corners of.
struct Fields {
    /// Places there.
    corners: Vec<[f32; 3]>,
    ids: Vec<u32>,
    /// To the frame before.
    back: Vec<Vector>,
    /// To the frame after, if the passes know it.
    on: Option<Vec<Vector>>,
}

impl Fields {
    fn new(grid: &Grid, frame: &PassFrame, sheets: &Sheets) -> Fields {
        let shares = grid.values(sheets, |pixel| [share_of(frame.depth[pixel])]);
        let corner = |(point, [share]): (&super::grid::Point, [f32; 1])| {
            let [x, y] = point.corner.map(|c| c as f32);
            [x, y, share]
        };
        Fields {
            corners: grid.points.iter().zip(shares).map(corner).collect(),
            ids: grid.pixels(sheets).map(|pixel| frame.id[pixel]).collect(),
            back: grid.values(sheets, |pixel| frame.previous[pixel]),
            on: frame.next.as_ref().map(|next| grid.values(sheets, |pixel| next[pixel])),
        }
    }
}

/// The vector from a place to where the frame after shows it: its vectors lead back here.
fn ahead(after: &Seen, place: Place, back: Vector) -> Option<Vector> {
    let mut at = less(place.at, back);
    for _ in 0..ROUNDS {
        at = less(place.at, after.look(Place { at, ..place })?.previous);
    }
    let off = less(add(at, after.look(Place { at, ..place })?.previous), place.at);
    (length(off) <= FOUND).then(|| less(at, place.at))
}

/// Values, of which those that are not known are the mean of their neighbours'; 0 where none is near.
fn spread(values: Vec<Option<Vector>>, neighbours: &Lists) -> Vec<Vector> {
    let mut values = values;
    let mut unknown: Vec<u32> = (0..values.len() as u32).filter(|i| values[*i as usize].is_none()).collect();
    for _ in 0..SPREAD {
        let mean = |point: &u32| {
            let known = neighbours.of(*point as usize).iter().filter_map(|other| values[*other as usize]);
            let (sum, count) = known.fold(([0.0; 2], 0), |(sum, count), value| (add(sum, value), count + 1));
            (count > 0).then(|| (*point, sum.map(|c| c / count as f32)))
        };
        let found: Vec<(u32, Vector)> = unknown.iter().filter_map(mean).collect();
        if found.is_empty() {
            break;
        }
        found.into_iter().for_each(|(point, value)| values[point as usize] = Some(value));
        unknown.retain(|point| values[*point as usize].is_none());
    }
    values.into_iter().map(Option::unwrap_or_default).collect()
}
