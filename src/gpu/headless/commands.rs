//! Command buffers, each with a fence, that are used again once their work is done.

use ash::vk;

use crate::error::{Error, Result};

/// Commands in recording state, from [`super::Headless::begin`].
#[derive(Debug)]
#[must_use = "commands that are not submitted do nothing"]
pub struct Commands(Slot);

impl Commands {
    /// The command buffer.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.0.commands
    }
}

/// Commands on their way, to be waited for with [`super::Headless::wait`].
#[derive(Debug)]
#[must_use = "its commands are reused once it has been waited for"]
pub struct Submission {
    slot: Slot,
    what: String,
}

impl Submission {
    pub(super) fn fence(&self) -> vk::Fence {
        self.slot.fence
    }

    pub(super) fn what(&self) -> &str {
        &self.what
    }
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

/// Where commands come from while a device is recorded for, see [`super::Headless::recording`].
pub struct CommandSource<'a> {
    pub(super) device: &'a ash::Device,
    pub(super) pool: &'a mut Pool,
}

impl CommandSource<'_> {
    /// Begins commands.
    pub fn begin(&mut self) -> Result<Commands> {
        self.pool.begin(self.device)
    }
}

/// The command buffers of one queue family, which one device has made; each call gets this device.
pub(super) struct Pool {
    raw: vk::CommandPool,
    /// Every slot there is.
    slots: Vec<Slot>,
    /// Those that wait for work.
    free: Vec<Slot>,
}

impl Pool {
    /// # Safety
    /// The device is valid and was made with this family.
    pub(super) unsafe fn new(device: &ash::Device, family: u32) -> Result<Pool> {
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER | vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the caller's.
        let raw = unsafe { device.create_command_pool(&info, None) };
        let raw = raw.map_err(Error::vulkan("vkCreateCommandPool", ""))?;
        Ok(Pool { raw, slots: Vec::new(), free: Vec::new() })
    }

    fn begin(&mut self, device: &ash::Device) -> Result<Commands> {
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => self.make_slot(device)?,
        };
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: a free slot is not on the device; beginning resets it.
        match unsafe { device.begin_command_buffer(slot.commands, &info) } {
            Ok(()) => Ok(Commands(slot)),
            Err(result) => {
                self.free.push(slot);
                Err(Error::vulkan("vkBeginCommandBuffer", "")(result))
            }
        }
    }

    fn make_slot(&mut self, device: &ash::Device) -> Result<Slot> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.raw).command_buffer_count(1);
        // SAFETY: the pool and the device are valid; the fence is destroyed with the pool.
        let slot = unsafe {
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None);
            let fence = fence.map_err(Error::vulkan("vkCreateFence", ""))?;
            match device.allocate_command_buffers(&info) {
                Ok(commands) => Slot { commands: commands.first().copied().unwrap_or_default(), fence },
                Err(result) => {
                    device.destroy_fence(fence, None);
                    return Err(Error::vulkan("vkAllocateCommandBuffers", "")(result));
                }
            }
        };
        self.slots.push(slot);
        Ok(slot)
    }

    pub(super) fn discard(&mut self, device: &ash::Device, Commands(slot): Commands) {
        // SAFETY: the commands are in recording state and were not submitted; the pool allows the reset.
        let reset = unsafe { device.reset_command_buffer(slot.commands, vk::CommandBufferResetFlags::empty()) };
        if reset.is_ok() {
            self.free.push(slot);
        }
    }

    /// # Safety
    /// The queue is of this family and used by nobody else.
    pub(super) unsafe fn submit(
        &mut self,
        device: &ash::Device,
        queue: vk::Queue,
        Commands(slot): Commands,
        what: &str,
    ) -> Result<Submission> {
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let submits = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the commands are in recording state, the fence is unsignalled; for the queue, the caller's.
        let submitted = unsafe {
            device.end_command_buffer(slot.commands).map_err(Error::vulkan("vkEndCommandBuffer", what)).and_then(|()| {
                let result = device.queue_submit2(queue, &submits, slot.fence);
                result.map_err(Error::vulkan("vkQueueSubmit2", what))
            })
        };
        match submitted {
            Ok(()) => Ok(Submission { slot, what: what.into() }),
            Err(error) => {
                self.free.push(slot);
                Err(error)
            }
        }
    }

    /// Takes the commands of a submission back whose fence has signalled.
    pub(super) fn ended(&mut self, device: &ash::Device, Submission { slot, what }: Submission) -> Result<()> {
        // SAFETY: the fence has signalled.
        unsafe { device.reset_fences(&[slot.fence]) }.map_err(Error::vulkan("vkResetFences", what))?;
        self.free.push(slot);
        Ok(())
    }

    /// # Safety
    /// The device is done with every submission; nothing is called afterwards.
    pub(super) unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller's; the pool frees its command buffers.
        unsafe {
            self.slots.iter().for_each(|slot| device.destroy_fence(slot.fence, None));
            device.destroy_command_pool(self.raw, None);
        }
    }
}
