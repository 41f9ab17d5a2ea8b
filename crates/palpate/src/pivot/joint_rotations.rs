//! Rotations of a group of readings, or of two at once, against the rest: groups that share no boundary are held together by the form of the whole shape
//! alone, and where two of them are wrong, moving one of them may make nothing better.
//!
//! What a group tells, every θ eliminated, is a quadratic form in the coefficients of the shape, ½ xᵀHx + bᵀx. It turns with the group: its harmonics
//! turn by k times the rotation. So all pairs of rotations on a grid are compared by the evidence of a linear model, bᵀA⁻¹b − ln det A of the sums.

use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use crate::estimate::model::layout::{rotate, rotated_covariance};
use crate::math::lanes::{LANES, Lanes, Number};
use crate::pivot::calibration::Reading;
use crate::pivot::rows::sums_of_outer_products;
use crate::pivot::smoother::{Problem, State};

/// Rotations of each group: five degrees apart, for which each θ, which is free, makes up; a multiple of the lanes.
const ROTATIONS: usize = 72;

/// What a group tells of coefficients and constants.
#[derive(Clone, Debug)]
struct Form {
    information: DMatrix<f64>,
    linear: DVector<f64>,
}

impl Form {
    /// At a state that explains the readings.
    fn at(problem: &Problem, state: &State) -> Self {
        let told = problem.told(state);
        let (information, gradient) = sums_of_outer_products(&[(&told.jacobian, &told.left)], problem.unknowns());
        let linear = gradient - &information * DVector::from_column_slice(&state.coefficients);
        Self { information, linear }
    }

    /// Of a group alone, and its contact angles: what the others say of the shape bends how the group sees it.
    fn of(problem: &Problem, state: &State, group: &[usize]) -> Option<(Self, Vec<f64>)> {
        let readings: Vec<Reading> = group.iter().map(|&place| problem.readings[place]).collect();
        let theta_rad = group.iter().map(|&place| state.theta_rad[place]).collect();
        let problem = Problem { readings: &readings, ..problem.clone() };
        let own = problem.solve(State { theta_rad, ..state.clone() })?.state;
        Some((Self::at(&problem, &own), own.theta_rad))
    }

    /// Of no reading.
    fn nothing(unknowns: usize) -> Self {
        Self { information: DMatrix::zeros(unknowns, unknowns), linear: DVector::zeros(unknowns) }
    }

    /// The same of readings whose contact angles are larger by `angle`.
    fn turned(&self, angle: f64) -> Self {
        let mut linear = self.linear.clone();
        rotate(linear.as_mut_slice(), angle);
        Self { information: rotated_covariance(&self.information, angle), linear }
    }
}

/// The cost of each pair of rotations, ½ |L⁻¹b|² less and ln det L more for A = L Lᵀ; those of the second group eight in step.
struct Comparing<'a> {
    rest: &'a Form,
    first: &'a [Form],
    second: &'a [Form],
}

impl WithSimd for Comparing<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let Self { rest, first, second } = self;
        let unknowns = rest.linear.len();
        // The rows of the lower triangle one after another, and b as the last of them.
        let packed = |form: &Form| -> Vec<f64> {
            let row = |row: usize| (0..=row).map(move |column| form.information[(row, column)]);
            (0..unknowns).flat_map(row).chain(form.linear.iter().copied()).collect()
        };
        let begin = |row: usize| row * (row + 1) / 2;
        let side_by_side = |eight: &[Form]| -> Vec<Lanes> {
            let packed: Vec<Vec<f64>> = eight.iter().map(packed).collect();
            (0..packed[0].len()).map(|element| Lanes::from_fn(|lane| packed[lane][element])).collect()
        };
        let second: Vec<Vec<Lanes>> = second.chunks_exact(LANES).map(side_by_side).collect();
        let rest = packed(rest);
        let mut factor = vec![Lanes::ZERO; rest.len()];
        let mut scales = vec![Lanes::ZERO; unknowns];
        let mut costs = Vec::with_capacity(ROTATIONS * ROTATIONS);
        for first in first {
            let both: Vec<f64> = rest.iter().zip(packed(first)).map(|(rest, first)| rest + first).collect();
            for second in &second {
                for ((sum, both), second) in factor.iter_mut().zip(&both).zip(second) {
                    *sum = *second + Lanes::from(*both);
                }
                let (mut determinant, mut square) = (Lanes::from(1.0), Lanes::ZERO);
                for row in 0..=unknowns {
                    let (above, own) = factor.split_at_mut(begin(row));
                    for column in 0..unknowns.min(row) {
                        let mut sum = own[column];
                        for (a, b) in own[..column].iter().zip(&above[begin(column)..]) {
                            sum = sum - *a * *b;
                        }
                        own[column] = sum * scales[column];
                    }
                    let mut squares = Lanes::ZERO;
                    own[..unknowns.min(row)].iter().for_each(|value| squares = squares + *value * *value);
                    if row < unknowns {
                        let diagonal = (own[row] - squares).map(f64::sqrt);
                        determinant = determinant * diagonal;
                        scales[row] = Lanes::from_fn(|lane| 1.0 / diagonal[lane]);
                    } else {
                        square = squares;
                    }
                }
                let cost = determinant.map(f64::ln) - square * 0.5;
                // What is no number is no place.
                costs.extend(cost.0.map(|cost| if cost.is_finite() { cost } else { f64::INFINITY }));
            }
        }
        costs
    }
}

/// States in which a group is turned, or two, each at a maximum of the evidence over all rotations, the best first, with how much less than the best they
/// have, nats. The rotations of the state itself are not among them.
pub(super) fn turned(problem: &Problem, state: &State, group: &[usize], other: Option<&[usize]>) -> Vec<(f64, State)> {
    // The second group turns fastest, eight rotations in step; without another the first does not turn.
    let groups: Vec<&[usize]> = other.into_iter().chain([group]).collect();
    let mut inside = vec![false; problem.readings.len()];
    groups.iter().flat_map(|group| group.iter()).for_each(|&place| inside[place] = true);
    let rest: Vec<usize> = (0..inside.len()).filter(|&place| !inside[place]).collect();
    // The constants of the rig do not turn: harmonics are compared at those of the state.
    let stated = problem.stated.with_told(state.told);
    let fixed = Problem { open: Vec::new(), between: None, stated, ..problem.clone() };
    let own = |group: &[usize]| Form::of(&fixed, state, group);
    let forms: Option<Vec<(Form, Vec<f64>)>> = groups.iter().map(|group| own(group)).collect();
    let (Some((mut rest, _)), Some(forms)) = (own(&rest), forms) else { return Vec::new() };
    for (index, sd) in fixed.prior_sds().into_iter().enumerate() {
        rest.information[(index, index)] += 1.0 / (sd * sd);
    }
    let angle = |turn: usize| TAU * turn as f64 / ROTATIONS as f64;
    let (forms, angles): (Vec<Form>, Vec<Vec<f64>>) = forms.into_iter().unzip();
    let mut turned: Vec<Vec<Form>> =
        forms.iter().map(|form| (0..ROTATIONS).map(|turn| form.turned(angle(turn))).collect()).collect();
    if other.is_none() {
        turned.insert(0, vec![Form::nothing(fixed.unknowns())]);
    }
    let [first, second] = [&turned[0], &turned[1]];
    let solved = |a: usize, b: usize| {
        let information = &rest.information + &first[a].information + &second[b].information;
        let linear = &rest.linear + &first[a].linear + &second[b].linear;
        let factor = Cholesky::new(information)?;
        let log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
        let coefficients = -factor.solve(&linear);
        let cost = 0.5 * linear.dot(&coefficients) + log_determinant;
        cost.is_finite().then_some((cost, coefficients))
    };
    let costs = Arch::new().dispatch(Comparing { rest: &rest, first, second });
    let at = |a: usize, b: usize| costs[(a % first.len()) * ROTATIONS + b % ROTATIONS];
    let is_least = |a: usize, b: usize| {
        let around = (0..9).map(|place| at(a + first.len() + place / 3 - 1, b + ROTATIONS + place % 3 - 1));
        at(a, b).is_finite() && around.into_iter().all(|other| at(a, b) <= other)
    };
    let minima = (0..costs.len())
        .map(|index| (index / ROTATIONS, index % ROTATIONS))
        .filter(|&(a, b)| (a, b) != (0, 0) && is_least(a, b));
    let mut found: Vec<(f64, State)> = minima
        .filter_map(|(a, b)| {
            let (cost, coefficients) = solved(a, b)?;
            let mut turned = State { coefficients: coefficients.as_slice().to_vec(), ..state.clone() };
            let turns = [a, b].into_iter().skip(2 - groups.len());
            for ((group, own_rad), turn) in groups.iter().zip(&angles).zip(turns) {
                group.iter().zip(own_rad).for_each(|(&place, own)| turned.theta_rad[place] = own + angle(turn));
            }
            Some((cost, turned))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = found.first().map_or(0.0, |(cost, _)| *cost).min(at(0, 0));
    found.iter_mut().for_each(|(cost, _)| *cost -= least);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::support;
    use crate::pivot::calibration::PivotCalibration;
    use crate::pivot::harmonic_prior::HarmonicPrior;
    use crate::pivot::smoother::Noise;
    use crate::shape::ContactSupport;

    /// Readings of three arcs that share nothing, and where they were felt.
    fn arcs() -> (Vec<Reading>, State) {
        let coefficients = vec![0.03, 0.004, -0.003, 0.0, 0.002, 0.002, 0.0];
        let theta_rad: Vec<f64> =
            [0.2, 2.4, 4.3].iter().flat_map(|from| (0..20).map(move |index| from + 0.08 * f64::from(index))).collect();
        let reading = |theta: &f64| {
            let ContactSupport { r, d, .. } = support(&coefficients, *theta);
            Reading { along_m: 0.5, above_m: r, s_m: 0.5 - d }
        };
        let readings = theta_rad.iter().map(reading).collect();
        (readings, State { coefficients, told: PivotCalibration::default().told(), theta_rad })
    }

    fn problem(readings: &[Reading]) -> Problem<'_> {
        Problem {
            readings,
            noise: Noise { r_m: 2e-5, d_m: 1e-4 },
            order: 3,
            size_m: 0.03,
            harmonics: HarmonicPrior::of_scale(0.01),
            stated: PivotCalibration::default(),
            open: Vec::new(),
            between: None,
        }
    }

    /// What comes first explains the readings, and what was wrong does not.
    fn assert_mended(problem: &Problem, wrong: State, found: &[(f64, State)]) {
        let best = problem.solve(found[0].1.clone()).expect("an optimum");
        let own = problem.solve(wrong).expect("an optimum").cost;
        assert!(best.cost < 2.0 && own > 100.0, "{own} {}", best.cost);
    }

    #[test]
    fn two_groups_that_were_turned_are_turned_back() {
        let (readings, right) = arcs();
        let problem = problem(&readings);
        let groups: [Vec<usize>; 2] = [(20..40).collect(), (40..60).collect()];
        let mut wrong = right.clone();
        for (group, by) in groups.iter().zip([1.0, -2.1]) {
            group.iter().for_each(|&place| wrong.theta_rad[place] += by);
        }
        let found = turned(&problem, &wrong, &groups[0], Some(&groups[1]));
        assert_mended(&problem, wrong, &found);
    }

    #[test]
    fn a_group_that_was_turned_alone_is_turned_back() {
        let (readings, right) = arcs();
        let problem = problem(&readings);
        let group: Vec<usize> = (20..40).collect();
        let mut wrong = right;
        group.iter().for_each(|&place| wrong.theta_rad[place] += 1.0);
        let found = turned(&problem, &wrong, &group, None);
        assert_mended(&problem, wrong, &found);
    }

    /// As one pair after the other has it.
    #[test]
    fn eight_pairs_are_as_each_of_them() {
        let (readings, state) = arcs();
        let form = |range: std::ops::Range<usize>| {
            let problem = problem(&readings[range.clone()]);
            Form::at(&problem, &State { theta_rad: state.theta_rad[range].to_vec(), ..state.clone() })
        };
        let mut rest = form(0..20);
        (0..7).for_each(|index| rest.information[(index, index)] += 1e4);
        let turned = |form: &Form| (0..ROTATIONS).map(|turn| form.turned(0.087 * turn as f64)).collect::<Vec<Form>>();
        let (first, second) = (turned(&form(20..40)), turned(&form(40..60)));
        let costs = Arch::new().dispatch(Comparing { rest: &rest, first: &first, second: &second });
        assert_eq!(costs.len(), ROTATIONS * ROTATIONS);
        for (a, b) in [(0, 0), (3, 17), (71, 8), (40, 71)] {
            let information = &rest.information + &first[a].information + &second[b].information;
            let linear = &rest.linear + &first[a].linear + &second[b].linear;
            let solved = information.clone().cholesky().expect("positive definite").solve(&linear);
            let expected = 0.5 * information.determinant().ln() - 0.5 * linear.dot(&solved);
            let found = costs[a * ROTATIONS + b];
            assert!((found - expected).abs() < 1e-6 * expected.abs().max(1.0), "{a} {b}: {found} {expected}");
        }
    }

    #[test]
    fn a_form_turns_with_its_group() {
        let (readings, state) = arcs();
        let problem = problem(&readings[..20]);
        let state = State { theta_rad: state.theta_rad[..20].to_vec(), ..state };
        let turned = Form::at(&problem, &state).turned(0.7);
        // The same readings of the shape turned as much.
        let mut moved = state.clone();
        rotate(&mut moved.coefficients, 0.7);
        moved.theta_rad.iter_mut().for_each(|theta| *theta += 0.7);
        let form = Form::at(&problem, &moved);
        assert!((&turned.information - &form.information).norm() < 1e-9 * form.information.norm());
        assert!((&turned.linear - &form.linear).norm() < 1e-6 * form.linear.norm());
    }
}
