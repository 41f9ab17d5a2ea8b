//! From a log of strokes to shape and motion: segments, closed form, search, maximum likelihood, rivals, verdict.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use crate::estimate::coverage::{LONGEST_SLIDE, NODES, touches};
use crate::math::angle::{mean_direction, wrapped};
use crate::math::statistics::{median, root_mean_square, typical_sd};
use crate::pivot::beside_leaps::are_open;
use crate::pivot::calibration::{Reading, TOLD};
use crate::pivot::center_of_mass::{self, FirstContact};
use crate::pivot::closed_form::Stretch;
use crate::pivot::decode::{Decoding, decoded};
use crate::pivot::error::PivotReconstructError;
use crate::pivot::error_bars::ErrorBars;
use crate::pivot::evidence::{self, Fit, MOST_HARMONICS, Stated, choose_order, squares_and_redundancies};
use crate::pivot::log::{PivotLog, PivotSample};
use crate::pivot::motion_between::{FIRST_SD_RAD, MotionBetween};
use crate::pivot::motion_prior::{MotionPrior, leap_nats, lifted, tips_over};
use crate::pivot::posterior::PivotPosterior;
use crate::pivot::result::{PivotPose, PivotReconstruction};
use crate::pivot::rig::PivotRig;
use crate::pivot::rivals::{Rivals, Whole};
use crate::pivot::search::{Arrangement, SEARCH_ORDER, Segments, same, search_noise, shape_given_angles};
use crate::pivot::segments::{Cuts, LIFTED_SAMPLES, segments};
use crate::pivot::smoother::{Noise, Optimum, Problem, State, across, curve_row};
use crate::pivot::thinning::Thinning;
use crate::pivot::verdict::{Findings, MODEL_ALLOWANCE, PivotDoubt, RIVAL_NATS};
use crate::reconstruct::OutlinePoint;
use crate::shape::SupportFunction;

/// Fewest samples with a contact that can be solved.
const FEWEST_SAMPLES: usize = 30;

/// The crossings of d = 0 are taken so many times as wide, and rolled through or not, in turn.
const CROSSINGS: [(f64, bool); 4] = [(1.0, true), (1.0, false), (2.0, true), (0.5, false)];

/// Contact angles are decoded anew at most so many times.
const MOST_DECODINGS: usize = 8;

/// A reading that is missed by so many standard deviations may be on the wrong branch: angles are decoded anew.
const ASTRAY_SDS: f64 = 5.0;

/// Closed forms and fit agree on a segment where their angles differ by less, radians.
const AGREED_RAD: f64 = 0.2;

/// A fit that leaves more than this, χ² per degree of freedom, is not certified: its rivals are not looked for.
const EXPLAINED_CHI2: f64 = 1.6;

/// Second differences of the contact angle that a result believes in, standard deviation in radians at least: those of an object that begins to slide are a
/// few times smaller, and an angle that readings hardly tell, around d = 0, could be off by a few times as much.
const LOOSE_SD_RAD: f64 = 0.05;

/// Rivals that turn out better are examined in their turn, so many times.
const MOST_BETTER_RIVALS: usize = 3;

/// A contact angle with a larger standard deviation, radians, may seem to leap.
const TOLD_RAD: f64 = 0.05;

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
    // An object may tip over unseen where it turns fast: what the rest tells is tried first.
    let cautious = Prepared::new(log, options, Cuts::AtLongSteps).ok();
    let cautious = cautious.filter(|cautious| cautious.ranges != prepared.ranges);
    let start = cautious.and_then(|cautious| {
        let rest = likeliest_first(cautious.search(None)).into_iter().next()?;
        prepared.completed(&cautious, &rest.fit)
    });
    let mut found = likeliest_first(prepared.search(start)).into_iter();
    let Found { mut reconstruction, posterior, log_evidence, .. } =
        found.next().ok_or(PivotReconstructError::NotSolvable)?;
    let rivals = found.filter(|rival| {
        rival.is_explained()
            && rival.log_evidence > log_evidence - RIVAL_NATS
            && reconstruction.turns_otherwise(&rival.reconstruction)
    });
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
    led_to: State,
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
            spread_m: 0.5 * self.size_m,
            stated: self.options.rig.calibration,
            open: told.into_iter().enumerate().filter(|(_, sd)| *sd > 0.0).collect(),
            between: None,
        }
    }

    /// Results from the closed forms, and from a start where there is one.
    fn search(&self, start: Option<State>) -> Vec<Found> {
        let pair = |width: f64, may_roll: bool| [may_roll, !may_roll].map(|may_roll| self.relative(width, may_roll));
        let mut found: Vec<Found> = Vec::new();
        if let Some(start) = start {
            let [(width, may_roll), ..] = CROSSINGS;
            found.extend(self.solved(&pair(width, may_roll), Some(start), &[]));
        }
        let mut tried: Vec<Vec<f64>> = Vec::new();
        for (width, may_roll) in CROSSINGS {
            // Where others lead elsewhere the log does not tell; for a start to go on from the first will do.
            if self.cuts == Cuts::AtLongSteps && found.iter().any(Found::is_explained) {
                break;
            }
            // Without a crossing all closed forms are one.
            let pair = pair(width, may_roll);
            if !tried.contains(&pair[0]) {
                let other = self.solved(&pair, None, &found);
                found.extend(other);
                let [relative_rad, _] = pair;
                tried.push(relative_rad);
            }
        }
        found
    }

    /// The state of all readings that are used, from a fit of some of them: the others are decoded by its shape.
    fn completed(&self, others: &Self, fit: &Fit) -> Option<State> {
        let state = &fit.optimum.state;
        let mut known: Vec<Option<f64>> = vec![None; self.readings.len()];
        others.used().into_iter().zip(&state.theta_rad).for_each(|(index, theta)| known[index] = Some(*theta));
        let used = self.used();
        let errors = self.options.rig.calibration.with_told(state.told);
        let measured = |&index: &usize| self.readings[index].measured(&errors);
        let measured: Vec<[f64; 2]> = used.iter().map(measured).map(|m| [m.r_m, m.d_m]).collect();
        let is_lifted = lifted(&self.readings, self.scatter.r_m);
        let decoding = Decoding {
            measured: &measured,
            leap_nats: &|place| leap_nats(is_lifted[used[place]]),
            known_rad: &|place| known[used[place]],
        };
        let variance = curve_variance(&fit.optimum, fit.order, fit.noise)?;
        let decoded = decoded(state, &decoding, &self.ranges_of_used(), fit.noise, variance);
        // A known angle is within half a step of what was decoded, whole turns apart.
        let theta_rad = decoded.iter().zip(&used).map(|(theta, &index)| match known[index] {
            Some(known) => theta + wrapped(known - theta),
            None => *theta,
        });
        Some(State { theta_rad: theta_rad.collect(), ..state.clone() })
    }

    /// The best result from one closed form, the other of the same crossings beside it. It is left where it leads to the same as an earlier start; and
    /// where one of these explains the log, if its segments, laid on that, lead back to it, or if what they are arranged to leads there, or explains the
    /// log with as many harmonics so little that no decoding makes a rival of it.
    fn solved(
        &self,
        [relative_rad, other_rad]: &[Vec<f64>; 2],
        start: Option<State>,
        earlier: &[Found],
    ) -> Option<Found> {
        let explained = earlier.iter().find(|found| found.is_explained());
        let noise = self.reference();
        let search = Problem { noise: search_noise(noise, self.size_m), ..self.problem(&[]) };
        let used = self.used();
        let readings: Vec<Reading> = used.iter().map(|&index| self.readings[index]).collect();
        let thinning = Thinning::new(&self.ranges_of_used());
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
        let choose = |order: usize, start: State| {
            let order = self.options.harmonics.unwrap_or(order);
            let decided = evidence::fit(Problem { order, ..problem.clone() }, start, self.stated())?;
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
        let whole = |fit: &Fit| fit.like(problem.clone());
        if let Some(Found { fit, .. }) = explained {
            let alike = whole(fit);
            let laid = laid_on(&prior.ranges, relative_rad, &fit.optimum.state.theta_rad);
            let there = alike.solve(shape_given_angles(&alike, laid)?)?;
            if same(&there.state, &fit.optimum.state) {
                return None;
            }
        }
        let segments = Segments {
            readings: &thinning.of(&readings),
            ranges: &thinning.ranges,
            relative_rad: &thinning.of(relative_rad),
            begins_at_rest: &self.begins_at_rest(),
        };
        let arrangements = if start.is_some() { Vec::new() } else { segments.arrangements(&search) };
        let whole_state = |arrangement: &Arrangement| {
            let state = segments.in_order(arrangement)?;
            Some(State { theta_rad: thinning.spread(relative_rad, &state.theta_rad), ..state })
        };
        let start = start.or_else(|| whole_state(arrangements.first()?))?;
        if let Some(Found { fit, .. }) = explained {
            let there = whole(fit).solve(start.clone())?;
            if same(&there.state, &fit.optimum.state) || self.chi2_per_dof(fit.noise, &there).0 > EXPLAINED_CHI2 {
                return None;
            }
        }
        let mut fit = choose(SEARCH_ORDER, start)?;
        for _ in 0..MOST_DECODINGS {
            let state = &fit.optimum.state;
            let continuous = prior.without_leaps(&state.theta_rad);
            let continuous = continuous.map(|theta_rad| State { theta_rad, ..state.clone() });
            let own = Problem { noise: fit.noise, between: None, ..problem.clone() };
            let bridged = prior.bridged(&state.theta_rad, &|index, theta_rad| own.settled(state, index, theta_rad));
            let bridged = bridged.map(|theta_rad| State { theta_rad, ..state.clone() });
            let few = Problem { order: SEARCH_ORDER, between: None, ..problem.clone() };
            let starts =
                [continuous, bridged, self.mended(&readings, &prior, &fit), self.placed_by_others(&few, &prior, &fit)];
            let mut starts: Vec<State> = starts.into_iter().flatten().collect();
            if !starts.is_empty() {
                // What is wrong may have come with the fit: the closed forms, where it is, know nothing of it.
                let few = Problem { order: SEARCH_ORDER, ..problem.clone() };
                let laid = prior.relative_rad.iter().map(|relative| laid_on(&prior.ranges, relative, &state.theta_rad));
                starts.extend(laid.filter_map(|theta_rad| shape_given_angles(&few, theta_rad)));
            }
            // From few harmonics, which do not follow what is wrong.
            let tried = starts.into_iter().filter_map(|start| choose(SEARCH_ORDER, start));
            let Some(next) = tried.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence)) else { break };
            if next.log_evidence <= fit.log_evidence + 1.0 {
                break;
            }
            fit = next;
        }
        if earlier.iter().any(|found| same(&found.led_to, &fit.optimum.state)) {
            return None;
        }
        if let Ok(path) = std::env::var("TRUTH") {
            let text = std::fs::read_to_string(path).unwrap();
            let mut head = text.lines().filter(|l| !l.starts_with('#'));
            let col = head.next().unwrap().split(',').position(|c| c == "psi_rad").unwrap();
            let psi: Vec<f64> = head.map(|l| l.split(',').nth(col).unwrap().parse().unwrap()).collect();
            let truth: Vec<f64> =
                used.iter().map(|&i| self.options.rig.pad.tilt_rad - FRAC_PI_2 - psi[self.samples[i]]).collect();
            let few = Problem { order: SEARCH_ORDER, ..problem.clone() };
            let tell = |what: &str, theta: &[f64]| {
                for range in &prior.ranges {
                    let offs: Vec<f64> = range.clone().map(|i| wrapped(theta[i] - truth[i])).collect();
                    let m = median(&mut offs.clone());
                    let far = offs.iter().filter(|o| wrapped(**o - m).abs() > 0.1).count();
                    let worst = offs.iter().map(|o| wrapped(o - m).abs()).fold(0.0, f64::max);
                    eprintln!(
                        "   {what} {:?} ({}..{}): truth from {:.2} to {:.2}; median off {:.3} worst {:.3} far {}",
                        range,
                        self.samples[used[range.start]],
                        self.samples[used[range.end - 1]],
                        truth[range.start],
                        truth[range.end - 1],
                        m,
                        worst,
                        far
                    );
                }
            };
            tell("closed", relative_rad);
            tell("fit", &fit.optimum.state.theta_rad);
            if let Some(of_truth) =
                shape_given_angles(&few, truth.clone()).and_then(|start| choose(SEARCH_ORDER, start))
            {
                let pr = |f: &Fit| {
                    prior
                        .leaps(&f.optimum.state.theta_rad)
                        .map(|i| (self.samples[used[i]], prior.leap_nats(i)))
                        .collect::<Vec<_>>()
                };
                eprintln!(
                    "fit evidence {:.2} order {} noise {:?} chi2 {:.3} leaps {:?} other {} between {:?}; from truth {:.2} order {} noise {:?} chi2 {:.3} leaps {:?} other {} between {:?}",
                    fit.log_evidence,
                    fit.order,
                    fit.noise,
                    self.chi2_per_dof(fit.noise, &fit.optimum).0,
                    pr(&fit),
                    prior.other_starts(&fit.optimum.state.theta_rad),
                    fit.between_rad,
                    of_truth.log_evidence,
                    of_truth.order,
                    of_truth.noise,
                    self.chi2_per_dof(of_truth.noise, &of_truth.optimum).0,
                    pr(&of_truth),
                    prior.other_starts(&of_truth.optimum.state.theta_rad),
                    of_truth.between_rad
                );
                tell("of truth", &of_truth.optimum.state.theta_rad);
            }
        }
        let led_to = fit.optimum.state.clone();
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
            let next = better.map(|better| choose(SEARCH_ORDER, better.optimum.state.clone()));
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
        let fit = loosened(&whole(&fit), fit);
        let (mut reconstruction, posterior) = self.assembled(&problem, &fit, &prior, 1 + alternatives.len())?;
        let others = alternatives
            .iter()
            .take(4)
            .filter_map(|other| self.assembled(&problem, other, &prior, 1 + alternatives.len()));
        reconstruction.others = others.map(|(other, _)| other).collect();
        Some(Found { reconstruction, posterior, log_evidence: fit.log_evidence, fit, led_to })
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

    /// Whether a reading may be on the wrong branch.
    fn is_astray(&self, fit: &Fit) -> bool {
        let reference = self.reference();
        let sds = |[r, d]: &[f64; 2]| (r * fit.noise.r_m / reference.r_m).hypot(d * fit.noise.d_m / reference.d_m);
        fit.optimum.linear.told.residuals.iter().any(|residual| sds(residual) > ASTRAY_SDS)
    }

    /// The state with all angles decoded anew; `None` where no reading asks for it.
    fn mended(&self, readings: &[Reading], prior: &MotionPrior, fit: &Fit) -> Option<State> {
        let reference = self.reference();
        let noise = Noise { r_m: fit.noise.r_m.max(reference.r_m), d_m: fit.noise.d_m.max(reference.d_m) };
        let state = &fit.optimum.state;
        if !self.is_astray(fit) {
            return None;
        }
        let variance = curve_variance(&fit.optimum, fit.order, noise)?;
        let errors = self.options.rig.calibration.with_told(state.told);
        let measured: Vec<[f64; 2]> =
            readings.iter().map(|reading| reading.measured(&errors)).map(|m| [m.r_m, m.d_m]).collect();
        let decoding =
            Decoding { measured: &measured, leap_nats: &|place| prior.leap_nats(place), known_rad: &|_| None };
        Some(State { theta_rad: decoded(state, &decoding, &prior.ranges, noise, variance), ..state.clone() })
    }

    /// The state with the angles of segments that closed forms and fit do not agree on decoded anew, by the shape that the others tell; `None` where
    /// they agree on all, or on few.
    fn placed_by_others(&self, few: &Problem, prior: &MotionPrior, fit: &Fit) -> Option<State> {
        if !self.is_astray(fit) {
            return None;
        }
        let state = &fit.optimum.state;
        let laid = prior.relative_rad.each_ref().map(|relative| laid_on(&prior.ranges, relative, &state.theta_rad));
        let is_agreed = |range: &Range<usize>| {
            let mut all =
                range.clone().flat_map(|place| laid.iter().map(move |laid| laid[place] - state.theta_rad[place]));
            all.all(|off| off.abs() < AGREED_RAD)
        };
        let (agreed, others): (Vec<Range<usize>>, Vec<Range<usize>>) =
            prior.ranges.iter().cloned().partition(is_agreed);
        let kept: Vec<usize> = agreed.into_iter().flatten().collect();
        if others.is_empty() || kept.len() < FEWEST_SAMPLES {
            return None;
        }
        let readings: Vec<Reading> = kept.iter().map(|&place| few.readings[place]).collect();
        let of_kept = Problem { readings: &readings, ..few.clone() };
        let start = shape_given_angles(&of_kept, kept.iter().map(|&place| state.theta_rad[place]).collect())?;
        let told = of_kept.solve(start)?;
        let errors = self.options.rig.calibration.with_told(told.state.told);
        let measured: Vec<[f64; 2]> =
            few.readings.iter().map(|reading| reading.measured(&errors)).map(|m| [m.r_m, m.d_m]).collect();
        let variance = curve_variance(&told, few.order, few.noise)?;
        let mut theta_rad = state.theta_rad.clone();
        kept.iter().zip(&told.state.theta_rad).for_each(|(&place, theta)| theta_rad[place] = *theta);
        let decoding =
            Decoding { measured: &measured, leap_nats: &|place| prior.leap_nats(place), known_rad: &|_| None };
        let decoded = decoded(&told.state, &decoding, &others, few.noise, variance);
        others.into_iter().flatten().zip(decoded).for_each(|(place, theta)| theta_rad[place] = theta);
        Some(State { theta_rad, ..told.state })
    }

    /// Which of the readings may as well be on the other side of a leap.
    fn open_samples(&self, problem: &Problem, prior: &MotionPrior, fit: &Fit) -> Option<Vec<bool>> {
        let state = &fit.optimum.state;
        let own = Problem { between: None, ..problem.clone() };
        let variance = curve_variance(&fit.optimum, fit.order, fit.noise)?;
        let cost = |sample: usize, theta_rad: f64| {
            let (nats, theta_rad) = own.settled(state, sample, theta_rad);
            let contact = crate::estimate::model::contact::support(&state.coefficients, theta_rad);
            let share = across([-contact.d / fit.noise.r_m, (contact.r - contact.v) / fit.noise.d_m]);
            (nats / (1.0 + variance(theta_rad, share)), theta_rad)
        };
        Some(are_open(&prior.ranges, &state.theta_rad, &cost, &|sample| prior.leap_nats(sample)))
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

    /// The result of one fit, whose noise and number of harmonics are its own and not those of the problem.
    fn assembled(
        &self,
        problem: &Problem,
        fit: &Fit,
        prior: &MotionPrior,
        alternatives: usize,
    ) -> Option<(PivotReconstruction, PivotPosterior)> {
        let problem = &fit.like(problem.clone());
        let rig = &self.options.rig;
        let state = &fit.optimum.state;
        let linear = &fit.optimum.linear;
        let calibration = rig.calibration.with_told(state.told);
        let tilt_rad = rig.pad.tilt_rad + calibration.tilt_rad;
        let first_rad = *state.theta_rad.first()?;
        // ψ = 0 at the first contact.
        let turn_rad = tilt_rad - FRAC_PI_2 - first_rad;
        let open = self.open_samples(problem, prior, fit)?;
        let shape = SupportFunction::from_coefficients(&state.coefficients).rotated(turn_rad);
        if shape.has_nonfinite() {
            return None;
        }
        let paths: Vec<Vec<f64>> = self
            .ranges_of_used()
            .into_iter()
            .flat_map(|range| {
                let placed: Vec<f64> =
                    range.filter(|&place| !open[place]).map(|place| state.theta_rad[place] + turn_rad).collect();
                let slides = placed.chunk_by(|a, b| (b - a).abs() <= LONGEST_SLIDE);
                slides.map(<[f64]>::to_vec).collect::<Vec<Vec<f64>>>()
            })
            .collect();
        let counts = touches(&paths);
        let felt: Vec<usize> = (0..NODES).filter(|&node| counts[node] > 0).collect();
        let angle = |node: usize| TAU * node as f64 / NODES as f64;
        // Error bars belong to the shape before it was turned.
        let felt_before: Vec<f64> = felt.iter().map(|&node| angle(node) - turn_rad).collect();
        let alone = Problem { between: None, ..problem.clone() }.linearised(state);
        let bars = ErrorBars::new(linear, &alone, state, &felt_before)?;
        let outline: Vec<OutlinePoint> = (0..NODES)
            .map(|node| {
                let theta_rad = angle(node);
                let (contact, point) = (shape.at(theta_rad), shape.boundary_point(theta_rad));
                OutlinePoint {
                    theta_rad,
                    r_m: contact.r,
                    r_sd_m: bars.r_sd_m(theta_rad - turn_rad),
                    x_m: point.x_m,
                    y_m: point.y_m,
                    curvature_radius_m: contact.v,
                    touches: counts[node],
                }
            })
            .collect();
        let motion = self.motion(problem, fit, (&bars, &open), turn_rad, tilt_rad);
        let theta_sd_rad = root_mean_square(&bars.theta_sd_rad);
        let r_sd_m = root_mean_square(&felt.iter().map(|&node| outline[node].r_sd_m).collect::<Vec<f64>>());
        let (chi2_per_dof, dof) = self.chi2_per_dof(fit.noise, &fit.optimum);
        let coverage = felt.len() as f64 / NODES as f64;
        let concave_sds = felt_before
            .iter()
            .map(|&theta| {
                -crate::estimate::model::contact::support(&state.coefficients, theta).v
                    / bars.v_sd_m(theta).max(1e-12 * self.size_m)
            })
            .fold(0.0, f64::max);
        // Where readings hardly tell an angle it may seem to leap.
        let is_told = |index: usize| bars.theta_sd_rad[index].max(bars.theta_sd_rad[index - 1]) < TOLD_RAD;
        let leaps = prior.unexplained_leaps(&state.theta_rad).filter(|&index| is_told(index)).count();
        let stated = rig.calibration.told();
        let rig_off_sds = problem
            .open
            .iter()
            .map(|&(constant, sd)| ((state.told[constant] - stated[constant]) / sd).abs())
            .fold(0.0, f64::max);
        let findings = Findings {
            size_m: shape.mean_radius_m(),
            least_r_m: felt.iter().map(|&node| outline[node].r_m).fold(f64::INFINITY, f64::min),
            chi2_per_dof,
            dof,
            noise_stated: self.stated().d_m.is_some(),
            coverage,
            r_sd_m,
            theta_sd_rad,
            largest_theta_sd_rad: bars.theta_sd_rad.iter().copied().fold(0.0, f64::max),
            most_harmonics: (self.options.harmonics.is_none() && fit.order >= MOST_HARMONICS).then_some(fit.order),
            concave_sds,
            alternatives,
            leaps,
            other_starts: prior.other_starts(&state.theta_rad),
            rig_off_sds,
            left_out: 1.0 - open.iter().filter(|open| !**open).count() as f64 / self.readings.len() as f64,
        };
        let mut told_sd = rig.tolerances.told();
        for (place, &(constant, _)) in problem.open.iter().enumerate() {
            let index = 2 * fit.order + 1 + place;
            told_sd[constant] = bars.covariance[(index, index)].max(0.0).sqrt();
        }
        let [zero_sd_m, scale_sd, tilt_sd_rad]: [f64; TOLD] = told_sd;
        let first = self.first_contacts(&motion);
        let center_of_mass = center_of_mass::estimate(&shape, &first, tilt_rad, self.log.swing_period_s);
        let posterior = PivotPosterior::new(&state.coefficients, bars.of_shape(), turn_rad);
        let reconstruction = PivotReconstruction {
            shape,
            outline,
            motion,
            doubts: findings.doubts(),
            chi2_per_dof: findings.chi2_per_dof,
            coverage,
            alternatives,
            others: Vec::new(),
            segments: self.ranges.len(),
            sensor_sd_m: fit.noise.d_m,
            arm_sd_m: fit.noise.r_m,
            calibration,
            calibration_sd: crate::pivot::calibration::PivotTolerances {
                zero_sd_m,
                scale_sd,
                tilt_sd_rad,
                height_sd_m: rig.tolerances.height_sd_m,
            },
            center_of_mass,
        };
        Some((reconstruction, posterior))
    }

    /// One pose per sample of the log.
    fn motion(
        &self,
        problem: &Problem,
        fit: &Fit,
        (bars, open): (&ErrorBars, &[bool]),
        turn_rad: f64,
        tilt_rad: f64,
    ) -> Vec<PivotPose> {
        let mut motion: Vec<PivotPose> = self
            .log
            .samples
            .iter()
            .map(|sample| PivotPose {
                time_s: sample.time_s,
                pivot_x_m: sample.pivot_x_m,
                pivot_y_m: sample.pivot_y_m,
                theta_rad: None,
                psi_rad: None,
                psi_sd_rad: None,
                segment: None,
                height_residual_m: None,
                offset_residual_m: None,
            })
            .collect();
        let state = &fit.optimum.state;
        let mut first = 0;
        for (segment, range) in self.ranges.iter().enumerate() {
            // Whole turns do not count: each segment begins within half a turn of the first.
            let begins = state.theta_rad[first] + turn_rad - (tilt_rad - FRAC_PI_2);
            let whole = wrapped(begins) - begins;
            for (place, index) in (first..).zip(range.clone()).filter(|(place, _)| !open[*place]) {
                let pose = &mut motion[self.samples[index]];
                let theta = state.theta_rad[place] + turn_rad + whole;
                let [r, d] = fit.optimum.linear.told.residuals[place];
                pose.theta_rad = Some(theta);
                pose.psi_rad = Some(tilt_rad - FRAC_PI_2 - theta);
                pose.psi_sd_rad = Some(bars.theta_sd_rad[place]);
                pose.segment = Some(segment as u32);
                pose.height_residual_m = Some(-r * problem.noise.r_m);
                pose.offset_residual_m = Some(-d * problem.noise.d_m);
            }
            first += range.len();
        }
        motion
    }

    /// What each stroke begins with: the first contact after samples without one.
    fn first_contacts(&self, motion: &[PivotPose]) -> Vec<FirstContact> {
        let mut first = Vec::new();
        for range in &self.ranges {
            let sample = self.samples[range.start];
            let Some(before) = sample.checked_sub(1).filter(|_| self.hung_free_before(sample)) else { continue };
            if let (Some(theta), Some(sd)) = (motion[sample].theta_rad, motion[sample].psi_sd_rad) {
                let lowered_m = self.height_m(before) - self.height_m(sample);
                first.push(FirstContact::new(theta, sd, lowered_m, self.d_m[range.start]));
            }
        }
        first
    }
}

/// The variance of shares of the residuals of r and of d, over this noise, as far as they are those of the shape: at an angle.
fn curve_variance(
    Optimum { state, linear, .. }: &Optimum,
    order: usize,
    noise: Noise,
) -> Option<impl Fn(f64, [f64; 2]) -> f64 + use<>> {
    let covariance = linear.factorised(&state.coefficients, 0.0)?.inverse();
    let unknowns = 2 * order + 1;
    let of_shape = covariance.view((0, 0), (unknowns, unknowns)).into_owned();
    Some(move |theta_rad: f64, [r_share, d_share]: [f64; 2]| {
        let row = curve_row(theta_rad, order, [r_share / noise.r_m, d_share / noise.d_m]);
        (&of_shape * &row).dot(&row).max(0.0)
    })
}

/// What a fit comes to: the motion between readings is believed loosely only, in its final shape too. Believed as it was fitted it would bend the shape
/// where the object slides or tips over; without it, angles that are hardly told would.
fn loosened(problem: &Problem, fit: Fit) -> Fit {
    let Some((between, sd_rad)) = problem.between else { return fit };
    let loose_rad = sd_rad.max(LOOSE_SD_RAD);
    let loose = Problem { between: Some((between, loose_rad)), ..problem.clone() };
    let Some(optimum) = loose.solve(fit.optimum.state.clone()) else { return fit };
    Fit { optimum, between_rad: Some(loose_rad), ..fit }
}

/// Angles of segments, each up to a constant, laid on others by the rotation of each segment that suits most of it: some of either may be elsewhere.
fn laid_on(ranges: &[Range<usize>], relative_rad: &[f64], theta_rad: &[f64]) -> Vec<f64> {
    let laid = |range: &Range<usize>| {
        let (own, there) = (&relative_rad[range.clone()], &theta_rad[range.clone()]);
        let turns = || own.iter().zip(there).map(|(own, there)| there - own);
        let mean_rad = mean_direction(turns());
        let turn_rad = mean_rad + median(&mut turns().map(|turn| wrapped(turn - mean_rad)).collect::<Vec<f64>>());
        own.iter().map(move |own| own + turn_rad)
    };
    ranges.iter().flat_map(laid).collect()
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
        let Found { fit, reconstruction, .. } = prepared.solved(&relative_rad, None, &[]).expect("a result");
        let readings: Vec<Reading> = prepared.used().iter().map(|&index| prepared.readings[index]).collect();
        let problem = Problem {
            readings: &readings,
            noise: fit.noise,
            order: fit.order,
            size_m: prepared.size_m,
            spread_m: prepared.size_m,
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
            let (found, _) = prepared.assembled(&problem, &other, &prior, 2).expect("its result");
            assert_eq!((found.shape.harmonics_m().len(), found.alternatives), (order, 2));
            assert_eq!(found.motion.len(), reconstruction.motion.len());
        }
    }

    #[test]
    fn segments_are_laid_on_others_by_one_rotation_each() {
        let theta_rad: Vec<f64> = (0..12).map(|index| 0.1 * f64::from(index)).collect();
        let turned = |index: usize| theta_rad[index] + if index < 5 { 2.0 } else { -7.0 };
        // Angles that are off, fewer than half of them, do not turn their segment.
        let mut relative_rad: Vec<f64> = (0..12).map(turned).collect();
        relative_rad[8] += 0.07;
        relative_rad[10] += 0.7;
        let laid = laid_on(&[0..5, 5..12], &relative_rad, &theta_rad);
        for (index, (laid, theta)) in laid.iter().zip(&theta_rad).enumerate() {
            let expected = match index {
                8 => 0.07,
                10 => 0.7,
                _ => 0.0,
            };
            assert!((wrapped(laid - theta) - expected).abs() < 1e-9, "{index}: {laid} {theta}");
        }
    }
}
