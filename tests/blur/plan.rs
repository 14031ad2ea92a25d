//! Plans, barriers and sizes of the blur, without a device.

use ash::vk;
use celfx::blur::settings::Completion;
use celfx::blur::{
    Background, Blur, ClusterInput, Counts, Desc, Frame, FrameView, GroupInput, IntervalInput, Knot, PoseInput,
    Settings, ToonInput, TopologyInput, Trajectories,
};
use celfx::effect::{DeviceTraits, Effort, Inventory};
use celfx::error::Error;
use celfx::host::{HostBuffer, HostImage, ImageState};
use celfx::low_level::blur::layout::{self, Layout};
use celfx::low_level::blur::passes::Passes;
use celfx::low_level::blur::steps::Steps;
use celfx::low_level::plan::{Command, PassId, Plan};
use celfx::low_level::shaders::blur::constants::BLOCK;
use celfx::low_level::smoke::limits::LOOP_BUDGET;
use celfx::view::{Camera, Light, LightSource};

use crate::common::handles::handle;

const TRAITS: DeviceTraits = DeviceTraits::LAVAPIPE;
fn view() -> FrameView {
    FrameView { frame: 1, view: Camera::default().view([64, 48]) }
}

fn next_view() -> FrameView {
    FrameView { frame: 2, ..view() }
}

fn toon() -> ToonInput {
    let light = Light { source: LightSource::Direction(glam::DVec3::NEG_Y), ..Light::default() };
    ToonInput { view: next_view(), light }
}

const SEGMENTS: [celfx::blur::motion::Segment; 3] = [
    celfx::blur::motion::Segment { begin: 0.0, end: 1.0 },
    celfx::blur::motion::Segment { begin: -1.0, end: 0.0 },
    celfx::blur::motion::Segment { begin: -2.0, end: -1.0 },
];

fn desc(settings: Settings) -> Desc {
    Desc {
        occluders: None,
        size: [200, 150],
        target_format: vk::Format::R32G32B32A32_SFLOAT,
        points: 1000,
        triangles: 1900,
        neighbours: 5800,
        surfaces: 3,
        groups: 1100,
        group_triangles: 5700,
        texture_rows: 0,
        outer: true,
        toon: true,
        depth: None,
        most_triangles: 1_000_000,
        segments: Desc::segments_of(&settings),
        frames_resident: 26,
        parts: None,
        sources: Vec::new(),
        seed: 0,
        settings,
        layers: true,
        temporal: Default::default(),
    }
}

fn buffer() -> HostBuffer {
    let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
    HostBuffer { buffer: handle(), offset: 0, size: u64::MAX, stage, access }
}

fn image(desc: &Desc) -> HostImage {
    let state = ImageState { layout: vk::ImageLayout::GENERAL, ..ImageState::default() };
    HostImage::new(handle(), handle(), desc.target_format, desc.size, state, state)
}

fn frame<'a>(desc: &Desc, trajectories: Trajectories<'a>, seams: u32) -> Frame<'a> {
    let counts = Counts { clusters: 3, bounds: 100, seams, farthest: 500.0, ..Counts::default() };
    Frame {
        mesh: Some(TopologyInput {
            triangles: buffer(),
            neighbour_starts: buffer(),
            neighbours: buffer(),
            groups: Some(GroupInput { corners: buffer(), starts: buffer(), triangles: buffer() }),
            colours: Some(buffer()),
            textures: None,
            shares: None,
            parts: None,
            source_rows: None,
            sizes: None,
        }),
        poses: Some(PoseInput { first: 20, count: 26, positions: buffer() }),
        skinned: None,
        interval: Some(IntervalInput {
            counts,
            segments: &SEGMENTS[..desc.segments as usize],
            views: [view(), view(), next_view(), next_view()],
            trajectories,
            clusters: Some(ClusterInput {
                motion: buffer(),
                labels: buffer(),
                clusters: buffer(),
                bounds: buffer(),
                seams: buffer(),
                fronts: buffer(),
            }),
        }),
        images: Some([image(desc); 2]),
        toon: None,
        occluders: [None; 4],
        outer: [Some(image(desc)); 2],
        target: image(desc),
        depth: None,
        background: Background::Keep,
        temporal: Default::default(),
    }
}

/// The effect's side of a frame, and a plan to be filled.
struct Effect {
    desc: Desc,
    layout: Layout,
    passes: Passes,
    plan: Plan,
}

impl Effect {
    fn new(desc: Desc) -> Effect {
        let layout = Layout::new(&desc, &TRAITS).expect("a layout");
        let passes = Passes::new(&desc, &TRAITS);
        Effect { layout, plan: Plan::for_passes(&passes.list), passes, desc }
    }

    fn fill(&mut self, frame: &Frame) {
        let Effect { desc, layout, passes, plan } = self;
        plan.clear();
        Steps { plan, passes, desc, layout, traits: &TRAITS, effort: Effort::Needed, drawn: &[None; 4] }.fill(frame);
    }

    fn skipped(&self) -> Vec<(&'static str, &'static str)> {
        let name = |(pass, reason): &(PassId, &'static str)| (self.passes.list[usize::from(pass.0)].name, *reason);
        self.plan.skipped.iter().map(name).collect()
    }

    fn names(&self) -> Vec<&'static str> {
        let name = |step: &celfx::low_level::plan::Step| self.passes.list[usize::from(step.pass.0)].name;
        let mut names: Vec<_> = self.plan.steps.iter().map(name).collect();
        names.dedup();
        names
    }
}

#[test]
fn the_steps_of_a_frame_in_order() {
    let mut effect = Effect::new(desc(Settings::default()));
    let knots = [Knot { view: view(), weights: [[0.0; 4]; 12] }; 26];
    let mut frame = frame(&effect.desc.clone(), Trajectories::Poses(&knots), 5);
    effect.fill(&frame);
    let expected = [
        "blur.background",
        "blur.mesh",
        "blur.poses",
        "blur.params",
        "blur.interval",
        "blur.tiles",
        "blur.params",
        "blur.learn",
        "blur.trajectory",
        "blur.tiles",
        "blur.params",
        "blur.trajectory",
        "blur.extent",
        "blur.seams",
        "blur.extent",
        "blur.refine",
        "blur.frames",
        "blur.visibility",
        "blur.distort",
        "blur.layers",
        "blur.tiles",
        "blur.cover",
        "blur.normals",
        "blur.learn",
        "blur.tones",
        "blur.shade",
        "blur.layers",
        "blur.complete",
        "blur.compose",
        "blur.composite",
    ];
    assert!(effect.names().starts_with(&expected), "{:?}", effect.names());
    // Where nothing moves, a copy is left.
    (frame.interval, frame.mesh, frame.poses) = (None, None, None);
    effect.fill(&frame);
    assert_eq!(effect.names(), ["blur.background"]);
    assert!(effect.plan.skipped.iter().all(|(_, reason)| !reason.is_empty()));
    assert!(effect.skipped().contains(&("blur.refine", "nothing moves")));
}

/// What completion does not need is left out, and says why.
#[test]
fn completion_is_skipped_by_name() {
    for completion in [Completion::None, Completion::Gradient] {
        let mut effect = Effect::new(desc(Settings { completion, ..Settings::default() }));
        let mut frame = frame(&effect.desc.clone(), Trajectories::Pieces(buffer()), 5);
        frame.outer = [None; 2];
        effect.fill(&frame);
        let names = effect.names();
        assert!(["blur.normals", "blur.learn", "blur.tones"].iter().all(|name| !names.contains(name)));
        let skipped: Vec<_> = effect.skipped().into_iter().map(|(name, _)| name).collect();
        assert!(["blur.normals", "blur.learn", "blur.tones"].iter().all(|name| skipped.contains(name)), "{skipped:?}");
        assert_eq!(effect.layout.tables, 0);
        // Where neither frame shows anything, colours come from neighbours, if there is such a sample.
        let inward = effect
            .plan
            .steps
            .iter()
            .filter(|step| effect.passes.list[usize::from(step.pass.0)].name == "blur.complete");
        assert!(inward.into_iter().all(|step| matches!(step.command, Command::DispatchIndirect { .. })));
    }
}

#[test]
fn frames_without_images_are_drawn() {
    let mut effect = Effect::new(desc(Settings::default()));
    let knots = [Knot { view: view(), weights: [[0.0; 4]; 12] }; 26];
    let mut frame = frame(&effect.desc.clone(), Trajectories::Poses(&knots), 5);
    (frame.images, frame.toon) = (None, Some(toon()));
    effect.fill(&frame);
    let names = effect.names();
    let place = |name: &str| names.iter().rposition(|other| *other == name);
    let order = ["blur.mesh", "blur.normals", "blur.toon", "blur.background", "blur.frames", "blur.shade"];
    assert!(order.is_sorted_by_key(|name| place(name)) && place(order[0]).is_some(), "{names:?}");
    let count = |effect: &Effect, command: fn(&Command) -> bool| {
        effect.plan.steps.iter().filter(|step| command(&step.command)).count()
    };
    let is_picture = |command: &Command| matches!(command, Command::Draw { vertices: 4 });
    assert_eq!(count(&effect, is_picture), 4, "frames i and i + 1, what the target begins with, and the composite");
    // Where nothing moves, the later one is all.
    frame.interval = None;
    effect.fill(&frame);
    assert_eq!(count(&effect, is_picture), 2);
    assert_eq!(effect.names().last(), Some(&"blur.background"));
}

#[test]
fn no_strength_is_a_copy() {
    let mut effect = Effect::new(desc(Settings { strength: 0.0, ..Settings::default() }));
    let mut frame = frame(&effect.desc.clone(), Trajectories::Pieces(buffer()), 5);
    (frame.mesh, frame.poses) = (None, None);
    effect.fill(&frame);
    assert_eq!(effect.names(), ["blur.background"]);
    assert!(effect.skipped().contains(&("blur.distort", "strength is 0")));
}

#[test]
fn poses_go_around() {
    let mut effect = Effect::new(desc(Settings::default()));
    let mut frame = frame(&effect.desc.clone(), Trajectories::Pieces(buffer()), 5);
    frame.poses = Some(PoseInput { first: 50, count: 5, positions: buffer() });
    effect.fill(&frame);
    let copies: Vec<_> = effect
        .plan
        .steps
        .iter()
        .filter_map(|step| match step.command {
            Command::CopyRange { from, to: (layout::POSES, to), bytes } => Some((from.1, to, bytes)),
            _ => None,
        })
        .collect();
    // Frames 50 and 51 stand in places 24 and 25, 52 to 54 in the first ones.
    assert_eq!(copies, [(0, 24 * 12_000, 2 * 12_000), (24_000, 0, 3 * 12_000)]);
}

#[test]
fn sizes_follow_from_counts_and_the_device() {
    let settings = Settings { strength: 3.0, ..Settings::default() };
    let desc = desc(settings);
    let layout = Layout::new(&desc, &TRAITS).expect("a layout");
    assert_eq!(desc.segments, 3);
    // Pieces of three segments, 192 bytes a vertex, are what the range has least room for.
    assert_eq!(u64::from(layout.vertices), TRAITS.storage_range / 192);
    assert_eq!(layout.triangles - desc.triangles, layout.vertices - desc.points);
    assert_eq!(layout.size(layout::POSES), 26 * 12_000);
    assert!(layout.size(layout::SPLINES) <= TRAITS.storage_range);
    let small = Desc { most_triangles: 5000, ..desc.clone() };
    let layout = Layout::new(&small, &TRAITS).expect("a layout");
    assert_eq!((layout.triangles, layout.vertices), (5000, 1000 + 3100));
    let memory = Blur::memory(&small, &TRAITS).expect("a size");
    let buffers: u64 = layout.buffers(&small).iter().map(|buffer| buffer.size).sum();
    let pixels: u64 = layout.images(&small).iter().map(|i| u64::from(i.extent[0] * i.extent[1])).sum();
    assert!(memory.total() >= buffers + 4 * pixels && memory.history >= 26 * 12_000);
}

#[test]
fn loops_stay_within_their_budget() {
    // What edges look at of hulls: `extent::new_vertices_have_the_extents_of_brute_force` has as much as there may be.
    // A prefix sum: lanes share the blocks of the most triangles that there can be, and then add each other up, three times.
    let layout = Layout::new(
        &Desc { most_triangles: 60_000_000, ..desc(Settings::default()) },
        &DeviceTraits { storage_range: u64::MAX, ..TRAITS },
    )
    .expect("a layout");
    let blocks = layout.triangles.div_ceil(BLOCK).div_ceil(BLOCK);
    assert!(blocks + 3 * BLOCK.ilog2() <= LOOP_BUDGET);
    // Around a pixel, in both frames: the widest skirt that there may be.
    let settings = Settings { skirt: 16.0, ..Settings::default() };
    let reach = 2 * settings.skirt as u32 + 1;
    assert!(settings.validate().is_ok() && 2 * (reach * reach + reach) <= LOOP_BUDGET);
    assert!(Settings { skirt: 16.1, ..settings }.validate().is_err());
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let refused = |desc: Desc| Blur::memory(&desc, &TRAITS).expect_err("refused").to_string();
    let base = || desc(Settings::default());
    assert!(refused(Desc { points: 0, ..base() }).contains("points"));
    assert!(refused(Desc { most_triangles: 10, ..base() }).contains("triangles"));
    assert!(refused(Desc { segments: 33, ..base() }).contains("segments"));
    assert!(refused(Desc { frames_resident: 3, ..base() }).contains("resident"));
    assert!(refused(Desc { size: [0, 5], ..base() }).contains("size"));
    assert!(
        refused(Desc { settings: Settings { strength: -1.0, ..Settings::default() }, ..base() })
            .contains("blur.strength")
    );
    let poses = refused(Desc { frames_resident: 1 << 20, ..base() });
    assert!(poses.contains("Poses") && poses.contains("keep fewer frames"), "{poses}");
    let Err(Error::Limit { what, .. }) = Blur::memory(
        &Desc { points: 5_000_000, frames_resident: 4, ..base() },
        &DeviceTraits { storage_range: u64::MAX, ..TRAITS },
    ) else {
        panic!("too many points");
    };
    assert_eq!(what, "blur's points");
}
