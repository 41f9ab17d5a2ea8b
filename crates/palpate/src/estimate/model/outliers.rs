//! Gross outliers among the readings of a contact, before any shape is known: single readings far from those before and after, as a
//! loose cable, a second touch or a lost count makes them (`docs/theory.md`, what the log says of itself). Where a contact jumps, or
//! slides fast, the readings around it are as far from each other, so that it is none.

use crate::estimate::measurements::{Instant, Measurements};

/// Readings on each side that a reading is compared with; one with fewer than two on either side is never an outlier.
const AROUND: usize = 3;

/// A reading is an outlier when it is farther from all of those on either side than so many standard deviations of the noise …
const NOISE_SDS: f64 = 10.0;

/// … and than this share of the size of the object (less than that is no gross error), …
const LEAST_SHARE: f64 = 0.01;

/// … and so many times what the contact moves there farther still: one that slides, to a jump or from one, has no outliers.
const SPREADS: f64 = 2.0;

/// An object that is about to jump slides faster and faster: a step the same way as the one before it, and up to so many times as long, is
/// such a slide. Where two poses meet it goes as the square root of time, with steps up to 2.4 times the one before; where three
/// meet, as the cube root, and 3.8 times.
const FOLD_GROWTH: f64 = 4.0;

/// The other contact is where it was when it is farther from its own neighbours by no more than this share of the limit.
const STILL: f64 = 0.3;

/// Palms rest from one sample to the next when they turn by less than this share of their largest step around. Nothing slides then, so that
/// what a contact moves from before to after does not count.
const AT_REST: f64 = 0.05;

/// An instant, by its index, and where a contact was then, metres.
type Reading = (usize, f64);

/// Sets the outliers of both contacts aside but for those of the samples `kept`, and gives the samples of all that were set aside.
pub(crate) fn set_outliers_aside(measurements: &mut Measurements, scatter_m: f64, kept: &[usize]) -> Vec<usize> {
    let limit_m = (NOISE_SDS * scatter_m).max(LEAST_SHARE * measurements.size_m());
    let first = readings(measurements, |instant| (instant.weight1 > 0.0).then_some(instant.s1));
    let second = readings(measurements, |instant| (instant.weight2 > 0.0).then_some(instant.s2));
    let at_rest = |index: usize| palms_rest(&measurements.instants, index);
    let mut outlying1 = outlying(&first, &second, limit_m, &at_rest);
    let mut outlying2 = outlying(&second, &first, limit_m, &at_rest);
    [&mut outlying1, &mut outlying2].into_iter().for_each(|outlying| outlying.retain(|index| !kept.contains(index)));
    // Not seen, as far as anything that follows is concerned.
    outlying1
        .iter()
        .for_each(|&index| (measurements.instants[index].s1, measurements.instants[index].weight1) = (0.0, 0.0));
    outlying2
        .iter()
        .for_each(|&index| (measurements.instants[index].s2, measurements.instants[index].weight2) = (0.0, 0.0));
    outlying1.append(&mut outlying2);
    outlying1
}

/// The readings of one contact, with the indices of their instants.
fn readings(measurements: &Measurements, reading: impl Fn(&Instant) -> Option<f64>) -> Vec<Reading> {
    let instants = measurements.instants.iter().enumerate();
    instants.filter_map(|(index, instant)| reading(instant).map(|value| (index, value))).collect()
}

/// The readings before and after one of them, of the same contact.
fn around(readings: &[Reading], place: usize) -> [&[Reading]; 2] {
    [&readings[place.saturating_sub(AROUND)..place], &readings[place + 1..(place + 1 + AROUND).min(readings.len())]]
}

/// Smallest difference between a value of one set and a value of another, or between two of the same.
fn smallest_step<'a>(pairs: impl Iterator<Item = (&'a Reading, &'a Reading)>) -> f64 {
    pairs.map(|(a, b)| (a.1 - b.1).abs()).fold(f64::INFINITY, f64::min)
}

/// Whether the palms rest between an instant and the one before it, or the one after it.
fn palms_rest(instants: &[Instant], index: usize) -> bool {
    let turn = |after: usize| instants[after - 1].palms_turn_to(&instants[after]);
    let around = index.saturating_sub(AROUND).max(1)..(index + AROUND + 1).min(instants.len());
    let largest = around.clone().map(turn).fold(0.0, f64::max);
    [index, index + 1].into_iter().any(|after| around.contains(&after) && turn(after) <= AT_REST * largest)
}

/// Whether a reading is far from those before and after it. How far they are from each other, on either side and, unless the palms rest,
/// across, is what the contact moves.
fn is_far(reading: f64, before: &[Reading], after: &[Reading], limit_m: f64, at_rest: bool) -> bool {
    let within = |side: &[Reading]| {
        smallest_step(side.iter().enumerate().flat_map(|(index, a)| side[..index].iter().map(move |b| (a, b))))
    };
    let across = smallest_step(before.iter().flat_map(|a| after.iter().map(move |b| (a, b))));
    let step = within(before).max(within(after)).max(if at_rest { 0.0 } else { across });
    before.iter().chain(after).all(|other| (reading - other.1).abs() > limit_m + SPREADS * step)
        && (at_rest || !slides_on(reading, before, limit_m))
}

/// Whether a reading goes on from those before it as an object does that is about to jump.
fn slides_on(reading: f64, before: &[Reading], limit_m: f64) -> bool {
    let [.., (_, second), (_, last)] = before else { return false };
    let (step, next) = (last - second, reading - last);
    step * next > 0.0 && next.abs() < FOLD_GROWTH * step.abs() + limit_m
}

/// Whether a contact is where it was before and after an instant, or between.
fn stays(readings: &[Reading], index: usize, limit_m: f64) -> bool {
    let Ok(place) = readings.binary_search_by_key(&index, |(index, _)| *index) else { return true };
    let [before, after] = around(readings, place);
    let others = || before.iter().chain(after).map(|(_, value)| *value);
    let (least, most) = (others().fold(f64::INFINITY, f64::min), others().fold(f64::NEG_INFINITY, f64::max));
    (least - STILL * limit_m..=most + STILL * limit_m).contains(&readings[place].1)
}

/// Instants of the outliers of one contact. Where the other contact is elsewhere too, the object is: on its way in a fall.
fn outlying(readings: &[Reading], other: &[Reading], limit_m: f64, at_rest: &dyn Fn(usize) -> bool) -> Vec<usize> {
    let is_outlier = |place: usize| {
        let ([before, after], (index, value)) = (around(readings, place), readings[place]);
        is_far(value, before, after, limit_m, at_rest(index)) && stays(other, index, limit_m)
    };
    (0..readings.len()).filter(|&place| is_outlier(place)).map(|place| readings[place].0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const NOISE_M: f64 = 1e-4;

    fn log(seed: u64) -> Log {
        let stone = NamedShape::Stone.shape(0.03).expect("a valid size");
        let motion = PalmMotion::random(seed, 60.0, 1.0).and_then(|motion| motion.sample(20.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() };
        simulate(&stone, &motion, &SimulateOptions { touchpad, seed, ..SimulateOptions::default() })
            .expect("possible")
            .log
    }

    fn found(log: &Log) -> (usize, Measurements) {
        let mut measurements = Measurements::new(log, None);
        (set_outliers_aside(&mut measurements, NOISE_M, &[]).len(), measurements)
    }

    /// A log in which nothing moves.
    fn still() -> Log {
        let mut log = log(1);
        log.samples.truncate(12);
        let first = log.samples[0];
        log.samples.fill(first);
        log
    }

    #[test]
    fn jumps_and_slides_are_no_outliers() {
        for seed in 0..20 {
            assert_eq!(found(&log(seed)).0, 0, "seed {seed}");
        }
    }

    #[test]
    fn those_of_kept_samples_stay() {
        let mut log = log(3);
        for index in [40, 90] {
            log.samples[index].s1_m = log.samples[index].s1_m.map(|s1_m| s1_m + 0.02);
        }
        let aside = |kept: &[usize]| set_outliers_aside(&mut Measurements::new(&log, None), NOISE_M, kept);
        assert_eq!((aside(&[]), aside(&[40]), aside(&[90, 40])), (vec![40, 90], vec![90], vec![]));
    }

    #[test]
    fn readings_far_off_are_set_aside_and_no_others() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for seed in 0..10 {
            let clean = log(seed);
            for share in [0.005, 0.05] {
                let mut spoilt = clean.clone();
                let mut off = Vec::new();
                for (index, sample) in spoilt.samples.iter_mut().enumerate() {
                    if rng.random_bool(share) {
                        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
                        sample.s1_m = sample.s1_m.map(|s1_m| s1_m + sign * rng.random_range(0.01..0.03));
                        off.push(index);
                    }
                }
                let (count, measurements) = found(&spoilt);
                let aside: Vec<usize> =
                    (0..measurements.len()).filter(|&i| measurements.instants[i].weight1 == 0.0).collect();
                assert!(measurements.instants.iter().all(|instant| instant.weight2 > 0.0));
                assert_eq!(count, aside.len());
                let wrongly = aside.iter().filter(|index| !off.contains(index)).count();
                let missed = off.iter().filter(|index| !aside.contains(index)).count();
                assert_eq!(wrongly, 0, "seed {seed}");
                assert!(missed * 5 <= off.len() + 4, "seed {seed}: {missed} of {}", off.len());
            }
        }
    }

    #[test]
    fn an_object_on_its_way_moves_both_contacts_and_neither_is_an_outlier() {
        let still = still();
        let first = still.samples[0];
        // The limit is ten standard deviations, 1 mm; 0.3 of it the other contact may move.
        let with = |other_m: f64| {
            let mut log = still.clone();
            log.samples[5].s1_m = first.s1_m.map(|s1_m| s1_m + 5e-3);
            log.samples[5].s2_m = first.s2_m.map(|s2_m| s2_m + other_m);
            found(&log).0
        };
        assert_eq!((with(0.29e-3), with(0.31e-3), with(5e-3)), (1, 0, 0));
        let mut alone = still.clone();
        (alone.samples[5].s1_m, alone.samples[5].s2_m) = (first.s1_m.map(|s1_m| s1_m + 5e-3), None);
        assert_eq!(found(&alone).0, 1);
    }

    #[test]
    fn a_slide_into_a_jump_is_none_up_to_four_times_the_step_before() {
        let before = |step: f64| [(0, 1.0 + 2.0 * step), (1, 1.0 + step), (2, 1.0)];
        let after = [(4, 1.02), (5, 1.02), (6, 1.02)];
        // A slide that starts with a step of 0.02, in units of the limit 0.01.
        assert!(!is_far(1.0 - 0.089, &before(0.02), &after, 0.01, false));
        assert!(is_far(1.0 - 0.091, &before(0.02), &after, 0.01, false));
        assert!(is_far(1.0 + 0.1, &before(0.02), &after, 0.01, false));
    }

    #[test]
    fn where_the_palms_rest_what_a_contact_moves_beyond_does_not_count() {
        // A step of the palms by 0.1 rad and of the contact by 7 mm after sample 5, which is off by 13 mm.
        let with = |last_turn: f64| {
            let mut log = still();
            let first = log.samples[0];
            for (index, sample) in log.samples.iter_mut().enumerate() {
                let moved = if index > 5 { 0.1 } else { 0.0 };
                sample.palms.phi1_rad += moved + if index == 5 { last_turn } else { 0.0 };
                let s1_m = first.s1_m.map(|s1_m| s1_m + 0.07 * moved + if index == 5 { 13e-3 } else { 0.0 });
                sample.s1_m = s1_m;
            }
            found(&log).0
        };
        assert_eq!((with(0.0), with(0.0047), with(0.0049)), (1, 1, 0));
    }

    #[test]
    fn a_reading_is_off_from_ten_standard_deviations_on() {
        let still = still();
        let first = still.samples[0];
        let with = |off_m: f64| {
            let mut log = still.clone();
            log.samples[5].s1_m = first.s1_m.map(|s1_m| s1_m + off_m);
            found(&log).0
        };
        assert_eq!((with(0.99e-3), with(1.01e-3)), (0, 1));
    }
}
