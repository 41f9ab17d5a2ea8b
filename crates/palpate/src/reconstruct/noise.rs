//! How noisy the contact positions are, told from the log alone, before any shape is known.
//!
//! Third differences of neighbouring samples cancel every smooth motion and leave the noise (√20 times over). Readings on a
//! lattice (a touchpad's counts, or digits cut off in a file) have at least the standard deviation of their step, q/√12.

use super::problem::{Instant, Problem};

/// Standard deviation of one contact position in metres, estimated from the scatter of neighbouring samples.
pub(super) fn contact_scatter_m(problem: &Problem) -> f64 {
    let scatter = third_difference_scatter(problem, [|i| i.s1, |i| i.s2]);
    let lattice = lattice_m(problem, |i| i.s1).max(lattice_m(problem, |i| i.s2));
    scatter.max(lattice / 12f64.sqrt())
}

/// Standard deviation of a palm angle in radians, estimated in the same way.
pub(super) fn angle_scatter_rad(problem: &Problem) -> f64 {
    third_difference_scatter(problem, [|i| i.phi1, |i| i.phi1 + i.phi2])
}

fn third_difference_scatter(problem: &Problem, channels: [fn(&Instant) -> f64; 2]) -> f64 {
    let mut differences: Vec<f64> = Vec::new();
    for window in problem.instants.windows(4) {
        if window.iter().all(Instant::both_seen) {
            for value in channels {
                let [a, b, c, d] = [0, 1, 2, 3].map(|index| value(&window[index]));
                differences.push((d - 3.0 * c + 3.0 * b - a).abs());
            }
        }
    }
    // Root mean square of the smaller four fifths: leaps do not count, and readings on a lattice do no harm as they do to a
    // median. Of a normal distribution that is 0.6616 of the standard deviation; third differences spread by √(1 + 9 + 9 + 1).
    differences.sort_by(f64::total_cmp);
    differences.truncate(differences.len() * 4 / 5);
    let mean_square = differences.iter().map(|d| d * d).sum::<f64>() / differences.len().max(1) as f64;
    mean_square.sqrt() / 0.6616 / 20f64.sqrt()
}

/// The step of the lattice that all readings lie on, or 0 when there is none.
fn lattice_m(problem: &Problem, s: fn(&Instant) -> f64) -> f64 {
    let mut values: Vec<f64> = problem.instants.iter().filter(|i| i.both_seen()).map(s).collect();
    values.sort_by(f64::total_cmp);
    let Some(&first) = values.first() else { return 0.0 };
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > 1e-12).collect();
    if gaps.len() < 8 {
        return 0.0;
    }
    gaps.sort_by(f64::total_cmp);
    // The step is the commonest small gap; a rounding of the file's digits may blur it a little.
    let step = gaps[gaps.len() / 10];
    let on_lattice = values.iter().filter(|value| {
        let count = (*value - first) / step;
        (count - count.round()).abs() < 0.02 + 1e-3 * count.abs().min(100.0)
    });
    if on_lattice.count() * 100 >= values.len() * 98 { step } else { 0.0 }
}

/// Median; 0 for an empty list.
pub(super) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// By how much the errors of neighbouring samples hang together: the integrated autocorrelation time of the residuals of
/// one sensor, in samples; 1 for white noise. `N` correlated samples tell as much as `N`/τ independent ones.
pub(super) fn correlation_time(residuals: &[f64]) -> f64 {
    let count = residuals.len();
    let variance: f64 = residuals.iter().map(|e| e * e).sum();
    if count < 16 || variance <= 0.0 {
        return 1.0;
    }
    let mut tau = 1.0;
    for lag in 1..count / 4 {
        let products: f64 = residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum();
        tau += 2.0 * products / variance;
        // Sokal's window: stop once the lag is well beyond the time found so far.
        if lag as f64 >= 5.0 * tau {
            break;
        }
    }
    tau.max(1.0)
}
