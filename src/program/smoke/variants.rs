//! The smoke in all ways that its kernels are specialised for.

use crate::effect::{DeviceTraits, Effort};
use crate::error::Result;
use crate::host::TemporalFormats;
use crate::offline::TARGET_FORMAT;
use crate::plan::Pass;
use crate::program::variants::{DEPTH, SIZE, TEMPORAL, passes, switches};
use crate::smoke::settings::{Integrator, Shadow};
use crate::smoke::{Desc, Settings, SmokeKind};
use crate::toon::Operator;

pub(super) fn variants(traits: &DeviceTraits) -> Result<Vec<Vec<Pass>>> {
    let shadows = [Shadow::Exact, Shadow::Map, Shadow::None];
    switches().flat_map(|switches| shadows.map(|shadow| variant(switches, shadow, traits))).collect()
}

fn variant(
    [rk2, second, layers, thorough, depth, flat, plain]: [bool; 7],
    shadow: Shadow,
    traits: &DeviceTraits,
) -> Result<Vec<Pass>> {
    let mut settings = Settings { shadow, ..Settings::default() };
    settings.integrator = if rk2 { Integrator::Rk2 } else { Integrator::Euler };
    settings.outline.operator = if second { Operator::Second } else { Operator::Roberts };
    settings.outline.width = if second { 16.0 } else { 1.0 };
    settings.outline.strength = if plain { 0.0 } else { 1.0 };
    settings.sigma = if flat { 0.0 } else { settings.sigma };
    let desc = Desc {
        size: SIZE,
        target_format: TARGET_FORMAT,
        dimensions: [8; 3],
        velocity: true,
        point_light: false,
        seed: 1,
        settings,
        layers,
        depth: depth.then_some(DEPTH),
        edges: depth,
        // Beside each way of moving, with depth and without.
        temporal: if flat { TEMPORAL } else { TemporalFormats::default() },
    };
    passes::<SmokeKind>(&desc, traits, if thorough { Effort::Everything } else { Effort::Needed })
}
