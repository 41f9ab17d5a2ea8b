//! From a log of strokes to shape and motion: segments, closed form, search, maximum likelihood, rivals, verdict.

mod assemble;
mod placed_anew;

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use rayon::prelude::*;

use self::placed_anew::laid_on;
use crate::math::statistics::{median, typical_sd};
use crate::pivot::calibration::Reading;
use crate::pivot::closed_form::Stretch;
use crate::pivot::error::PivotReconstructError;
use crate::pivot::evidence::{
    self, Fit, MOST_HARMONICS, ROUGHLY_SETTLED, Stated, choose_order, squares_and_redundancies,
};
use crate::pivot::harmonic_prior::HarmonicPrior;
use crate::pivot::log::{PivotLog, PivotSample};
use crate::pivot::motion_between::{FIRST_SD_RAD, MotionBetween};
use crate::pivot::motion_prior::{MotionPrior, lifted, tips_over};
use crate::pivot::posterior::PivotPosterior;
use crate::pivot::result::PivotReconstruction;
use crate::pivot::rig::PivotRig;
use crate::pivot::rivals::{Rivals, Whole};
use crate::pivot::search::{
    Arrangement, SEARCH_ORDER, Segments, TRUSTED_ORDER, same, same_but_for, search_noise, shape_given_angles,
};
use crate::pivot::segments::{Cuts, LIFTED_SAMPLES, segments};
use crate::pivot::smoother::{Noise, Optimum, Problem, State};
use crate::pivot::thinning::Thinning;
use crate::pivot::verdict::{MODEL_ALLOWANCE, PivotDoubt, RIVAL_NATS};

/// Fewest samples with a contact that can be solved.
const FEWEST_SAMPLES: usize = 30;

/// The crossings of d = 0 are taken so many times as wide, and rolled through or not, in turn.
const CROSSINGS: [(f64, bool); 4] = [(1.0, true), (1.0, false), (2.0, true), (0.5, false)];

/// Contact angles are decoded anew at most so many times.
const MOST_DECODINGS: usize = 8;

/// Of the starts of a decoding so many are fitted: those are far apart, and the likeliest was the first or the second of up to six in each of 28 decodings.
const MOST_TRIED: usize = 2;

/// A fit that leaves more than this, χ² per degree of freedom, is not certified: its rivals are not looked for.
const EXPLAINED_CHI2: f64 = 1.6;

/// Second differences of the contact angle that a result believes in, standard deviation in radians at least. A belief of a given scale asks for less motion:
/// all angles a little closer together and the object a little smaller, which readings tell worst of all. At 0.05 rad an object that bounces, sampled at 27 Hz,
/// came out smaller by five of its error bars; angles around d = 0 that readings hardly tell are still held.
const LOOSE_SD_RAD: f64 = 0.2;

/// Rivals that turn out better are examined in their turn, so many times.
const MOST_BETTER_RIVALS: usize = 3;

/// Smallest change of height or offset over all samples that is a motion, as a share of the size.
const LEAST_MOTION: f64 = 1e-3;

/// Largest time or length of a log, seconds or metres: beyond it sums lose their digits.
const LARGEST_VALUE: f64 = 1e9;

/// How to reconstruct.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PivotOptions {
    /// What is known of the rig.
    pub rig: PivotRig,
    /// Number of harmonics, 2 to 48; `None` = by the evidence.
    pub harmonics: Option<usize>,
}

impl PivotOptions {
    /// A rig, and the number of harmonics by the evidence.
    pub fn new(rig: PivotRig) -> Self {
        Self { rig, harmonics: None }
    }

    /// With a fixed number of harmonics.
    pub fn harmonics(self, harmonics: Option<usize>) -> Self {
        Self { harmonics, ..self }
    }
}

/// Shape about the pivot and motion from a log of strokes alone.
///
/// # Errors
/// When the log has too few contacts, impossible values, or tells nothing; or an option is out of range.
pub fn reconstruct_strokes(
    log: &PivotLog,
    options: &PivotOptions,
) -> Result<PivotReconstruction, PivotReconstructError> {
    reconstruct_with_posterior(log, options).map(|(reconstruction, _)| reconstruction)
}

/// The same with the posterior of the shape, to plan the next strokes by.
///
/// # Errors
/// As [`reconstruct_strokes`].
pub fn reconstruct_with_posterior(
    log: &PivotLog,
    options: &PivotOptions,
) -> Result<(PivotReconstruction, PivotPosterior), PivotReconstructError> {
    check(log, options)?;
    let prepared = Prepared::new(log, options, Cuts::AtLeaps)?;
    // An object may tip over unseen where it turns fast: what the rest tells is tried first, with few harmonics, which do not follow what is wrong.
    let cautious = Prepared::new(log, options, Cuts::AtLongSteps).ok();
    let starts = cautious.map_or_else(Vec::new, |cautious| {
        let rest = likeliest_first(cautious.search(Vec::new()));
        let completed = |rest: Found| {
            let state = prepared.completed(&cautious, &rest.led_to)?;
            Some(Start { state, explains_rest: rest.is_explained(), like: rest.led_to })
        };
        rest.into_iter().filter_map(completed).collect()
    });
    let mut found = likeliest_first(prepared.search(starts)).into_iter();
    let Found { mut reconstruction, posterior, log_evidence, .. } =
        found.next().ok_or(PivotReconstructError::NotSolvable)?;
    // One that explains the log less well is a rival where it is likelier all the same.
    let is_rival = |rival: &Found| {
        let least = if rival.is_explained() { log_evidence - RIVAL_NATS } else { log_evidence };
        rival.log_evidence > least && reconstruction.turns_otherwise(&rival.reconstruction)
    };
    let rivals = found.filter(is_rival);
    let rivals: Vec<PivotReconstruction> = rivals.map(|rival| rival.reconstruction).collect();
    if !rivals.is_empty() {
        reconstruction.alternatives += rivals.len();
        reconstruction.doubts.retain(|doubt| !matches!(doubt, PivotDoubt::Ambiguous { .. }));
        reconstruction.doubts.push(PivotDoubt::Ambiguous { alternatives: reconstruction.alternatives });
        reconstruction.others.extend(rivals);
    }
    Ok((reconstruction, posterior))
}

/// A result, and ln of its evidence.
struct Found {
    reconstruction: PivotReconstruction,
    posterior: PivotPosterior,
    log_evidence: f64,
    /// Noise, shape and contact angles of the readings that are used.
    fit: Fit,
    /// Where its start led, before rivals were looked for.
    led_to: Fit,
    /// Harmonics that the readings ask for.
    order: usize,
}

impl Found {
    /// Whether no other start could mend it.
    fn is_explained(&self) -> bool {
        !self.reconstruction.doubts.iter().any(|doubt| {
            matches!(
                doubt,
                PivotDoubt::Misfit { .. }
                    | PivotDoubt::NotSmooth { .. }
                    | PivotDoubt::NotConvex
                    | PivotDoubt::Leaps { .. }
                    | PivotDoubt::OtherStarts { .. }
                    | PivotDoubt::UncertainMotion { .. }
            )
        })
    }
}

/// A start for all readings, from a fit of some.
struct Start {
    state: State,
    like: Fit,
    /// Whether the fit explains those.
    explains_rest: bool,
}

/// The first that explains the log.
fn explained(found: &[Found]) -> Option<&Found> {
    found.iter().find(|found| found.is_explained())
}

/// Of those that explain the log the likeliest, or else of all.
fn likeliest_first(mut found: Vec<Found>) -> Vec<Found> {
    let rank = |found: &Found| (found.is_explained(), found.log_evidence);
    found.sort_by(|a, b| rank(b).partial_cmp(&rank(a)).unwrap_or(std::cmp::Ordering::Equal));
    found
}

/// A log made ready.
struct Prepared<'a> {
    log: &'a PivotLog,
    options: &'a PivotOptions,
    /// Numbers of the samples with a contact.
    samples: Vec<usize>,
    readings: Vec<Reading>,
    r_m: Vec<f64>,
    d_m: Vec<f64>,
    cuts: Cuts,
    ranges: Vec<Range<usize>>,
    size_m: f64,
    /// The largest height with a contact: higher, the object may turn as it likes.
    free_m: f64,
    /// Noise by the scatter of neighbouring samples.
    scatter: Noise,
}

impl<'a> Prepared<'a> {
    fn new(log: &'a PivotLog, options: &'a PivotOptions, cuts: Cuts) -> Result<Self, PivotReconstructError> {
        let rig = &options.rig;
        let (mut samples, mut readings) = (Vec::new(), Vec::new());
        for (index, sample) in log.samples.iter().enumerate() {
            if let Some(s_m) = sample.s_m {
                samples.push(index);
                readings.push(Reading::new(&rig.pad, sample.pivot_x_m, sample.pivot_y_m, s_m));
            }
        }
        if samples.len() < FEWEST_SAMPLES {
            return Err(PivotReconstructError::TooFewSamples { seen: samples.len(), needed: FEWEST_SAMPLES });
        }
        let measured = readings.iter().map(|reading| reading.measured(&rig.calibration));
        let (r_m, d_m): (Vec<f64>, Vec<f64>) = measured.map(|measured| (measured.r_m, measured.d_m)).unzip();
        let size_m = median(&mut r_m.iter().map(|r| r.abs()).collect::<Vec<f64>>());
        let spread = |values: &[f64]| {
            let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
            high - low
        };
        if !(size_m > 0.0 && size_m.is_finite() && spread(&r_m).max(spread(&d_m)) > LEAST_MOTION * size_m) {
            return Err(PivotReconstructError::NotSolvable);
        }
        let ranges = segments(&samples, [&r_m, &d_m], size_m, cuts);
        if ranges.iter().map(ExactSizeIterator::len).sum::<usize>() < FEWEST_SAMPLES {
            return Err(PivotReconstructError::NotSolvable);
        }
        let scatter = Noise { r_m: scatter(&r_m, &ranges), d_m: scatter(&d_m, &ranges) };
        let free_m = r_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Ok(Self { log, options, samples, readings, r_m, d_m, cuts, ranges, size_m, free_m, scatter })
    }

    /// Noise that is stated; that of an offset is of pad and arm together.
    fn stated(&self) -> Stated {
        let (pad, arm) = (self.options.rig.reading_sd_m, self.options.rig.arm_sd_m);
        Stated { r_m: arm, d_m: pad.map(|pad| pad.hypot(arm.unwrap_or(0.0))) }
    }

    /// The noise that the readings are held against.
    fn reference(&self) -> Noise {
        let stated = self.stated();
        let least_m = MODEL_ALLOWANCE * self.size_m;
        Noise {
            r_m: stated.r_m.unwrap_or(self.scatter.r_m).max(least_m),
            d_m: stated.d_m.unwrap_or(self.scatter.d_m).max(least_m),
        }
    }

    /// The readings that are used, segment by segment.
    fn used(&self) -> Vec<usize> {
        self.ranges.iter().flat_map(Clone::clone).collect()
    }

    /// The problem of some readings, with few harmonics and the noise that they are held against.
    fn problem<'b>(&self, readings: &'b [Reading]) -> Problem<'b> {
        let told = self.options.rig.tolerances.told();
        Problem {
            readings,
            noise: self.reference(),
            order: SEARCH_ORDER,
            size_m: self.size_m,
            harmonics: HarmonicPrior::of_scale(0.5 * self.size_m),
            stated: self.options.rig.calibration,
            open: told.into_iter().enumerate().filter(|(_, sd)| *sd > 0.0).collect(),
            between: None,
        }
    }

    /// Results from these starts, and from the closed forms where they do not explain the log, or do with many harmonics, or the fits that they come from did
    /// not explain theirs: what explains the log then may not be the likeliest.
    fn search(&self, starts: Vec<Start>) -> Vec<Found> {
        let pair = |width: f64, may_roll: bool| [may_roll, !may_roll].map(|may_roll| self.relative(width, may_roll));
        let mut found: Vec<Found> = Vec::new();
        let mut is_trusted = starts.is_empty() || starts.iter().any(|start| start.explains_rest);
        if !starts.is_empty() {
            let [(width, may_roll), ..] = CROSSINGS;
            let first = pair(width, may_roll);
            for start in starts {
                let other = self.solved(&first, Some(start), (&found, explained(&found)));
                found.extend(other);
            }
            is_trusted &= explained(&found).is_none_or(|found| found.order <= TRUSTED_ORDER);
        }
        if is_trusted && explained(&found).is_some() {
            return found;
        }
        let mut tried: Vec<Vec<f64>> = Vec::new();
        for (width, may_roll) in CROSSINGS {
            // Without a crossing all closed forms are one.
            let pair = pair(width, may_roll);
            if !tried.contains(&pair[0]) {
                let other = self.solved(&pair, None, (&found, explained(&found).filter(|_| is_trusted)));
                found.extend(other);
                let [relative_rad, _] = pair;
                tried.push(relative_rad);
            }
        }
        found
    }

    /// The best result from one closed form, the other of the same crossings beside it. It is left where it leads to the same as an earlier start; and
    /// where one of these is said to explain the log, if its segments, laid on that, lead back to it, or if what they are arranged to leads there, or
    /// explains the log with as many harmonics so little that no decoding makes a rival of it.
    fn solved(
        &self,
        [relative_rad, other_rad]: &[Vec<f64>; 2],
        start: Option<Start>,
        (earlier, explained): (&[Found], Option<&Found>),
    ) -> Option<Found> {
        let noise = self.reference();
        let search = Problem { noise: search_noise(noise, self.size_m), ..self.problem(&[]) };
        let used = self.used();
        let readings: Vec<Reading> = used.iter().map(|&index| self.readings[index]).collect();
        let thinning = Thinning::new(&self.ranges_of_used());
        let few_readings = thinning.of(&readings);
        let few = |state: &State| State { theta_rad: thinning.of(&state.theta_rad), ..state.clone() };
        let of_used = |all: &[bool]| used.iter().map(|&index| all[index]).collect();
        let prior = MotionPrior {
            ranges: self.ranges_of_used(),
            begins_at_rest: self.begins_at_rest(),
            relative_rad: [relative_rad.clone(), other_rad.clone()],
            tips_over: of_used(&tips_over(&self.r_m, &self.d_m, self.size_m)),
            lifted: of_used(&lifted(&self.readings, self.scatter.r_m)),
        };
        let may_leap: Vec<bool> =
            prior.tips_over.iter().zip(&prior.lifted).map(|(tips, lifted)| *tips || *lifted).collect();
        let numbers: Vec<usize> = used.iter().map(|&index| self.samples[index]).collect();
        let between = MotionBetween::new(&prior.ranges, &numbers, &may_leap);
        let believed = (!between.is_empty()).then_some((&between, FIRST_SD_RAD));
        let problem = Problem { readings: &readings, noise, between: believed, ..search.clone() };
        // What is believed of the motion decides on which side of d = 0 readings are, and which of several starts is likelier. Noise, spread and number of
        // harmonics are what the readings alone ask for: where an object slides or tips over, that belief is wrong and would pay for it with them.
        let choose = |start: State, like: Option<&Fit>| {
            let begun = like.map_or_else(|| problem.clone(), |fit| fit.like(problem.clone()));
            let order = self.options.harmonics.unwrap_or(SEARCH_ORDER);
            let decided = evidence::fit(Problem { order, ..begun }, start, self.stated())?;
            if self.cuts == Cuts::AtLongSteps {
                let log_evidence = decided.log_evidence - prior.cost(&decided.optimum.state.theta_rad);
                return Some(Fit { log_evidence, ..decided });
            }
            let alone = decided.like(Problem { between: None, ..problem.clone() });
            let state = decided.optimum.state.clone();
            let by_readings = match self.options.harmonics {
                Some(_) => evidence::fit(alone, state, self.stated()),
                None => choose_order(&alone, state, self.stated()),
            }?;
            let between = Fit { between_rad: decided.between_rad, ..by_readings };
            let fit = evidence::at_likeliest_scale(problem.clone(), between)?;
            Some(Fit { log_evidence: fit.log_evidence - prior.cost(&fit.optimum.state.theta_rad), ..fit })
        };
        let begin = |start: State| {
            let of_search = Problem { order: self.options.harmonics.unwrap_or(SEARCH_ORDER), ..problem.clone() };
            let optimum = of_search.solve_to(start, ROUGHLY_SETTLED)?;
            let log_evidence = evidence::log_evidence(&of_search, &optimum)? - prior.cost(&optimum.state.theta_rad);
            Some((log_evidence, optimum.state))
        };
        let whole = |fit: &Fit| fit.like(problem.clone());
        let of_few = |fit: &Fit| Problem { readings: &few_readings, between: None, ..whole(fit) };
        if let Some(Found { fit, .. }) = explained.filter(|_| start.is_none()) {
            let alike = of_few(fit);
            let laid = laid_on(&prior.ranges, relative_rad, &fit.optimum.state.theta_rad);
            let there = alike.solve_to(shape_given_angles(&alike, thinning.of(&laid))?, ROUGHLY_SETTLED)?;
            if same(&there.state, &few(&fit.optimum.state)) {
                return None;
            }
        }
        let segments = Segments {
            readings: &few_readings,
            ranges: &thinning.ranges,
            relative_rad: &thinning.of(relative_rad),
            begins_at_rest: &self.begins_at_rest(),
        };
        let arrangements = if start.is_some() { Vec::new() } else { segments.arrangements(&search) };
        let whole_state = |arrangement: &Arrangement| {
            let state = segments.in_order(arrangement)?;
            Some(State { theta_rad: thinning.spread(relative_rad, &state.theta_rad), ..state })
        };
        let (start, like) = match start {
            Some(Start { state, like, .. }) => (state, Some(like)),
            None => (whole_state(arrangements.first()?)?, None),
        };
        if let Some(Found { fit, .. }) = explained {
            // What a few readings contradict is not held against all of them.
            let there = of_few(fit).solve_to(few(&start), ROUGHLY_SETTLED)?;
            if self.chi2_per_dof(fit.noise, &there).0 > EXPLAINED_CHI2 {
                return None;
            }
            let there = whole(fit).solve(start.clone())?;
            if same(&there.state, &fit.optimum.state) || self.chi2_per_dof(fit.noise, &there).0 > EXPLAINED_CHI2 {
                return None;
            }
        }
        let mut fit = choose(start, like.as_ref())?;
        for _ in 0..MOST_DECODINGS {
            let state = &fit.optimum.state;
            let continuous = prior.without_leaps(&state.theta_rad);
            let continuous = continuous.map(|theta_rad| State { theta_rad, ..state.clone() });
            let own = Problem { noise: fit.noise, between: None, ..problem.clone() };
            let bridged = prior.bridged(&state.theta_rad, &|index, theta_rad| own.settled(state, index, theta_rad));
            let bridged = bridged.map(|theta_rad| State { theta_rad, ..state.clone() });
            let mended = self.mended(&readings, &prior, &fit);
            let by_others = self.placed_by_others(&readings, &prior, &fit);
            let mut starts: Vec<State> = [continuous, bridged, mended, by_others].into_iter().flatten().collect();
            if !starts.is_empty() {
                // What is wrong may have come with the fit: the closed forms, where it is, know nothing of it.
                let laid = prior.relative_rad.iter().map(|relative| laid_on(&prior.ranges, relative, &state.theta_rad));
                starts.extend(laid.filter_map(|theta_rad| shape_given_angles(&problem, theta_rad)));
            }
            // From few harmonics, which do not follow what is wrong. Where a start leads with the noise that is expected tells what it is worth.
            let mut begun: Vec<(f64, State)> = starts.into_par_iter().filter_map(begin).collect();
            begun.sort_by(|a, b| b.0.total_cmp(&a.0));
            begun.truncate(MOST_TRIED);
            let tried: Vec<Fit> = begun.into_par_iter().filter_map(|(_, start)| choose(start, None)).collect();
            let Some(next) = tried.into_iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence)) else { break };
            if next.log_evidence <= fit.log_evidence + 1.0 {
                break;
            }
            fit = next;
        }
        if earlier.iter().any(|found| same(&found.led_to.optimum.state, &fit.optimum.state)) {
            return None;
        }
        let led_to = fit.clone();
        let rivals = Rivals { search: &search, readings: &readings, thinning: &thinning, prior: &prior };
        // Rivals that turn out better take its place, and are examined in their turn.
        let mut alternatives = Vec::new();
        // What is not explained is not certified, whatever its rivals; nor is what others start from.
        let is_explained = self.chi2_per_dof(fit.noise, &fit.optimum).0 <= EXPLAINED_CHI2;
        let rounds = if is_explained && self.cuts == Cuts::AtLeaps { MOST_BETTER_RIVALS } else { 0 };
        for _ in 0..rounds {
            let beam = arrangements.iter().skip(1).filter_map(whole_state);
            let found = rivals.of(&Whole { problem: &whole(&fit), fit: &fit }, beam);
            let better = found.first().filter(|rival| rival.log_evidence > fit.log_evidence);
            let next = better.map(|better| choose(better.optimum.state.clone(), Some(better)));
            alternatives = found;
            let Some(next) = next else { break };
            let next = next?;
            if next.log_evidence <= fit.log_evidence {
                break;
            }
            // What it takes the place of is an alternative to it, until others are looked for.
            alternatives.push(std::mem::replace(&mut fit, next));
            alternatives.retain(|other| !same(&other.optimum.state, &fit.optimum.state));
        }
        // What has but a few samples elsewhere is no other arrangement: these are not told.
        let mut elsewhere = Vec::new();
        alternatives.retain(|other| {
            let few = same_but_for(&other.optimum.state, &fit.optimum.state);
            elsewhere.extend(few.iter().flatten());
            few.is_none()
        });
        let order = fit.order;
        let fit = match self.cuts {
            Cuts::AtLeaps => completed(&whole(&fit), fit, self.options.harmonics),
            Cuts::AtLongSteps => fit,
        };
        let (mut reconstruction, posterior) =
            self.assembled(&problem, &fit, &prior, &elsewhere, 1 + alternatives.len())?;
        let others = alternatives
            .iter()
            .take(4)
            .filter_map(|other| self.assembled(&problem, other, &prior, &elsewhere, 1 + alternatives.len()));
        reconstruction.others = others.map(|(other, _)| other).collect();
        Some(Found { reconstruction, posterior, log_evidence: fit.log_evidence, fit, led_to, order })
    }

    /// What a fit leaves over what the noise explains, per degree of freedom; and these.
    fn chi2_per_dof(&self, noise: Noise, optimum: &Optimum) -> (f64, f64) {
        let reference = self.reference();
        let Some([squares, redundancies]) = squares_and_redundancies(optimum) else { return (f64::NAN, 1.0) };
        let dof = redundancies.iter().sum::<f64>().max(1.0);
        let [r, d] = squares;
        let square = r * (noise.r_m / reference.r_m).powi(2) + d * (noise.d_m / reference.d_m).powi(2);
        (square / dof, dof)
    }

    /// Contact angles of the readings that are used by the closed form.
    fn relative(&self, width: f64, may_roll: bool) -> Vec<f64> {
        let along_m: Vec<f64> = self.readings.iter().map(|reading| reading.along_m).collect();
        let angles = |range: &Range<usize>| {
            let stretch = Stretch {
                r_m: &self.r_m[range.clone()],
                d_m: &self.d_m[range.clone()],
                along_m: &along_m[range.clone()],
                sd_m: [self.scatter.r_m, self.scatter.d_m],
                size_m: self.size_m,
            };
            stretch.angles(width, may_roll)
        };
        self.ranges.iter().flat_map(angles).collect()
    }

    /// Whether the object hung free before a sample: it was lifted from the pad, and so high that it could turn as it liked. One that tips over, or
    /// bounces, is off the pad for a while as well.
    fn hung_free_before(&self, sample: usize) -> bool {
        let is_off = |index: &usize| self.log.samples[*index].s_m.is_none();
        let off: Vec<f64> = (0..sample).rev().take_while(is_off).map(|index| self.height_m(index)).collect();
        off.len() >= LIFTED_SAMPLES && off.iter().any(|height_m| *height_m > self.free_m)
    }

    /// Height of the pivot over the pad at a sample of the log.
    fn height_m(&self, sample: usize) -> f64 {
        let sample = &self.log.samples[sample];
        self.options.rig.pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m)[1]
            - self.options.rig.calibration.height_m
    }

    /// Whether each segment begins after the object was lifted; the first one does.
    fn begins_at_rest(&self) -> Vec<bool> {
        let first = self.samples.first().copied();
        self.ranges
            .iter()
            .map(|range| Some(self.samples[range.start]) == first || self.hung_free_before(self.samples[range.start]))
            .collect()
    }

    /// The segments among the readings that are used.
    fn ranges_of_used(&self) -> Vec<Range<usize>> {
        let mut begin = 0;
        let next = |range: &Range<usize>| {
            begin += range.len();
            begin - range.len()..begin
        };
        self.ranges.iter().map(next).collect()
    }
}

/// What a fit comes to: with harmonics that no reading resolves, unless their number is given, and with the motion between readings believed loosely only.
/// Believed as it was fitted it would bend the shape where the object slides or tips over; without it, angles that are hardly told would.
fn completed(problem: &Problem, fit: Fit, harmonics: Option<usize>) -> Fit {
    let state = &fit.optimum.state;
    let wide = if harmonics.is_none() { evidence::with_unresolved(problem, state) } else { None };
    let wide = wide.unwrap_or_else(|| problem.clone());
    let loose = wide.between.map(|(between, sd_rad)| (between, sd_rad.max(LOOSE_SD_RAD)));
    let wide = Problem { between: loose, ..wide };
    let Some(optimum) = wide.solve(state.clone()) else { return fit };
    Fit { optimum, order: wide.order, harmonics: wide.harmonics, between_rad: loose.map(|(_, sd_rad)| sd_rad), ..fit }
}

/// The noise of a signal by its third differences, which hardly know of a smooth motion: those of independent errors spread by √20.
fn scatter(values: &[f64], ranges: &[Range<usize>]) -> f64 {
    let thirds: Vec<f64> = ranges
        .iter()
        .flat_map(|range| values[range.clone()].windows(4))
        .map(|four| (four[3] - 3.0 * four[2] + 3.0 * four[1] - four[0]) / 20f64.sqrt())
        .collect();
    typical_sd(thirds.iter())
}

fn check(log: &PivotLog, options: &PivotOptions) -> Result<(), PivotReconstructError> {
    let bad = |what: &str| Err(PivotReconstructError::BadOption(what.to_owned()));
    let rig = &options.rig;
    if options.harmonics.is_some_and(|order| !(2..=MOST_HARMONICS).contains(&order)) {
        return bad("the number of harmonics must be between 2 and 48");
    }
    let (constants, tolerances, pad) = (&rig.calibration, &rig.tolerances, &rig.pad);
    let numbers =
        [constants.zero_m, constants.scale, constants.tilt_rad, constants.height_m, pad.base_x_m, pad.base_y_m];
    if numbers.iter().any(|value| !value.is_finite()) || !(pad.tilt_rad.abs() < FRAC_PI_2) || constants.scale <= -0.9 {
        return bad(
            "pose and constants of the pad must be finite, its tilt between -90 and 90 degrees, its scale positive",
        );
    }
    let sds = tolerances.told().into_iter().chain([tolerances.height_sd_m]);
    if !sds.into_iter().all(|sd| sd >= 0.0 && sd.is_finite()) {
        return bad("the tolerances of the rig must be finite and not negative");
    }
    let noises = [rig.reading_sd_m, rig.arm_sd_m];
    if noises.into_iter().flatten().any(|sd| !(sd > 0.0 && sd.is_finite())) {
        return bad("the stated noise of pad and arm must be positive");
    }
    let mut before = None;
    for (index, sample) in log.samples.iter().enumerate() {
        if let Some(what) = fault_of(before, sample) {
            return Err(PivotReconstructError::BadSample { sample: index + 1, what: what.to_owned() });
        }
        before = Some(sample);
    }
    Ok(())
}

/// What is wrong with a sample, behind another.
pub(super) fn fault_of(before: Option<&PivotSample>, sample: &PivotSample) -> Option<&'static str> {
    let values = [sample.time_s, sample.pivot_x_m, sample.pivot_y_m, sample.s_m.unwrap_or(0.0)];
    if values.iter().any(|value| !(value.abs() < LARGEST_VALUE)) {
        return Some("time, pivot and contact must be finite numbers, in seconds and metres");
    }
    before.is_some_and(|before| sample.time_s < before.time_s).then_some("time runs backwards")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pivot::{PivotSimulateOptions, Stroke, simulate_strokes};
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;

    /// What was questioned before may have another number of harmonics than what took its place.
    #[test]
    fn alternatives_have_their_own_number_of_harmonics() {
        let egg = NamedShape::Egg.shape(0.03).expect("an egg").translated(0.004, 0.003);
        let strokes = [0.65, 0.35].map(|to_m| Stroke { along_m: vec![0.5, to_m], press: 3.0 });
        let touchpad = Touchpad { length_m: 1.0, noise_sd_m: 1e-4, ..Touchpad::ideal() };
        let options = PivotSimulateOptions { touchpad, arm_noise_sd_m: 2e-5, ..PivotSimulateOptions::default() };
        let log = simulate_strokes(&egg, &strokes, &options).expect("possible").log;
        let options = PivotOptions::default();
        let prepared = Prepared::new(&log, &options, Cuts::AtLeaps).expect("a log");
        let relative_rad = [true, false].map(|may_roll| prepared.relative(1.0, may_roll));
        let Found { fit, reconstruction, .. } = prepared.solved(&relative_rad, None, (&[], None)).expect("a result");
        let readings: Vec<Reading> = prepared.used().iter().map(|&index| prepared.readings[index]).collect();
        let problem = Problem {
            readings: &readings,
            noise: fit.noise,
            order: fit.order,
            size_m: prepared.size_m,
            harmonics: HarmonicPrior::of_scale(prepared.size_m),
            stated: options.rig.calibration,
            open: Vec::new(),
            between: None,
        };
        let theta_rad = fit.optimum.state.theta_rad.clone();
        let prior = MotionPrior {
            ranges: prepared.ranges_of_used(),
            begins_at_rest: prepared.begins_at_rest(),
            relative_rad: [theta_rad.clone(), theta_rad],
            tips_over: vec![false; readings.len()],
            lifted: vec![false; readings.len()],
        };
        for order in [fit.order - 2, fit.order + 2] {
            let of_order = Problem { order, ..problem.clone() };
            let other = evidence::fit(of_order, fit.optimum.state.clone(), prepared.stated()).expect("another");
            let (found, _) = prepared.assembled(&problem, &other, &prior, &[], 2).expect("its result");
            assert_eq!((found.shape.harmonics_m().len(), found.alternatives), (order, 2));
            assert_eq!(found.motion.len(), reconstruction.motion.len());
        }
    }
}
