//! Levenberg and Marquardt's method for normal equations shaped like an arrow.

use super::arrow::Arrow;
use nalgebra::DVector;

/// A cost that is half a sum of squares, nearly.
pub(crate) trait LeastSquares {
    /// Unknowns, with what depends on them.
    type Point;

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

/// What is spent on the way to an optimum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Steps at most.
    pub steps: usize,
    /// The relative change of the cost that ends them.
    pub tolerance: f64,
    /// Whether a valley that is long, narrow and bends, as that of a motion which forces hold tightly, is followed to its end. From afar, and where the cost is
    /// smooth near by only, long steps lead to optima that are worse.
    pub follows_valleys: bool,
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
    Effort { steps, tolerance, follows_valleys }: Effort,
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
            if promised_fall(&arrow).is_none_or(|promised| promised <= tolerance * at.cost.abs()) {
                break;
            }
            damping = LEAST_DAMPING;
        }
        let second_steps = if follows_valleys { SECOND_STEPS } else { 0 };
        let Some((lower, damped_by)) = lower(problem, &at, &arrow, (damping, second_steps)) else { break };
        fell_little = at.cost - lower.cost <= tolerance * lower.cost.abs();
        damping = (damped_by * LESS_DAMPING).max(LEAST_DAMPING);
        at = lower;
        if fell_little && !follows_valleys {
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
    (mut damping, mut second_steps): (f64, usize),
) -> Option<(Costed<P::Point>, f64)> {
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

/// By how much the quadratic that the normal equations are falls to its minimum. `None` where it has none.
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
    struct Valley {
        steep: f64,
        n: i32,
        is_spent: bool,
    }

    impl Valley {
        const BENDS: Self = Self { steep: 30.0, n: 2, is_spent: false };
        const STRAIGHT: Self = Self { steep: 1e4, n: 1, is_spent: false };
    }

    impl LeastSquares for Valley {
        type Point = [f64; 2];

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

    fn effort(follows_valleys: bool) -> Effort {
        Effort { steps: 25, tolerance: 1e-4, follows_valleys }
    }

    /// Where the valley is followed to its end, and where not.
    fn costs_at_the_end(of: &Valley, start: [f64; 2]) -> [f64; 2] {
        [true, false].map(|follows_valleys| minimise(of, start, effort(follows_valleys)).expect("worth it").1)
    }

    #[test]
    fn a_valley_that_bends_is_followed_to_its_end() {
        let [followed, other] = costs_at_the_end(&Valley::BENDS, [-1.2, 1.44]);
        assert!(followed < 1e-12 && other > 0.1, "{followed} {other}");
    }

    #[test]
    fn steps_that_fall_little_as_they_are_damped_are_not_the_last() {
        let [followed, other] = costs_at_the_end(&Valley::STRAIGHT, [0.0, 0.0]);
        assert!(followed < 1e-6 && other > 0.4, "{followed} {other}");
    }

    #[test]
    fn what_is_worth_no_more_steps_has_no_optimum() {
        let spent = Valley { is_spent: true, ..Valley::BENDS };
        assert!(minimise(&spent, [-1.2, 1.44], effort(true)).is_none());
    }
}
