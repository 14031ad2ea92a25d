//! Inputs of a shot, one per frame: a built-in one, one file for all frames, or files numbered by frame.

use std::fmt::Debug;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::ReadError;
use super::pattern::{Pattern, PatternError};

/// The input of which a sequence has one per frame.
pub trait Input: Debug + Sized {
    /// Those that the program makes itself.
    type Builtin: Copy + Debug + PartialEq;
    /// How files are read.
    type Options: Clone + Debug;
    /// One of them in words, for messages: "a volume".
    const ONE: &str;

    /// The one of that name (without `builtin:`), or what to say where there is none.
    fn builtin(name: &str) -> Result<Self::Builtin, String>;

    /// A frame of a built-in one; `fps` above 0.
    fn make(which: Self::Builtin, frame: u32, fps: f64) -> Self;

    /// Reads a file.
    fn read(path: &Path, options: &Self::Options) -> Result<Self, ReadError>;
}

/// Where the input of a frame comes from. Frames of equal source have the same input.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Source<B> {
    Builtin { which: B, frame: u32, fps: f64 },
    File(PathBuf),
}

#[derive(Clone, Debug)]
enum Kind<B> {
    Builtin { which: B, fps: f64 },
    Files(Pattern),
}

/// How far back `hold` looks for a file, in frames.
const MAX_HOLD: u32 = 100_000;

/// The inputs of a shot, one per frame.
#[derive(Clone, Debug)]
pub struct Sequence<I: Input> {
    kind: Kind<I::Builtin>,
    options: I::Options,
    hold: bool,
    /// Where files are numbered by frames of another rate: the frame that has its own number, and theirs by the shot's.
    rate: Option<(u32, f64)>,
    last: Option<(Source<I::Builtin>, Arc<I>)>,
}

impl<I: Input> Sequence<I> {
    /// `name` is `builtin:NAME`, or a path relative to `folder`, with a place for the frame number (see [`Pattern`]) or
    /// without. With `hold`, a missing frame has the input of the last one before it that is there (at most 100,000
    /// frames back). `fps` (above 0) is the time scale of the built-in ones.
    pub fn new(
        name: &str,
        folder: &Path,
        options: I::Options,
        hold: bool,
        fps: f64,
    ) -> Result<Sequence<I>, PatternError> {
        let kind = match name.strip_prefix("builtin:") {
            Some(builtin) => match I::builtin(builtin) {
                Ok(which) => Kind::Builtin { which, fps },
                Err(why) => return Err(PatternError { path: name.into(), why }),
            },
            None => Kind::Files(Pattern::parse(name)?.below(folder)),
        };
        Ok(Sequence { kind, options, hold, rate: None, last: None })
    }

    /// The same of files that have `ratio` frames for each of the shot's: `first` has the file of that number, and each later
    /// frame the last file that is not after it.
    #[must_use]
    pub fn at_rate(self, first: u32, ratio: f64) -> Sequence<I> {
        Sequence { rate: Some((first, ratio)), ..self }
    }

    /// The number of the file of a frame.
    fn number(&self, frame: u32) -> u32 {
        let Some((first, ratio)) = self.rate else { return frame };
        // What rounding takes from a whole number is no frame.
        first.saturating_add((f64::from(frame.saturating_sub(first)) * ratio + 1e-6) as u32)
    }

    /// The input of a frame. The last one is kept, so that a frame with the same one costs nothing.
    pub fn frame(&mut self, frame: u32) -> Result<Arc<I>, ReadError> {
        let source = self.source(frame)?;
        if let Some((last, input)) = &self.last
            && *last == source
        {
            return Ok(input.clone());
        }
        let input = Arc::new(match &source {
            Source::File(path) => I::read(path, &self.options)?,
            Source::Builtin { which, frame, fps } => I::make(*which, *frame, *fps),
        });
        self.last = Some((source, input.clone()));
        Ok(input)
    }

    /// Whether two frames have the same input.
    pub fn is_same(&self, one: u32, other: u32) -> Result<bool, ReadError> {
        Ok(self.source(one)? == self.source(other)?)
    }

    /// The file that a frame's input comes from; none where the program makes it.
    pub fn file(&self, frame: u32) -> Result<Option<PathBuf>, ReadError> {
        Ok(match self.source(frame)? {
            Source::File(path) => Some(path),
            Source::Builtin { .. } => None,
        })
    }

    /// How files are read.
    pub(super) fn options(&self) -> &I::Options {
        &self.options
    }

    /// The sources of frames, without those that are the one of the frame before.
    pub(super) fn sources(
        &self,
        frames: impl IntoIterator<Item = u32>,
    ) -> impl Iterator<Item = Result<Source<I::Builtin>, ReadError>> {
        let mut before = None;
        frames.into_iter().filter_map(move |frame| match self.source(frame) {
            Ok(source) if before.as_ref() == Some(&source) => None,
            Ok(source) => {
                before = Some(source.clone());
                Some(Ok(source))
            }
            Err(error) => Some(Err(error)),
        })
    }

    pub(super) fn source(&self, frame: u32) -> Result<Source<I::Builtin>, ReadError> {
        let pattern = match &self.kind {
            Kind::Builtin { which, fps } => return Ok(Source::Builtin { which: *which, frame, fps: *fps }),
            Kind::Files(pattern) => pattern,
        };
        let frame = self.number(frame);
        let wanted = pattern.path(frame);
        if exists(&wanted)? {
            return Ok(Source::File(wanted));
        }
        if self.hold && pattern.has_number() {
            for before in (frame.saturating_sub(MAX_HOLD)..frame).rev() {
                let path = pattern.path(before);
                if exists(&path)? {
                    return Ok(Source::File(path));
                }
            }
            return Err(ReadError::file(&wanted, "no such file, and none of an earlier frame to hold", I::ONE));
        }
        let expected = match pattern.has_number() {
            true => format!("{} for frame {frame} (hold = true keeps the last one before)", I::ONE),
            false => I::ONE.to_owned(),
        };
        Err(ReadError::file(&wanted, "no such file", expected))
    }
}

fn exists(path: &Path) -> Result<bool, ReadError> {
    fs::exists(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))
}
