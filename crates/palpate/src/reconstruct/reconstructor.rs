//! Reconstruction with more said of the problem than the log says.

use super::mistake::by_readings::are_of_no_object;
use super::options::check::{check_log, check_start};
use super::options::error::ReconstructError;
use super::options::limits::CertificateLimits;
use super::options::method::Method;
use super::options::{Progress, ReconstructOptions};
use super::ordinary_rig::arranged;
use super::paper::initial_conditions as integral;
use super::refine::calibrated::LEFT;
use super::refine::job::Job;
use super::result::friction::{FrictionEstimate, friction};
use super::result::reconstruction::Reconstruction;
use super::search::schedule::{self, Readings, Stage};
use super::selection::Explored;
use super::selection::stray_readings::{are_doubted, with_left_out, without_stray_readings};
use super::start::{Start, arrangement_of, way_of};
use super::verdict::assemble::Candidate;
use crate::estimate::friction::normal_forces::look_exchanged;
use crate::log::{Log, Sample};
use crate::sensor::Rig;
use crate::shape::SupportFunction;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell, RefCell};

/// Sizes in which a known shape is tried, one after the other until one explains the log: each leads to the optimum from up to two per cent
/// away.
const SIZES: [f64; 5] = [1.0, 0.97, 1.03, 0.94, 1.06];

/// What a brief search is worth, as a share of what a log is: what it certifies takes a hundredth, or over flat sides a tenth without being contradicted on
/// the way, and what it refuses took up to twice what the log is worth.
const BRIEFLY: f64 = 0.05;

/// Arrangements of a log that are judged in a brief search: each wrong one costs more than all the rest of it, and the right one is the first or
/// second.
const JUDGED_BRIEFLY: usize = 2;

/// Arrangements that are judged before other forces or mistakes are asked for, where the best misses a few readings by much: these would miss most of them,
/// and a wrong arrangement misses those of the samples that it has elsewhere.
const PATIENCE: usize = 2;

/// Times that a search begins anew without the stray readings that an explanation showed: the next one, no longer bent to these, may show a few more.
const MOST_CLEARINGS: usize = 3;

/// What a search came to.
enum Searched {
    /// A result.
    Ended(Box<Reconstruction>),
    /// The log without stray readings, and how many these were.
    Strays(Log, usize),
}

/// What explains a log where its rig is an ordinary one, found when it is first asked for ([`Reconstructor::explained_by_ordinary_rig`]).
pub(super) type OrdinaryRig<'a> = dyn Fn() -> Option<Reconstruction> + 'a;

/// How far a search goes.
#[derive(Clone, Copy)]
enum Extent<'a> {
    /// The first way alone, and the first arrangements that it finds.
    Brief,
    /// All of it, while this says so ([`Reconstructor::run_while`]).
    While(&'a OrdinaryRig<'a>, &'a dyn Fn(Stage, bool) -> bool),
}

/// Reconstructs logs, with what is known besides them. What is not said is left to the log.
///
/// ```
/// use palpate::reconstruct::Reconstructor;
/// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
/// # let egg = NamedShape::Egg.shape(0.03)?;
/// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
/// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
/// # let log = simulate(&egg, &plan.motion.sample(5.0)?, &options)?.log;
/// let found = Reconstructor::new()
///     .harmonics(8)
///     .sensor_sd_m(1e-4)
///     .progress(&|progress| eprintln!("{} {:.0} %", progress.stage, 100.0 * progress.fraction))
///     .run(&log)?;
/// assert_eq!(found.shape.harmonics_m().len(), 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
#[must_use = "nothing is reconstructed before `run`"]
pub struct Reconstructor<'a> {
    options: ReconstructOptions,
    start: Start,
    most_work: Option<u64>,
    progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl<'a> Reconstructor<'a> {
    /// With everything left to the log.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of harmonics K of the support function, 2 to [`MOST_HARMONICS`](super::MOST_HARMONICS); `None` = chosen by the evidence,
    /// or 12 by the methods that integrate.
    pub fn harmonics(mut self, harmonics: impl Into<Option<usize>>) -> Self {
        self.options.harmonics = harmonics.into();
        self
    }

    /// Standard deviation of the contact positions, metres, positive; `None` = stated by the log, or estimated from it.
    pub fn sensor_sd_m(mut self, sensor_sd_m: impl Into<Option<f64>>) -> Self {
        self.options.sensor_sd_m = sensor_sd_m.into();
        self
    }

    /// How to reconstruct; [`Method::Likelihood`] if not chosen.
    pub fn method(mut self, method: Method) -> Self {
        self.options.method = method;
        self
    }

    /// What the certificate asks.
    pub fn limits(mut self, limits: CertificateLimits) -> Self {
        self.options.limits = limits;
        self
    }

    /// What is known of the rig; readings are taken as they are if not said. Whatever the log tells of the constants that are open is
    /// estimated with the shape, and error bars contain the rest.
    ///
    /// ```
    /// use palpate::{reconstruct::Reconstructor, sensor::{Calibration, Rig, Tolerances}};
    /// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
    /// # let egg = NamedShape::Egg.shape(0.03)?;
    /// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
    /// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    /// # let felt = simulate(&egg, &plan.motion.sample(5.0)?, &options)?;
    /// // A pad whose zero is 0.3 mm off, which nobody knows.
    /// let mut truth = Calibration::default();
    /// truth.zero_m = [3e-4, 0.0];
    /// let log = truth.distorted(&felt.log);
    /// let found = Reconstructor::new().rig(Rig::uncalibrated()).run(&log)?;
    /// let of_rig = found.calibration.as_ref().expect("constants were open");
    /// let zero = &of_rig.constants[0];
    /// assert_eq!(zero.name, "s1_zero_m");
    /// assert!((zero.value - 3e-4).abs() < 5.0 * zero.sd && zero.sd < 0.1 * zero.prior_sd);
    /// // The size is as certain as the common scale of the pads, whatever the log.
    /// assert!(of_rig.size_sd > 0.005);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rig(mut self, rig: Rig) -> Self {
        self.options.rig = rig;
        self
    }

    /// What is known of shape and motion beforehand; [`Start::Nothing`] if not said.
    pub fn start(mut self, start: Start) -> Self {
        self.start = start;
        self
    }

    /// Is told now and then, from any thread, how far the work has come.
    pub fn progress(mut self, progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.progress = Some(progress);
        self
    }

    /// Reconstructs shape, motion and centre of mass of the object behind a log. May be called for any number of logs.
    ///
    /// # Errors
    /// When the log cannot be solved at all, an option is out of its range, or the start does not go with the log (see
    /// [`ReconstructError`]). A doubtful answer is not an error: it comes back as a [`Reconstruction`] that is not certified.
    pub fn run(&self, log: &Log) -> Result<Reconstruction, ReconstructError> {
        let ordinary = OnceCell::new();
        let ordinary = || ordinary.get_or_init(|| self.explained_by_ordinary_rig(log)).clone();
        self.run_while(log, &ordinary, &|_, _| true)
    }

    /// The same; where a stage of the search leads nowhere, `goes_on` is told which and whether the log is explained, and asked whether others are
    /// worth trying.
    pub(super) fn run_while(
        &self,
        log: &Log,
        ordinary: &OrdinaryRig,
        goes_on: &dyn Fn(Stage, bool) -> bool,
    ) -> Result<Reconstruction, ReconstructError> {
        check_log(log, &self.options)?;
        if look_exchanged(log) {
            // They are of no use, and the rest is what it is.
            let without = |sample: &Sample| Sample { force1_n: None, force2_n: None, ..*sample };
            return self.run_while(&Log { samples: log.samples.iter().map(without).collect() }, ordinary, goes_on);
        }
        if self.integrates() && self.options.rig != Rig::default() {
            // The methods that integrate take the constants of the rig as stated.
            let exact = Self { options: self.options.clone().with_rig(Rig::default()), ..self.clone() };
            return exact.run(&self.options.rig.calibration.corrected(log));
        }
        match &self.start {
            Start::Nothing => self.search(log, Extent::While(ordinary, goes_on)),
            Start::Shape(shape) => {
                check_start(log, shape, None)?;
                self.place(&Job::new(log, &self.options), shape)
            }
            Start::Motion { shape, psi_rad } => {
                check_start(log, shape, Some(psi_rad))?;
                self.refine(&Job::new(log, &self.options), shape, psi_rad.clone())
            }
        }
    }

    /// Whether the method is one of those that integrate.
    pub(super) fn integrates(&self) -> bool {
        self.options.method != Method::Likelihood
    }

    /// Whether nothing is known beforehand.
    pub(super) fn starts_from_nothing(&self) -> bool {
        matches!(self.start, Start::Nothing)
    }

    /// What is known of the rig.
    pub(super) fn known_rig(&self) -> Rig {
        self.options.rig
    }

    /// The same from nothing, by the first way of the search alone: most logs of an object are explained by it, and of others it is soon done. Of its
    /// progress nothing is told: it is a step of something longer.
    pub(crate) fn run_briefly(&self, log: &Log) -> Result<Reconstruction, ReconstructError> {
        check_log(log, &self.options)?;
        Self { progress: None, ..self.clone() }.search(log, Extent::Brief)
    }

    /// The same from nothing, and no further explanation of the log is looked for after so much work.
    pub(crate) fn run_within(&self, log: &Log, most_work: u64) -> Result<Reconstruction, ReconstructError> {
        Self { most_work: Some(most_work), start: Start::Nothing, ..self.clone() }.run(log)
    }

    fn tell(&self, stage: &'static str, fraction: f64) {
        if let Some(progress) = self.progress {
            progress(Progress { stage, fraction });
        }
    }

    fn search(&self, log: &Log, extent: Extent) -> Result<Reconstruction, ReconstructError> {
        if self.integrates() {
            return integral::reconstruct(log, &self.options, &|share| self.tell("integrating", share));
        }
        let mut cleared = Cow::Borrowed(log);
        let mut left_out = 0;
        for clearing in 0..=MOST_CLEARINGS {
            match self.search_until_strays(&cleared, extent, clearing < MOST_CLEARINGS)? {
                Searched::Ended(found) => return Ok(with_left_out(*found, left_out, &self.options.limits)),
                Searched::Strays(without, strays) => {
                    cleared = Cow::Owned(without);
                    left_out += strays;
                }
            }
        }
        Err(ReconstructError::NotSolvable)
    }

    /// The same, or the log without the stray readings that an explanation shows as soon as one does.
    fn search_until_strays(&self, log: &Log, extent: Extent, clears: bool) -> Result<Searched, ReconstructError> {
        let mut job = Job::new(log, &self.options);
        if let Some(most) = self.most_work {
            job.measurements.work = job.measurements.work.at_most(most);
        }
        let brief = matches!(extent, Extent::Brief);
        if brief {
            job.measurements.work = job.measurements.work.at_most_share(BRIEFLY);
        }
        let mut best: Option<Candidate> = None;
        let mut explanations = 0;
        let mut explored = if brief { Explored::briefly() } else { Explored::default() };
        let mut failure = None;
        let mut strays = None;
        let mut judged = 0;
        let explained_one = Cell::new(false);
        // One that may be right is a result where nothing else explains the log.
        let by_forces: RefCell<Option<Candidate>> = RefCell::new(None);
        let is_explained_by_forces = || by_forces.borrow().as_ref().is_some_and(Candidate::explains_forces);
        let explain_by_forces = |explain: &dyn Fn() -> Option<Candidate>| {
            let is_enough = by_forces.borrow().as_ref().is_some_and(Candidate::is_certified_throughout);
            if !is_enough
                && let Some(found) = explain()
                && by_forces.borrow().as_ref().is_none_or(|best| found.explains_forces_better_than(best))
            {
                by_forces.replace(Some(found));
            }
        };
        let forces_asked = Cell::new(false);
        let explained_by_forces = || {
            if !explained_one.get() && !forces_asked.replace(true) {
                explain_by_forces(&|| job.explained_by_forces());
                explain_by_forces(&|| job.explained_by_rolling());
            }
            is_explained_by_forces()
        };
        let goes_on = |stage: Stage| match extent {
            Extent::Brief => false,
            Extent::While(_, goes_on) => {
                let goes_on = |stage: Stage| goes_on(stage, explained_one.get());
                let is_explained = goes_on(Stage::Forces) && explained_by_forces();
                !is_explained && !are_of_no_object(log) && goes_on(stage)
            }
        };
        let from_ordinary_rig = || match extent {
            Extent::While(ordinary, _) if !explained_one.get() && self.most_work.is_none() => {
                arranged(&job, &ordinary()?)
            }
            _ => None,
        };
        schedule::search(
            &Readings { brief, goes_on: &goes_on, from_elsewhere: &from_ordinary_rig, ..job.readings() },
            &|found, trust| job.corrected(found, LEFT[trust]),
            &|share| self.tell("searching for arrangements", 0.9 * share),
            &mut || by_forces.borrow().is_some(),
            &mut |found| {
                if explored.contains(&found, 0) {
                    return false;
                }
                judged += 1;
                match job.judge(&found, &mut explored) {
                    Ok(candidate) => {
                        let limits = &self.options.limits;
                        let Reconstruction { shape, motion, .. } = &candidate.result;
                        let is_doubted = clears && are_doubted(&candidate.result);
                        let cleared = || without_stray_readings(log, shape, motion, limits);
                        strays = is_doubted.then(cleared).flatten();
                        if strays.is_some() {
                            return true;
                        }
                        explanations += usize::from(candidate.result.verdict.is_explained());
                        if best.as_ref().is_none_or(|other| candidate.is_likelier_than(other)) {
                            best = Some(candidate);
                        }
                    }
                    Err(error) => failure = Some(error),
                }
                let explained = best.as_ref().is_some_and(|candidate| candidate.result.verdict.is_explained());
                explained_one.set(explained);
                let misses_readings = || best.as_ref().is_some_and(Candidate::misses_readings);
                let patience = if best.as_ref().is_some_and(Candidate::misses_few_readings) { PATIENCE } else { 1 };
                let is_wrong = judged >= patience && !explained && !brief && misses_readings();
                if is_wrong && !goes_on(Stage::FirstArrangement) {
                    return true;
                }
                (brief && judged >= JUDGED_BRIEFLY)
                    || explored.is_enough(job.trusts())
                    || best.as_ref().is_some_and(|candidate| candidate.is_enough(explanations))
            },
        );
        if let Some((without, strays)) = strays {
            return Ok(Searched::Strays(without, strays));
        }
        // Where balance explains the log but does not tell it, inertia may.
        if !brief && !best.as_ref().is_some_and(|best| best.result.is_certified()) && !forces_asked.replace(true) {
            explain_by_forces(&|| job.explained_in_motion());
        }
        self.tell("done", 1.0);
        let explained = best.as_ref().is_some_and(|candidate| candidate.result.verdict.is_explained());
        if let Some(candidate) = by_forces.into_inner().filter(|by_forces| !explained || by_forces.explains_forces()) {
            // What explains the forces stands against none that does not.
            return Ok(Searched::Ended(Box::new(candidate.result)));
        }
        let answered = |candidate| with_center_by_friction(log, explored.against_others(candidate));
        best.map(|candidate| Searched::Ended(Box::new(answered(candidate)))).ok_or_else(|| {
            failure.unwrap_or_else(|| ReconstructError::NoStart {
                advice: "check the units and signs of the palm angles and contact positions".to_owned(),
            })
        })
    }

    /// From a known shape: in the size given, and where that contradicts the log, in others near it.
    fn place(&self, job: &Job, shape: &SupportFunction) -> Result<Reconstruction, ReconstructError> {
        if self.integrates() {
            return self.refine(job, shape, way_of(shape, job));
        }
        let mut best: Option<Candidate> = None;
        let mut failure = ReconstructError::NotSolvable;
        for size in SIZES {
            let known = shape.scaled(size);
            match Self::refined(job, &known, way_of(&known, job)) {
                Ok(candidate) if best.as_ref().is_none_or(|other| candidate.is_likelier_than(other)) => {
                    best = Some(candidate);
                }
                Ok(_) => {}
                Err(error) => failure = error,
            }
            if best.as_ref().is_some_and(|candidate| candidate.result.verdict.is_explained()) {
                break;
            }
        }
        self.tell("done", 1.0);
        best.map(|candidate| candidate.result).ok_or(failure)
    }

    fn refine(&self, job: &Job, shape: &SupportFunction, psi: Vec<f64>) -> Result<Reconstruction, ReconstructError> {
        if self.integrates() {
            return integral::reconstruct_from(&job.log, shape, &psi, &self.options);
        }
        let candidate = Self::refined(job, shape, psi)?;
        self.tell("done", 1.0);
        Ok(candidate.result)
    }

    /// The optimum next to a shape and a motion.
    fn refined(job: &Job, shape: &SupportFunction, psi: Vec<f64>) -> Result<Candidate, ReconstructError> {
        let found = arrangement_of(job, job.measurements.clone(), shape, psi);
        let solved = job.solve(&found, 0, &Explored::default())?.ok_or(ReconstructError::NotSolvable)?;
        job.assemble(solved)
    }
}

/// Where only the balance is missed, and friction explains that, the centre of mass that goes with it.
fn with_center_by_friction(log: &Log, found: Reconstruction) -> Reconstruction {
    if !found.is_certified() || found.is_com_certified() {
        return found;
    }
    match friction(log, &found).filter(FrictionEstimate::explains) {
        Some(friction) => found.with_friction(friction),
        None => found,
    }
}

impl From<ReconstructOptions> for Reconstructor<'_> {
    /// For options that are held as data: a command line's, a sweep's, Python's.
    fn from(options: ReconstructOptions) -> Self {
        Self { options, ..Self::default() }
    }
}

impl std::fmt::Debug for Reconstructor<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { options, start, most_work: _, progress } = self;
        let told = progress.is_some();
        formatter
            .debug_struct("Reconstructor")
            .field("options", options)
            .field("start", start)
            .field("progress", &told)
            .finish()
    }
}
