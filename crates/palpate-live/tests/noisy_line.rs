//! A serial line on which bytes change on their way: how many wrong samples get through, and how soon good ones do again.

use palpate::Sample;
use palpate::palms::PalmPair;
use palpate::pivot::PivotSample;
use palpate_io::Conventions;
use palpate_live::RigSample;
use palpate_live::protocol::{Decoder, Packet, StrokesPacket};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Between two samples, microseconds.
const STEP_US: u32 = 10_000;

/// A sample of a rig that moves, so that no two are alike.
fn packet(index: u32) -> Packet {
    let time_s = f64::from(index) * 0.01;
    let palms = PalmPair::hinged(1.0 + 0.4 * (0.31 * time_s).sin(), 1.3 + 0.3 * (0.47 * time_s).cos());
    let [s1_m, s2_m] = [0.4, 0.6].map(|rate| 0.03 + 0.01 * (rate * time_s).sin());
    let force1_n = Some(1.0 + 0.5 * time_s.cos());
    Packet::of_sample(&Sample { force1_n, force2_n: Some(1.25), ..Sample::new(time_s, palms, s1_m, s2_m) })
}

/// The same of an arm that drags an object to and fro.
fn strokes_packet(index: u32) -> StrokesPacket {
    let time_s = f64::from(index) * 0.01;
    let [pivot_x_m, s_m] = [0.4, 0.6].map(|rate| 0.5 + 0.1 * (rate * time_s).sin());
    let pivot_y_m = 0.03 + 0.01 * (1.3 * time_s).cos();
    StrokesPacket::of_sample(&PivotSample { time_s, pivot_x_m, pivot_y_m, s_m: Some(s_m) })
}

/// What happens to a byte.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// One of its bits changes.
    Bit,
    /// It becomes any other.
    Byte,
    /// It becomes another digit: nothing but the check notices.
    Digit,
}

#[derive(Debug, Default, PartialEq, Eq)]
struct Outcome {
    right: usize,
    wrong: usize,
}

/// Sends so many lines of palms, each byte changed with this probability.
fn send(lines: u32, probability: f64, change: Change, seed: u64) -> Outcome {
    let is_right = |sample: &Sample| {
        let found = Packet::of_sample(sample);
        found == packet(found.time_us / STEP_US)
    };
    send_of(|index| packet(index).to_line(), is_right, (lines, probability), change, seed)
}

/// The same of strokes.
fn send_strokes(lines: u32, probability: f64, change: Change, seed: u64) -> Outcome {
    let is_right = |sample: &PivotSample| {
        let found = StrokesPacket::of_sample(sample);
        // The counter may have gone round before the first of them came through.
        let sent_us = |rounds: u64| u64::from(found.time_us) + (rounds << 32);
        (0..3).any(|rounds| found == strokes_packet((sent_us(rounds) / u64::from(STEP_US)) as u32))
    };
    send_of(|index| strokes_packet(index).to_line(), is_right, (lines, probability), change, seed)
}

fn send_of<S: RigSample>(
    line: impl Fn(u32) -> String,
    is_right: impl Fn(&S) -> bool,
    (lines, probability): (u32, f64),
    change: Change,
    seed: u64,
) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut decoder = Decoder::<S>::new(S::Conventions::default());
    let (mut samples, mut outcome) = (Vec::new(), Outcome::default());
    for index in 0..lines {
        let mut bytes = line(index).into_bytes();
        for byte in &mut bytes {
            if rng.random_bool(probability) {
                *byte = match change {
                    Change::Bit => *byte ^ (1 << rng.random_range(0..8)),
                    Change::Byte => byte.wrapping_add(rng.random_range(1..=255)),
                    Change::Digit if byte.is_ascii_digit() => b'0' + (*byte - b'0' + rng.random_range(1..10)) % 10,
                    Change::Digit => *byte,
                };
            }
        }
        decoder.push(&bytes, 0.01 * f64::from(index), &mut samples);
        for sample in samples.drain(..) {
            // What was sent at that time.
            if is_right(&sample) { outcome.right += 1 } else { outcome.wrong += 1 }
        }
    }
    outcome
}

#[test]
fn of_a_million_lines_with_one_byte_in_ten_changed_no_wrong_one_gets_through() {
    for (change, seed) in [(Change::Bit, 1), (Change::Byte, 2), (Change::Digit, 3)] {
        let outcome = send(1_000_000, 0.1, change, seed);
        assert_eq!(outcome.wrong, 0, "{change:?}: {outcome:?}");
    }
}

#[test]
fn nor_does_one_of_the_shorter_lines_of_strokes() {
    for (change, seed) in [(Change::Bit, 11), (Change::Byte, 12), (Change::Digit, 13)] {
        let outcome = send_strokes(1_000_000, 0.1, change, seed);
        assert_eq!(outcome.wrong, 0, "{change:?}: {outcome:?}");
    }
    let outcome = send_strokes(100_000, 0.000_5, Change::Bit, 14);
    assert!(outcome.right > 95_000 && outcome.wrong == 0, "{outcome:?}");
}

#[test]
fn on_a_line_with_few_faults_most_samples_get_through() {
    let outcome = send(100_000, 0.000_5, Change::Bit, 4);
    assert!(outcome.right > 95_000 && outcome.wrong == 0, "{outcome:?}");
}

#[test]
fn whatever_came_before_the_line_is_in_step_again_within_two_lines() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for trial in 0..2000 {
        let mut decoder = Decoder::<Sample>::new(Conventions::default());
        let mut samples = Vec::new();
        (0..10).for_each(|index| decoder.push(packet(index).to_line().as_bytes(), 0.0, &mut samples));
        let noise: Vec<u8> = (0..rng.random_range(0..300)).map(|_| rng.random()).collect();
        decoder.push(&noise, 0.0, &mut samples);
        samples.clear();
        // The first line may be joined to the noise. Of those after it none is lost, and the third of them lets all through.
        (20..24).for_each(|index| decoder.push(packet(index).to_line().as_bytes(), 0.0, &mut samples));
        let found: Vec<u32> = samples.iter().map(|sample| (sample.time_s * 100.0).round() as u32).collect();
        assert!(found.ends_with(&[21, 22, 23]), "{trial}: {found:?}");
    }
}
