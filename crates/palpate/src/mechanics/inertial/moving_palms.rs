//! Palms on their way, and a smooth way through palms given at some times.

use crate::mechanics::force_model::MotionState;
use crate::palms::{Contacts, PalmAngles, PalmPair};

/// The palms at some time, with the rates of their angles against the horizontal (rad/s) and accelerations (rad/s²); their base points stay.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingPalms {
    pub pair: PalmPair,
    pub angles: PalmAngles,
    pub rates: [f64; 2],
    pub accelerations: [f64; 2],
    /// How far each base point lies out on its palm from where the lines of the palms meet, metres.
    pub base_shifts_m: [f64; 2],
}

impl MovingPalms {
    pub fn new(pair: PalmPair, rates: [f64; 2], accelerations: [f64; 2]) -> Self {
        let angles = pair.angles();
        Self { pair, angles, rates, accelerations, base_shifts_m: pair.base_shifts_m(&angles) }
    }

    /// Cosines and sines of both contact angles of an object at some orientation.
    pub fn contact_directions(&self, psi: f64) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = (self.pair.phi1_rad - psi).sin_cos();
        self.angles.contact_directions(sin, cos)
    }

    /// An object between them with these contacts, ψ' and ψ''.
    pub fn carrying(&self, contacts: Contacts, [psi_rate, psi_acceleration]: [f64; 2]) -> MotionState {
        MotionState {
            palms: self.angles,
            contacts,
            base_shifts_m: self.base_shifts_m,
            palm_rates: self.rates,
            palm_accelerations: self.accelerations,
            psi_rate,
            psi_acceleration,
        }
    }

    /// The same palms turned by these angles against the horizontal, radians.
    pub fn turned(&self, [by1, by2]: [f64; 2]) -> Self {
        let pair =
            PalmPair { phi1_rad: self.pair.phi1_rad + by1, phi2_rad: self.pair.phi2_rad + by2 - by1, ..self.pair };
        Self::new(pair, self.rates, self.accelerations)
    }
}

/// A way through palms at given times: quintic polynomials between them, with the rates and accelerations of the polynomial through each of them
/// and its neighbours.
#[derive(Clone, Debug)]
pub(crate) struct PalmCurve {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    time_s: f64,
    pair: PalmPair,
    /// Angle, rate and acceleration of palm 1 and palm 2 against the horizontal.
    palms: [[f64; 3]; 2],
}

/// Palms whose polynomial gives the rate of the middle one.
const AROUND: usize = 5;

impl PalmCurve {
    /// Through palms whose times increase.
    pub fn new(motion: &[(f64, PalmPair)]) -> Self {
        let angles = |pair: &PalmPair| [pair.phi1_rad, pair.phi12_rad()];
        let count = AROUND.min(motion.len());
        let node = |(index, (time_s, pair)): (usize, &(f64, PalmPair))| {
            let first = index.saturating_sub(count / 2).min(motion.len() - count);
            let around = &motion[first..first + count];
            let palms = [0, 1].map(|palm| {
                let values: Vec<(f64, f64)> =
                    around.iter().map(|(time, pair)| (time - time_s, angles(pair)[palm])).collect();
                derivatives_at_zero(&values)
            });
            Node { time_s: *time_s, pair: *pair, palms }
        };
        Self { nodes: motion.iter().enumerate().map(node).collect() }
    }

    /// The palms at a time; before the first and after the last they are as there.
    pub fn at(&self, time_s: f64) -> MovingPalms {
        let after = self.nodes.partition_point(|node| node.time_s <= time_s);
        let (Some(from), Some(to)) = (self.nodes.get(after.wrapping_sub(1)), self.nodes.get(after)) else {
            let node = &self.nodes[after.saturating_sub(1).min(self.nodes.len() - 1)];
            let [one, two] = node.palms;
            return MovingPalms::new(node.pair, [one[1], two[1]], [one[2], two[2]]);
        };
        let step_s = to.time_s - from.time_s;
        let share = (time_s - from.time_s) / step_s;
        let [one, two] = [0, 1].map(|palm| quintic(from.palms[palm], to.palms[palm], share, step_s));
        let pair = from.pair.towards(&to.pair, share);
        let pair = PalmPair { phi1_rad: one[0], phi2_rad: two[0] - one[0], ..pair };
        MovingPalms::new(pair, [one[1], two[1]], [one[2], two[2]])
    }
}

/// Value and first two derivatives at 0 of the polynomial through these points (Newton's divided differences).
fn derivatives_at_zero(points: &[(f64, f64)]) -> [f64; 3] {
    let mut differences: Vec<f64> = points.iter().map(|(_, value)| *value).collect();
    for order in 1..points.len() {
        for i in (order..points.len()).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (points[i].0 - points[i - order].0);
        }
    }
    // Horner's scheme for the polynomial and its derivatives.
    let [mut value, mut first, mut second] = [0.0; 3];
    for (difference, (time, _)) in differences.iter().zip(points).rev() {
        second = first * 2.0 - second * time;
        first = value - first * time;
        value = difference - value * time;
    }
    [value, first, second]
}

/// Value and first two derivatives of the quintic with these values and derivatives at both ends, a share of the step on.
fn quintic(from: [f64; 3], to: [f64; 3], share: f64, step: f64) -> [f64; 3] {
    let (a, b, c) = (from[0], from[1] * step, 0.5 * from[2] * step * step);
    let rest = to[0] - a - b - c;
    let slope = to[1] * step - b - 2.0 * c;
    let bend = to[2] * step * step - 2.0 * c;
    let (d, e, f) = (
        10.0 * rest - 4.0 * slope + 0.5 * bend,
        -15.0 * rest + 7.0 * slope - bend,
        6.0 * rest - 3.0 * slope + 0.5 * bend,
    );
    let u = share;
    [
        a + u * (b + u * (c + u * (d + u * (e + u * f)))),
        (b + u * (2.0 * c + u * (3.0 * d + u * (4.0 * e + u * 5.0 * f)))) / step,
        (2.0 * c + u * (6.0 * d + u * (12.0 * e + u * 20.0 * f))) / (step * step),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_motion_is_followed_with_its_derivatives() {
        let phi1 = |t: f64| [0.8 + 0.3 * t - 0.2 * t.powi(4), 0.3 - 0.8 * t.powi(3), -2.4 * t * t];
        let phi12 = |t: f64| [2.1 - 0.4 * t * t, -0.8 * t, -0.8];
        let motion: Vec<(f64, PalmPair)> = (0..12)
            .map(|i| 0.1 * f64::from(i) + 0.01 * f64::from(i * i % 7))
            .map(|t| (t, PalmPair::hinged(phi1(t)[0], phi12(t)[0] - phi1(t)[0])))
            .collect();
        let curve = PalmCurve::new(&motion);
        for t in [0.0, 0.234, 0.55, 1.08] {
            let palms = curve.at(t);
            assert!(
                (palms.pair.phi1_rad - phi1(t)[0]).abs() < 1e-12
                    && (palms.pair.phi12_rad() - phi12(t)[0]).abs() < 1e-12
            );
            assert!((palms.rates[0] - phi1(t)[1]).abs() < 1e-10 && (palms.rates[1] - phi12(t)[1]).abs() < 1e-10);
            assert!((palms.accelerations[0] - phi1(t)[2]).abs() < 1e-8, "at {t}");
            assert!((palms.accelerations[1] - phi12(t)[2]).abs() < 1e-8, "at {t}");
        }
    }

    #[test]
    fn one_palm_position_stays() {
        let palms = PalmCurve::new(&[(1.0, PalmPair::hinged(0.5, 1.0))]).at(2.0);
        assert_eq!((palms.pair, palms.rates), (PalmPair::hinged(0.5, 1.0), [0.0; 2]));
    }
}
