//! The blur in all ways that its kernels are specialised for.

use ash::vk::{self, Handle};

use crate::blur::parts::PartSizes;
use crate::blur::settings::{Completion, Ink, Mix, Refine, Space};
use crate::blur::{BlurKind, Desc, Settings, Source};
use crate::effect::{DeviceTraits, Effort};
use crate::error::Result;
use crate::host::{HostBuffer, TemporalFormats};
use crate::offline::TARGET_FORMAT;
use crate::plan::Pass;
use crate::program::variants::{DEPTH, SIZE, TEMPORAL, passes, switches};
use crate::toon::Operator;

pub(super) fn variants(traits: &DeviceTraits) -> Result<Vec<Vec<Pass>>> {
    let completions = [Completion::Surface, Completion::Gradient, Completion::None];
    let plain = switches().flat_map(|switches| completions.map(|completion| variant(switches, completion, traits)));
    plain.chain([Space::Homogeneous, Space::Screen].map(|space| of_parts(space, traits))).collect()
}

/// Of a host that names parts and has poses on the device.
fn of_parts(space: Space, traits: &DeviceTraits) -> Result<Vec<Pass>> {
    let settings = Settings { space, ..Settings::default() };
    let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
    // Pipelines do not depend on which.
    let buffer = HostBuffer { buffer: vk::Buffer::from_raw(1), offset: 0, size: 1 << 16, stage, access };
    let source = Source { buffer, stride: 3, vertices: 8, points: 8 };
    let parts = Some(PartSizes { parts: 1, chunks: 1, seams: 0, most_neighbours: 0 });
    let desc = Desc { parts, sources: vec![source], ..desc(settings) };
    passes::<BlurKind>(&desc, traits, Effort::Needed)
}

fn variant(
    [screen, by_length, layers, depth, second, plain, many]: [bool; 7],
    completion: Completion,
    traits: &DeviceTraits,
) -> Result<Vec<Pass>> {
    let mut settings = Settings { completion, ..Settings::default() };
    settings.space = if screen { Space::Screen } else { Space::Homogeneous };
    settings.refine = if by_length { Refine::Length } else { Refine::Error };
    settings.mix = if screen { Mix::Blend } else { Mix::Choose };
    settings.toon.ink = if by_length { Ink::Before } else { Ink::After };
    settings.toon.outline.operator = match (second, by_length) {
        (true, true) => Operator::Second,
        (true, false) => Operator::Step,
        (false, _) => Operator::Roberts,
    };
    settings.toon.outline.width = if second { 16.0 } else { 1.0 };
    settings.toon.outline.strength = if plain { 0.0 } else { 1.0 };
    let (depth, occluders) = (depth.then_some(DEPTH), depth.then_some(DEPTH));
    settings.dry = if many { 0.5 } else { 0.0 };
    let segments = if many { 32 } else { 1 };
    // In both spaces, with depth and without.
    let temporal = if plain { TEMPORAL } else { TemporalFormats::default() };
    // A kernel that looks frames up and draws textures, too, has two subgroups on the oldest chip, and is not counted.
    let texture_rows = if by_length { 0 } else { 8 };
    let desc = Desc { depth, occluders, segments, layers, temporal, texture_rows, ..desc(settings) };
    passes::<BlurKind>(&desc, traits, Effort::Needed)
}

fn desc(settings: Settings) -> Desc {
    Desc {
        size: SIZE,
        target_format: TARGET_FORMAT,
        points: 8,
        triangles: 8,
        neighbours: 8,
        surfaces: 1,
        groups: 8,
        group_triangles: 8,
        texture_rows: 0,
        outer: true,
        toon: true,
        depth: None,
        occluders: None,
        most_triangles: 64,
        segments: 1,
        frames_resident: 4,
        parts: None,
        sources: Vec::new(),
        seed: 0,
        settings,
        layers: false,
        temporal: TemporalFormats::default(),
    }
}
