//! What a contact does: it sticks to its palm, or slides along it one way or the other.

use std::fmt;

/// Whether the material of the object sticks to a palm at the contact, or slides along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactMode {
    /// No slip: the object rolls on this palm, or rests on it.
    #[default]
    Stick,
    /// Slides along t̄, away from the base on palm 1 and towards it on palm 2.
    SlidePlus,
    /// Slides against t̄.
    SlideMinus,
}

impl ContactMode {
    /// As in files: `stick`, `slide+` or `slide-`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stick => "stick",
            Self::SlidePlus => "slide+",
            Self::SlideMinus => "slide-",
        }
    }

    /// That of a name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Stick, Self::SlidePlus, Self::SlideMinus].into_iter().find(|mode| mode.name() == name)
    }

    /// Sliding in the direction of a sign.
    pub(crate) fn sliding(sign: f64) -> Self {
        if sign > 0.0 { Self::SlidePlus } else { Self::SlideMinus }
    }

    /// Sign of the slip along t̄, 0 where it sticks.
    pub fn slip_sign(self) -> f64 {
        match self {
            Self::Stick => 0.0,
            Self::SlidePlus => 1.0,
            Self::SlideMinus => -1.0,
        }
    }

    /// That with a sign of the slip; `None` where it is not a number.
    pub fn of_slip_sign(sign: f64) -> Option<Self> {
        match sign {
            _ if sign.is_nan() => None,
            0.0 => Some(Self::Stick),
            sign => Some(Self::sliding(sign)),
        }
    }
}

impl fmt::Display for ContactMode {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back() {
        for mode in [ContactMode::Stick, ContactMode::SlidePlus, ContactMode::SlideMinus] {
            assert_eq!(ContactMode::named(&mode.to_string()), Some(mode));
            assert_eq!(ContactMode::of_slip_sign(mode.slip_sign()), Some(mode));
        }
        assert_eq!((ContactMode::named("slide"), ContactMode::of_slip_sign(f64::NAN)), (None, None));
        assert_eq!(
            (ContactMode::sliding(2.0), ContactMode::sliding(-0.1)),
            (ContactMode::SlidePlus, ContactMode::SlideMinus)
        );
    }
}
