//! Many jobs on several threads: each thread takes the next free job and runs it alone.
//!
//! The loops inside a job run on one thread: whole jobs keep every thread busy without communication, and the seconds of a job are
//! its own.

use std::num::NonZero;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use crate::job::{Job, Outcome};
use crate::sweep_error::SweepError;

/// Does the jobs `todo`, in this order, on `threads` threads, with logs looked for from the folder `base`, and hands each outcome
/// over on the calling thread as it comes. An error there ends the work.
pub(crate) fn each(
    todo: &[(u64, &Job)],
    base: &Path,
    threads: NonZero<usize>,
    take: &mut dyn FnMut(Outcome) -> Result<(), SweepError>,
) -> Result<(), SweepError> {
    let next = AtomicUsize::new(0);
    let (send, receive) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.get().min(todo.len()) {
            let alone = rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .build()
                .map_err(|error| SweepError::Threads(error.to_string()))?;
            let (next, send) = (&next, send.clone());
            std::thread::Builder::new()
                .spawn_scoped(scope, move || {
                    alone.install(|| {
                        while let Some(&(index, job)) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                            // The receiver is gone: the work was ended.
                            if send.send(job.run(index, base)).is_err() {
                                break;
                            }
                        }
                    });
                })
                .map_err(|error| SweepError::Threads(error.to_string()))?;
        }
        drop(send);
        // The receiver goes with the first error, which tells the threads to stop.
        receive.into_iter().try_for_each(take)
    })
}
