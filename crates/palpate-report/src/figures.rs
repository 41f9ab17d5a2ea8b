//! The words and numbers of the page: verdict, key figures, error table.

use palpate::Reconstruction;

use crate::data::{MAX_SAMPLES_SHOWN, felt_half_width_m, shown_samples};
use crate::html::escape;
use crate::{ReportInput, TruthOverlay};

/// A number for people: about three significant digits, without an exponent unless it is enormous.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    let text = match size {
        _ if size >= 1e6 || (size > 0.0 && size < 1e-4) => format!("{value:.2e}"),
        _ if size >= 100.0 => format!("{value:.0}"),
        _ if size >= 10.0 => format!("{value:.1}"),
        _ if size >= 1.0 || size == 0.0 => format!("{value:.2}"),
        _ => {
            // Two significant digits below 1; the size is at least 1e-4 here, so this is at most 5 decimals.
            let decimals = (1.0 - size.log10().floor()).clamp(2.0, 5.0) as usize;
            format!("{value:.decimals$}")
        }
    };
    text.replace('-', "\u{2212}")
}

/// A length given in metres as (number, unit): millimetres, or micrometres below 0.1 mm.
pub(crate) fn length(metres: f64) -> (String, &'static str) {
    let millimetres = metres * 1e3;
    if millimetres.abs() < 0.1 && millimetres != 0.0 {
        (number(millimetres * 1e3), "µm")
    } else {
        (number(millimetres), "mm")
    }
}

fn length_text(metres: f64) -> String {
    let (value, unit) = length(metres);
    format!("{value} {unit}")
}

/// The badge and the sentence beside it.
pub(crate) fn verdict(result: &Reconstruction) -> String {
    let (class, icon, badge, sentence) = match (result.certified, result.com_certified) {
        (true, true) => (
            "good",
            "M4 10.5l4 4 8-9",
            "Certified",
            "The fit agrees with the sensor noise, no other arrangement fits as well, the shape is convex, and force balance \
             holds: shape, motion and centre of mass can be relied on within their error bars.",
        ),
        (true, false) => (
            "partial",
            "M4 10h12",
            "Shape and motion certified, centre of mass not",
            "Shape and motion can be relied on within their error bars. The centre of mass is only a best guess.",
        ),
        (false, _) => {
            ("bad", "M5 5l10 10M15 5L5 15", "Not certified", "What follows is the best fit found. Do not rely on it.")
        }
    };
    let reason = result.reason.trim();
    let reason = if reason.is_empty() {
        String::new()
    } else {
        format!("<p class=\"reason\"><b>Why:</b> {}</p>", escape(reason))
    };
    format!(
        "<div class=\"verdict {class}\"><span class=\"badge\"><svg viewBox=\"0 0 20 20\" aria-hidden=\"true\">\
         <path d=\"{icon}\"/></svg>{badge}</span><div><p>{sentence}</p>{reason}</div></div>"
    )
}

/// The strip of key figures.
pub(crate) fn key_figures(input: &ReportInput) -> String {
    let result = input.reconstruction;
    let centroid = result.shape.centroid();
    let mut strip = String::new();
    let mut add = |label: &str, (value, unit): (String, &str), tip: &str| {
        let missing = value.ends_with('–');
        let value = if missing { "–" } else { value.as_str() };
        let unit = if missing || unit.is_empty() { String::new() } else { format!(" <small>{unit}</small>") };
        strip.push_str(&format!(
            "<div class=\"figure\" tabindex=\"0\"><dt>{label}</dt><dd>{value}{unit}</dd><p class=\"tip\" role=\"note\">{tip}</p></div>"
        ));
    };
    add(
        "Mean radius",
        length(result.shape.mean_radius_m()),
        "Average of the support function r(θ) over all directions. The perimeter is 2π times this.",
    );
    add(
        "Centre-of-mass offset",
        length(centroid.x_m.hypot(centroid.y_m)),
        "Distance from the centre of mass to the centroid of the area. It would be 0 if the mass were spread evenly.",
    );
    let (value, unit) = length(felt_half_width_m(result));
    add(
        "Boundary known to",
        (format!("±{value}"), unit),
        "Root mean square of the half-width of the 95 % band of r(θ), over the part of the boundary that was felt.",
    );
    add(
        "Sensor noise",
        length(result.sensor_sd_m),
        "Standard deviation of one contact reading: stated by the log, or found from what the fit leaves over.",
    );
    add(
        "χ² per degree of freedom",
        (number(result.chi2_per_dof), ""),
        "Squared residuals over what the noise explains. Near 1: the fit is as good as the sensors are. Far above 1: something \
         in the log is not explained.",
    );
    add(
        "Boundary felt",
        (number(100.0 * result.coverage), "%"),
        "Share of the normal directions that a contact passed over at least once. The rest is smooth guesswork.",
    );
    add(
        "Jumps",
        (result.jumps.len().to_string(), ""),
        "Times at which a resting pose vanished and the object fell over to another one. They part the motion into pieces.",
    );
    add(
        "Samples",
        (input.log.samples.len().to_string(), ""),
        "Readings in the log, each with two palm angles and up to two contact positions.",
    );
    add(
        "Harmonics",
        (result.shape.harmonics_m().len().to_string(), ""),
        "Terms of the Fourier series that describes r(θ). More terms allow finer detail.",
    );
    add(
        "Arrangements",
        (result.alternatives.to_string(), ""),
        "Number of distinct ways to arrange the pieces that fit equally well. 1 means the answer is unique.",
    );
    let times = || input.log.samples.iter().map(|sample| sample.time_s).filter(|time| time.is_finite());
    let span = times().fold(f64::NAN, f64::max) - times().fold(f64::NAN, f64::min);
    add("Log", (number(span), "s"), "Time from the first sample to the last.");
    add("Computing time", (number(input.seconds), "s"), "Wall-clock time of the reconstruction.");
    strip
}

/// The card with the errors against the truth; empty without one.
pub(crate) fn truth_errors(truth: Option<&TruthOverlay>) -> String {
    let Some(truth) = truth else { return String::new() };
    let rows = [
        ("Boundary, felt part", length_text(truth.rms_r_m), "RMS of r after the best rotation"),
        ("Form alone", length_text(truth.rms_form_m), "RMS of r after the best rotation and shift"),
        ("Largest gap", length_text(truth.hausdorff_m), "Hausdorff distance of the boundaries"),
        ("Orientation", format!("{}°", number(truth.rms_psi_rad.to_degrees())), "RMS of ψ"),
        ("Centre of mass", length_text(truth.rms_com_m), "RMS of its position"),
    ];
    let rows: String = rows
        .iter()
        .map(|(what, value, how)| format!("<div class=\"figure\"><dt>{what}</dt><dd>{value}</dd><p>{how}</p></div>"))
        .collect();
    include_str!("../assets/errors.html").replace("{{rows}}", &rows)
}

/// A note where the plots do not show every sample.
pub(crate) fn thinned(input: &ReportInput) -> String {
    let (all, shown) = (input.log.samples.len().min(input.reconstruction.motion.len()), shown_samples(input).len());
    if all <= MAX_SAMPLES_SHOWN {
        return String::new();
    }
    format!("<p>The plots show {shown} of {all} samples; all figures and histograms use every one.</p>")
}

/// The command line in the footer.
pub(crate) fn command(command: Option<&str>) -> String {
    command.map_or_else(String::new, |command| format!("<p>Made with <code>{}</code></p>", escape(command)))
}

#[cfg(test)]
mod tests {
    use super::{length, number};

    #[test]
    fn numbers_read_well() {
        for (value, text) in [
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
            (0.0, "0.00"),
            (0.00123, "0.0012"),
            (0.0999, "0.100"),
            (1.234, "1.23"),
            (-12.34, "\u{2212}12.3"),
            (1234.5, "1234"),
            (1e300, "1.00e300"),
        ] {
            assert_eq!(number(value), text, "{value}");
        }
    }

    #[test]
    fn small_lengths_are_micrometres() {
        assert_eq!(length(0.03), ("30.0".to_owned(), "mm"));
        assert_eq!(length(4.3e-6), ("4.30".to_owned(), "µm"));
        assert_eq!(length(0.0), ("0.00".to_owned(), "mm"));
    }
}
