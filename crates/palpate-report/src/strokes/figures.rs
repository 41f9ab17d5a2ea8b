//! The figures of the page of strokes: outline, readings, orientation, support function, residuals.

use crate::data::TWO_SIDED_95;
use crate::html::escape;
use crate::overlay::SampledSupport;
use crate::still::{Still, center_mark};
use crate::strokes::StrokesInput;
use crate::strokes::chart::{Chart, Curve, Lane};
use crate::strokes::motion::Shown;

/// Heights of the charts.
const TALL: f64 = 180.0;
const LOW: f64 = 130.0;

/// The band of the outline is drawn wider, so that its half-width is about this share of the mean radius.
const BAND_SHARE: f64 = 0.04;

/// Factors by which it may be drawn wider.
const FACTORS: [f64; 9] = [500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0];

/// Residuals are drawn up to so many standard deviations of the noise.
const RESIDUAL_SDS: f64 = 5.0;

fn curve(class: &'static str, y: &[f64]) -> Curve<'static> {
    Curve { class, y: y.to_vec(), dots: false }
}

/// The outline about the pivot with its band, the truth, and where the centre of mass is seen.
pub(super) fn shape(input: &StrokesInput) -> String {
    let result = input.reconstruction;
    let line = |touches: u32| if touches > 0 { "felt" } else { "unfelt" };
    let points = result.outline.iter().map(|point| ([point.x_m, point.y_m], line(point.touches)));
    let Some(still) = Still::of(points.collect()) else { return "<p>There is no outline to draw.</p>".to_owned() };
    let radius_m = result.shape.mean_radius_m();
    let band_m = TWO_SIDED_95 * result.r_sd_m();
    let factor = FACTORS.into_iter().find(|factor| factor * band_m <= BAND_SHARE * radius_m).unwrap_or(1.0);
    let mut below = String::new();
    let offset = |sign: f64| {
        move |point: &palpate::reconstruct::OutlinePoint| {
            let (sin, cos) = point.theta_rad.sin_cos();
            let off = sign * factor * TWO_SIDED_95 * point.r_sd_m;
            [point.x_m + off * cos, point.y_m + off * sin]
        }
    };
    let mut from = 0;
    while from < result.outline.len() {
        let felt = result.outline[from..].iter().take_while(|point| point.touches > 0).count();
        let run = &result.outline[from..from + felt];
        if felt > 1 {
            below += &still.path("band", run.iter().map(offset(1.0)).chain(run.iter().rev().map(offset(-1.0))));
        }
        from += felt.max(1);
    }
    let (px, py) = still.place([0.0; 2]);
    let mut above = String::new();
    if let Some(truth) = &input.truth {
        let boundary =
            SampledSupport::new(&truth.truth.support).map(|support| support.boundary_m(truth.errors.rotation_rad, 360));
        above += &still.path("truth", boundary.unwrap_or_default().into_iter());
    }
    if let Some(center) = &result.center_of_mass {
        let (sin, cos) = center.direction_rad.sin_cos();
        let reach_m = center.distance_m.unwrap_or(0.6 * radius_m);
        above += &still.path("sight", [[0.0; 2], [reach_m * cos, reach_m * sin]].into_iter());
        if center.distance_m.is_some() {
            above += &center_mark(still.place([reach_m * cos, reach_m * sin]));
        }
    }
    above += &format!("<circle class=\"hinge\" cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"5\"/>");
    let entry = |picture: &str, words: &str| {
        format!("<li><svg viewBox=\"0 0 26 14\" aria-hidden=\"true\">{picture}</svg>{words}</li>")
    };
    let mut legend = entry("<path class=\"felt\" d=\"M1 7H25\"/>", "felt")
        + &entry("<path class=\"unfelt\" d=\"M1 7H25\"/>", "never felt")
        + &entry("<circle class=\"hinge\" cx=\"13\" cy=\"7\" r=\"5\"/>", "pivot");
    if below.contains("band") {
        let times = if factor > 1.0 { format!(", drawn {factor} times wider") } else { String::new() };
        legend += &entry("<path class=\"band\" d=\"M1 1H25V13H1Z\"/>", &format!("95 % band{times}"));
    }
    if result.center_of_mass.is_some() {
        legend += &entry("<path class=\"sight\" d=\"M1 7H25\"/>", "towards the centre of mass");
    }
    if input.truth.is_some() {
        legend += &entry("<path class=\"truth\" d=\"M1 7H25\"/>", "truth");
    }
    format!("<div class=\"plot\" id=\"shape\">{}</div><ul class=\"legend\">{legend}</ul>", still.drawn(&below, &above))
}

/// Height of the pivot over the pad.
pub(super) fn height(samples: &Shown) -> String {
    over_time(
        "height",
        "Height of the pivot over the pad, over time",
        samples,
        vec![curve("reading palm1", &samples.height)],
        None,
    )
}

/// What the pad read.
pub(super) fn contact(samples: &Shown) -> String {
    over_time(
        "contact-chart",
        "Contact position on the pad, over time",
        samples,
        vec![curve("reading palm2", &samples.s)],
        None,
    )
}

/// Orientation with its band.
pub(super) fn psi(samples: &Shown) -> String {
    let lane = Lane { unit: "°", band: samples.psi_band.clone(), error: samples.psi_error.clone() };
    over_time(
        "psi",
        "Orientation ψ over time, with its 95 % band",
        samples,
        vec![curve("line", &samples.psi_line)],
        Some(lane),
    )
}

fn over_time(id: &str, name: &str, samples: &Shown, curves: Vec<Curve>, lane: Option<Lane>) -> String {
    let chart = Chart {
        id,
        name,
        x: &samples.time,
        x_unit: " s",
        height: if lane.is_some() { TALL } else { LOW },
        curves,
        y: None,
        levels: Vec::new(),
        marks: &samples.begins,
        lane,
    };
    chart.drawn()
}

/// The support function about the pivot.
pub(super) fn support(input: &StrokesInput) -> String {
    let outline = &input.reconstruction.outline;
    let theta: Vec<f64> = outline.iter().map(|point| point.theta_rad.to_degrees()).collect();
    let part = |felt: bool| -> Vec<f64> {
        outline.iter().map(|point| if (point.touches > 0) == felt { 1e3 * point.r_m } else { f64::NAN }).collect()
    };
    let mut curves = vec![curve("unfelt", &part(false)), curve("felt", &part(true))];
    let truth = input
        .truth
        .and_then(|overlay| Some((SampledSupport::new(&overlay.truth.support)?, overlay.errors.rotation_rad)));
    let real = truth.map(|(support, turned)| {
        outline.iter().map(|point| 1e3 * support.r(point.theta_rad - turned)).collect::<Vec<f64>>()
    });
    if let Some(real) = &real {
        curves.push(curve("truth", real));
    }
    let felt = |index: usize, value: f64| if outline[index].touches > 0 { value } else { f64::NAN };
    let band =
        outline.iter().enumerate().map(|(index, point)| felt(index, 1e3 * TWO_SIDED_95 * point.r_sd_m)).collect();
    let error = real.map(|real| {
        outline.iter().enumerate().map(|(index, point)| felt(index, 1e3 * point.r_m - real[index])).collect()
    });
    let chart = Chart {
        id: "support",
        name: "Support function r over the normal angle θ, with its 95 % band",
        x: &theta,
        x_unit: "°",
        height: TALL,
        curves,
        y: None,
        levels: Vec::new(),
        marks: &[],
        lane: Some(Lane { unit: "mm", band, error }),
    };
    chart.drawn()
}

/// What the fit leaves of height and offset.
pub(super) fn residuals(input: &StrokesInput, samples: &Shown) -> String {
    let result = input.reconstruction;
    let part = |id: &'static str, name: &'static str, class: &'static str, values: &[f64], sd_m: f64| {
        let sd_mm = 1e3 * sd_m;
        let reach = RESIDUAL_SDS * sd_mm;
        let micro = reach < 0.5;
        let factor = if micro { 1e3 } else { 1.0 };
        let y = (reach > 0.0 && reach.is_finite()).then_some([-factor * reach, factor * reach]);
        let chart = Chart {
            id,
            name,
            x: &samples.time,
            x_unit: " s",
            height: LOW,
            curves: vec![Curve { class, y: values.iter().map(|value| factor * value).collect(), dots: true }],
            y,
            levels: if y.is_some() { vec![-2.0 * factor * sd_mm, 2.0 * factor * sd_mm] } else { Vec::new() },
            marks: &samples.begins,
            lane: None,
        };
        format!("<h3>{} <small>{}</small></h3>{}", escape(name), if micro { "µm" } else { "mm" }, chart.drawn())
    };
    part("height-residuals", "Height of the pivot", "cloud one", &samples.height_residual, result.arm_sd_m)
        + &part("offset-residuals", "Offset of the contact", "cloud two", &samples.offset_residual, result.sensor_sd_m)
}
