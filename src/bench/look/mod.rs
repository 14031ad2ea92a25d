//! `celfx bench look`: what makes smoke, fire and smears look drawn, or not, from the layers of rendered frames.
//!
//! | file | holds |
//! |---|---|
//! | `take.rs` | frames of a shot with their layers |
//! | `frame.rs` | a frame of smoke as it is measured |
//! | `still.rs` | what is measured in one frame |
//! | `motion.rs` | what is measured between a frame and the next |
//! | `detail.rs` | what is measured of fire |
//! | `smear.rs` | what is measured of smears |
//! | `faults.rs` | pictures of it |
//! | `rows.rs` | rows of `bench.json` and the table |

mod detail;
mod faults;
mod frame;
mod motion;
mod plane;
pub(super) mod rows;
mod smear;
mod still;
mod take;

use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::{BenchError, Watch};
use crate::gpu::headless::Headless;
use crate::io::WriteError;
use crate::io::image::write_png8;
use crate::io::shot::{BUILTIN, Background, Shot};
use crate::program::blur::Blur;
use crate::program::smoke::Smoke;
use crate::view::Camera;
use detail::{brightness, fine_detail};
use faults::{Faults, LEGEND};
use frame::SmokeFrame;
use motion::compare;
use plane::Plane;
use rows::{Counts, FlameLook, FrameCounts, LookRow, SmearCounts, SmearLook, middle};
use smear::Sides;
use still::{Share, airbrushed, borders, inked, largest_tone, specks};
use take::{Motion, Still, Take};

/// Frames of a scene; they make one pair less.
const FRAMES: u32 = 21;
/// Where they begin in shots that are long enough: built-in smoke has risen by then.
const FIRST: u32 = 20;
/// Views around a scene.
const VIEWS: u32 = 16;
/// How often the camera halves its distance from a fire.
const HALVINGS: i32 = 4;
/// Of a quick run: frames, views, and by what the picture's sides are divided.
const QUICK: [u32; 3] = [3, 4, 4];
/// Measured where no shot is named: as far as they are built in.
const SCENES: [&str; 7] = [
    "builtin:smoke",
    "builtin:cloud",
    "builtin:paper_smoke",
    "builtin:flame",
    "builtin:paper_flame",
    "builtin:blur",
    "builtin:paper_blur",
];

/// A shot, and the frames of it that are measured.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The shot. Its smoke, its fire and its smears are measured; at least one of them is there.
    pub shot: Arc<Shot>,
    /// First and last frame, within the shot's.
    pub frames: [u32; 2],
}

/// The shots that are measured where none is named.
pub fn scenes() -> Vec<&'static str> {
    SCENES.into_iter().filter(|name| BUILTIN.iter().any(|(builtin, _)| builtin == name)).collect()
}

/// The frames that are measured of a shot with these: 20 to 40, or the last 21 if it has not all of those.
pub fn frames_of([first, last]: [u32; 2]) -> [u32; 2] {
    let end = FIRST + FRAMES - 1;
    match first <= FIRST && end <= last {
        true => [FIRST, end],
        false => [first.max(last.saturating_sub(FRAMES - 1)), last],
    }
}

/// What was found.
pub(super) struct Look {
    pub(super) rows: Vec<LookRow>,
    pictures: Vec<(String, [u32; 2], Faults)>,
}

impl Look {
    /// Writes `look/SCENE.png` and `look/SCENE_faults.png`, and says what they show.
    pub(super) fn write(&self, folder: &Path) -> Result<String, BenchError> {
        let folder = folder.join("look");
        std::fs::create_dir_all(&folder).map_err(|source| WriteError { path: folder.clone(), source })?;
        for (name, size, Faults { picture, marked }) in &self.pictures {
            write_png8(&folder.join(format!("{name}.png")), *size, picture)?;
            write_png8(&folder.join(format!("{name}_faults.png")), *size, marked)?;
        }
        Ok(format!("\n{}: {LEGEND}\n", folder.display()))
    }
}

/// Measures scenes whose names contain one of `only`, or all of them where that is empty.
pub(super) fn measure(
    mut device: Headless,
    scenes: &[Scene],
    quick: bool,
    only: &[String],
    watch: &dyn Watch,
) -> Result<Look, BenchError> {
    let mut look = Look { rows: Vec::new(), pictures: Vec::new() };
    let is_wanted = |scene: &&Scene| only.is_empty() || only.iter().any(|only| scene.shot.name.contains(only));
    for scene in scenes.iter().filter(is_wanted) {
        let scene = if quick { cut(scene) } else { scene.clone() };
        let mut shown =
            Shown { scene: &scene, quick, watch, counts: Counts::default(), faults: None, flame: None, blur: None };
        device = shown.measure(device)?;
        let Shown { counts, faults, flame, blur, .. } = shown;
        let shot = &scene.shot;
        look.rows.push(LookRow {
            scene: shot.name.clone(),
            size: shot.size,
            frames: scene.frames,
            smoke: shot.part::<Smoke>().map(|_| counts.look()),
            flame,
            blur,
        });
        let name = file_name(&shot.name, &look.pictures.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>());
        look.pictures.extend(faults.map(|faults| (name, shot.size, faults)));
    }
    Ok(look)
}

/// The scene as a quick run has it.
fn cut(scene: &Scene) -> Scene {
    let [frames, _, divisor] = QUICK;
    let [first, last] = scene.frames;
    let mut shot = (*scene.shot).clone();
    shot.size = shot.size.map(|side| (side / divisor).max(1));
    Scene { shot: Arc::new(shot), frames: [first, last.min(first + frames - 1)] }
}

/// A file's name for a scene that is not `taken`: the shot's own, without folder and extension.
fn file_name(shot: &str, taken: &[&str]) -> String {
    let stem = Path::new(shot.strip_prefix("builtin:").unwrap_or(shot)).file_stem();
    let stem = stem.map_or_else(|| "shot".into(), |stem| stem.to_string_lossy().into_owned());
    let others = (2_u32..).map(|number| format!("{stem}_{number}"));
    std::iter::once(stem.clone()).chain(others).find(|name| !taken.contains(&name.as_str())).unwrap_or(stem)
}

/// A scene while it is measured.
struct Shown<'a> {
    scene: &'a Scene,
    quick: bool,
    watch: &'a dyn Watch,
    counts: Counts,
    faults: Option<Faults>,
    flame: Option<FlameLook>,
    blur: Option<SmearLook>,
}

impl Shown<'_> {
    fn measure(&mut self, mut device: Headless) -> Result<Headless, BenchError> {
        let shot = &self.scene.shot;
        let [first, last] = self.scene.frames;
        if let Some(smoke) = shot.part::<Smoke>() {
            let frames: Vec<u32> = (first..=last).collect();
            let mut take = Take::new(device, shot, &frames, self.watch)?;
            self.sequence(&mut take, smoke)?;
            device = take.into_device();
        }
        if let Some(blur) = shot.part::<Blur>() {
            device = self.smears(device, blur)?;
        }
        let mut take = Take::new(device, shot, &[middle([first, last])], self.watch)?;
        self.around(&mut take)?;
        Ok(take.into_device())
    }

    /// The frames of smears, and the same without them; nothing is behind them.
    fn smears(&mut self, mut device: Headless, blur: &Blur) -> Result<Headless, BenchError> {
        let shot = &self.scene.shot;
        let [first, last] = self.scene.frames;
        self.next(&format!("frames {first} to {last}"));
        let frames: Vec<u32> = (first..=last).collect();
        let ink = blur.settings.toon.outline.colour;
        let mesh = blur.mesh(shot)?;
        let triangles = &mesh.topology().triangles;
        let mut still = blur.clone();
        still.settings.strength = 0.0;
        let mut counts = vec![[Share::default(); 4]; frames.len()];
        for (is_still, part) in [(false, blur.clone()), (true, still)] {
            let mut shot = shot.with_part(part);
            shot.background = Background::None;
            let shot = Arc::new(shot);
            let mut take = Take::new(device, &shot, &frames, self.watch)?;
            for (number, counts) in frames.iter().zip(&mut counts) {
                let still = take.frame(*number)?;
                counts[1 + usize::from(is_still)] = smear::inked(&still.picture, ink);
                if !is_still {
                    let vertices: Vec<_> = still.values("blur.vertices").as_chunks().0.to_vec();
                    let sides = Sides {
                        picture: &still.picture,
                        previous: still.colours("blur.previous"),
                        next: still.colours("blur.next"),
                        mask: still.values("blur.mask"),
                        subframe: still.values("blur.subframe"),
                    };
                    (counts[0], counts[3]) = (smear::leading(&vertices, triangles), smear::mixed(&sides, ink));
                }
            }
            device = take.into_device();
        }
        self.blur = Some(SmearCounts { frames: counts }.look());
        Ok(device)
    }

    fn next(&self, what: &str) {
        self.watch.progress(&format!("look {}: {what}", self.scene.shot.name));
    }

    fn width(&self) -> usize {
        self.scene.shot.size[0] as usize
    }

    fn smoke_frame(&self, still: &Still, smoke: &Smoke) -> SmokeFrame {
        let colours: Vec<[f32; 3]> = smoke.settings.tones.iter().map(|tone| tone.colour).collect();
        SmokeFrame::new(still, self.width(), &colours)
    }

    /// The frames of smoke, one after the other.
    fn sequence(&mut self, take: &mut Take, smoke: &Smoke) -> Result<(), BenchError> {
        let [first, last] = self.scene.frames;
        self.next(&format!("frames {first} to {last}"));
        let mut before: Option<(SmokeFrame, Motion)> = None;
        for number in first..=last {
            let still = take.frame(number)?;
            let frame = self.smoke_frame(&still, smoke);
            if let Some((before, motion)) = before.take() {
                let carried = compare(&before.moment(), &frame.moment(), motion.moved(), motion.voxel());
                self.counts.add_pair(&carried);
                if let Some(faults) = self.faults.as_mut().filter(|_| number == middle([first, last]) + 1) {
                    faults.mark_carried(&carried);
                }
            }
            let Some(motion) = take.motion() else { continue };
            let is_middle = number == middle([first, last]);
            let sigma = smoke.settings.pixels(self.scene.shot.size[1]).sigma;
            self.still(&frame, is_middle.then_some(&still), motion.voxel(), sigma.into());
            before = Some((frame, motion));
        }
        Ok(())
    }

    /// One frame; `shown` is the one that there is a picture of.
    fn still(&mut self, frame: &SmokeFrame, shown: Option<&Still>, voxel: f64, sigma: f64) {
        let smoke = frame.smoke();
        let ink = inked(&frame.line);
        let airbrush = airbrushed(&frame.line);
        let ((ink_specks, ink_count), (smoke_specks, smoke_count)) = (specks(&ink), specks(&smoke));
        let borders = borders(&frame.surface(voxel, sigma));
        let of_smoke = |mask: &Plane<bool>| Share::new(mask.count(), smoke.count());
        self.counts.frames.push(FrameCounts {
            airbrush: of_smoke(&airbrush),
            ink: of_smoke(&ink),
            seams: borders.seams,
            jumps: borders.jumps,
            ink_specks: ink_count,
            smoke_specks: smoke_count,
        });
        if let Some(still) = shown {
            let mut faults = Faults::new(&still.picture);
            faults.mark_still(&airbrush, [&ink_specks, &smoke_specks]);
            self.faults = Some(faults);
        }
    }

    /// The frame in the middle from other places: around smoke, and nearer to a fire.
    fn around(&mut self, take: &mut Take) -> Result<(), BenchError> {
        let shot = &self.scene.shot;
        let number = middle(self.scene.frames);
        self.next(&format!("views of frame {number}"));
        let (still, camera) = (take.frame(number)?, shot.camera(number));
        if let Some(smoke) = shot.part::<Smoke>() {
            let centre = centre(&self.smoke_frame(&still, smoke).spheres);
            let views = if self.quick { QUICK[1] } else { VIEWS };
            for view in 0..views {
                let angle = std::f64::consts::TAU * f64::from(view) / f64::from(views);
                let frame = self.smoke_frame(&take.seen(turned(&camera, centre, angle))?, smoke);
                self.counts.views.push(largest_tone(&frame.tone, &frame.line));
            }
        }
        if shot.has("flame") {
            self.flame = Some(self.nearing(take, &still, &camera)?);
        }
        self.faults.get_or_insert_with(|| Faults::new(&still.picture));
        Ok(())
    }

    /// Fine detail of a fire, of which `still` shows a frame, as the camera halves its distance.
    fn nearing(&self, take: &mut Take, still: &Still, camera: &Camera) -> Result<FlameLook, BenchError> {
        let particles = still.values("flame.particles").chunks_exact(9);
        let places = particles.map(|row| DVec3::new(row[0].into(), row[1].into(), row[2].into()));
        let centre = centre(&places.collect::<Vec<_>>());
        let mut flame = FlameLook::default();
        for halvings in 0..=HALVINGS {
            let camera = nearer(camera, centre, halvings);
            let still = take.seen(camera)?;
            let picture = Plane::new(self.width(), still.colours("flame").to_vec());
            let coverage = Plane::new(self.width(), still.values("flame.coverage").to_vec());
            flame.distance.push(camera.eye.distance(centre));
            flame.fine_detail.push(fine_detail(&brightness(&picture), &coverage.map(|share| *share > 0.0)));
        }
        Ok(flame)
    }
}

/// Mean of places; the origin where there are none.
fn centre(places: &[DVec3]) -> DVec3 {
    places.iter().sum::<DVec3>() / places.len().max(1) as f64
}

/// The camera turned about the axis along its own up direction through `centre`, by an angle in radians.
fn turned(camera: &Camera, centre: DVec3, angle: f64) -> Camera {
    let turn = DQuat::from_axis_angle(camera.up.normalize(), angle);
    let moved = |place: DVec3| centre + turn * (place - centre);
    Camera { eye: moved(camera.eye), target: moved(camera.target), ..*camera }
}

/// The camera that looks at `centre` from its own direction, with the distance halved so often.
fn nearer(camera: &Camera, centre: DVec3, halvings: i32) -> Camera {
    let away = (camera.eye - centre) * 0.5_f64.powi(halvings);
    Camera { eye: centre + away, target: centre, near: camera.near.min(0.01 * away.length()), ..*camera }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_those_of_the_built_in_shots_or_the_last() {
        let all = [[1, 48], [20, 40], [1, 39], [21, 60], [5, 8], [7, 7]];
        let expected = [[20, 40], [20, 40], [19, 39], [40, 60], [5, 8], [7, 7]];
        assert_eq!(all.map(frames_of), expected);
        assert!(scenes().starts_with(&["builtin:smoke", "builtin:cloud"]) && scenes().contains(&"builtin:flame"));
    }

    #[test]
    fn files_have_names_of_their_own() {
        assert_eq!(file_name("builtin:smoke", &[]), "smoke");
        assert_eq!(file_name("some/where/plume.toml", &["smoke"]), "plume");
        assert_eq!(file_name("other/plume.toml", &["plume", "plume_2"]), "plume_3");
    }

    #[test]
    fn cameras_turn_and_come_nearer() {
        let camera = Camera { eye: DVec3::new(0.0, 1.0, 4.0), target: DVec3::new(0.5, 1.0, 0.0), ..Camera::default() };
        let centre = DVec3::new(0.0, 5.0, 1.0);
        let behind = turned(&camera, centre, std::f64::consts::PI);
        assert!(behind.eye.distance(DVec3::new(0.0, 1.0, -2.0)) < 1e-12, "{}", behind.eye);
        assert!(behind.target.distance(DVec3::new(-0.5, 1.0, 2.0)) < 1e-12, "{}", behind.target);
        let near = nearer(&camera, centre, 2);
        assert_eq!((near.eye.distance(centre), near.target), (camera.eye.distance(centre) / 4.0, centre));
        assert_eq!(self::centre(&[]), DVec3::ZERO);
    }
}
