//! What the layouts of all effects share.

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
        /// What shaders call them.
        const BLOCKS: [&str; BUFFERS as usize] = [$($name),*];
        /// What debuggers call them.
        const NAMES: [&str; BUFFERS as usize] = [$(concat!($effect, " ", $name)),*];
        /// What errors call their sizes.
        const SIZES: [&str; BUFFERS as usize] = [$(concat!($effect, "'s buffer ", $name, " (in bytes)")),*];
    };
}
pub(crate) use buffers;

/// Loop turns that one invocation may take; lavapipe ends its loops after 65,535.
pub const LOOP_BUDGET: u32 = 48_000;
