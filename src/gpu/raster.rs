//! Render passes: pipelines for dynamic rendering.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::module::{create_module, specialisation};
use crate::host::Host;
use crate::plan::{Blend, Pass, Raster, Topology};

/// Creates the pipeline of a render pass.
///
/// # Safety
/// `host` holds valid handles; the layout was made for `pass`, and what the flags need is enabled.
pub(crate) unsafe fn create(
    host: &Host,
    pass: &Pass,
    raster: &Raster,
    made: (vk::PipelineLayout, vk::PipelineCreateFlags),
) -> Result<vk::Pipeline> {
    let mut entries = Vec::new();
    let specialisation = specialisation(pass, &mut entries);
    // SAFETY: the caller's; modules are only needed until the pipeline is made.
    unsafe {
        let vertex = create_module(host, raster.vertex)?;
        let fragment = match create_module(host, raster.fragment) {
            Ok(module) => module,
            Err(error) => {
                host.device.destroy_shader_module(vertex, None);
                return Err(error);
            }
        };
        let stage = |flags, module| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(flags)
                .module(module)
                .name(c"main")
                .specialization_info(&specialisation)
        };
        let stages = [stage(vk::ShaderStageFlags::VERTEX, vertex), stage(vk::ShaderStageFlags::FRAGMENT, fragment)];
        let result = create_pipeline(host, raster, made, &stages);
        host.device.destroy_shader_module(vertex, None);
        host.device.destroy_shader_module(fragment, None);
        result.map_err(Error::vulkan("vkCreateGraphicsPipelines", pass.name))
    }
}

unsafe fn create_pipeline(
    host: &Host,
    raster: &Raster,
    (layout, flags): (vk::PipelineLayout, vk::PipelineCreateFlags),
    stages: &[vk::PipelineShaderStageCreateInfo],
) -> std::result::Result<vk::Pipeline, vk::Result> {
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(match raster.topology {
        Topology::Quads => vk::PrimitiveTopology::TRIANGLE_STRIP,
        Topology::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
    });
    let viewport_state = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic_state = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
    let rasterisation = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(vk::CullModeFlags::NONE)
        .line_width(1.0);
    let multisample =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let mut depth_state = vk::PipelineDepthStencilStateCreateInfo::default();
    if let Some(depth) = &raster.depth {
        depth_state =
            depth_state.depth_test_enable(true).depth_write_enable(depth.write).depth_compare_op(depth.compare);
    }
    let blend_attachments: Vec<_> = raster.colour.iter().map(|colour| blend(colour.blend)).collect();
    let blend_state = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend_attachments);
    let formats: Vec<_> = raster.colour.iter().map(|colour| colour.format).collect();
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(&formats)
        .depth_attachment_format(raster.depth.map_or(vk::Format::UNDEFINED, |depth| depth.format));
    let info = vk::GraphicsPipelineCreateInfo::default()
        .flags(flags)
        .stages(stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport_state)
        .rasterization_state(&rasterisation)
        .multisample_state(&multisample)
        .depth_stencil_state(&depth_state)
        .color_blend_state(&blend_state)
        .dynamic_state(&dynamic_state)
        .layout(layout)
        .push_next(&mut rendering);
    // SAFETY: the caller's.
    let result = unsafe { host.device.create_graphics_pipelines(host.pipeline_cache, &[info], None) };
    result.map(|pipelines| pipelines[0]).map_err(|(_, error)| error)
}

fn blend(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    use vk::BlendFactor as Factor;
    let (source, target, target_alpha) = match blend {
        // Factors do not count for the larger.
        Blend::Replace | Blend::Over | Blend::Max => {
            (Factor::ONE, Factor::ONE_MINUS_SRC_ALPHA, Factor::ONE_MINUS_SRC_ALPHA)
        }
        Blend::Add => (Factor::ONE, Factor::ONE, Factor::ONE),
        Blend::Brighten => (Factor::DST_COLOR, Factor::ONE, Factor::ONE),
    };
    let operation = if blend == Blend::Max { vk::BlendOp::MAX } else { vk::BlendOp::ADD };
    vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(blend != Blend::Replace)
        .src_color_blend_factor(source)
        .dst_color_blend_factor(target)
        .color_blend_op(operation)
        .src_alpha_blend_factor(if blend == Blend::Brighten { Factor::ZERO } else { Factor::ONE })
        .dst_alpha_blend_factor(target_alpha)
        .alpha_blend_op(operation)
}

/// The whole of an area.
pub(crate) fn viewport(area: &vk::Rect2D) -> vk::Viewport {
    let [x, y] = [area.offset.x, area.offset.y].map(|side| side as f32);
    let [width, height] = [area.extent.width, area.extent.height].map(|side| side as f32);
    vk::Viewport { x, y, width, height, min_depth: 0.0, max_depth: 1.0 }
}
