//! The residuals of [`super::contact`] for eight samples side by side (SIMD lanes), the Newton steps that project each ψ to its
//! minimum, and rotations that separate ψ from the shape.

use crate::estimate::measurements::Instant;
use crate::estimate::model::contact::supports;
use crate::estimate::model::noise::Noise;
use crate::math::lanes::{LANES, Lanes, Number, sin_cos};
use crate::mechanics::force_model::{ForceModel, MotionState};
use crate::palms::{ContactRow, Contacts, PalmAngles};
use std::marker::PhantomData;

/// An orientation has converged when a further step would lower its squares by less than this (squared standard deviations): a
/// thousandth of its standard deviation.
const CONVERGED: f64 = 1e-6;

/// Largest step of an orientation, radians: beyond it the linearisation does not hold.
const LARGEST_STEP: f64 = 0.1;

/// Eight samples; where the log ends before, the remaining lanes have weight 0.
pub(crate) struct Block<F> {
    force_model: F,
    phi1: Lanes,
    palms: PalmAngles<Lanes>,
    s1: Lanes,
    s2: Lanes,
    /// Of the three residuals, 1/m.
    weights: [Lanes; 3],
}

/// Weighted residuals of eight samples, and their derivatives by ψ.
#[derive(Clone, Copy)]
pub(crate) struct Weighted {
    pub value: [Lanes; 3],
    pub by_psi: [Lanes; 3],
}

/// cos kθ and sin kθ at both contacts, for k = 1 … K.
pub(crate) struct Waves(Vec<[[Lanes; 2]; 2]>);

impl Waves {
    pub fn new(order: usize) -> Self {
        Self(vec![[[Lanes::ZERO; 2]; 2]; order])
    }
}

impl<F: ForceModel> Block<F> {
    /// For at most the first eight instants.
    #[inline(always)]
    pub fn new(force_model: F, instants: &[Instant], noise: Noise) -> Self {
        let mut weights = [Lanes::ZERO; 3];
        for (lane, instant) in instants.iter().take(LANES).enumerate() {
            for (weights, weight) in weights.iter_mut().zip(noise.weights(instant)) {
                weights[lane] = weight;
            }
        }
        let mut each = [&instants[0]; LANES];
        each.iter_mut().zip(instants).for_each(|(lane, instant)| *lane = instant);
        let gather = |field: fn(&Instant) -> f64| -> Lanes { Lanes::from_fn(|lane| field(each[lane])) };
        let palms = PalmAngles {
            sin1: gather(|instant| instant.palms.sin1),
            cos1: gather(|instant| instant.palms.cos1),
            sin12: gather(|instant| instant.palms.sin12),
            cos12: gather(|instant| instant.palms.cos12),
            sin2: gather(|instant| instant.palms.sin2),
            cos2: gather(|instant| instant.palms.cos2),
            inverse2: gather(|instant| instant.palms.inverse2),
        };
        let (phi1, s1, s2) =
            (gather(|instant| instant.phi1), gather(|instant| instant.s1), gather(|instant| instant.s2));
        Self { force_model, phi1, palms, s1, s2, weights }
    }

    /// The residuals at orientations and a shape; `waves` keep cos kθ and sin kθ for k = 1 … K.
    #[inline(always)]
    pub fn at(&self, coefficients: &[f64], psi: &Lanes, waves: Option<&mut Waves>) -> Weighted {
        let (sines, cosines) = sin_cos(self.phi1 - *psi);
        let (cos, sin) = self.palms.contact_directions(sines, cosines);
        let at: Contacts<Lanes> = match waves {
            Some(waves) => {
                let kept = &mut waves.0[..coefficients.len() / 2];
                supports(coefficients, cos, sin, |index, cos, sin| kept[index] = [cos, sin])
            }
            None => supports(coefficients, cos, sin, |_, _, _| ()),
        }
        .into();
        let (r_by_psi, d_by_psi) = at.by_psi();
        let ([s1, s2], [s1_by_psi, s2_by_psi]) =
            (self.palms.positions(at.r, at.d), self.palms.positions(r_by_psi, d_by_psi));
        let forces = self.force_model.residual(&MotionState::at_rest(self.palms, at));
        let [w1, w2, w3] = self.weights;
        Weighted {
            value: [w1 * (s1 - self.s1), w2 * (s2 - self.s2), w3 * forces.value],
            by_psi: [w1 * s1_by_psi, w2 * s2_by_psi, w3 * forces.by_psi],
        }
    }

    /// The derivative by the contacts of the mixture `share` of the three residuals.
    #[inline(always)]
    pub fn mixture(&self, share: &[Lanes; 3]) -> Mixture<F> {
        let [one, two, three] = [self.weights[0] * share[0], self.weights[1] * share[1], self.weights[2] * share[2]];
        let none = Contacts { r: [Lanes::ZERO; 2], d: [Lanes::ZERO; 2], v: [Lanes::ZERO; 2] };
        let of_forces = self.force_model.row(&MotionState::at_rest(self.palms, none));
        let row = self.palms.positions_row([one, two]).plus(three, &of_forces);
        Mixture { row, force_model: PhantomData }
    }

    /// Brings each ψ (as many as there are samples) to the minimum of its own sample by at most `rounds` Gauss-Newton steps; the
    /// residuals there.
    #[inline(always)]
    pub fn project_orientations(
        &self,
        coefficients: &[f64],
        samples: &mut [f64],
        rounds: usize,
        mut waves: Option<&mut Waves>,
    ) -> Weighted {
        let mut psi = Lanes::loaded(samples);
        let mut at = self.at(coefficients, &psi, waves.as_deref_mut());
        let mut open = [true; LANES];
        let mut any_rejected = false;
        for _ in 0..rounds {
            let (square, slope, curvature) = at.sums();
            let mut moved = psi;
            for lane in 0..LANES {
                open[lane] &= (slope[lane] * slope[lane] > CONVERGED * curvature[lane]) & (curvature[lane] > 0.0);
                let step = (slope[lane] / curvature[lane]).clamp(-LARGEST_STEP, LARGEST_STEP);
                moved[lane] -= if open[lane] { step } else { 0.0 };
            }
            if open == [false; LANES] {
                break;
            }
            let there = self.at(coefficients, &moved, waves.as_deref_mut());
            let (next, _, _) = there.sums();
            for lane in 0..LANES {
                let better = open[lane] & (next[lane] < square[lane]);
                any_rejected |= open[lane] & !better;
                open[lane] = better;
            }
            psi.replace(&moved, &open);
            for j in 0..3 {
                at.value[j].replace(&there.value[j], &open);
                at.by_psi[j].replace(&there.by_psi[j], &open);
            }
        }
        if any_rejected && waves.is_some() {
            at = self.at(coefficients, &psi, waves);
        }
        samples.copy_from_slice(&psi.0[..samples.len()]);
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
pub(crate) fn dots(a: &[Lanes; 3], b: &[Lanes; 3]) -> Lanes {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Derivative of a mixture of residuals by the coefficients, as a row over the contacts.
pub(crate) struct Mixture<F> {
    row: ContactRow<Lanes>,
    force_model: PhantomData<F>,
}

impl<F: ForceModel> Mixture<F> {
    /// One element of the derivative, for the coefficients (a0, a1 … aK, b1 … bK).
    #[inline(always)]
    pub fn element(&self, waves: &Waves, index: usize) -> Lanes {
        let ContactRow { r: [r1, r2], d: [d1, d2], v: [v1, v2] } = &self.row;
        let order = waves.0.len();
        if index == 0 {
            return if F::READS_CURVATURE { *r1 + *r2 + *v1 + *v2 } else { *r1 + *r2 };
        }
        let (number, even, odd) = if index <= order {
            let [cos, sin] = &waves.0[index - 1];
            (index as f64, cos, sin)
        } else {
            let [cos, sin] = &waves.0[index - order - 1];
            ((order as f64) - (index as f64), sin, cos)
        };
        let row = *r1 * even[0] + *r2 * even[1] + (*d1 * odd[0] + *d2 * odd[1]) * number;
        if F::READS_CURVATURE {
            // v is r with the k-th harmonic times 1 − k².
            row + (*v1 * even[0] + *v2 * even[1]) * (1.0 - number * number)
        } else {
            row
        }
    }
}

/// Three orthonormal vectors for each sample, the last along `p` (any three, where p vanishes).
#[inline(always)]
pub(crate) fn turned_frames(p: &[Lanes; 3]) -> [[Lanes; 3]; 3] {
    let mut frames = [[Lanes::ZERO; 3]; 3];
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
