//! What every effect is on the device: its buffers and images, its pipelines, and the recorder that walks its plans.

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use crate::error::Result;
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::kernel::Pipelines;
use crate::gpu::profiler::{Mode, Timing};
use crate::gpu::recorder::{Recorder, Recording, Stream};
use crate::gpu::resources::Resources;
use crate::host::Host;
use crate::plan::{BufferId, Pass, Plan};

/// An effect's objects on the device, and the list of its passes that they were made for.
#[derive(Debug)]
pub struct OnDevice {
    /// By [`crate::plan::PassId`].
    pub passes: Vec<Pass>,
    /// What plans name. The host's buffers and images come after the own ones.
    pub resources: Resources,
    pipelines: Pipelines,
    recorder: Recorder,
}

/// How many buffers and images an effect has.
pub struct Inventory<B, I> {
    /// Its own buffers, in the order of their ids.
    pub buffers: B,
    /// Buffers that the host hands over.
    pub host_buffers: usize,
    /// Its own images, in the order of their ids.
    pub images: I,
    /// Images that the host hands over.
    pub host_images: usize,
}

impl OnDevice {
    /// Creates everything; leaves nothing behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles, and `allocator` belongs to its device.
    pub unsafe fn new<B, I>(
        host: &Host,
        allocator: &mut Allocator,
        passes: Vec<Pass>,
        inventory: Inventory<B, I>,
    ) -> Result<OnDevice>
    where
        B: IntoIterator<Item = BufferDesc>,
        I: IntoIterator<Item = ImageDesc>,
    {
        let mut resources = Resources::default();
        // SAFETY: the caller's; what was made is destroyed unused on error.
        unsafe {
            let pipelines = create(host, allocator, inventory, &mut resources)
                .and_then(|()| Pipelines::new(host, &passes, &resources))
                .inspect_err(|_| resources.destroy(host, allocator))?;
            let recorder = Recorder::new(&resources);
            Ok(OnDevice { passes, resources, pipelines, recorder })
        }
    }

    /// Whether steps overlap or are isolated by full barriers.
    pub fn set_mode(&mut self, mode: Mode) {
        self.recorder.set_mode(mode);
    }

    /// Records a plan of the passes.
    ///
    /// # Errors
    /// A step does not fit the resources.
    ///
    /// # Safety
    /// `host` is the one that everything was made with; the command buffers of `stream` are in recording state, outside of
    /// a render pass; what the host has handed over is in the states that it declared.
    pub unsafe fn record(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        plan: &Plan,
        timing: &mut Timing,
    ) -> Result<()> {
        let OnDevice { passes, resources, pipelines, recorder } = self;
        let mut recording = Recording { host, stream, passes, pipelines, resources };
        // SAFETY: the caller's.
        unsafe { recorder.record(plan, &mut recording, timing) }
    }

    /// Records steps of a plan once more, without any image of the host's.
    ///
    /// # Errors
    /// A step does not fit the resources.
    ///
    /// # Safety
    /// As [`OnDevice::record`].
    #[cfg(feature = "cli")]
    pub unsafe fn replay(
        &mut self,
        host: &Host,
        mut commands: vk::CommandBuffer,
        plan: &Plan,
        host_images: &[crate::plan::ImageId],
    ) -> Result<()> {
        host_images.iter().for_each(|image| self.resources.set_host_image(*image, None));
        // SAFETY: the caller's.
        unsafe { self.record(host, &mut commands, plan, &mut Timing::None) }
    }

    /// A buffer: handle, offset and size in bytes.
    pub fn buffer(&self, id: BufferId) -> (vk::Buffer, u64, u64) {
        self.resources.buffer(id)
    }

    /// Destroys what celfx made.
    ///
    /// # Safety
    /// The GPU is done with every recorded plan; `host` and `allocator` are those it was made with. Nothing else is called
    /// afterwards.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        unsafe {
            self.pipelines.destroy(host);
            self.resources.destroy(host, allocator);
        }
    }
}

unsafe fn create<B, I>(
    host: &Host,
    allocator: &mut Allocator,
    inventory: Inventory<B, I>,
    resources: &mut Resources,
) -> Result<()>
where
    B: IntoIterator<Item = BufferDesc>,
    I: IntoIterator<Item = ImageDesc>,
{
    // SAFETY: the caller's.
    unsafe {
        for buffer in inventory.buffers {
            resources.add_buffer(host, allocator, &buffer)?;
        }
        for _ in 0..inventory.host_buffers {
            resources.add_host_buffer();
        }
        for image in inventory.images {
            resources.add_image(host, allocator, &image)?;
        }
        for _ in 0..inventory.host_images {
            resources.add_host_image();
        }
    }
    Ok(())
}

/// What all effects do alike once they are made: an effect has its `desc`, the `plan` of the frame recorded last, and is
/// `on_device`. `host_images`: those that its frames hand over.
macro_rules! effect_methods {
    ($effect:ident, host_images: $host_images:expr) => {
        impl $effect {
            /// Changes the size of the picture. The next frame must bring all that a first one does. On error the effect is
            /// as it was.
            ///
            /// # Errors
            /// As [`Self::new`].
            ///
            /// # Safety
            /// As [`Self::new`], and the GPU is done with every frame recorded so far.
            pub unsafe fn resize(&mut self, host: &Host, allocator: &mut Allocator, size: [u32; 2]) -> Result<()> {
                let desc = Desc { size, ..self.desc.clone() };
                // SAFETY: the caller's.
                unsafe {
                    let mut old = std::mem::replace(self, Self::new(host, allocator, desc)?);
                    old.destroy(host, allocator);
                }
                Ok(())
            }

            /// Whether steps overlap (default) or are isolated by full barriers, for comparing kernels.
            pub fn set_mode(&mut self, mode: $crate::gpu::profiler::Mode) {
                self.on_device.set_mode(mode);
            }

            /// Records steps of a recorded frame's plan once more, to measure them alone. They read what that frame left;
            /// none of them may touch the host's images or buffers, or what later frames go on from.
            ///
            /// # Errors
            /// A step does not fit the effect's buffers.
            ///
            /// # Safety
            /// As for [`Self::record`].
            #[cfg(feature = "cli")]
            pub(crate) unsafe fn replay(
                &mut self,
                host: &Host,
                commands: vk::CommandBuffer,
                plan: &Plan,
            ) -> Result<()> {
                // SAFETY: the caller's.
                unsafe { self.on_device.replay(host, commands, plan, &$host_images) }
            }

            /// The list of the frame recorded last.
            pub fn plan(&self) -> &Plan {
                &self.plan
            }

            /// The declared passes, which the plan's steps refer to.
            pub fn passes(&self) -> &[$crate::plan::Pass] {
                &self.on_device.passes
            }

            /// A buffer of the effect, to be read after a frame: handle, offset and size in bytes. The ids stand in
            /// [`layout`]. The last access to it was a shader's or a transfer's write.
            pub fn buffer(&self, id: $crate::plan::BufferId) -> (vk::Buffer, u64, u64) {
                self.on_device.buffer(id)
            }

            /// What the effect was made for.
            pub fn desc(&self) -> &Desc {
                &self.desc
            }

            /// Destroys what celfx made.
            ///
            /// # Safety
            /// The GPU is done with every recorded frame; `host` and `allocator` are those it was made with. Nothing else is
            /// called afterwards.
            pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
                // SAFETY: the caller's.
                unsafe { self.on_device.destroy(host, allocator) };
            }
        }
    };
}
pub(crate) use effect_methods;
