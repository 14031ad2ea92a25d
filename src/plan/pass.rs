//! Passes: shaders with their bindings, attachments, and everything that a pass touches.

use ash::vk;

use crate::host::DepthFormat;

/// Shader stage of a [`Shader`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Compute.
    Compute,
    /// Vertex.
    Vertex,
    /// Fragment.
    Fragment,
}

/// A shader's access to a binding, as its `readonly` and `writeonly` qualifiers say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Reads only.
    Read,
    /// Writes only.
    Write,
    /// Reads and writes.
    ReadWrite,
}

/// Descriptor type of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescriptorKind {
    /// Storage buffer.
    StorageBuffer,
    /// Uniform buffer.
    UniformBuffer,
    /// Storage image.
    StorageImage,
    /// Image that is read through texel fetches.
    SampledImage,
}

/// One binding of a shader (descriptor set 0), from reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Name of the block or image in the shader.
    pub name: &'static str,
    /// Its number in the set.
    pub number: u32,
    /// Descriptor type.
    pub kind: DescriptorKind,
    /// The shader's access to it.
    pub access: Access,
}

/// A compiled shader, from the table that `build.rs` writes.
#[derive(Debug)]
pub struct Shader {
    /// Path below `glsl/`.
    pub file: &'static str,
    /// Its stage.
    pub stage: Stage,
    /// Invocations per workgroup along x, y, z (compute).
    pub local_size: [u32; 3],
    /// Bytes of push constants.
    pub push_size: u32,
    /// Its bindings, ascending.
    pub bindings: &'static [Binding],
    /// SPIR-V.
    pub words: &'static [u32],
}

/// A buffer of the effect, or one that the host hands over each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BufferId(pub u16);

/// An image of the effect, or one that the host hands over each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageId(pub u16);

/// A buffer or an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Resource {
    /// A buffer, whole.
    Buffer(BufferId),
    /// An image, whole.
    Image(ImageId),
}

impl From<BufferId> for Resource {
    fn from(id: BufferId) -> Self {
        Resource::Buffer(id)
    }
}

impl From<ImageId> for Resource {
    fn from(id: ImageId) -> Self {
        Resource::Image(id)
    }
}

/// How a pass uses a resource: what barriers are derived from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Usage {
    /// Pipeline stages that touch it.
    pub stage: vk::PipelineStageFlags2,
    /// Reads among the accesses.
    pub reads: vk::AccessFlags2,
    /// Writes among the accesses.
    pub writes: vk::AccessFlags2,
}

impl Usage {
    /// Arguments of an indirect dispatch or draw.
    pub const INDIRECT: Usage = Usage {
        stage: vk::PipelineStageFlags2::DRAW_INDIRECT,
        reads: vk::AccessFlags2::INDIRECT_COMMAND_READ,
        writes: vk::AccessFlags2::NONE,
    };
    /// Source of a copy.
    pub const COPY_SOURCE: Usage = Usage {
        stage: vk::PipelineStageFlags2::ALL_TRANSFER,
        reads: vk::AccessFlags2::TRANSFER_READ,
        writes: vk::AccessFlags2::NONE,
    };
    /// Destination of a copy, fill, update or clear.
    pub const COPY_TARGET: Usage = Usage {
        stage: vk::PipelineStageFlags2::ALL_TRANSFER,
        reads: vk::AccessFlags2::NONE,
        writes: vk::AccessFlags2::TRANSFER_WRITE,
    };
    /// Colour attachment.
    pub const COLOUR: Usage = Usage {
        stage: vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT,
        reads: vk::AccessFlags2::COLOR_ATTACHMENT_READ,
        writes: vk::AccessFlags2::COLOR_ATTACHMENT_WRITE,
    };
    /// Depth attachment, tested and written.
    pub const DEPTH: Usage = Usage {
        stage: vk::PipelineStageFlags2::from_raw(
            vk::PipelineStageFlags2::EARLY_FRAGMENT_TESTS.as_raw()
                | vk::PipelineStageFlags2::LATE_FRAGMENT_TESTS.as_raw(),
        ),
        reads: vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_READ,
        writes: vk::AccessFlags2::DEPTH_STENCIL_ATTACHMENT_WRITE,
    };

    /// The usage of a binding in `stage`.
    pub fn of_binding(stage: Stage, binding: &Binding) -> Usage {
        let stage = match stage {
            Stage::Compute => vk::PipelineStageFlags2::COMPUTE_SHADER,
            Stage::Vertex => vk::PipelineStageFlags2::VERTEX_SHADER,
            Stage::Fragment => vk::PipelineStageFlags2::FRAGMENT_SHADER,
        };
        let read = match binding.kind {
            DescriptorKind::UniformBuffer => vk::AccessFlags2::UNIFORM_READ,
            DescriptorKind::SampledImage => vk::AccessFlags2::SHADER_SAMPLED_READ,
            DescriptorKind::StorageBuffer | DescriptorKind::StorageImage => vk::AccessFlags2::SHADER_STORAGE_READ,
        };
        let write = vk::AccessFlags2::SHADER_STORAGE_WRITE;
        let none = vk::AccessFlags2::NONE;
        let (reads, writes) = match binding.access {
            Access::Read => (read, none),
            Access::Write => (none, write),
            Access::ReadWrite => (read, write),
        };
        Usage { stage, reads, writes }
    }

    /// Reads and writes together.
    pub fn access(&self) -> vk::AccessFlags2 {
        self.reads | self.writes
    }
}

/// A colour attachment of a render pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourAttachment {
    /// The image.
    pub image: ImageId,
    /// Its format.
    pub format: vk::Format,
    /// Clear value in bits, or none to keep what is there.
    pub clear: Option<[u32; 4]>,
    /// How it takes what is drawn.
    pub blend: Blend,
}

/// The depth attachment of a render pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthAttachment {
    /// The image, `D32_SFLOAT` if the effect made it.
    pub image: ImageId,
    /// Its format.
    pub format: vk::Format,
    /// Clear value, or none to keep what is there.
    pub clear: Option<f32>,
    /// The comparison that a fragment must pass.
    pub compare: vk::CompareOp,
    /// Whether what passes stays; else it is only tested.
    pub write: bool,
    /// Array layer.
    pub layer: u32,
}

impl DepthAttachment {
    /// An image of the effect that is cleared to 0 and keeps the largest depth; of equal ones the first.
    pub fn nearest(image: ImageId) -> DepthAttachment {
        let (format, compare) = (vk::Format::D32_SFLOAT, vk::CompareOp::GREATER);
        DepthAttachment { image, format, clear: Some(0.0), compare, write: true, layer: 0 }
    }

    /// The host's depth. Equal depth passes: what is drawn twice stays.
    pub fn of_host(image: ImageId, DepthFormat { format, reversed }: DepthFormat, write: bool) -> DepthAttachment {
        let compare = if reversed { vk::CompareOp::GREATER_OR_EQUAL } else { vk::CompareOp::LESS_OR_EQUAL };
        DepthAttachment { image, format, clear: None, compare, write, layer: 0 }
    }
}

/// How a colour attachment takes what is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blend {
    /// Replaces.
    Replace,
    /// Premultiplied "over".
    Over,
    /// Brightens: `target * (1 + drawn)`; alpha stays.
    Brighten,
    /// Adds.
    Add,
    /// Keeps the larger of both.
    Max,
}

/// Primitives of a render pass. Vertex shaders make their vertices from `gl_VertexIndex`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Topology {
    /// Quads as triangle strips of four vertices, one an instance.
    Quads,
    /// Triangles, three vertices each.
    Triangles,
}

/// Shaders and fixed state of a render pass; nothing is culled.
#[derive(Debug)]
pub struct Raster {
    /// Its primitives.
    pub topology: Topology,
    /// Vertex shader.
    pub vertex: &'static Shader,
    /// Fragment shader.
    pub fragment: &'static Shader,
    /// At most one colour attachment.
    pub colour: Option<ColourAttachment>,
    /// Depth attachment.
    pub depth: Option<DepthAttachment>,
    /// Pixels.
    pub extent: [u32; 2],
}

/// The kernel of a pass: its shaders, or a transfer.
#[derive(Debug)]
pub enum Kernel {
    /// A compute shader.
    Compute(&'static Shader),
    /// A render pass.
    Raster(Raster),
    /// Clears, fills, updates and copies.
    Transfer,
}

/// Index into an effect's passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PassId(pub u16);

/// A pass: declared once, when the effect is made.
#[derive(Debug)]
pub struct Pass {
    /// Label, profile row: `effect.pass`.
    pub name: &'static str,
    /// Its kernel.
    pub kernel: Kernel,
    /// Descriptors.
    pub bindings: Vec<(Binding, Resource)>,
    /// Everything it touches, bound or not.
    pub uses: Vec<(Resource, Usage)>,
    /// Specialisation constants 0, 1, 2..., each 32 bits.
    pub specialisation: Vec<u32>,
    /// The most steps of it that a frame has.
    pub most_steps: usize,
    /// The most bytes that these write from the plan.
    pub most_bytes: usize,
}

impl Pass {
    fn new(name: &'static str, kernel: Kernel, most_steps: usize) -> Pass {
        let (bindings, uses, specialisation) = (Vec::new(), Vec::new(), Vec::new());
        Pass { name, kernel, bindings, uses, specialisation, most_steps, most_bytes: 0 }
    }

    /// A compute pass: one dispatch a frame, unless [`Pass::times`] says more.
    pub fn compute(name: &'static str, shader: &'static Shader) -> Pass {
        Pass::new(name, Kernel::Compute(shader), 1)
    }

    /// A render pass: one draw a frame, unless [`Pass::times`] says more.
    pub fn raster(name: &'static str, raster: Raster) -> Pass {
        let colour = raster.colour.as_ref().map(|colour| (colour.image.into(), Usage::COLOUR));
        let depth = raster.depth.as_ref().map(|depth| (depth.image.into(), Usage::DEPTH));
        let pass = Pass::new(name, Kernel::Raster(raster), 1);
        Pass { uses: colour.into_iter().chain(depth).collect(), ..pass }
    }

    /// A pass of the clears, fills, updates and copies that follow.
    pub fn transfer(name: &'static str) -> Pass {
        Pass::new(name, Kernel::Transfer, 0)
    }

    /// Fills a buffer with a word.
    pub fn fills(self, buffer: BufferId) -> Pass {
        self.writes(buffer.into(), 0)
    }

    /// Writes up to `count` values of the plan to a buffer.
    pub fn updates<T>(self, buffer: BufferId, count: usize) -> Pass {
        self.writes(buffer.into(), count * size_of::<T>())
    }

    fn writes(mut self, target: Resource, bytes: usize) -> Pass {
        self.most_steps += 1;
        self.most_bytes += bytes;
        self.uses(target, Usage::COPY_TARGET)
    }

    /// Copies one resource to another.
    pub fn copies(mut self, from: impl Into<Resource>, to: impl Into<Resource>) -> Pass {
        self.most_steps += 1;
        self.uses(from, Usage::COPY_SOURCE).uses(to, Usage::COPY_TARGET)
    }

    /// A frame has all of its steps up to so many times.
    pub fn times(mut self, count: usize) -> Pass {
        self.most_steps *= count;
        self.most_bytes *= count;
        self
    }

    /// Binds a resource; what the pass does with it is what the shader's qualifiers say.
    pub fn bind(mut self, binding: Binding, resource: impl Into<Resource>) -> Pass {
        let resource = resource.into();
        for shader in self.shaders().into_iter().flatten() {
            if shader.bindings.contains(&binding) {
                self.uses.push((resource, Usage::of_binding(shader.stage, &binding)));
            }
        }
        if !self.bindings.iter().any(|(bound, _)| bound.number == binding.number) {
            self.bindings.push((binding, resource));
        }
        self
    }

    /// Binds everything that its shaders declare to what `resource` knows by that name.
    pub fn bind_all(mut self, resource: impl Fn(&Binding) -> Option<Resource>) -> Pass {
        for binding in self.shaders().into_iter().flatten().flat_map(|shader| shader.bindings) {
            let bound = self.bindings.iter().any(|(bound, _)| bound.number == binding.number);
            if let Some(resource) = resource(binding).filter(|_| !bound) {
                self = self.bind(*binding, resource);
            }
        }
        self
    }

    /// Declares a use that is no descriptor.
    pub fn uses(mut self, resource: impl Into<Resource>, usage: Usage) -> Pass {
        self.uses.push((resource.into(), usage));
        self
    }

    /// Sets the specialisation constants 0, 1, 2...
    pub fn specialise(mut self, constants: impl IntoIterator<Item = u32>) -> Pass {
        self.specialisation = constants.into_iter().collect();
        self
    }

    /// Its shaders.
    pub fn shaders(&self) -> [Option<&'static Shader>; 2] {
        match &self.kernel {
            Kernel::Compute(shader) => [Some(shader), None],
            Kernel::Raster(raster) => [Some(raster.vertex), Some(raster.fragment)],
            Kernel::Transfer => [None, None],
        }
    }

    /// The bindings that its shaders have and nothing is bound to.
    pub fn unbound(&self) -> impl Iterator<Item = &'static Binding> + '_ {
        let all = self.shaders().into_iter().flatten().flat_map(|shader| shader.bindings);
        all.filter(|binding| !self.bindings.iter().any(|(bound, _)| bound.number == binding.number))
    }
}
