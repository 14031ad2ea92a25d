//! Targets and depth that are one layer of one mip level of an image. The others are in states of their own, and stay so.

use ash::vk;
use celfx::host::{DepthFormat, Host, HostImage, ImageState};
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM};
use celfx::offline::TARGET_FORMAT;
use celfx::profile::Timing;
use celfx::smoke::{Background, Desc, Frame, Smoke};

use crate::common::host::{self, HOST_READ, Place, TRANSFER_WRITTEN};
use crate::common::{TestDevice, device};
use crate::host::{SIZE, Slot, effect};

const LAYERS: u32 = 3;
const LEVELS: u32 = 2;
const DEPTH: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: false };
const SENTINEL: f32 = 0.25;

/// An array of images with mip levels, the second of which has the size of the effect.
struct Array {
    image: vk::Image,
    memory: vk::DeviceMemory,
    view: vk::ImageView,
    format: vk::Format,
    aspect: vk::ImageAspectFlags,
    level: u32,
    layer: u32,
    /// Where the picture lies in that level.
    place: Place,
}

impl Array {
    fn new(device: &TestDevice, format: vk::Format, [level, layer]: [u32; 2], corner: [u32; 2]) -> Array {
        let place = Place { size: SIZE, corner };
        let host = device.host();
        let (aspect, usage) = match format {
            vk::Format::D32_SFLOAT => (vk::ImageAspectFlags::DEPTH, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT),
            _ => (vk::ImageAspectFlags::COLOR, vk::ImageUsageFlags::COLOR_ATTACHMENT),
        };
        let [width, height] = place.extent().map(|side| side << level);
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(LEVELS)
            .array_layers(LAYERS)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST);
        // SAFETY: the device's own handles; the memory is fresh and large enough.
        unsafe {
            let image = host.device.create_image(&info, None).expect("an image");
            let needed = host.device.get_image_memory_requirements(image);
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(needed.size)
                .memory_type_index(needed.memory_type_bits.trailing_zeros());
            let memory = host.device.allocate_memory(&info, None).expect("memory");
            host.device.bind_image_memory(image, memory, 0).expect("it fits");
            let range = Array::range(aspect, level..level + 1, layer..layer + 1);
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(range);
            let view = host.device.create_image_view(&info, None).expect("a view");
            Array { image, memory, view, format, aspect, level, layer, place }
        }
    }

    fn range(
        aspect_mask: vk::ImageAspectFlags,
        levels: std::ops::Range<u32>,
        layers: std::ops::Range<u32>,
    ) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask,
            base_mip_level: levels.start,
            level_count: levels.end - levels.start,
            base_array_layer: layers.start,
            layer_count: layers.end - layers.start,
        }
    }

    /// Fills all of it; then what the effect gets is as a clear leaves it, and everything else as copies take it.
    unsafe fn fill(&self, host: &Host, commands: vk::CommandBuffer, value: f32) {
        let all = Array::range(self.aspect, 0..LEVELS, 0..LAYERS);
        let state = |from: ImageState, to: ImageState, range| {
            // SAFETY: the caller's.
            unsafe { host::change_range(host, commands, (self.image, range), from, to) };
        };
        state(ImageState::default(), CLEARED, all);
        // SAFETY: the caller's.
        unsafe {
            match self.aspect {
                vk::ImageAspectFlags::DEPTH => {
                    let depth = vk::ClearDepthStencilValue { depth: value, stencil: 0 };
                    let layout = CLEARED.layout;
                    host.device.cmd_clear_depth_stencil_image(commands, self.image, layout, &depth, &[all]);
                }
                _ => {
                    let colour = vk::ClearColorValue { float32: [value; 4] };
                    host.device.cmd_clear_color_image(commands, self.image, CLEARED.layout, &colour, &[all]);
                }
            }
        }
        for (level, layer) in (0..LEVELS).flat_map(|level| (0..LAYERS).map(move |layer| (level, layer))) {
            if (level, layer) != (self.level, self.layer) {
                state(CLEARED, COPIED_FROM, Array::range(self.aspect, level..level + 1, layer..layer + 1));
            }
        }
    }

    /// As the effect is given it.
    fn given(&self) -> HostImage {
        let (extent, offset) = (self.place.extent(), self.place.corner);
        let only = HostImage::new(self.image, self.view, self.format, extent, CLEARED, COPIED_FROM);
        HostImage { base_mip: self.level, base_layer: self.layer, offset, ..only }
    }

    /// Copies each layer of a level, one after the other.
    unsafe fn show(&self, host: &Host, commands: vk::CommandBuffer, level: u32, to: &Buffer) {
        let [width, height] = self.place.extent().map(|side| (side << self.level) >> level);
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: self.aspect,
            mip_level: level,
            base_array_layer: 0,
            layer_count: LAYERS,
        };
        let regions = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        })];
        // SAFETY: the caller's; all of the image is in the state that copies want.
        unsafe {
            host.device.cmd_copy_image_to_buffer(commands, self.image, COPIED_FROM.layout, to.handle, &regions);
            host::barrier(host, commands, TRANSFER_WRITTEN, HOST_READ);
        }
    }

    fn destroy(self, device: &TestDevice) {
        // SAFETY: every submission has been waited for.
        unsafe {
            device.host().device.destroy_image_view(self.view, None);
            device.host().device.destroy_image(self.image, None);
            device.host().device.free_memory(self.memory, None);
        }
    }
}

/// Target and depth in the images of `arrays`; every layer of the target's level, and the depth's.
fn render(device: &mut TestDevice, arrays: &[Array; 2]) -> (Vec<[f32; 4]>, Vec<f32>) {
    let desc = Desc { depth: Some(DEPTH), ..effect() };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, desc) }.expect("an effect");
    let mut slot = Slot::new(device, SIZE);
    let [target, depth] = arrays;
    let [width, height] = target.place.extent();
    let pixels = u64::from(width * height * LAYERS);
    let mut found = [host::sink(device, 16 * pixels), host::sink(device, 4 * pixels)];
    let good = slot.frame(0);
    let frame = Frame {
        view: good.view.with_reversed(false),
        target: Some(target.given()),
        depth: Some(depth.given()),
        background: Background::Keep,
        ..good
    };
    host::run(device, |host, commands| {
        // SAFETY: everything is the test's own and waited for.
        unsafe {
            target.fill(host, commands, SENTINEL);
            depth.fill(host, commands, 1.0);
            smoke.record(host, commands, &frame, &mut Timing::None).expect("a frame");
            target.show(host, commands, target.level, &found[0]);
            depth.show(host, commands, depth.level, &found[1]);
        }
    });
    let values = (host::values(&found[0], pixels as usize), host::values(&found[1], pixels as usize));
    slot.destroy(device);
    host::destroy(device, &mut found, []);
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.retire().destroy(&host, allocator) };
    values
}

#[test]
fn a_layer_of_a_level_is_a_target_like_any_other() {
    let Some(mut device) = device() else { return };
    let places = [
        ([0, 0], [0, 0], [0, 0]),
        ([1, 2], [0, 1], [0, 0]),
        ([0, 1], [1, 2], [0, 0]),
        ([0, 0], [0, 0], [3, 6]),
        ([1, 1], [0, 2], [40, 1]),
    ];
    let mut expected = None;
    for (of_target, of_depth, corner) in places {
        let arrays = [
            Array::new(&device, TARGET_FORMAT, of_target, corner),
            Array::new(&device, DEPTH.format, of_depth, corner),
        ];
        let place = arrays[0].place;
        let (colours, depths) = render(&mut device, &arrays);
        arrays.into_iter().for_each(|array| array.destroy(&device));
        let pixels = (place.extent()[0] * place.extent()[1]) as usize;
        let (mut picture, mut depth) = (Vec::new(), Vec::new());
        for (layer, (colours, depths)) in (0..).zip(colours.chunks(pixels).zip(depths.chunks(pixels))) {
            match layer == of_target[1] {
                true => {
                    let (inside, beside) = place.parts(colours);
                    assert!(beside.iter().all(|colour| *colour == [SENTINEL; 4]), "beside the picture");
                    picture = inside;
                }
                false => assert!(colours.iter().all(|colour| *colour == [SENTINEL; 4]), "layer {layer} has changed"),
            }
            match layer == of_depth[1] {
                true => {
                    let (inside, beside) = place.parts(depths);
                    assert!(beside.iter().all(|depth| *depth == 1.0), "beside the depth");
                    depth = inside;
                }
                false => assert!(depths.iter().all(|depth| *depth == 1.0), "depth of layer {layer} has changed"),
            }
        }
        assert!(depth.iter().any(|depth| *depth < 1.0), "no smoke");
        let expected = expected.get_or_insert_with(|| (picture.clone(), depth.clone()));
        assert!((picture, depth) == *expected, "level and layer {of_target:?}, depth {of_depth:?}");
    }
}
