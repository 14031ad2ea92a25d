//! The passes of the smoke effect, declared once. Every kernel binds its slots by their names.

use ash::vk;

use crate::plan::{Blend, ColourAttachment, Declare, DepthAttachment, Pass, PassId, Raster, Topology, Usage};
use crate::shaders::smoke as glsl;
use crate::smoke::frame::Desc;
use crate::smoke::layout::*;
use crate::smoke::settings::{Integrator, Operator, Shadow};

/// What an effect declares: its passes, and which is which.
#[derive(Debug)]
pub struct Passes {
    /// By [`PassId`].
    pub list: Vec<Pass>,
    pub(super) params: PassId,
    pub(super) tables: PassId,
    pub(super) volume: PassId,
    pub(super) background: PassId,
    pub(super) restart: PassId,
    pub(super) clear: PassId,
    pub(super) occupancy: PassId,
    pub(super) births: PassId,
    pub(super) pyramid: PassId,
    pub(super) field: [PassId; 3],
    pub(super) advect: PassId,
    pub(super) grow_field: PassId,
    pub(super) grow_pyramid: PassId,
    pub(super) grow_growth: PassId,
    pub(super) grow_reset: PassId,
    pub(super) count: PassId,
    pub(super) scan: PassId,
    pub(super) listing: PassId,
    pub(super) shadow_reset: PassId,
    pub(super) shadow_count: PassId,
    pub(super) shadow_scan: PassId,
    pub(super) shadow_fill: PassId,
    pub(super) shadow_map: Vec<PassId>,
    pub(super) occlusion_reset: PassId,
    pub(super) occluders: PassId,
    pub(super) quads: PassId,
    pub(super) spheres: PassId,
    pub(super) tiles: PassId,
    pub(super) occupied: PassId,
    pub(super) luminance: PassId,
    pub(super) dilate: PassId,
    pub(super) items: PassId,
    pub(super) rows: PassId,
    pub(super) columns: PassId,
    pub(super) outline: PassId,
    pub(super) tone: PassId,
    pub(super) edges: PassId,
    pub(super) composite: PassId,
}

impl Passes {
    /// Declares every pass that some frame of this effect may need.
    pub fn new(desc: &Desc, layout: &Layout) -> Passes {
        let mut d = Declare::new(resource);
        let settings = &desc.settings;
        let across = (layout.cells_across as f32).to_bits();
        let (from, to) = (Usage::COPY_SOURCE, Usage::COPY_TARGET);
        Passes {
            params: d.writes("smoke.params", &[PARAMS, CONTROL]),
            tables: d.writes("smoke.tables", &[WEIGHTS, TONES]),
            volume: d.transfer(
                "smoke.volume",
                &[
                    (HOST_DENSITY.into(), from),
                    (HOST_VELOCITY.into(), from),
                    (DENSITY.into(), to),
                    (VELOCITY.into(), to),
                ],
            ),
            background: d.transfer("smoke.background", &[(TARGET.into(), to), (BACKGROUND.into(), from)]),
            restart: d.writes("smoke.restart", &[DYING, SPHERES, GROUPS]),
            clear: d.writes("smoke.clear", &[PIXELS, DEPTH, LINES, SHADOW, SMOOTH, PICTURE, TONE_LAYER, OUTLINE_LAYER]),
            occupancy: d.compute("smoke.occupancy", &glsl::occupancy::SHADER),
            births: d.compute("smoke.occupancy", &glsl::births::SHADER),
            pyramid: d.compute("smoke.pyramid", &glsl::pyramid::SHADER),
            field: [
                d.compute("smoke.field", &glsl::field_rows::SHADER),
                d.compute("smoke.field", &glsl::field_columns::SHADER),
                d.compute("smoke.field", &glsl::field_slices::SHADER),
            ],
            advect: d.add(
                Pass::compute("smoke.advect", &glsl::advect::SHADER)
                    .specialise([u32::from(settings.integrator == Integrator::Rk2)]),
            ),
            grow_field: d.compute("smoke.grow", &glsl::grow_field::SHADER),
            grow_pyramid: d.compute("smoke.grow", &glsl::grow_pyramid::SHADER),
            grow_growth: d.compute("smoke.grow", &glsl::grow_growth::SHADER),
            grow_reset: d.writes("smoke.grow", &[CONTINUATIONS]),
            count: d.compute("smoke.list", &glsl::count::SHADER),
            scan: d.compute("smoke.list", &glsl::scan::SHADER),
            listing: d.compute("smoke.list", &glsl::list::SHADER),
            shadow_reset: d.writes("smoke.shadow", &[CELLS]),
            shadow_count: d.add(Pass::compute("smoke.shadow", &glsl::shadow_count::SHADER).specialise([across])),
            shadow_scan: d.compute("smoke.shadow", &glsl::shadow_scan::SHADER),
            shadow_fill: d.add(Pass::compute("smoke.shadow", &glsl::shadow_fill::SHADER).specialise([across])),
            shadow_map: match settings.shadow {
                Shadow::Map => (0..layout.light_faces).map(|face| d.add(shadow_map(desc, face))).collect(),
                _ => Vec::new(),
            },
            occlusion_reset: d.writes("smoke.occlusion", &[OCCLUSION]),
            occluders: d.compute("smoke.occlusion", &glsl::occluders::SHADER),
            quads: d.add(Pass::compute("smoke.occlusion", &glsl::quads::SHADER).specialise([u32::from(desc.skipping)])),
            spheres: d.add(spheres(desc)),
            tiles: d.compute("smoke.tiles", &glsl::tiles::SHADER),
            occupied: d.compute("smoke.tiles", &glsl::occupied::SHADER),
            luminance: d.add(luminance(desc, layout, across)),
            dilate: d.compute("smoke.tiles", &glsl::dilate::SHADER),
            items: d.compute("smoke.tiles", &glsl::items::SHADER),
            rows: d.compute("smoke.rows", &glsl::rows::SHADER),
            columns: d.compute("smoke.columns", &glsl::columns::SHADER),
            outline: d.add(
                Pass::compute("smoke.outline", &glsl::outline::SHADER)
                    .specialise([u32::from(settings.outline.operator == Operator::Second)]),
            ),
            tone: d.add(tone(desc)),
            edges: d.transfer("smoke.edges", &[(HOST_EDGES.into(), from), (EDGES.into(), to)]),
            composite: d.add(composite(desc)),
            list: d.list,
        }
    }
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
    Pass::raster("smoke.spheres", raster)
}

fn luminance(desc: &Desc, layout: &Layout, across: u32) -> Pass {
    let shader = match desc.settings.shadow {
        Shadow::None => &glsl::luminance::SHADER,
        Shadow::Exact => &glsl::luminance_exact::SHADER,
        Shadow::Map => &glsl::luminance_map::SHADER,
    };
    let keep_shadow = desc.layers || layout.luminance_parts > 1;
    Pass::compute("smoke.luminance", shader).specialise([across, u32::from(keep_shadow)])
}

fn tone(desc: &Desc) -> Pass {
    let settings = &desc.settings;
    let reach = settings.outline.width.ceil() as u32 - 1;
    Pass::compute("smoke.tone", &glsl::tone::SHADER).specialise([
        u32::from(settings.sigma > 0.0),
        u32::from(settings.outline.strength > 0.0),
        u32::from(desc.layers),
        reach,
    ])
}

fn composite(desc: &Desc) -> Pass {
    let raster = Raster {
        topology: Topology::Quads,
        vertex: &glsl::composite_vertex::SHADER,
        fragment: match desc.depth {
            Some(_) => &glsl::composite_depth_fragment::SHADER,
            None => &glsl::composite_fragment::SHADER,
        },
        colour: Some(ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over }),
        depth: desc.depth.map(|format| DepthAttachment::of_host(HOST_DEPTH, format, true)),
        extent: desc.size,
    };
    Pass::raster("smoke.composite", raster)
}
