//! Command buffers, each with a fence, that are submitted, waited for, and used again.

use std::time::{Duration, Instant};

use ash::vk;

use super::Options;
use crate::error::{Error, Result};

/// How long is waited before it is asked whether to go on.
const WAIT: Duration = Duration::from_millis(100);
/// How long what runs may take to end once the answer was no.
const GRACE: Duration = Duration::from_secs(1);

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

#[derive(Clone, Copy, Debug)]
struct Slot {
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

/// The queue of a device, and its command buffers; each call gets the device.
pub(super) struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    /// Every slot there is.
    slots: Vec<Slot>,
    /// Those that wait for work.
    free: Vec<Slot>,
    timeout: Option<Duration>,
    go_on: fn(Duration) -> bool,
    /// Nothing is submitted any more.
    interrupted: bool,
    /// Something is still running that nobody can wait for.
    pub(super) stuck: bool,
}

impl Queue {
    /// # Safety
    /// The device is valid and was made with a queue of this family, which nobody else uses.
    pub(super) unsafe fn new(device: &ash::Device, family: u32, options: &Options) -> Result<Queue> {
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER | vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the caller's.
        let (raw, pool) = unsafe { (device.get_device_queue(family, 0), device.create_command_pool(&info, None)) };
        let pool = pool.map_err(Error::vulkan("vkCreateCommandPool", ""))?;
        let Options { timeout, go_on, .. } = *options;
        let (slots, free) = (Vec::new(), Vec::new());
        Ok(Queue { raw, pool, slots, free, timeout, go_on, interrupted: false, stuck: false })
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
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        // SAFETY: the pool and the device are valid; the fence is destroyed with the queue.
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

    fn submit(&self, device: &ash::Device, slot: Slot, what: &str) -> Result<()> {
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let submits = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the commands are in recording state, the fence is unsignalled, and the queue is used by `self` alone.
        unsafe {
            device.end_command_buffer(slot.commands).map_err(Error::vulkan("vkEndCommandBuffer", what))?;
            device.queue_submit2(self.raw, &submits, slot.fence).map_err(Error::vulkan("vkQueueSubmit2", what))
        }
    }

    fn wait_for(&mut self, device: &ash::Device, fence: vk::Fence, what: &str) -> Result<()> {
        let begin = Instant::now();
        let mut limit = self.timeout;
        loop {
            let left = limit.map_or(WAIT, |limit| limit.saturating_sub(begin.elapsed()).min(WAIT));
            // SAFETY: the fence was submitted and belongs to the device.
            match unsafe { device.wait_for_fences(&[fence], true, left.as_nanos() as u64) } {
                Err(vk::Result::TIMEOUT) => {}
                result => return result.map_err(Error::vulkan("vkWaitForFences", what)),
            }
            let waited = begin.elapsed();
            if !self.interrupted && !(self.go_on)(waited) {
                self.interrupted = true;
                limit = Some(limit.map_or(waited + GRACE, |limit| limit.min(waited + GRACE)));
            }
            if limit.is_some_and(|limit| waited >= limit) {
                return Err(match self.interrupted {
                    true => Error::Interrupted { what: what.into() },
                    false => Error::vulkan("vkWaitForFences", what)(vk::Result::TIMEOUT),
                });
            }
        }
    }

    /// # Safety
    /// The device is done with every submission; nothing is called afterwards.
    pub(super) unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller's; the pool frees its command buffers.
        unsafe {
            self.slots.iter().for_each(|slot| device.destroy_fence(slot.fence, None));
            device.destroy_command_pool(self.pool, None);
        }
    }
}

/// A device's queue while the device is recorded for, see [`super::Headless::recording`].
pub struct Submitter<'a> {
    pub(super) device: &'a ash::Device,
    pub(super) queue: &'a mut Queue,
}

impl Submitter<'_> {
    /// Begins commands.
    pub fn begin(&mut self) -> Result<Commands> {
        self.queue.begin(self.device)
    }

    /// Takes commands back that will not be submitted.
    pub fn discard(&mut self, Commands(slot): Commands) {
        // SAFETY: the commands are in recording state and were not submitted; the pool allows the reset.
        let reset = unsafe { self.device.reset_command_buffer(slot.commands, vk::CommandBufferResetFlags::empty()) };
        if reset.is_ok() {
            self.queue.free.push(slot);
        }
    }

    /// Submits commands and does not wait. `what` names them in errors.
    pub fn start(&mut self, commands: Commands, what: &str) -> Result<Submission> {
        let queue = &mut *self.queue;
        queue.interrupted = queue.interrupted || !(queue.go_on)(Duration::ZERO);
        if queue.interrupted {
            self.discard(commands);
            return Err(Error::Interrupted { what: what.into() });
        }
        let Commands(slot) = commands;
        match queue.submit(self.device, slot, what) {
            Ok(()) => Ok(Submission { slot, what: what.into() }),
            Err(error) => {
                queue.free.push(slot);
                Err(error)
            }
        }
    }

    /// As [`super::Headless::wait`].
    pub fn wait(&mut self, submission: Submission) -> Result<()> {
        let Submission { slot, what } = submission;
        if let Err(error) = self.queue.wait_for(self.device, slot.fence, &what) {
            // Only a lost device is known to be done.
            self.queue.stuck |= !error.is_lost();
            return Err(error);
        }
        // SAFETY: the fence has signalled.
        unsafe { self.device.reset_fences(&[slot.fence]) }.map_err(Error::vulkan("vkResetFences", what))?;
        self.queue.free.push(slot);
        Ok(())
    }
}
