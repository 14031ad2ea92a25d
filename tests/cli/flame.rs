//! Shots with fire, alone and with smoke.

use std::fs;

use celfx::io::image;
use npyz::NpyFile;

use super::run::{self, Folder, celfx, has_device};
use super::{fails, succeeds};

const FIRE: &str =
    "size = [64, 48]\nframes = [1, 5]\n[camera]\neye = [0, 1, 5]\n[flame]\nparticles = \"builtin:random\"\n";
const SMOKE: &str = "[smoke]\nparticles = 60\n";

/// Renders the whole shot and some of its frames alone: they are the same, and of so many files.
fn assert_alone(shot: &str, files: usize) -> Folder {
    let folder = Folder::new();
    folder.write("shot.toml", shot);
    let render = ["render", "shot.toml", "-q", run::validate()];
    succeeds(&folder, &[&render[..], &["-o", "all/####.exr", "--layers", "all", "--threads", "3"]].concat());
    for frame in ["2", "5"] {
        let alone = ["--frames", frame, "-o", "alone/####.exr", "--layers", "alone"];
        succeeds(&folder, &[&render[..], &alone].concat());
    }
    let names = run::names(&folder.0.join("alone"));
    assert_eq!(names.len(), 2 * files, "{names:?}");
    for name in names {
        let [all, alone] = ["all", "alone"].map(|of| fs::read(folder.0.join(of).join(&name)).expect(&name));
        assert!(all == alone, "{name} differs");
    }
    // What is missing is rendered as it was.
    for name in ["0003.exr", "flame.mask.0004.npy"] {
        let path = folder.0.join("all").join(name);
        let before = fs::read(&path).expect(name);
        fs::remove_file(&path).expect(name);
        succeeds(&folder, &[&render[..], &["-o", "all/####.exr", "--layers", "all", "--resume"]].concat());
        assert!(fs::read(&path).expect(name) == before, "{name} differs after --resume");
    }
    folder
}

#[test]
fn a_frame_of_fire_alone_equals_the_frame_of_the_sequence() {
    if !has_device() {
        return;
    }
    let folder = assert_alone(FIRE, 12);
    let array = |name: &str| {
        let bytes = fs::read(folder.0.join("all").join(name)).expect(name);
        let shape = NpyFile::new(&bytes[..]).expect(name).shape().to_vec();
        let values: Vec<f32> = NpyFile::new(&bytes[..]).expect(name).into_vec().expect(name);
        (shape, values)
    };
    let (shape, rows) = array("flame.particles.0002.npy");
    assert!(shape[0] > 0 && shape[1] == 9, "{shape:?}");
    assert!(rows.chunks(9).all(|row| row[3] > 0.0 && row[4] > 0.0), "temperature and mean count");
    assert_eq!(array("flame.mask.0002.npy").0, [16, 64, 64]);
    let channels = [("mean", "BGR"), ("variance", "BGR"), ("coverage", "Y"), ("depth", "Y"), ("repetitions", "Y")];
    let drawn = [("heat", "Y"), ("tone", "ABGR"), ("outline", "Y")];
    for (layer, names) in channels.into_iter().chain(drawn) {
        let picture = image::read_exr(&folder.0.join(format!("all/flame.{layer}.0002.exr"))).expect(layer);
        let found: String = picture.channels.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!((found.as_str(), picture.size), (names, [64, 48]), "{layer}");
    }
    assert_eq!(image::read_exr(&folder.0.join("all/flame.0002.exr")).expect("a layer").channels.len(), 4);
}

#[test]
fn a_frame_of_fire_and_smoke_alone_equals_the_frame_of_the_sequence() {
    if !has_device() {
        return;
    }
    let folder = assert_alone(&format!("{FIRE}{SMOKE}"), 21);
    succeeds(&folder, &["render", "shot.toml", "-o", "a.png", "--frames", "2", "--profile", "p.csv"]);
    let profile = fs::read_to_string(folder.0.join("p.csv")).expect("a profile");
    assert!(["\n2,smoke.", "\n2,flame."].iter().all(|row| profile.contains(row)), "{profile}");
}

#[test]
fn a_spread_is_found_and_said() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", FIRE);
    let said = |frame: &str| {
        let arguments = ["render", "shot.toml", "-v", "-o", "a.png", "--frames", frame];
        let output = celfx(&folder, &arguments).output().expect("the program runs");
        let text = String::from_utf8(output.stderr).expect("UTF-8");
        text.lines().find(|line| line.contains("flame.spread = ")).expect("it is said").to_owned()
    };
    assert_eq!(said("1"), said("4"), "that of the shot");
}

#[test]
fn fire_lights_only_what_is_there() {
    let folder = Folder::new();
    folder.write("shot.toml", &format!("{FIRE}light = 0.5\n"));
    fails(&folder, &["render", "shot.toml"], 2, &["shot.toml", "flame.light = 0.5", "[smoke] or [blur]"]);
    assert_eq!(folder.names(), ["shot.toml"], "nothing was written");
}
