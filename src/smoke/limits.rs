//! How much is worked on at a time.

use crate::effect::DeviceTraits;
pub use crate::layout::LOOP_BUDGET;
use crate::shaders::smoke as glsl;
use crate::shaders::smoke::constants::{MAX_LIGHT_LEVELS, TILE};

/// Pixels of a tile that an invocation of `luminance` shades, one after the other.
const TILE_ROWS: u32 = TILE / glsl::luminance_exact::SHADER.local_size[1];
/// Entries of light-space tiles that one dispatch works on for a pixel, which also walks the levels of tiles, where drivers
/// end loops.
pub const LUMINANCE_ENTRIES: u32 = LOOP_BUDGET / TILE_ROWS - MAX_LIGHT_LEVELS;

/// The same on a device with these traits.
pub fn luminance_entries(traits: &DeviceTraits) -> u32 {
    if traits.ends_loops { LUMINANCE_ENTRIES } else { u32::MAX }
}
/// Pixels to each side from which a line can reach a pixel: all of them are within the loop budget.
pub const MOST_INK_REACH: u32 = 127;
/// Bytes of row sums in a batch of groups, unless a single group needs more.
pub const ROW_SUM_BYTES: u64 = 64 << 20;
