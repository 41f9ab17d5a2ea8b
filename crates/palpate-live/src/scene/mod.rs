//! What is estimated as a scene in an MCAP file that Foxglove and Rerun show without a plug-in: palms or pad, contacts, boundary and pose, by the schemas of
//! Foxglove in Protobuf.

mod drawing;
mod moment;
mod writer;

pub use moment::Moment;
pub use writer::SceneWriter;
