//! Limits of the device: a kernel that copies and one that computes.

use super::measure::interleaved;
use super::report::Limits;
use super::rig::KernelBuffer;
use super::{BenchError, Session};
use crate::gpu::buffer::BufferDesc;
use crate::plan::{BufferId, Command, Pass, PassId, Plan};
use crate::shaders::bench as glsl;

/// Bytes that are copied: more than caches hold, less than the largest buffer that every device can bind.
const COPIED: u64 = 112 << 20;
/// Iterations of the arithmetic loop, far below the loop budget of software drivers.
const ITERATIONS: u32 = 1024;
/// Multiply-adds an iteration; the shader has them written out.
const CHAINS: u64 = 16;
const THREADS: u32 = 1 << 18;

pub(super) fn measure(session: &mut Session) -> Result<Limits, BenchError> {
    session.next("limits: copy and arithmetic")?;
    let rig = &mut session.rig;
    let bytes = COPIED.min(rig.largest_buffer()) / 16 * 16;
    let buffer = |name, bytes| KernelBuffer::Own(BufferDesc::storage(name, bytes));
    let buffers =
        vec![buffer("copied from", bytes), buffer("copied to", bytes), buffer("results", u64::from(THREADS) * 4)];
    let passes = vec![
        Pass::compute("bench.copy", &glsl::copy::SHADER)
            .bind(glsl::copy::FROM, BufferId(0))
            .bind(glsl::copy::TO, BufferId(1)),
        Pass::compute("bench.arithmetic", &glsl::arithmetic::SHADER)
            .bind(glsl::arithmetic::RESULTS, BufferId(2))
            .specialise([ITERATIONS]),
    ];
    let kernels = rig.kernels(buffers, passes)?;
    let plans = [(bytes / 16) as u32, THREADS].into_iter().enumerate().map(|(pass, threads)| {
        let mut plan = Plan::default();
        plan.step(PassId(pass as u16), Command::Dispatch { threads: [threads, 1, 1] });
        plan
    });
    let plans: Vec<Plan> = plans.collect();
    for plan in &plans {
        rig.warm_up(kernels, plan)?;
    }
    // Never one run alone: every row is compared with these.
    let times = interleaved(plans.len(), false, |variant| rig.run(kernels, &plans[variant]))?;
    rig.clear();
    let rate = |amount: u64, ms: f64| if ms > 0.0 { amount as f64 / ms / 1e6 } else { 0.0 };
    let operations = 2 * CHAINS * u64::from(ITERATIONS) * u64::from(THREADS);
    Ok(Limits { copy_gb_s: rate(2 * bytes, times[0].gpu_ms), fma_gflop_s: rate(operations, times[1].gpu_ms) })
}
