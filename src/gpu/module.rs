//! Shader modules, and the constants that passes specialise them with.

use ash::vk;

use crate::error::{Error, Result};
use crate::host::Host;
use crate::plan::{Pass, Shader};

/// Specialisation constants 0, 1, 2... of a pass, 32 bits each; `entries` is room for where they stand.
pub(crate) fn specialisation<'a>(
    pass: &'a Pass,
    entries: &'a mut Vec<vk::SpecializationMapEntry>,
) -> vk::SpecializationInfo<'a> {
    let ids = 0..pass.specialisation.len() as u32;
    *entries = ids.map(|id| vk::SpecializationMapEntry { constant_id: id, offset: id * 4, size: 4 }).collect();
    vk::SpecializationInfo::default().map_entries(entries).data(bytemuck::cast_slice(&pass.specialisation))
}

/// Creates a shader module.
pub(crate) unsafe fn create_module(host: &Host, shader: &Shader) -> Result<vk::ShaderModule> {
    let info = vk::ShaderModuleCreateInfo::default().code(shader.words);
    // SAFETY: the caller's; `words` is SPIR-V from build.rs.
    unsafe { host.device.create_shader_module(&info, None) }.map_err(Error::vulkan("vkCreateShaderModule", shader.file))
}
