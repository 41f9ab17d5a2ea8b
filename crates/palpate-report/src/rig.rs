//! The card on the constants of the rig: what was stated, what the log says, and what to do about it.

use palpate::Reconstruction;
use palpate::reconstruct::{CalibrationEstimate, ConstantEstimate};
use palpate::sensor::CalibrationConstant;

use crate::figures::{belongs_to, decimals, length, number};
use crate::html::{escape, fill};
use crate::input::ReportInput;

/// Below this share of the stated standard deviation a constant is told by the log.
const TOLD: f64 = 0.2;
/// Above this share it is not.
const UNTOLD: f64 = 0.8;
/// Further than this from what was stated, in standard deviations of that, something is wrong.
const OFF_SDS: f64 = 3.0;
/// Half of the width of a picture, in standard deviations of what was stated: as far as needed between these.
const LEAST_REACH: f64 = 3.0;
const MOST_REACH: f64 = 5.0;
/// Half of the length of bars, in standard deviations.
const BAR_SDS: f64 = 2.0;

/// The card, one for each arrangement; empty where no rig was stated.
pub(crate) fn rig(input: &ReportInput) -> String {
    let estimates = input.arrangements().enumerate();
    estimates.filter_map(|(index, result)| Some(card(index, result, result.calibration.as_ref()?))).collect()
}

fn card(index: usize, result: &Reconstruction, estimate: &CalibrationEstimate) -> String {
    let open: Vec<&ConstantEstimate> = estimate.constants.iter().filter(|constant| constant.prior_sd > 0.0).collect();
    fill(include_str!("../assets/rig.html"), |name| {
        match name {
        "of" => belongs_to(index),
        "warning" if !result.is_certified() && !open.is_empty() => {
            "<p class=\"warning\"><b>The result is not certified:</b> a wrong shape or motion makes these numbers wrong too. Do not \
             correct the rig by them.</p>"
                .to_owned()
        }
        "table" => table(&open),
        "size" => size(estimate.size_sd, estimate.offset_sd_m),
        _ => String::new(),
    }
    })
}

fn table(open: &[&ConstantEstimate]) -> String {
    if open.is_empty() {
        return "<p>Every constant that a log can tell was stated to be exact, so none was estimated.</p>".to_owned();
    }
    let reach = reach(open);
    let rows: String = open.iter().map(|constant| row(constant, reach)).collect();
    // Roles are spelled out, because a table that a narrow window lays out as blocks is no table to every reader otherwise.
    format!(
        "<ul class=\"legend\" aria-hidden=\"true\">\
         <li><svg viewBox=\"0 0 26 14\"><rect class=\"prior\" x=\"0\" y=\"2\" width=\"26\" height=\"10\" rx=\"2\"/><path class=\"stated\" d=\"M13 2V12\"/></svg>stated (prior), ± 2 sd</li>\
         <li><svg viewBox=\"0 0 26 14\"><path class=\"bar\" d=\"M1 7H25M1 4V10M25 4V10\"/><circle class=\"found\" cx=\"13\" cy=\"7\" r=\"3\"/></svg>\
         from the log, ± 2 sd</li>\
         <li><svg viewBox=\"0 0 26 14\"><path class=\"origin\" d=\"M22.5 0V14\"/></svg>zero</li></ul>\
         <table role=\"table\" aria-label=\"Constants of the rig\"><thead role=\"rowgroup\"><tr role=\"row\">\
         <th role=\"columnheader\" scope=\"col\">Constant</th><th role=\"columnheader\" scope=\"col\">Stated and found</th>\
         <th role=\"columnheader\" scope=\"col\">Found ± sd</th><th role=\"columnheader\" scope=\"col\">Verdict</th></tr></thead>\
         <tbody role=\"rowgroup\">{rows}</tbody></table>"
    )
}

fn row(constant: &ConstantEstimate, reach: f64) -> String {
    let about = CalibrationConstant::named(&constant.name);
    let name = about.map_or_else(|| escape(&constant.name), |about| escape(about.label));
    let (unit, factor) = unit(about);
    let found = with_sd(constant.value, constant.sd, factor);
    let stated = with_sd(constant.stated, constant.prior_sd, factor);
    let (class, verdict) = verdict(constant, about);
    format!(
        "<tr role=\"row\" class=\"{class}\"><th role=\"rowheader\" scope=\"row\">{name}</th><td role=\"cell\" class=\"picture\">{}</td>\
         <td role=\"cell\" class=\"number\">{found}{unit}<small>stated {stated}{unit}</small></td><td role=\"cell\" class=\"says\">{verdict}</td></tr>",
        picture(constant, reach)
    )
}

/// Unit as it follows a number, and how many of it are in one of the constant's own.
fn unit(about: Option<&CalibrationConstant>) -> (&'static str, f64) {
    about.map_or(("", 1.0), |about| {
        let unit = match about.unit {
            "mm" => " mm",
            "ms" => " ms",
            "deg" => "°",
            _ => " %",
        };
        (unit, about.units_per_si)
    })
}

/// A value and its standard deviation, with as many decimals as that has meaning.
fn with_sd(value: f64, sd: f64, factor: f64) -> String {
    let (value, sd) = (value * factor, sd * factor);
    if !(sd.is_finite() && sd > 0.0) {
        return format!("{} ± {}", number(value), number(sd));
    }
    let places = (1.0 - sd.log10().floor()).clamp(0.0, 5.0) as usize;
    format!("{} ± {}", decimals(value, places), decimals(sd, places))
}

/// Class of the row, and the phrase.
fn verdict(constant: &ConstantEstimate, about: Option<&CalibrationConstant>) -> (&'static str, String) {
    let off = (constant.value - constant.stated).abs() / constant.prior_sd;
    let share = constant.sd / constant.prior_sd;
    let phrase = |bold: String, rest: String| format!("<b>{bold}</b>{rest}");
    let after = |text: Option<&str>| text.map_or_else(String::new, |text| format!(": {text}"));
    if !off.is_finite() || !share.is_finite() {
        return ("untold", phrase("not told:".to_owned(), " the estimate has no number".to_owned()));
    }
    let finer = || {
        let times = 1.0 / share;
        let times = if times >= 10.0 { decimals(times, 0) } else { decimals(times, 1) };
        if share > 0.0 { format!(", {times} times finer than stated") } else { String::new() }
    };
    if off > OFF_SDS {
        let bold = format!("{} prior sd off", decimals(off, 1));
        // Where the log says nothing of a constant, it cannot say that it is wrong.
        let rest = if share > UNTOLD {
            ", yet not told by this log: something else is wrong, see the reasons at the top".to_owned()
        } else {
            after(about.map(|about| about.check))
        };
        return ("off", phrase(bold, rest));
    }
    match share {
        _ if share < TOLD => ("told", phrase("told by the log".to_owned(), finer())),
        _ if share > UNTOLD => {
            ("untold", phrase("not told by this log".to_owned(), after(about.map(|about| about.motion))))
        }
        _ => ("partly", phrase("partly told".to_owned(), finer())),
    }
}

/// Half of the width of all pictures, in standard deviations of what was stated.
fn reach(open: &[&ConstantEstimate]) -> f64 {
    let needs = open.iter().map(|constant| {
        (constant.value - constant.stated).abs() / constant.prior_sd + BAR_SDS * constant.sd / constant.prior_sd
    });
    needs.filter(|need| need.is_finite()).fold(LEAST_REACH, f64::max).min(MOST_REACH)
}

/// The stated value as a pale bar in the middle, the estimate as a dot with its error bar, at the width of the box: places are percentages.
fn picture(constant: &ConstantEstimate, reach: f64) -> String {
    let &ConstantEstimate { value, sd, stated, prior_sd, .. } = constant;
    let place = |at: f64| 50.0 + 50.0 * (at - stated) / (reach * prior_sd);
    let inside = |percent: &f64| (0.0..=100.0).contains(percent);
    let half = 50.0 * BAR_SDS / reach;
    let mut drawing = format!(
        "<rect class=\"prior\" x=\"{:.2}%\" y=\"4\" width=\"{:.2}%\" height=\"16\" rx=\"3\"/>",
        50.0 - half,
        2.0 * half
    );
    if stated != 0.0 {
        drawing += "<line class=\"stated\" x1=\"50%\" x2=\"50%\" y1=\"4\" y2=\"20\"/>";
    }
    let zero = place(0.0);
    if inside(&zero) {
        drawing += &format!("<line class=\"origin\" x1=\"{zero:.2}%\" x2=\"{zero:.2}%\" y1=\"0\" y2=\"24\"/>");
    }
    let at = place(value);
    if inside(&at) {
        let ends = [place(value - BAR_SDS * sd), place(value + BAR_SDS * sd)];
        if ends.iter().all(|end| end.is_finite()) {
            let [from, to] = ends.map(|end| end.clamp(0.0, 100.0));
            drawing += &format!("<line class=\"bar\" x1=\"{from:.2}%\" x2=\"{to:.2}%\" y1=\"12\" y2=\"12\"/>");
            for end in ends.iter().filter(|end| inside(end)) {
                drawing += &format!("<line class=\"bar\" x1=\"{end:.2}%\" x2=\"{end:.2}%\" y1=\"8\" y2=\"16\"/>");
            }
        }
        drawing += &format!("<circle class=\"found\" cx=\"{at:.2}%\" cy=\"12\" r=\"3\"/>");
    } else if at.is_finite() {
        // Further off than the picture reaches: an arrow that points there.
        let (edge, arrow) = if at > 50.0 { ("100%", "M-10 6L0 12L-10 18Z") } else { ("0%", "M10 6L0 12L10 18Z") };
        drawing += &format!("<svg x=\"{edge}\" overflow=\"visible\"><path class=\"found\" d=\"{arrow}\"/></svg>");
    }
    let (unit, factor) = unit(CalibrationConstant::named(&constant.name));
    let words = format!(
        "stated {}{unit}, found {}{unit}, each with two standard deviations",
        with_sd(stated, BAR_SDS * prior_sd, factor),
        with_sd(value, BAR_SDS * sd, factor)
    );
    format!("<svg role=\"img\" aria-label=\"{words}\" width=\"100%\" height=\"24\">{drawing}</svg>")
}

/// How well the size is known, from what no log tells.
fn size(size_sd: f64, offset_sd_m: f64) -> String {
    let percent = format!("{}\u{a0}%", number(100.0 * size_sd));
    let (value, unit) = length(offset_sd_m);
    let shift = format!("{value}\u{a0}{unit} all around");
    // What is not a number is shown as missing rather than taken for exact.
    let (known, because, them) = match (size_sd == 0.0, offset_sd_m == 0.0) {
        (true, true) => {
            return "as exact as the scale and the surface offset of the pads were stated to be; no log can check these two.".to_owned();
        }
        (false, true) => (percent, "the common scale", "it against a calliper"),
        (true, false) => (shift, "the common surface offset", "it with a calliper"),
        (false, false) => {
            (format!("{percent} and {shift}"), "the common scale and the common surface offset", "them with a calliper")
        }
    };
    format!("known to {known}, because no log can tell {because}; measure {them}.")
}

#[cfg(test)]
mod tests {
    use super::{picture, size, verdict, with_sd};
    use palpate::reconstruct::ConstantEstimate;

    fn constant(value: f64, sd: f64) -> ConstantEstimate {
        ConstantEstimate { name: "s1_zero_m".to_owned(), value, sd, stated: 0.0, prior_sd: 1e-3 }
    }

    #[test]
    fn decimals_follow_the_standard_deviation() {
        assert_eq!(with_sd(-2.2e-5, 2.31e-5, 1e3), "\u{2212}0.022 ± 0.023");
        assert_eq!(with_sd(0.0, 5e-4, 1e3), "0.00 ± 0.50");
        assert_eq!(with_sd(0.123_456, 0.012, 1e3), "123 ± 12");
        assert_eq!(with_sd(f64::NAN, 1.0, 1.0), "– ± 1.0");
        assert_eq!(with_sd(1.0, f64::INFINITY, 1.0), "1.00 ± –");
        assert_eq!(with_sd(1e300, 1e-300, 1.0), "1.00\u{a0}×\u{a0}10³⁰⁰ ± 0.00000");
    }

    #[test]
    fn verdicts_change_at_their_limits() {
        let class = |value, sd| verdict(&constant(value, sd), None).0;
        let cases = [(0.0, 1.9e-4), (0.0, 2.1e-4), (0.0, 7.9e-4), (0.0, 8.1e-4), (2.9e-3, 1e-4), (-3.1e-3, 1e-4)];
        let found = cases.map(|(value, sd)| class(value, sd));
        assert_eq!(found, ["told", "partly", "partly", "untold", "told", "off"]);
        assert_eq!(class(f64::NAN, 1e-4), "untold");
        assert_eq!(class(0.0, f64::INFINITY), "untold");
        // A log that says nothing of a constant cannot say that it is wrong.
        assert!(verdict(&constant(4e-3, 1e-3), None).1.contains("something else is wrong"));
    }

    #[test]
    fn what_lies_beyond_the_picture_is_an_arrow() {
        assert!(picture(&constant(1e-4, 1e-5), 3.0).contains("<circle"));
        let beyond = picture(&constant(1.0, 1e-5), 6.0);
        assert!(!beyond.contains("<circle") && beyond.contains("<svg x=\"100%\""));
        assert!(picture(&constant(-1.0, 1e-5), 6.0).contains("<svg x=\"0%\""));
        let nothing = picture(&constant(f64::NAN, f64::NAN), 3.0);
        assert!(!nothing.contains("<circle") && !nothing.contains("NaN"));
    }

    #[test]
    fn the_size_is_said_of_what_is_open() {
        assert!(size(0.007_07, 3.54e-4).starts_with("known to 0.71\u{a0}% and 0.35\u{a0}mm all around, because"));
        assert!(size(0.007_07, 0.0).starts_with("known to 0.71\u{a0}%, because no log can tell the common scale;"));
        assert!(
            size(0.0, 5e-5)
                .starts_with("known to 50.0\u{a0}µm all around, because no log can tell the common surface offset;")
        );
        assert!(size(0.0, 0.0).starts_with("as exact as"));
        assert!(size(f64::NAN, f64::INFINITY).starts_with("known to –\u{a0}% and –\u{a0}mm"));
    }
}
