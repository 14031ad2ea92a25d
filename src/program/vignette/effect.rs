//! The vignette on the device: two passes.

use ash::vk;

use crate::effect::{DeviceTraits, Effect, Effort, Inventory, Kind};
use crate::error::Result;
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::resources::{Kept, Resources};
use crate::host::{HostImage, NamedFormat, target_format};
use crate::layout::{Sizes, buffers};
use crate::plan::{
    Binding, Blend, BufferId, ColourAttachment, Command, ImageId, Pass, Plan, Raster, Resource, Topology, passes,
};
use crate::shaders::vignette as glsl;
pub use crate::shaders::vignette::blocks::VignetteParams;

buffers!("vignette" PARAMS = "VignetteParams", DARKNESS = "Darkness");
/// The host's target.
const TARGET: ImageId = ImageId(0);
/// Vertices of a draw of the whole picture.
const QUAD_VERTICES: u32 = 4;

/// Description of a vignette.
#[derive(Clone, Debug)]
pub struct Desc {
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// Format of the target.
    pub target_format: vk::Format,
    /// Darkness of the corners, 0 to 1.
    pub strength: f32,
    /// Where it begins, as a share of the way from the centre to a corner, 0 to 0.99.
    pub radius: f32,
}

/// The vignette.
pub type Vignette = Effect<VignetteKind>;

/// The parts that are the vignette's own.
#[derive(Debug)]
pub struct VignetteKind {
    layout: Layout,
    passes: Passes,
}

/// Its buffers.
#[derive(Debug)]
pub struct Layout(Sizes<{ BUFFERS as usize }>);

passes! {
    (desc: &Desc), resource;
    params = Pass::transfer("vignette.darkness").updates::<VignetteParams>(PARAMS, 1);
    darkness = Pass::compute("vignette.darkness", &glsl::darkness::SHADER);
    composite = Pass::raster("vignette.composite", Raster {
        topology: Topology::Quads,
        vertex: &glsl::composite_vertex::SHADER,
        fragment: &glsl::composite_fragment::SHADER,
        colour: Some(ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: Blend::Over }),
        depth: None,
        extent: desc.size,
    });
}

fn resource(binding: &Binding) -> Option<Resource> {
    BLOCKS.iter().position(|name| *name == binding.name).map(|index| Resource::Buffer(BufferId(index as u16)))
}

impl Kind for VignetteKind {
    const NAME: &'static str = "vignette";
    type Desc = Desc;
    type Layout = Layout;
    type Frame<'a> = HostImage;
    type Recorded = ();

    fn new(desc: &Desc, traits: &DeviceTraits, _: Effort) -> Result<VignetteKind> {
        traits.check_sides(desc.size)?;
        let mut sizes = Sizes::LEAST;
        sizes.set(PARAMS, size_of::<VignetteParams>() as u64);
        sizes.set(DARKNESS, 4 * u64::from(desc.size[0]) * u64::from(desc.size[1]));
        sizes.check(traits.storage_range, &NAMES, |_| "use a smaller picture")?;
        Ok(VignetteKind { layout: Layout(sizes), passes: Passes::new(desc) })
    }

    fn resized(desc: &Desc, size: [u32; 2]) -> Desc {
        Desc { size, ..desc.clone() }
    }

    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn take_passes(&mut self) -> Vec<Pass> {
        std::mem::take(&mut self.passes.list)
    }

    fn plan(&mut self, desc: &Desc, target: &HostImage, plan: &mut Plan) -> Result<()> {
        let Passes { params, darkness, composite, .. } = self.passes;
        let Desc { size, strength, radius, .. } = *desc;
        if strength == 0.0 {
            plan.skip(darkness, "no darkness");
            plan.skip(composite, "no darkness");
            return Ok(());
        }
        plan.update(params, PARAMS, &VignetteParams { size, corner: target.offset, strength, radius });
        plan.step(darkness, Command::Dispatch { threads: [size[0], size[1], 1] });
        plan.step(composite, Command::Draw { vertices: QUAD_VERTICES });
        Ok(())
    }

    fn upload(&self, _: &Desc, target: &HostImage, resources: &mut Resources) {
        resources.set_host_image(TARGET, Some(*target));
    }

    fn recorded(&mut self, _: &Desc, (): ()) {}

    fn forget(&mut self) {}

    fn go_on(&mut self, _: &VignetteKind, _: [&Desc; 2], _: &Kept) {}

    fn formats(desc: &Desc) -> Vec<NamedFormat> {
        vec![target_format(desc.target_format)]
    }
}

impl Inventory for Layout {
    type Desc = Desc;
    const HOST_BUFFERS: usize = 0;
    const HOST_IMAGES: usize = 1;

    fn buffers(&self, _: &Desc) -> Vec<BufferDesc> {
        self.0.descriptions(&NAMES, [PARAMS], false).collect()
    }

    fn images(&self, _: &Desc) -> Vec<ImageDesc> {
        Vec::new()
    }
}
