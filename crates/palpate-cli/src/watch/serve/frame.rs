//! An estimate as the page draws it: short keys, lengths in millimetres, and no more digits than can be seen.

use palpate::Sample;
use palpate::live::Estimate;
use palpate::pivot::{PadPose, PivotSample, StrokesEstimate};
use palpate::reconstruct::OutlinePoint;
use palpate_live::Losses;
use serde_json::{Value, json};

/// Points of the outline that are drawn, of 720.
const EVERY: usize = 4;

/// What changes with every frame.
pub fn of(sample: &Sample, estimate: &Estimate, losses: Losses, rate_hz: f64) -> Value {
    let palms = &sample.palms;
    let bases = [palms.base1_m, palms.base2_m].map(|base| base.map(mm));
    let pose = estimate.pose.as_ref().map(|pose| {
        json!({
            "psi": rounded(pose.psi_rad, 1e5),
            "psi_sd": rounded(pose.psi_sd_rad, 1e7),
            "com": [mm(pose.com_x_m), mm(pose.com_y_m)],
            "com_sd": rounded(1e3 * pose.com_sd_m, 1e5),
        })
    });
    json!({
        "t": estimate.time_s,
        "n": estimate.samples,
        "rate": rounded(rate_hz, 10.0),
        "phi": [rounded(palms.phi1_rad, 1e5), rounded(palms.phi12_rad(), 1e5)],
        "bases": bases,
        "s": [sample.s1_m.map(mm), sample.s2_m.map(mm)],
        "pose": pose,
        "felt": rounded(estimate.coverage, 1e3),
        "r_sd": rounded(1e3 * estimate.r_sd_m(), 1e5),
        "round": estimate.shape.as_ref().map(|shape| mm(shape.perimeter_m())),
        "certified": estimate.is_certified(),
        "com_certified": estimate.is_com_certified(),
        "reason": estimate.reason(),
        "hypotheses": estimate.hypotheses,
        "alternatives": estimate.alternatives,
        "searched": estimate.searched,
        "lost": losses.to_string(),
    })
}

/// The same of strokes: `pad` is what tells a page that draws them.
pub fn of_strokes(
    sample: &PivotSample,
    pad: &PadPose,
    estimate: &StrokesEstimate,
    losses: Losses,
    rate_hz: f64,
) -> Value {
    let pose = estimate.psi_rad.map(|psi_rad| {
        json!({
            "psi": rounded(psi_rad, 1e5),
            "psi_sd": estimate.psi_sd_rad.map(|sd_rad| rounded(sd_rad, 1e7)),
        })
    });
    let center = estimate.center_of_mass.map(|center| {
        json!({
            "towards": rounded(center.direction_rad, 1e5),
            "towards_sd": rounded(center.direction_sd_rad, 1e7),
            "away": center.distance_m.map(mm),
        })
    });
    json!({
        "t": estimate.time_s,
        "n": estimate.samples,
        "rate": rounded(rate_hz, 10.0),
        "pad": {"base": [mm(pad.base_x_m), mm(pad.base_y_m)], "tilt": rounded(pad.tilt_rad, 1e7)},
        "pivot": [mm(sample.pivot_x_m), mm(sample.pivot_y_m)],
        "s": [sample.s_m.map(mm)],
        "pose": pose,
        "unfelt": estimate.is_on_unfelt,
        "center": center,
        "felt": rounded(estimate.coverage, 1e3),
        "r_sd": rounded(1e3 * estimate.r_sd_m, 1e5),
        "round": estimate.shape.as_ref().map(|shape| mm(shape.perimeter_m())),
        "certified": estimate.is_certified(),
        "reason": estimate.reason(),
        "alternatives": estimate.alternatives,
        "searched": estimate.searched,
        "lost": losses.to_string(),
    })
}

/// The outline in the frame of the object: x, y, standard deviation and touches of every fourth point; `None` before there is one.
pub fn outline(outline: &[OutlinePoint]) -> Option<Value> {
    let points = outline.iter().step_by(EVERY);
    let points: Vec<Value> = points
        .map(|point| json!([mm(point.x_m), mm(point.y_m), rounded(1e3 * point.r_sd_m, 1e5), point.touches]))
        .collect();
    (!points.is_empty()).then(|| Value::from(points))
}

fn mm(length_m: f64) -> f64 {
    rounded(1e3 * length_m, 1e3)
}

fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}
