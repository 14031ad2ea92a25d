//! What tests do as a host of the effects: images and buffers of their own, commands that are recorded, submitted and waited
//! for, and everything read back. That validation says nothing is seen to by the device itself.

use std::collections::VecDeque;

use ash::vk;
use celfx::effect::ScratchRange;
use celfx::host::{Host, HostBuffer, HostImage, ImageState};
use celfx::low_level::gpu::buffer::{Buffer, BufferDesc, UPLOADED};
use celfx::low_level::gpu::headless::{Headless, Submission};
use celfx::low_level::gpu::image::{Image, ImageDesc};
use celfx::low_level::gpu::scratch::Lifetime;
use celfx::low_level::gpu::transfer::{COPIED_FROM, readback};

use super::TestDevice;

/// Where and how memory is used.
pub type Use = (vk::PipelineStageFlags2, vk::AccessFlags2);

/// Whatever comes before, all of it written.
pub const ALL_WRITTEN: Use = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
/// Whatever comes after.
pub const ALL: Use = (
    vk::PipelineStageFlags2::ALL_COMMANDS,
    vk::AccessFlags2::from_raw(vk::AccessFlags2::MEMORY_READ.as_raw() | vk::AccessFlags2::MEMORY_WRITE.as_raw()),
);
/// What transfers have written, and what they may do next.
pub const TRANSFER_WRITTEN: Use = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
pub const TRANSFERRED: Use = (
    vk::PipelineStageFlags2::ALL_TRANSFER,
    vk::AccessFlags2::from_raw(vk::AccessFlags2::TRANSFER_READ.as_raw() | vk::AccessFlags2::TRANSFER_WRITE.as_raw()),
);
/// Mapped memory is read.
pub const HOST_READ: Use = (vk::PipelineStageFlags2::HOST, vk::AccessFlags2::HOST_READ);

/// An image whose pixels do not matter any more: if it has been used, it was copied from last.
pub const DISCARDED: ImageState = ImageState { layout: vk::ImageLayout::UNDEFINED, ..COPIED_FROM };

/// All of an image.
pub fn whole(aspect_mask: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange { aspect_mask, base_mip_level: 0, level_count: 1, base_array_layer: 0, layer_count: 1 }
}

/// The pixels of an image, and those of a buffer without gaps.
pub fn image_copy(aspect_mask: vk::ImageAspectFlags, [width, height]: [u32; 2]) -> vk::BufferImageCopy {
    let layers = vk::ImageSubresourceLayers { aspect_mask, mip_level: 0, base_array_layer: 0, layer_count: 1 };
    let extent = vk::Extent3D { width, height, depth: 1 };
    vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)
}

/// Makes `after` wait for `before`.
///
/// # Safety
/// As for all that records: `host` holds valid handles, and `commands` are being recorded outside of a render pass.
pub unsafe fn barrier(host: &Host, commands: vk::CommandBuffer, before: Use, after: Use) {
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(before.0)
        .src_access_mask(before.1)
        .dst_stage_mask(after.0)
        .dst_access_mask(after.1)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}

/// Changes the state of an image.
///
/// # Safety
/// As for [`barrier`]; the image is alive and in state `from`.
pub unsafe fn change(
    host: &Host,
    commands: vk::CommandBuffer,
    (image, aspect): (vk::Image, vk::ImageAspectFlags),
    from: ImageState,
    to: ImageState,
) {
    // SAFETY: the caller's.
    unsafe { change_range(host, commands, (image, whole(aspect)), from, to) };
}

/// The same of some levels and layers.
///
/// # Safety
/// As for [`change`].
pub unsafe fn change_range(
    host: &Host,
    commands: vk::CommandBuffer,
    (image, range): (vk::Image, vk::ImageSubresourceRange),
    from: ImageState,
    to: ImageState,
) {
    let barriers = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(from.stage)
        .src_access_mask(from.access)
        .dst_stage_mask(to.stage)
        .dst_access_mask(to.access)
        .old_layout(from.layout)
        .new_layout(to.layout)
        .image(image)
        .subresource_range(range)];
    let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}

/// Copies an image in state [`COPIED_FROM`] to the start of where the host reads it.
///
/// # Safety
/// As for [`barrier`]; the image has this aspect and size, and its pixels fit into `to`.
pub unsafe fn show(
    host: &Host,
    commands: vk::CommandBuffer,
    (image, aspect): (vk::Image, vk::ImageAspectFlags),
    size: [u32; 2],
    to: &Buffer,
) {
    // SAFETY: the caller's.
    unsafe {
        let regions = [image_copy(aspect, size)];
        host.device.cmd_copy_image_to_buffer(commands, image, COPIED_FROM.layout, to.handle, &regions);
        barrier(host, commands, TRANSFER_WRITTEN, HOST_READ);
    }
}

/// An image that effects and transfers read and write.
pub fn image(device: &mut TestDevice, extent: [u32; 2], format: vk::Format) -> Image {
    let attachment = match format {
        vk::Format::D32_SFLOAT => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        _ => vk::ImageUsageFlags::COLOR_ATTACHMENT,
    };
    let usage = attachment | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
    let (host, allocator) = device.parts();
    // SAFETY: the handles are the device's own.
    unsafe {
        let desc =
            ImageDesc { name: "test", extent, layers: 1, array_view: false, format, usage, lifetime: Lifetime::Kept };
        Image::new(&host, allocator, &desc)
    }
    .expect("an image")
}

/// Where a picture lies in a larger image: `corner` pixels from the upper left, as many more than that below and to the right.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    pub size: [u32; 2],
    pub corner: [u32; 2],
}

impl Place {
    /// Of the image.
    pub fn extent(&self) -> [u32; 2] {
        [0, 1].map(|axis| self.size[axis] + 2 * self.corner[axis])
    }

    /// Pixels of the picture, and those beside it.
    pub fn parts<T: Copy>(&self, pixels: &[T]) -> (Vec<T>, Vec<T>) {
        let width = self.extent()[0] as usize;
        assert_eq!(pixels.len(), width * self.extent()[1] as usize);
        let is_inside = |i: usize| {
            let at = [(i % width) as u32, (i / width) as u32];
            (0..2).all(|axis| (self.corner[axis]..self.corner[axis] + self.size[axis]).contains(&at[axis]))
        };
        let part = |inside: bool| (0..pixels.len()).filter(|i| is_inside(*i) == inside).map(|i| pixels[i]).collect();
        (part(true), part(false))
    }

    /// The image's pixels, with this picture, and `beside` around it.
    pub fn around<T: Copy>(&self, picture: &[T], beside: T) -> Vec<T> {
        let mut pixels = vec![beside; (self.extent()[0] * self.extent()[1]) as usize];
        let width = self.size[0] as usize;
        for (y, row) in picture.chunks(width).enumerate() {
            let start = (y + self.corner[1] as usize) * self.extent()[0] as usize + self.corner[0] as usize;
            pixels[start..start + width].copy_from_slice(row);
        }
        pixels
    }

    /// An image as an effect is given it.
    pub fn given(&self, image: &Image, format: vk::Format, from: ImageState, to: ImageState) -> HostImage {
        HostImage { offset: self.corner, ..host_image(image, self.extent(), format, from, to) }
    }
}

/// An image as an effect is given it.
pub fn host_image(
    image: &Image,
    extent: [u32; 2],
    format: vk::Format,
    state_in: ImageState,
    state_out: ImageState,
) -> HostImage {
    HostImage::new(image.handle, image.view, format, extent, state_in, state_out)
}

/// A buffer that the host writes and the device copies from.
pub fn source(device: &mut TestDevice, bytes: u64) -> Buffer {
    use vk::BufferUsageFlags as Use;
    let (usage, properties) = (Use::TRANSFER_SRC | Use::TRANSFER_DST | Use::STORAGE_BUFFER, UPLOADED);
    buffer(device, &BufferDesc { name: "test", size: bytes.max(16), usage, properties, lifetime: Lifetime::Kept })
}

/// A buffer that the device copies to and the host reads.
pub fn sink(device: &mut TestDevice, bytes: u64) -> Buffer {
    buffer(device, &readback("test", bytes.max(16)))
}

fn buffer(device: &mut TestDevice, desc: &BufferDesc) -> Buffer {
    let (host, allocator) = device.parts();
    // SAFETY: the handles are the device's own.
    unsafe { Buffer::new(&host, allocator, desc) }.expect("a buffer")
}

/// Writes the start of a [`source`]: all of it as an effect is given it.
pub fn fill<T: bytemuck::NoUninit>(buffer: &mut Buffer, values: &[T]) -> HostBuffer {
    let bytes: &[u8] = bytemuck::cast_slice(values);
    buffer.mapped_mut().expect("mapped memory")[..bytes.len()].copy_from_slice(bytes);
    // Submitting makes what the host wrote visible.
    let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
    HostBuffer { buffer: buffer.handle, offset: 0, size: buffer.size, stage, access }
}

/// Destroys buffers and images, which nothing on its way uses.
pub fn destroy<'a>(
    device: &mut TestDevice,
    buffers: impl IntoIterator<Item = &'a mut Buffer>,
    images: impl IntoIterator<Item = &'a mut Image>,
) {
    let (host, allocator) = device.parts();
    // SAFETY: every submission has been waited for.
    unsafe {
        buffers.into_iter().for_each(|buffer| buffer.destroy(&host, allocator));
        images.into_iter().for_each(|image| image.destroy(&host, allocator));
    }
}

/// Words that no frame may find in what it has not written: all bits, and a quiet NaN.
pub const POISONS: [u32; 2] = [u32::MAX, 0x7fc0_dead];

/// A buffer over all of scratch memory, that can be filled.
pub fn over(host: &Host, range: ScratchRange) -> vk::Buffer {
    let info = vk::BufferCreateInfo::default().size(range.bytes).usage(vk::BufferUsageFlags::TRANSFER_DST);
    // SAFETY: valid handles; the range begins where any buffer may.
    unsafe {
        let buffer = host.device.create_buffer(&info, None).expect("a buffer");
        host.device.bind_buffer_memory(buffer, range.memory, range.offset).expect("it fits");
        buffer
    }
}

/// Fills scratch memory with a word between frames.
pub fn poison(device: &mut Headless, scratch: Option<ScratchRange>, word: u32) {
    let buffer = over(&device.parts().0, scratch.expect("scratch memory"));
    let done = device.one_time("poison", |host, commands| {
        // SAFETY: nothing else is on its way, and nothing in the range is needed.
        unsafe { host.device.cmd_fill_buffer(commands, buffer, 0, vk::WHOLE_SIZE, word) };
        Ok(())
    });
    done.expect("it runs");
    // SAFETY: it has been waited for.
    unsafe { device.parts().0.device.destroy_buffer(buffer, None) };
}

/// Records, submits and waits.
pub fn run(device: &mut TestDevice, record: impl FnOnce(&Host, vk::CommandBuffer)) {
    let done = device.one_time("test", |host, commands| {
        record(host, commands);
        Ok(())
    });
    done.expect("it runs");
}

/// The first values of a range of a buffer: handle, offset and size.
pub fn read<T: bytemuck::AnyBitPattern>(
    device: &mut TestDevice,
    (from, src_offset, available): (vk::Buffer, u64, u64),
    count: usize,
) -> Vec<T> {
    let size = (count * size_of::<T>()) as u64;
    assert!(size <= available, "there are {available} bytes, not {size}");
    if size == 0 {
        return Vec::new();
    }
    read_back(device, size, |host, commands, to| {
        // SAFETY: both buffers are alive.
        unsafe {
            let regions = [vk::BufferCopy { src_offset, dst_offset: 0, size }];
            host.device.cmd_copy_buffer(commands, from, to.handle, &regions);
        }
    })
}

/// All pixels of an image in state [`COPIED_FROM`].
pub fn read_image<T: bytemuck::AnyBitPattern>(device: &mut TestDevice, image: &Image, size: [u32; 2]) -> Vec<T> {
    let bytes = u64::from(size[0]) * u64::from(size[1]) * size_of::<T>() as u64;
    let regions = [image_copy(image.aspect, size)];
    read_back(device, bytes, |host, commands, to| {
        // SAFETY: image and buffer are alive.
        unsafe {
            host.device.cmd_copy_image_to_buffer(commands, image.handle, COPIED_FROM.layout, to.handle, &regions);
        }
    })
}

/// What `copy` puts into a buffer after everything before.
fn read_back<T: bytemuck::AnyBitPattern>(
    device: &mut TestDevice,
    bytes: u64,
    copy: impl FnOnce(&Host, vk::CommandBuffer, &Buffer),
) -> Vec<T> {
    let mut to = sink(device, bytes);
    run(device, |host, commands| {
        // SAFETY: commands are being recorded, and nothing else is on its way.
        unsafe {
            barrier(host, commands, ALL_WRITTEN, TRANSFERRED);
            copy(host, commands, &to);
            barrier(host, commands, TRANSFER_WRITTEN, HOST_READ);
        }
    });
    let values = values(&to, bytes as usize / size_of::<T>());
    destroy(device, [&mut to], []);
    values
}

/// The first values of a [`sink`].
pub fn values<T: bytemuck::AnyBitPattern>(buffer: &Buffer, count: usize) -> Vec<T> {
    let bytes = &buffer.mapped().expect("mapped memory")[..count * size_of::<T>()];
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

/// Records frames, each with one of `slots` in turn, and submits them: as many are on their way as there are slots. What
/// `shown` makes of each one's slot when it has been waited for.
pub fn in_flight<S, T>(
    device: &mut TestDevice,
    slots: &mut [S],
    frames: u32,
    mut record: impl FnMut(&Host, vk::CommandBuffer, &mut S, u32),
    shown: impl Fn(&S) -> T,
) -> Vec<T> {
    let count = slots.len();
    let mut on_their_way: VecDeque<(usize, Submission)> = VecDeque::new();
    let mut ended = Vec::new();
    for frame in 0..frames as usize + count {
        let slot = frame % count;
        if on_their_way.len() == count || frame >= frames as usize {
            let Some((slot, submission)) = on_their_way.pop_front() else { break };
            device.wait(submission).expect("it ends");
            ended.push(shown(&slots[slot]));
        }
        if frame < frames as usize {
            let commands = device.begin().expect("commands");
            record(&device.host(), commands.raw(), &mut slots[slot], frame as u32);
            on_their_way.push_back((slot, device.start(commands, "frame").expect("it starts")));
        }
    }
    ended
}
