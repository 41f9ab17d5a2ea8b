//! Time of a board that counts microseconds modulo 2³², and begins anew when it loses its power.

/// A board silent for longer than this may have begun to count anew, microseconds: 10 s. Far more than a sample takes, far less than the 71 minutes
/// of the counter.
pub(crate) const LONGEST_SILENCE_US: u32 = 10_000_000;
/// A sample that is older than the newest by no more than this is late, microseconds: 1 s, as for other sources.
const LONGEST_DELAY_US: u32 = 1_000_000;
/// The counter and the clock of this machine agree on a silence if they differ by less than this, seconds, and a hundredth of it: lines may have
/// waited on their way.
const SAME_SILENCE_S: f64 = 1.0;
/// Time given to a sample after the board began anew, where this machine's clock has not moved, seconds.
const SHORTEST_STEP_S: f64 = 1e-3;

/// How a time relates to the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// Later by so many seconds.
    Forward(f64),
    /// The same.
    Same,
    /// Earlier by a little.
    Late,
    /// Much earlier or much later.
    Leap,
}

/// From one time of the counter to another.
pub(crate) fn step(from_us: u32, to_us: u32) -> Step {
    let (forward_us, back_us) = (to_us.wrapping_sub(from_us), from_us.wrapping_sub(to_us));
    if forward_us == 0 {
        Step::Same
    } else if forward_us <= LONGEST_SILENCE_US {
        Step::Forward(f64::from(forward_us) / 1e6)
    } else if back_us <= LONGEST_DELAY_US {
        Step::Late
    } else {
        Step::Leap
    }
}

/// Time in seconds that goes on where the counter wraps or begins anew.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Clock {
    /// Counter, time of this machine and time given to the newest sample.
    newest: Option<Reading>,
    /// How often the counter began anew.
    pub(crate) restarts: u64,
    /// The board was gone since the newest sample: nothing is late that comes now.
    interrupted: bool,
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    counter_us: u32,
    host_s: f64,
    /// Whole microseconds, so that a long recording gathers no rounding.
    time_us: u64,
}

impl Clock {
    /// Takes in that the board was gone.
    pub(crate) fn interrupted(&mut self) {
        self.interrupted = true;
    }

    /// How a counter relates to the newest; `None` at the beginning.
    pub(crate) fn step(&self, counter_us: u32) -> Option<Step> {
        self.newest.map(|newest| match step(newest.counter_us, counter_us) {
            Step::Same | Step::Late if self.interrupted => Step::Leap,
            step => step,
        })
    }

    /// Seconds of a counter that is neither the same nor late; `host_s` is the time of this machine, on a clock that only runs forward.
    pub(crate) fn advance(&mut self, counter_us: u32, host_s: f64) -> f64 {
        let time_us = match self.newest {
            None => u64::from(counter_us),
            Some(newest) => {
                let forward_us = counter_us.wrapping_sub(newest.counter_us);
                let forward_s = f64::from(forward_us) / 1e6;
                let silence_s = (host_s - newest.host_s).max(SHORTEST_STEP_S);
                let agree = (forward_s - silence_s).abs() <= SAME_SILENCE_S + 0.01 * silence_s;
                if forward_us > 0 && (forward_us <= LONGEST_SILENCE_US || agree) {
                    newest.time_us + u64::from(forward_us)
                } else {
                    self.restarts += 1;
                    newest.time_us + (1e6 * silence_s) as u64
                }
            }
        };
        self.interrupted = false;
        self.newest = Some(Reading { counter_us, host_s, time_us });
        time_us as f64 / 1e6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on_where_the_counter_wraps() {
        let mut clock = Clock::default();
        let times = [4_294_000_000, 4_294_960_000, 2_704, 20_000].map(|counter_us| clock.advance(counter_us, 0.0));
        assert_eq!(times, [4294.0, 4294.96, 4294.97, 4_294.987_296]);
        assert_eq!(clock.restarts, 0);
    }

    #[test]
    fn a_board_that_begins_anew_goes_on_by_the_clock_of_this_machine() {
        let mut clock = Clock::default();
        clock.advance(500_000_000, 100.0);
        assert_eq!(clock.advance(1_000, 104.5), 504.5);
        assert_eq!((clock.advance(11_000, 104.5), clock.restarts), (504.51, 1));
        // A board that was only silent, for longer than is usual.
        assert_eq!((clock.advance(30_011_000, 134.6), clock.restarts), (534.51, 1));
        // Silent for as long as the limit, and longer than this machine knows of.
        assert_eq!((clock.advance(40_011_000, 134.6), clock.restarts), (544.51, 1));
        assert_eq!((clock.advance(50_011_001, 135.6), clock.restarts), (545.51, 2));
    }

    #[test]
    fn nothing_is_late_after_an_interruption() {
        let mut clock = Clock::default();
        clock.advance(500_000, 0.0);
        assert_eq!(clock.step(20_000), Some(Step::Late));
        clock.interrupted();
        assert_eq!(clock.step(20_000), Some(Step::Leap));
        assert_eq!((clock.advance(20_000, 0.25), clock.restarts), (0.75, 1));
        assert_eq!(clock.step(10_000), Some(Step::Late));
        clock.interrupted();
        assert_eq!((clock.step(20_000), clock.advance(20_000, 0.5), clock.restarts), (Some(Step::Leap), 1.0, 2));
    }

    #[test]
    fn steps_are_told_apart_across_the_wrap() {
        assert_eq!(step(4_294_967_295, 0), Step::Forward(1e-6));
        assert_eq!((step(5, 5), step(0, 4_294_967_295)), (Step::Same, Step::Late));
        assert_eq!(step(0, LONGEST_SILENCE_US), Step::Forward(10.0));
        assert_eq!(step(0, LONGEST_SILENCE_US + 1), Step::Leap);
        assert_eq!(step(LONGEST_DELAY_US, 0), Step::Late);
        assert_eq!(step(LONGEST_DELAY_US + 1, 0), Step::Leap);
    }
}
