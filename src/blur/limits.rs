//! How much there may be of everything, and how much is dispatched.

use crate::effect::DeviceTraits;
use crate::shaders::blur::constants::{BESIDE, SEARCHES, STARTS};

/// Places of frames that are drawn because the host has no images of them.
pub const DRAWN_PLACES: usize = 4;
/// The most surfaces that completion learns colours of; places of others have what the frame that shows them has.
pub const MOST_TABLES: u32 = 256;
/// The most samples in one of completion's lists. A round of so many would not be within the loop budget: it and what would
/// come after it are left out, and samples keep the side that is known.
pub const MOST_LISTED: u64 = 1 << 21;
/// The most frames that trajectories go through.
pub const MOST_KNOTS: usize = 64;
/// The most speed lines of a picture.
pub const MOST_LINES: u32 = 16_384;
/// Candidates of each round of the search for the light.
pub const LIGHT_CANDIDATES: [u32; SEARCHES as usize] = {
    let mut candidates = [BESIDE * BESIDE; SEARCHES as usize];
    candidates[0] = STARTS;
    candidates
};
/// Rounds in which the points are chosen that speed lines trail from.
pub const CHOOSE_ROUNDS: u32 = 3;

/// Dispatches for colours that follow from neighbours, where neither frame shows anything and where one does: what is left
/// when all have run stays as it is.
const INWARD_DISPATCHES: [u32; 2] = [4, 16];
/// Loop iterations that an invocation takes in each of them.
const INWARD_ITERATIONS: u32 = 40_000;

/// Dispatches for colours that follow from neighbours, where neither frame shows anything and where one does.
pub fn inward_dispatches(traits: &DeviceTraits) -> [u32; 2] {
    if traits.ends_loops { INWARD_DISPATCHES } else { [1, 1] }
}

/// Loop iterations that an invocation takes in each of them.
pub fn inward_iterations(traits: &DeviceTraits) -> u32 {
    if traits.ends_loops { INWARD_ITERATIONS } else { u32::MAX }
}
