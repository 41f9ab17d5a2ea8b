//! What is estimated as a scene in an MCAP file that Foxglove and Rerun show without a plug-in: palms, contacts, boundary and pose, by the schemas of
//! Foxglove in Protobuf.

mod drawing;
mod writer;

pub use writer::SceneWriter;
