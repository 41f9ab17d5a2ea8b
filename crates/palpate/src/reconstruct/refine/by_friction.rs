//! Refinement with friction (`docs/theory.md`, friction): form, motion, friction and centre of mass together, from contacts, rolling and forces.
//!
//! From what the contacts alone leave follow rough contact modes, friction and centre of mass. Then the optimum with these modes, and the modes
//! that mechanics finds with that object, follow each other to a fixed point.

mod confined;
mod continuation;
mod growth;
mod nearly_symmetric;
mod profile;
mod rotations;
mod stretch;

use self::growth::Grown;
use super::calibrated::trusts;
use super::job::{Job, Refined};
use crate::estimate::association::shared_boundary::alone;
use crate::estimate::coverage::{ENOUGH_PASSED_BEFORE, passed_before};
use crate::estimate::friction::falls::falls;
use crate::estimate::friction::modes::{Decoded, Object, Sds, decode};
use crate::estimate::friction::normal_forces::weight_without_friction_n;
use crate::estimate::friction::problem::{BESIDES_SHAPE, Corrected, Problem, Unknowns, of_sample};
use crate::estimate::friction::regimes::{Place, Regime, regimes};
use crate::estimate::friction::smoother::{Bounds, FrictionNoise, Optimum};
use crate::estimate::friction::strips::{center_and_friction, runs};
use crate::estimate::jumps::{DetectedJump, detect_jumps};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::{contacts, psi_sd_by_contacts};
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::{ELSEWHERE, SHORT_SEGMENT, short_segments};
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::log::Log;
use crate::mechanics::ContactMode;
use crate::reconstruct::result::friction::{FrictionEstimate, is_hinged};
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::reconstruct::verdict::assemble::{Candidate, assemble};
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::reconstruct::verdict::joint_error_bars::JointErrorBars;
use crate::reconstruct::verdict::uncertainty::{FoundRig, PoseErrorBars, Uncertainty};
use crate::shape::{SupportFunction, Symmetry};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Standard deviations that the first fit begins with: of the slip over a step that rolls, and of the forces, as shares of the mean radius.
const FIRST_SLIP: f64 = 1e-3;
const FIRST_FORCES: f64 = 3e-3;

/// Standard deviation of a measured force that the first fit begins with, and least that is believed, as shares of the weight.
const FIRST_PADS: f64 = 0.1;
const PADS_FLOOR: f64 = 1e-4;

/// Least of the slip, of the forces and of the error of a contact position (3 µm) that are believed, as shares of the mean radius: what is exact to less
/// has errors of other kinds, pads that yield and creep, and modes would alternate to explain these.
const SLIP_FLOOR: f64 = 1e-5;
const FORCES_FLOOR: f64 = 2e-4;
pub(super) const SENSOR_FLOOR: f64 = 1e-4;

/// Standard deviation of the centre of mass from the middle of the form, as a share of the mean radius: it lies within the object, however little
/// the forces tell.
const CENTER_SD: f64 = 0.3;

/// Friction explains the log where the slip over a step that rolls, and what the forces of all samples miss, come down to this share of the mean radius:
/// right arrangements leave half of it at most, wrong ones half as much again of either or of both.
const EXPLAINED: f64 = 5e-4;

/// Up to these shares of slip and of what the forces of a sample miss that misses any it may: a result then, but no certificate.
const PLAUSIBLE: [f64; 2] = [2e-3, 3e-3];

const FAR_BELOW: f64 = 0.2;

/// The contacts may be missed by so many times what contact alone leaves.
const CONTACTS_ALLOWANCE: f64 = 1.3;

/// Slip that is allowed to a contact that sticks when modes are told apart, as a share of the mean radius: while the fit is rough, that of
/// its steps says little.
const DECODED_SLIP: f64 = 1e-4;

/// Pieces of fewer samples that share boundary with no other may be at another pose: there they also move otherwise, so that rotations of what was found
/// do not tell.
const SHORT_AND_ALONE: usize = 30;

/// Times that the contact modes are found anew.
const ROUNDS: usize = 8;

/// Share of what the round before left, above which one that is far from plausible is the last, and rounds that it takes at least: growth of a stretch has
/// no more.
const HOPELESS: f64 = 0.9;
const FEWEST_ROUNDS: usize = 3;

/// Updates of the standard deviations in each of them.
const UPDATES: usize = 12;

/// Contact modes that were found with wrong coefficients of friction hold these where they are: so fit and modes begin anew with others, which are
/// held for some rounds, while slip or forces are missed by more than so many times what palms are exact to.
const OTHER_FRICTION: [[f64; 2]; 5] = [[1.25, 1.25], [0.8, 0.8], [1.6, 1.6], [1.5, 1.0], [1.0, 1.5]];
const OTHER_FRICTION_ROUNDS: usize = 3;

/// They are tried where slip and forces already come within so many times what is plausible: of logs with friction those that need it miss the
/// forces by a third of that, and objects without friction, which some coefficient or other would bend to a fit, by five times as much.
const NEARLY_PLAUSIBLE: f64 = 3.0;
const HELD_ROUNDS: usize = 3;
const EXACT: f64 = 2.0;

/// Others take their place where they are likelier by so much for each sample (nats).
const LIKELIER: f64 = 0.01;

/// Harmonics of what was grown, in turn; more are kept where the contacts fall below this share of what they were.
const MORE_HARMONICS: [usize; 3] = [12, 18, 28];
const HARMONICS_GAIN: f64 = 0.98;

/// What growth and what follows it are worth, as a multiple of what a search is: logs that they explain take up to 2.5 times as much.
const WORTH: f64 = 2.7;

/// What other rotations are worth, as a multiple of what a search is: where friction acts, logs that it explains took up to 12 times as much, and where none
/// is told so far 0.24. What is worth no more is not explained: none of the others is excluded.
const ROTATIONS_WORTH: f64 = 16.0;
const ROTATIONS_WORTH_UNTOLD: f64 = 0.4;

/// Coefficient of friction below which dry surfaces do not come: where the log asks for less of it on both palms, it is hardly friction that it asks for.
const SLIPPERY: f64 = 0.01;

/// Friction acts where a coefficient of it is told, or where the object rolls for this share of the samples and never falls.
const MOSTLY_STICKS: f64 = 0.5;

/// What is to be explained.
#[derive(Clone, Copy)]
struct Setting<'a> {
    log: &'a Log,
    job: &'a Job<'a>,
    /// The readings with their weights.
    weighted: &'a Measurements,
    order: usize,
    prior: Prior,
    bounds: Bounds,
    /// Samples at which a jump has just ended.
    starts: &'a [usize],
    /// Whether intervals beside changes of the contact modes are left out.
    steady_only: bool,
}

/// Where fit and contact modes come to.
struct Settled {
    optimum: Optimum,
    regimes: Vec<Regime>,
    /// Samples at which a jump has just ended.
    starts: Vec<usize>,
}

impl Settled {
    /// Whether slip and forces are explained to what palms are exact to.
    fn is_exact(&self, bounds: Bounds) -> bool {
        let FrictionNoise { slip_m, forces_m, .. } = self.optimum.noise;
        slip_m < EXACT * bounds.slip_m && forces_m < EXACT * bounds.forces_m
    }

    /// Slip or forces, whichever are missed by more, as a multiple of what is plausible.
    fn implausible(&self) -> f64 {
        let size_m = self.optimum.unknowns.coefficients[0];
        let FrictionNoise { slip_m, forces_m, .. } = self.optimum.noise;
        (slip_m / PLAUSIBLE[0]).max(forces_m / PLAUSIBLE[1]) / size_m
    }

    /// Whether they are beyond what other coefficients of friction may mend, and no better than the round before left them.
    fn is_hopeless_after(&self, before: &Self) -> bool {
        self.implausible() > NEARLY_PLAUSIBLE && self.implausible() > HOPELESS * before.implausible()
    }

    /// −ln of the likelihood, up to a constant of the log: slip is missed where it sticks and forces where it slides.
    fn missed(&self) -> f64 {
        self.optimum.cost + self.of_noise(self.optimum.noise)
    }

    /// What standard deviations add to it.
    fn of_noise(&self, FrictionNoise { sensor_m, slip_m, forces_m, pads_n }: FrictionNoise) -> f64 {
        let Optimum { corrected, measured, .. } = &self.optimum;
        let contacts = corrected.measurements.seen() as f64;
        let sticks = self.regimes.iter().filter(|regime| regime.sticks().is_some()).count() as f64;
        let slides = self.regimes.len() as f64 - sticks;
        let of_pads = *measured as f64 * pads_n.ln();
        contacts * sensor_m.ln() + sticks * slip_m.ln() + slides * forces_m.ln() + of_pads
    }

    /// How far each sample may be elsewhere, radians: a few between two jumps, or before the first, bend the shape to any pose of theirs; some more do
    /// on boundary that no others felt.
    fn ambiguity_rad(&self) -> Vec<f64> {
        let Optimum { unknowns: Unknowns { psi, .. }, corrected, .. } = &self.optimum;
        let mut ambiguity_rad = vec![0.0; psi.len()];
        let alone = alone(&corrected.measurements, psi, &self.starts);
        let open = alone.into_iter().filter(|piece| piece.len() < SHORT_AND_ALONE && piece.len() < psi.len());
        open.chain(short_segments(&self.starts, psi.len())).for_each(|short| ambiguity_rad[short].fill(PI));
        ambiguity_rad
    }

    /// Whether some sample slides on both palms: where none does, the modes follow from the very friction that they should tell.
    fn slides_on_both(&self) -> bool {
        self.regimes.iter().any(|regime| regime.place == Place::Between)
    }

    /// Whether the contacts are explained.
    fn meets_contacts(&self, bounds: Bounds) -> bool {
        self.optimum.noise.sensor_m < bounds.sensor_m[1].max(FORCES_FLOOR * self.optimum.unknowns.coefficients[0])
    }

    /// Whether they are, and the standard deviations of slip and forces come down to these shares of the mean radius.
    fn leaves_at_most(&self, bounds: Bounds, [slip, forces]: [f64; 2]) -> bool {
        let size_m = self.optimum.unknowns.coefficients[0];
        let FrictionNoise { slip_m, forces_m, .. } = self.optimum.noise;
        self.meets_contacts(bounds) && slip_m < slip * size_m && forces_m < forces * size_m
    }

    /// Whether they are, and slip and what the forces of all samples miss come down to this share of the mean radius.
    fn misses_at_most(&self, bounds: Bounds, share: f64) -> bool {
        let most_m = share * self.optimum.unknowns.coefficients[0];
        self.meets_contacts(bounds) && self.optimum.noise.slip_m < most_m && self.optimum.forces_missed_m() < most_m
    }
}

impl<'a> Setting<'a> {
    fn new(job: &'a Job<'a>, log: &'a Log, weighted: &'a Measurements, fit: &Fit, starts: &'a [usize]) -> Self {
        let size_m = fit.estimate.coefficients[0];
        // Many harmonics explain away some of the noise of a short stretch.
        let noise_m = fit.noise.sensor_m.max(job.scatter_m);
        let most_m = (CONTACTS_ALLOWANCE * noise_m).max(FORCES_FLOOR * size_m);
        let bounds = Bounds {
            sensor_m: job.stated_m.map_or([SENSOR_FLOOR * size_m, most_m], |stated_m| [stated_m; 2]),
            slip_m: SLIP_FLOOR * size_m,
            forces_m: FORCES_FLOOR * size_m,
            pads: PADS_FLOOR,
        };
        // What of it looks symmetric may be so without friction alone.
        let prior = Prior { origin_sd_m: CENTER_SD * size_m, symmetry: Symmetry::NONE, ..fit.prior };
        Self { log, job, weighted, order: fit.order, prior, bounds, starts, steady_only: false }
    }

    /// Noise that the first fit begins with.
    fn first_noise(&self, fit: &Fit, weight_n: f64) -> FrictionNoise {
        let size_m = fit.estimate.coefficients[0];
        FrictionNoise {
            sensor_m: fit.noise.sensor_m,
            slip_m: FIRST_SLIP * size_m,
            forces_m: FIRST_FORCES * size_m,
            pads_n: FIRST_PADS * weight_n,
        }
    }

    /// Centre of mass, friction and contact modes that go with what contact alone leaves.
    fn contacts_suggest(&self, fit: &Fit) -> Option<(Unknowns, Vec<Regime>)> {
        let Estimate { coefficients, psi, .. } = &fit.estimate;
        let psi_sd = psi_sd_by_contacts(self.weighted, coefficients, psi, fit.noise.sensor_m);
        let regimes = regimes(self.weighted, psi, &psi_sd, self.starts);
        let found = center_and_friction(self.weighted, coefficients, psi, &psi_sd, &regimes, coefficients[0])?;
        let [x, y] = found.center_m;
        let about_center = SupportFunction::from_coefficients(coefficients).translated(-x, -y);
        let unknowns = Unknowns {
            coefficients: about_center.coefficients(),
            friction: found.coefficients,
            weight_n: weight_without_friction_n(self.log),
            calibration: self.job.calibration,
            psi: psi.clone(),
        };
        Some((unknowns, regimes))
    }

    /// Fits and contact modes in turn, at most so many times.
    fn settled(
        &self,
        start: (Unknowns, Vec<Regime>),
        noise: FrictionNoise,
        (rounds, updates): (usize, usize),
    ) -> Option<Settled> {
        self.settled_holding(None, start, noise, (rounds, updates))
    }

    /// The same, with coefficients of friction that are held.
    fn settled_holding(
        &self,
        held: Option<[f64; 2]>,
        (mut unknowns, mut regimes): (Unknowns, Vec<Regime>),
        mut noise: FrictionNoise,
        (rounds, updates): (usize, usize),
    ) -> Option<Settled> {
        let (mut last, mut starts): (Option<Settled>, _) = (None, self.starts.to_vec());
        for round in 1..=rounds {
            let problem = self.problem();
            let corrected = problem.corrected(&unknowns.calibration);
            let mut problem = problem.with_regimes(&regimes, &starts, &unknowns, &corrected).holding(held);
            let optimum = problem.optimum(unknowns, noise, self.bounds, (updates, STUDENT))?;
            (unknowns, noise) = (optimum.unknowns.clone(), optimum.noise);
            let corrected = &optimum.corrected;
            let mut found = self.decoded(corrected, &unknowns, None, noise, &starts);
            found.starts.append(&mut found.falls);
            found.starts.sort_unstable();
            let pairs = unknowns.psi.iter().zip(&found.psi);
            let elsewhere: Vec<usize> =
                pairs.enumerate().filter(|(_, (a, b))| (*a - *b).abs() > ELSEWHERE).map(|(index, _)| index).collect();
            let strayed = (1..SHORT_SEGMENT).contains(&elsewhere.len());
            let same = found.regimes == regimes && found.starts == starts && !strayed;
            if found.starts != starts {
                // What does not jump is where mechanics has it.
                unknowns.psi = found.psi;
            } else if strayed {
                // So are a few samples that a fit leaves on boundary that nothing else has felt.
                elsewhere.into_iter().for_each(|index| unknowns.psi[index] = found.psi[index]);
            }
            let before = std::mem::replace(&mut regimes, found.regimes);
            let starts_before = std::mem::replace(&mut starts, found.starts);
            let settled = Settled { optimum, regimes: before, starts: starts_before };
            let is_hopeless =
                round >= FEWEST_ROUNDS && last.as_ref().is_some_and(|last| settled.is_hopeless_after(last));
            last = Some(settled);
            if same || is_hopeless {
                break;
            }
        }
        last
    }

    /// The contact modes that mechanics finds.
    fn decoded(
        &self,
        corrected: &Corrected,
        at: &Unknowns,
        covariance: Option<&DMatrix<f64>>,
        noise: FrictionNoise,
        starts: &[usize],
    ) -> Decoded {
        let object = Object { coefficients: &at.coefficients, friction: at.friction, covariance };
        let slip_m = noise.slip_m.min(DECODED_SLIP * at.coefficients[0]);
        let sds = Sds { sensor_m: noise.sensor_m, slip_m, forces_m: noise.forces_m };
        decode(&corrected.measurements, &corrected.base_shifts_m, object, sds, &at.psi, starts)
    }
}

impl Job<'_> {
    /// What friction makes of an optimum by contact alone, where it may explain the forces.
    pub(super) fn explained_by_friction(&self, refined: &Refined) -> Option<Candidate> {
        let fit = &refined.fine;
        let shape = SupportFunction::from_coefficients(&fit.estimate.coefficients);
        let starts: Vec<usize> =
            detect_jumps(&shape, &self.log, &fit.estimate.psi).iter().map(|jump| jump.sample).collect();
        let setting = Setting::new(self, self.raw, &refined.measurements, fit, &starts);
        let start = setting.contacts_suggest(fit)?;
        let noise = setting.first_noise(fit, start.0.weight_n);
        let settled = setting.settled(start, noise, (ROUNDS, UPDATES))?;
        setting.candidate(setting.with_other_friction(settled))
    }

    /// The same of a motion that grows from where the object rolls.
    pub fn explained_by_rolling(&self) -> Option<Candidate> {
        if !is_hinged(self.raw) {
            return None;
        }
        let job = self.without_balance_worth(WORTH / trusts(self.options) as f64);
        let Grown { mut fit, mut unknowns, mut noise, starts } = growth::grown(&job)?;
        let mut best: Option<(Setting, Settled)> = None;
        for order in MORE_HARMONICS {
            fit.order = fit.order.max(order);
            let setting = Setting::new(&job, job.raw, &job.measurements, &fit, &starts);
            coefficients_to_order(&mut unknowns.coefficients, fit.order);
            let regimes = setting.modes_of(&unknowns, noise);
            let Some(settled) = setting.settled((unknowns.clone(), regimes), noise, (ROUNDS, UPDATES)) else { break };
            let settled = if best.is_none() { setting.with_other_friction(settled) } else { settled };
            let gains = best.is_none() || settled.optimum.noise.sensor_m < HARMONICS_GAIN * noise.sensor_m;
            (unknowns, noise) = (settled.optimum.unknowns.clone(), settled.optimum.noise);
            if !gains {
                break;
            }
            if best.is_none() || settled.leaves_at_most(setting.bounds, PLAUSIBLE) {
                best = Some((setting, settled));
            }
        }
        let (setting, settled) = best?;
        setting.candidate(settled)
    }
}

impl<'a> Setting<'a> {
    /// The best of what other coefficients of friction lead to.
    fn with_other_friction(&self, mut best: Settled) -> Settled {
        let near = PLAUSIBLE.map(|share| NEARLY_PLAUSIBLE * share);
        for _ in 0..OTHER_FRICTION_ROUNDS {
            if best.is_exact(self.bounds) || !best.leaves_at_most(self.bounds, near) || self.job.is_spent() {
                break;
            }
            let led = OTHER_FRICTION.into_par_iter().filter_map(|factors| self.beginning_with_friction(&best, factors));
            let likeliest = led.collect::<Vec<_>>().into_iter().min_by(|a, b| a.missed().total_cmp(&b.missed()));
            match likeliest.filter(|other| other.missed() < best.missed() - LIKELIER * self.log.samples.len() as f64) {
                Some(other) => best = other,
                None => break,
            }
        }
        best
    }

    /// Where fit and contact modes come to from coefficients of friction other by these factors, held at first.
    fn beginning_with_friction(&self, from: &Settled, factors: [f64; 2]) -> Option<Settled> {
        let Optimum { unknowns, noise, .. } = &from.optimum;
        let friction = [0, 1].map(|palm| factors[palm] * unknowns.friction[palm]);
        let start = Unknowns { friction, ..unknowns.clone() };
        let setting = Setting { starts: &from.starts, ..*self };
        let regimes = from.regimes.clone();
        let held = setting.settled_holding(Some(friction), (start, regimes), *noise, (HELD_ROUNDS, UPDATES))?;
        let setting = Setting { starts: &held.starts, ..*self };
        let Optimum { unknowns, noise, .. } = held.optimum;
        let regimes = setting.modes_of(&unknowns, noise);
        setting.settled((unknowns, regimes), noise, (ROUNDS, UPDATES))
    }

    /// The contact modes that mechanics finds with some object and motion.
    fn modes_of(&self, at: &Unknowns, noise: FrictionNoise) -> Vec<Regime> {
        let problem = self.problem();
        self.decoded(&problem.corrected(&at.calibration), at, None, noise, self.starts).regimes
    }

    /// What is done with it for such a share of what the log is worth.
    fn worth<T>(&self, share: f64, done: impl FnOnce(&Setting) -> T) -> T {
        let job = &self.job.worth(share);
        let weighted = &Measurements { work: job.measurements.work.clone(), ..self.weighted.clone() };
        done(&Setting { job, weighted, ..*self })
    }

    fn problem(&self) -> Problem<'a> {
        let problem = Problem::new(self.log, &self.job.options.rig, self.weighted, self.order, self.prior);
        problem.with_steady_intervals_only(self.steady_only)
    }

    /// The result, where friction explains the log.
    fn candidate(&self, settled: Settled) -> Option<Candidate> {
        if !settled.leaves_at_most(self.bounds, PLAUSIBLE) {
            return None;
        }
        let of = OfFriction { job: self.job, settled };
        let worth = of.rotations_worth();
        let (settled, others) = self.worth(worth, |setting| rotations::likeliest(setting, of.settled))?;
        let told = self.judged_by_steady_intervals(&settled).filter(Candidate::explains_forces);
        let mut candidate = match told {
            Some(candidate) => candidate,
            None => self.judged(self.profiled(settled)?)?,
        };
        let result = &mut candidate.result;
        result.others = others.into_iter().filter_map(|other| Some(self.judged(other)?.result)).collect();
        result.alternatives = 1 + result.others.len();
        if result.alternatives > 1 && result.is_certified() {
            result.verdict = Verdict::new(vec![Doubt::Alternatives { objects: result.alternatives }]);
        }
        Some(candidate)
    }

    /// An optimum as a result without intervals beside changes of the contact modes, where what slides on both palms tells friction. They help to find it, and
    /// noise that takes a contact about to slide beyond the edge of its cone pushes that edge out: coefficients were up to five standard deviations off.
    fn judged_by_steady_intervals(&self, settled: &Settled) -> Option<Candidate> {
        // What contradicts an arrangement does so near changes, too.
        if !settled.slides_on_both() || !self.is_explained_by(settled) {
            return None;
        }
        let setting = Setting { starts: &settled.starts, steady_only: true, ..*self };
        let Optimum { unknowns, noise, .. } = &settled.optimum;
        let steady = setting.settled((unknowns.clone(), settled.regimes.clone()), *noise, (ROUNDS, UPDATES))?;
        setting.judged(setting.profiled(steady)?)
    }

    /// An optimum with the information on friction that its profile leaves, where friction acts at all.
    fn profiled(&self, settled: Settled) -> Option<Settled> {
        // A profile widens what the intervals confine, unless it meets a likelier optimum: where friction does not act none was that acts (40 logs).
        let mut of = OfFriction { job: self.job, settled };
        let of_equations = of.settled.optimum.eliminated.clone();
        of.settled.confine();
        let acts = of.acts(&of.estimate());
        of.settled.optimum.eliminated = of_equations;
        acts.then(|| profile::profiled(self, of.settled))
    }

    /// Whether it explains contacts, slip and forces.
    fn is_explained_by(&self, settled: &Settled) -> bool {
        // Standard deviations far below what is asked need not have settled.
        let share = if settled.optimum.settled { EXPLAINED } else { FAR_BELOW * EXPLAINED };
        settled.misses_at_most(self.bounds, share)
    }

    /// An optimum as a result, with its doubts, where friction explains the log.
    fn judged(&self, settled: Settled) -> Option<Candidate> {
        if !settled.leaves_at_most(self.bounds, PLAUSIBLE) {
            return None;
        }
        let explains = self.is_explained_by(&settled);
        let mut candidate = OfFriction { job: self.job, settled }.candidate(self.order, self.prior)?;
        let passes = candidate.result.outline.iter().map(|point| point.touches);
        let is_told = passed_before(passes) >= ENOUGH_PASSED_BEFORE;
        if !explains || !is_told {
            let friction = candidate.result.friction?;
            let doubt = Doubt::Friction { coefficients: friction.coefficients, sds: friction.coefficient_sds };
            // Those of the centre of mass alone say that all else is certified.
            let others = candidate.result.verdict.doubts.iter().filter(|other| !other.concerns_center_of_mass_only());
            candidate.result.verdict = Verdict::new(std::iter::once(doubt).chain(others.cloned()).collect());
        }
        Some(candidate)
    }
}

/// An optimum with friction.
struct OfFriction<'a> {
    job: &'a Job<'a>,
    settled: Settled,
}

impl OfFriction<'_> {
    fn candidate(&self, order: usize, prior: Prior) -> Option<Candidate> {
        let Self { job, settled: Settled { optimum, .. } } = self;
        let Optimum { unknowns, noise, corrected, .. } = optimum;
        let estimate = self.estimate();
        if !self.acts(&estimate) {
            return None;
        }
        let fit = Fit {
            estimate: Estimate { coefficients: unknowns.coefficients.clone(), psi: unknowns.psi.clone(), cost: 0.0 },
            order,
            noise: Noise { sensor_m: noise.sensor_m, balance_m: noise.forces_m },
            prior,
            evidence: Evidence::of_samples(-self.settled.missed()),
        };
        let ambiguity_rad = self.settled.ambiguity_rad();
        let expected = job.expected();
        let log = unknowns.calibration.corrected(job.raw);
        assemble(
            &log,
            &corrected.measurements,
            fit,
            (&ambiguity_rad, FoundSymmetry::default()),
            expected,
            self,
            &job.options.limits,
        )
    }

    /// What other rotations are worth, as a multiple of what a search is.
    fn rotations_worth(&self) -> f64 {
        let estimate = self.estimate();
        let is_slippery = estimate.coefficients.iter().all(|coefficient| *coefficient < SLIPPERY);
        if !is_slippery && self.acts(&estimate) { ROTATIONS_WORTH } else { ROTATIONS_WORTH_UNTOLD }
    }

    /// Whether friction is told, or holds the object.
    fn acts(&self, estimate: &FrictionEstimate) -> bool {
        let Unknowns { coefficients: of_shape, psi, .. } = &self.settled.optimum.unknowns;
        let sticks = self.settled.regimes.iter().filter(|regime| regime.sticks().is_some()).count();
        // What falls slides before it falls: friction that holds it elsewhere without being told is none.
        let shape = SupportFunction::from_coefficients(of_shape);
        let falls = || !self.jumps(&shape, &self.job.log, psi).is_empty();
        estimate.is_told() || (sticks as f64 >= MOSTLY_STICKS * psi.len() as f64 && !falls())
    }

    fn estimate(&self) -> FrictionEstimate {
        let Settled { optimum, regimes, .. } = &self.settled;
        let covariance = optimum.eliminated.covariance();
        let friction = optimum.unknowns.coefficients.len();
        let sd = |unknown: usize| optimum.sd(&covariance, unknown);
        // The first harmonic of a shape that was felt in part is not where its centre of mass is.
        let of_center = optimum.center_and_friction();
        let of_center = of_center.map(|[x, y, ..]| [x, y].map(|row| optimum.sd_along(&covariance, &row)));
        FrictionEstimate {
            coefficients: optimum.unknowns.friction,
            coefficient_sds: [sd(friction), sd(friction + 1)],
            center_m: [0.0; 2],
            center_sd_m: of_center.unwrap_or([CENTER_SD * optimum.unknowns.coefficients[0]; 2]),
            misfit: optimum.misfit,
            slides: regimes.iter().filter(|regime| regime.place == Place::Between).count(),
            rolls: runs(regimes),
        }
    }
}

impl Uncertainty for OfFriction<'_> {
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
        let inflation = inflation.max(self.settled.optimum.inflation);
        let Unknowns { coefficients, psi, .. } = &self.settled.optimum.unknowns;
        let samples = psi.iter().enumerate().map(|(index, at)| (of_sample(psi.len(), index), *at)).collect();
        let eliminated = &self.settled.optimum.eliminated;
        let bars = JointErrorBars::new(eliminated, (coefficients, BESIDES_SHAPE), samples, felt, inflation);
        Some(Box::new(bars?))
    }

    fn of_rig(&self, inflation: f64) -> Option<FoundRig> {
        let Optimum { unknowns, eliminated, .. } = &self.settled.optimum;
        let inflation = inflation.max(self.settled.optimum.inflation);
        FoundRig::jointly(unknowns.calibration, &self.job.options.rig, &eliminated.covariance(), inflation)
    }

    fn inertia(&self, _: f64) -> Option<InertiaEstimate> {
        None
    }

    fn friction(&self) -> Option<FrictionEstimate> {
        Some(self.estimate())
    }

    fn modes(&self, index: usize) -> Option<[ContactMode; 2]> {
        let Optimum { unknowns, corrected, .. } = &self.settled.optimum;
        let (instant, regime) = (&corrected.measurements.instants[index], &self.settled.regimes[index]);
        regime.modes(instant, &contacts(instant, &unknowns.coefficients, unknowns.psi[index]))
    }

    fn jumps(&self, shape: &SupportFunction, log: &Log, psi: &[f64]) -> Vec<DetectedJump> {
        falls(shape, &log.palms(), psi, &self.settled.starts)
    }
}

#[cfg(test)]
mod tests;
