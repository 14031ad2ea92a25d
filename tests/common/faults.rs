//! Vulkan calls that fail when they are told to: every call of a device that can fail goes through here.

use std::cell::Cell;
use std::ffi::c_void;
use std::sync::RwLock;

use ash::vk;

thread_local! {
    /// Calls of this thread until one fails.
    static LEFT: Cell<Option<u32>> = const { Cell::new(None) };
    /// Only calls of this name are counted.
    static ONLY: Cell<Option<&'static str>> = const { Cell::new(None) };
    static FAILED: Cell<Option<&'static str>> = const { Cell::new(None) };
}

/// Lets this thread's call after so many others fail, of those of this name if one is given.
pub fn arm(calls: u32, only: Option<&'static str>) {
    LEFT.set(Some(calls));
    ONLY.set(only);
    FAILED.set(None);
}

/// The call that has failed, if one has; no more will.
pub fn disarm() -> Option<&'static str> {
    LEFT.set(None);
    FAILED.take()
}

/// How many of the calls that were allowed are left.
pub fn left() -> Option<u32> {
    LEFT.get()
}

/// Whether a call fails now.
fn fails(name: &'static str) -> bool {
    let Some(left) = LEFT.get().filter(|_| ONLY.get().is_none_or(|only| only == name)) else { return false };
    LEFT.set(left.checked_sub(1));
    if left == 0 {
        FAILED.set(Some(name));
    }
    left == 0
}

/// Replaces calls in the function tables of a device, by what returns a result where they fail. One of those `late` does
/// its work before.
macro_rules! failing {
    ($($field:ident($($argument:ident: $kind:ty),*) of $table:ident: $name:literal, $result:ident, $late:literal;)*) => {
        /// The device with calls that can fail, for [`celfx::low_level::gpu::headless::Options::table`].
        pub fn table(device: ash::Device) -> ash::Device {
            let (mut core, v11) = (device.fp_v1_0().clone(), device.fp_v1_1().clone());
            let (v12, mut core_1_3) = (device.fp_v1_2().clone(), device.fp_v1_3().clone());
            $({
                // Of the newest device: drivers and layers may be unloaded between two, and lie elsewhere then.
                static REAL: RwLock<Option<unsafe extern "system" fn($($kind),*) -> vk::Result>> = RwLock::new(None);
                unsafe extern "system" fn call($($argument: $kind),*) -> vk::Result {
                    let real = REAL.read().ok().and_then(|real| *real).expect("it was replaced");
                    let fails = fails($name);
                    // SAFETY: the caller's.
                    while fails && $late && unsafe { real($($argument),*) } == vk::Result::TIMEOUT {}
                    // SAFETY: the caller's.
                    if fails { vk::Result::$result } else { unsafe { real($($argument),*) } }
                }
                let replaced = table_of!($table, core, core_1_3);
                *REAL.write().expect("nobody panicked") = Some(replaced.$field);
                replaced.$field = call;
            })*
            ash::Device::from_parts_1_3(device.handle(), core, v11, v12, core_1_3)
        }
    };
}

macro_rules! table_of {
    (core, $core:ident, $core_1_3:ident) => {
        &mut $core
    };
    (core_1_3, $core:ident, $core_1_3:ident) => {
        &mut $core_1_3
    };
}

type Device = vk::Device;
type In<T> = *const T;
type Out<T> = *mut T;
type Callbacks<'a> = *const vk::AllocationCallbacks<'a>;

failing! {
    create_buffer(d: Device, i: In<vk::BufferCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::Buffer>) of core: "vkCreateBuffer", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_image(d: Device, i: In<vk::ImageCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::Image>) of core: "vkCreateImage", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_image_view(d: Device, i: In<vk::ImageViewCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::ImageView>) of core: "vkCreateImageView", ERROR_OUT_OF_DEVICE_MEMORY, false;
    allocate_memory(d: Device, i: In<vk::MemoryAllocateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::DeviceMemory>) of core: "vkAllocateMemory", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_shader_module(d: Device, i: In<vk::ShaderModuleCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::ShaderModule>) of core: "vkCreateShaderModule", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_descriptor_set_layout(d: Device, i: In<vk::DescriptorSetLayoutCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::DescriptorSetLayout>) of core: "vkCreateDescriptorSetLayout", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_pipeline_layout(d: Device, i: In<vk::PipelineLayoutCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::PipelineLayout>) of core: "vkCreatePipelineLayout", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_descriptor_pool(d: Device, i: In<vk::DescriptorPoolCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::DescriptorPool>) of core: "vkCreateDescriptorPool", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_query_pool(d: Device, i: In<vk::QueryPoolCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::QueryPool>) of core: "vkCreateQueryPool", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_command_pool(d: Device, i: In<vk::CommandPoolCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::CommandPool>) of core: "vkCreateCommandPool", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_fence(d: Device, i: In<vk::FenceCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::Fence>) of core: "vkCreateFence", ERROR_OUT_OF_DEVICE_MEMORY, false;
    bind_buffer_memory(d: Device, b: vk::Buffer, m: vk::DeviceMemory, o: vk::DeviceSize) of core: "vkBindBufferMemory", ERROR_OUT_OF_DEVICE_MEMORY, false;
    bind_image_memory(d: Device, b: vk::Image, m: vk::DeviceMemory, o: vk::DeviceSize) of core: "vkBindImageMemory", ERROR_OUT_OF_DEVICE_MEMORY, false;
    map_memory(d: Device, m: vk::DeviceMemory, o: vk::DeviceSize, s: vk::DeviceSize, f: vk::MemoryMapFlags, p: Out<Out<c_void>>) of core: "vkMapMemory", ERROR_MEMORY_MAP_FAILED, false;
    create_compute_pipelines(d: Device, c: vk::PipelineCache, n: u32, i: In<vk::ComputePipelineCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::Pipeline>) of core: "vkCreateComputePipelines", ERROR_OUT_OF_DEVICE_MEMORY, false;
    create_graphics_pipelines(d: Device, c: vk::PipelineCache, n: u32, i: In<vk::GraphicsPipelineCreateInfo<'_>>, a: Callbacks<'_>, o: Out<vk::Pipeline>) of core: "vkCreateGraphicsPipelines", ERROR_OUT_OF_DEVICE_MEMORY, false;
    allocate_descriptor_sets(d: Device, i: In<vk::DescriptorSetAllocateInfo<'_>>, o: Out<vk::DescriptorSet>) of core: "vkAllocateDescriptorSets", ERROR_OUT_OF_POOL_MEMORY, false;
    allocate_command_buffers(d: Device, i: In<vk::CommandBufferAllocateInfo<'_>>, o: Out<vk::CommandBuffer>) of core: "vkAllocateCommandBuffers", ERROR_OUT_OF_DEVICE_MEMORY, false;
    begin_command_buffer(c: vk::CommandBuffer, i: In<vk::CommandBufferBeginInfo<'_>>) of core: "vkBeginCommandBuffer", ERROR_OUT_OF_DEVICE_MEMORY, false;
    end_command_buffer(c: vk::CommandBuffer) of core: "vkEndCommandBuffer", ERROR_OUT_OF_DEVICE_MEMORY, false;
    queue_submit2(q: vk::Queue, n: u32, i: In<vk::SubmitInfo2<'_>>, f: vk::Fence) of core_1_3: "vkQueueSubmit2", ERROR_DEVICE_LOST, false;
    wait_for_fences(d: Device, n: u32, f: In<vk::Fence>, a: vk::Bool32, t: u64) of core: "vkWaitForFences", ERROR_DEVICE_LOST, true;
    reset_fences(d: Device, n: u32, f: In<vk::Fence>) of core: "vkResetFences", ERROR_OUT_OF_DEVICE_MEMORY, false;
}
