//! Frames as animations.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;

use celfx::io::image::srgb8;
use celfx::io::picture;

use super::run::{Folder, celfx, has_device};
use super::{SMALL, succeeds};

/// A program of that name in a folder of its own: that is where programs are looked for.
fn with_ffmpeg(folder: &Folder, script: &str) -> String {
    let bin = folder.0.join("bin");
    fs::create_dir_all(&bin).expect("a folder");
    let path = bin.join("ffmpeg");
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("a script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("permissions");
    format!("{}:/usr/bin:/bin", bin.display())
}

/// Exit code, and what is said.
fn render(folder: &Folder, path: &str, file: &str) -> (Option<i32>, String) {
    let arguments = ["render", "shot.toml", "-q", "--frames", "2-4", "-o", "o/####.png", "--animation", file];
    let output = celfx(folder, &arguments).env("PATH", path).output().expect("the program runs");
    assert_eq!(folder.parts(), Vec::<String>::new());
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

/// What ffmpeg is fed with is what the pictures show, over black, frame by frame.
#[test]
fn videos_are_made_of_the_pictures() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", &SMALL.replacen("frames", "background = \"none\"\nframes", 1));
    // As ffmpeg does: its last argument is where it writes.
    let path = with_ffmpeg(&folder, "[ \"$1\" = -version ] && exit 0\nfor last; do :; done\ncat > \"$last\"");
    assert_eq!(render(&folder, &path, "v/a.mp4"), (Some(0), String::new()));
    let expected: Vec<u8> = (2..=4)
        .flat_map(|frame| picture::read(&folder.0.join(format!("o/{frame:04}.png"))).expect("a picture").pixels)
        .flat_map(|[r, g, b, _]| {
            let [r, g, b, _] = srgb8(&[[r, g, b, 1.0]])[0];
            [r, g, b]
        })
        .collect();
    let found = fs::read(folder.0.join("v/a.mp4")).expect("a video");
    assert!(found == expected && found.iter().any(|byte| *byte > 0), "{} {}", found.len(), expected.len());
}

#[test]
fn without_ffmpeg_nothing_is_rendered() {
    let folder = Folder::new();
    folder.write("shot.toml", SMALL);
    let (code, said) = render(&folder, "/nowhere", "a.webm");
    assert_eq!(code, Some(2), "{said}");
    for needle in ["--animation a.webm: ffmpeg makes videos", ".gif or .apng"] {
        assert!(said.contains(needle), "{said}");
    }
    assert!(!folder.0.join("o/0002.png").exists());
}

#[test]
fn what_ffmpeg_says_is_passed_on() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", SMALL);
    let path = with_ffmpeg(&folder, "[ \"$1\" = -version ] && exit 0\necho \"Unknown encoder 'libx264'\" >&2\nexit 1");
    let (code, said) = render(&folder, &path, "a.mov");
    assert_eq!(code, Some(6), "{said}");
    assert!(said.contains("a.mov: ffmpeg: Unknown encoder 'libx264'"), "{said}");
    assert!(!folder.0.join("a.mov").exists() && folder.0.join("o/0004.png").exists());
}

#[test]
fn an_apng_has_the_frames_exactly() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", SMALL);
    succeeds(&folder, &["render", "shot.toml", "-q", "--frames", "2-4", "-o", "o/####.png", "--animation", "a.apng"]);
    // Viewers without animations show the first frame.
    let animation = fs::read(folder.0.join("a.apng")).expect("a file");
    assert!(animation.windows(4).filter(|word| word == b"fcTL").count() == 3, "three frames");
    fs::write(folder.0.join("b.png"), &animation).expect("a copy");
    let shown = |name: &str| picture::read(&folder.0.join(name)).expect("a picture");
    assert!(shown("b.png") == shown("o/0002.png"));
}
