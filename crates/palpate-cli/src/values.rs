//! Values of options: numbers in their range, with a sentence when they are not.

use palpate::reconstruct::MOST_HARMONICS;

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a number is needed, such as 12.5".to_string()),
    }
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("it must be above 0".to_string()) })
}

/// A number that is not below 0.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value >= 0.0 { Ok(value) } else { Err("it must not be below 0".to_string()) })
}

/// A number from 0 up to, but not including, 1.
pub fn share(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| {
        if (0.0..1.0).contains(&value) { Ok(value) } else { Err("it must be at least 0 and below 1".to_string()) }
    })
}

/// A number of harmonics that the estimator takes.
pub fn harmonics(text: &str) -> Result<usize, String> {
    match text.trim().parse::<usize>() {
        Ok(count) if (2..=MOST_HARMONICS).contains(&count) => Ok(count),
        _ => Err(format!("a whole number from 2 to {MOST_HARMONICS} is needed")),
    }
}

/// Two numbers with a comma between them.
pub fn pair(text: &str) -> Result<[f64; 2], String> {
    let needed = || "two numbers with a comma between them are needed, such as 3,-2".to_string();
    let (x, y) = text.split_once(',').ok_or_else(needed)?;
    Ok([number(x).map_err(|_| needed())?, number(y).map_err(|_| needed())?])
}

/// Coefficients of friction of both palms: one number for both, or two.
pub fn friction(text: &str) -> Result<[f64; 2], String> {
    let both = match text.split_once(',') {
        Some(_) => pair(text)?,
        None => [number(text)?; 2],
    };
    if both.iter().all(|friction| *friction >= 0.0) { Ok(both) } else { Err("it must not be below 0".to_string()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_range_are_taken() {
        assert_eq!(number(" 1e-3 "), Ok(0.001));
        assert_eq!(positive("0.1"), Ok(0.1));
        assert_eq!(not_negative("0"), Ok(0.0));
        assert_eq!(share("0.25"), Ok(0.25));
        assert_eq!(pair("3,-2"), Ok([3.0, -2.0]));
        assert_eq!((friction("0.2"), friction("0,0.3")), (Ok([0.2; 2]), Ok([0.0, 0.3])));
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for text in ["", "ten", "nan", "inf", "1,5"] {
            assert!(number(text).is_err(), "{text}");
        }
        assert!(positive("0").is_err());
        assert!(not_negative("-1").is_err());
        assert!(share("1").is_err());
        assert!(friction("-0.1").is_err() && friction("0.1,-1").is_err() && friction("a").is_err());
        for text in ["3", "3,", "3,4,5", "x,1"] {
            assert!(pair(text).is_err(), "{text}");
        }
    }
}
