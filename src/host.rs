//! Types that a host hands over and gets back. Pure data: nothing here calls Vulkan.
//!
//! The host owns instance, device, queue, command buffer and synchronisation; celfx destroys exactly what it
//! created, submits nothing and waits for nothing.
//!
//! **Supported is not enabled.** [`requirements()`] says what celfx needs, before anything exists.
//! [`check_device`] says what a physical device does not *support*. What the host has *enabled* on its
//! `vk::Device` cannot be read back from it: the host must have enabled everything in
//! [`Requirements::features`], for instance with [`Features::enable`] on its own create chain.

mod check;
mod memory;
mod temporal;

use ash::vk;

pub use crate::gpu::capabilities::check_device;
pub(crate) use check::*;
pub use memory::{Allocation, CallbackAllocation, CallbackRequest, MemoryCallbacks, MemoryRequest, MemorySource};
pub use temporal::{MOTION_FORMATS, REACTIVE_FORMATS, TemporalFormats, TemporalImages};

/// The host's Vulkan objects, borrowed for the length of a call.
#[derive(Clone, Copy)]
pub struct Host<'a> {
    /// Created for Vulkan 1.3 or later.
    pub instance: &'a ash::Instance,
    /// The device's physical device; [`check_device`] finds nothing missing on it.
    pub physical_device: vk::PhysicalDevice,
    /// Created with the features that [`requirements()`] names.
    pub device: &'a ash::Device,
    /// If `VK_EXT_debug_utils` is enabled: passes get labels and objects get names. Works without.
    /// `ash::ext::debug_utils::Device::new` makes one.
    pub debug: Option<&'a ash::ext::debug_utils::Device>,
    /// Used for every pipeline that celfx creates; may be `vk::PipelineCache::null()`.
    pub pipeline_cache: vk::PipelineCache,
}

/// The last use of an image, or the next one: stages, accesses and layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageState {
    /// Stages that touch the image.
    pub stage: vk::PipelineStageFlags2,
    /// How they touch it.
    pub access: vk::AccessFlags2,
    /// The layout that they see.
    pub layout: vk::ImageLayout,
}

/// A layer of a mip level of an image of the host, exclusive to the queue family that celfx records for. Others of the same image
/// are not touched, and may be in any state.
#[derive(Clone, Copy, Debug)]
pub struct HostImage {
    /// The image; it stays the host's.
    pub image: vk::Image,
    /// A 2-D view of that layer of that level; it stays the host's.
    pub view: vk::ImageView,
    /// Format of the view.
    pub format: vk::Format,
    /// Samples a pixel: `TYPE_1`. Resolve images that have more.
    pub samples: vk::SampleCountFlags,
    /// Width and height of the level in pixels, both at least 1.
    pub extent: [u32; 2],
    /// Where the picture's upper left pixel lies in it: all of the picture does. What lies beside it is not touched.
    pub offset: [u32; 2],
    /// The mip level.
    pub base_mip: u32,
    /// The layer.
    pub base_layer: u32,
    /// Its state when the recorded commands begin; layout `UNDEFINED` where its contents do not matter; stages and
    /// accesses are waited for all the same.
    pub state_in: ImageState,
    /// The state that celfx leaves it in; not `UNDEFINED`.
    pub state_out: ImageState,
}

impl HostImage {
    /// The only layer of the only level of an image with one sample a pixel, from its upper left pixel on.
    pub fn new(
        image: vk::Image,
        view: vk::ImageView,
        format: vk::Format,
        extent: [u32; 2],
        state_in: ImageState,
        state_out: ImageState,
    ) -> HostImage {
        let samples = vk::SampleCountFlags::TYPE_1;
        HostImage {
            image,
            view,
            format,
            samples,
            extent,
            offset: [0; 2],
            base_mip: 0,
            base_layer: 0,
            state_in,
            state_out,
        }
    }
}

/// A range of a buffer of the host, exclusive to the queue family that celfx records for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostBuffer {
    /// The buffer; it stays the host's.
    pub buffer: vk::Buffer,
    /// Start of the range in bytes, a multiple of the device's `minStorageBufferOffsetAlignment`.
    pub offset: u64,
    /// Length of the range in bytes, at least 1.
    pub size: u64,
    /// Stages that touched the range last; `NONE` if the host has already made it visible.
    pub stage: vk::PipelineStageFlags2,
    /// How they touched it.
    pub access: vk::AccessFlags2,
}

/// The background of an effect.
#[derive(Clone, Copy, Debug, Default)]
pub enum Background {
    /// The target's own content. A blur writes its whole target and keeps nothing of it: to draw over a picture, hand it a copy of that.
    #[default]
    Keep,
    /// Linear RGBA, premultiplied; none beyond [`crate::view::BRIGHTEST`].
    Clear([f32; 4]),
    /// An image of the target's format. Usage: `TRANSFER_SRC`; target: `TRANSFER_DST`.
    Copy(HostImage),
}

impl Background {
    /// Its image, if it is one.
    pub fn image(&self) -> Option<HostImage> {
        match self {
            Background::Copy(image) => Some(*image),
            Background::Keep | Background::Clear(_) => None,
        }
    }
}

/// How the host's depth images hold depth: as the frame's [`crate::view::View`] projects it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthFormat {
    /// A format that can be a depth attachment.
    pub format: vk::Format,
    /// Whether nearer is larger.
    pub reversed: bool,
}

/// Device memory in bytes, known before anything is created.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Memory {
    /// Bytes of what must survive from frame to frame.
    pub history: u64,
    /// Bytes of the range of all that each frame writes anew. Effects that never run at once can share it
    /// ([`crate::effect::ScratchPool`]).
    pub scratch: u64,
    /// Bytes of images, which devices pad, among both.
    pub images: u64,
}

impl Memory {
    /// `history` and `scratch` together, in bytes.
    pub fn total(&self) -> u64 {
        self.history.saturating_add(self.scratch)
    }
}

/// The features of Vulkan 1.3 that must be enabled on the device. Everything else is optional and unused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Features {
    /// `VkPhysicalDeviceVulkan13Features::dynamicRendering`.
    pub dynamic_rendering: bool,
    /// `VkPhysicalDeviceVulkan13Features::synchronization2`.
    pub synchronization2: bool,
}

impl Features {
    /// Switches these on in a structure of the host's own create chain; touches no other field of it.
    pub fn enable(&self, features: &mut vk::PhysicalDeviceVulkan13Features<'_>) {
        if self.dynamic_rendering {
            features.dynamic_rendering = vk::TRUE;
        }
        if self.synchronization2 {
            features.synchronization2 = vk::TRUE;
        }
    }
}

/// Limits, named as in `VkPhysicalDeviceLimits`; each must be at least this.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Invocations in a workgroup.
    pub max_compute_work_group_invocations: u32,
    /// Shared memory of a workgroup in bytes.
    pub max_compute_shared_memory_size: u32,
    /// Push constants in bytes.
    pub max_push_constants_size: u32,
    /// Storage buffers that one shader stage can see.
    pub max_per_stage_descriptor_storage_buffers: u32,
}

/// A format and what an optimally tiled image of it must be usable as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FormatUse {
    /// The format.
    pub format: vk::Format,
    /// The uses that the format must support.
    pub features: vk::FormatFeatureFlags,
}

/// Requirements of celfx on an instance and a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Requirements {
    /// Lowest version of both the instance and the device.
    pub api_version: u32,
    /// One queue family must have all of these.
    pub queue_flags: vk::QueueFlags,
    /// To be supported, and enabled by the host.
    pub features: Features,
    /// Lowest limits.
    pub limits: Limits,
    /// Formats and their uses.
    pub formats: [FormatUse; 3],
}

/// The requirements of celfx, whatever the effect: no optional feature, no extension.
pub fn requirements() -> Requirements {
    use vk::FormatFeatureFlags as Use;
    Requirements {
        api_version: vk::API_VERSION_1_3,
        queue_flags: vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE,
        features: Features { dynamic_rendering: true, synchronization2: true },
        limits: Limits {
            max_compute_work_group_invocations: 256,
            max_compute_shared_memory_size: 16 * 1024,
            max_push_constants_size: 128,
            max_per_stage_descriptor_storage_buffers: 12,
        },
        formats: [
            FormatUse { format: vk::Format::R32_UINT, features: Use::COLOR_ATTACHMENT | Use::STORAGE_IMAGE },
            FormatUse { format: vk::Format::D32_SFLOAT, features: Use::DEPTH_STENCIL_ATTACHMENT | Use::SAMPLED_IMAGE },
            FormatUse { format: vk::Format::R32G32B32A32_SFLOAT, features: Use::COLOR_ATTACHMENT },
        ],
    }
}

/// The capabilities of a physical device, as far as [`requirements()`] asks for them.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Capabilities {
    /// Version of the device.
    pub api_version: u32,
    /// Flags of each queue family.
    pub queue_flags: Vec<vk::QueueFlags>,
    /// Supported features; all false below Vulkan 1.3.
    pub features: Features,
    /// The device's limits.
    pub limits: Limits,
    /// The same formats in the same order as in [`Requirements::formats`], with all that each can be used as.
    pub formats: [FormatUse; 3],
}

impl Requirements {
    /// Names everything that a device with these capabilities lacks, one sentence each; empty: it can run celfx.
    pub fn missing(&self, device: &Capabilities) -> Vec<String> {
        let mut missing = Vec::new();
        if device.api_version < self.api_version {
            missing.push(format!("Vulkan {} (it has {})", version(self.api_version), version(device.api_version)));
        }
        if !device.queue_flags.iter().any(|flags| flags.contains(self.queue_flags)) {
            missing.push("a queue family with graphics and compute".into());
        }
        let features = [
            ("dynamicRendering", self.features.dynamic_rendering, device.features.dynamic_rendering),
            ("synchronization2", self.features.synchronization2, device.features.synchronization2),
        ];
        for (name, needed, supported) in features {
            if needed && !supported {
                missing.push(format!("feature {name}"));
            }
        }
        for ((name, needed), (_, has)) in self.limits.named().into_iter().zip(device.limits.named()) {
            if has < needed {
                missing.push(format!("{name} of {needed} (it has {has})"));
            }
        }
        for (needed, has) in self.formats.iter().zip(&device.formats) {
            let lacks = needed.features & !has.features;
            if !lacks.is_empty() {
                missing.push(format!("format {:?} as {lacks:?}", needed.format));
            }
        }
        missing
    }
}

impl Limits {
    fn named(&self) -> [(&'static str, u32); 4] {
        [
            ("maxComputeWorkGroupInvocations", self.max_compute_work_group_invocations),
            ("maxComputeSharedMemorySize", self.max_compute_shared_memory_size),
            ("maxPushConstantsSize", self.max_push_constants_size),
            ("maxPerStageDescriptorStorageBuffers", self.max_per_stage_descriptor_storage_buffers),
        ]
    }
}

/// `1.3.281`.
pub(crate) fn version(v: u32) -> String {
    format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sufficient() -> Capabilities {
        let r = requirements();
        Capabilities {
            api_version: r.api_version,
            queue_flags: vec![vk::QueueFlags::TRANSFER, r.queue_flags],
            features: r.features,
            limits: r.limits,
            formats: r.formats,
        }
    }

    #[test]
    fn a_device_that_just_suffices_lacks_nothing() {
        assert_eq!(requirements().missing(&sufficient()), Vec::<String>::new());
    }

    #[test]
    fn everything_that_is_missing_is_named_at_once() {
        let mut device = sufficient();
        device.api_version = vk::API_VERSION_1_2;
        device.queue_flags = vec![vk::QueueFlags::GRAPHICS, vk::QueueFlags::COMPUTE];
        device.features = Features::default();
        device.limits = Limits::default();
        device.formats.iter_mut().for_each(|f| f.features = vk::FormatFeatureFlags::SAMPLED_IMAGE);
        let missing = requirements().missing(&device);
        assert_eq!(
            missing,
            [
                "Vulkan 1.3.0 (it has 1.2.0)",
                "a queue family with graphics and compute",
                "feature dynamicRendering",
                "feature synchronization2",
                "maxComputeWorkGroupInvocations of 256 (it has 0)",
                "maxComputeSharedMemorySize of 16384 (it has 0)",
                "maxPushConstantsSize of 128 (it has 0)",
                "maxPerStageDescriptorStorageBuffers of 12 (it has 0)",
                "format R32_UINT as STORAGE_IMAGE | COLOR_ATTACHMENT",
                "format D32_SFLOAT as DEPTH_STENCIL_ATTACHMENT",
                "format R32G32B32A32_SFLOAT as COLOR_ATTACHMENT",
            ]
        );
    }

    #[test]
    fn enabling_touches_only_what_is_required() {
        let mut features = vk::PhysicalDeviceVulkan13Features::default().maintenance4(true);
        requirements().features.enable(&mut features);
        assert_eq!((features.dynamic_rendering, features.synchronization2), (vk::TRUE, vk::TRUE));
        assert_eq!((features.maintenance4, features.private_data), (vk::TRUE, vk::FALSE));
    }
}
