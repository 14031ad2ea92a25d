//! A frame is a list: what an effect does, as plain data.
//!
//! An effect declares its [`Pass`]es once: name, kernel, what each reads and writes. Each frame it fills a [`Plan`] with
//! [`Step`]s: which passes run, in which order, over how many threads. `barrier` derives the barriers, `gpu::recorder`
//! walks the list into a command buffer. The order that you read is the order that runs. Nothing here calls Vulkan.

mod declare;
mod pass;

pub(crate) use declare::passes;
pub use declare::{Declare, Declared};
pub use pass::*;

use crate::host::Background;

/// Bytes of push constants.
pub const PUSH_CONSTANT_BYTES: usize = 128;

/// The command of one step.
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
    /// Clears a colour image: an attachment that nothing is drawn into.
    Clear {
        /// The image.
        image: ImageId,
        /// Value in bits.
        value: [u32; 4],
        /// Pixels.
        extent: [u32; 2],
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

impl Command {
    /// How a picture's background gets into its target; none if that is kept. `from`: the host's image of it.
    pub(crate) fn background(background: &Background, from: ImageId, to: ImageId, extent: [u32; 2]) -> Option<Command> {
        match background {
            Background::Keep => None,
            Background::Clear(colour) => Some(Command::Clear { image: to, value: colour.map(f32::to_bits), extent }),
            Background::Copy(_) => Some(Command::CopyImage { from, to, extent }),
        }
    }
}

/// One entry of a frame's list.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The pass that runs.
    pub pass: PassId,
    /// Its command.
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

/// The most steps that a frame of these passes can have.
pub(crate) fn most_steps(passes: &[Pass]) -> usize {
    passes.iter().map(|pass| pass.most_steps).sum()
}

/// A frame's list, and what is not in it. Kept between frames, so that filling it allocates nothing.
#[derive(Debug, Default)]
pub struct Plan {
    /// The steps that run, in this order.
    pub steps: Vec<Step>,
    /// The passes that do not run, and why.
    pub skipped: Vec<(PassId, &'static str)>,
    /// Bytes that updates write.
    pub data: Vec<u8>,
    /// How many barriers are between its steps, before and after them: known once it has been recorded.
    pub barriers: u32,
}

impl Plan {
    /// Room for any frame of these passes, so that a list never grows while it is filled.
    pub fn for_passes(passes: &[Pass]) -> Plan {
        Plan {
            steps: Vec::with_capacity(most_steps(passes)),
            skipped: Vec::with_capacity(passes.len()),
            data: Vec::with_capacity(passes.iter().map(|pass| pass.most_bytes).sum()),
            barriers: 0,
        }
    }

    /// Forgets the last frame.
    pub fn clear(&mut self) {
        self.steps.clear();
        self.skipped.clear();
        self.data.clear();
        self.barriers = 0;
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

    /// Notes that a pass is not needed in this frame, and why: all passes of that name.
    pub fn skip(&mut self, pass: PassId, reason: &'static str) {
        self.skipped.push((pass, reason));
    }
}
