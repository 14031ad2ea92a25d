//! Effects in all ways that their kernels are specialised for.

use ash::vk;
use celfx::blur::BlurKind;
use celfx::blur::settings::{Completion, Refine, Space};
use celfx::effect::{DeviceLimits, Effort, Kind, describe};
use celfx::flame::settings::{Colour, Mode, Sampling, Shape};
use celfx::flame::{self, FlameKind, SceneFormat};
use celfx::host::DepthFormat;
use celfx::low_level::plan::Pass;
use celfx::smoke::SmokeKind;
use celfx::smoke::settings::{Integrator, Shadow};
use celfx::toon::Operator;
use celfx::{blur, smoke};

use crate::common::bench::RANGE;
use crate::common::{flame as fire, scenes};

const DEPTH: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: false };

/// Each of `bits` switches on or off, in all ways.
fn switches<const N: usize>() -> impl Iterator<Item = [bool; N]> {
    (0..1_u32 << N).map(|word| std::array::from_fn(|bit| word >> bit & 1 == 1))
}

pub fn all() -> Vec<Vec<Pass>> {
    let smoke = switches().flat_map(|bits| [Shadow::Exact, Shadow::Map, Shadow::None].map(|s| smoke_of(bits, s)));
    let completions = [Completion::Surface, Completion::Gradient, Completion::None];
    let blur = switches().flat_map(|bits| completions.map(|c| blur_of(bits, c)));
    smoke.chain(flames()).chain(blur).collect()
}

fn smoke_of([rk2, second, layers, thorough, depth, flat, plain]: [bool; 7], shadow: Shadow) -> Vec<Pass> {
    let mut settings = smoke::Settings { shadow, ..smoke::Settings::default() };
    settings.integrator = if rk2 { Integrator::Rk2 } else { Integrator::Euler };
    settings.outline.operator = if second { Operator::Second } else { Operator::Roberts };
    settings.outline.width = if second { 16.0 } else { 1.0 };
    settings.outline.strength = if plain { 0.0 } else { 1.0 };
    settings.sigma = if flat { 0.0 } else { settings.sigma };
    let desc = scenes::desc([16, 16], [8; 3], settings);
    let desc = smoke::Desc { layers, depth: depth.then_some(DEPTH), edges: depth, velocity: true, ..desc };
    described::<SmokeKind>(&desc, if thorough { Effort::Everything } else { Effort::Needed })
}

fn flames() -> impl Iterator<Item = Vec<Pass>> {
    let colours = || [Colour::Physical, Colour::Displayable, Colour::Ramp(vec![[1.0; 3]; 2])];
    switches().flat_map(move |bits| colours().map(|colour| flame_of(bits, colour)))
}

fn flame_of([expected, cube, sobol, flicker, scene, layers]: [bool; 6], colour: Colour) -> Vec<Pass> {
    let settings = flame::Settings {
        mode: if expected { Mode::Expected } else { Mode::Stochastic },
        shape: if cube { Shape::Cube } else { Shape::Ball },
        sampling: if sobol { Sampling::ShuffledSobol } else { Sampling::Independent },
        flicker: if flicker { 0.5 } else { 0.0 },
        colour,
        ..flame::Settings::default()
    };
    let scene = scene.then_some(SceneFormat::Buffer);
    described::<FlameKind>(&flame::Desc { scene, layers, ..fire::desc([16, 16], 8, settings) }, Effort::Needed)
}

/// What an effect is made of.
fn described<K: Kind>(desc: &K::Desc, effort: Effort) -> Vec<Pass> {
    let limits = DeviceLimits { storage_range: RANGE, image_side: 4096 };
    describe(&mut K::new(desc, &limits, effort).expect("it can be made"), desc).passes
}

fn blur_of([screen, by_length, layers, depth, second, plain, many]: [bool; 7], completion: Completion) -> Vec<Pass> {
    let mut settings = blur::Settings { completion, ..blur::Settings::default() };
    settings.space = if screen { Space::Screen } else { Space::Homogeneous };
    settings.refine = if by_length { Refine::Length } else { Refine::Error };
    settings.toon.outline.operator = if second { Operator::Second } else { Operator::Roberts };
    settings.toon.outline.width = if second { 16.0 } else { 1.0 };
    settings.toon.outline.strength = if plain { 0.0 } else { 1.0 };
    let desc = blur::Desc {
        size: [16, 16],
        target_format: vk::Format::R32G32B32A32_SFLOAT,
        points: 8,
        triangles: 8,
        neighbours: 8,
        objects: 1,
        groups: 8,
        group_triangles: 8,
        outer: true,
        toon: true,
        depth: depth.then_some(DEPTH),
        most_triangles: 64,
        segments: if many { 32 } else { 1 },
        frames_resident: 4,
        seed: 0,
        settings,
        layers,
    };
    described::<BlurKind>(&desc, Effort::Needed)
}
