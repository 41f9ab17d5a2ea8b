//! Units that a column name may carry, and their conversion to SI.

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dimension {
    Time,
    Angle,
    Length,
    Force,
}

/// A unit that is understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    Second,
    Millisecond,
    Microsecond,
    Nanosecond,
    Radian,
    Degree,
    Meter,
    Centimeter,
    Millimeter,
    Micrometer,
    Newton,
}

impl Dimension {
    /// The units understood, SI first; beyond that from large to small.
    pub(crate) fn units(self) -> &'static [Unit] {
        match self {
            Dimension::Time => &[Unit::Second, Unit::Millisecond, Unit::Microsecond, Unit::Nanosecond],
            Dimension::Angle => &[Unit::Radian, Unit::Degree],
            Dimension::Length => &[Unit::Meter, Unit::Centimeter, Unit::Millimeter, Unit::Micrometer],
            Dimension::Force => &[Unit::Newton],
        }
    }
}

impl Unit {
    /// The end of a column name in this unit, and its symbol in messages.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Unit::Second => "s",
            Unit::Millisecond => "ms",
            Unit::Microsecond => "us",
            Unit::Nanosecond => "ns",
            Unit::Radian => "rad",
            Unit::Degree => "deg",
            Unit::Meter => "m",
            Unit::Centimeter => "cm",
            Unit::Millimeter => "mm",
            Unit::Micrometer => "um",
            Unit::Newton => "n",
        }
    }

    /// A value in this unit as SI. Divides by exact powers of ten, so that 29.7 mm is the same number as 0.0297 m.
    pub(crate) fn to_si(self, value: f64) -> f64 {
        match self {
            Unit::Second | Unit::Radian | Unit::Meter | Unit::Newton => value,
            Unit::Millisecond | Unit::Millimeter => value / 1000.0,
            Unit::Centimeter => value / 100.0,
            Unit::Microsecond | Unit::Micrometer => value / 1e6,
            Unit::Nanosecond => value / 1e9,
            Unit::Degree => value.to_radians(),
        }
    }
}
