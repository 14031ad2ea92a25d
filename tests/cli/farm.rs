//! A shot by many processes: each frame once, all as one process makes them, whoever dies.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::run::{self, Folder, celfx, has_device};
use super::{fails, succeeds};

const SMALL: &str = "--set=size=[48, 48]";

/// Frames of a folder, by name.
fn pictures(folder: &Folder, name: &str) -> Vec<(String, Vec<u8>)> {
    let names = run::names(&folder.0.join(name)).into_iter();
    names.map(|file| (file.clone(), fs::read(folder.0.join(name).join(&file)).expect("a frame"))).collect()
}

/// Frames that a run says it has rendered.
fn rendered(output: &str) -> u32 {
    let line = output.lines().find(|line| line.contains(" rendered")).expect("a count");
    line.split(' ').next().and_then(|count| count.parse().ok()).expect("a count")
}

fn start(folder: &Folder, arguments: &[&str]) -> Child {
    celfx(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program runs")
}

#[test]
fn four_processes_of_which_one_is_killed_make_what_one_makes() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let shot = ["render", "builtin:campfire", SMALL, "--frames", "1-20", "--threads", "1"];
    let shared = [&shot[..], &["-o", "many/####.png", "--resume", "--cache", "cache"]].concat();
    let mut all: Vec<Child> = (0..4).map(|_| start(&folder, &shared)).collect();
    // In the midst of it: it has claimed frames, and may be writing one.
    let begun = Instant::now();
    let has_picture = || {
        let files = fs::read_dir(folder.0.join("many")).into_iter().flatten().flatten();
        files.into_iter().any(|file| file.file_name().as_encoded_bytes().ends_with(b"png"))
    };
    while !has_picture() && begun.elapsed() < Duration::from_secs(120) {
        sleep(Duration::from_millis(2));
    }
    let mut killed = all.remove(0);
    killed.kill().expect("it runs");
    killed.wait().expect("it has ended");
    let mut count = 0;
    for child in all {
        let output = child.wait_with_output().expect("it ends");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{error}");
        count += rendered(&String::from_utf8_lossy(&output.stdout));
    }
    assert!((1..=20).contains(&count), "{count} frames: some twice");
    // Half a past that the killed one left stays until somebody writes that again.
    let left: Vec<String> = folder.parts().into_iter().filter(|name| !name.contains(".past.")).collect();
    assert_eq!(left, Vec::<String>::new());
    fs::remove_dir_all(folder.0.join("cache")).expect("a folder");
    succeeds(&folder, &[&shot[..], &["-o", "one/####.png"]].concat());
    assert!(pictures(&folder, "many") == pictures(&folder, "one"), "many processes make others");
}

#[test]
fn frames_that_begin_in_the_midst_are_those_of_the_sequence() {
    if !has_device() {
        return;
    }
    // On twos and threes frames also begin within a drawing. With what dies and shrinks, and depth ranges that are smoothed.
    for (shot, on) in [("builtin:smoke", "on=2"), ("builtin:smoke", "on=3"), ("builtin:cloud", "on=1")] {
        let folder = Folder::new();
        let render = ["render", shot, SMALL, "-q", "--set=smoke.particles=200", "--set", on, run::validate()];
        let frames = |frames: &'static str, to: &'static str, cache: &'static [&str]| {
            succeeds(&folder, &[&render[..], &["--frames", frames, "-o", to], cache].concat())
        };
        frames("1-14", "all/####.png", &[]);
        const CACHE: &[&str] = &["--cache", "cache"];
        // What the 8th and the last leave is kept.
        frames("9", "part/####.png", CACHE);
        assert_eq!(run::names(&folder.0.join("cache")).len(), 2, "{shot}");
        frames("10-13", "part/####.png", CACHE);
        frames("14", "part/####.png", CACHE);
        let (all, part) = (pictures(&folder, "all"), pictures(&folder, "part"));
        assert!(part.len() == 6 && part.iter().all(|frame| all.contains(frame)), "{shot}");
        // It is read: with what another seed leaves in its place, another picture follows.
        let kept = run::names(&folder.0.join("cache"));
        frames("14", "part/####.png", &["--cache", "other", "--set=seed=9"]);
        let [other, ..] = &run::names(&folder.0.join("other"))[..] else { panic!("nothing kept") };
        for name in kept {
            fs::copy(folder.0.join("other").join(other), folder.0.join("cache").join(name)).expect("copied");
        }
        frames("14", "wrong/####.png", CACHE);
        assert!(pictures(&folder, "wrong")[0] != all[13], "{shot}: the cache is not read");
        // What is damaged is not.
        for name in run::names(&folder.0.join("cache")) {
            fs::write(folder.0.join("cache").join(name), "celfx past 1\nnothing").expect("written");
        }
        frames("14", "again/####.png", CACHE);
        assert!(pictures(&folder, "again")[0] == all[13], "{shot}");
        let sizes = run::names(&folder.0.join("cache")).into_iter();
        let sizes = sizes.map(|name| fs::metadata(folder.0.join("cache").join(name)).expect("a file").len());
        assert_eq!(sizes.filter(|size| *size > 1000).count(), 2, "{shot}: those of this run are written anew");
    }
}

#[test]
fn a_shot_falls_apart_into_commands() {
    let folder = Folder::new();
    folder.write("it's a shot.toml", super::SMALL);
    let lines =
        succeeds(&folder, &["frames", "it's a shot.toml", "--chunk", "4", "-o", "o/####.png", "--cache=c", "-q"]);
    let lines: Vec<&str> = lines.lines().collect();
    assert_eq!(lines.len(), 2, "6 frames");
    assert!(lines[0].ends_with("--output 'o/####.png' --cache c --resume --frames 1-4 --quiet"), "{}", lines[0]);
    assert!(lines[1].contains(" --frames 5-6 "), "{}", lines[1]);
    for (arguments, needles) in [
        (&["--chunk", "0"][..], &["--chunk", "0"][..]),
        (&[], &["--chunk"]),
        (&["--chunk", "2", "--sheet", "s.png"], &["--sheet", "all frames together"]),
        (&["--chunk", "2", "--frames", "1-9"], &["--frames 1-9", "1 to 6"]),
        (&["--chunk", "2", "--set", "smoke.sigam=2"], &["smoke.sigam", "smoke.sigma"]),
    ] {
        fails(&folder, &[&["frames", "it's a shot.toml"], arguments].concat(), 2, needles);
    }
    if !has_device() {
        return;
    }
    // In any order, twice, and at once.
    let script = [lines[1], lines[0], lines[1]].join(" & ") + " & wait";
    let status = Command::new("sh").args(["-c", &script]).current_dir(&folder.0).status().expect("a shell");
    assert!(status.success());
    succeeds(&folder, &["render", "it's a shot.toml", "-q", "-o", "one/####.png"]);
    assert!(pictures(&folder, "o") == pictures(&folder, "one"));
}
