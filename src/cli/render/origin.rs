//! The input of frames, as a hash that each picture's file keeps: so that `--resume` tells frames of this shot from
//! those of another one, or of the same with other settings or input.
//!
//! In it is all that a frame's pixels depend on: the settings, the camera and the light, what is in the files of its input
//! (not where they are), its number, and the version of the program. Not in it is what changes no pixel (names and
//! formats of outputs, layers, threads, validation, which frames are rendered), and not the device and its driver: two of
//! them differ by a step of 1/255 here and there, and a sequence may be shared among machines.

use xxhash_rust::xxh3::Xxh3;

use crate::io::ReadError;
use crate::io::display::Output;
use crate::io::shot::{Background, Shot};
use crate::program::{Files, Input, add};

/// Hashes of what the frames of a shot are made from. Files are read once.
pub(super) struct Origins<'a> {
    shot: &'a Shot,
    files: Files,
    /// The hash of all that frames have in common.
    common: Xxh3,
    /// The hash of all that effects with a past have gone through.
    past: Xxh3,
    /// What it was after each frame, from the shot's first.
    pasts: Vec<u128>,
}

/// The input of a shot's effects.
pub(super) type Effects = [Box<dyn Input>];

impl<'a> Origins<'a> {
    /// Of a shot with the input of its effects. Reads the background and the animated mesh.
    pub(super) fn new(shot: &'a Shot, effects: &Effects) -> Result<Origins<'a>, ReadError> {
        let mut files = Files::default();
        let mut common = Xxh3::new();
        add(&mut common, (env!("CARGO_PKG_VERSION"), shot.size, shot.fps, shot.seed));
        match &shot.background {
            Background::Image(path) => add(&mut common, files.digest(path)?),
            other => add(&mut common, other),
        }
        // Frames of the usual display are those of versions that had no other.
        if shot.output != Output::default() {
            let Output { view, config, space } = &shot.output;
            match config.as_ref().filter(|config| config.exists()) {
                Some(file) => add(&mut common, (view, space, files.digest(file)?)),
                None => add(&mut common, (view, space, config)),
            }
        }
        effects.iter().try_for_each(|effect| effect.add_common(&mut common, &mut files))?;
        Ok(Origins { shot, files, common, past: Xxh3::new(), pasts: Vec::new() })
    }

    /// The hash of a frame. Smoke has all volumes up to its frame in it.
    pub(super) fn of(&mut self, frame: u32, effects: &Effects) -> Result<u128, ReadError> {
        let mut hash = self.common.clone();
        add(&mut hash, frame);
        self.add_view(&mut hash, frame);
        add(&mut hash, self.gone_through(frame, effects)?);
        for effect in effects.iter().filter(|effect| !effect.has_past()) {
            effect.add_frame(&mut hash, &mut self.files, frame)?;
        }
        Ok(hash.digest128())
    }

    /// An error if a file that was asked for since the last check is no longer what it was.
    pub(super) fn check(&mut self) -> Result<(), ReadError> {
        self.files.check()
    }

    /// The same of the files that a frame brings, whenever they were asked for.
    pub(super) fn check_of(&mut self, frame: u32, effects: &Effects) -> Result<(), ReadError> {
        effects.iter().try_for_each(|effect| effect.add_frame(&mut Xxh3::new(), &mut self.files, frame))?;
        self.check()
    }

    /// The hash of what the frame after this one goes on from.
    pub(super) fn past(&mut self, frame: u32, effects: &Effects) -> Result<u128, ReadError> {
        let mut hash = self.common.clone();
        add(&mut hash, ("past", self.gone_through(frame, effects)?));
        Ok(hash.digest128())
    }

    /// The hash of what effects that have a past have gone through up to a frame, with that: what they see of camera and light leaves
    /// something to the next, too. Nothing if none has.
    fn gone_through(&mut self, frame: u32, effects: &Effects) -> Result<u128, ReadError> {
        let with_past = || effects.iter().filter(|effect| effect.has_past());
        if with_past().next().is_none() {
            return Ok(0);
        }
        let [first, _] = self.shot.frames;
        let at = (frame - first) as usize;
        while self.pasts.len() <= at {
            let (frame, mut hash) = (first + self.pasts.len() as u32, self.past.clone());
            self.add_view(&mut hash, frame);
            with_past().try_for_each(|effect| effect.add_frame(&mut hash, &mut self.files, frame))?;
            self.pasts.push(hash.digest128());
            self.past = hash;
        }
        Ok(self.pasts[at])
    }

    fn add_view(&self, hash: &mut Xxh3, frame: u32) {
        add(hash, (self.shot.camera(frame), self.shot.light(frame)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::render::input::Inputs;
    use crate::io::array::tests::{npy, write_archive};
    use crate::io::tests::Folder;
    use std::fs;
    use std::path::Path;
    use std::sync::Arc;

    fn origins(folder: &Folder, name: &str, sets: &[&str], frames: &[u32]) -> Vec<u128> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let shot = crate::program::load(folder.0.join(name).to_str().expect("UTF-8"), &sets).expect("a shot");
        let shot = Arc::new(shot);
        let inputs = Inputs::open(&shot).expect("readable");
        let mut origins = Origins::new(&shot, inputs.effects()).expect("readable");
        frames.iter().map(|frame| origins.of(*frame, inputs.effects()).expect("readable")).collect()
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
        // Smoke goes on from frame to frame; fire whose spread isn't given is as wide as that of two frames before and behind
        // says; and a blur is between its frames and the ones around them.
        assert_eq!(differ, [vec![3, 4], vec![1, 2, 3, 4], vec![2, 3, 4]]);
        // A table of colours that ends elsewhere is another one for all frames.
        let physical = || origins(&folder, "flame.toml", &["flame.colour=physical"], &ALL);
        let before = physical();
        write_particles(&folder.0.join("p.3.npz"), 1600.0);
        assert!(before.iter().zip(physical()).all(|(before, after)| *before != after));
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_named() {
        let folder = folder();
        let shot = crate::program::load(folder.0.join("smoke.toml").to_str().expect("UTF-8"), &[]).expect("a shot");
        let shot = Arc::new(shot);
        let inputs = Inputs::open(&shot).expect("readable");
        let mut origins = Origins::new(&shot, inputs.effects()).expect("readable");
        origins.of(2, inputs.effects()).expect("readable");
        origins.check().expect("as it was");
        origins.of(3, inputs.effects()).expect("readable");
        fs::write(folder.0.join("v.3.npz"), "of another length").expect("temporary folder");
        assert!(origins.check().expect_err("changed").to_string().contains("v.3.npz: was written or replaced"));
    }
}
