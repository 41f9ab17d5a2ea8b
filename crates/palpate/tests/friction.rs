//! The quasistatic motion under Coulomb friction against independent programs, limits and conservation of energy.

use palpate::mechanics::{ContactMode, EnergyLandscape, STANDARD_GRAVITY_M_PER_S2};
use palpate::palms::{PalmMotion, PalmPair};
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateError, SimulateOptions, Simulation, simulate};

fn shape() -> SupportFunction {
    SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
}

/// Palms that squeeze and turn for 20 s.
fn motion(samples: u32) -> Vec<(f64, PalmPair)> {
    let at = |index: u32| {
        let t = 20.0 * f64::from(index) / f64::from(samples - 1);
        (t, PalmPair::hinged(0.9 + 0.35 * (0.7 * t).sin(), 1.35 + 0.4 * (0.9 * t + 0.5).sin()))
    };
    (0..samples).map(at).collect()
}

fn run(motion: &[(f64, PalmPair)], friction: [f64; 2]) -> Simulation {
    let options = SimulateOptions { friction, start_psi_rad: 0.4, with_forces: true, ..SimulateOptions::default() };
    simulate(&shape(), motion, &options).expect("possible")
}

/// ψ at every other second by another program, which takes one implicit step for each half sample and chooses the mode of each by the sign
/// of the moments at its end.
#[test]
fn another_program_finds_the_same_motion() {
    let reference = [
        (
            [0.2, 0.2],
            [0.4, 0.747487, 0.736727, 0.949838, 1.674649, 2.092291, 1.845902, 1.948499, 1.818024, 1.550487, 2.000796],
        ),
        (
            [0.05, 0.3],
            [0.4, 0.747487, 0.736727, 0.949838, 1.269156, 1.740699, 2.094872, 1.350777, 1.138036, 1.733623, 1.888419],
        ),
        (
            [0.1, 0.1],
            [0.4, 0.747487, 0.736727, 1.476549, 2.049962, 2.091284, 1.857436, 1.918005, 1.787499, 1.571787, 2.067368],
        ),
    ];
    for (friction, expected) in reference {
        let found = run(&motion(8001), friction);
        for (index, expected) in expected.into_iter().enumerate() {
            let psi = found.truth.motion[800 * index].psi_rad;
            assert!((psi - expected).abs() < 5e-4, "{friction:?} at {} s: {psi} {expected}", 2 * index);
        }
    }
}

#[test]
fn without_friction_the_object_stays_in_the_minimum_of_its_energy() {
    // Friction of a millionth: within a millionth of the radius, over the stiffness, of the minimum.
    let motion = motion(401);
    let found = run(&motion, [1e-6; 2]);
    let without = run(&motion, [0.0; 2]);
    assert!(without.modes.is_empty() && found.modes.len() == motion.len());
    assert_eq!(found.jumps.len(), without.jumps.len());
    for (a, b) in found.truth.motion.iter().zip(&without.truth.motion) {
        assert!((a.psi_rad - b.psi_rad).abs() < 1e-4, "{} {}", a.psi_rad, b.psi_rad);
    }
}

#[test]
fn samples_in_between_change_nothing() {
    let (coarse, fine) = (motion(201), motion(201));
    let fine: Vec<(f64, PalmPair)> = fine
        .windows(2)
        .flat_map(|pair| {
            let [(from_s, from), (to_s, to)] = [pair[0], pair[1]];
            [0.0, 0.37].map(|share| (from_s + share * (to_s - from_s), from.towards(&to, share)))
        })
        .chain(fine.last().copied())
        .collect();
    let (coarse, fine) = (run(&coarse, [0.15, 0.2]), run(&fine, [0.15, 0.2]));
    for (index, pose) in coarse.truth.motion.iter().enumerate() {
        let other = fine.truth.motion[2 * index];
        assert!((pose.psi_rad - other.psi_rad).abs() < 1e-9, "{index}: {} {}", pose.psi_rad, other.psi_rad);
    }
}

#[test]
fn the_palms_do_the_work_that_lifts_the_object_and_rubs() {
    let motion = motion(20_001);
    let options =
        SimulateOptions { friction: [0.15, 0.2], start_psi_rad: 0.4, with_forces: true, ..SimulateOptions::default() };
    let found = simulate(&shape(), &motion, &options).expect("possible");
    // A slide at the start, before anything moves, is none of this.
    let from = found.jumps.last().map_or(0, |jump| motion.iter().filter(|(time_s, _)| *time_s <= jump.time_s).count());
    let (samples, poses) = (&found.log.samples[from..], &found.truth.motion[from..]);
    let weight_n = options.mass_kg * STANDARD_GRAVITY_M_PER_S2;
    let (mut work_j, mut rubbed_j) = (0.0, 0.0);
    for (samples, poses) in samples.windows(2).zip(poses.windows(2)) {
        let mean = |value: fn(&palpate::Sample) -> Option<f64>| {
            0.5 * (value(&samples[0]).unwrap_or(0.0) + value(&samples[1]).unwrap_or(0.0))
        };
        let palms = [samples[0].palms, samples[1].palms];
        let turned = [palms[1].phi1_rad - palms[0].phi1_rad, palms[1].phi12_rad() - palms[0].phi12_rad()];
        let (force1, force2) = (mean(|sample| sample.force1_n), mean(|sample| sample.force2_n));
        // Palm 2 presses on its other side.
        work_j += force1 * mean(|sample| sample.s1_m) * turned[0] - force2 * mean(|sample| sample.s2_m) * turned[1];
        // How far the material slips along palm k, by the rigid motion of the contact point.
        let (angle, centers) =
            (poses[1].psi_rad - poses[0].psi_rad, poses.iter().map(|pose| [pose.com_x_m, pose.com_y_m]));
        let centers: Vec<[f64; 2]> = centers.collect();
        for (k, palm) in [palpate::palms::Palm::One, palpate::palms::Palm::Two].into_iter().enumerate() {
            let t = palms[0].tangent(palm);
            let (s, force) = if k == 0 { (samples[0].s1_m, force1) } else { (samples[0].s2_m, force2) };
            let sign = if k == 0 { 1.0 } else { -1.0 };
            let contact = t.map(|t| sign * s.unwrap_or(0.0) * t);
            let arm = [contact[0] - centers[0][0], contact[1] - centers[0][1]];
            let moved =
                [centers[1][0] - centers[0][0] - angle * arm[1], centers[1][1] - centers[0][1] + angle * arm[0]];
            rubbed_j += options.friction[k] * force * (moved[0] * t[0] + moved[1] * t[1]).abs();
        }
    }
    let lifted_j = weight_n * (poses[poses.len() - 1].com_y_m - poses[0].com_y_m);
    assert!(rubbed_j > 0.005, "{rubbed_j}");
    assert!((work_j - lifted_j - rubbed_j).abs() < 2e-3 * rubbed_j, "{work_j} {lifted_j} {rubbed_j}");
}

#[test]
fn a_contact_sticks_or_slides_as_it_says() {
    let found = run(&motion(2001), [0.15, 0.2]);
    let count = |mode: fn(&[ContactMode; 2]) -> bool| found.modes.iter().filter(|modes| mode(modes)).count();
    // All three regimes, and never both at once while the opening changes.
    assert!(count(|modes| modes[0] == ContactMode::Stick) > 100 && count(|modes| modes[1] == ContactMode::Stick) > 100);
    assert!(count(|modes| !modes.contains(&ContactMode::Stick)) > 100);
    assert!(count(|modes| *modes == [ContactMode::Stick; 2]) <= 1);
}

#[test]
fn what_friction_holds_stays_and_what_it_does_not_slides() {
    let palms = PalmPair::hinged(0.8, 1.4);
    let still = vec![(0.0, palms), (1.0, palms)];
    let landscape = EnergyLandscape::new(&shape(), &palms);
    let rest = landscape.stable_poses()[1].psi_rad;
    let from = |start_psi_rad: f64, friction: f64| {
        let options = SimulateOptions { friction: [friction; 2], start_psi_rad, ..SimulateOptions::default() };
        simulate(&shape(), &still, &options).expect("possible").truth.motion[1].psi_rad
    };
    assert_eq!(from(rest + 0.02, 0.3), rest + 0.02);
    let slid = from(rest + 0.3, 0.01);
    assert!(slid < rest + 0.29 && slid > rest, "{slid} {rest}");
}

#[test]
fn an_egg_rolls_between_fingers_that_travel() {
    let egg = NamedShape::Egg.shape(0.03).expect("a positive size");
    let fingers = PalmMotion::random(5, 30.0, 0.5)
        .map(|motion| motion.with_bases([0.003, 0.0], [-0.003, 0.0]))
        .and_then(|motion| motion.sample(50.0))
        .expect("possible");
    let options = SimulateOptions { friction: [0.2; 2], ..SimulateOptions::default() };
    let found = simulate(&egg, &fingers, &options).expect("possible");
    assert!(found.truth.motion.iter().all(|pose| pose.psi_rad.is_finite()));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let narrow: Vec<(f64, PalmPair)> =
        [1.2, 0.3].iter().enumerate().map(|(index, opening)| (index as f64, PalmPair::hinged(1.4, *opening))).collect();
    let options = |friction| SimulateOptions { friction, ..SimulateOptions::default() };
    let result = |friction| simulate(&shape(), &narrow, &options(friction));
    assert!(matches!(result([0.6; 2]), Err(SimulateError::Jams { .. } | SimulateError::LeavesPalm { .. })));
    assert!(matches!(result([-0.1, 0.2]), Err(SimulateError::OutOfRange { .. })));
    assert!(matches!(result([0.1, f64::NAN]), Err(SimulateError::OutOfRange { .. })));
}
