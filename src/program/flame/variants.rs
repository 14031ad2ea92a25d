//! The flame in all ways that its kernels are specialised for.

use crate::effect::{DeviceTraits, Effort};
use crate::error::Result;
use crate::flame::settings::{Colour, Embers, Glow, Look, Mode, Sampling, Shape};
use crate::flame::{Desc, FlameKind, SceneFormat, Settings};
use crate::host::TemporalFormats;
use crate::offline::TARGET_FORMAT;
use crate::plan::Pass;
use crate::program::variants::{SIZE, TEMPORAL, passes, switches};

pub(super) fn variants(traits: &DeviceTraits) -> Result<Vec<Vec<Pass>>> {
    let colours = || [Colour::Physical, Colour::Displayable, Colour::Ramp(vec![[1.0; 3]; 2])];
    switches().flat_map(|switches| colours().map(|colour| variant(switches, colour, traits))).collect()
}

fn variant(
    [expected, cube, sobol, flicker, scene, layers]: [bool; 6],
    colour: Colour,
    traits: &DeviceTraits,
) -> Result<Vec<Pass>> {
    let settings = Settings {
        mode: if expected { Mode::Expected } else { Mode::Stochastic },
        shape: if cube { Shape::Cube } else { Shape::Ball },
        sampling: if sobol { Sampling::ShuffledSobol } else { Sampling::Independent },
        flicker: if flicker { 0.5 } else { 0.0 },
        look: if cube { Look::Light } else { Look::Cel },
        glow: Glow { strength: if flicker { 1.0 } else { 0.0 }, ..Glow::default() },
        embers: Embers { share: if flicker { 0.1 } else { 0.0 }, ..Embers::default() },
        stretch: if sobol { 0.1 } else { 0.0 },
        colour,
        // Each way with them and without.
        emission: if cube || expected { Some(0.0) } else { None },
        octaves: if sobol { 0 } else { 2 },
        spread: Some(0.1),
        ..Settings::default()
    };
    let desc = Desc {
        size: SIZE,
        lines: None,
        target_format: TARGET_FORMAT,
        scene: scene.then_some(SceneFormat::Buffer),
        accumulates: false,
        particles: 8,
        hottest: settings.hottest,
        seed: 1,
        settings,
        layers,
        // Beside each way to resolve.
        temporal: if flicker { TEMPORAL } else { TemporalFormats::default() },
    };
    passes::<FlameKind>(&desc, traits, Effort::Needed)
}
