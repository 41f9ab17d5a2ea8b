//! The view of a terminal: a few lines that are drawn anew, or, where the output is no terminal, a line now and then.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::time::Instant;

use palpate::live::{Estimate, Stage};
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

    /// Takes an estimate into the curve.
    pub fn take(&mut self, estimate: &Estimate) {
        self.samples += 1;
        let newest = estimate.time_s;
        let elapsed_s = self.since.elapsed().as_secs_f64();
        if elapsed_s >= 1.0 {
            (self.rate_hz, self.samples, self.since) = (self.samples as f64 / elapsed_s, 0, Instant::now());
        }
        if self.psi.back().is_none_or(|(time_s, _)| newest - time_s >= CURVE_S / COLUMNS as f64) {
            self.psi.push_back((newest, estimate.pose.as_ref().map(|pose| pose.psi_rad)));
            if self.psi.len() > COLUMNS {
                self.psi.pop_front();
            }
        }
    }

    /// Shows an estimate.
    pub fn show(&mut self, estimate: &Estimate, losses: Losses) -> Result<(), Failure> {
        if !self.is_shown {
            return Ok(());
        }
        if !self.is_terminal {
            return print(&line(estimate));
        }
        let text = self.text(estimate, losses);
        let up = if self.lines > 0 { format!("\x1b[{}A", self.lines) } else { String::new() };
        self.lines = text.lines().count();
        print(&format!("{up}{CLEAR_BELOW}{text}"))
    }

    fn text(&self, estimate: &Estimate, losses: Losses) -> String {
        let mut text = String::new();
        let samples = estimate.samples;
        // Writing into a text cannot fail.
        let _ = writeln!(
            text,
            "  {:.1} s, {samples} samples, {:.0} a second; lost: {losses}",
            estimate.time_s, self.rate_hz
        );
        if let Some(pose) = &estimate.pose {
            let [psi, sd] = [pose.psi_rad, pose.psi_sd_rad].map(f64::to_degrees);
            let _ = writeln!(text, "  ψ       {} {psi:.2}° ± {sd:.2}°", curve(&self.psi));
            let [x, y, sd] = [pose.com_x_m, pose.com_y_m, pose.com_sd_m].map(|length_m| 1e3 * length_m);
            let _ = writeln!(text, "  centre  {x:.2}, {y:.2} mm ± {sd:.3} mm");
        }
        if let Some(shape) = &estimate.shape {
            let felt = 100.0 * estimate.coverage;
            let _ = writeln!(text, "  felt    {} {felt:.0} %", boundary(estimate));
            let [around, sd] = [shape.perimeter_m(), estimate.r_sd_m()].map(|length_m| 1e3 * length_m);
            let _ = writeln!(text, "  shape   {around:.2} mm around, boundary ± {sd:.3} mm");
        }
        text.push_str("  ");
        text.push_str(&verdict(estimate));
        text
    }
}

/// Everything in one line.
fn line(estimate: &Estimate) -> String {
    let mut line = format!("{:.1} s, {} samples", estimate.time_s, estimate.samples);
    if let Some(pose) = &estimate.pose {
        let [psi, sd] = [pose.psi_rad, pose.psi_sd_rad].map(f64::to_degrees);
        let felt = 100.0 * estimate.coverage;
        let _ = write!(line, ", psi {psi:.2} ± {sd:.2} deg, {felt:.0} % felt, r ± {:.3} mm", 1e3 * estimate.r_sd_m());
    }
    format!("{line}: {}", verdict(estimate))
}

/// The verdict in words.
fn verdict(estimate: &Estimate) -> String {
    match estimate.stage {
        _ if estimate.is_com_certified() => "certified: shape, motion and centre of mass".to_owned(),
        _ if estimate.is_certified() => "certified: shape and motion, but not the centre of mass".to_owned(),
        Stage::Gathering => "nothing is known yet: too few samples".to_owned(),
        Stage::Searching => format!("searching: {}", estimate.reason()),
        _ => format!("not certified: {}", estimate.reason()),
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
fn boundary(estimate: &Estimate) -> String {
    let mut felt = [0_usize; COLUMNS];
    let mut all = [0_usize; COLUMNS];
    for point in &estimate.outline {
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
        let estimate = Estimate::default();
        assert_eq!(line(&estimate), "NaN s, 0 samples: nothing is known yet: too few samples");
        let text = View::new(true, true).text(&estimate, Losses::default());
        assert_eq!(text.lines().count(), 2, "{text}");
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
        let mut estimate = Estimate::default();
        for index in 0..10_000 {
            estimate.time_s = 0.1 * f64::from(index);
            view.take(&estimate);
        }
        assert_eq!(view.psi.len(), COLUMNS);
    }
}
