//! The palms at any time: least-squares splines through their angles.

use crate::log::Log;
use crate::math::spline::FittedSpline;
use crate::mechanics::inertial::MovingPalms;
use crate::palms::PalmPair;

/// Palms whose base points stay, over the time of a log.
#[derive(Clone, Debug)]
pub(crate) struct PalmPath {
    phi1: FittedSpline,
    phi12: FittedSpline,
    bases_m: [[f64; 2]; 2],
}

impl PalmPath {
    /// `None` where the log is too short, times do not increase, or the base points move.
    pub fn new(log: &Log) -> Option<Self> {
        let first = log.samples.first()?.palms;
        let bases_m = [first.base1_m, first.base2_m];
        let stays = log.samples.iter().all(|sample| [sample.palms.base1_m, sample.palms.base2_m] == bases_m);
        let times: Vec<f64> = log.samples.iter().map(|sample| sample.time_s).collect();
        if !stays || times.windows(2).any(|pair| pair[1] <= pair[0]) {
            return None;
        }
        let spline = |angle: fn(&PalmPair) -> f64| {
            let angles: Vec<f64> = log.samples.iter().map(|sample| angle(&sample.palms)).collect();
            FittedSpline::new(&times, &angles)
        };
        Some(Self { phi1: spline(|palms| palms.phi1_rad)?, phi12: spline(PalmPair::phi12_rad)?, bases_m })
    }

    /// The palms at a time in seconds.
    pub fn at(&self, time_s: f64) -> MovingPalms {
        let ([phi1, rate1, acceleration1], [phi12, rate12, acceleration12]) =
            (self.phi1.at(time_s), self.phi12.at(time_s));
        let [base1_m, base2_m] = self.bases_m;
        let pair = PalmPair { phi1_rad: phi1, phi2_rad: phi12 - phi1, base1_m, base2_m };
        MovingPalms::new(pair, [rate1, rate12], [acceleration1, acceleration12])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Sample;

    #[test]
    fn rates_and_accelerations_are_those_of_the_motion() {
        let palms = |t: f64| PalmPair::hinged(0.8 + 0.3 * (2.0 * t).sin(), 1.3 + 0.2 * (3.0 * t).cos());
        let at = |i: u32| 0.02 * f64::from(i);
        let samples: Vec<Sample> = (0..200).map(|i| Sample::new(at(i), palms(at(i)), 0.03, 0.04)).collect();
        let path = PalmPath::new(&Log { samples: samples.clone() }).expect("long enough");
        let t: f64 = 1.234;
        let found = path.at(t);
        assert!(
            (found.pair.phi1_rad - palms(t).phi1_rad).abs() < 1e-8
                && (found.pair.phi2_rad - palms(t).phi2_rad).abs() < 1e-8
        );
        assert!((found.rates[0] - 0.6 * (2.0 * t).cos()).abs() < 1e-5);
        assert!((found.accelerations[1] + 1.2 * (2.0 * t).sin() + 1.8 * (3.0 * t).cos()).abs() < 1e-2);
        let mut moving = samples;
        moving[7].palms.base2_m = [1e-3, 0.0];
        assert!(PalmPath::new(&Log { samples: moving }).is_none(), "a base point that moves");
    }
}
