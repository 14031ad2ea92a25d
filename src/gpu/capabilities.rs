//! Asks a physical device what it supports, and how much.

use ash::vk;

use crate::error::{Error, Result};
#[cfg(feature = "cli")]
use crate::host::Host;
use crate::host::{Capabilities, Features, Limits, requirements};
use crate::tuning::Tuning;

/// Names everything that a physical device lacks to run celfx, one entry each; empty: nothing.
///
/// This is about what the device *supports*. What the host has *enabled* is not visible to it.
///
/// # Safety
///
/// `instance` must be a valid instance that was created for Vulkan 1.3 or later, and `physical_device` one of its
/// physical devices.
pub unsafe fn check_device(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Vec<String> {
    // SAFETY: the caller's promise.
    requirements().missing(&unsafe { capabilities(instance, physical_device) })
}

/// The capabilities of a physical device.
///
/// # Safety
///
/// As for [`check_device`].
pub unsafe fn capabilities(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Capabilities {
    // SAFETY: the caller promises a valid instance of Vulkan 1.3 and one of its physical devices. The structure of
    // Vulkan 1.3 is only chained where the device knows it.
    unsafe {
        let properties = instance.get_physical_device_properties(physical_device);
        let mut vulkan_1_3 = vk::PhysicalDeviceVulkan13Features::default();
        if properties.api_version >= vk::API_VERSION_1_3 {
            let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan_1_3);
            instance.get_physical_device_features2(physical_device, &mut features);
        }
        let families = instance.get_physical_device_queue_family_properties(physical_device);
        let formats = requirements().formats.map(|mut f| {
            f.features =
                instance.get_physical_device_format_properties(physical_device, f.format).optimal_tiling_features;
            f
        });
        let limits = &properties.limits;
        Capabilities {
            api_version: properties.api_version,
            queue_flags: families.iter().map(|family| family.queue_flags).collect(),
            features: Features {
                dynamic_rendering: vulkan_1_3.dynamic_rendering == vk::TRUE,
                synchronization2: vulkan_1_3.synchronization2 == vk::TRUE,
            },
            limits: Limits {
                max_compute_work_group_invocations: limits.max_compute_work_group_invocations,
                max_compute_shared_memory_size: limits.max_compute_shared_memory_size,
                max_push_constants_size: limits.max_push_constants_size,
                max_per_stage_descriptor_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
            },
            formats,
        }
    }
}

/// The traits of a device that effects are fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceTraits {
    /// Bytes of a storage buffer that a shader can bind: `maxStorageBufferRange`.
    pub storage_range: u64,
    /// Pixels along a side of an image that can be rendered to.
    pub image_side: u32,
    /// Whether the driver ends an invocation's loops after 65,535 iterations, as lavapipe does. Only then is work cut into
    /// dispatches that stay within a budget.
    pub ends_loops: bool,
    /// Which of several ways are taken.
    pub tuning: Tuning,
}

impl DeviceTraits {
    /// The least that Vulkan promises, of a GPU.
    pub const LEAST: DeviceTraits =
        DeviceTraits { storage_range: 1 << 27, image_side: 4096, ends_loops: false, tuning: Tuning::GPU };

    /// Those of lavapipe, Mesa's driver on the CPU.
    pub const LAVAPIPE: DeviceTraits =
        DeviceTraits { storage_range: 1 << 27, image_side: 16_384, ends_loops: true, tuning: Tuning::CPU };

    /// Those of a device, which need not exist yet.
    ///
    /// # Safety
    /// As for [`check_device`], which finds nothing missing on it.
    pub unsafe fn of(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> DeviceTraits {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
        // SAFETY: the caller's.
        unsafe { instance.get_physical_device_properties2(physical_device, &mut chain) };
        let vk::PhysicalDeviceProperties { limits, device_type, .. } = chain.properties;
        let framebuffer = limits.max_framebuffer_width.min(limits.max_framebuffer_height);
        DeviceTraits {
            storage_range: u64::from(limits.max_storage_buffer_range),
            image_side: framebuffer.min(limits.max_image_dimension2_d),
            ends_loops: driver.driver_id == vk::DriverId::MESA_LLVMPIPE,
            tuning: Tuning::of(device_type),
        }
    }

    /// Refuses a picture with a side that the device cannot render to.
    pub(crate) fn check_sides(&self, size: [u32; 2]) -> Result<()> {
        match size.into_iter().find(|side| *side > self.image_side) {
            Some(side) => Err(Error::Limit {
                what: "a side of the picture",
                needed: side.into(),
                limit: self.image_side.into(),
                advice: "render a smaller picture",
            }),
            None => Ok(()),
        }
    }
}

/// The largest heap of a device's own memory, in bytes.
///
/// # Safety
/// `host` holds valid handles.
#[cfg(feature = "cli")]
pub(crate) unsafe fn own_memory(host: &Host) -> u64 {
    // SAFETY: the caller's.
    let memory = unsafe { host.instance.get_physical_device_memory_properties(host.physical_device) };
    let heaps = memory.memory_heaps_as_slice().iter();
    let own = heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
    own.map(|heap| heap.size).max().unwrap_or(0)
}
