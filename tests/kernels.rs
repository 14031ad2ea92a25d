//! What drivers make of the kernels: no shader is such that a compiler's time multiplies with its branches, and, in a lane
//! of its own (`cargo test --test kernels -- --ignored`), SwiftShader makes every pipeline of every effect.
#![cfg(feature = "cli")]

mod common;

#[path = "kernels/radv.rs"]
mod radv;
#[path = "kernels/ways.rs"]
mod ways;

use std::time::Instant;

use celfx::effect::{DeviceTraits, Kernels};
use celfx::low_level::gpu::headless::{Headless, Options};
use celfx::low_level::plan::Pass;
use celfx::low_level::shaders;
use celfx::tuning::Tuning;

/// A driver that is slower than SwiftShader, or has less memory to compile with, is not expected.
const MOST_SECONDS: f64 = 20.0;
const MOST_MEBIBYTES: u64 = 1024;

/// SwiftShader walks through a loop's body breadth first and meets a block once for every way of the same length that
/// leads to it: twice as often with each branch. With a million steps that is a second; two kernels that took minutes and
/// gigabytes had billions.
#[test]
fn ways_through_loops_do_not_multiply() {
    let most = |shader: &&&celfx::low_level::plan::Shader| ways::most_steps(shader.words) >= ways::MOST_STEPS;
    let slow: Vec<_> = shaders::ALL.iter().filter(most).map(|shader| shader.file).collect();
    assert!(slow.is_empty(), "{slow:?}: more than {} steps; choose values where loops branch", ways::MOST_STEPS);
}

/// A line of `/proc/self/status`, in MiB; 0 where there is none.
fn memory(line: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let value = status.lines().find_map(|l| l.strip_prefix(line)?.split_whitespace().next()?.parse().ok());
    value.unwrap_or(0_u64) / 1024
}

/// The lane that `VK_DRIVER_FILES` brings SwiftShader to; on any other driver it says so and passes.
#[test]
#[ignore = "for SwiftShader: VK_DRIVER_FILES=/usr/lib/chromium/vk_swiftshader_icd.json"]
fn swiftshader_makes_every_pipeline() {
    let headless = match Headless::new(&Options::default()) {
        Ok(headless) if headless.info().name.contains("SwiftShader") => headless,
        Ok(headless) => return println!("SKIPPED: the device is {}, not SwiftShader", headless.info().name),
        Err(error) => return println!("SKIPPED, no device: {error}"),
    };
    let mut kernels = Kernels::new();
    let mut slow = Vec::new();
    // As it has them itself, and as GPUs have them.
    for traits in [headless.traits(), DeviceTraits { tuning: Tuning::GPU, ..headless.traits() }] {
        let passes = celfx::program::variants(&traits).expect("allowed settings");
        slow.extend(passes.iter().filter_map(|pass| make(&headless, &kernels, pass)));
    }
    println!("{} pipelines", kernels.count());
    // SAFETY: valid handles; nothing was submitted.
    unsafe { kernels.destroy(&headless.host()) };
    assert!(slow.is_empty(), "more than {MOST_SECONDS} s or {MOST_MEBIBYTES} MiB:\n{}", slow.join("\n"));
}

/// Makes the pipeline of a pass, if it is not there; its line, if that took too much.
fn make(headless: &Headless, kernels: &Kernels, pass: &Pass) -> Option<String> {
    // The peak is counted anew.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let (before, start, count) = (memory("VmRSS:"), Instant::now(), kernels.count());
    // SAFETY: valid handles, of one device.
    unsafe { kernels.make(&headless.host(), std::slice::from_ref(pass)) }.expect("a pipeline");
    let (seconds, peak) = (start.elapsed().as_secs_f64(), memory("VmHWM:").saturating_sub(before));
    if kernels.count() == count {
        return None;
    }
    let files: Vec<_> = pass.shaders().into_iter().flatten().map(|shader| shader.file).collect();
    let line = format!("{:<48} {:?}: {seconds:.2} s, {peak} MiB", files.join(", "), pass.specialisation);
    println!("{line}");
    (seconds > MOST_SECONDS || peak > MOST_MEBIBYTES).then_some(line)
}
