//! Resampling of an arrangement between thinnings of the log: orientations by linear interpolation inside the arranged ranges,
//! and by the misfit of the contacts elsewhere.

use crate::estimate::association::candidates::best_orientation;
use crate::estimate::measurements::Measurements;
use crate::estimate::thinning::Thinning;
use crate::math::angle::wrapped;
use std::ops::Range;

/// The instants in these ranges thinned to about `count`, never across the edge of a range.
pub(crate) fn thinned_in_ranges(
    measurements: &Measurements,
    ranges: &[Range<usize>],
    noise_m: f64,
    count: usize,
) -> Measurements {
    let thinning = Thinning::to(measurements, ranges, noise_m, count);
    let runs: Vec<Range<usize>> = ranges.iter().flat_map(|range| thinning.runs(measurements, range)).collect();
    measurements.means(&runs)
}

/// Error of a contact position within which orientations explain it equally well, as a share of the mean radius.
const USUAL_ERROR: f64 = 1e-3;

/// Orientations at the instants of `to`, given those at the instants `from` (in order of time): interpolated inside the
/// arranged ranges, searched for everywhere else.
pub(crate) fn carry_over(
    from: &Measurements,
    psi: &[f64],
    coefficients: &[f64],
    to: &Measurements,
    ranges: &[Range<usize>],
) -> Vec<f64> {
    let places: Vec<f64> = from.instants.iter().map(|instant| instant.position).collect();
    let tolerance = (USUAL_ERROR * coefficients[0]).powi(2);
    let mut carried = Vec::with_capacity(to.len());
    for instant in &to.instants {
        let range = ranges.iter().find(|range| range.contains(&(instant.position.round() as usize)));
        let interpolated = range.and_then(|range| {
            let low = places.partition_point(|place| *place < range.start as f64 - 0.5);
            let high = places.partition_point(|place| *place < range.end as f64 - 0.5);
            (high > low).then(|| between(&places[low..high], &psi[low..high], instant.position))
        });
        let nearest = carried.last().copied().unwrap_or_else(|| psi.first().copied().unwrap_or(0.0));
        carried.push(interpolated.unwrap_or_else(|| best_orientation(instant, coefficients, nearest, tolerance)));
    }
    carried
}

/// Linear interpolation, constant beyond the ends.
fn between(places: &[f64], psi: &[f64], place: f64) -> f64 {
    let after = places.partition_point(|other| *other < place);
    if after == 0 {
        psi[0]
    } else if after == places.len() {
        psi[after - 1]
    } else {
        let share = (place - places[after - 1]) / (places[after] - places[after - 1]);
        psi[after - 1] + share * wrapped(psi[after] - psi[after - 1])
    }
}
