//! Numbers that the kernel of physics computes with: one `f64`, or eight in step ([`Lanes`]), so that the processor takes them together.
//! What is generic over [`Number`] is written once for both.
//!
//! Sine and cosine of eight angles are here too: the standard library takes one at a time, which would be most of the smoother's work.

use std::f64::consts::FRAC_2_PI;
use std::ops::{Add, Index, IndexMut, Mul, Neg, Sub};

/// What formulas are written in.
pub(crate) trait Number:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// Zero.
    const ZERO: Self;
}

impl Number for f64 {
    const ZERO: Self = 0.0;
}

/// How many numbers go in step.
pub(crate) const LANES: usize = 8;

/// One number for each of eight samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes(pub [f64; LANES]);

impl Number for Lanes {
    const ZERO: Self = Self([0.0; LANES]);
}

impl From<f64> for Lanes {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self([value; LANES])
    }
}

impl Lanes {
    /// The first eight of `values`, or as many as there are and then the first again.
    #[inline(always)]
    pub fn loaded(values: &[f64]) -> Self {
        match values.first_chunk() {
            Some(lanes) => Self(*lanes),
            None => Self::from_fn(|lane| values.get(lane).copied().unwrap_or(values[0])),
        }
    }

    /// Lane by lane. A loop of its own: `std::array::from_fn` is not always inlined, and what is not loses the instruction set of its
    /// caller.
    #[inline(always)]
    pub fn from_fn(mut value: impl FnMut(usize) -> f64) -> Self {
        let mut lanes = Self::ZERO;
        for lane in 0..LANES {
            lanes[lane] = value(lane);
        }
        lanes
    }

    /// A function of each.
    #[inline(always)]
    pub fn map(self, mut function: impl FnMut(f64) -> f64) -> Self {
        Self::from_fn(|lane| function(self[lane]))
    }

    /// Takes those of `others` that are `chosen`.
    #[inline(always)]
    pub fn replace(&mut self, others: &Self, chosen: &[bool; LANES]) {
        for lane in 0..LANES {
            self[lane] = if chosen[lane] { others[lane] } else { self[lane] };
        }
    }

    /// The sum over all lanes, in their order.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl Index<usize> for Lanes {
    type Output = f64;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lanes {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::from_fn(|lane| self[lane] + other[lane])
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::from_fn(|lane| self[lane] - other[lane])
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::from_fn(|lane| self[lane] * other[lane])
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self::from_fn(|lane| self[lane] * factor)
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_fn(|lane| -self[lane])
    }
}

/// Angles up to this are reduced to the first quadrant without loss, radians.
const MOST: f64 = 1e6;

/// π/2 in three parts; the first two have so few digits that their products with a million are exact.
const HALF_PI: [f64; 3] =
    [f64::from_bits(0x3FF9_21FB_5440_0000), f64::from_bits(0x3DD0_B461_1A60_0000), 2.022_266_248_795_950_6e-21];

/// Adding this to a number (far smaller) rounds it, and leaves the integer in its last bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// (−1)ⁿ/(2n + 1)! for n = 1 … 7, and (−1)ⁿ/(2n)! for n = 1 … 8: Taylor's series up to π/4, to the last digit.
const SINE: [f64; 7] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COSINE: [f64; 8] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// (sin, cos), to the last digit or two.
#[inline(always)]
pub(crate) fn sin_cos(angles: Lanes) -> (Lanes, Lanes) {
    let (mut sines, mut cosines) = (Lanes::ZERO, Lanes::ZERO);
    if !angles.0.iter().all(|angle| angle.abs() <= MOST) {
        for lane in 0..LANES {
            (sines[lane], cosines[lane]) = angles[lane].sin_cos();
        }
        return (sines, cosines);
    }
    for lane in 0..LANES {
        let shifted = angles[lane] * FRAC_2_PI + ROUNDING;
        let (quarters, quadrant) = (shifted - ROUNDING, shifted.to_bits());
        let [first, second, third] = HALF_PI;
        let x = ((angles[lane] - quarters * first) - quarters * second) - quarters * third;
        let square = x * x;
        let series = |factors: &[f64]| factors.iter().rev().fold(0.0, |sum, factor| (sum + factor) * square);
        let (sine, cosine) = (x + x * series(&SINE), 1.0 + series(&COSINE));
        let swapped = quadrant & 1 == 1;
        let signed = |value: f64, negative: u64| f64::from_bits(value.to_bits() ^ (negative & 2) << 62);
        sines[lane] = signed(if swapped { cosine } else { sine }, quadrant);
        cosines[lane] = signed(if swapped { sine } else { cosine }, quadrant + 1);
    }
    (sines, cosines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_the_standard_library_has_them() {
        let quarters = (-400..400).map(|i| f64::from(i) * std::f64::consts::FRAC_PI_2);
        let near = quarters.flat_map(|x| [x - 1e-9, x, x + 0.1, x + std::f64::consts::FRAC_PI_4]);
        for x in near.chain((0..700).map(|i| (1.37 * f64::from(i)).exp2() % MOST)).chain([0.0, -0.0, MOST, -MOST]) {
            let (sine, cosine) = sin_cos(Lanes([x; LANES]));
            let (expected, other) = x.sin_cos();
            assert!((sine[3] - expected).abs() <= 2.3e-16, "sin {x}: {} {expected}", sine[3]);
            assert!((cosine[3] - other).abs() <= 2.3e-16, "cos {x}: {} {other}", cosine[3]);
        }
    }

    #[test]
    fn what_cannot_be_reduced_is_left_to_the_standard_library() {
        let angles = [0.5, 1e9, -1e300, f64::NAN, f64::INFINITY, 1.0, 2.0, 3.0];
        let (sines, cosines) = sin_cos(Lanes(angles));
        for (lane, angle) in angles.into_iter().enumerate() {
            assert!(sines[lane] == angle.sin() || angle.sin().is_nan() && sines[lane].is_nan());
            assert!(cosines[lane] == angle.cos() || angle.cos().is_nan() && cosines[lane].is_nan());
        }
    }
}
