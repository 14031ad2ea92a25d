//! Hand-drawn motion blur of an animated mesh (Sakai: Motion Blur for 3DCG Animation with Hand Drawing Style).
//!
//! A post effect: from the mesh's poses and the frames already rendered, each output smears the mesh along the
//! trajectories of its vertices, in ragged teeth, and colours it from both frames.

pub mod desc;
pub mod frame;
pub(crate) mod layout;
pub(crate) mod limits;
pub mod mesh;
pub mod motion;
pub(crate) mod params;
pub mod parts;
pub(crate) mod passes;
#[cfg(any(test, feature = "reference"))]
pub mod reference;
pub mod settings;
pub(crate) mod shells;
pub(crate) mod steps;
pub mod textures;
pub mod upload;

use std::borrow::Cow;
use std::ops::Range;

use ash::vk;

pub use crate::host::{Background, DepthFormat};
pub use desc::{Desc, MOST_SOURCES, MOST_TRIANGLES, Source};
pub use frame::{
    ClusterInput, Counts, DepthInput, Frame, FrameView, GroupInput, IntervalInput, Knot, MeshSizes, PartInput,
    PoseInput, SkinnedInput, ToonInput, TopologyInput, Trajectories,
};
pub use mesh::{Mesh, MeshInput};
pub use motion::{Cluster, Interval, Motion, Pose, Window};
pub use parts::{PartSizes, Parts};
pub use settings::Settings;
pub use textures::{Texture, Wrap, texture_rows};
pub use upload::{Placed, Upload};

use crate::effect::{DeviceTraits, Effect, Effort, Kind};
use crate::error::Result;
use crate::gpu::resources::{Kept, Resources};
use crate::host::{HostBuffer, NamedFormat, depth_format, target_format};
use crate::plan::{Pass, Plan};
use layout::Layout;
use passes::Passes;
use steps::Steps;

/// The blur effect, of one mesh. Poses stay on the device from frame to frame.
pub type Blur = Effect<BlurKind>;

/// The parts that are the blur's own.
#[derive(Debug)]
pub struct BlurKind {
    traits: DeviceTraits,
    layout: Layout,
    passes: Passes,
    effort: Effort,
    /// The frame whose pose stands in each place.
    resident: Vec<Option<u32>>,
    /// The frame that is drawn in each place.
    drawn: [Option<frame::Drawn>; limits::DRAWN_PLACES],
    has_mesh: bool,
    /// How much there is of the mesh, if that is not what the effect was made for.
    sizes: Option<MeshSizes>,
}

/// What a frame leaves on the device.
#[derive(Clone, Debug)]
pub struct Brought {
    /// Whether it brought the mesh.
    mesh: bool,
    /// How much there is of that.
    sizes: Option<MeshSizes>,
    /// Frames whose poses it brought.
    poses: Range<u32>,
    /// The frame whose pose the host's skinning made.
    skinned: Option<u32>,
    /// Frames that were drawn.
    drawn: [Option<frame::Drawn>; 4],
}

impl Kind for BlurKind {
    const NAME: &'static str = "blur";
    type Desc = Desc;
    type Layout = Layout;
    type Frame<'a> = Frame<'a>;
    type Recorded = Brought;

    fn new(desc: &Desc, traits: &DeviceTraits, effort: Effort) -> Result<BlurKind> {
        desc.validate()?;
        // Four samples a pixel.
        traits.check_sides(desc.size.map(|side| side.saturating_mul(2)))?;
        let layout = Layout::new(desc, traits)?;
        let passes = Passes::new(desc, traits);
        let resident = vec![None; desc.frames_resident as usize];
        let (drawn, has_mesh, sizes) = (Default::default(), false, None);
        Ok(BlurKind { traits: *traits, layout, passes, effort, resident, drawn, has_mesh, sizes })
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

    fn plan(&mut self, desc: &Desc, frame: &Frame, plan: &mut Plan) -> Result<Brought> {
        let sizes = frame.mesh.and_then(|mesh| mesh.sizes);
        sizes.map_or(Ok(()), |sizes| sizes.check(&desc.sizes()))?;
        let desc = &*self.sized(desc, frame);
        // With a mesh of another size come all poses.
        let resident = if sizes.is_some() { &[] } else { &self.resident[..] };
        frame.validate(desc, !self.has_mesh, resident)?;
        let BlurKind { traits, layout, passes, effort, drawn, .. } = self;
        Steps { plan, passes, desc, layout, traits, effort: *effort, drawn }.fill(frame);
        let poses = frame.poses.map_or(0..0, |poses| poses.first..poses.first + poses.count);
        let skinned = frame.skinned.map(|skinned| skinned.frame);
        Ok(Brought { mesh: frame.mesh.is_some(), sizes, poses, skinned, drawn: steps::drawn(desc, frame) })
    }

    fn upload(&self, desc: &Desc, frame: &Frame, resources: &mut Resources) {
        let desc = &*self.sized(desc, frame);
        let topology = frame.mesh.map(|mesh| [mesh.triangles, mesh.neighbour_starts, mesh.neighbours]);
        for (place, id) in layout::HOST_TOPOLOGY.into_iter().enumerate() {
            resources.set_host_buffer(id, topology.map(|buffers| buffers[place]));
        }
        resources.set_host_buffer(layout::HOST_COLOURS, frame.mesh.and_then(|mesh| mesh.colours));
        resources.set_host_buffer(layout::HOST_TEXTURES, frame.mesh.and_then(|mesh| mesh.textures));
        resources.set_host_buffer(layout::HOST_SHARES, frame.mesh.and_then(|mesh| mesh.shares));
        let groups = frame.mesh.and_then(|mesh| mesh.groups);
        let groups = groups.map(|groups| [groups.corners, groups.starts, groups.triangles]);
        for (place, id) in layout::HOST_GROUPS.into_iter().enumerate() {
            resources.set_host_buffer(id, groups.map(|buffers| buffers[place]));
        }
        resources.set_host_buffer(layout::HOST_POSES, frame.poses.map(|poses| poses.positions));
        let parts = frame.mesh.and_then(|mesh| mesh.parts).zip(desc.parts);
        let parts = parts.map(|(parts, sizes)| parts.sized(&sizes, desc.points));
        for (place, id) in layout::HOST_PARTS.into_iter().enumerate() {
            let used = parts.map(|parts| parts[place]).filter(|(_, bytes)| *bytes > 0);
            resources.set_host_buffer(id, used.map(|(buffer, _)| buffer));
        }
        resources.set_host_buffer(layout::HOST_SOURCE_ROWS, frame.mesh.and_then(|mesh| mesh.source_rows));
        let interval = frame.interval.as_ref().filter(|_| steps::still(desc, frame).is_none());
        let given = interval.and_then(|interval| Some(interval.clusters?.sized(&interval.counts, desc)));
        let [found @ .., pieces] = layout::HOST_INTERVAL;
        for (place, id) in found.into_iter().enumerate() {
            let used = given.map(|given| given[place]).filter(|(.., bytes)| *bytes > 0);
            resources.set_host_buffer(id, used.map(|(_, buffer, _)| buffer));
        }
        let given = interval.and_then(|interval| match interval.trajectories {
            Trajectories::Poses(_) => None,
            Trajectories::Pieces(pieces) => Some(pieces),
        });
        resources.set_host_buffer(pieces, given);
        resources.set_host_image(layout::TARGET, Some(frame.target));
        for (place, id) in layout::HOST_FRAMES.into_iter().enumerate() {
            resources.set_host_image(id, frame.images.map(|images| images[place]));
        }
        for (id, image) in layout::HOST_SCENES.into_iter().zip(frame.occluders) {
            resources.set_host_image(id, image);
        }
        resources.set_host_image(layout::HOST_DEPTH, frame.depth.map(|depth| depth.host));
        resources.set_host_image(layout::HOST_BACKGROUND, frame.background.image());
        resources.set_host_image(layout::MOTION, frame.temporal.motion);
        resources.set_host_image(layout::REACTIVE, frame.temporal.reactive);
        for (id, image) in layout::HOST_OUTER.into_iter().zip(frame.outer) {
            resources.set_host_image(id, image);
        }
    }

    fn recorded(&mut self, desc: &Desc, Brought { mesh, sizes, poses, skinned, drawn }: Brought) {
        self.has_mesh = true;
        if mesh {
            self.sizes = sizes;
        }
        if sizes.is_some() {
            self.resident.fill(None);
        }
        let is_new = |frame: u32| mesh || poses.contains(&frame) || skinned == Some(frame);
        for place in &mut self.drawn {
            *place = place.filter(|drawn| !is_new(drawn.frame()));
        }
        drawn.into_iter().flatten().for_each(|new| self.drawn[new.place(desc)] = Some(new));
        for new in poses.chain(skinned) {
            self.resident[(new % desc.frames_resident) as usize] = Some(new);
        }
    }

    fn forget(&mut self) {
        self.has_mesh = false;
        self.drawn.fill(None);
        self.resident.fill(None);
    }

    fn go_on(&mut self, old: &BlurKind, descs: [&Desc; 2], kept: &Kept) {
        let mesh = descs
            .map(|d| [d.points, d.triangles, d.neighbours, d.surfaces, d.groups, d.group_triangles, d.texture_rows]);
        let has_normals = descs.map(|desc| self.layout.has_normals(desc));
        let same_parts = descs[0].parts == descs[1].parts && descs[0].sources.len() == descs[1].sources.len();
        let same_mesh =
            same_parts && mesh[0] == mesh[1] && (descs[0].toon, has_normals[0]) == (descs[1].toon, has_normals[1]);
        if same_mesh && kept.sequence() {
            (self.has_mesh, self.sizes) = (old.has_mesh, old.sizes);
            self.resident.clone_from(&old.resident);
        }
    }

    fn formats(desc: &Desc) -> Vec<NamedFormat> {
        let depth = desc.depth.map(|depth| depth_format(depth, vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT));
        let occluders = desc.occluders.map(|depth| depth_format(depth, vk::FormatFeatureFlags::TRANSFER_SRC));
        let depths = depth.into_iter().chain(occluders);
        [target_format(desc.target_format)].into_iter().chain(depths).chain(desc.temporal.formats()).collect()
    }
}

impl BlurKind {
    /// The description for the mesh that a frame is of.
    fn sized<'a>(&self, desc: &'a Desc, frame: &Frame) -> Cow<'a, Desc> {
        let sizes = frame.mesh.map_or(self.sizes, |mesh| mesh.sizes);
        sizes.map_or(Cow::Borrowed(desc), |sizes| Cow::Owned(desc.sized(&sizes)))
    }
}

impl Effect<BlurKind> {
    /// The mesh's coverage of pixels in the frame recorded last, for a smoke's `Frame::edges` of a frame that is
    /// recorded after it; none if the host has no depth.
    pub fn edges(&self) -> Option<HostBuffer> {
        self.desc().depth?;
        let (buffer, offset, size) = self.buffer(layout::SURFACE);
        let (stage, access) = (vk::PipelineStageFlags2::COMPUTE_SHADER, vk::AccessFlags2::SHADER_STORAGE_WRITE);
        Some(HostBuffer { buffer, offset, size, stage, access })
    }
}
