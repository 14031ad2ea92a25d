//! Input of an effect's frames, whichever effect it is: read ahead of the renderer, a frame at a time.

use std::any::Any;
use std::path::Path;
use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use super::hash::Files;
use crate::error::Error;
use crate::interrupt::Interrupted;
use crate::io::ReadError;
use crate::io::pattern::PatternError;
use crate::io::sequence::{self, Sequence};
use crate::offline::{BlurError, Effects, Scene};

/// Why the input of a shot cannot be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// It has a name that no input has.
    #[error(transparent)]
    Name(#[from] PatternError),
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// What follows from it cannot be made.
    #[error(transparent)]
    Effect(#[from] Error),
    /// The program was asked to stop.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<BlurError> for InputError {
    fn from(error: BlurError) -> InputError {
        match error {
            BlurError::Read(error) => error.into(),
            BlurError::Effect(error) => error.into(),
        }
    }
}

/// The input of an effect of a shot.
pub(crate) trait Input: Send {
    /// Adds what all frames are made from to their hash: settings, and what does not change.
    fn add_common(&self, hash: &mut Xxh3, files: &mut Files) -> Result<(), ReadError>;

    /// Adds what a frame is made from.
    fn add_frame(&self, hash: &mut Xxh3, files: &mut Files, frame: u32) -> Result<(), ReadError>;

    /// Whether a frame depends on all frames before it.
    fn has_past(&self) -> bool {
        false
    }

    /// Reads what there must be before the effect can be made that draws the frames `rendered`, with so many threads.
    fn prepare(&mut self, _rendered: &[u32], _threads: usize) -> Result<(), InputError> {
        Ok(())
    }

    /// Parts of the input that are passed over, and the choices where there are several.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Adds what the effect is made for that draws the frames `rendered`, and keeps its layers if that is asked for.
    fn describe(&mut self, effects: Effects, rendered: &[u32], layers: bool) -> Result<Effects, InputError>;

    /// The choices that the shot left to its input, for people.
    fn choices(&self) -> Option<String> {
        None
    }

    /// Reads what a frame brings; none where the effect has nothing to do in a frame that is not drawn.
    fn read(&mut self, frame: u32, rendered: bool) -> Result<Option<Box<dyn Brought>>, InputError>;
}

/// Input of a frame.
pub(crate) trait Brought: Any + Send {
    /// Puts it into the scene.
    fn put<'a>(&'a self, scene: &mut Scene<'a>);
}

/// A sequence, and the input that it handed out last.
pub(super) struct Fresh<I: sequence::Input> {
    pub(super) sequence: Sequence<I>,
    last: Option<Arc<I>>,
}

impl<I: sequence::Input> Fresh<I> {
    pub(super) fn new(sequence: Sequence<I>) -> Fresh<I> {
        Fresh { sequence, last: None }
    }

    /// The input of the last frame that was read.
    pub(super) fn last(&self) -> Option<&I> {
        self.last.as_deref()
    }

    /// A frame's input, unless it is that of the last frame that was read. What is read from a file must pass `check`; what
    /// the program makes itself is as it should be.
    pub(super) fn read(
        &mut self,
        frame: u32,
        check: impl FnOnce(&I, &Path) -> Result<(), ReadError>,
    ) -> Result<Option<Arc<I>>, ReadError> {
        // A sequence hands out the same one for as long as it lasts.
        let input = self.sequence.frame(frame)?;
        let is_same = self.last.as_ref().is_some_and(|last| Arc::ptr_eq(last, &input));
        self.last = Some(input.clone());
        if is_same {
            return Ok(None);
        }
        if let Some(path) = self.sequence.file(frame)? {
            check(&input, &path)?;
        }
        Ok(Some(input))
    }
}
