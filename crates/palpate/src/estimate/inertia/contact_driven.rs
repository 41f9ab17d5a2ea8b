//! The motion of an object with inertia that follows from its contacts alone, whatever its shape.
//!
//! Where the contacts are, r₁ and r₂ give d₁ and d₂ (eq. 3 of Moll & Erdmann 2001), and they change with r_k' = d_k (Ω − p_k'), since r' = −d by the contact
//! angle. How fast a contact moves along its palm gives v_k, and W = 0 (`mechanics/inertial/moment.rs`), linear in Ω', the rest: (r₁, r₂, ψ, Ω) obey a
//! differential equation that the readings drive. Five numbers are left, (r₁, r₂, Ω) at one time, the radius of gyration and the damping. Of quasistatic
//! motion balance and virtual work leave one (`estimate/closed_form.rs`).
//!
//! Errors grow by a factor e within about the time √(R/g), forwards and backwards: a way through a few such times on either side is all that it gives.

use super::palm_path::PalmPath;
use crate::estimate::measurements::Measurements;
use crate::log::Log;
use crate::math::spline::FittedSpline;
use crate::mechanics::force_model::MotionState;
use crate::mechanics::inertial::{Inertia, MovingPalms, radii_of_curvature_in_motion_m};
use crate::palms::Contacts;
use crate::shape::SupportFunction;

/// Palms and contact positions at any time: splines through what a log says of them.
pub(crate) struct ContactPath {
    pub palms: PalmPath,
    s1: FittedSpline,
    s2: FittedSpline,
}

/// Palms and contacts at one time.
#[derive(Clone, Copy)]
pub(crate) struct Drive {
    pub palms: MovingPalms,
    /// Contact positions from the meeting point of the palms, metres.
    s_m: [f64; 2],
    /// How fast the contacts move along t̄_k, m/s.
    rates_m_per_s: [f64; 2],
}

/// An object on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InMotion {
    pub r_m: [f64; 2],
    pub psi_rad: f64,
    pub psi_rate: f64,
}

/// The same with its contacts, and the normal forces over the weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passed {
    pub state: InMotion,
    pub contacts: Contacts,
    pub normal_forces: [f64; 2],
}

impl ContactPath {
    /// Through the contacts of `measurements` that count. `None` where they are too few, times do not increase, or base points move.
    pub fn new(log: &Log, measurements: &Measurements) -> Option<Self> {
        let spline = |palm: usize| {
            let samples = log.samples.iter().zip(&measurements.instants);
            let seen = samples.filter_map(|(sample, instant)| {
                let (position, weight) = [(sample.s1_m, instant.weight1), (sample.s2_m, instant.weight2)][palm];
                position.filter(|_| weight > 0.0).map(|position| (sample.time_s, position))
            });
            let (times, positions): (Vec<f64>, Vec<f64>) = seen.unzip();
            FittedSpline::new(&times, &positions)
        };
        Some(Self { palms: PalmPath::new(log)?, s1: spline(0)?, s2: spline(1)? })
    }

    /// Palms and contacts at a time in seconds.
    pub fn at(&self, time_s: f64) -> Drive {
        let palms = self.palms.at(time_s);
        let ([s1, rate1, _], [s2, rate2, _]) = (self.s1.at(time_s), self.s2.at(time_s));
        let shift = palms.base_shifts_m;
        Drive { palms, s_m: [s1 + shift[0], s2 + shift[1]], rates_m_per_s: [rate1, -rate2] }
    }

    /// The same at both ends and in the middle of `steps` steps from a time on, of `step_s` seconds each; back in time where that is negative.
    pub fn along(&self, from_s: f64, step_s: f64, steps: usize) -> Vec<Drive> {
        (0..=2 * steps).map(|half| self.at(from_s + 0.5 * step_s * half as f64)).collect()
    }
}

impl Drive {
    /// Both radii of an object that touches the palms there and moves no contact off its foot: a disc.
    pub fn disc_radius_m(&self) -> f64 {
        let angles = &self.palms.angles;
        // (1 + cos φ₂)/sin φ₂ = 1/tan(φ₂/2).
        0.5 * (self.s_m[0] + self.s_m[1]) * angles.sin2 / (1.0 + angles.cos2)
    }

    /// An object in motion with its contacts as they were read, and the acceleration that goes with it.
    fn driven(&self, state: InMotion, inertia: Inertia) -> MotionState {
        let d = self.palms.angles.feet(state.r_m, self.s_m);
        let mut at = self.palms.carrying(Contacts { r: state.r_m, d, v: [0.0; 2] }, [state.psi_rate, 0.0]);
        at.contacts.v = radii_of_curvature_in_motion_m(&at, self.rates_m_per_s);
        accelerated(at, inertia)
    }

    /// The same with the contacts of a shape.
    fn carried(&self, shape: &SupportFunction, state: InMotion, inertia: Inertia) -> MotionState {
        let (theta1, theta2) = self.palms.pair.contact_angles(state.psi_rad);
        let contacts = Contacts::from([shape.at(theta1), shape.at(theta2)]);
        accelerated(self.palms.carrying(contacts, [state.psi_rate, 0.0]), inertia)
    }
}

/// The same state with the acceleration that goes with it, from one without: W is linear in it.
fn accelerated(mut at: MotionState, inertia: Inertia) -> MotionState {
    let moment = inertia.moment(&at, [0.0; 2]);
    at.psi_acceleration = -moment.value_m / moment.by_psi_acceleration;
    at
}

/// A rate of change.
type Rate = [f64; 4];

fn stepped(from: &InMotion, by: Rate, time_s: f64) -> InMotion {
    InMotion {
        r_m: [from.r_m[0] + time_s * by[0], from.r_m[1] + time_s * by[1]],
        psi_rad: from.psi_rad + time_s * by[2],
        psi_rate: from.psi_rate + time_s * by[3],
    }
}

/// The way of an object of any shape from its state at the first of these places, which lie half a step apart, to the last, one entry for each step; it
/// ends where it leads out of all bounds.
pub(crate) fn driven(drives: &[Drive], step_s: f64, start: InMotion, inertia: Inertia) -> Vec<Passed> {
    way(drives, step_s, start, inertia, &|drive, state| drive.driven(state, inertia))
}

/// The same of an object of this shape, whatever the contacts read.
pub(crate) fn carried(
    shape: &SupportFunction,
    drives: &[Drive],
    step_s: f64,
    start: InMotion,
    inertia: Inertia,
) -> Vec<Passed> {
    way(drives, step_s, start, inertia, &|drive, state| drive.carried(shape, state, inertia))
}

/// By the method of Runge and Kutta of order 4.
fn way(
    drives: &[Drive],
    step_s: f64,
    start: InMotion,
    inertia: Inertia,
    accelerated_at: &dyn Fn(&Drive, InMotion) -> MotionState,
) -> Vec<Passed> {
    let rate = |drive: &Drive, state: InMotion| -> (MotionState, Rate) {
        let at = accelerated_at(drive, state);
        let by_r = [0, 1].map(|k| at.contacts.d[k] * (state.psi_rate - drive.palms.rates[k]));
        (at, [by_r[0], by_r[1], state.psi_rate, at.psi_acceleration])
    };
    let passed = |state: InMotion, at: &MotionState| Passed {
        state,
        contacts: at.contacts,
        normal_forces: inertia.moment(at, [0.0; 2]).normal_forces,
    };
    let mut way = Vec::with_capacity(drives.len() / 2 + 1);
    let mut state = start;
    for places in drives.windows(3).step_by(2) {
        let (at, first) = rate(&places[0], state);
        way.push(passed(state, &at));
        let (_, second) = rate(&places[1], stepped(&state, first, 0.5 * step_s));
        let (_, third) = rate(&places[1], stepped(&state, second, 0.5 * step_s));
        let (_, fourth) = rate(&places[2], stepped(&state, third, step_s));
        let mean = [0, 1, 2, 3].map(|i| (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) / 6.0);
        state = stepped(&state, mean, step_s);
        if !(state.psi_rate.is_finite() && state.r_m.iter().all(|r| r.is_finite())) {
            return way;
        }
    }
    if let Some(last) = drives.last() {
        way.push(passed(state, &rate(last, state).0));
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::simulate::{ObjectInertia, SimulateOptions, Simulation, simulate};

    const INERTIA: Inertia = Inertia { gyration_m2: 4.5e-4, damping_per_s: 0.3 };

    /// Where a way begins, and how long and how fine it is.
    const FROM: usize = 400;
    const STEP_S: f64 = 0.005;
    const STEPS: usize = 60;

    fn shape() -> SupportFunction {
        SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
    }

    /// Between fast palms, without noise, at 200 Hz.
    fn swinging() -> Simulation {
        let motion = PalmMotion::random(3, 8.0, 0.5).and_then(|motion| motion.sample(200.0)).expect("possible");
        let inertia = ObjectInertia { gyration_radius_m: Some(INERTIA.gyration_m2.sqrt()), damping_per_s: 0.3 };
        let options =
            SimulateOptions { touchpad: Touchpad::ideal(), inertia: Some(inertia), ..SimulateOptions::default() };
        simulate(&shape(), &motion, &options).expect("possible")
    }

    /// The true state at a sample.
    fn state(run: &Simulation, index: usize) -> InMotion {
        let psi = |index: usize| run.truth.motion[index].psi_rad;
        let interval_s = run.log.samples[1].time_s - run.log.samples[0].time_s;
        // Five points: exact to the fourth power of the interval.
        let psi_rate =
            (psi(index - 2) - 8.0 * psi(index - 1) + 8.0 * psi(index + 1) - psi(index + 2)) / (12.0 * interval_s);
        let (theta1, theta2) = run.log.samples[index].palms.contact_angles(psi(index));
        InMotion { r_m: [theta1, theta2].map(|theta| shape().at(theta).r), psi_rad: psi(index), psi_rate }
    }

    /// The largest error of ψ along a way from `FROM` on (backwards with a negative step), and by how much the object turned on it.
    fn largest_error(run: &Simulation, step_s: f64, way: &[Passed]) -> (f64, f64) {
        let from = run.truth.motion[FROM].psi_rad;
        let off = way.iter().enumerate().map(|(step, passed)| {
            // One sample for each step.
            let index = if step_s > 0.0 { FROM + step } else { FROM - step };
            let truth = run.truth.motion[index].psi_rad;
            ((passed.state.psi_rad - truth).abs(), (truth - from).abs())
        });
        off.fold((0.0, 0.0), |most, off| (f64::max(most.0, off.0), f64::max(most.1, off.1)))
    }

    #[test]
    fn contacts_alone_drive_the_object_along_its_way() {
        let run = swinging();
        let path = ContactPath::new(&run.log, &Measurements::new(&run.log, None)).expect("long enough");
        let from_s = run.log.samples[FROM].time_s;
        for step_s in [STEP_S, -STEP_S] {
            let drives = path.along(from_s, step_s, STEPS);
            let way = driven(&drives, step_s, state(&run, FROM), INERTIA);
            assert_eq!(way.len(), STEPS + 1);
            let (off, turned) = largest_error(&run, step_s, &way);
            assert!(off < 2e-3 && turned > 0.2, "{off} of {turned}");
            assert!(way.iter().flat_map(|passed| passed.normal_forces).all(|force| force > 0.0));
            // Another radius of gyration leads elsewhere.
            let heavier = Inertia { gyration_m2: 1.5 * INERTIA.gyration_m2, ..INERTIA };
            let elsewhere = driven(&drives, step_s, state(&run, FROM), heavier);
            assert!(largest_error(&run, step_s, &elsewhere).0 > 10.0 * off);
        }
    }

    #[test]
    fn a_known_shape_is_carried_along_the_same_way_whatever_is_read() {
        let mut run = swinging();
        // Contacts that say nothing.
        run.log.samples.iter_mut().for_each(|sample| (sample.s1_m, sample.s2_m) = (Some(0.05), Some(0.05)));
        let path = ContactPath::new(&run.log, &Measurements::new(&run.log, None)).expect("long enough");
        let from_s = run.log.samples[FROM].time_s;
        for step_s in [STEP_S, -STEP_S] {
            let drives = path.along(from_s, step_s, STEPS);
            let way = carried(&shape(), &drives, step_s, state(&run, FROM), INERTIA);
            let (off, turned) = largest_error(&run, step_s, &way);
            assert!(off < 1e-3 && turned > 0.2, "{off} of {turned}");
        }
    }

    #[test]
    fn a_disc_touches_both_palms_at_its_feet() {
        let disc = SupportFunction::new(0.02, vec![]);
        let motion = PalmMotion::random(3, 20.0, 0.5).and_then(|motion| motion.sample(50.0)).expect("possible");
        let options = SimulateOptions { touchpad: Touchpad::ideal(), ..SimulateOptions::default() };
        let run = simulate(&disc, &motion, &options).expect("possible");
        let path = ContactPath::new(&run.log, &Measurements::new(&run.log, None)).expect("long enough");
        let radius_m = path.at(run.log.samples[30].time_s).disc_radius_m();
        assert!((radius_m - 0.02).abs() < 1e-6, "{radius_m}");
    }

    #[test]
    fn a_way_ends_where_it_leads_out_of_all_bounds() {
        let run = swinging();
        let path = ContactPath::new(&run.log, &Measurements::new(&run.log, None)).expect("long enough");
        let drives = path.along(run.log.samples[FROM].time_s, STEP_S, STEPS);
        let mad = InMotion { psi_rate: f64::INFINITY, ..state(&run, FROM) };
        assert_eq!(driven(&drives, STEP_S, mad, INERTIA).len(), 1);
    }
}
