//! Prefix sums over buffers, exactly: every size around the borders of blocks, and as many counters as there may be.
#![cfg(feature = "cli")]

mod common;

use celfx::low_level::gpu::buffer::BufferDesc;
use celfx::low_level::gpu::executor::{Description, Executor};
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::plan::{BufferId, Command, Pass, PassId};
use celfx::low_level::scan;
use celfx::low_level::shaders::scan::constants::SCAN_BLOCK;
use common::scenes::random;
use common::{TestDevice, device, host};

const VALUES: BufferId = BufferId(0);
const SUMS: BufferId = BufferId(1);
const GIVEN: BufferId = BufferId(2);

/// What the device makes of these values.
fn scanned(device: &mut TestDevice, values: &[u32]) -> Vec<u32> {
    let bytes = (4 * values.len() as u64).next_multiple_of(16);
    let [sums, add] = scan::passes("scan", VALUES, SUMS);
    let buffers = vec![BufferDesc::storage("values", bytes), BufferDesc::storage("sums", scan::sums_bytes(bytes))];
    let description = Description {
        name: "scan",
        passes: vec![Pass::transfer("values").fills(VALUES).copies(GIVEN, VALUES), sums, add],
        buffers,
        host_buffers: 1,
        images: Vec::new(),
        host_images: 0,
        bound: Vec::new(),
        overlays: Vec::new(),
        memory: Default::default(),
    };
    let mut given = host::source(device, bytes);
    let handed = host::fill(&mut given, values);
    let (host, kernels, allocator) = device.making();
    // SAFETY: valid handles of one device.
    let mut executor = unsafe { Executor::new(&host, kernels, allocator, description, None) }.expect("buffers");
    executor.resources_mut().set_host_buffer(GIVEN, Some(handed));
    let plan = executor.plan_mut();
    // What lies beyond the values is summed up after them: it changes none of their sums.
    plan.step(PassId(0), Command::Fill { buffer: VALUES, word: 77 });
    plan.step(PassId(0), Command::CopyBuffer { from: GIVEN, to: VALUES, bytes: 4 * values.len() as u64 });
    scan::step(plan, PassId(1), bytes);
    scan::step(plan, PassId(2), bytes);
    let steps = plan.steps.len();
    device
        .one_time("scan", |host, mut commands| {
            // SAFETY: all is alive, and the host's buffer has been written.
            unsafe { executor.record(host, &mut commands, 0..steps, &mut Timing::None) }
        })
        .expect("it runs");
    let found = host::read(device, executor.buffer(VALUES), values.len());
    let (host, allocator) = device.parts();
    // SAFETY: it has been waited for.
    unsafe { executor.destroy(&host, allocator) };
    host::destroy(device, [&mut given], []);
    found
}

fn summed(values: &[u32]) -> Vec<u32> {
    let mut sum = 0_u32;
    let mut next = |value: &u32| {
        let before = sum;
        sum = sum.wrapping_add(*value);
        before
    };
    values.iter().map(&mut next).collect()
}

#[test]
fn sums_are_exact_around_the_borders_of_blocks() {
    let Some(mut device) = device() else { return };
    let block = SCAN_BLOCK as usize;
    let around = |count: usize| count.saturating_sub(5)..count + 6;
    // One vector, one block, as many blocks as a workgroup has lanes.
    let sizes = around(1).chain(around(block)).chain(around(2 * block)).chain([block * 256, block * 257 + 3]);
    for count in sizes.filter(|count| *count > 0) {
        let values: Vec<u32> = (0..count as u32).map(|i| (9.0 * random(3, i, count as u32)) as u32).collect();
        let found = scanned(&mut device, &values);
        let expected = summed(&values);
        let wrong = found.iter().zip(&expected).position(|(a, b)| a != b);
        assert_eq!(wrong, None, "{count} values");
    }
}

#[test]
fn five_million_counters() {
    let Some(mut device) = device() else { return };
    let values: Vec<u32> = (0..5_242_880_u32).map(|i| i.wrapping_mul(0x9e37_79b9) >> 28).collect();
    assert!(scanned(&mut device, &values) == summed(&values));
}
