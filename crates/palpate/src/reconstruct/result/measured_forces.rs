//! What measured normal forces say of a result: the weight of the object, their noise, and whether both pads agree (`docs/theory.md`, measured
//! forces).

use crate::estimate::friction::normal_forces::{NormalForces, look_exchanged};
use crate::log::{Log, Sample};
use crate::math::statistics::{correlation_time, median, typical_sd};
use crate::mechanics::{ContactMode, STANDARD_GRAVITY_M_PER_S2};
use crate::palms::Contacts;
use crate::reconstruct::result::reconstruction::{Pose, Reconstruction};

/// Weight of an object by measured forces.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredForces {
    /// Weight, newtons.
    pub weight_n: f64,
    /// Its standard deviation, newtons: by the noise alone, not by what the pads may have in common.
    pub weight_sd_n: f64,
    /// Standard deviation of a measured force, newtons.
    pub force_sd_n: f64,
    /// The weight by each palm alone, newtons, and its standard deviation; `None` where it measures no force.
    pub by_palm_n: [Option<(f64, f64)>; 2],
    /// Whether the forces of both palms look exchanged; all else here is then of little worth.
    pub exchanged: bool,
    /// Mass over that of a body of gold which is as deep as the object is wide: an object of more is none, and its forces are in other units.
    pub over_gold: f64,
}

/// Pads disagree where the weights by them differ by so many standard deviations, and by this share of the weight.
const DISAGREE_SDS: f64 = 5.0;
const DISAGREE: f64 = 0.05;

/// Forces further off than this many standard deviations of most of them tell nothing of the weight.
const FAR_SDS: f64 = 4.0;

/// Density of gold, kg/m³.
const GOLD_KG_PER_M3: f64 = 19_300.0;

impl MeasuredForces {
    /// Mass, kilograms.
    pub fn mass_kg(&self) -> f64 {
        self.weight_n / STANDARD_GRAVITY_M_PER_S2
    }

    /// By how much the weight by palm 2 is larger than by palm 1, as a share, where that is more than noise.
    pub fn disagreement(&self) -> Option<f64> {
        let [first, second] = self.by_palm_n;
        let ((first, first_sd), (second, second_sd)) = first.zip(second)?;
        let share = second / first - 1.0;
        let told = (second - first).abs() > DISAGREE_SDS * first_sd.hypot(second_sd) && share.abs() > DISAGREE;
        told.then_some(share)
    }
}

impl MeasuredForces {
    /// What is odd about the forces, a sentence each, with what to look at.
    pub fn oddities(&self) -> Vec<String> {
        let mut oddities = Vec::new();
        if self.exchanged {
            oddities.push(
                "the normal forces of the two palms look exchanged, and were not used: exchange force1 and force2 in the log".to_owned(),
            );
        } else if let Some(share) = self.disagreement() {
            let (percent, which) = (100.0 * share.abs(), if share > 0.0 { "more" } else { "less" });
            oddities.push(format!(
                "palm 2 measures {percent:.0} % {which} force than palm 1: check the scales of both sensors"
            ));
        }
        if self.over_gold > 1.0 {
            oddities.push(format!(
                "by its forces the object weighs {:.1} N ({:.1} kg), more than gold of its size: are they in grams, or counts? The columns are \
                 in newtons (force1_n, force2_n)",
                self.weight_n,
                self.mass_kg()
            ));
        }
        oddities
    }
}

/// What the forces of a log say of its result. `None` where no force was measured, or where the object is on its way: with inertia they carry more
/// than the weight.
pub fn measured_forces(log: &Log, result: &Reconstruction) -> Option<MeasuredForces> {
    if result.inertia.is_some() || log.samples.len() != result.motion.len() {
        return None;
    }
    let corrected = result.calibration.as_ref().map(|of_rig| of_rig.calibration.corrected(log));
    let samples = &corrected.as_ref().unwrap_or(log).samples;
    // Measured, and what a weight of one newton would give.
    let mut pairs: [Vec<(f64, f64)>; 2] = [Vec::new(), Vec::new()];
    for (sample, pose) in samples.iter().zip(&result.motion).filter(|(sample, _)| sample.forces_n() != [None; 2]) {
        let Some(over_weight) = over_weight(sample, pose, result) else { continue };
        for palm in 0..2 {
            pairs[palm].extend(sample.forces_n()[palm].map(|force_n| (force_n, over_weight[palm])));
        }
    }
    let all: Vec<(f64, f64)> = pairs.iter().flatten().copied().collect();
    let (weight_n, force_sd_n, weight_sd_n) = weight_n(&all)?;
    let wide_m = 2.0 * result.shape.mean_radius_m();
    let gold_kg = GOLD_KG_PER_M3 * result.shape.area_m2() * wide_m;
    Some(MeasuredForces {
        weight_n,
        weight_sd_n,
        force_sd_n,
        by_palm_n: pairs.map(|pairs| weight_n_by(&pairs)),
        exchanged: look_exchanged(log),
        over_gold: weight_n / STANDARD_GRAVITY_M_PER_S2 / gold_kg,
    })
}

fn weight_n_by(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    weight_n(pairs).map(|(weight_n, _, sd_n)| (weight_n, sd_n))
}

/// Normal forces over the weight at a sample.
fn over_weight(sample: &Sample, pose: &Pose, result: &Reconstruction) -> Option<[f64; 2]> {
    let (friction, modes) = match result.friction {
        Some(friction) => (friction.coefficients, pose.modes?),
        // Without friction it slides, whichever way.
        None => ([0.0; 2], [ContactMode::SlidePlus; 2]),
    };
    let at = Contacts::from([result.shape.at(pose.theta1_rad), result.shape.at(pose.theta2_rad)]);
    let end = |other: bool| {
        modes.map(|mode| match mode {
            ContactMode::Stick => f64::from(i8::from(other) * 2 - 1),
            slides => slides.slip_sign(),
        })
    };
    Some(NormalForces::new(&sample.palms.angles(), &at, friction, [end(false), end(true)])?.over_weight)
}

/// The weight that goes best with forces of which each has a share in it, the standard deviation of one of them, and that of the weight.
fn weight_n(pairs: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    let mut each: Vec<f64> =
        pairs.iter().filter(|(_, share)| *share > 0.0).map(|(force_n, share)| force_n / share).collect();
    if each.is_empty() {
        return None;
    }
    let first_n = median(&mut each);
    let off_n = |weight_n: f64| pairs.iter().map(|(force_n, share)| force_n - weight_n * share).collect::<Vec<f64>>();
    let left_n = off_n(first_n);
    let far_n = FAR_SDS * typical_sd(left_n.iter());
    let near = || pairs.iter().zip(&left_n).filter(|(_, left_n)| left_n.abs() <= far_n).map(|(pair, _)| *pair);
    let squares: f64 = near().map(|(_, share)| share * share).sum();
    let weight_n = near().map(|(force_n, share)| force_n * share).sum::<f64>() / squares;
    let left_n: Vec<f64> = near().map(|(force_n, share)| force_n - weight_n * share).collect();
    let sd_n = (left_n.iter().map(|left| left * left).sum::<f64>() / left_n.len().max(1) as f64).sqrt();
    let weight_sd_n = sd_n * (correlation_time(&left_n) / squares).sqrt();
    weight_n.is_finite().then_some((weight_n, sd_n, weight_sd_n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_that_of_most_forces() {
        let noise = |i: usize| 0.01 * (12.9898 * i as f64).sin();
        let mut pairs: Vec<(f64, f64)> =
            (0..400).map(|i| (0.5 * (0.4 + 1e-3 * i as f64) + noise(i), 0.4 + 1e-3 * i as f64)).collect();
        let (weight_n, sd_n, weight_sd_n) = super::weight_n(&pairs).expect("told");
        assert!((weight_n - 0.5).abs() < 4.0 * weight_sd_n && weight_sd_n < 2e-3, "{weight_n} {weight_sd_n}");
        assert!((sd_n - 0.01 / 2.0_f64.sqrt()).abs() < 1e-3, "{sd_n}");
        pairs.iter_mut().step_by(40).for_each(|(force_n, _)| *force_n += 3.0);
        let (with_strays_n, ..) = super::weight_n(&pairs).expect("told");
        assert!((with_strays_n - weight_n).abs() < 1e-3);
        assert_eq!(super::weight_n(&[]), None);
    }

    #[test]
    fn pads_disagree_beyond_noise_and_one_twentieth() {
        let forces = |second_n: f64, sd_n: f64| MeasuredForces {
            weight_n: 1.0,
            weight_sd_n: sd_n,
            force_sd_n: 0.02,
            by_palm_n: [Some((1.0, sd_n)), Some((second_n, sd_n))],
            exchanged: false,
            over_gold: 0.1,
        };
        assert_eq!(forces(1.049, 1e-3).disagreement(), None);
        assert!((forces(1.051, 1e-3).disagreement().expect("told") - 0.051).abs() < 1e-12);
        assert_eq!(forces(1.1, 0.015).disagreement(), None);
        assert!(forces(1.1, 0.014).disagreement().is_some());
    }
}
