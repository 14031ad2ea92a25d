//! The program's part of the smoke effect.

mod feed;
mod input;
mod layers;
mod shot;
mod variants;

pub use feed::SmokeFeed;
pub use shot::Smoke;

use super::EffectEntry;
use super::layers::{Shown, Who};
use crate::bench::{self, Benchmark};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    table: &shot::TABLE,
    open: input::open,
    layers: layers::LAYERS,
    shown: Some(Shown { depth: "smoke.depth", who: Who::Effect { colour: "smoke", id: Some("smoke.id") } }),
    watch: None,
    variants: variants::variants,
    benchmark: Benchmark(bench::smoke::measure),
};
