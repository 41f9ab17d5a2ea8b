//! Quintic B-splines: values and first two derivatives at any time (Cox and de Boor), and least-squares splines with as many pieces as
//! generalised cross-validation likes.

use super::banded::Banded;

/// Degree of the polynomials between two knots: second derivatives are then smooth as well.
const DEGREE: usize = 5;

/// Basis functions that differ from zero between two knots.
pub(crate) const SUPPORT: usize = DEGREE + 1;

/// Quintic B-splines on given knots.
#[derive(Clone, Debug)]
pub(crate) struct SplineBasis {
    /// The first and the last knot six times each.
    knots: Vec<f64>,
}

/// The basis functions that differ from zero at some time: values, first and second derivatives of `SUPPORT` of them from `first` on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SplineRow {
    pub first: usize,
    pub derivatives: [[f64; SUPPORT]; 3],
}

impl SplineRow {
    /// The derivatives of its value by its coefficients, and the first of these.
    pub fn of_value(&self) -> (usize, [f64; SUPPORT]) {
        (self.first, self.derivatives[0])
    }

    /// Value and first two derivatives of the spline with these coefficients.
    pub fn of(&self, coefficients: &[f64]) -> [f64; 3] {
        let there = &coefficients[self.first..self.first + SUPPORT];
        self.derivatives.map(|row| row.iter().zip(there).map(|(by, of)| by * of).sum())
    }
}

impl SplineBasis {
    /// On knots that increase, at least two.
    pub fn new(knots: &[f64]) -> Self {
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        let mut all = vec![first; DEGREE];
        all.extend_from_slice(knots);
        all.extend([last; DEGREE]);
        Self { knots: all }
    }

    /// Number of coefficients.
    pub fn len(&self) -> usize {
        self.knots.len() - SUPPORT
    }

    /// The basis functions at a time; beyond the ends, those of the first or the last piece go on.
    pub fn at(&self, time: f64) -> SplineRow {
        let knots = &self.knots;
        let after = knots.partition_point(|knot| *knot <= time);
        let piece = after.clamp(SUPPORT, self.len()) - 1;
        // values[i] is that of the basis function piece − degree + i.
        let mut values = [0.0; SUPPORT];
        values[0] = 1.0;
        let mut lower = [[0.0; SUPPORT]; 2];
        for degree in 1..=DEGREE {
            if degree >= DEGREE - 1 {
                lower[DEGREE - degree] = values;
            }
            let mut next = [0.0; SUPPORT];
            for i in 0..degree {
                let (from, to) = (knots[piece + 1 + i - degree], knots[piece + 1 + i]);
                let share = values[i] / (to - from);
                next[i] += (to - time) * share;
                next[i + 1] += (time - from) * share;
            }
            values = next;
        }
        let [of_four, of_three] = lower;
        let first = differentiated(knots, piece, DEGREE, &of_four);
        let second = differentiated(knots, piece, DEGREE, &differentiated(knots, piece, DEGREE - 1, &of_three));
        SplineRow { first: piece - DEGREE, derivatives: [values, first, second] }
    }

    /// Coefficients of a spline that follows the values of a signal at times that increase, straight between them: each is the signal at the mean
    /// of its knots (Schoenberg). `None` with fewer than two values.
    pub fn approximating(&self, times: &[f64], values: &[f64]) -> Option<Vec<f64>> {
        if times.len() < 2 {
            return None;
        }
        let at = |time: f64| {
            let after = times.partition_point(|other| *other < time).clamp(1, times.len() - 1);
            let share = (time - times[after - 1]) / (times[after] - times[after - 1]);
            values[after - 1] + (values[after] - values[after - 1]) * share.clamp(0.0, 1.0)
        };
        let coefficients = self.knots[1..].windows(DEGREE).take(self.len());
        Some(coefficients.map(|knots| at(knots.iter().sum::<f64>() / DEGREE as f64)).collect())
    }

    /// Coefficients of the spline that another one is, on finer knots. `None` where the knots are so uneven that it cannot be told.
    pub fn resampled(&self, other: &Self, coefficients: &[f64]) -> Option<Vec<f64>> {
        let places = |pair: &[f64]| {
            let (from, to) = (pair[0], pair[1]);
            (0..SUPPORT).map(move |i| from + (to - from) * (i as f64 + 0.5) / SUPPORT as f64)
        };
        let times: Vec<f64> = self.knots[DEGREE..self.knots.len() - DEGREE].windows(2).flat_map(places).collect();
        let values: Vec<f64> = times.iter().map(|time| other.at(*time).of(coefficients)[0]).collect();
        self.fitted(&times, &values).map(|(coefficients, _)| coefficients)
    }

    /// The coefficients that fit values at these times best, and the sum of squares that they leave. `None` where a piece has too few of them.
    fn fitted(&self, times: &[f64], values: &[f64]) -> Option<(Vec<f64>, f64)> {
        let mut normal = Banded::zeros(self.len());
        let mut coefficients = vec![0.0; self.len()];
        let rows: Vec<SplineRow> = times.iter().map(|time| self.at(*time)).collect();
        for (row, value) in rows.iter().zip(values) {
            let basis = &row.derivatives[0];
            normal.add_outer_product(row.first, basis, 1.0);
            for (i, by) in basis.iter().enumerate() {
                coefficients[row.first + i] += by * value;
            }
        }
        normal.map_diagonal(|entry| entry * (1.0 + RIDGE));
        let factor = normal.cholesky()?;
        factor.solve_lower(&mut coefficients, 1);
        factor.solve_upper(&mut coefficients, 1);
        let left = rows.iter().zip(values).map(|(row, value)| (row.of(&coefficients)[0] - value).powi(2)).sum();
        Some((coefficients, left))
    }
}

/// Values of the derivatives of the splines of a degree, from those of the splines of one degree less.
fn differentiated(knots: &[f64], piece: usize, degree: usize, lower: &[f64; SUPPORT]) -> [f64; SUPPORT] {
    let mut derivative = [0.0; SUPPORT];
    for i in 0..degree {
        let (from, to) = (knots[piece + 1 + i - degree], knots[piece + 1 + i]);
        let slope = degree as f64 * lower[i] / (to - from);
        derivative[i] -= slope;
        derivative[i + 1] += slope;
    }
    derivative
}

/// Keeps least squares solvable where a piece has hardly any values; far below what any value changes.
const RIDGE: f64 = 1e-12;

/// Values that a piece has, as tried.
const VALUES_PER_PIECE: [usize; 12] = [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96];

/// A least-squares spline through a signal.
#[derive(Clone, Debug)]
pub(crate) struct FittedSpline {
    basis: SplineBasis,
    coefficients: Vec<f64>,
}

impl FittedSpline {
    /// With pieces as long as generalised cross-validation likes. `times` increase. `None` with too few of them.
    pub fn new(times: &[f64], values: &[f64]) -> Option<Self> {
        let candidate = |per_piece: usize| {
            let pieces = (times.len().checked_sub(1)?) / per_piece;
            if pieces < 3 {
                return None;
            }
            let last = times.len() - 1;
            let knots: Vec<f64> = (0..=pieces).map(|i| times[(i * last + pieces / 2) / pieces]).collect();
            let basis = SplineBasis::new(&knots);
            let (coefficients, left) = basis.fitted(times, values)?;
            let redundancy = 1.0 - basis.len() as f64 / times.len() as f64;
            (redundancy > 0.0).then(|| (left / redundancy.powi(2), Self { basis, coefficients }))
        };
        let candidates = VALUES_PER_PIECE.into_iter().filter_map(candidate);
        candidates.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, spline)| spline)
    }

    /// Value and first two derivatives at a time.
    pub fn at(&self, time: f64) -> [f64; 3] {
        self.basis.at(time).of(&self.coefficients)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Knots at uneven places.
    fn basis() -> SplineBasis {
        SplineBasis::new(&[0.0, 0.5, 0.8, 1.7, 2.0, 3.1])
    }

    #[test]
    fn the_basis_functions_add_up_to_one_everywhere() {
        for i in 0..=62 {
            let [values, first, second] =
                basis().at(0.05 * f64::from(i)).derivatives.map(|row| row.iter().sum::<f64>());
            assert!((values - 1.0).abs() < 1e-14 && first.abs() < 1e-12 && second.abs() < 1e-10);
        }
    }

    #[test]
    fn derivatives_match_finite_differences_within_a_piece_and_across_knots() {
        const STEP: f64 = 1e-4;
        let coefficients: Vec<f64> = (0..basis().len()).map(|i| (2.1 * i as f64).sin()).collect();
        let at = |time: f64| basis().at(time).of(&coefficients);
        for time in [0.2, 0.5, 0.65, 0.8, 1.3, 2.0, 2.9] {
            let (before, here, after) = (at(time - STEP), at(time), at(time + STEP));
            for order in 0..2 {
                let slope = (after[order] - before[order]) / (2.0 * STEP);
                assert!((slope - here[order + 1]).abs() < 1e-4, "derivative {order} at {time}");
            }
        }
    }

    #[test]
    fn finer_knots_change_nothing() {
        let coefficients: Vec<f64> = (0..basis().len()).map(|i| (2.1 * i as f64).sin()).collect();
        let knots = [0.0, 0.25, 0.5, 0.65, 0.8, 1.25, 1.7, 1.85, 2.0, 2.55, 3.1];
        let finer = SplineBasis::new(&knots);
        let same = finer.resampled(&basis(), &coefficients).expect("enough places");
        for i in 0..=31 {
            let time = 0.1 * f64::from(i);
            let (before, after) = (basis().at(time).of(&coefficients), finer.at(time).of(&same));
            assert!((before[0] - after[0]).abs() < 1e-8 && (before[2] - after[2]).abs() < 1e-4, "at {time}");
        }
    }

    #[test]
    fn an_approximation_follows_a_signal() {
        let times: Vec<f64> = (0..=31).map(|i| 0.1 * f64::from(i)).collect();
        let line: Vec<f64> = times.iter().map(|t| 2.0 - 3.0 * t).collect();
        let coefficients = basis().approximating(&times, &line).expect("enough values");
        for time in [0.0, 0.7, 1.9, 3.1] {
            assert!((basis().at(time).of(&coefficients)[0] - (2.0 - 3.0 * time)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_quintic_is_reproduced_with_its_derivatives() {
        let times: Vec<f64> = (0..60).map(|i| 0.05 * f64::from(i) + 0.01 * f64::from(i).sin()).collect();
        let values: Vec<f64> = times.iter().map(|t| t.powi(5) - 3.0 * t.powi(3) + t).collect();
        let spline = FittedSpline::new(&times, &values).expect("enough values");
        for t in [0.05_f64, 0.77, 1.9, 2.8] {
            let expected =
                [t.powi(5) - 3.0 * t.powi(3) + t, 5.0 * t.powi(4) - 9.0 * t * t + 1.0, 20.0 * t.powi(3) - 18.0 * t];
            let found = spline.at(t);
            for order in 0..3 {
                assert!((found[order] - expected[order]).abs() < 1e-5, "derivative {order} at {t}: {found:?}");
            }
        }
    }

    #[test]
    fn pieces_are_long_over_noise_and_short_without() {
        let times: Vec<f64> = (0..600).map(|i| 0.01 * f64::from(i)).collect();
        let exact: Vec<f64> = times.iter().map(|t| (3.0 * t).sin()).collect();
        let noisy: Vec<f64> =
            exact.iter().enumerate().map(|(i, x)| x + 1e-3 * (12.9898 * i as f64 * i as f64).sin()).collect();
        let [of_exact, of_noisy] =
            [&exact, &noisy].map(|values| FittedSpline::new(&times, values).expect("enough values"));
        assert!(of_exact.basis.len() > 2 * of_noisy.basis.len());
        for t in [1.0, 2.5, 4.0] {
            assert!((of_exact.at(t)[2] + 9.0 * (3.0 * t).sin()).abs() < 1e-4);
            assert!((of_noisy.at(t)[2] + 9.0 * (3.0 * t).sin()).abs() < 0.1, "{:?}", of_noisy.at(t));
        }
    }

    #[test]
    fn too_few_values_have_no_spline() {
        assert!(FittedSpline::new(&[0.0, 1.0, 2.0, 3.0], &[0.0; 4]).is_none());
        assert!(FittedSpline::new(&[], &[]).is_none());
    }
}
