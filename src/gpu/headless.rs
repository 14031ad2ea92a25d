//! A device without a window, for the program and the tests. Hosts bring their own.

mod devices;
mod instance;

use std::mem::ManuallyDrop;
use std::time::Duration;

use ash::vk;
use gpu_allocator::AllocationSizes;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

pub use devices::{DeviceInfo, Report, report};
pub use instance::{Messages, VALIDATION_LAYER};

use crate::error::{Error, Result};
use crate::gpu::debug;
use crate::host::{Host, requirements};
use devices::Candidate;
use instance::Instance;

/// What to open.
#[derive(Clone, Debug)]
pub struct Options {
    /// Core and synchronisation validation; what the layer says is collected in [`Headless::messages`].
    pub validate: bool,
    /// Index of a device, or part of its name in any case; none: the best that can run celfx.
    pub device: Option<String>,
    /// Longest wait for one submission. Finite, so that a hang is an error; long, because a software driver compiles
    /// shaders while it runs them and may share its cores.
    pub timeout: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Options { validate: false, device: None, timeout: Duration::from_secs(300) }
    }
}

/// What helps wherever there is no device.
const INSTALL: &str = "install a Vulkan driver; on Debian and Ubuntu: apt install libvulkan1 mesa-vulkan-drivers \
    (it brings lavapipe, which needs no GPU)";

/// Why there is no usable Vulkan device, and what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoDevice {
    /// The Vulkan loader is not installed.
    #[error("no Vulkan loader: {0}; {INSTALL}")]
    NoLoader(String),
    /// The loader is older than Vulkan 1.3.
    #[error("the Vulkan loader is too old: it knows Vulkan {0}, 1.3 is needed; {INSTALL}")]
    OldLoader(String),
    /// The loader found no driver.
    #[error("no Vulkan driver: {0} (VK_DRIVER_FILES or VK_ICD_FILENAMES, if set, say where it looks); {INSTALL}")]
    NoDriver(String),
    /// A driver is installed, but something about it is broken.
    #[error(
        "a Vulkan driver or its description is broken: {call} returned {result:?}; \
        VK_LOADER_DEBUG=error shows which file it is (they are listed in VK_DRIVER_FILES or VK_ICD_FILENAMES, if set, \
        or lie in /usr/share/vulkan/icd.d and /etc/vulkan/icd.d); or {INSTALL}"
    )]
    BrokenDriver {
        /// The call that failed.
        call: &'static str,
        /// What it returned.
        result: vk::Result,
    },
    /// Validation was asked for, and its layer is not installed.
    #[error(
        "validation was asked for, but the layer VK_LAYER_KHRONOS_validation is not installed; \
        on Debian and Ubuntu: apt install vulkan-validationlayers"
    )]
    NoLayer,
    /// No device matches what was asked for.
    #[error("no Vulkan device matches \"{wanted}\"; there are:\n{devices}")]
    NoMatch {
        /// What was asked for.
        wanted: String,
        /// The devices, one a line.
        devices: String,
    },
    /// There are devices, and none can run celfx.
    #[error("no usable Vulkan device; tried:\n{tried}\n{INSTALL}")]
    NoneUsable {
        /// The devices and what each lacks, one a line.
        tried: String,
    },
    /// The device that was chosen could not be opened.
    #[error("{device}: {why}")]
    NotOpened {
        /// Its name.
        device: String,
        /// What failed.
        why: String,
    },
}

/// Commands in recording state, from [`Headless::begin`].
#[derive(Debug)]
#[must_use = "commands that are not submitted do nothing"]
pub struct Commands(Slot);

impl Commands {
    /// The command buffer.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.0.commands
    }
}

/// Commands on their way, to be waited for with [`Headless::wait`].
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

/// Instance, device, queue, allocator and command buffers, all owned and destroyed here.
pub struct Headless {
    /// Dropped by hand, before the device whose memory it holds.
    allocator: ManuallyDrop<Allocator>,
    opened: Opened,
    queue: vk::Queue,
    pool: vk::CommandPool,
    /// Every slot there is.
    slots: Vec<Slot>,
    /// Those that wait for work.
    free: Vec<Slot>,
    timeout: Duration,
    /// Something is still running that nobody can wait for.
    stuck: bool,
}

/// What a [`Host`] borrows.
struct Opened {
    candidate: Candidate,
    device: ash::Device,
    debug: Option<ash::ext::debug_utils::Device>,
    /// Dropped by hand, after the device.
    instance: ManuallyDrop<Instance>,
}

impl Opened {
    fn host(&self) -> Host<'_> {
        Host {
            instance: &self.instance.raw,
            physical_device: self.candidate.physical_device,
            device: &self.device,
            debug: self.debug.as_ref(),
            pipeline_cache: vk::PipelineCache::null(),
        }
    }
}

impl Headless {
    /// Opens a device that can run celfx, GPUs before CPUs.
    pub fn new(options: &Options) -> std::result::Result<Headless, NoDevice> {
        let instance = Instance::new(options.validate)?;
        let candidates = devices::list(&instance)?;
        let index = devices::choose(&candidates, options.device.as_deref())?;
        let mut candidates = candidates;
        let candidate = candidates.swap_remove(index);
        let name = candidate.info.name.clone();
        Self::open(instance, candidate, options.timeout).map_err(|why| NoDevice::NotOpened { device: name, why })
    }

    fn open(instance: Instance, candidate: Candidate, timeout: Duration) -> std::result::Result<Headless, String> {
        let family = candidate.queue_family;
        let mut features = vk::PhysicalDeviceVulkan13Features::default();
        requirements().features.enable(&mut features);
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
        // SAFETY: a physical device of this instance, which supports these features and has this queue family.
        let device = unsafe { instance.raw.create_device(candidate.physical_device, &info, None) }
            .map_err(|e| format!("vkCreateDevice returned {e:?}"))?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.clone(),
            physical_device: candidate.physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            // Small blocks: an effect takes some tens of MiB, and what is larger than a block gets one of its own.
            allocation_sizes: AllocationSizes::new(8 << 20, 8 << 20),
        });
        let pool_info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER | vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device was made with this family; if one of the two is missing, the device has no other child.
        let (allocator, pool) = unsafe {
            let pool = device.create_command_pool(&pool_info, None);
            match (allocator, pool) {
                (Ok(allocator), Ok(pool)) => (allocator, pool),
                (allocator, pool) => {
                    let why = match (&allocator, &pool) {
                        (Err(e), _) => e.to_string(),
                        (_, error) => format!("vkCreateCommandPool returned {error:?}"),
                    };
                    device.destroy_command_pool(pool.unwrap_or_default(), None);
                    drop(allocator);
                    device.destroy_device(None);
                    return Err(why);
                }
            }
        };
        // SAFETY: the device is valid and has one queue of this family; debug utils is asked for where it is enabled.
        let (queue, debug) = unsafe {
            let debug = if instance.has_debug_utils { debug::table(&instance.raw, &device) } else { None };
            (device.get_device_queue(family, 0), debug)
        };
        let opened = Opened { candidate, device, debug, instance: ManuallyDrop::new(instance) };
        Ok(Headless {
            allocator: ManuallyDrop::new(allocator),
            opened,
            queue,
            pool,
            slots: Vec::new(),
            free: Vec::new(),
            timeout,
            stuck: false,
        })
    }

    /// What an effect is made and recorded with.
    pub fn host(&self) -> Host<'_> {
        self.opened.host()
    }

    /// [`Headless::host`] and the allocator together, for creating and destroying.
    pub fn parts(&mut self) -> (Host<'_>, &mut Allocator) {
        (self.opened.host(), &mut self.allocator)
    }

    /// The family of the queue that everything is submitted to.
    pub fn queue_family(&self) -> u32 {
        self.opened.candidate.queue_family
    }

    /// The device that was chosen.
    pub fn info(&self) -> &DeviceInfo {
        &self.opened.candidate.info
    }

    /// What validation has said so far, warnings and errors; empty without validation. The messages outlive `self`, so
    /// that those about its destruction can be read too.
    pub fn messages(&self) -> Messages {
        self.opened.instance.messages.clone()
    }

    /// Whether a wait did not end: something may still be running, so nothing that was submitted may be reused or
    /// destroyed, ever.
    pub fn is_stuck(&self) -> bool {
        self.stuck
    }

    /// Begins commands.
    pub fn begin(&mut self) -> Result<Commands> {
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => self.make_slot()?,
        };
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: a free slot is not on the device; beginning resets it.
        match unsafe { self.opened.device.begin_command_buffer(slot.commands, &info) } {
            Ok(()) => Ok(Commands(slot)),
            Err(result) => {
                self.free.push(slot);
                Err(Error::vulkan("vkBeginCommandBuffer", "")(result))
            }
        }
    }

    fn make_slot(&mut self) -> Result<Slot> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        // SAFETY: the pool and the device are valid; the fence is destroyed when `self` is.
        let slot = unsafe {
            let fence = self.opened.device.create_fence(&vk::FenceCreateInfo::default(), None);
            let fence = fence.map_err(Error::vulkan("vkCreateFence", ""))?;
            match self.opened.device.allocate_command_buffers(&info) {
                Ok(commands) => Slot { commands: commands.first().copied().unwrap_or_default(), fence },
                Err(result) => {
                    self.opened.device.destroy_fence(fence, None);
                    return Err(Error::vulkan("vkAllocateCommandBuffers", "")(result));
                }
            }
        };
        self.slots.push(slot);
        Ok(slot)
    }

    /// Submits commands and does not wait. `what` names them in errors.
    pub fn start(&mut self, commands: Commands, what: &str) -> Result<Submission> {
        let Commands(slot) = commands;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let submits = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the commands are in recording state, the fence is unsignalled, and the queue is used by `self` alone.
        let submitted = unsafe {
            self.opened
                .device
                .end_command_buffer(slot.commands)
                .map_err(Error::vulkan("vkEndCommandBuffer", what))
                .and_then(|()| {
                    let result = self.opened.device.queue_submit2(self.queue, &submits, slot.fence);
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

    /// Waits for a submission, at most [`Options::timeout`]: then the result is `TIMEOUT`, and what runs is left alone
    /// (see [`Headless::is_stuck`]).
    pub fn wait(&mut self, submission: Submission) -> Result<()> {
        let Submission { slot, what } = submission;
        let nanoseconds = u64::try_from(self.timeout.as_nanos()).unwrap_or(u64::MAX - 1);
        // SAFETY: the fence was submitted and belongs to the device.
        let waited = unsafe { self.opened.device.wait_for_fences(&[slot.fence], true, nanoseconds) };
        if let Err(result) = waited {
            // Only a lost device is known to be done.
            self.stuck |= result != vk::Result::ERROR_DEVICE_LOST;
            return Err(Error::vulkan("vkWaitForFences", what)(result));
        }
        // SAFETY: the fence has signalled.
        unsafe { self.opened.device.reset_fences(&[slot.fence]) }.map_err(Error::vulkan("vkResetFences", what))?;
        self.free.push(slot);
        Ok(())
    }

    /// Submits commands and waits for them.
    pub fn submit(&mut self, commands: Commands, what: &str) -> Result<()> {
        let submission = self.start(commands, what)?;
        self.wait(submission)
    }

    /// Records with `record`, submits and waits. Nothing is submitted if `record` fails.
    pub fn one_time<T>(&mut self, what: &str, record: impl FnOnce(&Host, vk::CommandBuffer) -> Result<T>) -> Result<T> {
        let commands = self.begin()?;
        match record(&self.host(), commands.raw()) {
            Ok(value) => self.submit(commands, what).map(|()| value),
            Err(error) => {
                // SAFETY: the commands are in recording state and were not submitted; the pool allows the reset.
                let reset = unsafe {
                    let flags = vk::CommandBufferResetFlags::empty();
                    self.opened.device.reset_command_buffer(commands.raw(), flags)
                };
                if reset.is_ok() {
                    self.free.push(commands.0);
                }
                Err(error)
            }
        }
    }
}

impl Drop for Headless {
    fn drop(&mut self) {
        if self.stuck {
            // Destroying what the device still uses is undefined, and waiting for it may take for ever: it stays.
            return;
        }
        // SAFETY: nothing is used after this, and no field twice. A lost device still has to be destroyed. The
        // allocator goes before the device, the device before the instance.
        unsafe {
            let _ = self.opened.device.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            for slot in &self.slots {
                self.opened.device.destroy_fence(slot.fence, None);
            }
            self.opened.device.destroy_command_pool(self.pool, None);
            self.opened.device.destroy_device(None);
            ManuallyDrop::drop(&mut self.opened.instance);
        }
    }
}
