//! The object over the pad: the picture of one moment, and what the script needs to show any other.

use std::fmt::Write;

use palpate::pivot::{PadPose, PivotPose};
use palpate::reconstruct::OutlinePoint;
use serde::Serialize;

use crate::data::{TWO_SIDED_95, rounded};
use crate::html;
use crate::overlay::{most_common, wrapped};
use crate::strokes::StrokesInput;
use crate::strokes::chart::path;

/// Logs with more samples than this are thinned for the page.
const MOST_SHOWN: usize = 1500;

/// Width and height of the picture, in mean radii of the object.
const WIDE: f64 = 7.0;
const HIGH: f64 = 4.2;

/// Height of the pad from the lower edge, in mean radii, and how thick it is drawn.
const GROUND: f64 = 0.45;
const THICK: f64 = 0.14;

/// Marks on the pad are so far apart, metres.
const TICK_M: f64 = 0.01;

/// Points of the outline.
const POINTS: usize = 240;

/// What is shown of the samples, millimetres and degrees; what is missing is not a number.
#[derive(Serialize)]
pub(super) struct Shown {
    pub time: Vec<f64>,
    /// Height of the pivot over the pad as stated, and what the pad read.
    pub height: Vec<f64>,
    pub s: Vec<f64>,
    /// Pivot along the pad.
    pub along: Vec<f64>,
    pub psi: Vec<f64>,
    pub psi_band: Vec<f64>,
    /// ψ as a line that is broken where a segment begins.
    #[serde(skip)]
    pub psi_line: Vec<f64>,
    #[serde(skip)]
    pub psi_error: Option<Vec<f64>>,
    #[serde(skip)]
    pub height_residual: Vec<f64>,
    #[serde(skip)]
    pub offset_residual: Vec<f64>,
    /// When segments begin.
    #[serde(skip)]
    pub begins: Vec<f64>,
}

impl Shown {
    pub fn of(input: &StrokesInput) -> Self {
        let motion = &input.reconstruction.motion;
        let stride = motion.len().div_ceil(MOST_SHOWN).max(1);
        let shown: Vec<usize> = (0..motion.len().min(input.log.samples.len())).step_by(stride).collect();
        let pad = pad(input);
        let pose = |pick: &dyn Fn(&PivotPose) -> Option<f64>| -> Vec<f64> {
            shown.iter().map(|&index| pick(&motion[index]).map_or(f64::NAN, |value| rounded(value, 4))).collect()
        };
        let placed =
            |axis: usize| move |pose: &PivotPose| Some(1e3 * pad.along_and_above(pose.pivot_x_m, pose.pivot_y_m)[axis]);
        let truth = input.truth.map(|overlay| overlay.truth).filter(|truth| truth.motion.len() == motion.len());
        let turned = truth.and_then(|truth| {
            most_common(truth.motion.iter().zip(motion).filter_map(|(real, found)| Some(real.psi_rad - found.psi_rad?)))
        });
        let psi_error = truth.zip(turned).map(|(truth, turned)| {
            let error = |index: usize| {
                let off =
                    motion[index].psi_rad.map(|psi| wrapped(psi + turned - truth.motion[index].psi_rad).to_degrees());
                off.map_or(f64::NAN, |off| rounded(off, 4))
            };
            shown.iter().map(|&index| error(index)).collect()
        });
        let first = |index: &usize| *index == 0 || motion[*index].segment != motion[index - 1].segment;
        Self {
            time: pose(&|pose| Some(pose.time_s)),
            height: pose(&placed(1)),
            s: shown
                .iter()
                .map(|&index| input.log.samples[index].s_m.map_or(f64::NAN, |s| rounded(1e3 * s, 4)))
                .collect(),
            along: pose(&placed(0)),
            psi: pose(&|pose| pose.psi_rad.map(f64::to_degrees)),
            psi_line: shown
                .iter()
                .enumerate()
                .map(|(place, &index)| {
                    let before = if place > 0 { motion[shown[place - 1]].segment } else { None };
                    let same = before.is_none() || before == motion[index].segment;
                    motion[index].psi_rad.filter(|_| same).map_or(f64::NAN, f64::to_degrees)
                })
                .collect(),
            psi_band: pose(&|pose| pose.psi_sd_rad.map(|sd| TWO_SIDED_95 * sd.to_degrees())),
            psi_error,
            height_residual: pose(&|pose| pose.height_residual_m.map(|off| 1e3 * off)),
            offset_residual: pose(&|pose| pose.offset_residual_m.map(|off| 1e3 * off)),
            begins: (0..motion.len())
                .filter(|index| motion[*index].segment.is_some() && first(index))
                .map(|index| motion[index].time_s)
                .collect(),
        }
    }
}

/// The pad as the log has it.
fn pad(input: &StrokesInput) -> PadPose {
    let stated = input.rig.pad;
    PadPose { tilt_rad: stated.tilt_rad + input.reconstruction.calibration.tilt_rad, ..stated }
}

/// What the script moves: samples, and the factors between them and the picture.
#[derive(Serialize)]
struct Data<'a> {
    samples: &'a Shown,
    /// Constants of the pad: a contact is at (s − zero) / (1 + scale) along it.
    zero: f64,
    scale: f64,
    /// How far the pad lies above where it was stated.
    raised: f64,
    /// Tilt of the pad, degrees.
    tilt: f64,
}

/// The data of the page, ready to stand in a `<script>` element.
pub(super) fn json(input: &StrokesInput, samples: &Shown) -> String {
    let calibration = &input.reconstruction.calibration;
    let data = Data {
        samples,
        zero: 1e3 * calibration.zero_m,
        scale: calibration.scale,
        raised: 1e3 * calibration.height_m,
        tilt: pad(input).tilt_rad.to_degrees(),
    };
    // Plain structs of numbers: serialising them cannot fail, and an empty object draws nothing.
    html::embed(&serde_json::to_string(&data).unwrap_or_else(|_| "{}".to_owned()))
}

/// The picture in the frame of the pad, millimetres, y up; the script moves its parts. The pad lies level in it.
pub(super) fn stage(input: &StrokesInput) -> String {
    let radius = 1e3 * input.reconstruction.shape.mean_radius_m();
    if !(radius > 0.0 && radius.is_finite()) {
        return "<div class=\"plot empty\">No object.</div>".to_owned();
    }
    let (wide, high, ground, thick) = (WIDE * radius, HIGH * radius, GROUND * radius, THICK * radius);
    let mut svg = format!(
        "<svg id=\"stage-svg\" viewBox=\"{:.2} {:.2} {wide:.2} {high:.2}\" role=\"img\" aria-label=\"Pad, contact, pivot and object at the time \
         shown\"><g transform=\"scale(1 -1)\"><g id=\"pad\">",
        -0.5 * wide,
        ground - high
    );
    let (from, to) = pad_ends(input);
    let _ = write!(svg, "<path class=\"pad\" d=\"M{from:.1} 0H{to:.1}V{:.2}H{from:.1}Z\"/>", -thick);
    let _ = write!(svg, "<path class=\"face\" d=\"M{from:.1} 0H{to:.1}\"/><path class=\"ruler\" d=\"");
    let tick = 1e3 * TICK_M;
    let mut at = (from / tick).ceil() * tick;
    while at <= to {
        let _ = write!(svg, "M{at:.1} 0v{:.2}", -0.6 * thick);
        at += tick;
    }
    svg += "\"/></g><path class=\"lever\" id=\"lever\"/><g id=\"object\">";
    svg += &body(&input.reconstruction.outline);
    let _ = write!(
        svg,
        "</g><g id=\"pivot\"><path class=\"arm\" d=\"M0 0V{high:.2}\"/><circle class=\"hinge\" r=\"{:.2}\"/></g>\
         <circle class=\"contact2 dot\" id=\"contact\" r=\"{:.2}\"/></g></svg>",
        0.07 * radius,
        0.07 * radius
    );
    format!("<div class=\"plot\" id=\"stage\">{svg}</div>")
}

/// Where the pad is drawn from and to, millimetres along it: where the pivot has been, and a bit.
fn pad_ends(input: &StrokesInput) -> (f64, f64) {
    let pad = pad(input);
    let margin = 0.5 * WIDE * 1e3 * input.reconstruction.shape.mean_radius_m();
    let along = input.log.samples.iter().map(|sample| 1e3 * pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m)[0]);
    let [low, high] = crate::drawing::plot::range(along);
    (low - margin, high + margin)
}

/// Felt and unfelt parts of the outline about the pivot.
fn body(outline: &[OutlinePoint]) -> String {
    let stride = outline.len().div_ceil(POINTS).max(1);
    let points: Vec<&OutlinePoint> = outline.iter().step_by(stride).collect();
    let place = |index: usize| [1e3 * points[index % points.len()].x_m, 1e3 * points[index % points.len()].y_m];
    let all = path((0..points.len()).map(place));
    let mut drawing = format!("<path class=\"body\" d=\"{all}Z\"/>");
    for (class, felt) in [("unfelt", false), ("felt", true)] {
        // A piece of the line belongs to the point at which it begins.
        let pieces = (0..points.len()).flat_map(|index| {
            let drawn = (points[index].touches > 0) == felt;
            let end = if drawn { place(index + 1) } else { [f64::NAN; 2] };
            [if drawn { place(index) } else { [f64::NAN; 2] }, end]
        });
        let _ = write!(drawing, "<path class=\"{class}\" d=\"{}\"/>", path(pieces));
    }
    drawing
}
