//! From declared passes to pipelines and descriptor sets. All of it happens at creation; recording only binds.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::module::{create_module, specialisation};
use crate::gpu::resources::Resources;
use crate::gpu::{debug, raster};
use crate::host::Host;
use crate::plan::{DescriptorKind, Kernel, Pass, Resource, Shader, Stage};

/// The Vulkan side of one pass; null handles for transfer passes.
#[derive(Debug, Default)]
pub struct Pipeline {
    /// The pipeline.
    pub handle: vk::Pipeline,
    /// Its layout.
    pub layout: vk::PipelineLayout,
    /// Its only descriptor set, written once: a pass always binds the same resources.
    pub set: vk::DescriptorSet,
    set_layout: vk::DescriptorSetLayout,
}

/// The Vulkan side of an effect's passes, by pass id.
#[derive(Debug, Default)]
pub struct Pipelines {
    /// One a pass.
    pub pipelines: Vec<Pipeline>,
    pool: vk::DescriptorPool,
}

impl Pipelines {
    /// Creates pipelines and descriptor sets; leaves nothing behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles; `resources` are made for `passes` and outlive the result.
    pub unsafe fn new(host: &Host, passes: &[Pass], resources: &Resources) -> Result<Pipelines> {
        let mut made = Pipelines::default();
        // SAFETY: the caller's; on error everything made so far is destroyed unused.
        unsafe {
            match made.create(host, passes, resources) {
                Ok(()) => Ok(made),
                Err(error) => {
                    made.destroy(host);
                    Err(error)
                }
            }
        }
    }

    unsafe fn create(&mut self, host: &Host, passes: &[Pass], resources: &Resources) -> Result<()> {
        // SAFETY: the caller's, for all calls below.
        unsafe {
            self.pool = create_pool(host, passes)?;
            for pass in passes {
                self.pipelines.push(Pipeline::default());
                if matches!(pass.kernel, Kernel::Transfer) {
                    continue;
                }
                if let Some(binding) = pass.unbound().next() {
                    let why = format!("{}: nothing is bound to {}", pass.name, binding.name);
                    return Err(Error::HostResource { name: "pass", why });
                }
                let Some(pipeline) = self.pipelines.last_mut() else { continue };
                pipeline.set_layout = create_set_layout(host, pass)?;
                pipeline.layout = create_pipeline_layout(host, pass, pipeline.set_layout)?;
                pipeline.set = allocate_set(host, pass, self.pool, pipeline.set_layout)?;
                write_set(host, pass, resources, pipeline.set);
                pipeline.handle = match &pass.kernel {
                    Kernel::Compute(shader) => create_compute(host, pass, shader, pipeline.layout)?,
                    Kernel::Raster(raster) => raster::create(host, pass, raster, pipeline.layout)?,
                    Kernel::Transfer => vk::Pipeline::null(),
                };
                debug::set_name(host, pipeline.handle, pass.name);
            }
        }
        Ok(())
    }

    /// Destroys everything.
    ///
    /// # Safety
    /// The GPU is done with it; `host` is the one it was made with.
    pub unsafe fn destroy(&mut self, host: &Host) {
        // SAFETY: the caller's; null handles are ignored, and the pool frees its sets.
        unsafe {
            for pipeline in self.pipelines.drain(..) {
                host.device.destroy_pipeline(pipeline.handle, None);
                host.device.destroy_pipeline_layout(pipeline.layout, None);
                host.device.destroy_descriptor_set_layout(pipeline.set_layout, None);
            }
            host.device.destroy_descriptor_pool(self.pool, None);
        }
        self.pool = vk::DescriptorPool::null();
    }
}

fn descriptor_type(kind: DescriptorKind) -> vk::DescriptorType {
    match kind {
        DescriptorKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        DescriptorKind::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
        DescriptorKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        DescriptorKind::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
    }
}

unsafe fn create_pool(host: &Host, passes: &[Pass]) -> Result<vk::DescriptorPool> {
    let mut sizes = Vec::new();
    for kind in [
        DescriptorKind::StorageBuffer,
        DescriptorKind::UniformBuffer,
        DescriptorKind::StorageImage,
        DescriptorKind::SampledImage,
    ] {
        let count = passes.iter().flat_map(|p| &p.bindings).filter(|(binding, _)| binding.kind == kind).count();
        if count > 0 {
            sizes.push(vk::DescriptorPoolSize { ty: descriptor_type(kind), descriptor_count: count as u32 });
        }
    }
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(passes.len().max(1) as u32).pool_sizes(&sizes);
    // SAFETY: the caller's.
    unsafe { host.device.create_descriptor_pool(&info, None) }.map_err(Error::vulkan("vkCreateDescriptorPool", ""))
}

unsafe fn create_set_layout(host: &Host, pass: &Pass) -> Result<vk::DescriptorSetLayout> {
    let stages = |number| {
        let shaders = pass.shaders().into_iter().flatten();
        let using = shaders.filter(|shader| shader.bindings.iter().any(|other| other.number == number));
        using.fold(vk::ShaderStageFlags::empty(), |flags, shader| flags | stage_flags(shader.stage))
    };
    let bindings: Vec<_> = pass
        .bindings
        .iter()
        .map(|(binding, _)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding.number)
                .descriptor_type(descriptor_type(binding.kind))
                .descriptor_count(1)
                .stage_flags(stages(binding.number))
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the caller's.
    unsafe { host.device.create_descriptor_set_layout(&info, None) }
        .map_err(Error::vulkan("vkCreateDescriptorSetLayout", pass.name))
}

fn stage_flags(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Compute => vk::ShaderStageFlags::COMPUTE,
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::Fragment => vk::ShaderStageFlags::FRAGMENT,
    }
}

/// The push-constant range of a pass: its stages and its size.
pub(crate) fn push_range(pass: &Pass) -> (vk::ShaderStageFlags, u32) {
    let shaders = pass.shaders().into_iter().flatten().filter(|shader| shader.push_size > 0);
    shaders.fold((vk::ShaderStageFlags::empty(), 0), |(flags, size), shader| {
        (flags | stage_flags(shader.stage), size.max(shader.push_size))
    })
}

unsafe fn create_pipeline_layout(
    host: &Host,
    pass: &Pass,
    set_layout: vk::DescriptorSetLayout,
) -> Result<vk::PipelineLayout> {
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

unsafe fn allocate_set(
    host: &Host,
    pass: &Pass,
    pool: vk::DescriptorPool,
    layout: vk::DescriptorSetLayout,
) -> Result<vk::DescriptorSet> {
    let layouts = [layout];
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
    // SAFETY: the caller's.
    let sets = unsafe { host.device.allocate_descriptor_sets(&info) };
    Ok(sets.map_err(Error::vulkan("vkAllocateDescriptorSets", pass.name))?[0])
}

unsafe fn write_set(host: &Host, pass: &Pass, resources: &Resources, set: vk::DescriptorSet) {
    for (binding, resource) in &pass.bindings {
        let write = vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(binding.number)
            .descriptor_type(descriptor_type(binding.kind));
        match resource {
            Resource::Buffer(id) => {
                let (buffer, offset, range) = resources.buffer(*id);
                let info = [vk::DescriptorBufferInfo { buffer, offset, range }];
                // SAFETY: the caller's; the set is not in use yet.
                unsafe { host.device.update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
            }
            Resource::Image(id) => {
                let image_view = resources.descriptor_view(*id);
                let sampler = vk::Sampler::null();
                let info = [vk::DescriptorImageInfo { sampler, image_view, image_layout: vk::ImageLayout::GENERAL }];
                // SAFETY: the caller's; the set is not in use yet.
                unsafe { host.device.update_descriptor_sets(&[write.image_info(&info)], &[]) };
            }
        }
    }
}

unsafe fn create_compute(
    host: &Host,
    pass: &Pass,
    shader: &Shader,
    layout: vk::PipelineLayout,
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
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout);
        let result = host.device.create_compute_pipelines(host.pipeline_cache, &[info], None);
        host.device.destroy_shader_module(module, None);
        let pipelines = result.map_err(|(_, e)| e).map_err(Error::vulkan("vkCreateComputePipelines", pass.name))?;
        Ok(pipelines[0])
    }
}
