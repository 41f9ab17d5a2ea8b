//! The four kinds of messages that are read, from CDR and from JSON.

use byteorder::{BigEndian, LittleEndian};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Stamp {
    /// Seconds.
    #[serde(alias = "secs")]
    pub sec: i32,
    /// Nanoseconds.
    #[serde(alias = "nsec", alias = "nsecs")]
    pub nanosec: u32,
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Header {
    /// When it was measured.
    pub stamp: Stamp,
    /// In which frame.
    pub frame_id: String,
}

/// `geometry_msgs/Point` and `Vector3`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Vector {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

/// `sensor_msgs/JointState`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct JointState {
    /// Stamp and frame.
    pub header: Header,
    /// Of the joints.
    pub name: Vec<String>,
    /// Radians.
    pub position: Vec<f64>,
    /// Radians per second.
    pub velocity: Vec<f64>,
    /// Newton metres.
    pub effort: Vec<f64>,
}

/// `geometry_msgs/PointStamped`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PointStamped {
    /// Stamp and frame.
    pub header: Header,
    /// Metres.
    pub point: Vector,
}

/// `geometry_msgs/Wrench`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Wrench {
    /// Newtons.
    pub force: Vector,
    /// Newton metres.
    pub torque: Vector,
}

/// `geometry_msgs/WrenchStamped`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct WrenchStamped {
    /// Stamp and frame.
    pub header: Header,
    /// Force and torque.
    pub wrench: Wrench,
}

/// `std_msgs/MultiArrayDimension`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Dimension {
    /// What it is called.
    pub label: String,
    /// Its entries.
    pub size: u32,
    /// From one to the next.
    pub stride: u32,
}

/// `std_msgs/MultiArrayLayout`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Layout {
    /// Outermost first.
    pub dim: Vec<Dimension>,
    /// Of the first entry.
    pub data_offset: u32,
}

/// `std_msgs/Float64MultiArray`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Float64MultiArray {
    /// How the numbers are arranged.
    pub layout: Layout,
    /// The numbers.
    pub data: Vec<f64>,
}

/// A message of one of the kinds.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Joint angles.
    JointState(JointState),
    /// A point.
    PointStamped(PointStamped),
    /// A force.
    WrenchStamped(WrenchStamped),
    /// Numbers.
    Float64MultiArray(Float64MultiArray),
}

/// The kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageKind {
    /// `sensor_msgs/JointState`.
    JointState,
    /// `geometry_msgs/PointStamped`.
    PointStamped,
    /// `geometry_msgs/WrenchStamped`.
    WrenchStamped,
    /// `std_msgs/Float64MultiArray`.
    Float64MultiArray,
}

/// How a message is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Common Data Representation with its four bytes of encapsulation, as ROS 2 has it.
    Cdr,
    /// JSON with the names of the fields.
    Json,
}

/// Why a message says nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MessageError {
    /// The four bytes before a CDR message say neither byte order.
    #[error("the message does not begin as plain CDR does")]
    Encapsulation,
    /// It ends early, or its fields are not as the kind has them.
    #[error("{0}")]
    Content(String),
}

impl MessageKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::JointState, Self::PointStamped, Self::WrenchStamped, Self::Float64MultiArray];

    /// The name of its schema.
    pub fn name(self) -> &'static str {
        match self {
            Self::JointState => "sensor_msgs/msg/JointState",
            Self::PointStamped => "geometry_msgs/msg/PointStamped",
            Self::WrenchStamped => "geometry_msgs/msg/WrenchStamped",
            Self::Float64MultiArray => "std_msgs/msg/Float64MultiArray",
        }
    }

    /// By the name of a schema, with or without `/msg`.
    pub fn of_schema(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name || kind.name().replace("/msg/", "/") == name)
    }

    /// Reads a message of this kind.
    ///
    /// # Errors
    /// It ends early, or is not of this kind.
    pub fn decode(self, encoding: Encoding, bytes: &[u8]) -> Result<Message, MessageError> {
        Ok(match self {
            Self::JointState => Message::JointState(read(encoding, bytes)?),
            Self::PointStamped => Message::PointStamped(read(encoding, bytes)?),
            Self::WrenchStamped => Message::WrenchStamped(read(encoding, bytes)?),
            Self::Float64MultiArray => Message::Float64MultiArray(read(encoding, bytes)?),
        })
    }
}

impl Message {
    /// When it was measured, seconds, where it says so.
    pub fn stamp_s(&self) -> Option<f64> {
        let header = match self {
            Self::JointState(message) => &message.header,
            Self::PointStamped(message) => &message.header,
            Self::WrenchStamped(message) => &message.header,
            Self::Float64MultiArray(_) => return None,
        };
        Some(f64::from(header.stamp.sec) + f64::from(header.stamp.nanosec) / 1e9)
    }
}

fn read<T: DeserializeOwned>(encoding: Encoding, bytes: &[u8]) -> Result<T, MessageError> {
    if encoding == Encoding::Json {
        return serde_json::from_slice(bytes).map_err(|error| MessageError::Content(error.to_string()));
    }
    let Some((&[0, order, _, _], body)) = bytes.split_first_chunk() else {
        return Err(MessageError::Encapsulation);
    };
    let read = match order {
        0 => cdr_encoding::from_bytes::<T, BigEndian>(body),
        1 => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        _ => return Err(MessageError::Encapsulation),
    };
    read.map(|(message, _)| message).map_err(|error| MessageError::Content(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message in CDR, written by hand: each number at a multiple of its size.
    struct Cdr {
        bytes: Vec<u8>,
        little: bool,
    }

    impl Cdr {
        fn new(little: bool) -> Self {
            Self { bytes: vec![0, u8::from(little), 0, 0], little }
        }

        fn put(mut self, big_endian: &[u8]) -> Self {
            while !(self.bytes.len() - 4).is_multiple_of(big_endian.len()) {
                self.bytes.push(0);
            }
            let from = self.bytes.len();
            self.bytes.extend(big_endian);
            if self.little {
                self.bytes[from..].reverse();
            }
            self
        }

        fn int(self, value: u32) -> Self {
            self.put(&value.to_be_bytes())
        }

        fn floats(self, values: &[f64]) -> Self {
            values.iter().fold(self, |cdr, value| cdr.put(&value.to_be_bytes()))
        }

        fn text(self, text: &str) -> Self {
            let mut cdr = self.int(text.len() as u32 + 1);
            cdr.bytes.extend(text.bytes().chain([0]));
            cdr
        }

        fn header(self) -> Self {
            self.int(7).int(500_000_000).text("palm")
        }
    }

    fn header() -> Header {
        Header { stamp: Stamp { sec: 7, nanosec: 500_000_000 }, frame_id: "palm".to_owned() }
    }

    /// Each kind of message, in CDR and as it is meant.
    fn messages(little: bool) -> [(MessageKind, Vec<u8>, Message); 4] {
        let cdr = || Cdr::new(little);
        let joints =
            cdr().header().int(2).text("left").text("r").int(2).floats(&[1.0, -0.5]).int(0).int(1).floats(&[3.0]);
        let array = cdr().int(1).text("pads").int(2).int(2).int(0).int(2).floats(&[0.03, f64::MAX]);
        let vector = |x, y, z| Vector { x, y, z };
        [
            (
                MessageKind::JointState,
                joints.bytes,
                Message::JointState(JointState {
                    header: header(),
                    name: vec!["left".to_owned(), "r".to_owned()],
                    position: vec![1.0, -0.5],
                    velocity: vec![],
                    effort: vec![3.0],
                }),
            ),
            (
                MessageKind::PointStamped,
                cdr().header().floats(&[1.0, 2.0, 3.0]).bytes,
                Message::PointStamped(PointStamped { header: header(), point: vector(1.0, 2.0, 3.0) }),
            ),
            (
                MessageKind::WrenchStamped,
                cdr().header().floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).bytes,
                Message::WrenchStamped(WrenchStamped {
                    header: header(),
                    wrench: Wrench { force: vector(1.0, 2.0, 3.0), torque: vector(4.0, 5.0, 6.0) },
                }),
            ),
            (
                MessageKind::Float64MultiArray,
                array.bytes,
                Message::Float64MultiArray(Float64MultiArray {
                    layout: Layout {
                        dim: vec![Dimension { label: "pads".to_owned(), size: 2, stride: 2 }],
                        data_offset: 0,
                    },
                    data: vec![0.03, f64::MAX],
                }),
            ),
        ]
    }

    #[test]
    fn messages_are_read_in_both_byte_orders() {
        for little in [false, true] {
            for (kind, bytes, message) in messages(little) {
                assert_eq!(kind.decode(Encoding::Cdr, &bytes), Ok(message), "{kind:?}, little endian: {little}");
            }
        }
        assert_eq!(messages(true)[0].2.stamp_s(), Some(7.5));
    }

    #[test]
    fn messages_that_end_early_are_refused_wherever_they_end() {
        for little in [false, true] {
            for (kind, bytes, _) in messages(little) {
                for end in 0..bytes.len() {
                    assert!(kind.decode(Encoding::Cdr, &bytes[..end]).is_err(), "{kind:?}, {end} of {}", bytes.len());
                }
            }
        }
    }

    #[test]
    fn lengths_that_no_message_has_are_refused_at_once() {
        let (kind, mut bytes, _) = messages(true)[3].clone();
        let count = bytes.len() - 20;
        bytes[count..count + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(kind.decode(Encoding::Cdr, &bytes).is_err());
        for start in [[1, 1, 0, 0], [0, 2, 0, 0], [0, 7, 0, 0]] {
            bytes[..4].copy_from_slice(&start);
            assert_eq!(kind.decode(Encoding::Cdr, &bytes), Err(MessageError::Encapsulation));
        }
    }

    #[test]
    fn json_has_the_names_of_the_fields_and_of_other_programs() {
        let json = r#"{"header": {"stamp": {"sec": 7, "nsec": 500000000}, "frame_id": "palm", "seq": 1}, "point": {"x": 1, "y": 2.0, "z": 3e0}}"#;
        let read = MessageKind::PointStamped.decode(Encoding::Json, json.as_bytes());
        assert_eq!(read, Ok(messages(true)[1].2.clone()));
        assert!(MessageKind::WrenchStamped.decode(Encoding::Json, json.as_bytes()).is_err());
    }

    #[test]
    fn kinds_go_by_the_names_of_their_schemas() {
        for name in ["sensor_msgs/JointState", "sensor_msgs/msg/JointState"] {
            assert_eq!(MessageKind::of_schema(name), Some(MessageKind::JointState));
        }
        assert_eq!(MessageKind::of_schema("sensor_msgs/msg/Image"), None);
    }
}
