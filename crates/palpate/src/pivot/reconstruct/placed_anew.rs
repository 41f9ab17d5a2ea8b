//! Contact angles that a fit has wrong, or has not, found anew: by the shape of the fit, or by that of the segments which its closed forms do not doubt.

use std::ops::Range;

use super::{FEWEST_SAMPLES, Prepared};
use crate::math::angle::{mean_direction, wrapped};
use crate::math::statistics::median;
use crate::pivot::calibration::Reading;
use crate::pivot::decode::{Decoding, decoded};
use crate::pivot::evidence::Fit;
use crate::pivot::motion_prior::{MotionPrior, leap_nats, lifted};
use crate::pivot::search::shape_given_angles;
use crate::pivot::smoother::{Noise, Optimum, State, curve_row};

/// A reading that is missed by so many standard deviations may be on the wrong branch: angles are decoded anew.
const ASTRAY_SDS: f64 = 5.0;

/// Closed forms and fit agree on a segment where their angles differ by less, radians.
const AGREED_RAD: f64 = 0.2;

impl Prepared<'_> {
    /// The state of all readings that are used, from a fit of some of them: the others are decoded by its shape.
    pub(super) fn completed(&self, others: &Self, fit: &Fit) -> Option<State> {
        let state = &fit.optimum.state;
        let mut known: Vec<Option<f64>> = vec![None; self.readings.len()];
        others.used().into_iter().zip(&state.theta_rad).for_each(|(index, theta)| known[index] = Some(*theta));
        let used = self.used();
        let measured = self.measured(used.iter().map(|&index| &self.readings[index]), state);
        let is_lifted = lifted(&self.readings, self.scatter.r_m);
        let decoding = Decoding {
            measured: &measured,
            leap_nats: &|place| leap_nats(is_lifted[used[place]]),
            known_rad: &|place| known[used[place]],
        };
        let variance = curve_variance(&fit.optimum, fit.order, fit.noise)?;
        // What is known bounds what is not.
        let ranges = self.ranges_of_used();
        let open: Vec<Range<usize>> =
            ranges.iter().flat_map(|range| between_known(range, &|place| known[used[place]].is_some())).collect();
        let mut theta_rad: Vec<f64> = used.iter().map(|&index| known[index].unwrap_or(0.0)).collect();
        let decoded = decoded(state, &decoding, &open, fit.noise, variance);
        for (place, decoded) in open.into_iter().flatten().zip(decoded) {
            theta_rad[place] = known[used[place]].unwrap_or(decoded);
        }
        for range in ranges {
            // The shorter way from one to the next, whole turns apart.
            for place in range.skip(1) {
                let before = theta_rad[place - 1];
                theta_rad[place] = before + wrapped(theta_rad[place] - before);
            }
        }
        Some(State { theta_rad, ..state.clone() })
    }

    /// Height and offset of readings, with the constants of the rig of a state.
    fn measured<'b>(&self, readings: impl IntoIterator<Item = &'b Reading>, state: &State) -> Vec<[f64; 2]> {
        let errors = self.options.rig.calibration.with_told(state.told);
        readings.into_iter().map(|reading| reading.measured(&errors)).map(|m| [m.r_m, m.d_m]).collect()
    }

    /// Whether a reading may be on the wrong branch.
    fn is_astray(&self, fit: &Fit) -> bool {
        let reference = self.reference();
        let sds = |[r, d]: &[f64; 2]| (r * fit.noise.r_m / reference.r_m).hypot(d * fit.noise.d_m / reference.d_m);
        fit.optimum.linear.told.residuals.iter().any(|residual| sds(residual) > ASTRAY_SDS)
    }

    /// The state with all angles decoded anew; `None` where no reading asks for it.
    pub(super) fn mended(&self, readings: &[Reading], prior: &MotionPrior, fit: &Fit) -> Option<State> {
        if !self.is_astray(fit) {
            return None;
        }
        let reference = self.reference();
        let noise = Noise { r_m: fit.noise.r_m.max(reference.r_m), d_m: fit.noise.d_m.max(reference.d_m) };
        let state = &fit.optimum.state;
        let variance = curve_variance(&fit.optimum, fit.order, noise)?;
        let measured = self.measured(readings, state);
        let decoding =
            Decoding { measured: &measured, leap_nats: &|place| prior.leap_nats(place), known_rad: &|_| None };
        Some(State { theta_rad: decoded(state, &decoding, &prior.ranges, noise, variance), ..state.clone() })
    }

    /// The state with the angles of segments that closed forms and fit do not agree on decoded anew, by the shape that the others tell; `None` where
    /// they agree on all, or on few.
    pub(super) fn placed_by_others(&self, readings: &[Reading], prior: &MotionPrior, fit: &Fit) -> Option<State> {
        if !self.is_astray(fit) {
            return None;
        }
        let state = &fit.optimum.state;
        let laid = prior.relative_rad.each_ref().map(|relative| laid_on(&prior.ranges, relative, &state.theta_rad));
        let is_agreed = |range: &Range<usize>| {
            let mut all =
                range.clone().flat_map(|place| laid.iter().map(move |laid| laid[place] - state.theta_rad[place]));
            all.all(|off| off.abs() < AGREED_RAD)
        };
        let (agreed, others): (Vec<Range<usize>>, Vec<Range<usize>>) =
            prior.ranges.iter().cloned().partition(is_agreed);
        let kept: Vec<usize> = agreed.into_iter().flatten().collect();
        if others.is_empty() || kept.len() < FEWEST_SAMPLES {
            return None;
        }
        let of_kept: Vec<Reading> = kept.iter().map(|&place| readings[place]).collect();
        let few = self.problem(&of_kept);
        let start = shape_given_angles(&few, kept.iter().map(|&place| state.theta_rad[place]).collect())?;
        let told = few.solve(start)?;
        let measured = self.measured(readings, &told.state);
        let variance = curve_variance(&told, few.order, few.noise)?;
        let mut theta_rad = state.theta_rad.clone();
        kept.iter().zip(&told.state.theta_rad).for_each(|(&place, theta)| theta_rad[place] = *theta);
        let decoding =
            Decoding { measured: &measured, leap_nats: &|place| prior.leap_nats(place), known_rad: &|_| None };
        let decoded = decoded(&told.state, &decoding, &others, few.noise, variance);
        others.into_iter().flatten().zip(decoded).for_each(|(place, theta)| theta_rad[place] = theta);
        Some(State { theta_rad, ..told.state })
    }
}

/// The parts of a segment that are not known, each with what is known at its ends.
fn between_known(range: &Range<usize>, is_known: &dyn Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    for place in range.clone().filter(|place| !is_known(*place)) {
        let end = (place + 2).min(range.end);
        match parts.last_mut() {
            Some(part) if part.end > place => part.end = end,
            _ => parts.push(place.saturating_sub(1).max(range.start)..end),
        }
    }
    parts
}

/// The variance of shares of the residuals of r and of d, over this noise, as far as they are those of the shape: at an angle.
pub(super) fn curve_variance(
    Optimum { state, linear, .. }: &Optimum,
    order: usize,
    noise: Noise,
) -> Option<impl Fn(f64, [f64; 2]) -> f64 + use<>> {
    let covariance = linear.factorised(&state.coefficients, 0.0)?.inverse();
    let unknowns = 2 * order + 1;
    let of_shape = covariance.view((0, 0), (unknowns, unknowns)).into_owned();
    Some(move |theta_rad: f64, [r_share, d_share]: [f64; 2]| {
        let row = curve_row(theta_rad, order, [r_share / noise.r_m, d_share / noise.d_m]);
        (&of_shape * &row).dot(&row).max(0.0)
    })
}

/// Angles of segments, each up to a constant, laid on others by the rotation of each segment that suits most of it: some of either may be elsewhere.
pub(super) fn laid_on(ranges: &[Range<usize>], relative_rad: &[f64], theta_rad: &[f64]) -> Vec<f64> {
    let laid = |range: &Range<usize>| {
        let (own, there) = (&relative_rad[range.clone()], &theta_rad[range.clone()]);
        let turns = || own.iter().zip(there).map(|(own, there)| there - own);
        let mean_rad = mean_direction(turns());
        let turn_rad = mean_rad + median(&mut turns().map(|turn| wrapped(turn - mean_rad)).collect::<Vec<f64>>());
        own.iter().map(move |own| own + turn_rad)
    };
    ranges.iter().flat_map(laid).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_lies_between_what_is() {
        let parts = |known: &[usize]| between_known(&(2..12), &|place| known.contains(&place));
        assert!(parts(&(2..12).collect::<Vec<usize>>()).is_empty());
        assert_eq!(parts(&[]), vec![2..12]);
        assert_eq!(parts(&[4, 5, 6, 9]), [2..5, 6..10, 9..12]);
        assert_eq!(parts(&[2, 3, 5, 11]), [3..6, 5..12]);
    }

    #[test]
    fn segments_are_laid_on_others_by_one_rotation_each() {
        let theta_rad: Vec<f64> = (0..12).map(|index| 0.1 * f64::from(index)).collect();
        let turned = |index: usize| theta_rad[index] + if index < 5 { 2.0 } else { -7.0 };
        // Angles that are off, fewer than half of them, do not turn their segment.
        let mut relative_rad: Vec<f64> = (0..12).map(turned).collect();
        relative_rad[8] += 0.07;
        relative_rad[10] += 0.7;
        let laid = laid_on(&[0..5, 5..12], &relative_rad, &theta_rad);
        for (index, (laid, theta)) in laid.iter().zip(&theta_rad).enumerate() {
            let expected = match index {
                8 => 0.07,
                10 => 0.7,
                _ => 0.0,
            };
            assert!((wrapped(laid - theta) - expected).abs() < 1e-9, "{index}: {laid} {theta}");
        }
    }
}
