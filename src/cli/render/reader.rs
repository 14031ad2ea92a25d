//! Reads frames ahead of the renderer: which are this process's, what they bring, and what they go on from.

use std::any::Any;
use std::sync::mpsc::SyncSender;

use super::Failure;
use super::cache::Cache;
use super::input::{Inputs, NamedBrought};
use super::origin::Origins;
use super::turns::{Claim, Turn, Turns};
use crate::cli::memory;
use crate::io::shot::Shot;
use crate::offline::Scene;

/// A frame, and what it brings.
pub(super) struct Step {
    /// The shot's number of it.
    pub(super) number: u32,
    /// A hash of what it is made from; 0 where it is not rendered.
    pub(super) origin: u128,
    /// Whether it is rendered, or only moves on what has a past.
    pub(super) rendered: bool,
    /// What it goes on from, if that is not the step before.
    pub(super) past: Option<Vec<u8>>,
    /// The key of what it leaves, if that is to be kept.
    pub(super) keeps: Option<u128>,
    /// Keeps other processes from the frame.
    pub(super) claim: Option<Claim>,
    /// By the effect's name.
    brought: Vec<NamedBrought>,
}

/// A step, or why there are no more.
pub(super) type Read = Result<Step, Failure>;

impl Step {
    /// Puts what the frame brings into its scene.
    pub(super) fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        self.brought.iter().for_each(|(_, brought)| brought.put(scene));
    }

    /// Input of the frame, by the effect's name.
    pub(super) fn brought(&self) -> Vec<(&'static str, &dyn Any)> {
        self.brought.iter().map(|(name, brought)| (*name, &**brought as &dyn Any)).collect()
    }
}

/// Reads the steps of a process.
pub(super) struct Reader<'a> {
    pub(super) shot: &'a Shot,
    pub(super) inputs: Inputs,
    pub(super) origins: Origins<'a>,
    pub(super) turns: &'a Turns<'a>,
    pub(super) cache: Option<&'a Cache>,
}

impl Reader<'_> {
    /// Reads what the steps bring that render those of the `missing` frames that are this process's, one step ahead of who takes
    /// them: what has a past is stepped from the shot's first frame, or from one whose past is kept. Returns the frames that other
    /// processes were at, and their origins.
    pub(super) fn run(mut self, missing: &[u32], to: &SyncSender<Read>) -> Vec<(u32, u128)> {
        let mut others = Vec::new();
        let mut next = self.shot.frames[0];
        for frame in missing {
            let sent = self.take(*frame).and_then(|(turn, origin)| match turn {
                Turn::Ours(mut claim) => {
                    let from = std::mem::replace(&mut next, frame + 1);
                    let is_last = Some(frame) == missing.last();
                    self.steps(from, *frame, is_last, |step| {
                        let rendered = step.number == *frame;
                        let claim = if rendered { claim.take() } else { None };
                        let origin = if rendered { origin } else { 0 };
                        to.send(Ok(Step { rendered, origin, claim, ..step })).is_ok()
                    })
                }
                Turn::Others => {
                    others.push((*frame, origin));
                    Ok(true)
                }
                Turn::Nobody => Ok(true),
            });
            match sent {
                Ok(true) => {}
                // The renderer has gone.
                Ok(false) => break,
                Err(failure) => {
                    // It may have gone, too.
                    let _ = to.send(Err(failure));
                    break;
                }
            }
        }
        others
    }

    /// Whose turn a frame is, and what it is made from.
    fn take(&mut self, frame: u32) -> Result<(Turn, u128), Failure> {
        memory::doing("reading the input of frame", Some(frame));
        let origin = self.origins.of(frame, self.inputs.effects())?;
        Ok((self.turns.take(frame, origin)?, origin))
    }

    /// Hands on the steps to a frame that is rendered, where the next that effects with a past have not gone through is `next`, as
    /// long as they are taken; whether all were.
    fn steps(
        &mut self,
        next: u32,
        frame: u32,
        is_last: bool,
        mut take: impl FnMut(Step) -> bool,
    ) -> Result<bool, Failure> {
        let mut kept = self.kept(next, frame)?;
        let from = match &kept {
            Some((after, _)) => after + 1,
            None if self.inputs.has_past() => next,
            None => frame,
        };
        for number in from..=frame {
            memory::doing("reading the input of frame", Some(number));
            let past = kept.take().map(|(_, past)| past);
            let is_kept = Cache::keeps(number - self.shot.frames[0] + 1) || is_last && number == frame;
            let keeps = if is_kept { self.keeps(number)? } else { None };
            let brought = self.inputs.read(number, number == frame)?;
            self.origins.check_of(number, self.inputs.effects())?;
            let (origin, rendered, claim) = (0, false, None);
            if !take(Step { number, origin, rendered, past, keeps, claim, brought }) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The last frame before `frame` and not before `next` whose past is kept, and that.
    fn kept(&mut self, next: u32, frame: u32) -> Result<Option<(u32, Vec<u8>)>, Failure> {
        let Some(cache) = self.cache.filter(|_| self.inputs.has_past()) else { return Ok(None) };
        for after in (next..frame).rev() {
            let key = self.origins.past(after, self.inputs.effects())?;
            if let Some(past) = cache.read(key) {
                return Ok(Some((after, past)));
            }
        }
        Ok(None)
    }

    /// The key of what a frame leaves, if that is to be kept.
    fn keeps(&mut self, frame: u32) -> Result<Option<u128>, Failure> {
        let Some(cache) = self.cache.filter(|_| self.inputs.has_past()) else { return Ok(None) };
        let key = self.origins.past(frame, self.inputs.effects())?;
        // One that is damaged is written anew.
        Ok(cache.read(key).is_none().then_some(key))
    }
}
