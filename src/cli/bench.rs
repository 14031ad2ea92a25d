//! `celfx bench`: run time against error.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::{Common, Failure, print};
use crate::bench::{self, BenchError, Request, Watch};
use crate::gpu::headless;
use crate::interrupt;
use crate::program::{EFFECTS, benchmarks};

const EXAMPLES: &str = "\
Examples:
  celfx bench                                       everything, into ./bench: bench.json and the plots
  celfx bench smoke --quick                         one effect, one run each
  celfx bench smoke --only 'gaussian/per_id_tiles'  one variant at its workloads
  celfx bench flame --only 'tiles R=16/paper'       one row
  celfx bench blur --only refine                    where triangles are divided, at all workloads
  celfx bench calibrate > mine.toml                 which ways are the fastest here; then:
  celfx render --tuning mine.toml shot.toml -o out/%04d.png";

/// Options of `celfx bench`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// What to measure
    #[arg(value_parser = names(), default_value = ALL)]
    what: String,
    /// Folder for bench.json and the plots
    #[arg(short, long, value_name = "DIR", default_value = "bench")]
    output: PathBuf,
    /// One run each, the largest workload cut
    #[arg(long)]
    quick: bool,
    /// Write a page of Markdown with the table, performance-DEVICE.md, into this folder
    #[arg(long, value_name = "DIR")]
    page: Option<PathBuf>,
    /// Only rows whose PASS/VARIANT/WORKLOAD contains this; may be given several times
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
}

/// Name of the benchmark of the device alone; the other name stands for all of them.
const LIMITS: &str = "limits";
/// Name of what only says which ways kernels should take.
const CALIBRATE: &str = "calibrate";
const ALL: &str = "all";

/// Names that can be measured.
fn names() -> PossibleValuesParser {
    let effects = EFFECTS.iter().map(|effect| {
        PossibleValue::new(effect.name())
            .help(format!("The {} effect: its kernels with a choice, and its frames", effect.name()))
    });
    let others = [
        PossibleValue::new(CALIBRATE).help("Which ways are the fastest on the device: prints a file for --tuning"),
        PossibleValue::new(LIMITS).help("What the device can do: copy and arithmetic"),
        PossibleValue::new(ALL).help("All of it"),
    ];
    PossibleValuesParser::new(effects.chain(others))
}

/// Asks, while waiting for a run, whether to go on, and says each half minute that it still does.
fn go_on(waited: Duration) -> bool {
    static SAID: AtomicU64 = AtomicU64::new(0);
    let halves = waited.as_secs() / 30;
    if SAID.swap(halves, Ordering::Relaxed) < halves {
        // Nothing is left to tell where standard error is closed.
        let _ = writeln!(io::stderr(), "{:7}  still running, for {} s", "", 30 * halves);
    }
    interrupt::go_on(waited)
}

/// Progress on standard error.
struct Terminal {
    begin: Instant,
    quiet: bool,
}

impl Watch for Terminal {
    fn progress(&self, text: &str) {
        if !self.quiet {
            let ink = if io::stderr().is_terminal() { ("\x1b[2m", "\x1b[0m") } else { ("", "") };
            let seconds = self.begin.elapsed().as_secs();
            // Nothing is left to tell where standard error is closed.
            let _ = writeln!(io::stderr(), "{}{seconds:5} s{}  {text}", ink.0, ink.1);
        }
    }

    fn is_interrupted(&self) -> bool {
        interrupt::check().is_err()
    }
}

impl From<BenchError> for Failure {
    fn from(error: BenchError) -> Failure {
        match error {
            BenchError::NoDevice(error) => error.into(),
            BenchError::Device(error) => error.into(),
            BenchError::Write(error) => error.into(),
            BenchError::Validation(_) => Failure::new(Failure::DEVICE, error.to_string()),
            BenchError::Interrupted => Failure::new(Failure::INTERRUPTED, "interrupted; nothing was written"),
        }
    }
}

pub(super) fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    interrupt::install(Failure::INTERRUPTED);
    let what = benchmarks(Some(options.what.as_str()).filter(|what| *what != ALL));
    let go_on = if common.quiet { interrupt::go_on } else { go_on };
    let device = headless::Options { go_on, ..common.device()? };
    let request =
        Request { what, quick: options.quick, only: options.only.clone(), page: options.page.clone(), device };
    let watch = Terminal { begin: Instant::now(), quiet: common.quiet };
    if options.what == CALIBRATE {
        return print(&bench::calibrate::calibrate(&request, &watch)?);
    }
    let table = bench::run(&request, &options.output, &watch)?;
    if common.quiet { Ok(()) } else { print(&table) }
}
