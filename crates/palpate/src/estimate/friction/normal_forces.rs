//! What pads that measure forces should read: the normal forces in some contact mode, N₁ and N₂ of [`cone`](crate::mechanics::coulomb) times the
//! weight. The ratio of a contact that slides is at the edge of its cone, and that of a contact that sticks is the one at which the moment
//! vanishes. So every sample tells of the centre of mass, whatever the friction, each palm by itself.

use crate::log::Log;
use crate::math::statistics::median;
use crate::mechanics::coulomb::{
    Ratios, at_the_edges, balancing_ratio, moment_by_psi, moment_by_ratio, moment_row, normal_forces,
    normal_forces_by_ratio,
};
use crate::palms::{ContactRow, Contacts, PalmAngles};

/// Normal forces over the weight at a sample, and what they depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NormalForces {
    pub over_weight: [f64; 2],
    tau: Ratios,
    /// The palm on which the contact sticks, within its cone.
    sticks: Option<usize>,
    /// Signs of the slips: with them friction gives the ratio of a contact that does not stick.
    signs: [f64; 2],
}

/// Derivatives of the normal force of one palm over the weight.
pub(crate) struct ByUnknowns {
    /// As a function of the contacts.
    pub contacts: ContactRow,
    pub psi: f64,
    /// By both coefficients of friction.
    pub friction: [f64; 2],
}

impl NormalForces {
    /// Between these ends of the cones; `None` where they say too little, or where the object jams.
    pub fn new(palms: &PalmAngles, at: &Contacts, friction: [f64; 2], ends: [[f64; 2]; 2]) -> Option<Self> {
        let differ = |palm: usize| ends[0][palm] != ends[1][palm];
        let mut signs = ends[0];
        let mut tau = at_the_edges(friction, signs);
        let mut sticks = None;
        match [differ(0), differ(1)] {
            [true, true] => return None,
            [false, false] => {}
            [first, _] => {
                let palm = usize::from(!first);
                let balancing = balancing_ratio(palms, at, tau, palm)?;
                if balancing.abs() < friction[palm] {
                    (tau[palm], sticks) = (balancing, Some(palm));
                } else {
                    signs[palm] = -balancing.signum();
                    tau = at_the_edges(friction, signs);
                }
            }
        }
        let over_weight = normal_forces(palms, tau)?;
        Some(Self { over_weight, tau, sticks, signs })
    }

    /// Derivatives of the force of a palm.
    pub fn by_unknowns(&self, palms: &PalmAngles, at: &Contacts, of: usize) -> ByUnknowns {
        let by_ratio = [0, 1].map(|k: usize| normal_forces_by_ratio(palms, self.tau, self.over_weight, k)[of]);
        let mut friction = [0, 1].map(|k: usize| -self.signs[k] * by_ratio[k]);
        let mut by = ByUnknowns { contacts: ContactRow { r: [0.0; 2], d: [0.0; 2], v: [0.0; 2] }, psi: 0.0, friction };
        if let Some(palm) = self.sticks {
            let other = 1 - palm;
            // The moment stays at 0: its ratio takes back what the rest changes.
            let share = -by_ratio[palm] / moment_by_ratio(palms, at, self.tau, palm);
            let row = moment_row(palms, self.tau);
            by.contacts = ContactRow { r: row.r.map(|by| share * by), d: row.d.map(|by| share * by), v: [0.0; 2] };
            by.psi = share * moment_by_psi(palms, at, self.tau);
            let moment_by_friction = -self.signs[other] * moment_by_ratio(palms, at, self.tau, other);
            friction[palm] = 0.0;
            friction[other] += share * moment_by_friction;
            by.friction = friction;
        }
        by
    }
}

/// The weight of an object, newtons, were it not for friction: the median of what each measured force says. 1 where none is measured.
pub(crate) fn weight_without_friction_n(log: &Log) -> f64 {
    let said = log.samples.iter().flat_map(|sample| {
        let over_weight = normal_forces(&sample.palms.angles(), [0.0; 2]);
        let of = |palm: usize| Some(sample.forces_n()[palm]? / over_weight?[palm]);
        [of(0), of(1)].into_iter().flatten().filter(|weight_n| weight_n.is_finite() && *weight_n > 0.0)
    });
    let mut said: Vec<f64> = said.collect();
    if said.is_empty() { 1.0 } else { median(&mut said) }
}

/// Forces look exchanged where the angles of the palms explain the exchanged ones to this share of what they leave of the others.
const EXCHANGED: f64 = 0.5;

/// Whether the forces of both palms look exchanged: friction turns what palms carry by a few degrees, and an exchange turns it over.
pub(crate) fn look_exchanged(log: &Log) -> bool {
    let both = log.samples.iter().filter_map(|sample| {
        let [first, second] = sample.forces_n();
        Some((first.zip(second)?, normal_forces(&sample.palms.angles(), [0.0; 2])?))
    });
    let both: Vec<((f64, f64), [f64; 2])> = both.collect();
    // What the best weight leaves.
    let left = |exchanged: bool| {
        let pairs = both.iter().flat_map(|((first, second), share)| {
            let (first, second) = if exchanged { (second, first) } else { (first, second) };
            [(*first, share[0]), (*second, share[1])]
        });
        let sums = pairs.fold([0.0; 3], |[ff, fs, ss], (force, share)| {
            [ff + force * force, fs + force * share, ss + share * share]
        });
        (sums[0] - sums[1] * sums[1] / sums[2]).max(0.0).sqrt()
    };
    left(true) < EXCHANGED * left(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use crate::shape::SupportFunction;

    const FRICTION: [f64; 2] = [0.3, 0.2];
    const PSI: f64 = 0.7;

    fn contacts(palms: &PalmPair, psi: f64, x: f64) -> Contacts {
        let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4]]).translated(x, 0.0);
        let (theta1, theta2) = palms.contact_angles(psi);
        Contacts::from([shape.at(theta1), shape.at(theta2)])
    }

    #[test]
    fn derivatives_match_finite_differences_in_every_mode() {
        const STEP: f64 = 1e-6;
        let palms = PalmPair::hinged(0.6, 1.3);
        let angles = palms.angles();
        let mut sticking = 0;
        for ends in
            [[[1.0, -1.0]; 2], [[1.0, -1.0], [-1.0, -1.0]], [[1.0, 1.0], [1.0, -1.0]], [[-1.0, 1.0], [1.0, 1.0]]]
        {
            let forces = |friction: [f64; 2], psi: f64, x: f64| {
                NormalForces::new(&angles, &contacts(&palms, psi, x), friction, ends).expect("not jammed")
            };
            let at = contacts(&palms, PSI, 0.0);
            let here = forces(FRICTION, PSI, 0.0);
            sticking += usize::from(here.sticks.is_some());
            for of in 0..2 {
                let by = here.by_unknowns(&angles, &at, of);
                let slope = |more: NormalForces, less: NormalForces| {
                    (more.over_weight[of] - less.over_weight[of]) / (2.0 * STEP)
                };
                let numeric = slope(forces(FRICTION, PSI + STEP, 0.0), forces(FRICTION, PSI - STEP, 0.0));
                assert!((by.psi - numeric).abs() < 1e-8, "{ends:?}: {} {numeric}", by.psi);
                for k in 0..2 {
                    let there = |step: f64| {
                        let mut friction = FRICTION;
                        friction[k] += step;
                        forces(friction, PSI, 0.0)
                    };
                    let numeric = slope(there(STEP), there(-STEP));
                    assert!((by.friction[k] - numeric).abs() < 1e-8, "{ends:?}: {} {numeric}", by.friction[k]);
                }
                let length = 1e-3 * STEP;
                let (more, less) = (forces(FRICTION, PSI, length), forces(FRICTION, PSI, -length));
                let numeric = (more.over_weight[of] - less.over_weight[of]) / (2.0 * length);
                let [more, less] = [1e-3, -1e-3].map(|x| contacts(&palms, PSI, x));
                let moved = |k: usize| ((more.r[k] - less.r[k]) / 2e-3, (more.d[k] - less.d[k]) / 2e-3);
                let exact: f64 = (0..2).map(|k| by.contacts.r[k] * moved(k).0 + by.contacts.d[k] * moved(k).1).sum();
                assert!((exact - numeric).abs() < 1e-4 * (1.0 + exact.abs()), "{ends:?}: {exact} {numeric}");
            }
        }
        assert!(sticking >= 2);
    }

    #[test]
    fn moments_about_the_hinge_balance_whatever_the_friction() {
        let palms = PalmPair::hinged(0.6, 1.3);
        let (angles, at) = (palms.angles(), contacts(&palms, PSI, 0.0));
        let [s1, s2] = angles.positions(at.r, at.d);
        let mut seen = 0;
        for ends in [[[1.0, -1.0], [-1.0, -1.0]], [[1.0, 1.0], [1.0, -1.0]], [[-1.0, 1.0], [1.0, 1.0]]] {
            let forces = NormalForces::new(&angles, &at, FRICTION, ends).expect("not jammed");
            if forces.sticks.is_none() {
                continue;
            }
            seen += 1;
            let [n1, n2] = forces.over_weight;
            // n̄₁ = (−sin φ₁, cos φ₁), n̄₂ = (sin φ₁₂, −cos φ₁₂): c from its heights over both palms.
            let x = (at.r[1] * angles.cos1 + at.r[0] * angles.cos12) / angles.sin2;
            assert!((n1 * s1 - n2 * s2 - x).abs() < 1e-15, "{} {x}", n1 * s1 - n2 * s2);
        }
        assert!(seen >= 2);
    }

    #[test]
    fn exchanged_forces_are_recognised_and_friction_is_no_exchange() {
        let log = |exchanged: bool, friction: f64| {
            let sample = |index: u32| {
                let t = 0.1 * f64::from(index);
                let palms = PalmPair::hinged(0.6 + 0.3 * t.sin(), 1.3 + 0.2 * (1.3 * t).sin());
                let tau = [friction * (0.7 * t).sin(), friction * (0.9 * t).cos()];
                let [first, second] = normal_forces(&palms.angles(), tau).expect("not jammed");
                let (first, second) = if exchanged { (second, first) } else { (first, second) };
                let felt = crate::log::Sample::new(t, palms, 0.03, 0.03);
                crate::log::Sample { force1_n: Some(first), force2_n: Some(second), ..felt }
            };
            Log { samples: (0..200).map(sample).collect() }
        };
        for friction in [0.0, 0.1, 0.3] {
            assert!(look_exchanged(&log(true, friction)), "{friction}");
            assert!(!look_exchanged(&log(false, friction)), "{friction}");
        }
        assert!(!look_exchanged(&Log::default()));
    }

    #[test]
    fn a_contact_that_may_stick_or_slide_on_either_palm_says_nothing() {
        let palms = PalmPair::hinged(0.6, 1.3);
        let at = contacts(&palms, PSI, 0.0);
        assert_eq!(NormalForces::new(&palms.angles(), &at, FRICTION, [[1.0, 1.0], [-1.0, -1.0]]), None);
    }
}
