//! The program as its users meet it: exit codes, messages, files.
//!
//! What renders needs a Vulkan device; without one such a test says so and passes, unless `CELFX_REQUIRE_VULKAN=1`.
#![cfg(feature = "cli")]

#[path = "cli/blur.rs"]
mod blur;
#[path = "cli/colour.rs"]
mod colour;
#[path = "cli/exposure.rs"]
mod exposure;
#[path = "cli/farm.rs"]
mod farm;
#[path = "cli/flame.rs"]
mod flame;
#[path = "cli/hostile.rs"]
mod hostile;
#[path = "cli/info.rs"]
mod info;
#[path = "cli/layered.rs"]
mod layered;
#[path = "cli/look.rs"]
mod look;
#[path = "cli/mixed.rs"]
mod mixed;
#[path = "cli/outputs.rs"]
mod outputs;
#[path = "cli/resume.rs"]
mod resume;
#[path = "cli/run.rs"]
mod run;
#[path = "cli/smoke.rs"]
mod smoke;
#[path = "cli/tuning.rs"]
mod tuning;
#[path = "cli/vectors.rs"]
mod vectors;
#[path = "cli/video.rs"]
mod video;
#[path = "cli/vignette.rs"]
mod vignette;
#[path = "cli/winding.rs"]
mod winding;

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use celfx::data::Volume;
use celfx::io::volume::write_npz;
use celfx::io::{image, picture};
use run::{Folder, celfx, has_device};

/// Exit code, and standard output and error as text; no run may ever panic or leave part of a file.
fn fails(folder: &Folder, arguments: &[&str], code: i32, needles: &[&str]) {
    let output = celfx(folder, arguments).output().expect("the program runs");
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{error}");
    assert!(error.starts_with("celfx: ") && !error.contains("panicked"), "{arguments:?}\n{error}");
    for needle in needles {
        assert!(error.contains(needle), "{arguments:?}: no {needle:?} in\n{error}");
    }
    assert_eq!(folder.parts(), Vec::<String>::new(), "{arguments:?}");
}

/// Runs to the end without a fault; returns standard output.
fn succeeds(folder: &Folder, arguments: &[&str]) -> String {
    let output = celfx(folder, arguments).output().expect("the program runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{error}");
    assert!(!error.contains("panicked"), "{arguments:?}\n{error}");
    assert_eq!(folder.parts(), Vec::<String>::new(), "{arguments:?}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

const SMALL: &str = "size = [64, 64]\nframes = [1, 6]\n[smoke]\nparticles = 60\n";

#[test]
fn wrong_usage_is_2_and_says_what_is_right() {
    let folder = Folder::new();
    folder.write("ok.toml", SMALL);
    for (arguments, needles) in [
        (&[][..], &["a subcommand is missing", "celfx render builtin:smoke"][..]),
        (&["rendre"], &["rendre", "render"]),
        (&["render"], &["<SHOT>"]),
        (&["render", "ok.toml", "--frame", "1"], &["--frame", "--frames"]),
        (&["render", "ok.toml", "--frames", "9-3"], &["9-3", "above the last"]),
        (&["render", "ok.toml", "--frames", "5-9"], &["5-9", "frames 1 to 6"]),
        (&["render", "ok.toml", "-o", "a.png"], &["a.png", "####"]),
        (&["render", "ok.toml", "-o", "####.jpg"], &["####.jpg", ".png or .exr"]),
        (&["render", "ok.toml", "--profile", "p.txt"], &["p.txt", ".json or .csv"]),
        (&["render", "ok.toml", "--threads", "0"], &["--threads"]),
        (&["render", "ok.toml", "--set", "smoke.sigmaa=4"], &["--set smoke.sigmaa=4", "smoke.sigma?"]),
        (&["render", "ok.toml", "--set", "smoke.sigma"], &["KEY=VALUE"]),
        (&["render", "ok.toml", "--set", "size=[0, 64]"], &["size = [0, 64]", "1 to 16384"]),
        (&["render", "ok.toml", "--set", "size=[1000000, 64]"], &["size = [1000000, 64]", "1 to 16384"]),
        (&["render", "builtin:smok"], &["did you mean builtin:smoke?"]),
        (&["shot", "builtin:clod"], &["did you mean builtin:cloud?"]),
    ] {
        fails(&folder, arguments, 2, needles);
    }
    assert_eq!(folder.names(), ["ok.toml"], "nothing was written");
}

#[test]
fn a_wrong_shot_is_2_and_names_file_line_key_and_what_is_allowed() {
    let folder = Folder::new();
    for (text, needles) in [
        ("[smoke]\n\nsigmaa = 4", &["shot.toml:3: ", "smoke.sigmaa", "did you mean smoke.sigma?"][..]),
        ("[smoke]\nsigma = 100", &["shot.toml:2: ", "smoke.sigma = 100", "0.1 to 64"]),
        ("[smoke]\nsigma = \"a\"", &["shot.toml:2: ", "smoke.sigma = \"a\"", "0.1 to 64"]),
        ("size = [0, 0]\n[smoke]", &["shot.toml:1: ", "size = [0, 0]", "1 to 16384"]),
        ("size = [64, 1000000]\n[smoke]", &["shot.toml:1: ", "size = [64, 1000000]", "1 to 16384"]),
        ("[smoke\n", &["shot.toml:1: "]),
        ("[flame]\nrepetition = 4", &["shot.toml:2: ", "flame.repetition", "did you mean flame.repetitions?"]),
        ("[flame]\nthreshold = inf", &["shot.toml:2: ", "flame.threshold = inf", "a finite number"]),
        ("[flame]\nparticles = \"builtin:sph\"", &["shot.toml:2: ", "builtin:sph", "not built yet"]),
        ("[blur]\nscene = \"builtin:rum\"", &["shot.toml:2: ", "builtin:rum", "builtin:run"]),
    ] {
        folder.write("shot.toml", text);
        fails(&folder, &["render", "shot.toml"], 2, needles);
    }
    assert_eq!(folder.names(), ["shot.toml"], "nothing was written");
}

fn volume(dimensions: [u32; 3], density: f32) -> Volume {
    let count = dimensions.map(|n| n as usize).iter().product();
    Volume {
        dimensions,
        voxel_size: [0.25; 3],
        origin: [-0.5, 0.0, -0.5],
        density: vec![density; count],
        velocity: None,
    }
}

/// An `.npz` with a density of any shape.
fn write_density(path: &Path, shape: &[u64]) {
    let count: u64 = shape.iter().product();
    run::add_array(&mut run::archive(path), "density", shape, (0..count).map(|_| 1.0f32));
}

#[test]
fn unreadable_input_is_3_and_names_file_and_place() {
    let folder = Folder::new();
    let path = |name: &str| folder.0.join(name);
    write_density(&path("flat.npz"), &[4, 4]);
    write_density(&path("none.npz"), &[0, 4, 4]);
    write_npz(&path("v.0001.npz"), &volume([4; 3], 1.0)).expect("temporary folder");
    fs::write(path("text.npz"), b"not a zip archive").expect("temporary folder");
    let whole = fs::read(path("v.0001.npz")).expect("just written");
    fs::write(path("cut.npz"), &whole[..whole.len() / 2]).expect("temporary folder");
    image::write_png8(&path("sky.png"), [1, 1], &[[9; 4]]).expect("temporary folder");

    fails(&folder, &["render", "missing.toml"], 3, &["missing.toml"]);
    let shot = |line: &str| format!("size = [64, 64]\nframes = [1, 2]\n{line}\n");
    for (line, needles) in [
        ("[smoke]\nvolume = \"missing.npz\"", &["missing.npz", "no such file"][..]),
        ("[smoke]\nvolume = \"flat.npz\"", &["flat.npz", "`density`", "[4, 4]", "[nz, ny, nx]"]),
        ("[smoke]\nvolume = \"none.npz\"", &["none.npz", "density", "has no voxels, in any frame"]),
        ("[smoke]\nvolume = \"text.npz\"", &["text.npz"]),
        ("[smoke]\nvolume = \"cut.npz\"", &["cut.npz"]),
        ("[smoke]\nvolume = \"v.0001.npz\"\ndensity_grid = \"rho\"", &["v.0001.npz", "`rho`", "density"]),
        ("[smoke]\nvolume = \"v.####.npz\"", &["v.0002.npz", "hold = true"]),
        ("[smoke]\ntones = \"missing.png\"", &["missing.png"]),
        ("background = \"missing.png\"\n[smoke]", &["missing.png"]),
        ("background = \"sky.png\"\n[smoke]", &["sky.png", "1 x 1", "64 x 64"]),
    ] {
        folder.write("shot.toml", &shot(line));
        // In a folder of its own: nothing is rendered, and the frame that could be is not begun.
        fails(&folder, &["render", "shot.toml", "-o", "out/####.png"], 3, needles);
        assert_eq!(fs::read_dir(path("out")).expect("made by the probe").count(), 0, "{line}");
    }
}

#[test]
fn without_a_driver_it_is_4_and_says_what_to_install() {
    let folder = Folder::new();
    for arguments in [&["info"][..], &["render", "builtin:smoke", "--set", "size=[64,64]"]] {
        let mut command = celfx(&folder, arguments);
        command.env("VK_ICD_FILENAMES", "/nonexistent").env("VK_DRIVER_FILES", "/nonexistent");
        let output = command.output().expect("the program runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{error}");
        assert!(error.starts_with("celfx: ") && error.contains("install") && !error.contains("panicked"), "{error}");
    }
    if has_device() {
        fails(&folder, &["info", "--device", "no such device"], 4, &["no such device", "there are"]);
    }
}

#[test]
fn unwritable_output_is_6_before_anything_is_rendered() {
    let folder = Folder::new();
    folder.write("ok.toml", SMALL);
    folder.write("file", "");
    fs::create_dir(folder.0.join("taken.json")).expect("temporary folder");
    let ok = ["render", "ok.toml"];
    for (more, needle) in [
        (&["-o", "file/####.png"][..], "file/0001.png"),
        (&["-o", "out/####.png", "--layers", "file"], "file"),
        (&["-o", "out/####.png", "--profile", "file/p.json"], "file/p.json"),
        (&["-o", "out/####.png", "--profile", "taken.json"], "taken.json"),
        (&["-o", "out/####.png", "--sheet", "file/s.png"], "file/s.png"),
        (&["-o", "out/####.png", "--animation", "file/a.gif"], "file/a.gif"),
    ] {
        // Without a driver: what cannot be written is found before a device is looked for.
        let arguments = [&ok[..], more].concat();
        fails(&folder, &arguments, 6, &["cannot write", needle]);
    }
    assert!(!folder.0.join("out/0001.png").exists());
}

#[test]
fn help_and_version_are_no_failure() {
    let folder = Folder::new();
    for arguments in [&["--help"][..], &["render", "--help"], &["shot", "-h"], &["bench", "--help"], &["info", "-h"]] {
        assert!(succeeds(&folder, arguments).contains("Examples:"), "{arguments:?}");
    }
    assert!(succeeds(&folder, &["--version"]).starts_with("celfx "));
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = Folder::new();
    for arguments in [&["shot", "builtin:smoke"][..], &["info"], &["--help"]] {
        if arguments == ["info"] && !has_device() {
            continue;
        }
        let mut child =
            celfx(&folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program runs");
        // Closed before a byte is read, as `| head -0` does.
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{arguments:?}");
    }
}

#[test]
fn a_printed_shot_renders_as_the_built_in_one() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    for name in ["smoke", "cloud"] {
        let builtin = format!("builtin:{name}");
        folder.write("printed.toml", &succeeds(&folder, &["shot", &builtin]));
        let small = ["--set", "size=[64, 64]", "--set", "smoke.particles=100", "--frames", "2", "-q"];
        succeeds(&folder, &[&["render", &builtin, "-o", "a.png"], &small[..]].concat());
        succeeds(&folder, &[&["render", "printed.toml", "-o", "b.png"], &small[..]].concat());
        let [a, b] = ["a.png", "b.png"].map(|file| fs::read(folder.0.join(file)).expect(file));
        assert!(a == b, "{name}");
        let pixels = picture::read(&folder.0.join("a.png")).expect("readable").pixels;
        assert!(pixels.iter().any(|pixel| *pixel != pixels[0]), "{name} shows something");
    }
}

#[test]
fn a_frame_alone_equals_the_frame_of_the_sequence() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    // Fast deaths and births, so that state matters.
    folder.write("shot.toml", &format!("{SMALL}lifetime = 2\nfade = 2\n[light]\nposition = [1, 3, 2]"));
    let render = ["render", "shot.toml", "-q"];
    succeeds(&folder, &[&render[..], &["-o", "all/####.exr", "--layers", "all", "--threads", "3"]].concat());
    for frame in ["1", "4", "6"] {
        let alone = ["--frames", frame, "-o", "alone/####.exr", "--layers", "alone", "--threads", "1"];
        succeeds(&folder, &[&render[..], &alone].concat());
    }
    let names = run::names(&folder.0.join("alone"));
    assert_eq!(names.len(), 3 * 18, "three frames, a picture and 17 layers each: {names:?}");
    for name in names {
        let [all, alone] = ["all", "alone"].map(|of| fs::read(folder.0.join(of).join(&name)).expect(&name));
        assert!(all == alone, "{name} differs");
    }
    let [first, last] = ["all/0001.exr", "all/0006.exr"].map(|name| run::shown(&folder.0.join(name)));
    assert!(first != last, "something moves");
}

#[test]
fn a_killed_run_leaves_whole_frames_and_resume_completes_them() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", &SMALL.replace("[1, 6]", "[1, 40]"));
    let render = |output: &str| {
        let pattern = format!("{output}/####.png");
        let layers = format!("{output}/layers");
        ["render", "shot.toml", "-q", "-o", &pattern, "--layers", &layers].map(str::to_owned)
    };
    let whole = render("whole");
    succeeds(&folder, &whole.iter().map(String::as_str).collect::<Vec<_>>());
    let killed = render("killed");
    let killed: Vec<&str> = killed.iter().map(String::as_str).collect();
    let mut child = celfx(&folder, &killed).spawn().expect("the program runs");
    let deadline = Instant::now() + Duration::from_secs(60);
    // Files come in any order.
    let awaited = ["0001.png", "0002.png", "0003.png", "layers/smoke.depth.0001.exr"];
    while !awaited.iter().all(|name| folder.0.join("killed").join(name).exists()) {
        assert!(Instant::now() < deadline, "no frame within a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("still running");
    child.wait().expect("it ends");
    // What a killed run was writing stays behind under a name that nobody takes for a frame.
    let visible = |of: &str| run::names(&folder.0.join(of)).into_iter().filter(|n| !n.starts_with('.'));
    for (of, from) in [("killed", "whole"), ("killed/layers", "whole/layers")] {
        for name in visible(of).filter(|name| name != "layers") {
            let [a, b] = [of, from].map(|of| fs::read(folder.0.join(of).join(&name)).expect(&name));
            assert!(a == b, "{name} is not whole");
        }
    }
    // One more that is not whole, and one that is gone.
    let path = folder.0.join("killed/0002.png");
    let bytes = fs::read(&path).expect("rendered");
    fs::write(&path, &bytes[..bytes.len() / 2]).expect("temporary folder");
    fs::remove_file(folder.0.join("killed/layers/smoke.depth.0001.exr")).expect("rendered");
    let kept = fs::metadata(folder.0.join("killed/0003.png")).and_then(|m| m.modified()).expect("rendered");

    let output = celfx(&folder, &[&killed[..], &["--resume"]].concat()).output().expect("the program runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(folder.parts(), Vec::<String>::new(), "what the killed run left is removed");
    for (of, from) in [("killed", "whole"), ("killed/layers", "whole/layers")] {
        assert_eq!(visible(of).collect::<Vec<_>>(), visible(from).collect::<Vec<_>>());
        for name in visible(of).filter(|name| name != "layers") {
            let [a, b] = [of, from].map(|of| fs::read(folder.0.join(of).join(&name)).expect(&name));
            assert!(a == b, "{name} differs after --resume");
        }
    }
    let still = fs::metadata(folder.0.join("killed/0003.png")).and_then(|m| m.modified()).expect("kept");
    assert_eq!(kept, still, "a complete frame is kept as it was");
    let again = [&["render", "shot.toml", "-o", "killed/####.png", "--resume"][..]].concat();
    let output = celfx(&folder, &again).output().expect("the program runs");
    assert!(String::from_utf8_lossy(&output.stdout).contains("0 frames rendered, 40 kept"));
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_is_130_and_leaves_whole_frames() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", &SMALL.replace("[1, 6]", "[1, 4000]"));
    let mut command = celfx(&folder, &["render", "shot.toml", "-q", "-o", "out/####.png", "--sheet", "s.png"]);
    let child = command.stderr(Stdio::piped()).spawn().expect("the program runs");
    let deadline = Instant::now() + Duration::from_secs(60);
    while !folder.0.join("out/0002.png").exists() {
        assert!(Instant::now() < deadline, "no frame within a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{error}");
    assert!(error.starts_with("celfx: interrupted") && !error.contains("panicked"), "{error}");
    let names = run::names(&folder.0.join("out"));
    assert!(
        names.len() < 4000 && names.iter().all(|name| name.ends_with(".png") && !name.starts_with('.')),
        "{names:?}"
    );
    for name in names {
        picture::read(&folder.0.join("out").join(&name)).expect("whole");
    }
    assert!(!folder.0.join("s.png").exists(), "no sheet of half a sequence");
}

/// Looking at all of a shot's frames before the first is rendered is no reason not to answer.
#[test]
#[cfg(target_os = "linux")]
fn a_run_that_has_not_begun_to_render_can_be_interrupted() {
    let folder = Folder::new();
    // Each frame has the only file, which is far back.
    folder
        .write("shot.toml", "size = [32, 32]\nframes = [1, 99999]\n[flame]\nparticles = \"p.####.npz\"\nhold = true\n");
    let mut archive = run::archive(&folder.0.join("p.0001.npz"));
    run::add_array(&mut archive, "position", &[1, 3], [0.0_f32; 3]);
    run::add_array(&mut archive, "temperature", &[1], [1500.0_f32]);
    drop(archive);
    let mut command = celfx(&folder, &["render", "shot.toml", "-q", "--frames", "1-1", "-o", "f.png"]);
    let child = command.stderr(Stdio::piped()).spawn().expect("the program runs");
    let deadline = Instant::now() + Duration::from_secs(60);
    let answers = || {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 2 != 0))
    };
    while !answers() {
        assert!(Instant::now() < deadline, "interrupts are not answered within a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{error}");
    assert!(error.starts_with("celfx: interrupted") && folder.names().len() == 2, "{error}");
}

#[test]
fn layers_profile_sheet_and_animation_are_written() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", &format!("background = \"none\"\n{SMALL}"));
    let files = ["--layers", "layers", "--profile", "p.json", "--sheet", "s.png", "--animation", "a.gif"];
    let table =
        succeeds(&folder, &[&["render", "shot.toml", "--frames", "2-4", "-o", "f.####.exr"], &files[..]].concat());
    assert!(table.contains("smoke.tone") && table.contains("3 frames rendered"), "{table}");
    let values = |name: &str| image::read_exr(&folder.0.join(format!("layers/{name}.0003.exr"))).expect(name);
    for name in ["smoke.luminance", "smoke.depth", "smoke.id", "smoke.smooth", "smoke.outline", "smoke.shadow"] {
        let channels: Vec<String> = values(name).channels.into_iter().map(|(name, _)| name).collect();
        assert_eq!(channels, ["Y"], "{name}");
    }
    let (id, depth) = (values("smoke.id"), values("smoke.depth"));
    let pairs = id.channels[0].1.iter().zip(&depth.channels[0].1);
    assert!(pairs.clone().all(|(id, depth)| (*id == 0.0) == (*depth == f32::INFINITY)), "empty pixels in both");
    assert!(pairs.clone().any(|(id, _)| *id > 0.0) && pairs.clone().any(|(id, _)| *id == 0.0), "smoke and sky");
    // Over nothing, the picture is the effect alone.
    let [alone, frame] = ["layers/smoke.0003.exr", "f.0003.exr"].map(|f| picture::read(&folder.0.join(f)).expect(f));
    assert!(alone == frame, "the layer `smoke` is the very buffer that was composited");
    let spheres = fs::read(folder.0.join("layers/smoke.spheres.0003.npy")).expect("spheres");
    let spheres = npyz::NpyFile::new(&spheres[..]).expect("an array");
    assert!(spheres.shape()[1] == 5 && spheres.shape()[0] > 0 && spheres.shape()[0] <= 60 * 7, "{:?}", spheres.shape());

    let profile = fs::read_to_string(folder.0.join("p.json")).expect("a profile");
    let profile: serde_json::Value = serde_json::from_str(&profile).expect("JSON");
    assert!(profile["traceEvents"].as_array().is_some_and(|events| events.iter().any(|e| e["name"] == "smoke.grow")));
    let sheet = image::read_png(&folder.0.join("s.png")).expect("a sheet");
    assert_eq!(sheet.size, [64 * 2 + 4, 64 * 2 + 4], "three frames in two columns");
    assert!(fs::read(folder.0.join("a.gif")).expect("an animation").starts_with(b"GIF89a"));
    succeeds(&folder, &["render", "shot.toml", "--frames", "1", "-o", "1.png", "--profile", "p.csv"]);
    let csv = fs::read_to_string(folder.0.join("p.csv")).expect("a profile");
    assert!(csv.starts_with("frame,pass,begin_ns,end_ns,skipped,reason\n1,smoke."), "{csv}");
}

#[test]
fn nothing_to_see_is_the_background() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    write_npz(&folder.0.join("empty.npz"), &volume([4; 3], 0.0)).expect("temporary folder");
    let sky: Vec<[u8; 4]> = (0..64 * 64).map(|i| [(i % 64) as u8, (i / 64) as u8, 7, 255]).collect();
    image::write_png8(&folder.0.join("sky.png"), [64, 64], &sky).expect("temporary folder");
    for smoke in ["volume = \"empty.npz\"", "particles = 0"] {
        folder.write(
            "shot.toml",
            &format!("size = [64, 64]\nframes = [1, 2]\nbackground = \"sky.png\"\n[smoke]\n{smoke}"),
        );
        succeeds(&folder, &["render", "shot.toml", "-q", "-o", "o/####.png", "--layers", "l", run::validate()]);
        for frame in ["0001", "0002"] {
            let rendered = picture::read(&folder.0.join(format!("o/{frame}.png"))).expect("readable");
            let expected = picture::read(&folder.0.join("sky.png")).expect("readable");
            assert!(rendered == expected, "{smoke}: frame {frame} is the very background");
            let empty = [("depth", f32::INFINITY), ("shadow", 1.0), ("id", 0.0), ("luminance", 0.0), ("outline", 0.0)];
            for (layer, empty) in empty.into_iter().chain([("smooth", 0.0), ("tone", 0.0)]) {
                let picture = image::read_exr(&folder.0.join(format!("l/smoke.{layer}.{frame}.exr"))).expect(layer);
                let values = picture.channels.iter().flat_map(|(_, values)| values);
                assert!(values.into_iter().all(|value| *value == empty), "{smoke}: {layer}");
            }
            let spheres = fs::read(folder.0.join(format!("l/smoke.spheres.{frame}.npy"))).expect("spheres");
            assert_eq!(npyz::NpyFile::new(&spheres[..]).expect("an array").shape(), [0, 5], "{smoke}");
        }
    }
}

#[test]
fn volumes_come_from_files() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    for (frame, size) in [(1, 6), (3, 9)] {
        write_npz(&folder.0.join(format!("v.{frame:04}.npz")), &volume([size; 3], 1.0)).expect("temporary folder");
    }
    let shot = "size = [64, 64]\nframes = [1, 4]\n[smoke]\nvolume = \"v.####.npz\"\nhold = true\nparticles = 40\n";
    folder.write("shot.toml", shot);
    succeeds(&folder, &["render", "shot.toml", "-q", "-o", "o/####.png", run::validate()]);
    let frames = ["1", "2", "3", "4"].map(|f| run::shown(&folder.0.join(format!("o/000{f}.png"))));
    assert!(frames[0] == frames[1], "without velocity, a held volume holds the picture");
    assert!(frames[1] != frames[2], "the next volume, larger than the first, is seen");
}

/// What `celfx inspect --json` prints.
fn inspected(folder: &Folder, file: &str) -> serde_json::Value {
    serde_json::from_str(&succeeds(folder, &["inspect", "--json", file])).expect("JSON")
}

#[test]
fn inspect_shows_what_files_hold() {
    let folder = Folder::new();
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 40, "uri": "t.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 40}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
            {"bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 1, "byteOffset": 36},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}, {"attributes": {"POSITION": 0}, "mode": 0}]}],
        "nodes": [{"mesh": 0}, {"mesh": 0}],
        "animations": [{
            "name": "Walk",
            "samplers": [{"input": 1, "output": 0}],
            "channels": [],
        }],
    });
    folder.write("t.gltf", &gltf.to_string());
    fs::write(folder.0.join("t.bin"), [&[0; 36][..], &1.5f32.to_le_bytes()].concat()).expect("written");
    let mesh = inspected(&folder, "t.gltf");
    assert_eq!((&mesh["vertices"], &mesh["triangles"], &mesh["objects"]), (&6.into(), &2.into(), &2.into()), "{mesh}");
    assert_eq!(mesh["animations"], serde_json::json!([{"name": "Walk", "seconds": 1.5}]));
    assert!(
        succeeds(&folder, &["inspect", "t.gltf"])
            .contains("6 vertices, 2 triangles, 2 objects\nobject `node 0`\nobject `node 1`\nanimation `Walk`")
    );
    assert_eq!(mesh["names"], serde_json::json!({"objects": ["node 0", "node 1"], "materials": []}));

    let density = [0.0, 1.0, 2.5, -1.0];
    let volume = Volume {
        dimensions: [2, 2, 1],
        voxel_size: [0.5; 3],
        origin: [1.0, 2.0, 3.0],
        density: density.into(),
        velocity: None,
    };
    write_npz(&folder.0.join("v.npz"), &volume).expect("written");
    let grid = &inspected(&folder, "v.npz")["grids"][0];
    let expected = serde_json::json!({
        "name": "density", "type": "float", "dimensions": [2, 2, 1], "voxel_size": [0.5, 0.5, 0.5],
        "origin": [1.0, 2.0, 3.0], "active": 4, "min": -1.0, "max": 2.5, "sum": 2.5, "not_finite": 0,
    });
    assert_eq!(*grid, expected);
    assert_eq!(inspected(&folder, "builtin:campfire")["effects"], serde_json::json!(["smoke", "flame"]));

    folder.write(
        "t.gltf",
        &gltf.to_string().replace("\"asset\"", "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"asset\""),
    );
    fails(&folder, &["inspect", "t.gltf"], 3, &["t.gltf: extensionsRequired", "KHR_draco_mesh_compression"]);
    fails(&folder, &["inspect", "none.glb"], 3, &["none.glb"]);
    fails(&folder, &["inspect", "none.obj"], 3, &["none.obj", ".glb, .gltf, .npz"]);
    fails(&folder, &["inspect", "none.toml"], 3, &["none.toml"]);
    fails(&folder, &["inspect"], 2, &["<FILE>"]);
}

/// What the device works on takes hours; nobody waits for it.
#[cfg(unix)]
#[test]
fn an_interruption_is_answered_while_a_frame_is_rendered() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let long = ["--set", "size=[1024, 1024]", "--set", "flame.repetitions=10000", "--frames", "1"];
    let mut child = celfx(&folder, &[&["render", "builtin:paper_flame", "-v"][..], &long].concat())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    let mut error = std::io::BufReader::new(child.stderr.take().expect("a pipe"));
    let mut line = String::new();
    std::io::BufRead::read_line(&mut error, &mut line).expect("what it says first");
    assert!(line.contains("device"), "{line}");
    // Now it renders, or soon will.
    std::thread::sleep(Duration::from_secs(3));
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("there is kill").success());
    let begin = Instant::now();
    let status = loop {
        match child.try_wait().expect("the program's state") {
            Some(status) => break status,
            None if begin.elapsed() > Duration::from_secs(60) => {
                child.kill().expect("it still runs");
                panic!("it waits");
            }
            None => std::thread::sleep(Duration::from_millis(50)),
        }
    };
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut error, &mut rest).expect("UTF-8");
    assert_eq!(status.code(), Some(130), "{rest}");
    assert!(rest.contains("interrupted") && !folder.0.join("out/0001.png").exists(), "{rest}");
    assert_eq!(folder.parts(), Vec::<String>::new());
}
