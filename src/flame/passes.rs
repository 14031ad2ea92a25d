//! The passes of the flame effect, declared once. Every kernel binds its slots by their names.

use crate::flame::colour::{Form, Table};
use crate::flame::frame::Desc;
use crate::flame::layout::*;
use crate::flame::settings::{Mode, Sampling, Shape};
use crate::plan::{Blend, BufferId, ColourAttachment, Pass, PassId, Raster, Resource, Shader, Usage};
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
    pub(super) resolve: PassId,
    pub(super) composite: PassId,
}

/// Collects declarations.
struct Declare(Vec<Pass>);

impl Declare {
    fn add(&mut self, pass: Pass) -> PassId {
        self.0.push(pass.bind_all(resource));
        PassId(self.0.len() as u16 - 1)
    }

    fn compute(&mut self, name: &'static str, shader: &'static Shader) -> PassId {
        self.add(Pass::compute(name, shader))
    }

    fn transfer(&mut self, name: &'static str, uses: &[(Resource, Usage)]) -> PassId {
        self.add(uses.iter().fold(Pass::transfer(name), |pass, (resource, usage)| pass.uses(*resource, *usage)))
    }

    /// Writes to buffers by fills and updates.
    fn writes(&mut self, name: &'static str, buffers: &[BufferId]) -> PassId {
        let uses: Vec<_> = buffers.iter().map(|buffer| ((*buffer).into(), Usage::COPY_TARGET)).collect();
        self.transfer(name, &uses)
    }
}

impl Passes {
    /// Declares every pass that some frame of this effect may need.
    pub fn new(desc: &Desc, table: &Table) -> Passes {
        let mut d = Declare(Vec::new());
        let (from, to) = (Usage::COPY_SOURCE, Usage::COPY_TARGET);
        let form = match table.form {
            Form::Radiance => 0,
            Form::Chromaticity => 1,
            Form::Ramp => 2,
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
            bin_reset: d.writes("flame.bin", &[CELLS]),
            count: d.compute("flame.bin", &glsl::count::SHADER),
            scan: d.compute("flame.bin", &glsl::scan::SHADER),
            fill: d.compute("flame.bin", &glsl::fill::SHADER),
            tiles: d.compute("flame.bin", &glsl::tiles::SHADER),
            accumulate: match desc.settings.mode {
                Mode::Stochastic => [0, 1].map(|magnified| d.add(accumulate(desc, magnified))),
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
            clear: d.writes("flame.clear", &[PICTURE, MEAN, VARIANCE, NEAREST]),
            resolve: d.add(
                Pass::compute("flame.resolve", &glsl::resolve::SHADER)
                    .specialise([u32::from(desc.layers), u32::from(desc.settings.mode == Mode::Expected)]),
            ),
            composite: d.add(composite(desc)),
            list: d.0,
        }
    }
}

fn accumulate(desc: &Desc, magnified: u32) -> Pass {
    let settings = &desc.settings;
    Pass::compute("flame.accumulate", &glsl::accumulate::SHADER).specialise([
        u32::from(settings.shape == Shape::Cube),
        u32::from(settings.sampling == Sampling::ShuffledSobol),
        u32::from(settings.flicker > 0.0),
        magnified,
        u32::from(desc.scene.is_some()),
    ])
}

fn expected(desc: &Desc) -> Pass {
    Pass::compute("flame.accumulate", &glsl::expected::SHADER).specialise([u32::from(desc.scene.is_some())])
}

fn composite(desc: &Desc) -> Pass {
    let raster = Raster {
        vertex: &glsl::composite_vertex::SHADER,
        fragment: &glsl::composite_fragment::SHADER,
        colour: Some(ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over }),
        depth: None,
        extent: desc.size,
    };
    Pass::raster("flame.composite", raster)
}
