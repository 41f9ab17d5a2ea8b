//! The log cut into windows short enough that a trial shape can follow the object through each of them.

use std::ops::Range;

use super::problem::Problem;
use super::quadrature::{feasible_heights, relative_height};

/// Thinned instants of one window, about.
const LENGTH: usize = 24;

/// Fewest thinned instants of a window; shorter pieces wait until the shape is known.
const SHORTEST: usize = 6;

/// A short run of thinned instants with no leap of a contact inside.
#[derive(Clone)]
pub(super) struct Window {
    /// Instants of the whole problem that it covers.
    pub range: Range<usize>,
    /// Means over neighbouring instants.
    pub thin: Problem,
    /// Nothing leaps between the window before and this one.
    pub joined: bool,
    /// Path length of the contacts in metres: how much there is to learn from the window.
    pub telling_m: f64,
    /// Samples per thinned instant.
    run: usize,
}

impl Window {
    /// `None` when the range is too short.
    fn new(problem: &Problem, range: Range<usize>, run: usize, joined: bool) -> Option<Self> {
        let whole = Problem { instants: problem.instants[range.clone()].to_vec() };
        let thin = whole.thinned_by(run);
        let telling_m = thin.instants.windows(2).map(|p| (p[1].s1 - p[0].s1).hypot(p[1].s2 - p[0].s2)).sum();
        (thin.len() >= SHORTEST).then_some(Self { range, thin, joined, telling_m, run })
    }

    /// The window cut in two, each looked at more closely; fewer where there is too little to look at.
    pub fn halves(&self, problem: &Problem) -> Vec<Self> {
        let Range { start, end } = self.range;
        let middle = start + (end - start) / 2;
        let run = (self.run / 2).max(1);
        let parts = [(start..middle, self.joined), (middle..end, true)];
        parts.into_iter().filter_map(|(range, joined)| Self::new(problem, range, run, joined)).collect()
    }
}

/// Windows of all pieces, in order of time; about `count` thinned instants in all.
pub(super) fn windows(problem: &Problem, pieces: &[Range<usize>], count: usize) -> Vec<Window> {
    let total: usize = pieces.iter().map(|range| range.len()).sum();
    let run = (total / count.max(1)).max(1);
    let mut windows = Vec::new();
    for piece in pieces {
        let run = run.min((piece.len() / SHORTEST).max(1));
        let share = (piece.len() / run).div_ceil(LENGTH).max(1);
        for part in 0..share {
            let range = piece.start + piece.len() * part / share..piece.start + piece.len() * (part + 1) / share;
            windows.extend(Window::new(problem, range, run, part > 0));
        }
    }
    windows
}

/// A run of joined windows that a start may begin with: whole pieces, their halves, quarters and so on.
pub(super) fn spans(windows: &[Window]) -> Vec<Range<usize>> {
    let mut whole = Vec::new();
    let mut start = 0;
    for index in 1..=windows.len() {
        if index == windows.len() || !windows[index].joined {
            whole.push(start..index);
            start = index;
        }
    }
    let mut spans = whole.clone();
    let mut parts = 2;
    while whole.iter().any(|piece| piece.len() >= parts) && parts <= 16 {
        for piece in whole.iter().filter(|piece| piece.len() >= parts) {
            spans.extend(
                (0..parts).map(|part| {
                    piece.start + piece.len() * part / parts..piece.start + piece.len() * (part + 1) / parts
                }),
            );
        }
        parts *= 2;
    }
    let telling = |span: &Range<usize>| windows[span.clone()].iter().map(|w| w.telling_m).sum::<f64>();
    spans.sort_by(|a, b| telling(b).total_cmp(&telling(a)));
    spans
}

/// The thinned instants of a run of windows.
pub(super) fn joined(windows: &[Window]) -> Problem {
    Problem { instants: windows.iter().flat_map(|window| window.thin.instants.iter().copied()).collect() }
}

/// Rise of the centre of mass along a run of instants and the heights at its first that are possible.
pub(super) fn heights(thin: &Problem, size_m: f64) -> Option<(Vec<f64>, (f64, f64))> {
    let relative = relative_height(thin);
    let range = feasible_heights(thin, &relative, size_m)?;
    Some((relative, range))
}
