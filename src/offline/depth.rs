//! The depth that a mesh, smoke and fire share, so that they hide each other.

use ash::vk;

use crate::error::Result;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::scratch::Lifetime;
use crate::gpu::transfer::{CLEARED, record_depth};
use crate::host::{DepthFormat, Host, HostImage, ImageState, MemorySource};

/// As [`crate::view::Camera::view`] projects it.
pub(super) const FORMAT: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
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
    pub(super) unsafe fn new(host: &Host, allocator: &mut dyn MemorySource, extent: [u32; 2]) -> Result<SharedDepth> {
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let format = FORMAT.format;
        let desc =
            ImageDesc { name: "depth", extent, layers: 1, array_view: false, format, usage, lifetime: Lifetime::Kept };
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

    /// As an effect takes it: the first one of a frame finds it cleared.
    pub(super) fn placed(&self, is_first: bool) -> HostImage {
        let (image, view) = (self.image.handle, self.image.view);
        let state_in = if is_first { CLEARED } else { DRAWN };
        let format = FORMAT.format;
        HostImage::new(image, view, format, self.extent, state_in, DRAWN)
    }

    /// Destroys it.
    ///
    /// # Safety
    /// As [`Image::destroy`].
    pub(super) unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        unsafe { self.image.destroy(host, allocator) };
    }
}
