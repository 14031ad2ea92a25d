//! Pictures in images of the host's own.

use ash::vk;

use super::TARGET_FORMAT;
use crate::error::{Error, Result};
use crate::gpu::headless::Headless;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::scratch::Lifetime;
use crate::gpu::transfer::{Upload, record_picture};
use crate::host::{HostImage, ImageState};

/// Description of the images of pictures.
pub(crate) fn image_desc(name: &'static str, extent: [u32; 2]) -> ImageDesc {
    // A backdrop is only copied, but every image has a view, and a view needs a usage of its own.
    let usage =
        vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
    ImageDesc { name, extent, layers: 1, array_view: false, format: TARGET_FORMAT, usage, lifetime: Lifetime::Kept }
}

/// Such an image, as an effect takes it and leaves it: to be copied from.
pub(crate) fn host_image(image: &Image, extent: [u32; 2], state_in: ImageState) -> HostImage {
    let state_out = crate::gpu::transfer::COPIED_FROM;
    HostImage::new(image.handle, image.view, TARGET_FORMAT, extent, state_in, state_out)
}

/// Bytes of a picture.
pub(crate) fn pixel_bytes(size: [u32; 2]) -> u64 {
    u64::from(size[0]) * u64::from(size[1]) * size_of::<[f32; 4]>() as u64
}

/// Puts a picture of so many pixels into an image that is there, or into a new one.
///
/// # Errors
/// Another size; no memory; a failed Vulkan call; a device that does not answer. The image is gone then.
pub(crate) fn put(
    device: &mut Headless,
    upload: &mut Upload,
    name: &'static str,
    image: Option<Image>,
    size: [u32; 2],
    pixels: &[[f32; 4]],
) -> Result<Image> {
    let bytes: &[u8] = bytemuck::cast_slice(pixels);
    let is_whole = bytes.len() as u64 == pixel_bytes(size);
    let (host, allocator) = device.parts();
    // SAFETY: the device is this host's own, and every submission has been waited for.
    unsafe {
        let mut image = match image {
            Some(image) => image,
            None => Image::new(&host, allocator, &image_desc(name, size))?,
        };
        let wrong = || Error::HostResource { name, why: format!("{} pixels, {size:?} expected", pixels.len()) };
        let upload = if is_whole { upload.write(&host, allocator, "upload", bytes) } else { Err(wrong()) };
        let done = upload.and_then(|from| {
            device.one_time(name, |host, commands| {
                // Buffer and image are alive until the wait is over, and nothing else uses them.
                record_picture(host, commands, &from, image.handle, size);
                Ok(())
            })
        });
        if done.is_err() && !device.is_stuck() {
            let (host, allocator) = device.parts();
            image.destroy(&host, allocator);
        }
        done.map(|()| image)
    }
}
