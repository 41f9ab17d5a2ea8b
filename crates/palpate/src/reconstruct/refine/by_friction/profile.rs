//! The likelihood along both coefficients of friction, each contact mode found anew: where modes give way, the log tells less of friction, and of
//! the centre of mass with it, than the equations with the modes as they are.
//!
//! Both coefficients are held off the optimum along the axes of their covariance, ever further while the likelihood hardly falls. What the fall
//! leaves of the information stands for the error bars (profile likelihood); a likelier optimum takes the place of the present one.

use super::{ROUNDS, Setting, Settled, UPDATES};
use crate::estimate::friction::problem::Unknowns;
use crate::estimate::friction::smoother::{FrictionNoise, Optimum};
use nalgebra::{DVector, Matrix2, Vector2};
use rayon::prelude::*;

/// Standard deviations that the coefficients are held off at first, each further one twice as far, and how many at most.
const NEAREST: f64 = 3.0;
const DOUBLED: usize = 5;

/// Fall of the ln likelihood at one standard deviation: within it, the profile is followed further.
const ONE_SD: f64 = 0.5;

/// Rounds of fit and modes with coefficients that are held.
const HELD_ROUNDS: usize = 3;

/// Another optimum takes the place of the present one where it is likelier by this (3 standard deviations), so many times at most.
const LIKELIER: f64 = 4.5;
const REPLACED: usize = 2;

/// Coefficients that are held off the optimum, in standard deviations, and where fit and modes come to.
struct Held {
    away_sds: f64,
    /// ln of by how much less likely that is.
    fall: f64,
    settled: Settled,
}

/// The optimum with the information on friction that its profile leaves.
pub(super) fn profiled(setting: &Setting, mut settled: Settled) -> Settled {
    let mut replaced = 0;
    loop {
        let profile = profile(setting, &settled);
        let all = profile.iter().flat_map(|(_, held)| held);
        let likeliest = all.min_by(|a, b| a.fall.total_cmp(&b.fall)).filter(|held| held.fall < -LIKELIER);
        let released = likeliest.filter(|_| replaced < REPLACED).and_then(|held| setting.released(&held.settled));
        replaced += 1;
        match released.filter(|other| other.missed_at(settled.optimum.noise) < settled.missed() - LIKELIER) {
            Some(other) => settled = other,
            None => {
                profile.into_iter().for_each(|(axis, held)| settled.optimum.loosen(&axis, widening(&held)));
                return settled;
            }
        }
    }
}

/// By how much a standard deviation is larger than the equations say: the profile falls as that of a Gaussian no wider than this.
fn widening(profile: &[Held]) -> f64 {
    widening_of(&profile.iter().map(|held| (held.away_sds, held.fall)).collect::<Vec<_>>())
}

/// The same of distances in standard deviations, and how far the ln likelihood falls there.
fn widening_of(profile: &[(f64, f64)]) -> f64 {
    let top = profile.iter().fold(0.0, |top: f64, (_, fall)| top.min(*fall));
    let of = |(away_sds, fall): &(f64, f64)| away_sds / (2.0 * (fall - top).max(ONE_SD)).sqrt();
    profile.iter().map(of).fold(1.0, f64::max)
}

/// The profile along each axis of the covariance of both coefficients.
fn profile(setting: &Setting, settled: &Settled) -> Vec<(Vector2<f64>, Vec<Held>)> {
    let axes = settled.optimum.covariance_of_friction().symmetric_eigen();
    let sides: Vec<(usize, f64)> = [0, 1].into_iter().flat_map(|axis| [(axis, -1.0), (axis, 1.0)]).collect();
    let held: Vec<Vec<Held>> = sides
        .into_par_iter()
        .map(|(axis, side)| {
            let sd = axes.eigenvalues[axis].max(0.0).sqrt();
            side_of(setting, settled, axes.eigenvectors.column(axis) * (side * sd))
        })
        .collect();
    let mut held = held.into_iter();
    [0, 1]
        .map(|axis| {
            let both = held.by_ref().take(2).flatten().collect();
            (axes.eigenvectors.column(axis).into_owned(), both)
        })
        .into()
}

/// The profile to one side, in steps of one standard deviation.
fn side_of(setting: &Setting, settled: &Settled, sd: Vector2<f64>) -> Vec<Held> {
    let mut found = Vec::new();
    let mut away_sds = NEAREST;
    for _ in 0..DOUBLED {
        let friction = [0, 1].map(|palm| settled.optimum.unknowns.friction[palm] + away_sds * sd[palm]);
        let Some(there) = friction.iter().all(|mu| *mu >= 0.0).then(|| setting.held_at(settled, friction)).flatten()
        else {
            break;
        };
        let fall = there.missed_at(settled.optimum.noise) - settled.missed();
        found.push(Held { away_sds, fall, settled: there });
        if fall > ONE_SD {
            break;
        }
        away_sds *= 2.0;
    }
    found
}

impl Setting<'_> {
    /// Where fit and modes come to with these coefficients of friction.
    fn held_at(&self, from: &Settled, friction: [f64; 2]) -> Option<Settled> {
        let Optimum { unknowns, noise, .. } = &from.optimum;
        let setting = Setting { starts: &from.starts, ..*self };
        let start = (Unknowns { friction, ..unknowns.clone() }, from.regimes.clone());
        setting.settled_holding(Some(friction), start, *noise, (HELD_ROUNDS, UPDATES))
    }

    /// Where they come to from there when they are held no more.
    fn released(&self, from: &Settled) -> Option<Settled> {
        let Optimum { unknowns, noise, .. } = &from.optimum;
        let setting = Setting { starts: &from.starts, ..*self };
        setting.settled((unknowns.clone(), from.regimes.clone()), *noise, (ROUNDS, UPDATES))
    }
}

impl Optimum {
    fn covariance_of_friction(&self) -> Matrix2<f64> {
        let first = self.unknowns.coefficients.len();
        self.eliminated.covariance().fixed_view::<2, 2>(first, first).into_owned()
    }

    /// Makes the standard deviation of friction along an axis larger by a factor, and with it all that depends on it.
    fn loosen(&mut self, axis: &Vector2<f64>, factor: f64) {
        let first = self.unknowns.coefficients.len();
        let mut row = DVector::zeros(self.eliminated.information().nrows());
        (0..2).for_each(|palm| row[first + palm] = axis[palm]);
        self.eliminated.loosen(&row, factor);
    }
}

impl Settled {
    /// −ln of the likelihood with these standard deviations, up to a constant of the log.
    fn missed_at(&self, noise: FrictionNoise) -> f64 {
        self.optimum.cost_at(noise) + self.of_noise(noise)
    }
}

#[cfg(test)]
mod tests {
    use super::{LIKELIER, NEAREST, ONE_SD, widening_of};

    #[test]
    fn a_profile_as_the_equations_have_it_widens_nothing() {
        let gaussian = [NEAREST, -NEAREST].map(|away_sds: f64| (away_sds.abs(), 0.5 * away_sds * away_sds));
        assert!((widening_of(&gaussian) - 1.0).abs() < 1e-12);
        // A steeper one neither: contact modes never tell more than their equations.
        assert!((widening_of(&[(NEAREST, 20.0)]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_flat_profile_reaches_as_far_as_it_was_followed() {
        assert!((widening_of(&[(3.0, 0.1), (6.0, 0.2), (12.0, 40.0)]) - 6.0).abs() < 1e-12);
        // Where another place is likelier, that is the top.
        assert!((widening_of(&[(3.0, -LIKELIER), (3.0, ONE_SD)]) - 3.0).abs() < 1e-12);
    }
}
