//! Exclusive prefix sums over a buffer, in two passes of many workgroups: each sums a block up, then each block adds what is
//! before it. Effects have it where nothing else is done at the same time; `glsl/common/scan.glsl` is for the others.

use crate::plan::{BufferId, Command, Pass, PassId, Plan};
use crate::shaders::scan as glsl;
use crate::shaders::scan::constants::{SCAN_BLOCK, SCAN_VECTORS};

/// Counters of a scan: more would take more workgroups than every device can dispatch.
pub const MOST_COUNTERS: u64 = 1 << 25;

/// Bytes of the sums of a buffer of so many bytes.
pub fn sums_bytes(bytes: u64) -> u64 {
    4 * bytes.div_ceil(4 * u64::from(SCAN_BLOCK))
}

/// The passes over `values`, by way of `sums`.
pub fn passes(name: &'static str, values: BufferId, sums: BufferId) -> [Pass; 2] {
    [
        Pass::compute(name, &glsl::sums::SHADER).bind(glsl::sums::VALUES, values).bind(glsl::sums::BLOCK_SUMS, sums),
        Pass::compute(name, &glsl::add::SHADER).bind(glsl::add::VALUES, values).bind(glsl::add::BLOCK_SUMS, sums),
    ]
}

/// Half of a scan over a buffer of so many bytes, a multiple of 16.
pub fn step(plan: &mut Plan, pass: PassId, bytes: u64) {
    let constants = glsl::blocks::ScanConstants { vectors: (bytes / 16) as u32 };
    let threads = [constants.vectors.div_ceil(SCAN_VECTORS), 1, 1];
    plan.step_with(pass, Command::Dispatch { threads }, &constants);
}
