//! A frame is a list: what an effect does, as plain data.
//!
//! An effect declares its [`Pass`]es once: name, kernel, what each reads and writes. Each frame it fills a [`Plan`] with
//! [`Step`]s: which passes run, in which order, over how many threads. `barrier` derives the barriers, `gpu::recorder`
//! walks the list into a command buffer. The order that you read is the order that runs. Nothing here calls Vulkan.

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

/// What a shader does with a binding, as its `readonly` and `writeonly` qualifiers say.
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
pub enum SlotKind {
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
pub struct Slot {
    /// Name of the block or image in the shader.
    pub name: &'static str,
    /// Binding number.
    pub binding: u32,
    /// Descriptor type.
    pub kind: SlotKind,
    /// What the shader does with it.
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
    pub slots: &'static [Slot],
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

    /// What `stage` does with a slot.
    pub fn of_slot(stage: Stage, slot: &Slot) -> Usage {
        let stage = match stage {
            Stage::Compute => vk::PipelineStageFlags2::COMPUTE_SHADER,
            Stage::Vertex => vk::PipelineStageFlags2::VERTEX_SHADER,
            Stage::Fragment => vk::PipelineStageFlags2::FRAGMENT_SHADER,
        };
        let read = match slot.kind {
            SlotKind::UniformBuffer => vk::AccessFlags2::UNIFORM_READ,
            SlotKind::SampledImage => vk::AccessFlags2::SHADER_SAMPLED_READ,
            SlotKind::StorageBuffer | SlotKind::StorageImage => vk::AccessFlags2::SHADER_STORAGE_READ,
        };
        let write = vk::AccessFlags2::SHADER_STORAGE_WRITE;
        let none = vk::AccessFlags2::NONE;
        let (reads, writes) = match slot.access {
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
    /// What passes.
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

/// What a render pass draws. Vertex shaders make their vertices from `gl_VertexIndex`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    /// Quads as triangle strips of four vertices, one an instance.
    Quads,
    /// Triangles, three vertices each.
    Triangles,
}

/// Shaders and fixed state of a render pass; nothing is culled.
#[derive(Debug)]
pub struct Raster {
    /// What it draws.
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

/// What a pass runs.
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
    /// What runs.
    pub kernel: Kernel,
    /// Descriptors.
    pub bindings: Vec<(Slot, Resource)>,
    /// Everything it touches, bound or not.
    pub uses: Vec<(Resource, Usage)>,
    /// Specialisation constants 0, 1, 2..., each 32 bits.
    pub specialisation: Vec<u32>,
}

impl Pass {
    /// A compute pass.
    pub fn compute(name: &'static str, shader: &'static Shader) -> Pass {
        Pass { name, kernel: Kernel::Compute(shader), bindings: vec![], uses: vec![], specialisation: vec![] }
    }

    /// A render pass.
    pub fn raster(name: &'static str, raster: Raster) -> Pass {
        let mut uses = Vec::new();
        if let Some(colour) = &raster.colour {
            uses.push((Resource::Image(colour.image), Usage::COLOUR));
        }
        if let Some(depth) = &raster.depth {
            uses.push((Resource::Image(depth.image), Usage::DEPTH));
        }
        Pass { name, kernel: Kernel::Raster(raster), bindings: vec![], uses, specialisation: vec![] }
    }

    /// A pass of clears, fills, updates or copies.
    pub fn transfer(name: &'static str) -> Pass {
        Pass { name, kernel: Kernel::Transfer, bindings: vec![], uses: vec![], specialisation: vec![] }
    }

    /// Binds a resource; what the pass does with it is what the shader's qualifiers say.
    pub fn bind(mut self, slot: Slot, resource: impl Into<Resource>) -> Pass {
        let resource = resource.into();
        for shader in self.shaders().into_iter().flatten() {
            if shader.slots.contains(&slot) {
                self.uses.push((resource, Usage::of_slot(shader.stage, &slot)));
            }
        }
        if !self.bindings.iter().any(|(bound, _)| bound.binding == slot.binding) {
            self.bindings.push((slot, resource));
        }
        self
    }

    /// Binds every slot of its shaders to what `resource` knows by the slot's name.
    pub fn bind_all(mut self, resource: impl Fn(&Slot) -> Option<Resource>) -> Pass {
        for slot in self.shaders().into_iter().flatten().flat_map(|shader| shader.slots) {
            let bound = self.bindings.iter().any(|(bound, _)| bound.binding == slot.binding);
            if let Some(resource) = resource(slot).filter(|_| !bound) {
                self = self.bind(*slot, resource);
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

    /// The slots that its shaders have and nothing is bound to.
    pub fn unbound(&self) -> impl Iterator<Item = &'static Slot> + '_ {
        let slots = self.shaders().into_iter().flatten().flat_map(|shader| shader.slots);
        slots.filter(|slot| !self.bindings.iter().any(|(bound, _)| bound.binding == slot.binding))
    }
}

/// Collects an effect's passes as they are declared; every kernel binds its slots by their names.
pub(crate) struct Declare {
    /// By [`PassId`].
    pub(crate) list: Vec<Pass>,
    resource: fn(&Slot) -> Option<Resource>,
}

impl Declare {
    /// `resource`: what a slot stands for.
    pub(crate) fn new(resource: fn(&Slot) -> Option<Resource>) -> Declare {
        Declare { list: Vec::new(), resource }
    }

    pub(crate) fn add(&mut self, pass: Pass) -> PassId {
        self.list.push(pass.bind_all(self.resource));
        PassId(self.list.len() as u16 - 1)
    }

    pub(crate) fn compute(&mut self, name: &'static str, shader: &'static Shader) -> PassId {
        self.add(Pass::compute(name, shader))
    }

    pub(crate) fn transfer(&mut self, name: &'static str, uses: &[(Resource, Usage)]) -> PassId {
        self.add(uses.iter().fold(Pass::transfer(name), |pass, (resource, usage)| pass.uses(*resource, *usage)))
    }

    /// Writes to buffers by fills and updates.
    pub(crate) fn writes(&mut self, name: &'static str, buffers: &[BufferId]) -> PassId {
        let uses: Vec<_> = buffers.iter().map(|buffer| ((*buffer).into(), Usage::COPY_TARGET)).collect();
        self.transfer(name, &uses)
    }
}

/// Bytes of push constants.
pub const PUSH_CONSTANT_BYTES: usize = 128;

/// What one step tells the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// So many threads; groups are `div_ceil(threads, local size)`.
    Dispatch {
        /// Threads along x, y, z.
        threads: [u32; 3],
    },
    /// Groups from a buffer.
    DispatchIndirect {
        /// Holds a `VkDispatchIndirectCommand`.
        arguments: BufferId,
        /// Its offset in bytes.
        offset: u64,
    },
    /// So many vertices of one instance: triangles, or one quad of four.
    Draw {
        /// Vertices.
        vertices: u32,
    },
    /// Quads, one an instance, or triangles of one instance; their number from a buffer.
    DrawIndirect {
        /// Holds a `VkDrawIndirectCommand`.
        arguments: BufferId,
        /// Its offset in bytes.
        offset: u64,
    },
    /// Fills a buffer with a word.
    Fill {
        /// The buffer, whole.
        buffer: BufferId,
        /// The word.
        word: u32,
    },
    /// Writes bytes of the plan (at most 64 KiB) to the start of a buffer.
    Update {
        /// The buffer.
        buffer: BufferId,
        /// First byte in [`Plan::data`].
        from: usize,
        /// Number of bytes.
        bytes: usize,
    },
    /// Clears a colour image.
    Clear {
        /// The image.
        image: ImageId,
        /// Value in bits.
        value: [u32; 4],
    },
    /// Copies the start of a buffer.
    CopyBuffer {
        /// Source.
        from: BufferId,
        /// Destination.
        to: BufferId,
        /// Number of bytes.
        bytes: u64,
    },
    /// Copies a range of a buffer into the middle of another.
    CopyRange {
        /// Source, and the first byte.
        from: (BufferId, u64),
        /// Destination, and the first byte.
        to: (BufferId, u64),
        /// Number of bytes.
        bytes: u64,
    },
    /// Copies a colour image to another of the same format and size.
    CopyImage {
        /// Source.
        from: ImageId,
        /// Destination.
        to: ImageId,
        /// Pixels.
        extent: [u32; 2],
    },
    /// Copies the depth of a depth image to the start of a buffer, rows without gaps.
    CopyDepth {
        /// Source.
        from: ImageId,
        /// Destination.
        to: BufferId,
        /// Pixels.
        extent: [u32; 2],
    },
}

/// How a colour attachment takes what is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Replaces.
    Replace,
    /// Premultiplied "over".
    Over,
    /// Brightens: `target * (1 + drawn)`; alpha stays.
    Brighten,
}

/// One entry of a frame's list.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The pass that runs.
    pub pass: PassId,
    /// What it is told.
    pub command: Command,
    /// Push constants.
    pub constants: [u8; PUSH_CONSTANT_BYTES],
    /// How many bytes of them.
    pub constants_len: usize,
}

impl Step {
    /// The buffer that indirect arguments come from.
    pub fn arguments(&self) -> Option<BufferId> {
        match self.command {
            Command::DispatchIndirect { arguments, .. } | Command::DrawIndirect { arguments, .. } => Some(arguments),
            _ => None,
        }
    }
}

/// A frame's list, and what is not in it. Kept between frames, so that filling it allocates nothing.
#[derive(Debug, Default)]
pub struct Plan {
    /// What runs, in this order.
    pub steps: Vec<Step>,
    /// What does not run: name and reason.
    pub skipped: Vec<(&'static str, &'static str)>,
    /// Bytes that updates write.
    pub data: Vec<u8>,
}

impl Plan {
    /// Room for so many steps, so that a frame's list never grows while it is recorded.
    pub fn with_capacity(steps: usize, data: usize) -> Plan {
        Plan { steps: Vec::with_capacity(steps), skipped: Vec::with_capacity(32), data: Vec::with_capacity(data) }
    }

    /// Forgets the last frame.
    pub fn clear(&mut self) {
        self.steps.clear();
        self.skipped.clear();
        self.data.clear();
    }

    /// Adds a step without constants.
    pub fn step(&mut self, pass: PassId, command: Command) {
        self.step_with(pass, command, &[0_u8; 0]);
    }

    /// Adds a step with push constants.
    pub fn step_with<T: bytemuck::NoUninit>(&mut self, pass: PassId, command: Command, constants: &T) {
        let bytes = bytemuck::bytes_of(constants);
        let mut step = Step { pass, command, constants: [0; PUSH_CONSTANT_BYTES], constants_len: bytes.len() };
        step.constants[..bytes.len()].copy_from_slice(bytes);
        self.steps.push(step);
    }

    /// Adds a step that writes `value` to the start of `buffer`.
    pub fn update<T: bytemuck::NoUninit>(&mut self, pass: PassId, buffer: BufferId, value: &T) {
        self.update_slice(pass, buffer, std::slice::from_ref(value));
    }

    /// Adds a step that writes `values` to the start of `buffer`.
    pub fn update_slice<T: bytemuck::NoUninit>(&mut self, pass: PassId, buffer: BufferId, values: &[T]) {
        let from = self.data.len();
        self.data.extend_from_slice(bytemuck::cast_slice(values));
        self.step(pass, Command::Update { buffer, from, bytes: self.data.len() - from });
    }

    /// Notes that a step is not needed in this frame, and why.
    pub fn skip(&mut self, name: &'static str, reason: &'static str) {
        self.skipped.push((name, reason));
    }
}
