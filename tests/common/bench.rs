//! Single passes of the effect on inputs that the test chooses: the plan of a frame, less the steps whose results are
//! written instead. Made of the engine's public pieces, as the effect itself is.

use ash::vk;
use celfx::data::Volume;
use celfx::effect::{DeviceTraits, Effort, Inventory};
use celfx::error::Result;
use celfx::host::{HostImage, ImageState};
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::pipelines::Pipelines;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::recorder::{Recorder, Recording};
use celfx::low_level::gpu::resources::Resources;
use celfx::low_level::gpu::transfer::CLEARED;
use celfx::low_level::plan::{BufferId, Plan};
use celfx::low_level::smoke::layout::{self, Layout};
use celfx::low_level::smoke::params::SmokeParams;
use celfx::low_level::smoke::passes::Passes;
use celfx::low_level::smoke::steps::{FrameDelta, Steps};
use celfx::low_level::smoke::tables::Tables;
use celfx::offline::TARGET_FORMAT;
use celfx::smoke::{Background, Desc, Frame, Sequence, Shape, VolumeInput};
use celfx::view::{Camera, Light};

use super::host::{self, ALL, ALL_WRITTEN};
use super::{TestDevice, device};

/// Lavapipe's largest range of a storage buffer, the smallest of the devices that tests run on.
pub const TRAITS: DeviceTraits = DeviceTraits::LAVAPIPE;

/// How the effect leaves its images, for whatever comes.
const GENERAL: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::ALL_COMMANDS,
    access: vk::AccessFlags2::MEMORY_WRITE,
    layout: vk::ImageLayout::GENERAL,
};

/// The effect's passes, and buffers that tests write and read.
pub struct Bench {
    device: TestDevice,
    /// Settings may be changed between frames where the passes learn of them through parameters or tables.
    pub desc: Desc,
    pub layout: Layout,
    passes: Passes,
    plan: Plan,
    resources: Resources,
    pipelines: Option<Pipelines>,
    recorder: Recorder,
    target: Option<Image>,
}

/// A frame of a bench.
pub struct Given<'a> {
    pub camera: Camera,
    pub light: Light,
    pub volume: &'a Volume,
    /// Frames since the restart; 0 restarts.
    pub frames: u32,
    /// Whether a picture is made.
    pub rendered: bool,
    /// Steps that are left out: their results have been written.
    pub omit: &'a [&'a str],
}

impl Bench {
    /// None where there is no device and tests may do without.
    pub fn new(desc: Desc) -> Option<Bench> {
        let mut device = device()?;
        let layout = Layout::new(&desc, &TRAITS).expect("a layout");
        let passes = Passes::new(&desc, &layout, &Tables::new(&desc.settings, &layout), Effort::Needed);
        let mut resources = Resources::default();
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own; everything is destroyed before it.
        let pipelines = unsafe {
            for buffer in layout.buffers(&desc) {
                resources.add_buffer(&host, allocator, &buffer).expect("a buffer");
            }
            resources.add_host_buffer();
            resources.add_host_buffer();
            for mut image in layout.images(&desc) {
                if image.format == vk::Format::R32_UINT {
                    image.usage |= vk::ImageUsageFlags::TRANSFER_DST;
                }
                resources.add_image(&host, allocator, &image).expect("an image");
            }
            resources.add_host_image();
            resources.add_host_image();
            Pipelines::new(&host, kernels, &passes.list, &resources).expect("pipelines")
        };
        let target = host::image(&mut device, desc.size, TARGET_FORMAT);
        let recorder = Recorder::new(&resources);
        let plan = Plan::default();
        let (pipelines, target) = (Some(pipelines), Some(target));
        Some(Bench { device, desc, layout, passes, plan, resources, pipelines, recorder, target })
    }

    /// Writes the start of a buffer.
    pub fn write<T: bytemuck::NoUninit>(&mut self, id: BufferId, values: &[T]) {
        let size = size_of_val(values) as u64;
        let (to, _, available) = self.resources.buffer(id);
        assert!(size <= available, "{id:?} holds {available} bytes");
        let mut from = host::source(&mut self.device, size);
        host::fill(&mut from, values);
        host::run(&mut self.device, |host, commands| {
            // SAFETY: both buffers are alive; nothing else is on its way.
            unsafe {
                host::barrier(host, commands, ALL_WRITTEN, ALL);
                let regions = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size }];
                host.device.cmd_copy_buffer(commands, from.handle, to, &regions);
                host::barrier(host, commands, ALL_WRITTEN, ALL);
            }
        });
        host::destroy(&mut self.device, [&mut from], []);
    }

    /// Writes what each pixel has seen: `(slot + 1) << 8 | group`, 0 for nothing. After the first frame.
    pub fn write_seen(&mut self, codes: &[u32]) {
        let [width, height] = self.desc.size;
        assert_eq!(codes.len(), (width * height) as usize);
        let mut from = host::source(&mut self.device, size_of_val(codes) as u64);
        host::fill(&mut from, codes);
        let image = (self.resources.image(layout::SEEN), vk::ImageAspectFlags::COLOR);
        let regions = [host::image_copy(image.1, self.desc.size)];
        host::run(&mut self.device, |host, commands| {
            // SAFETY: buffer and image are alive; the image has been in layout GENERAL since the first frame.
            unsafe {
                host::change(host, commands, image, GENERAL, CLEARED);
                host.device.cmd_copy_buffer_to_image(commands, from.handle, image.0, CLEARED.layout, &regions);
                host::change(host, commands, image, CLEARED, GENERAL);
            }
        });
        host::destroy(&mut self.device, [&mut from], []);
    }

    /// Reads the first `count` values of a buffer.
    pub fn read<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Vec<T> {
        host::read(&mut self.device, self.resources.buffer(id), count)
    }

    /// Plans a frame, leaves steps out, and runs the rest.
    pub fn run(&mut self, given: &Given) {
        let Volume { dimensions, voxel_size, origin, .. } = *given.volume;
        let mut upload = host::source(&mut self.device, size_of_val(&given.volume.density[..]) as u64);
        let density = host::fill(&mut upload, &given.volume.density);
        let target = given.rendered.then(|| self.target());
        let restart = given.frames == 0;
        let frame = Frame {
            sequence: if restart { Sequence::Restart } else { Sequence::Advance },
            dt: 1.0 / 24.0,
            view: given.camera.view(self.desc.size),
            light: given.light,
            fire: None,
            volume: Some(VolumeInput { dimensions, voxel_size, origin, density, velocity: None }),
            target,
            background: Background::Clear([0.0; 4]),
            depth: None,
            edges: None,
            temporal: Default::default(),
        };
        let shape = Shape { dimensions, voxel_size, origin };
        let delta = FrameDelta {
            shape,
            restart,
            new_volume: true,
            stale: false,
            new_tables: true,
            still: None,
            view_before: None,
            moves: false,
            same_shadow: None,
        };
        let mut params = SmokeParams::new(&self.desc, &self.layout, &frame, &shape, given.frames);
        params.range_before = given.frames % 2;
        let tables = Tables::new(&self.desc.settings, &self.layout);
        let Bench { plan, passes, desc, layout, .. } = self;
        plan.clear();
        Steps { plan, passes, desc, layout, traits: &TRAITS, delta: &delta }.fill(&frame, &params, &tables);
        let list = &self.passes.list;
        self.plan.steps.retain(|step| !given.omit.contains(&list[usize::from(step.pass.0)].name));
        self.resources.set_host_buffer(layout::HOST_DENSITY, Some(density));
        self.resources.set_host_image(layout::TARGET, target);
        self.submit().expect("the frame runs");
        host::destroy(&mut self.device, [&mut upload], []);
    }

    fn target(&self) -> HostImage {
        let image = self.target.as_ref().expect("a target");
        host::host_image(image, self.desc.size, TARGET_FORMAT, ImageState::default(), GENERAL)
    }

    fn submit(&mut self) -> Result<()> {
        let Bench { device, passes, plan, resources, pipelines, recorder, .. } = self;
        let pipelines = pipelines.as_ref().expect("pipelines");
        device.one_time("bench frame", |host, commands| {
            let passes = &passes.list;
            let mut commands = commands;
            let mut recording = Recording { host, stream: &mut commands, passes, pipelines, resources };
            // SAFETY: everything was made for these passes, and what the plan names has been handed over.
            unsafe { recorder.record(plan, 0..plan.steps.len(), &mut recording, &mut Timing::None) }.map(drop)
        })
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let (pipelines, target) = (self.pipelines.take(), self.target.take());
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for.
        unsafe {
            if let Some(mut pipelines) = pipelines {
                pipelines.destroy(&host);
            }
            if let Some(mut target) = target {
                target.destroy(&host, allocator);
            }
            self.resources.destroy(&host, allocator);
        }
    }
}
