//! The words and numbers of the page: verdict, key figures, error table.

use palpate::Reconstruction;
use palpate::reconstruct::Doubt;

use crate::data::{
    MAX_JUMPS_SHOWN, MAX_SAMPLES_SHOWN, TWO_SIDED_95, felt_half_width_m, root_mean_square, rounded, shown_samples,
    time_origin_s,
};
use crate::html::escape;
use crate::input::{ReportInput, TruthOverlay};

/// A number for people: about three significant digits, without an exponent unless it is enormous.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    let text = match size {
        _ if size >= 1e6 || (size > 0.0 && size < 1e-4) => power_of_ten(&format!("{value:.2e}")),
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

/// 1.23e-4 as people write it: 1.23 × 10⁻⁴.
fn power_of_ten(text: &str) -> String {
    let Some((mantissa, exponent)) = text.split_once('e') else { return text.to_owned() };
    let raised = exponent.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    });
    format!("{mantissa}\u{a0}×\u{a0}10{}", raised.collect::<String>())
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

/// A length that is not rounding alone: below a nanometre it is 0.
fn above_rounding(metres: f64) -> f64 {
    if metres.abs() < 1e-9 { 0.0 } else { metres }
}

pub(crate) fn length_text(metres: f64) -> String {
    let (value, unit) = length(metres);
    format!("{value} {unit}")
}

/// What the badge shows: a tick, a line, a cross.
pub(crate) const TICK: &str = "M4 10.5l4 4 8-9";
const LINE: &str = "M4 10h12";
pub(crate) const CROSS: &str = "M5 5l10 10M15 5L5 15";

/// A badge of a class (`good`, `partial`, `bad`) with what stands beside it.
pub(crate) fn badge(class: &str, icon: &str, badge: &str, beside: &str) -> String {
    format!(
        "<div class=\"verdict {class}\"><span class=\"badge\"><svg viewBox=\"0 0 20 20\" aria-hidden=\"true\">\
         <path d=\"{icon}\"/></svg>{badge}</span><div>{beside}</div></div>"
    )
}

/// Reasons, each with what to do about it and where that is explained; nothing where there are none.
pub(crate) fn reasons(reasons: impl Iterator<Item = (String, String, String)>) -> String {
    let item = |(what, next, docs): (String, String, String)| {
        let docs = if docs.is_empty() { docs } else { format!(" <code>{docs}</code>") };
        let next = if next.is_empty() { next } else { format!("<br>{}{docs}", escape(&next)) };
        format!("<li>{}{next}</li>", escape(&what))
    };
    let items: String = reasons.map(item).collect();
    if items.is_empty() {
        items
    } else {
        format!("<div class=\"reason\"><b>Why, and what to do:</b><ul>{items}</ul></div>")
    }
}

/// One of the key figures: label, number with its unit, and what it means.
pub(crate) fn key_figure(label: &str, value: &str, unit: &str, tip: &str) -> String {
    let missing = value.ends_with('–');
    let value = if missing { "–" } else { value };
    let unit = if missing || unit.is_empty() { String::new() } else { format!(" <small>{unit}</small>") };
    format!(
        "<div class=\"figure\" tabindex=\"0\"><dt>{label}</dt><dd>{value}{unit}</dd><dd class=\"tip\">{tip}</dd></div>"
    )
}

/// The badge and the sentence beside it.
pub(crate) fn verdict(result: &Reconstruction) -> String {
    let (class, icon, heading, sentence) = match (result.is_certified(), result.is_com_certified()) {
        (true, true) => (
            "good",
            TICK,
            "Certified",
            "The fit agrees with the sensor noise, no other arrangement fits as well, the shape is convex, and force balance \
             holds: shape, motion and centre of mass can be relied on within their error bars.",
        ),
        (true, false) => (
            "partial",
            LINE,
            "Shape and motion certified, centre of mass not",
            "Shape and motion are certified within their error bars. The centre of mass is an estimate without a certificate.",
        ),
        (false, _) if !result.others.is_empty() => (
            "bad",
            CROSS,
            "Not certified",
            "Several objects explain the log equally well. All of them are shown below; do not rely on any one of them.",
        ),
        (false, _) => ("bad", CROSS, "Not certified", "This is the best fit found. Do not rely on it."),
    };
    let doubts = result.verdict.doubts.iter();
    let reason = reasons(doubts.map(|doubt: &Doubt| (doubt.to_string(), doubt.next_step(), doubt.docs())));
    let quiet = quiet(result);
    let symmetry = result.symmetry.symmetry.is_any().then(|| {
        format!(
            "<p class=\"reason\"><b>Symmetry:</b> the object is {}. Unfelt copies of felt boundary follow from that.</p>",
            escape(&result.symmetry.to_string())
        )
    });
    let symmetry = symmetry.unwrap_or_default();
    badge(class, icon, heading, &format!("<p>{sentence}</p>{reason}{symmetry}{quiet}"))
}

/// With a χ² per degree of freedom below this, noise was expected that is not there.
const HARDLY_ANY_NOISE: f64 = 0.05;

/// What is below so many of its standard deviations is not told: an object that hardly slides is held by any friction above some, and with its centre of mass
/// nearly anywhere.
const TOLD_SDS: f64 = 2.0;

/// What a χ² of nearly 0 means: no fit is that good by chance.
fn quiet(result: &Reconstruction) -> String {
    let chi2 = result.chi2_per_dof;
    if !(chi2 < HARDLY_ANY_NOISE && chi2 > 0.0 && result.sensor_sd_m.is_finite()) {
        return String::new();
    }
    let (left, expected) = (length_text(result.sensor_sd_m), length_text(result.sensor_sd_m / chi2.sqrt()));
    format!(
        "<p class=\"reason\"><b>Hardly any noise:</b> the fit leaves {left}, where readings like these were expected to have {expected} \
         (χ² = {} per degree of freedom). That is as it should be for a simulation without noise; the verdict asks only that no more is \
         left than the noise explains.</p>",
        number(chi2)
    )
}

/// Below this many times finer than a reading, an outline is no finer than one.
const FINER: f64 = 1.5;

/// What came out in one sentence, one for each arrangement; nothing where it is not certified.
pub(crate) fn headline(input: &ReportInput) -> String {
    if !input.reconstruction.is_certified() {
        return String::new();
    }
    let line = |(index, result)| format!("<p class=\"headline\"{}>{}</p>", belongs_to(index), headline_of(result));
    input.arrangements().enumerate().map(line).collect()
}

fn headline_of(result: &Reconstruction) -> String {
    let band = felt_half_width_m(result);
    let (value, unit) = length(band);
    let mut sentence = format!("<b>Outline known to ±{value} {unit}</b>");
    let times = TWO_SIDED_95 * result.sensor_sd_m / band;
    if times.is_finite() && times >= FINER {
        let times = if times >= 10.0 { decimals(times, 0) } else { decimals(times, 1) };
        sentence += &format!(", <b>{times} times finer than one reading</b>");
    }
    let turns: Vec<f64> = result.motion.iter().map(|pose| TWO_SIDED_95 * pose.psi_sd_rad.to_degrees()).collect();
    let turn = root_mean_square(turns.into_iter().filter(|turn| turn.is_finite() && *turn < 180.0));
    if turn.is_finite() {
        sentence += &format!("; orientation to ±{}°", number(turn));
    }
    let places = result.motion.iter().map(|pose| TWO_SIDED_95 * pose.com_sd_m).filter(|sd| sd.is_finite());
    let place = root_mean_square(places);
    if result.is_com_certified() && place.is_finite() {
        sentence += &format!(", centre of mass to ±{}", length_text(place));
    }
    sentence += &format!("; {} % of the boundary felt.", decimals(100.0 * result.coverage, 0));
    match &result.calibration {
        Some(rig) if rig.size_sd > 0.0 => {
            sentence += &format!(" The size as a whole is known to {} %, as the rig is.", number(100.0 * rig.size_sd));
        }
        _ => {}
    }
    sentence
}

/// The choice between arrangements that fit equally well; empty when there is only one.
pub(crate) fn chooser(result: &Reconstruction) -> String {
    if result.others.is_empty() {
        return String::new();
    }
    let options: String = std::iter::once(result)
        .chain(&result.others)
        .enumerate()
        .map(|(index, arrangement)| {
            let checked = if index == 0 { " checked" } else { "" };
            format!(
                "<label><input type=\"radio\" name=\"arrangement\" value=\"{index}\"{checked}>{}<span>{}</span></label>",
                thumbnail(arrangement),
                index + 1
            )
        })
        .collect();
    include_str!("../assets/chooser.html").replace("{{options}}", &options)
}

/// A small picture of the outline.
fn thumbnail(result: &Reconstruction) -> String {
    let stride = (result.outline.len() / 90).max(1);
    let points = || result.outline.iter().step_by(stride).filter(|p| p.x_m.is_finite() && p.y_m.is_finite());
    let reach = points().map(|p| p.x_m.hypot(p.y_m)).fold(1e-12, f64::max);
    let path: String = points()
        .enumerate()
        .map(|(index, p)| {
            let pen = if index == 0 { 'M' } else { 'L' };
            format!("{pen}{:.1} {:.1}", 20.0 + 18.0 * p.x_m / reach, 20.0 - 18.0 * p.y_m / reach)
        })
        .collect();
    let path = if path.is_empty() { path } else { path + "Z" };
    format!("<svg viewBox=\"0 0 40 40\" aria-hidden=\"true\"><path d=\"{path}\"/></svg>")
}

/// The attribute of what belongs to one of several arrangements; all but the first wait until they are chosen.
pub(crate) fn belongs_to(index: usize) -> String {
    let hidden = if index == 0 { "" } else { " hidden" };
    format!(" data-arrangement=\"{index}\"{hidden}")
}

/// The table of jumps, one for each arrangement; empty when nothing jumped.
pub(crate) fn jumps(input: &ReportInput) -> String {
    let origin = time_origin_s(input.log);
    let cards = input.arrangements().enumerate().filter(|(_, result)| !result.jumps.is_empty());
    cards
        .map(|(index, result)| {
            let rows: String = result
                .jumps
                .iter()
                .take(MAX_JUMPS_SHOWN)
                .map(|jump| {
                    let time = rounded(jump.time_s - origin, 5);
                    let turn = (jump.psi_after_rad - jump.psi_before_rad).to_degrees();
                    let drop = 1e3 * jump.height_drop_m();
                    let place = if time.is_finite() { format!("{time}") } else { String::new() };
                    let physical = if jump.physical { "<td>yes</td>" } else { "<td class=\"no\">no</td>" };
                    format!(
                        "<tr><td><button type=\"button\" data-time=\"{place}\">{} s</button></td><td>{}°</td><td>{} mm</td>\
                         {physical}</tr>",
                        decimals(time, 2),
                        decimals(turn, 1),
                        decimals(drop, 2),
                    )
                })
                .collect();
            include_str!("../assets/jumps.html").replace("{{of}}", &belongs_to(index)).replace("{{rows}}", &rows)
        })
        .collect()
}

/// A number with so many decimals, for a column of its like.
pub(crate) fn decimals(value: f64, decimals: usize) -> String {
    if !value.is_finite() || value.abs() >= 1e6 {
        return number(value);
    }
    let text = format!("{value:.decimals$}");
    // No minus before what is nothing but zeros.
    let zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if zero { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// The strip of key figures, one for each arrangement.
pub(crate) fn key_figures(input: &ReportInput) -> String {
    let strip =
        |(index, result)| format!("<dl class=\"figures\"{}>{}</dl>", belongs_to(index), key_figures_of(input, result));
    input.arrangements().enumerate().map(strip).collect()
}

fn key_figures_of(input: &ReportInput, result: &Reconstruction) -> String {
    let centroid = result.shape.centroid();
    let mut strip = String::new();
    let mut add = |label: &str, (value, unit): (String, &str), tip: &str| {
        strip.push_str(&key_figure(label, &value, unit, tip));
    };
    add(
        "Mean radius",
        length(result.shape.mean_radius_m()),
        "Average of the support function r(θ) over all directions. The perimeter is 2π times this.",
    );
    let offset_m = above_rounding(centroid.x_m.hypot(centroid.y_m));
    let center_sd_m = result.com_sd_m();
    let is_told = result.is_com_certified() || offset_m > TOLD_SDS * center_sd_m;
    add(
        "Centre-of-mass offset",
        if is_told { length(offset_m) } else { ("–".to_owned(), "") },
        &format!(
            "Distance from the centre of mass to the centroid of the area, where the centre is told: it is known to ± {}, one standard deviation. \
             0 for a uniform mass distribution.",
            length_text(center_sd_m)
        ),
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
        "Standard deviation of one contact reading: stated by the log, or estimated from the residuals of the fit.",
    );
    let hardly_any = result.chi2_per_dof < HARDLY_ANY_NOISE;
    add(
        "χ² per d.o.f.",
        if hardly_any { ("≪ 1".to_owned(), "no noise") } else { (number(result.chi2_per_dof), "") },
        "Squared residuals over those of the noise that readings like these were expected to have, per degree of freedom. Near 1: the fit \
         is as good as the sensors are. Far above 1: something in the log is not explained. Far below 1: the log has hardly any noise.",
    );
    if let Some(friction) = result.friction {
        let (of, sd) =
            (|palm: usize| friction.coefficients[palm], |palm: usize| number(friction.coefficient_sds[palm]));
        let is_told = |palm: usize| of(palm) > TOLD_SDS * friction.coefficient_sds[palm];
        let value = |palm: usize| if is_told(palm) { format!("{:.3}", of(palm)) } else { "?".to_owned() };
        let both = if is_told(0) || is_told(1) { format!("{}, {}", value(0), value(1)) } else { "–".to_owned() };
        add(
            "Friction",
            (both, ""),
            &format!(
                "Coefficients of friction of palm 1 (± {}) and palm 2 (± {}), one standard deviation: tangential over normal force where \
                 the object slides.",
                sd(0),
                sd(1)
            ),
        );
    }
    if let Some(inertia) = result.inertia {
        add(
            "Radius of gyration",
            length(inertia.gyration_radius_m),
            "How far from the centre of mass the mass lies: the object resists being turned as if all of it were on a ring of this radius.",
        );
    }
    add(
        "Boundary felt",
        (number(100.0 * result.coverage), "%"),
        "Share of the normal directions that a contact passed over at least once, or passed over a symmetric copy of. The rest is \
         extrapolated by the prior.",
    );
    add(
        "Jumps",
        (result.jumps.len().to_string(), ""),
        "Times at which a resting pose vanished and the object moved to another one. They divide the motion into segments.",
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
        (input.reconstruction.alternatives.to_string(), ""),
        "Number of arrangements of the segments that fit equally well. 1 means that the answer is unique.",
    );
    let times = || input.log.samples.iter().map(|sample| sample.time_s).filter(|time| time.is_finite());
    let span = times().fold(f64::NAN, f64::max) - times().fold(f64::NAN, f64::min);
    add("Log", (number(span), "s"), "Time from the first sample to the last.");
    add("Computing time", (number(input.seconds), "s"), "Wall-clock time of the reconstruction.");
    strip
}

/// The card with the errors against the truth; empty without one.
pub(crate) fn truth_errors(truth: Option<&TruthOverlay>) -> String {
    let Some(TruthOverlay { errors, .. }) = truth else { return String::new() };
    let rows = [
        ("Boundary, felt part", length_text(errors.rms_r_m), "RMS of r after the best rotation"),
        ("Form alone", length_text(errors.rms_form_m), "RMS of r after the best rotation and shift"),
        ("Largest gap", length_text(errors.hausdorff_m), "Hausdorff distance of the boundaries"),
        ("Orientation", format!("{}°", number(errors.rms_psi_rad.to_degrees())), "RMS of ψ"),
        ("Centre of mass", length_text(errors.rms_com_m), "RMS of its position"),
    ];
    errors_card(&belongs_to(0), "centre of mass", &rows)
}

/// A card with errors, each with its name and what it is the error of; `origin` is that of the frame of the object.
pub(crate) fn errors_card(of: &str, origin: &str, rows: &[(&str, String, &str)]) -> String {
    let rows: String = rows
        .iter()
        .map(|(what, value, how)| {
            format!("<div class=\"figure\"><dt>{what}</dt><dd>{value}</dd><dd class=\"how\">{how}</dd></div>")
        })
        .collect();
    let card = include_str!("../assets/errors.html").replace("{{of}}", of);
    card.replace("{{origin}}", origin).replace("{{rows}}", &rows)
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
    use super::{decimals, length, number};

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
            (1e300, "1.00\u{a0}×\u{a0}10³⁰⁰"),
            (-2.25e-7, "\u{2212}2.25\u{a0}×\u{a0}10⁻⁷"),
        ] {
            assert_eq!(number(value), text, "{value}");
        }
    }

    #[test]
    fn columns_have_their_decimals() {
        let shown = [-0.001, 12.3456, -7.0, f64::NAN, 1e9].map(|value| decimals(value, 2));
        assert_eq!(shown, ["0.00", "12.35", "\u{2212}7.00", "–", "1.00\u{a0}×\u{a0}10⁹"]);
    }

    #[test]
    fn small_lengths_are_micrometres() {
        assert_eq!(length(0.03), ("30.0".to_owned(), "mm"));
        assert_eq!(length(4.3e-6), ("4.30".to_owned(), "µm"));
        assert_eq!(length(0.0), ("0.00".to_owned(), "mm"));
    }
}
