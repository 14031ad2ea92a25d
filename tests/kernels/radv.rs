//! What AMD's GPUs would make of the kernels: Mesa's RADV compiles for a chip that is not there, and says what it made.
//!
//! Each chip has a process of its own, which is this test's again: the driver survives neither the end of such a device nor
//! a wait for it.

use std::collections::BTreeSet;
use std::fmt;
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::process::Command;

use celfx::low_level::gpu::costs::{Cost, Executable};
use celfx::low_level::gpu::headless::{Headless, Options};
use celfx::low_level::plan::Pass;
use celfx::low_level::shaders;

/// Chips, and the fewest subgroups that a unit of each must be able to hold: a quarter of what it can.
const CHIPS: [(&str, f64); 3] = [("GFX1100", 8.0), ("NAVI21", 8.0), ("VEGA10", 3.0)];

/// Says to the process of which chip it is.
const CHIP: &str = "RADV_FORCE_FAMILY";

/// Kernels that may do what others may not, and why.
const EXCEPTIONS: [(&str, &str); 2] = [
    ("blur/trajectory.comp", "solves for a whole spline in an array: one invocation a vertex, little of a frame"),
    ("blur/light.comp", "has a matrix in shared memory: few of its many workgroups run at a time"),
];

/// What a chip's process says of a kernel.
struct Line {
    shader: String,
    constants: String,
    spilled: f64,
    scratch: f64,
    subgroups: f64,
}

impl Line {
    fn parse(line: &str) -> Option<Line> {
        let mut parts = line.split_once(MARK)?.1.split('|').map(str::to_owned);
        let (shader, constants) = (parts.next()?, parts.next()?);
        let mut figure = || parts.next()?.parse().ok();
        Some(Line { shader, constants, spilled: figure()?, scratch: figure()?, subgroups: figure()? })
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Line { shader, constants, spilled, scratch, subgroups } = self;
        write!(f, "{shader} {constants}: {spilled} spilled, {scratch} bytes of scratch, {subgroups} subgroups")
    }
}

/// RADV's description, wherever this machine's kind of it is.
fn driver() -> Option<PathBuf> {
    let entries = std::fs::read_dir("/usr/share/vulkan/icd.d").ok()?;
    let is_radv = |path: &PathBuf| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("radeon_icd"));
    entries.flatten().map(|entry| entry.path()).find(is_radv)
}

/// Runs the other half of the test for a chip.
fn lines_of(chip: &str, driver: &Path) -> Vec<Line> {
    let mut child = Command::new(std::env::current_exe().expect("the test's own program"));
    child.args(["radv::costs_on_a_chip", "--exact", "--ignored", "--nocapture"]);
    child.env("VK_DRIVER_FILES", driver).env("VK_ICD_FILENAMES", driver).env(CHIP, chip);
    let output = child.output().expect("it runs");
    let [text, errors] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{chip}: {text}{errors}");
    text.lines().filter_map(Line::parse).collect()
}

#[test]
fn gpus_neither_spill_nor_starve() {
    let Some(driver) = driver() else {
        assert!(!std::env::var("CELFX_REQUIRE_VULKAN").is_ok_and(|v| v == "1"), "no RADV: install mesa-vulkan-drivers");
        return eprintln!("SKIPPED, no RADV");
    };
    let mut found = BTreeSet::new();
    for (chip, least) in CHIPS {
        let lines = lines_of(chip, &driver);
        // Every shader but those of the benchmark is under some setting in some pipeline.
        let is_there = |file: &str| file.contains("bench") || lines.iter().any(|line| line.shader == file);
        let missing: Vec<_> = shaders::ALL.iter().map(|shader| shader.file).filter(|file| !is_there(file)).collect();
        assert!(missing.is_empty(), "{chip}: {missing:?}");
        let mut wrong = lines;
        wrong.retain(|line| line.spilled > 0.0 || line.scratch > 0.0 || line.subgroups < least);
        found.extend(wrong.iter().map(|line| line.shader.clone()));
        assert!(wrong.iter().any(|line| line.shader == PLANTED), "{chip}: the planted kernel has a large array");
        wrong.retain(|line| line.shader != PLANTED && !EXCEPTIONS.iter().any(|(shader, _)| *shader == line.shader));
        let wrong: Vec<_> = wrong.iter().map(Line::to_string).collect();
        assert!(wrong.is_empty(), "{chip}: {wrong:#?}");
    }
    for (shader, why) in EXCEPTIONS {
        assert!(found.contains(shader), "{shader} is no exception any more: {why}");
    }
}

/// A kernel that is to be found, in place of one that came by mistake.
const PLANTED: &str = "vignette/planted.comp";

/// Before what the other process prints for this one.
const MARK: &str = "cost|";

#[test]
#[ignore = "the other half of a test above"]
fn costs_on_a_chip() {
    if std::env::var(CHIP).is_err() {
        return;
    }
    // It ends with the process.
    let options = Options { costs: true, ..Options::default() };
    let device = ManuallyDrop::new(Headless::new(&options).expect("a device that only compiles"));
    let mut passes = celfx::program::variants(&device.traits()).expect("allowed settings");
    passes.push(Pass::compute("vignette.planted", &shaders::vignette::planted::SHADER));
    // SAFETY: valid handles, of one device.
    unsafe { device.kernels().make(&device.host(), &passes) }.expect("pipelines");
    for cost in device.costs().expect("figures").expect("a device that says") {
        cost.executables.iter().enumerate().for_each(|(number, executable)| print(&cost, number, executable));
    }
    std::process::exit(0);
}

fn print(cost: &Cost, number: usize, executable: &Executable) {
    let figures = [executable.spilled(), executable.scratch(), executable.occupancy()].map(|f| f.expect("a figure"));
    let [spilled, scratch, subgroups] = figures;
    println!("{MARK}{}|{:?}|{spilled}|{scratch}|{subgroups}", cost.shaders[number], cost.specialisation);
}
