//! Common parts of all effects' layouts: sizes of buffers, and their names.

use crate::error::{Error, Result};
use crate::gpu::buffer::BufferDesc;
use crate::gpu::scratch::Lifetime;
use crate::plan::BufferId;

/// Declares an effect's own buffers: each goes by one name, from shader block to error message, and is scratch unless a
/// [`Lifetime`] is said.
macro_rules! buffers {
    ($effect:literal $($id:ident = $name:literal $(: $lifetime:ident)?),* $(,)?) => {
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
            lifetimes: [$($crate::layout::buffers!(@lifetime $($lifetime)?)),*],
        };
    };
    (@lifetime) => { $crate::gpu::scratch::Lifetime::Scratch };
    (@lifetime $lifetime:ident) => { $crate::gpu::scratch::Lifetime::$lifetime };
}
pub(crate) use buffers;

/// Loop iterations that one invocation may take; lavapipe ends its loops after 65,535.
pub const LOOP_BUDGET: u32 = 48_000;

/// Workgroups that every device can dispatch along an axis.
pub const MOST_GROUPS: u64 = 65_535;

/// What is said of an effect's buffers.
pub(crate) struct Names<const N: usize> {
    /// By debuggers.
    pub(crate) debug: [&'static str; N],
    /// Their sizes, by errors.
    pub(crate) sizes: [&'static str; N],
    /// How long each is needed.
    pub(crate) lifetimes: [Lifetime; N],
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

    /// Descriptions, in order, of an effect that keeps layers or does not. `uniform` are uniform buffers, all others are
    /// storage buffers.
    pub(crate) fn descriptions<const M: usize>(
        &self,
        names: &Names<N>,
        uniform: [BufferId; M],
        layers: bool,
    ) -> impl Iterator<Item = BufferDesc> + use<N, M> {
        let Names { debug: names, lifetimes, .. } = *names;
        self.0.into_iter().enumerate().map(move |(index, bytes)| {
            let desc = match uniform.contains(&BufferId(index as u16)) {
                true => BufferDesc::uniform(names[index], bytes),
                false => BufferDesc::storage(names[index], bytes),
            };
            BufferDesc { lifetime: lifetimes[index].with_layers(layers), ..desc }
        })
    }
}
