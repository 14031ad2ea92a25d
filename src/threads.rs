//! Work on several threads, as many as the system gives: where it has no more, it is done here.

use std::thread::{self, Builder};

/// A part of the work.
#[cfg(any(test, feature = "reference"))]
enum Part<'scope, R> {
    Running(thread::ScopedJoinHandle<'scope, R>),
    Done(R),
}

/// Results of `work` for each part, in their order; on a thread for each, so there should be few. A panic stays one.
#[cfg(any(test, feature = "reference"))]
pub(crate) fn map<T: Clone + Send, R: Send>(
    parts: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let work = &work;
    thread::scope(|scope| {
        let start = |part: T| {
            let own = part.clone();
            match Builder::new().spawn_scoped(scope, move || work(own)) {
                Ok(thread) => Part::Running(thread),
                Err(_) => Part::Done(work(part)),
            }
        };
        let parts: Vec<Part<R>> = parts.into_iter().map(start).collect();
        let end = |part| match part {
            Part::Running(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            Part::Done(result) => result,
        };
        parts.into_iter().map(end).collect()
    })
}

/// Does `work` here and on at most so many other threads at once; it takes what is left to do by itself.
pub(crate) fn together<R: Send>(others: usize, work: impl Fn() -> R + Sync) -> Vec<R> {
    let work = &work;
    thread::scope(|scope| {
        let helpers: Vec<_> = (0..others).map_while(|_| Builder::new().spawn_scoped(scope, work).ok()).collect();
        let own = work();
        let helped = helpers.into_iter().map(|h| h.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        std::iter::once(own).chain(helped).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn parts_come_back_in_order() {
        assert_eq!(map(0..20, |n: u32| n * n), (0..20).map(|n| n * n).collect::<Vec<_>>());
        assert!(map([0_u32; 0], |n| n).is_empty());
    }

    #[test]
    fn all_work_is_done_by_however_many() {
        for others in [0, 1, 7] {
            let next = AtomicU32::new(0);
            let take =
                || std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed)).take_while(|n| *n < 100).sum();
            let sums: Vec<u32> = together(others, take);
            assert_eq!((sums.iter().sum::<u32>(), sums.len()), (4950, others + 1));
        }
    }
}
