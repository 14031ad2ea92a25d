//! What drivers make of the kernels: no shader is such that a compiler's time multiplies with its branches, and, in a lane
//! of its own (`cargo test --test kernels -- --ignored`), SwiftShader makes every pipeline of every effect.
#![cfg(feature = "cli")]

mod common;

#[path = "kernels/variants.rs"]
mod variants;
#[path = "kernels/ways.rs"]
mod ways;

use std::collections::BTreeSet;
use std::time::Instant;

use celfx::low_level::gpu::headless::{Headless, Options};
use celfx::low_level::gpu::kernel::Pipelines;
use celfx::low_level::gpu::resources::Resources;
use celfx::low_level::plan::{Kernel, Pass};
use celfx::low_level::shaders;

use variants::Variant;

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

/// What a pipeline is made of, as far as compilers see it.
fn key(pass: &Pass) -> Option<(Vec<&'static str>, &[u32])> {
    let files = pass.shaders().into_iter().flatten().map(|shader| shader.file).collect();
    (!matches!(pass.kernel, Kernel::Transfer)).then_some((files, &pass.specialisation))
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
    let mut headless = match Headless::new(&Options::default()) {
        Ok(headless) if headless.info().name.contains("SwiftShader") => headless,
        Ok(headless) => return println!("SKIPPED: the device is {}, not SwiftShader", headless.info().name),
        Err(error) => return println!("SKIPPED, no device: {error}"),
    };
    let mut made = BTreeSet::new();
    let mut slow = Vec::new();
    for mut variant in variants::all() {
        let new = |pass: &Pass| key(pass).is_some_and(|(files, words)| made.insert((files, words.to_vec())));
        let (new, _): (Vec<_>, Vec<_>) = std::mem::take(&mut variant.passes).into_iter().partition(new);
        slow.extend(make(&mut headless, &variant, &new));
    }
    println!("{} pipelines", made.len());
    assert!(slow.is_empty(), "more than {MOST_SECONDS} s or {MOST_MEBIBYTES} MiB:\n{}", slow.join("\n"));
}

/// Makes the pipelines of some of a variant's passes, each by itself; those that took too much.
fn make(headless: &mut Headless, variant: &Variant, passes: &[Pass]) -> Vec<String> {
    let mut resources = Resources::default();
    let (host, allocator) = headless.parts();
    let mut slow = Vec::new();
    if passes.is_empty() {
        return slow;
    }
    // SAFETY: the handles are the device's own; nothing is submitted, and all is destroyed before it.
    unsafe {
        for buffer in &variant.buffers {
            resources.add_buffer(&host, allocator, buffer).expect("a buffer");
        }
        for image in &variant.images {
            resources.add_image(&host, allocator, image).expect("an image");
        }
        for pass in passes.chunks(1) {
            // The peak is counted anew.
            let _ = std::fs::write("/proc/self/clear_refs", "5");
            let (before, start) = (memory("VmRSS:"), Instant::now());
            let mut pipelines = Pipelines::new(&host, pass, &resources).expect("a pipeline");
            let (seconds, peak) = (start.elapsed().as_secs_f64(), memory("VmHWM:").saturating_sub(before));
            pipelines.destroy(&host);
            let (files, words) = key(&pass[0]).unwrap_or_default();
            let line = format!("{:<48} {words:?}: {seconds:.2} s, {peak} MiB", files.join(", "));
            println!("{line}");
            if seconds > MOST_SECONDS || peak > MOST_MEBIBYTES {
                slow.push(line);
            }
        }
        resources.destroy(&host, allocator);
    }
    slow
}
