//! Images with a name and views, and memory of their own or a place in scratch memory.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::debug;
use crate::gpu::scratch::Lifetime;
use crate::host::{Allocation, Host, MemoryRequest, MemorySource};

/// Description of an image: two-dimensional, one mip level, single-sampled, optimal tiling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageDesc {
    /// Debug name.
    pub name: &'static str,
    /// Pixels.
    pub extent: [u32; 2],
    /// Array layers, at least 1.
    pub layers: u32,
    /// Whether shaders see the whole image as an array.
    pub array_view: bool,
    /// Format; `D32_SFLOAT` makes a depth image.
    pub format: vk::Format,
    /// Its usage.
    pub usage: vk::ImageUsageFlags,
    /// How long what it holds is needed.
    pub lifetime: Lifetime,
}

impl ImageDesc {
    /// Its bytes, before alignment.
    pub fn bytes(&self) -> u64 {
        let [width, height] = self.extent.map(u64::from);
        width * height * u64::from(self.layers) * texel_bytes(self.format)
    }
}

/// Bytes of a texel of an uncompressed format; 0 for others.
pub fn texel_bytes(format: vk::Format) -> u64 {
    // The order of Vulkan's enumeration: by components, then by their size.
    match format.as_raw() {
        1 | 9..=15 | 127 => 1,
        2..=8 | 16..=22 | 70..=76 | 124 => 2,
        23..=36 => 3,
        37..=69 | 77..=83 | 98..=100 | 122 | 123 | 125 | 126 | 128 | 129 => 4,
        84..=90 => 6,
        91..=97 | 101..=103 | 110..=112 | 130 => 8,
        104..=106 => 12,
        107..=109 | 113..=115 => 16,
        116..=118 => 24,
        119..=121 => 32,
        _ => 0,
    }
}

/// An image that celfx made.
#[derive(Debug)]
pub struct Image {
    /// The handle.
    pub handle: vk::Image,
    /// The whole image: what shaders bind.
    pub view: vk::ImageView,
    /// One view a layer: what render passes attach.
    pub layer_views: Vec<vk::ImageView>,
    /// Colour or depth.
    pub aspect: vk::ImageAspectFlags,
    /// What it was made as.
    pub desc: ImageDesc,
    /// Whether it has left layout UNDEFINED.
    pub(crate) initialised: bool,
    /// Memory of its own, if it is not in scratch memory.
    allocation: Option<Allocation>,
}

impl Image {
    /// Creates the image, its memory and views; leaves nothing behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles, and `allocator` belongs to its device.
    pub unsafe fn new(host: &Host, allocator: &mut dyn MemorySource, desc: &ImageDesc) -> Result<Image> {
        // SAFETY: the caller's; never used before it is destroyed.
        unsafe {
            let mut image = Image::unbound(host, desc)?;
            match image.bind_own(host, allocator) {
                Ok(()) => Ok(image),
                Err(error) => {
                    image.destroy(host, allocator);
                    Err(error)
                }
            }
        }
    }

    /// Creates the image alone, without memory and views.
    ///
    /// # Safety
    /// `host` holds valid handles.
    pub(crate) unsafe fn unbound(host: &Host, desc: &ImageDesc) -> Result<Image> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.extent[0], height: desc.extent[1], depth: 1 })
            .mip_levels(1)
            .array_layers(desc.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage);
        // SAFETY: the caller's.
        let handle = unsafe { host.device.create_image(&info, None) };
        let handle = handle.map_err(Error::vulkan("vkCreateImage", desc.name))?;
        let aspect = match desc.format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        let (view, layer_views) = (vk::ImageView::null(), Vec::new());
        // SAFETY: `handle` was just made.
        unsafe { debug::set_name(host, handle, desc.name) };
        Ok(Image { handle, view, layer_views, aspect, desc: *desc, initialised: false, allocation: None })
    }

    /// What its memory must be.
    ///
    /// # Safety
    /// `host` is the one it was made with.
    pub(crate) unsafe fn requirements(&self, host: &Host) -> vk::MemoryRequirements {
        // SAFETY: the caller's.
        unsafe { host.device.get_image_memory_requirements(self.handle) }
    }

    /// Whether it lies in scratch memory: frames begin without what it holds.
    pub(crate) fn is_scratch(&self) -> bool {
        self.allocation.is_none()
    }

    /// Takes memory of its own.
    ///
    /// # Safety
    /// As [`Image::new`]; it has none.
    pub(crate) unsafe fn bind_own(&mut self, host: &Host, allocator: &mut dyn MemorySource) -> Result<()> {
        let (name, properties) = (self.desc.name, vk::MemoryPropertyFlags::DEVICE_LOCAL);
        // SAFETY: the caller's.
        let requirements = unsafe { self.requirements(host) };
        let allocation = allocator.allocate(&MemoryRequest { name, requirements, properties, linear: false })?;
        // SAFETY: fresh memory that fits the image's requirements.
        let bound = unsafe { self.bind(host, allocation.memory, allocation.offset) };
        self.allocation = Some(allocation);
        bound
    }

    /// Takes this memory, and makes views.
    ///
    /// # Safety
    /// It has none; this fits its requirements.
    pub(crate) unsafe fn bind(&mut self, host: &Host, memory: vk::DeviceMemory, offset: u64) -> Result<()> {
        let desc = self.desc;
        // SAFETY: the caller's; then the image is bound.
        unsafe {
            let bound = host.device.bind_image_memory(self.handle, memory, offset);
            bound.map_err(Error::vulkan("vkBindImageMemory", desc.name))?;
            self.view = self.make_view(host, &desc, 0, desc.layers, desc.array_view)?;
            for layer in 0..desc.layers {
                let view = self.make_view(host, &desc, layer, 1, false)?;
                self.layer_views.push(view);
            }
        }
        Ok(())
    }

    unsafe fn make_view(
        &self,
        host: &Host,
        desc: &ImageDesc,
        layer: u32,
        layers: u32,
        array: bool,
    ) -> Result<vk::ImageView> {
        let view_type = if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.handle)
            .view_type(view_type)
            .format(desc.format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: self.aspect,
                base_mip_level: 0,
                level_count: 1,
                base_array_layer: layer,
                layer_count: layers,
            });
        // SAFETY: the image is bound and has these layers.
        unsafe { host.device.create_image_view(&info, None) }.map_err(Error::vulkan("vkCreateImageView", desc.name))
    }

    /// Destroys the image and its views, and gives its memory back.
    ///
    /// # Safety
    /// The GPU is done with it; `host` and `allocator` are those it was made with.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's; null handles are ignored.
        unsafe {
            for view in self.layer_views.drain(..) {
                host.device.destroy_image_view(view, None);
            }
            host.device.destroy_image_view(self.view, None);
            host.device.destroy_image(self.handle, None);
        }
        self.view = vk::ImageView::null();
        self.handle = vk::Image::null();
        if let Some(allocation) = self.allocation.take() {
            allocator.free(allocation);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_have_the_bytes_of_their_components() {
        let cases = [
            (vk::Format::R8_UNORM, 1),
            (vk::Format::R5G6B5_UNORM_PACK16, 2),
            (vk::Format::R8G8_SRGB, 2),
            (vk::Format::R8G8B8_UNORM, 3),
            (vk::Format::B8G8R8_SRGB, 3),
            (vk::Format::R8G8B8A8_UNORM, 4),
            (vk::Format::B8G8R8A8_SRGB, 4),
            (vk::Format::A2B10G10R10_SINT_PACK32, 4),
            (vk::Format::R16_UNORM, 2),
            (vk::Format::R16G16_SFLOAT, 4),
            (vk::Format::R16G16B16A16_UNORM, 8),
            (vk::Format::R16G16B16A16_SFLOAT, 8),
            (vk::Format::R32_UINT, 4),
            (vk::Format::R32G32_UINT, 8),
            (vk::Format::R32G32B32A32_SFLOAT, 16),
            (vk::Format::R64G64B64A64_SFLOAT, 32),
            (vk::Format::B10G11R11_UFLOAT_PACK32, 4),
            (vk::Format::D16_UNORM, 2),
            (vk::Format::D32_SFLOAT, 4),
            (vk::Format::D32_SFLOAT_S8_UINT, 8),
            (vk::Format::BC1_RGB_UNORM_BLOCK, 0),
            (vk::Format::UNDEFINED, 0),
        ];
        for (format, bytes) in cases {
            assert_eq!(texel_bytes(format), bytes, "{format:?}");
        }
    }
}
