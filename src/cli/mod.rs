//! The program `celfx`: one file per subcommand.

mod bench;
mod frames;
mod info;
mod inspect;
pub mod memory;
mod render;
mod shot;

use std::borrow::Cow;
use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand};

use crate::error::Error;
use crate::gpu::headless::{self, NoDevice};
use crate::interrupt::{self, Interrupted};
use crate::io::overlap::Overlap;
use crate::io::pattern::PatternError;
use crate::io::shot::ShotError;
use crate::io::{ReadError, WriteError};
use crate::program::InputError;
use crate::tuning::Tuning;

/// Hand-drawn-looking effects on Vulkan, from the terminal.
#[derive(Debug, Parser)]
#[command(name = "celfx", version, after_help = EXAMPLES, max_term_width = 120, disable_help_subcommand = true)]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  celfx render builtin:smoke -o out/####.png        48 frames of a plume; needs nothing else on disk
  celfx shot builtin:smoke > my.toml                a shot to edit, every key explained
  celfx render my.toml --frames 1-8 --sheet s.png   eight frames and a contact sheet of them
  celfx info                                        the devices, and which one would be used
  celfx inspect walk.glb                            what a file holds

Exit codes:
  0 done    2 wrong usage or shot    3 unreadable input    4 no usable Vulkan device
  5 device lost or out of memory    6 output cannot be written    130 interrupted";

/// Options of every subcommand.
#[derive(Clone, Debug, Args)]
struct Common {
    /// Device to run on: its index in `celfx info`, or a part of its name
    #[arg(long, global = true, value_name = "NAME|INDEX")]
    device: Option<String>,
    /// Ways that kernels take to the same picture: "cpu", "gpu", or a file that `celfx bench calibrate` has printed
    /// [default: as the device's type suggests]
    #[arg(long, global = true, value_name = "NAME|FILE")]
    tuning: Option<String>,
    /// Run with Vulkan validation, synchronisation included; a message of it is an error
    #[arg(long, global = true)]
    validate: bool,
    /// Print nothing but errors
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Say more: the device, the memory, each file written
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    verbose: bool,
    /// Threads that encode pictures [default: one per core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Common {
    /// The device to open.
    fn device(&self) -> Result<headless::Options, Failure> {
        let tuning = self.tuning.as_deref().map(tuning).transpose()?;
        let (validate, device) = (self.validate, self.device.clone());
        Ok(headless::Options { validate, device, tuning, go_on: interrupt::go_on, ..headless::Options::default() })
    }

    /// As on the command line.
    fn arguments(&self) -> Vec<OsString> {
        let Common { device, tuning, validate, quiet, verbose, threads } = self;
        let mut all = frames::option("--device", device);
        all.extend(frames::option("--tuning", tuning));
        all.extend(frames::option("--threads", &threads.map(|threads| threads.to_string())));
        let flags = [("--validate", validate), ("--quiet", quiet), ("--verbose", verbose)].into_iter();
        all.extend(flags.filter(|(_, is_given)| **is_given).map(|(flag, _)| flag.into()));
        all
    }

    fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a shot to a sequence of pictures
    Render(render::Options),
    /// Print the commands that render a shot in parts, one a line, for a farm
    Frames(frames::Options),
    /// Print a built-in shot: every key, commented
    Shot(shot::Options),
    /// Measure run time against error
    Bench(bench::Options),
    /// List the devices, what each lacks, and which would be used
    Info(info::Options),
    /// Show what a mesh, volume, particle or shot file holds
    Inspect(inspect::Options),
}

/// Ways that kernels take, by name or from a file.
fn tuning(text: &str) -> Result<Tuning, Failure> {
    let tuning = match text {
        "cpu" => Tuning::CPU,
        "gpu" => Tuning::GPU,
        path => {
            let read = |e| Failure::new(Failure::INPUT, format!("--tuning {path}: {e}; or \"cpu\" or \"gpu\""));
            let text = fs::read_to_string(path).map_err(|e| read(e.to_string()))?;
            toml::from_str(&text).map_err(|e| read(e.to_string()))?
        }
    };
    tuning.validate().map_err(|e| Failure::usage(e.to_string()))?;
    Ok(tuning)
}

/// Why the program ends without having done its work.
#[derive(Debug)]
struct Failure {
    code: u8,
    message: String,
}

impl Failure {
    const USAGE: u8 = 2;
    const INPUT: u8 = 3;
    const NO_DEVICE: u8 = 4;
    const DEVICE: u8 = 5;
    const OUTPUT: u8 = 6;
    const INTERRUPTED: u8 = 130;

    fn new(code: u8, message: impl Into<String>) -> Failure {
        Failure { code, message: message.into() }
    }

    fn usage(message: impl Into<String>) -> Failure {
        Failure::new(Failure::USAGE, message)
    }
}

impl From<ShotError> for Failure {
    fn from(error: ShotError) -> Failure {
        let code = match error {
            ShotError::Wrong { .. } => Failure::USAGE,
            ShotError::Read { .. } | ShotError::Input(_) => Failure::INPUT,
        };
        Failure::new(code, error.to_string())
    }
}

impl From<PatternError> for Failure {
    fn from(error: PatternError) -> Failure {
        Failure::usage(error.to_string())
    }
}

impl From<Interrupted> for Failure {
    fn from(error: Interrupted) -> Failure {
        Failure::new(Failure::INTERRUPTED, error.to_string())
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Failure {
        match error {
            InputError::Name(error) => error.into(),
            InputError::Read(error) => error.into(),
            InputError::Effect(error) => error.into(),
            InputError::Interrupted(error) => error.into(),
        }
    }
}

impl From<Overlap> for Failure {
    fn from(error: Overlap) -> Failure {
        Failure::usage(error.to_string())
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Failure {
        Failure::new(Failure::INPUT, error.to_string())
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        Failure::new(Failure::OUTPUT, error.to_string())
    }
}

impl From<NoDevice> for Failure {
    fn from(error: NoDevice) -> Failure {
        let limit = memory::limit().map(|mebibytes| {
            format!(
                "\nthe address space is limited to {mebibytes} MiB (ulimit -v), which may be too little for a driver"
            )
        });
        Failure::new(Failure::NO_DEVICE, error.to_string() + &limit.unwrap_or_default())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        let code = match error {
            Error::Setting { .. } => Failure::USAGE,
            Error::Device { .. } => Failure::NO_DEVICE,
            Error::Interrupted { .. } => Failure::INTERRUPTED,
            _ => Failure::DEVICE,
        };
        Failure::new(code, error.to_string())
    }
}

/// Runs the program with the arguments of the process; returns its exit code.
pub fn main() -> ExitCode {
    ignore_file_size_limit();
    memory::name_aborts();
    match run(std::env::args_os()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { code, message }) => {
            if !message.is_empty() {
                // Nothing is left to tell where standard error is closed.
                let _ = writeln!(io::stderr(), "celfx: {}", visible(&message));
            }
            match code {
                // A frame may not have ended.
                Failure::INTERRUPTED | Failure::DEVICE => interrupt::leave(code),
                _ => ExitCode::from(code),
            }
        }
    }
}

/// Makes a write beyond `ulimit -f` an error as any other, where it would end the program.
fn ignore_file_size_limit() {
    #[cfg(unix)]
    // SAFETY: no thread but this one, and no handler of this signal, is there yet.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

fn run(arguments: impl Iterator<Item = OsString>) -> Result<(), Failure> {
    let arguments: Vec<OsString> = arguments.collect();
    let program = arguments.first().cloned().unwrap_or_else(|| "celfx".into());
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    match cli.command {
        Command::Render(options) => render::run(&options, &cli.common),
        Command::Frames(options) => frames::run(&options, &cli.common, &program),
        Command::Shot(options) => shot::run(&options),
        Command::Bench(options) => bench::run(&options, &cli.common),
        Command::Info(options) => info::run(&options, &cli.common),
        Command::Inspect(options) => inspect::run(&options),
    }
}

/// Help and version go to standard output and are no failure; everything else that clap says is.
fn usage(error: &clap::Error) -> Result<(), Failure> {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => print(&error.render().to_string()),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Err(Failure::usage(format!("a subcommand is missing\n\n{}", error.render())))
        }
        _ => {
            let text = error.render().to_string();
            Err(Failure::usage(text.strip_prefix("error: ").unwrap_or(&text).trim_end()))
        }
    }
}

/// The text as it may be shown: control characters but for ends of lines, and characters that turn the direction of
/// writing, are spelled out (as JSON does), so that no name in a file takes over a terminal.
fn visible(text: &str) -> Cow<'_, str> {
    let is_unseen = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t')) || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(is_unseen) {
        return text.into();
    }
    let spelled = |c: char| if is_unseen(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    text.chars().map(spelled).collect::<String>().into()
}

/// Prints to standard output. A reader that has gone away (`| head`) is no failure: it has what it wanted.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(visible(text).as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(Failure::OUTPUT, format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn control_characters_are_spelled_out() {
        assert_eq!(visible("a \u{e9}\n\tb"), "a \u{e9}\n\tb");
        assert_eq!(visible("\u{1b}[2J\r\u{9b}\u{7f}\0\u{202e}x"), "\\u001b[2J\\u000d\\u009b\\u007f\\u0000\\u202ex");
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
