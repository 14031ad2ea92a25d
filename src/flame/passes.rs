//! The passes of the flame effect, declared once. Kernels bind by name.

use ash::vk;

use crate::flame::colour::{Form, Table};
use crate::flame::desc::Desc;
use crate::flame::layout::*;
use crate::flame::limits::is_raster;
use crate::flame::params::{
    CHROMATICITY, Control, EITHER, FlameParams, MAGNIFIED, MASK_LEVELS, MINIFIED, RADIANCE, RAMP, TILE, Tone,
};
use crate::flame::settings::{Mode, Pixels, Sampling, Shape};
use crate::flame::tables::Tables;
use crate::plan::{Blend, ColourAttachment, DepthAttachment, Pass, PassId, Raster, Shader, Topology, passes};
use crate::scan;
use crate::shaders::flame as glsl;
use crate::tuning::Tuning;

passes! {
    (desc: &Desc, layout: &Layout, tables: &Tables, tuning: &Tuning), resource;
    params = Pass::transfer("flame.params").updates::<FlameParams>(PARAMS, 1).updates::<Control>(CONTROL, 1);
    tables = Pass::transfer("flame.tables")
        .updates::<[f32; 4]>(COLOURS, tables.colours.entries.len())
        .updates::<f32>(WEIGHTS, tables.weights.len())
        .updates::<f32>(GLOW_WEIGHTS, tables.glow_weights.len())
        .updates::<Tone>(TONES, tables.tones.len());
    particles = Pass::transfer("flame.particles").copies(HOST_POSITIONS, POSITIONS).copies(HOST_IDS, IDS);
    previous: Option<PassId> =
        desc.temporal.motion.map(|_| Pass::transfer("flame.particles").copies(HOST_PREVIOUS, PREVIOUS));
    velocities: Option<PassId> = desc
        .settings
        .stretches()
        .then(|| Pass::transfer("flame.particles").copies(HOST_VELOCITIES, VELOCITIES));
    background = Pass::transfer("flame.background").copies(BACKGROUND, TARGET);
    scene_copy = Pass::transfer("flame.scene").copies(HOST_DEPTH, SCENE_WORDS).copies(HOST_SCENE, SCENE);
    scene = Pass::compute("flame.scene", &glsl::scene::SHADER);
    mask = Pass::compute("flame.mask", &glsl::mask::SHADER);
    mips = Pass::compute("flame.mask", &glsl::mips::SHADER).times(MASK_LEVELS as usize - 1);
    prepare = Pass::compute("flame.prepare", &glsl::prepare::SHADER).specialise([form(&tables.colours)]);
    range = Pass::compute("flame.prepare", &glsl::range::SHADER);
    bin_reset = Pass::transfer("flame.bin").fills(CELLS);
    count = Pass::compute("flame.bin", &glsl::count::SHADER).specialise([u32::from(desc.settings.is_expected())]);
    /// Where the list of each bucket of each cell begins.
    scan: [PassId; 2] = scan::passes("flame.bin", CELLS, CELL_SUMS);
    fill = Pass::compute("flame.bin", &glsl::fill::SHADER);
    /// Sums of blocks, and what follows from them.
    tiles: [PassId; 2] = [
        Pass::compute("flame.bin", &glsl::tiles_sum::SHADER),
        Pass::compute("flame.bin", &glsl::tiles::SHADER).specialise([reach(desc, &tables.pixels)]),
    ];
    /// One for all repetitions, or one where the mask is minified and one where it is magnified.
    accumulate: Vec<PassId> = accumulate(desc, layout, tuning);
    converge = Pass::compute("flame.accumulate", &glsl::converge::SHADER).times(layout.stages.len());
    /// As `tiles`.
    adapt: [PassId; 2] = [&glsl::adapt_sum::SHADER, &glsl::adapt::SHADER]
        .map(|shader| Pass::compute("flame.accumulate", shader).times(layout.stages.len()));
    rebuild = Pass::compute("flame.kernel", &glsl::rebuild::SHADER);
    shares = Pass::compute("flame.kernel", &glsl::shares::SHADER);
    kernel = Pass::compute("flame.kernel", &glsl::kernel::SHADER)
        .specialise([u32::from(desc.settings.shape == Shape::Cube)]);
    clear = [PICTURE, MEAN, VARIANCE, NEAREST, PARTICLES, HEAT_LAYER, TONE_LAYER]
        .into_iter()
        .fold(Pass::transfer("flame.clear"), Pass::fills);
    /// As `tiles`.
    sprites: [PassId; 2] = [&glsl::sprites_sum::SHADER, &glsl::sprites::SHADER]
        .map(|shader| Pass::compute("flame.raster", shader));
    raster = raster(desc).times(drawn(layout));
    add = Pass::compute("flame.raster", &glsl::add::SHADER).times(drawn(layout));
    lamp = Pass::compute("flame.light", &glsl::light::SHADER).specialise([u32::from(desc.settings.is_cel())]);
    light = light(desc);
    resolve = Pass::compute("flame.resolve", &glsl::resolve::SHADER)
        .specialise(resolved(desc).map(u32::from));
    smooth = Pass::compute("flame.smooth", &glsl::smooth::SHADER)
        .specialise([desc.settings.is_expected(), desc.scene.is_some()].map(u32::from));
    tone = Pass::compute("flame.tone", &glsl::tone::SHADER)
        .specialise([desc.settings.is_expected(), desc.scene.is_some(), desc.layers].map(u32::from));
    /// Rows and columns; none without a glow.
    glow: Vec<PassId> = glow(desc);
    displacement: Option<PassId> = desc.temporal.motion.map(|_| displacement(desc));
    motion: Option<PassId> = desc.temporal.motion.map(|format| motion(desc, format));
    reactive: Option<PassId> = desc.temporal.reactive.map(|format| reactive(desc, format));
    composite = composite(desc);
    embers: Option<PassId> = desc.settings.embers.is_on().then(|| {
        let colour = ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over };
        embers(desc, tables, "flame.embers", &glsl::embers_fragment::SHADER, colour)
    });
    embers_reactive: Option<PassId> =
        desc.temporal.reactive.filter(|_| desc.settings.embers.is_on()).map(|format| {
            let colour = ColourAttachment { image: REACTIVE, format, clear: None, blend: Blend::Max };
            embers(desc, tables, "flame.reactive", &glsl::embers_reactive_fragment::SHADER, colour)
        });
}

/// How colours follow from the table, as `prepare` is told.
fn form(table: &Table) -> u32 {
    match table.form {
        Form::Radiance => RADIANCE,
        Form::Chromaticity => CHROMATICITY,
        Form::Ramp => RAMP,
    }
}

/// Tiles around one with fire that it is smoothed into, and glows into. Differences between pixels reach one farther; and
/// where a scene hides pixels, their weights are asked for as far again.
fn reach(desc: &Desc, pixels: &Pixels) -> u32 {
    let window = pixels.window();
    let smoothed = match (desc.settings.is_cel(), desc.scene) {
        (false, _) => 0,
        (true, None) => window + 1,
        (true, Some(_)) => 2 * window + 1,
    };
    (smoothed + pixels.glow.window()).div_ceil(TILE)
}

fn glow(desc: &Desc) -> Vec<Pass> {
    let shaders = [&glsl::glow_rows::SHADER, &glsl::glow_columns::SHADER];
    shaders
        .into_iter()
        .filter(|_| desc.settings.glow.is_on())
        .map(|shader| Pass::compute("flame.glow", shader))
        .collect()
}

/// What is made of sums.
fn resolved(desc: &Desc) -> [bool; 5] {
    let settings = &desc.settings;
    [desc.layers, settings.is_expected(), desc.keeps_depth(), settings.is_cel(), settings.spreads()]
}

/// Specialisation constants of kernels that make sprites; a workgroup has so many invocations.
fn variant(desc: &Desc, look_up: u32, invocations: u32) -> [u32; 9] {
    let settings = &desc.settings;
    [
        invocations,
        u32::from(settings.shape == Shape::Cube),
        u32::from(settings.sampling == Sampling::ShuffledSobol),
        u32::from(settings.flickers()),
        look_up,
        u32::from(desc.scene.is_some()),
        // Sprites that are not magnified have none.
        if look_up == MINIFIED { 0 } else { settings.detail() },
        u32::from(settings.shines() > 0.0),
        u32::from(settings.stretches()),
    ]
}

fn accumulate(desc: &Desc, layout: &Layout, tuning: &Tuning) -> Vec<Pass> {
    let invocations = tuning.tile_invocations;
    let parts = layout.stages.iter().map(|stage| stage.parts as usize).sum::<usize>();
    let stochastic = |look_up| {
        let pass = Pass::compute("flame.accumulate", &glsl::accumulate::SHADER).specialise(variant(
            desc,
            look_up,
            invocations,
        ));
        pass.times(parts)
    };
    match desc.settings.mode {
        Mode::Stochastic if tuning.mask_kernels == 1 => vec![stochastic(EITHER)],
        Mode::Stochastic => [MINIFIED, MAGNIFIED].map(stochastic).into(),
        Mode::Expected => vec![expected(desc, invocations).times(parts)],
    }
}

/// Repetitions that are drawn.
fn drawn(layout: &Layout) -> usize {
    layout.stages.iter().map(|stage| stage.drawn() as usize).sum()
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
    Pass::raster("flame.raster", raster).specialise(variant(desc, EITHER, 0))
}

/// The fire's light on the scene around it.
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

fn expected(desc: &Desc, invocations: u32) -> Pass {
    Pass::compute("flame.accumulate", &glsl::expected::SHADER).specialise([
        invocations,
        u32::from(desc.scene.is_some()),
        u32::from(desc.layers),
        u32::from(desc.settings.stretches()),
    ])
}

fn composite(desc: &Desc) -> Pass {
    let colour = ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over };
    Pass::raster("flame.composite", over_tiles(desc, &glsl::composite_fragment::SHADER, colour))
}

/// How far particles have moved, at each pixel.
fn displacement(desc: &Desc) -> Pass {
    let (format, blend) = (DISPLACEMENT_FORMAT, Blend::Add);
    let raster = Raster {
        topology: Topology::Triangles,
        vertex: &glsl::displacement_vertex::SHADER,
        fragment: &glsl::displacement_fragment::SHADER,
        colour: Some(ColourAttachment { image: DISPLACEMENTS, format, clear: Some([0; 4]), blend }),
        depth: None,
        extent: desc.size,
    };
    Pass::raster("flame.motion", raster)
}

fn motion(desc: &Desc, format: vk::Format) -> Pass {
    let colour = ColourAttachment { image: MOTION, format, clear: None, blend: Blend::Replace };
    Pass::raster("flame.motion", over_tiles(desc, &glsl::motion_fragment::SHADER, colour))
}

fn reactive(desc: &Desc, format: vk::Format) -> Pass {
    let colour = ColourAttachment { image: REACTIVE, format, clear: None, blend: Blend::Max };
    Pass::raster("flame.reactive", over_tiles(desc, &glsl::reactive_fragment::SHADER, colour))
}

fn embers(
    desc: &Desc,
    tables: &Tables,
    name: &'static str,
    fragment: &'static Shader,
    colour: ColourAttachment,
) -> Pass {
    let raster = Raster {
        topology: Topology::Triangles,
        vertex: &glsl::embers_vertex::SHADER,
        fragment,
        colour: Some(colour),
        depth: None,
        extent: desc.size,
    };
    let facts = [desc.settings.is_cel(), desc.scene.is_some(), desc.settings.spreads()].map(u32::from);
    let [is_cel, has_scene, spreads] = facts;
    Pass::raster(name, raster).specialise([form(&tables.colours), is_cel, has_scene, spreads])
}

/// A draw over occupied tiles.
fn over_tiles(desc: &Desc, fragment: &'static Shader, colour: ColourAttachment) -> Raster {
    Raster {
        topology: Topology::Quads,
        vertex: &glsl::composite_vertex::SHADER,
        fragment,
        colour: Some(colour),
        depth: None,
        extent: desc.size,
    }
}
