use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const SIZE_M: f64 = 0.02;
const ORDER: usize = 12;
const NODES: usize = 84;

/// Normal equations of random rows that pull a circle towards a shape with flat sides.
fn pulled(seed: u64, strength: f64) -> (Convexity, Vec<f64>, Normal) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || random.sample::<f64, _>(StandardNormal);
    let unknowns = 2 * ORDER + 1;
    let rows = DMatrix::from_fn(2 * unknowns, unknowns, |_, _| normal() / (1e-2 * SIZE_M));
    let mut target = DVector::zeros(unknowns);
    for k in 2..=ORDER {
        target[k] = strength * SIZE_M * normal() / (k * k) as f64;
    }
    let matrix = rows.transpose() * &rows;
    let gradient = -(&matrix * target);
    let mut coefficients = vec![0.0; unknowns];
    coefficients[0] = SIZE_M;
    let equations =
        Normal { matrix, gradient, psi_offset: Vec::new(), psi_slope: Vec::new(), psi_information: Vec::new() };
    (Convexity::new(ORDER, SIZE_M, NODES), coefficients, equations)
}

fn cost(convexity: &Convexity, coefficients: &[f64], normal: &Normal, step: &DVector<f64>) -> f64 {
    let moved: Vec<f64> = coefficients.iter().zip(step.iter()).map(|(a, b)| a + b).collect();
    (&normal.matrix * step).dot(step) + 2.0 * normal.gradient.dot(step) + penalty(&convexity.residuals(&moved))
}

#[test]
fn without_a_violated_node_the_step_is_that_of_newton() {
    let (convexity, coefficients, normal) = pulled(1, 0.1);
    let (step, factor) = Penalised::new(&convexity, &coefficients, &normal).minimum(0.0).expect("definite");
    let newton = -normal.matrix.clone().cholesky().expect("definite").solve(&normal.gradient);
    assert!((&step - &newton).norm() < 1e-12 * newton.norm());
    assert!((factor.l() * factor.l().transpose() - &normal.matrix).norm() < 1e-10 * normal.matrix.norm());
    // Damping shortens it.
    let (damped, _) = Penalised::new(&convexity, &coefficients, &normal).minimum(1.0).expect("definite");
    assert!(damped.norm() < 0.9 * newton.norm());
}

#[test]
fn the_step_is_the_minimum_of_model_and_penalty() {
    let (mut rounds_were_needed, mut short) = (0, 0);
    for seed in 0..20 {
        let (convexity, coefficients, normal) = pulled(seed, 1.0);
        let at = |step: &DVector<f64>| cost(&convexity, &coefficients, &normal, step);
        let penalised = Penalised::new(&convexity, &coefficients, &normal);
        let (step, factor) = penalised.minimum(0.0).expect("definite");
        let least = at(&step);
        let fall = at(&DVector::zeros(step.len())) - least;
        assert!(fall > 0.0, "seed {seed}");
        // Newton from there, with the nodes that are violated there, gains next to nothing.
        let moved: Vec<f64> = coefficients.iter().zip(step.iter()).map(|(a, b)| a + b).collect();
        let (mut matrix, mut gradient) = (normal.matrix.clone(), &normal.matrix * &step + &normal.gradient);
        let mut row = DVector::zeros(step.len());
        for (node, residual) in convexity.violations(&moved) {
            convexity.row(node, row.as_mut_slice());
            matrix.ger(1.0, &row, &row, 1.0);
            gradient.axpy(residual, &row, 1.0);
            rounds_were_needed += 1;
        }
        let further = -matrix.clone().cholesky().expect("definite").solve(&gradient);
        let best = (0..=100).map(|share| at(&(&step + &further * (0.01 * f64::from(share))))).fold(least, f64::min);
        // A round that other nodes cut short may be the last.
        assert!(least - best < 0.3 * fall, "seed {seed}: {} of {fall}", least - best);
        short += usize::from(least - best > 5.0 * ENOUGH * fall);
        // And the factor is that of one of the last rounds: it solves for a direction of descent.
        assert!(gradient.dot(&factor.solve(&gradient)) >= 0.0);
        let once = -normal.matrix.clone().cholesky().expect("definite").solve(&normal.gradient);
        assert!(least < at(&once), "seed {seed}: no better than without the penalty");
    }
    assert!(rounds_were_needed > 20, "{rounds_were_needed} violated nodes");
    assert!(short <= 5, "{short} of 20 end far from the minimum");
}

#[test]
fn the_minimum_along_a_line_is_where_the_derivative_vanishes() {
    let (from, to) = (vec![-1.0, 2.0, -3.0, 0.5], vec![2.0, 1.0, 4.0, -1.0]);
    for (slope, bent) in [(-20.0, 1.0), (-9.0, 8.0), (-2.0, 0.1), (-1e-3, 0.0)] {
        let at = |t: f64| {
            let penalty: f64 = from.iter().zip(&to).map(|(a, b)| f64::max(0.0, a + t * (b - a)).powi(2)).sum();
            slope * t + 0.5 * bent * t * t + 0.5 * penalty
        };
        let t = along_line(slope - at_zero(&from, &to), bent, &from, &to);
        let least = |t: f64| at(t) - at_zero(&from, &to) * t;
        assert!((0.0..=1.0).contains(&t));
        for other in 0..=1000 {
            assert!(least(t) <= least(f64::from(other) * 1e-3) + 1e-9, "{slope} {bent}: {t}, {other}");
        }
    }
}

/// The slope of the penalty at t = 0.
fn at_zero(from: &[f64], to: &[f64]) -> f64 {
    from.iter().zip(to).map(|(a, b)| f64::max(0.0, *a) * (b - a)).sum()
}

#[test]
fn what_cannot_be_factored_has_no_step() {
    let (convexity, coefficients, mut normal) = pulled(2, 1.0);
    normal.matrix[(3, 3)] = f64::NAN;
    assert!(Penalised::new(&convexity, &coefficients, &normal).minimum(0.0).is_none());
    normal.matrix.fill(0.0);
    assert!(Penalised::new(&convexity, &coefficients, &normal).minimum(0.0).is_none());
}
