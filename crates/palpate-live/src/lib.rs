//! Everything between a sensor and a [`Sample`](palpate::Sample): sources that are read as they run, and recordings of them.
//!
//! A [`Source`] is named by an [`Address`], as on the command line: a CSV file that grows, `-` for CSV lines on standard input, a serial port with
//! the [line protocol](protocol), Linux input devices, an MCAP file or ROS 2 bag, or a simulated rig. [`Stream`] reads one on a thread of its own, and
//! gives plausible samples in the order of time; what does not become a sample is counted by cause in [`Losses`]. Memory stays bounded, however fast a
//! source is and whatever it sends.
//!
//! ```
//! use palpate_live::protocol::Decoder;
//! use palpate_io::Conventions;
//!
//! let lines = "1000000,1047198,1308997,29700,*9B\n1010000,1047198,1308997,29700,*e5\n1020000,1047198,1308997,29710,*83\n";
//! let mut decoder = Decoder::<palpate::Sample>::new(Conventions::default());
//! let mut samples = Vec::new();
//! decoder.push(lines.as_bytes(), 0.0, &mut samples);
//! assert_eq!(samples.len(), 0); // the check of the second line fails
//! assert_eq!(decoder.losses().to_string(), "1 faulty line or message, 1 line alone among faulty ones");
//! ```
//!
//! [`Recorder`] writes samples to CSV or MCAP as they come, so that the file can be read whenever the program or the machine stops.
//!
//! All of them carry [`RigSample`]s: those of two palms ([`Sample`](palpate::Sample)), or of the other rig, a pivoting grasp
//! ([`PivotSample`](palpate::pivot::PivotSample)). [`Address::rig_kind`] says which; [`Head`] is what tells it of CSV lines.
//!
//! Nothing here estimates anything.
#![forbid(unsafe_code)]

mod error;
mod gate;
mod head;
mod join;
mod line_protocol;
mod lines;
mod log_file;
mod losses;
mod mcap_files;
mod record;
mod rigs;
mod ros;
#[cfg(feature = "scene")]
mod scene;
mod source;
mod stream;

pub use error::{RecordError, SourceError};
pub use head::Head;
pub use log_file::{mcap_rig_kind, parse_mcap_log, read_mcap_log, read_mcap_strokes};
pub use losses::Losses;
pub use record::{Recorded, Recorder, Rotation};
pub use rigs::{RigKind, RigSample};
#[cfg(feature = "scene")]
pub use scene::{Moment, SceneWriter};
pub use source::address::{Address, EvdevAngles};
pub use source::{Arrival, Overflow, Source};
pub use stream::{Batch, Stream};

/// The serial line protocol: one line per sample, with a check.
pub mod protocol {
    pub use crate::line_protocol::decoder::Decoder;
    pub use crate::line_protocol::fields::PacketError;
    pub use crate::line_protocol::palms_packet::{Packet, lines_of};
    pub use crate::line_protocol::strokes_packet::{StrokesPacket, lines_of_strokes};
}

/// Messages of ROS 2, as they stand in bags.
pub mod messages {
    pub use crate::ros::message::{
        Dimension, Encoding, Float64MultiArray, Header, JointState, Layout, Message, MessageError, MessageKind,
        PointStamped, Stamp, Vector, Wrench, WrenchStamped,
    };
}
