//! The view of a terminal: a few lines that are drawn anew, or, where the output is no terminal, a line now and then.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::time::Instant;

use palpate::live::{Estimate, Stage};
use palpate::pivot::StrokesEstimate;
use palpate::reconstruct::OutlinePoint;
use palpate::shape::SupportFunction;
use palpate_live::Losses;

use crate::terminal::{Failure, print};

/// Columns of the curve of ψ, and of the boundary.
const COLUMNS: usize = 48;
/// Time that the curve covers, seconds.
const CURVE_S: f64 = 20.0;
/// Heights of the curve.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// To the beginning of the line, and everything below cleared.
const CLEAR_BELOW: &str = "\r\x1b[J";

/// What is shown.
pub struct View {
    is_shown: bool,
    is_terminal: bool,
    /// Times and orientations of the curve.
    psi: VecDeque<(f64, Option<f64>)>,
    /// When the first sample came, and how many did since the last view.
    since: Instant,
    samples: u64,
    rate_hz: f64,
    lines: usize,
}

impl View {
    /// One that is shown or not, on a terminal or not.
    pub fn new(is_shown: bool, is_terminal: bool) -> Self {
        Self { is_shown, is_terminal, psi: VecDeque::new(), since: Instant::now(), samples: 0, rate_hz: 0.0, lines: 0 }
    }

    /// Whether it is drawn anew in place.
    pub fn is_redrawn(&self) -> bool {
        self.is_terminal
    }

    /// Samples a second, by the clock.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Takes the time of a sample and its orientation into the curve.
    pub fn take(&mut self, time_s: f64, psi_rad: Option<f64>) {
        self.samples += 1;
        let elapsed_s = self.since.elapsed().as_secs_f64();
        if elapsed_s >= 1.0 {
            (self.rate_hz, self.samples, self.since) = (self.samples as f64 / elapsed_s, 0, Instant::now());
        }
        if self.psi.back().is_none_or(|(newest_s, _)| time_s - newest_s >= CURVE_S / COLUMNS as f64) {
            self.psi.push_back((time_s, psi_rad));
            if self.psi.len() > COLUMNS {
                self.psi.pop_front();
            }
        }
    }

    /// Shows what is known.
    pub fn show<'a>(&mut self, seen: impl FnOnce() -> Seen<'a>, losses: Losses) -> Result<(), Failure> {
        if !self.is_shown {
            return Ok(());
        }
        if !self.is_terminal {
            return print(&seen().line());
        }
        let text = self.text(&seen(), losses);
        let up = if self.lines > 0 { format!("\x1b[{}A", self.lines) } else { String::new() };
        self.lines = text.lines().count();
        print(&format!("{up}{CLEAR_BELOW}{text}"))
    }

    fn text(&self, seen: &Seen, losses: Losses) -> String {
        let mut text = String::new();
        // Writing into a text cannot fail.
        let _ = writeln!(
            text,
            "  {:.1} s, {} samples, {:.0} a second; lost: {losses}",
            seen.time_s, seen.samples, self.rate_hz
        );
        if let Some(psi) = seen.psi_and_sd_rad {
            let [psi, sd] = psi.map(f64::to_degrees);
            let _ = writeln!(text, "  ψ       {} {psi:.2}° ± {sd:.2}°", curve(&self.psi));
        }
        if let Some(center) = seen.center_and_sd_m {
            let [x, y, sd] = center.map(|length_m| 1e3 * length_m);
            let _ = writeln!(text, "  centre  {x:.2}, {y:.2} mm ± {sd:.3} mm");
        }
        if let Some(perimeter_m) = seen.perimeter_m {
            let felt = 100.0 * seen.coverage;
            let _ = writeln!(text, "  felt    {} {felt:.0} %", boundary(seen.outline));
            let [around, sd] = [perimeter_m, seen.r_sd_m].map(|length_m| 1e3 * length_m);
            let _ = writeln!(text, "  shape   {around:.2} mm around, boundary ± {sd:.3} mm");
        }
        text.push_str("  ");
        text.push_str(&seen.verdict);
        text
    }
}

/// What the view shows of an estimate, of either rig.
pub struct Seen<'a> {
    time_s: f64,
    samples: u64,
    psi_and_sd_rad: Option<[f64; 2]>,
    center_and_sd_m: Option<[f64; 3]>,
    perimeter_m: Option<f64>,
    r_sd_m: f64,
    outline: &'a [OutlinePoint],
    coverage: f64,
    verdict: String,
}

impl Seen<'_> {
    /// Time, and orientation where it is known, radians.
    pub fn time_and_psi(&self) -> (f64, Option<f64>) {
        (self.time_s, self.psi_and_sd_rad.map(|[psi_rad, _]| psi_rad))
    }

    /// Everything in one line.
    fn line(&self) -> String {
        let mut line = format!("{:.1} s, {} samples", self.time_s, self.samples);
        if let Some(psi) = self.psi_and_sd_rad {
            let [psi, sd] = psi.map(f64::to_degrees);
            let _ = write!(line, ", psi {psi:.2} ± {sd:.2} deg");
        }
        if self.perimeter_m.is_some() {
            let _ = write!(line, ", {:.0} % felt, r ± {:.3} mm", 100.0 * self.coverage, 1e3 * self.r_sd_m);
        }
        format!("{line}: {}", self.verdict)
    }
}

impl<'a> From<&'a Estimate> for Seen<'a> {
    fn from(estimate: &'a Estimate) -> Self {
        let pose = estimate.pose.as_ref();
        let certified = match (estimate.is_com_certified(), estimate.is_certified()) {
            (true, _) => Some("certified: shape, motion and centre of mass"),
            (false, true) => Some("certified: shape and motion, but not the centre of mass"),
            _ => None,
        };
        Self {
            time_s: estimate.time_s,
            samples: estimate.samples,
            psi_and_sd_rad: pose.map(|pose| [pose.psi_rad, pose.psi_sd_rad]),
            center_and_sd_m: pose.map(|pose| [pose.com_x_m, pose.com_y_m, pose.com_sd_m]),
            perimeter_m: estimate.shape.as_ref().map(SupportFunction::perimeter_m),
            r_sd_m: estimate.r_sd_m(),
            outline: &estimate.outline,
            coverage: estimate.coverage,
            verdict: verdict(certified, estimate.stage, || estimate.reason()),
        }
    }
}

impl<'a> From<&'a StrokesEstimate> for Seen<'a> {
    fn from(estimate: &'a StrokesEstimate) -> Self {
        let certified = estimate.is_certified().then_some("certified: shape about the pivot and motion");
        Self {
            time_s: estimate.time_s,
            samples: estimate.samples,
            psi_and_sd_rad: estimate.psi_rad.zip(estimate.psi_sd_rad).map(|(psi_rad, sd_rad)| [psi_rad, sd_rad]),
            center_and_sd_m: None,
            perimeter_m: estimate.shape.as_ref().map(SupportFunction::perimeter_m),
            r_sd_m: estimate.r_sd_m,
            outline: &estimate.outline,
            coverage: estimate.coverage,
            verdict: verdict(certified, estimate.stage, || estimate.reason()),
        }
    }
}

/// The verdict in words.
fn verdict(certified: Option<&str>, stage: Stage, reason: impl FnOnce() -> String) -> String {
    match (certified, stage) {
        (Some(certified), _) => certified.to_owned(),
        (None, Stage::Gathering) => "nothing is known yet: too few samples".to_owned(),
        (None, Stage::Searching) => format!("searching: {}", reason()),
        _ => format!("not certified: {}", reason()),
    }
}

/// A curve of ψ over the last seconds, between its least and its largest value.
fn curve(psi: &VecDeque<(f64, Option<f64>)>) -> String {
    let known = || psi.iter().filter_map(|(_, psi)| *psi);
    let (low, high) =
        known().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), psi| (low.min(psi), high.max(psi)));
    let bar = |psi: Option<f64>| {
        let share = psi.map(|psi| (psi - low) / (high - low).max(f64::MIN_POSITIVE));
        share.map_or(' ', |share| BARS[((share * BARS.len() as f64) as usize).min(BARS.len() - 1)])
    };
    let drawn: String = psi.iter().map(|(_, psi)| bar(*psi)).collect();
    format!("{drawn:<COLUMNS$}")
}

/// The boundary once round: what was felt, and what was not.
fn boundary(outline: &[OutlinePoint]) -> String {
    let mut felt = [0_usize; COLUMNS];
    let mut all = [0_usize; COLUMNS];
    for point in outline {
        let column = ((point.theta_rad / TAU * COLUMNS as f64) as usize).min(COLUMNS - 1);
        all[column] += 1;
        felt[column] += usize::from(point.touches > 0);
    }
    felt.iter().zip(all).map(|(felt, all)| if 2 * felt > all { '█' } else { '░' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn before_anything_is_known_it_says_so() {
        let (palms, strokes) = (Estimate::default(), StrokesEstimate::default());
        for seen in [Seen::from(&palms), Seen::from(&strokes)] {
            assert_eq!(seen.line(), "NaN s, 0 samples: nothing is known yet: too few samples");
            let text = View::new(true, true).text(&seen, Losses::default());
            assert_eq!(text.lines().count(), 2, "{text}");
        }
    }

    #[test]
    fn the_curve_has_gaps_where_nothing_is_known() {
        let psi = [None, Some(0.0), Some(0.5), Some(1.0)].into_iter().map(|psi| (0.0, psi)).collect();
        assert_eq!(curve(&psi).trim_end(), " ▁▅█");
        assert_eq!(curve(&psi).chars().count(), COLUMNS);
    }

    #[test]
    fn the_view_keeps_only_what_it_shows() {
        let mut view = View::new(true, true);
        for index in 0..10_000 {
            view.take(0.1 * f64::from(index), None);
        }
        assert_eq!(view.psi.len(), COLUMNS);
    }
}
