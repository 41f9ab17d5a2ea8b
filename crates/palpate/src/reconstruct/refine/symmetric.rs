//! Symmetric models of the object in place of the general one, where the evidence prefers them (`docs/theory.md`, symmetry).

use crate::estimate::association::transitions::near;
use crate::estimate::coverage::{MOSTLY_FELT_AGAIN, completed, contact_paths, felt_again, overlap, touches};
use crate::estimate::evidence::symmetry::{SymmetricModel, against_general, log_prior_odds, symmetric_models};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::{outlying_steps, same_motion, unwrap_to};
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::refine::job::{Job, Refined};
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::shape::Symmetry;
use std::f64::consts::TAU;
use std::ops::Range;

/// Symmetric models that are fitted at most, the most likely first: each costs as much as the general one.
const MOST_MODELS: usize = 3;

/// A symmetric model is fitted where the posterior of the general one does not exclude it by more than this, in nats: a generous
/// limit, since a piece at a wrong pose spoils that posterior, and the fit decides.
const NOT_EXCLUDED: f64 = 200.0;

/// Standard deviations, in the mean over the directions that the log determines, by which a general model may miss a symmetry that it would
/// have but for pieces at wrong poses: those that the shape does not have are missed by hundreds.
const SPOILT_SDS: f64 = 30.0;

/// Standard deviation of a contact position, over the scatter of neighbouring samples, below which impossible jumps may be all that is wrong
/// with a motion: pieces on other copies of their boundary fit nearly as well.
const FITS: f64 = 4.0;

/// Where one model holds, those further behind the likeliest than this are not fitted, in nats.
const FAR_BEHIND: f64 = 20.0;

/// Least share of the felt boundary that must have been felt on two copies: with less, they are not compared, and a symmetric model
/// extrapolates. The pieces of a symmetric object can lie on one copy, where they share a boundary, as well as on several.
const OVERLAP: f64 = 0.2;

/// Whether a motion is known to stay on one copy of an object that comes to itself by a rotation: its long steps are jumps whose landing statics tells. Over
/// another one, of palms that move far from one sample to the next, it could as well have gone to the next copy.
fn is_told_of_copies(psi: &[f64], jumps: &[usize]) -> bool {
    (1..psi.len()).all(|sample| near(psi[sample - 1], psi[sample], TAU) || jumps.contains(&sample))
}

/// The likeliest of symmetric models and the general one (`None`), by their log odds against that, and how probable it is that the object has that symmetry
/// and maybe more. Where that is less than `least`, a part of the symmetry may be as good as certain: an ellipse of which the mirror is not told comes to
/// itself by half a turn. A part with fewer copies will do only for motions that are `told` of them.
fn most_symmetry(
    symmetries: &[Symmetry],
    log_odds: &[f64],
    told: &dyn Fn(usize) -> bool,
    least: f64,
) -> (Option<usize>, f64) {
    let largest = log_odds.iter().copied().fold(0.0, f64::max);
    let share = |log_odds: f64| (log_odds - largest).exp();
    let sum = share(0.0) + log_odds.iter().copied().map(share).sum::<f64>();
    let of = |index: usize| {
        let including = symmetries.iter().zip(log_odds).filter(|(other, _)| other.includes(symmetries[index]));
        including.map(|(_, odds)| share(*odds)).sum::<f64>() / sum
    };
    let by_odds = |a: &usize, b: &usize| log_odds[*a].total_cmp(&log_odds[*b]);
    let Some(likeliest) = (0..log_odds.len()).filter(|&index| log_odds[index] > 0.0).max_by(by_odds) else {
        return (None, share(0.0) / sum);
    };
    let has_as_many = |index: usize| symmetries[index].order == symmetries[likeliest].order;
    let is_part =
        |index: &usize| symmetries[likeliest].includes(symmetries[*index]) && (has_as_many(*index) || told(*index));
    let certain = (0..log_odds.len()).filter(is_part).filter(|&index| of(index) >= least).max_by(by_odds);
    let chosen = certain.unwrap_or(likeliest);
    (Some(chosen), of(chosen))
}

/// The probability behind log odds.
fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

impl Job<'_> {
    /// The most likely of the general optimum and of those with a symmetry.
    pub(super) fn with_symmetry(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        mut general: Refined,
    ) -> Refined {
        let fits = general.fine.noise.sensor_m < FITS * self.scatter_m;
        if fits && self.unphysical_jumps(&general.fine.estimate, TAU) > 0 {
            general = self.laid_out(medium, ranges, general);
        }
        let mut models = symmetric_models(&general.measurements, &general.fine);
        models.retain(|model| model.log_ratio > -NOT_EXCLUDED);
        // With ln of the evidence, times the prior odds against the general one.
        let mut fitted: Vec<(f64, Refined)> = Vec::new();
        let likeliest = models.first().map_or(0.0, |model| model.log_ratio);
        for model in models.into_iter().take(MOST_MODELS) {
            if !fitted.is_empty() && model.log_ratio < likeliest - FAR_BEHIND {
                break;
            }
            let Ok(mut refined) = self.symmetric(medium, ranges, &general, &model) else { continue };
            refined.fine.estimate.psi = self.motion(&refined.fine);
            let is_same = |general: &Refined| same_motion(&general.fine.estimate.psi, &refined.fine.estimate.psi, TAU);
            let against_general = against_general(&refined.measurements, &refined.fine);
            let Some(held) = against_general.filter(|held| !held.model.is_contradicted()) else { continue };
            let weight = refined.fine.evidence.log() + log_prior_odds();
            let radius_m = refined.fine.estimate.coefficients[0].abs();
            let compared = self.is_compared(&refined.fine);
            let deviation_sd_m = if compared { held.deviation_sd_m } else { radius_m };
            if !compared && self.unphysical_jumps(&refined.fine.estimate, TAU) > 0 {
                continue;
            }
            let limits = &self.options.limits;
            let is_guess = deviation_sd_m > limits.symmetry_deviation * radius_m
                || probability(weight - general.fine.evidence.log()) < limits.symmetry_probability;
            // The pieces of an object that is not known to be symmetric may lie as the symmetric model has them.
            if is_guess && !is_same(&general) {
                general = general.or_likelier(self.without_symmetry(medium, ranges, &refined));
            }
            // A symmetry that would be a doubt is of no use where the general model has the same motion. Else the two are rivals.
            if is_guess && is_same(&general) {
                continue;
            }
            refined.symmetry =
                FoundSymmetry { symmetry: model.symmetry, probability: None, deviation_sd_m: Some(deviation_sd_m) };
            // The search compares arrangements by the general model.
            fitted.push((weight, Refined { coarse: general.coarse.clone(), ..refined }));
        }
        // ln of the posterior odds against the general model.
        let log_odds: Vec<f64> = fitted.iter().map(|(weight, _)| weight - general.fine.evidence.log()).collect();
        let symmetries: Vec<Symmetry> = fitted.iter().map(|(_, refined)| refined.symmetry.symmetry).collect();
        let told = |index: usize| self.is_told_of_copies(&fitted[index].1.fine.estimate);
        let least = self.options.limits.symmetry_probability;
        let (chosen, probability) = most_symmetry(&symmetries, &log_odds, &told, least);
        let mut likeliest = chosen.map_or(general, |index| fitted.swap_remove(index).1);
        likeliest.symmetry.probability = Some(probability);
        likeliest
    }

    fn is_told_of_copies(&self, estimate: &Estimate) -> bool {
        let jumps = self.jumps(estimate, TAU);
        let landed: Vec<usize> = jumps.iter().filter(|jump| jump.physical).map(|jump| jump.sample).collect();
        is_told_of_copies(&estimate.psi, &landed)
    }

    /// The optimum of a symmetric model next to the general one.
    fn symmetric(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        general: &Refined,
        model: &SymmetricModel,
    ) -> Result<Refined, ReconstructError> {
        let prior = Prior { symmetry: model.symmetry, ..general.fine.prior };
        let mut psi: Vec<f64> = general.fine.estimate.psi.iter().map(|psi| psi - model.turn).collect();
        unwrap_to(&mut psi, model.symmetry.period_rad());
        let estimate = self.on_medium(medium, ranges, &model.coefficients, &psi);
        let rough = Fit { estimate, prior, ..general.coarse.clone() };
        self.to_fixed_point(medium, ranges, rough, Some(psi))
    }

    /// Pieces of an object that is nearly symmetric lie on any copy of their boundary, with jumps between them that statics forbids. A model
    /// with as much symmetry of rotation as may be has them all on one; the motion that statics then allows is where the general one is
    /// fitted anew.
    fn laid_out(&self, medium: &Measurements, ranges: &[Range<usize>], general: Refined) -> Refined {
        let models = symmetric_models(&general.measurements, &general.fine);
        let is_rotation = |model: &SymmetricModel| model.symmetry.order > 1 && !model.symmetry.mirror;
        let is_near = |model: &SymmetricModel| model.missed < SPOILT_SDS * SPOILT_SDS * model.determined;
        let highest = models.into_iter().filter(|model| is_rotation(model) && is_near(model));
        let Some(model) = highest.max_by_key(|model| model.symmetry.order) else { return general };
        let symmetric = self.symmetric(medium, ranges, &general, &model).ok();
        // Else the pieces do not lie on copies.
        let is_likelier = |symmetric: &Refined| symmetric.posterior.log_ratio(&general.posterior) > 0.0;
        let Some(mut symmetric) = symmetric.filter(is_likelier) else { return general };
        symmetric.fine.estimate.psi = self.motion(&symmetric.fine);
        general.or_likelier(self.without_symmetry(medium, ranges, &symmetric))
    }

    /// The general optimum next to a symmetric one.
    fn without_symmetry(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        symmetric: &Refined,
    ) -> Result<Refined, ReconstructError> {
        let Fit { estimate: Estimate { coefficients, psi, .. }, prior, .. } = &symmetric.fine;
        let estimate = self.on_medium(medium, ranges, coefficients, psi);
        let rough = Fit { estimate, prior: Prior { symmetry: Symmetry::NONE, ..*prior }, ..symmetric.coarse.clone() };
        self.to_fixed_point(medium, ranges, rough, Some(psi.clone()))
    }

    /// Whether the symmetry of a model is seen, and not only believed in: enough of the boundary was felt on two copies, and enough again at all.
    fn is_compared(&self, fine: &Fit) -> bool {
        let symmetry: Symmetry = fine.prior.symmetry;
        let psi = &fine.estimate.psi;
        let angles: Vec<(f64, f64)> =
            self.measurements.instants.iter().zip(psi).map(|(instant, psi)| instant.contact_angles(*psi)).collect();
        let counts = touches(&contact_paths(&self.measurements, &angles, &outlying_steps(psi)));
        overlap(&counts, symmetry, 0.0) >= OVERLAP
            && felt_again(completed(&counts, symmetry, 0.0).into_iter()) >= MOSTLY_FELT_AGAIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::evidence::fit::{Fitted, ROUNDS, fit};
    use crate::estimate::evidence::jump_prior::with_jumps;
    use crate::estimate::evidence::variance_components::{LEAST_BALANCE_SHARE_AT_FIRST, VarianceComponents};
    use crate::estimate::model::noise::Noise;
    use crate::estimate::motion::LONGEST_STEP;
    use crate::palms::PalmMotion;
    use crate::reconstruct::options::ReconstructOptions;
    use crate::sensor::Touchpad;
    use crate::shape::SupportFunction;
    use crate::simulate::{SimulateOptions, simulate};

    const NOISE_SD_M: f64 = 5e-5;
    const ORDER: usize = 6;

    /// Of an object with three lobes and a mark of `mark_m`: whether the true motion comes out where some samples were given poses that are a
    /// copy, a third of a turn, away.
    fn comes_out(mark_m: f64) -> bool {
        let mut harmonics = vec![[0.0; 2]; ORDER];
        harmonics[2] = [5e-4, 0.0];
        harmonics[3] = [0.0, mark_m];
        let shape = SupportFunction::new(0.03, harmonics);
        let motion = PalmMotion::random(4, 20.0, 0.4).and_then(|motion| motion.sample(20.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: NOISE_SD_M, ..Touchpad::ideal() };
        let run =
            simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible");
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let mut psi = truth.clone();
        let count = psi.len();
        for (from, to) in [(count / 5, 2 * count / 5), (3 * count / 5, 4 * count / 5)] {
            psi[from..to].iter_mut().for_each(|psi| *psi += TAU / 3.0);
        }
        let estimate = Estimate { coefficients: shape.coefficients(), psi, cost: f64::INFINITY };
        let noise = Noise { sensor_m: NOISE_SD_M, balance_m: NOISE_SD_M };
        let components =
            VarianceComponents { sensor: true, floor_m: 1e-8, least_balance_share: LEAST_BALANCE_SHARE_AT_FIRST };
        let Fitted { fit: fine, weighted: measurements } =
            fit(&job.measurements, ORDER, estimate, noise, job.prior, components, ROUNDS).expect("an optimum");
        let jumps = job.jumps(&fine.estimate, TAU);
        assert!(jumps.iter().any(|jump| !jump.physical));
        let general = Refined {
            coarse: fine.clone(),
            posterior: with_jumps(&measurements, &fine, &jumps),
            fine,
            measurements,
            ambiguity_rad: vec![0.0; count],
            symmetry: FoundSymmetry::default(),
            settled: true,
            rivals: Vec::new(),
            as_likely: Vec::new(),
        };
        let all = 0..count;
        let found = job.laid_out(&job.measurements, std::slice::from_ref(&all), general);
        same_motion(&found.fine.estimate.psi, &truth, TAU)
    }

    #[test]
    fn as_much_symmetry_is_claimed_as_is_probable() {
        let [turn, mirrored] = [false, true].map(|mirror| Symmetry { order: 2, mirror });
        let chosen = |log_odds: [f64; 2]| most_symmetry(&[mirrored, turn], &log_odds, &|_| false, 0.9);
        let (index, probability) = chosen([30.0, 25.0]);
        assert!(index == Some(0) && (probability - 0.993).abs() < 1e-3, "{probability}");
        // The mirror is not told, the half turn is.
        let (index, probability) = chosen([30.0, 29.0]);
        assert!(index == Some(1) && probability > 1.0 - 1e-12, "{probability}");
        // Nor is the half turn, where no symmetry is nearly as likely.
        let (index, probability) = chosen([0.5, 0.4]);
        assert!(index == Some(0) && (0.3..0.5).contains(&probability), "{probability}");
        let (index, probability) = chosen([-30.0, -31.0]);
        assert!(index.is_none() && probability > 1.0 - 1e-12, "{probability}");
        // A third of a turn in place of a sixth has fewer copies: the motion must not go from one to another.
        let [third, sixth] = [3, 6].map(|order| Symmetry { order, mirror: false });
        let told_or_not = [true, false].map(|told| most_symmetry(&[sixth, third], &[30.0, 29.0], &|_| told, 0.9).0);
        assert_eq!(told_or_not, [Some(1), Some(0)]);
    }

    #[test]
    fn a_step_may_lead_to_another_copy_where_it_is_long() {
        let steps = |longest: f64| [0.0, 0.1, 0.1 + longest, 0.2 + longest];
        let [short, long] = [0.99, 1.01].map(|times| steps(times * LONGEST_STEP));
        assert!(is_told_of_copies(&short, &[]) && !is_told_of_copies(&long, &[]));
        assert!(is_told_of_copies(&long, &[2]) && !is_told_of_copies(&long, &[1]), "where it jumps, statics tells");
    }

    #[test]
    fn pieces_on_other_copies_of_their_boundary_are_brought_to_one() {
        assert!(comes_out(0.0));
        assert!(comes_out(1e-5), "not quite symmetric");
        assert!(!comes_out(5e-4), "there are no copies");
    }
}
