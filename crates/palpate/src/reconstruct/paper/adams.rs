//! The fourth-order Adams-Bashforth-Moulton predictor-corrector with fixed steps, in the mode PECE (predict, evaluate,
//! correct, evaluate), for slopes that are known on a grid of times only. Three steps of the classical Runge-Kutta method,
//! which also asks for the slope half-way, give the starting values.
//!
//! E. Hairer, S. P. Nørsett and G. Wanner, *Solving Ordinary Differential Equations I*, section III.1, 1993.

/// Runge-Kutta steps at the start: with the first node they give the four slopes that the predictor needs.
pub(crate) const STARTING_STEPS: usize = 3;

/// State and slope at one node of the grid.
pub(crate) type Node<const N: usize> = ([f64; N], [f64; N]);

/// Integrates y' = f from `start` over `steps` steps of length `step`; returns y and y' at all `steps + 1` nodes.
///
/// `slope` is f: it is given the time in *half* steps from the start (an even number at a node; odd numbers, the middles, only
/// within the first [`STARTING_STEPS`] steps) and the state.
pub(crate) fn integrate<const N: usize>(
    start: [f64; N],
    steps: usize,
    step: f64,
    mut slope: impl FnMut(usize, &[f64; N]) -> [f64; N],
) -> Vec<Node<N>> {
    let mut nodes = Vec::with_capacity(steps + 1);
    nodes.push((start, slope(0, &start)));
    for index in 0..steps {
        let (y, f) = nodes[index];
        let next = if index < STARTING_STEPS {
            let f2 = slope(2 * index + 1, &moved(&y, step, [(0.5, &f)]));
            let f3 = slope(2 * index + 1, &moved(&y, step, [(0.5, &f2)]));
            let f4 = slope(2 * index + 2, &moved(&y, step, [(1.0, &f3)]));
            moved(&y, step / 6.0, [(1.0, &f), (2.0, &f2), (2.0, &f3), (1.0, &f4)])
        } else {
            let [f1, f2, f3] = [1, 2, 3].map(|back| &nodes[index - back].1);
            let predicted = moved(&y, step / 24.0, [(55.0, &f), (-59.0, f1), (37.0, f2), (-9.0, f3)]);
            let ahead = slope(2 * index + 2, &predicted);
            moved(&y, step / 24.0, [(9.0, &ahead), (19.0, &f), (-5.0, f1), (1.0, f2)])
        };
        nodes.push((next, slope(2 * index + 2, &next)));
    }
    nodes
}

/// y + step Σ weight · slope.
fn moved<const N: usize, const TERMS: usize>(y: &[f64; N], step: f64, terms: [(f64, &[f64; N]); TERMS]) -> [f64; N] {
    std::array::from_fn(|i| y[i] + step * terms.iter().map(|(weight, slope)| weight * slope[i]).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum-like system with forcing whose solution is known: y = (sin t + t/5, e^(−t/2) cos 2t).
    fn error(steps: usize) -> f64 {
        let truth = |t: f64| [t.sin() + 0.2 * t, (-0.5 * t).exp() * (2.0 * t).cos()];
        let step = 5.0 / steps as f64;
        let nodes = integrate(truth(0.0), steps, step, |half, y| {
            let t = 0.5 * half as f64 * step;
            let [one, two] = truth(t);
            let drift = -0.5 * two - 2.0 * (-0.5 * t).exp() * (2.0 * t).sin();
            // Terms that vanish on the solution make the slope depend on the state, and not linearly.
            [t.cos() + 0.2 + (y[1] - two).sin() - (y[0] - one), drift + (y[0] - one) * y[1]]
        });
        let last = truth(5.0);
        (nodes[steps].0[0] - last[0]).hypot(nodes[steps].0[1] - last[1])
    }

    #[test]
    fn the_order_is_four() {
        let errors = [320, 640, 1280].map(error);
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 4.0).abs() < 0.2, "{order} from {errors:?}");
        }
    }

    #[test]
    fn cubic_polynomials_come_out_exactly() {
        let nodes = integrate([1.0], 10, 0.3, |half, _| {
            let t = 0.15 * half as f64;
            [3.0 * t * t - 2.0]
        });
        assert!((nodes[10].0[0] - (27.0 - 6.0 + 1.0)).abs() < 1e-12);
    }

    #[test]
    fn zero_steps_return_the_start() {
        assert_eq!(integrate([2.0], 0, 1.0, |_, y| [-y[0]]), [([2.0], [-2.0])]);
    }
}
