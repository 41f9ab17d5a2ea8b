//! Following a window from the placed one beside it (`docs/theory.md`, the search): height and orientation carry over, and the closed forms give the
//! motion. Where contacts run over flat sides and stay at corners, these lead astray over a whole window; a few instants at a time, with what those before
//! told of the shape, they do not.

use super::{BeamSearch, EXPLAINED, PLACING, misfit};
use crate::estimate::closed_form::{integrate, relative_height};
use crate::estimate::friction::rolling::rolling_motion;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::contacts;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother};
use crate::estimate::solver::posterior::Posterior;
use crate::reconstruct::search::windows::Window;
use rayon::prelude::*;

/// Instants of a placed window that are followed again with the window beside it, so that the rotation carries over.
const OVERLAP: usize = 6;

/// Instants of one step, where a window is followed in steps; fewer where so many are not explained.
const STEPS: [usize; 2] = [6, 2];

/// Standard deviations of the change of the rotation from one step to the next that are tried when a window is followed, radians:
/// from an even motion to one that passes a singularity of eq. 21.
const RATE_SDS: [f64; 3] = [0.003, 0.01, 0.04];

/// Instants in order of time, and their orientations.
type Near<'a> = (&'a [Instant], &'a [f64]);

/// A hypothesis carried on to a window.
pub(super) struct Followed {
    /// The posterior of the shape given the placed windows.
    pub belief: Posterior,
    /// Where the window may be; none where it is joined to no placed one.
    pub placements: Vec<Estimate>,
    /// Whether the last of them explains it.
    pub explained: bool,
    /// How many of its instants are explained one step after the other, where they are not as a whole.
    pub reached: Option<usize>,
}

/// Where instants lie that are placed from others.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
}

impl Side {
    /// What was there, in order of time, with what lies on this side of it.
    fn joined<T: Copy>(self, mut there: Vec<T>, more: &[T]) -> Vec<T> {
        let at = match self {
            Self::Before => 0,
            Self::After => there.len(),
        };
        there.splice(at..at, more.iter().copied());
        there
    }

    /// Of what lies on this side, the next after so many that are nearer, `most` of them.
    fn next<T>(self, there: &[T], nearer: usize, most: usize) -> &[T] {
        match self {
            Self::Before => &there[(there.len() - nearer).saturating_sub(most)..there.len() - nearer],
            Self::After => &there[nearer..(nearer + most).min(there.len())],
        }
    }
}

impl BeamSearch<'_> {
    /// Each hypothesis carried on to a window, from the placed one that it is joined to, if any; `None` where the placed windows tell no shape.
    pub(super) fn followed(&self, window: usize, neighbour: Option<usize>) -> Vec<Option<Followed>> {
        let carried = |hypothesis: &Estimate| {
            let belief = self.belief(&self.thin, hypothesis)?;
            let mut followed = Followed { belief, placements: Vec::new(), explained: false, reached: None };
            if let Some((near, side)) = neighbour.and_then(|other| self.beside(window, other, hypothesis)) {
                self.follow(&self.windows[window].thin, near, side, hypothesis, &mut followed);
            }
            Some(followed)
        };
        self.beam.par_iter().map(|hypothesis| carried(&hypothesis.estimate)).collect()
    }

    /// Cuts a window at the end of so many instants that follow from the placed one beside it: the numbers of the near part and of the placed one.
    pub(super) fn cut(&mut self, window: usize, neighbour: usize, reached: usize) -> Option<(usize, usize)> {
        let target = &self.windows[window];
        let count = target.thin.len();
        if reached == count {
            return None;
        }
        let after = window > neighbour;
        let [first, second] = target.cut(&self.measurements, if after { reached } else { count - reached });
        let (near, far) = if after { (first?, second) } else { (second?, first) };
        let parts: Vec<Window> =
            if after { [Some(near), far] } else { [far, Some(near)] }.into_iter().flatten().collect();
        let more = parts.len() - 1;
        self.offset.splice(window..=window, parts.iter().map(|_| None));
        self.deferred.splice(window..=window, parts.iter().map(|_| false));
        self.windows.splice(window..=window, parts);
        Some(if after { (window, neighbour) } else { (window + more, neighbour + more) })
    }

    /// The posterior of the shape given some placed instants.
    pub(super) fn belief(&self, placed: &Measurements, hypothesis: &Estimate) -> Option<Posterior> {
        Smoother::new(placed, self.order, self.tolerance.loose(), self.prior).belief(hypothesis)
    }

    /// The instants of a placed window with their orientations, and on which side of them a window lies.
    fn beside<'b>(&'b self, window: usize, placed: usize, hypothesis: &'b Estimate) -> Option<(Near<'b>, Side)> {
        let offset = self.offset[placed]?;
        let instants = &self.windows[placed].thin.instants;
        let side = if window > placed { Side::After } else { Side::Before };
        Some(((instants, &hypothesis.psi[offset..offset + instants.len()]), side))
    }

    /// Adds the window as a whole, and where that is not explained in steps.
    fn follow(&self, target: &Measurements, near: Near, side: Side, hypothesis: &Estimate, followed: &mut Followed) {
        let sharp = self.tolerance.sharp();
        let is_explained = |estimate: &Estimate| misfit(target, estimate, sharp) < EXPLAINED * target.len() as f64;
        let whole = self.carried_on(near, target, side, &hypothesis.coefficients, &followed.belief);
        followed.explained = whole.as_ref().is_some_and(is_explained);
        followed.placements.extend(whole);
        if followed.explained {
            return;
        }
        let Some(stepped) = self.carried_on_in_steps(near, target, side, hypothesis, &followed.belief) else { return };
        followed.reached = Some(stepped.psi.len());
        if stepped.psi.len() == target.len() {
            followed.explained = is_explained(&stepped);
            followed.placements.push(stepped);
        }
    }

    /// The motion over as many instants as are explained one step after the other; `None` where none are.
    fn carried_on_in_steps(
        &self,
        near: Near,
        target: &Measurements,
        side: Side,
        hypothesis: &Estimate,
        belief: &Posterior,
    ) -> Option<Estimate> {
        let mut near = (near.0.to_vec(), near.1.to_vec());
        let (mut placed, mut estimate) = (self.thin.clone(), hypothesis.clone());
        let mut psi: Vec<f64> = Vec::new();
        let mut updated: Option<Posterior> = None;
        let loose = self.tolerance.loose();
        while psi.len() < target.len() {
            if !psi.is_empty() {
                updated = self.belief(&placed, &estimate);
                if updated.is_none() {
                    break;
                }
            }
            let belief = updated.as_ref().unwrap_or(belief);
            let step = |most: usize| {
                let instants = self.measurements.of(side.next(&target.instants, psi.len(), most).to_vec());
                let carried = self.carried_on((&near.0, &near.1), &instants, side, &estimate.coefficients, belief)?;
                let is_explained = misfit(&instants, &carried, loose) <= EXPLAINED * instants.len() as f64;
                is_explained.then_some((instants, carried))
            };
            let Some((instants, carried)) = STEPS.into_iter().find_map(step) else { break };
            placed.instants.extend(&instants.instants);
            estimate.coefficients = carried.coefficients;
            estimate.psi.extend(&carried.psi);
            psi = side.joined(psi, &carried.psi);
            near = (side.joined(near.0, &instants.instants), side.joined(near.1, &carried.psi));
        }
        (!psi.is_empty()).then_some(Estimate { coefficients: estimate.coefficients, psi, cost: 0.0 })
    }

    /// The motion over `target` that goes on from the instants beside it, which lie before or after it in time.
    fn carried_on(
        &self,
        (beside, psi): Near,
        target: &Measurements,
        side: Side,
        coefficients: &[f64],
        belief: &Posterior,
    ) -> Option<Estimate> {
        let overlap = OVERLAP.min(beside.len());
        let (run, anchor, placed, keep) = match side {
            Side::After => {
                let mut run = beside[beside.len() - overlap..].to_vec();
                run.extend(&target.instants);
                (run, overlap.checked_sub(1)?, beside.len() - 1, overlap..overlap + target.len())
            }
            Side::Before => {
                let mut run = target.instants.clone();
                run.extend(&beside[..overlap]);
                (run, target.len(), 0, 0..target.len())
            }
        };
        let run = self.measurements.of(run);
        let relative = relative_height(&run);
        let at = run.instants.get(anchor)?;
        let [_, height] = at.palms.center(contacts(at, coefficients, psi[placed]).r);
        let h0 = height - relative[anchor];
        let noise = self.tolerance.loose();
        let smoother = Smoother::with_belief(target, self.order, noise, self.prior, belief);
        let balanced = RATE_SDS.map(|rate_sd| integrate(&run, &relative, h0, noise.sensor_m, rate_sd).psi);
        let rolling = self.tolerance.is_of_contact_alone().then(|| [0, 1].map(|palm| rolling_motion(&run, palm)));
        balanced
            .into_iter()
            .chain(rolling.into_iter().flatten())
            .map(|path| {
                let turn = psi[placed] - path[anchor];
                let psi = path[keep.clone()].iter().map(|psi| psi + turn).collect();
                smoother.run(coefficients.to_vec(), psi, PLACING)
            })
            .filter(|estimate| estimate.cost.is_finite())
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}
