//! The program's part of the flame effect.

mod feed;
mod input;
mod layers;
mod shot;
mod spread;
mod variants;

pub use feed::FlameFeed;
pub use shot::Flame;
pub(super) use shot::fire_lights_smoke;

use super::EffectEntry;
use super::layers::{Shown, Who};
use crate::bench::{self, Benchmark};

pub(super) static ENTRY: EffectEntry = EffectEntry {
    table: &shot::TABLE,
    open: input::open,
    layers: layers::LAYERS,
    shown: Some(Shown { depth: "flame.depth", who: Who::Effect { colour: "flame", id: None } }),
    watch: None,
    variants: variants::variants,
    benchmark: Benchmark(bench::flame::measure),
};
