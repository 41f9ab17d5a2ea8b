//! The noise that the search assumes (`docs/theory.md`, the search): more than that of the contacts, for what the closed forms
//! and few harmonics leave.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::reconstruct::search::beam::EXPLAINED;

/// A misfit is that of the noise when it is at most this many times its expectation (two squares for each instant).
const NOISE_MISFIT: f64 = 2.0;

/// Least misfit per instant that counts as that of the noise: an exact log leaves the errors of few harmonics.
const LEAST_NOISE_MISFIT: f64 = 0.5;

/// Least noise of the search, as a share of the scale: loose, so that no start is trapped in the narrow valley of the exact
/// problem; and sharp, at which arrangements are judged.
const LOOSE: f64 = 0.01;
const SHARP: f64 = 0.003;

/// Standard deviation of the balance, over that of the contacts, at which it says nothing.
const CONTACT_ALONE: f64 = 1e4;

/// The noise that the search assumes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// Scatter of the contact positions, metres.
    pub scatter_m: f64,
    /// Length that errors of the search are a share of, metres ([`Measurements::scale_m`]).
    pub scale_m: f64,
    /// Standard deviation of the balance as a multiple of that of the contacts, for growing and for judging arrangements.
    pub balance: [f64; 2],
}

impl Tolerance {
    /// For an object that was felt like this.
    pub fn new(measurements: &Measurements, scatter_m: f64, balance: [f64; 2]) -> Self {
        Self { scatter_m, scale_m: measurements.scale_m(), balance }
    }

    /// For a search by contact alone, whatever the forces are.
    pub fn of_contact_alone(self) -> Self {
        Self { balance: [CONTACT_ALONE; 2], ..self }
    }

    /// Whether the balance says nothing, so that objects may roll.
    pub fn is_of_contact_alone(&self) -> bool {
        self.balance == [CONTACT_ALONE; 2]
    }

    /// At a share of the scale, never below the scatter.
    fn at(&self, share: f64, balance: f64) -> Noise {
        let sd = (share * self.scale_m).max(self.scatter_m);
        Noise { sensor_m: sd, balance_m: balance * sd }
    }

    /// The noise at which windows are placed.
    pub fn loose(&self) -> Noise {
        self.at(LOOSE, self.balance[0])
    }

    /// The noise at which arrangements are judged.
    pub fn sharp(&self) -> Noise {
        self.at(SHARP, self.balance[1])
    }

    /// The largest misfit per instant that is attributed to the noise of samples thinned to so many instants.
    pub fn noise_misfit(&self, instants: usize, samples: usize) -> f64 {
        let noise = self.scatter_m / self.sharp().sensor_m;
        (NOISE_MISFIT * 2.0 * noise * noise * instants as f64 / samples.max(1) as f64)
            .clamp(LEAST_NOISE_MISFIT, EXPLAINED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE_M: f64 = 0.02;
    const TOLERANCE: Tolerance = Tolerance { scatter_m: 1e-5, scale_m: SIZE_M, balance: [1.0, 1.0] };

    #[test]
    fn the_noise_misfit_is_that_of_thinned_samples_within_limits() {
        let tolerance = |scatter_m: f64| Tolerance { scatter_m, ..TOLERANCE };
        // Noise as large as that at which arrangements are judged: two squares for each instant, several times over.
        let noisy = tolerance(1e-3);
        assert_eq!(noisy.sharp().sensor_m, noisy.scatter_m);
        assert!((noisy.noise_misfit(10, 25) - NOISE_MISFIT * 2.0 * 10.0 / 25.0).abs() < 1e-12);
        // Half of that noise: a quarter of the squares.
        let half = tolerance(0.5 * TOLERANCE.sharp().sensor_m);
        assert!((half.noise_misfit(8, 9) - NOISE_MISFIT * 0.5 * 8.0 / 9.0).abs() < 1e-12);
        assert_eq!(noisy.noise_misfit(10, 10), EXPLAINED);
        assert_eq!(tolerance(0.0).noise_misfit(10, 10), LEAST_NOISE_MISFIT);
        assert_eq!(noisy.noise_misfit(10, 0), EXPLAINED);
        assert_eq!(noisy.noise_misfit(0, 0), LEAST_NOISE_MISFIT);
    }

    #[test]
    fn the_noise_of_the_search_is_never_below_the_scatter() {
        let exact = Tolerance { scatter_m: 0.0, scale_m: SIZE_M, balance: [15.0, 0.3] };
        let share =
            |share: f64, balance: f64| Noise { sensor_m: share * SIZE_M, balance_m: balance * (share * SIZE_M) };
        assert_eq!((exact.loose(), exact.sharp()), (share(0.01, 15.0), share(0.003, 0.3)));
        let noisy = Tolerance { scatter_m: 0.1 * SIZE_M, ..exact };
        assert_eq!((noisy.loose(), noisy.sharp()), (share(0.1, 15.0), share(0.1, 0.3)));
    }
}
