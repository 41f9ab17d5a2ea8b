//! A number in a message, named by its path: `position[palm1]`, `point.x`, `wrench.force.z`, `data[0]`.

use std::str::FromStr;

use serde::Deserialize;

use crate::ros::message::{Message, MessageKind, Vector};

/// Where in a message the number stands.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) enum Field {
    /// `position[NAME]` or `position[INDEX]`.
    Position(Joint),
    /// `effort[NAME]` or `effort[INDEX]`.
    Effort(Joint),
    /// `point.x`.
    Point(Axis),
    /// `wrench.force.x`.
    Force(Axis),
    /// `wrench.torque.x`.
    Torque(Axis),
    /// `data[INDEX]`.
    Data(usize),
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Joint {
    Named(String),
    At(usize),
}

/// A coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

impl FromStr for Field {
    type Err = String;

    fn from_str(path: &str) -> Result<Self, String> {
        let unknown = || {
            format!(
                "{path:?} is no field; write position[JOINT], effort[JOINT], point.x, wrench.force.x, wrench.torque.x (or .y, .z) or data[0]"
            )
        };
        let indexed = path.strip_suffix(']').and_then(|path| path.split_once('['));
        if let Some((array, key)) = indexed.filter(|(_, key)| !key.is_empty()) {
            let joint = || key.parse().map_or_else(|_| Joint::Named(key.to_owned()), Joint::At);
            return match array {
                "position" => Ok(Self::Position(joint())),
                "effort" => Ok(Self::Effort(joint())),
                "data" => key.parse().map(Self::Data).map_err(|_| unknown()),
                _ => Err(unknown()),
            };
        }
        let (vector, axis) = path.rsplit_once('.').ok_or_else(unknown)?;
        let axis = match axis {
            "x" => Axis::X,
            "y" => Axis::Y,
            "z" => Axis::Z,
            _ => return Err(unknown()),
        };
        match vector {
            "point" => Ok(Self::Point(axis)),
            "wrench.force" => Ok(Self::Force(axis)),
            "wrench.torque" => Ok(Self::Torque(axis)),
            _ => Err(unknown()),
        }
    }
}

impl TryFrom<String> for Field {
    type Error = String;

    fn try_from(path: String) -> Result<Self, String> {
        path.parse()
    }
}

impl Field {
    /// The kind of message that has it.
    pub(crate) fn kind(&self) -> MessageKind {
        match self {
            Self::Position(_) | Self::Effort(_) => MessageKind::JointState,
            Self::Point(_) => MessageKind::PointStamped,
            Self::Force(_) | Self::Torque(_) => MessageKind::WrenchStamped,
            Self::Data(_) => MessageKind::Float64MultiArray,
        }
    }

    /// The number; `None` where this message does not have it.
    pub(crate) fn of(&self, message: &Message) -> Option<f64> {
        match (self, message) {
            (Self::Position(joint), Message::JointState(state)) => joint.of(&state.name, &state.position),
            (Self::Effort(joint), Message::JointState(state)) => joint.of(&state.name, &state.effort),
            (Self::Point(axis), Message::PointStamped(stamped)) => Some(axis.of(stamped.point)),
            (Self::Force(axis), Message::WrenchStamped(stamped)) => Some(axis.of(stamped.wrench.force)),
            (Self::Torque(axis), Message::WrenchStamped(stamped)) => Some(axis.of(stamped.wrench.torque)),
            (Self::Data(index), Message::Float64MultiArray(array)) => array.data.get(*index).copied(),
            _ => None,
        }
    }
}

impl Joint {
    fn of(&self, names: &[String], values: &[f64]) -> Option<f64> {
        let index = match self {
            Self::Named(name) => names.iter().position(|found| found == name)?,
            Self::At(index) => *index,
        };
        values.get(index).copied()
    }
}

impl Axis {
    fn of(self, vector: Vector) -> f64 {
        match self {
            Self::X => vector.x,
            Self::Y => vector.y,
            Self::Z => vector.z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::message::Encoding;

    const JOINTS: &str = r#"{"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}, "name": ["a", "b"], "position": [1, 2], "velocity": [], "effort": [3]}"#;
    const WRENCH: &str = r#"{"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}, "wrench": {"force": {"x": 1, "y": 2, "z": 3}, "torque": {"x": 4, "y": 5, "z": 6}}}"#;
    const POINT: &str =
        r#"{"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}, "point": {"x": 1, "y": 2, "z": 3}}"#;
    const ARRAY: &str = r#"{"layout": {"dim": [], "data_offset": 0}, "data": [1, 2, 3]}"#;

    #[test]
    fn numbers_are_found_by_their_paths() {
        let cases = [
            ("position[b]", JOINTS, Some(2.0)),
            ("position[0]", JOINTS, Some(1.0)),
            ("position[c]", JOINTS, None),
            ("effort[a]", JOINTS, Some(3.0)),
            ("effort[b]", JOINTS, None),
            ("point.y", POINT, Some(2.0)),
            ("wrench.force.z", WRENCH, Some(3.0)),
            ("wrench.torque.x", WRENCH, Some(4.0)),
            ("data[2]", ARRAY, Some(3.0)),
            ("data[3]", ARRAY, None),
        ];
        for (path, json, value) in cases {
            let field: Field = path.parse().expect(path);
            let message = field.kind().decode(Encoding::Json, json.as_bytes()).expect(path);
            assert_eq!(field.of(&message), value, "{path}");
        }
        for path in ["", "x", "position", "position[]", "velocity[a]", "data[a]", "point.w", "force.x", "data[0"] {
            assert!(path.parse::<Field>().is_err(), "{path}");
        }
    }
}
