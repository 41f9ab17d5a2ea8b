//! A stretch continued beyond its ends as mechanics goes on from it, backwards with the friction reversed, and over jumps: where the object lands, the contacts
//! tell, and of several poses the one from which mechanics goes on best.

use super::Setting;
use super::growth::Strided;
use super::stretch::Stretch;
use crate::estimate::association::candidates::minima;
use crate::estimate::friction::problem::{Problem, Unknowns};
use crate::estimate::measurements::Instant;
use crate::estimate::model::contact::residuals;
use std::f64::consts::TAU;
use std::ops::Range;

/// Jumps that a stretch grows over at most in one step.
const JUMPS_AT_ONCE: usize = 2;

/// Poses that an object may land at, those first that its contacts explain best.
const LANDINGS: usize = 6;

impl Strided<'_> {
    /// ψ over a longer stretch, as it is within, and beyond both ends as mechanics continues it; and the samples at which jumps have just ended.
    pub fn followed(&self, stretch: &Stretch, range: &Range<usize>, over_jumps: bool) -> (Vec<f64>, Vec<usize>) {
        let (within, known) = (&stretch.range, &stretch.settled.optimum.unknowns.psi);
        let (mut psi, before) = self.continued(stretch, range.start..within.start + 1, true, over_jumps);
        psi.reverse();
        psi.pop();
        psi.extend(known);
        let (after, later) = self.continued(stretch, within.end - 1..range.end, false, over_jumps);
        psi.extend(after.into_iter().skip(1));
        // Backwards, what ends a jump is what it began at.
        let mut starts: Vec<usize> = before.into_iter().rev().map(|start| within.start + 1 - start).collect();
        starts.extend(stretch.starts());
        starts.extend(later.into_iter().map(|start| within.end - 1 + start));
        (psi, starts)
    }

    /// ψ over a part of the log that begins, or backwards ends, where a stretch is known, as mechanics continues it from there; and the places in it at
    /// which jumps have just ended.
    fn continued(
        &self,
        stretch: &Stretch,
        part: Range<usize>,
        backwards: bool,
        over_jumps: bool,
    ) -> (Vec<f64>, Vec<usize>) {
        let known = &stretch.settled.optimum.unknowns;
        let from = if backwards { known.psi.first() } else { known.psi.last() };
        let psi = vec![from.copied().unwrap_or(0.0); part.len()];
        let (mut log, mut measurements) = self.part(&part);
        let mut friction = known.friction;
        if backwards {
            log.samples.reverse();
            measurements.instants.reverse();
            // Forces that resist the motion would drive it backwards.
            friction = friction.map(|value| -value);
        }
        let setting = Setting::new(self.job, &log, &measurements, &stretch.fit, &[]);
        let problem = Problem::new(&log, &self.job.options.rig, &measurements, setting.order, setting.prior);
        let corrected = problem.corrected(&known.calibration);
        let noise = stretch.settled.optimum.noise;
        let covariance = stretch.settled.optimum.covariance_of_object();
        let decoded = |psi: Vec<f64>, starts: &[usize]| {
            let at = Unknowns { psi, friction, ..known.clone() };
            setting.decoded(&corrected, &at, covariance.as_ref(), noise, starts)
        };
        let mut best = decoded(psi, &[]);
        let mut starts = Vec::new();
        while over_jumps && starts.len() < JUMPS_AT_ONCE {
            // Where it is lost, or could not slide so far.
            let lost = best.starts.iter().chain(&best.falls).filter(|at| starts.last().is_none_or(|last| *at > last));
            let Some(&at) = lost.min() else { break };
            let landings = landings(&corrected.measurements.instants[at], &known.coefficients, best.psi[at - 1]);
            starts.push(at);
            let landed = landings.into_iter().map(|landing| {
                let mut psi = best.psi.clone();
                psi[at..].fill(landing);
                decoded(psi, &starts)
            });
            let likeliest = landed.min_by(|a, b| a.cost().total_cmp(&b.cost()));
            let Some(likelier) = likeliest.filter(|landed| landed.cost() < best.cost()) else {
                starts.pop();
                break;
            };
            best = likelier;
        }
        (best.psi, starts)
    }
}

/// Poses at which the contacts of a sample are where a shape has them.
fn landings(instant: &Instant, coefficients: &[f64], near: f64) -> Vec<f64> {
    let missed = |psi: f64| {
        let value = residuals(instant, coefficients, psi).value;
        (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2)
    };
    let mut poses = minima(near, TAU, &missed);
    poses.sort_by(|a, b| a.1.total_cmp(&b.1));
    poses.truncate(LANDINGS);
    poses.into_iter().map(|(psi, _)| psi).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::measurements::Measurements;
    use crate::math::angle::wrapped;
    use crate::palms::PalmPair;
    use crate::sensor::Touchpad;
    use crate::shape::rounded_polygon;
    use crate::simulate::{SimulateOptions, simulate};

    #[test]
    fn an_object_may_land_at_any_pose_at_which_its_contacts_are_where_they_are_felt() {
        let square = rounded_polygon(4, 0.4, 0.2).expect("a shape").scaled(0.03);
        let motion: Vec<(f64, PalmPair)> =
            [0.0, 0.1].map(|time_s| (time_s, PalmPair::hinged(0.8 + time_s, 1.3))).to_vec();
        let touchpad = Touchpad::ideal();
        let options =
            SimulateOptions { touchpad, friction: [0.2; 2], start_psi_rad: 0.1, ..SimulateOptions::default() };
        let run = simulate(&square, &motion, &options).expect("possible");
        let (instants, truth) = (Measurements::new(&run.log, None).instants, run.truth.motion[1].psi_rad);
        let found = landings(&instants[1], &square.coefficients(), 0.0);
        for quarter in 0..4 {
            let pose = truth + f64::from(quarter) * TAU / 4.0;
            assert!(found[..4].iter().any(|psi| wrapped(psi - pose).abs() < 1e-3), "{found:?} {truth}");
        }
        assert!(found.len() <= LANDINGS);
    }
}
