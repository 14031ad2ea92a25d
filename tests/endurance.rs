//! Memory over many frames: what a driver or the program keeps of each shows only here. The long lanes are run by
//! `make test-all`.
#![cfg(all(feature = "cli", target_os = "linux"))]

#[allow(dead_code, reason = "each test file uses its part")]
#[path = "cli/run.rs"]
mod run;

use std::fs;
use std::process::Child;
use std::time::Duration;

use run::{Folder, celfx, has_device};

/// Bytes that may come once, whenever they come: arenas of allocators, buffers of the driver, and the poses of a window of
/// frames. A shader that is compiled once more for each frame takes 1.5 MiB and more of each: 37 MiB in the shortest lane.
const ONCE: u64 = 10 << 20;
/// Bytes that a frame may leave besides: an allocator's fragments.
const EACH: u64 = 8 << 10;

/// Resident memory of a process, in bytes; none once it has ended.
fn resident(child: &Child) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kibibytes| kibibytes << 10)
}

/// Renders so many frames and fails if memory grows from frame `begin` to the last.
fn endures(folder: &Folder, shot: &str, size: u32, frames: u32, begin: u32, more: &[&str]) {
    let name = format!("out{}", folder.names().len());
    let (pattern, size, range) =
        (format!("{name}/####.png"), format!("size=[{size}, {size}]"), format!("frames=[1, {frames}]"));
    let mut arguments = vec!["render", shot, "-q", "--threads", "1", "-o", &pattern, "--set", &size, "--set", &range];
    arguments.extend(more.iter().flat_map(|set| ["--set", set]));
    let mut child = celfx(folder, &arguments).spawn().expect("the program runs");
    let last = folder.0.join(&name).join(format!("{frames:04}.png"));
    let first = folder.0.join(&name).join(format!("{begin:04}.png"));
    let (mut early, mut late) = (None, None);
    while child.try_wait().expect("its state").is_none() {
        if !last.exists() && first.exists() {
            let memory = resident(&child);
            early = early.or(memory);
            late = memory.or(late);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(child.wait().expect("its state").success(), "{arguments:?}");
    let (early, late) = early.zip(late).expect("frames take some time");
    let (grown, frames) = (late.saturating_sub(early), u64::from(frames - begin));
    let most = ONCE + EACH * frames;
    eprintln!("{shot} {more:?}: {} MiB, and {} KiB in {frames} frames", early >> 20, grown >> 10);
    assert!(grown <= most, "{shot} {more:?}: {grown} bytes in {frames} frames, {most} may be");
}

#[test]
fn memory_does_not_grow_in_few_frames() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    endures(&folder, "builtin:smoke", 32, 60, 20, &[]);
    endures(&folder, "builtin:blur", 32, 40, 15, &["blur.scene=builtin:crossing", "camera.file=builtin:crossing"]);
}

#[test]
#[ignore = "takes minutes; make test-all runs it"]
fn memory_does_not_grow_in_500_frames_of_smoke_and_fire() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    for shot in ["builtin:smoke", "builtin:flame", "builtin:campfire"] {
        endures(&folder, shot, 64, 500, 100, &[]);
    }
    let mapped = ["smoke.shadow=map", "light.position=[2.0, 3.0, 2.0]"];
    endures(&folder, "builtin:smoke", 64, 500, 100, &mapped);
}

#[test]
#[ignore = "takes minutes; make test-all runs it"]
fn memory_does_not_grow_in_500_frames_of_blur() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    // It stays in the picture, so that a late frame is as much work as an early one.
    let spin = ["blur.scene=builtin:spin", "camera.file=builtin:spin"];
    // What the first one has drawn, and what is drawn besides.
    let more: [&[&str]; 3] = [&[], &["blur.images=out0/####.png"], &["blur.lines.count=8", "blur.ghosts.count=3"]];
    for more in more {
        endures(&folder, "builtin:blur", 64, 500, 100, &[&spin, more].concat());
    }
}
