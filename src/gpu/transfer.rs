//! Transfers of a host without a window: volumes and pictures to the device, frames and layers from it.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::buffer::{Buffer, BufferDesc, READ_BACK, UPLOADED};
use crate::gpu::scratch::Lifetime;
use crate::host::{Host, HostBuffer, ImageState, MemorySource};

/// The state of an image that is copied from.
pub const COPIED_FROM: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::ALL_TRANSFER,
    access: vk::AccessFlags2::TRANSFER_READ,
    layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
};

/// The state of an image that has been cleared.
pub const CLEARED: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::ALL_TRANSFER,
    access: vk::AccessFlags2::TRANSFER_WRITE,
    layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
};

/// A buffer that the host writes and the device copies from. Grows as needed.
#[derive(Debug, Default)]
pub struct Upload(Option<Buffer>);

impl Upload {
    /// Puts `bytes` into the buffer, which is made anew if they do not fit.
    ///
    /// # Safety
    /// The device is done with what was uploaded before; `host` holds valid handles and is always the same one, and
    /// `allocator` belongs to its device.
    pub unsafe fn write(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        name: &'static str,
        bytes: &[u8],
    ) -> Result<HostBuffer> {
        let size = bytes.len() as u64;
        let (usage, properties, lifetime) = (vk::BufferUsageFlags::TRANSFER_SRC, UPLOADED, Lifetime::Kept);
        let desc = BufferDesc { name, size, usage, properties, lifetime };
        // SAFETY: the caller's.
        let buffer = unsafe { grown(&mut self.0, host, allocator, desc)? };
        let memory = buffer.mapped_mut().and_then(|memory| memory.get_mut(..bytes.len()));
        let unmapped = || Error::HostResource { name, why: "its memory cannot be mapped".into() };
        memory.ok_or_else(unmapped)?.copy_from_slice(bytes);
        // Submitting makes what the host wrote visible.
        let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
        Ok(HostBuffer { buffer: buffer.handle, offset: 0, size, stage, access })
    }

    /// Destroys the buffer.
    ///
    /// # Safety
    /// As for [`Upload::write`].
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        if let Some(mut buffer) = self.0.take() {
            // SAFETY: the caller's.
            unsafe { buffer.destroy(host, allocator) };
        }
    }
}

/// A range that is never empty, which a buffer's must not be; an upload has at least 16 bytes.
#[cfg(feature = "cli")]
pub fn at_least_a_row(buffer: HostBuffer) -> HostBuffer {
    HostBuffer { size: buffer.size.max(16), ..buffer }
}

/// A buffer that the device copies to and the host reads. Grows as needed.
#[derive(Debug, Default)]
pub struct Download(Option<Buffer>);

impl Download {
    /// A buffer of at least `size` bytes, made anew if it has fewer; what it held is lost then.
    ///
    /// # Safety
    /// The device is done with what was read back before; `host` holds valid handles and is always the same one, and
    /// `allocator` belongs to its device.
    pub unsafe fn fit(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        name: &'static str,
        size: u64,
    ) -> Result<()> {
        // SAFETY: the caller's.
        unsafe { grown(&mut self.0, host, allocator, readback(name, size)).map(drop) }
    }

    /// The buffer; none before [`Download::fit`].
    pub fn buffer(&self) -> Option<&Buffer> {
        self.0.as_ref()
    }

    /// The bytes that the device copied, once it has been waited for.
    pub fn bytes(&self) -> &[u8] {
        self.0.as_ref().and_then(Buffer::mapped).unwrap_or_default()
    }

    /// Destroys the buffer.
    ///
    /// # Safety
    /// As for [`Download::fit`].
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        if let Some(mut buffer) = self.0.take() {
            // SAFETY: the caller's.
            unsafe { buffer.destroy(host, allocator) };
        }
    }
}

/// The buffer, made anew if it is smaller than described.
///
/// # Safety
/// `host` and `allocator` are those that it was made with, and the device is done with it.
unsafe fn grown<'a>(
    buffer: &'a mut Option<Buffer>,
    host: &Host,
    allocator: &mut dyn MemorySource,
    desc: BufferDesc,
) -> Result<&'a mut Buffer> {
    // A buffer of no bytes does not exist.
    let desc = BufferDesc { size: desc.size.max(16), ..desc };
    // SAFETY: the caller's.
    unsafe {
        if let Some(mut small) = buffer.take_if(|buffer| buffer.size < desc.size) {
            small.destroy(host, allocator);
        }
        match buffer {
            Some(buffer) => Ok(buffer),
            None => Ok(buffer.insert(Buffer::new(host, allocator, &desc)?)),
        }
    }
}

/// A buffer that the device writes and the host reads.
pub fn readback(name: &'static str, size: u64) -> BufferDesc {
    let (usage, lifetime) = (vk::BufferUsageFlags::TRANSFER_DST, Lifetime::Kept);
    BufferDesc { name, size, usage, properties: READ_BACK, lifetime }
}

/// Where a copy of an image or of a range of a buffer starts in the buffer that it goes to.
#[derive(Clone, Copy, Debug)]
pub struct Copy<T> {
    /// The source of the copy.
    pub from: T,
    /// Bytes; a multiple of 16.
    pub to: u64,
}

/// Records copies into `to` after everything recorded before, and makes them visible to the host.
///
/// # Safety
/// `host` holds valid handles and `commands` is in recording state outside of a render pass. Images are colour images of
/// these extents in state [`COPIED_FROM`], ranges are buffer, offset and size, and all fit into `to`.
pub unsafe fn record_readback(
    host: &Host,
    commands: vk::CommandBuffer,
    images: &[Copy<(vk::Image, [u32; 2])>],
    ranges: &[Copy<(vk::Buffer, u64, u64)>],
    to: &Buffer,
) {
    use vk::{AccessFlags2 as Access, PipelineStageFlags2 as Stage};
    let barrier = |src: (Stage, Access), dst: (Stage, Access)| {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(src.0)
            .src_access_mask(src.1)
            .dst_stage_mask(dst.0)
            .dst_access_mask(dst.1)];
        // SAFETY: the caller's.
        unsafe {
            host.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&barriers));
        }
    };
    barrier((Stage::ALL_COMMANDS, Access::MEMORY_WRITE), (Stage::ALL_TRANSFER, Access::TRANSFER_READ));
    for Copy { from: (image, extent), to: offset } in images {
        let regions = [image_copy(*offset, *extent)];
        let layout = COPIED_FROM.layout;
        // SAFETY: the caller's.
        unsafe { host.device.cmd_copy_image_to_buffer(commands, *image, layout, to.handle, &regions) };
    }
    for Copy { from: (buffer, src_offset, size), to: dst_offset } in ranges {
        let regions = [vk::BufferCopy { src_offset: *src_offset, dst_offset: *dst_offset, size: *size }];
        // SAFETY: the caller's.
        unsafe { host.device.cmd_copy_buffer(commands, *buffer, to.handle, &regions) };
    }
    barrier((Stage::ALL_TRANSFER, Access::TRANSFER_WRITE), (Stage::HOST, Access::HOST_READ));
}

/// Records copies from places in a buffer to ranges (buffer, offset and size) and makes them visible to all that follows.
///
/// # Safety
/// `host` holds valid handles and `commands` is in recording state outside of a render pass; nothing else uses the ranges, and
/// `from` holds all that is copied.
#[cfg(feature = "cli")]
pub unsafe fn record_upload(
    host: &Host,
    commands: vk::CommandBuffer,
    from: vk::Buffer,
    copies: &[(u64, (vk::Buffer, u64, u64))],
) {
    for (src_offset, (buffer, dst_offset, size)) in copies {
        let regions = [vk::BufferCopy { src_offset: *src_offset, dst_offset: *dst_offset, size: *size }];
        // SAFETY: the caller's.
        unsafe { host.device.cmd_copy_buffer(commands, from, *buffer, &regions) };
    }
    let after = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
        .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().memory_barriers(&after)) };
}

/// Records zeroes over a range of a buffer.
///
/// # Safety
/// `host` holds valid handles and `commands` is in recording state outside of a render pass; nothing else uses the range.
pub unsafe fn record_zeroes(host: &Host, commands: vk::CommandBuffer, buffer: vk::Buffer, offset: u64, size: u64) {
    // SAFETY: the caller's; fills are whole words.
    unsafe { host.device.cmd_fill_buffer(commands, buffer, offset, size & !3, 0) };
}

/// Records the upload of a picture's pixels into a fresh image and leaves it in state [`COPIED_FROM`].
///
/// # Safety
/// `host` holds valid handles and `commands` is in recording state outside of a render pass. The image is a colour image
/// of this extent that nothing uses, and `from` holds its pixels without gaps.
pub unsafe fn record_picture(
    host: &Host,
    commands: vk::CommandBuffer,
    from: &HostBuffer,
    image: vk::Image,
    extent: [u32; 2],
) {
    let target = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
    let subresource_range = vk::ImageSubresourceRange {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: 1,
    };
    let whole = || {
        vk::ImageMemoryBarrier2::default()
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image)
            .subresource_range(subresource_range)
    };
    let written = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
    let before = [whole().dst_stage_mask(written.0).dst_access_mask(written.1).new_layout(target)];
    let after = [whole()
        .src_stage_mask(written.0)
        .src_access_mask(written.1)
        .dst_stage_mask(COPIED_FROM.stage)
        .dst_access_mask(COPIED_FROM.access)
        .old_layout(target)
        .new_layout(COPIED_FROM.layout)];
    let regions = [image_copy(from.offset, extent)];
    // SAFETY: the caller's.
    unsafe {
        host.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&before));
        host.device.cmd_copy_buffer_to_image(commands, from.buffer, image, target, &regions);
        host.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&after));
    }
}

/// Records one depth over all of a depth image, whatever it held, and leaves it in state [`CLEARED`].
///
/// # Safety
/// `host` holds valid handles and `commands` is in recording state outside of a render pass. The image has a depth and no
/// stencil, and is as a copy target can be.
pub unsafe fn record_depth(host: &Host, commands: vk::CommandBuffer, image: vk::Image, depth: f32) {
    let value = vk::ClearDepthStencilValue { depth, stencil: 0 };
    // SAFETY: the caller's.
    unsafe {
        let range = record_clearing(host, commands, image, vk::ImageAspectFlags::DEPTH);
        host.device.cmd_clear_depth_stencil_image(commands, image, CLEARED.layout, &value, &[range]);
    }
}

/// Records zeroes over all of a colour image, whatever it held, and leaves it in state [`CLEARED`].
///
/// # Safety
/// `host` holds valid handles and `commands` is in recording state outside of a render pass. The image has colours, and is as a
/// copy target can be.
#[cfg(feature = "cli")]
pub unsafe fn record_black(host: &Host, commands: vk::CommandBuffer, image: vk::Image) {
    let value = vk::ClearColorValue { float32: [0.0; 4] };
    // SAFETY: the caller's.
    unsafe {
        let range = record_clearing(host, commands, image, vk::ImageAspectFlags::COLOR);
        host.device.cmd_clear_color_image(commands, image, CLEARED.layout, &value, &[range]);
    }
}

/// Records what there must be before an image is cleared; all of it.
///
/// # Safety
/// As for what clears it.
unsafe fn record_clearing(
    host: &Host,
    commands: vk::CommandBuffer,
    image: vk::Image,
    aspect_mask: vk::ImageAspectFlags,
) -> vk::ImageSubresourceRange {
    let range = vk::ImageSubresourceRange {
        aspect_mask,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: 1,
    };
    let barriers = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_stage_mask(CLEARED.stage)
        .dst_access_mask(CLEARED.access)
        .new_layout(CLEARED.layout)
        .image(image)
        .subresource_range(range)];
    // SAFETY: the caller's.
    unsafe {
        host.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&barriers));
    }
    range
}

fn image_copy(offset: u64, [width, height]: [u32; 2]) -> vk::BufferImageCopy {
    let layers = vk::ImageSubresourceLayers {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        mip_level: 0,
        base_array_layer: 0,
        layer_count: 1,
    };
    vk::BufferImageCopy::default().buffer_offset(offset).image_subresource(layers).image_extent(vk::Extent3D {
        width,
        height,
        depth: 1,
    })
}
