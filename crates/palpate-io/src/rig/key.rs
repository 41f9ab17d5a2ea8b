//! The keys of a rig file: their names, the units they may end in, and the nearest one to a name that is none.

use crate::csv::unit::{Dimension, Unit};
use crate::rig::rig_error::RigProblem;

/// A key; in a file it is named `stem_unit`, or `stem` alone where it has no dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    stem: &'static str,
    dimension: Option<Dimension>,
}

pub(crate) const ZERO: Key = Key::length("zero");
pub(crate) const ZERO_SD: Key = Key::length("zero_sd");
pub(crate) const SCALE: Key = Key::plain("scale");
pub(crate) const SCALE_SD: Key = Key::plain("scale_sd");
pub(crate) const SURFACE: Key = Key::length("surface_offset");
pub(crate) const SURFACE_SD: Key = Key::length("surface_offset_sd");
pub(crate) const DIRECTION: Key = Key::plain("direction");
pub(crate) const LENGTH: Key = Key::length("length");
pub(crate) const READING_SD: Key = Key::length("reading_sd");
pub(crate) const COUNTS_PER_INCH: Key = Key::plain("counts_per_inch");
pub(crate) const LEVELS: Key = Key::plain("levels");
pub(crate) const FRICTION: Key = Key::plain("friction");
pub(crate) const FRICTION_SD: Key = Key::plain("friction_sd");
pub(crate) const BASE: [Key; 2] = [Key::length("base_x"), Key::length("base_y")];
pub(crate) const ANGLE_ZERO: [Key; 2] = [Key::angle("phi1_zero"), Key::angle("phi2_zero")];
pub(crate) const ANGLE_ZERO_SD: [Key; 2] = [Key::angle("phi1_zero_sd"), Key::angle("phi2_zero_sd")];
pub(crate) const SIGN: [Key; 2] = [Key::plain("sign1"), Key::plain("sign2")];
pub(crate) const ANGLE_READING_SD: Key = Key::angle("reading_sd");
pub(crate) const RATIO_SD: Key = Key::plain("scale_ratio_sd");
pub(crate) const DIFFERENCE_SD: Key = Key::length("surface_difference_sd");
pub(crate) const CLOCK: Key = Key::time("offset");
pub(crate) const CLOCK_SD: Key = Key::time("offset_sd");

const PALM_KEYS: &[Key] = &[
    ZERO,
    ZERO_SD,
    SCALE,
    SCALE_SD,
    SURFACE,
    SURFACE_SD,
    DIRECTION,
    LENGTH,
    READING_SD,
    COUNTS_PER_INCH,
    LEVELS,
    FRICTION,
    FRICTION_SD,
    BASE[0],
    BASE[1],
];
const ANGLE_KEYS: &[Key] =
    &[ANGLE_ZERO[0], ANGLE_ZERO_SD[0], ANGLE_ZERO[1], ANGLE_ZERO_SD[1], SIGN[0], SIGN[1], ANGLE_READING_SD];

/// The tables of a rig file and the keys in each.
pub(crate) const TABLES: [(&str, &[Key]); 5] = [
    ("palm1", PALM_KEYS),
    ("palm2", PALM_KEYS),
    ("pads", &[RATIO_SD, DIFFERENCE_SD]),
    ("angles", ANGLE_KEYS),
    ("clock", &[CLOCK, CLOCK_SD]),
];

impl Key {
    const fn length(stem: &'static str) -> Self {
        Self { stem, dimension: Some(Dimension::Length) }
    }

    const fn angle(stem: &'static str) -> Self {
        Self { stem, dimension: Some(Dimension::Angle) }
    }

    const fn time(stem: &'static str) -> Self {
        Self { stem, dimension: Some(Dimension::Time) }
    }

    const fn plain(stem: &'static str) -> Self {
        Self { stem, dimension: None }
    }

    /// The units it may end in, SI first; none where it has no dimension.
    fn units(self) -> impl Iterator<Item = &'static str> {
        self.dimension.map_or(&[][..], Dimension::units).iter().map(|unit| unit.suffix())
    }

    /// Its name in one of its units; "" stands for no dimension.
    pub(crate) fn named(self, unit: &str) -> String {
        if unit.is_empty() { self.stem.to_string() } else { format!("{}_{unit}", self.stem) }
    }

    /// Its names, that in SI units first.
    pub(crate) fn names(self) -> Vec<String> {
        if self.dimension.is_none() {
            vec![self.named("")]
        } else {
            self.units().map(|unit| self.named(unit)).collect()
        }
    }

    /// Its name in SI units.
    pub(crate) fn si_name(self) -> String {
        self.named(self.si_unit())
    }

    fn si_unit(self) -> &'static str {
        self.units().next().unwrap_or_default()
    }

    /// Its name in the unit that a number was likely meant in when it is far too large in SI units.
    pub(crate) fn smaller_name(self, unit: &str) -> Option<String> {
        let smaller = match self.dimension? {
            Dimension::Time => Unit::Millisecond,
            Dimension::Angle => Unit::Degree,
            Dimension::Length => Unit::Millimeter,
            Dimension::Force => return None,
        };
        (unit == self.si_unit()).then(|| self.named(smaller.suffix()))
    }

    /// A number in one of its units, in SI units.
    pub(crate) fn to_si(self, unit: &str, number: f64) -> f64 {
        let units = self.dimension.map_or(&[][..], Dimension::units);
        units.iter().find(|known| known.suffix() == unit).map_or(number, |known| known.to_si(number))
    }

    /// "zero_m, zero_cm or zero_mm".
    fn choice(self) -> String {
        let names = self.names();
        match names.split_last() {
            Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
            _ => names.concat(),
        }
    }
}

/// The key of a table that `name` names, and its unit ("" without dimension).
pub(crate) fn find(table: &str, keys: &[Key], name: &str) -> Result<(Key, &'static str), RigProblem> {
    let of_stem = |stem: &str| keys.iter().copied().find(|key| key.stem == stem);
    if let Some(key) = of_stem(name) {
        return if key.dimension.is_none() { Ok((key, "")) } else { Err(RigProblem::NoUnit { names: key.choice() }) };
    }
    if let Some((stem, unit)) = name.rsplit_once('_')
        && let Some(key) = of_stem(stem).filter(|key| key.dimension.is_some())
    {
        let known = key.units().find(|known| *known == unit);
        return known
            .map(|unit| (key, unit))
            .ok_or_else(|| RigProblem::UnknownUnit { unit: crate::csv::text::quoted(unit), names: key.choice() });
    }
    Err(RigProblem::UnknownKey { nearest: nearest_key(table, name) })
}

/// The key nearest to a name that is none, with its table; of equals one in the same table.
pub(crate) fn nearest_key(table: &str, name: &str) -> String {
    let named = |(of, keys): (&'static str, &'static [Key])| {
        keys.iter().flat_map(|key| key.names()).map(move |known| (of, known))
    };
    let nearest = TABLES.into_iter().flat_map(named).min_by_key(|(of, known)| (edits(known, name), *of != table));
    nearest.map(|(of, known)| format!("{of}.{known}")).unwrap_or_default()
}

/// The table nearest to a name that is none.
pub(crate) fn nearest_table(name: &str) -> &'static str {
    TABLES.into_iter().map(|(known, _)| known).min_by_key(|known| edits(known, name)).unwrap_or_default()
}

/// Letters that must be changed, added or left out to make a known name of another, whatever their case.
fn edits(known: &str, name: &str) -> usize {
    /// No known name is half as long.
    const MOST: usize = 64;
    let name: Vec<char> = name.chars().take(MOST).map(|letter| letter.to_ascii_lowercase()).collect();
    let mut row: Vec<usize> = (0..=name.len()).collect();
    for (index, letter) in known.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = index + 1;
        for (column, other) in name.iter().enumerate() {
            let changed = diagonal + usize::from(letter != *other);
            diagonal = row[column + 1];
            row[column + 1] = changed.min(diagonal + 1).min(row[column] + 1);
        }
    }
    row[name.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted() {
        for (known, name, count) in
            [("zero_m", "zero_m", 0), ("zero_m", "zreo_m", 2), ("scale", "Scal", 1), ("", "ab", 2), ("ab", "", 2)]
        {
            assert_eq!(edits(known, name), count, "{known} {name}");
        }
    }

    #[test]
    fn units_are_converted() {
        assert_eq!(ZERO.to_si("mm", 0.3), 0.3e-3);
        assert_eq!(ZERO_SD.to_si("um", 20.0), 20e-6);
        assert_eq!(ANGLE_ZERO[0].to_si("deg", 180.0), std::f64::consts::PI);
        assert_eq!(CLOCK.to_si("ms", 5.0), 5e-3);
        assert_eq!(SCALE.to_si("", 1.01), 1.01);
    }

    #[test]
    fn the_nearest_key_is_in_the_same_table_if_it_is_as_near() {
        assert_eq!(nearest_key("palm2", "zero_st_mm"), "palm2.zero_sd_mm");
        assert_eq!(nearest_key("palm2", "phi1_zero_rad"), "angles.phi1_zero_rad");
        assert_eq!(nearest_table("Angle"), "angles");
    }
}
