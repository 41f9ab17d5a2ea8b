//! Levenberg and Marquardt's method for normal equations shaped like an arrow.

use super::arrow::Arrow;
use nalgebra::DVector;

/// A cost that is half a sum of squares, nearly.
pub(crate) trait LeastSquares {
    /// Unknowns, with what depends on them.
    type Point;

    /// Whether the way to the optimum leads along a valley that is long, narrow and bends, and is followed to its end: that of a motion which forces hold
    /// tightly. Where the cost is smooth near by only, as contact modes make it, long steps lead to optima that are worse.
    const FOLLOWS_VALLEYS: bool;

    fn cost(&self, at: &Self::Point) -> f64;

    /// The normal equations there.
    fn arrow(&self, at: &Self::Point) -> Arrow;

    /// The point after a step of the dense unknowns and of those in the band.
    fn stepped(&self, from: &Self::Point, dense: &DVector<f64>, band: &[f64]) -> Self::Point;

    /// Whether it is worth no more steps.
    fn is_spent(&self) -> bool {
        false
    }
}

/// Damping of the first step, factors by which it changes, its largest and its least value.
const DAMPING: f64 = 1e-3;
const LESS_DAMPING: f64 = 0.125;
const MORE_DAMPING: f64 = 6.0;
const MOST_DAMPING: f64 = 1e8;
const LEAST_DAMPING: f64 = 1e-10;

/// Second steps that are tried at most on the way to one that lowers the cost: each takes as long as a step, and from far they lead nowhere.
const SECOND_STEPS: usize = 4;

/// The optimum from some start, and its cost, after at most so many steps; ends where one lowers the cost by no more than its share `tolerance`, or,
/// along a valley, where none is promised to. `None` where it is worth no more steps.
pub(crate) fn minimise<P: LeastSquares>(
    problem: &P,
    start: P::Point,
    steps: usize,
    tolerance: f64,
) -> Option<(P::Point, f64)> {
    let mut at = Costed::new(problem, start);
    let (mut damping, mut fell_little) = (DAMPING, false);
    for _ in 0..steps {
        if problem.is_spent() {
            return None;
        }
        let arrow = problem.arrow(&at.point);
        if fell_little {
            // A damped step falls little too where the valley is long and narrow.
            if promised_fall(&arrow)? <= tolerance * at.cost.abs() {
                break;
            }
            damping = LEAST_DAMPING;
        }
        let Some((lower, damped_by)) = lower(problem, &at, &arrow, damping) else { break };
        fell_little = at.cost - lower.cost <= tolerance * lower.cost.abs();
        let ends = fell_little && !P::FOLLOWS_VALLEYS;
        damping = (damped_by * LESS_DAMPING).max(LEAST_DAMPING);
        at = lower;
        if ends {
            break;
        }
    }
    at.cost.is_finite().then_some((at.point, at.cost))
}

/// A point with its cost.
struct Costed<T> {
    point: T,
    cost: f64,
}

impl<T> Costed<T> {
    fn new<P: LeastSquares<Point = T>>(problem: &P, point: T) -> Self {
        let cost = problem.cost(&point);
        Self { point, cost }
    }

    /// After the step of these normal equations.
    fn stepped<P: LeastSquares<Point = T>>(&self, problem: &P, arrow: &Arrow, damping: f64) -> Option<Self> {
        let (dense, band) = arrow.eliminated(damping)?.step(arrow);
        Some(Self::new(problem, problem.stepped(&self.point, &dense, &band)))
    }
}

/// A point of lower cost, and by how much the step there was damped: by as little as that takes, from `damping` on. A step that does not lower the cost is
/// followed by one from where it led: along a valley that bends the first leads up its side, and the second back to its floor, further on.
fn lower<P: LeastSquares>(
    problem: &P,
    from: &Costed<P::Point>,
    arrow: &Arrow,
    mut damping: f64,
) -> Option<(Costed<P::Point>, f64)> {
    let mut second_steps = if P::FOLLOWS_VALLEYS { SECOND_STEPS } else { 0 };
    while damping <= MOST_DAMPING {
        let is_lower = |there: &Costed<P::Point>| there.cost < from.cost;
        let first = from.stepped(problem, arrow, damping);
        let found = first.and_then(|there| {
            if is_lower(&there) {
                return Some(there);
            }
            if second_steps == 0 || !there.cost.is_finite() {
                return None;
            }
            second_steps -= 1;
            there.stepped(problem, &problem.arrow(&there.point), damping).filter(is_lower)
        });
        if let Some(found) = found {
            return Some((found, damping));
        }
        damping *= MORE_DAMPING;
    }
    None
}

/// By how much the quadratic that the normal equations are falls to its minimum.
fn promised_fall(arrow: &Arrow) -> Option<f64> {
    let (dense, band) = arrow.eliminated(0.0)?.step(arrow);
    let of_band: f64 = arrow.band_gradient.iter().zip(&band).map(|(by, step)| by * step).sum();
    Some(-0.5 * (arrow.dense_gradient.dot(&dense) + of_band))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::solver::arrow::ArrowBuilder;
    use crate::math::spline::SUPPORT;

    /// Residuals 1 − x and steep·(y − xⁿ), with coefficients of a spline that are nothing: Rosenbrock's valley with n = 2, a straight one with n = 1.
    struct Valley<const FOLLOWED: bool> {
        steep: f64,
        n: i32,
        is_spent: bool,
    }

    impl<const FOLLOWED: bool> Valley<FOLLOWED> {
        const BENDS: Self = Self { steep: 30.0, n: 2, is_spent: false };
        const STRAIGHT: Self = Self { steep: 1e4, n: 1, is_spent: false };
    }

    impl<const FOLLOWED: bool> LeastSquares for Valley<FOLLOWED> {
        type Point = [f64; 2];

        const FOLLOWS_VALLEYS: bool = FOLLOWED;

        fn cost(&self, &[x, y]: &[f64; 2]) -> f64 {
            0.5 * ((1.0 - x).powi(2) + (self.steep * (y - x.powi(self.n))).powi(2))
        }

        fn arrow(&self, &[x, y]: &[f64; 2]) -> Arrow {
            let Self { steep, n, .. } = *self;
            let mut builder = ArrowBuilder::new(2, SUPPORT);
            builder.add(1.0 - x, &[-1.0, 0.0], (0, [0.0; SUPPORT]));
            let by_x = -steep * f64::from(n) * x.powi(n - 1);
            builder.add(steep * (y - x.powi(n)), &[by_x, steep], (0, [0.0; SUPPORT]));
            for i in 0..SUPPORT {
                builder.add(0.0, &[0.0; 2], (0, std::array::from_fn(|j| f64::from(u8::from(i == j)))));
            }
            builder.finish()
        }

        fn stepped(&self, &[x, y]: &[f64; 2], dense: &DVector<f64>, _: &[f64]) -> [f64; 2] {
            [x + dense[0], y + dense[1]]
        }

        fn is_spent(&self) -> bool {
            self.is_spent
        }
    }

    fn cost_at_the_end<const FOLLOWED: bool>(of: &Valley<FOLLOWED>, start: [f64; 2]) -> f64 {
        minimise(of, start, 25, 1e-4).expect("worth it").1
    }

    #[test]
    fn a_valley_that_bends_is_followed_to_its_end() {
        let start = [-1.2, 1.44];
        assert!(cost_at_the_end(&Valley::<true>::BENDS, start) < 1e-12);
        assert!(cost_at_the_end(&Valley::<false>::BENDS, start) > 0.1);
    }

    #[test]
    fn steps_that_fall_little_as_they_are_damped_are_not_the_last() {
        let start = [0.0, 0.0];
        assert!(cost_at_the_end(&Valley::<true>::STRAIGHT, start) < 1e-6);
        assert!(cost_at_the_end(&Valley::<false>::STRAIGHT, start) > 0.4);
    }

    #[test]
    fn what_is_worth_no_more_steps_has_no_optimum() {
        let spent = Valley::<true> { is_spent: true, ..Valley::BENDS };
        assert!(minimise(&spent, [-1.2, 1.44], 25, 1e-6).is_none());
    }
}
