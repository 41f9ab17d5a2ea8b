//! The rotation (and translation) that best lays a reconstructed support function over the true one, in least squares:
//! with the true frame turned by α against the reconstructed one, r(θ) ≈ r_true(θ − α) + x cos θ + y sin θ.

use std::f64::consts::TAU;

use crate::shape::SupportFunction;

/// Rotations tried over the whole circle.
const TURNS: usize = 720;

/// Entries of the table used for that.
const TABLE: usize = 2880;

/// A felt point of the reconstructed support function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Felt {
    pub theta_rad: f64,
    pub r_m: f64,
}

/// A best fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alignment {
    pub angle_rad: f64,
    pub rms_m: f64,
}

/// The best alignment: from `start_rad` (where the motions agree) and from every local minimum over the circle. Where
/// several fit equally well, as for a symmetric object, the one near `start_rad`.
pub(super) fn best(felt: &[Felt], truth: &SupportFunction, start_rad: f64, with_translation: bool) -> Alignment {
    let rms = |angle: f64| misfit(felt, |theta| truth.radius_m(theta), angle, with_translation);
    let step = TAU / TURNS as f64;
    // Over the whole circle a table does.
    let table: Vec<f64> = (0..=TABLE).map(|entry| truth.radius_m(TAU * entry as f64 / TABLE as f64)).collect();
    let looked_up = |theta: f64| {
        let place = theta.rem_euclid(TAU) / TAU * TABLE as f64;
        let entry = (place as usize).min(TABLE - 1);
        table[entry] + (table[entry + 1] - table[entry]) * (place - entry as f64)
    };
    let coarse: Vec<f64> =
        (0..TURNS).map(|turn| misfit(felt, looked_up, start_rad + step * turn as f64, with_translation)).collect();
    let mut best = refined(&rms, start_rad, step);
    let mut minima: Vec<usize> = (0..TURNS)
        .filter(|&turn| {
            coarse[turn] <= coarse[(turn + TURNS - 1) % TURNS] && coarse[turn] <= coarse[(turn + 1) % TURNS]
        })
        .collect();
    minima.sort_by(|a, b| coarse[*a].total_cmp(&coarse[*b]));
    for turn in minima.into_iter().take(6) {
        let other = refined(&rms, start_rad + step * turn as f64, step);
        if other.rms_m < best.rms_m * (1.0 - 1e-6) - 1e-15 {
            best = other;
        }
    }
    best
}

/// Golden section search within two steps of `start_rad`.
fn refined(rms: &impl Fn(f64) -> f64, start_rad: f64, step: f64) -> Alignment {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (start_rad - 2.0 * step, start_rad + 2.0 * step);
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_left, mut at_right) = (rms(left), rms(right));
    for _ in 0..60 {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = rms(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = rms(right);
        }
    }
    let angle_rad = 0.5 * (low + high);
    Alignment { angle_rad, rms_m: rms(angle_rad) }
}

/// RMS of the residuals at the rotation `angle_rad`, after the best translation if asked.
fn misfit(felt: &[Felt], truth: impl Fn(f64) -> f64, angle_rad: f64, with_translation: bool) -> f64 {
    let residual = |point: &Felt| point.r_m - truth(point.theta_rad - angle_rad);
    let count = felt.len() as f64;
    if !with_translation {
        return (felt.iter().map(|point| residual(point).powi(2)).sum::<f64>() / count).sqrt();
    }
    let (mut cc, mut cs, mut ss, mut ce, mut se) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let residuals: Vec<(f64, f64, f64)> = felt
        .iter()
        .map(|point| {
            let ((sin, cos), e) = (point.theta_rad.sin_cos(), residual(point));
            cc += cos * cos;
            cs += cos * sin;
            ss += sin * sin;
            ce += cos * e;
            se += sin * e;
            (cos, sin, e)
        })
        .collect();
    let determinant = cc * ss - cs * cs;
    let (x, y) = if determinant > 1e-12 * count * count {
        ((ss * ce - cs * se) / determinant, (cc * se - cs * ce) / determinant)
    } else {
        (0.0, 0.0)
    };
    (residuals.iter().map(|(cos, sin, e)| (e - x * cos - y * sin).powi(2)).sum::<f64>() / count).sqrt()
}
