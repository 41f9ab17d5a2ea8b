//! The normal equations in the unknowns that all instants share, every orientation eliminated: the Schur complement A − B C⁻¹ Bᵀ
//! of `docs/theory.md`, maximum likelihood, formed by an orthogonal projection of each sample's three rows.

use crate::estimate::measurements::Instant;
use crate::estimate::model::contact_lanes::{Block, Waves, dots, turned_frames};
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::outer_products::OuterProducts;
use crate::math::lanes::{LANES, Lanes};
use crate::mechanics::force_model::ForceModel;
use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Prior information on the change of ψ in one step, rad⁻²: a standard deviation of one radian. Matters only where a sample does
/// not determine ψ.
pub(crate) const PSI_INFORMATION: f64 = 1.0;

/// Samples that one thread takes at a time. The sums over each share are added in order, so that no result depends on the number
/// of threads.
pub(crate) const SHARE: usize = 512 * LANES;

/// The normal equations in the shape alone, at one estimate.
pub(crate) struct Normal {
    pub matrix: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// dψᵢ = offsetᵢ + slopeᵢ · da.
    pub psi_offset: Vec<f64>,
    /// In blocks of eight instants, element by element.
    pub psi_slope: Vec<Lanes>,
    /// Squared norm of the weighted derivative of each sample's residuals by ψ.
    pub psi_information: Vec<f64>,
}

impl Normal {
    /// Derivative of ψ of one instant by the coefficients.
    pub fn psi_slope(&self, instant: usize) -> DVector<f64> {
        let (block, lane) = (instant / LANES * self.gradient.len(), instant % LANES);
        DVector::from_fn(self.gradient.len(), |element, _| self.psi_slope[block + element][lane])
    }

    /// Orientations after a step of the coefficients, given the turn of each without one.
    pub fn turned(&self, psi: &[f64], offset: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let mut turned = psi.to_vec();
        let slopes = self.psi_slope.par_chunks(SHARE / LANES * step.len());
        turned.par_chunks_mut(SHARE).zip(offset.par_chunks(SHARE)).zip(slopes).for_each(|((psi, offset), slopes)| {
            Arch::new().dispatch(Turning { psi, offset, slopes, step: step.as_slice() });
        });
        turned
    }

    /// Information on ψ of one instant from its own sample, given the shape.
    pub fn psi_information(&self, instant: usize) -> f64 {
        self.psi_information[instant]
    }
}

/// Largest turn of an orientation in one step, radians: beyond it the linearisation does not hold.
pub(crate) const LARGEST_TURN: f64 = 0.3;

/// [`Normal::turned`], compiled for several instruction sets.
struct Turning<'a> {
    psi: &'a mut [f64],
    offset: &'a [f64],
    slopes: &'a [Lanes],
    step: &'a [f64],
}

impl WithSimd for Turning<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { psi, offset, slopes, step } = self;
        let blocks = slopes.chunks_exact(step.len().max(1));
        for ((psi, offset), slopes) in psi.chunks_mut(LANES).zip(offset.chunks(LANES)).zip(blocks) {
            let mut turn = Lanes::loaded(offset);
            for (slopes, step) in slopes.iter().zip(step) {
                turn = turn + *slopes * *step;
            }
            psi.iter_mut().zip(turn.0).for_each(|(psi, turn)| *psi += turn.clamp(-LARGEST_TURN, LARGEST_TURN));
        }
    }
}

/// [`super::gauss_newton::Smoother::linearise`] for the samples alone, compiled for several instruction sets.
pub(crate) struct Linearising<'a, F> {
    pub force_model: F,
    pub instants: &'a [Instant],
    pub noise: Noise,
    pub coefficients: &'a [f64],
    pub psi: &'a [f64],
    pub offset: &'a mut [f64],
    pub information: &'a mut [f64],
    pub slopes: &'a mut [Lanes],
}

impl<F: ForceModel> WithSimd for Linearising<'_, F> {
    type Output = OuterProducts;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> OuterProducts {
        let Self { force_model, instants, noise, coefficients, psi, offset, information, slopes } = self;
        let unknowns = coefficients.len();
        let mut sums = OuterProducts::new(unknowns, 3 * psi.len());
        let mut waves = Waves::new(unknowns / 2);
        let of_psi = offset.chunks_mut(LANES).zip(information.chunks_mut(LANES)).zip(slopes.chunks_exact_mut(unknowns));
        let blocks = instants.chunks(LANES).zip(psi.chunks(LANES)).zip(of_psi);
        for ((instants, psi), ((psi_offset, psi_information), slopes)) in blocks {
            let block = Block::new(force_model, instants, noise);
            let at = block.at(coefficients, &Lanes::loaded(psi), Some(&mut waves));
            let information = dots(&at.by_psi, &at.by_psi);
            let [first, second, along] = turned_frames(&at.by_psi);
            for share in [first, second] {
                let mixture = block.mixture(&share);
                sums.push_block(unknowns, dots(&share, &at.value), |index| mixture.element(&waves, index));
            }
            // Along its own derivative ψ absorbs the residual but for the share that its prior information keeps.
            let mixture = block.mixture(&along);
            let value = dots(&along, &at.value);
            let left = information.map(|information| (PSI_INFORMATION / (information + PSI_INFORMATION)).sqrt());
            let scale = information.map(|information| -information.sqrt() / (information + PSI_INFORMATION));
            sums.push_block(unknowns, left * value, |index| {
                let element = mixture.element(&waves, index);
                slopes[index] = scale * element;
                left * element
            });
            psi_offset.copy_from_slice(&(scale * value).0[..psi.len()]);
            psi_information.copy_from_slice(&information.0[..psi.len()]);
        }
        sums
    }
}
