//! Shots with smoke from files.

use std::fs;
use std::path::Path;

use celfx::io::image;

use super::run::{self, Folder, has_device};
use super::{fails, succeeds};

const SHOT: &str = "size = [64, 64]\nframes = [1, 3]\nbackground = \"none\"\n[camera]\neye = [0.6, 3, 9]\n\
    target = [0.6, 2.6, 3.6]\n[smoke]\nparticles = 200\nscale = 2\nthreshold = 0.05\n";

/// Files of OpenVDB's own, and archives of what it reads in them.
fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/vdb").join(name)
}

/// What a picture shows; its header says what it is made of.
fn shown(folder: &Folder, name: &str) -> Vec<(String, Vec<u32>)> {
    let picture = image::read_exr(&folder.0.join(name)).expect("a picture");
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect();
    picture.channels.into_iter().map(|(name, values)| (name, bits(values))).collect()
}

fn render(folder: &Folder, keys: &str, frame: &str) -> Vec<(String, Vec<u32>)> {
    folder.write("shot.toml", &format!("{SHOT}{keys}\n"));
    succeeds(folder, &["render", "shot.toml", "-q", "-o", "a.exr", "--frames", frame, run::validate()]);
    shown(folder, "a.exr")
}

/// Smoke is the same from OpenVDB's files and from archives, where these have the same voxels at the same places.
#[test]
fn smoke_does_not_depend_on_the_kind_of_file() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    for name in ["plain.vdb", "plain.npz"] {
        fs::copy(fixture(name), folder.0.join(name)).expect("a copy");
    }
    for more in ["", "\nup = \"z\"", "\nvelocity_scale = 3", "\nvelocity_grid = \"nothing\""] {
        let of = |name: &str| format!("volume = \"{name}\"{more}");
        if more.contains("nothing") {
            let shot = format!("{SHOT}{}\n", of("plain.vdb"));
            folder.write("shot.toml", &shot);
            let needles = ["plain.vdb: no frame has a velocity `nothing`"];
            fails(&folder, &["render", "shot.toml", "-o", "a.####.exr"], 3, &needles);
            continue;
        }
        let [vdb, npz] = ["plain.vdb", "plain.npz"].map(|name| render(&folder, &of(name), "2"));
        assert!(vdb == npz, "{more}");
        let is_seen = vdb.iter().any(|(name, values)| name == "A" && values.iter().any(|value| *value > 0));
        assert!(is_seen || more.contains("up"), "the camera looks at it where y is up");
    }
}

/// Smoke may begin later, and files may be fewer than frames.
#[test]
fn caches_are_of_their_own_rate_and_may_begin_empty() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    fs::copy(fixture("maps.vdb"), folder.0.join("s.0001.vdb")).expect("a copy");
    fs::copy(fixture("tiles.vdb"), folder.0.join("s.0002.vdb")).expect("a copy");
    let keys = "volume = \"s.####.vdb\"\ndensity_grid = \"copy\"\nvolume_fps = 12\nstill = 0\n[light]\nambient = 0.3";
    folder.write("shot.toml", &format!("{SHOT}{keys}\n"));
    succeeds(&folder, &["render", "shot.toml", "-q", "-o", "####.exr", run::validate()]);
    let frames = [1, 2, 3].map(|frame| shown(&folder, &format!("{frame:04}.exr")));
    assert!(frames[0] == frames[1] && frames[1] != frames[2], "two without smoke, one with");
    // A frame without smoke that is rendered alone is none of a wrong name.
    succeeds(&folder, &["render", "shot.toml", "-q", "-o", "a.exr", "--frames", "1", run::validate()]);
    assert!(shown(&folder, "a.exr") == frames[0]);
    folder.write("shot.toml", &format!("{SHOT}volume = \"s.####.vdb\"\ndensity_grid = \"copy\"\n"));
    fails(&folder, &["render", "shot.toml", "-o", "a.####.exr"], 3, &["s.0003.vdb: no such file"]);
    let inspected = succeeds(&folder, &["inspect", "s.0002.vdb"]);
    assert!(inspected.contains("grid `density[1]`: float, 4 x 4 x 4 voxels"), "{inspected}");
}
