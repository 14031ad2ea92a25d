//! Limits of the device: a kernel that copies and one that computes.

use super::measure::interleaved;
use super::report::Limits;
use super::rig::{KernelBuffer, KernelsId, Rig};
use super::{BenchError, Session};
use crate::error::Result;
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

pub(super) fn measure(session: &mut Session) -> std::result::Result<Limits, BenchError> {
    session.next("limits: copy and arithmetic")?;
    let rig = &mut session.rig;
    let Kernels { kernels, plans, bytes, operations } = Kernels::new(rig)?;
    for plan in &plans {
        rig.warm_up(kernels, plan)?;
    }
    // Never one run alone: every row is compared with these.
    let times = interleaved(plans.len(), false, |variant| rig.run(kernels, &plans[variant]))?;
    rig.clear();
    let rate = |amount: u64, ms: f64| if ms > 0.0 { amount as f64 / ms / 1e6 } else { 0.0 };
    Ok(Limits { copy_gb_s: rate(bytes, times[0].gpu_ms), fma_gflop_s: rate(operations, times[1].gpu_ms) })
}

/// The two kernels, a plan of each, and what they do.
struct Kernels {
    kernels: KernelsId,
    plans: [Plan; 2],
    /// Read and written, together.
    bytes: u64,
    operations: u64,
}

impl Kernels {
    fn new(rig: &mut Rig) -> Result<Kernels> {
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
        let plans = [(0, (bytes / 16) as u32), (1, THREADS)].map(|(pass, threads)| {
            let mut plan = Plan::default();
            plan.step(PassId(pass), Command::Dispatch { threads: [threads, 1, 1] });
            plan
        });
        let operations = 2 * CHAINS * u64::from(ITERATIONS) * u64::from(THREADS);
        Ok(Kernels { kernels, plans, bytes: 2 * bytes, operations })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::report::Work;
    use crate::gpu::headless::{Headless, Options};

    /// Nothing else says so exactly what it does.
    #[test]
    fn what_is_counted_is_what_these_do() -> std::result::Result<(), Box<dyn std::error::Error>> {
        let device = std::env::var("CELFX_DEVICE").ok();
        let headless = match Headless::new(&Options { validate: true, stores: true, device, ..Options::default() }) {
            Ok(headless) => headless,
            Err(error) if std::env::var_os("CELFX_REQUIRE_VULKAN").is_some() => return Err(error.into()),
            Err(_) => return Ok(()),
        };
        let messages = headless.messages();
        let mut rig = Rig::new(headless)?;
        let Kernels { kernels, plans: [copy, arithmetic], bytes, operations } = Kernels::new(&mut rig)?;
        for _ in 0..2 {
            let work = rig.work_of_run(kernels, &copy)?;
            assert_eq!(work, Work { bytes: Some(bytes), flops: Some(0) });
            let work = rig.work_of_run(kernels, &arithmetic)?;
            assert_eq!(work.bytes, Some(4 * u64::from(THREADS)));
            // A few operations before and after the loop.
            let flops = work.flops.unwrap_or_default();
            assert!((operations..operations + 100 * u64::from(THREADS)).contains(&flops), "{flops} of {operations}");
        }
        drop(rig);
        let messages = messages.lock().map_err(|_| "a message")?;
        assert!(messages.is_empty(), "{messages:?}");
        Ok(())
    }
}
