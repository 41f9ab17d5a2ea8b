//! The schedule of the search (`docs/theory.md`, the search): which seeds are grown over the whole log by beam search, in which
//! order and with how much trust in the balance, until one arrangement explains all of the log. A wrong seed may grow far, but
//! with a normalized misfit well above 1; such seeds are deferred. Where none explains all of it, the best of a part are judged.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::reconstruct::search::beam::{BeamSearch, Budget, EXPLAINED, explained, misfit};
use crate::reconstruct::search::problem::{Calibrate, Corrected, Problem};
use crate::reconstruct::search::seed::Seed;
use crate::reconstruct::search::segments::segments;
use crate::reconstruct::search::tolerance::Tolerance;
use crate::reconstruct::search::windows::{Window, spans, windows};
use crate::sensor::Calibration;
use std::borrow::Cow;
use std::ops::Range;

/// Thinned instants that the search works on, about: its cost is proportional to their number.
const SAMPLES: usize = 250;

/// Standard deviations of the balance as multiples of those of the contacts, in turn (for growing, and for judging arrangements):
/// equal; then as exact as statics has it, since near-circular objects differ in little else; and, where that explains nothing
/// (friction, fast palms), large.
const BALANCES: [[f64; 2]; 3] = [[1.0, 1.0], [1.0, 0.3], [15.0, 15.0]];

/// Before this one of them, which does not believe in the balance, it is asked whether other forces explained the log.
const AFTER_CONTACT_ALONE: usize = 2;

/// Trusts in the calibration of the rig, as many standard deviations of a contact position with what is unknown of it, that are tried with the first of
/// these; the others have the first trust.
pub(crate) const TRUSTS: usize = 3;

/// Cost per instant of the part of a log that is not arranged: well above [`EXPLAINED`].
const MISSING: f64 = 10.0;

/// Largest normalized misfit of a growing seed, in turn: one above it is deferred until the others have been grown.
const MISFIT_LIMITS: [f64; 3] = [1.0, 2.0, f64::INFINITY];

/// Spans that are searched for a seed, those with the longest contact paths: more cost time, fewer may all contain a hidden jump.
const SPANS: usize = 16;

/// Misfit of a seed, as [`EXPLAINED`], below which errors of the rig may be all that is wrong with it: with three times the error that is allowed for.
const NEARLY_EXPLAINED: f64 = 10.0 * EXPLAINED;

/// Seeds, those with the longest contact paths, that are begun anew with more harmonics: each costs more than all that was done for it before.
const BEGUN_ANEW: usize = 6;

/// Seeds that are grown to the end before the search gives up: more cost time, fewer may all be wrong.
const SEEDS: usize = 6;

/// Shares of the work that are reported as done: of that of a way, when its seeds with few harmonics are grown, and of what follows, when seeds have more.
const FEW_HARMONICS_DONE: f64 = 0.4;
const SEEDS_DONE: f64 = 0.2;

/// Arrangements of a part of the log that are tried with each of them: those that explain most instants. Those with the exact balance are
/// much the same as those before.
const PARTS: [usize; 3] = [3, 1, 3];

/// What is searched.
#[derive(Clone, Copy)]
pub(crate) struct Readings<'a> {
    /// What the measurements were corrected by.
    pub calibration: Calibration,
    pub measurements: &'a Measurements,
    /// Standard deviation of a contact position from one sample to the next, metres.
    pub scatter_m: f64,
    /// The same with what is unknown of the calibration, in turn. Of equal ones only the first is tried.
    pub tolerances_m: [f64; TRUSTS],
    pub prior: Prior,
    /// Whether only the first way is gone, that of most logs: few harmonics, and an equal trust in balance and contacts.
    pub brief: bool,
    /// Asked when one of these has led nowhere: whether others are tried.
    pub goes_on: &'a dyn Fn(Stage) -> bool,
    /// Asked for an arrangement from elsewhere, which is tried before seeds are begun anew.
    pub from_elsewhere: &'a dyn Fn() -> Option<Found>,
}

/// Where it is asked whether to go on: before something, or after what has led nowhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Before it is asked whether forces besides balance explain the log.
    Forces,
    /// The first way, that of most logs: few harmonics, or more within the noise, and an equal trust in balance and contacts.
    FirstWay,
    /// The first arrangement that was judged, under balance without friction, and that misses contacts or balance.
    FirstArrangement,
    /// An equal trust in balance and contacts, with any number of harmonics.
    EqualTrust,
}

/// Arrangements found.
pub(crate) struct Found {
    /// What its readings were corrected by, and the standard deviation of a contact position that was allowed, metres.
    pub calibration: Calibration,
    pub tolerance_m: f64,
    /// The thinned instants that were arranged, in order of time.
    pub thin: Measurements,
    /// Index ranges (of all samples) that were arranged.
    pub ranges: Vec<Range<usize>>,
    /// Best first, over the instants of `thin`.
    pub estimates: Vec<Estimate>,
}

/// The ways of the search in turn: trusts in the calibration with an equal trust in balance and contacts, then the others in the balance. Each is an index
/// of [`BALANCES`] and one of the tolerances.
fn ways(tolerances_m: &[f64; TRUSTS]) -> Vec<(usize, usize)> {
    let is_new = |trust: &usize| !tolerances_m[..*trust].contains(&tolerances_m[*trust]);
    let calibrations = (0..TRUSTS).filter(is_new).map(|trust| (0, trust));
    calibrations.chain((1..BALANCES.len()).map(|balance| (balance, 0))).collect()
}

/// Passes each arrangement of the log that the search finds to `accept` until that returns true, most promising first; for each trust in calibration
/// and balance those that explain the log, then the best of a part. `calibrate` is told the number of that trust in the calibration, `tell` the share
/// of the work done; before the balance is no longer believed in, `otherwise` is asked whether the log is explained in another way.
pub(crate) fn search(
    readings: &Readings,
    calibrate: &dyn Fn(&Found, usize) -> Option<Corrected>,
    tell: &dyn Fn(f64),
    otherwise: &mut dyn FnMut() -> bool,
    accept: &mut dyn FnMut(Found) -> bool,
) {
    let Readings { calibration, measurements, scatter_m, tolerances_m, prior, brief, goes_on, from_elsewhere } =
        *readings;
    let windows = windows(measurements, &segments(measurements, scatter_m), scatter_m, SAMPLES);
    let is_spent = || measurements.work.is_spent();
    let ways = ways(&tolerances_m);
    for (number, &(balance, trust)) in ways.iter().enumerate() {
        let last = number > 0 && is_spent();
        let is_explained = (balance == AFTER_CONTACT_ALONE || last) && otherwise();
        if is_explained || last {
            return;
        }
        let tolerance = Tolerance::new(measurements, tolerances_m[trust], BALANCES[balance]);
        let (measurements, windows) = (Cow::Borrowed(measurements), windows.clone());
        let problem = Problem { calibration, measurements, windows, tolerance, prior };
        let calibrate = |found: &Found| calibrate(found, trust);
        let tell = |share: f64| tell((number as f64 + share) / ways.len() as f64);
        let mut partial: Vec<(usize, Found)> = Vec::new();
        let mut any_explained = false;
        let mut consider = |arranged: Arrangement| match arranged {
            Arrangement::Whole(found) => {
                any_explained = true;
                accept(found)
            }
            Arrangement::Partial(explained, found) => {
                partial.push((explained, found));
                false
            }
        };
        let few = |share: f64| tell(FEW_HARMONICS_DONE * share);
        let Some(mut begun) = with_few_harmonics(&problem, &calibrate, &few, &mut consider) else { return };
        if brief || begun.with_more_harmonics(&problem, &calibrate, &mut consider) {
            return;
        }
        if number == 0 && !goes_on(Stage::FirstWay) {
            return;
        }
        if number == 0
            && let Some(found) = from_elsewhere()
            && consider(Arrangement::Whole(found))
        {
            return;
        }
        let more = |share: f64| tell(FEW_HARMONICS_DONE + (1.0 - FEW_HARMONICS_DONE) * share);
        if begun.with_all(&problem, &calibrate, &more, &mut consider) {
            return;
        }
        // The shape of a part may tell where the object is in all others, though no window beside it was explained.
        partial.sort_by_key(|(explained, _)| std::cmp::Reverse(*explained));
        let mut parts = partial.into_iter().take(PARTS[balance]).enumerate();
        if parts.any(|(index, (_, found))| (number + index == 0 || !is_spent()) && accept(found)) {
            return;
        }
        // Where arrangements with an exact balance explain the log, those without it are no better.
        if (any_explained && balance > 0) || (number == 0 && !goes_on(Stage::EqualTrust)) {
            return;
        }
    }
}

/// The same by contact alone, whatever the forces are: for objects that roll and slide with friction. Passes arrangements of the whole log to
/// `accept` until that returns true.
pub(crate) fn search_by_contact(readings: &Readings, calibrate: &Calibrate, accept: &mut dyn FnMut(Found) -> bool) {
    let Readings { calibration, measurements, scatter_m, tolerances_m, prior, .. } = *readings;
    let windows = windows(measurements, &segments(measurements, scatter_m), scatter_m, SAMPLES);
    let tolerance = Tolerance::new(measurements, tolerances_m[0], BALANCES[0]).of_contact_alone();
    let problem = Problem { calibration, measurements: Cow::Borrowed(measurements), windows, tolerance, prior };
    let mut partial: Vec<(usize, Found)> = Vec::new();
    let mut consider = |arranged: Arrangement| match arranged {
        Arrangement::Whole(found) => accept(found),
        Arrangement::Partial(explained, found) => {
            partial.push((explained, found));
            false
        }
    };
    if with_few_harmonics(&problem, calibrate, &|_| (), &mut consider).is_some() {
        partial.sort_by_key(|(explained, _)| std::cmp::Reverse(*explained));
        let _ = partial.into_iter().take(PARTS[0]).any(|(_, found)| accept(found));
    }
}

/// A seed that is explained, as it is or once its readings are corrected by what it tells of the rig; `None` where it is not.
fn explained_seed<'a>(seed: &Seed, problem: &Problem<'a>, calibrate: &Calibrate) -> Option<BeamSearch<'a>> {
    if seed.misfit < EXPLAINED {
        return Some(seed.beam_search(problem, calibrate));
    }
    let nearly = (seed.misfit < NEARLY_EXPLAINED).then(|| seed.calibrated(problem, calibrate)).flatten();
    nearly.filter(|beam_search| beam_search.normalized_misfit() <= MISFIT_LIMITS[0])
}

/// What became of a seed.
enum Arrangement {
    /// All of the log is explained.
    Whole(Found),
    /// So many instants are.
    Partial(usize, Found),
}

/// Seeds, and those of them that grew so far and no further with few harmonics and with more, with what is left of the work of growing them.
#[derive(Default)]
struct Begun<'a> {
    seeds: Vec<Seed>,
    deferred: Vec<BeamSearch<'a>>,
    budget: Budget,
    grown: usize,
    richer: Vec<BeamSearch<'a>>,
    budget_of_richer: Budget,
}

/// Passes what a search has grown to `consider`.
fn submit(problem: &Problem, beam_search: BeamSearch, consider: &mut dyn FnMut(Arrangement) -> bool) -> bool {
    let (calibration, tolerance) = (beam_search.calibration, beam_search.tolerance);
    let arranged = beam_search.in_order_of_time();
    let Some(top) = arranged.hypotheses.first() else { return false };
    // Samples that are not arranged are not explained.
    let instants = |windows: &[Window]| windows.iter().map(|window| window.range.len()).sum::<usize>();
    let missing = 1.0 - instants(&arranged.windows) as f64 / instants(&problem.windows) as f64;
    let cost =
        misfit(&arranged.thin, &top.estimate, tolerance.sharp()) / arranged.thin.len() as f64 + MISSING * missing;
    let ranges = covered_ranges(&arranged.windows);
    let estimates = arranged.hypotheses.into_iter().map(|hypothesis| hypothesis.estimate).collect();
    let found = Found { calibration, tolerance_m: tolerance.scatter_m, thin: arranged.thin, ranges, estimates };
    consider(if cost < EXPLAINED { Arrangement::Whole(found) } else { found.partial(tolerance) })
}

/// Passes arrangements with few harmonics, over every span, to `consider` until that returns true, which gives `None`: many can explain a short span with
/// a jump in it. Seeds whose misfit is that of the noise, for as long as it is: above it, even few harmonics may hide a jump.
fn with_few_harmonics<'a>(
    problem: &Problem<'a>,
    calibrate: &Calibrate,
    tell: &dyn Fn(f64),
    consider: &mut dyn FnMut(Arrangement) -> bool,
) -> Option<Begun<'a>> {
    let mut begun = Begun::default();
    for (number, span) in spans(&problem.windows).into_iter().take(SPANS).enumerate() {
        if problem.measurements.work.is_spent() {
            break;
        }
        tell(number as f64 / SPANS as f64);
        let Some(seed) = Seed::with_few_harmonics(problem, span) else { continue };
        if begun.grown < SEEDS
            && !begun.budget.is_spent()
            && let Some(mut beam_search) = explained_seed(&seed, problem, calibrate)
        {
            if beam_search.grow(&mut begun.budget, MISFIT_LIMITS[0]) {
                begun.grown += 1;
                if submit(problem, beam_search, consider) {
                    return None;
                }
            } else {
                begun.deferred.push(beam_search);
            }
        }
        begun.seeds.push(seed);
    }
    Some(begun)
}

impl<'a> Begun<'a> {
    /// The same with more harmonics, for objects that take them; true when an arrangement is enough.
    fn with_more_harmonics(
        &mut self,
        problem: &Problem<'a>,
        calibrate: &Calibrate,
        consider: &mut dyn FnMut(Arrangement) -> bool,
    ) -> bool {
        let mut grown = 0;
        for seed in &mut self.seeds {
            if grown >= SEEDS || self.budget_of_richer.is_spent() || problem.measurements.work.is_spent() {
                break;
            }
            if !seed.add_harmonics(problem) {
                continue;
            }
            let mut beam_search = seed.beam_search(problem, calibrate);
            if !beam_search.grow(&mut self.budget_of_richer, MISFIT_LIMITS[0]) {
                self.richer.push(beam_search);
                continue;
            }
            grown += 1;
            if submit(problem, beam_search, consider) {
                return true;
            }
        }
        false
    }

    /// And then those that were deferred, seeds that are begun anew, and only then those whose misfit no noise explains.
    fn with_all(
        mut self,
        problem: &Problem<'a>,
        calibrate: &Calibrate,
        tell: &dyn Fn(f64),
        consider: &mut dyn FnMut(Arrangement) -> bool,
    ) -> bool {
        let mut submit = |beam_search: BeamSearch<'a>| submit(problem, beam_search, consider);
        let (left, limit) = (SEEDS - self.grown, &MISFIT_LIMITS[1..2]);
        if grow_in_turn(&mut self.deferred, limit, &mut self.budget, left, &|_| (), &mut submit) {
            return true;
        }
        let anew = self.seeds.iter_mut().take(BEGUN_ANEW).filter_map(|seed| {
            let is_new = !problem.measurements.work.is_spent() && seed.begin_anew(problem);
            is_new.then(|| seed.beam_search(problem, calibrate))
        });
        self.richer.extend(anew);
        self.deferred.append(&mut self.richer);
        tell(SEEDS_DONE);
        let tell = |share: f64| tell(SEEDS_DONE + (1.0 - SEEDS_DONE) * share);
        let budget = &mut self.budget_of_richer;
        if grow_in_turn(&mut self.deferred, &MISFIT_LIMITS, budget, SEEDS, &tell, &mut submit) {
            return true;
        }
        self.seeds.into_iter().for_each(|seed| {
            consider(seed.found(problem).partial(problem.tolerance));
        });
        false
    }
}

impl Found {
    fn partial(self, tolerance: Tolerance) -> Arrangement {
        let explained = self.estimates.first().map_or(0, |best| explained(&self.thin, best, tolerance.sharp()));
        Arrangement::Partial(explained, self)
    }
}

/// Grows seeds by increasing misfit, with one limit after the other, and submits those that came to their end; true when one of them is
/// enough. Ends when so many were grown or the budget is spent; `tell` is given the share of either that is used up.
fn grow_in_turn<'a>(
    seeds: &mut Vec<BeamSearch<'a>>,
    limits: &[f64],
    budget: &mut Budget,
    most: usize,
    tell: &dyn Fn(f64),
    submit: &mut dyn FnMut(BeamSearch<'a>) -> bool,
) -> bool {
    let mut grown = 0;
    for &largest_misfit in limits {
        let mut deferred = Vec::new();
        seeds.sort_by(|a, b| a.normalized_misfit().total_cmp(&b.normalized_misfit()));
        for mut beam_search in std::mem::take(seeds) {
            tell((grown as f64 / most.max(1) as f64).max(budget.share_spent()));
            if grown >= most || budget.is_spent() || beam_search.is_spent() {
                deferred.push(beam_search);
            } else if beam_search.grow(budget, largest_misfit) {
                grown += 1;
                if submit(beam_search) {
                    return true;
                }
            } else {
                deferred.push(beam_search);
            }
        }
        *seeds = deferred;
    }
    false
}

/// The index ranges that placed windows cover; windows that are joined make one range.
pub(crate) fn covered_ranges(placed: &[Window]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for Window { range, joined, .. } in placed {
        match ranges.last_mut() {
            Some(last) if *joined && last.end == range.start => last.end = range.end,
            _ => ranges.push(range.clone()),
        }
    }
    ranges
}

#[cfg(test)]
mod tests;
