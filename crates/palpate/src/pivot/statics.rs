//! Quasistatic equilibrium of an object that turns about a pivot P over a pad, with Coulomb friction at the contact.
//!
//! Forces in units of the weight. About P the moment of normal force N, friction F and gravity is
//!
//! M = −d N + r F + ρ sin(θ − θ₀),
//!
//! where θ is the body angle of the contact, ρ the distance of the centre of mass from P and θ₀ the contact angle of the object at rest.
//! A positive M turns the object counter-clockwise, which lowers θ. An arm that presses with the force w normal to the pad gives
//! N = w + cos(tilt). While |F| ≤ μ N suffices the object sticks and rolls, dθ = du/r as the foot of P moves by du; otherwise it turns
//! until it does: along the edge of the friction cone while it slides, by a leap where it tips over.

use crate::shape::SupportFunction;

/// Longest step in which an edge of the friction cone, or the first contact of a free swing, is looked for, radians: far less than r needs
/// to bend.
const LOOK_RAD: f64 = 4e-3;

/// Halvings of a bracket: to rounding.
const HALVINGS: usize = 60;

/// An object on its pivot over a pad.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pivoted<'a> {
    pub shape: &'a SupportFunction,
    /// Distance of the centre of mass from the pivot, metres.
    pub rho_m: f64,
    /// Contact angle θ₀ at rest, radians.
    pub rest_rad: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Cosine of the tilt of the pad: the weight that rests on it.
    pub cos_tilt: f64,
}

impl Pivoted<'_> {
    /// Friction over normal force that balance asks for at θ while the arm presses with `press` weights.
    fn needed(&self, theta: f64, press: f64) -> f64 {
        let contact = self.shape.at(theta);
        let normal = press + self.cos_tilt;
        (contact.d - self.rho_m * (theta - self.rest_rad).sin() / normal) / contact.r
    }

    /// Where the object comes to rest from θ while it is pressed on the pad.
    pub fn pressed(&self, theta: f64, press: f64) -> f64 {
        let excess = |theta: f64| {
            let needed = self.needed(theta, press);
            needed.signum() * (needed.abs() - self.friction).max(0.0)
        };
        let direction = excess(theta).signum();
        if excess(theta) == 0.0 {
            return theta;
        }
        let mut from = theta;
        // Within a turn there is a pose at rest: the energy has a minimum.
        while (from - theta).abs() <= std::f64::consts::TAU {
            let to = from + direction * LOOK_RAD;
            if excess(to) * direction <= 0.0 {
                // On the side where friction suffices.
                return bisected(from, to, |theta| excess(theta) * direction > 0.0);
            }
            from = to;
        }
        theta
    }

    /// Rolls while the foot of the pivot moves by `along_m`, then turns to where friction suffices.
    pub fn dragged(&self, theta: f64, along_m: f64, press: f64) -> f64 {
        let rate = |theta: f64| 1.0 / self.shape.radius_m(theta);
        let a = rate(theta) * along_m;
        let b = rate(theta + 0.5 * a) * along_m;
        let c = rate(theta + 0.5 * b) * along_m;
        let d = rate(theta + c) * along_m;
        self.pressed(theta + (a + 2.0 * b + 2.0 * c + d) / 6.0, press)
    }

    /// Where the object comes to rest from θ under its weight alone, with the pivot at a height over the pad, and whether it touches the pad
    /// there. It must not reach into the pad at θ.
    pub fn hanging(&self, theta: f64, height_m: f64) -> (f64, bool) {
        let away = crate::math::angle::wrapped(theta - self.rest_rad);
        let rest = theta - away;
        let steps = (away.abs() / LOOK_RAD).ceil().max(1.0);
        let step = -away / steps;
        let reaches = |theta: f64| self.shape.radius_m(theta) > height_m;
        for index in 0..steps as usize {
            let (from, to) = (theta + step * index as f64, theta + step * (index + 1) as f64);
            if reaches(to) {
                return (bisected(to, from, reaches), true);
            }
        }
        (rest, false)
    }

    /// Where the contact goes from θ when the pivot is lowered to a height: downhill on r, the way of `direction` (±1).
    pub fn lowered(&self, theta: f64, height_m: f64, direction: f64) -> f64 {
        let mut from = theta;
        let reaches = |theta: f64| self.shape.radius_m(theta) > height_m;
        while reaches(from) && (from - theta).abs() <= std::f64::consts::PI {
            let to = from + direction * LOOK_RAD;
            if !reaches(to) {
                return bisected(from, to, reaches);
            }
            from = to;
        }
        from
    }
}

/// The boundary between `inside`, which holds at `from`, and outside, where `to` is; a point outside, or on it.
fn bisected(mut from: f64, mut to: f64, inside: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if inside(middle) {
            from = middle;
        } else {
            to = middle;
        }
    }
    to
}

#[cfg(test)]
mod tests {
    use super::*;

    fn egg() -> SupportFunction {
        SupportFunction::new(0.03, vec![[0.002, 0.003], [0.0015, -0.001], [0.0004, 0.0002]])
    }

    #[test]
    fn without_friction_a_pressed_object_rests_where_the_energy_is_least() {
        let shape = egg();
        let object = Pivoted { shape: &shape, rho_m: 0.004, rest_rad: 0.7, friction: 0.0, cos_tilt: 1.0 };
        let theta = object.pressed(2.5, 3.0);
        // Height of the pivot, pressed with w + 1 weights, and of the centre of mass under it.
        let energy = |theta: f64| 4.0 * shape.radius_m(theta) - 0.004 * (theta - 0.7).cos();
        assert!((energy(theta + 1e-4) - energy(theta - 1e-4)).abs() < 1e-11);
        assert!(energy(theta + 0.05) > energy(theta) && energy(theta - 0.05) > energy(theta));
    }

    #[test]
    fn enough_friction_lets_it_roll_and_too_little_lets_it_slide() {
        let shape = egg();
        let rough = Pivoted { shape: &shape, rho_m: 0.0, rest_rad: 0.0, friction: 5.0, cos_tilt: 1.0 };
        let mut theta = 0.3;
        for _ in 0..1000 {
            theta = rough.dragged(theta, 1e-4, 3.0);
        }
        // Rolling: the way is the integral of r.
        let integral: f64 = (0..10_000).map(|i| shape.radius_m(0.3 + (theta - 0.3) * (f64::from(i) + 0.5) / 1e4)).sum();
        assert!((integral * (theta - 0.3) / 1e4 - 0.1).abs() < 1e-8);
        let smooth = Pivoted { friction: 0.05, ..rough };
        let mut at_edge = smooth.pressed(0.3, 3.0);
        for _ in 0..1000 {
            at_edge = smooth.dragged(at_edge, 1e-4, 3.0);
        }
        let contact = shape.at(at_edge);
        assert!((contact.d + 0.05 * contact.r).abs() < 1e-12, "slides at the edge of its cone");
        assert!((smooth.dragged(at_edge, 1e-4, 3.0) - at_edge).abs() < 1e-9);
    }

    #[test]
    fn an_object_hangs_at_rest_or_leans_on_the_pad() {
        let shape = egg();
        let object = Pivoted { shape: &shape, rho_m: 0.004, rest_rad: 0.7, friction: 0.3, cos_tilt: 1.0 };
        let (theta, touches) = object.hanging(2.0, 0.05);
        assert!((theta - 0.7).abs() < 1e-12 && !touches);
        let height = shape.radius_m(0.7) - 1e-3;
        let (theta, touches) = object.hanging(3.0, height.max(shape.radius_m(3.0)));
        assert!(touches || (theta - 0.7).abs() < 1e-12);
    }
}
