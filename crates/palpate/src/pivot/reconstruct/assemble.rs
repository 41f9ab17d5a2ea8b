//! The result of a fit: shape, outline, motion and what is known of them, with the findings that a verdict rests on.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::Prepared;
use super::placed_anew::curve_variance;
use crate::estimate::coverage::{LONGEST_SLIDE, NODES, touches};
use crate::math::angle::wrapped;
use crate::math::statistics::root_mean_square;
use crate::pivot::beside_leaps::are_open;
use crate::pivot::calibration::TOLD;
use crate::pivot::center_of_mass::{self, FirstContact};
use crate::pivot::error_bars::ErrorBars;
use crate::pivot::evidence::{Fit, MOST_HARMONICS};
use crate::pivot::motion_prior::MotionPrior;
use crate::pivot::posterior::PivotPosterior;
use crate::pivot::result::{PivotPose, PivotReconstruction};
use crate::pivot::segments::Cuts;
use crate::pivot::smoother::{Problem, across};
use crate::pivot::verdict::Findings;
use crate::reconstruct::OutlinePoint;
use crate::shape::SupportFunction;

/// A contact angle with a larger standard deviation, radians, may seem to leap.
const TOLD_RAD: f64 = 0.05;

impl Prepared<'_> {
    /// Which of the readings may as well be on the other side of a leap.
    fn open_samples(&self, problem: &Problem, prior: &MotionPrior, fit: &Fit) -> Option<Vec<bool>> {
        let state = &fit.optimum.state;
        let own = Problem { between: None, ..problem.clone() };
        let variance = curve_variance(&fit.optimum, fit.order, fit.noise)?;
        let cost = |sample: usize, theta_rad: f64| {
            let (nats, theta_rad) = own.settled(state, sample, theta_rad);
            let contact = crate::estimate::model::contact::support(&state.coefficients, theta_rad);
            let share = across([-contact.d / fit.noise.r_m, (contact.r - contact.v) / fit.noise.d_m]);
            (nats / (1.0 + variance(theta_rad, share)), theta_rad)
        };
        Some(are_open(&prior.ranges, &state.theta_rad, &cost, &|sample| prior.leap_nats(sample)))
    }

    /// The result of one fit, whose noise and number of harmonics are its own and not those of the problem. Samples that may as well be elsewhere have no
    /// pose.
    pub(super) fn assembled(
        &self,
        problem: &Problem,
        fit: &Fit,
        prior: &MotionPrior,
        elsewhere: &[usize],
        alternatives: usize,
    ) -> Option<(PivotReconstruction, PivotPosterior)> {
        let problem = &fit.like(problem.clone());
        let rig = &self.options.rig;
        let state = &fit.optimum.state;
        let linear = &fit.optimum.linear;
        let calibration = rig.calibration.with_told(state.told);
        let tilt_rad = rig.pad.tilt_rad + calibration.tilt_rad;
        let first_rad = *state.theta_rad.first()?;
        // ψ = 0 at the first contact.
        let turn_rad = tilt_rad - FRAC_PI_2 - first_rad;
        // What others start from has them decoded once more.
        let mut open = match self.cuts {
            Cuts::AtLeaps => self.open_samples(problem, prior, fit)?,
            Cuts::AtLongSteps => vec![false; problem.readings.len()],
        };
        elsewhere.iter().for_each(|&place| open[place] = true);
        let shape = SupportFunction::from_coefficients(&state.coefficients).rotated(turn_rad);
        if shape.has_nonfinite() {
            return None;
        }
        let paths: Vec<Vec<f64>> = self
            .ranges_of_used()
            .into_iter()
            .flat_map(|range| {
                let placed: Vec<f64> =
                    range.filter(|&place| !open[place]).map(|place| state.theta_rad[place] + turn_rad).collect();
                let slides = placed.chunk_by(|a, b| (b - a).abs() <= LONGEST_SLIDE);
                slides.map(<[f64]>::to_vec).collect::<Vec<Vec<f64>>>()
            })
            .collect();
        let counts = touches(&paths);
        let felt: Vec<usize> = (0..NODES).filter(|&node| counts[node] > 0).collect();
        let angle = |node: usize| TAU * node as f64 / NODES as f64;
        // Error bars belong to the shape before it was turned.
        let felt_before: Vec<f64> = felt.iter().map(|&node| angle(node) - turn_rad).collect();
        let alone = Problem { between: None, ..problem.clone() }.linearised(state);
        let bars = ErrorBars::new(linear, &alone, state, &felt_before)?;
        let outline: Vec<OutlinePoint> = (0..NODES)
            .map(|node| {
                let theta_rad = angle(node);
                let (contact, point) = (shape.at(theta_rad), shape.boundary_point(theta_rad));
                OutlinePoint {
                    theta_rad,
                    r_m: contact.r,
                    r_sd_m: bars.r_sd_m(theta_rad - turn_rad),
                    x_m: point.x_m,
                    y_m: point.y_m,
                    curvature_radius_m: contact.v,
                    touches: counts[node],
                }
            })
            .collect();
        let motion = self.motion(problem, fit, (&bars, &open), turn_rad, tilt_rad);
        let theta_sd_rad = root_mean_square(&bars.theta_sd_rad);
        let r_sd_m = root_mean_square(&felt.iter().map(|&node| outline[node].r_sd_m).collect::<Vec<f64>>());
        let (chi2_per_dof, dof) = self.chi2_per_dof(fit.noise, &fit.optimum);
        let coverage = felt.len() as f64 / NODES as f64;
        let concave_sds = felt_before
            .iter()
            .map(|&theta| {
                -crate::estimate::model::contact::support(&state.coefficients, theta).v
                    / bars.v_sd_m(theta).max(1e-12 * self.size_m)
            })
            .fold(0.0, f64::max);
        // Where readings hardly tell an angle it may seem to leap.
        let is_told = |index: usize| bars.theta_sd_rad[index].max(bars.theta_sd_rad[index - 1]) < TOLD_RAD;
        let leaps = prior.unexplained_leaps(&state.theta_rad).filter(|&index| is_told(index)).count();
        let stated = rig.calibration.told();
        let rig_off_sds = problem
            .open
            .iter()
            .map(|&(constant, sd)| ((state.told[constant] - stated[constant]) / sd).abs())
            .fold(0.0, f64::max);
        let findings = Findings {
            size_m: shape.mean_radius_m(),
            least_r_m: felt.iter().map(|&node| outline[node].r_m).fold(f64::INFINITY, f64::min),
            chi2_per_dof,
            dof,
            noise_stated: self.stated().d_m.is_some(),
            coverage,
            r_sd_m,
            theta_sd_rad,
            largest_theta_sd_rad: bars.theta_sd_rad.iter().copied().fold(0.0, f64::max),
            most_harmonics: (self.options.harmonics.is_none() && fit.order >= MOST_HARMONICS).then_some(fit.order),
            concave_sds,
            alternatives,
            leaps,
            other_starts: prior.other_starts(&state.theta_rad),
            rig_off_sds,
            left_out: 1.0 - open.iter().filter(|open| !**open).count() as f64 / self.readings.len() as f64,
        };
        let mut told_sd = rig.tolerances.told();
        for (place, &(constant, _)) in problem.open.iter().enumerate() {
            let index = 2 * fit.order + 1 + place;
            told_sd[constant] = bars.covariance[(index, index)].max(0.0).sqrt();
        }
        let [zero_sd_m, scale_sd, tilt_sd_rad]: [f64; TOLD] = told_sd;
        let first = self.first_contacts(&motion);
        let center_of_mass = center_of_mass::estimate(&shape, &first, tilt_rad, self.log.swing_period_s);
        let posterior = PivotPosterior::new(&state.coefficients, bars.of_shape(), turn_rad);
        let reconstruction = PivotReconstruction {
            shape,
            outline,
            motion,
            doubts: findings.doubts(),
            chi2_per_dof: findings.chi2_per_dof,
            coverage,
            alternatives,
            others: Vec::new(),
            segments: self.ranges.len(),
            sensor_sd_m: fit.noise.d_m,
            arm_sd_m: fit.noise.r_m,
            calibration,
            calibration_sd: crate::pivot::calibration::PivotTolerances {
                zero_sd_m,
                scale_sd,
                tilt_sd_rad,
                height_sd_m: rig.tolerances.height_sd_m,
            },
            center_of_mass,
        };
        Some((reconstruction, posterior))
    }

    /// One pose per sample of the log.
    fn motion(
        &self,
        problem: &Problem,
        fit: &Fit,
        (bars, open): (&ErrorBars, &[bool]),
        turn_rad: f64,
        tilt_rad: f64,
    ) -> Vec<PivotPose> {
        let mut motion: Vec<PivotPose> = self
            .log
            .samples
            .iter()
            .map(|sample| PivotPose {
                time_s: sample.time_s,
                pivot_x_m: sample.pivot_x_m,
                pivot_y_m: sample.pivot_y_m,
                theta_rad: None,
                psi_rad: None,
                psi_sd_rad: None,
                segment: None,
                height_residual_m: None,
                offset_residual_m: None,
            })
            .collect();
        let state = &fit.optimum.state;
        let mut first = 0;
        for (segment, range) in self.ranges.iter().enumerate() {
            // Whole turns do not count: each segment begins within half a turn of the first.
            let begins = state.theta_rad[first] + turn_rad - (tilt_rad - FRAC_PI_2);
            let whole = wrapped(begins) - begins;
            for (place, index) in (first..).zip(range.clone()).filter(|(place, _)| !open[*place]) {
                let pose = &mut motion[self.samples[index]];
                let theta = state.theta_rad[place] + turn_rad + whole;
                let [r, d] = fit.optimum.linear.told.residuals[place];
                pose.theta_rad = Some(theta);
                pose.psi_rad = Some(tilt_rad - FRAC_PI_2 - theta);
                pose.psi_sd_rad = Some(bars.theta_sd_rad[place]);
                pose.segment = Some(segment as u32);
                pose.height_residual_m = Some(-r * problem.noise.r_m);
                pose.offset_residual_m = Some(-d * problem.noise.d_m);
            }
            first += range.len();
        }
        motion
    }

    /// What each stroke begins with: the first contact after samples without one.
    fn first_contacts(&self, motion: &[PivotPose]) -> Vec<FirstContact> {
        let mut first = Vec::new();
        for range in &self.ranges {
            let sample = self.samples[range.start];
            let Some(before) = sample.checked_sub(1).filter(|_| self.hung_free_before(sample)) else { continue };
            if let (Some(theta), Some(sd)) = (motion[sample].theta_rad, motion[sample].psi_sd_rad) {
                let lowered_m = self.height_m(before) - self.height_m(sample);
                first.push(FirstContact::new(theta, sd, lowered_m, self.d_m[range.start]));
            }
        }
        first
    }
}
