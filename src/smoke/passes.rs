//! The passes of the smoke effect, declared once. Kernels bind by name.

use ash::vk;

use crate::effect::Effort;
use crate::plan::{Blend, BufferId, ColourAttachment, DepthAttachment, Pass, PassId, Raster, Shader, Topology, passes};
use crate::scan;
use crate::shaders::smoke as glsl;
use crate::smoke::desc::Desc;
use crate::smoke::layout::*;
use crate::smoke::params::{Control, MAX_LEVELS, NO_CHANNEL, SmokeParams, Tone};
use crate::smoke::settings::{Integrator, Operator, Outline, Radius, Shadow};
use crate::smoke::tables::Tables;

passes! {
    (desc: &Desc, layout: &Layout, tables: &Tables, effort: Effort), resource;
    params = Pass::transfer("smoke.params").updates::<SmokeParams>(PARAMS, 1).updates::<Control>(CONTROL, 1);
    tables = Pass::transfer("smoke.tables")
        .updates::<f32>(WEIGHTS, tables.weights.len())
        .updates::<Tone>(TONES, tables.tones.len());
    volume = Pass::transfer("smoke.volume").copies(HOST_DENSITY, DENSITY).copies(HOST_VELOCITY, VELOCITY);
    background = Pass::transfer("smoke.background").copies(BACKGROUND, TARGET);
    restart = Pass::transfer("smoke.restart").fills(DYING).fills(SPHERES).fills(GROUPS);
    clear = [PIXELS, DEPTH, LINES, INK_BITS, SHADOW, SMOOTH, PICTURE]
        .into_iter()
        .chain(COLOUR_LAYERS)
        .fold(Pass::transfer("smoke.clear"), Pass::fills);
    /// Along x and y, and along z.
    detail: [PassId; 2] = [&glsl::detail_across::SHADER, &glsl::detail_along::SHADER]
        .map(|shader| Pass::compute("smoke.detail", shader));
    occupancy = Pass::compute("smoke.occupancy", &glsl::occupancy::SHADER)
        .bind(glsl::occupancy::DENSITY, density(desc));
    /// Where each block of births begins.
    births: [PassId; 2] = scan::passes("smoke.occupancy", BIRTH_COUNTS, BIRTH_SUMS);
    pyramid = Pass::compute("smoke.pyramid", &glsl::pyramid::SHADER).times(MAX_LEVELS as usize);
    crossings = Pass::compute("smoke.crossings", &glsl::crossings::SHADER).times(MAX_LEVELS as usize);
    field: [PassId; 3] = [&glsl::field_rows::SHADER, &glsl::field_columns::SHADER, &glsl::field_slices::SHADER]
        .map(|shader| Pass::compute("smoke.field", shader));
    advect = Pass::compute("smoke.advect", &glsl::advect::SHADER)
        .specialise([desc.settings.integrator == Integrator::Rk2, desc.temporal.motion.is_some()].map(u32::from));
    grow_field = Pass::compute("smoke.grow", &glsl::grow_field::SHADER);
    grow_pyramid = Pass::compute("smoke.grow", &glsl::grow_pyramid::SHADER).times(layout.search_parts as usize);
    grow_growth = Pass::compute("smoke.grow", &glsl::grow_growth::SHADER).times(layout.search_parts as usize);
    grow_surface = Pass::compute("smoke.grow", &glsl::grow_surface::SHADER)
        .bind(glsl::grow_surface::DENSITY, density(desc))
        .specialise([u32::from(desc.settings.radius == Radius::Ball)]);
    grow_reset = Pass::transfer("smoke.grow").fills(CONTINUATIONS);
    count = Pass::compute("smoke.list", &glsl::count::SHADER);
    listing = Pass::compute("smoke.list", &glsl::list::SHADER).specialise([soft(desc)]);
    shadow_reset = Pass::transfer("smoke.shadow").fills(CELLS);
    shadow_count = Pass::compute("smoke.shadow", &glsl::shadow_count::SHADER).specialise([across(layout)]);
    /// Where each light-space list begins.
    shadow_scan: [PassId; 2] = scan::passes("smoke.shadow", CELLS, CELL_SUMS);
    shadow_fill = Pass::compute("smoke.shadow", &glsl::shadow_fill::SHADER).specialise([across(layout)]);
    /// A pass a face; none without a shadow map.
    shadow_map: Vec<PassId> = shadow_maps(desc, layout);
    occlusion_reset = Pass::transfer("smoke.occlusion").fills(OCCLUSION);
    occluders = Pass::compute("smoke.occlusion", &glsl::occluders::SHADER);
    quads = Pass::compute("smoke.occlusion", &glsl::quads::SHADER).specialise([u32::from(effort.skips())]);
    spheres = spheres(desc);
    tiles = Pass::compute("smoke.tiles", &glsl::tiles::SHADER).specialise([u32::from(desc.settings.is_antialiased())]);
    /// Sums of blocks, and what follows from them.
    occupied: [PassId; 2] = [&glsl::occupied_sum::SHADER, &glsl::occupied::SHADER]
        .map(|shader| Pass::compute("smoke.tiles", shader));
    luminance = luminance(desc, layout);
    dilate = Pass::compute("smoke.tiles", &glsl::dilate::SHADER);
    /// As `occupied`.
    items: [PassId; 2] = [&glsl::items_sum::SHADER, &glsl::items::SHADER]
        .map(|shader| Pass::compute("smoke.tiles", shader).specialise([soft(desc)]).times(layout.batches as usize));
    gaussian: [PassId; 2] = gaussian(desc, layout, None);
    /// The same of each channel.
    channels: Vec<[PassId; 2]> =
        (0..layout.channels.count()).map(|channel| gaussian(desc, layout, Some(channel))).collect::<Vec<_>>();
    outline: Vec<PassId> = outline(&layout.pixels.outline);
    tone = tone(desc, layout);
    edges = Pass::transfer("smoke.edges").copies(HOST_EDGES, EDGES);
    motion: Option<PassId> = desc.temporal.motion.map(|format| motion(desc, format));
    reactive: Option<PassId> = desc.temporal.reactive.map(|format| reactive(desc, format));
    composite = composite(desc);
}

/// What the threshold cuts.
fn density(desc: &Desc) -> BufferId {
    if desc.settings.is_detailed() { DETAILED } else { DENSITY }
}

/// The mask, as a specialisation constant.
fn soft(desc: &Desc) -> u32 {
    desc.settings.is_soft().into()
}

/// Cells across a sphere at its level, as a specialisation constant.
fn across(layout: &Layout) -> u32 {
    (layout.cells_across as f32).to_bits()
}

/// The faces of the shadow map.
fn shadow_maps(desc: &Desc, layout: &Layout) -> Vec<Pass> {
    let faces = if desc.settings.has_shadow_map() { layout.light_faces } else { 0 };
    (0..faces).map(|face| shadow_map(desc, face)).collect()
}

/// One face of the shadow map.
fn shadow_map(desc: &Desc, face: u32) -> Pass {
    let raster = Raster {
        topology: Topology::Quads,
        vertex: &glsl::shadow_vertex::SHADER,
        fragment: &glsl::shadow_fragment::SHADER,
        colour: None,
        depth: Some(DepthAttachment { layer: face, ..DepthAttachment::nearest(SHADOW_MAP) }),
        extent: [desc.settings.shadow_map; 2],
    };
    Pass::raster("smoke.shadow", raster)
}

fn spheres(desc: &Desc) -> Pass {
    let seen =
        ColourAttachment { image: SEEN, format: vk::Format::R32_UINT, clear: Some([0; 4]), blend: Blend::Replace };
    let raster = Raster {
        topology: Topology::Quads,
        vertex: &glsl::spheres_vertex::SHADER,
        fragment: &glsl::spheres_fragment::SHADER,
        colour: Some(seen),
        depth: Some(DepthAttachment::nearest(SEEN_DEPTH)),
        extent: desc.size,
    };
    Pass::raster("smoke.spheres", raster).specialise([soft(desc)])
}

fn luminance(desc: &Desc, layout: &Layout) -> Pass {
    let shader = match desc.settings.shadow {
        Shadow::None => &glsl::luminance::SHADER,
        Shadow::Exact => &glsl::luminance_exact::SHADER,
        Shadow::Map => &glsl::luminance_map::SHADER,
    };
    let [shade, fire, rim] = layout.channels.words();
    let switches = [layout.keeps_shadow(desc), desc.second_light].map(u32::from);
    let pass = Pass::compute("smoke.luminance", shader);
    let pass = pass.specialise([across(layout), switches[0], switches[1], shade, fire, rim]);
    pass.times(layout.luminance_parts as usize)
}

/// Rows and columns of the Gaussian: of luminance, or of a channel.
fn gaussian(desc: &Desc, layout: &Layout, channel: Option<u32>) -> [Pass; 2] {
    [("smoke.rows", &glsl::rows::SHADER), ("smoke.columns", &glsl::columns::SHADER)].map(|(name, shader)| {
        let pass = Pass::compute(name, shader).specialise([soft(desc), channel.unwrap_or(NO_CHANNEL)]);
        pass.times(layout.batches as usize)
    })
}

/// One pass, or two for steps.
fn outline(outline: &Outline) -> Vec<Pass> {
    let pass = |shader| Pass::compute("smoke.outline", shader);
    let fading = |second: u32| vec![pass(&glsl::outline::SHADER).specialise([second])];
    match outline.operator {
        Operator::Roberts => fading(0),
        Operator::Second => fading(1),
        Operator::Step => {
            let all_stay = u32::from(outline.shortest == 0.0);
            vec![pass(&glsl::outline_step::SHADER), pass(&glsl::outline_ink::SHADER).specialise([all_stay])]
        }
    }
}

fn tone(desc: &Desc, layout: &Layout) -> Pass {
    let (settings, outline) = (&desc.settings, &layout.pixels.outline);
    let [shade, fire, rim] = layout.channels.words();
    Pass::compute("smoke.tone", &glsl::tone::SHADER).specialise([
        u32::from(settings.is_filtered()),
        u32::from(outline.is_on()),
        u32::from(desc.layers),
        outline.reach(),
        u32::from(outline.is_hard()),
        soft(desc),
        u32::from(settings.has_shaded_tones() && settings.casts_shadows()),
        u32::from(settings.tones_above.is_some()),
        shade,
        fire,
        rim,
        u32::from(settings.is_antialiased()),
    ])
}

fn composite(desc: &Desc) -> Pass {
    let fragment = match desc.depth {
        Some(_) => &glsl::composite_depth_fragment::SHADER,
        None => &glsl::composite_fragment::SHADER,
    };
    let colour = ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over };
    Pass::raster("smoke.composite", over_tiles(desc, fragment, colour, true))
}

/// Before the composite: the host's depth still decides where smoke is seen.
fn motion(desc: &Desc, format: vk::Format) -> Pass {
    let colour = ColourAttachment { image: MOTION, format, clear: None, blend: Blend::Replace };
    Pass::raster("smoke.motion", over_tiles(desc, &glsl::motion_fragment::SHADER, colour, false))
}

/// As `motion`.
fn reactive(desc: &Desc, format: vk::Format) -> Pass {
    let colour = ColourAttachment { image: REACTIVE, format, clear: None, blend: Blend::Max };
    Pass::raster("smoke.reactive", over_tiles(desc, &glsl::reactive_fragment::SHADER, colour, false))
}

/// A draw over occupied tiles, in front of the host's depth, which takes the smoke's or not.
fn over_tiles(desc: &Desc, fragment: &'static Shader, colour: ColourAttachment, write: bool) -> Raster {
    Raster {
        topology: Topology::Quads,
        vertex: &glsl::composite_vertex::SHADER,
        fragment,
        colour: Some(colour),
        depth: desc.depth.map(|format| DepthAttachment::of_host(HOST_DEPTH, format, write)),
        extent: desc.size,
    }
}
