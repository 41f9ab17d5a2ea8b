//! A serial line on which bytes change on their way: how many wrong samples get through, and how soon good ones do again.

use palpate::Sample;
use palpate::palms::PalmPair;
use palpate_io::Conventions;
use palpate_live::protocol::{Decoder, Packet};
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

/// Sends so many lines, each byte changed with this probability.
fn send(lines: u32, probability: f64, change: Change, seed: u64) -> Outcome {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut decoder = Decoder::new(Conventions::default());
    let (mut samples, mut outcome) = (Vec::new(), Outcome::default());
    for index in 0..lines {
        let mut bytes = packet(index).to_line().into_bytes();
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
            let found = Packet::of_sample(&sample);
            let sent = packet(found.time_us / STEP_US);
            if found == sent { outcome.right += 1 } else { outcome.wrong += 1 }
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
fn on_a_line_with_few_faults_most_samples_get_through() {
    let outcome = send(100_000, 0.000_5, Change::Bit, 4);
    assert!(outcome.right > 95_000 && outcome.wrong == 0, "{outcome:?}");
}

#[test]
fn whatever_came_before_the_line_is_in_step_again_within_two_lines() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for trial in 0..2000 {
        let mut decoder = Decoder::new(Conventions::default());
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
