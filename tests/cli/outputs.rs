//! Outputs: they destroy nothing, fail before the work and not after it, and say what they lack.

use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

use celfx::data::Volume;
use celfx::io::image;
use celfx::io::volume::write_npz;

use super::run::{self, Folder, celfx, has_device};
use super::{SMALL, fails, succeeds};

/// A file that is an input of a kind, and the shot that names it.
fn inputs(folder: &Folder) -> Vec<(&'static str, String)> {
    let head = "size = [8, 8]\nframes = [1, 4]\n";
    let mut shots = Vec::new();
    for frame in 1..=4 {
        image::write_png8(&folder.0.join(format!("im/{frame:04}.png")), [8, 8], &[[9; 4]; 64]).expect("written");
    }
    image::write_png8(&folder.0.join("one.png"), [8, 8], &[[9; 4]; 64]).expect("written");
    let gltf = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "b.png", "byteLength": 1}], "images": [{"uri": "t.png"}]}"#;
    folder.write("s.gltf", gltf);
    folder.write("b.png", "b");
    folder.write("t.png", "t");
    for (file, text) in [
        ("im/####.png", "[blur]\nimages = \"im/####.png\"\n"),
        ("one.png", "background = \"one.png\"\n[smoke]\n"),
        ("one.png", "[smoke]\ntones = \"one.png\"\n"),
        ("one.png", "[flame]\ncolour = \"one.png\"\n"),
        ("one.png", "[blur]\ntoon.tones = \"one.png\"\n"),
        ("v.####.png", "[smoke]\nvolume = \"v.####.png\"\n"),
        ("p.####.png", "[flame]\nparticles = \"p.####.png\"\n"),
        ("b.png", "[blur]\nscene = \"s.gltf\"\n"),
        ("t.png", "[blur]\nscene = \"s.gltf\"\n"),
    ] {
        shots.push((file, format!("{head}{text}")));
    }
    shots
}

/// What is in all files of a folder.
fn contents(folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.0.clone()];
    while let Some(at) = folders.pop() {
        for name in run::names(&at) {
            let path = at.join(name);
            let bytes = if path.is_dir() { Vec::new() } else { fs::read(&path).expect("readable") };
            found.push((path.display().to_string(), bytes));
            folders.extend(Some(path).filter(|path| path.is_dir()));
        }
    }
    found
}

#[test]
fn an_output_that_is_an_input_is_refused_before_anything_is_written() {
    let folder = Folder::new();
    for (file, text) in inputs(&folder) {
        folder.write("shot.toml", &text);
        let before = contents(&folder);
        let single = file.replace("####", "0003");
        let roundabout = format!("new/../{file}");
        let mut refused = vec![vec!["--sheet", &single]];
        if file.contains('#') {
            // In whatever spelling, and frames that are not rendered, too.
            let percent = file.replace("####", "%04d");
            for pattern in [file, &percent, &roundabout] {
                for more in [&["-o", pattern, "--frames", "2"][..], &["-o", pattern]] {
                    fails(&folder, &[&["render", "shot.toml"], more].concat(), 2, &["would overwrite", pattern]);
                }
            }
        } else {
            refused.push(vec!["-o", file, "--frames", "2"]);
            refused.push(vec!["-o", &roundabout, "--frames", "2"]);
        }
        for more in refused {
            let arguments = [&["render", "shot.toml"], &more[..]].concat();
            fails(&folder, &arguments, 2, &["would overwrite", more[1], "another name or in another folder"]);
        }
        assert!(contents(&folder) == before, "{text}: something was written");
    }
    // The shot itself, by another name.
    folder.write("shot.png", SMALL);
    fails(
        &folder,
        &["render", "./shot.png", "-o", "shot.png", "--frames", "1"],
        2,
        &["the shot ./shot.png", "-o shot.png"],
    );
}

#[test]
fn outputs_that_are_the_same_file_are_refused() {
    let folder = Folder::new();
    folder.write("shot.toml", SMALL);
    for (more, needles) in [
        (&["-o", "c.png", "--frames", "1", "--sheet", "./c.png"][..], &["-o c.png", "--sheet ./c.png"][..]),
        (&["-o", "####.png", "--sheet", "0042.png"], &["-o ####.png", "--sheet 0042.png"]),
        (&["-o", "l/smoke.%04d.exr", "--layers", "x/../l"], &["smoke of --layers", "-o l/smoke.%04d.exr"]),
        (&["-o", "a.gif/####.png", "--animation", "a.gif"], &["-o a.gif/####.png", "--animation a.gif"]),
    ] {
        fails(&folder, &[&["render", "shot.toml"], more].concat(), 2, needles);
    }
    assert_eq!(folder.names(), ["shot.toml"], "nothing was written");
}

#[cfg(unix)]
#[test]
fn an_output_that_leads_to_an_input_is_refused() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    let (file, text) = inputs(&folder).swap_remove(0);
    folder.write("shot.toml", &text);
    symlink("im", folder.0.join("link")).expect("temporary folder");
    fs::create_dir(folder.0.join("hard")).expect("temporary folder");
    fs::hard_link(folder.0.join("im/0002.png"), folder.0.join("hard/0001.png")).expect("temporary folder");
    let before = contents(&folder);
    for pattern in ["link/####.png", "hard/####.png"] {
        fails(&folder, &["render", "shot.toml", "-o", pattern], 2, &["would overwrite", pattern, file]);
    }
    assert!(contents(&folder) == before, "something was written");
}

#[test]
fn names_that_are_too_long_fail_before_the_rendering() {
    let folder = Folder::new();
    folder.write("shot.toml", &SMALL.replace("[1, 6]", "[1, 12]"));
    let long = |length: usize, end: &str| "n".repeat(length - end.len()) + end;
    // Without a driver: names are tried before a device is looked for. 255 bytes are the most; frame 12 has one more.
    let (picture, profile) = (long(255, "#.png"), long(256, ".csv"));
    let (picture, profile): (&str, &str) = (&picture, &profile);
    for arguments in [&["-o", picture][..], &["-o", "o/####.png", "--profile", profile]] {
        fails(&folder, &[&["render", "shot.toml"], arguments].concat(), 6, &["cannot write", "too long"]);
    }
    if has_device() {
        let picture = long(255, "##.png");
        succeeds(&folder, &["render", "shot.toml", "-q", "-o", &picture.replace("##", "#"), "--frames", "1-2"]);
        assert_eq!(folder.names().iter().filter(|name| name.ends_with(".png")).count(), 2);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_of_any_bytes_keeps_the_frame_number() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", SMALL);
    let name = OsStr::from_bytes(b"out\xff");
    let output = folder.0.join(name).join("####.png");
    let mut command = celfx(&folder, &["render", "shot.toml", "-q", "--frames", "1-2"]);
    assert!(command.arg("-o").arg(&output).status().expect("the program runs").success());
    assert_eq!(run::names(&folder.0.join(name)), ["0001.png", "0002.png"]);
}

#[test]
fn quiet_is_quiet() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    // A mesh too coarse for its tolerance, which is worth a warning.
    let shot = "size = [64, 64]\nframes = [1, 2]\n[blur]\nrefine = \"length\"\nedge = 0.001\n";
    folder.write("shot.toml", shot);
    let render = ["render", "shot.toml", "-o", "o/####.png", "--profile", "p.json"];
    let said = |more: &[&str]| {
        let output = celfx(&folder, &[&render[..], more].concat()).output().expect("the program runs");
        assert!(output.status.success(), "{output:?}");
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("UTF-8"))
    };
    let [table, warning] = said(&[]);
    assert!(table.contains("2 frames rendered") && warning.contains("refinement ended"), "{table}\n{warning}");
    assert!(said(&["--resume"])[1].contains("p.json: no frame was rendered, so that the profile has no times"));
    let [_, others] = said(&["--resume", "--set", "seed=1"]);
    assert!(others.contains("2 frames are rendered again"), "{others}");
    for more in [&["-q"][..], &["-q", "--resume"], &["-q", "--resume", "--set", "seed=2"]] {
        assert_eq!(said(more), [String::new(), String::new()], "{more:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_is_6() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", SMALL);
    // 1 block of 512 or 1024 bytes: less than a frame's layers. Beyond it the system sends a signal that would end it.
    let program = env!("CARGO_BIN_EXE_celfx");
    let script = format!("ulimit -f 1; exec '{program}' render shot.toml -q -o o/####.exr --layers l");
    let mut command = std::process::Command::new("sh");
    let output = command.args(["-c", &script]).current_dir(&folder.0).stdin(Stdio::null()).output().expect("sh runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(6), "{error}");
    assert!(error.starts_with("celfx: cannot write"), "{error}");
    assert_eq!(folder.parts(), Vec::<String>::new());
}

/// Runs the program with so much address space.
#[cfg(target_os = "linux")]
fn with_memory(folder: &Folder, mebibytes: u32, arguments: &str) -> (Option<i32>, String) {
    let program = env!("CARGO_BIN_EXE_celfx");
    let script = format!("ulimit -v {}; exec '{program}' {arguments}", mebibytes << 10);
    let mut command = std::process::Command::new("sh");
    // What it needs a device for is not looked at here: drivers have ways of their own.
    command.env("VK_ICD_FILENAMES", "/nonexistent").env("VK_DRIVER_FILES", "/nonexistent");
    let output = command.args(["-c", &script]).current_dir(&folder.0).stdin(Stdio::null()).output().expect("sh runs");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_not_there_is_5_and_says_what_for() {
    let folder = Folder::new();
    // Room for many frames, and a mesh.
    let shot = "size = [64, 64]\nframes = [0, 249999]\n[camera]\nfile = \"builtin:run\"\n[blur]\n";
    folder.write("shot.toml", shot);
    let starts = |mebibytes: u32| with_memory(&folder, mebibytes, "--version").0 == Some(0);
    assert!(starts(1024), "the program starts with a gibibyte");
    let (mut too_little, mut least) = (7, 1024);
    while least - too_little > 1 {
        let middle = (too_little + least) / 2;
        *if starts(middle) { &mut least } else { &mut too_little } = middle;
    }
    // Until it gets so far that it misses a device: there is no limit that it could run into with more.
    let mut failures = 0;
    for mebibytes in least + 1.. {
        let arguments = "render shot.toml -q --frames 0-249999 --animation a.gif --threads 64";
        let (code, error) = with_memory(&folder, mebibytes, arguments);
        assert!(matches!(code, Some(4 | 5)), "{mebibytes} MiB: {code:?}: {error}");
        assert!(error.starts_with("celfx: ") && !error.contains("panicked"), "{mebibytes} MiB: {error}");
        if code == Some(4) {
            break;
        }
        assert!(error.contains("out of memory") && mebibytes < least + 96, "{mebibytes} MiB: {error}");
        failures += 1;
    }
    assert!(failures > 4, "{failures} limits are too low");
}

fn volume(side: u32, velocity: bool) -> Volume {
    let count = side.pow(3) as usize;
    Volume {
        dimensions: [side; 3],
        voxel_size: [0.25; 3],
        origin: [-0.5, 0.0, -0.5],
        density: vec![1.0; count],
        velocity: velocity.then(|| vec![[0.0; 3]; count]),
    }
}

/// Inputs that become others once the rendering has begun.
#[test]
fn input_that_changes_meanwhile_is_3_and_named() {
    if !has_device() {
        return;
    }
    let particles = |folder: &Folder, name: &str, count: u64, temperature: f32| {
        let mut archive = run::archive(&folder.0.join(name));
        run::add_array(&mut archive, "position", &[count, 3], vec![0.0f32; 3 * count as usize]);
        run::add_array(&mut archive, "temperature", &[count], vec![temperature; count as usize]);
    };
    type Change<'a> = &'a dyn Fn(&Folder, &str);
    let cases: [(&str, Change, &str); 6] = [
        (
            "[smoke]\nvolume = \"i.####.npz\"\n",
            &|f, n| write_npz(&f.0.join(n), &volume(9, true)).expect("written"),
            "grown",
        ),
        (
            "[smoke]\nvolume = \"i.####.npz\"\n",
            &|f, n| write_npz(&f.0.join(n), &volume(4, false)).expect("written"),
            "velocity",
        ),
        ("[flame]\nparticles = \"i.####.npz\"\n", &|f, n| particles(f, n, 900, 1500.0), "grown"),
        ("[flame]\nparticles = \"i.####.npz\"\n", &|f, n| particles(f, n, 9, 9000.0), "temperature"),
        ("[smoke]\nvolume = \"i.####.npz\"\n", &|f, n| f.write(n, "no archive"), "i.0399.npz"),
        ("[flame]\nparticles = \"i.####.npz\"\n", &|f, n| fs::remove_file(f.0.join(n)).expect("there"), "no such file"),
    ];
    for (text, change, needle) in cases {
        let folder = Folder::new();
        folder.write("shot.toml", &format!("size = [16, 16]\nframes = [1, 400]\n{text}"));
        let first = folder.0.join("i.0001.npz");
        match text.contains("smoke") {
            true => write_npz(&first, &volume(4, true)).expect("written"),
            false => particles(&folder, "i.0001.npz", 9, 1500.0),
        }
        for frame in 2..=400 {
            fs::hard_link(&first, folder.0.join(format!("i.{frame:04}.npz"))).expect("temporary folder");
        }
        let mut command = celfx(&folder, &["render", "shot.toml", "-q", "-o", "o/####.png"]);
        let child = command.stderr(Stdio::piped()).spawn().expect("the program runs");
        let deadline = Instant::now() + Duration::from_secs(120);
        while !folder.0.join("o/0001.png").exists() {
            assert!(Instant::now() < deadline, "no frame within two minutes");
            std::thread::sleep(Duration::from_millis(1));
        }
        // Far ahead of the frame that is rendered now, and a new file: the others stay as they are.
        let late = "i.0399.npz";
        fs::write(folder.0.join("new"), "").expect("temporary folder");
        fs::rename(folder.0.join("new"), folder.0.join(late)).expect("temporary folder");
        change(&folder, late);
        let output = child.wait_with_output().expect("it ends");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{error}");
        assert!(error.contains(late) && error.contains(needle), "{needle}: {error}");
        assert!(folder.0.join("o/0001.png").exists());
    }
}
