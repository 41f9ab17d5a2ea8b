//! Logs of objects that were simulated, then spoilt as rigs and their owners spoil them: readings and times lost, repeated, swapped,
//! scaled, set to anything. The estimator returns: a result or an error, never a panic, and what is certified has numbers to show for it.
#![no_main]

use std::sync::OnceLock;

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use palpate::Log;
use palpate::log::Sample;
use palpate::palms::PalmMotion;
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};

/// Logs to begin with; longer ones only make a run slow.
const LOGS: u64 = 24;
const SAMPLES: usize = 60;

/// More mutations leave nothing of a log.
const MOST_MUTATIONS: usize = 8;

#[derive(Arbitrary, Debug)]
struct Input {
    log: u8,
    keep: u8,
    mutations: Vec<Mutation>,
}

/// Places are taken modulo the length of the log.
#[derive(Arbitrary, Debug)]
enum Mutation {
    Drop { at: u8, count: u8 },
    Repeat { at: u8, count: u8 },
    Swap { at: u8, with: u8 },
    Reverse,
    Missing { at: u8, count: u8, second: bool },
    Reading { at: u8, second: bool, value_m: f64 },
    Outlier { at: u8, second: bool, mm: i8 },
    Angle { at: u8, second: bool, value_rad: f64 },
    Bases { at: u8, base1_m: [f64; 2], base2_m: [f64; 2] },
    Time { at: u8, value_s: f64 },
    SwapContacts,
    SwapPalms,
    ScaleContacts { by: f32 },
    ScaleAngles { by: f32 },
    OffsetContacts { mm: i8 },
    Still { at: u8, count: u8 },
    Round { um: u16 },
}

fn logs() -> &'static [Log] {
    static LOGS_MADE: OnceLock<Vec<Log>> = OnceLock::new();
    LOGS_MADE.get_or_init(|| {
        let made = (0..LOGS).filter_map(|seed| {
            let names =
                [NamedShape::Egg, NamedShape::Stone, NamedShape::Pebble, NamedShape::Triangle, NamedShape::Ellipse];
            let shape = names[seed as usize % names.len()].shape(0.03).ok()?;
            let motion = PalmMotion::random(seed, 6.0 + seed as f64, 1.0).ok()?;
            let motion = motion.sample(SAMPLES as f64 / (7.0 + seed as f64)).ok()?;
            let touchpad = Touchpad { noise_sd_m: [0.0, 3e-5, 3e-4][seed as usize % 3], ..Touchpad::ideal() };
            let options = SimulateOptions { touchpad, seed, ..SimulateOptions::default() };
            simulate(&shape, &motion, &options).ok().map(|run| run.log)
        });
        made.collect()
    })
}

fn reading(sample: &mut Sample, second: bool) -> &mut Option<f64> {
    if second { &mut sample.s2_m } else { &mut sample.s1_m }
}

impl Mutation {
    fn apply(self, samples: &mut Vec<Sample>) {
        let length = samples.len();
        if length == 0 {
            return;
        }
        let place = |at: u8| at as usize % length;
        let range = |at: u8, count: u8| place(at)..(place(at) + count as usize % 16).min(length);
        match self {
            Self::Drop { at, count } => drop(samples.drain(range(at, count))),
            Self::Repeat { at, count } => {
                let range = range(at, count);
                let again = samples[range.clone()].to_vec();
                samples.splice(range.start..range.start, again).for_each(drop);
            }
            Self::Swap { at, with } => samples.swap(place(at), place(with)),
            Self::Reverse => samples.reverse(),
            Self::Missing { at, count, second } => {
                for sample in &mut samples[range(at, count)] {
                    *reading(sample, second) = None;
                }
            }
            Self::Reading { at, second, value_m } => *reading(&mut samples[place(at)], second) = Some(value_m),
            Self::Outlier { at, second, mm } => {
                if let Some(value_m) = reading(&mut samples[place(at)], second) {
                    *value_m += 1e-3 * f64::from(mm);
                }
            }
            Self::Angle { at, second, value_rad } => {
                let palms = &mut samples[place(at)].palms;
                if second { palms.phi2_rad = value_rad } else { palms.phi1_rad = value_rad }
            }
            Self::Bases { at, base1_m, base2_m } => {
                let palms = &mut samples[place(at)].palms;
                (palms.base1_m, palms.base2_m) = (base1_m, base2_m);
            }
            Self::Time { at, value_s } => samples[place(at)].time_s = value_s,
            Self::SwapContacts => {
                samples.iter_mut().for_each(|sample| std::mem::swap(&mut sample.s1_m, &mut sample.s2_m))
            }
            Self::SwapPalms => samples
                .iter_mut()
                .for_each(|sample| std::mem::swap(&mut sample.palms.phi1_rad, &mut sample.palms.phi2_rad)),
            Self::ScaleContacts { by } => samples.iter_mut().for_each(|sample| {
                (sample.s1_m, sample.s2_m) =
                    (sample.s1_m.map(|s| s * f64::from(by)), sample.s2_m.map(|s| s * f64::from(by)));
            }),
            Self::ScaleAngles { by } => samples.iter_mut().for_each(|sample| {
                sample.palms.phi1_rad *= f64::from(by);
                sample.palms.phi2_rad *= f64::from(by);
            }),
            Self::OffsetContacts { mm } => samples.iter_mut().for_each(|sample| {
                sample.s1_m = sample.s1_m.map(|s| s + 1e-3 * f64::from(mm));
            }),
            Self::Still { at, count } => {
                let still = samples[place(at)];
                for sample in &mut samples[range(at, count)] {
                    *sample = Sample { time_s: sample.time_s, ..still };
                }
            }
            Self::Round { um } => {
                let step = 1e-6 * f64::from(um.max(1));
                for sample in samples {
                    sample.s1_m = sample.s1_m.map(|s| (s / step).round() * step);
                    sample.s2_m = sample.s2_m.map(|s| (s / step).round() * step);
                }
            }
        }
    }
}

fuzz_target!(|input: Input| {
    let logs = logs();
    let mut log = logs[input.log as usize % logs.len()].clone();
    log.samples.truncate(8 + input.keep as usize % SAMPLES);
    for mutation in input.mutations.into_iter().take(MOST_MUTATIONS) {
        mutation.apply(&mut log.samples);
    }
    if let Ok(result) = palpate::reconstruct(&log) {
        assert_eq!(result.motion.len(), log.samples.len());
        if result.is_certified() {
            assert!(result.chi2_per_dof.is_finite() && result.sensor_sd_m.is_finite());
            assert!(result.outline.iter().all(|point| point.r_m.is_finite() && point.r_sd_m.is_finite()));
            assert!(result.motion.iter().all(|pose| pose.psi_rad.is_finite() && pose.psi_sd_rad.is_finite()));
        }
    }
});
