//! When the palms pass where: a path over the surface with its corners rounded, and run through at an even pace.

use super::surface::Place;
use crate::palms::PalmMotion;

/// The path with four places put in between any two.
pub(super) fn subdivided(path: &[Place]) -> Vec<Place> {
    let mut fine = Vec::with_capacity(5 * path.len());
    for pair in path.windows(2) {
        for step in 0..5 {
            let between = |a: f64, b: f64| a + (b - a) * f64::from(step) / 5.0;
            let (a, b) = (&pair[0], &pair[1]);
            let (phi1, phi12) = (between(a.phi1, b.phi1), between(a.phi12, b.phi12));
            fine.push(Place { phi1, phi12, psi: between(a.psi, b.psi), stiffness: a.stiffness });
        }
    }
    fine.extend(path.last());
    fine
}

/// The path with its palm angles averaged over `width` places to either side, twice. The ends stay.
pub(super) fn smoothed(path: &[Place], width: usize) -> Vec<Place> {
    let mut smooth = path.to_vec();
    for _ in 0..2 {
        let rough = smooth.clone();
        for (index, place) in smooth.iter_mut().enumerate() {
            let reach = width.min(index).min(rough.len() - 1 - index);
            let around = &rough[index - reach..=index + reach];
            let count = around.len() as f64;
            place.phi1 = around.iter().map(|near| near.phi1).sum::<f64>() / count;
            place.phi12 = around.iter().map(|near| near.phi12).sum::<f64>() / count;
        }
    }
    smooth
}

/// The path run through in `duration_s`, at a pace that turns palms and object evenly and starts and ends gently.
pub(super) fn timed(path: &[Place], duration_s: f64) -> Option<PalmMotion> {
    let mut lengths = vec![0.0];
    for pair in path.windows(2) {
        let (turn1, turn12, psi) =
            (pair[1].phi1 - pair[0].phi1, pair[1].phi12 - pair[0].phi12, pair[1].psi - pair[0].psi);
        // A floor keeps times apart where nothing moves.
        let step = (turn1 * turn1 + turn12 * turn12 + psi * psi).sqrt().max(1e-4);
        lengths.push(lengths.last().copied().unwrap_or(0.0) + step);
    }
    let total = lengths.last().copied().filter(|total| *total > 0.0)?;
    // Over the first and last twentieth of the time the pace grows evenly from 0.
    let ease = 0.05;
    let time = |u: f64| -> f64 {
        let top = 1.0 / (1.0 - ease);
        let ramp = 0.5 * top * ease;
        if u < ramp {
            (2.0 * u * ease / top).sqrt()
        } else if u > 1.0 - ramp {
            1.0 - (2.0 * (1.0 - u).max(0.0) * ease / top).sqrt()
        } else {
            0.5 * ease + u / top
        }
    };
    let points: Vec<(f64, f64, f64)> = path
        .iter()
        .zip(&lengths)
        .map(|(place, length)| (duration_s * time(length / total), place.phi1, place.phi12 - place.phi1))
        .collect();
    PalmMotion::through(&points).ok()
}
