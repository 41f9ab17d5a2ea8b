//! The likelihood along both coefficients of friction, each contact mode found anew: where modes give way, the log tells less of friction, and of
//! the centre of mass with it, than the equations with the modes as they are.
//!
//! Both coefficients are held off the optimum along the axes of their covariance, ever further while the likelihood hardly falls. What the fall
//! leaves of the information stands for the error bars: the posterior spreads as the profile does (profile likelihood, integrated over what was
//! followed). A likelier optimum takes the place of the present one.

use super::{ROUNDS, Setting, Settled, UPDATES};
use crate::estimate::friction::problem::Unknowns;
use crate::estimate::friction::smoother::{FrictionNoise, Optimum};
use nalgebra::{DVector, Matrix2, Vector2};
use rayon::prelude::*;

/// Standard deviations that the coefficients are held off at first, each further one twice as far, and how many at most.
const NEAREST: f64 = 3.0;
const DOUBLED: usize = 5;

/// Fall of the ln likelihood at two standard deviations: the profile is followed to there, beyond which little of the posterior is left.
const FOLLOWED: f64 = 2.0;

/// What of a fall is not believed: modes that are found anew leave the profile uneven, typically by this.
const UNEVEN: f64 = 1.0;

/// Least fall that is believed of the last place: at one standard deviation.
const ONE_SD: f64 = 0.5;

/// Midpoints on each side of the integral over a profile, which is followed beyond the last place for so many of its standard deviations.
const MIDPOINTS: usize = 400;
const TAIL_SDS: f64 = 4.0;

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
        let all = profile.iter().flat_map(|(_, sides)| sides.iter().flatten());
        let likeliest = all.min_by(|a, b| a.fall.total_cmp(&b.fall)).filter(|held| held.fall < -LIKELIER);
        let released = likeliest.filter(|_| replaced < REPLACED).and_then(|held| setting.released(&held.settled));
        replaced += 1;
        match released.filter(|other| other.missed_at(settled.optimum.noise) < settled.missed() - LIKELIER) {
            Some(other) => settled = other,
            None => {
                settled.confine();
                for (axis, sides) in profile {
                    let [less, more] =
                        sides.map(|side| side.iter().map(|held| (held.away_sds, held.fall)).collect::<Vec<_>>());
                    settled.optimum.loosen(&axis, widening([&less, &more]));
                }
                return settled;
            }
        }
    }
}

/// By how much a standard deviation is larger than the equations say, at least 1: the root mean square of the distance from the optimum, where the
/// likelihood falls as on both sides of it (distances in standard deviations, increasing, and how far its ln falls there).
fn widening(sides: [&[(f64, f64)]; 2]) -> f64 {
    let top = sides.iter().copied().flatten().fold(0.0, |top: f64, (_, fall)| top.min(*fall));
    let moments = sides.map(|side| moments(side, top));
    let [mass, square] = [0, 1].map(|power| moments.iter().map(|of_side| of_side[power]).sum::<f64>());
    (square / mass).sqrt().max(1.0)
}

/// Integrals of the likelihood over that at the top, and of it times the square of the distance, on one side of the optimum.
fn moments(side: &[(f64, f64)], top: f64) -> [f64; 2] {
    let standard = [(1.0, ONE_SD)];
    let side = if side.is_empty() { &standard[..] } else { side };
    let believed = |fall: f64| (fall - top - UNEVEN).max(0.0);
    let (farthest, last) = side[side.len() - 1];
    // Before the first place and beyond the last it falls as that of a Gaussian.
    let parabola = |x: f64, (away, fall): (f64, f64)| fall * (x / away).powi(2);
    let beyond = (farthest, believed(last).max(ONE_SD));
    let here = believed(0.0);
    let fall = |x: f64| match side.iter().position(|(away, _)| x <= *away) {
        Some(0) => here + parabola(x, (side[0].0, believed(side[0].1) - here)),
        Some(next) => {
            let [(from, fell), (to, falls)] = [side[next - 1], side[next]];
            let [fell, falls] = [fell, falls].map(believed);
            fell + (falls - fell) * (x - from) / (to - from)
        }
        None => parabola(x, beyond),
    };
    let reach = farthest * (1.0 + TAIL_SDS / (2.0 * beyond.1).sqrt());
    let step = reach / MIDPOINTS as f64;
    let places = (0..MIDPOINTS).map(|index| (index as f64 + 0.5) * step);
    places.fold([0.0; 2], |[mass, square], x| {
        let share = step * (-fall(x)).exp();
        [mass + share, square + share * x * x]
    })
}

/// The profile along each axis of the covariance of both coefficients, to both sides.
fn profile(setting: &Setting, settled: &Settled) -> Vec<(Vector2<f64>, [Vec<Held>; 2])> {
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
    let mut side = || held.next().unwrap_or_default();
    [0, 1].map(|axis| (axes.eigenvectors.column(axis).into_owned(), [side(), side()])).into()
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
        if fall > FOLLOWED {
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
    use super::{FOLLOWED, NEAREST, UNEVEN, widening};

    fn symmetric(side: &[(f64, f64)]) -> f64 {
        widening([side, side])
    }

    #[test]
    fn a_profile_as_the_equations_have_it_widens_nothing() {
        let gaussian = (NEAREST, UNEVEN + 0.5 * NEAREST * NEAREST);
        assert!((symmetric(&[gaussian]) - 1.0).abs() < 1e-2);
        assert!((symmetric(&[]) - 1.0).abs() < 1e-2);
        // A steeper one neither: contact modes never tell more than their equations.
        assert_eq!(symmetric(&[(NEAREST, 20.0)]), 1.0);
        // One that is twice as wide, however far it was followed.
        let twice = |away: f64| (away, UNEVEN + 0.125 * away * away);
        assert!((symmetric(&[twice(6.0)]) - 2.0).abs() < 1e-2);
        assert!((symmetric(&[twice(3.0), twice(6.0), twice(12.0)]) - 2.0).abs() < 0.4);
    }

    #[test]
    fn a_flat_profile_is_as_wide_as_it_is_long() {
        // An even distribution over ±6 standard deviations.
        assert!((symmetric(&[(3.0, 0.0), (6.0, 0.0), (6.1, 40.0)]) - 6.0 / 3.0_f64.sqrt()).abs() < 0.1);
        // Where the place of the top is another one, the distance to it counts.
        assert!(widening([&[(3.0, -8.0), (6.0, 8.0)], &[(3.0, 8.0)]]) > 2.5);
    }

    #[test]
    fn an_uneven_profile_hardly_changes_the_width() {
        let [lower, higher] =
            [-0.5 * UNEVEN, 0.5 * UNEVEN].map(|more| symmetric(&[(3.0, 0.5), (6.0, 4.0 * FOLLOWED + more)]));
        assert!(higher <= lower && lower < 1.1 * higher, "{lower} {higher}");
        // What falls by no more is no fall.
        assert_eq!(symmetric(&[(3.0, UNEVEN), (6.0, 20.0)]), symmetric(&[(3.0, 0.0), (6.0, 20.0)]));
        assert!(symmetric(&[(3.0, 2.0 * UNEVEN), (6.0, 20.0)]) < symmetric(&[(3.0, UNEVEN), (6.0, 20.0)]));
    }
}
