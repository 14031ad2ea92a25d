//! Threads that encode and write frames while the next ones are rendered.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Scope, ScopedJoinHandle};

use super::Failure;

/// The threads and the queue to them, which holds as many frames as there are threads.
pub(super) struct Pool<'scope, T> {
    queue: SyncSender<T>,
    threads: Vec<ScopedJoinHandle<'scope, ()>>,
}

/// State that the threads share.
pub(super) struct Shared<T> {
    queue: Mutex<Receiver<T>>,
    failed: Mutex<Option<Failure>>,
}

impl<T: Send> Shared<T> {
    /// A queue of `length` items: its entrance and what threads share.
    pub(super) fn new(length: usize) -> (SyncSender<T>, Shared<T>) {
        let (sender, receiver) = sync_channel(length);
        (sender, Shared { queue: Mutex::new(receiver), failed: Mutex::new(None) })
    }

    /// The first failure of any thread, once.
    fn check(&self) -> Result<(), Failure> {
        lock(&self.failed).take().map_or(Ok(()), Err)
    }

    fn work(&self, work: impl Fn(T) -> Result<(), Failure>) {
        loop {
            // The lock is held while waiting: one thread waits in the queue, the others for the lock.
            let next = lock(&self.queue).recv();
            let Ok(item) = next else { return };
            if lock(&self.failed).is_some() {
                // What is left is taken out unwritten, so that the renderer does not wait for room in the queue.
                continue;
            }
            if let Err(failure) = work(item) {
                lock(&self.failed).get_or_insert(failure);
            }
        }
    }
}

impl<'scope, T: Send + 'scope> Pool<'scope, T> {
    /// Starts `threads` threads that do `work` on what comes through the queue.
    pub(super) fn start<'env>(
        scope: &'scope Scope<'scope, 'env>,
        threads: usize,
        queue: SyncSender<T>,
        shared: &'env Shared<T>,
        work: impl Fn(T) -> Result<(), Failure> + Copy + Send + 'env,
    ) -> Result<Self, Failure>
    where
        T: 'env,
    {
        let start = |_| thread::Builder::new().spawn_scoped(scope, move || shared.work(work));
        // As many as there is memory for; one will do.
        let first = start(0).map_err(|e| no_thread("writes", &e))?;
        let more = (1..threads).map_while(|at| start(at).ok());
        Ok(Pool { queue, threads: std::iter::once(first).chain(more).collect() })
    }

    /// Hands over an item; waits while the queue is full. Fails if a thread has failed.
    pub(super) fn send(&self, shared: &Shared<T>, item: T) -> Result<(), Failure> {
        shared.check()?;
        self.queue.send(item).map_err(|_| Failure::new(Failure::OUTPUT, "the threads that write frames have ended"))
    }

    /// Waits until everything that was handed over is written.
    pub(super) fn finish(self, shared: &Shared<T>) -> Result<(), Failure> {
        drop(self.queue);
        for thread in self.threads {
            if thread.join().is_err() {
                return Err(Failure::new(Failure::OUTPUT, "a thread that writes frames has failed"));
            }
        }
        shared.check()
    }
}

/// A thread that could not be had, by what it does.
pub(super) fn no_thread(does: &str, error: &io::Error) -> Failure {
    Failure::new(Failure::DEVICE, format!("out of memory: no thread that {does} frames: {error}"))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn everything_is_written_before_it_is_finished() {
        let sum = AtomicU32::new(0);
        let (queue, shared) = Shared::new(2);
        let work = |n: u32| {
            thread::sleep(std::time::Duration::from_millis(1));
            sum.fetch_add(n, Ordering::SeqCst);
            Ok(())
        };
        thread::scope(|scope| {
            let pool = Pool::start(scope, 3, queue, &shared, work).expect("threads");
            (1..=20).for_each(|n| pool.send(&shared, n).expect("no failure"));
            pool.finish(&shared).expect("no failure");
        });
        assert_eq!(sum.into_inner(), 210);
    }

    #[test]
    fn the_first_failure_comes_back_and_nobody_waits_for_ever() {
        let (queue, shared) = Shared::new(1);
        let work = |n: u32| if n == 3 { Err(Failure::new(6, "full")) } else { Ok(()) };
        let failure = thread::scope(|scope| {
            let pool = Pool::start(scope, 2, queue, &shared, work).expect("threads");
            let sent = (1..=50).try_for_each(|n| pool.send(&shared, n));
            let finished = pool.finish(&shared);
            sent.and(finished).expect_err("it failed")
        });
        assert_eq!((failure.code, failure.message.as_str()), (6, "full"));
    }
}
