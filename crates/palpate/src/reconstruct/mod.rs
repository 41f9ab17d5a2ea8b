//! Log in, shape, motion and centre of mass out.
//!
//! [`reconstruct`] runs through these stages, a file each:
//!
//! 1. `noise`, `pieces`, `windows`: how noisy the log is, where the contacts leap, and what to look at;
//! 2. `start` (on the closed forms of `quadrature`): starts from nothing, over stretches that explain themselves;
//! 3. `grow`, `search`: from there over the whole log, through jumps, as several hypotheses;
//! 4. `smooth` (on `residuals` and `problem`): maximum likelihood over all samples, every pose eliminated exactly;
//! 5. `evidence`: number of harmonics, noise and prior, by what the data say of them;
//! 6. `track` (on `place`, `tabulated` and `known`): the way of the shape through the log; samples put at a wrong pose are placed anew;
//! 7. `posterior`, `felt`, `brief` (on `known`): error bars, which boundary was felt, and what too few samples cannot tell;
//! 8. `jumps`, `certificate`: is it right, and is it the only answer. When not, the search goes on.
//!
//! That is [`Method::Likelihood`]. `given` is the fourth stage alone, with everything else given. `integral` holds the methods that integrate instead: `ode`, the paper's own (on rates from
//! `smoothing`), and `quadrature`.

mod assemble;
mod bound;
mod brief;
mod certificate;
mod diagnostics;
mod evidence;
mod felt;
mod given;
mod grow;
mod integral;
mod jumps;
mod known;
mod noise;
mod ode;
mod options;
mod pieces;
mod place;
mod posterior;
mod problem;
mod quadrature;
mod reconstruction;
mod residuals;
mod search;
mod smooth;
mod smoothing;
mod start;
mod tabulated;
mod track;
mod windows;

pub use bound::cramer_rao_bound_m;
pub use diagnostics::{ContactDiagnostics, diagnostics};
pub use given::{SmoothOptions, Smoothed, smooth_from};
pub use integral::{Integrated, PaperEquations};
pub use options::{Method, Progress, ReconstructError, ReconstructOptions};
pub use reconstruction::{Jump, OutlinePoint, Pose, Reconstruction};

use std::ops::Range;

use crate::log::Log;
use crate::shape::SupportFunction;
use rayon::prelude::*;

use assemble::{Expected, Judged, assemble};
use evidence::{Fit, Freedom, ROUNDS, choose_order, fit};
use known::Known;
use problem::Problem;
use smooth::{Effort, Estimate, Noise, Prior, Smoother};
use track::{Aside, Track, track};

/// Fewest samples with both contacts seen that are tried.
pub const FEWEST_SAMPLES: usize = 12;

/// Most harmonics that a user may ask for.
pub const MOST_HARMONICS: usize = 64;

/// Times that badly placed samples are placed anew.
const REPAIRS: usize = 3;

/// Standard deviation of the balance that a fit begins with, as shares of that of the contacts.
const BALANCE_SHARES: [f64; 2] = [1.0, 0.1];

/// Samples beside a doubtful one that are set aside with it, and how many at the most.
const BESIDE: usize = 5;
const MOST_ASIDE: usize = 240;

/// Explanations that are looked at besides the first, where the balance is missed.
const SECOND_THOUGHTS: usize = 2;

/// Samples at each end of the log that are set aside when the balance is missed by more than this share of the sensor noise.
const END: usize = 60;
const INEXACT: f64 = 0.5;

/// Contacts with more noise than this share of the mean radius are noisy.
const NOISY: f64 = 3e-4;

/// Samples that the choice of the number of harmonics works on.
const ORDER_SAMPLES: usize = 450;

/// Reconstructs shape, motion and centre of mass from a palm log and nothing else.
///
/// `progress` is called now and then from any thread. The result does not depend on the number of threads.
///
/// # Errors
/// When the log cannot be solved at all (see [`ReconstructError`]). A doubtful answer is not an error: it comes back as a
/// [`Reconstruction`] that is not certified.
pub fn reconstruct(
    log: &Log,
    options: &ReconstructOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Reconstruction, ReconstructError> {
    let tell = |stage, fraction| progress(Progress { stage, fraction });
    check(log, options)?;
    if options.method != Method::Likelihood {
        return integral::reconstruct(log, options, &|share| tell("integrating", share));
    }
    let task = Task::new(log, options);
    let mut best: Option<Judged> = None;
    let mut explanations = 0;
    let mut failure = None;
    search::search(
        &task.problem,
        task.scatter_m,
        task.prior,
        &|share| tell("searching for arrangements", 0.9 * share),
        &mut |found| {
            match task.judge(&found) {
                Ok(judged) => {
                    explanations += usize::from(judged.explained);
                    if best.as_ref().is_none_or(|other| judged.is_likelier_than(other)) {
                        best = Some(judged);
                    }
                }
                Err(error) => failure = Some(error),
            }
            // Where nothing speaks against an answer, another would tell no more; but noise hides much, and only the balance tells.
            let noisy_balance = |judged: &Judged| {
                let Reconstruction { sensor_sd_m, balance_sd_m, ref shape, .. } = judged.result;
                missed(sensor_sd_m, balance_sd_m, shape.mean_radius_m())
            };
            best.as_ref().is_some_and(|best| explanations > if noisy_balance(best) { SECOND_THOUGHTS } else { 0 })
        },
    );
    tell("done", 1.0);
    best.map(|judged| judged.result).ok_or_else(|| {
        failure.unwrap_or_else(|| ReconstructError::NoStart {
            advice: "check the units and signs of the palm angles and contact positions".to_owned(),
        })
    })
}

impl Judged {
    /// Of results that nothing speaks against, the one with more evidence; of others, by jumps that cannot be, then by what
    /// the fit leaves.
    fn is_likelier_than(&self, other: &Self) -> bool {
        match (self.explained, other.explained) {
            (true, true) => self.log_evidence > other.log_evidence,
            (false, false) => self.doubt() < other.doubt(),
            (explained, _) => explained,
        }
    }

    fn doubt(&self) -> f64 {
        let impossible = self.result.jumps.iter().filter(|jump| !jump.physical).count();
        1e3 * impossible as f64 + self.result.chi2_per_dof.clamp(0.0, 999.0)
    }
}

/// Whether the balance is missed by more than exact statics would, and contacts too noisy to tell why.
fn missed(sensor_m: f64, balance_m: f64, mean_radius_m: f64) -> bool {
    sensor_m > NOISY * mean_radius_m.abs() && balance_m > INEXACT * sensor_m
}

/// The same from a known start, one orientation per sample (radians) and a shape: nothing is searched for. For a log that
/// was solved before, or to see what the estimator could reach. Methods that integrate take their initial conditions from the start,
/// one for each piece between jumps, and nothing else.
///
/// # Errors
/// As [`reconstruct`]; also when `psi_rad` is not as long as the log.
pub fn reconstruct_from(
    log: &Log,
    shape: &SupportFunction,
    psi_rad: &[f64],
    options: &ReconstructOptions,
) -> Result<Reconstruction, ReconstructError> {
    check(log, options)?;
    check_start(log, psi_rad)?;
    if options.method != Method::Likelihood {
        return integral::reconstruct_from(log, shape, psi_rad, options);
    }
    let task = Task::new(log, options);
    let ranges = pieces::pieces(&task.problem, task.scatter_m);
    let mut coefficients = shape.coefficients();
    smooth::coefficients_to_order(&mut coefficients, START_ORDER);
    let estimate = Estimate { coefficients, psi: psi_rad.to_vec(), cost: 0.0 };
    let found = search::Found { thin: task.problem.clone(), ranges, estimates: vec![estimate] };
    let refined = task.refine(&found, 0)?;
    Ok(task.assemble(refined)?.result)
}

/// Harmonics that a given start is cut to before the number is chosen.
const START_ORDER: usize = 8;

/// A log made ready, with what is known of its noise.
struct Task<'a> {
    log: &'a Log,
    options: &'a ReconstructOptions,
    problem: Problem,
    stated_m: Option<f64>,
    scatter_m: f64,
    prior: Prior,
}

/// An arrangement smoothed to the end.
struct Refined {
    /// On the thinned log, where the number of harmonics was chosen.
    coarse: Fit,
    /// On all samples.
    fine: Fit,
    /// All samples, with the weight that the balance has at each.
    problem: Problem,
    /// For each sample, how much more it costs to put it elsewhere (see [`track::Track`]).
    margin: Vec<f64>,
}

impl<'a> Task<'a> {
    fn new(log: &'a Log, options: &'a ReconstructOptions) -> Self {
        let stated_m = options.sensor_sd_m.or_else(|| stated_noise_m(log));
        let problem = Problem::new(log, stated_m);
        let scatter_m = noise::contact_scatter_m(&problem);
        let size_m = problem.size_m();
        Self { log, options, problem, stated_m, scatter_m, prior: Prior { size_m, scale_m: 0.5 * size_m } }
    }

    /// Takes one arrangement of the search to the optimum over all samples.
    fn refine(&self, found: &search::Found, arrangement: usize) -> Result<Refined, ReconstructError> {
        let start = found.estimates.get(arrangement).ok_or(ReconstructError::NotSolvable)?;
        let medium = search::thinned_in_ranges(&self.problem, &found.ranges, ORDER_SAMPLES);
        let psi = search::carry_over(&found.thin, &start.psi, &start.coefficients, &medium, &found.ranges);
        let start = Estimate { coefficients: start.coefficients.clone(), psi, cost: f64::INFINITY };
        let rough = self.rough(&medium, start).ok_or(ReconstructError::NotSolvable)?;
        let psi = track(&medium, &rough, self.floor_m(), None).psi;
        let rough = Fit { estimate: Estimate { psi, ..rough.estimate }, ..rough };
        self.settle(medium, &found.ranges, rough)
    }

    /// A few samples at a wrong pose would ask for harmonics that the object has not, so the first fit has none to give. Balance
    /// as exact as statics has it is tried, and balance that friction or pace spoil.
    fn rough(&self, medium: &Problem, start: Estimate) -> Option<Fit> {
        let sd = self.scatter_m.max(1e-3 * self.prior.size_m);
        let order = start.coefficients.len() / 2;
        let with_share = |share: f64| {
            let noise = Noise { sensor_m: sd, balance_m: share * sd };
            fit(&mut medium.clone(), order, start.clone(), noise, self.prior, self.freedom(), ROUNDS)
        };
        BALANCE_SHARES.into_iter().filter_map(with_share).max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
    }

    /// Chooses the number of harmonics and fits all samples, until the way of the shape through the log leaves every sample where
    /// it is. `rough` is a fit to the thinned log.
    fn settle(&self, mut medium: Problem, ranges: &[Range<usize>], rough: Fit) -> Result<Refined, ReconstructError> {
        let Fit { estimate: mut start, noise, prior, .. } = rough;
        let mut tracked: Option<Vec<f64>> = None;
        let (mut attempt, mut unsettled) = (0, self.problem.len() / 4);
        loop {
            let coarse = match self.options.harmonics {
                Some(order) => fit(&mut medium, order, start, noise, prior, self.freedom(), ROUNDS),
                None => choose_order(&mut medium, start, noise, prior, self.freedom()),
            }
            .ok_or(ReconstructError::NotSolvable)?;
            let mut problem = self.problem.clone();
            let coefficients = coarse.estimate.coefficients.clone();
            let psi = tracked
                .unwrap_or_else(|| search::carry_over(&medium, &coarse.estimate.psi, &coefficients, &problem, ranges));
            let all = Estimate { coefficients, psi, cost: f64::INFINITY };
            let noise = Noise { sensor_m: self.stated_m.unwrap_or(coarse.noise.sensor_m), ..coarse.noise };
            let fine = fit(&mut problem, coarse.order, all, noise, coarse.prior, self.freedom_of_all(), ROUNDS)
                .ok_or(ReconstructError::NotSolvable)?;
            let mut track = track(&self.problem, &fine, self.floor_m(), None);
            if let Some(again) = self.without_doubtful(&fine, &track) {
                track = again;
            }
            // Where the way does not settle, the arrangement is wrong.
            if track.moved == 0 || attempt == REPAIRS || 2 * track.moved > unsettled {
                return Ok(Refined { coarse, fine, problem, margin: track.margin });
            }
            attempt += 1;
            unsettled = track.moved;
            let coefficients = fine.estimate.coefficients;
            let psi = search::carry_over(&self.problem, &track.psi, &coefficients, &medium, ranges);
            start = Estimate { coefficients, psi, cost: f64::INFINITY };
            tracked = Some(track.psi);
        }
    }

    /// What may be learnt of the noise from the thinned log.
    fn freedom(&self) -> Freedom {
        Freedom { sensor: true, floor_m: 1e-6 * self.prior.size_m }
    }

    /// The same from all samples.
    fn freedom_of_all(&self) -> Freedom {
        Freedom { sensor: self.stated_m.is_none(), ..self.freedom() }
    }

    /// No contact is believed to be more exact than this on the way through the log, metres.
    fn floor_m(&self) -> f64 {
        0.3 * self.scatter_m
    }

    /// The way through the log of the shape that the samples have without some of them. `None` when too little is left.
    fn with_aside(&self, fine: &Fit, aside: &[usize], doubtful: &(dyn Fn(usize) -> bool + Sync)) -> Option<Track> {
        let mut problem = self.problem.clone();
        aside.iter().for_each(|&index| problem.instants[index].set_aside());
        let estimate = fine.estimate.clone();
        let others = fit(&mut problem, fine.order, estimate, fine.noise, fine.prior, self.freedom_of_all(), ROUNDS)?;
        let known = Known::from(&problem, &others)?;
        let aside = Aside { samples: aside, doubtful, known: &known };
        Some(track(&self.problem, &others, self.floor_m(), Some(aside)))
    }

    /// The way through the log of the shape that the samples beyond doubt have without the others, which bend the shape towards
    /// the poses that they were given. `None` when there are none, or too many.
    fn without_doubtful(&self, fine: &Fit, of_all: &Track) -> Option<Track> {
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
        let inexact = missed(sensor_m, balance_m, mean_radius_m)
            && balance_m < certificate::balance_limit_m(sensor_m, mean_radius_m);
        let end = |index: usize| inexact && (index < END || index + END >= count);
        let aside: Vec<usize> = (0..count).filter(|&index| beside(index) || end(index)).collect();
        if aside.is_empty() || aside.len() > MOST_ASIDE {
            return None;
        }
        let mut again = self.with_aside(fine, &aside, &beside)?;
        again.moved = of_all.moved + grow::moved(&of_all.psi, &again.psi);
        Some(again)
    }

    fn assemble(&self, refined: Refined) -> Result<Judged, ReconstructError> {
        let expected = Expected { stated_m: self.stated_m, scatter_m: self.scatter_m };
        assemble(self.log, &refined.problem, refined.fine, &refined.margin, expected)
            .ok_or(ReconstructError::NotSolvable)
    }

    /// Takes the arrangements that explain the log about equally well to their ends. Only those count that an object at
    /// rest could go through; when just one does, it is the answer.
    fn judge(&self, found: &search::Found) -> Result<Judged, ReconstructError> {
        let first = self.refine(found, 0)?;
        let rivals = rivals(&found.thin, &found.estimates, &first.coarse);
        let mut results = vec![self.assemble(first)?];
        // An answer wants all of them ruled out; where nothing speaks against one that is not certified, they change nothing.
        let first = &results[0];
        let worth = if first.result.certified {
            MOST_RIVALS
        } else if first.explained {
            0
        } else {
            MOST_RIVALS / 2
        };
        for rival in rivals.into_iter().take(worth) {
            results.extend(self.refine(found, rival).and_then(|refined| self.assemble(refined)));
        }
        let mut possible: Vec<Judged> = Vec::new();
        let mut rest = Vec::new();
        for judged in results {
            if !judged.result.certified {
                rest.push(judged);
            } else if !possible.iter().any(|other| same_result(&other.result, &judged.result)) {
                possible.push(judged);
            }
        }
        possible.sort_by(|a, b| a.result.chi2_per_dof.total_cmp(&b.result.chi2_per_dof));
        let mut answers = possible.into_iter();
        let Some(mut answer) = answers.next() else {
            let likelier = |a: Judged, b: Judged| if b.is_likelier_than(&a) { b } else { a };
            return rest.into_iter().reduce(likelier).ok_or(ReconstructError::NotSolvable);
        };
        let result = &mut answer.result;
        result.others = answers.map(|judged| judged.result).collect();
        result.alternatives = 1 + result.others.len();
        if result.alternatives > 1 {
            (result.certified, result.com_certified) = (false, false);
            result.reason = certificate::ambiguity(result.alternatives);
        }
        Ok(answer)
    }
}

/// Whether two results are one, but for a common rotation and what noise makes of it.
fn same_result(a: &Reconstruction, b: &Reconstruction) -> bool {
    let psi = |result: &Reconstruction| -> Vec<f64> { result.motion.iter().map(|pose| pose.psi_rad).collect() };
    grow::same_motion(&psi(a), &psi(b))
}

fn check(log: &Log, options: &ReconstructOptions) -> Result<(), ReconstructError> {
    if let Some(order) = options.harmonics {
        check_harmonics(order)?;
    }
    if let Some(sd) = options.sensor_sd_m
        && !(sd > 0.0 && sd.is_finite())
    {
        let text = format!("the standard deviation of the sensors must be a positive number of metres, not {sd}");
        return Err(ReconstructError::BadOption(text));
    }
    check_samples(log)
}

fn check_harmonics(order: usize) -> Result<(), ReconstructError> {
    if (2..=MOST_HARMONICS).contains(&order) {
        return Ok(());
    }
    let text = format!("the number of harmonics must be from 2 to {MOST_HARMONICS}, not {order}");
    Err(ReconstructError::BadOption(text))
}

fn check_start(log: &Log, psi_rad: &[f64]) -> Result<(), ReconstructError> {
    if psi_rad.len() == log.samples.len() {
        return Ok(());
    }
    let text = format!("{} orientations were given for {} samples", psi_rad.len(), log.samples.len());
    Err(ReconstructError::BadOption(text))
}

fn check_samples(log: &Log) -> Result<(), ReconstructError> {
    for (index, sample) in log.samples.iter().enumerate() {
        let palms = &sample.palms;
        let numbers = [sample.time_s, palms.phi1_rad, palms.phi2_rad]
            .into_iter()
            .chain(palms.base1_m)
            .chain(palms.base2_m)
            .chain([sample.s1_m, sample.s2_m, sample.s1_sd_m, sample.s2_sd_m].into_iter().flatten());
        let bad = |what: &str| Err(ReconstructError::BadSample { sample: index + 1, what: what.to_owned() });
        if numbers.into_iter().any(|value| !value.is_finite() || value.abs() > LARGEST_VALUE) {
            return bad("a value is not a finite number, or is far too large");
        }
        if palms.phi2_rad.sin().abs() < SMALLEST_OPENING {
            return bad("the palms are parallel");
        }
        if [sample.s1_sd_m, sample.s2_sd_m].into_iter().flatten().any(|sd| sd <= 0.0) {
            return bad("a standard deviation is not positive");
        }
        if index > 0 && log.samples[index - 1].time_s > sample.time_s {
            return bad("time runs backwards");
        }
    }
    let seen = log.samples.iter().filter(|sample| sample.s1_m.is_some() && sample.s2_m.is_some()).count();
    if seen < FEWEST_SAMPLES {
        return Err(ReconstructError::TooFewSamples { seen, needed: FEWEST_SAMPLES });
    }
    Ok(())
}

/// Palms closer to parallel than this (sine of the angle between them) cannot be used.
const SMALLEST_OPENING: f64 = 1e-3;

/// No time, angle or length of a palm log is larger than this.
const LARGEST_VALUE: f64 = 1e12;

/// The median of the standard deviations that the log states, if it states any.
fn stated_noise_m(log: &Log) -> Option<f64> {
    let mut stated: Vec<f64> =
        log.samples.iter().flat_map(|sample| [sample.s1_sd_m, sample.s2_sd_m]).flatten().collect();
    (!stated.is_empty()).then(|| noise::median(&mut stated))
}

/// The arrangements but the first that explain the thinned log about as well as the chosen one, or better.
fn rivals(thin: &Problem, candidates: &[Estimate], chosen: &Fit) -> Vec<usize> {
    let smoother = Smoother::new(thin, chosen.order, chosen.noise, chosen.prior);
    let effort = Effort { iterations: 20, tolerance: 1e-5 };
    let polished: Vec<Estimate> = candidates
        .par_iter()
        .map(|estimate| smoother.run(estimate.coefficients.clone(), estimate.psi.clone(), effort))
        .collect();
    let best = polished.iter().map(|estimate| estimate.cost).fold(f64::INFINITY, f64::min);
    (1..polished.len())
        .filter(|&index| polished[index].cost < best + NEAR_EQUAL)
        .filter(|&index| !polished[..index].iter().any(|other| grow::same_motion(&other.psi, &polished[index].psi)))
        .take(MOST_RIVALS)
        .collect()
}

/// Rivals that are followed to the end, at the most.
const MOST_RIVALS: usize = 4;

/// Two arrangements whose sums of squares differ by less than this explain the log equally well.
const NEAR_EQUAL: f64 = 40.0;
