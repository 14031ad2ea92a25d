//! The depth that a mesh, smoke and fire share, so that they hide each other.

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use super::Effects;
use crate::error::Result;
use crate::flame::SceneFormat;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::transfer::{CLEARED, record_depth};
use crate::host::{DepthFormat, Host, HostDepth, HostImage, ImageState};

/// Near over view depth.
const FORMAT: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
/// How an effect leaves it to the next.
const DRAWN: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::from_raw(
        vk::PipelineStageFlags2::EARLY_FRAGMENT_TESTS.as_raw() | vk::PipelineStageFlags2::LATE_FRAGMENT_TESTS.as_raw(),
    ),
    access: vk::AccessFlags2::from_raw(
        vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()
            | vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
    ),
    layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
};

/// Makes effects hide each other: a mesh, smoke and fire by a depth image, smoke and fire by the smoke's own depth, which
/// costs less. Whether there is to be an image.
pub(super) fn join(effects: &mut Effects) -> bool {
    let (has_smoke, has_flame) = (effects.smoke.is_some(), effects.flame.is_some());
    let shared = effects.blur.is_some() && (has_smoke || has_flame);
    if shared {
        effects.smoke.iter_mut().for_each(|smoke| (smoke.depth, smoke.edges) = (Some(FORMAT), true));
        effects.blur.iter_mut().for_each(|blur| blur.depth = Some(FORMAT));
    }
    if let Some(flame) = effects.flame.as_mut().filter(|_| shared || has_smoke) {
        flame.scene = Some(if shared { SceneFormat::Image(FORMAT) } else { SceneFormat::Buffer });
    }
    shared
}

/// The depth image.
pub(super) struct SharedDepth {
    image: Image,
    extent: [u32; 2],
}

impl SharedDepth {
    /// Makes it.
    ///
    /// # Safety
    /// As [`Image::new`].
    pub(super) unsafe fn new(host: &Host, allocator: &mut Allocator, extent: [u32; 2]) -> Result<SharedDepth> {
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let format = FORMAT.format;
        let desc = ImageDesc { name: "depth", extent, layers: 1, array_view: false, format, usage };
        // SAFETY: the caller's.
        Ok(SharedDepth { image: unsafe { Image::new(host, allocator, &desc)? }, extent })
    }

    /// Begins a frame: nothing is there.
    ///
    /// # Safety
    /// As [`record_depth`]; every frame before has been waited for.
    pub(super) unsafe fn clear(&self, host: &Host, commands: vk::CommandBuffer) {
        // SAFETY: the caller's.
        unsafe { record_depth(host, commands, self.image.handle, 0.0) };
    }

    /// As an effect takes it, of pictures that a camera with this near plane sees.
    pub(super) fn of_frame(&self, near: f64, is_first: bool) -> HostDepth {
        let (image, view) = (self.image.handle, self.image.view);
        let state_in = if is_first { CLEARED } else { DRAWN };
        let image = HostImage { image, view, format: FORMAT.format, extent: self.extent, state_in, state_out: DRAWN };
        HostDepth { image, terms: HostDepth::perspective(near as f32, f32::INFINITY, FORMAT.reversed) }
    }

    /// Destroys it.
    ///
    /// # Safety
    /// As [`Image::destroy`].
    pub(super) unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        unsafe { self.image.destroy(host, allocator) };
    }
}
