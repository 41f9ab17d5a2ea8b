//! The words and numbers of the page of strokes: verdict, key figures, constants of the rig, errors.

use palpate::pivot::{CenterOfMassEstimate, PivotReconstruction, PivotTolerances};

use crate::data::TWO_SIDED_95;
use crate::figures::{CROSS, TICK, badge, decimals, errors_card, key_figure, length, length_text, number, reasons};
use crate::strokes::StrokesInput;

/// The badge and what stands beside it.
pub(super) fn verdict(result: &PivotReconstruction) -> String {
    let doubts = result.doubts.iter().map(|doubt| (doubt.to_string(), doubt.next_step().to_owned(), String::new()));
    let (class, icon, heading, sentence) = if result.is_certified() {
        let sentence = "The fit agrees with the noise, no other arrangement of the strokes fits as well, and the shape is convex: shape about \
                        the pivot and motion can be relied on within their error bars.";
        ("good", TICK, "Certified", sentence)
    } else {
        ("bad", CROSS, "Not certified", "This is the best fit found. Do not rely on it.")
    };
    badge(class, icon, heading, &format!("<p>{sentence}</p>{}", reasons(doubts)))
}

/// What came out in one sentence; nothing where it is not certified.
pub(super) fn headline(result: &PivotReconstruction) -> String {
    if !result.is_certified() {
        return String::new();
    }
    let band = length_text(TWO_SIDED_95 * result.r_sd_m());
    let turn = number((TWO_SIDED_95 * result.psi_sd_rad()).to_degrees());
    let felt = decimals(100.0 * result.coverage, 0);
    let size = size_words(&result.calibration_sd);
    format!(
        "<p class=\"headline\"><b>Outline known to ±{band}</b>; orientation to ±{turn}°; {felt} % of the boundary felt.{size}</p>"
    )
}

/// What no log of strokes tells.
fn size_words(sd: &PivotTolerances) -> String {
    let size = length_text(TWO_SIDED_95 * sd.height_sd_m);
    let words = format!(" All of it may be larger or smaller by {size}, as the height of the pad is known.");
    if sd.height_sd_m > 0.0 { words } else { String::new() }
}

/// The strip of key figures.
pub(super) fn key_figures(input: &StrokesInput) -> String {
    let result = input.reconstruction;
    let mut strip = String::new();
    let (direction, direction_band) = center(result.center_of_mass.as_ref());
    let mut add =
        |label: &str, (value, unit): (String, &str), tip: &str| strip += &key_figure(label, &value, unit, tip);
    add(
        "Mean radius",
        length(result.shape.mean_radius_m()),
        "Average of the support function r(θ) over all directions. The perimeter is 2π times this.",
    );
    let (value, unit) = length(TWO_SIDED_95 * result.r_sd_m());
    add(
        "Boundary known to",
        (format!("±{value}"), unit),
        "Root mean square of the half-width of the 95 % band of r(θ), over the part of the boundary that was felt.",
    );
    let felt = (number(100.0 * result.coverage), "%");
    add(
        "Boundary felt",
        felt,
        "Share of the normal directions that the contact passed over. The rest is a smooth continuation by the prior.",
    );
    add(
        "Towards centre of mass",
        (direction, &direction_band),
        "Direction from the pivot in the frame of the object, from the angle at which it hung before each stroke. Contact alone never tells it.",
    );
    add(
        "Noise of the pad",
        length(result.sensor_sd_m),
        "Standard deviation of the offset of the contact from the foot of the pivot.",
    );
    add("Noise of the arm", length(result.arm_sd_m), "Standard deviation of the height of the pivot over the pad.");
    let chi2 = (number(result.chi2_per_dof), "");
    add(
        "χ² per d.o.f.",
        chi2,
        "Squared residuals over those that the noise explains, per degree of freedom. Far above 1: something is not explained.",
    );
    let count = |count: usize| (count.to_string(), "");
    add(
        "Segments",
        count(result.segments),
        "Stretches of the motion with the contact kept. Each is placed by the boundary that it has in common with others.",
    );
    add(
        "Arrangements",
        count(result.alternatives),
        "Number of arrangements of the segments that fit equally well. 1 means that the answer is unique.",
    );
    add("Samples", count(input.log.samples.len()), "Readings in the log, with and without a contact.");
    add(
        "Harmonics",
        count(result.shape.harmonics_m().len()),
        "Terms of the Fourier series that describes r(θ). More terms allow finer detail.",
    );
    add("Computing time", (number(input.seconds), "s"), "Wall-clock time of the reconstruction.");
    format!("<dl class=\"figures\">{strip}</dl>")
}

fn center(center: Option<&CenterOfMassEstimate>) -> (String, String) {
    center.map_or(("–".to_owned(), String::new()), |center| {
        let [direction, sd] = [center.direction_rad, TWO_SIDED_95 * center.direction_sd_rad].map(f64::to_degrees);
        (format!("{}°", decimals(direction, 1)), format!("± {}°", number(sd)))
    })
}

/// The card on the constants of the rig; empty where all of them were stated to be exact.
pub(super) fn rig(input: &StrokesInput) -> String {
    let (stated, found, sd) =
        (&input.rig.calibration, &input.reconstruction.calibration, &input.reconstruction.calibration_sd);
    let tolerances = &input.rig.tolerances;
    let millimetres = |m: f64| 1e3 * m;
    let rows = [
        (
            "Zero of the pad",
            " mm",
            millimetres(stated.zero_m),
            millimetres(tolerances.zero_sd_m),
            millimetres(found.zero_m),
            millimetres(sd.zero_sd_m),
        ),
        (
            "Scale of the pad",
            " %",
            100.0 * stated.scale,
            100.0 * tolerances.scale_sd,
            100.0 * found.scale,
            100.0 * sd.scale_sd,
        ),
        (
            "Tilt of the pad",
            "°",
            stated.tilt_rad.to_degrees(),
            tolerances.tilt_sd_rad.to_degrees(),
            found.tilt_rad.to_degrees(),
            sd.tilt_sd_rad.to_degrees(),
        ),
        (
            "Height of the pad",
            " mm",
            millimetres(stated.height_m),
            millimetres(tolerances.height_sd_m),
            millimetres(found.height_m),
            millimetres(sd.height_sd_m),
        ),
    ];
    let rows: String = rows
        .iter()
        .filter(|(_, _, _, tolerance, _, _)| *tolerance > 0.0)
        .map(|(name, unit, stated, tolerance, value, sd)| {
            let told = if sd / tolerance > UNTOLD { "not told by a log of strokes" } else { "told by the log" };
            let places = (1.0 - sd.log10().floor()).clamp(0.0, 4.0) as usize;
            format!(
                "<tr><th scope=\"row\">{name}</th><td>{} ± {}{unit}</td><td>{} ± {}{unit}<small>{told}</small></td></tr>",
                decimals(*stated, 2),
                decimals(*tolerance, 2),
                decimals(*value, places),
                decimals(*sd, places)
            )
        })
        .collect();
    if rows.is_empty() { rows } else { include_str!("../../assets/strokes-rig.html").replace("{{rows}}", &rows) }
}

/// Above this share of the stated standard deviation a constant is not told.
const UNTOLD: f64 = 0.8;

/// The card with the errors against the truth; empty without one.
pub(super) fn truth_errors(input: &StrokesInput) -> String {
    let Some(overlay) = &input.truth else { return String::new() };
    let errors = &overlay.errors;
    let rows = [
        ("Boundary, felt part", length_text(errors.rms_r_m), "RMS of r after the best rotation"),
        ("Form alone", length_text(errors.rms_form_m), "RMS of r after the best rotation and shift"),
        ("Largest gap", length_text(errors.hausdorff_m), "Hausdorff distance of the felt boundaries"),
        ("Orientation", format!("{}°", number(errors.rms_psi_rad.to_degrees())), "RMS of ψ"),
    ];
    errors_card("", "pivot", &rows)
}
