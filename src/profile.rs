//! Costs of passes: times of frames, and their table, CSV and Chrome trace. Pure data: nothing here calls Vulkan.
//!
//! Passes may overlap on the device, so the time of a frame is the span from its first begin to its last end, never
//! the sum of its passes.

pub use crate::gpu::costs::{Cost, Executable, Statistic};
pub use crate::gpu::profiler::{Mode, Profiler, Timing, queries};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// When a pass ran. Nanoseconds since the first tick that its [`Clock`] saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PassTime {
    /// `effect.pass`.
    pub name: &'static str,
    /// When it began; its barrier is not in it.
    pub begin_ns: u64,
    /// When it ended, not before `begin_ns`.
    pub end_ns: u64,
}

/// The passes of one frame, in the order in which they were recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct FrameTimes {
    /// The host's number of the frame.
    pub frame: u32,
    /// Passes that ran. Steps of one name that follow each other are one row.
    pub passes: Vec<PassTime>,
    /// Passes that did not run: name and reason.
    pub skipped: Vec<(&'static str, &'static str)>,
    /// Steps that were recorded: dispatches, draws, copies, clears.
    pub steps: u32,
    /// Barriers between them, before and after them.
    pub barriers: u32,
}

impl FrameTimes {
    /// From the first begin to the last end, in nanoseconds; 0 if nothing ran.
    pub fn total_ns(&self) -> u64 {
        let begin = self.passes.iter().map(|p| p.begin_ns).min().unwrap_or(0);
        let end = self.passes.iter().map(|p| p.end_ns).max().unwrap_or(0);
        end.saturating_sub(begin)
    }

    /// Adds a step; one that follows a step of the same name lengthens that row.
    fn push(&mut self, step: PassTime) {
        match self.passes.last_mut() {
            Some(row) if row.name == step.name => row.end_ns = row.end_ns.max(step.end_ns),
            _ => self.passes.push(step),
        }
    }
}

/// Turns the ticks of a queue family's timestamps into nanoseconds.
///
/// Ticks have only so many valid bits and wrap around. Each tick is taken as the one nearest to the tick before it, so
/// the times go on without a break as long as ticks come more often than half the counter's range.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    mask: u64,
    period_ns: f64,
    /// The tick before: as read, and in ticks since the first.
    last: Option<(u64, i64)>,
}

impl Clock {
    /// With the queue family's `timestampValidBits` and the device's `timestampPeriod` in nanoseconds; none where the
    /// family has no timestamps.
    pub fn new(valid_bits: u32, period_ns: f32) -> Option<Clock> {
        let mask = u64::MAX.checked_shr(64 - valid_bits.min(64))?;
        Some(Clock { mask, period_ns: f64::from(period_ns), last: None })
    }

    /// Nanoseconds since the first tick; a tick before the first is 0.
    pub fn nanoseconds(&mut self, tick: u64) -> u64 {
        let tick = tick & self.mask;
        let (last, since_first) = self.last.unwrap_or((tick, 0));
        let forward = tick.wrapping_sub(last) & self.mask;
        let backward = last.wrapping_sub(tick) & self.mask;
        let step = if forward <= backward { forward as i64 } else { -(backward as i64) };
        let since_first = since_first.saturating_add(step);
        self.last = Some((tick, since_first));
        (since_first.max(0) as f64 * self.period_ns).round() as u64
    }

    /// A frame from its steps' names, and two ticks a step, begin and end; for hosts that hand over their own queries.
    pub fn frame<'a>(
        &mut self,
        frame: u32,
        names: impl IntoIterator<Item = &'static str>,
        ticks: impl IntoIterator<Item = &'a [u64; 2]>,
    ) -> FrameTimes {
        let mut times = FrameTimes { frame, ..FrameTimes::default() };
        for (name, [begin, end]) in names.into_iter().zip(ticks) {
            let begin_ns = self.nanoseconds(*begin);
            let end_ns = self.nanoseconds(*end).max(begin_ns);
            times.push(PassTime { name, begin_ns, end_ns });
        }
        times
    }
}

/// Milliseconds of a pass in those frames that it ran in.
#[derive(Default)]
struct Row {
    frames: u32,
    sum: f64,
    min: f64,
    max: f64,
}

impl Row {
    fn add(&mut self, ms: f64) {
        self.min = if self.frames == 0 { ms } else { self.min.min(ms) };
        self.max = self.max.max(ms);
        self.sum += ms;
        self.frames += 1;
    }
}

/// A table for people: mean, least and greatest milliseconds of each pass over the frames that it ran in, and its share of
/// all frames' time. Passes may overlap, so shares need not add up to 100 %.
pub fn table(frames: &[FrameTimes]) -> String {
    let mut order: Vec<&str> = Vec::new();
    let mut rows: BTreeMap<&str, Row> = BTreeMap::new();
    let mut whole = Row::default();
    for frame in frames {
        let mut sums: BTreeMap<&str, f64> = BTreeMap::new();
        for pass in &frame.passes {
            if !order.contains(&pass.name) {
                order.push(pass.name);
            }
            *sums.entry(pass.name).or_default() += milliseconds(pass.end_ns - pass.begin_ns);
        }
        for (name, ms) in sums {
            rows.entry(name).or_default().add(ms);
        }
        whole.add(milliseconds(frame.total_ns()));
    }
    let width = order.iter().map(|name| name.len()).max().unwrap_or(0).max("frame".len());
    let mut text = format!(
        "{:width$} {:>10} {:>10} {:>10} {:>8} {:>7}\n",
        "pass", "mean ms", "min ms", "max ms", "share", "frames"
    );
    let mut line = |name: &str, row: &Row| {
        let mean = row.sum / f64::from(row.frames.max(1));
        let share = if whole.sum > 0.0 { 100.0 * row.sum / whole.sum } else { 0.0 };
        let Row { min, max, frames, .. } = row;
        let _ = writeln!(text, "{name:width$} {mean:10.3} {min:10.3} {max:10.3} {share:6.1} % {frames:7}");
    };
    for name in order {
        if let Some(row) = rows.get(name) {
            line(name, row);
        }
    }
    line("frame", &whole);
    let (steps, barriers) = (frames.iter().map(|f| f.steps).max(), frames.iter().map(|f| f.barriers).max());
    if let (Some(steps @ 1..), Some(barriers)) = (steps, barriers) {
        let _ = writeln!(text, "at most {steps} steps and {barriers} barriers a frame");
    }
    text
}

/// Skipped passes, for people: a line for each pass and reason, and in how many of the frames.
pub fn skips(frames: &[FrameTimes]) -> String {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for frame in frames {
        // A pass may be left out of several places of one frame.
        let skipped: BTreeSet<_> = frame.skipped.iter().copied().collect();
        skipped.into_iter().for_each(|skip| *counts.entry(skip).or_default() += 1);
    }
    let mut text = String::new();
    for ((name, reason), count) in counts {
        let _ = writeln!(text, "{name}: skipped, {reason} ({count} of {} frames)", frames.len());
    }
    text
}

fn milliseconds(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

/// Comma-separated values with the header `frame,pass,begin_ns,end_ns,skipped,reason`. A skipped pass has no times.
pub fn csv(frames: &[FrameTimes]) -> String {
    let mut text = String::from("frame,pass,begin_ns,end_ns,skipped,reason\n");
    for frame in frames {
        for PassTime { name, begin_ns, end_ns } in &frame.passes {
            let _ = writeln!(text, "{},{},{begin_ns},{end_ns},false,", frame.frame, field(name));
        }
        for (name, reason) in &frame.skipped {
            let _ = writeln!(text, "{},{},,,true,{}", frame.frame, field(name), field(reason));
        }
    }
    text
}

/// A field, quoted where it has to be.
fn field(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.into(),
    }
}

/// Chrome trace events, for Perfetto and chrome://tracing: one track of frames, one of passes; a skipped pass is an
/// instant event with its reason. `device` names the process.
#[cfg(feature = "cli")]
pub fn chrome_trace(frames: &[FrameTimes], device: &str) -> String {
    use serde_json::json;
    const FRAMES: u32 = 1;
    const PASSES: u32 = 2;
    let microseconds = |ns: u64| ns as f64 * 1e-3;
    let complete = |name: &str, track: u32, begin_ns: u64, duration_ns: u64, args: serde_json::Value| {
        json!({
            "name": name, "cat": "gpu", "ph": "X", "pid": 1, "tid": track,
            "ts": microseconds(begin_ns), "dur": microseconds(duration_ns), "args": args,
        })
    };
    let named = |what: &str, track: u32, name: &str| json!({ "name": what, "ph": "M", "pid": 1, "tid": track, "args": { "name": name } });
    let mut events = vec![
        named("process_name", FRAMES, device),
        named("thread_name", FRAMES, "frames"),
        named("thread_name", PASSES, "passes"),
    ];
    for frame in frames {
        let begin = frame.passes.iter().map(|p| p.begin_ns).min();
        if let Some(begin) = begin {
            let args = json!({ "frame": frame.frame, "steps": frame.steps, "barriers": frame.barriers });
            events.push(complete(&format!("frame {}", frame.frame), FRAMES, begin, frame.total_ns(), args));
        }
        for PassTime { name, begin_ns, end_ns } in &frame.passes {
            let args = json!({ "frame": frame.frame });
            events.push(complete(name, PASSES, *begin_ns, end_ns - begin_ns, args));
        }
        for (name, reason) in &frame.skipped {
            events.push(json!({
                "name": format!("{name}: skipped, {reason}"), "cat": "skipped", "ph": "i", "s": "t", "pid": 1,
                "tid": PASSES, "ts": microseconds(begin.unwrap_or(0)),
                "args": { "frame": frame.frame, "pass": name, "skipped": true, "reason": reason },
            }));
        }
    }
    json!({ "traceEvents": events, "displayTimeUnit": "ms" }).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_frames() -> Vec<FrameTimes> {
        let pass = |name, begin_ns, end_ns| PassTime { name, begin_ns, end_ns };
        vec![
            FrameTimes {
                frame: 7,
                passes: vec![pass("smoke.grow", 0, 1_000_000), pass("smoke.outline", 500_000, 2_000_000)],
                skipped: vec![("smoke.shadow", "off, or \"none\"")],
                steps: 2,
                barriers: 3,
            },
            FrameTimes {
                frame: 8,
                passes: vec![pass("smoke.grow", 10_000_000, 13_000_000)],
                skipped: vec![("smoke.shadow", "off, or \"none\"")],
                steps: 1,
                barriers: 2,
            },
        ]
    }

    #[test]
    fn a_family_without_timestamps_has_no_clock() {
        assert!(Clock::new(0, 1.0).is_none());
        assert!(Clock::new(64, 1.0).is_some());
    }

    #[test]
    fn ticks_are_masked_scaled_and_wrap() {
        let mut clock = Clock::new(36, 2.5).expect("36 bits");
        let top = (1_u64 << 36) - 4;
        // The bits above the valid ones are garbage.
        assert_eq!(clock.nanoseconds(top | 7 << 40), 0);
        assert_eq!(clock.nanoseconds(4 | 9 << 50), 20, "8 ticks of 2.5 ns across the wrap");
        assert_eq!(clock.nanoseconds(2), 15, "a tick may be a little older than the one before");
        assert_eq!(clock.nanoseconds(1 << 35), ((1_u64 << 35) + 4) * 5 / 2);
        assert_eq!(clock.nanoseconds(0), ((1_u64 << 36) + 4) * 5 / 2, "a second wrap");
    }

    #[test]
    fn all_64_bits_can_be_valid() {
        let mut clock = Clock::new(64, 1.0).expect("64 bits");
        assert_eq!(clock.nanoseconds(u64::MAX - 1), 0);
        assert_eq!(clock.nanoseconds(3), 5);
        assert_eq!(clock.nanoseconds(u64::MAX - 9), 0, "before the first tick");
    }

    #[test]
    fn steps_of_one_name_that_follow_each_other_are_one_row() {
        let mut clock = Clock::new(64, 1.0).expect("64 bits");
        let ticks = [[100, 110], [112, 120], [120, 125], [130, 140]];
        let times = clock.frame(3, ["a", "a", "b", "a"], &ticks);
        let rows: Vec<_> = times.passes.iter().map(|p| (p.name, p.begin_ns, p.end_ns)).collect();
        assert_eq!(rows, [("a", 0, 20), ("b", 20, 25), ("a", 30, 40)]);
        assert_eq!((times.frame, times.total_ns()), (3, 40));
    }

    #[test]
    fn a_frame_is_a_span_and_not_a_sum() {
        assert_eq!(two_frames()[0].total_ns(), 2_000_000);
        assert_eq!(FrameTimes::default().total_ns(), 0);
    }

    #[test]
    fn the_table_has_means_and_shares() {
        let text = table(&two_frames());
        let words: Vec<Vec<&str>> = text.lines().map(|l| l.split_whitespace().collect()).collect();
        assert_eq!(words[1], ["smoke.grow", "2.000", "1.000", "3.000", "80.0", "%", "2"]);
        assert_eq!(words[2], ["smoke.outline", "1.500", "1.500", "1.500", "30.0", "%", "1"]);
        assert_eq!(words[3], ["frame", "2.500", "2.000", "3.000", "100.0", "%", "2"]);
        assert_eq!(words[4], "at most 2 steps and 3 barriers a frame".split(' ').collect::<Vec<_>>());
        assert!(table(&[]).lines().count() == 2, "no frames: a header and an empty frame row");
    }

    #[test]
    fn a_pass_is_left_out_of_no_more_frames_than_there_are() {
        let mut frames = two_frames();
        // Several steps of one name, for one reason.
        let skip = frames[0].skipped[0];
        frames[0].skipped.push(skip);
        assert_eq!(skips(&frames), "smoke.shadow: skipped, off, or \"none\" (2 of 2 frames)\n");
    }

    #[test]
    fn csv_has_the_fixed_columns_and_quotes() {
        let expected = "frame,pass,begin_ns,end_ns,skipped,reason\n\
            7,smoke.grow,0,1000000,false,\n\
            7,smoke.outline,500000,2000000,false,\n\
            7,smoke.shadow,,,true,\"off, or \"\"none\"\"\"\n";
        assert_eq!(csv(&two_frames()[..1]), expected);
    }

    #[cfg(feature = "cli")]
    #[test]
    fn the_trace_is_json_in_microseconds() {
        let text = chrome_trace(&two_frames(), "llvm \"pipe\"");
        let trace: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let events = trace["traceEvents"].as_array().expect("events");
        let grow = events.iter().find(|e| e["name"] == "smoke.grow" && e["args"]["frame"] == 8).expect("smoke.grow");
        assert_eq!((&grow["ph"], &grow["ts"], &grow["dur"]), (&"X".into(), &10_000.0.into(), &3_000.0.into()));
        let frame = events.iter().find(|e| e["name"] == "frame 7").expect("frame 7");
        assert_eq!(frame["dur"], 2_000.0);
        assert_eq!(frame["args"], serde_json::json!({ "frame": 7, "steps": 2, "barriers": 3 }));
        let skipped = events.iter().find(|e| e["ph"] == "i").expect("skipped");
        assert_eq!((&skipped["args"]["pass"], &skipped["args"]["skipped"]), (&"smoke.shadow".into(), &true.into()));
        assert_eq!(events[0]["args"]["name"], "llvm \"pipe\"");
    }
}
