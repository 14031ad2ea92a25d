//! Input of a blur: a mesh that moves, and the pictures of its frames.

use std::collections::BTreeSet;
use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::shot::Blur;
use crate::blur::settings::Trajectory;
use crate::interrupt;
use crate::io::image::Picture;
use crate::io::passes::Passes;
use crate::io::pattern::Pattern;
use crate::io::scene::{AnimatedMesh, Source, references};
use crate::io::shot::Shot;
use crate::io::{ReadError, picture};
use crate::offline::motion::{FRAMES_BESIDE, STEPS};
use crate::offline::{BlurError, BlurFrame, BlurInput as Animation, BlurScene, Effects, PassesInput, Scene};
use crate::program::{Brought, Files, Input, InputError, Opened, add};

/// A shot's mesh and pictures.
struct BlurInput {
    shot: Arc<Shot>,
    blur: Blur,
    /// Both are there once frames are to be rendered.
    motion: Option<Motion>,
    images: Option<Images>,
    /// Names of the mesh's objects, by their numbers in it.
    objects: Arc<[String]>,
    notes: Vec<String>,
}

/// Where motion comes from.
enum Motion {
    Scene(Box<Animation>),
    Passes(Box<PassesInput>),
}

impl Motion {
    fn frame(&mut self, frame: u32) -> Result<BlurFrame, BlurError> {
        match self {
            Motion::Scene(scene) => scene.frame(frame),
            Motion::Passes(passes) => passes.frame(frame),
        }
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
type Image = Arc<Picture<[f32; 4]>>;

/// Input of a blurred frame.
pub(super) struct BlurBrought {
    /// The motion.
    pub(super) frame: BlurFrame,
    /// Names of the objects of a mesh, by their numbers in it.
    pub(super) names: Arc<[String]>,
    /// The pictures of the frames that it is between.
    images: [Option<Image>; 2],
    /// Those of the frame before and of the one after, where the shot has such.
    outer: [Option<Image>; 2],
}

pub(super) fn open(shot: &Arc<Shot>) -> Opened {
    let Some(blur) = shot.part::<Blur>() else { return Ok(None) };
    let (shot, blur) = (shot.clone(), blur.clone());
    Ok(Some(Box::new(BlurInput { shot, blur, motion: None, images: None, objects: Arc::default(), notes: Vec::new() })))
}

impl Input for BlurInput {
    fn add_common(&self, hash: &mut Xxh3, files: &mut Files) -> Result<(), ReadError> {
        let Blur { scene, animations, images, passes, cuts, shares, share_map, settings } = &self.blur;
        add(hash, ("blur", self.shot.frames, animations, images.is_some(), cuts, shares, settings));
        add(hash, share_map.as_ref().map(|map| files.digest(map)).transpose()?);
        if let Some(Passes { vectors, scale, .. }) = passes {
            add(hash, ("passes", vectors, scale));
        }
        match scene {
            Source::Builtin(which) => add(hash, which),
            Source::File(path) => {
                for part in std::iter::once(path.clone()).chain(references(path)) {
                    // A part that is not there is told when the mesh is read; some are done without.
                    let digest = if part == *path { Some(files.digest(&part)?) } else { files.digest(&part).ok() };
                    add(hash, digest);
                }
            }
        }
        Ok(())
    }

    /// The cameras of all frames that trajectories may go through, and the images of those that are blurred.
    fn add_frame(&self, hash: &mut Xxh3, files: &mut Files, frame: u32) -> Result<(), ReadError> {
        let [first, last] = self.shot.frames;
        let around = |before: u32, after: u32| frame.saturating_sub(before).max(first)..=(frame + after).min(last);
        let steps = if self.blur.settings.trajectory == Trajectory::Exact { STEPS } else { 1 };
        for at in around(FRAMES_BESIDE + 1, FRAMES_BESIDE) {
            let times = (0..steps).map(|step| f64::from(at) + f64::from(step) / f64::from(steps));
            times.for_each(|time| add(hash, self.shot.camera(time)));
        }
        for at in around(2, 1) {
            for pattern in self.blur.passes.iter().flat_map(Passes::files) {
                add(hash, files.digest(&pattern.path(at))?);
            }
            let image = self.blur.images.as_ref().map(|images| files.digest(&images.path(at)));
            add(hash, image.transpose()?);
        }
        Ok(())
    }

    fn prepare(&mut self, rendered: &[u32], threads: usize) -> Result<(), InputError> {
        if let Some(pattern) = self.blur.images.clone() {
            self.images = Some(Images::new(pattern, &self.shot, rendered)?);
        }
        let cuts = self.blur.cuts.as_deref().unwrap_or_default();
        let (frames, size) = (self.shot.frames, self.shot.size);
        if let Some(passes) = self.blur.passes.clone() {
            let read = move |frame: u32| passes.read(frame, size);
            let motion = PassesInput::new(read, frames, &self.blur.settings, size, threads)?;
            self.motion = Some(Motion::Passes(Box::new(motion.cut_at(cuts))));
            return Ok(());
        }
        let scene = self.blur.mesh(&self.shot)?;
        self.notes = notes(&scene, &self.blur);
        self.objects = scene.topology().objects.clone().into();
        let of_shot = self.shot.clone();
        let view = move |frame: f64| of_shot.camera(frame).view(of_shot.size);
        let motion = Animation::new(scene, view, frames, &self.blur.settings, size, threads)?;
        self.motion = Some(Motion::Scene(Box::new(motion.cut_at(cuts))));
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn describe(&mut self, effects: Effects, rendered: &[u32], layers: bool) -> Result<Effects, InputError> {
        let Shot { size, frames: [start, end], seed, .. } = *self.shot;
        let rendered = [*rendered.first().unwrap_or(&start), *rendered.last().unwrap_or(&end)];
        let drawn = self.images.is_none();
        Ok(match &self.motion {
            Some(Motion::Scene(motion)) => effects.with(motion.desc(size, rendered, seed, drawn, layers)),
            Some(Motion::Passes(passes)) => effects.with(passes.desc(seed, layers)?),
            None => effects,
        })
    }

    fn read(&mut self, frame: u32, rendered: bool) -> Result<Option<Box<dyn Brought>>, InputError> {
        let Some(motion) = self.motion.as_mut().filter(|_| rendered) else { return Ok(None) };
        let frame = motion.frame(frame)?;
        let ([before, after], [earlier, later]) = (frame.images(), frame.outer_images());
        let images = &mut self.images;
        let mut image = |frame: Option<u32>| match (&mut *images, frame) {
            (Some(images), Some(frame)) => images.frame(frame).map(Some),
            _ => Ok(None),
        };
        let (earlier, before) = (image(earlier)?, image(Some(before))?);
        let (after, later) = (image(Some(after))?, image(later)?);
        let names = self.objects.clone();
        Ok(Some(Box::new(BlurBrought { frame, names, images: [before, after], outer: [earlier, later] })))
    }
}

impl BlurBrought {
    /// Names of objects in the order of their numbers on the device; where they have none, their numbers.
    pub(super) fn objects(&self) -> Vec<String> {
        let name = |object: &u32| self.names.get(*object as usize).cloned().unwrap_or_else(|| object.to_string());
        self.frame.mesh.objects().iter().map(name).collect()
    }
}

impl Brought for BlurBrought {
    fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        fn pixels(images: &[Option<Image>; 2]) -> [Option<&[[f32; 4]]>; 2] {
            images.each_ref().map(|image| image.as_deref().map(|picture| &picture.pixels[..]))
        }
        scene.blur = Some(BlurScene { frame: &self.frame, images: pixels(&self.images), outer: pixels(&self.outer) });
    }
}

fn notes(mesh: &AnimatedMesh, blur: &Blur) -> Vec<String> {
    let file = mesh.path().display();
    // Where frames are images, it does not matter how the mesh looks.
    let passed_over = mesh.notes().iter().filter(|note| blur.images.is_none() || !note.looks);
    let mut notes: Vec<String> = passed_over.map(|note| format!("{file}: {}", note.text)).collect();
    if let ([first, _, ..], true) = (mesh.animations(), blur.animations.is_empty()) {
        let (name, all) = (&first.name, mesh.animations().len());
        notes.push(format!("{file}: plays its first animation, `{name}`, of {all}; blur.animation names others"));
    }
    notes
}

impl Images {
    /// An error if one of the shot's frames has none that a frame to be `rendered` is made from.
    fn new(pattern: Pattern, shot: &Shot, rendered: &[u32]) -> Result<Images, InputError> {
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
