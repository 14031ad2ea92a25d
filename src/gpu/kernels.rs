//! The pipelines of a device: each is made once, and all effects share it.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::capabilities::DeviceTraits;
use crate::gpu::costs::{Cost, executables};
use crate::gpu::module::{create_module, specialisation};
use crate::gpu::{debug, raster};
use crate::host::Host;
use crate::plan::{Blend, DescriptorKind, Kernel, Pass, Shader, Stage, Topology};

/// The pipelines that effects have been made with, on one device. An effect whose pipelines are there already, because
/// another one or its own former size had them, is made in a fraction of the time.
///
/// It may be used by several threads at once. It must outlive the effects that are made with it, and is then destroyed.
#[derive(Debug, Default)]
pub struct Kernels {
    /// Without one while a thread makes it.
    made: Mutex<HashMap<Key, Option<Made>>>,
    /// A pipeline has been made, or could not be.
    changed: Condvar,
    /// The traits that effects are fitted to, if they are not to be the device's.
    traits: Option<DeviceTraits>,
    /// Of pipelines.
    flags: vk::PipelineCreateFlags,
}

/// A pipeline, and what it was made for.
#[derive(Debug)]
struct Made {
    pipeline: Pipeline,
    pass: &'static str,
    shaders: Vec<&'static str>,
}

/// A pipeline and its layouts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pipeline {
    pub handle: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub set_layout: vk::DescriptorSetLayout,
}

/// The part of a pass that its pipeline depends on. Shaders go by where their words are.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(crate) struct Key {
    shaders: [Option<usize>; 2],
    specialisation: Vec<u32>,
    topology: Option<Topology>,
    colour: Option<(vk::Format, Blend)>,
    depth: Option<(vk::Format, vk::CompareOp, bool)>,
}

impl Key {
    pub(crate) fn of(pass: &Pass) -> Key {
        let raster = match &pass.kernel {
            Kernel::Raster(raster) => Some(raster),
            Kernel::Compute(_) | Kernel::Transfer => None,
        };
        Key {
            shaders: pass.shaders().map(|shader| shader.map(|shader| shader.words.as_ptr().addr())),
            specialisation: pass.specialisation.clone(),
            topology: raster.map(|raster| raster.topology),
            colour: raster.and_then(|raster| raster.colour).map(|colour| (colour.format, colour.blend)),
            depth: raster.and_then(|raster| raster.depth).map(|depth| (depth.format, depth.compare, depth.write)),
        }
    }
}

impl Kernels {
    /// Has no pipeline yet.
    pub fn new() -> Kernels {
        Kernels::default()
    }

    /// Has no pipeline yet, and lets the driver keep what each costs. The device has
    /// `VK_KHR_pipeline_executable_properties` and its feature enabled.
    pub fn with_costs() -> Kernels {
        Kernels { flags: vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR, ..Kernels::default() }
    }

    /// From now on effects are fitted to these traits, which must be within what the device can do; none: to the device's.
    pub fn fit(&mut self, traits: Option<DeviceTraits>) {
        self.traits = traits;
    }

    /// The traits that effects are fitted to.
    ///
    /// # Safety
    /// `host` holds valid handles.
    pub unsafe fn traits(&self, host: &Host) -> DeviceTraits {
        // SAFETY: the caller's.
        self.traits.unwrap_or_else(|| unsafe { DeviceTraits::of(host.instance, host.physical_device) })
    }

    /// What each pipeline costs, by pass, shaders and specialisation; none unless this was made by [`Kernels::with_costs`].
    ///
    /// # Errors
    /// A failed Vulkan call.
    ///
    /// # Safety
    /// `host` is of the device that all of them were made on.
    pub unsafe fn costs(&self, host: &Host) -> Result<Option<Vec<Cost>>> {
        if !self.flags.contains(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR) {
            return Ok(None);
        }
        let made = self.lock();
        let cost = |(key, made): (&Key, &Option<Made>)| {
            let Some(made) = made else { return Ok(None) };
            // SAFETY: the caller's.
            let executables = unsafe { executables(host, made.pipeline.handle)? };
            let (shaders, specialisation) = (made.shaders.clone(), key.specialisation.clone());
            Ok(Some(Cost { pass: made.pass, shaders, specialisation, executables }))
        };
        let mut costs = made.iter().filter_map(|made| cost(made).transpose()).collect::<Result<Vec<Cost>>>()?;
        drop(made);
        costs.sort_by(|a, b| (a.pass, &a.shaders, &a.specialisation).cmp(&(b.pass, &b.shaders, &b.specialisation)));
        Ok(Some(costs))
    }

    /// How many pipelines there are.
    pub fn count(&self) -> usize {
        self.lock().values().flatten().count()
    }

    /// Makes those pipelines of passes that are not there. Threads that do so at the same time divide the work.
    ///
    /// # Errors
    /// A failed Vulkan call.
    ///
    /// # Safety
    /// `host` holds valid handles, of the same device in all calls.
    pub unsafe fn make(&self, host: &Host, passes: &[Pass]) -> Result<()> {
        let passes = || passes.iter().filter(|pass| !matches!(pass.kernel, Kernel::Transfer));
        for pass in passes() {
            if self.claim(&mut self.lock(), pass) {
                // SAFETY: the caller's.
                unsafe { self.create(host, pass)? };
            }
        }
        // What others were making has to be there, too.
        // SAFETY: the caller's.
        passes().try_for_each(|pass| unsafe { self.pipeline(host, pass) }.map(drop))
    }

    /// Whether the pipeline of a pass is now this thread's to make: it is not there, and no other makes it.
    fn claim(&self, made: &mut HashMap<Key, Option<Made>>, pass: &Pass) -> bool {
        match made.entry(Key::of(pass)) {
            Entry::Occupied(_) => false,
            Entry::Vacant(entry) => {
                entry.insert(None);
                true
            }
        }
    }

    /// The pipeline of a pass that is no transfer.
    ///
    /// # Safety
    /// `host` holds valid handles, of the same device in all calls.
    pub(crate) unsafe fn pipeline(&self, host: &Host, pass: &Pass) -> Result<Pipeline> {
        let mut made = self.lock();
        while !self.claim(&mut made, pass) {
            if let Some(Some(made)) = made.get(&Key::of(pass)) {
                return Ok(made.pipeline);
            }
            made = self.changed.wait(made).unwrap_or_else(PoisonError::into_inner);
        }
        drop(made);
        // SAFETY: the caller's.
        unsafe { self.create(host, pass) }
    }

    /// Makes a pipeline that this thread has claimed. Others need not wait while it is compiled.
    ///
    /// # Safety
    /// As of [`Self::pipeline`].
    unsafe fn create(&self, host: &Host, pass: &Pass) -> Result<Pipeline> {
        let mut new = Pipeline::default();
        // SAFETY: the caller's; a pipeline that failed has not been used.
        let result = unsafe {
            new.create(host, pass, self.flags)
                .map(|()| debug::set_name(host, new.handle, pass.name))
                .inspect_err(|_| new.destroy(host))
        };
        let mut made = self.lock();
        match result {
            Ok(()) => {
                let shaders = pass.shaders().into_iter().flatten().map(|shader| shader.file).collect();
                made.insert(Key::of(pass), Some(Made { pipeline: new, pass: pass.name, shaders }));
            }
            Err(_) => drop(made.remove(&Key::of(pass))),
        }
        self.changed.notify_all();
        result.map(|()| new)
    }

    /// Destroys the pipelines.
    ///
    /// # Safety
    /// `host` is of the device that all of them were made on. Every effect that was made with them is destroyed.
    pub unsafe fn destroy(&mut self, host: &Host) {
        for made in self.lock().drain().filter_map(|(_, made)| made) {
            // SAFETY: the caller's.
            unsafe { made.pipeline.destroy(host) };
        }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<Key, Option<Made>>> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Pipeline {
    /// # Safety
    /// `host` holds valid handles.
    unsafe fn create(&mut self, host: &Host, pass: &Pass, flags: vk::PipelineCreateFlags) -> Result<()> {
        // SAFETY: as above; the layouts are made for the pass.
        unsafe {
            self.set_layout = create_set_layout(host, pass)?;
            self.layout = create_layout(host, pass, self.set_layout)?;
            self.handle = match &pass.kernel {
                Kernel::Compute(shader) => create_compute(host, pass, shader, (self.layout, flags))?,
                Kernel::Raster(raster) => raster::create(host, pass, raster, (self.layout, flags))?,
                Kernel::Transfer => vk::Pipeline::null(),
            };
        }
        Ok(())
    }

    /// # Safety
    /// `host` is the one that it was made with, and nothing uses it any more.
    unsafe fn destroy(self, host: &Host) {
        // SAFETY: as above; null handles are ignored.
        unsafe {
            host.device.destroy_pipeline(self.handle, None);
            host.device.destroy_pipeline_layout(self.layout, None);
            host.device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

pub(crate) fn descriptor_type(kind: DescriptorKind) -> vk::DescriptorType {
    match kind {
        DescriptorKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        DescriptorKind::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
        DescriptorKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        DescriptorKind::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
    }
}

fn stage_flags(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Compute => vk::ShaderStageFlags::COMPUTE,
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::Fragment => vk::ShaderStageFlags::FRAGMENT,
    }
}

unsafe fn create_set_layout(host: &Host, pass: &Pass) -> Result<vk::DescriptorSetLayout> {
    let mut bindings: Vec<vk::DescriptorSetLayoutBinding> = Vec::new();
    for shader in pass.shaders().into_iter().flatten() {
        let stages = stage_flags(shader.stage);
        for binding in shader.bindings {
            match bindings.iter_mut().find(|other| other.binding == binding.number) {
                Some(shared) => shared.stage_flags |= stages,
                None => bindings.push(
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding.number)
                        .descriptor_type(descriptor_type(binding.kind))
                        .descriptor_count(1)
                        .stage_flags(stages),
                ),
            }
        }
    }
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the caller's.
    unsafe { host.device.create_descriptor_set_layout(&info, None) }
        .map_err(Error::vulkan("vkCreateDescriptorSetLayout", pass.name))
}

/// The push-constant range of a pass: its stages and its size.
pub(crate) fn push_range(pass: &Pass) -> (vk::ShaderStageFlags, u32) {
    let shaders = pass.shaders().into_iter().flatten().filter(|shader| shader.push_size > 0);
    shaders.fold((vk::ShaderStageFlags::empty(), 0), |(flags, size), shader| {
        (flags | stage_flags(shader.stage), size.max(shader.push_size))
    })
}

unsafe fn create_layout(host: &Host, pass: &Pass, set_layout: vk::DescriptorSetLayout) -> Result<vk::PipelineLayout> {
    let (stages, size) = push_range(pass);
    let range = [vk::PushConstantRange { stage_flags: stages, offset: 0, size }];
    let layouts = [set_layout];
    let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
    if size > 0 {
        info = info.push_constant_ranges(&range);
    }
    // SAFETY: the caller's.
    unsafe { host.device.create_pipeline_layout(&info, None) }
        .map_err(Error::vulkan("vkCreatePipelineLayout", pass.name))
}

unsafe fn create_compute(
    host: &Host,
    pass: &Pass,
    shader: &Shader,
    (layout, flags): (vk::PipelineLayout, vk::PipelineCreateFlags),
) -> Result<vk::Pipeline> {
    let mut entries = Vec::new();
    let specialisation = specialisation(pass, &mut entries);
    // SAFETY: the caller's; the module is only needed until the pipeline is made.
    unsafe {
        let module = create_module(host, shader)?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main")
            .specialization_info(&specialisation);
        let info = vk::ComputePipelineCreateInfo::default().flags(flags).stage(stage).layout(layout);
        let result = host.device.create_compute_pipelines(host.pipeline_cache, &[info], None);
        host.device.destroy_shader_module(module, None);
        let pipelines = result.map_err(|(_, e)| e).map_err(Error::vulkan("vkCreateComputePipelines", pass.name))?;
        Ok(pipelines[0])
    }
}
