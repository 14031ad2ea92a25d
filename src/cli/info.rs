//! `celfx info`: the devices.

use clap::Args;

use super::{Common, Failure, print};
use crate::gpu::headless;

const EXAMPLES: &str = "\
Examples:
  celfx info                        the devices; a star marks the one that is used
  celfx info --json                 the same for scripts
  celfx info --device llvmpipe      which one would be used if llvmpipe were asked for";

/// Options of `celfx info`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let report = headless::report(common.device.as_deref())?;
    let text = match options.json {
        true => serde_json::to_string_pretty(&report).map_err(|e| Failure::new(Failure::OUTPUT, e.to_string()))? + "\n",
        false => report.to_string(),
    };
    print(&text)
}
