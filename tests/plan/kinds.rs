//! Plans of every kind of effect, with every input that a frame may bring: each binding is bound, each step fits, is one of
//! those that its pass declares, and touches what its pass says.

use ash::vk;
use celfx::blur::{self, BlurKind};
use celfx::effect::{DeviceTraits, Effort, Kind, describe};
use celfx::flame::{self, FlameKind, ParticleInput, SceneDepth, SceneFormat};
use celfx::host::{
    Background, DepthFormat, HostBuffer, HostImage, ImageState, TemporalFormats, TemporalImages, requirements,
};
use celfx::low_level::barrier::{Barrier, Tracker, return_to};
use celfx::low_level::gpu::executor::Description;
use celfx::low_level::plan::{BufferId, Command, DescriptorKind, Kernel, Pass, Plan, Resource, Step, Topology, Usage};
use celfx::program::vignette::{self, VignetteKind};
use celfx::smoke::{self, SmokeKind, VolumeInput};
use celfx::view::{Camera, Light};

use crate::allocations::allocated;
use crate::handles::handle;

pub const SIZE: [u32; 2] = [200, 150];
pub const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
const DEPTH: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
const TRAITS: DeviceTraits = DeviceTraits { image_side: 16_384, ..DeviceTraits::LEAST };

pub fn buffer() -> HostBuffer {
    let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
    HostBuffer { buffer: handle(), offset: 0, size: u64::MAX, stage, access }
}

pub fn image(format: vk::Format) -> HostImage {
    let state = ImageState { layout: vk::ImageLayout::GENERAL, ..ImageState::default() };
    let (image, view) = (handle(), handle());
    HostImage::new(image, view, format, SIZE, state, state)
}

/// Both outputs for temporal upscalers, or none.
fn temporal(is_asked: bool) -> (TemporalFormats, TemporalImages) {
    let formats = [vk::Format::R16G16_SFLOAT, vk::Format::R8_UNORM].map(|format| is_asked.then_some(format));
    let [motion, reactive] = formats.map(|format| format.map(image));
    (TemporalFormats { motion: formats[0], reactive: formats[1] }, TemporalImages { motion, reactive, previous: None })
}

fn depth() -> HostImage {
    image(DEPTH.format)
}

/// A mesh with all that one may have.
pub fn mesh() -> blur::TopologyInput {
    let groups = blur::GroupInput { corners: buffer(), starts: buffer(), triangles: buffer() };
    blur::TopologyInput {
        triangles: buffer(),
        neighbour_starts: buffer(),
        neighbours: buffer(),
        groups: Some(groups),
        colours: Some(buffer()),
        textures: None,
        shares: Some(buffer()),
        parts: None,
        source_rows: None,
        sizes: None,
    }
}

pub fn clusters() -> blur::ClusterInput {
    let [motion, labels, clusters, bounds, seams, fronts] = [buffer(); 6];
    blur::ClusterInput { motion, labels, clusters, bounds, seams, fronts }
}

/// Where trajectories begin and end, of as many segments as an effect has.
pub fn segments(desc: &blur::Desc) -> Vec<blur::motion::Segment> {
    (0..desc.segments).map(|s| blur::motion::Segment { begin: -(s as f32), end: 1.0 - s as f32 }).collect()
}

fn backgrounds() -> [Background; 3] {
    [Background::Keep, Background::Clear([0.5; 4]), Background::Copy(image(FORMAT))]
}

/// Plans the frames one after the other, as they follow each other, and checks each.
fn check<K: Kind>(desc: &K::Desc, frames: &[K::Frame<'_>]) {
    let mut kind = K::new(desc, &TRAITS, Effort::Needed).expect("it can be made");
    let description = describe(&mut kind, desc, Effort::Needed);
    let mut plan = Plan::for_passes(&description.passes);
    bound(&description);
    // What begins in a frame's middle has no layout to begin with.
    let later = description.overlays.iter().flat_map(|overlay| overlay.iter().skip(1).flatten());
    assert!({ later }.all(|resource| matches!(resource, Resource::Buffer(_))), "{desc:?}");
    for frame in frames {
        plan.clear();
        let before = allocated();
        let recorded = kind.plan(desc, frame, &mut plan).expect("a frame");
        assert_eq!(allocated() - before, 0, "planning allocates: {desc:?}");
        kind.recorded(desc, recorded);
        assert!(plan.skipped.iter().all(|(_, reason)| !reason.is_empty()));
        declared(&plan, &description);
        plan.steps.iter().for_each(|step| fits(step, &description));
        covered(&plan, &description);
        let returned = return_to(&plan, &description.passes, &description.overlays);
        assert_eq!(returned, None, "it is used after what lies there later: {desc:?}");
    }
}

fn bound(description: &Description) {
    let count = allocated();
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert!(allocated() > count, "allocations are not counted");
    for pass in &description.passes {
        assert_eq!(pass.unbound().map(|binding| binding.name).collect::<Vec<_>>(), [""; 0], "{}", pass.name);
        for (binding, resource) in &pass.bindings {
            let is_given = |id: &BufferId| description.bound.iter().any(|(bound, _)| bound == id);
            let own = match resource {
                Resource::Buffer(id) => usize::from(id.0) < description.buffers.len() || is_given(id),
                Resource::Image(id) => usize::from(id.0) < description.images.len(),
            };
            assert!(own, "{}: {} is bound to {resource:?}", pass.name, binding.name);
            assert!(pass.uses.iter().any(|(used, _)| used == resource), "{}: {}", pass.name, binding.name);
        }
        let mut numbers: Vec<_> = pass.bindings.iter().map(|(binding, _)| binding.number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), pass.bindings.len(), "{}: two resources at one binding", pass.name);
        // What every device has for a stage (`requirements`).
        let is_storage = |kind| kind == DescriptorKind::StorageBuffer;
        let storage = pass.bindings.iter().filter(|(binding, _)| is_storage(binding.kind)).count() as u32;
        let most = requirements().limits.max_per_stage_descriptor_storage_buffers;
        assert!(storage <= most, "{}: {storage} storage buffers", pass.name);
    }
}

fn declared(plan: &Plan, description: &Description) {
    for (id, pass) in description.passes.iter().enumerate() {
        let steps = plan.steps.iter().filter(|step| usize::from(step.pass.0) == id).count();
        assert!(steps <= pass.most_steps, "{}: {steps} steps, {} declared", pass.name, pass.most_steps);
    }
    let bytes: usize = description.passes.iter().map(|pass| pass.most_bytes).sum();
    assert!(plan.data.len() <= bytes, "{} bytes, {bytes} declared", plan.data.len());
}

fn fits(step: &Step, description: &Description) {
    let pass = &description.passes[usize::from(step.pass.0)];
    let pushed = pass.shaders().into_iter().flatten().map(|shader| shader.push_size).max().unwrap_or(0);
    assert_eq!(step.constants_len as u32, pushed, "{}: push constants", pass.name);
    let size =
        |id: celfx::low_level::plan::BufferId| description.buffers.get(usize::from(id.0)).map_or(u64::MAX, |b| b.size);
    let fits = match (&pass.kernel, step.command) {
        // Every device can dispatch 65,535 workgroups along an axis, and many no more.
        (Kernel::Compute(shader), Command::Dispatch { threads }) => {
            (0..3).all(|axis| (1..=65_535).contains(&threads[axis].div_ceil(shader.local_size[axis])))
        }
        (Kernel::Compute(_), Command::DispatchIndirect { arguments, offset }) => offset + 12 <= size(arguments),
        (Kernel::Raster(_), Command::DrawIndirect { arguments, offset }) => offset + 16 <= size(arguments),
        (Kernel::Raster(raster), Command::Draw { vertices }) => match raster.topology {
            Topology::Triangles => vertices % 3 == 0,
            Topology::Quads => vertices == 4,
        },
        // vkCmdUpdateBuffer takes multiples of 4 up to 64 KiB.
        (Kernel::Transfer, Command::Update { buffer, bytes, .. }) => {
            bytes as u64 <= size(buffer) && bytes <= 65_536 && bytes % 4 == 0
        }
        (Kernel::Transfer, Command::CopyBuffer { to, bytes, .. }) => bytes <= size(to),
        (Kernel::Transfer, Command::CopyRange { to, bytes, .. }) => to.1 + bytes <= size(to.0),
        (Kernel::Transfer, Command::CopyDepth { to, extent: [width, height], .. }) => {
            4 * u64::from(width) * u64::from(height) <= size(to)
        }
        (Kernel::Transfer, Command::Fill { .. } | Command::Clear { .. } | Command::CopyImage { .. }) => true,
        _ => false,
    };
    assert!(fits, "{}: {:?}", pass.name, step.command);
    for resource in touched(step) {
        assert!(pass.uses.iter().any(|(used, _)| *used == resource), "{}: {resource:?}", pass.name);
    }
}

/// What a transfer touches; nothing of other steps.
fn touched(step: &Step) -> Vec<Resource> {
    match step.command {
        Command::Fill { buffer, .. } | Command::Update { buffer, .. } => vec![buffer.into()],
        Command::CopyBuffer { from, to, .. } => vec![from.into(), to.into()],
        Command::CopyRange { from, to, .. } => vec![from.0.into(), to.0.into()],
        Command::CopyImage { from, to, .. } => vec![from.into(), to.into()],
        Command::CopyDepth { from, to, .. } => vec![from.into(), to.into()],
        Command::Clear { image, .. } => vec![image.into()],
        _ => vec![],
    }
}

/// What a step uses waits for the last write of it, a write for what was read before it, and what lies where something else has
/// lain for all uses of that.
fn covered(plan: &Plan, description: &Description) {
    let buffers = description.buffers.len() + description.host_buffers;
    let images = description.images.len() + description.host_images;
    let mut tracker = Tracker::new(buffers, images).with_overlays(&description.overlays);
    let before = allocated();
    tracker.begin(plan, &description.passes);
    for index in 0..plan.steps.len() {
        std::hint::black_box(tracker.before(plan, index, &description.passes));
    }
    assert_eq!(allocated() - before, 0, "barriers allocate");
    tracker.begin(plan, &description.passes);
    let mut touched: std::collections::HashMap<Resource, Vec<(usize, Usage)>> = Default::default();
    let mut barriers: Vec<Barrier> = Vec::new();
    for (index, step) in plan.steps.iter().enumerate() {
        let pass = &description.passes[usize::from(step.pass.0)];
        barriers.push(tracker.before(plan, index, &description.passes));
        for (resource, usage) in uses(step, pass) {
            let is_own = |other: &Resource| *other == resource;
            let lain = description.overlays.iter().filter_map(|overlay| {
                let own = overlay.iter().position(|group| group.contains(&resource))?;
                Some(overlay[..own].iter().flatten().copied())
            });
            let others: Vec<Resource> = lain.flatten().chain([resource]).collect();
            let earlier = others.iter().flat_map(|other| {
                let uses = touched.get(other).into_iter().flatten();
                uses.filter(|(_, before)| !is_own(other) || !(before.writes | usage.writes).is_empty())
            });
            for (since, other) in earlier {
                let is_covered = barriers[since + 1..].iter().any(|barrier| {
                    barrier.src_stage.contains(other.stage)
                        && barrier.src_access.contains(other.writes)
                        && barrier.dst_stage.contains(usage.stage)
                        && barrier.dst_access.contains(usage.access())
                });
                assert!(is_covered, "{} at step {index} does not wait for {resource:?}", pass.name);
            }
        }
        for (resource, usage) in uses(step, pass) {
            touched.entry(resource).or_default().push((index, usage));
        }
    }
}

/// What a step touches.
fn uses(step: &Step, pass: &Pass) -> Vec<(Resource, Usage)> {
    let of_command = touched(step);
    let indirect = step.arguments().map(|id| (Resource::Buffer(id), Usage::INDIRECT));
    let all = pass.uses.iter().copied().chain(indirect);
    all.filter(|(resource, _)| of_command.is_empty() || of_command.contains(resource)).collect()
}

#[test]
fn smoke_with_everything_that_a_frame_may_bring() {
    use smoke::settings::{Grow, Shadow};
    for desc in super::combinations() {
        let shadows = desc.settings.shadow == Shadow::Exact && desc.settings.grow == Grow::Chosen;
        for has_depth in if shadows { &[false, true][..] } else { &[true][..] } {
            let (size, target_format, depth_format) = (SIZE, FORMAT, has_depth.then_some(DEPTH));
            let (formats, outputs) = temporal(*has_depth);
            let desc = smoke::Desc {
                temporal: formats,
                size,
                target_format,
                depth: depth_format,
                edges: *has_depth,
                ..desc.clone()
            };
            let volume = VolumeInput {
                dimensions: desc.dimensions,
                voxel_size: [0.1; 3],
                origin: [0.0; 3],
                density: buffer(),
                velocity: desc.velocity.then(buffer),
            };
            let mut light = Light::default();
            if desc.point_light {
                light.source = celfx::view::LightSource::Position(glam::DVec3::splat(9.0));
            }
            let first = smoke::Frame {
                sequence: smoke::Sequence::Restart,
                dt: 0.04,
                view: Camera::default().view(SIZE),
                light,
                fire: None,
                volume: Some(volume),
                target: Some(image(FORMAT)),
                background: Background::Keep,
                depth: has_depth.then(depth),
                edges: has_depth.then(buffer),
                temporal: outputs,
            };
            let next = smoke::Frame { sequence: smoke::Sequence::Advance, volume: None, edges: None, ..first };
            let unseen = smoke::Frame { target: None, temporal: TemporalImages::default(), ..next };
            let mut frames = vec![first, next, unseen];
            frames.extend(backgrounds().map(|background| smoke::Frame { background, ..next }));
            frames.push(smoke::Frame { sequence: smoke::Sequence::Hold, ..first });
            let previous = outputs.motion.map(|_| first.view);
            let temporal = TemporalImages { previous, ..outputs };
            frames.push(smoke::Frame { sequence: smoke::Sequence::Again, temporal, ..first });
            check::<SmokeKind>(&desc, &frames);
        }
    }
}

#[test]
fn flame_with_everything_that_a_frame_may_bring() {
    use flame::settings::{Embers, Glow, Look, Method, Mode, Shape};
    let scenes = [
        (None, None),
        (Some(SceneFormat::Buffer), Some(SceneDepth::Buffer(buffer()))),
        (Some(SceneFormat::Image(DEPTH)), Some(SceneDepth::Image(depth()))),
    ];
    for (mode, method, adaptive, particles) in [
        (Mode::Stochastic, Method::Tiles, 0.0, 500),
        (Mode::Stochastic, Method::Tiles, 0.1, 500),
        // So many that their lists are worked on in parts.
        (Mode::Stochastic, Method::Tiles, 0.0, 200_000),
        (Mode::Stochastic, Method::Raster, 0.0, 500),
        (Mode::Expected, Method::Tiles, 0.0, 500),
        (Mode::Expected, Method::Tiles, 0.0, 20_000),
    ] {
        for (shape, layers) in [(Shape::Ball, true), (Shape::Cube, false)] {
            for (format, scene) in scenes {
                let spread = Some(0.1);
                let settings =
                    flame::Settings { mode, method, adaptive, shape, spread, light: 0.5, ..Default::default() };
                let glow = Glow { strength: 1.0, ..Glow::default() };
                let embers = Embers { share: 0.1, ..Embers::default() };
                let settings = match layers {
                    true => flame::Settings { stretch: 0.1, glow, embers, ..settings },
                    false => {
                        flame::Settings { look: if particles == 500 { Look::Light } else { Look::Cel }, ..settings }
                    }
                };
                let hottest = settings.hottest;
                let (formats, outputs) = temporal(layers);
                let desc = flame::Desc {
                    size: SIZE,
                    lines: None,
                    target_format: FORMAT,
                    scene: format,
                    accumulates: true,
                    particles,
                    hottest,
                    seed: 1,
                    settings,
                    layers,
                    temporal: formats,
                };
                let input = ParticleInput {
                    count: particles,
                    hottest,
                    position_temperature: buffer(),
                    ids: Some(buffer()),
                    previous: layers.then(buffer),
                    velocity: layers.then(buffer),
                };
                let first = flame::Frame {
                    view: Camera::default().view(SIZE),
                    particles: Some(input),
                    spread: None,
                    number: 3,
                    accumulate: false,
                    target: image(FORMAT),
                    background: Background::Keep,
                    scene,
                    temporal: outputs,
                };
                let next = flame::Frame { particles: None, accumulate: adaptive == 0.0, ..first };
                let none = flame::Frame { particles: Some(ParticleInput { count: 0, ids: None, ..input }), ..first };
                let mut frames = vec![first, next, none, first];
                frames.extend(backgrounds().map(|background| flame::Frame { background, ..first }));
                check::<FlameKind>(&desc, &frames);
            }
        }
    }
}

#[test]
fn blur_with_everything_that_a_frame_may_bring() {
    use blur::settings::{Completion, Ghosts, Lines, Refine, Space};
    let knots = [blur::Knot {
        view: blur::FrameView { frame: 1, view: Camera::default().view(SIZE) },
        weights: [[0.0; 4]; 12],
    }; 26];
    let camera = Camera { eye: glam::DVec3::new(0.0, 1.0, 4.0), ..Camera::default() };
    let view = |frame| blur::FrameView { frame, view: camera.view(SIZE) };
    let toon = Some(blur::ToonInput { view: view(2), light: Light::default() });
    for completion in [Completion::Surface, Completion::Gradient, Completion::None] {
        for (has_depth, layers, strength, behind) in [
            (true, true, 1.0, true),
            (false, false, 2.5, false),
            (true, false, 0.0, false),
            (true, false, 1.0, false),
            (false, false, 1.0, true),
        ] {
            let mut settings = blur::Settings { completion, strength, ..Default::default() };
            if behind {
                settings.lines = Lines { count: 3, length: 0.4, ..Lines::default() };
                settings.ghosts = Ghosts { count: 2, step: 0.2, ..Ghosts::default() };
            } else {
                (settings.space, settings.refine) = (Space::Screen, Refine::Length);
            }
            let (formats, outputs) = temporal(has_depth);
            let desc = blur::Desc {
                texture_rows: 0,
                occluders: has_depth.then_some(DEPTH),
                size: SIZE,
                target_format: FORMAT,
                points: 1000,
                triangles: 1900,
                neighbours: 5800,
                surfaces: 3,
                groups: 1100,
                group_triangles: 5700,
                outer: true,
                toon: true,
                depth: has_depth.then_some(DEPTH),
                most_triangles: 100_000,
                segments: blur::Desc::segments_of(&settings),
                frames_resident: 26,
                parts: None,
                sources: Vec::new(),
                seed: 0,
                settings,
                layers,
                temporal: formats,
            };
            let segments = segments(&desc);
            let interval = blur::IntervalInput {
                counts: blur::Counts { clusters: 3, bounds: 100, seams: 7, farthest: 500.0, ..Default::default() },
                segments: &segments,
                views: [view(0), view(1), view(2), view(3)],
                trajectories: blur::Trajectories::Pieces(buffer()),
                clusters: Some(clusters()),
            };
            let host = blur::DepthInput { host: depth(), view: view(2) };
            let first = blur::Frame {
                mesh: Some(mesh()),
                poses: Some(blur::PoseInput { first: 0, count: 26, positions: buffer() }),
                skinned: None,
                interval: Some(interval),
                images: Some([image(FORMAT); 2]),
                toon: None,
                occluders: [has_depth.then(depth); 4],
                outer: [Some(image(FORMAT)); 2],
                target: image(FORMAT),
                depth: has_depth.then_some(host),
                background: Background::Keep,
                temporal: outputs,
            };
            let given = blur::Frame { mesh: None, poses: None, ..first };
            let drawn = blur::Frame { images: None, toon, outer: [None; 2], occluders: [None; 4], ..given };
            let posed = blur::IntervalInput {
                trajectories: blur::Trajectories::Poses(&knots),
                counts: blur::Counts { seams: 0, ..interval.counts },
                ..interval
            };
            let mut frames = vec![first, given, drawn, drawn];
            frames.extend([given, drawn].map(|frame| blur::Frame { interval: Some(posed), ..frame }));
            // Poses that go around.
            let poses = Some(blur::PoseInput { first: 16, count: 20, positions: buffer() });
            let still = blur::FrameView { frame: 20, view: camera.view(SIZE) };
            let toon = Some(blur::ToonInput { view: still, light: Light::default() });
            let depth = has_depth.then_some(blur::DepthInput { view: still, ..host });
            let around = blur::Frame { poses, interval: None, toon, depth, ..drawn };
            for background in backgrounds() {
                frames.extend([given, drawn].map(|frame| blur::Frame { background, ..frame }));
                frames.extend([given, drawn].map(|frame| blur::Frame { background, interval: None, ..frame }));
            }
            frames.push(around);
            check::<BlurKind>(&desc, &frames);
        }
    }
}

#[test]
fn blur_of_parts_and_of_poses_on_the_device() {
    let knots = [blur::Knot {
        view: blur::FrameView { frame: 1, view: Camera::default().view(SIZE) },
        weights: [[0.0; 4]; 12],
    }; 4];
    let view = |frame| blur::FrameView { frame, view: Camera::default().view(SIZE) };
    let sizes = blur::parts::PartSizes { parts: 3, chunks: 5, seams: 40, most_neighbours: 8 };
    let source = blur::Source { buffer: buffer(), stride: 8, vertices: 600, points: 500 };
    let settings = blur::Settings::default();
    let desc = blur::Desc {
        target_format: FORMAT,
        points: 1000,
        triangles: 1900,
        neighbours: 5800,
        surfaces: 2,
        groups: 1100,
        group_triangles: 5700,
        toon: true,
        frames_resident: 5,
        parts: Some(sizes),
        sources: vec![source; 2],
        ..blur::Desc::new(&celfx::blur::Mesh::new(&one_triangle()).expect("a mesh"), SIZE, settings)
    };
    let parts =
        blur::PartInput { labels: buffer(), members: buffer(), chunks: buffer(), rows: buffer(), seams: buffer() };
    let topology = blur::TopologyInput { parts: Some(parts), source_rows: Some(buffer()), ..mesh() };
    let skinned = |frame| Some(blur::SkinnedInput { frame, offsets: [0; blur::MOST_SOURCES] });
    let segments = segments(&desc);
    let interval = blur::IntervalInput {
        counts: blur::Counts::of_parts(&sizes, 1),
        segments: &segments,
        views: [view(0), view(1), view(2), view(2)],
        trajectories: blur::Trajectories::Poses(&knots),
        clusters: None,
    };
    let still = blur::Frame {
        mesh: Some(topology),
        skinned: skinned(0),
        images: Some([image(FORMAT); 2]),
        ..blur::Frame::new(image(FORMAT))
    };
    let next = blur::Frame { mesh: None, skinned: skinned(1), ..still };
    let toon = Some(blur::ToonInput { view: view(2), light: Light::default() });
    let moving = blur::Frame { skinned: skinned(2), interval: Some(interval), ..next };
    let drawn = blur::Frame { skinned: skinned(3), images: None, toon, ..moving };
    check::<BlurKind>(&desc, &[still, next, moving, drawn]);
    // A dropped frame takes past poses with it: the list of views begins anew with the frame that is skinned then.
    let mut kind = BlurKind::new(&desc, &TRAITS, Effort::Needed).expect("it can be made");
    let mut plan = Plan::for_passes(&describe(&mut kind, &desc, Effort::Needed).passes);
    let mut planned = |kind: &mut BlurKind, frame: &blur::Frame| {
        plan.clear();
        kind.plan(&desc, frame, &mut plan).map(|recorded| kind.recorded(&desc, recorded))
    };
    [still, next, moving].iter().for_each(|frame| planned(&mut kind, frame).expect("a frame"));
    kind.forget();
    let interval = blur::IntervalInput { views: [view(1), view(2), view(3), view(3)], ..interval };
    let lost = blur::Frame { skinned: skinned(3), interval: Some(interval), ..still };
    let said = planned(&mut kind, &lost).expect_err("poses that are gone").to_string();
    let expected =
        "poses: that of frame 1 is needed and not on the device, which keeps 5: begin the list of views anew";
    assert!(said.starts_with(expected), "{said}");
    planned(&mut kind, &blur::Frame { interval: None, ..lost }).expect("a frame");
    let knots = [3, 4].map(|frame| blur::Knot { view: view(frame), ..knots[0] });
    let trajectories = blur::Trajectories::Poses(&knots);
    let interval = blur::IntervalInput { views: [view(3), view(3), view(4), view(4)], trajectories, ..interval };
    let after = blur::Frame { skinned: skinned(4), interval: Some(interval), ..next };
    planned(&mut kind, &after).expect("a frame");
}

fn one_triangle() -> blur::MeshInput<'static> {
    blur::MeshInput { vertices: 3, triangles: &[[0, 1, 2]], objects: None, weld: None, normals: None, rest: None }
}

/// An effect that the engine does not know is planned as the others are.
#[test]
fn vignette() {
    for strength in [0.0, 0.5] {
        let desc = vignette::Desc { size: SIZE, target_format: FORMAT, strength, radius: 0.5 };
        check::<VignetteKind>(&desc, &[image(FORMAT), image(FORMAT)]);
    }
}
