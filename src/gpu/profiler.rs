//! Times passes on the device with a ring of query pools. Never waits.

use ash::vk;

use crate::error::{Error, Result};
use crate::host::Host;
use crate::profile::{Clock, FrameTimes};

/// Whether steps may overlap on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// As it runs: only the barriers that the steps need.
    #[default]
    Overlapping,
    /// A full barrier around each step, for comparing kernels.
    Isolated,
}

/// Where the timestamps of a recorded frame go.
#[derive(Debug, Default)]
pub enum Timing<'a> {
    /// Nowhere.
    #[default]
    None,
    /// To a profiler whose [`Profiler::begin_frame`] was called on the same command buffer.
    Profiler(&'a mut Profiler),
    /// To the host's own timestamp queries: two a step, begin and end, in the order of the steps. The host has reset
    /// [`queries`] of them and turns the ticks into times with a [`Clock`]. The step's name is that of `Effect::step`'s pass; passes that
    /// are skipped have no queries.
    Queries {
        /// The host's pool.
        pool: vk::QueryPool,
        /// The next query that is written; counts up while frames are recorded.
        first: u32,
        /// Queries of the pool. A frame that needs more than are left is refused before anything is recorded.
        count: u32,
    },
}

/// Queries that so many steps need.
pub const fn queries(steps: u32) -> u32 {
    steps.saturating_mul(2)
}

impl Timing<'_> {
    /// Refuses a frame of so many steps that the host's pool has too few queries for.
    pub(crate) fn check(&self, steps: u32) -> Result<()> {
        match self {
            Timing::Queries { first, count, .. } if first.saturating_add(queries(steps)) > *count => {
                let needed = queries(steps);
                let left = count.saturating_sub(*first);
                let why = format!(
                    "{left} queries are left from {first} of {count}; this frame of {steps} steps needs {needed}"
                );
                Err(Error::HostResource { name: "timing", why })
            }
            _ => Ok(()),
        }
    }

    /// Writes the begin of a step; to be called after the step's own barrier.
    ///
    /// # Safety
    ///
    /// `host` is valid, `commands` is in recording state outside of a render pass, and what the variant asks for holds.
    pub unsafe fn begin_scope(&mut self, host: &Host, commands: vk::CommandBuffer, name: &'static str) {
        match self {
            Timing::None => {}
            // SAFETY: the caller's.
            Timing::Profiler(profiler) => unsafe { profiler.begin_scope(host, commands, name) },
            // SAFETY: the caller's.
            Timing::Queries { pool, first, .. } => unsafe { write(host, commands, *pool, *first) },
        }
    }

    /// Writes the end of the step.
    ///
    /// # Safety
    ///
    /// As for [`Timing::begin_scope`], which was called before.
    pub unsafe fn end_scope(&mut self, host: &Host, commands: vk::CommandBuffer) {
        match self {
            Timing::None => {}
            // SAFETY: the caller's.
            Timing::Profiler(profiler) => unsafe { profiler.end_scope(host, commands) },
            Timing::Queries { pool, first, .. } => {
                // SAFETY: the caller's.
                unsafe { write(host, commands, *pool, first.saturating_add(1)) };
                *first = first.saturating_add(queries(1));
            }
        }
    }

    /// Notes how many steps and barriers an effect has recorded into the frame.
    pub fn count(&mut self, steps: u32, barriers: u32) {
        if let Timing::Profiler(profiler) = self
            && let Some(slot) = profiler.slots.get_mut(profiler.current)
        {
            slot.steps += steps;
            slot.barriers += barriers;
        }
    }

    /// Notes that a step is not in the frame, and why.
    pub fn skip(&mut self, name: &'static str, reason: &'static str) {
        if let Timing::Profiler(profiler) = self {
            profiler.skip(name, reason);
        }
    }
}

/// `ALL_COMMANDS`: the time at which everything before is done.
unsafe fn write(host: &Host, commands: vk::CommandBuffer, pool: vk::QueryPool, query: u32) {
    // SAFETY: the caller's.
    unsafe { host.device.cmd_write_timestamp2(commands, vk::PipelineStageFlags2::ALL_COMMANDS, pool, query) };
}

/// Ends everything before, the writing of timestamps included. Without it lavapipe charges a pass's work to the time
/// before its first timestamp (measured: 2 ms of 2 ms); it runs one command after the other anyway.
unsafe fn settle(host: &Host, commands: vk::CommandBuffer) {
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}

/// A pool of queries for one frame in flight.
#[derive(Debug)]
struct Slot {
    pool: vk::QueryPool,
    frame: u32,
    /// Names of the steps that have queries.
    names: Vec<&'static str>,
    skipped: Vec<(&'static str, &'static str)>,
    steps: u32,
    barriers: u32,
    /// Recorded and not collected.
    pending: bool,
}

/// A ring of query pools, one for each frame in flight.
///
/// A frame goes: [`begin_frame`](Profiler::begin_frame), then recording with [`Timing::Profiler`], submission, and once
/// its fence has signalled [`collect`](Profiler::collect). On a queue family without timestamps nothing is recorded and
/// nothing collected.
#[derive(Debug)]
pub struct Profiler {
    slots: Vec<Slot>,
    /// None where the queue family has no timestamps.
    clock: Option<Clock>,
    steps: u32,
    /// A software driver: its threads may write a timestamp after work that follows it has begun.
    software: bool,
    /// The slot that is recorded into.
    current: usize,
    /// Whether the scope that was opened last has queries.
    open: bool,
    dropped: u64,
}

/// Why a step that ran has no times.
const UNTIMED: &str = "it ran but was not timed: the profiler was made for fewer steps";

impl Profiler {
    /// For `frames_in_flight` frames (at least 1) of up to `steps` steps, recorded for queues of `queue_family`.
    ///
    /// # Safety
    ///
    /// `host` holds valid handles.
    pub unsafe fn new(host: &Host, queue_family: u32, frames_in_flight: u32, steps: u32) -> Result<Profiler> {
        // SAFETY: the caller's.
        let (families, properties) = unsafe {
            let families = host.instance.get_physical_device_queue_family_properties(host.physical_device);
            (families, host.instance.get_physical_device_properties(host.physical_device))
        };
        let family = families.get(queue_family as usize).ok_or_else(|| Error::HostResource {
            name: "queue_family",
            why: format!("{queue_family}, but the device has {} queue families", families.len()),
        })?;
        let clock = Clock::new(family.timestamp_valid_bits, properties.limits.timestamp_period);
        let steps = steps.max(1);
        let software = properties.device_type == vk::PhysicalDeviceType::CPU;
        let mut profiler = Profiler { slots: Vec::new(), clock, steps, software, current: 0, open: false, dropped: 0 };
        for _ in 0..frames_in_flight.max(1) {
            // SAFETY: the caller's; on error the pools made so far are destroyed unused.
            unsafe {
                match profiler.make_slot(host) {
                    Ok(slot) => profiler.slots.push(slot),
                    Err(error) => {
                        profiler.destroy(host);
                        return Err(error);
                    }
                }
            }
        }
        Ok(profiler)
    }

    unsafe fn make_slot(&self, host: &Host) -> Result<Slot> {
        let info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(queries(self.steps));
        let pool = match self.clock {
            // SAFETY: the caller's.
            Some(_) => unsafe { host.device.create_query_pool(&info, None) }
                .map_err(Error::vulkan("vkCreateQueryPool", "profiler"))?,
            None => vk::QueryPool::null(),
        };
        let room = self.steps as usize;
        let (names, skipped) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Ok(Slot { pool, frame: 0, names, skipped, steps: 0, barriers: 0, pending: false })
    }

    /// Whether the queue family has timestamps.
    pub fn is_supported(&self) -> bool {
        self.clock.is_some()
    }

    /// Frames that were begun again before they were collected.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Opens frame number `frame` in `slot` (0 to frames in flight - 1) and resets its queries on the device.
    /// Times in the slot that nobody collected are dropped.
    ///
    /// # Safety
    ///
    /// `host` is the one it was made with, `commands` is in recording state outside of a render pass, and what was
    /// recorded into `slot` before has finished on the device.
    pub unsafe fn begin_frame(
        &mut self,
        host: &Host,
        commands: vk::CommandBuffer,
        slot: usize,
        frame: u32,
    ) -> Result<()> {
        let count = self.slots.len();
        let why = || format!("slot {slot}: the profiler was made for {count} frames in flight");
        let entry = self.slots.get_mut(slot).ok_or_else(|| Error::HostResource { name: "profiler", why: why() })?;
        self.dropped += u64::from(entry.pending);
        entry.frame = frame;
        entry.names.clear();
        entry.skipped.clear();
        (entry.steps, entry.barriers) = (0, 0);
        entry.pending = self.clock.is_some();
        self.current = slot;
        self.open = false;
        if self.clock.is_some() {
            // SAFETY: the caller's.
            unsafe { host.device.cmd_reset_query_pool(commands, entry.pool, 0, queries(self.steps)) };
        }
        Ok(())
    }

    unsafe fn begin_scope(&mut self, host: &Host, commands: vk::CommandBuffer, name: &'static str) {
        self.open = false;
        let Some(slot) = self.slots.get_mut(self.current).filter(|slot| slot.pending) else { return };
        let step = slot.names.len() as u32;
        if step >= self.steps {
            self.skip(name, UNTIMED);
            return;
        }
        slot.names.push(name);
        self.open = true;
        // SAFETY: the caller's; the query is within the pool.
        unsafe {
            write(host, commands, slot.pool, queries(step));
            if self.software {
                settle(host, commands);
            }
        }
    }

    unsafe fn end_scope(&mut self, host: &Host, commands: vk::CommandBuffer) {
        let Some(slot) = self.slots.get(self.current).filter(|_| self.open) else { return };
        let query = queries(slot.names.len() as u32) - 1;
        self.open = false;
        // SAFETY: the caller's; the query is within the pool, and the begin of this step was written.
        unsafe { write(host, commands, slot.pool, query) };
    }

    /// Keeps to the room that was reserved: a frame that skips more than it has steps loses reasons, not time.
    fn skip(&mut self, name: &'static str, reason: &'static str) {
        if let Some(slot) = self.slots.get_mut(self.current)
            && slot.pending
            && slot.skipped.len() < slot.skipped.capacity()
        {
            slot.skipped.push((name, reason));
        }
    }

    /// The times of the frame in `slot`, once. None if there is none, if the device has not finished it, or if the
    /// queue family has no timestamps. Never waits.
    ///
    /// # Safety
    ///
    /// `host` is the one it was made with, and the commands that were recorded for the frame have been executed (its
    /// fence has signalled): queries that were never reset must not be read.
    pub unsafe fn collect(&mut self, host: &Host, slot: usize) -> Option<FrameTimes> {
        let clock = self.clock.as_mut()?;
        let slot = self.slots.get_mut(slot).filter(|slot| slot.pending)?;
        // Each query: its ticks, and whether they are there.
        let mut results = vec![[0_u64; 2]; queries(slot.names.len() as u32) as usize];
        if !results.is_empty() {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
            // SAFETY: the caller's; as many queries were written as there are results.
            unsafe { host.device.get_query_pool_results(slot.pool, 0, &mut results, flags) }.ok()?;
        }
        if results.iter().any(|[_, available]| *available == 0) {
            return None;
        }
        slot.pending = false;
        let ticks: Vec<[u64; 2]> = results.chunks_exact(2).map(|pair| [pair[0][0], pair[1][0]]).collect();
        let mut times = clock.frame(slot.frame, slot.names.iter().copied(), &ticks);
        times.skipped.clone_from(&slot.skipped);
        (times.steps, times.barriers) = (slot.steps, slot.barriers);
        Some(times)
    }

    /// The step of the frame in `slot` that has begun and not ended, as far as the device has written times: where it
    /// stands, or was lost. None where no step is, where there are no times, or where they can't be read.
    ///
    /// # Safety
    ///
    /// As for [`Profiler::collect`], but that the commands may be running.
    pub unsafe fn running(&self, host: &Host, slot: usize) -> Option<&'static str> {
        let slot = self.slots.get(slot).filter(|slot| slot.pending)?;
        let mut results = vec![[0_u64; 2]; queries(slot.names.len() as u32) as usize];
        if results.is_empty() {
            return None;
        }
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
        // SAFETY: the caller's; each of the queries has been recorded.
        match unsafe { host.device.get_query_pool_results(slot.pool, 0, &mut results, flags) } {
            Ok(()) | Err(vk::Result::NOT_READY) => {}
            Err(_) => return None,
        }
        let is_running = |pair: &[[u64; 2]]| pair[0][1] != 0 && pair[1][1] == 0;
        results.chunks_exact(2).position(is_running).and_then(|step| slot.names.get(step).copied())
    }

    /// Destroys the query pools.
    ///
    /// # Safety
    ///
    /// `host` is the one it was made with, and the device is done with every frame that was recorded.
    pub unsafe fn destroy(&mut self, host: &Host) {
        for slot in self.slots.drain(..) {
            // SAFETY: the caller's; a null pool is ignored.
            unsafe { host.device.destroy_query_pool(slot.pool, None) };
        }
    }
}
