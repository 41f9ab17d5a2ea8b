//! Gross outliers that only an explanation of the log shows (`docs/theory.md`, what the log says of itself): single readings far from where it has the
//! contact, while it fits all others. Held against its neighbours ([`crate::estimate::model::outliers`]) such a reading may be that of a contact on its
//! way, where the object slides fast for the rate of the samples.

use crate::estimate::jumps::REVERSED;
use crate::estimate::motion::LONGEST_STEP;
use crate::log::{Log, Sample};
use crate::math::angle::wrapped;
use crate::math::statistics::{root_mean_square, typical_sd};
use crate::mechanics::Jump;
use crate::palms::PalmPair;
use crate::reconstruct::options::limits::CertificateLimits;
use crate::reconstruct::result::reconstruction::{Pose, Reconstruction};
use crate::reconstruct::verdict::bent_poses::off_elsewhere_m;
use crate::reconstruct::verdict::certificate::doubt_of_outliers;
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::shape::SupportFunction;
use std::ops::Range;

/// A reading is a stray one when it is farther from where its contact should be than so many standard deviations of most readings (noise that grows with
/// the tilt of a palm has several times theirs) and than this share of the mean radius: gross, as those that neighbours show.
const STRAY_SDS: f64 = 10.0;
const LEAST_SHARE: f64 = 0.01;

/// Samples in a row that may have one each. What a wrong motion misses, it misses for longer.
const LONGEST_RUN: usize = 3;

/// Samples on each side between whose orientations that of a sample is, and steps between these at which its contacts are looked at, radians.
const BESIDE: usize = 2;
const STEP_RAD: f64 = 0.05;

/// The log without the stray readings of an explanation, and how many they are. `None` where it has none, or more than may be left out, or does not fit the
/// others evenly.
pub(in crate::reconstruct) fn without_stray_readings(
    log: &Log,
    shape: &SupportFunction,
    motion: &[Pose],
    limits: &CertificateLimits,
) -> Option<(Log, usize)> {
    let left = |pose: &Pose| [pose.residual1_m, pose.residual2_m];
    let all: Vec<f64> = motion.iter().flat_map(left).flatten().collect();
    let typical_m = typical_sd(all.iter());
    let limit_m = (STRAY_SDS * typical_m).max(LEAST_SHARE * shape.mean_radius_m());
    let steady = without_excursions(motion);
    let of_sample = |sample: usize| are_strays(&log.samples[sample].palms, shape, [motion, &steady], sample, limit_m);
    let mut strays: Vec<[bool; 2]> = (0..motion.len()).map(of_sample).collect();
    let is_any = |strays: &[bool; 2]| strays[0] || strays[1];
    for run in strays.chunk_by_mut(|a, b| is_any(a) == is_any(b)) {
        if run.len() > LONGEST_RUN {
            run.fill([false; 2]);
        }
    }
    let count = strays.iter().flatten().filter(|is_stray| **is_stray).count();
    // The orientation of a sample is bent to both readings.
    let others = motion.iter().zip(&strays).filter(|(_, strays)| !is_any(strays)).flat_map(|(pose, _)| left(pose));
    let is_even = root_mean_square(&others.flatten().collect::<Vec<f64>>()) <= limits.tails * typical_m;
    if count == 0 || count as f64 > limits.outliers * all.len() as f64 || !is_even {
        return None;
    }
    let without = |(sample, strays): (&Sample, &[bool; 2])| Sample {
        s1_m: sample.s1_m.filter(|_| !strays[0]),
        s2_m: sample.s2_m.filter(|_| !strays[1]),
        ..*sample
    };
    Some((Log { samples: log.samples.iter().zip(&strays).map(without).collect() }, count))
}

/// Which readings of a sample are farther than this from where their contacts should be, whatever the orientation between those of the samples beside it:
/// its own is bent to a reading that is wrong. None beside a jump, where the contacts may be anywhere.
/// `steady` is the motion without excursions.
fn are_strays(
    palms: &PalmPair,
    shape: &SupportFunction,
    [motion, steady]: [&[Pose]; 2],
    sample: usize,
    limit_m: f64,
) -> [bool; 2] {
    let Some(around) = steady.get(sample.wrapping_sub(BESIDE)..=sample + BESIDE) else { return [false; 2] };
    if around.iter().any(|pose| pose.piece != steady[sample].piece) {
        return [false; 2];
    }
    let mut psi: Vec<f64> = around.iter().map(|pose| pose.psi_rad).collect();
    psi.remove(BESIDE);
    psi.sort_by(f64::total_cmp);
    // One of them on each side may be bent too.
    let (from, to) = (psi[1], psi[psi.len() - 2]);
    let steps = ((to - from) / STEP_RAD).ceil().max(1.0);
    let Pose { psi_rad, residual1_m, residual2_m, .. } = motion[sample];
    let off_m = |step: usize| {
        let elsewhere_rad = from + (to - from) * step as f64 / steps;
        off_elsewhere_m(palms, shape, (psi_rad, [residual1_m, residual2_m]), elsewhere_rad)
    };
    let off_m: Vec<[Option<f64>; 2]> = (0..=steps as usize).map(off_m).collect();
    [0, 1].map(|palm| {
        let is_beyond = |sign: f64| off_m.iter().all(|off_m| off_m[palm].is_some_and(|off_m| sign * off_m > limit_m));
        is_beyond(1.0) || is_beyond(-1.0)
    })
}

/// Runs of a few samples at other poses than the one that the object comes from and goes on from, within the share [`REVERSED`] of how far it went,
/// and within [`LONGEST_STEP`]. No object does that: they were put where a stray reading has them.
fn excursions(motion: &[Pose]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut sample = 1;
    while sample < motion.len() {
        let before = &motion[sample - 1];
        let apart = |pose: &Pose| wrapped(pose.psi_rad - before.psi_rad).abs();
        let leaves = motion[sample].piece != before.piece;
        let there = (REVERSED * apart(&motion[sample])).min(LONGEST_STEP);
        let returns = |to: &usize| motion.get(*to).is_some_and(|pose| apart(pose) < there);
        let end = leaves.then(|| (sample + 1..=sample + LONGEST_RUN).find(returns)).flatten();
        found.extend(end.map(|end| sample..end));
        sample = end.unwrap_or(sample + 1);
    }
    found
}

/// The motion without its excursions: there it stays as it was before.
fn without_excursions(motion: &[Pose]) -> Vec<Pose> {
    let mut steady = motion.to_vec();
    for excursion in excursions(motion) {
        let before = steady[excursion.start - 1];
        steady[excursion.clone()]
            .iter_mut()
            .for_each(|pose| (pose.psi_rad, pose.piece) = (before.psi_rad, before.piece));
        let (apart, piece) = (motion[excursion.end].psi_rad - before.psi_rad, motion[excursion.end].piece);
        let turns = apart - wrapped(apart);
        for (pose, was) in steady[excursion.end..].iter_mut().zip(&motion[excursion.end..]) {
            pose.psi_rad = was.psi_rad - turns;
            pose.piece = if was.piece == piece { before.piece } else { was.piece };
        }
    }
    steady
}

/// Whether single readings are all that contradicts a result: its jumps and poses are those that statics makes, but for excursions.
pub(in crate::reconstruct) fn are_doubted(result: &Reconstruction) -> bool {
    let (verdict, motion) = (&result.verdict, &result.motion);
    let ends: Vec<f64> =
        excursions(motion).iter().flat_map(|at| [motion[at.start].time_s, motion[at.end].time_s]).collect();
    let is_of_excursion = |jump: &Jump| ends.contains(&jump.time_s);
    let strays = result.jumps.iter().filter(|jump| !jump.physical).all(is_of_excursion);
    verdict.doubts_stray_readings(strays)
}

/// A result of a log of which so many readings were left out.
pub(in crate::reconstruct) fn with_left_out(
    mut found: Reconstruction,
    left_out: usize,
    limits: &CertificateLimits,
) -> Reconstruction {
    if left_out > 0 {
        let of_pose = |pose: &Pose| [pose.residual1_m, pose.residual2_m].iter().flatten().count();
        let seen = found.motion.iter().map(of_pose).sum();
        found.verdict = with_outliers(found.verdict, left_out, seen, limits);
        if let Some(findings) = &mut found.findings {
            findings.outliers += left_out;
            findings.readings += left_out;
        }
    }
    found
}

/// A verdict on so many readings with so many outliers besides.
fn with_outliers(Verdict { mut doubts }: Verdict, left_out: usize, seen: usize, limits: &CertificateLimits) -> Verdict {
    let present = doubts.iter().position(|doubt| matches!(doubt, Doubt::Outliers { .. })).map(|at| doubts.remove(at));
    let (outliers, readings) = match present {
        Some(Doubt::Outliers { outliers, readings }) => (outliers + left_out, readings + left_out),
        _ => (left_out, seen + left_out),
    };
    doubts.extend(doubt_of_outliers(outliers, readings, &doubts, limits));
    Verdict::new(doubts)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE_M: f64 = 1e-4;

    fn circle() -> SupportFunction {
        SupportFunction::new(0.03, Vec::new())
    }

    /// So many poses with residuals of one size that change sign, but for those of `strays` (sample, palm, metres); and their log.
    fn felt(count: usize, strays: &[(usize, usize, f64)]) -> (Log, Vec<Pose>) {
        let left = |sample: usize, palm: usize| {
            let stray = strays.iter().find(|stray| (stray.0, stray.1) == (sample, palm));
            Some(stray.map_or(if (sample + palm).is_multiple_of(2) { NOISE_M } else { -NOISE_M }, |stray| stray.2))
        };
        let pose = |sample: usize| {
            let (residual1_m, residual2_m) = (left(sample, 0), left(sample, 1));
            Pose { residual1_m, residual2_m, ..Pose::of_test(sample as f64, 0.0) }
        };
        let palms = PalmPair::hinged(0.5, 1.9);
        let samples = (0..count).map(|sample| Sample::new(sample as f64, palms, 0.03, 0.04)).collect();
        (Log { samples }, (0..count).map(pose).collect())
    }

    fn left_out(count: usize, strays: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
        let (log, motion) = felt(count, strays);
        let Some((log, count)) = without_stray_readings(&log, &circle(), &motion, &CertificateLimits::default()) else {
            return Vec::new();
        };
        let missing = |(index, sample): (usize, &Sample)| {
            [sample.s1_m, sample.s2_m].into_iter().enumerate().filter(|s| s.1.is_none()).map(|s| (index, s.0)).collect()
        };
        let found: Vec<(usize, usize)> = log.samples.iter().enumerate().flat_map::<Vec<_>, _>(missing).collect();
        assert_eq!(found.len(), count);
        found
    }

    #[test]
    fn readings_far_beyond_most_are_left_out() {
        // The standard deviation of most is 1.48 of what they have.
        let limit_m = 1.4826 * STRAY_SDS * NOISE_M;
        assert!(limit_m > LEAST_SHARE * 0.03);
        assert_eq!(left_out(100, &[(20, 0, 1.01 * limit_m), (20, 1, -1.02 * limit_m)]), [(20, 0), (20, 1)]);
        assert_eq!(left_out(100, &[(20, 0, -1.01 * limit_m), (50, 1, 0.99 * limit_m)]), [(20, 0)]);
        assert_eq!(left_out(100, &[]), []);
    }

    #[test]
    fn of_a_sample_whose_orientation_is_bent_to_a_stray_reading_that_is_left_out() {
        let shape = crate::shape::ellipse(0.03, 0.024).expect("possible");
        let (log, mut motion) = felt(100, &[]);
        let at = |psi: f64| <[f64; 2]>::from(log.samples[40].palms.contact_positions_m(&shape, psi));
        let bent_rad = 0.8;
        motion[40].psi_rad = bent_rad;
        let moved = [0, 1].map(|palm| at(bent_rad)[palm] - at(0.0)[palm]);
        assert!(moved[0].abs() > 2e-3 && moved[1].abs() > 1e-3, "{moved:?}");
        // Contact 1 was read where it should be but for the noise, contact 2 where the bent orientation has it and farther.
        (motion[40].residual1_m, motion[40].residual2_m) = (Some(-moved[0]), Some(1e-4));
        let (without, count) =
            without_stray_readings(&log, &shape, &motion, &CertificateLimits::default()).expect("one stray reading");
        assert!(count == 1 && without.samples[40].s1_m.is_some() && without.samples[40].s2_m.is_none());
        let is_none =
            |motion: &[Pose]| without_stray_readings(&log, &shape, motion, &CertificateLimits::default()).is_none();
        // Where the object turned, it may have been anywhere on the way.
        let mut turned = motion.clone();
        turned[41..].iter_mut().for_each(|pose| pose.psi_rad = bent_rad);
        assert!(is_none(&turned));
        // And beside a jump, wherever it was before.
        [38, 42].into_iter().for_each(|first| {
            let mut jumped = motion.clone();
            jumped[first..].iter_mut().for_each(|pose| pose.piece = 1);
            assert_eq!(is_none(&jumped), first > 38);
        });
    }

    /// A motion at rest but for samples that are `off_rad` away, in pieces of their own, and a jump by `jump_rad` after them.
    fn with_excursion(samples: Range<usize>, off_rad: f64, jump_rad: f64) -> Vec<Pose> {
        let (_, mut motion) = felt(100, &[]);
        for (sample, pose) in motion.iter_mut().enumerate() {
            let after = sample >= samples.end;
            pose.psi_rad = if samples.contains(&sample) { off_rad } else { f64::from(u8::from(after)) * jump_rad };
            pose.piece = u32::from(samples.contains(&sample)) + 2 * u32::from(after);
        }
        motion
    }

    #[test]
    fn a_few_samples_there_and_back_again_are_an_excursion() {
        let found = |samples: Range<usize>, jump_rad: f64| -> Vec<(usize, usize)> {
            let found = excursions(&with_excursion(samples, -1.0, jump_rad));
            found.into_iter().map(|excursion| (excursion.start, excursion.end)).collect()
        };
        assert_eq!(found(40..41, 0.0), vec![(40, 41)]);
        assert_eq!(found(40..40 + LONGEST_RUN, 0.9 * LONGEST_STEP), vec![(40, 40 + LONGEST_RUN)]);
        assert_eq!(found(40..41 + LONGEST_RUN, 0.0), vec![]);
        assert_eq!(found(40..41, 1.1 * LONGEST_STEP), vec![]);
        // One by less than the longest step is one, too.
        let small = |jump_rad: f64| excursions(&with_excursion(40..41, 0.6 * LONGEST_STEP, jump_rad)).len();
        assert_eq!((small(0.27 * LONGEST_STEP), small(0.33 * LONGEST_STEP)), (1, 0));
        // A whole turn on is where it was.
        let motion = with_excursion(40..42, 3.0, std::f64::consts::TAU + 0.01);
        let steady = without_excursions(&motion);
        assert!(steady.iter().all(|pose| pose.piece == 0 && pose.psi_rad.abs() < 0.011), "{:?}", steady[60]);
    }

    #[test]
    fn a_reading_that_sends_a_sample_elsewhere_is_left_out() {
        let shape = crate::shape::ellipse(0.03, 0.024).expect("possible");
        let (log, _) = felt(100, &[]);
        let mut motion = with_excursion(40..41, 0.8, 0.0);
        let at = |psi: f64| <[f64; 2]>::from(log.samples[40].palms.contact_positions_m(&shape, psi));
        // Contact 1 was read where it should be, and nothing is left where the sample was put.
        (motion[40].residual1_m, motion[40].residual2_m) = (Some(at(0.0)[0] - at(0.8)[0]), Some(1e-4));
        let limits = CertificateLimits::default();
        let (without, count) = without_stray_readings(&log, &shape, &motion, &limits).expect("one stray reading");
        assert!(count == 1 && without.samples[40].s1_m.is_some() && without.samples[40].s2_m.is_none());
    }

    #[test]
    fn what_is_missed_for_longer_is_no_stray_reading() {
        let run =
            |length: usize| -> Vec<(usize, usize, f64)> { (30..30 + length).map(|at| (at, at % 2, 5e-3)).collect() };
        assert_eq!(left_out(100, &run(LONGEST_RUN)).len(), LONGEST_RUN);
        // And with it left in, the rest is not even.
        assert_eq!(left_out(100, &run(LONGEST_RUN + 1)), []);
        let with_another: Vec<_> = run(LONGEST_RUN + 1).into_iter().chain([(80, 0, 5e-3)]).collect();
        assert_eq!(left_out(100, &with_another), []);
    }

    #[test]
    fn no_more_are_left_out_than_may_be() {
        // One reading in ten samples is one in twenty readings.
        let every =
            |step: usize| -> Vec<(usize, usize, f64)> { (2..990).step_by(step).map(|at| (at, 0, 5e-3)).collect() };
        assert_eq!(left_out(1000, &every(6)).len(), every(6).len());
        assert_eq!(left_out(1000, &every(4)), []);
    }

    #[test]
    fn what_was_left_out_counts_as_outliers_do() {
        let limits = CertificateLimits::default();
        let doubts =
            |before: Vec<Doubt>, left_out: usize| with_outliers(Verdict::new(before), left_out, 900, &limits).doubts;
        assert_eq!(doubts(Vec::new(), 90), []);
        assert_eq!(doubts(Vec::new(), 110), [Doubt::Outliers { outliers: 110, readings: 1010 }]);
        assert_eq!(
            doubts(vec![Doubt::NotConvex], 10),
            [Doubt::Outliers { outliers: 10, readings: 910 }, Doubt::NotConvex]
        );
        let more = doubts(vec![Doubt::NotConvex, Doubt::Outliers { outliers: 20, readings: 920 }], 10);
        assert_eq!(more, [Doubt::Outliers { outliers: 30, readings: 930 }, Doubt::NotConvex]);
    }
}
