//! `celfx frames`: the commands that render a shot in parts, for a farm.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use clap::Args;

use super::{Common, Failure, print, render};

const EXAMPLES: &str = "\
Examples:
  celfx frames my.toml --chunk 10                            one command a line, 10 frames each
  celfx frames my.toml --chunk 1 -o out/####.exr | parallel  as many at a time as there are cores
  celfx frames my.toml --chunk 25 --cache cache > jobs.txt   with what is handed to every command

Each command keeps frames that are finished and claims those that it renders (--resume): any of them
may run again, twice, or at the same time as others. Exit codes are those of `celfx render`.";

/// Options of `celfx frames`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
#[group(skip)]
pub(super) struct Options {
    #[command(flatten)]
    render: render::Options,
    /// Frames of a command
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    chunk: u32,
}

pub(super) fn run(options: &Options, common: &Common, program: &OsStr) -> Result<(), Failure> {
    let Options { render, chunk } = options;
    if let Some((option, _)) = render.of_all_frames().next() {
        let then = "leave it out, and add it to `celfx render --resume` when all frames are there";
        return Err(Failure::usage(format!("{option} is of all frames together: {then}")));
    }
    let (_, [first, last]) = render.shot()?;
    let mut lines = String::new();
    for first in (first..=last).step_by(*chunk as usize) {
        let last = last.min(first.saturating_add(chunk - 1));
        let frames = [OsString::from("--frames"), format!("{first}-{last}").into()];
        let words = [program.to_owned(), "render".into()].into_iter();
        let words: Vec<String> =
            words.chain(render.arguments()).chain(frames).chain(common.arguments()).map(|word| quoted(&word)).collect();
        lines += &words.join(" ");
        lines.push('\n');
    }
    print(&lines)
}

/// A word for a shell.
fn quoted(word: &OsStr) -> String {
    let text = word.to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-:=,+@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.into_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// An option and its value, if it is given.
pub(super) fn option(name: &str, value: &Option<impl AsRef<OsStr>>) -> Vec<OsString> {
    value.iter().flat_map(|value| [name.into(), value.as_ref().to_owned()]).collect()
}

/// As [`option`], of a path.
pub(super) fn path(name: &str, value: &Option<PathBuf>) -> Vec<OsString> {
    option(name, &value.as_ref().map(|path| path.as_os_str()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Cli;
    use clap::Parser;

    #[test]
    fn words_of_a_command_come_back_from_a_shell() {
        for word in ["a", "out/####.png", "it's", "smoke.tones=[[0, 0, 0]]", "", "a b", "$HOME", "~", "-q"] {
            let script = format!("printf %s {}", quoted(OsStr::new(word)));
            let output = std::process::Command::new("sh").args(["-c", &script]).output().expect("a shell");
            assert_eq!(String::from_utf8_lossy(&output.stdout), word);
        }
    }

    #[test]
    fn commands_have_the_options_that_were_given() {
        let given = [
            "celfx",
            "render",
            "my.toml",
            "--set",
            "smoke.sigma=3",
            "--set",
            "seed=4",
            "-o",
            "o/####.exr",
            "--layers",
            "l.exr",
            "--motion",
            "--compression",
            "piz",
            "--resume=strict",
            "--cache",
            "c",
            "--device",
            "0",
            "--tuning",
            "gpu",
            "--validate",
            "-v",
            "--threads",
            "3",
        ];
        let cli = Cli::try_parse_from(given).expect("allowed");
        let crate::cli::Command::Render(render) = &cli.command else { panic!("render") };
        let words: Vec<OsString> = ["celfx", "render"]
            .into_iter()
            .map(OsString::from)
            .chain(render.arguments())
            .chain(cli.common.arguments())
            .collect();
        let again = Cli::try_parse_from(&words).expect("allowed");
        assert_eq!(format!("{cli:?}"), format!("{again:?}"), "{words:?}");
        // Whatever an option is named: all that help lists are there, but for those of single runs.
        let all = <crate::cli::Cli as clap::CommandFactory>::command();
        let render = all.find_subcommand("render").expect("render");
        let of_one_run = ["help", "frames", "sheet", "animation", "profile", "quiet", "version"];
        for option in render.get_arguments().chain(all.get_arguments()).filter_map(|argument| argument.get_long()) {
            let is_there = words
                .iter()
                .any(|word| word.to_str().is_some_and(|word| word.split('=').next() == Some(&format!("--{option}"))));
            assert!(is_there || of_one_run.contains(&option), "--{option}");
        }
    }
}
