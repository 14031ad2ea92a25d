//! `celfx shot`: prints a built-in shot.

use clap::Args;

use super::{Failure, print};
use crate::program::builtin_text;

const EXAMPLES: &str = "\
Examples:
  celfx shot builtin:smoke                  what can be set, with unit, range and default
  celfx shot builtin:flame > my.toml        a shot to edit and render";

/// Options of `celfx shot`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// The shot: builtin:smoke, builtin:cloud, builtin:paper_smoke, builtin:flame, builtin:paper_flame, builtin:campfire,
    /// builtin:blur or builtin:paper_blur
    #[arg(value_name = "builtin:NAME")]
    name: String,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    print(&builtin_text(&options.name)?)
}
