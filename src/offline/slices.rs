//! A frame as several submissions, each of which is short: drivers end those that seem to hang, and between them the
//! caller can be asked whether to go on. A frame that is short itself is one.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::headless::{Commands, Submission, Submitter};
use crate::gpu::recorder::Stream;

/// The pace by which frames are cut.
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
    fn learn(&mut self, steps: &Steps, seconds: f64) {
        let is_known = steps.seconds.is_finite() && steps.seconds > 0.0;
        for step in &steps.names {
            let share = match is_known {
                true => self.of(step) * seconds / steps.seconds,
                false => seconds / steps.names.len() as f64,
            };
            self.steps.insert(step, share);
        }
    }
}

/// Steps that are submitted together.
#[derive(Debug, Default)]
struct Steps {
    names: Vec<&'static str>,
    /// That they are expected to take.
    seconds: f64,
}

impl Steps {
    /// Their name in errors: steps of a frame.
    fn of(&self, frame: &str) -> String {
        match (self.names.first(), self.names.last()) {
            (Some(first), Some(last)) if first == last => format!("{frame}, {first}"),
            (Some(first), Some(last)) => format!("{frame}, {first} to {last}"),
            _ => frame.to_owned(),
        }
    }
}

/// Submits the steps of a frame in slices while they are recorded, and learns what they take. One slice runs while the
/// next is recorded. Where recording fails, what has been submitted is waited for.
pub(super) struct Slicer<'a> {
    submitter: Submitter<'a>,
    pace: &'a mut Pace,
    frame: &'a str,
    recorded: Option<(Commands, Steps)>,
    running: Option<(Submission, Steps, Instant)>,
}

impl<'a> Slicer<'a> {
    /// Begins the first one of this frame.
    pub(super) fn new(mut submitter: Submitter<'a>, pace: &'a mut Pace, frame: &'a str) -> Result<Slicer<'a>> {
        let recorded = Some((submitter.begin()?, Steps::default()));
        Ok(Slicer { submitter, pace, frame, recorded, running: None })
    }

    /// Submits what is recorded, once what runs has ended.
    fn submit(&mut self) -> Result<()> {
        self.settle()?;
        let Some((commands, steps)) = self.recorded.take() else { return Ok(()) };
        let begin = Instant::now();
        let submission = self.submitter.start(commands, &steps.of(self.frame))?;
        self.running = Some((submission, steps, begin));
        Ok(())
    }

    fn settle(&mut self) -> Result<()> {
        let Some((submission, steps, begin)) = self.running.take() else { return Ok(()) };
        self.submitter.wait(submission)?;
        self.pace.learn(&steps, begin.elapsed().as_secs_f64());
        Ok(())
    }

    /// Submits the last one and waits until all have ended.
    pub(super) fn finish(mut self) -> Result<()> {
        self.submit()?;
        self.settle()
    }
}

impl Drop for Slicer<'_> {
    fn drop(&mut self) {
        if let Some((commands, _)) = self.recorded.take() {
            self.submitter.discard(commands);
        }
        // There is an error already.
        let _ = self.settle();
    }
}

impl Stream for Slicer<'_> {
    fn next(&mut self, step: &'static str) -> Result<vk::CommandBuffer> {
        let seconds = self.pace.of(step);
        let longest = self.pace.longest;
        let is_full = |(_, steps): &(Commands, Steps)| !steps.names.is_empty() && steps.seconds + seconds > longest;
        if self.recorded.as_ref().is_none_or(is_full) {
            self.submit()?;
            self.recorded = Some((self.submitter.begin()?, Steps::default()));
        }
        if let Some((_, steps)) = &mut self.recorded {
            steps.names.push(step);
            steps.seconds += seconds;
        }
        Ok(self.current())
    }

    fn current(&self) -> vk::CommandBuffer {
        self.recorded.as_ref().map_or(vk::CommandBuffer::null(), |(commands, _)| commands.raw())
    }
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
