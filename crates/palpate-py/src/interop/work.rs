//! Long work: off the interpreter's lock, on a pool of threads, with progress told and Ctrl-C heard.
//!
//! The work runs on the pool while the calling thread waits, wakes now and then to run Python's signal handlers, and passes
//! progress on, so that all Python code runs in the thread that called. When a handler or a listener raises, the
//! call ends at once; the work, which owns all it needs, notices at its next sign of progress and is dropped.

use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use palpate::reconstruct::Progress;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::interop::errors::{self, InternalError};
use crate::interop::whole::Whole;

/// Time between two looks at Python's signals.
const TICK: Duration = Duration::from_millis(50);

/// Most threads that a call may ask for.
const MOST_THREADS: usize = 1024;

/// What the work tells the thread that waits for it.
enum Message<T> {
    Progress(Progress),
    Done(T),
    Panicked,
}

/// Carried by the unwinding of work that nobody waits for any more.
struct Abandoned;

/// Passes signs of progress on to the thread that waits.
pub struct Teller {
    tell: Box<dyn Fn(Progress) + Send + Sync>,
    abandoned: Arc<AtomicBool>,
}

impl Teller {
    /// Tells how far the work has come; does not return when nobody waits for it any more.
    pub fn tell(&self, progress: Progress) {
        if self.abandoned.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Abandoned));
        }
        (self.tell)(progress);
    }
}

/// Runs `work` on the pool without the interpreter's lock; see the top of this file.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<u64>,
    listener: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Teller) -> T + Send + 'static,
) -> PyResult<T> {
    let pool = pool(threads)?;
    let (sender, mut receiver) = mpsc::channel();
    let abandoned = Arc::new(AtomicBool::new(false));
    let teller = Teller { tell: tell_through(sender.clone()), abandoned: Arc::clone(&abandoned) };
    pool.spawn(move || {
        let message = match catch_unwind(AssertUnwindSafe(|| work(&teller))) {
            Ok(result) => Message::Done(result),
            Err(_) => Message::Panicked,
        };
        // Nobody may be waiting any more.
        let _ = sender.send(message);
    });
    loop {
        let (returned, next) = py.detach(move || {
            let next = receiver.recv_timeout(TICK);
            (receiver, next)
        });
        receiver = returned;
        let told = match next {
            Ok(Message::Done(result)) => break Ok(result),
            Ok(Message::Panicked) | Err(RecvTimeoutError::Disconnected) => {
                break Err(InternalError::new_err("palpate failed on this input; please report it with the input"));
            }
            Ok(Message::Progress(progress)) => {
                listener.map_or(Ok(()), |listener| listener.call1((progress.stage, progress.fraction)).map(drop))
            }
            Err(RecvTimeoutError::Timeout) => Ok(()),
        };
        if let Err(raised) = told.and_then(|()| py.check_signals()) {
            abandoned.store(true, Ordering::Relaxed);
            break Err(raised);
        }
    }
}

/// The same, told to whom `progress` of a Python function asks for: a callable, a bar, or nobody.
pub fn run_told<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<Whole>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Teller) -> T + Send + 'static,
) -> PyResult<T> {
    let listener = py.import("palpate._progress")?.getattr("listener")?.call1((progress,))?;
    let listener = (!listener.is_none()).then_some(listener);
    let outcome = run(py, threads.map(|threads| threads.0), listener.as_ref(), work);
    if let Some(listener) = listener {
        listener.call_method0("close")?;
    }
    outcome
}

fn tell_through<T: Send + 'static>(sender: Sender<Message<T>>) -> Box<dyn Fn(Progress) + Send + Sync> {
    // A listener that has gone away is noticed by the flag.
    Box::new(move |progress| drop(sender.send(Message::Progress(progress))))
}

/// The pool that calls share, and the process that it belongs to: the threads of a pool do not survive a fork.
static SHARED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// So many threads, if a call may ask for them.
pub fn thread_count(threads: u64) -> PyResult<NonZero<usize>> {
    let count = usize::try_from(threads).ok().filter(|count| *count <= MOST_THREADS).and_then(NonZero::new);
    count.ok_or_else(|| errors::input(format!("threads must be from 1 to {MOST_THREADS}")))
}

/// A pool of so many threads, or the shared one, with as many threads as there are processors. The lock is held only by a
/// thread that holds the interpreter's lock too, so no fork from Python can catch it locked.
fn pool(threads: Option<u64>) -> PyResult<Arc<ThreadPool>> {
    if let Some(count) = threads {
        return started(thread_count(count)?.get());
    }
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    match shared.take() {
        Some((owner, pool)) if owner == process => {
            *shared = Some((process, Arc::clone(&pool)));
            return Ok(pool);
        }
        #[expect(clippy::mem_forget, reason = "dropping it would wait for threads that are not there")]
        Some(inherited) => std::mem::forget(inherited),
        None => {}
    }
    let pool = started(0)?;
    *shared = Some((process, Arc::clone(&pool)));
    Ok(pool)
}

/// A new pool; 0 threads = as many as there are processors.
fn started(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(|number| format!("palpate-{number}")).build();
    pool.map(Arc::new).map_err(|error| InternalError::new_err(format!("the threads cannot be started: {error}")))
}
