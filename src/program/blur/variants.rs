//! The blur in all ways that its kernels are specialised for.

use crate::blur::settings::{Completion, Refine, Space};
use crate::blur::{BlurKind, Desc, Settings};
use crate::effect::{DeviceTraits, Effort};
use crate::error::Result;
use crate::offline::TARGET_FORMAT;
use crate::plan::Pass;
use crate::program::variants::{DEPTH, SIZE, passes, switches};
use crate::toon::Operator;

pub(super) fn variants(traits: &DeviceTraits) -> Result<Vec<Vec<Pass>>> {
    let completions = [Completion::Surface, Completion::Gradient, Completion::None];
    switches().flat_map(|switches| completions.map(|completion| variant(switches, completion, traits))).collect()
}

fn variant(
    [screen, by_length, layers, depth, second, plain, many]: [bool; 7],
    completion: Completion,
    traits: &DeviceTraits,
) -> Result<Vec<Pass>> {
    let mut settings = Settings { completion, ..Settings::default() };
    settings.space = if screen { Space::Screen } else { Space::Homogeneous };
    settings.refine = if by_length { Refine::Length } else { Refine::Error };
    settings.toon.outline.operator = if second { Operator::Second } else { Operator::Roberts };
    settings.toon.outline.width = if second { 16.0 } else { 1.0 };
    settings.toon.outline.strength = if plain { 0.0 } else { 1.0 };
    let desc = Desc {
        size: SIZE,
        target_format: TARGET_FORMAT,
        points: 8,
        triangles: 8,
        neighbours: 8,
        objects: 1,
        groups: 8,
        group_triangles: 8,
        outer: true,
        toon: true,
        depth: depth.then_some(DEPTH),
        occluders: depth.then_some(DEPTH),
        most_triangles: 64,
        segments: if many { 32 } else { 1 },
        frames_resident: 4,
        seed: 0,
        settings,
        layers,
    };
    passes::<BlurKind>(&desc, traits, Effort::Needed)
}
