//! The benchmark's host: one device, effects and kernels of the benchmark's own on it. Runs one thing at a time and
//! times it, from its first to its last step, with a full barrier around each.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::time::Instant;

use ash::vk;

use super::count::Counter;
use super::report::Work;
use crate::effect::DeviceTraits;
use crate::effect::Effort;
use crate::error::Result;
use crate::gpu::buffer::{Buffer, BufferDesc};
use crate::gpu::executor::Executor;
use crate::gpu::headless::{Headless, Messages};
use crate::gpu::image::Image;
use crate::gpu::profiler::{Mode, Profiler, Timing};
use crate::gpu::resources::Resources;
use crate::gpu::transfer::{Copy, readback, record_readback, record_zeroes};
use crate::host::{Background, Host, HostBuffer, ImageState};
use crate::offline::picture::{host_image, image_desc};
use crate::offline::{Describe, Left, Place, Player, Scene, make};
use crate::plan::{BufferId, Command, Pass, Plan};
use crate::tuning::Tuning;

/// Format of the pictures.
pub(crate) const FORMAT: vk::Format = crate::offline::TARGET_FORMAT;

/// Times of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measured {
    /// On the device, from the first step's begin to the last one's end. Where there are no timestamps: from the
    /// submission to the end of the wait.
    pub(crate) gpu_ms: f64,
    /// Recording on the host.
    pub(crate) cpu_ms: f64,
}

/// An effect of a [`Rig`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct EffectId(usize);

/// Kernels of a [`Rig`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelsId(usize);

/// What runs a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Runner {
    Effect(usize),
    Kernels(usize),
}

/// A buffer of kernels.
pub(crate) enum KernelBuffer {
    /// Of their own, zeroed.
    Own(BufferDesc),
    /// An effect's.
    Shared(EffectId, BufferId),
}

/// An effect and the picture that it makes.
struct Slot {
    player: Option<Box<dyn Player>>,
    target: Option<Image>,
    size: [u32; 2],
}

/// A device and what is measured on it.
pub(crate) struct Rig {
    headless: Headless,
    profiler: Option<Profiler>,
    effects: Vec<Slot>,
    kernels: Vec<Executor>,
    /// Of what counts its work by now.
    counters: HashMap<Runner, Counter>,
}

impl Rig {
    pub(crate) fn new(mut headless: Headless) -> Result<Rig> {
        let family = headless.queue_family();
        let (host, _) = headless.parts();
        // SAFETY: the device's own handles; it is destroyed in `drop`.
        let profiler = unsafe { Profiler::new(&host, family, 1, 1)? };
        Ok(Rig {
            headless,
            profiler: Some(profiler),
            effects: Vec::new(),
            kernels: Vec::new(),
            counters: HashMap::new(),
        })
    }

    /// Name and driver of the device.
    pub(crate) fn device(&self) -> (String, String) {
        let info = self.headless.info();
        (info.name.clone(), format!("{} {}", info.driver, info.driver_info).trim().to_owned())
    }

    pub(crate) fn messages(&self) -> Messages {
        self.headless.messages()
    }

    /// Effects that are made from now on take these ways; none: those that the device's type suggests.
    pub(crate) fn tune(&mut self, tuning: Option<Tuning>) {
        self.headless.fit(None);
        let traits = self.headless.traits();
        self.headless.fit(tuning.map(|tuning| DeviceTraits { tuning, ..traits }));
    }

    /// Ways that effects take.
    pub(crate) fn tuning(&self) -> Tuning {
        self.headless.traits().tuning
    }

    /// Largest storage buffer of the device in bytes.
    pub(crate) fn largest_buffer(&self) -> u64 {
        self.headless.traits().storage_range
    }

    /// Makes an effect that is measured step by step.
    pub(crate) fn effect(&mut self, desc: impl Describe) -> Result<EffectId> {
        let id = EffectId(self.effects.len());
        let size = desc.size();
        self.effects.push(Slot { player: None, target: None, size });
        let Some(slot) = self.effects.last_mut() else { return Ok(id) };
        slot.player.insert(make(&mut self.headless, desc, Effort::Repeatable)?).executor_mut().set_mode(Mode::Isolated);
        let (host, allocator) = self.headless.parts();
        // SAFETY: the device's own handles; it is destroyed in `clear`.
        slot.target = Some(unsafe { Image::new(&host, allocator, &image_desc("picture", size))? });
        Ok(id)
    }

    /// Renders a frame over nothing. What carries the scene to the device is not measured.
    pub(crate) fn frame(&mut self, id: EffectId, scene: &Scene) -> Result<Measured> {
        let Slot { player: Some(player), target: Some(target), size } = &mut self.effects[id.0] else {
            return Ok(NOTHING);
        };
        let target = host_image(target, *size, ImageState::default());
        let place = Place {
            target: Some(target).filter(|_| scene.rendered),
            background: Background::Clear([0.0; 4]),
            depth: None,
            vectors: None,
            left: Left::default(),
        };
        player.upload(&mut self.headless, scene, &place)?;
        let measured = measure(&mut self.headless, &mut self.profiler, |host, commands| {
            let mut commands = commands;
            // SAFETY: the device's own handles; every frame is submitted in order and waited for.
            unsafe { player.record(host, &mut commands, scene, &place, &mut Timing::None) }
        });
        player.finished();
        measured
    }

    fn executor(&self, id: EffectId) -> Option<&Executor> {
        self.effects[id.0].player.as_ref().map(|player| player.executor())
    }

    /// The steps of the frame recorded last that belong to these passes.
    pub(crate) fn steps(&self, id: EffectId, wanted: impl Fn(&Pass) -> bool) -> Plan {
        let mut plan = Plan::default();
        if let Some(effect) = self.executor(id) {
            let all = effect.plan();
            plan.data.clone_from(&all.data);
            plan.steps.extend(all.steps.iter().filter(|step| wanted(&effect.passes()[usize::from(step.pass.0)])));
        }
        plan
    }

    /// Runs steps of the frame recorded last again.
    pub(crate) fn replay(&mut self, id: EffectId, plan: &Plan) -> Result<Measured> {
        let Slot { player: Some(player), .. } = &mut self.effects[id.0] else { return Ok(NOTHING) };
        measure(&mut self.headless, &mut self.profiler, |host, commands| {
            // SAFETY: the device's own handles; the plan is of this effect, and the frame before is over.
            unsafe { player.executor_mut().replay(host, commands, plan) }
        })
    }

    /// Makes kernels of the benchmark's own; buffers get their ids in the given order.
    pub(crate) fn kernels(&mut self, buffers: Vec<KernelBuffer>, passes: Vec<Pass>) -> Result<KernelsId> {
        let id = KernelsId(self.kernels.len());
        let mut resources = Resources::default();
        let shared = buffers.iter().map(|buffer| match buffer {
            KernelBuffer::Own(_) => None,
            KernelBuffer::Shared(effect, buffer) => self.shared(*effect, *buffer),
        });
        let shared: Vec<Option<HostBuffer>> = shared.collect();
        let (host, kernels, allocator) = self.headless.making();
        for (buffer, shared) in buffers.iter().zip(shared) {
            match buffer {
                // SAFETY: the device's own handles; what is made is destroyed here or in `clear`.
                KernelBuffer::Own(desc) => unsafe {
                    if let Err(error) = resources.add_buffer(&host, allocator, desc) {
                        resources.destroy(&host, allocator);
                        return Err(error);
                    }
                },
                KernelBuffer::Shared(..) => {
                    let id = resources.add_host_buffer();
                    resources.set_host_buffer(id, shared);
                }
            }
        }
        // SAFETY: as above.
        let mut executor = unsafe { Executor::on(&host, kernels, allocator, passes, resources)? };
        executor.set_mode(Mode::Isolated);
        self.kernels.push(executor);
        self.zero(id, &buffers)?;
        Ok(id)
    }

    fn shared(&self, effect: EffectId, buffer: BufferId) -> Option<HostBuffer> {
        let (buffer, offset, size) = self.executor(effect)?.buffer(buffer);
        let (stage, access) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
        Some(HostBuffer { buffer, offset, size, stage, access })
    }

    /// Fresh memory holds old data, and its pages may be there only once they have been touched.
    fn zero(&mut self, id: KernelsId, buffers: &[KernelBuffer]) -> Result<()> {
        let resources = self.kernels[id.0].resources();
        let own = buffers.iter().enumerate().filter(|(_, buffer)| matches!(buffer, KernelBuffer::Own(_)));
        let own: Vec<_> = own.map(|(index, _)| resources.buffer(BufferId(index as u16))).collect();
        self.headless.one_time("zeroes", |host, commands| {
            for (buffer, offset, size) in own {
                // SAFETY: the device's own handles; nothing else uses the buffers yet.
                unsafe { record_zeroes(host, commands, buffer, offset, size) };
            }
            Ok(())
        })
    }

    /// Runs a plan of such kernels.
    pub(crate) fn run(&mut self, id: KernelsId, plan: &Plan) -> Result<Measured> {
        let executor = &mut self.kernels[id.0];
        measure(&mut self.headless, &mut self.profiler, |host, commands| {
            // SAFETY: the device's own handles; the plan is of these passes, and everything before is over.
            unsafe { executor.replay(host, commands, plan) }
        })
    }

    /// Runs a plan with no work in it: drivers that compile a kernel at its first dispatch do so now.
    pub(crate) fn warm_up(&mut self, id: KernelsId, plan: &Plan) -> Result<()> {
        let mut empty = Plan::default();
        empty.steps.extend(plan.steps.iter().filter(|step| matches!(step.command, Command::Dispatch { .. })));
        for step in &mut empty.steps {
            step.command = Command::Dispatch { threads: [0, 0, 0] };
        }
        self.run(id, &empty).map(|_| ())
    }

    /// An effect's buffer: the first `count` values.
    pub(crate) fn read<T: bytemuck::AnyBitPattern>(
        &mut self,
        id: EffectId,
        buffer: BufferId,
        count: usize,
    ) -> Result<Vec<T>> {
        let source = self.executor(id).map(|effect| effect.buffer(buffer));
        self.read_buffer(source, count)
    }

    /// A buffer of kernels: the first `count` values.
    pub(crate) fn read_kernels<T: bytemuck::AnyBitPattern>(
        &mut self,
        id: KernelsId,
        buffer: BufferId,
        count: usize,
    ) -> Result<Vec<T>> {
        let source = self.kernels[id.0].buffer(buffer);
        self.read_buffer(Some(source), count)
    }

    fn read_buffer<T: bytemuck::AnyBitPattern>(
        &mut self,
        source: Option<(vk::Buffer, u64, u64)>,
        count: usize,
    ) -> Result<Vec<T>> {
        let Some((buffer, offset, size)) = source else { return Ok(Vec::new()) };
        let size = size.min((count * size_of::<T>()) as u64);
        let bytes = self.read_back(size, &[], &[Copy { from: (buffer, offset, size), to: 0 }])?;
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    /// The work of a frame. What is timed comes before: passes that count take longer.
    pub(crate) fn work_of_frame(&mut self, id: EffectId, scene: &Scene) -> Result<Work> {
        self.count(Runner::Effect(id.0))?;
        self.frame(id, scene)?;
        let plan = self.steps(id, |_| true);
        self.counted(Runner::Effect(id.0), &plan)
    }

    /// The work of steps of the frame recorded last; as [`Rig::work_of_frame`].
    pub(crate) fn work_of_replay(&mut self, id: EffectId, plan: &Plan) -> Result<Work> {
        self.count(Runner::Effect(id.0))?;
        self.replay(id, plan)?;
        self.counted(Runner::Effect(id.0), plan)
    }

    /// The work of a plan of such kernels; as [`Rig::work_of_frame`].
    pub(crate) fn work_of_run(&mut self, id: KernelsId, plan: &Plan) -> Result<Work> {
        self.count(Runner::Kernels(id.0))?;
        self.run(id, plan)?;
        self.counted(Runner::Kernels(id.0), plan)
    }

    /// Makes passes count, if they do not yet, from 0.
    fn count(&mut self, runner: Runner) -> Result<()> {
        let raster = self.headless.has_stores();
        let (host, kernels, allocator) = self.headless.making();
        let Some(executor) = executor_of(&mut self.effects, &mut self.kernels, runner) else { return Ok(()) };
        let counter = match self.counters.entry(runner) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let counter = Counter::new(executor.resources(), raster);
                // SAFETY: the device's own handles; everything recorded before has been waited for.
                unsafe {
                    executor.resources_mut().add_buffer(&host, allocator, &counter.desc())?;
                    executor.change(&host, kernels, |pass| counter.instrument(pass))?;
                }
                executor.set_mode(Mode::Isolated);
                entry.insert(counter)
            }
        };
        let ((buffer, offset, size), header) = (executor.buffer(counter.buffer), counter.header());
        self.headless.one_time("counts", |host, commands| {
            let begin = header.len() as u64;
            // SAFETY: the device's own handles; nothing else uses the buffer, of which each byte is written once.
            unsafe {
                host.device.cmd_update_buffer(commands, buffer, offset, &header);
                record_zeroes(host, commands, buffer, offset + begin, size - begin);
            }
            Ok(())
        })
    }

    /// What has been counted since.
    fn counted(&mut self, runner: Runner, plan: &Plan) -> Result<Work> {
        let executor = executor_of(&mut self.effects, &mut self.kernels, runner);
        let source = self.counters.get(&runner).zip(executor);
        let source = source.map(|(counter, executor)| (executor.buffer(counter.buffer), counter.words()));
        let Some((source, count)) = source else { return Ok(Work::default()) };
        let words = self.read_buffer(Some(source), count)?;
        let executor = executor_of(&mut self.effects, &mut self.kernels, runner);
        let counter = self.counters.get(&runner).zip(executor);
        Ok(counter.map_or(Work::default(), |(counter, executor)| counter.work(executor.passes(), plan, words)))
    }

    /// The picture of the frame rendered last.
    pub(crate) fn picture(&mut self, id: EffectId) -> Result<Vec<[f32; 4]>> {
        let Slot { target: Some(target), size, .. } = &self.effects[id.0] else { return Ok(Vec::new()) };
        let (image, extent) = (target.handle, *size);
        let bytes = u64::from(extent[0]) * u64::from(extent[1]) * 16;
        let bytes = self.read_back(bytes, &[Copy { from: (image, extent), to: 0 }], &[])?;
        Ok(bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect())
    }

    fn read_back(
        &mut self,
        bytes: u64,
        images: &[Copy<(vk::Image, [u32; 2])>],
        ranges: &[Copy<(vk::Buffer, u64, u64)>],
    ) -> Result<Vec<u8>> {
        let (host, allocator) = self.headless.parts();
        // SAFETY: the device's own handles; the buffer is destroyed below.
        let mut staging = unsafe { Buffer::new(&host, allocator, &readback("read back", bytes.max(16)))? };
        let done = self.headless.one_time("read back", |host, commands| {
            // SAFETY: everything is alive until the wait is over, and images are where frames leave them.
            unsafe { record_readback(host, commands, images, ranges, &staging) };
            Ok(())
        });
        let result = staging.mapped().and_then(|memory| memory.get(..bytes as usize)).unwrap_or_default().to_vec();
        if !self.headless.is_stuck() {
            let (host, allocator) = self.headless.parts();
            // SAFETY: the copy is over.
            unsafe { staging.destroy(&host, allocator) };
        }
        done.map(|()| result)
    }

    /// Destroys all effects and kernels.
    pub(crate) fn clear(&mut self) {
        if self.headless.is_stuck() {
            return;
        }
        let (host, allocator) = self.headless.parts();
        // SAFETY: every submission has been waited for.
        unsafe {
            self.counters.clear();
            self.kernels.drain(..).for_each(|mut kernels| kernels.destroy(&host, allocator));
            for Slot { mut player, mut target, .. } in self.effects.drain(..) {
                player.iter_mut().for_each(|player| player.destroy(&host, allocator));
                target.iter_mut().for_each(|target| target.destroy(&host, allocator));
            }
        }
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.clear();
        if self.headless.is_stuck() {
            return;
        }
        if let Some(mut profiler) = self.profiler.take() {
            // SAFETY: every submission has been waited for.
            unsafe { profiler.destroy(&self.headless.host()) };
        }
    }
}

fn executor_of<'a>(effects: &'a mut [Slot], kernels: &'a mut [Executor], runner: Runner) -> Option<&'a mut Executor> {
    match runner {
        Runner::Effect(id) => effects.get_mut(id)?.player.as_mut().map(|player| player.executor_mut()),
        Runner::Kernels(id) => kernels.get_mut(id),
    }
}

const NOTHING: Measured = Measured { gpu_ms: 0.0, cpu_ms: 0.0 };

fn measure(
    headless: &mut Headless,
    profiler: &mut Option<Profiler>,
    record: impl FnOnce(&Host, vk::CommandBuffer) -> Result<()>,
) -> Result<Measured> {
    let mut cpu_ms = 0.0;
    let mut submitted = Instant::now();
    headless.one_time("benchmark", |host, commands| {
        // SAFETY: the device's own handles; the frame before has been waited for and collected.
        unsafe {
            if let Some(profiler) = profiler.as_mut() {
                profiler.begin_frame(host, commands, 0, 0)?;
                Timing::Profiler(profiler).begin_scope(host, commands, "benchmark");
            }
            let begin = Instant::now();
            record(host, commands)?;
            cpu_ms = begin.elapsed().as_secs_f64() * 1e3;
            if let Some(profiler) = profiler.as_mut() {
                Timing::Profiler(profiler).end_scope(host, commands);
            }
        }
        submitted = Instant::now();
        Ok(())
    })?;
    let waited = submitted.elapsed().as_secs_f64() * 1e3;
    // SAFETY: the submission has been waited for.
    let times = profiler.as_mut().and_then(|profiler| unsafe { profiler.collect(&headless.host(), 0) });
    Ok(Measured { gpu_ms: times.map_or(waited, |times| times.total_ns() as f64 / 1e6), cpu_ms })
}
