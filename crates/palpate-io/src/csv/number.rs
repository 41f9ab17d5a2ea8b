//! Numbers as they are written to files.

/// The shortest text that reads back as the same number; an exponent only where the digits would run long.
/// Infinity is `inf`, not-a-number `NaN`, both understood by numpy and pandas.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && size.is_finite() && !(1e-5..1e16).contains(&size) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

/// The number to six digits, as messages show what was computed.
pub(crate) fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// One line of a CSV file, ended.
pub(crate) fn push_row(text: &mut String, cells: impl IntoIterator<Item = String>) {
    for (index, cell) in cells.into_iter().enumerate() {
        if index > 0 {
            text.push(',');
        }
        text.push_str(&cell);
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_the_same() {
        for value in
            [0.0, -0.0, 1.0, 0.1, 1.0 / 3.0, 1e-5, 9e-6, 5e-324, f64::MIN_POSITIVE, f64::MAX, -1e16, 123456.789]
        {
            let text = number(value);
            assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(value.to_bits()), "{text}");
            assert!(text.len() < 26, "{text}");
        }
        assert_eq!(number(0.0297), "0.0297");
        assert_eq!(number(2.0), "2");
        assert_eq!(number(1e-7), "1e-7");
        assert_eq!((number(f64::INFINITY), number(f64::NAN)), ("inf".to_string(), "NaN".to_string()));
    }
}
