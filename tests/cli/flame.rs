//! Shots with fire, alone and with smoke.

use std::fs;

use celfx::io::{image, picture};
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
    let folder = assert_alone(&format!("{FIRE}light = 2\n{SMOKE}"), 29);
    succeeds(&folder, &["render", "shot.toml", "-o", "a.png", "--frames", "2", "--profile", "p.csv"]);
    let profile = fs::read_to_string(folder.0.join("p.csv")).expect("a profile");
    assert!(["\n2,smoke.", "\n2,flame."].iter().all(|row| profile.contains(row)), "{profile}");
}

/// The same particles in another kind of file are the same fire.
#[test]
fn fire_does_not_depend_on_the_kind_of_file() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let particles = [[0.0, 0.1, 0.0, 2900.0, 5.0], [0.05, 0.25, 0.02, 2200.0, 9.0], [-0.04, 0.4, 0.0, 1500.0, 2.0]];
    let rows = |separator: &str| {
        let row = |row: &[f64; 5]| row.map(|value| value.to_string()).join(separator) + "\n";
        particles.iter().map(row).collect::<String>()
    };
    folder.write("fire.csv", &format!("x, y, z, temperature, id\n{}", rows(", ")));
    let properties = ["x", "y", "z", "temperature", "id"].map(|name| format!("property double {name}\n")).concat();
    let header = |format: &str| format!("ply\nformat {format} 1.0\nelement vertex 3\n{properties}end_header\n");
    folder.write("fire.ply", &(header("ascii") + &rows(" ")));
    let bytes: Vec<u8> = particles.as_flattened().iter().flat_map(|value| value.to_be_bytes()).collect();
    let file = [header("binary_big_endian").as_bytes(), &bytes].concat();
    fs::write(folder.0.join("big.ply"), file).expect("a file");
    let pictures = ["fire.csv", "fire.ply", "big.ply"].map(|name| {
        folder.write("shot.toml", &FIRE.replace("builtin:random", name));
        succeeds(&folder, &["render", "shot.toml", "-q", "-o", "a.exr", "--frames", "1"]);
        let inspected = succeeds(&folder, &["inspect", "--json", name]);
        assert!(inspected.contains("\"count\": 3") && inspected.contains("2900"), "{inspected}");
        image::read_exr(&folder.0.join("a.exr")).expect("a picture").channels
    });
    assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2]);
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
    for frame in ["1", "4"] {
        assert!(said(frame).contains(&format!(" m in frame {frame}")), "each frame has its own: {}", said(frame));
    }
}

/// The fire's light has the smoke's form: steps, below and not above. It is no tint: what is not smoke stays.
#[test]
fn fire_lights_smoke_from_below_and_in_steps() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let smoke = "particles = 300\nsigma = 2\ntone_softness = 0\nantialias = \"none\"\nemitter = { min = [-1, 0.7, -1], max = [1, 2, 1] }\n\
        tones = [[0, [0.1, 0.1, 0.1]], [0.4, [0.25, 0.25, 0.25]], [0.7, [0.5, 0.5, 0.5]]]\noutline = { strength = 0 }\n";
    let shot = |light: u32| format!("{FIRE}light = {light}\nreach = 1\n[smoke]\n{smoke}");
    let tones = [0, 4].map(|light| {
        folder.write("shot.toml", &shot(light));
        let name = format!("{light}");
        let arguments = ["-q", "-o", "a.exr", "--frames", "5", "--layers", &name, run::validate()];
        succeeds(&folder, &[&["render", "shot.toml"][..], &arguments].concat());
        picture::read(&folder.0.join(name).join("smoke.tone.0005.exr")).expect("a layer").pixels
    });
    let added: Vec<f32> = tones[0].iter().zip(&tones[1]).map(|(dark, lit)| lit[0] - dark[0]).collect();
    assert!(tones[0].iter().zip(&added).all(|(tone, added)| tone[3] > 0.0 || *added == 0.0));
    // The red of a fire is the brightest of it: 4, half of it and none, times the lightest tone.
    let step = |added: f32| [0.0, 1.0, 2.0].iter().position(|step| (added - step).abs() < 1e-5);
    let steps: Option<Vec<usize>> = added.iter().map(|added| step(*added)).collect();
    let steps = steps.expect("light comes in steps");
    let lit = |rows: std::ops::Range<usize>| steps[64 * rows.start..64 * rows.end].iter().sum::<usize>();
    let seen: Vec<usize> = (0..48).filter(|y| (0..64).any(|x| tones[0][64 * y + x][3] > 0.0)).collect();
    let (top, bottom) = (seen[0], seen[seen.len() - 1] + 1);
    let middle = (top + bottom) / 2;
    let [above, below] = [lit(top..middle), lit(middle..bottom)];
    assert!(below > 10 && below > 2 * above, "{above} above, {below} below");
}

#[test]
fn fire_lights_only_what_is_there() {
    let folder = Folder::new();
    folder.write("shot.toml", &format!("{FIRE}light = 0.5\n"));
    fails(&folder, &["render", "shot.toml"], 2, &["shot.toml", "flame.light = 0.5", "[smoke] or [blur]"]);
    assert_eq!(folder.names(), ["shot.toml"], "nothing was written");
}
