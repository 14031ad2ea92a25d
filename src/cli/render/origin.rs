//! What frames are made from, as a hash that each picture's file keeps: so that `--resume` tells frames of this shot from
//! those of another one, or of the same with other settings or input.
//!
//! In it is all that a frame's pixels depend on: the settings, the camera and the light, what is in the files of its input
//! (not where they are), its number, and the version of the program. Not in it is what changes no pixel (names and
//! formats of outputs, layers, threads, validation, which frames are rendered), and not the device and its driver: two of
//! them differ by a step of 1/255 here and there, and a sequence may be shared among machines.

use std::collections::HashMap;
use std::fmt::Debug;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::Xxh3;

use super::input::Fire;
use crate::blur::settings::Trajectory;
use crate::io::ReadError;
use crate::io::file::{Stamp, digest};
use crate::io::particles::ParticleSequence;
use crate::io::pattern::PatternError;
use crate::io::scene::{Source, references};
use crate::io::sequence::{Input, Sequence};
use crate::io::shot::{Background, Shot};
use crate::io::volume::VolumeSequence;
use crate::offline::blur::{FRAMES_BESIDE, STEPS};

/// Hashes of what the frames of a shot are made from. Files are read once.
pub(super) struct Origins<'a> {
    shot: &'a Shot,
    files: Known,
    volumes: Option<VolumeSequence>,
    particles: Option<ParticleSequence>,
    /// What all frames have in common.
    common: Xxh3,
    /// What smoke has gone through before a frame, and that frame.
    past: (u32, Xxh3),
}

/// Files whose contents are known.
#[derive(Default)]
struct Known {
    files: HashMap<PathBuf, (Stamp, u128)>,
    /// Those that were asked for since the last check.
    recent: Vec<PathBuf>,
}

impl Known {
    fn digest(&mut self, path: &Path) -> Result<u128, ReadError> {
        self.recent.push(path.to_owned());
        if let Some((_, digest)) = self.files.get(path) {
            return Ok(*digest);
        }
        // Before the contents, so that what is written meanwhile shows.
        let stamp = Stamp::of(path)?;
        let digest = digest(path)?;
        self.files.insert(path.to_owned(), (stamp, digest));
        Ok(digest)
    }

    fn check(&mut self) -> Result<(), ReadError> {
        let Known { files, recent } = self;
        recent.drain(..).try_for_each(|path| files.get(&path).map_or(Ok(()), |(stamp, _)| stamp.check(&path)))
    }
}

impl<'a> Origins<'a> {
    /// Of a shot whose fire is `fire`. Reads the background and the animated mesh.
    pub(super) fn new(shot: &'a Shot, fire: Option<&Fire>) -> Result<Origins<'a>, ReadError> {
        let refused = |e: PatternError| ReadError::file(&e.path, e.why, "a file name");
        let (volumes, particles) = (shot.volumes().map_err(refused)?, shot.particles().map_err(refused)?);
        let mut files = Known::default();
        let mut common = Xxh3::new();
        add(&mut common, (env!("CARGO_PKG_VERSION"), shot.size, shot.fps, shot.seed));
        match &shot.background {
            Background::Image(path) => add(&mut common, files.digest(path)?),
            other => add(&mut common, other),
        }
        if let Some(smoke) = &shot.smoke {
            add(&mut common, ("smoke", shot.frames[0], &smoke.grids, builtin(&smoke.volume), &smoke.settings));
        }
        if let Some(flame) = &shot.flame {
            add(&mut common, ("flame", builtin(&flame.particles), fire, &flame.settings));
        }
        if let Some(blur) = &shot.blur {
            add(&mut common, ("blur", shot.frames, &blur.animations, blur.images.is_some(), &blur.settings));
            match &blur.scene {
                Source::Builtin(which) => add(&mut common, which),
                Source::File(path) => {
                    for part in std::iter::once(path.clone()).chain(references(path)) {
                        // A part that is not there is told when the mesh is read; some are done without.
                        let digest = if part == *path { Some(files.digest(&part)?) } else { files.digest(&part).ok() };
                        add(&mut common, digest);
                    }
                }
            }
        }
        Ok(Origins { shot, files, volumes, particles, common, past: (shot.frames[0], Xxh3::new()) })
    }

    /// The hash of a frame. Frames are best asked for in ascending order: smoke has all volumes up to its frame in it.
    pub(super) fn of(&mut self, frame: u32) -> Result<u128, ReadError> {
        let mut hash = self.common.clone();
        add(&mut hash, frame);
        self.add_view(&mut hash, frame);
        self.advance(frame)?;
        add(&mut hash, self.past.1.digest128());
        add(&mut hash, input(&mut self.files, &self.particles, frame)?);
        self.add_blur(&mut hash, frame)?;
        Ok(hash.digest128())
    }

    /// An error if a file that was asked for since the last check is no longer what it was.
    pub(super) fn check(&mut self) -> Result<(), ReadError> {
        self.files.check()
    }

    /// Takes smoke, if there is any, through a frame: what it sees of camera and light leaves something to the next, too.
    pub(super) fn advance(&mut self, frame: u32) -> Result<(), ReadError> {
        if self.volumes.is_none() {
            return Ok(());
        }
        if self.past.0 > frame + 1 {
            self.past = (self.shot.frames[0], Xxh3::new());
        }
        while self.past.0 <= frame {
            let (at, mut hash) = (self.past.0, self.past.1.clone());
            self.add_view(&mut hash, at);
            add(&mut hash, input(&mut self.files, &self.volumes, at)?);
            self.past = (at + 1, hash);
        }
        Ok(())
    }

    fn add_view(&self, hash: &mut Xxh3, frame: u32) {
        add(hash, (self.shot.camera(frame), self.shot.light(frame)));
    }

    /// The cameras of all frames that trajectories may go through, and the images of those that are blurred.
    fn add_blur(&mut self, hash: &mut Xxh3, frame: u32) -> Result<(), ReadError> {
        let Some(blur) = &self.shot.blur else { return Ok(()) };
        let [first, last] = self.shot.frames;
        let around = |before: u32, after: u32| frame.saturating_sub(before).max(first)..=(frame + after).min(last);
        let steps = if blur.settings.trajectory == Trajectory::Exact { STEPS } else { 1 };
        for at in around(FRAMES_BESIDE + 1, FRAMES_BESIDE) {
            let times = (0..steps).map(|step| f64::from(at) + f64::from(step) / f64::from(steps));
            times.for_each(|time| add(hash, self.shot.camera(time)));
        }
        for at in around(2, 1) {
            let image = blur.images.as_ref().map(|images| self.files.digest(&images.path(at)));
            add(hash, image.transpose()?);
        }
        Ok(())
    }
}

/// What is in the file of a frame's input; none where it is built in.
fn input<I: Input>(files: &mut Known, sequence: &Option<Sequence<I>>, frame: u32) -> Result<Option<u128>, ReadError> {
    let file = sequence.as_ref().map(|sequence| sequence.file(frame)).transpose()?.flatten();
    file.map(|file| files.digest(&file)).transpose()
}

/// The name of a built-in input; a file is known by what is in it.
fn builtin(name: &str) -> Option<&str> {
    name.starts_with("builtin:").then_some(name)
}

/// Adds a value by its text, which has every digit of every number and ends where the next begins.
fn add(hash: &mut Xxh3, value: impl Debug) {
    hash.update(format!("{value:?}\n").as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::array::tests::{npy, write_archive};
    use crate::io::tests::Folder;
    use std::fs;

    fn origins(folder: &Folder, name: &str, sets: &[&str], frames: &[u32]) -> Vec<u128> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let shot = Shot::load(folder.0.join(name).to_str().expect("UTF-8"), &sets).expect("a shot");
        let fire = Fire::of(&shot).expect("readable");
        let mut origins = Origins::new(&shot, fire.as_ref()).expect("readable");
        frames.iter().map(|frame| origins.of(*frame).expect("readable")).collect()
    }

    fn f32s(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn write_volume(path: &Path, density: f32) {
        let density = npy("'<f4'", false, "(1, 1, 2)", &f32s(&[density, 0.0]));
        write_archive(path, &[("density", density), ("voxel_size", npy("'<f4'", false, "()", &f32s(&[1.0])))]);
    }

    fn write_particles(path: &Path, temperature: f32) {
        let positions = npy("'<f4'", false, "(2, 3)", &f32s(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]));
        let temperatures = npy("'<f4'", false, "(2,)", &f32s(&[1000.0, temperature]));
        write_archive(path, &[("position", positions), ("temperature", temperatures)]);
    }

    /// A shot of four frames with all effects, from files.
    fn folder() -> Folder {
        let folder = Folder::new();
        for frame in 1..=4 {
            write_volume(&folder.0.join(format!("v.{frame}.npz")), 1.0);
            write_particles(&folder.0.join(format!("p.{frame}.npz")), 1500.0);
            fs::write(folder.0.join(format!("i.{frame}.png")), [frame]).expect("temporary folder");
        }
        let head = "size = [8, 8]\nframes = [1, 4]\n";
        let smoke = format!("{head}[smoke]\nvolume = \"v.#.npz\"\n");
        let flame = format!("{head}[flame]\nparticles = \"p.#.npz\"\n");
        let blur = format!("{head}[blur]\nimages = \"i.#.png\"\n");
        for (name, text) in [("smoke.toml", smoke), ("flame.toml", flame), ("blur.toml", blur)] {
            fs::write(folder.0.join(name), text).expect("temporary folder");
        }
        folder
    }

    const ALL: [u32; 4] = [1, 2, 3, 4];

    /// Which of the four frames are others with these settings.
    fn others(folder: &Folder, name: &str, sets: &[&str]) -> Vec<u32> {
        let (before, after) = (origins(folder, name, &[], &ALL), origins(folder, name, sets, &ALL));
        ALL.into_iter().filter(|frame| before[*frame as usize - 1] != after[*frame as usize - 1]).collect()
    }

    #[test]
    fn frames_know_their_settings_and_not_where_anything_is() {
        let folder = folder();
        for name in ["smoke.toml", "flame.toml", "blur.toml"] {
            let all = origins(&folder, name, &[], &ALL);
            assert!((1..4).all(|i| all[i] != all[i - 1]), "{name}: frames differ");
            for frame in ALL {
                assert_eq!(origins(&folder, name, &[], &[frame]), [all[frame as usize - 1]], "{name}: alone");
            }
            assert_eq!(
                origins(&folder, name, &[], &[4, 1, 3, 2]),
                [3, 0, 2, 1].map(|i: usize| all[i]),
                "{name}: order"
            );
            let sets =
                ["size=[8, 9]", "fps=25", "seed=1", "background=none", "camera.eye=[0, 0, 9]", "light.ambient=0"];
            for set in sets {
                assert_eq!(others(&folder, name, &[set]), ALL, "{name}: {set}");
            }
            assert!(others(&folder, name, &["seed=0", "fps=24"]).is_empty(), "{name}: what it was");
        }
        assert_eq!(others(&folder, "smoke.toml", &["smoke.sigma=3"]), ALL);
        assert_eq!(others(&folder, "flame.toml", &["flame.flicker=0.5"]), ALL);
        assert_eq!(others(&folder, "blur.toml", &["blur.toon.outline.width=2"]), ALL);
        // The shot's end is the smoke's only as far as it gets, and a blur's always.
        assert!(others(&folder, "smoke.toml", &["frames=[1, 9]"]).is_empty());
        assert_eq!(others(&folder, "smoke.toml", &["frames=[0, 4]", "smoke.hold=true", "smoke.volume=v.1.npz"]), ALL);
        let moved = Folder::new();
        for name in folder.names() {
            fs::copy(folder.0.join(&name), moved.0.join(&name)).expect("temporary folder");
        }
        assert_eq!(origins(&folder, "smoke.toml", &[], &ALL), origins(&moved, "smoke.toml", &[], &ALL));
    }

    #[test]
    fn keyframes_change_the_frames_that_see_them() {
        let folder = folder();
        let moves = ["camera.eye=[[3, [0, 1, 4]], [4, [0, 1, 5]]]"];
        let still = "camera.eye=[0, 1, 4]";
        let differ = |name: &str| {
            let (a, b) = (origins(&folder, name, &[still], &ALL), origins(&folder, name, &moves, &ALL));
            (0..4).filter(|i| a[*i] != b[*i]).collect::<Vec<_>>()
        };
        assert_eq!((differ("smoke.toml"), differ("flame.toml")), (vec![3], vec![3]));
        assert_eq!(differ("blur.toml"), [0, 1, 2, 3], "trajectories go through frames around");
    }

    #[test]
    fn frames_know_what_is_in_the_files_that_they_are_made_from() {
        let folder = folder();
        let before = ["smoke.toml", "flame.toml", "blur.toml"].map(|name| origins(&folder, name, &[], &ALL));
        write_volume(&folder.0.join("v.3.npz"), 2.0);
        write_particles(&folder.0.join("p.3.npz"), 1200.0);
        fs::write(folder.0.join("i.3.png"), "other").expect("temporary folder");
        let after = ["smoke.toml", "flame.toml", "blur.toml"].map(|name| origins(&folder, name, &[], &ALL));
        let differ = [0, 1, 2].map(|shot: usize| {
            ALL.into_iter()
                .filter(|i| before[shot][*i as usize - 1] != after[shot][*i as usize - 1])
                .collect::<Vec<_>>()
        });
        // Smoke goes on from frame to frame, fire does not, and a blur is between its frames and the ones around them.
        assert_eq!(differ, [vec![3, 4], vec![3], vec![2, 3, 4]]);
        // A table of colours that ends elsewhere is another one for all frames.
        let physical = || origins(&folder, "flame.toml", &["flame.colour=physical"], &ALL);
        let before = physical();
        write_particles(&folder.0.join("p.3.npz"), 1600.0);
        assert!(before.iter().zip(physical()).all(|(before, after)| *before != after));
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_named() {
        let folder = folder();
        let shot = Shot::load(folder.0.join("smoke.toml").to_str().expect("UTF-8"), &[]).expect("a shot");
        let mut origins = Origins::new(&shot, None).expect("readable");
        origins.of(2).expect("readable");
        origins.check().expect("as it was");
        origins.of(3).expect("readable");
        fs::write(folder.0.join("v.3.npz"), "of another length").expect("temporary folder");
        assert!(origins.check().expect_err("changed").to_string().contains("v.3.npz: was written or replaced"));
    }
}
