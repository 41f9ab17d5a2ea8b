//! A source read by a thread of its own, through a queue of limited length.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use palpate::Sample;

use crate::error::SourceError;
use crate::gate::Gate;
use crate::losses::Losses;
use crate::rigs::RigSample;
use crate::source::{Arrival, Overflow, Source};

/// Samples that wait at most: minutes of a usual rig, and a few megabytes.
const QUEUE_SAMPLES: usize = 16_384;

/// What came of a source.
#[derive(Clone, Debug, PartialEq)]
pub enum Batch<S = Sample> {
    /// Samples in the order of time; none where none came in time.
    Samples(Vec<S>),
    /// The source has ended.
    End,
}

/// The samples of a source: plausible ones in the order of time, as they come. What is not taken fast enough is dropped, oldest first, where the
/// source cannot wait.
#[derive(Debug)]
pub struct Stream<S: RigSample = Sample> {
    shared: Arc<Shared<S>>,
}

#[derive(Debug)]
struct Shared<S: RigSample> {
    state: Mutex<State<S>>,
    changed: Condvar,
}

#[derive(Debug)]
struct State<S: RigSample> {
    queue: VecDeque<S>,
    losses: Losses,
    overflowed: u64,
    first_fault: Option<String>,
    rig: Option<S::Rig>,
    ended: Option<Result<(), SourceError>>,
    abandoned: bool,
}

impl<S: RigSample> Default for Shared<S> {
    fn default() -> Self {
        let state = State {
            queue: VecDeque::new(),
            losses: Losses::default(),
            overflowed: 0,
            first_fault: None,
            rig: None,
            ended: None,
            abandoned: false,
        };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }
}

impl<S: RigSample> Shared<S> {
    /// The state is whole at every instant, so that a thread that panicked left nothing half done.
    fn lock(&self) -> MutexGuard<'_, State<S>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<S: RigSample> Stream<S> {
    /// Begins to read. Samples are given as the source writes them; `conventions` say which of them are plausible: those of the rig of the source
    /// where none are stated.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(mut source: Box<dyn Source<S>>, conventions: Option<S::Conventions>) -> Result<Self, SourceError> {
        let shared = Arc::new(Shared::default());
        let of_reader = Arc::clone(&shared);
        let read = move || {
            let ended = read(source.as_mut(), conventions, &of_reader);
            let mut state = of_reader.lock();
            state.ended = Some(ended);
            of_reader.changed.notify_all();
        };
        let thread = std::thread::Builder::new().name("source".to_owned()).spawn(read);
        thread.map_err(|error| SourceError::io("source", "no thread can be started", &error))?;
        Ok(Self { shared })
    }

    /// What has come, waiting for it no longer than `patience`.
    ///
    /// # Errors
    /// The source failed; what came before that has been handed on.
    pub fn next(&self, patience: Duration) -> Result<Batch<S>, SourceError> {
        let waiting = |state: &mut State<S>| state.queue.is_empty() && state.ended.is_none();
        let locked = self.shared.changed.wait_timeout_while(self.shared.lock(), patience, waiting);
        let (mut state, _) = locked.unwrap_or_else(PoisonError::into_inner);
        let samples: Vec<S> = state.queue.drain(..).collect();
        let ended = if samples.is_empty() { state.ended.clone() } else { None };
        drop(state);
        self.shared.changed.notify_all();
        match ended {
            Some(ended) => ended.map(|()| Batch::End),
            None => Ok(Batch::Samples(samples)),
        }
    }

    /// What was lost so far.
    pub fn losses(&self) -> Losses {
        let state = self.shared.lock();
        let mut losses = state.losses;
        losses += Losses { overflowed: state.overflowed, ..Losses::default() };
        losses
    }

    /// What the source says of its rig: all it ever will when the first sample is there.
    pub fn rig(&self) -> Option<S::Rig> {
        self.shared.lock().rig
    }

    /// What was wrong with the first line or message that was left out, where the source says so.
    pub fn first_fault(&self) -> Option<String> {
        self.shared.lock().first_fault.clone()
    }
}

impl<S: RigSample> Drop for Stream<S> {
    fn drop(&mut self) {
        self.shared.lock().abandoned = true;
        self.shared.changed.notify_all();
    }
}

fn read<S: RigSample>(
    source: &mut dyn Source<S>,
    stated: Option<S::Conventions>,
    shared: &Shared<S>,
) -> Result<(), SourceError> {
    let mut gate = Gate::<S>::new(stated.unwrap_or_default());
    let has_room = |state: &State<S>| state.queue.len() < QUEUE_SAMPLES;
    loop {
        let arrival = source.next();
        if shared.lock().rig.is_none()
            && let Some(rig) = source.rig()
        {
            // Known before the first sample.
            if stated.is_none() {
                gate = Gate::new(S::conventions(&rig));
            }
            shared.lock().rig = Some(rig);
        }
        let admitted = match arrival {
            Ok(Arrival::Sample(sample)) => gate.admit(sample),
            _ => None,
        };
        let mut state = shared.lock();
        state.losses = source.losses();
        state.losses += gate.losses();
        if state.first_fault.is_none() && !state.losses.is_none() {
            state.first_fault = source.first_fault();
        }
        if let Some(sample) = admitted {
            if source.overflow() == Overflow::Waits {
                let full = |state: &mut State<S>| !has_room(state) && !state.abandoned;
                state = shared.changed.wait_while(state, full).unwrap_or_else(PoisonError::into_inner);
            } else if !has_room(&state) {
                state.queue.pop_front();
                state.overflowed += 1;
            }
            state.queue.push_back(sample);
            shared.changed.notify_all();
        }
        if state.abandoned {
            return Ok(());
        }
        match arrival {
            Err(error) => return Err(error),
            Ok(Arrival::End) => return Ok(()),
            Ok(Arrival::Sample(_) | Arrival::Nothing) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::palms::PalmPair;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Longer than any machine takes.
    const FOREVER: Duration = Duration::from_secs(600);

    struct Counting {
        given: Arc<AtomicUsize>,
        count: usize,
        overflow: Overflow,
    }

    impl Source for Counting {
        fn next(&mut self) -> Result<Arrival, SourceError> {
            let index = self.given.load(Ordering::SeqCst);
            if index == self.count {
                return Ok(Arrival::End);
            }
            self.given.store(index + 1, Ordering::SeqCst);
            Ok(Arrival::Sample(Sample::new(index as f64, PalmPair::hinged(1.0, 1.2), 0.03, 0.03)))
        }

        fn losses(&self) -> Losses {
            Losses::default()
        }

        fn overflow(&self) -> Overflow {
            self.overflow
        }
    }

    fn start(count: usize, overflow: Overflow) -> (Stream, Arc<AtomicUsize>) {
        let given = Arc::new(AtomicUsize::new(0));
        let source = Counting { given: Arc::clone(&given), count, overflow };
        (Stream::start(Box::new(source), None).expect("a thread"), given)
    }

    fn all(stream: &Stream) -> Vec<f64> {
        let mut times = Vec::new();
        while let Batch::Samples(samples) = stream.next(FOREVER).expect("a source without faults") {
            times.extend(samples.iter().map(|sample| sample.time_s));
        }
        times
    }

    #[test]
    fn a_source_that_waits_loses_nothing_and_runs_no_farther_than_the_queue() {
        let count = 3 * QUEUE_SAMPLES;
        let (stream, given) = start(count, Overflow::Waits);
        while given.load(Ordering::SeqCst) <= QUEUE_SAMPLES {
            std::thread::yield_now();
        }
        assert!(stream.shared.lock().queue.len() <= QUEUE_SAMPLES);
        assert_eq!(given.load(Ordering::SeqCst), QUEUE_SAMPLES + 1);
        assert_eq!(all(&stream), (0..count).map(|index| index as f64).collect::<Vec<_>>());
        assert!(stream.losses().is_none());
    }

    #[test]
    fn of_a_source_that_cannot_wait_the_oldest_samples_are_dropped_and_counted() {
        let count = QUEUE_SAMPLES + 1000;
        let (stream, _) = start(count, Overflow::DropsOldest);
        while stream.shared.lock().ended.is_none() {
            std::thread::yield_now();
        }
        let times = all(&stream);
        assert_eq!((times.len(), times[0], stream.losses().overflowed), (QUEUE_SAMPLES, 1000.0, 1000));
    }
}
