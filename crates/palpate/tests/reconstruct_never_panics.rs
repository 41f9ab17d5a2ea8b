//! Whatever the numbers of a log are: an answer, or an error that says something; and no panic.

use palpate::palms::PalmPair;
use palpate::reconstruct::{Method, Reconstructor, diagnostics, reconstruct};
use palpate::{Log, Sample};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same cases every time; change the seed to explore.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() }
}

/// Samples that have nothing to do with each other, up to three of them with a number that no log should have.
fn wild(samples: std::ops::Range<usize>) -> impl Strategy<Value = Log> {
    let contact = || prop_oneof![9 => (0.01..0.06_f64).prop_map(Some), 1 => Just(None)];
    let sample = (0.2..1.2_f64, 0.6..2.4_f64, contact(), contact(), 0.0..0.1_f64);
    let absurd = prop_oneof![Just(0.0), Just(1e-300), Just(1e9), Just(-1e12), Just(f64::NAN), -1e3..1e3_f64];
    let absurd = prop::collection::vec((0..4_usize, 0..60_usize, absurd), 0..4);
    (prop::collection::vec(sample, samples), absurd).prop_map(|(samples, absurd)| {
        let mut time_s = 0.0;
        let samples = samples.into_iter().map(|(phi1_rad, phi2_rad, s1, s2, step)| {
            time_s += step;
            let mut sample = Sample::new(time_s, PalmPair::hinged(phi1_rad, phi2_rad), 0.0, 0.0);
            (sample.s1_m, sample.s2_m) = (s1, s2);
            sample
        });
        let mut log = Log { samples: samples.collect() };
        for (field, index, value) in absurd {
            let Some(sample) = log.samples.get_mut(index) else { continue };
            match field {
                0 => sample.palms.phi1_rad = value,
                1 => sample.palms.phi2_rad = value,
                2 => sample.s1_m = Some(value),
                _ => sample.s2_m = Some(value),
            }
        }
        log
    })
}

/// Smooth curves that no object need feel like, with a scale from a micrometre to a kilometre.
fn smooth() -> impl Strategy<Value = Log> {
    let wave = || (-1.0..1.0_f64, -1.0..1.0_f64, 0.1..3.0_f64);
    let missing = prop::collection::vec(prop::bool::weighted(0.1), 120);
    let base = prop::array::uniform4(-1.0..1.0_f64);
    (12..60_usize, [wave(), wave(), wave(), wave()], -6.0..3.0_f64, missing, base, prop::bool::ANY).prop_map(
        |(count, waves, exponent, missing, base, apart)| {
            let scale = 10f64.powf(exponent);
            let at =
                |wave: &(f64, f64, f64), t: f64| 0.5 * wave.0 * (wave.2 * t).sin() + 0.5 * wave.1 * (wave.2 * t).cos();
            let samples = (0..count).map(|index| {
                let t = 0.1 * index as f64;
                let mut palms = PalmPair::hinged(0.8 + 0.5 * at(&waves[0], t), 1.4 + at(&waves[1], t));
                if apart {
                    palms.base1_m = [scale * base[0], scale * base[1]];
                    palms.base2_m = [scale * base[2], scale * base[3]];
                }
                let (s1, s2) = (scale * (1.2 + at(&waves[2], t)), scale * (1.2 + at(&waves[3], t)));
                let mut sample = Sample::new(t, palms, s1, s2);
                sample.s1_m = sample.s1_m.filter(|_| !missing[2 * index]);
                sample.s2_m = sample.s2_m.filter(|_| !missing[2 * index + 1]);
                sample
            });
            Log { samples: samples.collect() }
        },
    )
}

fn survives(log: &Log) -> Result<(), TestCaseError> {
    survives_by(log, Method::Likelihood)
}

fn survives_by(log: &Log, method: Method) -> Result<(), TestCaseError> {
    let result = Reconstructor::new().method(method).run(log);
    match result {
        Ok(found) => {
            prop_assert_eq!(found.motion.len(), log.samples.len());
            prop_assert_eq!(diagnostics(log, &found).len(), log.samples.len());
            prop_assert!(found.is_certified() || found.verdict.reason().len() > 20, "{}", found.verdict);
            prop_assert!(!found.is_certified() || found.outline.iter().all(|point| point.r_m.is_finite()));
        }
        Err(error) => prop_assert!(error.to_string().len() > 20, "{error}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(10))]

    #[test]
    fn on_wild_logs(log in wild(12..60)) {
        survives(&log)?;
    }

}

proptest! {
    // Each is searched until its worth is spent.
    #![proptest_config(cases(4))]

    #[test]
    fn on_smooth_logs_of_nothing(log in smooth()) {
        survives(&log)?;
    }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn by_the_methods_that_integrate(wild in wild(12..60), smooth in smooth()) {
        for method in [Method::Ode, Method::Quadrature] {
            survives_by(&wild, method)?;
            survives_by(&smooth, method)?;
        }
    }
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn on_logs_too_short_or_empty(log in wild(0..12)) {
        prop_assert!(reconstruct(&log).is_err());
    }
}
