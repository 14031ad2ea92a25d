//! What the program has of the blur effect.

mod feed;
mod input;
mod layers;

pub use feed::BlurFeed;

use super::EffectEntry;
use crate::bench::{self, Benchmark};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    name: "blur",
    open: input::open,
    layers: layers::LAYERS,
    watch: Some(layers::REFINEMENT),
    benchmark: Benchmark(bench::blur::measure),
};
