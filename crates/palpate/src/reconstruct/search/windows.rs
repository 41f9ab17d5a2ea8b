//! The log cut into windows: short runs of thinned instants without a jump, over each of which a trial shape can be followed
//! (`docs/theory.md`, the search).

use crate::estimate::measurements::Measurements;
use crate::estimate::thinning::{Thinning, most_instants};
use std::ops::Range;

/// Thinned instants of one window, up to twice as many: fewer do not determine its pose, more hide more jumps and cost more.
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
    /// How its samples were thinned, and the runs of them that made an instant each.
    thinning: Thinning,
    runs: Vec<Range<usize>>,
}

impl Window {
    /// `None` when there are too few runs.
    fn new(measurements: &Measurements, runs: &[Range<usize>], thinning: Thinning, joined: bool) -> Option<Self> {
        let thin = measurements.means(runs);
        let path_length_m = thin.instants.windows(2).map(|p| (p[1].s1 - p[0].s1).hypot(p[1].s2 - p[0].s2)).sum();
        let range = runs.first()?.start..runs.last()?.end;
        let runs = runs.to_vec();
        (thin.len() >= SHORTEST).then_some(Self { range, thin, joined, path_length_m, thinning, runs })
    }

    /// The same window of the same log, corrected otherwise.
    pub fn of(&self, measurements: &Measurements) -> Self {
        Self { thin: measurements.means(&self.runs), ..self.clone() }
    }

    /// The window cut before one of its instants; a part that is too short is dropped.
    pub fn cut(&self, measurements: &Measurements, instant: usize) -> [Option<Self>; 2] {
        let (first, second) = self.runs.split_at(instant.min(self.runs.len()));
        [(first, self.joined), (second, true)]
            .map(|(runs, joined)| Self::new(measurements, runs, self.thinning, joined))
    }

    /// The window cut in two halves, each thinned half as much; halves that are too short are dropped.
    pub fn halves(&self, measurements: &Measurements) -> Vec<Self> {
        let thinning = self.thinning.finer();
        let runs = thinning.runs(measurements, &self.range);
        let (first, second) = runs.split_at(runs.len() / 2);
        let parts = [(first, self.joined), (second, true)];
        parts.into_iter().filter_map(|(runs, joined)| Self::new(measurements, runs, thinning, joined)).collect()
    }
}

/// Windows of all segments, in order of time; about `count` thinned instants in all.
pub(crate) fn windows(
    measurements: &Measurements,
    segments: &[Range<usize>],
    noise_m: f64,
    count: usize,
) -> Vec<Window> {
    let thinning = Thinning::to(measurements, segments, noise_m, count);
    let mut windows = Vec::new();
    for segment in segments {
        let thinning = thinning.at_most(segment.len() / SHORTEST);
        let runs = thinning.runs(measurements, segment);
        let share = (runs.len() / LENGTH).max(1);
        for part in 0..share {
            let of_part = &runs[runs.len() * part / share..runs.len() * (part + 1) / share];
            windows.extend(Window::new(measurements, of_part, thinning, part > 0));
        }
    }
    part_without_jumps(windows, most_instants(count))
}

/// The windows in a row that have the fewest jumps between them, of those with so many instants at most: a long log is searched in part. The
/// shape of a part tells where the object is in the rest.
fn part_without_jumps(windows: Vec<Window>, most: usize) -> Vec<Window> {
    let part = |first: usize| {
        let instants = windows[first..].iter().scan(0, |sum, window| {
            *sum += window.thin.len();
            (*sum <= most).then_some(())
        });
        first..first + instants.count()
    };
    let jumps = |part: &Range<usize>| windows[part.clone()].iter().skip(1).filter(|window| !window.joined).count();
    // One that begins later and reaches the end of the log is shorter than it may be.
    let parts =
        (0..windows.len()).map(part).filter(|part| !part.is_empty() && (part.start == 0 || part.end < windows.len()));
    match parts.min_by_key(jumps) {
        Some(part) => windows[part].to_vec(),
        None => windows,
    }
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

/// The thinned instants of a run of windows, of these measurements.
pub(crate) fn joined(measurements: &Measurements, windows: &[Window]) -> Measurements {
    measurements.of(windows.iter().flat_map(|window| window.thin.instants.iter().copied()).collect())
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
        let windows = windows(&measurements, &segments, 0.0, 250);
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
            let windows = windows(&measurements, std::slice::from_ref(&(0..measurements.len())), 0.0, count);
            let instants: usize = windows.iter().map(|window| window.thin.len()).sum();
            assert!(instants >= count / 2 && instants <= count * 3 / 2, "{instants} of {count}");
            assert!(windows.iter().all(|window| window.thin.len() >= SHORTEST));
        }
    }

    #[test]
    fn of_a_log_that_moves_too_much_the_part_with_the_fewest_jumps_is_searched() {
        let measurements = measurements();
        let (count, segments) = (40, [0..60, 60..90, 90..130, 130..measurements.len()]);
        let part = windows(&measurements, &segments, 0.0, count);
        let instants: usize = part.iter().map(|window| window.thin.len()).sum();
        assert!(instants <= most_instants(count) && instants > count / 2, "{instants}");
        assert!(part[0].range.start >= 130 && part[part.len() - 1].range.end < measurements.len());
        assert!(part[1..].iter().all(|window| window.joined));
        assert!(part.windows(2).all(|pair| pair[0].range.end == pair[1].range.start));
        let whole = windows(&measurements, &segments, 0.0, 500);
        assert_eq!((whole[0].range.start, whole[whole.len() - 1].range.end), (0, measurements.len()));
    }

    #[test]
    fn halves_are_thinned_less() {
        let measurements = measurements();
        let whole = windows(&measurements, std::slice::from_ref(&(100..196)), 0.0, 24).remove(0);
        let halves = whole.halves(&measurements);
        assert_eq!(halves.len(), 2);
        assert_eq!((halves[0].range.start, halves[1].range.end), (100, 196));
        assert_eq!(halves[0].range.end, halves[1].range.start);
        assert_eq!(halves.iter().map(|half| half.joined).collect::<Vec<_>>(), [false, true]);
        let instants: usize = halves.iter().map(|half| half.thin.len()).sum();
        assert!(instants > whole.thin.len(), "{instants} of {}", whole.thin.len());
        let of = |samples: usize| windows(&measurements, std::slice::from_ref(&(0..samples)), 0.0, samples);
        assert!(of(SHORTEST)[0].halves(&measurements).is_empty());
        assert!(of(SHORTEST - 1).is_empty());
    }

    #[test]
    fn spans_are_ordered_by_path_length_and_stay_within_segments() {
        let measurements = measurements();
        let windows = windows(&measurements, &[0..300, 300..measurements.len()], 0.0, 250);
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
