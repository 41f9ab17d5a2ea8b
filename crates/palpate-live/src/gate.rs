//! What every source has to pass: values that a rig can have, and a time that increases.

use crate::losses::Losses;
use crate::rigs::RigSample;

/// A sample that is older than the newest by no more than this is late and left out; by more, the clock was set back. Networks and buses delay by
/// less than a second, and whoever sets a clock back by less loses as much.
const LONGEST_DELAY_S: f64 = 1.0;
/// Time between two samples across a step of the clock, where no two samples before tell it.
const USUAL_STEP_S: f64 = 0.01;

/// The order of time of what one source gives.
#[derive(Clone, Debug)]
struct Clock {
    /// Time of the newest sample as it was let through.
    newest_s: Option<f64>,
    /// Time between the two newest.
    step_s: f64,
    /// What is added to times since a clock was set back.
    offset_s: f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { newest_s: None, step_s: USUAL_STEP_S, offset_s: 0.0 }
    }
}

impl Clock {
    /// The time of the next sample as it enters the log, if it does; what befell it is counted.
    fn admit(&mut self, time_s: f64, losses: &mut Losses) -> Option<f64> {
        let mut time_s = time_s + self.offset_s;
        if let Some(newest_s) = self.newest_s {
            let behind_s = newest_s - time_s;
            if behind_s == 0.0 {
                losses.doubled += 1;
                return None;
            }
            if behind_s > 0.0 && behind_s <= LONGEST_DELAY_S {
                losses.late += 1;
                return None;
            }
            if behind_s > 0.0 {
                losses.clock_steps += 1;
                self.offset_s += behind_s + self.step_s;
                time_s = newest_s + self.step_s;
            }
            self.step_s = (time_s - newest_s).min(LONGEST_DELAY_S);
        }
        self.newest_s = Some(time_s);
        Some(time_s)
    }
}

/// Lets plausible samples through in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Gate<S: RigSample> {
    conventions: S::Conventions,
    clock: Clock,
    losses: Losses,
}

impl<S: RigSample> Gate<S> {
    pub(crate) fn new(conventions: S::Conventions) -> Self {
        Self { conventions, clock: Clock::default(), losses: Losses::default() }
    }

    pub(crate) fn losses(&self) -> Losses {
        self.losses
    }

    /// The sample as it enters the log, if it does.
    pub(crate) fn admit(&mut self, sample: S) -> Option<S> {
        if sample.is_implausible(&self.conventions) {
            self.losses.implausible += 1;
            return None;
        }
        let time_s = self.clock.admit(sample.time_s(), &mut self.losses)?;
        Some(sample.at(time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::Sample;
    use palpate::palms::PalmPair;
    use palpate_io::Conventions;

    fn at(time_s: f64) -> Sample {
        Sample::new(time_s, PalmPair::hinged(1.0, 1.2), 0.03, 0.03)
    }

    fn times(gate: &mut Gate<Sample>, times_s: &[f64]) -> Vec<f64> {
        times_s.iter().filter_map(|&time_s| gate.admit(at(time_s))).map(|sample| sample.time_s).collect()
    }

    #[test]
    fn late_and_doubled_samples_are_left_out_and_counted() {
        let mut gate = Gate::<Sample>::new(Conventions::default());
        assert_eq!(times(&mut gate, &[1.0, 2.0, 2.0, 1.5, 1.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(gate.losses(), Losses { doubled: 1, late: 2, ..Losses::default() });
    }

    #[test]
    fn a_clock_set_back_by_an_hour_costs_no_sample() {
        let mut gate = Gate::<Sample>::new(Conventions::default());
        let through = times(&mut gate, &[5000.0, 5000.25, 1400.5, 1400.75, 1401.0]);
        assert_eq!(through, [5000.0, 5000.25, 5000.5, 5000.75, 5001.0]);
        assert_eq!(gate.losses(), Losses { clock_steps: 1, ..Losses::default() });
        // Just within, and just beyond, what counts as late.
        assert_eq!(times(&mut gate, &[1400.0, 1399.875]).len(), 1);
        assert_eq!(gate.losses(), Losses { clock_steps: 2, late: 1, ..Losses::default() });
    }

    #[test]
    fn what_no_rig_has_is_left_out_by_the_conventions_of_the_rig() {
        let mut turned = at(1.0);
        turned.palms.phi2_rad *= -1.0;
        let mut gate = Gate::<Sample>::new(Conventions::default());
        assert_eq!(gate.admit(turned), None);
        assert_eq!(gate.admit(Sample { time_s: f64::NAN, ..at(0.0) }), None);
        assert_eq!(gate.admit(at(1.000_001e13)), None);
        assert_eq!(gate.losses().implausible, 3);
        assert!(gate.admit(at(1e13)).is_some());
        let clockwise = Conventions { angle_signs: [1.0, -1.0], ..Conventions::default() };
        assert_eq!(Gate::<Sample>::new(clockwise).admit(turned), Some(turned));
        assert_eq!(Gate::<Sample>::new(clockwise).admit(at(1.0)), None);
    }
}
