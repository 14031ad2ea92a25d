//! Cel-shaded smoke from a density volume (Hoshino, Dobashi, Yamamoto: Cartoon Rendering of Smoke).
//!
//! Spheres grow inside the thresholded volume (section 3.1), are lit and shadowed (3.2), smoothed within groups of equal
//! depth (3.3), cut into tones (3.4) and outlined from depth (3.5). [`Effect::record`] records it all into the host's
//! command buffer.

pub(crate) mod channels;
pub mod desc;
pub mod frame;
pub(crate) mod layout;
pub(crate) mod limits;
pub(crate) mod params;
pub(crate) mod passes;
#[cfg(any(test, feature = "reference"))]
pub mod reference;
pub(crate) mod search;
pub mod settings;
pub(crate) mod steps;
pub(crate) mod tables;

pub use crate::host::{Background, DepthFormat};
pub use desc::Desc;
pub use frame::{Frame, Sequence, Shape, VolumeInput};
pub use settings::Settings;

use ash::vk;

use crate::effect::{DeviceTraits, Effect, Effort, Kind};
use crate::error::{Error, Result};
use crate::gpu::resources::{Kept, Resources};
use crate::host::{HostBuffer, NamedFormat, depth_format, target_format};
use crate::plan::{BufferId, Pass, Plan};
use crate::view::{Light, View};
use layout::Layout;
use params::{HELD_RANGE, SmokeParams};
use passes::Passes;
use steps::{FrameDelta, Steps};
use tables::Tables;

/// The smoke effect.
pub type Smoke = Effect<SmokeKind>;

/// The parts that are the smoke's own.
#[derive(Debug)]
pub struct SmokeKind {
    traits: DeviceTraits,
    layout: Layout,
    passes: Passes,
    tables: Tables,
    effort: Effort,
    state: State,
}

/// State kept of the frames recorded so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// Whether a frame has been recorded.
    begun: bool,
    /// Frames since the restart.
    frames: u32,
    /// Frames since particles or their radii could last have changed.
    quiet: u32,
    /// Where the depth range of the frame before this one stands.
    range_before: u32,
    /// The last frame was of the moment of the one before.
    held: bool,
    /// A volume came in a hold: particles meet it when they move on.
    unmet: bool,
    shape: Shape,
    /// Tables and what radii are searched in are those of other settings.
    stale: bool,
    /// The light of the shadows on the device; none if there are none.
    shadowed: Option<Light>,
    /// The view of the last frame, the first one if it came again.
    view: Option<View>,
    /// Particles were born anew in that frame.
    restarted: bool,
    /// How far they moved in it is on the device.
    moved: bool,
}

impl Kind for SmokeKind {
    const NAME: &'static str = "smoke";
    type Desc = Desc;
    type Layout = Layout;
    type Frame<'a> = Frame;
    type Recorded = State;

    fn new(desc: &Desc, traits: &DeviceTraits, effort: Effort) -> Result<SmokeKind> {
        desc.validate()?;
        traits.check_sides(desc.size)?;
        let layout = Layout::new(desc, traits)?;
        let tables = Tables::new(&desc.settings, &layout);
        let passes = Passes::new(desc, &layout, &tables, effort);
        Ok(SmokeKind { traits: *traits, layout, passes, tables, effort, state: State::default() })
    }

    fn resized(desc: &Desc, size: [u32; 2]) -> Desc {
        Desc { size, ..desc.clone() }
    }

    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn take_passes(&mut self) -> Vec<Pass> {
        std::mem::take(&mut self.passes.list)
    }

    fn plan(&mut self, desc: &Desc, frame: &Frame, plan: &mut Plan) -> Result<State> {
        frame.validate(desc, !self.state.begun)?;
        self.check_again(desc, frame)?;
        let (delta, state) = self.delta(desc, frame);
        search::check(&desc.settings, &delta.shape, &self.traits, self.layout.search_parts)?;
        let SmokeKind { layout, passes, tables, traits, .. } = self;
        let mut params = SmokeParams::new(desc, layout, frame, &delta.shape, state.frames);
        params.range_before = state.range_before;
        if state.held {
            params.range_smoothing = HELD_RANGE;
        }
        Steps { plan, passes, desc, layout, traits, delta: &delta }.fill(frame, &params, tables);
        Ok(state)
    }

    fn upload(&self, _: &Desc, frame: &Frame, resources: &mut Resources) {
        let volume = frame.volume;
        resources.set_host_buffer(layout::HOST_DENSITY, volume.map(|v| v.density));
        resources.set_host_buffer(layout::HOST_VELOCITY, volume.and_then(|v| v.velocity));
        resources.set_host_image(layout::TARGET, frame.target);
        let background = frame.background.image().filter(|_| frame.target.is_some());
        resources.set_host_image(layout::BACKGROUND, background);
        let depth = frame.depth.filter(|_| frame.target.is_some());
        resources.set_host_image(layout::HOST_DEPTH, depth);
        let edges = frame.edges.filter(|_| frame.target.is_some());
        resources.set_host_buffer(layout::HOST_EDGES, edges);
        let temporal = frame.target.map(|_| frame.temporal).unwrap_or_default();
        resources.set_host_image(layout::MOTION, temporal.motion);
        resources.set_host_image(layout::REACTIVE, temporal.reactive);
    }

    fn recorded(&mut self, _: &Desc, state: State) {
        self.state = state;
    }

    fn restarts(frame: &Frame) -> bool {
        frame.sequence == Sequence::Restart && frame.volume.is_some()
    }

    fn forget(&mut self) {
        self.state = State::default();
    }

    fn go_on(&mut self, old: &SmokeKind, descs: [&Desc; 2], kept: &Kept) {
        if kept.sequence() && descs[0].velocity == descs[1].velocity {
            // Radii may be others now, and so may all that is made for the picture.
            let moved = old.state.moved && kept.buffer(layout::MOVED);
            self.state = State { quiet: 0, shadowed: None, stale: old.state.begun, moved, ..old.state };
        }
    }

    const PAST: &'static [BufferId] = &[
        layout::HISTORY,
        layout::PARTICLES,
        layout::DYING,
        layout::DYING_STEPS,
        layout::SPHERES,
        layout::RADII,
        layout::GROUPS,
    ];

    fn past(&self) -> Vec<u32> {
        let State { frames, range_before, held, unmet, .. } = self.state;
        vec![frames, range_before, held.into(), unmet.into()]
    }

    fn go_on_from(&mut self, words: &[u32]) {
        let &[frames, range_before, held, unmet] = words else { return };
        // All that is made from volumes and settings is made anew.
        let (begun, stale, shape) = (true, true, self.state.shape);
        let (held, unmet) = (held != 0, unmet != 0);
        self.state = State { begun, stale, shape, frames, range_before, held, unmet, ..State::default() };
    }

    fn formats(desc: &Desc) -> Vec<NamedFormat> {
        let depth = desc.depth.map(|depth| depth_format(depth, vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT));
        [target_format(desc.target_format)].into_iter().chain(depth).chain(desc.temporal.formats()).collect()
    }
}

impl SmokeKind {
    /// Only the host knows what the frame before was seen through in another view.
    fn check_again(&self, desc: &Desc, frame: &Frame) -> Result<()> {
        let is_asked = frame.target.is_some() && desc.temporal.motion.is_some() && !self.state.restarted;
        if frame.sequence != Sequence::Again || !is_asked || frame.temporal.previous.is_some() {
            return Ok(());
        }
        let why =
            "missing; motion vectors of Sequence::Again are from what the frame before was seen through in this view";
        Err(Error::HostResource { name: "temporal.previous", why: why.to_owned() })
    }

    /// The relation of this frame to the ones before, and the state after it.
    fn delta(&self, desc: &Desc, frame: &Frame) -> (FrameDelta, State) {
        let restart = frame.sequence == Sequence::Restart;
        let advance = frame.sequence == Sequence::Advance;
        let again = frame.sequence == Sequence::Again;
        let new_volume = frame.volume.is_some();
        let State { stale, .. } = self.state;
        let mut state = State { stale: false, ..self.state };
        state.begun = true;
        state.held = frame.sequence == Sequence::Hold || again && state.held;
        state.range_before = 1 - self.state.range_before;
        state.frames = if restart { 0 } else { state.frames.wrapping_add(u32::from(advance)) };
        state.shape = frame.volume.map_or(state.shape, |v| v.shape());
        let restless = desc.settings.lifetime.is_some() || desc.settings.boil > 0.0;
        let moving = desc.velocity || restless || new_volume || stale || state.unmet;
        state.unmet = !restart && !advance && (state.unmet || new_volume || stale);
        state.quiet = if restart || (moving && advance) { 0 } else { state.quiet + u32::from(advance) };
        let still = match () {
            _ if restart || !self.effort.skips() && advance => None,
            _ if !advance => Some("the same moment again"),
            _ if state.quiet > desc.settings.fade + desc.settings.settling() => {
                Some("neither velocity nor density changes")
            }
            _ => None,
        };
        let same_light = self.state.shadowed == Some(frame.light) && !new_volume;
        let same_shadow =
            (still.is_some() && same_light && self.effort.skips()).then_some("particles and light unchanged");
        if frame.target.is_some() {
            state.shadowed = Some(frame.light);
        } else if still.is_none() {
            state.shadowed = None;
        }
        let new_tables = !self.state.begun || restart || stale;
        if !again {
            (state.view, state.restarted, state.moved) = (Some(frame.view), restart, still.is_none() && !restart);
        }
        let view_before = frame.temporal.previous.or(self.state.view).filter(|_| !state.restarted);
        let (shape, moves) = (state.shape, state.moved);
        let delta =
            FrameDelta { shape, restart, new_volume, stale, new_tables, still, same_shadow, view_before, moves };
        (delta, state)
    }
}

impl Effect<SmokeKind> {
    /// View depth of each pixel of the last frame in metres, infinity where there is no smoke: what hides a fire that is
    /// drawn after it.
    pub fn depth(&self) -> HostBuffer {
        let (buffer, offset, size) = self.buffer(layout::DEPTH);
        // Written by shaders, or cleared where there is no smoke.
        let stage = vk::PipelineStageFlags2::COMPUTE_SHADER | vk::PipelineStageFlags2::ALL_TRANSFER;
        let access = vk::AccessFlags2::SHADER_STORAGE_WRITE | vk::AccessFlags2::TRANSFER_WRITE;
        HostBuffer { buffer, offset, size, stage, access }
    }
}
