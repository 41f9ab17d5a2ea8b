//! The palms: eq. 1 to 9 of Moll & Erdmann 2001 against the simulator, and palm motions.

use std::f64::consts::{FRAC_PI_2, PI};

use palpate::mechanics::EnergyLandscape;
use palpate::palms::{
    ContactRates, GeneralizedContactSupport, MotionError, Palm, PalmMotion, PalmMove, PalmPair, radii_of_curvature_m,
};
use palpate::shape::{RandomShape, SupportFunction, random_shape};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn pebble(seed: u64) -> SupportFunction {
    random_shape(&RandomShape::default(), seed).expect("the default kind is valid")
}

fn any_pair() -> impl Strategy<Value = PalmPair> {
    let base = || prop::array::uniform2(-0.02..0.02_f64);
    (-3.0..3.0_f64, 0.2..2.9_f64, base(), base()).prop_map(|(phi1_rad, phi2_rad, base1_m, base2_m)| PalmPair {
        phi1_rad,
        phi2_rad,
        base1_m,
        base2_m,
    })
}

fn turned(psi: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    [x * psi.cos() - y * psi.sin(), x * psi.sin() + y * psi.cos()]
}

/// The same cases every time; change the seed to explore.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn frames_of_object_and_palm_are_opposite_and_the_object_touches(
        seed in 0_u64..1000, pair in any_pair(), psi in -4.0..4.0_f64,
    ) {
        let shape = pebble(seed);
        let (theta1, theta2) = pair.contact_angles(psi);
        let (s1, s2) = pair.contact_positions_m(&shape, psi);
        let center = pair.center_of_mass_m(shape.at(theta1), shape.at(theta2));
        let (p1, p2) = pair.contact_points_m(s1, s2);
        for (palm, theta, point) in [(Palm::One, theta1, p1), (Palm::Two, theta2, p2)] {
            let outward = turned(psi, [theta.cos(), theta.sin()]);
            let normal = pair.normal(palm);
            prop_assert!((outward[0] + normal[0]).abs() < 1e-14 && (outward[1] + normal[1]).abs() < 1e-14);
            // eq. 2: the boundary point, carried along with the object, is the contact point on the palm.
            let x = shape.boundary_point(theta);
            let [dx, dy] = turned(psi, [x.x_m, x.y_m]);
            prop_assert!((center[0] + dx - point[0]).abs() < 1e-13 && (center[1] + dy - point[1]).abs() < 1e-13);
        }
        // eq. 4 to 7 are eq. 8.
        let (shaped, read) = (
            GeneralizedContactSupport::of_shape(&shape, theta1, pair.phi2_rad),
            GeneralizedContactSupport::of_readings(&pair, s1, s2),
        );
        for (a, b) in [(shaped.r1, read.r1), (shaped.d1, read.d1), (shaped.r2, read.r2), (shaped.d2, read.d2)] {
            prop_assert!((a - b).abs() < 1e-13, "{shaped:?} {read:?}");
        }
    }

    #[test]
    fn hinged_palms_give_equations_3_and_8(seed in 0_u64..1000, pair in any_pair(), psi in -4.0..4.0_f64) {
        let shape = pebble(seed);
        let pair = PalmPair::hinged(pair.phi1_rad, pair.phi2_rad);
        let (s1, s2) = pair.contact_positions_m(&shape, psi);
        let (sin2, cos2) = pair.phi2_rad.sin_cos();
        let read = GeneralizedContactSupport::of_readings(&pair, s1, s2);
        prop_assert!((read.r1 - s2 * sin2).abs() < 1e-14 && (read.d1 - (s2 * cos2 - s1)).abs() < 1e-14);
        prop_assert!((read.r2 + s1 * sin2).abs() < 1e-14 && (read.d2 - (s1 * cos2 - s2)).abs() < 1e-14);
        let (theta1, theta2) = pair.contact_angles(psi);
        let (contact1, contact2) = (shape.at(theta1), shape.at(theta2));
        let (d1, d2) = pair.foot_offsets_m(contact1.r, contact2.r, s1, s2);
        prop_assert!((d1 - contact1.d).abs() < 1e-13 && (d2 - contact2.d).abs() < 1e-13);
    }

    #[test]
    fn equation_9_gives_the_radii_of_curvature(
        seed in 0_u64..1000, phi1 in 0.3..0.9_f64, phi2 in 0.8..2.0_f64, psi in 0.0..6.0_f64,
        rate1 in -1.0..1.0_f64, rate2 in -1.0..1.0_f64, apart in 0.0..0.03_f64,
    ) {
        let shape = pebble(seed);
        let bases = |pair: PalmPair| PalmPair { base1_m: [apart, 0.0], base2_m: [-apart, 0.5 * apart], ..pair };
        let start = bases(PalmPair::hinged(phi1, phi2));
        let landscape = EnergyLandscape::new(&shape, &start);
        let rest = landscape.descend(psi);
        prop_assume!(landscape.balance_slope_m(rest) > 0.1 * shape.mean_radius_m());
        // Along a resting motion, by differences in time.
        let at = |time: f64| {
            let palms = bases(PalmPair::hinged(phi1 + rate1 * time, phi2 + rate2 * time));
            let psi = EnergyLandscape::new(&shape, &palms).descend(rest);
            let (s1, s2) = palms.contact_positions_m(&shape, psi);
            (palms.contact_angles(psi).0, GeneralizedContactSupport::of_readings(&palms, s1, s2))
        };
        let step = 1e-5;
        let ((theta_a, a), (theta_b, b)) = (at(-step), at(step));
        let slope = |a: f64, b: f64| (b - a) / (2.0 * step);
        let rates = ContactRates {
            theta1_rad_per_s: slope(theta_a, theta_b),
            phi2_rad_per_s: rate2,
            r1_m_per_s: slope(a.r1, b.r1),
            r2_m_per_s: slope(a.r2, b.r2),
        };
        prop_assume!(rates.theta1_rad_per_s.abs() > 0.05 && (rates.theta1_rad_per_s + rate2).abs() > 0.05);
        let (theta1, theta2) = start.contact_angles(rest);
        let (v1, v2) = radii_of_curvature_m(&at(0.0).1, &rates, phi2);
        prop_assert!((v1.unwrap_or(f64::NAN) - shape.at(theta1).v).abs() < 1e-6);
        prop_assert!((v2.unwrap_or(f64::NAN) - shape.at(theta2).v).abs() < 1e-6);
    }

    #[test]
    fn random_motions_keep_within_their_range(seed in 0_u64..1000, amplitude in 0.0..1.0_f64) {
        let motion = PalmMotion::random(seed, 9.0, amplitude).expect("in range");
        for (_, palms) in motion.sample(50.0).expect("never parallel") {
            let bisector = palms.phi1_rad + 0.5 * palms.phi2_rad;
            prop_assert!((bisector - FRAC_PI_2).abs() <= 35f64.to_radians());
            prop_assert!((40f64.to_radians()..=150f64.to_radians()).contains(&palms.phi2_rad));
            prop_assert!(palms.phi1_rad > 0.05 && palms.phi12_rad() < PI - 0.05);
        }
    }
}

#[test]
fn a_resting_contact_tells_no_curvature() {
    let contact = GeneralizedContactSupport { r1: 0.01, d1: -0.01, r2: -0.01, d2: -0.01 };
    let still = ContactRates { theta1_rad_per_s: 0.0, phi2_rad_per_s: 0.0, r1_m_per_s: 0.0, r2_m_per_s: 0.0 };
    assert_eq!(radii_of_curvature_m(&contact, &still, 1.5), (None, None));
}

#[test]
fn a_schedule_does_what_its_moves_say() {
    let there = vec![
        PalmMove::Rotate { angle_rad: 0.2, duration_s: 2.0 },
        PalmMove::Open { angle_rad: -0.4, duration_s: 1.0 },
        PalmMove::OpenOne { palm: Palm::One, angle_rad: 0.3, duration_s: 1.0 },
        PalmMove::OpenOne { palm: Palm::Two, angle_rad: 0.1, duration_s: 1.0 },
        PalmMove::Wait { duration_s: 0.5 },
    ];
    let start = PalmPair { base1_m: [0.01, 0.0], ..PalmPair::hinged(0.5, 1.5) };
    let motion = PalmMotion::schedule(start, &[PalmMove::BackAndForth { times: 2, moves: there }]).expect("possible");
    assert!((motion.duration_s() - 22.0).abs() < 1e-12);
    let close = |time: f64, phi1: f64, phi2: f64| {
        let palms = motion.at(time);
        assert!((palms.phi1_rad - phi1).abs() < 1e-12 && (palms.phi2_rad - phi2).abs() < 1e-12, "{time}: {palms:?}");
        assert_eq!(palms.base1_m, [0.01, 0.0]);
    };
    close(0.0, 0.5, 1.5);
    close(1.0, 0.6, 1.5);
    close(2.0, 0.7, 1.5);
    close(3.0, 0.9, 1.1);
    close(4.0, 0.6, 1.4);
    close(5.0, 0.6, 1.5);
    close(5.5, 0.6, 1.5);
    close(11.0, 0.5, 1.5);
    close(16.5, 0.6, 1.5);
    close(99.0, 0.5, 1.5);
    let samples = motion.sample(10.0).expect("possible");
    assert_eq!(samples.len(), 221);
    // Smooth: no step between samples beyond the greatest speed of a leg (15/8 of the mean).
    for pair in samples.windows(2) {
        assert!((pair[1].1.phi1_rad - pair[0].1.phi1_rad).abs() < 0.3 / 10.0 * 1.9);
    }
}

#[test]
fn palms_that_would_cross_are_refused_with_the_time() {
    let close = [PalmMove::Wait { duration_s: 1.0 }, PalmMove::Open { angle_rad: -2.0, duration_s: 2.0 }];
    let refused = PalmMotion::schedule(PalmPair::hinged(0.5, 1.5), &close);
    let Err(MotionError::Parallel { time_s, phi2_rad }) = refused else { panic!("{refused:?}") };
    assert!((2.0..3.0).contains(&time_s) && (phi2_rad - PI / 180.0).abs() < 1e-6);
    let open = [PalmMove::OpenOne { palm: Palm::Two, angle_rad: 2.0, duration_s: 1.0 }];
    assert!(matches!(PalmMotion::schedule(PalmPair::hinged(0.5, 1.5), &open), Err(MotionError::Parallel { .. })));
    assert!(matches!(PalmMotion::schedule(PalmPair::hinged(0.5, 0.0), &[]), Err(MotionError::Parallel { .. })));
    for bad in [f64::NAN, f64::INFINITY] {
        let moves = [PalmMove::Rotate { angle_rad: bad, duration_s: 1.0 }];
        assert!(matches!(
            PalmMotion::schedule(PalmPair::hinged(0.5, 1.0), &moves),
            Err(MotionError::OutOfRange { .. })
        ));
    }
    let backwards = [PalmMove::Wait { duration_s: -1.0 }];
    assert!(PalmMotion::schedule(PalmPair::hinged(0.5, 1.0), &backwards).is_err());
    assert!(PalmMotion::schedule(PalmPair::hinged(f64::NAN, 1.0), &[]).is_err());
    assert!(PalmMotion::random(1, -1.0, 0.5).is_err() && PalmMotion::random(1, 1.0, 2.0).is_err());
    let motion = PalmMotion::random(1, 1.0, 0.5).expect("in range");
    assert!(matches!(motion.sample(1e9), Err(MotionError::TooLong { .. })) && motion.sample(0.0).is_err());
    let endless = PalmMove::BackAndForth { times: u32::MAX, moves: vec![PalmMove::Wait { duration_s: 0.0 }] };
    assert!(PalmMotion::schedule(PalmPair::hinged(0.5, 1.0), &[endless]).is_err());
    let nothing = PalmMove::BackAndForth { times: u32::MAX, moves: vec![] };
    assert!(PalmMotion::schedule(PalmPair::hinged(0.5, 1.0), &[nothing]).is_ok());
}

#[test]
fn a_curve_goes_through_its_points() {
    let points = [(1.0, 0.5, 1.5), (2.0, 0.6, 1.2), (4.0, 0.3, 2.0)];
    let motion = PalmMotion::through(&points).expect("possible");
    for (time, phi1, phi2) in points {
        let palms = motion.at(time - 1.0);
        assert!((palms.phi1_rad - phi1).abs() < 1e-12 && (palms.phi2_rad - phi2).abs() < 1e-12);
    }
    assert!(PalmMotion::through(&points[..1]).is_err());
    assert!(PalmMotion::through(&[points[1], points[0]]).is_err());
    let squeeze = PalmMotion::squeeze_and_rotate(70.0, 2).expect("possible");
    assert!((squeeze.duration_s() - 70.0).abs() < 1e-9);
    for (_, palms) in squeeze.sample(5.0).expect("possible") {
        assert!(palms.phi1_rad > 0.02 && palms.phi12_rad() < PI - 0.02, "{palms:?}");
    }
}
