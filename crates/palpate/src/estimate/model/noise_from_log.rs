//! Noise of the readings estimated from the log alone, before any shape is known (`docs/theory.md`, what the log says of itself).
//!
//! Third differences of neighbouring samples cancel every smooth motion and leave √20 times the noise. They are taken where the palms
//! move least: palms that go from step to step, or fast for the rate of the samples, carry the contacts along. Quantised readings (a
//! touchpad's counts, or rounded digits in a file) have at least the standard deviation of their step q, q/√12.

use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::{by_palms, combine, contacts};
use crate::estimate::model::noise::Noise;
use crate::log::{Log, Sample};
use crate::math::statistics::median;
use crate::palms::PalmAngles;

/// Standard deviation of one contact position in metres, estimated from the scatter of neighbouring samples, and at least that of rounding to these steps
/// ([`steps_m`]).
pub(crate) fn contact_scatter_m(measurements: &Measurements, steps_m: [f64; 2]) -> f64 {
    scatter_of_neighbours_m(measurements).max(steps_m.map(rounding_sd_m).into_iter().fold(0.0, f64::max))
}

/// Samples for each reading that is an error of its own: where rounding is all the noise there is, a contact that is read at the same place again and
/// again has the same error each time. 1 where other noise is as large.
pub(crate) fn samples_per_error(measurements: &Measurements, raw: &Log, steps_m: [f64; 2]) -> f64 {
    let scatter = scatter_of_neighbours_m(measurements);
    let of_pad = |palm: usize| {
        if scatter >= rounding_sd_m(steps_m[palm]) {
            return 1.0;
        }
        let readings: Vec<f64> = raw.samples.iter().filter_map(READINGS[palm]).collect();
        let changes = readings.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > LEAST_GAP_M).count();
        readings.len() as f64 / (changes + 1) as f64
    };
    0.5 * (of_pad(0) + of_pad(1))
}

/// The steps that the readings of both pads are rounded to, metres, 0 where they are not: as the rig wrote them, in `raw`, since corrected ones no longer lie
/// on any.
pub(crate) fn steps_m(raw: &Log) -> [f64; 2] {
    READINGS.map(|reading| quantisation_m(raw, reading))
}

/// What each pad reads.
const READINGS: [fn(&Sample) -> Option<f64>; 2] = [|sample| sample.s1_m, |sample| sample.s2_m];

/// Standard deviation of rounding to a step, metres.
fn rounding_sd_m(step_m: f64) -> f64 {
    step_m / 12f64.sqrt()
}

fn scatter_of_neighbours_m(measurements: &Measurements) -> f64 {
    third_difference_scatter(&stillest_windows(measurements, 1), CONTACTS)
}

const CONTACTS: [fn(&Instant) -> f64; 2] = [|instant| instant.s1, |instant| instant.s2];

/// The directions of both palms.
const PALMS: [fn(&Instant) -> f64; 2] = [|instant| instant.phi1, |instant| instant.phi1 + instant.phi2];

/// Standard deviation of one contact position in metres where neighbouring samples share their errors, so that those further apart differ by more: at the
/// last lag from which the scatter grows on as that of errors with a memory, and not as that of a motion. `None` where neighbours show about as much.
pub(crate) fn scatter_with_memory_m(measurements: &Measurements) -> Option<f64> {
    let size_m = measurements.size_m();
    let windows = LAGS.into_iter().map(|lag| (lag as f64, stillest_windows(measurements, lag)));
    let enough = windows.take_while(|(_, windows)| windows.len() >= FEWEST_WINDOWS);
    let mut scatters: Vec<(f64, f64)> = enough
        .filter_map(|(lag, windows)| {
            let scatter_m = third_difference_scatter(&windows, CONTACTS);
            let carried_m = size_m * third_difference_scatter(&windows, PALMS);
            (carried_m < CARRIED * scatter_m).then_some((lag, scatter_m))
        })
        .collect();
    // What a longer lag does not show was the motion.
    for index in (1..scatters.len()).rev() {
        scatters[index - 1].1 = scatters[index - 1].1.min(scatters[index].1);
    }
    let of_memory = |pair: &&[(f64, f64)]| pair[1].1 <= pair[0].1 * (pair[1].0 / pair[0].0).powf(GROWTH_OF_MEMORY);
    let scatter_m = scatters.windows(2).take_while(of_memory).last()?[0].1;
    (scatter_m > SHOWN_BY_MOTION * scatter_of_neighbours_m(measurements)).then_some(scatter_m)
}

/// Lags, in samples, at which errors with a memory are looked for: up to about that of the longest that a sensor has.
const LAGS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];

/// Lags at which palms that turn unevenly carry the contacts along by more than this share of their scatter show no errors of the sensors: rolling, contacts
/// move three times as far, and make errors of the sensors seem half as large again.
const CARRIED: f64 = 0.25;

/// Power of the lag up to which growing scatter is that of errors with a memory: theirs grows with less than the first, that of a smooth motion with the
/// third.
const GROWTH_OF_MEMORY: f64 = 1.5;

/// Where it grows no faster, a smooth motion makes white noise seem larger by √2 at most.
const SHOWN_BY_MOTION: f64 = 1.5;

/// Standard deviation of a palm angle in radians, estimated in the same way.
fn angle_scatter_rad(measurements: &Measurements) -> f64 {
    angle_sd_rad(measurements, PALMS)
}

/// The same of some angles. Palms that move unevenly seem noisy, and where they seem to move least, their noise is least: so it is that
/// of all windows, or that of the stillest with what the choice of them takes away, whichever is less.
fn angle_sd_rad<const N: usize>(measurements: &Measurements, angles: [fn(&Instant) -> f64; N]) -> f64 {
    let anywhere = third_difference_scatter(&windows(measurements, 1), angles);
    anywhere.min(OF_STILLEST * third_difference_scatter(&stillest_windows(measurements, 1), angles))
}

/// Third differences of noise alone over those of the quarter in which it turns the palms least.
const OF_STILLEST: f64 = 1.5;

/// Weighs contacts by how far noise of the palm angles moves them: far out on the palms, and where these nearly meet, by many times what it
/// moves others. `contact_m` is the standard deviation of a reading, by which stated ones are weighed; returned is that of the typical contact,
/// which has weight 1 where none is stated.
pub(crate) fn weigh_by_angles(measurements: &mut Measurements, contact_m: f64, is_stated: bool) -> f64 {
    // What the stillest show, which is rather less than it is: weights that are too even lose little, those of a noise that is none lose
    // samples.
    let sd = third_difference_scatter(&stillest_windows(measurements, 1), PALMS);
    let least_m = contact_m.max(LEAST_CONTACT_SD * measurements.size_m());
    let size_m = measurements.size_m();
    // Palm 2 turned by an angle carries the object along palm 1, and both contacts with it; besides, the object turns, by about as much.
    let total = |instant: &Instant| {
        let PalmAngles { sin2, cos2, .. } = instant.palms;
        let lever_m = instant.s2 / sin2;
        [lever_m, lever_m * cos2].map(|lever_m| least_m.hypot(sd * lever_m.hypot(size_m)))
    };
    let both_seen = |instant: &&mut Instant| instant.both_seen();
    let mut all: Vec<f64> = measurements.instants.iter_mut().filter(both_seen).flat_map(|i| total(i)).collect();
    let typical_m = if all.is_empty() { least_m } else { median(&mut all) };
    let weight_1_m = if is_stated { least_m } else { typical_m };
    for instant in measurements.instants.iter_mut().filter(both_seen) {
        let [first_m, second_m] = total(instant);
        instant.weight1 *= weight_1_m / first_m;
        instant.weight2 *= weight_1_m / second_m;
    }
    typical_m
}

/// What noise of the palm angles leaves in the contact positions at an optimum, where every orientation has adapted to it: root mean square,
/// weighed as they are, metres.
pub(crate) fn angle_residual_m(measurements: &Measurements, coefficients: &[f64], psi: &[f64], noise: Noise) -> f64 {
    let angles: [fn(&Instant) -> f64; 2] = [|i| i.phi1, |i| i.phi2];
    let sds = angles.map(|angle| angle_sd_rad(measurements, [angle]));
    let (mut sum, mut count) = (0.0, 0.0);
    for (instant, &psi) in measurements.instants.iter().zip(psi) {
        let at = contacts(instant, coefficients, psi);
        let weights = noise.weights(instant);
        let weighted = |by: [f64; 3]| [0, 1, 2].map(|j| by[j] * weights[j]);
        let by_psi = weighted(combine(instant, at).by_psi);
        let information = by_psi.iter().map(|by| by * by).sum::<f64>().max(f64::MIN_POSITIVE);
        let [by_palm1, by_palm2] = by_palms(instant, &at);
        // φ₁ turns both palms, φ₂ the second.
        let by_phi1 = [0, 1, 2].map(|j| by_palm1[j] + by_palm2[j]);
        for (by_angle, sd) in [by_phi1, by_palm2].into_iter().zip(sds) {
            let by_angle = weighted(by_angle);
            let along = (0..3).map(|j| by_psi[j] * by_angle[j]).sum::<f64>() / information;
            sum += (0..2).map(|j| (sd * (by_angle[j] - along * by_psi[j])).powi(2)).sum::<f64>();
        }
        count += [instant.weight1, instant.weight2].into_iter().filter(|weight| *weight > 0.0).count() as f64;
    }
    noise.sensor_m * (sum / f64::max(count, 1.0)).sqrt()
}

/// Standard deviation of a palm angle at an optimum, radians: what neighbouring samples show, but no more than what leaves in the contacts all that is left
/// of them. Palms that turn far from one sample to the next look noisy, and are not.
pub(crate) fn angle_sd_at_optimum_rad(
    measurements: &Measurements,
    coefficients: &[f64],
    psi: &[f64],
    noise: Noise,
) -> f64 {
    let would_leave_m = angle_residual_m(measurements, coefficients, psi, noise);
    angle_scatter_rad(measurements) * (noise.sensor_m / would_leave_m).min(1.0)
}

/// No contact is taken to be more exact than this share of the mean radius: weights stay finite in an exact log.
const LEAST_CONTACT_SD: f64 = 1e-5;

/// Share of the third differences that are used, the smallest ones, so that jumps do not count; as a fraction, numerator and
/// denominator.
const USED: [usize; 2] = [4, 5];

/// Root mean square of the smaller four fifths of a standard normal distribution's absolute values.
const TRUNCATED_SD: f64 = 0.6616;

/// One in so many windows says how noisy the contacts are, those in which the palms move least, but not fewer than this.
const STILLEST: usize = 4;
const FEWEST_WINDOWS: usize = 50;

/// Four samples each that are so many apart, all of them with both contacts.
type Window<'a> = [&'a Instant; 4];

fn windows(measurements: &Measurements, lag: usize) -> Vec<Window<'_>> {
    let windows = measurements.instants.windows(3 * lag + 1).map(|window| [0, 1, 2, 3].map(|k| &window[k * lag]));
    windows.filter(|window| window.iter().all(|instant| instant.both_seen())).collect()
}

/// Those of them in which the palms move least.
fn stillest_windows(measurements: &Measurements, lag: usize) -> Vec<Window<'_>> {
    let mut windows: Vec<(f64, Window)> =
        windows(measurements, lag).into_iter().map(|window| (path_rad(&window), window)).collect();
    windows.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    windows.truncate((windows.len() / STILLEST).max(FEWEST_WINDOWS));
    windows.into_iter().map(|(_, window)| window).collect()
}

/// How far both palms turn within four instants, radians.
fn path_rad(window: &Window) -> f64 {
    window.windows(2).map(|pair| (pair[1].phi1 - pair[0].phi1).hypot(pair[1].phi2 - pair[0].phi2)).sum()
}

/// Standard deviation of the readings of these channels, from their third differences.
fn third_difference_scatter<const N: usize>(windows: &[Window], channels: [fn(&Instant) -> f64; N]) -> f64 {
    let mut differences: Vec<f64> =
        windows.iter().flat_map(|window| channels.map(|value| third_difference(window, value).abs())).collect();
    // Unlike a median, this is not biased by quantised readings. Third differences have √(1 + 9 + 9 + 1) times the standard
    // deviation.
    differences.sort_by(f64::total_cmp);
    differences.truncate(differences.len() * USED[0] / USED[1]);
    let mean_square = differences.iter().map(|d| d * d).sum::<f64>() / differences.len().max(1) as f64;
    mean_square.sqrt() / TRUNCATED_SD / 20f64.sqrt()
}

/// Smallest difference between two readings that are not equal, metres.
const LEAST_GAP_M: f64 = 1e-12;

/// Fewest gaps between readings that determine a quantisation step: of those that occur twice, as whole millimetres of a contact that moves by four do,
/// and of any. An object that rests in three places has two gaps, as large as you like.
const FEWEST_REPEATED_GAPS: usize = 3;
const FEWEST_GAPS: usize = 8;

/// The step is the gap at this quantile (one in so many) of all gaps: the commonest small one.
const GAP_QUANTILE: usize = 10;

/// Distance of a reading from a multiple of the step that rounding of digits explains, in steps: this, and this for each step
/// from the first reading, up to this many.
const OFF_STEP: f64 = 0.02;
const OFF_STEP_GROWTH: f64 = 1e-3;
const GROWTH_STEPS: f64 = 100.0;

/// Percentage of the readings that must lie on multiples of the step: outliers need not, and of readings that are not quantised at
/// most a quarter does by chance.
const ON_STEP_PERCENT: usize = 90;

/// Third difference of a channel over four instants.
fn third_difference(window: &Window, value: fn(&Instant) -> f64) -> f64 {
    let [a, b, c, d] = window.map(value);
    d - 3.0 * c + 3.0 * b - a
}

/// The quantisation step of the readings, or 0 when there is none: from the readings that occur twice, which outliers hardly do, or else from
/// all of them.
fn quantisation_m(raw: &Log, s: fn(&Sample) -> Option<f64>) -> f64 {
    let mut values: Vec<f64> = raw.samples.iter().filter_map(s).collect();
    values.sort_by(f64::total_cmp);
    let repeated: Vec<f64> = values.windows(2).filter(|w| w[1] - w[0] <= LEAST_GAP_M).map(|w| w[1]).collect();
    let is_step = |step: &f64| {
        let on_step = values.iter().filter(|value| {
            let count = (*value - repeated.first().unwrap_or(&values[0])) / step;
            (count - count.round()).abs() < OFF_STEP + OFF_STEP_GROWTH * count.abs().min(GROWTH_STEPS)
        });
        on_step.count() * 100 >= values.len() * ON_STEP_PERCENT
    };
    [(&repeated, FEWEST_REPEATED_GAPS), (&values, FEWEST_GAPS)]
        .into_iter()
        .filter_map(|(values, fewest)| commonest_small_gap_m(values, fewest))
        .find(is_step)
        .unwrap_or(0.0)
}

/// The commonest small gap between neighbouring values (sorted), `None` where there are fewer gaps.
fn commonest_small_gap_m(values: &[f64], fewest: usize) -> Option<f64> {
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).filter(|gap| *gap > LEAST_GAP_M).collect();
    gaps.sort_by(f64::total_cmp);
    (gaps.len() >= fewest).then(|| gaps[gaps.len() / GAP_QUANTILE])
}

/// The median of the standard deviations that the log states, if it states any.
pub(crate) fn stated_noise_m(log: &Log) -> Option<f64> {
    let mut stated: Vec<f64> =
        log.samples.iter().flat_map(|sample| [sample.s1_sd_m, sample.s2_sd_m]).flatten().collect();
    (!stated.is_empty()).then(|| median(&mut stated))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::{PalmMotion, PalmPair};
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// A motion of 40 s with jumps at 50 samples per second.
    fn log(touchpad: Touchpad) -> Log {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(1, 40.0, 1.0).and_then(|motion| motion.sample(50.0)).expect("possible");
        let run = simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() });
        let run = run.expect("possible");
        assert!(!run.jumps.is_empty());
        run.log
    }

    fn scatter_m(log: &Log) -> f64 {
        contact_scatter_m(&Measurements::new(log, None), steps_m(log))
    }

    #[test]
    fn gaussian_noise_is_estimated_to_a_tenth_in_spite_of_motion_and_jumps() {
        for noise_sd_m in [3e-5, 1e-4, 3e-4] {
            let found = scatter_m(&log(Touchpad { noise_sd_m, ..Touchpad::ideal() }));
            assert!((found / noise_sd_m - 1.0).abs() < 0.1, "{found} for {noise_sd_m}");
        }
    }

    #[test]
    fn palms_that_go_in_steps_do_not_make_contacts_noisy() {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        // Six samples of rest after each step, which takes three.
        let steps = |sample: u32| f64::from(sample / 9) + (f64::from(sample % 9) / 3.0).min(1.0);
        let motion: Vec<(f64, PalmPair)> = (0..600)
            .map(|sample| (f64::from(sample) / 10.0, PalmPair::hinged(0.4, 1.6 + 0.3 * steps(sample).sin())))
            .collect();
        let noise_sd_m = 3e-5;
        let touchpad = Touchpad { noise_sd_m, ..Touchpad::ideal() };
        let run = simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() });
        let log = run.expect("possible").log;
        let measurements = Measurements::new(&log, None);
        let anywhere = third_difference_scatter(&windows(&measurements, 1), [|i| i.s1, |i| i.s2]);
        assert!(anywhere > 3.0 * noise_sd_m, "the steps do not show: {anywhere}");
        let found = contact_scatter_m(&measurements, steps_m(&log));
        assert!((found / noise_sd_m - 1.0).abs() < 0.2, "{found}");
    }

    /// The scatter of errors of 0.1 mm with such a memory, samples, where readings come at such a rate: over that.
    fn with_memory_of(memory: f64, rate_hz: f64) -> Option<f64> {
        use crate::estimate::model::sensor_memory::with_memory;
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(1, 80.0, 1.0).and_then(|motion| motion.sample(rate_hz));
        let run = simulate(&shape, &motion.expect("possible"), &SimulateOptions::default()).expect("possible");
        let log = with_memory(run.log, 1e-4, memory);
        scatter_with_memory_m(&Measurements::new(&log, None)).map(|scatter_m| scatter_m / 1e-4)
    }

    #[test]
    fn errors_that_neighbours_share_are_seen_between_samples_further_apart() {
        for memory in [4.0, 7.0] {
            let found = with_memory_of(memory, 40.0).expect("a memory");
            assert!((0.75..1.25).contains(&found), "{found} for {memory}");
        }
        assert!(with_memory_of(3.2, 40.0).is_some() && with_memory_of(2.0, 40.0).is_none());
    }

    #[test]
    fn palms_that_go_in_steps_hide_a_memory_at_some_lags_and_make_none() {
        use crate::estimate::model::sensor_memory::with_memory;
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        // Between steps of such a length the palms rest for as many samples.
        let found = |step: u32, memory: f64| {
            let steps = |sample: u32| {
                f64::from(sample / (2 * step)) + (f64::from(sample % (2 * step)) / f64::from(step)).min(1.0)
            };
            let motion: Vec<(f64, PalmPair)> = (0..1200)
                .map(|k| (f64::from(k) / 20.0, PalmPair::hinged(0.4, 1.6 + 0.3 * (0.4 * steps(k)).sin())))
                .collect();
            let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
            let log = with_memory(run.log, 1e-4, memory);
            scatter_with_memory_m(&Measurements::new(&log, None)).map(|scatter_m| scatter_m / 1e-4)
        };
        for step in [1, 2, 3, 4, 6] {
            assert_eq!(found(step, 1.0), None, "{step}");
        }
        assert!(found(6, 7.0).is_some_and(|found| (0.6..1.4).contains(&found)), "{:?}", found(6, 7.0));
    }

    #[test]
    fn palms_that_go_to_and_fro_in_a_few_readings_are_no_memory() {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        for period in [5.0, 7.0, 9.0, 11.0, 14.0, 18.0] {
            let swing = |k: f64| 0.2 * (std::f64::consts::TAU * k / period).sin() + 0.1 * (0.37 * k).sin();
            let motion: Vec<(f64, PalmPair)> = (0..300)
                .map(|k| {
                    (f64::from(k) / 4.0, PalmPair::hinged(0.5 - 0.5 * swing(f64::from(k)), 1.6 + swing(f64::from(k))))
                })
                .collect();
            let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
            let run = simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() });
            let found = scatter_with_memory_m(&Measurements::new(&run.expect("possible").log, None));
            assert_eq!(found, None, "{period}");
        }
    }

    #[test]
    fn a_motion_that_is_fast_for_the_readings_is_no_memory() {
        for rate_hz in [4.0, 6.0, 8.0, 12.0, 16.0, 24.0] {
            assert_eq!(with_memory_of(1.0, rate_hz), None, "{rate_hz}");
        }
        // A memory that such a motion hides is not seen, and none that is larger than the errors.
        for rate_hz in [8.0, 12.0, 16.0, 24.0] {
            let found = with_memory_of(5.0, rate_hz);
            assert!(found.is_none_or(|found| found < 1.4), "{found:?} at {rate_hz}");
        }
    }

    /// A stone's log with noise of this standard deviation on both palm angles, its orientations, and the log without it.
    fn with_noisy_angles(angle_sd: f64) -> (Log, Vec<f64>, Log) {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(1, 10.0, 1.0).and_then(|motion| motion.sample(50.0)).expect("possible");
        let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let (mut rng, mut log) = (ChaCha8Rng::seed_from_u64(1), run.log.clone());
        for sample in &mut log.samples {
            sample.palms.phi1_rad += angle_sd * rng.sample::<f64, _>(StandardNormal);
            sample.palms.phi2_rad += angle_sd * rng.sample::<f64, _>(StandardNormal);
        }
        (log, psi, run.log)
    }

    #[test]
    fn contacts_weigh_less_where_noisy_angles_move_them() {
        let weights = |log: &Log, is_stated: bool| {
            let mut measurements = Measurements::new(log, None);
            let typical_m = weigh_by_angles(&mut measurements, 1e-4, is_stated);
            let weights: Vec<f64> = measurements.instants.iter().flat_map(|i| [i.weight1, i.weight2]).collect();
            (typical_m, weights)
        };
        let (noisy, _, exact) = with_noisy_angles(3e-3);
        let (typical_m, all) = weights(&exact, false);
        assert!((typical_m / 1e-4 - 1.0).abs() < 0.01 && all.iter().all(|weight| (weight - 1.0).abs() < 0.05));
        let (typical_m, all) = weights(&noisy, false);
        let heavier = all.iter().filter(|weight| **weight > 1.0).count();
        assert!(typical_m > 1.2e-4 && heavier.abs_diff(all.len() / 2) <= 1, "{typical_m} {heavier} of {}", all.len());
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least < 0.4, "{least}");
        // A stated standard deviation is that of a reading, without the angles.
        let (_, stated) = weights(&noisy, true);
        assert!(
            stated
                .iter()
                .zip(&all)
                .all(|(stated, weight)| *stated < 1.0 && (stated / weight * typical_m / 1e-4 - 1.0).abs() < 1e-9)
        );
    }

    #[test]
    fn what_noisy_angles_leave_in_the_contacts_is_what_is_expected() {
        use crate::estimate::model::prior::Prior;
        use crate::estimate::solver::gauss_newton::{Smoother, StoppingCriteria};
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        for angle_sd in [7e-4, 2e-3] {
            let (log, psi, _) = with_noisy_angles(angle_sd);
            let mut measurements = Measurements::new(&log, None);
            let sensor_m = weigh_by_angles(&mut measurements, 1e-6, false);
            let noise = Noise { sensor_m, balance_m: 0.2 * sensor_m };
            let prior = Prior::new(0.03, 0.015);
            let order = shape.harmonics_m().len();
            // Only the orientations adapt: the shape is that of the object.
            let smoother = Smoother::new(&measurements, order, noise, prior);
            let stopping = StoppingCriteria { iterations: 20, tolerance: 1e-12 };
            let estimate = smoother.run(shape.coefficients(), psi, stopping);
            let expected_m = angle_residual_m(&measurements, &estimate.coefficients, &estimate.psi, noise);
            let (mut sum, mut count) = (0.0, 0.0);
            for (instant, &psi) in measurements.instants.iter().zip(&estimate.psi) {
                let value = combine(instant, contacts(instant, &estimate.coefficients, psi)).value;
                sum += (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2);
                count += 2.0;
            }
            let found_m = f64::sqrt(sum / count);
            assert!((found_m / expected_m - 1.0).abs() < 0.1, "{found_m} {expected_m}");
            // Contacts that are left with that do not bound it, and those that are left with a tenth of it do.
            let sd_with = |share: f64| {
                let noise = Noise { sensor_m: share * expected_m, balance_m: 0.2 * share * expected_m };
                angle_sd_at_optimum_rad(&measurements, &estimate.coefficients, &estimate.psi, noise)
            };
            // φ₁ + φ₂ is off by both.
            let of_palms = 1.5_f64.sqrt() * angle_sd;
            assert!((sd_with(1.01) / of_palms - 1.0).abs() < 0.1, "{} {of_palms}", sd_with(1.01));
            assert!((sd_with(0.1) / (0.1 * of_palms) - 1.0).abs() < 0.1, "{} {of_palms}", sd_with(0.1));
        }
    }

    #[test]
    fn palms_that_turn_far_between_samples_look_noisy_until_the_contacts_fit() {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(1, 10.0, 1.0).and_then(|motion| motion.sample(4.0)).expect("possible");
        let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let measurements = Measurements::new(&run.log, None);
        let looks_rad = angle_scatter_rad(&measurements);
        let noise = Noise { sensor_m: 1e-5, balance_m: 1e-6 };
        let is_rad = angle_sd_at_optimum_rad(&measurements, &shape.coefficients(), &psi, noise);
        assert!(looks_rad > 1e-2 && is_rad < 1e-3, "{looks_rad} {is_rad}");
    }

    #[test]
    fn an_exact_log_has_next_to_no_scatter() {
        assert!(scatter_m(&log(Touchpad::ideal())) < 1e-6);
    }

    #[test]
    fn the_quantisation_step_of_a_touchpad_is_found() {
        let step = 0.0254 / 200.0;
        let pad = Touchpad { counts_per_inch: Some(200.0), ..Touchpad::ideal() };
        let log = log(pad);
        for channel in [|sample: &Sample| sample.s1_m, |sample: &Sample| sample.s2_m] {
            assert!((quantisation_m(&log, channel) / step - 1.0).abs() < 1e-6);
        }
        // Never less than rounding alone. More where the contact moves by about half a count per sample: 0, 1, 0, 1 …
        // looks 1.55 times as noisy as rounding at random.
        let found = scatter_m(&log) / pad.position_sd_m();
        assert!((1.0 - 1e-6..1.55).contains(&found), "{found}");
    }

    #[test]
    fn outliers_do_not_hide_the_quantisation_step() {
        let pad = Touchpad { counts_per_inch: Some(100.0), ..Touchpad::ideal() };
        let mut log = log(pad);
        let strayed = |every: usize, log: &mut Log| {
            for (place, sample) in log.samples.iter_mut().enumerate().step_by(every) {
                sample.s1_m = sample.s1_m.map(|s| s + 1e-2 * (1.0 + (place as f64).sin()));
            }
            quantisation_m(log, |sample| sample.s1_m) / 2.54e-4
        };
        let found = strayed(12, &mut log);
        assert!((found - 1.0).abs() < 1e-6, "{found}");
        assert_eq!(strayed(5, &mut log), 0.0, "most readings must lie on the steps");
    }

    #[test]
    fn whole_millimetres_of_a_contact_that_hardly_moves_are_steps_and_two_places_of_rest_are_none() {
        let log = |places_mm: i32| Log {
            samples: (0..100)
                .map(|k| {
                    Sample::new(
                        f64::from(k),
                        PalmPair::hinged(1.0, 1.2),
                        f64::from(30 + k * places_mm / 100) / 1e3,
                        0.03,
                    )
                })
                .collect(),
        };
        let step = |places_mm: i32| quantisation_m(&log(places_mm), |sample| sample.s1_m);
        assert!((step(FEWEST_REPEATED_GAPS as i32 + 1) - 1e-3).abs() < 1e-9);
        assert_eq!(step(FEWEST_REPEATED_GAPS as i32), 0.0);
    }

    #[test]
    fn rounding_repeats_its_errors_where_it_is_all_the_noise_there_is() {
        let per_error = |noise_sd_m: f64, counts_per_inch: f64| {
            let log = log(Touchpad { noise_sd_m, counts_per_inch: Some(counts_per_inch), ..Touchpad::ideal() });
            samples_per_error(&Measurements::new(&log, None), &log, steps_m(&log))
        };
        let step_m = 0.0254 / 25.4;
        assert!(per_error(0.0, 25.4) > 4.0 && per_error(0.0, 2.0 * 25.4) > 2.0);
        assert!(per_error(0.2 * step_m / 12f64.sqrt(), 25.4) > 4.0);
        assert!((per_error(2.0 * step_m / 12f64.sqrt(), 25.4) - 1.0).abs() < 1e-12);
        let unrounded = log(Touchpad::ideal());
        assert!(
            (samples_per_error(&Measurements::new(&unrounded, None), &unrounded, steps_m(&unrounded)) - 1.0).abs()
                < 1e-12
        );
    }

    #[test]
    fn steps_are_those_of_readings_before_they_are_corrected() {
        use crate::sensor::Calibration;
        let log = log(Touchpad { counts_per_inch: Some(50.0), ..Touchpad::ideal() });
        let calibration = Calibration { scale: [1.003, 0.998], angle_zero_rad: [2e-3, 1e-3], ..Calibration::default() };
        let corrected = Measurements::new(&calibration.corrected(&log), None);
        let rounding_m = 0.0254 / 50.0 / 12f64.sqrt();
        assert!(contact_scatter_m(&corrected, steps_m(&log)) > 0.999 * rounding_m);
    }

    #[test]
    fn noisy_readings_are_not_quantised() {
        let log = log(Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() });
        assert_eq!(quantisation_m(&log, |sample| sample.s1_m), 0.0);
    }

    #[test]
    fn noise_of_the_palm_angles_is_estimated_as_well() {
        for angle_noise_sd_rad in [1e-4, 2e-3] {
            let log = log(Touchpad { angle_noise_sd_rad, ..Touchpad::ideal() });
            let found = angle_scatter_rad(&Measurements::new(&log, None));
            assert!((found / angle_noise_sd_rad - 1.0).abs() < 0.1, "{found} for {angle_noise_sd_rad}");
        }
        assert!(angle_scatter_rad(&Measurements::new(&log(Touchpad::ideal()), None)) < 1e-5);
    }
}
