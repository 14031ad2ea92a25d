//! Cel-shaded smoke from a density volume (Hoshino, Dobashi, Yamamoto: Cartoon Rendering of Smoke).
//!
//! Spheres grow inside the thresholded volume (section 3.1), are lit and shadowed (3.2), smoothed within groups of equal
//! depth (3.3), cut into tones (3.4) and outlined from depth (3.5). [`Smoke::record`] records it all into the host's
//! command buffer.

pub mod frame;
pub mod layout;
pub mod params;
pub mod passes;
#[doc(hidden)]
pub mod reference;
pub mod settings;
pub mod steps;

use ash::vk;
use gpu_allocator::vulkan::Allocator;

pub use crate::host::{Background, DepthFormat, HostDepth};
pub use frame::{Desc, Frame, Sequence, Shape, VolumeInput};
pub use settings::Settings;

use crate::error::{Error, Result};
use crate::gpu::effect::{Inventory, OnDevice, effect_methods};
use crate::gpu::profiler::Timing;
use crate::gpu::recorder::Stream;
use crate::host::{Host, Memory, check_sides};
use crate::plan::Plan;
use crate::view::Light;
use layout::Layout;
use params::SmokeParams;
use passes::Passes;
use settings::Grow;
use steps::{Moment, Steps, Tables, chosen_grow};

/// The smoke effect: pipelines, and the buffers and images of one picture size.
///
/// Its state lives on the device and moves on with each recorded frame, so every recorded command buffer must be
/// submitted, in order, to the same queue. A frame may be recorded before the one before it has finished.
#[derive(Debug)]
pub struct Smoke {
    desc: Desc,
    layout: Layout,
    passes: Passes,
    tables: Tables,
    plan: Plan,
    on_device: OnDevice,
    state: State,
}

/// What is known of the frames recorded so far.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// Whether a frame has been recorded.
    begun: bool,
    /// Frames since the restart.
    frames: u32,
    /// Frames since particles or their radii could last have changed.
    quiet: u32,
    /// A volume came in a hold: particles meet it when they move on.
    unmet: bool,
    shape: Shape,
    /// The light of the shadows on the device; none if there are none.
    shadowed: Option<Light>,
}

impl Smoke {
    /// Device memory that an effect will take, before alignment. `limit` is the device's `maxStorageBufferRange`.
    ///
    /// # Errors
    /// A setting out of range, or something larger than `limit`.
    pub fn memory(desc: &Desc, limit: u64) -> Result<Memory> {
        validate(desc)?;
        Ok(Layout::new(desc, limit)?.memory(desc))
    }

    /// Creates pipelines, buffers and images; leaves nothing behind on error.
    ///
    /// # Errors
    /// A setting out of range, something too large for the device, no memory, a failed Vulkan call.
    ///
    /// # Safety
    /// `host` holds valid handles of a device that [`crate::host::requirements`] are enabled on, and `allocator` is its.
    pub unsafe fn new(host: &Host, allocator: &mut Allocator, desc: Desc) -> Result<Smoke> {
        validate(&desc)?;
        // SAFETY: the caller's.
        let limits = unsafe { host.instance.get_physical_device_properties(host.physical_device) }.limits;
        check_sides(desc.size, &limits)?;
        let layout = Layout::new(&desc, u64::from(limits.max_storage_buffer_range))?;
        let mut passes = Passes::new(&desc, &layout);
        let tables = Tables::new(&desc.settings, &layout);
        let inventory = Inventory {
            buffers: layout.buffers(),
            host_buffers: layout::HOST_BUFFERS,
            images: layout.images(&desc),
            host_images: 3,
        };
        let list = std::mem::take(&mut passes.list);
        // SAFETY: the caller's.
        let on_device = unsafe { OnDevice::new(host, allocator, list, inventory)? };
        let (steps, bytes) = steps::capacity(&layout, &tables);
        let plan = Plan::with_capacity(steps, bytes);
        Ok(Smoke { desc, layout, passes, tables, plan, on_device, state: State::default() })
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
        frame.validate(&self.desc, !self.state.begun)?;
        let (moment, state) = self.moment(frame);
        self.check_search(&moment.shape)?;
        let params = SmokeParams::new(&self.desc, &self.layout, frame, &moment.shape, state.frames);
        let Smoke { desc, layout, passes, tables, plan, .. } = self;
        Steps { plan, passes, desc, layout, moment: &moment }.fill(frame, &params, tables);
        let volume = frame.volume;
        self.on_device.resources.set_host_buffer(layout::HOST_DENSITY, volume.map(|v| v.density));
        self.on_device.resources.set_host_buffer(layout::HOST_VELOCITY, volume.and_then(|v| v.velocity));
        self.on_device.resources.set_host_image(layout::TARGET, frame.target);
        let background = match frame.background {
            Background::Copy(image) if frame.target.is_some() => Some(image),
            _ => None,
        };
        self.on_device.resources.set_host_image(layout::BACKGROUND, background);
        let depth = frame.depth.filter(|_| frame.target.is_some());
        self.on_device.resources.set_host_image(layout::HOST_DEPTH, depth.map(|depth| depth.image));
        let edges = frame.edges.filter(|_| frame.target.is_some());
        self.on_device.resources.set_host_buffer(layout::HOST_EDGES, edges);
        // SAFETY: the caller's.
        unsafe { self.on_device.record(host, stream, &self.plan, timing)? };
        self.state = state;
        Ok(())
    }

    /// The most steps that a frame can have, and the most bytes of its updates.
    pub fn plan_capacity(&self) -> (usize, usize) {
        steps::capacity(&self.layout, &self.tables)
    }

    /// What this frame is to the ones before, and the state after it.
    fn moment(&self, frame: &Frame) -> (Moment, State) {
        let restart = frame.sequence == Sequence::Restart;
        let advance = frame.sequence == Sequence::Advance;
        let new_volume = frame.volume.is_some();
        let mut state = self.state;
        state.begun = true;
        state.frames = if restart { 0 } else { state.frames.wrapping_add(u32::from(advance)) };
        state.shape = frame.volume.map_or(state.shape, |v| v.shape());
        let moving = self.desc.velocity || self.desc.settings.lifetime.is_some() || new_volume || state.unmet;
        state.unmet = !restart && !advance && (state.unmet || new_volume);
        state.quiet = if restart || (moving && advance) { 0 } else { state.quiet + u32::from(advance) };
        let still = match () {
            _ if restart || !self.desc.skipping && advance => None,
            _ if !advance => Some("the same moment again"),
            _ if state.quiet > self.desc.settings.fade => Some("neither velocity nor density changes"),
            _ => None,
        };
        let same_light = self.state.shadowed == Some(frame.light) && !new_volume;
        let same_shadow =
            (still.is_some() && same_light && self.desc.skipping).then_some("particles and light unchanged");
        if frame.target.is_some() {
            state.shadowed = Some(frame.light);
        } else if still.is_none() {
            state.shadowed = None;
        }
        let first = !self.state.begun;
        (Moment { shape: state.shape, restart, new_volume, first, still, same_shadow }, state)
    }

    /// A search that was asked for by name must be able to serve this volume.
    fn check_search(&self, shape: &Shape) -> Result<()> {
        match chosen_grow(&self.desc.settings, shape) {
            Grow::Field if !shape.is_cubic() => {
                Err(Error::setting("smoke.grow", "field", "needs cubic voxels; \"chosen\" or \"pyramid\" serve all"))
            }
            Grow::Field if !layout::field_fits(shape) => Err(Error::setting(
                "smoke.grow",
                "field",
                "needs smaller slices (x, y); \"chosen\" or \"pyramid\" serve all",
            )),
            Grow::Growth => {
                let iterations = layout::Pyramid::new(shape.dimensions).iterations();
                let needed = u64::from(layout::growth_rows(shape).div_ceil(iterations));
                let limit = u64::from(self.layout.search_parts);
                let advice = "its voxels are too flat for grow = \"growth\"; use \"chosen\"";
                match needed > limit {
                    true => Err(Error::Limit { what: "the search of radii (dispatches)", needed, limit, advice }),
                    false => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }
}

effect_methods!(Smoke, host_images: [layout::TARGET, layout::BACKGROUND, layout::HOST_DEPTH]);

fn validate(desc: &Desc) -> Result<()> {
    desc.settings.validate()?;
    if desc.size.contains(&0) {
        return Err(Error::setting("size", format!("{:?}", desc.size), "at least 1 pixel a side"));
    }
    if desc.dimensions.contains(&0) || desc.dimensions.iter().any(|n| *n > 1 << 16) {
        let dimensions = format!("{:?}", desc.dimensions);
        return Err(Error::setting("volume", dimensions, "1 to 65536 voxels a side"));
    }
    Ok(())
}
