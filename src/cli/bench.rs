//! `celfx bench`: run time against error, and what makes smoke, fire and smears look drawn.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::render::frame_range;
use super::{Common, Failure, print};
use crate::bench::look::{self, Scene};
use crate::bench::{self, BenchError, Request, Watch};
use crate::gpu::headless;
use crate::interrupt;
use crate::program::{self, EFFECTS, InputError, benchmarks};

const EXAMPLES: &str = "\
Examples:
  celfx bench                                       everything, into ./bench: bench.json and the plots
  celfx bench smoke --quick                         one effect, one run each
  celfx bench smoke --only 'gaussian/per_id_tiles'  one variant at its workloads
  celfx bench flame --only 'tiles R=16/paper'       one row
  celfx bench blur --only refine                    where triangles are divided, at all workloads
  celfx bench look                                  what makes the built-in effects look drawn
  celfx bench look my.toml --set smoke.sigma=8      the same of a shot of one's own
  celfx bench calibrate > tuning.toml               which ways are the fastest here; then:
  celfx render --tuning tuning.toml shot.toml -o out/%04d.png";

/// Options of `celfx bench`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// What to measure
    #[arg(value_parser = names(), default_value = ALL)]
    what: String,
    /// Of `look`: the shots to measure, files or builtin:NAME [default: built-in ones of each effect]
    #[arg(value_name = "SHOT")]
    shots: Vec<String>,
    /// Of `look`: the frames, both ends included [default: 20-40, or the last 21 of a shot that has not all of those]
    #[arg(long, value_name = "A-B", value_parser = frame_range)]
    frames: Option<[u32; 2]>,
    /// Of `look`: override one key of each shot
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Folder for bench.json, the plots, and the pictures of `look`
    #[arg(short, long, value_name = "DIR", default_value = "bench")]
    output: PathBuf,
    /// One run each, the largest workload cut; of `look`: 3 frames of a quarter of the size
    #[arg(long)]
    quick: bool,
    /// Write a page of Markdown with the table, performance-DEVICE.md, into this folder
    #[arg(long, value_name = "DIR")]
    page: Option<PathBuf>,
    /// Only rows whose PASS/VARIANT/WORKLOAD (of `look`: whose shot's name) contains this; may be given several times
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
}

/// Name of the benchmark of the device alone; the other name stands for all of them.
const LIMITS: &str = "limits";
/// Name of what only says which ways kernels should take.
const CALIBRATE: &str = "calibrate";
/// Name of what measures no times, and so is no part of all.
const LOOK: &str = "look";
const ALL: &str = "all";

/// Names that can be measured.
fn names() -> PossibleValuesParser {
    let effects = EFFECTS.iter().map(|effect| {
        PossibleValue::new(effect.name())
            .help(format!("The {} effect: its kernels with a choice, and its frames", effect.name()))
    });
    let others = [
        PossibleValue::new(CALIBRATE).help("Which ways are the fastest on the device: prints a file for --tuning"),
        PossibleValue::new(LOOK)
            .help("What makes smoke, fire and smears look drawn, in shares of pixels; no part of all"),
        PossibleValue::new(LIMITS).help("What the device can do: copy and arithmetic"),
        PossibleValue::new(ALL).help("All effects, and the device"),
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
            BenchError::Input(InputError::Interrupted(_)) => BenchError::Interrupted.into(),
            BenchError::Input(error) => error.into(),
            BenchError::Write(error) => error.into(),
            BenchError::Validation(_) => Failure::new(Failure::DEVICE, error.to_string()),
            BenchError::Interrupted => Failure::new(Failure::INTERRUPTED, "interrupted; nothing was written"),
        }
    }
}

/// The scenes that are measured.
fn scenes(options: &Options) -> Result<Vec<Scene>, Failure> {
    let built_in = || look::scenes().into_iter().map(str::to_owned).collect();
    let names = if options.shots.is_empty() { built_in() } else { options.shots.clone() };
    names.iter().map(|name| scene(name, options)).collect()
}

fn scene(name: &str, options: &Options) -> Result<Scene, Failure> {
    let shot = program::load(name, &options.set)?;
    shot.check_effects().map_err(|why| Failure::usage(format!("{}: {why}", shot.name)))?;
    let frames @ [first, last] = options.frames.unwrap_or_else(|| look::frames_of(shot.frames));
    let [a, b] = shot.frames;
    match a <= first && last <= b {
        true => Ok(Scene { shot: Arc::new(shot), frames }),
        false => Err(Failure::usage(format!("--frames {first}-{last}: {name} has frames {a} to {b}"))),
    }
}

/// Refuses what is of `look` alone.
fn no_scenes(options: &Options) -> Result<Vec<Scene>, Failure> {
    let given = [
        options.shots.first().map(|shot| shot.to_owned()),
        options.frames.map(|[first, last]| format!("--frames {first}-{last}")),
        options.set.first().map(|set| format!("--set {set}")),
    ];
    match given.into_iter().flatten().next() {
        Some(given) => Err(Failure::usage(format!("{given}: only with `celfx bench look`"))),
        None => Ok(Vec::new()),
    }
}

pub(super) fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    interrupt::install(Failure::INTERRUPTED);
    let what = benchmarks(Some(options.what.as_str()).filter(|what| *what != ALL));
    let look = if options.what == LOOK { scenes(options)? } else { no_scenes(options)? };
    let go_on = if common.quiet { interrupt::go_on } else { go_on };
    let device = headless::Options { go_on, ..common.device()? };
    let (quick, only, page) = (options.quick, options.only.clone(), options.page.clone());
    let request = Request { what, look, quick, only, page, device };
    let watch = Terminal { begin: Instant::now(), quiet: common.quiet };
    if options.what == CALIBRATE {
        return print(&bench::calibrate::calibrate(&request, &watch)?);
    }
    let table = bench::run(&request, &options.output, &watch)?;
    if common.quiet { Ok(()) } else { print(&table) }
}
