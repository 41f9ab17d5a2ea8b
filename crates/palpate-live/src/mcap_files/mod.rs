//! MCAP files: what they are made of, and the messages in which palpate records samples.

pub(crate) mod reader;
pub(crate) mod sample_message;
pub(crate) mod strokes_message;
pub(crate) mod writing;
