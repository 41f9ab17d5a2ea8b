//! Which topics and fields hold what: a small TOML file.

use std::path::Path;

use serde::Deserialize;

use crate::error::SourceError;
use crate::join::JoinOptions;
use crate::rigs::RigKind;
use crate::ros::field::Field;

/// What the file says.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Topics {
    phi1: Option<Entry>,
    phi2: Option<Entry>,
    s1: Option<Entry>,
    s2: Option<Entry>,
    force1: Option<Entry>,
    force2: Option<Entry>,
    pivot_x: Option<Entry>,
    pivot_y: Option<Entry>,
    s: Option<Entry>,
    /// Readings of the two pads closer in time than this are of one instant.
    #[serde(default = "together_ms")]
    together_ms: f64,
    /// Angles, or the pivot, are interpolated over no longer than this.
    #[serde(default = "longest_gap_ms")]
    longest_gap_ms: f64,
}

fn together_ms() -> f64 {
    1e3 * JoinOptions::default().together_s
}

fn longest_gap_ms() -> f64 {
    1e3 * JoinOptions::default().longest_gap_s
}

/// One quantity.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    topic: String,
    field: Field,
    unit: Option<Unit>,
}

/// A unit that is not that of ROS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Unit {
    M,
    Cm,
    Mm,
    Um,
    Rad,
    Deg,
    N,
    Mn,
}

/// What a number is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Angle φ₁ or φ₂.
    Angle(usize),
    /// X or Y of the pivot.
    Pivot(usize),
    /// Contact position on palm 1 or 2, or on the only pad.
    Position(usize),
    /// Normal force there.
    Force(usize),
}

/// A number to look for in the messages of a topic.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(crate) topic: String,
    pub(crate) field: Field,
    pub(crate) quantity: Quantity,
    /// Units of the message in one of SI.
    per_si: f64,
}

impl Wanted {
    /// A number of the message in SI.
    pub(crate) fn to_si(&self, value: f64) -> f64 {
        value / self.per_si
    }
}

impl Topics {
    pub(crate) fn read(path: &Path) -> Result<Self, SourceError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| SourceError::io(path.display().to_string(), "it cannot be read", &error))?;
        Self::parse(path, &text)
    }

    /// `path` stands for the file in messages.
    pub(crate) fn parse(path: &Path, text: &str) -> Result<Self, SourceError> {
        let topics: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            let place = line.map_or_else(String::new, |line| format!("line {line}: "));
            SourceError::settings(path, format!("{place}{}", error.message()))
        })?;
        for (key, value) in [("together_ms", topics.together_ms), ("longest_gap_ms", topics.longest_gap_ms)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SourceError::settings(path, format!("{key} must be a positive number of milliseconds")));
            }
        }
        let rig = topics.rig_kind();
        let (of_rig, others) = topics.all().into_iter().partition::<Vec<_>, _>(|(of, ..)| *of == rig);
        let missing = of_rig.iter().find(|(_, name, _, entry)| entry.is_none() && !name.starts_with("force"));
        if let Some((_, name, ..)) = missing {
            return Err(SourceError::settings(path, format!("missing field `{name}`")));
        }
        if let Some((_, name, ..)) = others.iter().find(|(.., entry)| entry.is_some()) {
            return Err(SourceError::settings(
                path,
                format!("{name} is of two palms, and pivot_x of a pivoting grasp; keep one of the rigs"),
            ));
        }
        for (name, quantity, entry) in topics.entries() {
            if entry.per_si(quantity).is_none() {
                let problem = format!(
                    "{name}: this unit is none of its own; lengths have m, cm, mm or um, angles rad or deg, forces n or mn"
                );
                return Err(SourceError::settings(path, problem));
            }
        }
        Ok(topics)
    }

    /// Of which rig the bag is.
    pub(crate) fn rig_kind(&self) -> RigKind {
        let is_pivot = [&self.pivot_x, &self.pivot_y, &self.s].into_iter().any(Option::is_some);
        if is_pivot { RigKind::Pivot } else { RigKind::Palms }
    }

    fn all(&self) -> [(RigKind, &'static str, Quantity, Option<&Entry>); 9] {
        let (palms, pivot) = (RigKind::Palms, RigKind::Pivot);
        [
            (palms, "phi1", Quantity::Angle(0), self.phi1.as_ref()),
            (palms, "phi2", Quantity::Angle(1), self.phi2.as_ref()),
            (palms, "s1", Quantity::Position(0), self.s1.as_ref()),
            (palms, "s2", Quantity::Position(1), self.s2.as_ref()),
            (palms, "force1", Quantity::Force(0), self.force1.as_ref()),
            (palms, "force2", Quantity::Force(1), self.force2.as_ref()),
            (pivot, "pivot_x", Quantity::Pivot(0), self.pivot_x.as_ref()),
            (pivot, "pivot_y", Quantity::Pivot(1), self.pivot_y.as_ref()),
            (pivot, "s", Quantity::Position(0), self.s.as_ref()),
        ]
    }

    fn entries(&self) -> Vec<(&'static str, Quantity, &Entry)> {
        self.all().into_iter().filter_map(|(_, name, quantity, entry)| Some((name, quantity, entry?))).collect()
    }

    pub(crate) fn wanted(&self) -> Vec<Wanted> {
        let wanted = |(_, quantity, entry): (_, _, &Entry)| {
            let per_si = entry.per_si(quantity)?;
            Some(Wanted { topic: entry.topic.clone(), field: entry.field.clone(), quantity, per_si })
        };
        self.entries().into_iter().filter_map(wanted).collect()
    }

    pub(crate) fn join(&self) -> JoinOptions {
        JoinOptions { together_s: 1e-3 * self.together_ms, longest_gap_s: 1e-3 * self.longest_gap_ms }
    }
}

impl Entry {
    /// `None` where the unit is not one of the quantity.
    fn per_si(&self, quantity: Quantity) -> Option<f64> {
        match (quantity, self.unit) {
            (_, None)
            | (Quantity::Position(_) | Quantity::Pivot(_), Some(Unit::M))
            | (Quantity::Angle(_), Some(Unit::Rad))
            | (Quantity::Force(_), Some(Unit::N)) => Some(1.0),
            (Quantity::Position(_) | Quantity::Pivot(_), Some(Unit::Cm)) => Some(1e2),
            (Quantity::Position(_) | Quantity::Pivot(_), Some(Unit::Mm)) | (Quantity::Force(_), Some(Unit::Mn)) => {
                Some(1e3)
            }
            (Quantity::Position(_) | Quantity::Pivot(_), Some(Unit::Um)) => Some(1e6),
            (Quantity::Angle(_), Some(Unit::Deg)) => Some(1_f64.to_degrees()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOPICS: &str = r#"
        phi1 = { topic = "/joint_states", field = "position[palm1]" }
        phi2 = { topic = "/joint_states", field = "position[palm2]", unit = "deg" }
        s1 = { topic = "/palm1/contact", field = "point.x" }
        s2 = { topic = "/pads", field = "data[1]", unit = "mm" }
        force2 = { topic = "/palm2/wrench", field = "wrench.force.z" }
        together_ms = 10
    "#;

    const ENTRY: &str = r#"{ topic = "/arm", field = "point.x" }"#;
    const ANGLE: &str = r#"{ topic = "/arm", field = "point.x", unit = "deg" }"#;

    fn parse(text: &str) -> Result<Topics, SourceError> {
        Topics::parse("topics.toml".as_ref(), text)
    }

    #[test]
    fn topics_fields_and_units_are_read() {
        let topics = parse(TOPICS).expect("topics");
        let wanted = topics.wanted();
        let found: Vec<_> = wanted.iter().map(|wanted| (wanted.quantity, wanted.to_si(180.0))).collect();
        let [angle1, angle2] = [Quantity::Angle(0), Quantity::Angle(1)];
        assert_eq!(found[..2], [(angle1, 180.0), (angle2, std::f64::consts::PI)]);
        assert_eq!(
            found[2..],
            [(Quantity::Position(0), 180.0), (Quantity::Position(1), 0.18), (Quantity::Force(1), 180.0)]
        );
        assert_eq!(topics.join(), JoinOptions { together_s: 0.01, longest_gap_s: 0.1 });
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let wrong = [
            (TOPICS.replace("palm1]", "palm1"), "topics.toml: line 2: "),
            (TOPICS.replace("\"deg\"", "\"mm\""), "topics.toml: phi2: "),
            (TOPICS.replace("s1 =", "s3 ="), "topics.toml: line 4: unknown field `s3`"),
            (TOPICS.replace("= 10", "= 0"), "topics.toml: together_ms must be"),
            (TOPICS.replace("\"mm\"", "\"inch\""), "topics.toml: line 5: "),
            (TOPICS.replace("s1 =", "force1 ="), "topics.toml: missing field `s1`"),
            (TOPICS.replace("s1 =", "s ="), "topics.toml: missing field `pivot_x`"),
            (
                format!("pivot_x = {ENTRY}\npivot_y = {ENTRY}\ns = {ENTRY}\nphi1 = {ENTRY}"),
                "topics.toml: phi1 is of two palms",
            ),
            (format!("pivot_x = {ENTRY}\npivot_y = {ENTRY}\ns = {ANGLE}"), "topics.toml: s: this unit"),
        ];
        for (text, expected) in wrong {
            let message = parse(&text).expect_err(expected).to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }
}
