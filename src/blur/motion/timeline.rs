//! The knots that trajectories go through: which pose, seen through which view, at which time.

use std::ops::Range;

use super::breaks::{Corners, Step, camera_snaps, mesh_snaps};
use super::projection::PixelClip;
use super::window::{Pose, Segment, WINDOW, Window};

/// A pose that trajectories go through, and what it is seen through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    /// In frames, of which those in which nothing moves are left out.
    pub(super) time: f64,
    /// Its place, as [`Window::pose`] takes it.
    pub(super) pose: usize,
    /// The place of the pose whose view it is.
    pub(super) sight: usize,
    pub(super) projection: PixelClip,
    /// Whether what comes before and what comes after know nothing of each other.
    pub(super) is_break: bool,
}

/// A segment of the trajectories and the knots at its ends: the same one twice where the mesh is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) segment: Segment,
    pub(super) knots: [usize; 2],
}

/// The knots of trajectories, and the segments that are looked at.
///
/// Poses that are equal and follow each other are one, and so are views. What the interval has is what counts: in one in
/// which the mesh is held, the camera alone moves; in one in which it moves, the poses before and after are those that it has
/// had and will have, and the camera goes on beside them as it does in the interval. So a mesh on twos under a camera on ones
/// goes a smooth way in frames that change it, and with the camera only in frames that hold it.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    pub(super) knots: Vec<Knot>,
    /// In the order of [`super::Interval::segments`].
    pub(super) spans: Vec<Span>,
    /// Knots of frames i and i + 1.
    pub(super) ends: [usize; 2],
    mesh: Stands,
    camera: Stands,
    /// Places of the moments from frame i to frame i + 1.
    inner: Vec<usize>,
}

/// How long one thing stays as it is.
#[derive(Clone, Copy, Debug)]
struct Stand {
    /// Of these poses, the nearest to the interval.
    place: usize,
    frames: usize,
    is_break: bool,
}

/// What the mesh, or the camera, is like before and after an interval, from it on.
#[derive(Clone, Debug, Default)]
struct Stands {
    before: Vec<Stand>,
    after: Vec<Stand>,
    /// Whether it changes in the interval. If not, there is nothing else.
    moves: bool,
    /// Places of all, in the order of time.
    places: Vec<usize>,
}

/// Whether two poses are the same, bit for bit.
fn same_mesh(a: &Pose, b: &Pose) -> bool {
    let bits = |pose: &Pose| -> *const [f32; 3] { pose.positions.as_ptr() };
    let same = || bytemuck::cast_slice::<_, u8>(a.positions) == bytemuck::cast_slice::<_, u8>(b.positions);
    bits(a) == bits(b) || same()
}

/// Whether two views are the same but for their jitter.
fn same_camera(a: &Pose, b: &Pose) -> bool {
    a.view.without_jitter() == b.view.without_jitter()
}

/// Whether two moments show the same.
fn is_held(window: &Window, [a, b]: [usize; 2]) -> bool {
    let [a, b] = [a, b].map(|place| window.pose(place));
    same_mesh(a, b) && same_camera(a, b)
}

impl Stands {
    /// Becomes that of poses of `shot`, around an interval whose moments are `inner`. So many changes to each side.
    fn renew(
        &mut self,
        window: &Window,
        shot: &Range<usize>,
        inner: &[usize],
        [before, after]: [usize; 2],
        same: impl Fn(&Pose, &Pose) -> bool,
    ) {
        let i = window.current;
        let is_same = |a: usize, b: usize| same(window.pose(a), window.pose(b));
        self.moves = inner.windows(2).any(|pair| !is_same(pair[0], pair[1]));
        let walk = |stands: &mut Vec<Stand>, from: usize, places: &mut dyn Iterator<Item = usize>, most: usize| {
            stands.clear();
            stands.push(Stand { place: from, frames: 1, is_break: false });
            for place in places {
                let count = stands.len();
                match stands.last_mut() {
                    Some(last) if is_same(last.place, place) => last.frames += 1,
                    _ if count > most => break,
                    _ => stands.push(Stand { place, frames: 1, is_break: false }),
                }
            }
        };
        let [before, after] = if self.moves { [before, after] } else { [0; 2] };
        let [mut earlier, mut later] = if self.moves { [shot.start..i, i + 2..shot.end] } else { [0..0, 0..0] };
        walk(&mut self.before, i, &mut earlier.by_ref().rev(), before);
        walk(&mut self.after, i + 1, &mut later.by_ref(), after);
    }

    /// Number `number` from the earliest on.
    fn at(&mut self, number: usize) -> &mut Stand {
        let before = self.before.len();
        match number.checked_sub(before) {
            None => &mut self.before[before - 1 - number],
            Some(after) => &mut self.after[after],
        }
    }

    /// Finds the breaks: what comes to rest, as it stands more than twice as long as what comes before or after; and both
    /// ends of a snap.
    fn find_breaks(&mut self, is_snap: impl Fn(Step) -> bool) {
        if !self.moves {
            return;
        }
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        places.extend(self.before.iter().rev().chain(&self.after).map(|stand| stand.place));
        for k in 1..places.len().saturating_sub(1) {
            let [before, own, after] = [k - 1, k, k + 1].map(|k| self.at(k).frames);
            self.at(k).is_break |= own > 2 * before.min(after);
        }
        for k in 1..places.len() {
            let before = k.checked_sub(2).map(|before| [places[before], places[k - 1]]);
            let after = places.get(k + 1).map(|after| [places[k], *after]);
            if is_snap(Step { own: [places[k - 1], places[k]], beside: [before, after] }) {
                self.at(k - 1).is_break = true;
                self.at(k).is_break = true;
            }
        }
        self.places = places;
    }

    /// Stand number `number` from the interval on, on one side; none where there is no more.
    fn beside(&self, number: usize, after: bool) -> Option<Stand> {
        let stands = if after { &self.after } else { &self.before };
        stands.get(if self.moves { number } else { 0 }).copied()
    }
}

impl Timeline {
    /// Becomes that of a window of which only the poses of `shot` are looked at, from `earlier` frames before frame i to frame i + 1,
    /// which must be among them. Pictures have `height`
    /// lines. Snaps of the camera are found if it is known where the mesh is.
    pub(super) fn renew(
        &mut self,
        window: &Window,
        shot: Range<usize>,
        earlier: usize,
        height: f64,
        corners: Option<&Corners>,
        project: impl Fn(&Pose) -> PixelClip,
    ) {
        let (i, count, between) = (window.current, window.poses.len(), window.between.len());
        let most = [WINDOW + earlier, WINDOW];
        let Timeline { mesh, camera, inner, .. } = self;
        inner.clear();
        inner.extend(std::iter::once(i).chain(count..count + between).chain([i + 1]));
        mesh.renew(window, &shot, inner, most, same_mesh);
        camera.renew(window, &shot, inner, most, same_camera);
        mesh.find_breaks(|step| mesh_snaps(window, step, height, &project));
        camera.find_breaks(|step| corners.is_some_and(|box_| camera_snaps(window, box_, step, height, &project)));
        self.join(window, &project);
        self.divide(window, shot.start, earlier);
    }

    /// Knots of the moments of the interval and of what is beside it.
    fn join(&mut self, window: &Window, project: &impl Fn(&Pose) -> PixelClip) {
        let Timeline { knots, ends, mesh, camera, inner, .. } = self;
        let projection = |sight: usize| project(window.pose(sight));
        let beside = &|number: usize, after: bool| {
            let (own, seen) = (mesh.beside(number, after)?, camera.beside(number, after)?);
            let (time, is_break) = (0.0, own.is_break || seen.is_break);
            Some(Knot { time, pose: own.place, sight: seen.place, projection: projection(seen.place), is_break })
        };
        // What moves neither here nor there has one stand for ever.
        let moves = mesh.moves || camera.moves;
        let beyond = |after: bool| (1..).map_while(move |number| beside(number, after).filter(|_| moves)).enumerate();
        knots.clear();
        knots.extend(beyond(false).map(|(number, knot)| Knot { time: -(number as f64) - 1.0, ..knot }));
        knots.reverse();
        ends[0] = knots.len();
        let step = 1.0 / (inner.len() as f64 - 1.0);
        let mut time = 0.0;
        for (number, place) in inner.iter().copied().enumerate() {
            if number > 0 && is_held(window, [inner[number - 1], place]) {
                continue;
            }
            time += if number > 0 { step } else { 0.0 };
            knots.push(Knot { time, pose: place, sight: place, projection: projection(place), is_break: false });
        }
        ends[1] = knots.len() - 1;
        for (end, after) in [(ends[0], false), (ends[1], true)] {
            knots[end].is_break |= beside(0, after).is_some_and(|knot| knot.is_break);
        }
        knots.extend(beyond(true).map(|(number, knot)| Knot { time: time + number as f64 + 1.0, ..knot }));
    }

    /// Segments of the interval, and of the frames before it.
    fn divide(&mut self, window: &Window, begin: usize, earlier: usize) {
        let Timeline { spans, ends, inner, .. } = self;
        let (i, parts) = (window.current, inner.len() - 1);
        spans.clear();
        let mut knot = ends[0];
        for (part, places) in inner.windows(2).enumerate() {
            let after = if is_held(window, [places[0], places[1]]) { knot } else { knot + 1 };
            let [begin, end] = [part, part + 1].map(|part| (part as f64 / parts as f64) as f32);
            spans.push(Span { segment: Segment { begin, end }, knots: [knot, after] });
            knot = after;
        }
        let mut knot = ends[0];
        for back in 1..=earlier.min(i - begin) {
            let is_held = is_held(window, [i - back, i - back + 1]);
            let before = if is_held { Some(knot) } else { knot.checked_sub(1) };
            let Some(before) = before else { break };
            let segment = Segment { begin: -(back as f32), end: 1.0 - back as f32 };
            spans.push(Span { segment, knots: [before, knot] });
            knot = before;
        }
    }

    /// Times of the knots, and whether they are breaks.
    pub(super) fn times(&self) -> impl Iterator<Item = (f64, bool)> {
        self.knots.iter().map(|knot| (knot.time, knot.is_break))
    }

    /// Square of the time from one knot to the other.
    pub(super) fn squared(&self, [a, b]: [usize; 2]) -> f64 {
        (self.knots[b].time - self.knots[a].time).powi(2)
    }
}
