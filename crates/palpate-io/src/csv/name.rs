//! Names of columns as people and spreadsheets write them, and which column may be meant by a name that is not understood.

use crate::csv::unit::Dimension;

/// From this similarity on (Jaro–Winkler, 0 to 1) a name is worth a question: `t` for `time` has 0.78, `temp` for `time` 0.70.
const MIN_SIMILARITY: f64 = 0.75;

/// A name in plain letters: lower case, the unit after `_` whether it stood in brackets or not, `µ` as `u` and a degree sign as `deg`.
/// `Phi1 [°]` and `phi1 (deg)` both become `phi1_deg`.
pub(crate) fn plain(name: &str) -> String {
    let mut plain = String::with_capacity(name.len());
    for character in name.chars() {
        match character {
            '(' | ')' | '[' | ']' | '_' => plain.push('_'),
            blank if blank.is_whitespace() => plain.push('_'),
            // Micro sign and the Greek letter.
            '\u{b5}' | '\u{3bc}' => plain.push('u'),
            '°' => plain.push_str("_deg"),
            other => plain.push(other.to_ascii_lowercase()),
        }
    }
    plain.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")
}

/// The name among `names` that may stand for a quantity: nearly its stem, apart from a unit. The digits, which tell the palms apart, must be
/// the same.
pub(crate) fn meant<'n>(
    stem: &str,
    dimension: Option<Dimension>,
    names: impl IntoIterator<Item = &'n str>,
) -> Option<&'n str> {
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    let joined = |name: &str| name.replace('_', "");
    let without_unit = |name: &str| {
        let plain = plain(name);
        let mut units = dimension.into_iter().flat_map(Dimension::units);
        let bare = units.find_map(|unit| plain.strip_suffix(unit.suffix())?.strip_suffix('_').map(str::to_owned));
        joined(&bare.unwrap_or(plain))
    };
    let similarity = |name: &'n str| {
        let bare = without_unit(name);
        (digits(&bare) == digits(stem)).then(|| (name, strsim::jaro_winkler(&joined(stem), &bare)))
    };
    let similar = names.into_iter().filter_map(similarity).filter(|(_, similarity)| *similarity >= MIN_SIMILARITY);
    similar.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_may_stand_in_brackets() {
        for name in ["phi1_deg", "phi1 (deg)", "Phi1 [DEG]", "phi1(°)", "phi1 °", "phi1_[deg]", " phi1  deg "] {
            assert_eq!(plain(name), "phi1_deg", "{name}");
        }
        assert_eq!(plain("s1_sd (µm)"), "s1_sd_um");
        assert_eq!(plain("Time [μs]"), "time_us");
        assert_eq!(plain("s1"), "s1");
    }

    #[test]
    fn a_name_that_is_nearly_right_may_be_meant() {
        let length = |stem: &str, names: &[&'static str]| meant(stem, Some(Dimension::Length), names.iter().copied());
        assert_eq!(length("s1", &["s_2_mm", "s_1_mm", "other"]), Some("s_1_mm"));
        assert_eq!(length("s2", &["s_1_mm", "s1b"]), None);
        let time = |name: &'static str| meant("time", Some(Dimension::Time), [name]);
        // On each side of the limit.
        assert_eq!(time("t [s]"), Some("t [s]"));
        assert_eq!(time("temp_s"), None);
        assert_eq!(meant("phi1", Some(Dimension::Angle), ["ph1_deg", "theta1_deg"]), Some("ph1_deg"));
    }
}
