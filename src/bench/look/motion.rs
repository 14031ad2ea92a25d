//! What is measured between a frame of smoke and the next: surface, tones and lines against where the smoke's own velocity
//! carries them.

use glam::{DVec2, DVec3};

use super::plane::{Plane, disc};
use super::still::{Share, Tones, inked};
use crate::view::Projection;

/// Pixels beside a border between tones within which tones are not compared: there they change by rights.
const BORDER: i64 = 2;
/// Pixels within which a carried line is found again.
const LINE: i64 = 2;

/// A frame as it is compared with the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment<'a> {
    /// What it is seen through.
    pub(super) projection: &'a Projection,
    /// View depth in metres, infinite where there is no smoke.
    pub(super) depth: &'a Plane<f32>,
    pub(super) tone: &'a Tones,
    /// Opacity of lines, 0 to 1.
    pub(super) line: &'a Plane<f32>,
}

/// What a frame and the next have in common, and the pixels of the first that show it.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    /// Share of compared pixels whose tone is another in the next frame.
    pub(super) tone: Share,
    pub(super) tone_faults: Plane<bool>,
    /// Share of pixels carried into the picture whose depth there is off by more than a voxel, or that find no smoke.
    pub(super) geometry: Share,
    /// Share of ink carried into the picture that finds no ink within 2 px.
    pub(super) lines_lost: Share,
    pub(super) lines_lost_faults: Plane<bool>,
}

/// Where a pixel of smoke is a frame later: the place in the picture, and its view depth in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Landing {
    at: usize,
    depth: f64,
}

/// Compares a frame with the next. `moved` is where a place (metres, world) is in the next frame; `voxel` is the smallest
/// side of a voxel in metres.
pub(super) fn compare(from: &Moment, to: &Moment, moved: impl Fn(DVec3) -> DVec3, voxel: f64) -> Carried {
    let landings = from.tone.filled(|index| landing(from, to, &moved, index));
    let [beside_from, beside_to] = [from, to].map(|moment| beside_borders(moment.tone));
    let (ink, ink_after) = (inked(from.line), inked(to.line).near(LINE));
    let mut carried = Carried {
        tone: Share::default(),
        tone_faults: from.tone.map(|_| false),
        geometry: Share::default(),
        lines_lost: Share::default(),
        lines_lost_faults: from.tone.map(|_| false),
    };
    for (index, landing) in landings.values.iter().enumerate() {
        let Some(Landing { at, depth }) = *landing else { continue };
        carried.geometry.whole += 1;
        if ink.values[index] {
            carried.lines_lost.whole += 1;
            carried.lines_lost.part += u64::from(!ink_after.values[at]);
            carried.lines_lost_faults.values[index] = !ink_after.values[at];
        }
        // No smoke has infinite depth.
        let is_there = to.tone.values[at] != 0 && (f64::from(to.depth.values[at]) - depth).abs() <= voxel;
        if !is_there {
            carried.geometry.part += 1;
        } else if !beside_from.values[index] && !beside_to.values[at] {
            let differs = from.tone.values[index] != to.tone.values[at];
            carried.tone.whole += 1;
            carried.tone.part += u64::from(differs);
            carried.tone_faults.values[index] = differs;
        }
    }
    carried
}

/// None where there is no smoke, or where it leaves the picture.
fn landing(from: &Moment, to: &Moment, moved: &impl Fn(DVec3) -> DVec3, index: usize) -> Option<Landing> {
    if from.tone.values[index] == 0 {
        return None;
    }
    let [x, y] = from.tone.pixel(index);
    let [start, ahead] = from.projection.ray_at(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
    let seen = start + ahead * f64::from(from.depth.values[index]);
    let place = from.projection.axes.transpose() * seen + from.projection.eye;
    let after = to.projection.to_view(moved(place));
    let pixel = to.projection.pixel_of(after).floor();
    let at = (after.z > to.projection.near).then(|| to.tone.index([pixel.x as i64, pixel.y as i64]))??;
    Some(Landing { at, depth: after.z })
}

/// Pixels of smoke that have smoke of another tone within 2 px.
fn beside_borders(tone: &Tones) -> Plane<bool> {
    let disc = disc(BORDER);
    tone.filled(|index| {
        let [x, y] = tone.pixel(index);
        let own = tone.values[index];
        let mut around = disc.iter().filter_map(|[dx, dy]| tone.index([x + dx, y + dy]));
        own != 0 && around.any(|at| tone.values[at] != 0 && tone.values[at] != own)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    const SIZE: [u32; 2] = [60, 40];
    /// Of a wall in front of the camera.
    const WALL: f32 = 4.0;

    /// A pixel's side in metres at the wall.
    fn footprint() -> f64 {
        f64::from(WALL) / seen(0.0).focal.y
    }

    fn seen(aside: f64) -> Projection {
        let default = Camera::default();
        let by = DVec3::X * aside;
        let camera = Camera { eye: default.eye + by, target: default.target + by, ..default };
        Projection::of_valid(&camera.view(SIZE), SIZE)
    }

    /// A wall of tones, of columns that `tone` names; ink at the columns of `ink`.
    struct Wall {
        projection: Projection,
        depth: Plane<f32>,
        tone: Tones,
        line: Plane<f32>,
    }

    impl Wall {
        fn new(aside: f64, tone: impl Fn(i64) -> u16, ink: impl Fn(i64) -> bool) -> Wall {
            let size = Plane::new(SIZE[0] as usize, vec![(); (SIZE[0] * SIZE[1]) as usize]);
            let tone = size.filled(|i| tone(size.pixel(i)[0]));
            let depth = tone.map(|tone| if *tone == 0 { f32::INFINITY } else { WALL });
            let line = size.filled(|i| if ink(size.pixel(i)[0]) { 1.0 } else { 0.0 });
            Wall { projection: seen(aside), depth, tone, line }
        }

        fn moment(&self) -> Moment<'_> {
            let Wall { projection, depth, tone, line } = self;
            Moment { projection, depth, tone, line }
        }
    }

    fn by(pixels: f64) -> impl Fn(DVec3) -> DVec3 {
        let step = DVec3::X * pixels * footprint();
        move |place| place + step
    }

    #[test]
    fn what_moves_along_has_no_faults() {
        let before = Wall::new(0.0, |x| if x < 30 { 1 } else { 2 }, |x| x == 10);
        // The wall moves 7 pixels to the right, the camera 3: 4 on screen.
        let after = Wall::new(3.0 * footprint(), |x| if x < 34 { 1 } else { 2 }, |x| x == 14);
        let found = compare(&before.moment(), &after.moment(), by(7.0), 0.1);
        // Four columns leave the picture; two on each side of the border are not compared.
        assert_eq!(found.geometry, Share::new(0, 56 * 40));
        assert_eq!(found.tone, Share::new(0, 52 * 40));
        assert_eq!(found.lines_lost, Share::new(0, 40));
    }

    #[test]
    fn tones_that_stay_behind_flip() {
        let before = Wall::new(0.0, |x| if x < 30 { 1 } else { 2 }, |x| x == 10 || x == 20);
        let after = Wall::new(0.0, |x| if x < 30 { 1 } else { 2 }, |x| x == 12 || x == 25);
        let found = compare(&before.moment(), &after.moment(), by(10.0), 0.1);
        // Columns 0 to 49 stay in; of 28, 29, 30, 31 here and of 18 to 21, which come there, none is compared; 22 to 27
        // come to the other tone.
        assert_eq!(found.tone, Share::new(6 * 40, 42 * 40));
        assert_eq!(found.tone_faults.count(), 6 * 40);
        // Ink of column 10 comes to 20, that of 20 to 30; the nearest is 5 columns away.
        assert_eq!((found.lines_lost, found.lines_lost_faults.count()), (Share::new(80, 80), 80));
        let near = compare(&before.moment(), &after.moment(), by(2.0), 0.1);
        assert_eq!(near.lines_lost, Share::new(40, 80));
    }

    #[test]
    fn surfaces_elsewhere_and_none_are_off_and_not_compared() {
        let before = Wall::new(0.0, |_| 1, |_| false);
        let after = Wall::new(0.0, |x| if x < 15 { 0 } else { 2 }, |_| false);
        let found = compare(&before.moment(), &after.moment(), by(0.0), 0.1);
        assert_eq!((found.geometry, found.tone), (Share::new(15 * 40, 60 * 40), Share::new(45 * 40, 45 * 40)));
        let closer = |place: DVec3| place + DVec3::Z * 0.2;
        let found = compare(&before.moment(), &after.moment(), closer, 0.1);
        assert_eq!(found.geometry.part, found.geometry.whole);
        assert_eq!((found.tone.percent(), found.lines_lost.percent()), (None, None));
        let found = compare(&before.moment(), &after.moment(), closer, 0.3);
        assert!(found.geometry.part < found.geometry.whole && found.tone.part == found.tone.whole);
        // Behind the camera.
        let found = compare(&before.moment(), &after.moment(), |place| place + DVec3::Z * 10.0, 0.1);
        assert_eq!(found.geometry.percent(), None);
    }
}
