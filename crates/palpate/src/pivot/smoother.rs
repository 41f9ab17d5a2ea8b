//! Maximum likelihood over all samples: shape r(θ), constants of the rig and one contact angle θ per sample from
//!
//! r(θ) = height of the pivot over the pad,  d(θ) = −r'(θ) = offset of the contact from its foot.
//!
//! θ stands in the two residuals of its own sample only. Eliminated, it leaves one residual per sample: that across the curve (r, d) of
//! the shape, each coordinate in units of its noise. Gauss–Newton steps, damped after Levenberg and Marquardt (Nocedal & Wright,
//! *Numerical Optimization*, 2006, sections 10.2 and 10.3).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::estimate::model::contact::support;
use crate::estimate::model::layout::{Layout, coefficients_to_order};
use crate::math::banded::BandedCholesky;
use crate::pivot::calibration::{Measured, PivotCalibration, Reading, TOLD};
use crate::pivot::curve::curve;
use crate::pivot::harmonic_prior::{HarmonicPrior, NormalEquations};
use crate::pivot::motion_between::{MotionBetween, SPAN};
use crate::pivot::rows::{fill_curve_rows, sums_of_outer_products, whitened_squares};
use crate::shape::ContactSupport;

/// Steps at most.
const MOST_STEPS: usize = 60;

/// The largest change of a contact angle in one step, radians.
const LONGEST_TURN_RAD: f64 = 0.3;

/// Newton steps of the contact angles after each step of the shape, at most.
const ANGLE_STEPS: usize = 2;

/// A step that lowers the cost by less, in units of half a χ², ends the search: a fiftieth of a standard deviation.
const SETTLED: f64 = 2e-4;

/// Damping of the first step, as a share of each diagonal element: steps from the closed form are long for a curve as bent as (r, d).
const FIRST_DAMPING: f64 = 1e-4;

/// The damping falls by no more than this at once.
const LEAST_SHRINKAGE: f64 = 0.05;

/// Newton steps of a single angle to its minimum, at most, …
const SETTLING_STEPS: usize = 10;

/// … and the shortest that another is worth, radians: far less than any reading tells.
const LEAST_TURN_RAD: f64 = 1e-6;

/// Holds an angle that its own reading does not tell, per radian squared: far less than any reading does.
pub(super) const HELD_INFORMATION: f64 = 1e-3;

/// With so much damping no step helps.
const MOST_DAMPING: f64 = 1e6;

/// Standard deviations of what is measured, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// Of the height of the pivot over the pad: the arm.
    pub r_m: f64,
    /// Of the offset of the contact: pad and arm.
    pub d_m: f64,
}

/// What is to be solved.
#[derive(Clone, Debug)]
pub(super) struct Problem<'a> {
    pub readings: &'a [Reading],
    pub noise: Noise,
    /// Harmonics K.
    pub order: usize,
    /// Rough size of the object, metres.
    pub size_m: f64,
    /// What is believed of the harmonics.
    pub harmonics: HarmonicPrior,
    /// Stated constants of the rig.
    pub stated: PivotCalibration,
    /// Which of the told constants are open, and their prior standard deviations.
    pub open: Vec<(usize, f64)>,
    /// What is believed of the motion between the readings, and its scale, radians; `None`: nothing.
    pub between: Option<(&'a MotionBetween, f64)>,
}

/// Shape, constants and contact angles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    /// (a₀, a₁ … a_K, b₁ … b_K), metres.
    pub coefficients: Vec<f64>,
    pub told: [f64; TOLD],
    pub theta_rad: Vec<f64>,
}

/// An optimum and its neighbourhood.
#[derive(Clone, Debug)]
pub(super) struct Optimum {
    pub state: State,
    /// Half of χ² with the priors.
    pub cost: f64,
    pub linear: Linear,
}

/// What the readings say at a state, every θ eliminated.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// Residuals of r and d over their noise, per sample.
    pub residuals: Vec<[f64; 2]>,
    /// Their derivatives by θ.
    pub slopes: Vec<[f64; 2]>,
    /// One row per sample: derivative of the residual that is left without θ by coefficients and open constants.
    pub jacobian: DMatrix<f64>,
    /// The residual that is left.
    pub left: Vec<f64>,
}

/// The problem linearised at a state.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub told: Told,
    /// The noise of r and d, metres.
    pub scales: [f64; 2],
    /// Derivatives of r and d, as measured, by the open constants, per sample.
    pub constants: Vec<Vec<[f64; 2]>>,
    /// JᵀJ, with the priors and without the gauge.
    pub information: DMatrix<f64>,
    /// Gradient of the cost.
    pub gradient: DVector<f64>,
    /// Where angles depend on each other: their information L Lᵀ, and L⁻¹ times its products with coefficients and open constants, one row per sample.
    pub joined: Option<(BandedCholesky<SPAN>, DMatrix<f64>)>,
}

impl Linear {
    /// Where coefficients and open constants stand among the unknowns.
    pub fn layout(&self, coefficients: &[f64]) -> Layout {
        let of_shape = Layout::of_coefficients(coefficients);
        Layout { shared: self.information.nrows() - of_shape.unknowns(), ..of_shape }
    }

    /// The information with a rotation held.
    pub fn held(&self, coefficients: &[f64]) -> DMatrix<f64> {
        let mut matrix = self.information.clone();
        let rotation = self.layout(coefficients).rotation(coefficients);
        let square = rotation.norm_squared();
        if square > 0.0 {
            // As stiff as the stiffest direction: a rotation is not told, and costs nothing.
            let stiffness = matrix.diagonal().max() / square;
            matrix += &rotation * rotation.transpose() * stiffness;
        }
        matrix
    }

    /// The same factorised, each element of its diagonal larger by a share.
    pub fn factorised(&self, coefficients: &[f64], damping: f64) -> Option<Cholesky<f64, Dyn>> {
        let mut matrix = self.held(coefficients);
        for index in 0..matrix.nrows() {
            matrix[(index, index)] *= 1.0 + damping;
        }
        Cholesky::new(matrix)
    }

    /// Variances of the angles at known shape and constants, radians squared.
    pub fn angle_variances(&self) -> Vec<f64> {
        match &self.joined {
            Some((factor, _)) => {
                let inverse = factor.inverse_in_band();
                (0..self.told.slopes.len()).map(|index| inverse.at(index, index)).collect()
            }
            None => self.told.slopes.iter().map(|slope| 1.0 / own_information(*slope)).collect(),
        }
    }

    /// Half the logarithm of the determinant of the information on the angles at known shape and constants.
    pub fn half_ln_angles(&self) -> f64 {
        match &self.joined {
            Some((factor, _)) => 0.5 * factor.ln_determinant(),
            None => self.told.slopes.iter().map(|slope| 0.5 * own_information(*slope).ln()).sum(),
        }
    }

    /// How far the angles go as shape and constants do, one column per sample.
    pub fn angles_by_unknowns(&self) -> Option<DMatrix<f64>> {
        let (factor, solved) = self.joined.as_ref()?;
        let mut gains = solved.transpose();
        let unknowns = gains.nrows();
        factor.solve_upper(gains.as_mut_slice(), unknowns);
        Some(-gains)
    }

    /// The share of its own residual in each sample's prediction.
    pub fn leverages(&self, factor: &Cholesky<f64, Dyn>) -> Vec<f64> {
        whitened_squares(&self.told.jacobian, factor.l_dirty()).into_iter().map(|share| share.min(1.0)).collect()
    }
}

impl Problem<'_> {
    /// Coefficients and open constants.
    pub fn unknowns(&self) -> usize {
        2 * self.order + 1 + self.open.len()
    }

    /// Whether there are readings to check so many harmonics by: half as many unknowns as readings leave little.
    pub fn checks(&self, order: usize) -> bool {
        2 * (2 * order + 1) <= self.readings.len()
    }

    /// The normal equations near a state, without the prior of the harmonics.
    pub fn normal_equations(&self, state: &State) -> NormalEquations {
        let mut state = state.clone();
        coefficients_to_order(&mut state.coefficients, self.order);
        let linear = self.linearised(&state);
        let off = DVector::from_vec(self.off_prior(&state));
        let (mut information, mut gradient) = (linear.held(&state.coefficients), linear.gradient);
        for (index, sd) in self.harmonics.sds(self.order, self.size_m).into_iter().enumerate() {
            information[(index, index)] -= 1.0 / (sd * sd);
            gradient[index] -= off[index] / (sd * sd);
        }
        gradient -= &information * off;
        NormalEquations { information, gradient }
    }

    /// Prior standard deviations of all unknowns.
    pub fn prior_sds(&self) -> Vec<f64> {
        self.harmonics.sds(self.order, self.size_m).into_iter().chain(self.open.iter().map(|(_, sd)| *sd)).collect()
    }

    /// How far unknowns are from where the prior has them.
    fn off_prior(&self, state: &State) -> Vec<f64> {
        let stated = self.stated.told();
        let constants = self.open.iter().map(|&(constant, _)| state.told[constant] - stated[constant]);
        state.coefficients.iter().copied().chain(constants).collect()
    }

    /// The cost at a state: half of χ² with the priors.
    fn cost(&self, state: &State, contacts: &[ContactSupport]) -> f64 {
        let errors = self.stated.with_told(state.told);
        let mut square = 0.0;
        for (measured, contact) in errors.measured(self.readings).zip(contacts) {
            square += ((contact.r - measured.r_m) / self.noise.r_m).powi(2);
            square += ((contact.d - measured.d_m) / self.noise.d_m).powi(2);
        }
        let prior: f64 = self.off_prior(state).iter().zip(self.prior_sds()).map(|(off, sd)| (off / sd).powi(2)).sum();
        let between = self.between.map_or(0.0, |(between, sd_rad)| between.cost(&state.theta_rad, sd_rad));
        0.5 * (square + prior) + between
    }

    /// Residuals and derivatives at a state, every θ eliminated.
    pub fn told(&self, state: &State) -> Told {
        let contacts = curve(&state.coefficients, &state.theta_rad);
        let measured = self.measured(state);
        let (residuals, slopes) = self.all_missed(&contacts, &measured);
        let shares: Vec<[f64; 2]> = slopes.iter().map(|slope| across(*slope)).collect();
        let [jacobian] = self.by_unknowns(state, &measured, [&shares]);
        let left = shares_of(&shares, &residuals);
        Told { residuals, slopes, jacobian, left }
    }

    /// Heights and offsets with the constants of the rig of a state.
    fn measured(&self, state: &State) -> Vec<Measured> {
        self.stated.with_told(state.told).measured(self.readings).collect()
    }

    /// Residuals of r and d of all readings over their noise, and their derivatives by θ.
    fn all_missed(&self, contacts: &[ContactSupport], measured: &[Measured]) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
        contacts.iter().zip(measured).map(|(contact, measured)| self.missed(*contact, measured)).unzip()
    }

    /// Derivatives of shares of the residuals of r and d by coefficients and open constants, one row per sample; a matrix for each of the shares.
    fn by_unknowns<const SHARES: usize>(
        &self,
        state: &State,
        measured: &[Measured],
        shares: [&[[f64; 2]]; SHARES],
    ) -> [DMatrix<f64>; SHARES] {
        let of_shape = 2 * self.order + 1;
        let scaled: [Vec<[f64; 2]>; SHARES] =
            shares.map(|shares| shares.iter().map(|[r, d]| [r / self.noise.r_m, d / self.noise.d_m]).collect());
        let mut matrices = [(); SHARES].map(|()| DMatrix::zeros(measured.len(), self.unknowns()));
        fill_curve_rows(matrices.each_mut(), scaled.each_ref().map(|scaled| &scaled[..]), self.order, &state.theta_rad);
        for (matrix, scaled) in matrices.iter_mut().zip(&scaled) {
            for (place, &(constant, _)) in self.open.iter().enumerate() {
                let of_samples = measured.iter().zip(scaled).enumerate();
                of_samples.for_each(|(index, (measured, [r, d]))| {
                    matrix[(index, of_shape + place)] = -r * measured.r_by[constant] - d * measured.d_by[constant];
                });
            }
        }
        matrices
    }

    /// The same with information and gradient.
    pub fn linearised(&self, state: &State) -> Linear {
        self.linearised_at(state, &curve(&state.coefficients, &state.theta_rad))
    }

    /// The same with the contacts of the state.
    fn linearised_at(&self, state: &State, contacts: &[ContactSupport]) -> Linear {
        let unknowns = self.unknowns();
        let measured = self.measured(state);
        let (residuals, slopes) = self.all_missed(contacts, &measured);
        let by_constants = |measured: &Measured| {
            self.open.iter().map(|&(which, _)| [measured.r_by[which], measured.d_by[which]]).collect()
        };
        let constants = measured.iter().map(by_constants).collect();
        let shares: Vec<[f64; 2]> = slopes.iter().map(|slope| across(*slope)).collect();
        let left = shares_of(&shares, &residuals);
        let (jacobian, mut information, mut gradient, joined) = match self.joined(state, &residuals, &slopes) {
            None => {
                let [jacobian] = self.by_unknowns(state, &measured, [&shares]);
                let (information, gradient) = sums_of_outer_products(&[(&jacobian, &left)], unknowns);
                (jacobian, information, gradient, None)
            }
            // What readings tell along the curve as well, less what the angles take of it.
            Some((factor, mut of_angles)) => {
                let lengths: Vec<f64> = slopes.iter().map(|slope| own_information(*slope).sqrt()).collect();
                let shares_along: Vec<[f64; 2]> =
                    slopes.iter().zip(&lengths).map(|([r, d], length)| [r / length, d / length]).collect();
                let left_along = shares_of(&shares_along, &residuals);
                let [jacobian, mut along] = self.by_unknowns(state, &measured, [&shares, &shares_along]);
                let (mut information, mut gradient) =
                    sums_of_outer_products(&[(&jacobian, &left), (&along, &left_along)], unknowns);
                for mut column in along.column_iter_mut() {
                    column.iter_mut().zip(&lengths).for_each(|(element, length)| *element *= length);
                }
                factor.solve_lower_stacked(along.as_mut_slice());
                factor.solve_lower(&mut of_angles, 1);
                let taken = sums_of_outer_products(&[(&along, &of_angles)], unknowns);
                information -= taken.0;
                gradient -= taken.1;
                (jacobian, information, gradient, Some((factor, along)))
            }
        };
        for (index, (off, sd)) in self.off_prior(state).into_iter().zip(self.prior_sds()).enumerate() {
            information[(index, index)] += 1.0 / (sd * sd);
            gradient[index] += off / (sd * sd);
        }
        let scales = [self.noise.r_m, self.noise.d_m];
        let told = Told { residuals, slopes, jacobian, left };
        Linear { told, scales, constants, information, gradient, joined }
    }

    /// Residuals of r and d over their noise where the contact is there, and their derivatives by θ.
    pub(super) fn missed(
        &self,
        ContactSupport { r, d, v }: ContactSupport,
        measured: &Measured,
    ) -> ([f64; 2], [f64; 2]) {
        let Noise { r_m, d_m } = self.noise;
        ([(r - measured.r_m) / r_m, (d - measured.d_m) / d_m], [-d / r_m, (r - v) / d_m])
    }

    /// Information on the angles that depend on each other, and the gradient by them.
    fn joined(
        &self,
        state: &State,
        residuals: &[[f64; 2]],
        slopes: &[[f64; 2]],
    ) -> Option<(BandedCholesky<SPAN>, Vec<f64>)> {
        let (between, sd_rad) = self.between?;
        let mut gradient: Vec<f64> = residuals.iter().zip(slopes).map(|(a, b)| dot(*a, *b)).collect();
        let information = slopes.iter().map(|slope| own_information(*slope));
        let factor = between.joined(information, &state.theta_rad, sd_rad, &mut gradient)?;
        Some((factor, gradient))
    }

    /// The state after a step of the unknowns, each θ at its best for it; and the gain of the last step of these.
    fn stepped(&self, state: &State, step: &DVector<f64>, settled: f64) -> (State, f64) {
        let order = self.order;
        let mut next = state.clone();
        next.coefficients.iter_mut().zip(step.iter()).for_each(|(value, step)| *value += step);
        for (place, &(constant, _)) in self.open.iter().enumerate() {
            next.told[constant] += step[2 * order + 1 + place];
        }
        let turned = self.settle_to(&mut next, settled);
        (next, turned)
    }

    /// The optimum nearest to a start; `None` where nothing is finite.
    pub fn solve(&self, start: State) -> Option<Optimum> {
        self.solve_to(start, SETTLED)
    }

    /// The same until a step lowers the cost by no more than `settled`. The damping follows the ratio of gain and prediction (Madsen, Nielsen &
    /// Tingleff, *Methods for Non-linear Least Squares Problems*, 2004, section 3.2).
    pub fn solve_to(&self, start: State, settled: f64) -> Option<Optimum> {
        let mut state = start;
        coefficients_to_order(&mut state.coefficients, self.order);
        let (mut of_angles, _) = self.settle(&mut state);
        let contacts = curve(&state.coefficients, &state.theta_rad);
        let mut cost = self.cost(&state, &contacts);
        if !cost.is_finite() {
            return None;
        }
        let (mut damping, mut growth) = (FIRST_DAMPING, 2.0);
        let mut linear = self.linearised_at(&state, &contacts);
        for _ in 0..MOST_STEPS {
            let Some(factor) = linear.factorised(&state.coefficients, damping) else {
                damping = (growth * damping).max(1e-12);
                growth *= 2.0;
                if damping > MOST_DAMPING {
                    break;
                }
                continue;
            };
            let step = -factor.solve(&linear.gradient);
            let stiff: f64 = step.iter().zip(linear.information.diagonal().iter()).map(|(x, h)| x * x * h).sum();
            let predicted = 0.5 * (damping * stiff - linear.gradient.dot(&step));
            if predicted + of_angles <= settled {
                break;
            }
            let (next, turned) = self.stepped(&state, &step, settled);
            let contacts = curve(&next.coefficients, &next.theta_rad);
            let lower = self.cost(&next, &contacts);
            let gain = cost - lower;
            if lower.is_finite() && gain >= 0.0 {
                (state, cost, of_angles) = (next, lower, turned);
                linear = self.linearised_at(&state, &contacts);
                if gain <= settled && predicted <= settled {
                    break;
                }
                let ratio = gain / predicted.max(1e-300);
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(LEAST_SHRINKAGE, 1.0);
                growth = 2.0;
            } else {
                damping = (growth * damping).max(1e-12);
                growth *= 2.0;
                if damping > MOST_DAMPING {
                    break;
                }
            }
        }
        Some(Optimum { state, cost, linear })
    }

    /// What a sample costs at the angle next to this one that costs least, half a χ², and that angle.
    pub fn settled(&self, state: &State, index: usize, theta_rad: f64) -> (f64, f64) {
        let measured = self.readings[index].measured(&self.stated.with_told(state.told));
        let mut theta = theta_rad;
        let mut square = 0.0;
        for _ in 0..SETTLING_STEPS {
            let (residual, slope) = self.missed(support(&state.coefficients, theta), &measured);
            square = residual[0] * residual[0] + residual[1] * residual[1];
            let step = turn(residual, slope);
            theta += step;
            if step.abs() < LEAST_TURN_RAD {
                break;
            }
        }
        (0.5 * square, theta)
    }

    /// Newton steps of every θ, until one lowers the cost by no more than `settled`; what the last one lowers it by.
    fn settle_to(&self, state: &mut State, settled: f64) -> f64 {
        let (mut gain, _) = self.settle(state);
        for _ in 1..ANGLE_STEPS {
            if gain <= settled {
                break;
            }
            (gain, _) = self.settle(state);
        }
        gain
    }

    /// One Newton step of every θ; how much it lowers the cost by, half a χ², were that a parabola, and the information on angles that depend on each other.
    pub fn settle(&self, state: &mut State) -> (f64, Option<BandedCholesky<SPAN>>) {
        let errors = self.stated.with_told(state.told);
        let contacts = curve(&state.coefficients, &state.theta_rad);
        let measured = contacts.into_iter().zip(errors.measured(self.readings));
        let (residuals, slopes): (Vec<[f64; 2]>, Vec<[f64; 2]>) =
            measured.map(|(contact, measured)| self.missed(contact, &measured)).unzip();
        match self.joined(state, &residuals, &slopes) {
            Some((factor, mut steps)) => {
                factor.solve_lower(&mut steps, 1);
                let gain = 0.5 * steps.iter().map(|step| step * step).sum::<f64>();
                factor.solve_upper(&mut steps, 1);
                let limited = steps.iter().map(|step| (-step).clamp(-LONGEST_TURN_RAD, LONGEST_TURN_RAD));
                state.theta_rad.iter_mut().zip(limited).for_each(|(theta, step)| *theta += step);
                (gain, Some(factor))
            }
            None => {
                let mut gain = 0.0;
                for ((theta, residual), slope) in state.theta_rad.iter_mut().zip(&residuals).zip(&slopes) {
                    *theta += turn(*residual, *slope);
                    gain += 0.5 * dot(*slope, *residual).powi(2) / own_information(*slope);
                }
                (gain, None)
            }
        }
    }
}

/// Derivative of r(θ) times one share plus d(θ) times another by the coefficients.
pub(super) fn curve_row(theta: f64, order: usize, [r_share, d_share]: [f64; 2]) -> DVector<f64> {
    let mut row = DVector::zeros(2 * order + 1);
    let (sin1, cos1) = theta.sin_cos();
    let (mut cos, mut sin) = (1.0, 0.0);
    row[0] = r_share;
    for k in 1..=order {
        (cos, sin) = (cos * cos1 - sin * sin1, sin * cos1 + cos * sin1);
        let k_share = k as f64 * d_share;
        row[k] = r_share * cos + k_share * sin;
        row[order + k] = r_share * sin - k_share * cos;
    }
    row
}

/// The unit vector across a slope; along d where there is none.
pub(super) fn across(slope: [f64; 2]) -> [f64; 2] {
    let length = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
    if length > 0.0 { [slope[1] / length, -slope[0] / length] } else { [0.0, 1.0] }
}

/// Shares of the residuals of r and d, sample by sample.
fn shares_of(shares: &[[f64; 2]], residuals: &[[f64; 2]]) -> Vec<f64> {
    shares.iter().zip(residuals).map(|(share, residual)| dot(*share, *residual)).collect()
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Information of a reading on its own θ, per radian squared. Without a slope it has none.
fn own_information(slope: [f64; 2]) -> f64 {
    dot(slope, slope) + HELD_INFORMATION
}

/// The change of θ that lowers two residuals most.
fn turn(residual: [f64; 2], slope: [f64; 2]) -> f64 {
    let square = own_information(slope);
    (-dot(slope, residual) / square).clamp(-LONGEST_TURN_RAD, LONGEST_TURN_RAD)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> (Vec<Reading>, State) {
        let coefficients = vec![0.03, 0.002, -0.001, 0.0005, 0.003, 0.0012, -0.0004];
        let theta: Vec<f64> = (0..60).map(|i| 0.1 * f64::from(i) + 0.2).collect();
        let readings = theta
            .iter()
            .map(|theta| {
                let ContactSupport { r, d, .. } = support(&coefficients, *theta);
                Reading { along_m: 0.1 + 0.02 * theta, above_m: r, s_m: 0.1 + 0.02 * theta - d }
            })
            .collect();
        (readings, State { coefficients, told: [0.0; TOLD], theta_rad: theta })
    }

    fn problem(readings: &[Reading]) -> Problem<'_> {
        Problem {
            readings,
            noise: Noise { r_m: 2e-5, d_m: 1e-4 },
            order: 3,
            size_m: 0.03,
            harmonics: HarmonicPrior::of_scale(0.03),
            stated: PivotCalibration::default(),
            open: vec![(0, 5e-4), (1, 0.01), (2, 0.01)],
            between: None,
        }
    }

    /// The gradient is that of finite differences off the optimum, every θ at its best.
    fn assert_gradient(problem: &Problem, state: &State) {
        let off = |unknown: usize, by: f64| {
            let mut moved = state.clone();
            moved.coefficients[2] += 2e-4;
            moved.coefficients[4] -= 1e-4;
            moved.told = [1e-4, 2e-3, 1e-3];
            let coefficients = moved.coefficients.len();
            if unknown < coefficients {
                moved.coefficients[unknown] += by;
            } else {
                moved.told[unknown - coefficients] += by;
            }
            for _ in 0..100 {
                problem.settle(&mut moved);
            }
            moved
        };
        let linear = problem.linearised(&off(0, 0.0));
        for unknown in 0..problem.unknowns() {
            let step = if unknown < 7 { 1e-8 } else { 1e-6 };
            let cost = |by: f64| {
                let state = off(unknown, by);
                problem.cost(&state, &curve(&state.coefficients, &state.theta_rad))
            };
            let slope = (cost(step) - cost(-step)) / (2.0 * step);
            let exact = linear.gradient[unknown];
            assert!((slope - exact).abs() < 1e-4 * exact.abs().max(1e3), "{unknown}: {slope} {exact}");
        }
    }

    #[test]
    fn rows_and_gradient_are_those_of_finite_differences() {
        let (readings, state) = example();
        assert_gradient(&problem(&readings), &state);
    }

    #[test]
    fn angles_that_depend_on_each_other_are_eliminated_as_well() {
        let (readings, state) = example();
        let samples = readings.len();
        let numbers: Vec<usize> = (0..samples).collect();
        let whole = 0..samples;
        let between = MotionBetween::new(std::slice::from_ref(&whole), &numbers, &vec![false; samples]);
        let problem = Problem { between: Some((&between, 0.01)), ..problem(&readings) };
        assert_gradient(&problem, &state);
        // With nothing believed, the angles are known as well as their own readings tell, and no better.
        let loose = Problem { between: Some((&between, 1e3)), ..problem.clone() }.linearised(&state);
        let alone = Problem { between: None, ..problem }.linearised(&state);
        assert!((&loose.information - &alone.information).norm() < 1e-5 * alone.information.norm());
        for (joined, own) in loose.angle_variances().into_iter().zip(alone.angle_variances()) {
            assert!((joined / own - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences() {
        let (readings, state) = example();
        let problem = problem(&readings);
        let linear = problem.linearised(&state);
        let turned = |by: f64| {
            let theta_rad = state.theta_rad.iter().map(|theta| theta + by).collect();
            problem.linearised(&State { theta_rad, ..state.clone() }).told.residuals
        };
        let (up, down) = (turned(1e-6), turned(-1e-6));
        for index in 0..readings.len() {
            for which in 0..2 {
                let slope = (up[index][which] - down[index][which]) / 2e-6;
                assert!((slope - linear.told.slopes[index][which]).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn exact_readings_are_solved_exactly() {
        let (readings, state) = example();
        let problem = Problem { noise: Noise { r_m: 1e-9, d_m: 1e-9 }, open: vec![], ..problem(&readings) };
        let mut start = state.clone();
        start.coefficients.iter_mut().enumerate().for_each(|(i, value)| *value += 1e-4 * (i as f64).sin());
        start.theta_rad.iter_mut().enumerate().for_each(|(i, theta)| *theta += 0.02 * (i as f64).cos());
        let found = problem.solve(start).expect("it is solvable");
        // The same object up to a rotation: heights of the curve agree.
        for (reading, theta) in readings.iter().zip(&found.state.theta_rad) {
            let ContactSupport { r, d, .. } = support(&found.state.coefficients, *theta);
            assert!((r - reading.above_m).abs() < 1e-9);
            assert!((d - (reading.along_m - reading.s_m)).abs() < 1e-9);
        }
        assert!((found.state.coefficients[0] - state.coefficients[0]).abs() < 1e-9);
    }
}
