//! One table of a rig file: its values by key, each checked as it is taken.

use toml::de::DeValue;

use crate::csv::text;
use crate::rig::key::{self, Key};
use crate::rig::rig_error::{RigError, RigProblem};

/// A largest value in SI units, and how messages show it.
#[derive(Clone, Copy)]
pub(crate) struct Limit(pub(crate) f64, pub(crate) &'static str);

/// What stands at a key.
pub(crate) struct Entry<'a> {
    /// Name in the file.
    pub(crate) name: &'a str,
    /// Line in the file, from 1.
    pub(crate) line: usize,
    pub(crate) value: &'a DeValue<'a>,
    /// The value as the file has it.
    pub(crate) source: &'a str,
}

/// A table whose keys are known.
pub(crate) struct Table<'a> {
    file: &'a str,
    name: &'static str,
    found: Vec<Found<'a>>,
}

struct Found<'a> {
    key: Key,
    unit: &'static str,
    entry: Entry<'a>,
}

impl Found<'_> {
    /// The value as messages show it, with its unit.
    fn shown(&self) -> String {
        let space = if self.unit.is_empty() { "" } else { " " };
        format!("{}{space}{}", text::quoted(self.entry.source), self.unit)
    }

    /// The value in SI units.
    fn number(&self) -> Result<f64, RigProblem> {
        let number = match self.entry.value {
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
            }
            DeValue::Float(float) => float.as_str().parse().ok(),
            _ => None,
        };
        let number = number.ok_or_else(|| RigProblem::NotANumber { text: text::quoted(self.entry.source) })?;
        if number.is_finite() {
            Ok(self.key.to_si(self.unit, number))
        } else {
            Err(RigProblem::NotFinite { text: self.shown() })
        }
    }
}

impl<'a> Table<'a> {
    /// A table of the file with the entries in it, in the order of the lines.
    pub(crate) fn new(
        file: &'a str,
        name: &'static str,
        keys: &[Key],
        entries: Vec<Entry<'a>>,
    ) -> Result<Self, RigError> {
        let mut table = Self { file, name, found: Vec::new() };
        for entry in entries {
            let error = |problem| RigError::at_key(file, entry.line, &format!("{name}.{}", entry.name), problem);
            let (key, unit) = key::find(name, keys, entry.name).map_err(error)?;
            if let Some(first) = table.found(key) {
                let (first, first_line) = (format!("{name}.{}", first.entry.name), first.entry.line);
                return Err(error(RigProblem::Twice { first, first_line }));
            }
            table.found.push(Found { key, unit, entry });
        }
        Ok(table)
    }

    fn found(&self, key: Key) -> Option<&Found<'a>> {
        self.found.iter().find(|found| found.key == key)
    }

    /// What `take` makes of the value of a key, if there is one.
    fn take<T>(&self, key: Key, take: impl Fn(&Found<'a>) -> Result<T, RigProblem>) -> Result<Option<T>, RigError> {
        let Some(found) = self.found(key) else { return Ok(None) };
        let error = |problem| {
            let entry = &found.entry;
            RigError::at_key(self.file, entry.line, &format!("{}.{}", self.name, entry.name), problem)
        };
        take(found).map(Some).map_err(error)
    }

    /// A number that passes, or else the problem with it.
    fn number_if(
        &self,
        key: Key,
        passes: impl Fn(f64) -> bool,
        problem: impl Fn(String) -> RigProblem,
    ) -> Result<Option<f64>, RigError> {
        self.take(key, |found| {
            let number = found.number()?;
            if passes(number) { Ok(number) } else { Err(problem(found.shown())) }
        })
    }

    /// A standard deviation; 0 = exact.
    pub(crate) fn sd(&self, key: Key) -> Result<Option<f64>, RigError> {
        self.number_if(key, |sd| sd >= 0.0, |text| RigProblem::NegativeSd { text })
    }

    /// A number of either sign, up to a limit.
    pub(crate) fn within(&self, key: Key, limit: Limit) -> Result<Option<f64>, RigError> {
        self.take(key, |found| {
            let number = found.number()?;
            if number.abs() <= limit.0 {
                return Ok(number);
            }
            Err(RigProblem::Beyond { text: found.shown(), limit: limit.1, smaller: key.smaller_name(found.unit) })
        })
    }

    /// A number above 0.
    pub(crate) fn positive(&self, key: Key) -> Result<Option<f64>, RigError> {
        self.number_if(key, |number| number > 0.0, |text| RigProblem::NotPositive { text })
    }

    /// A scale.
    pub(crate) fn scale(&self, key: Key) -> Result<Option<f64>, RigError> {
        self.number_if(key, |scale| (0.5..=2.0).contains(&scale), |text| RigProblem::Scale { text })
    }

    /// A sign, 1 or −1.
    pub(crate) fn sign(&self, key: Key) -> Result<Option<f64>, RigError> {
        self.number_if(key, |sign| sign.abs() == 1.0, |text| RigProblem::Sign { text })
    }

    /// A number of pressure levels.
    pub(crate) fn levels(&self, key: Key) -> Result<Option<u32>, RigError> {
        let possible = 2.0..=f64::from(u32::MAX);
        let whole = |levels: f64| levels.fract() == 0.0 && possible.contains(&levels);
        let levels = self.number_if(key, whole, |text| RigProblem::Levels { text })?;
        Ok(levels.map(|levels| levels as u32))
    }

    /// A coefficient of friction and its standard deviation.
    pub(crate) fn friction(&self, key: Key, sd: Key) -> Result<[Option<f64>; 2], RigError> {
        let friction = self.number_if(key, |mu| mu >= 0.0, |text| RigProblem::NegativeFriction { text })?;
        let needed = || RigProblem::FrictionNeeded { friction: self.full_name(key) };
        self.take(sd, |_| friction.ok_or_else(needed))?;
        Ok([friction, self.sd(sd)?])
    }

    /// Whether the pad counts from the tip, which takes its length.
    pub(crate) fn counts_from_tip(&self, key: Key, length: Key) -> Result<bool, RigError> {
        let counts = self.take(key, |found| match found.entry.value.as_str() {
            Some("from_base") => Ok(false),
            Some("to_base") if self.found(length).is_none() => {
                Err(RigProblem::LengthNeeded { length: self.full_name(length) })
            }
            Some("to_base") => Ok(true),
            _ => Err(RigProblem::Direction { text: text::quoted(found.entry.source) }),
        })?;
        Ok(counts.unwrap_or(false))
    }

    fn full_name(&self, key: Key) -> String {
        format!("{}.{}", self.name, key.si_name())
    }
}
