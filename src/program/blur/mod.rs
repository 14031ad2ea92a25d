//! The program's part of the blur effect.

mod feed;
mod input;
mod layers;
mod passes;
mod shot;
mod variants;

pub use feed::BlurFeed;
pub use shot::Blur;

use super::EffectEntry;
use crate::bench::{self, Benchmark};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    table: &shot::TABLE,
    open: input::open,
    layers: layers::LAYERS,
    shown: Some(layers::SHOWN),
    watch: Some(layers::REFINEMENT),
    variants: variants::variants,
    benchmark: Benchmark(bench::blur::measure),
};
