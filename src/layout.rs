//! Common parts of all effects' layouts: sizes of buffers, and their names.

use crate::error::{Error, Result};
use crate::gpu::buffer::BufferDesc;
use crate::host::Memory;
use crate::plan::BufferId;

/// Declares an effect's own buffers: each goes by one name, from shader block to error message.
macro_rules! buffers {
    ($effect:literal $($id:ident = $name:literal),* $(,)?) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        #[repr(u16)]
        #[derive(Clone, Copy)]
        enum Order { $($id),*, COUNT }
        $(#[doc = concat!("`", $name, "` in the shaders.")] pub const $id: BufferId = BufferId(Order::$id as u16);)*
        /// Number of own buffers.
        pub const BUFFERS: u16 = Order::COUNT as u16;
        /// Names of the blocks in shaders.
        const BLOCKS: [&str; BUFFERS as usize] = [$($name),*];
        const NAMES: crate::layout::Names<{ BUFFERS as usize }> = crate::layout::Names {
            debug: [$(concat!($effect, " ", $name)),*],
            sizes: [$(concat!($effect, "'s buffer ", $name, " (in bytes)")),*],
        };
    };
}
pub(crate) use buffers;

/// Loop iterations that one invocation may take; lavapipe ends its loops after 65,535.
pub const LOOP_BUDGET: u32 = 48_000;

/// Workgroups that every device can dispatch along an axis.
pub const MOST_GROUPS: u64 = 65_535;

/// Names of an effect's buffers.
pub(crate) struct Names<const N: usize> {
    /// By debuggers.
    pub(crate) debug: [&'static str; N],
    /// Their sizes, by errors.
    pub(crate) sizes: [&'static str; N],
}

/// Bytes of an effect's own buffers.
#[derive(Clone, Debug)]
pub(crate) struct Sizes<const N: usize>([u64; N]);

impl<const N: usize> Sizes<N> {
    /// The least that a buffer can be bound with.
    pub(crate) const LEAST: Self = Sizes([16; N]);

    pub(crate) fn set(&mut self, id: BufferId, bytes: u64) {
        self.0[usize::from(id.0)] = bytes.max(16).next_multiple_of(16);
    }

    pub(crate) fn get(&self, id: BufferId) -> u64 {
        self.0[usize::from(id.0)]
    }

    /// Refuses what is larger than `limit`, the largest range that a shader can bind.
    pub(crate) fn check(&self, limit: u64, names: &Names<N>, advice: impl Fn(BufferId) -> &'static str) -> Result<()> {
        match self.0.iter().position(|needed| *needed > limit) {
            Some(index) => {
                let (what, advice) = (names.sizes[index], advice(BufferId(index as u16)));
                Err(Error::Limit { what, needed: self.0[index], limit, advice })
            }
            None => Ok(()),
        }
    }

    /// Descriptions, in order. `uniform` are uniform buffers, all others are storage buffers.
    pub(crate) fn descriptions<const M: usize>(
        &self,
        names: &Names<N>,
        uniform: [BufferId; M],
    ) -> impl Iterator<Item = BufferDesc> + use<N, M> {
        let names = names.debug;
        self.0.into_iter().enumerate().map(move |(index, bytes)| match uniform.contains(&BufferId(index as u16)) {
            true => BufferDesc::uniform(names[index], bytes),
            false => BufferDesc::storage(names[index], bytes),
        })
    }

    /// Memory, of which what is `kept` survives from frame to frame.
    pub(crate) fn memory(&self, kept: &[BufferId]) -> Memory {
        let mut memory = Memory::default();
        for (index, bytes) in self.0.iter().enumerate() {
            match kept.contains(&BufferId(index as u16)) {
                true => memory.history += bytes,
                false => memory.scratch += bytes,
            }
        }
        memory
    }
}
