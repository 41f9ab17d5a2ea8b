//! Where an object rests and how it jumps, against hand calculation and brute force.

use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use palpate::mechanics::{EnergyLandscape, contact_forces_n, follow};
use palpate::palms::PalmPair;
use palpate::shape::{RandomShape, SupportFunction, ellipse, random_shape};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn pebble(seed: u64) -> SupportFunction {
    random_shape(&RandomShape::default(), seed).expect("the default kind is valid")
}

fn any_palms() -> impl Strategy<Value = PalmPair> {
    (0.1..1.4_f64, 0.3..1.0_f64).prop_map(|(phi1, part)| PalmPair::hinged(phi1, 0.3 + (PI - 0.2 - phi1 - 0.3) * part))
}

/// Height by the formula of the paper's frames, without the landscape.
fn height(shape: &SupportFunction, palms: &PalmPair, psi: f64) -> f64 {
    let (theta1, theta2) = palms.contact_angles(psi);
    palms.center_of_mass_m(shape.at(theta1), shape.at(theta2))[1]
}

/// The same cases every time; change the seed to explore.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn the_landscape_is_the_height_of_the_centre_of_mass(
        seed in 0_u64..10_000, palms in any_palms(), psi in -7.0..7.0_f64, bx in -0.05..0.05_f64, by in -0.05..0.05_f64,
    ) {
        let shape = pebble(seed);
        let palms = PalmPair { base1_m: [bx, by], base2_m: [-by, 0.3 * bx], ..palms };
        let landscape = EnergyLandscape::new(&shape, &palms);
        prop_assert!((landscape.height_m(psi) - height(&shape, &palms, psi)).abs() < 1e-14);
        let (theta1, theta2) = palms.contact_angles(psi);
        let (c1, c2) = (shape.at(theta1), shape.at(theta2));
        let g = c1.d * palms.phi12_rad().sin() + c2.d * palms.phi1_rad.sin();
        prop_assert!((landscape.balance_m(psi) - g).abs() < 1e-15);
        let slope = (c1.v - c1.r) * palms.phi12_rad().sin() + (c2.v - c2.r) * palms.phi1_rad.sin();
        prop_assert!((landscape.balance_slope_m(psi) - slope).abs() < 1e-14);
    }

    #[test]
    fn stable_poses_are_all_the_minima(seed in 0_u64..10_000, palms in any_palms()) {
        let shape = pebble(seed);
        let landscape = EnergyLandscape::new(&shape, &palms);
        let poses = landscape.stable_poses();
        let count = 4000;
        let h: Vec<f64> = (0..count).map(|i| height(&shape, &palms, TAU * f64::from(i) / f64::from(count))).collect();
        let minima: Vec<usize> = (0..h.len())
            .filter(|&i| h[i] < h[(i + h.len() - 1) % h.len()] && h[i] <= h[(i + 1) % h.len()])
            .collect();
        prop_assert_eq!(poses.len(), minima.len());
        for (pose, minimum) in poses.iter().zip(minima) {
            prop_assert!(landscape.balance_m(pose.psi_rad).abs() <= 1e-14 * shape.mean_radius_m());
            prop_assert!(pose.stiffness_m > 0.0);
            let apart = (pose.psi_rad - TAU * minimum as f64 / f64::from(count) + PI).rem_euclid(TAU) - PI;
            prop_assert!(apart.abs() < 2.0 * TAU / f64::from(count));
        }
    }

    #[test]
    fn descent_ends_in_the_next_minimum_downhill(seed in 0_u64..10_000, palms in any_palms(), psi in 0.0..TAU) {
        let shape = pebble(seed);
        let landscape = EnergyLandscape::new(&shape, &palms);
        let rest = landscape.descend(psi);
        prop_assert!(landscape.balance_m(rest).abs() <= 1e-14 * shape.mean_radius_m());
        prop_assert!(landscape.balance_slope_m(rest) > 0.0);
        // Downhill all the way.
        let mut last = landscape.height_m(psi);
        for step in 1..=500 {
            let now = landscape.height_m(psi + (rest - psi) * f64::from(step) / 500.0);
            prop_assert!(now <= last + 1e-16);
            last = now;
        }
    }

    #[test]
    fn a_pose_is_followed_and_jumps_go_down(seed in 0_u64..10_000, from in any_palms(), to in any_palms(), psi in 0.0..TAU) {
        let shape = pebble(seed);
        let mut steps = Vec::new();
        let Ok((end, jumps)) = follow(&shape, (2.0, from), (4.0, to), psi, |_, palms, psi| {
            steps.push((*palms, psi));
            Ok::<(), Infallible>(())
        });
        let size = shape.mean_radius_m();
        for (palms, psi) in &steps {
            let landscape = EnergyLandscape::new(&shape, palms);
            prop_assert!(landscape.balance_m(*psi).abs() <= 1e-12 * size);
            prop_assert!(landscape.balance_slope_m(*psi) > 0.0);
        }
        for jump in &jumps {
            prop_assert!(jump.physical && jump.height_after_m < jump.height_before_m);
            prop_assert!((2.0..=4.0).contains(&jump.time_s));
            // A pose that is about to vanish: balanced and stiff to nothing.
            let landscape = EnergyLandscape::new(&shape, &from.towards(&to, 0.5 * (jump.time_s - 2.0)));
            prop_assert!(landscape.balance_m(jump.psi_before_rad).abs() < 1e-8 * size);
            prop_assert!(landscape.balance_slope_m(jump.psi_before_rad).abs() < 1e-3 * size);
        }
        // The same in 700 small pieces, and by plain descent in far smaller steps.
        let (mut pieces, mut plain) = (EnergyLandscape::new(&shape, &from).descend(psi), psi);
        let mut pieces_jumps = 0;
        for i in 0..700 {
            let (a, b) = (from.towards(&to, f64::from(i) / 700.0), from.towards(&to, f64::from(i + 1) / 700.0));
            let Ok((next, some)) = follow(&shape, (0.0, a), (1.0, b), pieces, |_, _, _| Ok::<(), Infallible>(()));
            (pieces, pieces_jumps) = (next, pieces_jumps + some.len());
        }
        for i in 0..=20_000 {
            plain = EnergyLandscape::new(&shape, &from.towards(&to, f64::from(i) / 20_000.0)).descend(plain);
        }
        prop_assert_eq!(pieces_jumps, jumps.len());
        prop_assert!((pieces - end).abs() < 1e-9);
        prop_assert!((plain - end).abs() < 1e-9);
    }

    #[test]
    fn virtual_work_is_the_rate_of_the_height(seed in 0_u64..10_000, palms in any_palms(), psi in 0.0..TAU, rate1 in -1.0..1.0_f64, rate2 in -1.0..1.0_f64) {
        // h' = (φ₁' s₁ sin φ₁₂ − φ₁₂' s₂ sin φ₁) / sin φ₂ along a resting motion.
        let shape = pebble(seed);
        let rest = EnergyLandscape::new(&shape, &palms).descend(psi);
        prop_assume!(EnergyLandscape::new(&shape, &palms).balance_slope_m(rest) > 0.05 * shape.mean_radius_m());
        let step = 1e-5;
        let at = |time: f64| {
            let palms = PalmPair::hinged(palms.phi1_rad + rate1 * time, palms.phi2_rad + rate2 * time);
            let landscape = EnergyLandscape::new(&shape, &palms);
            landscape.height_m(landscape.descend(rest))
        };
        let slope = (at(step) - at(-step)) / (2.0 * step);
        let (s1, s2) = palms.contact_positions_m(&shape, rest);
        let work = (rate1 * s1 * palms.phi12_rad().sin() - (rate1 + rate2) * s2 * palms.phi1_rad.sin()) / palms.phi2_rad.sin();
        prop_assert!((slope - work).abs() < 1e-7, "{slope} {work}");
    }
}

#[test]
fn an_ellipse_in_an_upright_right_angle_rests_on_its_flat_sides() {
    // Palms at 45° and 135°: h ∝ r(θ₁) + r(θ₂) with θ₂ = θ₁ − π/2, so r₁² + r₂² = a² + b² and the sum is least where
    // one of them is b: the axes lie along the palms. Four poses a quarter turn apart, at h = (a + b)/√2.
    let (a, b) = (0.035, 0.025);
    let shape = ellipse(a, b).expect("valid axes");
    let palms = PalmPair::hinged(FRAC_PI_4, FRAC_PI_2);
    let poses = EnergyLandscape::new(&shape, &palms).stable_poses();
    assert_eq!(poses.len(), 4);
    for (index, pose) in poses.iter().enumerate() {
        let wanted = FRAC_PI_4 + FRAC_PI_2 * index as f64;
        assert!((pose.psi_rad - wanted).abs() < 1e-10, "{pose:?}");
        assert!((pose.height_m - (a + b) / 2f64.sqrt()).abs() < 1e-12);
    }
}

#[test]
fn an_ellipse_between_steep_palms_stands_between_flat_ones_lies() {
    // A centred ellipse under upright symmetry: between nearly flat palms it lies (long axis level), between steep ones it
    // stands on end. ψ = 0 has the long axis along X.
    let shape = ellipse(0.035, 0.025).expect("valid axes");
    for (phi2, lying) in [(2.6, true), (0.6, false)] {
        let palms = PalmPair::hinged(0.5 * (PI - phi2), phi2);
        let landscape = EnergyLandscape::new(&shape, &palms);
        let poses = landscape.stable_poses();
        assert_eq!(poses.len(), 2, "{poses:?}");
        assert_eq!(landscape.balance_slope_m(0.0) > 0.0, lying);
        assert!(landscape.balance_m(0.0).abs() < 1e-16 && landscape.balance_m(FRAC_PI_2).abs() < 1e-16);
    }
}

#[test]
fn a_disc_hangs_its_mass_down_and_a_circle_rests_anywhere() {
    let disc = SupportFunction::new(0.03, vec![[0.004, 0.003]]);
    let poses = EnergyLandscape::new(&disc, &PalmPair::hinged(0.4, 1.3)).stable_poses();
    assert_eq!(poses.len(), 1);
    // The centre of the disc lies at (0.004, 0.003) from the mass: straight above it at rest.
    assert!((poses[0].psi_rad + 3f64.atan2(4.0) - FRAC_PI_2).abs() < 1e-12);
    let circle = EnergyLandscape::new(&SupportFunction::new(0.03, vec![]), &PalmPair::hinged(0.4, 1.3));
    assert!(circle.is_flat() && circle.stable_poses().is_empty());
    assert_eq!(circle.descend(1.25), 1.25);
}

#[test]
fn the_palms_carry_the_weight() {
    let palms = PalmPair::hinged(0.5, 1.4);
    let (f1, f2) = contact_forces_n(&palms, 0.2);
    let (n1, n2) = (palms.normal(palpate::palms::Palm::One), palms.normal(palpate::palms::Palm::Two));
    assert!((f1 * n1[0] + f2 * n2[0]).abs() < 1e-14);
    assert!((f1 * n1[1] + f2 * n2[1] - 0.2 * 9.80665).abs() < 1e-14);
}

#[test]
fn nothing_hangs_on_odd_numbers() {
    let palms = PalmPair::hinged(0.5, 1.4);
    for harmonics in
        [vec![[f64::NAN, 0.0]], vec![[f64::INFINITY, 1.0]], vec![[1e300, 1e300]; 8], vec![[1e-300, 0.0]; 3]]
    {
        let shape = SupportFunction::new(0.03, harmonics);
        let landscape = EnergyLandscape::new(&shape, &palms);
        let _ = landscape.stable_poses();
        let _ = landscape.descend(0.3);
        let _ = landscape.descend(f64::NAN);
        let _ =
            follow(&shape, (0.0, palms), (1.0, PalmPair::hinged(0.6, 1.5)), 0.3, |_, _, _| Ok::<(), Infallible>(()));
        // And palms that turn without end come to one.
        let _ =
            follow(&shape, (0.0, palms), (1.0, PalmPair::hinged(1e300, 1.5)), 0.3, |_, _, _| Ok::<(), Infallible>(()));
    }
}
