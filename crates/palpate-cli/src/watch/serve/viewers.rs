//! Whoever looks at the page: each gets the newest estimate when it can take one, and none that it missed.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::Value;

/// Frames that whoever comes late gets: five minutes at ten a second.
const PAST: usize = 3000;
/// Time between two outlines, frames.
const OUTLINE_EVERY: u64 = 5;
/// After so long without news a line is sent all the same, so that a viewer that is gone is noticed.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// What there is to see.
pub struct Viewers {
    title: String,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Frames so far, and the last of them.
    shown: u64,
    past: VecDeque<Arc<str>>,
    outline: Option<(u64, Arc<str>)>,
    end: Option<Arc<str>>,
}

impl Viewers {
    pub fn new(title: &str) -> Self {
        Self { title: Value::from(title).to_string(), state: Mutex::default(), changed: Condvar::new() }
    }

    /// The state is whole at every instant.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows a frame, and now and then an outline.
    pub fn show(&self, frame: &Value, outline: impl FnOnce() -> Option<Value>) {
        let frame: Arc<str> = frame.to_string().into();
        let mut state = self.lock();
        state.shown += 1;
        state.past.push_back(frame);
        if state.past.len() > PAST {
            state.past.pop_front();
        }
        if state.outline.is_none() || state.shown.is_multiple_of(OUTLINE_EVERY) {
            let shown = state.shown;
            if let Some(outline) = outline() {
                state.outline = Some((shown, outline.to_string().into()));
            }
        }
        drop(state);
        self.changed.notify_all();
    }

    /// There are no more frames.
    pub fn end(&self, told: &str) {
        self.lock().end = Some(Value::from(told).to_string().into());
        self.changed.notify_all();
    }

    /// Sends a viewer what there is to see until it is gone, or there is no more.
    pub fn send(&self, stream: &mut impl Write) -> io::Result<()> {
        event(stream, "title", &self.title)?;
        let (mut seen, mut seen_outline) = (0, 0);
        loop {
            let is_old = |state: &mut State| state.shown == seen && state.end.is_none();
            let waited = self.changed.wait_timeout_while(self.lock(), HEARTBEAT, is_old);
            let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
            let outline = state.outline.clone().filter(|(shown, _)| *shown > seen_outline);
            let past = if seen == 0 { state.past.iter().cloned().collect() } else { Vec::new() };
            let newest = state.past.back().filter(|_| state.shown > seen && seen > 0).cloned();
            let (shown, end) = (state.shown, state.end.clone());
            // Whatever the viewer does now, nobody waits for it.
            drop(state);
            if let Some((shown, outline)) = outline {
                seen_outline = shown;
                event(stream, "outline", &outline)?;
            }
            if !past.is_empty() {
                event(stream, "past", &format!("[{}]", past.join(",")))?;
            }
            match newest {
                Some(newest) => event(stream, "frame", &newest)?,
                None if past.is_empty() => stream.write_all(b":\n\n")?,
                None => {}
            }
            seen = shown;
            if let Some(end) = end {
                return event(stream, "end", &end);
            }
        }
    }
}

fn event(stream: &mut impl Write, name: &str, data: &str) -> io::Result<()> {
    stream.write_all(format!("event: {name}\ndata: {data}\n\n").as_bytes())?;
    stream.flush()
}
