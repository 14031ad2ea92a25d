//! The passes of the blur effect, declared once. Kernels bind by name.

use crate::blur::limits::{CHOOSE_ROUNDS, LIGHT_CANDIDATES, MOST_KNOTS, inward_dispatches, inward_iterations};
use ash::vk;

use crate::blur::desc::Desc;
use crate::blur::layout::*;
use crate::blur::params::{
    BlurParams, Control, FROM_GRADIENT, FROM_SURFACE, Knot, PIECE_SEGMENTS, ROUNDS, Round, ToonParams, ink_reach,
};
use crate::blur::settings::{Completion, Extent, Mix, Refine, Space};
use crate::effect::DeviceTraits;
use crate::host::DepthFormat;
use crate::plan::{
    Blend, ColourAttachment, DepthAttachment, ImageId, Pass, PassId, Raster, Resource, Shader, Topology, Usage, passes,
};
use crate::shaders::blur as glsl;

passes! {
    (desc: &Desc, traits: &DeviceTraits), resource;
    params = Pass::transfer("blur.params")
        .updates::<BlurParams>(PARAMS, 1)
        .updates::<Control>(CONTROL, 1)
        .updates::<Round>(ROUND_LIST, ROUNDS as usize + 1);
    mesh = copies("blur.mesh", HOST_TOPOLOGY, [TRIANGLES, NEIGHBOUR_STARTS, NEIGHBOURS]);
    /// Where frames go around, those that come are in two runs.
    poses = copies("blur.poses", [HOST_POSES], [POSES]).times(2);
    parts = copies("blur.mesh", HOST_PARTS, [PART_LABELS, PART_MEMBERS, PART_CHUNKS, PART_ROWS, SEAMS])
        .copies(HOST_SOURCE_ROWS, SOURCE_ROWS);
    /// Of each source.
    gather: Vec<PassId> = {
        let gather = |number| Pass::compute("blur.poses", &glsl::gather::SHADER).bind(glsl::gather::SOURCE, host_source(number));
        (0..desc.sources.len()).map(gather).collect::<Vec<Pass>>()
    };
    background = copies("blur.background", [HOST_FRAMES[1]], [TARGET]);
    interval = {
        let [motions, labels, clusters, bounds, seams, fronts, _] = HOST_INTERVAL;
        let from = [motions, labels, clusters, bounds, seams, fronts];
        copies("blur.interval", from, [MOTIONS, LABELS, CLUSTERS, BOUNDS, SEAMS, FRONTS])
    };
    project = Pass::compute("blur.trajectory", &glsl::project::SHADER);
    knots = Pass::transfer("blur.trajectory").updates::<Knot>(KNOTS, MOST_KNOTS);
    trajectory = Pass::compute("blur.trajectory", &glsl::trajectory::SHADER)
        .specialise([desc.segments.min(PIECE_SEGMENTS), in_screen(desc)]);
    pieces = copies("blur.trajectory", [HOST_INTERVAL[6]], [SPLINES]).times(desc.segments as usize);
    /// Where parts are found on the device; what is closed is not known then.
    measure_begin = Pass::transfer("blur.measure").fills(SUPPORT_VALUES).fills(SUPPORT_POINTS).fills(ROW_VALUES).fills(FRONTS);
    /// Motion, the farthest points of chunks, those of parts, clusters; none without parts.
    measure: Vec<PassId> = match desc.parts {
        Some(_) => vec![
            Pass::compute("blur.measure", &glsl::measure::SHADER).specialise([in_screen(desc)]),
            Pass::compute("blur.measure", &glsl::support::SHADER),
            Pass::compute("blur.measure", &glsl::outline::SHADER),
            Pass::compute("blur.measure", &glsl::describe::SHADER),
        ],
        None => Vec::new(),
    };
    /// Of parts that have them: what bounds rows, and means of that.
    rows: Vec<PassId> = match desc.settings.extent {
        Extent::Row if desc.parts.is_some() => {
            [&glsl::rows::SHADER, &glsl::rows_mean::SHADER].map(|shader| Pass::compute("blur.measure", shader)).into()
        }
        _ => Vec::new(),
    };
    extent = Pass::compute("blur.extent", &glsl::extent::SHADER);
    seams = Pass::compute("blur.seams", &glsl::seams::SHADER).times(desc.settings.seam_smoothing as usize);
    settle = Pass::compute("blur.extent", &glsl::settle::SHADER).specialise([in_screen(desc)]);
    begin = Pass::compute("blur.refine", &glsl::begin::SHADER);
    /// Of even rounds, and of odd ones, which read what even ones write.
    count: [PassId; 2] = [ACTIVE, NEXT].map(|active| {
        let by_length = u32::from(desc.settings.refine == Refine::Length);
        let pass = Pass::compute("blur.refine", &glsl::count::SHADER).specialise([in_screen(desc), by_length]);
        pass.bind(glsl::count::ACTIVE, active).times(ROUNDS as usize / 2 + 1)
    });
    /// As `count`.
    emit: [PassId; 2] = [(ACTIVE, NEXT), (NEXT, ACTIVE)].map(|(active, next)| {
        let pass = Pass::compute("blur.refine", &glsl::emit::SHADER).specialise([in_screen(desc)]);
        pass.bind(glsl::emit::ACTIVE, active).bind(glsl::emit::NEXT, next).times(ROUNDS as usize / 2 + 1)
    });
    /// Frames i and i + 1.
    visibility: [PassId; 2] = [0, 1].map(|i| {
        drawing("blur.visibility", &glsl::visibility_vertex::SHADER, SEEN[i], SEEN_DEPTH[i], desc.size)
    });
    scenes = HOST_SCENES.into_iter().fold(Pass::transfer("blur.occluders"), |pass, from| pass.copies(from, SCENE_WORDS)).times(4);
    /// Of frames i - 1 to i + 2, before their meshes; none without depth images.
    occluders: Vec<PassId> = match desc.occluders {
        Some(_) => SEEN_FRAMES.map(|(image, depth)| occluders(desc, image, depth)).into(),
        None => Vec::new(),
    };
    /// The mesh behind them.
    hidden_visibility: Vec<PassId> = match desc.occluders {
        Some(_) => SEEN_FRAMES.map(|(image, depth)| behind_occluders(desc, image, depth)).into(),
        None => Vec::new(),
    };
    /// At pixel centres, and at four samples a pixel.
    distort: [PassId; 2] = [(DISTORTED, DISTORTED_DEPTH, 1), (SAMPLED, SAMPLED_DEPTH, 2)].map(|(image, depth, scale)| {
        distort(desc, image, depth, desc.size.map(|side| scale * side))
    });
    layers = Pass::compute("blur.layers", &glsl::layers::SHADER);
    /// Of the mesh where nothing moves, and of the refined one.
    objects: [PassId; 2] = [("blur.depth", 0), ("blur.layers", 1)]
        .map(|(name, refined)| Pass::compute(name, &glsl::objects::SHADER).specialise([refined]));
    frames = copies("blur.frames", HOST_FRAMES, FRAMES);
    /// Frames i - 1 and i + 2.
    outer_visibility: [PassId; 2] = [0, 1].map(|i| {
        let extent = extent_of(desc, OUTER_SEEN[i]);
        drawing("blur.visibility", &glsl::visibility_vertex::SHADER, OUTER_SEEN[i], OUTER_DEPTH[i], extent)
    });
    /// As `outer_visibility`.
    outer_frames: [PassId; 2] = [0, 1].map(|i| copies("blur.frames", [HOST_OUTER[i]], [OUTER_FRAMES[i]]));
    groups = copies("blur.mesh", HOST_GROUPS, [CORNER_GROUPS, GROUP_STARTS, GROUP_TRIANGLES]);
    completing = Pass::transfer("blur.params").fills(COMPLETING).updates::<u32>(COMPLETING, COMPLETING_WORDS);
    sums = Pass::transfer("blur.learn").fills(SUMS);
    tiles_begin = Pass::transfer("blur.tiles").fills(TILES).updates::<u32>(TILES, TILE_WORDS).fills(SAMPLE_STATES);
    tiles = Pass::compute("blur.tiles", &glsl::tiles::SHADER);
    cover = Pass::compute("blur.cover", &glsl::cover::SHADER);
    /// Of frames that are drawn, and of the output.
    large_groups = Pass::transfer("blur.normals").updates::<u32>(LARGE_GROUPS, LARGE_WORDS).times(2);
    normals = Pass::compute("blur.normals", &glsl::normals::SHADER).specialise([desc.groups]).times(2);
    normals_large = Pass::compute("blur.normals", &glsl::normals_large::SHADER).specialise([desc.groups]).times(2);
    learn = Pass::compute("blur.learn", &glsl::learn::SHADER).specialise([desc.groups]);
    fill = Pass::compute("blur.learn", &glsl::fill::SHADER);
    pairs = Pass::compute("blur.tones", &glsl::pairs::SHADER).specialise([desc.groups]);
    light = Pass::compute("blur.tones", &glsl::light::SHADER).times(LIGHT_CANDIDATES.len());
    tone = Pass::compute("blur.tones", &glsl::tone::SHADER).times(2);
    shade_params = Pass::transfer("blur.shade").updates::<ToonParams>(TOON_BUFFER, 1);
    /// Of frames that are drawn, if any are and completion follows from the surface.
    shade_drawn: Option<PassId> = draws_hidden(desc).then(|| {
        let facts = [completion(desc), chooses(desc), desc.settings.toon.draws_smears().into()];
        let [completion, chooses, is_bare] = facts;
        let constants = [desc.groups, completion, chooses, is_bare, textured(desc)];
        Pass::compute("blur.shade", &glsl::shade_drawn::SHADER).specialise(constants)
    });
    shade =
        Pass::compute("blur.shade", &glsl::shade::SHADER).specialise([desc.groups, completion(desc), chooses(desc)]);
    /// Of frames that are drawn, if ink comes after the distortion.
    ink: Option<PassId> = inks_smears(desc).then(|| {
        let [second, steps] = desc.settings.toon.outline.operator.words();
        Pass::compute("blur.ink", &glsl::ink::SHADER).specialise([second, steps, desc.settings.dry.to_bits()])
    });
    sides = Pass::compute("blur.layers", &glsl::sides::SHADER);
    /// Of samples that neither frame shows, and of those that one does.
    border: [PassId; 2] = [0, 1]
        .map(|gradient| Pass::compute("blur.complete", &glsl::border::SHADER).specialise([gradient]));
    /// As `border`.
    inward: [PassId; 2] = [0, 1].map(|gradient| {
        let pass = Pass::compute("blur.complete", &glsl::inward::SHADER);
        let pass = pass.specialise([gradient, inward_iterations(traits)]);
        pass.times(inward_dispatches(traits)[gradient as usize] as usize)
    });
    compose = compose(desc);
    composite = match desc.depth {
        Some(format) => composite_depth(desc, format),
        None => whole("blur.composite", &glsl::composite_fragment::SHADER, TARGET, desc),
    };
    motion: Option<PassId> = desc.temporal.motion.map(|format| motion(desc, format));
    reactive: Option<PassId> = desc.temporal.reactive.map(|format| reactive(desc, format));
    colours = copies("blur.mesh", [HOST_COLOURS], [TOON_BUFFER]);
    textures = copies("blur.mesh", [HOST_TEXTURES], [TOON_BUFFER]);
    shares = copies("blur.mesh", [HOST_SHARES], [SHARES]);
    shares_all = Pass::transfer("blur.mesh").fills(SHARES);
    toon_params = Pass::transfer("blur.toon").updates::<ToonParams>(TOON_BUFFER, 1).times(DRAWN_FRAMES);
    toon_project = Pass::compute("blur.toon", &glsl::project::SHADER);
    toon_see = sampling("blur.toon", desc).times(DRAWN_FRAMES);
    toon_lines = Pass::compute("blur.toon", &glsl::toon_lines::SHADER)
        .specialise(desc.settings.toon.outline.operator.words())
        .times(DRAWN_FRAMES);
    /// Into each place.
    toon: [PassId; TOON.len()] = TOON.map(|image| toon(desc, image));
    /// Of each place.
    toon_background: [PassId; TOON.len()] = TOON.map(|image| begin(desc, image));
    /// Under them, where the host's depth may hide them.
    under = copies("blur.background", [HOST_BACKGROUND], [TARGET]);
    /// As `toon_background`, over that; none without depth.
    toon_background_depth: Vec<PassId> = match desc.depth.filter(|_| desc.toon) {
        Some(format) => TOON.map(|image| begin_behind(desc, image, format)).into(),
        None => Vec::new(),
    };
    toon_frames = from_toon("blur.frames", &FRAMES);
    /// Frames i - 1 and i + 2.
    toon_outer_frames: [PassId; 2] = OUTER_FRAMES.map(|image| from_toon("blur.frames", &[image]));
    behind = copies("blur.background", [HOST_BACKGROUND], [BACKGROUND]);
    /// Of an image that lies over one.
    frame_behind = copies("blur.background", [HOST_FRAMES[1]], [FRAMES[1]]);
    frame_background = begin(desc, FRAMES[1]);
    ghost = ghost(desc).specialise([in_screen(desc)]).times(desc.settings.ghosts.count as usize);
    ghost_blend = {
        let (vertex, fragment) = (&glsl::composite_vertex::SHADER, &glsl::ghosts_blend_fragment::SHADER);
        let pass = over_target("blur.ghosts", Topology::Quads, vertex, fragment, desc);
        pass.times(desc.settings.ghosts.count as usize)
    };
    lines_begin = Pass::transfer("blur.lines").fills(TRAILING);
    lines_choose = Pass::compute("blur.lines", &glsl::lines_choose::SHADER).times(CHOOSE_ROUNDS as usize);
    lines = {
        let (vertex, fragment) = (&glsl::lines_vertex::SHADER, &glsl::lines_fragment::SHADER);
        over_target("blur.lines", Topology::Triangles, vertex, fragment, desc).specialise([in_screen(desc)])
    };
    depth_params = Pass::transfer("blur.depth").updates::<BlurParams>(PARAMS, 1);
    depth_project = Pass::compute("blur.depth", &glsl::project::SHADER);
    depth_see = sampling("blur.depth", desc);
    /// An image that is given, and one that has been drawn.
    depth_frame: [PassId; 2] =
        [copies("blur.depth", [HOST_FRAMES[1]], [FRAMES[1]]), from_toon("blur.depth", &FRAMES[1..])];
    surface = Pass::compute("blur.depth", &glsl::surface::SHADER).specialise([u32::from(desc.layers)]);
    /// None where the host has no depth.
    depth: Option<PassId> = desc.depth.map(|format| depth(desc, format));
}

/// Triangle-id buffers and depth of frames i - 1 to i + 2.
const SEEN_FRAMES: [(ImageId, ImageId); 4] = [
    (OUTER_SEEN[0], OUTER_DEPTH[0]),
    (SEEN[0], SEEN_DEPTH[0]),
    (SEEN[1], SEEN_DEPTH[1]),
    (OUTER_SEEN[1], OUTER_DEPTH[1]),
];

/// Frames i - 1 to i + 2, as far as they are drawn.
const DRAWN_FRAMES: usize = 4;

/// Whether trajectories are straight in screen space, as a specialisation constant.
fn in_screen(desc: &Desc) -> u32 {
    u32::from(desc.settings.space == Space::Screen)
}

/// Whether what drawn frames hide is drawn, too.
fn draws_hidden(desc: &Desc) -> bool {
    desc.toon && (desc.settings.completion == Completion::Surface || desc.settings.toon.draws_smears())
}

/// Whether frames are drawn with textures, as a specialisation constant.
fn textured(desc: &Desc) -> u32 {
    u32::from(desc.texture_rows > 0)
}

/// Whether there may be ink that is drawn after the distortion.
fn inks_smears(desc: &Desc) -> bool {
    desc.toon && desc.settings.toon.inks_smears()
}

/// What is made of two colours, as a specialisation constant.
fn chooses(desc: &Desc) -> u32 {
    u32::from(desc.settings.mix == Mix::Choose)
}

fn compose(desc: &Desc) -> Pass {
    let pass = Pass::compute("blur.compose", &glsl::compose::SHADER).specialise([
        u32::from(desc.layers),
        u32::from(desc.depth.is_some()),
        chooses(desc),
        u32::from(inks_smears(desc)),
        ink_reach(&desc.settings.toon, desc.size[1]),
    ]);
    // Without ink lines are not looked at, and something else may be where they have been.
    if inks_smears(desc) { pass } else { pass.bind(glsl::compose::LINES, SAMPLE_STATES) }
}

/// How colours are completed, as a specialisation constant.
fn completion(desc: &Desc) -> u32 {
    match desc.settings.completion {
        Completion::None => 0,
        Completion::Surface => FROM_SURFACE,
        Completion::Gradient => FROM_GRADIENT,
    }
}

/// Copies of the host's buffers or images, each to an own one.
fn copies<R: Into<Resource>, const N: usize>(name: &'static str, from: [R; N], to: [R; N]) -> Pass {
    from.into_iter().zip(to).fold(Pass::transfer(name), |pass, (from, to)| pass.copies(from, to))
}

/// The distorted mesh.
fn distort(desc: &Desc, image: ImageId, depth: ImageId, extent: [u32; 2]) -> Pass {
    let dry = desc.settings.dry;
    if dry == 0.0 {
        return drawing("blur.distort", &glsl::distort_vertex::SHADER, image, depth, extent);
    }
    let raster = triangles(&glsl::distort_dry_vertex::SHADER, image, depth, extent);
    let fragment = &glsl::name_dry_fragment::SHADER;
    Pass::raster("blur.distort", Raster { fragment, ..raster }).specialise([dry.to_bits()])
}

/// Triangles by their numbers. The first of those that are equally near stays.
fn drawing(name: &'static str, vertex: &'static Shader, image: ImageId, depth: ImageId, extent: [u32; 2]) -> Pass {
    Pass::raster(name, triangles(vertex, image, depth, extent))
}

fn triangles(vertex: &'static Shader, image: ImageId, depth: ImageId, extent: [u32; 2]) -> Raster {
    let (format, blend) = (vk::Format::R32_UINT, Blend::Replace);
    Raster {
        topology: Topology::Triangles,
        vertex,
        fragment: &glsl::name_fragment::SHADER,
        colour: Some(ColourAttachment { image, format, clear: Some([0; 4]), blend }),
        depth: Some(DepthAttachment::nearest(depth)),
        extent,
    }
}

/// Depth of what the host has drawn of a frame.
fn occluders(desc: &Desc, image: ImageId, depth: ImageId) -> Pass {
    let colour = ColourAttachment { image, format: vk::Format::R32_UINT, clear: Some([0; 4]), blend: Blend::Replace };
    let raster = Raster { colour: Some(colour), ..quad(&glsl::occluders_fragment::SHADER, None, None, desc) };
    let extent = extent_of(desc, image);
    Pass::raster("blur.occluders", Raster { depth: Some(DepthAttachment::nearest(depth)), extent, ..raster })
}

/// A frame's mesh behind that.
fn behind_occluders(desc: &Desc, image: ImageId, depth: ImageId) -> Pass {
    let raster = triangles(&glsl::visibility_vertex::SHADER, image, depth, extent_of(desc, image));
    let colour = raster.colour.map(|colour| ColourAttachment { clear: None, ..colour });
    let depth = raster.depth.map(|depth| DepthAttachment { clear: None, ..depth });
    Pass::raster("blur.visibility", Raster { colour, depth, ..raster })
}

/// Size of a triangle-id buffer: what no frame brings is never drawn.
fn extent_of(desc: &Desc, image: ImageId) -> [u32; 2] {
    if desc.outer || !OUTER_SEEN.contains(&image) { desc.size } else { [1, 1] }
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

fn motion(desc: &Desc, format: vk::Format) -> Pass {
    let colour = ColourAttachment { image: MOTION, format, clear: None, blend: Blend::Replace };
    let pass = temporal("blur.motion", &glsl::motion_fragment::SHADER, colour, desc);
    pass.specialise([in_screen(desc), desc.depth.is_some().into()])
}

fn reactive(desc: &Desc, format: vk::Format) -> Pass {
    let colour = ColourAttachment { image: REACTIVE, format, clear: None, blend: Blend::Max };
    let pass = temporal("blur.reactive", &glsl::reactive_fragment::SHADER, colour, desc);
    pass.specialise([desc.depth.is_some().into()])
}

/// An output for temporal upscalers, where the host has drawn nothing nearer.
fn temporal(name: &'static str, fragment: &'static Shader, colour: ColourAttachment, desc: &Desc) -> Pass {
    let depth = desc.depth.map(|format| DepthAttachment::of_host(HOST_DEPTH, format, false));
    Pass::raster(name, Raster { colour: Some(colour), ..quad(fragment, None, depth, desc) })
}

/// Copies of drawn frames, whichever they are.
fn from_toon(name: &'static str, to: &[ImageId]) -> Pass {
    let [first, others @ ..] = TOON;
    let pass = to.iter().fold(Pass::transfer(name), |pass, to| pass.copies(first, *to));
    others.into_iter().fold(pass, |pass, image| pass.uses(image, Usage::COPY_SOURCE))
}

/// A frame from what its samples see.
fn toon(desc: &Desc, image: ImageId) -> Pass {
    let toon = &desc.settings.toon;
    let inked = u32::from(toon.outline.is_on());
    let constants = [inked, ink_reach(toon, desc.size[1]), textured(desc)];
    whole("blur.toon", &glsl::toon_fragment::SHADER, image, desc).specialise(constants)
}

/// A frame over the background, as the target's first content.
fn begin(desc: &Desc, drawn: ImageId) -> Pass {
    let fragment = &glsl::background_fragment::SHADER;
    whole("blur.background", fragment, TARGET, desc).bind(glsl::background_fragment::DRAWN, drawn)
}

/// A frame that has been drawn, over what the target has, where the host has drawn nothing nearer.
fn begin_behind(desc: &Desc, drawn: ImageId, format: DepthFormat) -> Pass {
    let depth = DepthAttachment::of_host(HOST_DEPTH, format, false);
    let raster = quad(&glsl::background_depth_fragment::SHADER, Some(TARGET), Some(depth), desc);
    let colour = raster.colour.map(|colour| ColourAttachment { blend: Blend::Over, ..colour });
    Pass::raster("blur.background", Raster { colour, ..raster }).bind(glsl::background_depth_fragment::DRAWN, drawn)
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

/// A pass that is blended over the target.
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
