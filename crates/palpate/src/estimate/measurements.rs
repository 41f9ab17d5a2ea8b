//! A palm log prepared for estimation: one `Instant` per sample, with the trigonometry of its palms (`docs/theory.md`, contact).
//!
//! Palms whose base points lie apart are reduced to a hinged pair: their lines meet in one point, and measured from there the
//! contact equations (eq. 3 of Moll & Erdmann 2001) and the balance are those of a hinge. Only the origin of s changes.

use crate::estimate::work::Work;
use crate::log::{Log, Sample};
use crate::math::statistics::{median, root_mean_square};
use crate::palms::{PalmAngles, contact_angles};

/// One sample, measured from the point where the lines of both palms meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instant {
    /// Index of the sample in the log, or the mean index where instants were thinned.
    pub position: f64,
    pub phi1: f64,
    pub phi2: f64,
    pub palms: PalmAngles,
    /// Contact positions from the meeting point, metres; 0 where not seen.
    pub s1: f64,
    pub s2: f64,
    /// Weight of each contact: 1 / (its standard deviation relative to the common one), 0 where not seen.
    pub weight1: f64,
    pub weight2: f64,
    /// Square root of the weight of the balance: 1, or by Student's t at a fit (see [`super::evidence`]).
    pub balance_weight: f64,
}

impl Instant {
    fn new(index: usize, sample: &Sample, sd_scale_m: Option<f64>) -> Self {
        let palms = &sample.palms;
        let angles = palms.angles();
        let base = palms.base_shifts_m(&angles);
        let measured = |palm: usize, position: Option<f64>| position.map_or(0.0, |position| position + base[palm]);
        let weight = |s: Option<f64>, sd: Option<f64>| match (s, sd, sd_scale_m) {
            (None, _, _) => 0.0,
            (Some(_), Some(sd), Some(scale)) => scale / sd,
            (Some(_), _, _) => 1.0,
        };
        Self {
            position: index as f64,
            phi1: palms.phi1_rad,
            phi2: palms.phi2_rad,
            palms: angles,
            s1: measured(0, sample.s1_m),
            s2: measured(1, sample.s2_m),
            weight1: weight(sample.s1_m, sample.s1_sd_m),
            weight2: weight(sample.s2_m, sample.s2_sd_m),
            balance_weight: 1.0,
        }
    }

    /// The same readings had the palms been turned by these angles more, radians (each against the horizontal).
    pub fn turned(&self, palm1: f64, palm2: f64) -> Self {
        let (phi1, phi2) = (self.phi1 + palm1, self.phi2 + palm2 - palm1);
        Self { phi1, phi2, palms: PalmAngles::new(phi1, phi2), ..*self }
    }

    /// Contact angles (θ1, θ2) of an object at an orientation, radians (eq. 1).
    pub fn contact_angles(&self, psi: f64) -> (f64, f64) {
        contact_angles(self.phi1, self.phi2, psi)
    }

    /// By how much the palms turn from this instant to another, each against the horizontal, added up: radians.
    pub fn palms_turn_to(&self, other: &Self) -> f64 {
        (other.phi1 - self.phi1).abs() + (other.phi1 + other.phi2 - self.phi1 - self.phi2).abs()
    }

    /// Sets all weights of the sample to 0.
    pub fn set_aside(&mut self) {
        (self.weight1, self.weight2, self.balance_weight) = (0.0, 0.0, 0.0);
    }

    /// Whether the sample tells nothing.
    pub fn is_aside(&self) -> bool {
        [self.weight1, self.weight2, self.balance_weight] == [0.0; 3]
    }

    /// Whether both contacts were seen.
    pub fn both_seen(&self) -> bool {
        self.weight1 > 0.0 && self.weight2 > 0.0
    }

    /// Radii of the discs that touch both palms, and each of them where the object does, metres.
    pub fn disc_radii_m(&self) -> [f64; 2] {
        let per_radius = (0.5 * self.phi2).tan();
        [self.s1 * per_radius, self.s2 * per_radius]
    }

    /// X of the centre of mass from the readings alone (the three lines of force meet in one point).
    pub fn balance_x(&self) -> f64 {
        self.palms.balance_x(self.s1, self.s2)
    }
}

/// An object is nearly round when it is out of round by less than this share of its size: ellipses and polygons by a quarter to a half,
/// shapes of constant width by 0.05 to 0.1, discs with a relief of one per cent by 0.004 to 0.02.
const NEARLY_ROUND: f64 = 0.1;

/// All instants of a log, in order of time.
#[derive(Clone, Debug)]
pub(crate) struct Measurements {
    pub instants: Vec<Instant>,
    /// What has been done with them so far.
    pub work: Work,
}

impl Measurements {
    /// From a log; `sd_scale_m` is the common standard deviation to which stated ones are relative.
    pub fn new(log: &Log, sd_scale_m: Option<f64>) -> Self {
        let instants =
            log.samples.iter().enumerate().map(|(index, sample)| Instant::new(index, sample, sd_scale_m)).collect();
        Self { instants, work: Work::for_log(log.samples.len(), 1) }
    }

    /// Other instants of the same log: a part of them, or means.
    pub fn of(&self, instants: Vec<Instant>) -> Self {
        Self { instants, work: self.work.clone() }
    }

    pub fn len(&self) -> usize {
        self.instants.len()
    }

    /// Number of contacts that were seen and count.
    pub fn seen(&self) -> usize {
        self.instants
            .iter()
            .map(|instant| usize::from(instant.weight1 > 0.0) + usize::from(instant.weight2 > 0.0))
            .sum()
    }

    /// Typical distance of the contacts from each other: the size of the object to within a factor of two, metres.
    pub fn size_m(&self) -> f64 {
        let mut chords: Vec<f64> = self
            .instants
            .iter()
            .filter(|instant| instant.both_seen())
            .map(|i| (i.s1 * i.s1 + i.s2 * i.s2 - 2.0 * i.s1 * i.s2 * i.palms.cos2).max(0.0).sqrt())
            .collect();
        0.5 * median(&mut chords)
    }

    /// Length that errors of a search are a share of, metres: the size of the object, or less where that is nearly round. From a disc contacts tell nothing of a
    /// motion, and an object that is nearly one differs from it by less than what would be tolerated of another of its size.
    pub fn scale_m(&self) -> f64 {
        self.size_m().min(self.out_of_round_m() / NEARLY_ROUND)
    }

    /// How far the object is from round: root mean square by which the radii of the discs differ that touch the palms where it does, metres.
    fn out_of_round_m(&self) -> f64 {
        let seen = self.instants.iter().filter(|instant| instant.both_seen());
        let radii_m: Vec<f64> = seen.flat_map(Instant::disc_radii_m).collect();
        let mean_m = radii_m.iter().sum::<f64>() / radii_m.len().max(1) as f64;
        root_mean_square(&radii_m.iter().map(|radius_m| radius_m - mean_m).collect::<Vec<f64>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use crate::shape::SupportFunction;

    const SIZE_M: f64 = 0.02;

    /// An object turned between palms that open and close, seen without errors.
    fn felt(shape: &SupportFunction) -> Measurements {
        let sample = |index: usize| {
            let along = index as f64 / 100.0;
            let (phi1, phi2, psi) = (0.4 + 0.2 * (5.0 * along).sin(), 1.5 + 0.4 * along, 6.0 * along);
            let palms = PalmPair::hinged(phi1, phi2);
            let (s1, s2) = palms.contact_positions_m(shape, psi);
            Sample::new(index as f64, palms, s1, s2)
        };
        Measurements::new(&Log { samples: (0..100).map(sample).collect() }, None)
    }

    #[test]
    fn errors_are_a_share_of_the_size_and_of_what_a_nearly_round_object_differs_from_a_disc() {
        let felt = |relief: f64, center_m: f64| {
            felt(&SupportFunction::new(SIZE_M, vec![[center_m, 0.0], [relief * SIZE_M, 0.0]]))
        };
        assert_eq!(felt(0.1, 0.0).scale_m(), felt(0.1, 0.0).size_m());
        let round = felt(0.01, 0.0);
        assert!(round.scale_m() < 0.5 * round.size_m(), "{}", round.scale_m());
        // In proportion to the relief, and none of it where the centre of mass of a disc lies.
        let half = felt(0.005, 0.0).scale_m() / round.scale_m();
        assert!((half - 0.5).abs() < 0.02, "{half}");
        assert!(felt(0.0, 0.3 * SIZE_M).scale_m() < 1e-12);
    }
}
