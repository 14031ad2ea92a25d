//! Asks a physical device what it supports.

use ash::vk;

use crate::host::{Capabilities, Features, Limits, requirements};

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

/// What a physical device supports.
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
