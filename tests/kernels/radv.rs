//! What AMD's GPUs would make of the kernels: Mesa's RADV compiles for a chip that is not there, and says what it made.
//!
//! Each chip has a process of its own, which is this test's again: the driver survives neither the end of such a device nor
//! a wait for it.

use std::mem::ManuallyDrop;
use std::path::Path;
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
const EXCEPTIONS: [(&str, &str); 4] = [
    ("flame/accumulate.comp", "holds a column of eight pixels, as drivers of CPUs want it"),
    ("flame/expected.comp", "holds a column of eight pixels, as drivers of CPUs want it"),
    ("blur/trajectory.comp", "solves for a whole spline in an array: one invocation a vertex, little of a frame"),
    ("blur/light.comp", "has a matrix in shared memory: few of its many workgroups run at a time"),
];

const DRIVERS: [&str; 2] =
    ["/usr/share/vulkan/icd.d/radeon_icd.x86_64.json", "/usr/share/vulkan/icd.d/radeon_icd.json"];

#[test]
fn gpus_neither_spill_nor_starve() {
    let Some(driver) = DRIVERS.into_iter().find(|driver| Path::new(driver).exists()) else {
        assert!(!std::env::var("CELFX_REQUIRE_VULKAN").is_ok_and(|v| v == "1"), "no RADV: install mesa-vulkan-drivers");
        return eprintln!("SKIPPED, no RADV");
    };
    for (chip, least) in CHIPS {
        let own = std::env::current_exe().expect("the test's own program");
        let mut child = Command::new(own);
        child.args(["radv::costs_on_a_chip", "--exact", "--ignored", "--nocapture"]);
        child.env("VK_DRIVER_FILES", driver).env("VK_ICD_FILENAMES", driver).env(CHIP, chip);
        let output = child.output().expect("it runs");
        let text = String::from_utf8_lossy(&output.stdout);
        let lines: Vec<Vec<&str>> =
            text.lines().filter_map(|l| Some(l.split_once(MARK)?.1.split('|').collect())).collect();
        assert!(
            output.status.success() && lines.len() > 190,
            "{chip}: {text}{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let wrong = |line: &&Vec<&str>| {
            let number = |column: usize| line[column].parse::<f64>().expect("a number");
            number(2) > 0.0 || number(3) > 0.0 || number(4) < least
        };
        let (planted, wrong): (Vec<_>, Vec<_>) =
            lines.iter().filter(wrong).partition(|line| line[0].contains("planted"));
        let is_known = |line: &&&Vec<&str>| EXCEPTIONS.iter().any(|(shader, _)| line[0] == *shader);
        let unknown: Vec<_> = wrong.iter().filter(|line| !is_known(line)).collect();
        assert!(unknown.is_empty(), "{chip}: shader, constants, spilled, scratch, subgroups: {unknown:#?}");
        assert_eq!(planted.len(), 1, "{chip}: the planted kernel has a large array of its own");
    }
}

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
    let mut passes = celfx::program::variants().expect("allowed settings");
    passes.push(Pass::compute("vignette.planted", &shaders::vignette::planted::SHADER));
    for pass in &passes {
        // SAFETY: valid handles, of one device.
        unsafe { device.kernels().make(&device.host(), pass) }.expect("a pipeline");
    }
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
