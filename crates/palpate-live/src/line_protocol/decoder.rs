//! Bytes from a board to samples, on a line that may be bad.
//!
//! One faulty line in 256 passes a check of eight bits by chance. On a line where most lines are faulty, those would be a noticeable part of what
//! passes. So a line counts only among its like: after a fault, lines are held back until [`LinePacket::CONFIRMED`] in a row pass, with times and places that
//! follow from one to the next. Then they all count. Once that is so, a good line counts at once.

use palpate::Sample;

use crate::line_protocol::LinePacket;
use crate::line_protocol::clock::{Clock, Step, step};
use crate::line_protocol::fields::LONGEST_LINE;
use crate::lines::{Line, Lines};
use crate::losses::Losses;
use crate::rigs::RigSample;

/// Takes bytes in, gives samples out.
#[derive(Clone, Debug)]
pub struct Decoder<S: RigSample = Sample> {
    lines: Lines,
    conventions: S::Conventions,
    clock: Clock,
    /// The line before, if it counts.
    before: Option<S::Packet>,
    /// Good lines since the last fault that do not count yet, with the time of this machine.
    held: Vec<(S::Packet, f64)>,
    losses: Losses,
}

impl<S: RigSample> Decoder<S> {
    /// A decoder of what a board sends; the conventions of its rig say which samples are plausible.
    pub fn new(conventions: S::Conventions) -> Self {
        Self {
            lines: Lines::new(LONGEST_LINE),
            conventions,
            clock: Clock::default(),
            before: None,
            held: Vec::with_capacity(S::Packet::CONFIRMED),
            losses: Losses::default(),
        }
    }

    /// Takes in bytes that arrived at `host_s`, in seconds of a clock of this machine that only runs forward, and appends the samples in them. Their
    /// times go on where the board's counter wraps or begins anew.
    pub fn push(&mut self, bytes: &[u8], host_s: f64, samples: &mut Vec<S>) {
        let mut lines = std::mem::replace(&mut self.lines, Lines::new(0));
        lines.push(bytes, |line| match line {
            Line::TooLong => {
                self.losses.too_long += 1;
                self.doubt();
            }
            Line::Whole(line) => match S::Packet::parse(line) {
                Ok(packet) => self.take(packet, host_s, samples),
                Err(_) => {
                    self.losses.faulty += 1;
                    self.doubt();
                }
            },
        });
        self.lines = lines;
    }

    /// The board was gone: what had begun is forgotten.
    pub fn interrupted(&mut self) {
        self.lines.clear();
        self.losses.gaps += 1;
        self.clock.interrupted();
        self.doubt();
    }

    /// What was lost so far; lines that are held back are not.
    pub fn losses(&self) -> Losses {
        Losses { clock_steps: self.clock.restarts, ..self.losses }
    }

    /// The next lines have to confirm each other.
    fn doubt(&mut self) {
        self.losses.unconfirmed += self.held.len() as u64;
        self.held.clear();
        self.before = None;
    }

    fn take(&mut self, packet: S::Packet, host_s: f64, samples: &mut Vec<S>) {
        if packet.sample(0.0).is_implausible(&self.conventions) {
            self.losses.implausible += 1;
            self.doubt();
            return;
        }
        if let Some(before) = self.before.or(self.held.last().map(|(before, _)| *before)) {
            match step(before.time_us(), packet.time_us()) {
                Step::Same => {
                    self.losses.doubled += 1;
                    return;
                }
                Step::Late => {
                    self.losses.late += 1;
                    return;
                }
                Step::Forward(step_s) if packet.can_follow(&before, step_s) => {}
                Step::Forward(_) | Step::Leap => self.doubt(),
            }
        }
        if self.before.is_some() {
            self.give(packet, host_s, samples);
            self.before = Some(packet);
            return;
        }
        self.held.push((packet, host_s));
        if self.held.len() == S::Packet::CONFIRMED {
            std::mem::take(&mut self.held).into_iter().for_each(|(packet, host_s)| self.give(packet, host_s, samples));
            self.before = Some(packet);
        }
    }

    /// A line that counts; one that was sent before the newest is late.
    fn give(&mut self, packet: S::Packet, host_s: f64, samples: &mut Vec<S>) {
        match self.clock.step(packet.time_us()) {
            Some(Step::Same) => self.losses.doubled += 1,
            Some(Step::Late) => self.losses.late += 1,
            Some(Step::Forward(_) | Step::Leap) | None => {
                samples.push(packet.sample(self.clock.advance(packet.time_us(), host_s)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_protocol::palms_packet::Packet;
    use palpate_io::Conventions;

    fn packet(index: u32) -> Packet {
        Packet {
            time_us: 10_000 * index,
            phi_urad: [1_000_000, 1_300_000],
            s_um: [Some(30_000 + index as i32), None],
            force_mn: [None; 2],
        }
    }

    fn decoder() -> Decoder {
        Decoder::new(Conventions::default())
    }

    const NONE: [i64; 0] = [];

    /// What comes of these lines, as the last digits of their positions.
    fn found(decoder: &mut Decoder, lines: &[String]) -> Vec<i64> {
        let mut samples = Vec::new();
        lines.iter().for_each(|line| decoder.push(line.as_bytes(), 0.0, &mut samples));
        samples.iter().filter_map(|sample| sample.s1_m).map(|s1_m| (1e6 * s1_m).round() as i64 - 30_000).collect()
    }

    fn good(indices: impl IntoIterator<Item = u32>) -> Vec<String> {
        indices.into_iter().map(|index| packet(index).to_line()).collect()
    }

    #[test]
    fn lines_count_from_the_third_in_a_row_on_and_none_of_them_is_lost() {
        let mut decoder = decoder();
        assert_eq!(found(&mut decoder, &good([1, 2])), NONE);
        assert_eq!(found(&mut decoder, &good([3])), [1, 2, 3]);
        assert_eq!(found(&mut decoder, &good([4])), [4]);
        assert_eq!(found(&mut decoder, &["rubbish\n".to_owned()]), NONE);
        assert_eq!(found(&mut decoder, &good([6, 7])), NONE);
        assert_eq!(found(&mut decoder, &good([8, 9])), [6, 7, 8, 9]);
        assert_eq!(decoder.losses(), Losses { faulty: 1, ..Losses::default() });
    }

    #[test]
    fn lines_alone_among_faulty_ones_do_not_count() {
        let mut decoder = decoder();
        found(&mut decoder, &good([1, 2, 3]));
        for index in 2..5 {
            assert_eq!(found(&mut decoder, &["*\n".to_owned()]), NONE);
            assert_eq!(found(&mut decoder, &good([2 * index, 2 * index + 1])), NONE);
        }
        assert_eq!(found(&mut decoder, &["*\n".to_owned()]), NONE);
        assert_eq!(decoder.losses(), Losses { faulty: 4, unconfirmed: 6, ..Losses::default() });
    }

    #[test]
    fn late_and_doubled_lines_are_left_out_at_no_cost_to_others() {
        let mut decoder = decoder();
        assert_eq!(found(&mut decoder, &good([1, 2, 3, 3, 5, 4, 6])), [1, 2, 3, 5, 6]);
        assert_eq!(decoder.losses(), Losses { doubled: 1, late: 1, ..Losses::default() });
        // Also where they are among those that confirm each other.
        assert_eq!(found(&mut decoder, &[vec!["*\n".to_owned()], good([5, 6, 7, 7, 8])].concat()), [7, 8]);
        assert_eq!(decoder.losses(), Losses { doubled: 3, late: 2, faulty: 1, ..Losses::default() });
    }

    #[test]
    fn palms_that_turn_too_fast_and_times_that_leap_are_doubted() {
        let fast = |index, phi1_urad| Packet { phi_urad: [phi1_urad, 1_300_000], ..packet(index) }.to_line();
        let mut decoder = decoder();
        found(&mut decoder, &good([1, 2, 3]));
        // In 10 ms half a radian and the error of a reading, and a little more than that.
        assert_eq!(found(&mut decoder, &[fast(4, 1_699_999)]), [4]);
        assert_eq!(found(&mut decoder, &[fast(5, 999_998)]), NONE);
        assert_eq!(found(&mut decoder, &good([6, 7])), [5, 6, 7]);
        assert_eq!(found(&mut decoder, &[fast(8, 1_000_000 + 6_283_185)]), [8], "a turn more");
        let leap = Packet { time_us: 3_000_000_000, ..packet(9) }.to_line();
        assert_eq!(found(&mut decoder, &[leap]), NONE);
        assert_eq!(found(&mut decoder, &good([10, 11, 12])), [10, 11, 12]);
        assert_eq!(decoder.losses(), Losses { unconfirmed: 1, ..Losses::default() });
    }

    #[test]
    fn a_board_that_was_unplugged_goes_on() {
        let mut decoder = decoder();
        found(&mut decoder, &good([100, 101, 102]));
        decoder.push(b"1234,", 0.0, &mut Vec::new());
        decoder.interrupted();
        let mut samples = Vec::new();
        good([1, 2, 3]).iter().for_each(|line| decoder.push(line.as_bytes(), 60.0, &mut samples));
        let times: Vec<f64> = samples.iter().map(|sample| sample.time_s).collect();
        assert_eq!(times, [61.02, 61.03, 61.04]);
        assert_eq!(decoder.losses(), Losses { gaps: 1, clock_steps: 1, ..Losses::default() });
    }

    #[test]
    fn implausible_and_overlong_lines_are_counted() {
        let mut decoder = decoder();
        found(&mut decoder, &good([1, 2, 3]));
        let parallel = Packet { phi_urad: [1_000_000, 0], ..packet(4) }.to_line();
        assert_eq!(found(&mut decoder, &[parallel, format!("{}\n", "1".repeat(97))]), NONE);
        assert_eq!(decoder.losses(), Losses { implausible: 1, too_long: 1, ..Losses::default() });
    }
}
