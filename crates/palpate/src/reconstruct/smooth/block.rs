//! Eight samples in step, so that the processor takes them together: the residuals of [`super::super::residuals`], lane by lane.

use super::Noise;
use super::trigonometry::sin_cos;
use crate::reconstruct::problem::Instant;
use crate::reconstruct::residuals::supports;

/// Samples that are taken together.
pub(super) const LANES: usize = 8;

/// One number for each of them.
pub(super) type Lanes = [f64; LANES];

/// Eight numbers, or as many as there are and then the first again.
#[inline(always)]
pub(super) fn loaded(values: &[f64]) -> Lanes {
    match values.first_chunk() {
        Some(lanes) => *lanes,
        None => std::array::from_fn(|lane| values.get(lane).copied().unwrap_or(values[0])),
    }
}

/// Eight samples; where the log ends before, the rest weigh nothing.
pub(super) struct Block {
    phi1: Lanes,
    sin1: Lanes,
    sin12: Lanes,
    cos2: Lanes,
    sin2: Lanes,
    inverse2: Lanes,
    s1: Lanes,
    s2: Lanes,
    /// Of the three residuals, 1/m.
    weights: [Lanes; 3],
}

/// Weighted residuals of eight samples, and their derivatives by ψ.
#[derive(Clone, Copy)]
pub(super) struct Weighted {
    pub value: [Lanes; 3],
    pub by_psi: [Lanes; 3],
}

/// cos kθ and sin kθ at both contacts, for k = 1 … K: those of contact 1 in the first lanes, of contact 2 in the last.
pub(super) struct Waves(Vec<[[f64; 2 * LANES]; 2]>);

impl Waves {
    pub fn new(order: usize) -> Self {
        Self(vec![[[0.0; 2 * LANES]; 2]; order])
    }
}

impl Block {
    /// Of the first eight instants at the most.
    #[inline(always)]
    pub fn new(instants: &[Instant], noise: Noise) -> Self {
        let mut weights = [[0.0; LANES]; 3];
        for (lane, instant) in instants.iter().take(LANES).enumerate() {
            for (weights, weight) in weights.iter_mut().zip(noise.weights(instant)) {
                weights[lane] = weight;
            }
        }
        let gather = |field: fn(&Instant) -> f64| -> Lanes {
            std::array::from_fn(|lane| field(instants.get(lane).unwrap_or(&instants[0])))
        };
        let sin2 = gather(|instant| instant.sin2);
        Self {
            phi1: gather(|instant| instant.phi1),
            sin1: gather(|instant| instant.sin1),
            sin12: gather(|instant| instant.sin12),
            cos2: gather(|instant| instant.cos2),
            sin2,
            inverse2: sin2.map(|sin2| 1.0 / sin2),
            s1: gather(|instant| instant.s1),
            s2: gather(|instant| instant.s2),
            weights,
        }
    }

    /// The residuals at orientations and a shape; `waves` keep cos kθ and sin kθ for k = 1 … K.
    #[inline(always)]
    pub fn at(&self, coefficients: &[f64], psi: &Lanes, waves: Option<&mut Waves>) -> Weighted {
        let (mut cos, mut sin) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        // θ1 = φ1 − ψ − π/2, θ2 = θ1 + φ2 − π: one sine and cosine serve both.
        let (sines, cosines) = sin_cos(&std::array::from_fn(|lane| self.phi1[lane] - psi[lane]));
        for lane in 0..LANES {
            (cos[lane], sin[lane]) = (sines[lane], -cosines[lane]);
        }
        for lane in 0..LANES {
            cos[LANES + lane] = sin[lane] * self.sin2[lane] - cos[lane] * self.cos2[lane];
            sin[LANES + lane] = -(sin[lane] * self.cos2[lane] + cos[lane] * self.sin2[lane]);
        }
        let both = match waves {
            Some(waves) => {
                let kept = &mut waves.0[..coefficients.len() / 2];
                supports(coefficients, cos, sin, |index, cos, sin| kept[index] = [cos, sin])
            }
            None => supports(coefficients, cos, sin, |_, _, _| ()),
        };
        let mut at = Weighted { value: [[0.0; LANES]; 3], by_psi: [[0.0; LANES]; 3] };
        for lane in 0..LANES {
            let (r1, r2) = (both.r[lane], both.r[LANES + lane]);
            let (d1, d2) = (both.d[lane], both.d[LANES + lane]);
            let (bent1, bent2) = (r1 - both.v[lane], r2 - both.v[LANES + lane]);
            let (cos2, inverse) = (self.cos2[lane], self.inverse2[lane]);
            let [w1, w2, w3] = [self.weights[0][lane], self.weights[1][lane], self.weights[2][lane]];
            at.value[0][lane] = w1 * ((r1 * cos2 + r2) * inverse - d1 - self.s1[lane]);
            at.value[1][lane] = w2 * ((r2 * cos2 + r1) * inverse + d2 - self.s2[lane]);
            at.value[2][lane] = w3 * (d1 * self.sin12[lane] + d2 * self.sin1[lane]);
            at.by_psi[0][lane] = w1 * ((d1 * cos2 + d2) * inverse + bent1);
            at.by_psi[1][lane] = w2 * ((d2 * cos2 + d1) * inverse - bent2);
            at.by_psi[2][lane] = w3 * (-bent1 * self.sin12[lane] - bent2 * self.sin1[lane]);
        }
        at
    }

    /// What the mixture `share` of the three residuals makes of r1, r2, d1 and d2.
    #[inline(always)]
    pub fn mixture(&self, share: &[Lanes; 3]) -> Mixture {
        let mut mixture = Mixture { r: [[0.0; LANES]; 2], d: [[0.0; LANES]; 2] };
        let [first, second, third] = share;
        for lane in 0..LANES {
            let inverse = self.inverse2[lane];
            let ratio = self.cos2[lane] * inverse;
            let one = self.weights[0][lane] * first[lane];
            let two = self.weights[1][lane] * second[lane];
            let three = self.weights[2][lane] * third[lane];
            mixture.r[0][lane] = one * ratio + two * inverse;
            mixture.r[1][lane] = one * inverse + two * ratio;
            mixture.d[0][lane] = three * self.sin12[lane] - one;
            mixture.d[1][lane] = three * self.sin1[lane] + two;
        }
        mixture
    }

    /// Brings each ψ (as many as there are samples) to the minimum of its own sample by a few Newton steps; the residuals there.
    #[inline(always)]
    pub fn settle(
        &self,
        coefficients: &[f64],
        samples: &mut [f64],
        rounds: usize,
        mut waves: Option<&mut Waves>,
    ) -> Weighted {
        let mut psi = loaded(samples);
        let mut at = self.at(coefficients, &psi, waves.as_deref_mut());
        let mut open = [true; LANES];
        let mut taken_back = false;
        for _ in 0..rounds {
            let (square, slope, curvature) = at.sums();
            let mut moved = psi;
            for lane in 0..LANES {
                // Worth less than 1e-6 of a squared standard deviation: settled.
                open[lane] &= slope[lane] * slope[lane] > 1e-6 * curvature[lane] && curvature[lane] > 0.0;
                let step = (slope[lane] / curvature[lane]).clamp(-0.1, 0.1);
                moved[lane] -= if open[lane] { step } else { 0.0 };
            }
            if open == [false; LANES] {
                break;
            }
            let there = self.at(coefficients, &moved, waves.as_deref_mut());
            let (next, _, _) = there.sums();
            for lane in 0..LANES {
                let better = open[lane] && next[lane] < square[lane];
                taken_back |= open[lane] && !better;
                open[lane] = better;
                psi[lane] = if better { moved[lane] } else { psi[lane] };
                for j in 0..3 {
                    let (value, by_psi) = (&mut at.value[j][lane], &mut at.by_psi[j][lane]);
                    *value = if better { there.value[j][lane] } else { *value };
                    *by_psi = if better { there.by_psi[j][lane] } else { *by_psi };
                }
            }
        }
        if taken_back && waves.is_some() {
            at = self.at(coefficients, &psi, waves);
        }
        samples.copy_from_slice(&psi[..samples.len()]);
        at
    }
}

impl Weighted {
    /// Σ e², Σ e p and Σ p² over the three residuals e with the derivatives p.
    #[inline(always)]
    pub fn sums(&self) -> (Lanes, Lanes, Lanes) {
        (dots(&self.value, &self.value), dots(&self.value, &self.by_psi), dots(&self.by_psi, &self.by_psi))
    }
}

/// Inner products, lane by lane.
#[inline(always)]
pub(super) fn dots(a: &[Lanes; 3], b: &[Lanes; 3]) -> Lanes {
    std::array::from_fn(|lane| a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane])
}

/// Derivative of a mixture of residuals by the coefficients, in r1, r2 and d1, d2.
pub(super) struct Mixture {
    r: [Lanes; 2],
    d: [Lanes; 2],
}

impl Mixture {
    /// One element of the derivative, for the coefficients (a0, a1 … aK, b1 … bK).
    #[inline(always)]
    pub fn element(&self, waves: &Waves, index: usize) -> Lanes {
        let Self { r: [r1, r2], d: [d1, d2] } = self;
        let order = waves.0.len();
        if index == 0 {
            return std::array::from_fn(|lane| r1[lane] + r2[lane]);
        }
        let (number, even, odd) = if index <= order {
            let [cos, sin] = &waves.0[index - 1];
            (index as f64, cos, sin)
        } else {
            let [cos, sin] = &waves.0[index - order - 1];
            ((order as f64) - (index as f64), sin, cos)
        };
        std::array::from_fn(|lane| {
            let (one, two) = (lane, LANES + lane);
            r1[lane] * even[one] + r2[lane] * even[two] + number * (d1[lane] * odd[one] + d2[lane] * odd[two])
        })
    }
}

/// Three orthonormal vectors for each sample, the last along `p` (any three, where p vanishes).
#[inline(always)]
pub(super) fn turned_frames(p: &[Lanes; 3]) -> [[Lanes; 3]; 3] {
    let mut frames = [[[0.0; LANES]; 3]; 3];
    for lane in 0..LANES {
        let p = [p[0][lane], p[1][lane], p[2][lane]];
        let norm = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        let inverse = if norm > 0.0 { 1.0 / norm } else { 0.0 };
        let along = [p[0] * inverse, p[1] * inverse, if norm > 0.0 { p[2] * inverse } else { 1.0 }];
        // Householder reflection that carries p to the third axis; its other two columns span the complement.
        let sign = if p[2] < 0.0 { -1.0 } else { 1.0 };
        let u = [along[0], along[1], along[2] + sign];
        let beta = 2.0 / (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        frames[0][0][lane] = 1.0 - beta * u[0] * u[0];
        frames[0][1][lane] = -beta * u[0] * u[1];
        frames[0][2][lane] = -beta * u[0] * u[2];
        frames[1][0][lane] = -beta * u[0] * u[1];
        frames[1][1][lane] = 1.0 - beta * u[1] * u[1];
        frames[1][2][lane] = -beta * u[1] * u[2];
        for (frame, along) in frames[2].iter_mut().zip(along) {
            frame[lane] = along;
        }
    }
    frames
}
