//! The smoke in all ways that its kernels are specialised for.

use crate::effect::{DeviceTraits, Effort};
use crate::error::Result;
use crate::host::TemporalFormats;
use crate::offline::TARGET_FORMAT;
use crate::plan::Pass;
use crate::program::variants::{DEPTH, SIZE, TEMPORAL, passes, switches};
use crate::smoke::settings::{Integrator, LINES, Mask, Operator, Shadow};
use crate::smoke::{Desc, Settings, SmokeKind};

pub(super) fn variants(traits: &DeviceTraits) -> Result<Vec<Vec<Pass>>> {
    let shadows = [Shadow::Exact, Shadow::Map, Shadow::None];
    let operators = [Operator::Step, Operator::Roberts, Operator::Second];
    let ways = shadows.into_iter().flat_map(|shadow| operators.map(|operator| (shadow, operator)));
    let variants = switches().flat_map(|switches| ways.clone().map(move |way| variant(switches, way, traits)));
    variants.collect()
}

fn variant(
    [rk2, layers, thorough, depth, flat, plain]: [bool; 6],
    (shadow, operator): (Shadow, Operator),
    traits: &DeviceTraits,
) -> Result<Vec<Pass>> {
    let mut settings = Settings { shadow, ..Settings::default() };
    settings.integrator = if rk2 { Integrator::Rk2 } else { Integrator::Euler };
    // Ways of moving, masks and pieces of lines have no kernel in common.
    settings.mask = if rk2 { Mask::Soft } else { Mask::Groups };
    settings.outline.operator = operator;
    settings.outline.width = if operator == Operator::Roberts { 1.0 } else { 16.0 };
    settings.outline.shortest = if rk2 { 0.0 } else { settings.outline.shortest };
    settings.outline.strength = if plain { 0.0 } else { 1.0 };
    // More light and more colours, all together.
    settings.tones_above = rk2.then(|| settings.tones.clone());
    settings.tones[0].shadow = rk2.then_some([0.0; 3]);
    settings.sigma = if flat { 0.0 } else { settings.sigma };
    let desc = Desc {
        size: SIZE,
        lines: Some(LINES),
        target_format: TARGET_FORMAT,
        dimensions: [8; 3],
        velocity: true,
        point_light: false,
        rim: rk2,
        second_light: rk2,
        fire_light: rk2,
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
