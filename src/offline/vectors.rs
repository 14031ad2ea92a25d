//! The motion vectors of a picture, to which all of its effects add their own.

use ash::vk;

use crate::error::Result;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::scratch::Lifetime;
use crate::gpu::transfer::{CLEARED, COPIED_FROM, record_black};
use crate::host::{Host, HostImage, MemorySource};

/// As effects write them.
pub(super) const FORMAT: vk::Format = vk::Format::R32G32_SFLOAT;

/// The image of motion vectors.
pub(super) struct SharedVectors {
    image: Image,
    extent: [u32; 2],
}

impl SharedVectors {
    /// Makes it.
    ///
    /// # Safety
    /// As [`Image::new`].
    pub(super) unsafe fn new(host: &Host, allocator: &mut dyn MemorySource, extent: [u32; 2]) -> Result<SharedVectors> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let (format, lifetime) = (FORMAT, Lifetime::Kept);
        let desc = ImageDesc { name: "motion vectors", extent, layers: 1, array_view: false, format, usage, lifetime };
        // SAFETY: the caller's.
        Ok(SharedVectors { image: unsafe { Image::new(host, allocator, &desc)? }, extent })
    }

    /// Begins a frame: nothing moves.
    ///
    /// # Safety
    /// As [`record_black`]; every frame before has been waited for.
    pub(super) unsafe fn clear(&self, host: &Host, commands: vk::CommandBuffer) {
        // SAFETY: the caller's.
        unsafe { record_black(host, commands, self.image.handle) };
    }

    /// As an effect takes it: the first one of a frame finds it cleared.
    pub(super) fn placed(&self, is_first: bool) -> HostImage {
        let state_in = if is_first { CLEARED } else { COPIED_FROM };
        HostImage::new(self.image.handle, self.image.view, FORMAT, self.extent, state_in, COPIED_FROM)
    }

    /// What is read back after the effects: where each pixel's place was a frame earlier, in pixels to the right and down.
    pub(super) fn source(&self) -> (vk::Image, [u32; 2]) {
        (self.image.handle, self.extent)
    }

    /// Bytes of that.
    pub(super) fn bytes(&self) -> u64 {
        self.extent.iter().map(|side| u64::from(*side)).product::<u64>() * size_of::<[f32; 2]>() as u64
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
