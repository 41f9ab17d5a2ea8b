//! One arrangement of the search taken to the optimum over all samples, and what came of it put together.

use super::resample::{carry_over, thinned_in_ranges};
use super::restarts::along_weakest_direction;
use crate::estimate::association::alternatives::Ambiguity;
use crate::estimate::association::alternatives::compare_evidence;
use crate::estimate::association::decode::{Aside, Decoded, decode};
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::short_segments::reassociated;
use crate::estimate::evidence::fit::{Fitted, ROUNDS, fit};
use crate::estimate::evidence::order::choose_order;
use crate::estimate::evidence::variance_components::VarianceComponents;
use crate::estimate::jumps::detect_jumps;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::force::balance_is_missed;
use crate::estimate::model::force::balance_limit_m;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::noise_from_log::{contact_scatter_m, stated_noise_m, with_noisy_angles};
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::{moved, unwrap};
use crate::estimate::solver::gauss_newton::Estimate;
use crate::estimate::solver::gauss_newton::Fit;
use crate::log::Log;
use crate::palms::PalmPair;
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::options::ReconstructOptions;
use crate::reconstruct::search::schedule::Found;
use crate::shape::SupportFunction;
use std::ops::Range;

/// Times that badly placed samples are placed anew.
const REPAIRS: usize = 3;

/// Standard deviation of the balance that a fit begins with, as shares of that of the contacts.
const BALANCE_SHARES: [f64; 2] = [1.0, 0.1];

/// An estimate elsewhere whose log evidence on the thinned log is larger by this is taken to its optimum.
const WORTH_A_LOOK: f64 = 1.0;

/// Samples beside a doubtful one that are set aside with it, and how many at the most.
const BESIDE: usize = 5;

const MOST_ASIDE: usize = 240;

/// Samples at each end of the log that are set aside when the balance is missed by more than this share of the sensor noise.
const END: usize = 60;

/// Samples that the choice of the number of harmonics works on.
const ORDER_SAMPLES: usize = 450;

/// A log made ready, with what is known of its noise.
pub(crate) struct Job<'a> {
    pub log: &'a Log,
    pub options: &'a ReconstructOptions,
    pub measurements: Measurements,
    pub stated_m: Option<f64>,
    pub scatter_m: f64,
    pub prior: Prior,
}

/// An arrangement smoothed to the end.
pub(crate) struct Refined {
    /// On the thinned log, where the number of harmonics was chosen.
    pub coarse: Fit,
    /// On all samples.
    pub fine: Fit,
    /// All samples, with the weight that the balance has at each.
    pub measurements: Measurements,
    /// For each sample, how far from its pose another is that explains it about as well, radians.
    pub ambiguity_rad: Vec<f64>,
}

impl<'a> Job<'a> {
    pub(crate) fn new(log: &'a Log, options: &'a ReconstructOptions) -> Self {
        let stated_m = options.sensor_sd_m.or_else(|| stated_noise_m(log));
        let measurements = Measurements::new(log, stated_m);
        let scatter_m = contact_scatter_m(&measurements);
        let size_m = measurements.size_m();
        Self { log, options, measurements, stated_m, scatter_m, prior: Prior { size_m, scale_m: 0.5 * size_m } }
    }

    /// Takes one arrangement of the search to the optimum over all samples.
    pub(crate) fn refine(&self, found: &Found, arrangement: usize) -> Result<Refined, ReconstructError> {
        let start = found.estimates.get(arrangement).ok_or(ReconstructError::NotSolvable)?;
        let medium = thinned_in_ranges(&self.measurements, &found.ranges, ORDER_SAMPLES);
        let psi = carry_over(&found.thin, &start.psi, &start.coefficients, &medium, &found.ranges);
        let start = Estimate { coefficients: start.coefficients.clone(), psi, cost: f64::INFINITY };
        let rough = self.rough(&medium, start).ok_or(ReconstructError::NotSolvable)?;
        let psi = decode(&medium, &rough, self.floor_m(), None).psi;
        let rough = Fit { estimate: Estimate { psi, ..rough.estimate }, ..rough };
        let settled = self.to_fixed_point(&medium, &found.ranges, rough)?;
        Ok(self.with_restarts(&medium, &found.ranges, settled))
    }

    /// The best of an optimum and of those that lie along the valley of its cost.
    fn with_restarts(&self, medium: &Measurements, ranges: &[Range<usize>], mut best: Refined) -> Refined {
        for start in along_weakest_direction(medium, &best.coarse).into_iter().flatten() {
            let Fit { order, noise, prior, log_evidence, .. } = best.coarse;
            // As exact as statics has the balance: what is missed tells on which side the centre of mass is.
            let noise = Noise { balance_m: BALANCE_SHARES[1] * noise.sensor_m, ..noise };
            let there = fit(medium, order, start, noise, prior, self.variance_components(), ROUNDS);
            let Some(Fitted { fit: there, .. }) =
                there.filter(|there| there.fit.log_evidence > log_evidence + WORTH_A_LOOK)
            else {
                continue;
            };
            match self.to_fixed_point(medium, ranges, there) {
                Ok(other) if other.fine.log_evidence > best.fine.log_evidence => best = other,
                _ => {}
            }
        }
        best
    }

    /// A few samples at a wrong pose would ask for harmonics that the object has not, so the first fit has none to give. Balance
    /// as exact as statics has it is tried, and balance that friction or pace spoil.
    fn rough(&self, medium: &Measurements, start: Estimate) -> Option<Fit> {
        let sd = self.scatter_m.max(1e-3 * self.prior.size_m);
        let order = Layout::of_coefficients(&start.coefficients).order;
        let with_share = |share: f64| {
            let noise = Noise { sensor_m: sd, balance_m: share * sd };
            let fitted = fit(medium, order, start.clone(), noise, self.prior, self.variance_components(), ROUNDS);
            fitted.map(|fitted| fitted.fit)
        };
        BALANCE_SHARES.into_iter().filter_map(with_share).max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
    }

    /// Chooses the number of harmonics and fits all samples, until the way of the shape through the log leaves every sample where
    /// it is. `rough` is a fit to the thinned log.
    fn to_fixed_point(
        &self,
        medium: &Measurements,
        ranges: &[Range<usize>],
        rough: Fit,
    ) -> Result<Refined, ReconstructError> {
        let Fit { estimate: mut start, noise, prior, .. } = rough;
        let mut decoded: Option<Vec<f64>> = None;
        let mut medium = medium.clone();
        let (mut attempt, mut unsettled) = (0, self.measurements.len() / 4);
        loop {
            let fitted = match self.options.harmonics {
                Some(order) => fit(&medium, order, start, noise, prior, self.variance_components(), ROUNDS),
                None => choose_order(&medium, start, noise, prior, self.variance_components()),
            }
            .ok_or(ReconstructError::NotSolvable)?;
            let coarse = fitted.fit;
            medium = fitted.weighted;
            let coefficients = coarse.estimate.coefficients.clone();
            let psi = decoded.unwrap_or_else(|| {
                carry_over(&medium, &coarse.estimate.psi, &coefficients, &self.measurements, ranges)
            });
            let all = Estimate { coefficients, psi, cost: f64::INFINITY };
            let noise = Noise { sensor_m: self.stated_m.unwrap_or(coarse.noise.sensor_m), ..coarse.noise };
            let Fitted { fit: fine, weighted: measurements } = fit(
                &self.measurements,
                coarse.order,
                all,
                noise,
                coarse.prior,
                self.variance_components_of_all(),
                ROUNDS,
            )
            .ok_or(ReconstructError::NotSolvable)?;
            let Estimate { coefficients, psi, .. } = &fine.estimate;
            let with_noisy_angles = with_noisy_angles(&self.measurements, coefficients, psi, self.scatter_m);
            let of_all = decode(&with_noisy_angles, &fine, self.floor_m(), None);
            let (mut decoded_now, passed_over) = match self.without_doubtful(&with_noisy_angles, &fine, &of_all) {
                Some(again) => (again, Some(of_all.psi)),
                None => (of_all, None),
            };
            // Where the way does not settle, the arrangement is wrong, or it is a matter of a few samples.
            let last = attempt == REPAIRS || 2 * decoded_now.moved > unsettled;
            if decoded_now.moved == 0 || last {
                let mut doubts = Ambiguity::new(std::mem::take(&mut decoded_now.margin));
                let mut alternatives = std::mem::take(&mut decoded_now.alternatives);
                let ways = passed_over.iter().chain([&decoded_now.psi]);
                alternatives.extend(ways.filter_map(|way| doubts.unsettled(&fine.estimate.psi, way)));
                alternatives.extend(reassociated(&measurements, &fine, &self.starts(&fine), &mut doubts));
                match compare_evidence(&measurements, &fine, &alternatives, &mut doubts) {
                    Some(better) if !last => {
                        decoded_now.moved = moved(&fine.estimate.psi, &better.psi);
                        decoded_now.psi = better.psi;
                    }
                    _ => return Ok(Refined { coarse, fine, measurements, ambiguity_rad: doubts.ambiguity_rad() }),
                }
            }
            attempt += 1;
            unsettled = decoded_now.moved;
            let coefficients = fine.estimate.coefficients;
            let psi = carry_over(&self.measurements, &decoded_now.psi, &coefficients, &medium, ranges);
            start = Estimate { coefficients, psi, cost: f64::INFINITY };
            decoded = Some(decoded_now.psi);
        }
    }

    /// What may be learnt of the noise from the thinned log.
    fn variance_components(&self) -> VarianceComponents {
        VarianceComponents { sensor: true, floor_m: 1e-6 * self.prior.size_m }
    }

    /// The same from all samples.
    fn variance_components_of_all(&self) -> VarianceComponents {
        VarianceComponents { sensor: self.stated_m.is_none(), ..self.variance_components() }
    }

    /// No contact is believed to be more exact than this on the way through the log, metres.
    pub(crate) fn floor_m(&self) -> f64 {
        0.3 * self.scatter_m
    }

    /// The way through the log of the shape that the samples have without some of them. `None` when too little is left.
    fn with_aside(
        &self,
        weighted: &Measurements,
        fine: &Fit,
        aside: &[usize],
        doubtful: &(dyn Fn(usize) -> bool + Sync),
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
        let known = PredictiveShape::from(&measurements, &others)?;
        let aside = Aside { samples: aside, doubtful, known: &known };
        Some(decode(weighted, &others, self.floor_m(), Some(aside)))
    }

    /// The way through the log of the shape that the samples beyond doubt have without the others, which bend the shape towards
    /// the poses that they were given. `None` when there are none, or too many.
    fn without_doubtful(&self, weighted: &Measurements, fine: &Fit, of_all: &Decoded) -> Option<Decoded> {
        let count = of_all.psi.len();
        let doubtful: Vec<usize> = (0..count).filter(|&sample| of_all.doubts(sample)).collect();
        let beside = |index: usize| {
            let first = doubtful.partition_point(|&other| other + BESIDE < index);
            doubtful.get(first).is_some_and(|&other| other <= index + BESIDE)
        };
        // A pose at an end of the log hangs on one side only; that it is wrong may show in nothing but the balance, when the
        // contacts are noisy.
        let Noise { sensor_m, balance_m } = fine.noise;
        let mean_radius_m = fine.estimate.coefficients[0].abs();
        let inexact = balance_is_missed(sensor_m, balance_m, mean_radius_m)
            && balance_m < balance_limit_m(sensor_m, mean_radius_m);
        let end = |index: usize| inexact && (index < END || index + END >= count);
        let aside: Vec<usize> = (0..count).filter(|&index| beside(index) || end(index)).collect();
        if aside.is_empty() || aside.len() > MOST_ASIDE {
            return None;
        }
        let mut again = self.with_aside(weighted, fine, &aside, &beside)?;
        again.moved = moved(&fine.estimate.psi, &again.psi);
        Some(again)
    }

    /// The samples at which the object of a fit has just jumped.
    fn starts(&self, fine: &Fit) -> Vec<usize> {
        let mut psi = fine.estimate.psi.clone();
        unwrap(&mut psi);
        let shape = SupportFunction::from_coefficients(&fine.estimate.coefficients);
        let palms: Vec<PalmPair> = self.log.samples.iter().map(|sample| sample.palms).collect();
        detect_jumps(&shape, &palms, &psi).iter().map(|jump| jump.sample).collect()
    }
}
