//! Whose turn a frame is: processes that share a folder of pictures claim frames, so that none is rendered twice.
//!
//! A claim is a lock on a file beside the picture. The system lets go of it when its process ends, however that ends, on the same
//! machine or on another one that shares the folder: nothing has to be guessed from clocks.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use super::Failure;
use super::outputs::{Found, Outputs};
use crate::interrupt;
use crate::io::{WriteError, hidden, remove_stale_parts};

/// How long it is until others are asked again whether they have finished.
const PATIENCE: Duration = Duration::from_millis(200);

/// A frame that this process renders and no other one does, until this is dropped.
#[derive(Debug)]
pub(super) struct Claim {
    path: PathBuf,
    /// Locked.
    _file: File,
}

impl Drop for Claim {
    fn drop(&mut self) {
        // While it is locked: who opens it now finds, once it is unlocked, a frame that is finished.
        let _ = fs::remove_file(&self.path);
    }
}

/// Whose turn it is.
#[derive(Debug)]
pub(super) enum Turn {
    /// This process's.
    Ours(Option<Claim>),
    /// Another one's, which renders it now.
    Others,
    /// Nobody's: the frame is finished.
    Nobody,
}

/// Takes turns.
pub(super) struct Turns<'a> {
    pub(super) outputs: &'a Outputs,
    /// Whether frames are claimed, and finished ones kept. Otherwise all are rendered.
    pub(super) claims: bool,
    /// Takes the pixels of a frame that another process has finished.
    pub(super) collect: &'a (dyn Fn(u32, &[[f32; 4]]) + Sync),
    /// Whether a claim could not be locked.
    is_unsure: AtomicBool,
}

impl<'a> Turns<'a> {
    pub(super) fn new(outputs: &'a Outputs, claims: bool, collect: &'a (dyn Fn(u32, &[[f32; 4]]) + Sync)) -> Turns<'a> {
        Turns { outputs, claims, collect, is_unsure: AtomicBool::new(false) }
    }

    /// Takes the turn of a frame that is to be made from `origin`.
    pub(super) fn take(&self, frame: u32, origin: u128) -> Result<Turn, Failure> {
        if !self.claims {
            return Ok(Turn::Ours(None));
        }
        let Some(claim) = self.claim(&self.outputs.picture(frame))? else { return Ok(Turn::Others) };
        // Under the claim: others finish a frame before they let go of it.
        if let Found::Finished(pixels) = self.outputs.find(frame, origin) {
            (self.collect)(frame, &pixels);
            return Ok(Turn::Nobody);
        }
        remove_stale_parts(self.outputs.files(frame));
        Ok(Turn::Ours(Some(claim)))
    }

    /// Waits until one of these frames can be had, and returns those that are not finished; none: all are.
    pub(super) fn wait(&self, mut left: Vec<(u32, u128)>) -> Result<Vec<u32>, Failure> {
        loop {
            let mut is_free = false;
            let mut open = Vec::new();
            for (frame, origin) in left {
                match self.take(frame, origin)? {
                    Turn::Nobody => continue,
                    Turn::Ours(_) => is_free = true,
                    Turn::Others => {}
                }
                open.push((frame, origin));
            }
            if is_free || open.is_empty() {
                return Ok(open.into_iter().map(|(frame, _)| frame).collect());
            }
            left = open;
            interrupt::check()?;
            thread::sleep(PATIENCE);
        }
    }

    /// Whether the file system has no locks, so that frames may have been rendered twice. Says it once.
    pub(super) fn is_unsure(&self) -> bool {
        self.is_unsure.swap(false, Ordering::Relaxed)
    }

    /// A claim, unless another process has it.
    fn claim(&self, picture: &Path) -> Result<Option<Claim>, WriteError> {
        let path = hidden(picture, "claim");
        let open = File::options().create(true).truncate(false).write(true).open(&path);
        let file = open.map_err(|source| WriteError { path: path.clone(), source })?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Ok(None),
            // Without locks it is as if nobody else were there: a frame is whole whoever writes it.
            Err(TryLockError::Error(_)) => self.is_unsure.store(true, Ordering::Relaxed),
            Ok(()) => {}
        }
        Ok(Some(Claim { path, _file: file }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::render::outputs::Frame;
    use crate::io::tests::Folder;
    use std::sync::Mutex;

    const ORIGIN: u128 = 7;

    fn outputs(folder: &Folder) -> Outputs {
        Outputs::new(&folder.0.join("####.png"), None, Vec::new(), ([1, 1], 24.0), [1, 9]).expect("a pattern")
    }

    fn frame(number: u32) -> Frame {
        Frame { origin: ORIGIN, pixels: vec![[0.0, 0.0, 0.0, 1.0]], ..Frame::of_nothing(number) }
    }

    #[test]
    fn a_frame_is_one_process_s_until_it_is_finished() {
        let folder = Folder::new();
        let outputs = outputs(&folder);
        let seen = Mutex::new(Vec::new());
        let collect = |frame, _: &[[f32; 4]]| seen.lock().expect("no panic").push(frame);
        let [ours, others] = [0, 1].map(|_| Turns::new(&outputs, true, &collect));
        let taken = ours.take(3, ORIGIN).expect("a folder");
        assert!(matches!(taken, Turn::Ours(Some(_))));
        assert!(matches!(others.take(3, ORIGIN).expect("a folder"), Turn::Others));
        assert!(matches!(others.take(4, ORIGIN).expect("a folder"), Turn::Ours(Some(_))));
        outputs.write(&frame(3)).expect("written");
        assert!(matches!(others.take(3, ORIGIN).expect("a folder"), Turn::Others), "not before it is let go");
        drop(taken);
        assert!(matches!(others.take(3, ORIGIN).expect("a folder"), Turn::Nobody));
        assert!(matches!(others.take(3, ORIGIN + 1).expect("a folder"), Turn::Ours(Some(_))), "of another shot");
        assert_eq!(*seen.lock().expect("no panic"), [3]);
        assert_eq!(folder.names(), ["0003.png"], "claims are gone");
        assert!(!ours.is_unsure());
    }

    #[test]
    fn what_another_process_has_is_waited_for() {
        let folder = Folder::new();
        let outputs = outputs(&folder);
        let collect = |_, _: &[[f32; 4]]| {};
        let [ours, others] = [0, 1].map(|_| Turns::new(&outputs, true, &collect));
        let [finished, given_up] = [3, 5].map(|frame| others.take(frame, ORIGIN).expect("a folder"));
        let left = thread::scope(|scope| {
            let waiting = scope.spawn(|| ours.wait(vec![(3, ORIGIN), (5, ORIGIN)]));
            outputs.write(&frame(3)).expect("written");
            drop(finished);
            thread::sleep(2 * PATIENCE);
            assert!(!waiting.is_finished());
            drop(given_up);
            waiting.join().expect("no panic").expect("a folder")
        });
        assert_eq!(left, [5]);
        assert!(ours.wait(vec![(3, ORIGIN)]).expect("a folder").is_empty());
    }

    #[test]
    fn without_claims_all_is_rendered_again() {
        let folder = Folder::new();
        let outputs = outputs(&folder);
        outputs.write(&frame(3)).expect("written");
        let turns = Turns::new(&outputs, false, &|_, _| {});
        assert!(matches!(turns.take(3, ORIGIN).expect("a folder"), Turn::Ours(None)));
    }
}
