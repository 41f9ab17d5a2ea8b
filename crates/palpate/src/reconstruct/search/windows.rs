//! The log cut into windows: short runs of thinned instants without a jump, over each of which a trial shape can be followed
//! (`docs/theory.md`, the search).

use crate::estimate::measurements::Measurements;
use std::ops::Range;

/// Thinned instants of one window, about: fewer do not determine its pose, more hide more jumps and cost more.
const LENGTH: usize = 24;

/// Fewest thinned instants of a window; shorter segments are placed when the shape is known.
const SHORTEST: usize = 6;

/// A short run of thinned instants without a jump of a contact inside.
#[derive(Clone)]
pub(crate) struct Window {
    /// Instants of the whole problem that it covers.
    pub range: Range<usize>,
    /// Means over neighbouring instants.
    pub thin: Measurements,
    /// No contact jumps between the window before and this one.
    pub joined: bool,
    /// Path length of the contacts in metres: a measure of the information in the window.
    pub path_length_m: f64,
    /// Samples per thinned instant.
    run: usize,
}

impl Window {
    /// `None` when the range is too short.
    fn new(measurements: &Measurements, range: Range<usize>, run: usize, joined: bool) -> Option<Self> {
        let whole = Measurements { instants: measurements.instants[range.clone()].to_vec() };
        let thin = whole.thinned_by(run);
        let path_length_m = thin.instants.windows(2).map(|p| (p[1].s1 - p[0].s1).hypot(p[1].s2 - p[0].s2)).sum();
        (thin.len() >= SHORTEST).then_some(Self { range, thin, joined, path_length_m, run })
    }

    /// The window cut in two halves, each thinned half as much; halves that are too short are dropped.
    pub fn halves(&self, measurements: &Measurements) -> Vec<Self> {
        let Range { start, end } = self.range;
        let middle = start + (end - start) / 2;
        let run = (self.run / 2).max(1);
        let parts = [(start..middle, self.joined), (middle..end, true)];
        parts.into_iter().filter_map(|(range, joined)| Self::new(measurements, range, run, joined)).collect()
    }
}

/// Windows of all segments, in order of time; about `count` thinned instants in all.
pub(crate) fn windows(measurements: &Measurements, segments: &[Range<usize>], count: usize) -> Vec<Window> {
    let total: usize = segments.iter().map(|range| range.len()).sum();
    let run = (total / count.max(1)).max(1);
    let mut windows = Vec::new();
    for segment in segments {
        let run = run.min((segment.len() / SHORTEST).max(1));
        let share = (segment.len() / run).div_ceil(LENGTH).max(1);
        for part in 0..share {
            let range =
                segment.start + segment.len() * part / share..segment.start + segment.len() * (part + 1) / share;
            windows.extend(Window::new(measurements, range, run, part > 0));
        }
    }
    windows
}

/// A segment is divided into at most so many spans.
const MOST_PARTS: usize = 16;

/// Runs of joined windows that may become seeds, longest contact path first: whole segments, their halves, quarters and so on.
pub(crate) fn spans(windows: &[Window]) -> Vec<Range<usize>> {
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
    while whole.iter().any(|segment| segment.len() >= parts) && parts <= MOST_PARTS {
        for segment in whole.iter().filter(|segment| segment.len() >= parts) {
            spans.extend((0..parts).map(|part| {
                segment.start + segment.len() * part / parts..segment.start + segment.len() * (part + 1) / parts
            }));
        }
        parts *= 2;
    }
    let path_length = |span: &Range<usize>| windows[span.clone()].iter().map(|w| w.path_length_m).sum::<f64>();
    spans.sort_by(|a, b| path_length(b).total_cmp(&path_length(a)));
    spans
}

/// The thinned instants of a run of windows.
pub(crate) fn joined(windows: &[Window]) -> Measurements {
    Measurements { instants: windows.iter().flat_map(|window| window.thin.instants.iter().copied()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    fn measurements() -> Measurements {
        let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(3, 20.0, 0.5).and_then(|motion| motion.sample(50.0)).expect("possible");
        let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
        Measurements::new(&run.log, None)
    }

    #[test]
    fn windows_cover_their_segments_and_never_cross_a_jump() {
        let measurements = measurements();
        let segments = [0..400, 400..430, 430..measurements.len()];
        let windows = windows(&measurements, &segments, 250);
        for segment in segments {
            let of: Vec<&Window> =
                windows.iter().filter(|w| segment.start <= w.range.start && w.range.end <= segment.end).collect();
            assert_eq!((of[0].range.start, of[of.len() - 1].range.end), (segment.start, segment.end));
            assert!(of.windows(2).all(|pair| pair[0].range.end == pair[1].range.start));
            // The first window of a segment comes after a jump; the others continue it.
            assert!(!of[0].joined && of[1..].iter().all(|window| window.joined));
        }
        let crossing =
            |w: &&Window| (w.range.start < 400 && w.range.end > 400) || (w.range.start < 430 && w.range.end > 430);
        assert_eq!(windows.iter().filter(crossing).count(), 0);
    }

    #[test]
    fn thinning_keeps_about_as_many_instants_as_asked_for() {
        let measurements = measurements();
        for count in [100, 250] {
            let windows = windows(&measurements, std::slice::from_ref(&(0..measurements.len())), count);
            let instants: usize = windows.iter().map(|window| window.thin.len()).sum();
            assert!(instants >= count * 4 / 5 && instants <= count * 3 / 2, "{instants} of {count}");
            assert!(windows.iter().all(|window| window.thin.len() >= SHORTEST));
        }
    }

    #[test]
    fn halves_are_thinned_less() {
        let measurements = measurements();
        let window = Window::new(&measurements, 100..196, 4, false).expect("long enough");
        let halves = window.halves(&measurements);
        assert_eq!(halves.iter().map(|half| half.range.clone()).collect::<Vec<_>>(), [100..148, 148..196]);
        assert_eq!(halves.iter().map(|half| half.joined).collect::<Vec<_>>(), [false, true]);
        assert!(halves.iter().all(|half| half.thin.len() == 24), "as many instants in each half as in the whole");
        let short = Window::new(&measurements, 0..SHORTEST, 1, false).expect("just long enough");
        assert!(short.halves(&measurements).is_empty());
        assert!(Window::new(&measurements, 0..SHORTEST - 1, 1, false).is_none());
    }

    #[test]
    fn spans_are_ordered_by_path_length_and_stay_within_segments() {
        let measurements = measurements();
        let windows = windows(&measurements, &[0..300, 300..measurements.len()], 250);
        let spans = spans(&windows);
        let path_length = |span: &Range<usize>| windows[span.clone()].iter().map(|w| w.path_length_m).sum::<f64>();
        assert!(spans.windows(2).all(|pair| path_length(&pair[0]) >= path_length(&pair[1])));
        for span in &spans {
            assert!(!span.is_empty());
            assert!(windows[span.start + 1..span.end].iter().all(|window| window.joined));
        }
        // Both whole segments are among them.
        let second = windows.iter().position(|window| window.range.start == 300).expect("a second segment");
        assert!(spans.contains(&(0..second)) && spans.contains(&(second..windows.len())));
    }
}
