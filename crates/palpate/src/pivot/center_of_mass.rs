//! The centre of mass, of which contact says nothing: lifted, the object swings to rest with it under the pivot. So the contact at which
//! a stroke begins has the direction of the centre of mass, and the period of small swings about the pivot,
//!
//! T = 2π √((k² + ρ²)/(g ρ)),
//!
//! its distance ρ where the radius of gyration k about the centre of mass is known.

use std::f64::consts::TAU;

use crate::math::angle::{mean_direction, wrapped};
use crate::mechanics::STANDARD_GRAVITY_M_PER_S2;
use crate::pivot::result::CenterOfMassEstimate;
use crate::shape::SupportFunction;

/// How far the contact may have moved between the touch and the first sample, radians: beyond, that sample says little.
const LONGEST_TOUCH_RAD: f64 = 0.5;

/// Strokes begin at the same angle where the ranges that their first samples leave it miss each other by at most so many standard deviations.
const SAME_START_SDS: f64 = 4.0;

/// The first contact of a stroke: its angle with its standard deviation, and how far back the angle of the touch may lie (signed radians).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FirstContact {
    pub theta_rad: f64,
    pub sd_rad: f64,
    pub back_rad: f64,
}

impl FirstContact {
    /// Of a stroke whose pivot came down by `lowered_m` since the sample before, which had no contact; `d_m` is the offset of the contact.
    pub fn new(theta_rad: f64, sd_rad: f64, lowered_m: f64, d_m: f64) -> Self {
        // r' = −d: higher up the contact was where r is larger.
        let back_rad = if d_m == 0.0 { LONGEST_TOUCH_RAD } else { -lowered_m.max(0.0) / d_m };
        Self { theta_rad, sd_rad, back_rad: back_rad.clamp(-LONGEST_TOUCH_RAD, LONGEST_TOUCH_RAD) }
    }
}

/// The direction from what the strokes begin with; `None` of fewer than two, or where they do not agree.
pub(super) fn direction(first: &[FirstContact], tilt_rad: f64) -> Option<(f64, f64)> {
    if first.len() < 2 {
        return None;
    }
    let around = mean_direction(first.iter().map(|contact| contact.theta_rad));
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut information = 0.0;
    let mut largest_sd: f64 = 0.0;
    for contact in first {
        let from = wrapped(contact.theta_rad - around);
        let to = from + contact.back_rad;
        low = low.max(from.min(to));
        high = high.min(from.max(to));
        information += 1.0 / contact.sd_rad.powi(2).max(1e-18);
        largest_sd = largest_sd.max(contact.sd_rad);
    }
    if low - high > SAME_START_SDS * std::f64::consts::SQRT_2 * largest_sd {
        return None;
    }
    let width = (high - low).max(0.0);
    let sd = (width * width / 12.0 + 1.0 / information).sqrt();
    Some((wrapped(around + 0.5 * (low + high) - tilt_rad), sd))
}

/// Distance of the centre of mass from the pivot by the period of small swings, metres, for a radius of gyration `gyration_m` about the
/// centre of mass: both solutions, the smaller one first. `None` where there is none: no object swings as fast.
pub fn swing_distances_m(period_s: f64, gyration_m: f64) -> Option<[f64; 2]> {
    let length = STANDARD_GRAVITY_M_PER_S2 * (period_s / TAU).powi(2);
    let square = length * length - 4.0 * gyration_m * gyration_m;
    if !(square >= 0.0 && length.is_finite() && gyration_m >= 0.0) {
        return None;
    }
    let larger = 0.5 * (length + square.sqrt());
    Some([if larger > 0.0 { gyration_m * gyration_m / larger } else { 0.0 }, larger])
}

/// Radius of gyration of a plate of even mass about its centroid, metres: k² = ∮ over the area of the squared distance.
fn even_gyration_m(shape: &SupportFunction) -> f64 {
    let middle = shape.centroid();
    let centred = shape.translated(-middle.x_m, -middle.y_m);
    // Triangles from the centre: ∫ |x|² dA = ¼ ∮ |x|² (x·n) ds with ds = v dθ.
    let nodes = 4 * shape.harmonics_m().len() + 16;
    let sum: f64 = (0..nodes)
        .map(|node| centred.at(TAU * node as f64 / nodes as f64))
        .map(|contact| (contact.r * contact.r + contact.d * contact.d) * contact.r * contact.v)
        .sum();
    (0.25 * sum * TAU / nodes as f64 / shape.area_m2()).max(0.0).sqrt()
}

/// Direction and, with a period of swinging, distance.
pub(super) fn estimate(
    shape: &SupportFunction,
    first: &[FirstContact],
    tilt_rad: f64,
    period_s: Option<f64>,
) -> Option<CenterOfMassEstimate> {
    let (direction_rad, direction_sd_rad) = direction(first, tilt_rad)?;
    let rim_m = shape.radius_m(direction_rad);
    let inside = |distance: &f64| *distance < rim_m;
    let distances = period_s.and_then(|period| swing_distances_m(period, even_gyration_m(shape)));
    let distance_m = distances.and_then(|both| match both.map(|distance| inside(&distance)) {
        [true, false] => Some(both[0]),
        _ => None,
    });
    Some(CenterOfMassEstimate { direction_rad, direction_sd_rad, distance_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_has_the_period_that_it_came_from() {
        let (k, rho) = (0.02_f64, 0.006_f64);
        let period = TAU * ((k * k + rho * rho) / (STANDARD_GRAVITY_M_PER_S2 * rho)).sqrt();
        let [near, far] = swing_distances_m(period, k).expect("it swings");
        assert!((near - rho).abs() < 1e-12 && (far - k * k / rho).abs() < 1e-9);
        assert_eq!(swing_distances_m(0.1, k), None);
        assert_eq!(swing_distances_m(f64::NAN, k), None);
    }

    #[test]
    fn a_disc_has_the_gyration_of_a_disc() {
        let disc = SupportFunction::new(0.03, vec![[0.004, -0.002]]);
        assert!((even_gyration_m(&disc) - 0.03 / 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn strokes_that_begin_alike_give_a_direction_and_others_none() {
        let first = |theta: f64| FirstContact { theta_rad: theta, sd_rad: 0.01, back_rad: 0.0 };
        let (direction_rad, sd) = direction(&[first(0.5), first(0.52)], 0.1).expect("they agree");
        assert!((direction_rad - 0.41).abs() < 1e-12 && sd < 0.01);
        let apart = |sds: f64| direction(&[first(0.5), first(0.5 + sds * 0.01 * 2f64.sqrt())], 0.0);
        assert!(apart(0.9 * SAME_START_SDS).is_some() && apart(1.1 * SAME_START_SDS).is_none());
        assert_eq!(direction(&[first(0.5)], 0.0), None);
    }

    #[test]
    fn the_touch_lies_where_the_object_reaches_higher() {
        let contact = FirstContact::new(1.0, 0.01, 5e-4, 5e-3);
        assert!((contact.back_rad + 0.1).abs() < 1e-12);
        assert_eq!(FirstContact::new(1.0, 0.01, 5e-4, 1e-5).back_rad, -LONGEST_TOUCH_RAD);
        assert!(FirstContact::new(1.0, 0.01, 0.9 * LONGEST_TOUCH_RAD * 1e-3, 1e-3).back_rad > -LONGEST_TOUCH_RAD);
    }
}
