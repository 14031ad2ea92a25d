//! Fire from particles by stochastic alpha test (Mabuchi, Fujishiro, Ohno: Particle-Based Flame Rendering).
//!
//! Physical particles with a temperature draw render particles at random around them; each is a sprite that a pixel sees
//! where its alpha reaches a threshold; the nearest wins; repetitions are averaged. Nothing is sorted or blended.
//! [`Flame::record`] records it all into the host's command buffer. The [`settings::Mode::Expected`] mode integrates the
//! image that the repetitions converge to.

mod cie;
pub mod colour;
pub mod frame;
pub mod layout;
pub mod params;
pub mod passes;
#[doc(hidden)]
pub mod reference;
pub mod settings;
mod spacing;
pub mod steps;

use ash::vk;
use gpu_allocator::vulkan::Allocator;

pub use crate::host::{Background, DepthFormat, HostDepth};
pub use frame::{Desc, Frame, ParticleInput, SceneDepth, SceneFormat};
pub use settings::Settings;
pub use spacing::mean_spacing;

use crate::error::{Error, Result};
use crate::gpu::effect::{Inventory, OnDevice, effect_methods};
use crate::gpu::profiler::Timing;
use crate::gpu::recorder::Stream;
use crate::host::{Host, Memory, check_sides};
use crate::plan::Plan;
use crate::view::Camera;
use colour::Table;
use layout::Layout;
use params::{FlameParams, Given};
use passes::Passes;
use reference::mask::Mask;
use settings::{Colour, HOTTEST, MOST_REPETITIONS};
use steps::{Moment, Steps};

/// The flame effect: pipelines, and the buffers and images of one picture size.
///
/// A frame depends on no other, unless it takes the last one's particles or adds to its repetitions; then recorded
/// command buffers must be submitted in order, to the same queue. A frame may be recorded before the one before it has finished.
#[derive(Debug)]
pub struct Flame {
    desc: Desc,
    layout: Layout,
    passes: Passes,
    table: Table,
    /// The largest alpha of the mask.
    max_alpha: f32,
    plan: Plan,
    on_device: OnDevice,
    state: State,
}

/// What is known of the frames recorded so far.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// The camera of the last frame; none before the first.
    camera: Option<Camera>,
    /// The camera of the last frame that could see fire.
    lit: Option<Camera>,
    /// Whether tables and mask are on the device.
    has_tables: bool,
    given: Given,
    /// A bound of its particles' temperatures.
    hottest: f32,
    /// Repetitions that the sums on the device hold.
    repetitions: u32,
}

impl Flame {
    /// Device memory that an effect will take, before alignment. `limit` is the device's `maxStorageBufferRange`.
    ///
    /// # Errors
    /// A setting out of range, or something larger than `limit`.
    pub fn memory(desc: &Desc, limit: u64) -> Result<Memory> {
        validate(desc)?;
        Ok(Layout::new(desc, &table(desc), limit)?.memory(desc))
    }

    /// Creates pipelines, buffers and images; leaves nothing behind on error.
    ///
    /// # Errors
    /// A setting out of range, something too large for the device, no memory, a failed Vulkan call.
    ///
    /// # Safety
    /// `host` holds valid handles of a device that [`crate::host::requirements`] are enabled on, and `allocator` is its.
    pub unsafe fn new(host: &Host, allocator: &mut Allocator, desc: Desc) -> Result<Flame> {
        validate(&desc)?;
        // SAFETY: the caller's.
        let limits = unsafe { host.instance.get_physical_device_properties(host.physical_device) }.limits;
        check_sides(desc.size, &limits)?;
        let table = table(&desc);
        let layout = Layout::new(&desc, &table, u64::from(limits.max_storage_buffer_range))?;
        let mut passes = Passes::new(&desc, &table);
        let inventory =
            Inventory { buffers: layout.buffers(), host_buffers: 3, images: layout.images(&desc), host_images: 3 };
        let list = std::mem::take(&mut passes.list);
        // SAFETY: the caller's.
        let on_device = unsafe { OnDevice::new(host, allocator, list, inventory)? };
        let (steps, bytes) = steps::capacity(&layout, &table);
        let plan = Plan::with_capacity(steps, bytes);
        // The largest alpha that the device's mask can have, which is the reference's but for rounding.
        let max_alpha = (Mask::new(desc.seed, desc.settings.variants).largest() * 1.000001) as f32;
        let state = State::default();
        Ok(Flame { desc, layout, passes, table, max_alpha, plan, on_device, state })
    }

    /// Records a frame. Allocates nothing, submits nothing, waits for nothing.
    ///
    /// # Errors
    /// The frame does not fit what the effect was made for; nothing has been recorded then.
    ///
    /// # Safety
    /// `host` is the one the effect was made with. `commands` is in recording state, outside of a render pass, of a queue
    /// family with graphics and compute. Host images and buffers are in the states that they declare. The frame is
    /// submitted after all frames recorded before it, to the same queue.
    pub unsafe fn record(
        &mut self,
        host: &Host,
        mut commands: vk::CommandBuffer,
        frame: &Frame,
        timing: &mut Timing,
    ) -> Result<()> {
        // SAFETY: the caller's.
        unsafe { self.record_into(host, &mut commands, frame, timing) }
    }

    /// [`Self::record`] into the command buffers of a stream.
    ///
    /// # Errors
    /// As there, and what the stream says: the frame is recorded in part then.
    ///
    /// # Safety
    /// As there, for each command buffer.
    pub(crate) unsafe fn record_into(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        frame: &Frame,
        timing: &mut Timing,
    ) -> Result<()> {
        frame.validate(&self.desc, self.state.camera.is_none())?;
        let (moment, state) = self.moment(frame)?;
        let params = FlameParams::new(&self.desc, &self.layout, frame, &moment.given, &self.table, self.max_alpha);
        let Flame { desc, layout, passes, plan, table, .. } = self;
        Steps { plan, passes, desc, layout, moment: &moment }.fill(frame, &params, table);
        self.hand_over(frame);
        // SAFETY: the caller's.
        unsafe { self.on_device.record(host, stream, &self.plan, timing)? };
        self.state = state;
        Ok(())
    }

    fn hand_over(&mut self, frame: &Frame) {
        let particles = frame.particles.filter(|particles| particles.count > 0);
        let (buffer, image) = match frame.scene {
            Some(SceneDepth::Buffer(buffer)) => (Some(buffer), None),
            Some(SceneDepth::Image(depth)) => (None, Some(depth.image)),
            None => (None, None),
        };
        let background = match frame.background {
            Background::Copy(image) => Some(image),
            _ => None,
        };
        self.on_device.resources.set_host_buffer(layout::HOST_POSITIONS, particles.map(|p| p.position_temperature));
        self.on_device.resources.set_host_buffer(layout::HOST_IDS, particles.and_then(|p| p.ids));
        self.on_device.resources.set_host_buffer(layout::HOST_SCENE, buffer);
        self.on_device.resources.set_host_image(layout::TARGET, Some(frame.target));
        self.on_device.resources.set_host_image(layout::BACKGROUND, background);
        self.on_device.resources.set_host_image(layout::HOST_DEPTH, image);
    }

    /// The most steps that a frame can have, and the most bytes of its updates.
    pub fn plan_capacity(&self) -> (usize, usize) {
        steps::capacity(&self.layout, &self.table)
    }

    /// What this frame is to the ones before, and the state after it.
    fn moment(&self, frame: &Frame) -> Result<(Moment, State)> {
        let mut state = self.state;
        if let Some(particles) = &frame.particles {
            state.given = Given { count: particles.count, ids: particles.ids.is_some(), before: 0 };
            state.hottest = particles.hottest.min(self.desc.hottest);
        }
        let repetitions = self.desc.settings.repetitions;
        state.given.before = if frame.accumulate { self.state.repetitions } else { 0 };
        if frame.accumulate {
            self.check_accumulation(frame, state.given.before + repetitions)?;
        }
        state.repetitions = state.given.before + repetitions;
        state.camera = Some(frame.camera);
        let dark = self.dark(&state);
        // The mask is a layer of frames without fire, too.
        let make_tables = !state.has_tables && (dark.is_none() || self.desc.layers);
        state.has_tables |= make_tables;
        state.lit = if dark.is_none() { Some(frame.camera) } else { state.lit };
        Ok((Moment { given: state.given, camera: self.state.lit, make_tables, dark }, state))
    }

    /// Only what is the same can be added to.
    fn check_accumulation(&self, frame: &Frame, repetitions: u32) -> Result<()> {
        let refuse = |allowed: &str| Err(Error::setting("frame.accumulate", true, allowed));
        match () {
            _ if self.state.repetitions == 0 => refuse("false in the first frame: there is nothing to add to"),
            _ if frame.particles.is_some() => refuse("not with new particles"),
            _ if self.state.camera != Some(frame.camera) => refuse("not with another camera"),
            _ if repetitions > MOST_REPETITIONS => refuse("up to 1048576 repetitions in all"),
            _ => Ok(()),
        }
    }

    /// Why no fire can be seen, as far as the host can tell.
    fn dark(&self, state: &State) -> Option<&'static str> {
        let settings = &self.desc.settings;
        let size = settings.size_pixels.unwrap_or(settings.sprite());
        let alpha = settings.alpha_scale * state.hottest / settings.hottest * self.max_alpha;
        match () {
            _ if state.given.count == 0 => Some("no particles"),
            _ if settings.count == 0.0 => Some("count is 0: no render particles"),
            _ if size == 0.0 => Some("sprites have no size"),
            // A little more than the device's rounding.
            _ if alpha * 1.000001 < settings.threshold || settings.threshold > 1.0 => {
                Some("no particle can pass the alpha test")
            }
            _ => None,
        }
    }
}

fn table(desc: &Desc) -> Table {
    let settings = &desc.settings;
    let [hottest, falloff, adaptation] = [settings.hottest, settings.falloff, settings.adaptation].map(f64::from);
    match &settings.colour {
        Colour::Physical => Table::physical(hottest, adaptation, hottest.max(desc.hottest.into())),
        Colour::Displayable => Table::displayable(hottest, falloff, adaptation),
        Colour::Ramp(colours) => Table::ramp(hottest, colours),
    }
}

effect_methods!(Flame, host_images: [layout::TARGET, layout::BACKGROUND, layout::HOST_DEPTH]);

fn validate(desc: &Desc) -> Result<()> {
    desc.settings.validate()?;
    if desc.settings.spread.is_none() {
        let allowed = "metres, 0 or above; celfx::flame::mean_spacing finds the usual one";
        return Err(Error::setting("flame.spread", "none", allowed));
    }
    if desc.size.contains(&0) {
        return Err(Error::setting("size", format!("{:?}", desc.size), "at least 1 pixel a side"));
    }
    if !(desc.hottest > 0.0 && desc.hottest <= HOTTEST) {
        return Err(Error::setting("flame's hottest particle", desc.hottest, "kelvin, above 0, at most 1e6"));
    }
    Ok(())
}
