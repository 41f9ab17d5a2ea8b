//! Tactile readings, and where palms or pivot are, that come separately, each with its time: one sample for each instant of touch, with the place
//! interpolated.

use std::collections::VecDeque;
use std::marker::PhantomData;

use palpate::Sample;

use crate::losses::Losses;
use crate::rigs::RigSample;

/// Readings of a kind that are kept at most: several seconds of a fast sensor.
const MOST_KEPT: usize = 4096;
/// Readings of all pads, and places, are waited for until something this much later has come, seconds: a bus delivers within that time.
const SETTLED_AFTER_S: f64 = 0.05;
/// Something older than the newest by no more than this is late, seconds; by more, a clock was set back.
const LONGEST_DELAY_S: f64 = 1.0;

/// What belongs together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JoinOptions {
    /// Readings of the two pads closer in time than this are of one instant, seconds.
    pub(crate) together_s: f64,
    /// Places are interpolated over no longer than this, seconds.
    pub(crate) longest_gap_s: f64,
}

impl Default for JoinOptions {
    fn default() -> Self {
        Self { together_s: 0.002, longest_gap_s: 0.1 }
    }
}

/// One reading of a pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Touch {
    /// Position, metres; `None` without contact.
    Position(Option<f64>),
    /// Normal force, newtons.
    Force(f64),
}

/// Readings that belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joined {
    /// Time, seconds.
    pub time_s: f64,
    /// Where the rig was: φ₁ and φ₂ of palms in radians, X and Y of a pivot in metres.
    pub place: [f64; 2],
    /// Contact positions on its pads, metres.
    pub position_m: [Option<f64>; 2],
    /// Normal forces there, newtons.
    pub force_n: [Option<f64>; 2],
}

/// An instant of touch, until its place is known.
#[derive(Clone, Copy, Debug)]
struct Instant {
    time_s: f64,
    position_m: [Option<f64>; 2],
    force_n: [Option<f64>; 2],
}

/// Takes readings in, gives samples out.
#[derive(Clone, Debug)]
pub(crate) struct Join<S = Sample> {
    options: JoinOptions,
    /// Both coordinates of the place over time.
    places: [VecDeque<(f64, f64)>; 2],
    instants: VecDeque<Instant>,
    newest_s: f64,
    losses: Losses,
    of: PhantomData<S>,
}

impl<S: RigSample> Join<S> {
    pub(crate) fn new(options: JoinOptions) -> Self {
        Self {
            options,
            places: [VecDeque::new(), VecDeque::new()],
            instants: VecDeque::new(),
            newest_s: f64::NEG_INFINITY,
            losses: Losses::default(),
            of: PhantomData,
        }
    }

    pub(crate) fn losses(&self) -> Losses {
        self.losses
    }

    /// Takes in a coordinate (0 or 1) of the place.
    pub(crate) fn place(&mut self, coordinate: usize, time_s: f64, value: f64) {
        if !time_s.is_finite() || !value.is_finite() {
            self.losses.implausible += 1;
            return;
        }
        self.notice(time_s);
        let series = &mut self.places[coordinate];
        if series.back().is_some_and(|(newest_s, _)| time_s <= *newest_s) {
            self.losses.late += 1;
            return;
        }
        if series.len() == MOST_KEPT {
            series.pop_front();
        }
        series.push_back((time_s, value));
    }

    /// Takes in a reading of a pad (0 or 1).
    pub(crate) fn touch(&mut self, palm: usize, time_s: f64, touch: Touch) {
        if !time_s.is_finite() {
            self.losses.implausible += 1;
            return;
        }
        self.notice(time_s);
        let together_s = self.options.together_s;
        let place = self.instants.partition_point(|instant| instant.time_s <= time_s);
        let near =
            |index: usize| self.instants.get(index).is_some_and(|found| (found.time_s - time_s).abs() <= together_s);
        let index = if place > 0 && near(place - 1) {
            place - 1
        } else if near(place) {
            place
        } else {
            self.instants.insert(place, Instant { time_s, position_m: [None; 2], force_n: [None; 2] });
            place
        };
        if let Some(instant) = self.instants.get_mut(index) {
            match touch {
                Touch::Position(position_m) => instant.position_m[palm] = position_m.filter(|s_m| !s_m.is_nan()),
                Touch::Force(force_n) => instant.force_n[palm] = Some(force_n).filter(|force_n| !force_n.is_nan()),
            }
        }
        if self.instants.len() > MOST_KEPT {
            self.instants.pop_front();
            self.losses.without_angles += 1;
        }
    }

    /// Appends the samples that are complete.
    pub(crate) fn take(&mut self, samples: &mut VecDeque<S>) {
        while let Some(instant) = self.instants.front() {
            let place_known =
                self.places.iter().all(|series| series.back().is_some_and(|(at_s, _)| *at_s >= instant.time_s));
            let is_settled = self.newest_s > instant.time_s + SETTLED_AFTER_S;
            let given_up = self.newest_s > instant.time_s + SETTLED_AFTER_S.max(self.options.longest_gap_s);
            if !(is_settled && (place_known || given_up)) {
                return;
            }
            self.complete(samples);
        }
    }

    /// Appends what is left at the end.
    pub(crate) fn finish(&mut self, samples: &mut VecDeque<S>) {
        while !self.instants.is_empty() {
            self.complete(samples);
        }
    }

    /// The oldest instant becomes a sample, if there is a place for it.
    fn complete(&mut self, samples: &mut VecDeque<S>) {
        let Some(instant) = self.instants.pop_front() else { return };
        let longest_gap_s = self.options.longest_gap_s;
        let place = self.places.each_mut().map(|series| interpolated::<S>(series, instant.time_s, longest_gap_s));
        let [Some(first), Some(second)] = place else {
            self.losses.without_angles += 1;
            return;
        };
        let Instant { time_s, position_m, force_n } = instant;
        samples.push_back(S::of_joined(&Joined { time_s, place: [first, second], position_m, force_n }));
    }

    fn notice(&mut self, time_s: f64) {
        if time_s < self.newest_s - LONGEST_DELAY_S {
            self.losses.clock_steps += 1;
            self.forget();
        }
        self.newest_s = self.newest_s.max(time_s);
    }

    fn forget(&mut self) {
        self.losses.without_angles += self.instants.len() as u64;
        self.instants.clear();
        self.places.iter_mut().for_each(VecDeque::clear);
        self.newest_s = f64::NEG_INFINITY;
    }
}

/// A coordinate of the place at an instant, where it lies between two that are close enough. What no later instant needs is forgotten.
fn interpolated<S: RigSample>(series: &mut VecDeque<(f64, f64)>, time_s: f64, longest_gap_s: f64) -> Option<f64> {
    while series.get(1).is_some_and(|(next_s, _)| *next_s <= time_s) {
        series.pop_front();
    }
    let &(before_s, before) = series.front()?;
    if before_s == time_s {
        return Some(before);
    }
    let &(after_s, after) = series.get(1)?;
    if before_s > time_s || after_s - before_s > longest_gap_s {
        return None;
    }
    Some(S::between(before, after, (time_s - before_s) / (after_s - before_s)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn samples(join: &mut Join) -> Vec<Sample> {
        let mut samples = VecDeque::new();
        join.take(&mut samples);
        samples.into()
    }

    #[test]
    fn angles_are_interpolated_at_the_instants_of_touch() {
        let mut join = Join::<Sample>::new(JoinOptions::default());
        for step in 0..8 {
            let time_s = 0.05 * f64::from(step);
            join.place(0, time_s, 1.0 + time_s);
            join.place(1, time_s, 2.0 - time_s);
        }
        join.touch(0, 0.110, Touch::Position(Some(0.03)));
        join.touch(1, 0.111, Touch::Position(Some(0.04)));
        join.touch(1, 0.111, Touch::Force(2.0));
        join.touch(0, 0.2, Touch::Position(None));
        join.touch(1, 0.2, Touch::Position(Some(f64::NAN)));
        let found = samples(&mut join);
        assert_eq!(found.len(), 2);
        assert!((found[0].palms.phi1_rad - 1.11).abs() < 1e-12 && (found[0].palms.phi2_rad - 1.89).abs() < 1e-12);
        assert_eq!((found[0].time_s, found[0].s1_m, found[0].s2_m), (0.110, Some(0.03), Some(0.04)));
        assert_eq!((found[0].force1_n, found[0].force2_n), (None, Some(2.0)));
        assert_eq!((found[1].s1_m, found[1].s2_m), (None, None));
        assert!(join.losses().is_none());
    }

    #[test]
    fn the_other_pad_and_later_angles_are_waited_for() {
        let mut join = Join::<Sample>::new(JoinOptions::default());
        for palm in [0, 1] {
            join.place(palm, 0.0, 1.0);
        }
        join.touch(0, 0.01, Touch::Position(Some(0.03)));
        assert_eq!(samples(&mut join), []);
        join.place(0, 0.05, 1.0);
        assert_eq!(samples(&mut join), []);
        join.touch(1, 0.0119, Touch::Position(Some(0.04)));
        join.place(1, 0.0601, 1.0);
        let found = samples(&mut join);
        assert_eq!((found.len(), found[0].s2_m), (1, Some(0.04)));
    }

    #[test]
    fn readings_without_angles_are_counted_and_angles_are_not_interpolated_over_gaps() {
        let mut join = Join::<Sample>::new(JoinOptions::default());
        join.touch(0, 0.0, Touch::Position(Some(0.03)));
        for time_s in [0.01, 0.11, 0.22] {
            join.place(0, time_s, 1.0);
            join.place(1, time_s, 1.0);
        }
        join.touch(0, 0.05, Touch::Position(Some(0.03)));
        join.touch(0, 0.15, Touch::Position(Some(0.03)));
        let mut found = VecDeque::new();
        join.finish(&mut found);
        assert_eq!(found.iter().map(|sample| sample.time_s).collect::<Vec<_>>(), [0.05]);
        assert_eq!(join.losses(), Losses { without_angles: 2, ..Losses::default() });
    }

    #[test]
    fn angles_are_interpolated_the_shorter_way_round() {
        let mut series = VecDeque::from([(0.0, 3.0), (0.1, 3.0 - TAU + 0.2)]);
        let found = interpolated::<Sample>(&mut series, 0.05, 0.1).expect("an angle");
        assert!((found - 3.1).abs() < 1e-12, "{found}");
    }

    #[test]
    fn memory_is_bounded_and_a_clock_that_is_set_back_is_no_end() {
        let mut join = Join::<Sample>::new(JoinOptions::default());
        for index in 0..MOST_KEPT + 10 {
            join.touch(0, index as f64, Touch::Position(None));
            join.place(0, index as f64, 1.0);
        }
        assert_eq!((join.instants.len(), join.places[0].len()), (MOST_KEPT, MOST_KEPT));
        join.place(0, 10.0, 1.0);
        assert_eq!((join.instants.len(), join.places[0].len(), join.losses().clock_steps), (0, 1, 1));
        join.place(0, f64::NAN, 1.0);
        join.touch(0, f64::INFINITY, Touch::Force(1.0));
        assert_eq!(join.losses().implausible, 2);
    }
}
