//! `celfx bench`: the arguments.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Common, Failure};

const EXAMPLES: &str = "\
Examples:
  celfx bench                       everything, into ./bench: bench.json and the plots
  celfx bench smoke --quick         one effect, one run each";

/// Options of `celfx bench`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// What to measure
    #[arg(value_enum, default_value = "all")]
    what: What,
    /// Folder for bench.json and the plots
    #[arg(short, long, value_name = "DIR", default_value = "bench")]
    output: PathBuf,
    /// One run each, large workloads cut
    #[arg(long)]
    quick: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum What {
    /// The smoke effect's kernels and frames
    Smoke,
    /// Cost of a frame against covered screen
    Skipping,
    /// What the device can do: copy and arithmetic
    Limits,
    /// All of it
    All,
}

pub(super) fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let Options { what, output, quick } = options;
    let _ = (what, output, quick, common);
    Err(Failure::usage("celfx bench is not built yet"))
}
