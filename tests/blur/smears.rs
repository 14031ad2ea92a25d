//! Smears of frames that the effect draws: tones and ink after the distortion, against f64.

use celfx::blur::Settings;
use celfx::blur::reference::distort::{Drawing, interpolate};
use celfx::blur::reference::ink::{Sample, opacity, step};
use celfx::blur::reference::raster::Clip;
use celfx::blur::reference::{scene, visible};
use celfx::blur::settings::{Ink, Mix, Toon};
use celfx::simulate::mesh::Builtin;
use celfx::toon::{Operator, Outline, Tone};
use celfx::view::Projection;
use glam::DVec3;

use crate::scenes::drawn;
use crate::toon::Film;

const I: usize = 1;
const SIZE: [u32; 2] = [320, 180];
/// A step that is so near to a line's that rounding decides.
const UNSURE: f64 = 0.02;

fn settings(strength: f32, mix: Mix) -> Settings {
    let tone = |from, colour| Tone::new(from, colour);
    let tones = vec![tone(0.0, [0.2, 0.25, 0.5]), tone(0.4, [0.6, 0.5, 0.5]), tone(0.8, [1.0, 1.0, 0.9])];
    // 1.5 pixels of 180 lines.
    let outline = Outline { strength, width: 9.0, colour: [0.02, 0.0, 0.1], operator: Operator::Step };
    Settings { mix, toon: Toon { tones, ink: Ink::After, outline }, ..Settings::default() }
}

/// The picture where the references are sure of it: of pixels all of whose samples see what moves.
struct Smear<'a> {
    film: &'a Film,
    drawing: Drawing,
    next: Vec<[Clip; 3]>,
    /// Of both frames.
    normals: [Vec<[DVec3; 3]>; 2],
    /// Metres that a sample spans at a depth of 1.
    span: f64,
}

impl Smear<'_> {
    fn new(film: &mut Film) -> Smear<'_> {
        let frames = [I, I + 1];
        let (mesh, view) = (film.mesh.clone(), film.animation.seen(I + 1));
        let drawing = drawn(&mut film.rig, &mesh, &film.animation, frames);
        let next = scene::corners(&mesh, &film.animation.poses[I + 1], &view, SIZE);
        let projection = Projection::of_valid(&view, SIZE);
        let normals = frames.map(|frame| film.normals(frame));
        Smear { film, drawing, next, normals, span: 0.5 / projection.focal.y }
    }

    fn place([x, y]: [i32; 2]) -> usize {
        let [width, height] = SIZE.map(|side| 2 * side as i32);
        (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize
    }

    fn sample(&self, at: [i32; 2]) -> Sample {
        let Some(fragment) = self.drawing.fragments[Self::place(at)] else {
            return Sample { object: 0, depth: f64::INFINITY, place: [0.0; 3] };
        };
        let [x, y, w] = interpolate(fragment.weights, self.next[fragment.base as usize]);
        let object = 1 + self.film.mesh.triangle_objects()[fragment.base as usize];
        Sample { object, depth: fragment.depth, place: [2.0 * x / w, 2.0 * y / w, w] }
    }

    /// Whether there is a line; none where rounding decides.
    fn line(&self, at: [i32; 2]) -> Option<bool> {
        let [width, height] = SIZE.map(|side| 2 * side as i32);
        if !(0..width).contains(&at[0]) || !(0..height).contains(&at[1]) || self.sample(at).object == 0 {
            return Some(false);
        }
        let beside = (-1..=1).flat_map(|y| (-1..=1).map(move |x| [at[0] + x, at[1] + y]));
        let own = self.sample(at);
        let is_even = |other: Sample| {
            other.object > 0 && other.object != own.object && (other.depth / own.depth - 1.0).abs() < 1e-4
        };
        if beside.clone().any(|at| self.drawing.raster.uncertain[Self::place(at)] || is_even(self.sample(at))) {
            return None;
        }
        let footprint = self.span * own.place[2];
        let found = step(&own, footprint, |[x, y]| self.sample([at[0] + x, at[1] + y]));
        let found = found * f64::from(self.film.settings.toon.outline.strength);
        ((found - 1.0).abs() > UNSURE).then_some(found > 1.0)
    }

    fn colour(&self, at: [i32; 2]) -> Option<[f64; 3]> {
        let fragment = self.drawing.fragments[Self::place(at)]?;
        let Settings { mix, toon, .. } = &self.film.settings;
        if mix == &Mix::Choose && (fragment.time - 0.5).abs() < 1e-4 {
            return None;
        }
        let tones = [0, 1].map(|k| {
            let weights = DVec3::from_array(fragment.weights);
            self.film.tone(I + k, fragment.base as usize, weights, &self.normals[k])
        });
        let [previous, next] = [tones[0]?, tones[1]?];
        let [r, g, b, _] = visible::mixture(*mix, fragment.time, [previous, next]);
        let width = 2.0 * f64::from(toon.outline.width) * f64::from(SIZE[1]) / 1080.0;
        let reach = width.ceil() as i32 - 1;
        let near = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [at[0] + x, at[1] + y]));
        if toon.outline.strength > 0.0 && near.clone().any(|at| self.line(at).is_none()) {
            return None;
        }
        let is_line = |[x, y]: [i32; 2]| toon.outline.strength > 0.0 && self.line([at[0] + x, at[1] + y]) == Some(true);
        let line = opacity(width, is_line);
        let ink = toon.outline.colour.map(f64::from);
        Some(
            [r, g, b]
                .into_iter()
                .zip(ink)
                .map(|(c, ink)| c * (1.0 - line) + ink * line)
                .collect::<Vec<_>>()
                .try_into()
                .expect("three"),
        )
    }

    fn pixel(&self, pixel: usize) -> Option<[f64; 3]> {
        let [x, y] = [pixel as i32 % SIZE[0] as i32, pixel as i32 / SIZE[0] as i32];
        let samples = (0..4).map(|i| self.colour([2 * x + i % 2, 2 * y + i / 2])).collect::<Option<Vec<_>>>()?;
        let is_sure = (0..4).all(|i| !self.drawing.raster.uncertain[Self::place([2 * x + i % 2, 2 * y + i / 2])]);
        is_sure.then(|| [0, 1, 2].map(|c| samples.iter().map(|sample| sample[c]).sum::<f64>() / 4.0))
    }
}

#[test]
fn tones_and_ink_of_smears_are_those_of_f64() {
    for (which, vertices, strength, mix) in [
        (Builtin::Run, 1500, 1.0, Mix::Choose),
        (Builtin::Crossing, 400, 1.0, Mix::Choose),
        (Builtin::Crossing, 400, 0.0, Mix::Blend),
        (Builtin::Spin, 400, 0.3, Mix::Choose),
    ] {
        let Some(mut film) = Film::new(which, vertices, SIZE, 22..26, settings(strength, mix), false) else { return };
        let picture = film.output(I, true);
        let smear = Smear::new(&mut film);
        let (mut looked, mut inked, mut wrong, mut worst) = (0, 0, 0, 0.0_f64);
        for (pixel, found) in picture.iter().enumerate() {
            let Some(expected) = smear.pixel(pixel) else { continue };
            let off = (0..3).map(|c| (f64::from(found[c]) - expected[c]).abs()).fold(0.0, f64::max);
            looked += 1;
            inked += usize::from(expected[0] + expected[1] < 0.1);
            wrong += usize::from(off > 1e-4);
            worst = worst.max(off);
        }
        eprintln!("{which:?}, {strength}: {looked} pixels, {inked} inked, {wrong} differ, at most by {worst:.1e}");
        assert!(looked > 400 && (inked > 20 || strength < 1.0), "{which:?}: {looked} pixels, {inked} inked");
        // A tone of a smear is that of a place, which is good for 1e-4 pixels: few are so near to a border between tones.
        assert!(wrong * 500 <= looked, "{which:?}: {wrong} of {looked}");
    }
}
