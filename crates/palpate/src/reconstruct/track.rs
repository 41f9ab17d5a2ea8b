//! The way of a known shape through the log: of all orientations that each sample might have, those that explain the contacts
//! with the fewest leaps that statics does not foretell (Viterbi's algorithm, forward and backward).
//!
//! This mends samples that the search put at a wrong pose (beside a jump, in the ringing after it, in a stretch that was put
//! off), and it tells what cannot be known: a sample that a way of nearly the same cost puts elsewhere. Elsewhere is where the
//! object can only come by a leap; how uncertain a pose is about its place, the error bars say.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::certificate::balance_limit_m;
use super::evidence::Fit;
use super::known::Known;
use super::noise::{correlation_time, median};
use super::place::{Spread, candidates, minima};
use super::problem::{Instant, Problem};
use super::tabulated::Tabulated;
use crate::math::angle::wrapped;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::frictionless::followed;

/// Steps beyond this from one sample to the next need a reason, radians.
pub(super) const LONGEST_STEP: f64 = 0.15;

/// What a fall costs that statics foretells (the pose before vanishes, and the object goes downhill to the pose after), in
/// squared standard deviations as everything here: −2 ln of how rarely one sample in a log has it, some five of a thousand.
const FALL: f64 = 10.0;

/// What a leap costs that statics does not foretell, and what more if it is by half a turn: an object does not turn to and fro
/// to come from one pose to another.
const LEAP: f64 = 20.0;
const HALF_TURN: f64 = 40.0;

/// What such a leap costs where friction or pace spoil the balance, and no contact leapt. It cannot be: an object that looks
/// the same after half a turn would else turn wherever the balance is spoilt for long.
const MIRACLE: f64 = 1000.0;

/// A contact that moves by less than this share of the mean radius did not leap.
const STILL: f64 = 0.02;

/// A way is changed when that takes at least this much off its cost.
const WORTH_CHANGING: f64 = 9.0;

/// A pose counts as certain when every way elsewhere costs this much more (−2 ln of the odds: 150 to 1).
pub(super) const CERTAIN: f64 = 10.0;

/// Orientations closer than this are one, radians.
const SAME: f64 = 0.06;

/// Standard deviation of a hill that errors of the shape feign where the object falls: as a share of that of a contact
/// position, and of the mean radius.
const FEIGNED_HILL: [f64; 2] = [0.03, 1e-4];

/// The most likely way through a log.
pub(super) struct Track {
    /// One orientation for each sample.
    pub psi: Vec<f64>,
    /// Samples that it puts elsewhere than the fit did.
    pub moved: usize,
    /// For each sample, how much more a way costs (squared standard deviations) that puts it elsewhere.
    pub margin: Vec<f64>,
    /// Squared standard deviations by which each sample is missed.
    pub misfit: Vec<f64>,
    /// For samples that are not certain, the likeliest ways that put them elsewhere.
    pub rivals: Vec<Rival>,
}

/// Another way through the log.
pub(super) struct Rival {
    /// One orientation for each sample.
    pub psi: Vec<f64>,
    /// Samples that it was looked up for.
    pub samples: Vec<usize>,
    /// What its leaps and its poses at no minimum cost more.
    pub leaps: f64,
}

impl Track {
    /// Whether the pose of a sample is open to doubt: another is not much less likely, or none explains it.
    pub fn doubts(&self, sample: usize) -> bool {
        self.margin[sample] < 2.0 * CERTAIN || self.misfit[sample] > UNEXPLAINED
    }
}

/// An orientation that a sample might have.
#[derive(Clone, Copy, Debug)]
struct Choice {
    psi: f64,
    misfit: f64,
}

/// Samples that were not fitted: they may lie on boundary that was not felt, wherever what the others tell of it lets them.
#[derive(Clone, Copy)]
pub(super) struct Aside<'a> {
    /// In order.
    pub samples: &'a [usize],
    /// Those of which statics is not asked, since it foretells no better than the shape is known.
    pub doubtful: &'a (dyn Fn(usize) -> bool + Sync),
    /// The shape that the others leave.
    pub known: &'a Known,
}

/// Tracks the fitted shape through the log. Contacts are never believed to be more exact than `floor_m`.
pub(super) fn track(problem: &Problem, fit: &Fit, floor_m: f64, aside: Option<Aside>) -> Track {
    let coefficients = &fit.estimate.coefficients;
    let (shape, table) = (SupportFunction::from_coefficients(coefficients), Tabulated::new(coefficients));
    let here = &fit.estimate.psi;
    let spread = spread(problem, &table, here, floor_m.max(1e-5 * coefficients[0].abs()));
    let hill_sd_m = FEIGNED_HILL[0] * spread.contact_m2.sqrt() + FEIGNED_HILL[1] * coefficients[0].abs();
    let contact_sd_m = spread.contact_m2.sqrt();
    let balance_m = spread.balance_m2.sqrt();
    let spoilt = balance_m > balance_limit_m(contact_sd_m, coefficients[0].abs());
    let still_m = if spoilt { STILL * coefficients[0].abs() + 6.0 * contact_sd_m } else { 0.0 };
    let anchor = anchor(here);
    let mut choices: Vec<Vec<Choice>> = (0..problem.len())
        .into_par_iter()
        .map(|index| {
            let instant = &problem.instants[index];
            let restlessness = |psi: f64| restlessness(&table, instant, psi, balance_m);
            let misfit = spread.misfit(&table, instant, here[index]) + restlessness(here[index]);
            let mut choices = vec![Choice { psi: here[index], misfit }];
            if index == anchor {
                return choices;
            }
            for (psi, misfit) in candidates(&table, instant, spread, here[index]) {
                let misfit = misfit + restlessness(psi);
                if !same(psi, here[index]) {
                    choices.push(Choice { psi, misfit });
                } else if misfit + 1.0 < choices[0].misfit {
                    choices[0] = Choice { psi: here[index] + turn(here[index], psi), misfit };
                }
            }
            choices
        })
        .collect();
    if let Some(aside) = aside {
        place_anew(&mut choices, problem, &table, balance_m, aside);
    }
    let steps: Vec<Vec<f64>> = (1..problem.len())
        .into_par_iter()
        .map(|index| {
            let ahead = Ahead { shape: &shape, table: &table, instant: &problem.instants[index], hill_sd_m, still_m };
            let blind = aside.is_some_and(|aside| (aside.doubtful)(index));
            steps(&ahead, &problem.instants[index - 1], &choices[index - 1], &choices[index], blind)
        })
        .collect();
    let lattice = Lattice::new(&choices, &steps);
    let (way, cost) = lattice.best();
    let stay: f64 =
        choices.iter().map(|choices| choices[0].misfit).sum::<f64>() + steps.iter().map(|steps| steps[0]).sum::<f64>();
    let way = if cost + WORTH_CHANGING > stay { vec![0; choices.len()] } else { way };
    let along = |way: &[usize]| -> Vec<Choice> { way.iter().zip(&choices).map(|(&choice, all)| all[choice]).collect() };
    let chosen = along(&way);
    let psi: Vec<f64> = chosen.iter().map(|choice| choice.psi).collect();
    let elsewhere: Vec<(f64, usize)> = (0..psi.len()).map(|index| lattice.elsewhere(index, psi[index])).collect();
    let mut rivals: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
    for (index, &(other, choice)) in elsewhere.iter().enumerate().filter(|(_, (other, _))| *other < cost + CERTAIN) {
        let rival = lattice.through(index, choice);
        match rivals.iter().position(|(known, _)| *known == rival) {
            Some(known) => rivals[known].1.push(index),
            None if other.is_finite() && rivals.len() < MOST_RIVALS => rivals.push((rival, vec![index])),
            None => {}
        }
    }
    let leaps = |way: &[usize]| -> f64 {
        let poses = problem.instants.iter().zip(along(way));
        let restless = poses.map(|(instant, choice)| restlessness(&table, instant, choice.psi, balance_m)).sum::<f64>();
        restless + lattice.steps_along(way)
    };
    let of_way = leaps(&way);
    let rivals = rivals.into_iter().map(|(rival, samples)| Rival {
        psi: along(&rival).iter().map(|choice| choice.psi).collect(),
        samples,
        leaps: leaps(&rival) - of_way,
    });
    Track {
        rivals: rivals.collect(),
        psi,
        moved: way.iter().filter(|choice| **choice > 0).count(),
        margin: elsewhere.iter().map(|(other, _)| other - cost).collect(),
        misfit: chosen.iter().map(|choice| choice.misfit).collect(),
    }
}

/// Rivals that are looked up at the most.
const MOST_RIVALS: usize = 24;

/// Lets samples be wherever a shape that is known to within a Gaussian explains them.
fn place_anew(
    choices: &mut [Vec<Choice>],
    problem: &Problem,
    table: &Tabulated,
    balance_m: f64,
    Aside { samples, known, .. }: Aside,
) {
    let placed: Vec<Vec<Choice>> = samples
        .par_iter()
        .map(|&index| {
            let instant = &problem.instants[index];
            let surprise = |psi: f64| known.surprise(instant, psi);
            let misfit = |psi: f64| surprise(psi) + restlessness(table, instant, psi, balance_m);
            let mut placed: Vec<Choice> =
                choices[index].iter().map(|choice| Choice { misfit: misfit(choice.psi), ..*choice }).collect();
            for (psi, _) in minima(choices[index][0].psi, &surprise) {
                let misfit = misfit(psi);
                match placed.iter_mut().find(|choice| same(choice.psi, psi)) {
                    Some(choice) if choice.misfit > misfit => {
                        *choice = Choice { psi: choice.psi + turn(choice.psi, psi), misfit };
                    }
                    Some(_) => {}
                    None => placed.push(Choice { psi, misfit }),
                }
            }
            placed
        })
        .collect();
    for (&index, placed) in samples.iter().zip(placed) {
        choices[index] = placed;
    }
}

/// What it costs to be at a pose that is no minimum of the potential energy: such a sample is not explained.
const RESTLESS: f64 = 20.0;

fn restlessness(table: &Tabulated, instant: &Instant, psi: f64, balance_m: f64) -> f64 {
    if table.residuals(instant, psi).is_restless(balance_m) { RESTLESS } else { 0.0 }
}

/// A sample missed by this many squared standard deviations is not explained.
const UNEXPLAINED: f64 = 16.0;

/// How far off contacts and balance usually are. Half of the samples at least are placed well; they tell it whatever the
/// others do.
fn spread(problem: &Problem, table: &Tabulated, psi: &[f64], floor_m: f64) -> Spread {
    let both_seen = || problem.instants.iter().zip(psi).filter(|(instant, _)| instant.both_seen());
    let (mut contacts, balance): (Vec<f64>, Vec<f64>) = both_seen()
        .map(|(instant, psi)| {
            let [one, two, balance] = table.residuals(instant, *psi).value;
            ((instant.weight1 * one).powi(2) + (instant.weight2 * two).powi(2), balance)
        })
        .unzip();
    // The median of χ² with two degrees of freedom is 1.386, with one 0.455.
    let contact_m2 = (median(&mut contacts) / 1.386).max(floor_m * floor_m);
    let squares = median(&mut balance.iter().map(|balance| balance * balance).collect::<Vec<f64>>());
    let balance_m2 = (squares / 0.455).max(0.01 * floor_m * floor_m);
    // Bursts say nothing of how long friction pulls one way.
    let most = 3.0 * balance_m2.sqrt();
    let clipped: Vec<f64> = balance.iter().map(|balance| balance.clamp(-most, most)).collect();
    Spread { contact_m2, balance_m2, balance_memory: correlation_time(&clipped) }
}

/// The middle of the longest run of samples without a leap: what all else is placed against.
fn anchor(psi: &[f64]) -> usize {
    let mut edges = vec![0];
    edges.extend((1..psi.len()).filter(|&index| !near(psi[index - 1], psi[index])));
    edges.push(psi.len());
    let longest = edges.windows(2).max_by_key(|edge| edge[1] - edge[0]);
    longest.map_or(0, |edge| (edge[0] + edge[1]) / 2)
}

/// The way from one angle to another, radians, at most half a turn.
fn turn(from: f64, to: f64) -> f64 {
    wrapped(to - from)
}

/// Whether a step from one to the other needs no reason.
pub(super) fn near(a: f64, b: f64) -> bool {
    turn(a, b).abs() < LONGEST_STEP
}

fn same(a: f64, b: f64) -> bool {
    turn(a, b).abs() < SAME
}

/// The sample that a step leads to.
struct Ahead<'a> {
    shape: &'a SupportFunction,
    table: &'a Tabulated,
    instant: &'a Instant,
    hill_sd_m: f64,
    /// Contacts that move by less did not leap, metres; 0 where that is not asked.
    still_m: f64,
}

/// The cost of each step from one sample's choices (outer) to those of the next (inner). `blind` asks nothing of statics.
fn steps(ahead: &Ahead, before: &Instant, from: &[Choice], to: &[Choice], blind: bool) -> Vec<f64> {
    let mut costs = Vec::with_capacity(from.len() * to.len());
    let still = ahead.still_since(before);
    for start in from {
        // Where the object would go from here: looked up only when a choice lies elsewhere.
        let mut foretold = None;
        for end in to {
            costs.push(if near(start.psi, end.psi) {
                0.0
            } else if blind {
                FALL + HALF_TURN * turn(start.psi, end.psi).abs() / PI
            } else {
                let rest = *foretold.get_or_insert_with(|| ahead.rest(before, start.psi));
                if same(rest, end.psi) {
                    FALL
                } else {
                    let hill = ahead.hill_m(start.psi, end.psi) / ahead.hill_sd_m;
                    let unforeseen = LEAP + HALF_TURN * turn(start.psi, end.psi).abs() / PI;
                    (FALL + hill * hill).min(if still { MIRACLE } else { unforeseen })
                }
            });
        }
    }
    costs
}

impl Ahead<'_> {
    /// Where an object that was at `psi` comes to rest.
    fn rest(&self, before: &Instant, psi: f64) -> f64 {
        if self.instant.palms.sin2 <= 0.0 || before.palms.sin2 <= 0.0 {
            return psi;
        }
        let [from, to] = [before, self.instant].map(|instant| PalmPair::hinged(instant.phi1, instant.phi2));
        if let Some(rest) = EnergyLandscape::new(self.shape, &to).continued(psi) {
            return rest;
        }
        followed(self.shape, &from, &to, psi).0
    }

    /// Whether both contacts were seen and neither leapt.
    fn still_since(&self, before: &Instant) -> bool {
        let moved = (self.instant.s1 - before.s1).abs().max((self.instant.s2 - before.s2).abs());
        before.both_seen() && self.instant.both_seen() && moved < self.still_m
    }

    /// How far the centre of mass would have to rise on the way from one orientation to another, metres.
    fn hill_m(&self, from: f64, to: f64) -> f64 {
        const STEPS: usize = 32;
        let way = turn(from, to);
        let height = |psi: f64| self.table.height_m(self.instant, psi);
        let highest = (1..=STEPS).map(|step| height(from + way * step as f64 / STEPS as f64)).fold(0.0, f64::max);
        (highest - height(from)).max(0.0)
    }
}

/// All ways through the choices: what each choice costs together with the cheapest way up to it, and with the cheapest way on.
struct Lattice<'a> {
    choices: &'a [Vec<Choice>],
    steps: &'a [Vec<f64>],
    /// Cost up to and with each choice, and the choice before it on the way there.
    until: Vec<Vec<(usize, f64)>>,
    /// Cost after each choice, and the choice behind it.
    after: Vec<Vec<(usize, f64)>>,
}

impl<'a> Lattice<'a> {
    fn new(choices: &'a [Vec<Choice>], steps: &'a [Vec<f64>]) -> Self {
        let least = |costs: &mut dyn Iterator<Item = f64>| {
            costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
        };
        let mut until: Vec<Vec<(usize, f64)>> = Vec::with_capacity(choices.len());
        for (index, here) in choices.iter().enumerate() {
            let reached = here.iter().enumerate().map(|(end, choice)| {
                let Some(before) = index.checked_sub(1) else { return (0, choice.misfit) };
                let step = |start: usize| steps[before][start * here.len() + end];
                let ways = until[before].iter().enumerate();
                let (from, cost) = least(&mut ways.map(|(start, (_, cost))| cost + step(start)));
                (from, cost + choice.misfit)
            });
            let reached = reached.collect();
            until.push(reached);
        }
        let mut after: Vec<Vec<(usize, f64)>> = choices.iter().map(|here| vec![(0, 0.0); here.len()]).collect();
        for index in (1..choices.len()).rev() {
            let here = &choices[index];
            for start in 0..choices[index - 1].len() {
                let step = |end: usize| steps[index - 1][start * here.len() + end];
                let ways = here.iter().enumerate();
                after[index - 1][start] =
                    least(&mut ways.map(|(end, choice)| step(end) + choice.misfit + after[index][end].1));
            }
        }
        Self { choices, steps, until, after }
    }

    /// The cheapest way, and its cost.
    fn best(&self) -> (Vec<usize>, f64) {
        let last = self.until.last().map_or(&[][..], |last| last);
        let end = last.iter().enumerate().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        end.map_or((Vec::new(), 0.0), |(choice, (_, cost))| (self.through(self.until.len() - 1, choice), *cost))
    }

    /// What the cheapest way costs that puts a sample elsewhere than near `psi`, and the choice that it goes through.
    fn elsewhere(&self, index: usize, psi: f64) -> (f64, usize) {
        let others = self.choices[index].iter().enumerate().filter(|(_, choice)| !near(choice.psi, psi));
        others
            .map(|(choice, _)| (self.until[index][choice].1 + self.after[index][choice].1, choice))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, 0))
    }

    /// The cheapest way through a choice.
    fn through(&self, index: usize, choice: usize) -> Vec<usize> {
        let mut way = vec![choice; self.choices.len()];
        for before in (0..index).rev() {
            way[before] = self.until[before + 1][way[before + 1]].0;
        }
        for behind in index + 1..way.len() {
            way[behind] = self.after[behind - 1][way[behind - 1]].0;
        }
        way
    }

    /// What the steps of a way cost together.
    fn steps_along(&self, way: &[usize]) -> f64 {
        let steps = self.steps.iter().zip(self.choices.iter().skip(1)).zip(way.windows(2));
        steps.map(|((steps, to), step)| steps[step[0] * to.len() + step[1]]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two poses explain each sample about equally well; the noise prefers now one, now the other.
    fn undecided() -> (Vec<Vec<Choice>>, Vec<Vec<f64>>) {
        let choices: Vec<Vec<Choice>> = (0..8)
            .map(|i| {
                let (one, two) = if i % 2 == 0 { (3.0, 1.0) } else { (1.0, 3.0) };
                vec![Choice { psi: 0.0, misfit: one }, Choice { psi: 1.0, misfit: two }]
            })
            .collect();
        (choices, vec![vec![0.0, LEAP, LEAP, 0.0]; 7])
    }

    #[test]
    fn the_cheapest_way_leaps_never_where_each_sample_alone_would_leap_often() {
        let (mut choices, steps) = undecided();
        choices[0][1].misfit += 2.0;
        let lattice = Lattice::new(&choices, &steps);
        let (way, cost) = lattice.best();
        assert_eq!(way, [0; 8]);
        assert!((cost - 16.0).abs() < 1e-12);
        // The other pose all the way costs two more.
        for index in 0..8 {
            let (other, choice) = lattice.elsewhere(index, 0.0);
            assert!((other - cost - 2.0).abs() < 1e-12, "{other}");
            assert_eq!(lattice.through(index, choice), [1; 8]);
        }
        assert_eq!(lattice.steps_along(&[0, 1, 1, 0, 0, 0, 0, 0]), 2.0 * LEAP);
    }

    #[test]
    fn a_leap_is_taken_where_it_pays_and_its_neighbours_are_uncertain() {
        let (mut choices, steps) = undecided();
        choices[0].truncate(1);
        choices[7].remove(0);
        let steps: Vec<Vec<f64>> = steps
            .into_iter()
            .enumerate()
            .map(|(i, step)| match i {
                0 => step[..2].to_vec(),
                6 => vec![step[1], step[3]],
                _ => step,
            })
            .collect();
        // From sample 4 on the second pose explains all.
        choices[4..7].iter_mut().for_each(|choices| choices[0].misfit += 50.0);
        let lattice = Lattice::new(&choices, &steps);
        let (way, cost) = lattice.best();
        let orientations: Vec<f64> = way.iter().zip(&choices).map(|(&c, choices)| choices[c].psi).collect();
        assert_eq!(orientations[4..], [1.0; 4]);
        assert_eq!(orientations.windows(2).filter(|pair| pair[0] != pair[1]).count(), 1);
        let margin: Vec<f64> =
            orientations.iter().enumerate().map(|(index, psi)| lattice.elsewhere(index, *psi).0 - cost).collect();
        assert!(margin[0].is_infinite() && margin[7].is_infinite());
        assert!(margin[3] < 4.0 && margin[5] > 40.0, "{margin:?}");
    }
}
