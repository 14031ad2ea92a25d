//! What the program has of the flame effect.

mod feed;
mod input;
mod layers;

pub use feed::FlameFeed;

use super::EffectEntry;
use crate::bench::{self, Benchmark};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    name: "flame",
    open: input::open,
    layers: layers::LAYERS,
    watch: None,
    benchmark: Benchmark(bench::flame::measure),
};
