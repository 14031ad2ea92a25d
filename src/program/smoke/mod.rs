//! What the program has of the smoke effect.

mod feed;
mod input;
mod layers;

pub use feed::SmokeFeed;

use super::EffectEntry;
use crate::bench::{self, Benchmark};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    name: "smoke",
    open: input::open,
    layers: layers::LAYERS,
    watch: None,
    benchmark: Benchmark(bench::smoke::measure),
};
