use super::*;
use crate::palms::PalmMotion;
use crate::plan::{PalmLimits, plan_turn};
use crate::reconstruct::options::ReconstructOptions;
use crate::reconstruct::refine::job::Job;
use crate::sensor::Touchpad;
use crate::shape::{NamedShape, SupportFunction};
use crate::simulate::{SimulateOptions, simulate};
use std::cell::{Cell, RefCell};
use std::f64::consts::TAU;

/// Arrangements that a search finds in a log of a stone while none of them is accepted, and how often another explanation is asked for. The search goes
/// on where `goes_on` says so.
fn rejected(spend: bool, goes_on: &dyn Fn(Stage) -> bool) -> (usize, usize) {
    let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
    let motion = PalmMotion::random(3, 10.0, 0.6).and_then(|motion| motion.sample(10.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let log =
        simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible").log;
    let options = ReconstructOptions::default();
    let job = Job::new(&log, &options);
    while spend && !job.is_spent() {
        job.measurements.work.add_step(1_000_000, 50);
    }
    let (arrangements, asked) = (Cell::new(0), Cell::new(0));
    search(
        &Readings { goes_on, ..job.readings() },
        &|_, _| None,
        &|_| (),
        &mut || {
            asked.set(asked.get() + 1);
            false
        },
        &mut |_| {
            arrangements.set(arrangements.get() + 1);
            false
        },
    );
    (arrangements.get(), asked.get())
}

/// What is searched with the first trust in calibration and balance.
fn problem<'a>(job: &'a Job) -> Problem<'a> {
    let Readings { calibration, measurements, scatter_m, tolerances_m, prior, .. } = job.readings();
    let windows = windows(measurements, &segments(measurements, scatter_m), scatter_m, SAMPLES);
    let tolerance = Tolerance::new(measurements, tolerances_m[0], BALANCES[0]);
    Problem { calibration, measurements: Cow::Borrowed(measurements), windows, tolerance, prior }
}

#[test]
fn other_trusts_in_the_calibration_come_before_others_in_the_balance_and_equal_ones_once() {
    assert_eq!(ways(&[3e-4, 6e-4, 2e-4]), [(0, 0), (0, 1), (0, 2), (1, 0), (2, 0)]);
    assert_eq!(ways(&[3e-4; TRUSTS]), [(0, 0), (1, 0), (2, 0)]);
}

#[test]
fn once_the_work_is_spent_one_arrangement_is_judged_and_no_other_trust_in_the_balance_is_tried() {
    let (arrangements, asked) = rejected(false, &|_| true);
    assert!(arrangements > 3 && asked <= 1, "{arrangements} {asked}");
    let (arrangements, asked) = rejected(true, &|_| true);
    assert!(arrangements <= 1 && asked == 1, "{arrangements} {asked}");
}

#[test]
fn a_seed_that_errors_of_the_rig_may_spoil_is_calibrated_before_it_is_given_up() {
    let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
    let motion = PalmMotion::random(3, 10.0, 0.6).and_then(|motion| motion.sample(10.0)).expect("possible");
    let log = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible").log;
    let options = ReconstructOptions::default();
    let job = Job::new(&log, &options);
    let problem = problem(&job);
    let Problem { calibration, ref measurements, tolerance, .. } = problem;
    let span = spans(&problem.windows).into_iter().next().expect("a window");
    let seed = Seed::with_few_harmonics(&problem, span).expect("a candidate");
    let asked = Cell::new(0);
    let calibrate = |_: &Found| {
        asked.set(asked.get() + 1);
        Some(Corrected { calibration, measurements: measurements.as_ref().clone(), tolerance_m: tolerance.scatter_m })
    };
    // The readings are those of an exact rig, so that they explain it once it is calibrated.
    let with_misfit = |misfit: f64| {
        let Seed { span, candidates, order, .. } = &seed;
        let seed = Seed { span: span.clone(), candidates: candidates.clone(), order: *order, misfit };
        explained_seed(&seed, &problem, &calibrate).is_some()
    };
    assert!(with_misfit(0.9 * EXPLAINED) && with_misfit(0.99 * NEARLY_EXPLAINED));
    assert_eq!(asked.get(), 2);
    assert!(!with_misfit(1.01 * NEARLY_EXPLAINED));
    assert_eq!(asked.get(), 2);
    // A rig of which nothing is open cannot be what is wrong.
    let nearly = Seed { misfit: 1.01 * EXPLAINED, ..seed };
    assert!(explained_seed(&nearly, &problem, &|_| None).is_none());
}

#[test]
fn a_search_asks_after_the_first_way_and_after_an_equal_trust_and_ends_where_it_is_told() {
    let asked = RefCell::new(Vec::new());
    let until = |last: Stage| {
        asked.borrow_mut().clear();
        rejected(false, &|stage| {
            asked.borrow_mut().push(stage);
            stage != last
        })
    };
    let (soon, _) = until(Stage::FirstWay);
    assert_eq!(*asked.borrow(), [Stage::FirstWay]);
    let (later, otherwise) = until(Stage::EqualTrust);
    assert_eq!((asked.borrow().as_slice(), otherwise), ([Stage::FirstWay, Stage::EqualTrust].as_slice(), 0));
    let (all, _) = rejected(false, &|_| true);
    assert!(soon < later && later < all, "{soon} {later} {all}");
}

#[test]
fn stretches_over_nearly_flat_sides_are_explained_by_seeds_that_are_begun_anew() {
    // |x|^p + |y/q|^p = 1 by its support function: its curvature vanishes in the middle of each side.
    let (power, ratio) = (3.7_f64, 0.85_f64);
    let dual = power / (power - 1.0);
    let r =
        |theta: f64| 0.03 * (theta.cos().abs().powf(dual) + (ratio * theta.sin()).abs().powf(dual)).powf(1.0 / dual);
    let samples: Vec<(f64, f64)> =
        (0..720).map(|index| TAU * f64::from(index) / 720.0).map(|theta| (theta, r(theta))).collect();
    let superellipse = SupportFunction::from_samples(&samples, 120).expect("a shape");
    let shape = superellipse.translated(0.002, 0.001).rotated(0.3);
    let plan = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let motion = plan.motion.sample(15.0).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 3e-5, ..Touchpad::ideal() };
    let options = SimulateOptions { touchpad, start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    let log = simulate(&shape, &motion, &options).expect("possible").log;
    let options = ReconstructOptions::default();
    let job = Job::new(&log, &options);
    let problem = problem(&job);
    // An eighth of a turn and less, where 48 harmonics are enough.
    let length =
        |span: &Range<usize>| problem.windows[span.clone()].iter().map(|window| window.range.len()).sum::<usize>();
    let explained = |anew: bool| {
        let short = spans(&problem.windows).into_iter().filter(|span| (100..120).contains(&length(span)));
        let seeds = short.filter_map(|span| Seed::with_few_harmonics(&problem, span));
        seeds
            .filter_map(|mut seed| (seed.add_harmonics(&problem) || (anew && seed.begin_anew(&problem))).then_some(()))
            .count()
    };
    assert_eq!((explained(false), explained(true)), (0, 2));
}

/// A hexagon with sides so flat that few harmonics explain a stretch of it here and there, and never the whole log.
#[test]
fn more_harmonics_are_tried_before_anything_else_is_asked() {
    let shape = crate::shape::rounded_polygon(6, 0.1, 0.1).expect("a shape").scaled(0.03).translated(0.002, 0.001);
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let simulated = |seed: u64| {
        let motion = PalmMotion::random(seed, 40.0, 0.6).and_then(|motion| motion.sample(10.0)).ok()?;
        Some(simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).ok()?.log)
    };
    let options = ReconstructOptions::default();
    let few_and_more = |log| {
        let job = Job::new(&log, &options);
        let whole = |arranged: Arrangement| matches!(arranged, Arrangement::Whole(_));
        let few = with_few_harmonics(&problem(&job), &|_| None, &|_| (), &mut { whole }).is_none();
        let (more, asked) = (Cell::new(false), Cell::new(0));
        let goes_on = |_: Stage| {
            asked.set(asked.get() + 1);
            false
        };
        let accept = &mut |_: Found| {
            more.set(true);
            true
        };
        search(&Readings { goes_on: &goes_on, ..job.readings() }, &|_, _| None, &|_| (), &mut || false, accept);
        (few, more.get(), asked.get())
    };
    let mut found = (0..10).filter_map(simulated).map(few_and_more);
    assert!(found.any(|found| found == (false, true, 0)));
}
