//! Plans and barriers, without a device.
#![cfg(feature = "cli")]

#[path = "common/allocations.rs"]
mod allocations;
#[path = "plan/commands.rs"]
mod commands;
#[path = "common/handles.rs"]
mod handles;
#[path = "plan/kinds.rs"]
mod kinds;

use ash::vk;
use celfx::effect::{DeviceTraits, Effort};
use celfx::host::{HostImage, ImageState};
use celfx::low_level::barrier::{Barrier, Tracker, return_to};
use celfx::low_level::plan::{BufferId, Command, ImageId, Kernel, Pass, PassId, Plan, Resource, Usage};
use celfx::low_level::shaders::smoke as glsl;
use celfx::low_level::smoke::layout::Layout;
use celfx::low_level::smoke::params::SmokeParams;
use celfx::low_level::smoke::passes::Passes;
use celfx::low_level::smoke::steps::{FrameDelta, Steps};
use celfx::low_level::smoke::tables::Tables;
use celfx::smoke::settings::{Grow, Integrator, LINES, Operator, Outline, Radius, RadiusFrom, Shadow};
use celfx::smoke::{Background, Desc, Frame, Sequence, Settings, Shape};
use celfx::view::{Camera, Light};

const TRAITS: DeviceTraits = DeviceTraits::LAVAPIPE;
const A: BufferId = BufferId(0);
const B: BufferId = BufferId(1);

fn usage(stage: vk::PipelineStageFlags2, reads: bool, writes: bool) -> Usage {
    let flag = |on: bool, access| if on { access } else { vk::AccessFlags2::NONE };
    let reads = flag(reads, vk::AccessFlags2::SHADER_STORAGE_READ);
    Usage { stage, reads, writes: flag(writes, vk::AccessFlags2::SHADER_STORAGE_WRITE) }
}

const COMPUTE: vk::PipelineStageFlags2 = vk::PipelineStageFlags2::COMPUTE_SHADER;
const FRAGMENT: vk::PipelineStageFlags2 = vk::PipelineStageFlags2::FRAGMENT_SHADER;

fn read(buffer: BufferId) -> Pass {
    Pass::transfer("read").uses(buffer, usage(COMPUTE, true, false))
}

fn write(buffer: BufferId) -> Pass {
    Pass::transfer("write").uses(buffer, usage(COMPUTE, false, true))
}

fn fragment_read(buffer: BufferId) -> Pass {
    Pass::transfer("fragment read").uses(buffer, usage(FRAGMENT, true, false))
}

/// A plan of these passes, one after the other.
fn in_order(passes: &[Pass]) -> Plan {
    let mut plan = Plan::default();
    (0..passes.len()).for_each(|i| plan.step(PassId(i as u16), Command::Dispatch { threads: [1; 3] }));
    plan
}

/// Barriers of a plan.
fn derived(tracker: &mut Tracker, plan: &Plan, passes: &[Pass]) -> Vec<Barrier> {
    (0..plan.steps.len()).map(|index| tracker.before(plan, index, passes)).collect()
}

/// Derived barriers of passes that run one after the other.
fn barriers(passes: &[Pass]) -> Vec<Barrier> {
    let plan = in_order(passes);
    let mut tracker = Tracker::new(2, 1);
    tracker.begin(&plan, passes);
    let found = derived(&mut tracker, &plan, passes);
    assert_eq!(tracker.count() as usize, found.iter().filter(|barrier| !barrier.is_empty()).count());
    found
}

/// Which passes have a barrier before them.
fn waiting(passes: &[Pass]) -> Vec<usize> {
    let found = barriers(passes).into_iter().enumerate();
    found.filter(|(_, barrier)| !barrier.is_empty()).map(|(index, _)| index).collect()
}

#[test]
fn writes_are_waited_for_and_made_visible() {
    let found = barriers(&[write(A), read(A)]);
    let expected = Barrier {
        src_stage: COMPUTE,
        src_access: vk::AccessFlags2::SHADER_STORAGE_WRITE,
        dst_stage: COMPUTE,
        dst_access: vk::AccessFlags2::SHADER_STORAGE_READ | vk::AccessFlags2::SHADER_STORAGE_WRITE,
    };
    assert_eq!(found[1], expected, "read after write");
    assert_eq!(waiting(&[write(A), write(A)]), [0, 1], "write after write");
}

#[test]
fn reads_are_waited_for_before_a_write_and_not_made_available() {
    let found = barriers(&[read(A), fragment_read(A), write(A)]);
    assert!(!found[0].is_empty() && found[1].is_empty());
    assert_eq!((found[2].src_stage, found[2].src_access), (COMPUTE | FRAGMENT, vk::AccessFlags2::NONE));
    assert!(found[2].dst_stage.contains(COMPUTE));
}

#[test]
fn one_barrier_orders_all_before_it_with_all_after_it() {
    // Readers of one stage and another, of one buffer and another.
    let passes = [write(A), write(B), read(A), read(A), read(B), fragment_read(A), fragment_read(B), read(A)];
    assert_eq!(waiting(&passes), [0, 2]);
    assert_eq!(barriers(&passes)[2].dst_stage, COMPUTE | FRAGMENT, "all that comes after it");
    // Steps that touch nothing in common.
    assert_eq!(waiting(&[write(A), write(B)]), [0]);
    // A reader before a barrier is not waited for again.
    assert_eq!(waiting(&[write(A), read(A), write(B), read(B), write(A)]), [0, 1, 3]);
    assert_eq!(waiting(&[write(A), fragment_read(A), read(A), write(A), read(A)]), [0, 1, 3, 4]);
}

/// What lies where something else has lain waits for all that was done there; what lies elsewhere does not.
#[test]
fn what_lies_in_the_same_place_waits() {
    for passes in [[read(A), write(B)], [write(A), write(B)], [write(A), read(B)]] {
        let plan = in_order(&passes);
        let overlay = vec![vec![A.into()], vec![B.into()]];
        assert_eq!(return_to(&plan, &passes, std::slice::from_ref(&overlay)), None);
        let mut tracker = Tracker::new(2, 1).with_overlays(&[overlay]);
        tracker.begin(&plan, &passes);
        let found = derived(&mut tracker, &plan, &passes);
        assert!(found[1].src_stage.contains(COMPUTE) && found[1].dst_stage.contains(COMPUTE), "{found:?}");
        assert!(barriers(&passes)[1].is_empty(), "elsewhere");
    }
    let back = [write(A), write(B), read(A)];
    let overlay = vec![vec![A.into()], vec![B.into()]];
    assert_eq!(return_to(&in_order(&back), &back, &[overlay]), Some(A.into()));
}

#[test]
fn a_transfer_touches_what_its_command_does() {
    let both = Pass::transfer("fills").fills(A).fills(B);
    let passes = [both, Pass::transfer("copies").copies(A, B)];
    let mut plan = Plan::default();
    for buffer in [A, B, A] {
        plan.step(PassId(0), Command::Fill { buffer, word: 0 });
    }
    plan.step(PassId(1), Command::CopyBuffer { from: A, to: B, bytes: 4 });
    let mut tracker = Tracker::new(2, 1);
    tracker.begin(&plan, &passes);
    let found: Vec<bool> = derived(&mut tracker, &plan, &passes).iter().map(|barrier| !barrier.is_empty()).collect();
    assert_eq!(found, [true, false, true, true]);
}

#[test]
fn indirect_arguments_are_read_at_their_own_stage() {
    let passes = [write(A), Pass::transfer("indirect").uses(B, usage(COMPUTE, false, true))];
    let mut plan = Plan::default();
    plan.step(PassId(0), Command::Dispatch { threads: [1; 3] });
    plan.step(PassId(1), Command::DispatchIndirect { arguments: A, offset: 0 });
    plan.step(PassId(0), Command::Dispatch { threads: [1; 3] });
    let mut tracker = Tracker::new(2, 1);
    tracker.begin(&plan, &passes);
    let found = derived(&mut tracker, &plan, &passes);
    assert!(found[0].dst_stage.contains(vk::PipelineStageFlags2::DRAW_INDIRECT));
    assert!(found[1].dst_stage.contains(vk::PipelineStageFlags2::DRAW_INDIRECT));
    assert!(found[1].dst_access.contains(vk::AccessFlags2::INDIRECT_COMMAND_READ));
    // The arguments are written again: their reader is waited for.
    assert!(found[2].src_stage.contains(vk::PipelineStageFlags2::DRAW_INDIRECT));
}

#[test]
fn a_frame_waits_for_the_one_before_and_for_the_host() {
    let image = Pass::transfer("image").uses(ImageId(0), Usage::COLOUR);
    let passes = [write(A), fragment_read(A), image];
    let plan = in_order(&passes[..1]);
    let mut tracker = Tracker::new(2, 1);
    tracker.begin(&plan, &passes);
    tracker.take_buffer(vk::PipelineStageFlags2::HOST, vk::AccessFlags2::HOST_WRITE);
    let found = tracker.before(&plan, 0, &passes);
    // All that the effect's passes may have done, whether this frame does it or not.
    let stages = COMPUTE | FRAGMENT | vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT;
    assert_eq!(found.src_stage, stages | vk::PipelineStageFlags2::HOST);
    let writes = vk::AccessFlags2::SHADER_STORAGE_WRITE | vk::AccessFlags2::COLOR_ATTACHMENT_WRITE;
    assert_eq!((found.src_access, found.dst_stage), (writes | vk::AccessFlags2::HOST_WRITE, COMPUTE));
}

/// Images of the host's come in its states, have the layout of each use, and go back in its states.
#[test]
fn images_of_the_host_change_with_barriers() {
    const TARGET: ImageId = ImageId(0);
    let passes = [write(A), Pass::transfer("clear").fills(B).copies(ImageId(1), TARGET), {
        Pass::transfer("draw").uses(TARGET, Usage::COLOUR)
    }];
    let mut plan = Plan::default();
    plan.step(PassId(0), Command::Dispatch { threads: [1; 3] });
    plan.step(PassId(1), Command::Clear { image: TARGET, value: [0; 4], extent: [1, 1] });
    plan.step(PassId(2), Command::Draw { vertices: 4 });
    plan.step(PassId(1), Command::CopyImage { from: TARGET, to: ImageId(1), extent: [1, 1] });
    let state = |layout| ImageState { stage: FRAGMENT, access: vk::AccessFlags2::SHADER_SAMPLED_READ, layout };
    let (colour, copied) = (vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    for layout in [vk::ImageLayout::UNDEFINED, colour, copied] {
        let mut tracker = Tracker::new(2, 2);
        tracker.begin(&plan, &passes);
        tracker.take_image(TARGET, state(layout));
        let mut layouts = Vec::new();
        for index in 0..plan.steps.len() {
            let barrier = tracker.before(&plan, index, &passes);
            assert!(tracker.changes().is_empty() || !barrier.is_empty());
            let of_target = || tracker.changes().iter().filter(|change| change.image == TARGET);
            layouts.push(of_target().map(|change| (change.from.layout, change.to.layout)).collect::<Vec<_>>());
            assert!(index > 0 || barrier.src_stage.contains(FRAGMENT), "the host's own use of it is waited for");
        }
        let first = if layout == colour { vec![] } else { vec![(layout, colour)] };
        assert_eq!(layouts, [first, vec![], vec![], vec![(colour, copied)]], "{layout:?}");
        let back = state(vk::ImageLayout::GENERAL);
        assert!(!tracker.end([(TARGET, back)].into_iter()).is_empty());
        let of_target = tracker.changes().iter().filter(|change| change.image == TARGET);
        assert_eq!(of_target.map(|change| change.to).collect::<Vec<_>>(), [back]);
        // The first, the draw's (the same target again), the copy's and the last.
        assert_eq!(tracker.count(), 4);
    }
}

/// Copies in a row change their images at once, but an image that is written and then read does so twice.
#[test]
fn copies_in_a_row_share_a_barrier() {
    let [a, b, c] = [0, 1, 2].map(ImageId);
    let pass = Pass::transfer("copies").copies(a, b).copies(b, c).copies(a, c).fills(A);
    let copies = |pairs: &[(ImageId, ImageId)]| {
        let mut plan = Plan::default();
        plan.step(PassId(0), Command::Fill { buffer: A, word: 0 });
        // An image's first use is the frame's beginning: here that is as a source.
        plan.step(PassId(0), Command::CopyImage { from: b, to: a, extent: [1, 1] });
        pairs
            .iter()
            .for_each(|(from, to)| plan.step(PassId(0), Command::CopyImage { from: *from, to: *to, extent: [1, 1] }));
        let passes = std::slice::from_ref(&pass);
        let mut tracker = Tracker::new(2, 3);
        tracker.begin(&plan, passes);
        let mut changes = Vec::new();
        for index in 0..plan.steps.len() {
            tracker.before(&plan, index, passes);
            let mut images: Vec<_> = tracker.changes().iter().map(|change| change.image.0).collect();
            images.sort_unstable();
            assert!(images.windows(2).all(|pair| pair[0] != pair[1]), "an image changes twice in a barrier");
            changes.push(images);
        }
        changes
    };
    assert_eq!(copies(&[(a, c), (a, c)]), [vec![0, 1, 2], vec![], vec![0], vec![]]);
    assert_eq!(copies(&[(a, b), (b, c)]), [vec![0, 1, 2], vec![], vec![0, 1], vec![1]]);
}

#[test]
fn a_binding_is_bound_once_and_used_as_each_stage_says() {
    let seen = glsl::tiles::SEEN;
    let pass = Pass::compute("tiles", &glsl::tiles::SHADER).bind(seen, ImageId(0)).bind(seen, ImageId(0));
    assert_eq!(pass.bindings.len(), 1, "the same binding twice is one descriptor");
    let unbound: Vec<_> = pass.unbound().map(|binding| binding.name).collect();
    assert_eq!(unbound, ["SmokeParams", "BlockMasks", "TileGroups"]);
    let (resource, usage) = pass.uses[0];
    assert_eq!((resource, usage.writes), (Resource::Image(ImageId(0)), vk::AccessFlags2::NONE));
    assert_eq!((usage.stage, usage.reads), (COMPUTE, vk::AccessFlags2::SHADER_STORAGE_READ));
}

fn desc(settings: Settings) -> Desc {
    let new = Desc::new([200, 150], [32; 3], settings);
    Desc { lines: Some(LINES), target_format: vk::Format::R8G8B8A8_SRGB, velocity: true, ..new }
}

/// The effect's side of a frame, and a plan to be filled.
struct Effect {
    desc: Desc,
    layout: Layout,
    passes: Passes,
    tables: Tables,
    plan: Plan,
}

impl Effect {
    fn new(desc: Desc) -> Effect {
        let layout = Layout::new(&desc, &TRAITS).unwrap();
        let tables = Tables::new(&desc.settings, &layout);
        let passes = Passes::new(&desc, &layout, &tables, Effort::Needed);
        Effect { desc, layout, plan: Plan::for_passes(&passes.list), passes, tables }
    }

    fn delta(&self) -> FrameDelta {
        let shape = Shape { dimensions: self.desc.dimensions, voxel_size: [0.1; 3], origin: [0.0; 3] };
        FrameDelta {
            shape,
            restart: true,
            new_volume: true,
            stale: false,
            new_tables: true,
            still: None,
            same_shadow: None,
            view_before: None,
            moves: false,
        }
    }

    fn frame(&self) -> Frame {
        let state = ImageState { layout: vk::ImageLayout::GENERAL, ..ImageState::default() };
        let target = HostImage::new(
            vk::Image::null(),
            vk::ImageView::null(),
            self.desc.target_format,
            self.desc.size,
            state,
            state,
        );
        Frame {
            sequence: Sequence::Restart,
            dt: 0.04,
            view: Camera::default().view(self.desc.size),
            light: Light::default(),
            fire: None,
            volume: None,
            target: Some(target),
            background: Background::Clear([0.0; 4]),
            depth: None,
            edges: None,
            temporal: Default::default(),
        }
    }

    fn fill(&mut self, frame: &Frame, delta: &FrameDelta) {
        let params = SmokeParams::new(&self.desc, &self.layout, frame, &delta.shape, 0);
        let Effect { desc, layout, passes, tables, plan } = self;
        plan.clear();
        Steps { plan, passes, desc, layout, traits: &TRAITS, delta }.fill(frame, &params, tables);
    }

    /// Names of the steps, each once where it stands several times in a row.
    fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<_> =
            self.plan.steps.iter().map(|step| self.passes.list[usize::from(step.pass.0)].name).collect();
        names.dedup();
        names
    }

    fn reason(&self, name: &str) -> Option<&'static str> {
        let is_named = |pass: &PassId| self.passes.list[usize::from(pass.0)].name == name;
        self.plan.skipped.iter().find(|(pass, _)| is_named(pass)).map(|(_, reason)| *reason)
    }
}

#[test]
fn the_steps_of_a_frame_in_order() {
    // The search is named, so that the order does not hang on which is fastest for this volume. Steps that do not wait for each
    // other stand beside each other.
    let mut effect = Effect::new(desc(Settings {
        radius_from: RadiusFrom::Voxels,
        detail: Some(0.0),
        grow: Grow::Field,
        ..Settings::default()
    }));
    effect.fill(&effect.frame(), &effect.delta());
    let expected = [
        "smoke.background",
        "smoke.params",
        "smoke.tables",
        "smoke.restart",
        "smoke.shadow",
        "smoke.clear",
        "smoke.occlusion",
        "smoke.volume",
        "smoke.occupancy",
        "smoke.field",
        "smoke.occupancy",
        "smoke.field",
        "smoke.advect",
        "smoke.grow",
        "smoke.list",
        "smoke.shadow",
        "smoke.occlusion",
        "smoke.shadow",
        "smoke.occlusion",
        "smoke.shadow",
        "smoke.spheres",
        "smoke.shadow",
        "smoke.tiles",
        "smoke.luminance",
        "smoke.outline",
        "smoke.rows",
        "smoke.outline",
        "smoke.columns",
        "smoke.tone",
        "smoke.composite",
    ];
    assert_eq!(effect.names(), expected);
}

/// A frame in which `change` has been made, and the reason why `name` is not in it.
fn skipped(settings: Settings, name: &str, change: impl Fn(&mut Frame, &mut FrameDelta)) -> &'static str {
    let mut effect = Effect::new(desc(settings));
    let (mut frame, mut delta) = (effect.frame(), effect.delta());
    effect.fill(&frame, &delta);
    let before = effect.names().contains(&name);
    change(&mut frame, &mut delta);
    effect.fill(&frame, &delta);
    assert!(!effect.names().contains(&name), "{name} runs");
    let reason = effect.reason(name).unwrap_or_else(|| panic!("{name}: no reason in {:?}", effect.plan.skipped));
    assert!(!reason.is_empty());
    // Where the frame decides and not the settings, the step was there before.
    let decided_by_frame = frame.target.is_none() || delta.still.is_some() || !delta.new_volume;
    assert!(before || !decided_by_frame, "{name} never runs");
    reason
}

#[test]
fn what_is_not_needed_is_left_out_and_says_why() {
    let settings = Settings::default;
    let nothing = |_: &mut Frame, _: &mut FrameDelta| {};
    let sharp = Settings { sigma: 0.0, ..settings() };
    assert_eq!(skipped(sharp.clone(), "smoke.rows", nothing), "sigma is 0");
    assert_eq!(skipped(sharp.clone(), "smoke.columns", nothing), "sigma is 0");
    // So many groups would come in several batches.
    let many = Settings { groups: 254, ..sharp };
    assert_eq!(skipped(many, "smoke.columns", nothing), "sigma is 0");
    let outline = Outline { strength: 0.0, ..Outline::default() };
    assert_eq!(skipped(Settings { outline, ..settings() }, "smoke.outline", nothing), "strength is 0");
    let lit = Settings { shadow: Shadow::None, ..settings() };
    assert_eq!(skipped(lit, "smoke.shadow", nothing), "shadow is \"none\"");
    for name in ["smoke.volume", "smoke.detail", "smoke.occupancy"] {
        assert!(skipped(settings(), name, |_, delta| delta.new_volume = false).contains("unchanged"));
    }
    assert_eq!(skipped(settings(), "smoke.tables", |_, delta| delta.new_tables = false), "unchanged");
    for name in ["smoke.advect", "smoke.grow"] {
        assert_eq!(skipped(settings(), name, |_, delta| delta.still = Some("held")), "held");
    }
    let same = |_: &mut Frame, delta: &mut FrameDelta| delta.same_shadow = Some("same light");
    assert_eq!(skipped(settings(), "smoke.shadow", same), "same light");
    let keep = |frame: &mut Frame, _: &mut FrameDelta| frame.background = Background::Keep;
    assert_eq!(skipped(settings(), "smoke.background", keep), "the target is kept");
    for name in ["smoke.shadow", "smoke.spheres", "smoke.tiles", "smoke.luminance", "smoke.tone", "smoke.composite"] {
        assert!(skipped(settings(), name, |frame, _| frame.target = None).starts_with("no target"));
        assert_eq!(skipped(Settings { particles: 0, ..settings() }, name, nothing), "no particles");
    }
}

#[test]
fn no_particles_leave_nothing_but_the_background() {
    let mut effect = Effect::new(desc(Settings { particles: 0, ..Settings::default() }));
    effect.fill(&effect.frame(), &effect.delta());
    assert_eq!(effect.names(), ["smoke.background"]);
}

/// Descriptions that reach every pass and every variant of one.
fn combinations() -> Vec<Desc> {
    let mut all = Vec::new();
    for shadow in [Shadow::Exact, Shadow::Map, Shadow::None] {
        for (radius_from, grow, radius) in [
            (RadiusFrom::Surface, Grow::Chosen, Radius::Box),
            (RadiusFrom::Voxels, Grow::Field, Radius::Box),
            (RadiusFrom::Voxels, Grow::Pyramid, Radius::Ball),
            (RadiusFrom::Voxels, Grow::Growth, Radius::Box),
        ] {
            for (sigma, strength, operator) in
                [(4.0, 1.0, Operator::Step), (4.0, 1.0, Operator::Roberts), (0.0, 0.0, Operator::Second)]
            {
                for (flag, integrator) in [(false, Integrator::Euler), (true, Integrator::Rk2)] {
                    let outline = Outline { strength, operator, ..Outline::default() };
                    let fade = if flag { 0 } else { 6 };
                    let detail = if flag { Some(0.0) } else { None };
                    let settings = Settings {
                        detail,
                        radius_from,
                        shadow,
                        grow,
                        radius,
                        sigma,
                        outline,
                        integrator,
                        fade,
                        ..Settings::default()
                    };
                    let lit = Desc { rim: flag, second_light: flag, fire_light: flag, ..desc(settings) };
                    all.push(Desc { layers: flag, velocity: flag, point_light: flag, ..lit });
                }
            }
        }
    }
    all
}

/// Every device can dispatch 65,535 workgroups along an axis, and many no more.
#[test]
fn dispatches_stay_within_every_devices_limit() {
    for (dimensions, particles) in
        [([256; 3], 1_000_000), ([320, 320, 319], 500), ([17, 1300, 1300], 500), ([16_384, 2048, 1], 1_000_000)]
    {
        for (radius_from, grow) in [
            (RadiusFrom::Surface, Grow::Chosen),
            (RadiusFrom::Voxels, Grow::Chosen),
            (RadiusFrom::Voxels, Grow::Pyramid),
        ] {
            let settings = Settings { particles, fade: 0, radius_from, grow, ..Settings::default() };
            let mut effect = Effect::new(Desc { dimensions, velocity: false, ..desc(settings) });
            effect.fill(&effect.frame(), &effect.delta());
            for step in &effect.plan.steps {
                let pass = &effect.passes.list[usize::from(step.pass.0)];
                if let (Kernel::Compute(shader), Command::Dispatch { threads }) = (&pass.kernel, step.command) {
                    let groups = [0, 1, 2].map(|axis| threads[axis].div_ceil(shader.local_size[axis]));
                    assert!(groups.iter().all(|n| *n <= 65_535), "{}, {dimensions:?}: {groups:?} groups", shader.file);
                }
            }
        }
    }
}
