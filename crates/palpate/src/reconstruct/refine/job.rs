//! Refinement of one arrangement of the search to the optimum over all samples (`docs/theory.md`, the search): Gauss-Newton fits
//! with variance components and a number of harmonics chosen by the evidence alternate with Viterbi decoding of the motion, to a
//! fixed point; then ambiguous samples are compared by the evidence, and restarts along the weakest direction of the shape are
//! tried.

use super::calibrated::trusts;
use super::resample::{carry_over, thinned_in_ranges};
use super::restarts::along_weakest_direction;
use crate::estimate::association::alternatives::{Ambiguity, compare_evidence};
use crate::estimate::association::copies::carried_copies;
use crate::estimate::association::decode::{Aside, Decoded, decode};
use crate::estimate::association::landings::landings;
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::relative_rotation::rival_rotations;
use crate::estimate::association::rival_pieces::rival_motions;
use crate::estimate::association::short_segments::{is_out_of_balance, open_out_of_balance, reassociated};
use crate::estimate::evidence::fit::{Fitted, ROUNDS, fit};
use crate::estimate::evidence::jump_prior::with_jumps;
use crate::estimate::evidence::motion_prior::CERTAIN;
use crate::estimate::evidence::order::choose_order;
use crate::estimate::evidence::variance_components::{
    LEAST_BALANCE_SHARE, LEAST_BALANCE_SHARE_AT_FIRST, VarianceComponents,
};
use crate::estimate::jumps::{DetectedJump, detect_jumps};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::balance_tolerance::{
    EXACT_BALANCE, balance_is_missed, balance_limit_m, with_exact_balance,
};
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::noise_from_log::{
    contact_scatter_m, samples_per_error, stated_noise_m, steps_m, weigh_by_angles,
};
use crate::estimate::model::outliers::set_outliers_aside;
use crate::estimate::model::prior::Prior;
use crate::estimate::model::sensor_memory::{hidden_from_neighbours_by, samples_per_error_by};
use crate::estimate::motion::{moved, piece_starts, unwrap};
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::estimate::work::Work;
use crate::log::Log;
use crate::palms::PalmPair;
use crate::reconstruct::options::ReconstructOptions;
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::reconstruct::search::schedule::Found;
use crate::reconstruct::search::segments::segments;
use crate::reconstruct::selection::Explored;
use crate::reconstruct::verdict::assemble::Expected;
use crate::reconstruct::verdict::open_poses::open_motion_rad;
use crate::sensor::Calibration;
use crate::shape::SupportFunction;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

/// Times that a motion is decoded and fitted again: what does not settle by then is a wrong arrangement, or a matter of a few
/// samples.
const REPAIRS: usize = 3;

/// A decoding converges when it relocates at most one in this many of the samples that the one before relocated; as that of the
/// first counts one in [`FIRST_SHARE`] of all samples.
const CONTRACTION: usize = 2;
const FIRST_SHARE: usize = 4;

/// Share of the samples that the last decoding may relocate where the log contradicts the motion: with more, alternatives of a few samples
/// are not worth their fits. The samples that it relocates stay ambiguous.
const MOST_UNSETTLED: f64 = 0.02;

/// Of so many samples at most one is the first after a jump, unless the motion is lost: palms that go to and fro make one jump in 80. Where
/// the last decoding besides relocates more than one sample in [`FIRST_SHARE`], nothing is gained by alternatives for a few of them.
const LOST: usize = 20;

/// Standard deviation of a contact position, over that of a typical contact by the scatter of neighbouring samples and what a memory of the sensor hides from
/// these, above which the log contradicts such a motion.
const CONTRADICTED: f64 = 2.0;

/// What a log is worth once an arrangement explains its contacts, over what it is worth before: to find the poses of all pieces takes as long as the
/// search did.
const WORTH_OF_A_FIT: f64 = 2.0;

/// Standard deviations of the balance that a fit begins with, as shares of that of the contacts: spoilt by friction or pace, and
/// as exact as statics has it.
const BALANCE_SHARES: [f64; 2] = [1.0, EXACT_BALANCE];

/// Share of the loose standard deviation of the balance below which that of the repeated fit is another optimum, and not the same again.
const STAYS_EXACT: f64 = 0.5;

/// A restart whose log evidence on the thinned log is larger by this, in nats, is taken to its optimum over all samples: less is
/// within the differences between two runs.
pub(super) const PROMISING: f64 = 1.0;

/// Rivals of an optimum, and of those found from them, that are taken to an optimum of their own: each costs as much as the first.
const MOST_RIVALS: usize = 2;

/// Other rotations of a part of the log that are followed, and times that this is done.
const MOST_ROTATIONS: usize = 3;

/// Samples on each side of an ambiguous one that are set aside with it: a wrong pose bends the shape at its neighbours too.
const NEIGHBOURS_SET_ASIDE: usize = 5;

/// Samples that are set aside at most: with more, the others no longer predict the shape.
const MOST_SET_ASIDE: usize = 240;

/// Samples at each end of the log that are set aside when noisy contacts miss the balance: more would leave too
/// little of a short log to fit, fewer may miss a whole segment at a wrong pose.
const END: usize = 60;

/// Samples that the choice of the number of harmonics works on: enough for 48 harmonics, a fraction of the work of the whole log.
pub(super) const ORDER_SAMPLES: usize = 450;

/// Scale c of the prior of the harmonics that a fit begins with, as a share of the size of the object.
const PRIOR_SCALE: f64 = 0.5;

/// Least standard deviation of the contacts that a first fit believes in, as a share of the size: it keeps the fit of an exact
/// log well conditioned.
pub(super) const LEAST_FIRST_SD: f64 = 1e-3;

/// Least sensor noise that may be estimated, as a share of the size: far below any sensor.
const SENSOR_FLOOR: f64 = 1e-6;

/// In decoding, no contact is taken to be more exact than this share of the scatter of neighbouring samples.
const DECODING_FLOOR: f64 = 0.3;

/// Whether the samples that the last decoding relocates are few.
fn few(relocated: usize, samples: usize) -> bool {
    relocated as f64 <= MOST_UNSETTLED * samples as f64
}

/// A log prepared for estimation, with what is known of its noise.
#[derive(Clone)]
pub(crate) struct Job<'a> {
    /// As the rig wrote it, and as a rig without errors had.
    pub raw: &'a Log,
    pub log: Cow<'a, Log>,
    /// What lies between them.
    pub calibration: Calibration,
    pub options: &'a ReconstructOptions,
    pub measurements: Measurements,
    /// Samples with a reading that was set aside as a gross outlier, once for each, and those whose readings count whatever their neighbours say.
    pub outliers: Vec<usize>,
    pub kept: Vec<usize>,
    /// Standard deviation of a contact position that options or log state, metres.
    pub stated_m: Option<f64>,
    /// The same, estimated from the scatter of neighbouring samples.
    pub scatter_m: f64,
    /// Samples for each of these errors: rounded readings repeat them.
    pub samples_per_error: f64,
    /// The same of a typical contact, with what noise of the palm angles moves it.
    pub typical_m: f64,
    pub prior: Prior,
    /// Whether the balance counts; else the contacts alone.
    pub balance_counts: bool,
    /// Least standard deviation of the balance in fits to the thinned log, as a share of that of a sensor.
    pub least_balance_share: f64,
}

/// An arrangement at its optimum.
pub(crate) struct Refined {
    /// On the thinned log, where the number of harmonics was chosen.
    pub coarse: Fit,
    /// On all samples.
    pub fine: Fit,
    /// All samples, with the weight that the balance has at each.
    pub measurements: Measurements,
    /// For each sample, the distance of another pose that explains it about as well, radians; 0 where there is none.
    pub ambiguity_rad: Vec<f64>,
    /// The symmetry of `fine`, or that it has none.
    pub symmetry: FoundSymmetry,
    /// Whether decoding leaves the motion as it is, but for a few samples. Else it is wrong, or that of a symmetric object.
    pub settled: bool,
    /// Evidence of `fine` with the prior of its jumps.
    pub posterior: Evidence,
    /// Motions that deserve a fit of their own: with one short piece as all others predict it, or nearly as likely.
    pub rivals: Vec<Vec<f64>>,
    /// Optima with a part of the log at another rotation that are about as likely.
    pub as_likely: Vec<Self>,
}

impl Refined {
    fn new(optimum: Optimum, weighed: Weighed) -> Self {
        let Optimum { coarse, fine, measurements, posterior, .. } = optimum;
        let Weighed { ambiguity_rad, settled, rivals, .. } = weighed;
        let symmetry = FoundSymmetry::default();
        let as_likely = Vec::new();
        Self { coarse, fine, measurements, ambiguity_rad, symmetry, settled, posterior, rivals, as_likely }
    }

    /// This optimum, or the other where that is more likely.
    pub(super) fn or_likelier(self, other: Result<Self, ReconstructError>) -> Self {
        other.ok().filter(|other| other.posterior.log_ratio(&self.posterior) > 0.0).unwrap_or(self)
    }
}

/// One motion at the optimum of all else.
struct Optimum {
    /// As in [`Refined`].
    coarse: Fit,
    fine: Fit,
    measurements: Measurements,
    jumps: Vec<DetectedJump>,
    /// Evidence with the prior of the jumps.
    posterior: Evidence,
}

/// What comparing it with other motions told.
struct Weighed {
    /// As in [`Refined`].
    ambiguity_rad: Vec<f64>,
    settled: bool,
    rivals: Vec<Vec<f64>>,
    /// A motion that is more likely.
    likelier: Option<Vec<f64>>,
}

impl Optimum {
    fn is_likelier_than(&self, other: &Self) -> bool {
        self.posterior.log_ratio(&other.posterior) > PROMISING
    }
}

impl<'a> Job<'a> {
    pub(crate) fn new(log: &'a Log, options: &'a ReconstructOptions) -> Self {
        let work = Work::for_log(log.samples.len(), trusts(options));
        Self::calibrated(log, options, options.rig.calibration, work, Vec::new())
    }

    /// The same with another calibration than the rig's, after some work, and with all readings of the samples `kept`.
    pub(crate) fn calibrated(
        raw: &'a Log,
        options: &'a ReconstructOptions,
        calibration: Calibration,
        work: Work,
        kept: Vec<usize>,
    ) -> Self {
        let exact = calibration == Calibration::default();
        let log = if exact { Cow::Borrowed(raw) } else { Cow::Owned(calibration.corrected(raw)) };
        let stated_m = options.sensor_sd_m.or_else(|| stated_noise_m(&log));
        let mut measurements = Measurements { work, ..Measurements::new(&log, stated_m) };
        let steps_m = steps_m(raw);
        let scatter_m = contact_scatter_m(&measurements, steps_m);
        let outliers = set_outliers_aside(&mut measurements, scatter_m, &kept);
        let scatter_m = contact_scatter_m(&measurements, steps_m);
        let samples_per_error = samples_per_error(&measurements, raw, steps_m);
        let typical_m = weigh_by_angles(&mut measurements, stated_m.unwrap_or(scatter_m), stated_m.is_some());
        let size_m = measurements.size_m();
        let prior = Prior::new(size_m, PRIOR_SCALE * size_m);
        let balance_counts = true;
        Self {
            raw,
            log,
            calibration,
            options,
            measurements,
            outliers,
            kept,
            stated_m,
            scatter_m,
            samples_per_error,
            typical_m,
            prior,
            balance_counts,
            least_balance_share: LEAST_BALANCE_SHARE_AT_FIRST,
        }
    }

    /// The same with a balance that may be as exact as that of all samples from the first fit on.
    pub(crate) fn with_sharp_balance(&self) -> Self {
        Self { least_balance_share: LEAST_BALANCE_SHARE, ..self.clone() }
    }

    /// The same with the balance left out.
    pub(crate) fn without_balance(mut self) -> Self {
        self.measurements.instants.iter_mut().for_each(|instant| instant.balance_weight = 0.0);
        self.balance_counts = false;
        self
    }

    /// The same with the readings of a refined arrangement that look like outliers where the object is in motion: balance, and the other contact alone, do
    /// not tell its pose there, and the readings of a fast motion are far from those before and after. `None` where there are none.
    pub(crate) fn with_readings_in_motion(&self, refined: &Refined) -> Option<Self> {
        let of_sample = |sample: &usize| is_out_of_balance(&refined.measurements.instants[*sample]);
        let kept: Vec<usize> = self.outliers.iter().copied().filter(of_sample).collect();
        let job = || {
            let kept = [&self.kept[..], &kept].concat();
            let job = Self { kept, ..self.clone() }.recalibrated(self.raw, self.calibration);
            Self { least_balance_share: self.least_balance_share, ..job }
        };
        (!kept.is_empty()).then(job)
    }

    /// The same for what is worth such a share of what the log is; nothing of that is done.
    pub(super) fn worth(&self, share: f64) -> Self {
        let mut job = self.clone();
        job.measurements.work = job.measurements.work.afresh(share);
        job
    }

    /// The same of some log with another calibration.
    pub(super) fn recalibrated<'b>(&self, raw: &'b Log, calibration: Calibration) -> Job<'b>
    where
        'a: 'b,
    {
        let work = self.measurements.work.clone();
        let job = Job::calibrated(raw, self.options, calibration, work, self.kept.clone());
        if self.balance_counts { job } else { job.without_balance() }
    }

    /// What is known of the noise besides a fit.
    pub(crate) fn expected(&self) -> Expected {
        let Self { stated_m, scatter_m, samples_per_error, ref outliers, .. } = *self;
        Expected { stated_m, scatter_m, samples_per_error, outliers: outliers.len() }
    }

    /// Takes one arrangement of the search to the optimum over all samples; `None` where that leads to a motion that is known.
    pub(crate) fn refine(
        &self,
        found: &Found,
        arrangement: usize,
        explored: &Explored,
    ) -> Result<Option<Refined>, ReconstructError> {
        let start = found.estimates.get(arrangement).ok_or(ReconstructError::NotSolvable)?;
        let medium = thinned_in_ranges(&self.measurements, &found.ranges, self.scatter_m, ORDER_SAMPLES);
        let psi = carry_over(&found.thin, &start.psi, &start.coefficients, &medium, &found.ranges);
        let start = Estimate { coefficients: start.coefficients.clone(), psi, cost: f64::INFINITY };
        let rough = self.rough(&medium, start).ok_or(ReconstructError::NotSolvable)?;
        let rough = self.with_harmonics_for_contacts(&medium, rough);
        let decoded = self.decoded(&medium, rough);
        if explored.contains_motion(&medium, &decoded.estimate.psi) {
            return Ok(None);
        }
        let mut general = self.to_fixed_point(&medium, &found.ranges, decoded, None)?;
        if explored.contains_motion(&self.measurements, &general.fine.estimate.psi) {
            return Ok(None);
        }
        if self.is_worth_no_more(&general) {
            return Ok(Some(general));
        }
        if general.settled {
            general = self.with_restarts(&medium, &found.ranges, general);
        }
        let likeliest = self.with_symmetry(&medium, &found.ranges, general);
        let with_rotations = |optimum: Refined| self.with_other_rotations(&medium, &found.ranges, optimum);
        Ok(Some(if likeliest.settled { with_rotations(likeliest) } else { likeliest }))
    }

    /// Whether contacts or statics contradict an optimum with these jumps.
    fn is_contradicted(&self, fine: &Fit, jumps: &[DetectedJump]) -> bool {
        self.is_contradicted_by_contacts(fine) || jumps.iter().any(|jump| !jump.physical)
    }

    fn is_contradicted_by_contacts(&self, fine: &Fit) -> bool {
        let limit_m = CONTRADICTED * self.typical_m;
        let Estimate { coefficients, psi, .. } = &fine.estimate;
        fine.noise.sensor_m >= limit_m
            && fine.noise.sensor_m >= limit_m * hidden_from_neighbours_by(&self.measurements, coefficients, psi)
    }

    /// Whether no more is done for it: nothing that the log contradicts is worth more than it has cost.
    fn is_given_up(&self, fine: &Fit, jumps: &[DetectedJump]) -> bool {
        self.is_spent_on(fine) && self.is_contradicted(fine, jumps)
    }

    /// The same of an optimum that cannot be certified, since what is ambiguous of it may be anywhere: what would decide that has not been found so far.
    fn is_worth_no_more(&self, refined: &Refined) -> bool {
        let is_ambiguous = || open_motion_rad(&refined.ambiguity_rad, |_| false) > self.options.limits.ambiguity_rad;
        let is_contradicted = || self.is_contradicted(&refined.fine, &self.jumps(&refined.fine.estimate, TAU));
        self.is_spent_on(&refined.fine) && (is_ambiguous() || is_contradicted())
    }

    /// Whether nothing more is worth doing for an optimum. A search that took all that the log is worth was not in vain where the contacts are explained.
    fn is_spent_on(&self, fine: &Fit) -> bool {
        self.is_spent()
            && (self.measurements.work.is_spent_by(WORTH_OF_A_FIT) || self.is_contradicted_by_contacts(fine))
    }

    /// Whether nothing more is worth doing for the log.
    pub(crate) fn is_spent(&self) -> bool {
        self.measurements.work.is_spent()
    }

    /// The best of an optimum and of those reached by turning a part of the log against the rest.
    fn with_other_rotations(&self, medium: &Measurements, ranges: &[Range<usize>], optimum: Refined) -> Refined {
        let mut best = optimum;
        for _ in 0..MOST_ROTATIONS {
            if self.is_worth_no_more(&best) {
                break;
            }
            let on_medium = self.fit_on_medium(medium, ranges, &best);
            let means_per_error = self.means_per_error(medium, best.posterior.samples_per_error);
            let mut rivals = rival_rotations(medium, &on_medium, means_per_error);
            // Parts of an object that nearly comes to itself have many rotations that contacts explain.
            rivals.sort_by_cached_key(|rival| self.unphysical_jumps(&self.on_all(medium, ranges, rival), TAU));
            let mut likelier = None;
            for rival in rivals.into_iter().take(MOST_ROTATIONS) {
                let Some(fitted) = self.fit_with_exact_balance(medium, rival, &best.coarse) else { continue };
                let Ok(rival) = self.to_fixed_point(medium, ranges, fitted, None) else { continue };
                if rival.posterior.log_ratio(&best.posterior) > PROMISING {
                    likelier = Some(rival);
                    break;
                }
                best.as_likely.extend((best.posterior.log_ratio(&rival.posterior) < CERTAIN.0).then_some(rival));
            }
            let Some(likelier) = likelier else { break };
            let before = std::mem::replace(&mut best, likelier);
            best.as_likely.extend((best.posterior.log_ratio(&before.posterior) < CERTAIN.0).then_some(before));
        }
        best
    }

    /// The best of an optimum, of those reached from its rivals, and of those reached from the restarts along the valley of its cost.
    fn with_restarts(&self, medium: &Measurements, ranges: &[Range<usize>], optimum: Refined) -> Refined {
        let mut best = self.with_rivals(medium, ranges, optimum);
        for start in along_weakest_direction(medium, &best.coarse).into_iter().flatten() {
            if self.is_worth_no_more(&best) {
                break;
            }
            let Some(there) = self
                .fit_with_exact_balance(medium, start, &best.coarse)
                .filter(|there| there.evidence.log() > best.coarse.evidence.log() + PROMISING)
            else {
                continue;
            };
            best = best.or_likelier(self.to_fixed_point(medium, ranges, there, None));
        }
        best
    }

    /// The best of an optimum and of those reached from its rivals.
    fn with_rivals(&self, medium: &Measurements, ranges: &[Range<usize>], optimum: Refined) -> Refined {
        let mut best = optimum;
        for _ in 0..MOST_RIVALS {
            let Some(psi) = best.rivals.pop().filter(|_| !self.is_worth_no_more(&best)) else { break };
            let estimate = self.on_medium(medium, ranges, &best.fine.estimate.coefficients, &psi);
            let Some(there) = self.fit_with_exact_balance(medium, estimate, &best.coarse) else { continue };
            best = best.or_likelier(self.to_fixed_point(medium, ranges, there, Some(psi)));
        }
        best
    }

    /// A start on the thinned log with a motion of all samples.
    pub(super) fn on_medium(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        coefficients: &[f64],
        psi: &[f64],
    ) -> Estimate {
        let psi = carry_over(&self.measurements, psi, coefficients, medium, ranges);
        Estimate { coefficients: coefficients.to_vec(), psi, cost: f64::INFINITY }
    }

    /// An estimate of the thinned log, with the motion of all samples.
    fn on_all(&self, medium: &Measurements, ranges: &[Range<usize>], of: &Estimate) -> Estimate {
        let psi = carry_over(medium, &of.psi, &of.coefficients, &self.measurements, ranges);
        Estimate { psi, ..of.clone() }
    }

    /// A fit to all samples, on the thinned log. Where samples are nearly exact, what means along bent paths are off is larger than their noise.
    fn fit_on_medium(&self, medium: &Measurements, ranges: &[Range<usize>], refined: &Refined) -> Fit {
        let Refined { coarse, fine, .. } = refined;
        let estimate = self.on_medium(medium, ranges, &fine.estimate.coefficients, &fine.estimate.psi);
        let averaged = self.averaged(medium);
        let at_least = |of_fine: f64, of_coarse: f64| (of_fine / averaged).max(of_coarse);
        let noise = Noise {
            sensor_m: at_least(fine.noise.sensor_m, coarse.noise.sensor_m),
            balance_m: at_least(fine.noise.balance_m, coarse.noise.balance_m),
        };
        Fit { estimate, noise, ..fine.clone() }
    }

    /// The noise of a sample, as a multiple of that of a mean on the thinned log.
    pub(crate) fn averaged(&self, medium: &Measurements) -> f64 {
        (self.measurements.len() as f64 / medium.len() as f64).sqrt()
    }

    /// How many means of the thinned log share an error that so many samples share.
    fn means_per_error(&self, medium: &Measurements, samples_per_error: f64) -> f64 {
        (samples_per_error * medium.len() as f64 / self.measurements.len() as f64).max(1.0)
    }

    /// A fit to the thinned log with the number of harmonics that the evidence prefers, of means as far as they have errors of their own.
    pub(super) fn with_best_order(
        &self,
        medium: &Measurements,
        start: Estimate,
        noise: Noise,
        prior: Prior,
    ) -> Option<Fitted> {
        let means_per_error = self.means_per_error(medium, self.samples_per_error);
        choose_order(medium, start, noise, prior, self.variance_components(), means_per_error)
    }

    /// A fit to the thinned log with the balance as exact as statics has it: its residuals show on which side the centre of mass is.
    fn fit_with_exact_balance(&self, medium: &Measurements, start: Estimate, like: &Fit) -> Option<Fit> {
        let noise = Noise { balance_m: EXACT_BALANCE * like.noise.sensor_m, ..like.noise };
        fit(medium, like.order, start, noise, like.prior, self.variance_components(), ROUNDS).map(|fitted| fitted.fit)
    }

    /// A fit with the motion decoded.
    fn decoded(&self, medium: &Measurements, rough: Fit) -> Fit {
        let psi = decode(medium, &rough, self.floor_m(), None).psi;
        Fit { estimate: Estimate { psi, ..rough.estimate }, ..rough }
    }

    /// The first fit, with the number of harmonics of the search: a few samples at a wrong pose would make the evidence prefer
    /// harmonics that the object does not have. Of both standard deviations of the balance the one with more evidence is taken.
    fn rough(&self, medium: &Measurements, start: Estimate) -> Option<Fit> {
        let sd = self.scatter_m.max(LEAST_FIRST_SD * self.prior.size_m);
        let order = Layout::of_coefficients(&start.coefficients).order;
        let with_share = |share: f64| {
            let noise = Noise { sensor_m: sd, balance_m: share * sd };
            let fitted = fit(medium, order, start.clone(), noise, self.prior, self.variance_components(), ROUNDS);
            fitted.map(|fitted| fitted.fit)
        };
        BALANCE_SHARES.into_iter().filter_map(with_share).max_by(|a, b| a.evidence.log().total_cmp(&b.evidence.log()))
    }

    /// An estimate carried over from the thinned log, with the motion decoded where that does not tell it: where samples lack a contact, and where the search
    /// has arranged nothing. Straight lines across such a gap begin in the wrong valley, and a few samples there spoil the shape.
    fn decoded_in_gaps(&self, coarse: &Fit, all: Estimate, noise: Noise, ranges: &[Range<usize>]) -> Estimate {
        let arranged: usize = ranges.iter().map(ExactSizeIterator::len).sum();
        if arranged >= self.measurements.len() && self.measurements.instants.iter().all(Instant::both_seen) {
            return all;
        }
        let carried = Fit { estimate: all, noise, ..coarse.clone() };
        self.decoded(&self.measurements, carried).estimate
    }

    /// The first fit with as many harmonics as the evidence prefers, where those of the search do not explain the contacts and these do: decoded by a shape
    /// without its flat sides and corners, a motion that is right would be lost.
    fn with_harmonics_for_contacts(&self, medium: &Measurements, rough: Fit) -> Fit {
        let is_contradicted = |fit: &Fit| self.averaged(medium) * fit.noise.sensor_m >= CONTRADICTED * self.typical_m;
        if self.options.harmonics.is_some() || !is_contradicted(&rough) {
            return rough;
        }
        let Fit { estimate, noise, prior, .. } = &rough;
        let richer = self.with_best_order(medium, estimate.clone(), *noise, *prior).map(|fitted| fitted.fit);
        richer.filter(|richer| !is_contradicted(richer)).unwrap_or(rough)
    }

    /// Chooses the number of harmonics, fits all samples and decodes the motion, until the decoding relocates no sample. `rough`
    /// is a fit to the thinned log, `known` the motion of all samples where it is known.
    pub(super) fn to_fixed_point(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        rough: Fit,
        known: Option<Vec<f64>>,
    ) -> Result<Refined, ReconstructError> {
        let Fit { estimate: mut start, noise, prior, .. } = rough;
        let period = prior.symmetry.period_rad();
        let mut motion = known;
        let mut medium = medium.clone();
        let (mut attempt, mut relocated) = (0, self.measurements.len() / FIRST_SHARE);
        // With what comparing it told, where it was.
        let mut likeliest: Option<(Optimum, Option<Weighed>)> = None;
        loop {
            let fitted = match self.options.harmonics {
                Some(order) => fit(&medium, order, start, noise, prior, self.variance_components(), ROUNDS),
                None => self.with_best_order(&medium, start, noise, prior),
            }
            .ok_or(ReconstructError::NotSolvable)?;
            let coarse = fitted.fit;
            medium = fitted.weighted;
            let coefficients = coarse.estimate.coefficients.clone();
            let is_carried = motion.is_none();
            let psi = motion.unwrap_or_else(|| {
                carry_over(&medium, &coarse.estimate.psi, &coefficients, &self.measurements, ranges)
            });
            let all = Estimate { coefficients, psi, cost: f64::INFINITY };
            let averaged = self.averaged(&medium);
            let noise = Noise {
                sensor_m: self.stated_m.unwrap_or(averaged * coarse.noise.sensor_m),
                balance_m: averaged * coarse.noise.balance_m,
            };
            let all = if is_carried { self.decoded_in_gaps(&coarse, all, noise, ranges) } else { all };
            let fitted = self.fit_all(coarse.order, all, noise, coarse.prior).ok_or(ReconstructError::NotSolvable)?;
            let mut optimum = self.optimum(coarse, fitted);
            let decoded_again = self.decoded_again(&optimum.fine);
            let now = decoded_again.0.relocated;
            // Where the motion does not settle, the arrangement is wrong, or it is a matter of a few samples.
            let is_given_up = self.is_given_up(&optimum.fine, &optimum.jumps);
            let last = attempt == REPAIRS || CONTRACTION * now > relocated || is_given_up;
            let (next, moved, told) = if now == 0 || last {
                let mut weighed = self.weighed(&optimum, decoded_again, last);
                if weighed.likelier.is_none() || attempt == REPAIRS {
                    // A few wrong poses loosen the balance, and a loose balance lets the decoding place more of them wrongly.
                    if let Some((before, told)) = likeliest.take_if(|(before, _)| before.is_likelier_than(&optimum)) {
                        optimum = before;
                        weighed =
                            told.unwrap_or_else(|| self.weighed(&optimum, self.decoded_again(&optimum.fine), true));
                    }
                }
                match weighed.likelier.take() {
                    Some(likelier) if attempt < REPAIRS => {
                        let moved = moved(&optimum.fine.estimate.psi, &likelier, period);
                        (likelier, moved, Some(weighed))
                    }
                    _ => return Ok(Refined::new(optimum, weighed)),
                }
            } else {
                (decoded_again.0.psi, now, None)
            };
            attempt += 1;
            start = self.on_medium(&medium, ranges, &optimum.fine.estimate.coefficients, &next);
            (motion, relocated) = (Some(next), moved);
            if likeliest.as_ref().is_none_or(|(before, _)| !before.is_likelier_than(&optimum)) {
                likeliest = Some((optimum, told));
            }
        }
    }

    /// A shape that explains all samples with this motion and noise, with the number of harmonics that is asked for, or that the evidence prefers on the
    /// thinned log.
    pub(crate) fn with_order_by_evidence(
        &self,
        coefficients: &[f64],
        psi: &[f64],
        noise: Noise,
        prior: Prior,
    ) -> Option<Vec<f64>> {
        if self.options.harmonics.is_some() {
            return Some(coefficients.to_vec());
        }
        let pieces = segments(&self.measurements, self.scatter_m);
        let medium = thinned_in_ranges(&self.measurements, &pieces, self.scatter_m, ORDER_SAMPLES);
        let start = self.on_medium(&medium, &pieces, coefficients, psi);
        let averaged = self.averaged(&medium);
        let noise = Noise { sensor_m: noise.sensor_m / averaged, balance_m: noise.balance_m / averaged };
        let fitted = self.with_best_order(&medium, start, noise, prior)?;
        Some(fitted.fit.estimate.coefficients)
    }

    /// Compares an optimum with other motions: what its decoding left open, and what else short pieces and doubtful jumps may be. `last`:
    /// its motion will not be decoded again, though the decoding relocates samples.
    fn weighed(&self, optimum: &Optimum, (decoded, superseded): (Decoded, Option<Vec<f64>>), last: bool) -> Weighed {
        let Optimum { fine, measurements, jumps, .. } = optimum;
        let period = fine.prior.symmetry.period_rad();
        let mut ambiguity = Ambiguity::new(decoded.margin);
        let mut alternatives = decoded.alternatives;
        let motions = superseded.iter().chain([&decoded.psi]);
        alternatives.extend(motions.filter_map(|motion| ambiguity.unsettled(&fine.estimate.psi, motion, period)));
        let is_contradicted = self.is_contradicted(fine, jumps);
        let samples = self.measurements.len();
        let is_lost = decoded.relocated > samples / FIRST_SHARE && jumps.len() > samples / LOST;
        let settled = (!last || few(decoded.relocated, samples) || !(is_contradicted || is_lost))
            && !self.is_given_up(fine, jumps);
        if !settled {
            // The samples that may be elsewhere stay ambiguous; what was not held against other motions may be anywhere.
            if few(decoded.relocated, samples) {
                ambiguity.open(0..samples);
            }
            return Weighed { ambiguity_rad: ambiguity.ambiguity_rad(), settled, rivals: Vec::new(), likelier: None };
        }
        let starts: Vec<usize> = jumps.iter().map(|jump| jump.sample).collect();
        let starts = piece_starts(&starts, &fine.estimate.psi, period);
        alternatives.extend(reassociated(measurements, fine, &starts, &mut ambiguity));
        let found = rival_motions(measurements, fine, &starts, &mut ambiguity);
        alternatives.extend(found.alternatives);
        alternatives.extend(landings(measurements, &self.palms(), fine, jumps, &mut ambiguity));
        let jumps_of = |estimate: &Estimate| self.jumps(estimate, period);
        let compared = compare_evidence(measurements, fine, &alternatives, &jumps_of, &mut ambiguity);
        open_out_of_balance(measurements, fine, &starts, &mut ambiguity);
        let rivals = found.preferred.into_iter().chain(compared.nearly_as_likely).collect();
        let likelier = compared.likelier.map(|estimate| estimate.psi);
        Weighed { ambiguity_rad: ambiguity.ambiguity_rad(), settled, rivals, likelier }
    }

    fn optimum(&self, coarse: Fit, Fitted { fit: mut fine, weighted: measurements }: Fitted) -> Optimum {
        let Estimate { coefficients, psi, .. } = &fine.estimate;
        fine.evidence.samples_per_error =
            samples_per_error_by(&measurements, coefficients, psi).max(self.samples_per_error);
        let jumps = self.jumps(&fine.estimate, fine.prior.symmetry.period_rad());
        let posterior = with_jumps(&measurements, &fine, &jumps);
        Optimum { coarse, fine, measurements, jumps, posterior }
    }

    /// An optimum fitted again, with readings that are a little better.
    pub(super) fn refitted(&self, of: &Refined) -> Option<Refined> {
        self.refitted_from(of.fine.estimate.clone(), of)
    }

    /// The same from another estimate.
    pub(super) fn refitted_from(&self, estimate: Estimate, of: &Refined) -> Option<Refined> {
        let Fit { order, noise, prior, .. } = of.fine;
        let fitted = fit(&self.measurements, order, estimate, noise, prior, self.variance_components_of_all(), ROUNDS)?;
        let Optimum { coarse, fine, measurements, posterior, .. } = self.optimum(of.coarse.clone(), fitted);
        let (ambiguity_rad, symmetry, settled) = (of.ambiguity_rad.clone(), of.symmetry, of.settled);
        let (rivals, as_likely) = (Vec::new(), Vec::new());
        Some(Refined { coarse, fine, measurements, ambiguity_rad, symmetry, settled, posterior, rivals, as_likely })
    }

    /// The optimum with twice as many harmonics.
    pub(crate) fn with_more_harmonics(&self, of: &Refined) -> Option<Estimate> {
        let Fit { estimate, order, noise, prior, .. } = of.fine.clone();
        let components = self.variance_components_of_all();
        fit(&of.measurements, 2 * order, estimate, noise, prior, components, ROUNDS).map(|fitted| fitted.fit.estimate)
    }

    /// The motion decoded with the shape of a fit to all samples; where ambiguous ones were set aside, also as it came out with them.
    pub(super) fn decoded_again(&self, fine: &Fit) -> (Decoded, Option<Vec<f64>>) {
        let of_all = decode(&self.measurements, fine, self.floor_m(), None);
        match self.without_ambiguous(&self.measurements, fine, &of_all) {
            Some(again) => (again, Some(of_all.psi)),
            None => (of_all, None),
        }
    }

    /// The optimum over all samples. A shape that misses the balance can make the balance seem loose, and a loose balance holds it there: the
    /// centre of mass of nearly round objects was then off by ten error bars. So where the balance comes out loose, the fit is repeated from
    /// one as exact as statics has it, and the evidence decides.
    pub(crate) fn fit_all(&self, order: usize, start: Estimate, noise: Noise, prior: Prior) -> Option<Fitted> {
        let fit_from = |start: Estimate, noise: Noise| {
            fit(&self.measurements, order, start, noise, prior, self.variance_components_of_all(), ROUNDS)
        };
        let loose = fit_from(start, noise)?;
        let Some(exact) = with_exact_balance(loose.fit.noise) else { return Some(loose) };
        let likelier = |Fitted { fit: exact, .. }: &Fitted| {
            exact.noise.balance_m < STAYS_EXACT * loose.fit.noise.balance_m
                && exact.evidence.log() > loose.fit.evidence.log()
        };
        Some(fit_from(loose.fit.estimate.clone(), exact).filter(likelier).unwrap_or(loose))
    }

    /// The standard deviations that a fit to the thinned log may estimate.
    pub(super) fn variance_components(&self) -> VarianceComponents {
        VarianceComponents {
            sensor: true,
            floor_m: SENSOR_FLOOR * self.prior.size_m,
            least_balance_share: self.least_balance_share,
        }
    }

    /// The same for all samples.
    pub(crate) fn variance_components_of_all(&self) -> VarianceComponents {
        VarianceComponents {
            sensor: self.stated_m.is_none(),
            least_balance_share: LEAST_BALANCE_SHARE,
            ..self.variance_components()
        }
    }

    /// In decoding, no contact is taken to be more exact than this, metres.
    pub(crate) fn floor_m(&self) -> f64 {
        DECODING_FLOOR * self.scatter_m
    }

    /// The decoding with the shape fitted without the samples `aside`. Transitions to the samples `blind` do not consult statics.
    /// `None` when too little is left.
    fn decoded_without(
        &self,
        weighted: &Measurements,
        fine: &Fit,
        aside: &[usize],
        blind: &(dyn Fn(usize) -> bool + Sync),
    ) -> Option<Decoded> {
        let mut measurements = self.measurements.clone();
        aside.iter().for_each(|&index| measurements.instants[index].set_aside());
        let estimate = fine.estimate.clone();
        let Fitted { fit: others, weighted: measurements } = fit(
            &measurements,
            fine.order,
            estimate,
            fine.noise,
            fine.prior,
            self.variance_components_of_all(),
            ROUNDS,
        )?;
        let predictive = PredictiveShape::from(&measurements, &others)?;
        let aside = Aside { samples: aside, blind, predictive: &predictive };
        Some(decode(weighted, &others, self.floor_m(), Some(aside)))
    }

    /// The decoding with the shape fitted without the ambiguous samples, which bend the shape towards the poses that they were
    /// given. `None` when there are none, or too many.
    fn without_ambiguous(&self, weighted: &Measurements, fine: &Fit, of_all: &Decoded) -> Option<Decoded> {
        let count = of_all.psi.len();
        let ambiguous: Vec<usize> = (0..count).filter(|&sample| of_all.is_ambiguous(sample)).collect();
        let beside = |index: usize| {
            let first = ambiguous.partition_point(|&other| other + NEIGHBOURS_SET_ASIDE < index);
            ambiguous.get(first).is_some_and(|&other| other <= index + NEIGHBOURS_SET_ASIDE)
        };
        // A pose at an end of the log has neighbours on one side only; with noisy contacts, that it is wrong may show in nothing
        // but the balance.
        let Noise { sensor_m, balance_m } = fine.noise;
        let mean_radius_m = fine.estimate.coefficients[0].abs();
        let inexact = balance_is_missed(sensor_m, balance_m, mean_radius_m)
            && balance_m < balance_limit_m(sensor_m, mean_radius_m);
        let end = |index: usize| inexact && (index < END || index + END >= count);
        let aside: Vec<usize> = (0..count).filter(|&index| beside(index) || end(index)).collect();
        if aside.is_empty() || aside.len() > MOST_SET_ASIDE {
            return None;
        }
        let mut again = self.decoded_without(weighted, fine, &aside, &beside)?;
        again.relocated = moved(&fine.estimate.psi, &again.psi, fine.prior.symmetry.period_rad());
        Some(again)
    }

    /// The motion of a fit, unwrapped; of a symmetric object the one that statics allows.
    pub(super) fn motion(&self, fine: &Fit) -> Vec<f64> {
        self.allowed_motion(&fine.estimate.coefficients, &fine.estimate.psi, fine.prior.symmetry.period_rad())
    }

    /// The same of some shape and motion.
    fn allowed_motion(&self, coefficients: &[f64], psi: &[f64], period: f64) -> Vec<f64> {
        let mut psi = psi.to_vec();
        if period < TAU {
            psi = carried_copies(&SupportFunction::from_coefficients(coefficients), &self.palms(), &psi, period);
        }
        unwrap(&mut psi);
        psi
    }

    /// Jumps of a fit that statics does not allow.
    pub(super) fn unphysical_jumps(&self, estimate: &Estimate, period: f64) -> usize {
        self.jumps(estimate, period).iter().filter(|jump| !jump.physical).count()
    }

    /// The jumps in the motion that statics allows an object with such a period.
    pub(super) fn jumps(&self, Estimate { coefficients, psi, .. }: &Estimate, period: f64) -> Vec<DetectedJump> {
        let psi = self.allowed_motion(coefficients, psi, period);
        let jumps = detect_jumps(&SupportFunction::from_coefficients(coefficients), &self.log, &psi);
        self.measurements.work.add_passages(jumps.len());
        jumps
    }

    pub(crate) fn palms(&self) -> Vec<PalmPair> {
        self.log.palms()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::evidence::variance_components::balance_weight;
    use crate::estimate::model::layout::coefficients_to_order;
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, Simulation, simulate};

    /// An object between palms that move at random for 20 s ([`PalmMotion::random`]), read at such a rate with such a noise.
    fn felt(shape: &SupportFunction, seed: u64, amplitude: f64, rate_hz: f64, noise_sd_m: f64) -> Simulation {
        let motion = PalmMotion::random(seed, 20.0, amplitude).and_then(|motion| motion.sample(rate_hz));
        let touchpad = Touchpad { noise_sd_m, ..Touchpad::ideal() };
        let options = SimulateOptions { touchpad, ..SimulateOptions::default() };
        simulate(shape, &motion.expect("possible"), &options).expect("possible")
    }

    /// An optimum with this shape and motion, as if it were one.
    fn refined(job: &Job, shape: &SupportFunction, psi: &[f64], noise: Noise) -> Refined {
        let estimate = Estimate { coefficients: shape.coefficients(), psi: psi.to_vec(), cost: 0.0 };
        let order = shape.harmonics_m().len();
        let fine = Fit { estimate, order, noise, prior: job.prior, evidence: Evidence::NONE };
        Refined {
            coarse: fine.clone(),
            fine,
            measurements: job.measurements.clone(),
            ambiguity_rad: vec![0.0; psi.len()],
            symmetry: FoundSymmetry::default(),
            settled: true,
            posterior: Evidence::NONE,
            rivals: Vec::new(),
            as_likely: Vec::new(),
        }
    }

    #[test]
    fn a_shape_that_misses_the_balance_does_not_make_it_loose() {
        // Nearly round: the centre of mass is what tells its orientation.
        let shape = SupportFunction::new(0.03, vec![[0.002, 0.001], [2e-4, 1e-4], [1e-4, -1e-4]]);
        let run = felt(&shape, 4, 0.6, 20.0, 5e-5);
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        // From a centre of mass that is off by a millimetre, and a balance that is as loose.
        let mut coefficients = shape.coefficients();
        coefficients[1] += 1e-3;
        let start = Estimate { coefficients, psi, cost: f64::INFINITY };
        let found = job.fit_all(4, start, Noise { sensor_m: 5e-5, balance_m: 1e-3 }, job.prior).expect("an optimum");
        assert!(found.fit.noise.balance_m < 0.2 * found.fit.noise.sensor_m, "{:?}", found.fit.noise);
    }

    #[test]
    fn what_cannot_be_certified_is_worth_no_more_once_the_work_is_spent() {
        let shape = NamedShape::Egg.shape(0.03).expect("a valid size");
        let run = felt(&shape, 4, 0.2, 10.0, 5e-5);
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let is_worth_no_more = |spent: f64, sensor_sds: f64, ambiguity_share: f64| {
            let noise = Noise { sensor_m: sensor_sds * job.scatter_m, balance_m: 5e-5 };
            let ambiguity_rad = vec![ambiguity_share * options.limits.ambiguity_rad; psi.len()];
            let refined = Refined { ambiguity_rad, ..refined(&job, &shape, &psi, noise) };
            let mut job = job.clone();
            job.measurements.work = job.measurements.work.afresh(1.0);
            while !job.measurements.work.is_spent_by(spent) {
                job.measurements.work.add_passages(100);
            }
            job.is_worth_no_more(&refined)
        };
        let most = WORTH_OF_A_FIT;
        assert!(is_worth_no_more(most, 1.0, 1.01) && !is_worth_no_more(most, 1.0, 0.99));
        assert!(!is_worth_no_more(0.99 * most, 1.0, 1.01), "its contacts are explained");
        assert!(is_worth_no_more(1.0, 1.01 * CONTRADICTED, 0.0) && !is_worth_no_more(1.0, 0.99 * CONTRADICTED, 1.01));
        assert!(!is_worth_no_more(0.99, 2.0 * CONTRADICTED, 2.0));
    }

    #[test]
    fn a_reading_far_from_its_neighbours_counts_where_the_object_is_in_motion() {
        let shape = NamedShape::Stone.shape(0.03).expect("a valid size");
        let mut run = felt(&shape, 3, 0.6, 20.0, 5e-5);
        let far = [120, 200];
        for index in far {
            run.log.samples[index].s1_m = run.log.samples[index].s1_m.map(|s1_m| s1_m + 0.02);
        }
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        assert_eq!(job.outliers, far);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        // The first of them falls, and balance does not hold there.
        let kept_with = |missed_sds: f64| {
            let mut refined = refined(&job, &shape, &psi, Noise { sensor_m: 5e-5, balance_m: 1e-5 });
            refined.measurements.instants[far[0]].balance_weight = balance_weight(missed_sds);
            job.with_readings_in_motion(&refined)
        };
        assert!(kept_with(5.0).is_none(), "an object at rest");
        let job = kept_with(50.0).expect("one reading is kept");
        let is_seen = far.map(|index| job.measurements.instants[index].weight1 > 0.0);
        assert_eq!((&job.kept[..], &job.outliers[..], is_seen), (&far[..1], &far[1..], [true, false]));
        let again = job.recalibrated(&run.log, job.calibration);
        assert_eq!(again.kept, job.kept, "whatever the calibration");
    }

    #[test]
    fn means_along_bent_paths_are_no_more_exact_than_the_fit_to_them() {
        let shape = NamedShape::Egg.shape(0.03).expect("a valid size");
        let run = felt(&shape, 4, 0.2, 40.0, 0.0);
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let whole = 0..psi.len();
        let ranges = [whole];
        let medium = thinned_in_ranges(&job.measurements, &ranges, job.scatter_m, ORDER_SAMPLES);
        assert!(job.averaged(&medium) > 1.1);
        let of_medium = |sensor_m: f64| {
            let mut refined = refined(&job, &shape, &psi, Noise { sensor_m: 1e-5, balance_m: 1e-6 });
            refined.fine.noise = Noise { sensor_m, balance_m: 0.1 * sensor_m };
            let Noise { sensor_m, balance_m } = job.fit_on_medium(&medium, &ranges, &refined).noise;
            [sensor_m, balance_m]
        };
        assert_eq!(of_medium(1e-8), [1e-5, 1e-6], "samples that are nearly exact");
        let [sensor_m, balance_m] = of_medium(1e-3);
        let of_mean = 1e-3 / job.averaged(&medium);
        assert!((sensor_m / of_mean - 1.0).abs() < 1e-9 && (balance_m / of_mean - 0.1).abs() < 1e-9);
    }

    #[test]
    fn where_a_contact_is_missing_the_motion_is_decoded_and_not_drawn_as_a_straight_line() {
        use crate::math::angle::wrapped;
        use crate::math::statistics::root_mean_square;

        let shape = NamedShape::Pebble.shape(0.03).expect("a valid size");
        let mut run = felt(&shape, 4, 0.2, 10.0, 5e-5);
        let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let options = ReconstructOptions::default();
        let gap = 60..100;
        let mut straight = truth.clone();
        for index in gap.clone() {
            let share = (index - gap.start) as f64 / gap.len() as f64;
            straight[index] = truth[gap.start] + share * (truth[gap.end] - truth[gap.start]);
        }
        let off_rad = |psi: &[f64]| {
            root_mean_square(&gap.clone().map(|index| wrapped(psi[index] - truth[index])).collect::<Vec<_>>())
        };
        assert!(off_rad(&straight) > 0.2, "{}", off_rad(&straight));
        let filled = |log: &Log, ranges: &[Range<usize>]| {
            let job = Job::new(log, &options);
            let estimate = Estimate { coefficients: shape.coefficients(), psi: straight.clone(), cost: 0.0 };
            let noise = Noise { sensor_m: 5e-5, balance_m: 1e-5 };
            let order = shape.harmonics_m().len();
            let fit = Fit { estimate: estimate.clone(), order, noise, prior: job.prior, evidence: Evidence::NONE };
            job.decoded_in_gaps(&fit, estimate, noise, ranges).psi
        };
        let whole = 0..truth.len();
        let arranged = [0..gap.start, gap.end..truth.len()];
        assert_eq!(filled(&run.log, std::slice::from_ref(&whole)), straight, "nothing is missing");
        assert!(off_rad(&filled(&run.log, &arranged)) < 0.05, "what was not arranged");
        run.log.samples[gap.clone()].iter_mut().for_each(|sample| sample.s2_m = None);
        assert!(off_rad(&filled(&run.log, std::slice::from_ref(&whole))) < 0.05, "what lacks a contact");
    }

    #[test]
    fn a_first_fit_takes_more_harmonics_where_they_explain_contacts_that_fewer_contradict() {
        use crate::plan::{PalmLimits, plan_turn};
        use crate::shape::rounded_polygon;

        let shape = rounded_polygon(4, 0.15, 0.16).expect("possible").scaled(0.03).translated(0.002, 0.001);
        let plan = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
        let motion = plan.motion.sample(15.0).expect("possible");
        let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
        let options = SimulateOptions { touchpad, start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
        let run = simulate(&shape, &motion, &options).expect("possible");
        let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let whole = 0..truth.len();
        let medium = thinned_in_ranges(&job.measurements, std::slice::from_ref(&whole), job.scatter_m, ORDER_SAMPLES);
        let order = |from: usize, psi: &[f64]| {
            let mut coefficients = shape.coefficients();
            coefficients_to_order(&mut coefficients, from);
            let rough = job.rough(&medium, job.on_medium(&medium, std::slice::from_ref(&whole), &coefficients, psi));
            job.with_harmonics_for_contacts(&medium, rough.expect("an optimum")).order
        };
        let wrong: Vec<f64> = truth.iter().enumerate().map(|(index, psi)| psi + (index / 40 % 2) as f64).collect();
        let orders = [order(10, &truth), order(24, &truth), order(10, &wrong)];
        assert!(orders[0] > 10 && orders[1] == 24 && orders[2] == 10, "{orders:?}");
    }

    #[test]
    fn errors_with_a_memory_are_no_contradiction() {
        use crate::estimate::model::sensor_memory::with_memory;

        let shape = NamedShape::Egg.shape(0.03).expect("a valid size");
        let run = felt(&shape, 4, 0.2, 20.0, 0.0);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let options = ReconstructOptions::default();
        let is_contradicted = |memory: f64| {
            let log = with_memory(run.log.clone(), 1e-4, memory);
            let job = Job::new(&log, &options);
            let estimate = Estimate { coefficients: shape.coefficients(), psi: psi.clone(), cost: 0.0 };
            let noise = Noise { sensor_m: 1.1 * CONTRADICTED * job.scatter_m, balance_m: 5e-5 };
            let order = shape.harmonics_m().len();
            job.is_contradicted(&Fit { estimate, order, noise, prior: job.prior, evidence: Evidence::NONE }, &[])
        };
        assert!(is_contradicted(1.0) && !is_contradicted(5.0));
    }

    #[test]
    fn the_number_of_harmonics_is_the_one_asked_for_or_else_what_the_evidence_prefers() {
        let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let run = felt(&shape, 4, 0.2, 20.0, 5e-5);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let order = |harmonics: Option<usize>, from: usize| {
            let options = ReconstructOptions { harmonics, ..ReconstructOptions::default() };
            let job = Job::new(&run.log, &options);
            let mut coefficients = shape.coefficients();
            coefficients_to_order(&mut coefficients, from);
            let noise = Noise { sensor_m: 5e-5, balance_m: 2e-5 };
            let chosen = job.with_order_by_evidence(&coefficients, &psi, noise, job.prior).expect("an optimum");
            Layout::of_coefficients(&chosen).order
        };
        assert_eq!(order(Some(20), 20), 20);
        // What would be too few or too many for three is left, but for one step more.
        assert!((4..=8).contains(&order(None, 20)), "{}", order(None, 20));
        assert!((4..=8).contains(&order(None, 3)), "{}", order(None, 3));
    }

    #[test]
    fn two_in_a_hundred_samples_are_few() {
        assert!(few(20, 1000) && !few(21, 1000) && few(0, 0));
    }
}
