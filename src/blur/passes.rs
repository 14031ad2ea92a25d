//! The passes of the blur effect, declared once. Every kernel binds its slots by their names.

use ash::vk;

use crate::blur::frame::Desc;
use crate::blur::layout::*;
use crate::blur::params::{FROM_GRADIENT, FROM_SURFACE, PIECE_SEGMENTS, ink_reach};
use crate::blur::settings::{Completion, Operator, Refine, Space};
use crate::host::DepthFormat;
use crate::plan::{
    Blend, ColourAttachment, Declare, DepthAttachment, ImageId, Pass, PassId, Raster, Resource, Shader, Topology, Usage,
};
use crate::shaders::blur as glsl;

/// What an effect declares: its passes, and which is which.
#[derive(Debug)]
pub struct Passes {
    /// By [`PassId`].
    pub list: Vec<Pass>,
    pub(super) params: PassId,
    pub(super) mesh: PassId,
    pub(super) poses: PassId,
    pub(super) background: PassId,
    pub(super) interval: PassId,
    pub(super) project: PassId,
    pub(super) knots: PassId,
    pub(super) trajectory: PassId,
    pub(super) pieces: PassId,
    pub(super) extent: PassId,
    pub(super) seams: PassId,
    pub(super) settle: PassId,
    pub(super) begin: PassId,
    /// Of even rounds, and of odd ones, which read what even ones write.
    pub(super) count: [PassId; 2],
    pub(super) scan: PassId,
    /// As `count`.
    pub(super) emit: [PassId; 2],
    /// Frames i and i + 1.
    pub(super) visibility: [PassId; 2],
    /// At pixel centres, and at four samples a pixel.
    pub(super) distort: [PassId; 2],
    pub(super) layers: PassId,
    pub(super) frames: PassId,
    /// Frames i - 1 and i + 2.
    pub(super) outer_visibility: [PassId; 2],
    /// As `outer_visibility`.
    pub(super) outer_frames: [PassId; 2],
    pub(super) groups: PassId,
    pub(super) completing: PassId,
    pub(super) sums: PassId,
    pub(super) cover: PassId,
    pub(super) large_groups: PassId,
    pub(super) normals: PassId,
    pub(super) normals_large: PassId,
    pub(super) learn: PassId,
    pub(super) fill: PassId,
    pub(super) pairs: PassId,
    pub(super) light: PassId,
    pub(super) tone: PassId,
    pub(super) shade_params: PassId,
    pub(super) shade: PassId,
    /// Of frames that are drawn, if any are and completion follows from the surface.
    pub(super) shade_drawn: Option<PassId>,
    pub(super) sides: PassId,
    /// Of samples that neither frame shows, and of those that one does.
    pub(super) border: [PassId; 2],
    /// As `border`.
    pub(super) inward: [PassId; 2],
    pub(super) tiles_begin: PassId,
    pub(super) tiles: PassId,
    pub(super) compose: PassId,
    pub(super) composite: PassId,
    pub(super) colours: PassId,
    pub(super) toon_params: PassId,
    pub(super) toon_project: PassId,
    pub(super) toon_see: PassId,
    pub(super) toon_lines: PassId,
    /// Into each place.
    pub(super) toon: [PassId; TOON.len()],
    /// Of each place.
    pub(super) toon_background: [PassId; TOON.len()],
    pub(super) toon_frames: PassId,
    /// Frames i - 1 and i + 2.
    pub(super) toon_outer_frames: [PassId; 2],
    pub(super) behind: PassId,
    pub(super) ghost: PassId,
    pub(super) ghost_blend: PassId,
    pub(super) lines_begin: PassId,
    pub(super) lines_choose: PassId,
    pub(super) lines: PassId,
    pub(super) depth_params: PassId,
    pub(super) depth_project: PassId,
    pub(super) depth_see: PassId,
    /// An image that is given, and one that has been drawn.
    pub(super) depth_frame: [PassId; 2],
    pub(super) surface: PassId,
    /// None where the host has no depth.
    pub(super) depth: Option<PassId>,
}

impl Passes {
    /// Declares every pass that some frame of this effect may need.
    pub fn new(desc: &Desc) -> Passes {
        let mut d = Declare::new(resource);
        let screen = u32::from(desc.settings.space == Space::Screen);
        let by_length = u32::from(desc.settings.refine == Refine::Length);
        let completion = match desc.settings.completion {
            Completion::None => 0,
            Completion::Surface => FROM_SURFACE,
            Completion::Gradient => FROM_GRADIENT,
        };
        let segments = desc.segments.min(PIECE_SEGMENTS);
        Passes {
            params: d.writes("blur.params", &[PARAMS, CONTROL, ROUND_LIST]),
            mesh: d.transfer("blur.mesh", &copies(HOST_TOPOLOGY, [TRIANGLES, NEIGHBOUR_STARTS, NEIGHBOURS])),
            poses: d.transfer("blur.poses", &copies([HOST_POSES], [POSES])),
            background: d.transfer(
                "blur.background",
                &[(HOST_FRAMES[1].into(), Usage::COPY_SOURCE), (TARGET.into(), Usage::COPY_TARGET)],
            ),
            interval: d.transfer(
                "blur.interval",
                &copies(
                    [0, 1, 2, 3, 4, 5].map(|place| HOST_INTERVAL[place]),
                    [MOTIONS, LABELS, CLUSTERS, HULL, SEAMS, FRONTS],
                ),
            ),
            project: d.compute("blur.trajectory", &glsl::project::SHADER),
            knots: d.writes("blur.trajectory", &[KNOTS]),
            trajectory: d
                .add(Pass::compute("blur.trajectory", &glsl::trajectory::SHADER).specialise([segments, screen])),
            pieces: d.transfer("blur.trajectory", &copies([HOST_INTERVAL[6]], [SPLINES])),
            extent: d.compute("blur.extent", &glsl::extent::SHADER),
            seams: d.compute("blur.seams", &glsl::seams::SHADER),
            settle: d.add(Pass::compute("blur.extent", &glsl::settle::SHADER).specialise([screen])),
            begin: d.compute("blur.refine", &glsl::begin::SHADER),
            count: [ACTIVE, NEXT].map(|active| {
                let pass = Pass::compute("blur.refine", &glsl::count::SHADER).specialise([screen, by_length]);
                d.add(pass.bind(glsl::count::ACTIVE, active))
            }),
            scan: d.compute("blur.refine", &glsl::scan::SHADER),
            emit: [(ACTIVE, NEXT), (NEXT, ACTIVE)].map(|(active, next)| {
                let pass = Pass::compute("blur.refine", &glsl::emit::SHADER).specialise([screen]);
                d.add(pass.bind(glsl::emit::ACTIVE, active).bind(glsl::emit::NEXT, next))
            }),
            visibility: [0, 1].map(|i| {
                let vertex = &glsl::visibility_vertex::SHADER;
                d.add(drawing("blur.visibility", vertex, SEEN[i], SEEN_DEPTH[i], desc.size))
            }),
            distort: [(DISTORTED, DISTORTED_DEPTH, 1), (SAMPLED, SAMPLED_DEPTH, 2)].map(|(image, depth, scale)| {
                let extent = desc.size.map(|side| scale * side);
                d.add(drawing("blur.distort", &glsl::distort_vertex::SHADER, image, depth, extent))
            }),
            layers: d.compute("blur.layers", &glsl::layers::SHADER),
            frames: {
                let from = HOST_FRAMES.map(|image| (image.into(), Usage::COPY_SOURCE));
                let to = FRAMES.map(|image| (image.into(), Usage::COPY_TARGET));
                d.transfer("blur.frames", &[from, to].concat())
            },
            outer_visibility: [0, 1].map(|i| {
                let extent = if desc.outer { desc.size } else { [1, 1] };
                let vertex = &glsl::visibility_vertex::SHADER;
                d.add(drawing("blur.visibility", vertex, OUTER_SEEN[i], OUTER_DEPTH[i], extent))
            }),
            outer_frames: [0, 1].map(|i| {
                let (from, to) = (HOST_OUTER[i].into(), OUTER_FRAMES[i].into());
                d.transfer("blur.frames", &[(from, Usage::COPY_SOURCE), (to, Usage::COPY_TARGET)])
            }),
            groups: d.transfer("blur.mesh", &copies(HOST_GROUPS, [CORNER_GROUPS, GROUP_STARTS, GROUP_TRIANGLES])),
            completing: d.writes("blur.params", &[COMPLETING]),
            sums: d.writes("blur.learn", &[SUMS]),
            tiles_begin: d.writes("blur.tiles", &[TILES, SAMPLE_STATES]),
            tiles: d.compute("blur.tiles", &glsl::tiles::SHADER),
            cover: d.compute("blur.cover", &glsl::cover::SHADER),
            large_groups: d.writes("blur.normals", &[LARGE_GROUPS]),
            normals: d.add(Pass::compute("blur.normals", &glsl::normals::SHADER).specialise([desc.groups])),
            normals_large: d.add(Pass::compute("blur.normals", &glsl::normals_large::SHADER).specialise([desc.groups])),
            learn: d.add(Pass::compute("blur.learn", &glsl::learn::SHADER).specialise([desc.groups])),
            fill: d.compute("blur.learn", &glsl::fill::SHADER),
            pairs: d.add(Pass::compute("blur.tones", &glsl::pairs::SHADER).specialise([desc.groups])),
            light: d.compute("blur.tones", &glsl::light::SHADER),
            tone: d.compute("blur.tones", &glsl::tone::SHADER),
            shade_params: d.writes("blur.shade", &[TOON_BUFFER]),
            shade_drawn: (desc.toon && desc.settings.completion == Completion::Surface).then(|| {
                d.add(Pass::compute("blur.shade", &glsl::shade_drawn::SHADER).specialise([desc.groups, completion]))
            }),
            shade: d.add(Pass::compute("blur.shade", &glsl::shade::SHADER).specialise([desc.groups, completion])),
            sides: d.compute("blur.layers", &glsl::sides::SHADER),
            border: [0, 1]
                .map(|gradient| d.add(Pass::compute("blur.complete", &glsl::border::SHADER).specialise([gradient]))),
            inward: [0, 1]
                .map(|gradient| d.add(Pass::compute("blur.complete", &glsl::inward::SHADER).specialise([gradient]))),
            compose: d.add(
                Pass::compute("blur.compose", &glsl::compose::SHADER)
                    .specialise([u32::from(desc.layers), u32::from(desc.depth.is_some())]),
            ),
            composite: d.add(match desc.depth {
                Some(format) => composite_depth(desc, format),
                None => whole("blur.composite", &glsl::composite_fragment::SHADER, TARGET, desc),
            }),
            colours: d.transfer("blur.mesh", &copies([HOST_COLOURS], [TOON_BUFFER])),
            toon_params: d.writes("blur.toon", &[TOON_BUFFER]),
            toon_project: d.compute("blur.toon", &glsl::project::SHADER),
            toon_see: d.add(sampling("blur.toon", desc)),
            toon_lines: {
                let second = u32::from(desc.settings.toon.outline.operator == Operator::Second);
                d.add(Pass::compute("blur.toon", &glsl::toon_lines::SHADER).specialise([second]))
            },
            toon: TOON.map(|image| d.add(toon(desc, image))),
            toon_background: TOON.map(|image| d.add(begin(desc, image))),
            toon_frames: d.transfer("blur.frames", &from_toon(&FRAMES)),
            toon_outer_frames: OUTER_FRAMES.map(|image| d.transfer("blur.frames", &from_toon(&[image]))),
            behind: d.transfer(
                "blur.background",
                &[(HOST_BACKGROUND.into(), Usage::COPY_SOURCE), (BACKGROUND.into(), Usage::COPY_TARGET)],
            ),
            ghost: d.add(ghost(desc).specialise([screen])),
            ghost_blend: {
                let (vertex, fragment) = (&glsl::composite_vertex::SHADER, &glsl::ghosts_blend_fragment::SHADER);
                d.add(over_target("blur.ghosts", Topology::Quads, vertex, fragment, desc))
            },
            lines_begin: d.writes("blur.lines", &[TRAILING]),
            lines_choose: d.compute("blur.lines", &glsl::lines_choose::SHADER),
            lines: {
                let (vertex, fragment) = (&glsl::lines_vertex::SHADER, &glsl::lines_fragment::SHADER);
                d.add(over_target("blur.lines", Topology::Triangles, vertex, fragment, desc).specialise([screen]))
            },
            depth_params: d.writes("blur.depth", &[PARAMS]),
            depth_project: d.compute("blur.depth", &glsl::project::SHADER),
            depth_see: d.add(sampling("blur.depth", desc)),
            depth_frame: [
                d.transfer(
                    "blur.depth",
                    &[(HOST_FRAMES[1].into(), Usage::COPY_SOURCE), (FRAMES[1].into(), Usage::COPY_TARGET)],
                ),
                d.transfer("blur.depth", &from_toon(&FRAMES[1..])),
            ],
            surface: d.add(Pass::compute("blur.depth", &glsl::surface::SHADER).specialise([u32::from(desc.layers)])),
            depth: desc.depth.map(|format| d.add(depth(desc, format))),
            list: d.list,
        }
    }
}

/// Copies from the host's buffers.
fn copies<const N: usize>(from: [crate::plan::BufferId; N], to: [crate::plan::BufferId; N]) -> Vec<(Resource, Usage)> {
    let from = from.map(|id| (id.into(), Usage::COPY_SOURCE));
    let to = to.map(|id| (id.into(), Usage::COPY_TARGET));
    from.into_iter().chain(to).collect()
}

/// Triangles by their numbers. The first of those that are equally near stays.
fn drawing(name: &'static str, vertex: &'static Shader, image: ImageId, depth: ImageId, extent: [u32; 2]) -> Pass {
    let (format, blend) = (vk::Format::R32_UINT, Blend::Replace);
    let raster = Raster {
        topology: Topology::Triangles,
        vertex,
        fragment: &glsl::name_fragment::SHADER,
        colour: Some(ColourAttachment { image, format, clear: Some([0; 4]), blend }),
        depth: Some(DepthAttachment::nearest(depth)),
        extent,
    };
    Pass::raster(name, raster)
}

/// A frame at four samples a pixel.
fn sampling(name: &'static str, desc: &Desc) -> Pass {
    let extent = desc.size.map(|side| 2 * side);
    drawing(name, &glsl::visibility_vertex::SHADER, SAMPLED, SAMPLED_DEPTH, extent)
}

/// The mesh's depth into the host's.
fn depth(desc: &Desc, format: DepthFormat) -> Pass {
    let depth = DepthAttachment::of_host(HOST_DEPTH, format, true);
    Pass::raster("blur.depth", quad(&glsl::depth_fragment::SHADER, None, Some(depth), desc))
}

/// The picture, where the host has drawn nothing nearer. What pixels show is not what is nearest there: depth follows by
/// itself.
fn composite_depth(desc: &Desc, format: DepthFormat) -> Pass {
    let depth = DepthAttachment::of_host(HOST_DEPTH, format, false);
    let fragment = &glsl::composite_depth_fragment::SHADER;
    Pass::raster("blur.composite", quad(fragment, Some(TARGET), Some(depth), desc))
}

/// Copies of drawn frames.
fn from_toon(to: &[ImageId]) -> Vec<(Resource, Usage)> {
    let to = to.iter().map(|image| ((*image).into(), Usage::COPY_TARGET));
    TOON.iter().map(|image| ((*image).into(), Usage::COPY_SOURCE)).chain(to).collect()
}

/// A frame from what its samples see.
fn toon(desc: &Desc, image: ImageId) -> Pass {
    let toon = &desc.settings.toon;
    let inked = u32::from(toon.outline.strength > 0.0);
    whole("blur.toon", &glsl::toon_fragment::SHADER, image, desc).specialise([inked, ink_reach(toon)])
}

/// A frame that has been drawn, as the target's first content.
fn begin(desc: &Desc, drawn: ImageId) -> Pass {
    let fragment = &glsl::background_fragment::SHADER;
    whole("blur.background", fragment, TARGET, desc).bind(glsl::background_fragment::DRAWN, drawn)
}

/// Replaces a whole picture, or what its shader does not discard.
fn whole(name: &'static str, fragment: &'static Shader, image: ImageId, desc: &Desc) -> Pass {
    Pass::raster(name, quad(fragment, Some(image), None, desc))
}

/// All of a picture, replaced.
fn quad(fragment: &'static Shader, image: Option<ImageId>, depth: Option<DepthAttachment>, desc: &Desc) -> Raster {
    let (format, blend) = (desc.target_format, Blend::Replace);
    Raster {
        topology: Topology::Quads,
        vertex: &glsl::composite_vertex::SHADER,
        fragment,
        colour: image.map(|image| ColourAttachment { image, format, clear: None, blend }),
        depth,
        extent: desc.size,
    }
}

/// An after-image's surface.
fn ghost(desc: &Desc) -> Pass {
    let blend = Blend::Replace;
    let raster = Raster {
        topology: Topology::Triangles,
        vertex: &glsl::ghosts_vertex::SHADER,
        fragment: &glsl::ghosts_fragment::SHADER,
        colour: Some(ColourAttachment { image: GHOST, format: GHOST_FORMAT, clear: Some([0; 4]), blend }),
        depth: Some(DepthAttachment::nearest(GHOST_DEPTH)),
        extent: desc.size.map(|side| 2 * side),
    };
    Pass::raster("blur.ghosts", raster)
}

/// What is blended over the target.
fn over_target(
    name: &'static str,
    topology: Topology,
    vertex: &'static Shader,
    fragment: &'static Shader,
    desc: &Desc,
) -> Pass {
    let colour = ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over };
    Pass::raster(name, Raster { topology, vertex, fragment, colour: Some(colour), depth: None, extent: desc.size })
}
