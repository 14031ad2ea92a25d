//! `celfx info`: the devices, and what kernels cost on one.

use std::fmt::Write as _;
use std::mem::ManuallyDrop;

use clap::Args;
use serde_json::json;

use super::{Common, Failure, print};
use crate::gpu::costs::{Cost, Executable};
use crate::gpu::headless::{self, Headless};
use crate::program;

const EXAMPLES: &str = "\
Examples:
  celfx info                        the devices; a star marks the one that is used
  celfx info --json                 the same for scripts
  celfx info --device llvmpipe      which one would be used if llvmpipe were asked for
  celfx info --kernels              registers, spills, shared memory and more of every kernel there";

/// Options of `celfx info`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// What the device's driver says that each kernel costs there, as every setting makes it
    #[arg(long)]
    kernels: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if options.kernels {
        return print(&kernels(options, common)?);
    }
    let report = headless::report(common.device.as_deref())?;
    let text = match options.json {
        true => pretty(&report)?,
        false => report.to_string(),
    };
    print(&text)
}

fn pretty(value: &impl serde::Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Failure::new(Failure::OUTPUT, e.to_string()))?;
    Ok(text + "\n")
}

/// What every kernel costs.
fn kernels(options: &Options, common: &Common) -> Result<String, Failure> {
    let wanted = headless::Options { costs: true, ..common.device()? };
    // It ends with the process: a driver that only compiles may not survive its device's end.
    let device = ManuallyDrop::new(Headless::new(&wanted)?);
    let name = device.info().name.clone();
    let lacking = || {
        let message = format!("{name} does not say what kernels cost: it lacks VK_KHR_pipeline_executable_properties");
        Failure::new(Failure::NO_DEVICE, message)
    };
    device.costs()?.ok_or_else(lacking)?;
    // SAFETY: the device's own handles.
    unsafe { device.kernels().make(&device.host(), &program::variants(&device.traits())?)? };
    let costs = device.costs()?.ok_or_else(lacking)?;
    match options.json {
        true => pretty(&json!({"device": name, "kernels": costs.iter().map(as_json).collect::<Vec<_>>()})),
        false => Ok(table(&name, &costs)),
    }
}

fn as_json(cost: &Cost) -> serde_json::Value {
    let executable = |executable: &Executable| {
        let statistics = executable.statistics.iter().map(|s| (s.name.clone(), s.value.into()));
        json!({
            "name": executable.name,
            "subgroup_size": executable.subgroup_size,
            "registers": executable.registers(),
            "spilled": executable.spilled(),
            "scratch_bytes": executable.scratch(),
            "shared_bytes": executable.shared_memory(),
            "subgroups": executable.occupancy(),
            "code_bytes": executable.code_size(),
            "statistics": statistics.collect::<serde_json::Map<_, _>>(),
        })
    };
    json!({
        "pass": cost.pass,
        "shaders": cost.shaders,
        "specialisation": cost.specialisation,
        "executables": cost.executables.iter().map(executable).collect::<Vec<_>>(),
    })
}

/// A line an executable.
fn table(device: &str, costs: &[Cost]) -> String {
    let mut text = format!(
        "{} kernels on {device}\n{:<18} {:<34} {:<20} {:>8} {:>9} {:>7} {:>8} {:>7} {:>9} {:>6} {:>4}\n",
        costs.len(),
        "pass",
        "shader",
        "constants",
        "stage",
        "registers",
        "spilled",
        "scratch",
        "shared",
        "subgroups",
        "code",
        "size"
    );
    for cost in costs {
        let constants: Vec<String> = cost.specialisation.iter().map(u32::to_string).collect();
        for (number, executable) in cost.executables.iter().enumerate() {
            let shown = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value}"));
            let shader = cost.shaders.get(number).copied().unwrap_or_default();
            let stage = shader.rsplit('.').next().unwrap_or_default();
            let _ = writeln!(
                text,
                "{:<18} {shader:<34} {:<20} {stage:>8} {:>9} {:>7} {:>8} {:>7} {:>9} {:>6} {:>4}",
                cost.pass,
                constants.join(","),
                shown(executable.registers()),
                shown(executable.spilled()),
                shown(executable.scratch()),
                shown(executable.shared_memory()),
                shown(executable.occupancy()),
                shown(executable.code_size()),
                executable.subgroup_size,
            );
        }
    }
    text
}
