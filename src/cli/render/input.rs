//! What frames are rendered from: the shot's volumes, particles, poses and images, read ahead of the renderer.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use super::Failure;
use super::origin::Origins;
use crate::cli::{Common, interrupt, memory};
use crate::data::{ParticleExtent, Particles, Volume};
use crate::flame::settings::{Colour, Settings};
use crate::flame::{self, mean_spacing};
use crate::io::ReadError;
use crate::io::image::Picture;
use crate::io::particles::ParticleSequence;
use crate::io::pattern::Pattern;
use crate::io::picture;
use crate::io::scene::AnimatedMesh;
use crate::io::sequence::{Input, Sequence};
use crate::io::shot::Shot;
use crate::io::volume::{self, VolumeSequence};
use crate::offline::{BlurError, BlurFrame, BlurInput, Effects, TARGET_FORMAT};
use crate::smoke;
use crate::view::LightSource;

/// Spread of a flame without one in a shot none of whose frames has two particles, in metres.
const DEFAULT_SPREAD: f32 = 0.1;

/// The input of a shot's effects.
pub(super) struct Inputs {
    volumes: Option<VolumeSequence>,
    particles: Option<ParticleSequence>,
    blur: Option<BlurInput>,
    images: Option<Images>,
    notes: Vec<String>,
    fire: Option<Fire>,
    /// What the effects were made for, which every frame's input must be within.
    volume: Option<volume::Extent>,
    particle: Option<ParticleExtent>,
}

/// What of a fire follows from its whole shot, so that a frame alone looks as it does in the sequence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fire {
    /// Where the table of physical colours ends: at the hottest particle. None where colours are others.
    hottest: Option<f32>,
    spread: f32,
}

impl Fire {
    /// That of a shot, if it has one. Looks at all of its particles where that is what it follows from.
    pub(super) fn of(shot: &Shot) -> Result<Option<Fire>, Failure> {
        let (Some(mut particles), Some(flame)) = (shot.particles()?, &shot.flame) else { return Ok(None) };
        let [first, last] = shot.frames;
        let hottest = match flame.settings.colour {
            Colour::Physical => Some(particles.extent(interrupt::until(first..=last))?.hottest),
            _ => None,
        };
        let spread = match flame.settings.spread {
            Some(spread) => spread,
            None => spread(&mut particles, shot.frames)?,
        };
        interrupt::check()?;
        Ok(Some(Fire { hottest, spread }))
    }
}

/// The pictures of the frames that are blurred.
struct Images {
    pattern: Pattern,
    size: [u32; 2],
    /// The last that were read, as many as an output needs.
    last: Vec<(u32, Image)>,
}

/// A picture in memory.
pub(super) type Image = Arc<Picture<[f32; 4]>>;

/// A frame, and what it brings.
pub(super) struct Step {
    /// The shot's number of it.
    pub(super) number: u32,
    /// A hash of what it is made from; 0 where it is not rendered.
    pub(super) origin: u128,
    /// Whether it is rendered, or only moves the smoke on.
    pub(super) rendered: bool,
    /// Its volume; none where it is that of the step before.
    pub(super) volume: Option<Arc<Volume>>,
    /// Its particles; none where they are those of the last rendered step, and where it is not rendered.
    pub(super) particles: Option<Arc<Particles>>,
    /// What its blur is made from; none where it is not rendered.
    pub(super) blur: Option<Blurred>,
}

/// What a blurred frame is made from.
pub(super) struct Blurred {
    /// The motion.
    pub(super) frame: BlurFrame,
    /// The pictures of the frames that it is between.
    pub(super) images: [Option<Image>; 2],
    /// Those of the frame before and of the one after, where the shot has such.
    pub(super) outer: [Option<Image>; 2],
}

/// A step, or why there are no more.
pub(super) type Read = Result<Step, Failure>;

impl From<BlurError> for Failure {
    fn from(error: BlurError) -> Failure {
        match error {
            BlurError::Read(error) => error.into(),
            BlurError::Effect(error) => error.into(),
        }
    }
}

impl Inputs {
    /// For the frames to be `rendered`. Of all this only the animated mesh is read now.
    pub(super) fn new(shot: &Shot, rendered: &[u32], fire: Option<Fire>, common: &Common) -> Result<Inputs, Failure> {
        let images = match shot.blur.as_ref().and_then(|blur| blur.images.clone()) {
            Some(pattern) => Some(Images::new(pattern, shot, rendered)?),
            None => None,
        };
        let scene = shot.scene()?;
        let notes = notes(shot, scene.as_ref());
        let blur = match (scene, &shot.blur) {
            (Some(scene), Some(blur)) => {
                let of_shot = shot.clone();
                let camera = move |frame: f64| of_shot.camera(frame);
                Some(BlurInput::new(scene, camera, shot.frames, &blur.settings, shot.size, common.threads())?)
            }
            _ => None,
        };
        let (volumes, particles) = (shot.volumes()?, shot.particles()?);
        Ok(Inputs { volumes, particles, blur, images, notes, fire, volume: None, particle: None })
    }

    /// What of the shot's scenes is passed over, and what is used where there are several.
    pub(super) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// What the effects are made for that render the `missing` frames, and keep their layers if that is asked for.
    pub(super) fn effects(&mut self, shot: &Shot, missing: &[u32], layers: bool) -> Result<Effects, Failure> {
        let [start, end] = shot.frames;
        let (first, last) = (*missing.first().unwrap_or(&start), *missing.last().unwrap_or(&end));
        let mut effects = Effects::default();
        if let (Some(volumes), Some(smoke)) = (&self.volumes, &shot.smoke) {
            let extent = volumes.extent(interrupt::until(start..=last))?;
            self.volume = Some(extent);
            let light = shot.light(start).source;
            effects.smoke = Some(smoke::Desc {
                size: shot.size,
                target_format: TARGET_FORMAT,
                dimensions: extent.dimensions,
                velocity: extent.velocity,
                point_light: matches!(light, LightSource::Position(_)),
                seed: shot.seed,
                settings: smoke.settings.clone(),
                layers,
                depth: None,
                edges: false,
                skipping: true,
            });
        }
        if let (Some(particles), Some(flame), Some(Fire { hottest, spread })) =
            (&self.particles, &shot.flame, self.fire)
        {
            let extent = particles.extent(interrupt::until(missing.iter().copied()))?;
            let extent = ParticleExtent { hottest: hottest.unwrap_or(extent.hottest), ..extent };
            self.particle = Some(extent);
            effects.flame = Some(flame::Desc {
                size: shot.size,
                target_format: TARGET_FORMAT,
                scene: None,
                particles: extent.most,
                hottest: extent.hottest,
                seed: shot.seed,
                settings: Settings { spread: Some(spread), ..flame.settings.clone() },
                layers,
                skipping: true,
            });
        }
        interrupt::check()?;
        let drawn = self.images.is_none();
        effects.blur = self.blur.as_ref().map(|blur| blur.desc(shot.size, [first, last], shot.seed, drawn, layers));
        Ok(effects)
    }

    /// Reads what the steps bring that render the `missing` frames, one step ahead of who takes them: smoke is stepped
    /// from the shot's first frame, fire has no past.
    pub(super) fn read_ahead(mut self, shot: &Shot, mut origins: Origins, missing: &[u32], to: &SyncSender<Read>) {
        let steps = match (&self.volumes, missing.last()) {
            (Some(_), Some(last)) => (shot.frames[0]..=*last).collect(),
            _ => missing.to_vec(),
        };
        let (mut last_volume, mut last_particles) = (None, None);
        for number in steps {
            memory::doing("reading the input of frame", Some(number));
            let rendered = missing.binary_search(&number).is_ok();
            let mut read = || -> Read {
                // The hash first: what is read between it and the check is what it is of.
                let origin = match rendered {
                    true => origins.of(number)?,
                    false => origins.advance(number).map(|()| 0)?,
                };
                let volume = fresh(&mut self.volumes, number, &mut last_volume)?;
                within(&self.volumes, number, &volume, |volume, path| self.volume.map(|e| e.check(volume, path)))?;
                let particles = match rendered {
                    true => fresh(&mut self.particles, number, &mut last_particles)?,
                    false => None,
                };
                within(&self.particles, number, &particles, |p, path| self.particle.map(|e| e.check(p, path)))?;
                let blur = match (rendered, &mut self.blur) {
                    (true, Some(blur)) => Some(blurred(blur, &mut self.images, number)?),
                    _ => None,
                };
                origins.check()?;
                Ok(Step { number, origin, rendered, volume, particles, blur })
            };
            let step = read();
            let failed = step.is_err();
            // The renderer has gone where nobody takes it.
            if to.send(step).is_err() || failed {
                return;
            }
        }
    }
}

fn notes(shot: &Shot, scene: Option<&AnimatedMesh>) -> Vec<String> {
    let mut notes = Vec::new();
    let has_images = shot.blur.as_ref().is_some_and(|blur| blur.images.is_some());
    let mut of_file = |mesh: &AnimatedMesh, looks: bool| {
        let file = mesh.path().display();
        let passed_over = mesh.notes().iter().filter(|note| looks || !note.looks);
        notes.extend(passed_over.map(|note| format!("{file}: {}", note.text)));
    };
    scene.iter().for_each(|mesh| of_file(mesh, !has_images));
    // Of a camera's file nothing else is seen.
    shot.camera_scene().iter().for_each(|mesh| of_file(mesh, false));
    if let (Some(mesh), Some(blur)) = (scene, &shot.blur)
        && let ([first, _, ..], true) = (mesh.animations(), blur.animations.is_empty())
    {
        let (file, name, all) = (mesh.path().display(), &first.name, mesh.animations().len());
        notes.push(format!("{file}: plays its first animation, `{name}`, of {all}; blur.animation names others"));
    }
    if let Some(mesh) = shot.camera_scene()
        && let (Some(camera), [_, _, ..]) = (mesh.camera_taken(), mesh.cameras())
    {
        let (file, name, all) = (mesh.path().display(), &camera.name, mesh.cameras().len());
        notes.push(format!("{file}: is seen by its camera `{name}`, of {all}; camera.name names others"));
    }
    let mut seen = HashSet::new();
    notes.retain(|note| seen.insert(note.clone()));
    notes
}

fn blurred(blur: &mut BlurInput, images: &mut Option<Images>, number: u32) -> Result<Blurred, Failure> {
    let frame = blur.frame(number)?;
    let ([before, after], [earlier, later]) = (frame.images(), frame.outer_images());
    let mut image = |frame: Option<u32>| match (&mut *images, frame) {
        (Some(images), Some(frame)) => images.frame(frame).map(Some),
        _ => Ok(None),
    };
    let (earlier, before, after, later) = (image(earlier)?, image(Some(before))?, image(Some(after))?, image(later)?);
    Ok(Blurred { frame, images: [before, after], outer: [earlier, later] })
}

impl Images {
    /// An error if one of the shot's frames has none that a frame to be `rendered` is made from.
    fn new(pattern: Pattern, shot: &Shot, rendered: &[u32]) -> Result<Images, Failure> {
        let [first, last] = shot.frames;
        // From the frame before it, and those around both.
        let made_from = |frame: &u32| match *frame == first {
            true => first..=first,
            false => frame.saturating_sub(2).max(first)..=last.min(frame + 1),
        };
        let needed: BTreeSet<u32> = interrupt::until(rendered).flat_map(made_from).collect();
        let is_missing = |frame: &&u32| !pattern.path(**frame).is_file();
        let missing: Vec<u32> = interrupt::until(&needed).filter(is_missing).copied().collect();
        interrupt::check()?;
        if let Some(frame) = missing.first() {
            let (all, missing) = (last - first + 1, missing.len());
            let of_needed = match needed.len() as u32 {
                needed if needed == all => format!("{missing} of the shot's {all} frames have no image"),
                needed => format!("{missing} of the {needed} frames that are needed of the shot's {all} have no image"),
            };
            let what = if pattern.path(*frame).exists() { "is not a file" } else { "no such file" };
            let [from, to] = [needed.first(), needed.last()].map(|frame| *frame.unwrap_or(&first));
            let expected = format!("one for each of the frames {from} to {to}");
            return Err(ReadError::file(&pattern.path(*frame), format!("{what}; {of_needed}"), expected).into());
        }
        Ok(Images { pattern, size: shot.size, last: Vec::new() })
    }

    fn frame(&mut self, frame: u32) -> Result<Image, ReadError> {
        if let Some((_, image)) = self.last.iter().find(|(last, _)| *last == frame) {
            return Ok(image.clone());
        }
        let path = self.pattern.path(frame);
        let image = Arc::new(picture::read_frame(&path, self.size)?);
        if self.last.len() > 3 {
            self.last.remove(0);
        }
        self.last.push((frame, image.clone()));
        Ok(image)
    }
}

/// A frame's input, unless it is the `last` one that was handed over, which it becomes.
fn fresh<I: Input>(
    sequence: &mut Option<Sequence<I>>,
    frame: u32,
    last: &mut Option<Arc<I>>,
) -> Result<Option<Arc<I>>, ReadError> {
    let Some(sequence) = sequence else { return Ok(None) };
    // A sequence hands out the same one for as long as it lasts.
    let input = sequence.frame(frame)?;
    let is_same = last.as_ref().is_some_and(|last| Arc::ptr_eq(last, &input));
    *last = Some(input.clone());
    Ok((!is_same).then_some(input))
}

/// Refuses a frame's input that `check` refuses; what the program makes itself is as it should be.
fn within<I: Input>(
    sequence: &Option<Sequence<I>>,
    frame: u32,
    input: &Option<Arc<I>>,
    check: impl FnOnce(&I, &Path) -> Option<Result<(), ReadError>>,
) -> Result<(), ReadError> {
    let (Some(sequence), Some(input)) = (sequence, input) else { return Ok(()) };
    match sequence.file(frame)? {
        Some(path) => check(input, &path).unwrap_or(Ok(())),
        None => Ok(()),
    }
}

/// The spread of a flame that has none: the mean distance to the 8th neighbour in the shot's first frame that has one.
fn spread(particles: &mut ParticleSequence, [first, last]: [u32; 2]) -> Result<f32, ReadError> {
    for frame in interrupt::until(first..=last) {
        if let Some(spacing) = mean_spacing(&particles.frame(frame)?.position) {
            return Ok(spacing);
        }
    }
    Ok(DEFAULT_SPREAD)
}
