//! Refinement by contact alone, for objects on which friction acts (`docs/theory.md`, friction): form and motion from the contacts, whatever the
//! forces are; then centre of mass and friction from what the forces within the friction cones ask of them.

use super::by_inertia::balance_missed_m;
use super::calibrated::LEFT;
use super::job::{Job, LEAST_FIRST_SD, ORDER_SAMPLES, Refined};
use super::resample::{carry_over, thinned_in_ranges};
use crate::estimate::evidence::fit::{ROUNDS, fit};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::layout::{Layout, coefficients_to_order};
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::reconstruct::search::in_motion::{self, search_in_motion};
use crate::reconstruct::search::schedule::{Found, Readings, search_by_contact};
use crate::reconstruct::verdict::assemble::Candidate;
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::PI;

/// What a search by contact alone is worth, as a share of what all others are: asked of every log that neither few harmonics nor more explain, where a twentieth of
/// that finds inertia or friction that is the matter. Two and a half times as much, after all else, found nothing more.
const WORTH: f64 = 0.13;

/// Standard deviation of the origin of the form, as a share of the size: contact does not tell it, so it is held where it is.
const ORIGIN_SD: f64 = 1e-6;

impl Job<'_> {
    /// The result of a search by contact alone, where inertia or friction explains it, or friction may.
    pub fn explained_by_forces(&self) -> Option<Candidate> {
        if let Some(in_motion) = self.explained_in_motion() {
            return Some(in_motion);
        }
        let (mut explained, mut plausible) = (None, None);
        self.without_balance_worth(WORTH).each_by_contact(&mut |job, refined| {
            explained = job.inertia_of(refined);
            if explained.is_none()
                && let Some(candidate) = job.explained_by_friction(refined)
            {
                let place = if candidate.result.verdict.doubts_friction() { &mut plausible } else { &mut explained };
                place.get_or_insert(candidate);
            }
            explained.is_some()
        });
        explained.or(plausible)
    }

    /// What a search for a motion with inertia leads to.
    pub fn explained_in_motion(&self) -> Option<Candidate> {
        let of_contact = self.without_balance_worth(WORTH);
        let Job { log, calibration, measurements, scatter_m, prior, .. } = &of_contact;
        let found = search_in_motion(&in_motion::Readings {
            log,
            calibration: *calibration,
            measurements,
            scatter_m: *scatter_m,
            prior: *prior,
        })?;
        let job = of_contact.calibrated_by(&found);
        // Contacts alone say how noisy they are; the motion is that which the forces know of. They have still to place the samples that it leaves out.
        let mut refined = job.refined_by_contact(&found)?;
        let Found { thin, ranges, estimates, .. } = found;
        let Estimate { coefficients, psi, cost } = estimates.into_iter().next()?;
        let psi = carry_over(&thin, &psi, &coefficients, &job.measurements, &ranges);
        for (index, ambiguity_rad) in refined.ambiguity_rad.iter_mut().enumerate() {
            if !ranges.iter().any(|range| range.contains(&index)) {
                *ambiguity_rad = PI;
            }
        }
        refined.fine.estimate = Estimate { coefficients, psi, cost };
        if let Some(harmonics) = self.options.harmonics {
            coefficients_to_order(&mut refined.fine.estimate.coefficients, harmonics);
        }
        let Estimate { coefficients, psi, .. } = &refined.fine.estimate;
        let missed_m = balance_missed_m(&job.measurements, coefficients, psi);
        job.explained_in_motion_by(&refined, missed_m)
    }

    /// What inertia makes of an optimum by contact alone.
    fn inertia_of(&self, refined: &Refined) -> Option<Candidate> {
        let (balanced, missed_m) = self.balanced(refined);
        self.explained_by_inertia(refined, balanced, missed_m)
    }

    /// The same log without the balance, worth such a share of what it is with it; that keeps what it is worth.
    pub(super) fn without_balance_worth(&self, share: f64) -> Self {
        self.worth(share).without_balance()
    }

    /// Passes what a search by contact alone leads to at its optimum to `accept`, with the readings it is of, until that returns true or the log is
    /// worth no more.
    fn each_by_contact(&self, accept: &mut dyn FnMut(&Job, &Refined) -> bool) {
        let calibrate = |found: &Found| self.corrected(found, LEFT[0]);
        let mut is_first = true;
        search_by_contact(&Readings { brief: true, ..self.readings() }, &calibrate, &mut |found| {
            if !std::mem::take(&mut is_first) && self.is_spent() {
                return true;
            }
            let job = self.calibrated_by(&found);
            job.refined_by_contact(&found).is_some_and(|refined| accept(&job, &refined))
        });
    }

    /// The same log with what an arrangement tells of the rig: all but where gravity is, by contacts alone.
    fn calibrated_by(&self, found: &Found) -> Self {
        let calibrated = self.roughly_calibrated(found, 0);
        calibrated.map_or_else(|| self.clone(), |rough| self.recalibrated(self.raw, rough.calibration))
    }

    /// The coefficients of an optimum about the origin that misses the balance least, and by how much that does (root mean square, metres): the
    /// balance is linear in the origin.
    fn balanced(&self, refined: &Refined) -> (Vec<f64>, f64) {
        let Estimate { coefficients, psi, .. } = &refined.fine.estimate;
        let order = coefficients.len() / 2;
        let (mut normal, mut right, mut squares) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
        for (instant, psi) in self.measurements.instants.iter().zip(psi) {
            let missed_m = residuals(instant, coefficients, *psi).value[2];
            // d = −r' of the first harmonic.
            let (theta1, theta2) = instant.contact_angles(*psi);
            let [(sin1, cos1), (sin2, cos2)] = [theta1, theta2].map(f64::sin_cos);
            let row = Vector2::new(
                sin1 * instant.palms.sin12 + sin2 * instant.palms.sin1,
                -cos1 * instant.palms.sin12 - cos2 * instant.palms.sin1,
            );
            normal += row * row.transpose();
            right -= row * missed_m;
            squares += missed_m * missed_m;
        }
        let step = normal.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * right);
        let mut balanced = coefficients.clone();
        balanced[1] += step.x;
        balanced[order + 1] += step.y;
        let left = (squares - step.dot(&right)).max(0.0);
        (balanced, (left / psi.len().max(1) as f64).sqrt())
    }

    /// The best arrangement of such a search at its optimum over all samples.
    fn refined_by_contact(&self, found: &Found) -> Option<Refined> {
        let start = found.estimates.first()?;
        let medium = thinned_in_ranges(&self.measurements, &found.ranges, self.scatter_m, ORDER_SAMPLES);
        let psi = carry_over(&found.thin, &start.psi, &start.coefficients, &medium, &found.ranges);
        let start = Estimate { coefficients: start.coefficients.clone(), psi, cost: f64::INFINITY };
        let sd = self.scatter_m.max(LEAST_FIRST_SD * self.prior.size_m);
        let noise = Noise { sensor_m: sd, balance_m: sd };
        let components = self.variance_components();
        let order = Layout::of_coefficients(&start.coefficients).order;
        let rough = fit(&medium, order, start, noise, self.prior, components, ROUNDS)?.fit;
        let coarse = self.with_best_order(&medium, rough.estimate, rough.noise, rough.prior)?.fit;
        let all: &Measurements = &self.measurements;
        let coefficients = coarse.estimate.coefficients.clone();
        let psi = carry_over(&medium, &coarse.estimate.psi, &coefficients, all, &found.ranges);
        let estimate = Estimate { coefficients, psi, cost: f64::INFINITY };
        let averaged = self.averaged(&medium);
        let sensor_m = self.stated_m.unwrap_or(averaged * coarse.noise.sensor_m);
        let noise = Noise { sensor_m, balance_m: sensor_m };
        let fitted = fit(all, coarse.order, estimate, noise, coarse.prior, self.variance_components_of_all(), ROUNDS)?;
        let mut fine = fitted.fit;
        fine.prior.origin_sd_m = ORIGIN_SD * self.prior.size_m;
        let refined = Refined {
            coarse,
            posterior: fine.evidence,
            fine,
            measurements: fitted.weighted,
            ambiguity_rad: vec![0.0; self.measurements.len()],
            symmetry: FoundSymmetry::default(),
            settled: true,
            rivals: Vec::new(),
            as_likely: Vec::new(),
        };
        Some(refined)
    }
}
