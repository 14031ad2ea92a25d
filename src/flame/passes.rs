//! The passes of the flame effect, declared once. Every kernel binds its slots by their names.

use ash::vk;

use crate::flame::colour::{Form, Table};
use crate::flame::frame::Desc;
use crate::flame::layout::*;
use crate::flame::params::{CHROMATICITY, EITHER, MAGNIFIED, MINIFIED, RADIANCE, RAMP};
use crate::flame::settings::{Mode, Sampling, Shape};
use crate::plan::{Blend, ColourAttachment, Declare, DepthAttachment, Pass, PassId, Raster, Topology, Usage};
use crate::shaders::flame as glsl;

/// What an effect declares: its passes, and which is which.
#[derive(Debug)]
pub struct Passes {
    /// By [`PassId`].
    pub list: Vec<Pass>,
    pub(super) params: PassId,
    pub(super) tables: PassId,
    pub(super) particles: PassId,
    pub(super) background: PassId,
    pub(super) scene_copy: PassId,
    pub(super) scene: PassId,
    pub(super) mask: PassId,
    pub(super) mips: PassId,
    pub(super) prepare: PassId,
    pub(super) range: PassId,
    pub(super) bin_reset: PassId,
    pub(super) count: PassId,
    pub(super) scan: PassId,
    pub(super) fill: PassId,
    pub(super) tiles: PassId,
    /// Where the mask is minified, and where it is magnified.
    pub(super) accumulate: [PassId; 2],
    pub(super) converge: PassId,
    pub(super) adapt: PassId,
    pub(super) weigh: PassId,
    pub(super) rebuild: PassId,
    pub(super) shares: PassId,
    pub(super) kernel: PassId,
    pub(super) clear: PassId,
    pub(super) sprites: PassId,
    pub(super) raster: PassId,
    pub(super) add: PassId,
    pub(super) lamp: PassId,
    pub(super) light: PassId,
    pub(super) resolve: PassId,
    pub(super) composite: PassId,
}

impl Passes {
    /// Declares every pass that some frame of this effect may need.
    pub fn new(desc: &Desc, table: &Table) -> Passes {
        let mut d = Declare::new(resource);
        let (from, to) = (Usage::COPY_SOURCE, Usage::COPY_TARGET);
        let form = match table.form {
            Form::Radiance => RADIANCE,
            Form::Chromaticity => CHROMATICITY,
            Form::Ramp => RAMP,
        };
        Passes {
            params: d.writes("flame.params", &[PARAMS, CONTROL]),
            tables: d.writes("flame.tables", &[COLOURS]),
            particles: d.transfer(
                "flame.particles",
                &[(HOST_POSITIONS.into(), from), (HOST_IDS.into(), from), (POSITIONS.into(), to), (IDS.into(), to)],
            ),
            background: d.transfer("flame.background", &[(TARGET.into(), to), (BACKGROUND.into(), from)]),
            scene_copy: d.transfer(
                "flame.scene",
                &[(HOST_DEPTH.into(), from), (HOST_SCENE.into(), from), (SCENE_WORDS.into(), to), (SCENE.into(), to)],
            ),
            scene: d.compute("flame.scene", &glsl::scene::SHADER),
            mask: d.compute("flame.mask", &glsl::mask::SHADER),
            mips: d.compute("flame.mask", &glsl::mips::SHADER),
            prepare: d.add(Pass::compute("flame.prepare", &glsl::prepare::SHADER).specialise([form])),
            range: d.compute("flame.prepare", &glsl::range::SHADER),
            bin_reset: d.writes("flame.bin", &[CELLS]),
            count: d.compute("flame.bin", &glsl::count::SHADER),
            scan: d.compute("flame.bin", &glsl::scan::SHADER),
            fill: d.compute("flame.bin", &glsl::fill::SHADER),
            tiles: d.compute("flame.bin", &glsl::tiles::SHADER),
            accumulate: match desc.settings.mode {
                Mode::Stochastic => [MINIFIED, MAGNIFIED].map(|look_up| d.add(accumulate(desc, look_up))),
                Mode::Expected => [d.add(expected(desc)); 2],
            },
            converge: d.compute("flame.accumulate", &glsl::converge::SHADER),
            adapt: d.compute("flame.accumulate", &glsl::adapt::SHADER),
            weigh: d.compute("flame.prepare", &glsl::weigh::SHADER),
            rebuild: d.compute("flame.kernel", &glsl::rebuild::SHADER),
            shares: d.compute("flame.kernel", &glsl::shares::SHADER),
            kernel: d.add(
                Pass::compute("flame.kernel", &glsl::kernel::SHADER)
                    .specialise([u32::from(desc.settings.shape == Shape::Cube)]),
            ),
            clear: d.writes("flame.clear", &[PICTURE, MEAN, VARIANCE, NEAREST, PARTICLES]),
            sprites: d.compute("flame.raster", &glsl::sprites::SHADER),
            raster: d.add(raster(desc)),
            add: d.compute("flame.raster", &glsl::add::SHADER),
            lamp: d.compute("flame.light", &glsl::light::SHADER),
            light: d.add(light(desc)),
            resolve: d.add(
                Pass::compute("flame.resolve", &glsl::resolve::SHADER)
                    .specialise([u32::from(desc.layers), u32::from(desc.settings.mode == Mode::Expected)]),
            ),
            composite: d.add(composite(desc)),
            list: d.list,
        }
    }
}

/// What kernels that make sprites are specialised by.
fn variant(desc: &Desc, look_up: u32) -> [u32; 5] {
    let settings = &desc.settings;
    [
        u32::from(settings.shape == Shape::Cube),
        u32::from(settings.sampling == Sampling::ShuffledSobol),
        u32::from(settings.flicker > 0.0),
        look_up,
        u32::from(desc.scene.is_some()),
    ]
}

fn accumulate(desc: &Desc, look_up: u32) -> Pass {
    Pass::compute("flame.accumulate", &glsl::accumulate::SHADER).specialise(variant(desc, look_up))
}

/// One repetition, drawn.
fn raster(desc: &Desc) -> Pass {
    let extent = if is_raster(desc) { desc.size } else { [1, 1] };
    let (format, blend) = (vk::Format::R32G32_UINT, Blend::Replace);
    let raster = Raster {
        topology: Topology::Quads,
        vertex: &glsl::raster_vertex::SHADER,
        fragment: &glsl::raster_fragment::SHADER,
        colour: Some(ColourAttachment { image: DRAWN, format, clear: Some([0; 4]), blend }),
        depth: Some(DepthAttachment::nearest(DRAWN_DEPTH)),
        extent,
    };
    // Which look-up a sprite needs is its own to find out: the mask may be magnified in one frame and not in another.
    Pass::raster("flame.raster", raster).specialise(variant(desc, EITHER))
}

/// What the fire does to the scene around it.
fn light(desc: &Desc) -> Pass {
    let raster = Raster {
        topology: Topology::Quads,
        vertex: &glsl::light_vertex::SHADER,
        fragment: &glsl::light_fragment::SHADER,
        colour: Some(ColourAttachment {
            image: TARGET,
            format: desc.target_format,
            clear: None,
            blend: Blend::Brighten,
        }),
        depth: None,
        extent: desc.size,
    };
    Pass::raster("flame.light", raster)
}

fn expected(desc: &Desc) -> Pass {
    Pass::compute("flame.accumulate", &glsl::expected::SHADER)
        .specialise([u32::from(desc.scene.is_some()), u32::from(desc.layers)])
}

fn composite(desc: &Desc) -> Pass {
    let raster = Raster {
        topology: Topology::Quads,
        vertex: &glsl::composite_vertex::SHADER,
        fragment: &glsl::composite_fragment::SHADER,
        colour: Some(ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over }),
        depth: None,
        extent: desc.size,
    };
    Pass::raster("flame.composite", raster)
}
