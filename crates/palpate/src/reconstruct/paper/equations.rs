//! The paper's own method: equations 19 to 21 of Moll & Erdmann 2001, integrated over one piece of a log between jumps
//! (`docs/theory.md`, the paper's method; a printed copy of the equations drops the tildes).
//!
//! With the generalised contact support functions r̃₂ = −s₁ sin φ₂ and d̃₂ = s₁ cos φ₂ − s₂ (eq. 8), and d₁, d₂ from the
//! contact constraint (eq. 3),
//!
//! r₁' = −d₁ (φ₁' − ψ'),  r₂' = −d₂ (φ₁₂' − ψ'),
//!
//! ψ' = [r̃₂' cos φ₁ − d̃₂' sin φ₁ + d̃₂ φ₂' sin φ₁₂ / sin φ₂] / [r₁ sin φ₁₂ + (r₂ + r̃₂) sin φ₁ + d̃₂ cos φ₁].
//!
//! Sensor values and their rates come from local polynomials (Savitzky-Golay, [`crate::math::local_polynomial`]), the steps from
//! [`adams`]. The denominator of ψ' is the height of the point where the normals meet over the centre of mass (times sin φ₂). Where it
//! vanishes, so does the numerator, and the quotient is one of two errors: noise of the readings, and what the integral is off by. Against
//! noise the quotient n/q is damped towards the last rate, (n q + λ² ψ'₋)/(q² + λ²), with a λ that grows with the noise; a node next to
//! the crossing keeps the last rate. The height at a crossing is known from the readings alone, as the numerator has no height in it
//! ([`Signals::crossing_heights`]): there the search for the initial conditions begins.

use super::adams::{self, STARTING_STEPS};
use crate::estimate::closed_form::Contact;
use crate::estimate::measurements::Instant;
use crate::math::local_polynomial::Smoothing;
use crate::palms::PalmAngles;

/// A node where the denominator of ψ' is smaller than this share of what it changes by in a step is next to a crossing, and keeps the last
/// rate. From a quarter on, nodes that are sound lose theirs; at 0 none is kept. Both spoil a test in `tests.rs`.
const NEXT_TO_CROSSING: f64 = 0.1;

/// Damping λ for very noisy readings, as a share of the size of the object; the best value in `cargo xtask methods`.
const DAMPING: f64 = 0.1;

/// Noise, as a share of the size of the object, at which λ is half of [`DAMPING`].
const HALF_DAMPING_NOISE: f64 = 1e-3;

/// A sample this close to a node, as a share of the step, is taken to be at it.
const AT_NODE: f64 = 1e-6;

/// Palms and readings at one time, with their rates per second.
#[derive(Clone, Copy, Debug)]
struct Felt {
    phi1: f64,
    phi2: f64,
    s1: f64,
    s2: f64,
    phi1_rate: f64,
    phi2_rate: f64,
    s1_rate: f64,
    s2_rate: f64,
}

/// A piece of a log prepared for integration: smoothed, on a grid of even steps.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    times_s: Vec<f64>,
    step_s: f64,
    /// At the nodes of the grid.
    nodes: Vec<Felt>,
    /// In the middle of the first few steps, for Runge-Kutta.
    middles: Vec<Felt>,
    /// λ, metres.
    damping_m: f64,
}

impl Signals {
    /// From the instants of a piece, their times (which increase), the size of the object and the noise of the contacts in
    /// metres. `None` when there are too few.
    pub fn new(instants: &[Instant], times_s: &[f64], size_m: f64, noise_m: f64) -> Option<Self> {
        let channel = |value: fn(&Instant) -> f64| -> Vec<f64> { instants.iter().map(value).collect() };
        let channels = [channel(|i| i.phi1), channel(|i| i.phi2), channel(|i| i.s1), channel(|i| i.s2)];
        let [phi1, phi2, s1, s2] = [0, 1, 2, 3].map(|index| Smoothing::new(times_s, &channels[index]));
        let (phi1, phi2, s1, s2) = (phi1?, phi2?, s1?, s2?);
        let felt = |time_s: f64| {
            let ((phi1, phi1_rate), (phi2, phi2_rate)) = (phi1.at(time_s), phi2.at(time_s));
            let ((s1, s1_rate), (s2, s2_rate)) = (s1.at(time_s), s2.at(time_s));
            Felt { phi1, phi2, s1, s2, phi1_rate, phi2_rate, s1_rate, s2_rate }
        };
        let (first, last) = (*times_s.first()?, *times_s.last()?);
        let steps = times_s.len() - 1;
        let step_s = (last - first) / steps as f64;
        Some(Self {
            times_s: times_s.to_vec(),
            step_s,
            nodes: (0..=steps).map(|node| felt(first + step_s * node as f64)).collect(),
            middles: (0..STARTING_STEPS.min(steps)).map(|step| felt(first + step_s * (step as f64 + 0.5))).collect(),
            damping_m: DAMPING * size_m * noise_m / (noise_m + HALF_DAMPING_NOISE * size_m).max(f64::MIN_POSITIVE),
        })
    }

    /// r₁ and r₂ at the first instant if the centre of mass is `height_m` above the point where the palms meet, and below or
    /// above the point where the normals meet.
    pub fn start(&self, height_m: f64) -> (f64, f64) {
        let felt = &self.nodes[0];
        let palms = PalmAngles::new(felt.phi1, felt.phi2);
        palms.supports_of_center([palms.balance_x(felt.s1, felt.s2), height_m]).into()
    }

    /// Heights of the centre of mass at the first instant with which numerator and denominator of ψ' vanish together, one for each
    /// change of sign of the numerator. `relative_m` is the height at each sample over that at the first.
    pub fn crossing_heights(&self, relative_m: &[f64]) -> Vec<f64> {
        let first_s = self.times_s[0];
        let above_first_m = |time_s: f64| {
            let after = self.times_s.partition_point(|time| *time < time_s).clamp(1, self.times_s.len() - 1);
            let part = (time_s - self.times_s[after - 1]) / (self.times_s[after] - self.times_s[after - 1]);
            relative_m[after - 1] + (relative_m[after] - relative_m[after - 1]) * part
        };
        let numerator = |felt: &Felt| felt.numerator(PalmAngles::new(felt.phi1, felt.phi2));
        let crossing = |(node, pair): (usize, &[Felt])| {
            let [from, to] = [numerator(&pair[0]), numerator(&pair[1])];
            (from * to < 0.0).then(|| {
                let part = from / (from - to);
                let [low_m, high_m] = [pair[0].meeting_height_m(), pair[1].meeting_height_m()];
                low_m + (high_m - low_m) * part - above_first_m(first_s + self.step_s * (node as f64 + part))
            })
        };
        self.nodes.windows(2).enumerate().filter_map(crossing).collect()
    }

    /// Integrates from (r₁, r₂) at the first instant, where ψ = 0; returns the contacts at every sample.
    pub fn integrate(&self, start: (f64, f64)) -> Vec<Contact> {
        let steps = self.nodes.len() - 1;
        // The denominator and the rate at the time before, and at the latest.
        let (mut before, mut latest): (Option<Quotient>, Option<(usize, Quotient)>) = (None, None);
        let nodes = adams::integrate([start.0, start.1, 0.0], steps, self.step_s, |half, state| {
            let felt = if half % 2 == 0 { &self.nodes[half / 2] } else { &self.middles[half / 2] };
            // A time is asked for twice, with the predicted and with the corrected state.
            before = latest.filter(|(at, _)| *at < half).map(|(_, quotient)| quotient).or(before);
            let (slope, quotient) = slope(felt, state, self.damping_m, before);
            latest = Some((half, quotient));
            slope
        });
        let first = self.times_s[0];
        self.times_s
            .iter()
            .map(|time_s| {
                let place = ((time_s - first) / self.step_s).clamp(0.0, steps as f64);
                let (node, part) = if place.fract() < AT_NODE || place.fract() > 1.0 - AT_NODE {
                    (place.round() as usize, 0.0)
                } else {
                    (place as usize, place.fract())
                };
                let [r1, r2, psi] = between(&nodes[node], &nodes[(node + 1).min(steps)], self.step_s, part);
                let felt = |value: fn(&Felt) -> f64| {
                    let (a, b) = (value(&self.nodes[node]), value(&self.nodes[(node + 1).min(steps)]));
                    a + (b - a) * part
                };
                let palms = PalmAngles::new(felt(|f| f.phi1), felt(|f| f.phi2));
                let [d1, d2] = palms.feet([r1, r2], [felt(|f| f.s1), felt(|f| f.s2)]);
                Contact { psi, r1, d1, r2, d2 }
            })
            .collect()
    }
}

/// The denominator of ψ' and ψ' itself, at one time.
#[derive(Clone, Copy, Debug)]
struct Quotient {
    denominator_m: f64,
    psi_rate: f64,
}

impl Felt {
    /// Numerator of ψ'.
    fn numerator(&self, palms: PalmAngles) -> f64 {
        let PalmAngles { sin1, cos1, sin12, sin2, cos2, .. } = palms;
        let general_d2 = self.s1 * cos2 - self.s2;
        let general_r2_rate = -self.s1_rate * sin2 - self.s1 * cos2 * self.phi2_rate;
        let general_d2_rate = self.s1_rate * cos2 - self.s1 * sin2 * self.phi2_rate - self.s2_rate;
        general_r2_rate * cos1 - general_d2_rate * sin1 + general_d2 * self.phi2_rate * sin12 / sin2
    }

    /// Denominator of ψ'.
    fn denominator_m(&self, palms: PalmAngles, [r1, r2]: [f64; 2]) -> f64 {
        let PalmAngles { sin1, cos1, sin12, sin2, cos2, .. } = palms;
        let (general_r2, general_d2) = (-self.s1 * sin2, self.s1 * cos2 - self.s2);
        r1 * sin12 + (r2 + general_r2) * sin1 + general_d2 * cos1
    }

    /// Height of the point where the normals meet: that of a centre of mass with which the denominator of ψ' vanishes.
    fn meeting_height_m(&self) -> f64 {
        let palms = PalmAngles::new(self.phi1, self.phi2);
        let x = palms.balance_x(self.s1, self.s2);
        // Linear in the height.
        let [at_0, at_1] =
            [0.0, 1.0].map(|height_m| self.denominator_m(palms, palms.supports_of_center([x, height_m])));
        at_0 / (at_0 - at_1)
    }
}

/// Equations 19 to 21: the rates of (r₁, r₂, ψ), with λ, and with the quotient at the time before.
fn slope(felt: &Felt, &[r1, r2, _]: &[f64; 3], damping_m: f64, before: Option<Quotient>) -> ([f64; 3], Quotient) {
    let palms = PalmAngles::new(felt.phi1, felt.phi2);
    let (numerator, denominator_m) = (felt.numerator(palms), felt.denominator_m(palms, [r1, r2]));
    let damping = damping_m * damping_m;
    let psi_rate = match before {
        Some(before) if denominator_m.abs() < NEXT_TO_CROSSING * (denominator_m - before.denominator_m).abs() => {
            before.psi_rate
        }
        _ => {
            let last_rate = before.map_or(0.0, |before| before.psi_rate);
            let square = (denominator_m * denominator_m + damping).max(f64::MIN_POSITIVE);
            (numerator * denominator_m + damping * last_rate) / square
        }
    };
    let [d1, d2] = palms.feet([r1, r2], [felt.s1, felt.s2]);
    let rates = [-d1 * (felt.phi1_rate - psi_rate), -d2 * (felt.phi1_rate + felt.phi2_rate - psi_rate), psi_rate];
    (rates, Quotient { denominator_m, psi_rate })
}

/// Cubic Hermite interpolation between two nodes; `part` from 0 to 1.
fn between<const N: usize>(from: &adams::Node<N>, to: &adams::Node<N>, step: f64, part: f64) -> [f64; N] {
    let (u, u2) = (part, part * part);
    let u3 = u2 * u;
    std::array::from_fn(|i| {
        (2.0 * u3 - 3.0 * u2 + 1.0) * from.0[i]
            + (u3 - 2.0 * u2 + u) * step * from.1[i]
            + (3.0 * u2 - 2.0 * u3) * to.0[i]
            + (u3 - u2) * step * to.1[i]
    })
}
