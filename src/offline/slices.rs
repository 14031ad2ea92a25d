//! A frame as several submissions, each of which is short: drivers end those that seem to hang, and between them the
//! caller can be asked whether to go on. A frame that is short itself is one.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::headless::{CommandSource, Commands, Headless};
use crate::gpu::recorder::Stream;

/// What frames are cut by.
#[derive(Debug)]
pub(super) struct Pace {
    /// Seconds that a step of this name took when it ran last.
    steps: HashMap<&'static str, f64>,
    /// Seconds that a submission should take at most.
    longest: f64,
}

impl Default for Pace {
    /// Watchdogs wait for two seconds and more.
    fn default() -> Pace {
        Pace { steps: HashMap::new(), longest: 0.5 }
    }
}

impl Pace {
    /// See [`super::Offline::set_longest_submission`].
    pub(super) fn set_longest(&mut self, longest: Option<Duration>) {
        self.longest = longest.map_or(f64::INFINITY, |longest| longest.as_secs_f64());
    }

    /// Seconds that a step will take: any time where it has not run yet.
    fn of(&self, step: &str) -> f64 {
        self.steps.get(step).copied().unwrap_or(f64::INFINITY)
    }

    /// Shares the time of a submission among its steps, in the proportions known before.
    fn learn(&mut self, slice: &Slice, seconds: f64) {
        let scale = seconds / slice.seconds;
        for step in &slice.steps {
            let share = match slice.seconds.is_finite() && slice.seconds > 0.0 {
                true => self.of(step) * scale,
                false => seconds / slice.steps.len() as f64,
            };
            self.steps.insert(step, share);
        }
    }
}

/// Steps that are submitted together.
#[derive(Debug)]
pub(super) struct Slice {
    commands: Option<Commands>,
    steps: Vec<&'static str>,
    /// That they are expected to take.
    seconds: f64,
}

impl Slice {
    /// What it is called in errors: steps of a frame.
    fn name(&self, frame: &str) -> String {
        match (self.steps.first(), self.steps.last()) {
            (Some(first), Some(last)) if first == last => format!("{frame}, {first}"),
            (Some(first), Some(last)) => format!("{frame}, {first} to {last}"),
            _ => frame.to_owned(),
        }
    }
}

/// Cuts the steps of a frame into slices while they are recorded.
pub(super) struct Slicer<'a> {
    source: CommandSource<'a>,
    pace: &'a Pace,
    slices: &'a mut Vec<Slice>,
    current: vk::CommandBuffer,
}

impl<'a> Slicer<'a> {
    /// Begins the first one.
    pub(super) fn new(source: CommandSource<'a>, pace: &'a Pace, slices: &'a mut Vec<Slice>) -> Result<Slicer<'a>> {
        let mut slicer = Slicer { source, pace, slices, current: vk::CommandBuffer::null() };
        slicer.begin()?;
        Ok(slicer)
    }

    fn begin(&mut self) -> Result<()> {
        let commands = self.source.begin()?;
        self.current = commands.raw();
        self.slices.push(Slice { commands: Some(commands), steps: Vec::new(), seconds: 0.0 });
        Ok(())
    }
}

impl Stream for Slicer<'_> {
    fn next(&mut self, step: &'static str) -> Result<vk::CommandBuffer> {
        let seconds = self.pace.of(step);
        let is_full = |slice: &Slice| !slice.steps.is_empty() && slice.seconds + seconds > self.pace.longest;
        if self.slices.last().is_some_and(is_full) {
            self.begin()?;
        }
        if let Some(slice) = self.slices.last_mut() {
            slice.steps.push(step);
            slice.seconds += seconds;
        }
        Ok(self.current)
    }

    fn current(&self) -> vk::CommandBuffer {
        self.current
    }
}

/// Submits slices, each once the one before it has ended, and learns what their steps take. If one fails, those after it
/// are discarded.
pub(super) fn run(device: &mut Headless, slices: Vec<Slice>, pace: &mut Pace, frame: &str) -> Result<()> {
    let mut slices = slices.into_iter();
    let result = slices.by_ref().try_for_each(|mut slice| {
        let Some(commands) = slice.commands.take() else { return Ok(()) };
        let begin = Instant::now();
        device.submit(commands, &slice.name(frame))?;
        pace.learn(&slice, begin.elapsed().as_secs_f64());
        Ok(())
    });
    discard(device, slices);
    result
}

/// Takes slices back that are not submitted.
pub(super) fn discard(device: &mut Headless, slices: impl IntoIterator<Item = Slice>) {
    slices.into_iter().filter_map(|slice| slice.commands).for_each(|commands| device.discard(commands));
}

/// A lost device's error, with the step that ran if it is known.
pub(super) fn at_step(error: Error, frame: &str, step: Option<&'static str>) -> Error {
    match (error, step) {
        (Error::Vulkan { call, result: result @ vk::Result::ERROR_DEVICE_LOST, .. }, Some(step)) => {
            Error::Vulkan { call, object: Some(format!("{frame}, {step}")), result }
        }
        (error, _) => error,
    }
}
