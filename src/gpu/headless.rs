//! A device without a window, for the program and the tests. Hosts bring their own.

mod commands;
mod devices;
mod instance;

use std::mem::ManuallyDrop;
use std::time::Duration;

use ash::vk;
use gpu_allocator::AllocationSizes;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

pub use commands::{Commands, Submission, Submitter};
pub use devices::{DeviceInfo, Report, report};
pub use instance::{Messages, VALIDATION_LAYER};

use crate::error::Result;
use crate::gpu::capabilities::DeviceTraits;
use crate::gpu::costs::Cost;
use crate::gpu::debug;
use crate::gpu::kernels::Kernels;
use crate::host::{Host, requirements};
use crate::tuning::Tuning;
use commands::Queue;
use devices::Candidate;
use instance::Instance;

/// Options of a device to open.
#[derive(Clone, Debug)]
pub struct Options {
    /// Core and synchronisation validation; what the layer says is collected in [`Headless::messages`].
    pub validate: bool,
    /// Index of a device, or part of its name in any case; none: the best that can run celfx.
    pub device: Option<String>,
    /// Longest wait for one submission, then the result is `TIMEOUT`; none: as long as the device lives. What a frame
    /// takes is not known: software drivers compile shaders while they run them, and may share their cores.
    pub timeout: Option<Duration>,
    /// Asked before each submission and every tenth of a second while one is waited for, with how long that has been:
    /// whether to go on. Once it says no, nothing is submitted any more, and what runs gets a second to end.
    pub go_on: fn(Duration) -> bool,
    /// Enables what [`Kernels::with_costs`] needs, where the device has it.
    pub costs: bool,
    /// Which of several ways effects take; none: those that the device's type suggests.
    pub tuning: Option<Tuning>,
    /// Enables stores to memory in all stages of a render pass, where the device has them. For the benchmark, which counts
    /// what shaders do.
    #[doc(hidden)]
    pub stores: bool,
    /// Wrapper that all calls of the device then go through. For tests, which let calls fail.
    #[doc(hidden)]
    pub table: fn(ash::Device) -> ash::Device,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            validate: false,
            device: None,
            timeout: None,
            go_on: |_| true,
            costs: false,
            tuning: None,
            stores: false,
            table: |device| device,
        }
    }
}

/// Advice wherever there is no device.
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
        /// Its result.
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
        /// The device asked for.
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
        /// The failure.
        why: String,
    },
}

/// Instance, device, queue, allocator and command buffers, all owned and destroyed here.
pub struct Headless {
    /// Dropped by hand, before the device whose memory it holds.
    allocator: ManuallyDrop<Allocator>,
    kernels: Kernels,
    opened: Opened,
    queue: Queue,
    has_stores: bool,
}

/// The objects that a [`Host`] borrows.
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
        Self::open(instance, candidate, options).map_err(|why| NoDevice::NotOpened { device: name, why })
    }

    fn open(instance: Instance, candidate: Candidate, options: &Options) -> std::result::Result<Headless, String> {
        let family = candidate.queue_family;
        let mut features = vk::PhysicalDeviceVulkan13Features::default();
        requirements().features.enable(&mut features);
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let has_stores = options.stores && devices::has_stores(&instance, candidate.physical_device);
        let stores = vk::PhysicalDeviceFeatures::default()
            .fragment_stores_and_atomics(has_stores)
            .vertex_pipeline_stores_and_atomics(has_stores);
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&stores)
            .push_next(&mut features);
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        let extensions = [vk::KHR_PIPELINE_EXECUTABLE_PROPERTIES_NAME.as_ptr()];
        let has_costs = options.costs && devices::has_costs(&instance, candidate.physical_device);
        if has_costs {
            executables = executables.pipeline_executable_info(true);
            info = info.enabled_extension_names(&extensions).push_next(&mut executables);
        }
        // SAFETY: a physical device of this instance, which supports these features and has this queue family.
        let device = unsafe { instance.raw.create_device(candidate.physical_device, &info, None) }
            .map_err(|e| format!("vkCreateDevice returned {e:?}"))?;
        let device = (options.table)(device);
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.clone(),
            physical_device: candidate.physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            // Small blocks: an effect takes some tens of MiB, and what is larger than a block gets one of its own.
            allocation_sizes: AllocationSizes::new(8 << 20, 8 << 20),
        });
        // SAFETY: the device was made with this family; if one of the two is missing, the device has no other child.
        let (allocator, queue) = unsafe {
            let queue = Queue::new(&device, family, options);
            match (allocator, queue) {
                (Ok(allocator), Ok(queue)) => (allocator, queue),
                (allocator, queue) => {
                    let why = match (&allocator, &queue) {
                        (Err(e), _) => e.to_string(),
                        (_, Err(e)) => e.to_string(),
                        _ => String::new(),
                    };
                    queue.iter().for_each(|queue| queue.destroy(&device));
                    drop(allocator);
                    device.destroy_device(None);
                    return Err(why);
                }
            }
        };
        // SAFETY: the device is valid; debug utils is asked for where it is enabled.
        let debug = unsafe { if instance.has_debug_utils { debug::table(&instance.raw, &device) } else { None } };
        let opened = Opened { candidate, device, debug, instance: ManuallyDrop::new(instance) };
        let kernels = if has_costs { Kernels::with_costs() } else { Kernels::new() };
        let mut headless = Headless { allocator: ManuallyDrop::new(allocator), kernels, opened, queue, has_stores };
        if let Some(tuning) = options.tuning {
            headless.fit(Some(DeviceTraits { tuning, ..headless.traits() }));
        }
        Ok(headless)
    }

    /// The host that an effect is made and recorded with.
    pub fn host(&self) -> Host<'_> {
        self.opened.host()
    }

    /// [`Headless::host`] and the allocator together, for creating and destroying.
    pub fn parts(&mut self) -> (Host<'_>, &mut Allocator) {
        (self.opened.host(), &mut self.allocator)
    }

    /// The same with the device's pipelines, for making effects.
    pub fn making(&mut self) -> (Host<'_>, &Kernels, &mut Allocator) {
        (self.opened.host(), &self.kernels, &mut self.allocator)
    }

    /// The device's pipelines.
    pub fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// The traits that effects on it are fitted to.
    pub fn traits(&self) -> DeviceTraits {
        // SAFETY: the device's own handles.
        unsafe { self.kernels.traits(&self.host()) }
    }

    /// From now on effects are fitted to these; none: to its own.
    pub fn fit(&mut self, traits: Option<DeviceTraits>) {
        self.kernels.fit(traits);
    }

    /// What the pipelines cost that were made on it; none if the device does not say, or [`Options::costs`] was not set.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn costs(&self) -> Result<Option<Vec<Cost>>> {
        // SAFETY: the device's own handles.
        unsafe { self.kernels.costs(&self.host()) }
    }

    /// Bytes of the allocator's that are in use.
    pub fn allocated(&self) -> u64 {
        self.allocator.generate_report().total_allocated_bytes
    }

    /// Whether all stages may store to memory: [`Options::stores`].
    pub(crate) fn has_stores(&self) -> bool {
        self.has_stores
    }

    /// The family of the queue that everything is submitted to.
    pub fn queue_family(&self) -> u32 {
        self.opened.candidate.queue_family
    }

    /// The device that was chosen.
    pub fn info(&self) -> &DeviceInfo {
        &self.opened.candidate.info
    }

    /// Messages of validation so far, warnings and errors; empty without validation. The messages outlive `self`, so
    /// that those about its destruction can be read too.
    pub fn messages(&self) -> Messages {
        self.opened.instance.messages.clone()
    }

    /// Whether a wait did not end: something may still be running, so nothing that was submitted may be reused or
    /// destroyed, ever.
    pub fn is_stuck(&self) -> bool {
        self.queue.stuck
    }

    /// [`Headless::host`] and the queue together, for recording one submission while another runs.
    pub fn recording(&mut self) -> (Host<'_>, Submitter<'_>) {
        (self.opened.host(), Submitter { device: &self.opened.device, queue: &mut self.queue })
    }

    /// Begins commands.
    pub fn begin(&mut self) -> Result<Commands> {
        self.recording().1.begin()
    }

    /// Takes commands back that will not be submitted.
    pub fn discard(&mut self, commands: Commands) {
        self.recording().1.discard(commands);
    }

    /// Submits commands and does not wait. `what` names them in errors.
    pub fn start(&mut self, commands: Commands, what: &str) -> Result<Submission> {
        self.recording().1.start(commands, what)
    }

    /// Waits for a submission, however long it takes. What still runs after [`Options::timeout`], or a second after
    /// [`Options::go_on`] has said no, is left alone (see [`Headless::is_stuck`]).
    ///
    /// # Errors
    /// The result `TIMEOUT`; an interruption; a lost device.
    pub fn wait(&mut self, submission: Submission) -> Result<()> {
        self.recording().1.wait(submission)
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
                self.recording().1.discard(commands);
                Err(error)
            }
        }
    }
}

impl Drop for Headless {
    fn drop(&mut self) {
        if self.queue.stuck {
            // Destroying what the device still uses is undefined, and waiting for it may take for ever: it stays.
            return;
        }
        // SAFETY: nothing is used after this, and no field twice. A lost device still has to be destroyed. The
        // allocator goes before the device, the device before the instance.
        unsafe {
            let _ = self.opened.device.device_wait_idle();
            self.kernels.destroy(&self.opened.host());
            ManuallyDrop::drop(&mut self.allocator);
            self.queue.destroy(&self.opened.device);
            self.opened.device.destroy_device(None);
            ManuallyDrop::drop(&mut self.opened.instance);
        }
    }
}
