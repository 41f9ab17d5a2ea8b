//! The rolling closed forms: how ψ changes if the object rolls on a palm. Between palms hinged at a point that stays,
//!
//! on palm 1: ψ' = φ₁' + φ₂' s₂/(s₂ − s₁ cos φ₂),  on palm 2: ψ' = φ₁₂' − φ₂' s₁/(s₁ − s₂ cos φ₂),
//!
//! quadratures of the readings without an unknown and without the derivative of a contact position.

use crate::estimate::measurements::{Instant, Measurements};

/// ψ at every instant if the object rolls on a palm (0 or 1) all the time, from 0 at the first; steps by the mean of both ends.
pub(crate) fn rolling_motion(measurements: &Measurements, palm: usize) -> Vec<f64> {
    let mut psi = Vec::with_capacity(measurements.len());
    let mut sum = 0.0;
    psi.extend(measurements.instants.first().map(|_| sum));
    for pair in measurements.instants.windows(2) {
        let step =
            0.5 * (rolling_step(&pair[0], &pair[0], &pair[1], palm) + rolling_step(&pair[1], &pair[0], &pair[1], palm));
        sum += if step.is_finite() { step } else { 0.0 };
        psi.push(sum);
    }
    psi
}

/// The change of ψ between two instants with the contacts as they are at one.
fn rolling_step(at: &Instant, from: &Instant, to: &Instant, palm: usize) -> f64 {
    let (turn1, opening) = (to.phi1 - from.phi1, to.phi2 - from.phi2);
    if palm == 0 {
        turn1 + opening * at.s2 / (at.s2 - at.s1 * at.palms.cos2)
    } else {
        turn1 + opening - opening * at.s1 / (at.s1 - at.s2 * at.palms.cos2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    #[test]
    fn an_object_that_cannot_slide_on_one_palm_rolls_on_it() {
        let egg = NamedShape::Egg.shape(0.03).expect("a positive size");
        let at = |index: u32| {
            let t = 0.01 * f64::from(index);
            (t, PalmPair::hinged(1.0 + 0.2 * (0.5 * t).sin(), 1.3 + 0.2 * (0.9 * t).sin()))
        };
        let motion: Vec<(f64, PalmPair)> = (0..400).map(at).collect();
        for palm in [0, 1] {
            let mut friction = [0.0; 2];
            friction[palm] = 0.5;
            let options = SimulateOptions { friction, start_psi_rad: 0.3, ..SimulateOptions::default() };
            let run = simulate(&egg, &motion, &options).expect("possible");
            assert!(run.modes[1..].iter().all(|modes| modes[palm] == crate::mechanics::ContactMode::Stick));
            let psi = rolling_motion(&Measurements::new(&run.log, None), palm);
            let truth = &run.truth.motion;
            for (found, pose) in psi.iter().zip(truth) {
                let turned = pose.psi_rad - truth[0].psi_rad;
                assert!((found - turned).abs() < 1e-5, "{palm}: {found} {turned}");
            }
        }
    }
}
