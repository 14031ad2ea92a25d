//! An effect's passes on the device: which pipelines they run, and their descriptor sets. All of it happens at creation;
//! recording only binds.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::kernels::{Kernels, Pipeline, descriptor_type};
use crate::gpu::resources::Resources;
use crate::host::Host;
use crate::plan::{DescriptorKind, Kernel, Pass, Resource};

/// The Vulkan side of one pass; null handles for transfer passes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bound {
    pub pipeline: Pipeline,
    /// Its only descriptor set, written once: a pass always binds the same resources.
    pub set: vk::DescriptorSet,
}

/// The Vulkan side of an effect's passes.
#[derive(Debug, Default)]
pub struct Pipelines {
    /// By pass id.
    pub(crate) passes: Vec<Bound>,
    pool: vk::DescriptorPool,
}

impl Pipelines {
    /// Makes descriptor sets, and those pipelines that `kernels` has not got yet; leaves no set behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles of the device that `kernels` is of; `resources` are made for `passes` and outlive the
    /// result, as `kernels` does.
    pub unsafe fn new(host: &Host, kernels: &Kernels, passes: &[Pass], resources: &Resources) -> Result<Pipelines> {
        let mut made = Pipelines::default();
        // SAFETY: the caller's; on error everything made so far is destroyed unused.
        unsafe { made.create(host, kernels, passes, resources).inspect_err(|_| made.destroy(host))? };
        Ok(made)
    }

    unsafe fn create(&mut self, host: &Host, kernels: &Kernels, passes: &[Pass], resources: &Resources) -> Result<()> {
        // SAFETY: the caller's, for all calls below.
        unsafe {
            kernels.make(host, passes)?;
            self.pool = create_pool(host, passes)?;
            for pass in passes {
                self.passes.push(bind(host, kernels, pass, resources, self.pool)?);
            }
        }
        Ok(())
    }

    /// Destroys the descriptor sets.
    ///
    /// # Safety
    /// The GPU is done with them; `host` is the one they were made with.
    pub unsafe fn destroy(&mut self, host: &Host) {
        self.passes.clear();
        // SAFETY: the caller's; a null handle is ignored, and the pool frees its sets.
        unsafe { host.device.destroy_descriptor_pool(self.pool, None) };
        self.pool = vk::DescriptorPool::null();
    }
}

unsafe fn bind(
    host: &Host,
    kernels: &Kernels,
    pass: &Pass,
    resources: &Resources,
    pool: vk::DescriptorPool,
) -> Result<Bound> {
    if matches!(pass.kernel, Kernel::Transfer) {
        return Ok(Bound::default());
    }
    if let Some(binding) = pass.unbound().next() {
        let why = format!("{}: nothing is bound to {}", pass.name, binding.name);
        return Err(Error::HostResource { name: "pass", why });
    }
    // SAFETY: the caller's.
    unsafe {
        let pipeline = kernels.pipeline(host, pass)?;
        let set = allocate_set(host, pass, pool, pipeline.set_layout)?;
        write_set(host, pass, resources, set);
        Ok(Bound { pipeline, set })
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
