//! Hand-drawn motion blur of an animated mesh (Sakai: Motion Blur for 3DCG Animation with Hand Drawing Style).
//!
//! A post effect: from the mesh's poses and the frames already rendered, each output smears the mesh along the
//! trajectories of its vertices, in ragged teeth, and colours it from both frames.

pub mod frame;
pub mod layout;
pub mod mesh;
pub mod motion;
pub mod params;
pub mod passes;
#[doc(hidden)]
pub mod reference;
pub mod settings;
pub mod shells;
pub mod steps;

use ash::vk;
use gpu_allocator::vulkan::Allocator;

pub use crate::host::{Background, DepthFormat, HostDepth};
pub use frame::{
    Counts, DepthInput, Desc, Frame, GroupInput, IntervalInput, Knot, MOST_TRIANGLES, PoseInput, ToonInput,
    TopologyInput, Trajectories, View,
};
pub use mesh::{Mesh, MeshInput};
pub use motion::{Cluster, Interval, Motion, Pose, Window};
pub use settings::Settings;

use crate::error::{Error, Result};
use crate::gpu::effect::{Inventory, OnDevice, effect_methods};
use crate::gpu::profiler::Timing;
use crate::gpu::recorder::Stream;
use crate::host::{Host, HostBuffer, Memory, check_sides};
use crate::plan::Plan;
use layout::Layout;
use params::{BASE_MASK, MOST_SEGMENTS};
use passes::Passes;
use steps::Steps;

/// The blur effect: pipelines, and the buffers and images of one mesh and one picture size.
///
/// Poses stay on the device from frame to frame, so recorded command buffers must be submitted in order, to the same queue.
/// A frame may be recorded before the one before it has finished.
#[derive(Debug)]
pub struct Blur {
    desc: Desc,
    layout: Layout,
    passes: Passes,
    plan: Plan,
    on_device: OnDevice,
    /// The frame whose pose stands in each place.
    resident: Vec<Option<u32>>,
    /// The frame that is drawn in each place.
    drawn: [Option<frame::Drawn>; layout::TOON.len()],
    has_mesh: bool,
}

impl Blur {
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
    pub unsafe fn new(host: &Host, allocator: &mut Allocator, desc: Desc) -> Result<Blur> {
        validate(&desc)?;
        // SAFETY: the caller's.
        let limits = unsafe { host.instance.get_physical_device_properties(host.physical_device) }.limits;
        // Four samples a pixel.
        check_sides(desc.size.map(|side| side.saturating_mul(2)), &limits)?;
        let layout = Layout::new(&desc, u64::from(limits.max_storage_buffer_range))?;
        let mut passes = Passes::new(&desc);
        let inventory = Inventory {
            buffers: layout.buffers(),
            host_buffers: layout::HOST_BUFFERS,
            images: layout.images(&desc),
            host_images: layout::HOST_IMAGES,
        };
        let list = std::mem::take(&mut passes.list);
        // SAFETY: the caller's.
        let on_device = unsafe { OnDevice::new(host, allocator, list, inventory)? };
        let (steps, bytes) = steps::capacity(&desc);
        let plan = Plan::with_capacity(steps, bytes);
        let resident = vec![None; desc.frames_resident as usize];
        let drawn = Default::default();
        Ok(Blur { desc, layout, passes, plan, on_device, resident, drawn, has_mesh: false })
    }

    /// Records a frame. Allocates nothing, submits nothing, waits for nothing.
    ///
    /// # Errors
    /// The frame does not fit what the effect was made for; nothing has been recorded then.
    ///
    /// # Safety
    /// `host` is the one the effect was made with. `commands` is in recording state, outside of a render pass, of a queue
    /// family with graphics and compute. Host images and buffers are in the states that they declare, and the buffers hold
    /// what an [`Interval`] and a [`Mesh`] hold. The frame is submitted after all frames recorded before it, to the same
    /// queue.
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
        frame.validate(&self.desc, !self.has_mesh, &self.resident)?;
        let Blur { desc, layout, passes, plan, drawn, .. } = self;
        Steps { plan, passes, desc, layout, drawn }.fill(frame);
        self.hand_over(frame);
        // SAFETY: the caller's.
        unsafe { self.on_device.record(host, stream, &self.plan, timing)? };
        self.has_mesh = true;
        self.drawn.iter_mut().for_each(|place| *place = place.filter(|drawn| !frame.brings(drawn.frame())));
        steps::drawn(&self.desc, frame)
            .into_iter()
            .flatten()
            .for_each(|new| self.drawn[new.place(&self.desc)] = Some(new));
        if let Some(poses) = &frame.poses {
            for new in poses.first..poses.first + poses.count {
                self.resident[(new % self.desc.frames_resident) as usize] = Some(new);
            }
        }
        Ok(())
    }

    fn hand_over(&mut self, frame: &Frame) {
        let resources = &mut self.on_device.resources;
        let topology = frame.mesh.map(|mesh| [mesh.triangles, mesh.neighbour_starts, mesh.neighbours]);
        for (place, id) in layout::HOST_TOPOLOGY.into_iter().enumerate() {
            resources.set_host_buffer(id, topology.map(|buffers| buffers[place]));
        }
        resources.set_host_buffer(layout::HOST_COLOURS, frame.mesh.and_then(|mesh| mesh.colours));
        let groups = frame.mesh.and_then(|mesh| mesh.groups);
        let groups = groups.map(|groups| [groups.corners, groups.starts, groups.triangles]);
        for (place, id) in layout::HOST_GROUPS.into_iter().enumerate() {
            resources.set_host_buffer(id, groups.map(|buffers| buffers[place]));
        }
        resources.set_host_buffer(layout::HOST_POSES, frame.poses.map(|poses| poses.positions));
        let interval = frame.interval.as_ref().filter(|_| steps::still(&self.desc, frame).is_none());
        let buffers = interval.map(|interval| {
            let pieces = match interval.trajectories {
                Trajectories::Poses(_) => None,
                Trajectories::Pieces(pieces) => Some(pieces),
            };
            let seams = Some(interval.seams).filter(|_| interval.counts.seams > 0);
            let [motion, labels, clusters, hull] =
                [interval.motion, interval.labels, interval.clusters, interval.hull].map(Some);
            [motion, labels, clusters, hull, seams, Some(interval.fronts), pieces]
        });
        for (place, id) in layout::HOST_INTERVAL.into_iter().enumerate() {
            resources.set_host_buffer(id, buffers.and_then(|buffers| buffers[place]));
        }
        resources.set_host_image(layout::TARGET, Some(frame.target));
        for (place, id) in layout::HOST_FRAMES.into_iter().enumerate() {
            resources.set_host_image(id, frame.images.map(|images| images[place]));
        }
        resources.set_host_image(layout::HOST_DEPTH, frame.depth.map(|depth| depth.host.image));
        let background = match frame.background {
            Background::Copy(image) => Some(image),
            _ => None,
        };
        resources.set_host_image(layout::HOST_BACKGROUND, background);
        for (id, image) in layout::HOST_OUTER.into_iter().zip(frame.outer) {
            resources.set_host_image(id, image);
        }
    }

    /// What the mesh covers pixels with in the frame recorded last, for [`crate::smoke::Frame::edges`] of a frame that is
    /// recorded after it; none if the host has no depth.
    pub fn edges(&self) -> Option<HostBuffer> {
        self.desc.depth?;
        let (buffer, offset, size) = self.buffer(layout::SURFACE);
        let (stage, access) = (vk::PipelineStageFlags2::COMPUTE_SHADER, vk::AccessFlags2::SHADER_STORAGE_WRITE);
        Some(HostBuffer { buffer, offset, size, stage, access })
    }

    /// The most steps that a frame can have, and the most bytes of its updates.
    pub fn plan_capacity(&self) -> (usize, usize) {
        steps::capacity(&self.desc)
    }
}

effect_methods!(Blur, host_images: [
    layout::TARGET,
    layout::HOST_FRAMES[0],
    layout::HOST_FRAMES[1],
    layout::HOST_OUTER[0],
    layout::HOST_OUTER[1],
    layout::HOST_DEPTH,
    layout::HOST_BACKGROUND,
]);

fn validate(desc: &Desc) -> Result<()> {
    desc.settings.validate()?;
    if desc.size.contains(&0) {
        return Err(Error::setting("size", format!("{:?}", desc.size), "at least 1 pixel a side"));
    }
    if desc.points == 0 {
        return Err(Error::setting("blur's points", 0, "at least 1"));
    }
    if desc.triangles > desc.most_triangles || desc.most_triangles > BASE_MASK {
        let allowed = format!("from the mesh's own {} to {BASE_MASK}", desc.triangles);
        return Err(Error::setting("blur's triangles", desc.most_triangles, allowed));
    }
    if desc.toon && desc.groups == 0 {
        return Err(Error::setting("blur's normal groups", 0, "at least 1 where frames are drawn"));
    }
    crate::error::within("blur's segments", desc.segments, 1, MOST_SEGMENTS, "1 to 32")?;
    crate::error::within("blur's resident frames", desc.frames_resident, 4, 1 << 24, "4 to 16777216")
}
