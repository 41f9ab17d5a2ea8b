//! What the script of the page draws, as JSON in millimetres and degrees.

use std::collections::BTreeSet;

use palpate::reconstruct::{CenterStrip, center_strips};
use palpate::{Log, Reconstruction};
use serde::Serialize;

use crate::html;
use crate::input::{ReportInput, TruthOverlay};
use crate::overlay::{SampledSupport, rotation_rad, wrapped};

/// Logs with more samples than this are thinned for the plots.
pub const MAX_SAMPLES_SHOWN: usize = 6000;

/// 95 % of a normal distribution lie within this many standard deviations.
pub(crate) const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

const MM_PER_M: f64 = 1e3;
const OUTLINE_POINTS: usize = 720;
/// Jumps beyond these are not marked.
pub(crate) const MAX_JUMPS_SHOWN: usize = 1000;
const HISTOGRAM_BINS: usize = 41;
/// Half of the histogram's range, in standard deviations of the sensor.
const HISTOGRAM_REACH: f64 = 4.0;

/// Columns of numbers; what is not finite becomes `null`.
#[derive(Serialize)]
struct Data {
    log: LogData,
    /// What was made of the log; the result first, then what fits equally well.
    arrangements: Vec<Arrangement>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct LogData {
    time_origin: f64,
    time: Vec<f64>,
    phi1: Vec<f64>,
    phi2: Vec<f64>,
    base: Option<[Vec<f64>; 4]>,
    s1: Vec<f64>,
    s2: Vec<f64>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Arrangement {
    psi: Vec<f64>,
    psi_band: Vec<f64>,
    /// Sign of the slip along palm 1 and palm 2 at each sample shown, 0 where the object sticks, null where it is not known; without friction
    /// nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    modes: Option<[Vec<Option<i8>>; 2]>,
    /// Coefficients of friction of palm 1 and palm 2, and the left and right edges of where each sample leaves the centre of mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    strips: Option<[Vec<f64>; 2]>,
    x: Vec<f64>,
    y: Vec<f64>,
    com_band: Vec<f64>,
    piece: Vec<u32>,
    residuals: [Residuals; 2],
    sensor_sd: f64,
    jumps: Vec<f64>,
    outline: Outline,
    centroid: [f64; 2],
    mean_radius: f64,
    truth: Option<TruthData>,
}

#[derive(Serialize)]
struct Outline {
    theta: Vec<f64>,
    r: Vec<f64>,
    band: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    v: Vec<f64>,
    touches: Vec<u32>,
    /// Whether a contact itself passed over it: the others of those that count as felt are known by symmetry.
    itself: Vec<bool>,
}

/// Residuals of one sensor: those shown, and statistics over all.
#[derive(Serialize)]
struct Residuals {
    values: Vec<f64>,
    count: usize,
    rms: f64,
    beyond2: usize,
    reach: f64,
    histogram: Vec<usize>,
}

/// Errors are estimate minus truth.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct TruthData {
    aligned: Vec<[f64; 2]>,
    own: Vec<[f64; 2]>,
    psi: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    psi_error: Vec<f64>,
    x_error: Vec<f64>,
    y_error: Vec<f64>,
    r_error: Vec<f64>,
}

/// The data of the page, ready to stand in a `<script>` element.
pub(crate) fn json(input: &ReportInput) -> String {
    // Plain structs of numbers: serialising them cannot fail, and an empty object draws an empty page.
    html::embed(&serde_json::to_string(&data(input)).unwrap_or_else(|_| "{}".to_owned()))
}

fn data(input: &ReportInput) -> Data {
    let shown = shown_samples(input);
    Data {
        log: log(input, &shown),
        arrangements: input.arrangements().map(|result| arrangement(input, result, &shown)).collect(),
    }
}

/// Clocks that count from 1970 would fill an axis with digits: the time that counts as 0, seconds.
pub(crate) fn time_origin_s(log: &Log) -> f64 {
    let start = log.samples.first().map_or(0.0, |first| first.time_s);
    if start.is_finite() && start.abs() > 1e5 { start } else { 0.0 }
}

fn log(input: &ReportInput, shown: &[usize]) -> LogData {
    let log = input.log;
    let mm = Millimetres::for_object_of(input.reconstruction.shape.mean_radius_m());
    let sample = |pick: &dyn Fn(&palpate::Sample) -> f64| shown.iter().map(|&i| pick(&log.samples[i])).collect();
    let time_origin = time_origin_s(log);
    let hinged =
        shown.iter().all(|&i| log.samples[i].palms.base1_m == [0.0; 2] && log.samples[i].palms.base2_m == [0.0; 2]);
    LogData {
        time_origin,
        time: sample(&|s| rounded(s.time_s - time_origin, 5)),
        phi1: sample(&|s| degrees(s.palms.phi1_rad)),
        phi2: sample(&|s| degrees(s.palms.phi2_rad)),
        base: (!hinged).then(|| {
            [
                sample(&|s| mm.of(s.palms.base1_m[0])),
                sample(&|s| mm.of(s.palms.base1_m[1])),
                sample(&|s| mm.of(s.palms.base2_m[0])),
                sample(&|s| mm.of(s.palms.base2_m[1])),
            ]
        }),
        s1: sample(&|s| mm.of_option(s.s1_m)),
        s2: sample(&|s| mm.of_option(s.s2_m)),
    }
}

fn arrangement(input: &ReportInput, result: &Reconstruction, shown: &[usize]) -> Arrangement {
    let mm = Millimetres::for_object_of(result.shape.mean_radius_m());
    let pose =
        |pick: &dyn Fn(&palpate::reconstruct::Pose) -> f64| shown.iter().map(|&i| pick(&result.motion[i])).collect();
    let time_origin = time_origin_s(input.log);
    let centroid = result.shape.centroid();
    Arrangement {
        psi: pose(&|p| degrees(p.psi_rad)),
        psi_band: pose(&|p| significant(TWO_SIDED_95 * p.psi_sd_rad.to_degrees())),
        modes: result.friction.map(|_| [0, 1].map(|palm| modes(result, shown, palm))),
        friction: result.friction.map(|friction| friction.coefficients.map(significant)),
        strips: result.friction.map(|_| strips(input.log, result, shown, mm)),
        x: pose(&|p| mm.of(p.com_x_m)),
        y: pose(&|p| mm.of(p.com_y_m)),
        com_band: pose(&|p| significant(TWO_SIDED_95 * p.com_sd_m * MM_PER_M)),
        piece: shown.iter().map(|&i| result.motion[i].piece).collect(),
        residuals: [residuals(result, shown, |p| p.residual1_m), residuals(result, shown, |p| p.residual2_m)],
        sensor_sd: significant(result.sensor_sd_m * MM_PER_M),
        jumps: result.jumps.iter().take(MAX_JUMPS_SHOWN).map(|jump| rounded(jump.time_s - time_origin, 5)).collect(),
        outline: outline(result, mm),
        centroid: [mm.of(centroid.x_m), mm.of(centroid.y_m)],
        mean_radius: mm.of(result.shape.mean_radius_m()),
        truth: input.truth.as_ref().map(|overlay| truth(input.log, result, overlay, shown, mm)),
    }
}

fn modes(result: &Reconstruction, shown: &[usize], palm: usize) -> Vec<Option<i8>> {
    shown.iter().map(|&i| result.motion[i].modes.map(|modes| modes[palm].slip_sign() as i8)).collect()
}

fn strips(log: &Log, result: &Reconstruction, shown: &[usize], mm: Millimetres) -> [Vec<f64>; 2] {
    let all = center_strips(log, result);
    let edge = |pick: fn(CenterStrip) -> f64| shown.iter().map(|&i| mm.of_option(all[i].map(pick))).collect();
    [edge(|strip| strip.low_m), edge(|strip| strip.high_m)]
}

/// Indices of the samples that are drawn: all of them, or evenly spaced ones with the ends of each piece and the worst
/// residuals between.
pub(crate) fn shown_samples(input: &ReportInput) -> Vec<usize> {
    let motion = &input.reconstruction.motion;
    let lengths = input.arrangements().map(|result| result.motion.len());
    let count = lengths.fold(input.log.samples.len(), usize::min);
    if count <= MAX_SAMPLES_SHOWN {
        return (0..count).collect();
    }
    let stride = count.div_ceil(MAX_SAMPLES_SHOWN / 3);
    let mut kept: BTreeSet<usize> = (0..count).step_by(stride).chain([count - 1]).collect();
    let ends = (1..count).filter(|&i| input.arrangements().any(|r| r.motion[i].piece != r.motion[i - 1].piece));
    kept.extend(ends.flat_map(|i| [i - 1, i]).take(MAX_SAMPLES_SHOWN / 3));
    let size = |i: usize| {
        let pose = &motion[i];
        pose.residual1_m.unwrap_or(0.0).abs().max(pose.residual2_m.unwrap_or(0.0).abs())
    };
    kept.extend(
        (0..count)
            .step_by(stride)
            .filter_map(|start| (start..count.min(start + stride)).max_by(|&a, &b| size(a).total_cmp(&size(b)))),
    );
    kept.into_iter().collect()
}

/// RMS half-width of the 95 % band of r over the felt boundary, metres.
pub(crate) fn felt_half_width_m(result: &Reconstruction) -> f64 {
    let felt = result.outline.iter().filter(|point| point.touches > 0).map(|point| TWO_SIDED_95 * point.r_sd_m);
    root_mean_square(felt)
}

fn outline(result: &Reconstruction, mm: Millimetres) -> Outline {
    let stride = result.outline.len().div_ceil(OUTLINE_POINTS).max(1);
    let points: Vec<_> = result.outline.iter().step_by(stride).collect();
    Outline {
        theta: points.iter().map(|p| degrees(p.theta_rad)).collect(),
        r: points.iter().map(|p| mm.of(p.r_m)).collect(),
        band: points.iter().map(|p| significant(TWO_SIDED_95 * p.r_sd_m * MM_PER_M)).collect(),
        x: points.iter().map(|p| mm.of(p.x_m)).collect(),
        y: points.iter().map(|p| mm.of(p.y_m)).collect(),
        v: points.iter().map(|p| mm.of(p.curvature_radius_m)).collect(),
        touches: points.iter().map(|p| p.touches).collect(),
        itself: result.felt_itself().into_iter().step_by(stride).collect(),
    }
}

fn residuals(
    result: &Reconstruction,
    shown: &[usize],
    pick: impl Fn(&palpate::reconstruct::Pose) -> Option<f64>,
) -> Residuals {
    let all: Vec<f64> = result.motion.iter().filter_map(&pick).filter(|value| value.is_finite()).collect();
    let rms = root_mean_square(all.iter().copied());
    let sd = [result.sensor_sd_m, rms].into_iter().find(|sd| sd.is_finite() && *sd > 0.0).unwrap_or(0.0);
    let mut histogram = vec![0; HISTOGRAM_BINS];
    for value in &all {
        let place = (value / sd / HISTOGRAM_REACH + 1.0) / 2.0 * HISTOGRAM_BINS as f64;
        if (0.0..HISTOGRAM_BINS as f64).contains(&place) {
            histogram[place as usize] += 1;
        }
    }
    Residuals {
        values: shown
            .iter()
            .map(|&i| pick(&result.motion[i]).map_or(f64::NAN, |value| significant(value * MM_PER_M)))
            .collect(),
        count: all.len(),
        rms: significant(rms * MM_PER_M),
        beyond2: all.iter().filter(|value| value.abs() > 2.0 * sd).count(),
        reach: significant(HISTOGRAM_REACH * sd * MM_PER_M),
        histogram,
    }
}

fn truth(log: &Log, result: &Reconstruction, overlay: &TruthOverlay, shown: &[usize], mm: Millimetres) -> TruthData {
    let truth = overlay.truth;
    let rotation = rotation_rad(result, truth);
    let support = SampledSupport::new(&truth.support);
    let boundary = |rotation: Option<f64>| -> Vec<[f64; 2]> {
        let points =
            support.as_ref().zip(rotation).map(|(support, rotation)| support.boundary_m(rotation, OUTLINE_POINTS));
        points.unwrap_or_default().into_iter().map(|[x, y]| [mm.of(x), mm.of(y)]).collect()
    };
    // A truth of another length belongs to another log.
    let motion = if truth.motion.len() == log.samples.len() { truth.motion.as_slice() } else { &[] };
    let pose = |pick: &dyn Fn(&palpate::truth::TruePose, &palpate::reconstruct::Pose) -> f64| -> Vec<f64> {
        shown.iter().map(|&i| motion.get(i).map_or(f64::NAN, |pose| pick(pose, &result.motion[i]))).collect()
    };
    let stride = result.outline.len().div_ceil(OUTLINE_POINTS).max(1);
    let r_error = |theta: f64, r: f64| match (&support, rotation) {
        (Some(support), Some(rotation)) if theta.is_finite() => r - support.r(theta - rotation),
        _ => f64::NAN,
    };
    TruthData {
        aligned: boundary(rotation),
        own: boundary(Some(0.0)),
        psi: pose(&|t, _| degrees(t.psi_rad)),
        x: pose(&|t, _| mm.of(t.com_x_m)),
        y: pose(&|t, _| mm.of(t.com_y_m)),
        psi_error: pose(&|t, p| {
            significant(wrapped(p.psi_rad + rotation.unwrap_or(f64::NAN) - t.psi_rad).to_degrees())
        }),
        x_error: pose(&|t, p| significant((p.com_x_m - t.com_x_m) * MM_PER_M)),
        y_error: pose(&|t, p| significant((p.com_y_m - t.com_y_m) * MM_PER_M)),
        r_error: result
            .outline
            .iter()
            .step_by(stride)
            .map(|p| significant(r_error(p.theta_rad, p.r_m) * MM_PER_M))
            .collect(),
    }
}

pub(crate) fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|v| v.is_finite()).fold((0.0, 0_usize), |(sum, n), v| (sum + v * v, n + 1));
    if count == 0 { f64::NAN } else { (sum / count as f64).sqrt() }
}

/// Metres to millimetres, rounded to what the eye can tell of an object of this size.
#[derive(Clone, Copy)]
struct Millimetres {
    decimals: i32,
}

impl Millimetres {
    fn for_object_of(radius_m: f64) -> Self {
        let size = (radius_m * MM_PER_M).abs();
        let digits = if size.is_finite() && size > 0.0 { size.log10().floor() } else { 0.0 };
        Self { decimals: (5.0 - digits).clamp(0.0, 12.0) as i32 }
    }

    fn of(self, metres: f64) -> f64 {
        rounded(metres * MM_PER_M, self.decimals)
    }

    fn of_option(self, metres: Option<f64>) -> f64 {
        metres.map_or(f64::NAN, |metres| self.of(metres))
    }
}

fn degrees(radians: f64) -> f64 {
    rounded(radians.to_degrees(), 4)
}

/// Rounded to a number of decimals.
pub(crate) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    let scaled = value * scale;
    // Beyond 2^53 there is nothing behind the point to round.
    if scaled.abs() < 9e15 { scaled.round() / scale } else { value }
}

/// Rounded to three significant digits.
fn significant(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    rounded(value, (2.0 - value.abs().log10().floor()).clamp(-300.0, 300.0) as i32)
}

#[cfg(test)]
mod tests {
    use super::{rounded, significant};

    #[test]
    fn rounding_keeps_what_it_cannot_round() {
        assert_eq!(rounded(1.234_56, 2), 1.23);
        assert_eq!(rounded(1e300, 4), 1e300);
        assert!(rounded(f64::NAN, 4).is_nan());
        assert_eq!(significant(0.012_345), 0.0123);
        assert_eq!(significant(-123_456.0), -123_000.0);
        assert_eq!(significant(0.0), 0.0);
        assert!(significant(5e-324).is_finite() && significant(1e308).is_finite());
    }
}
