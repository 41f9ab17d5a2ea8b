//! The second rig, a pivoting grasp: its logs (`time_s, pivot_x_m, pivot_y_m, s_m`), planned strokes, the file of its rig, and the folder of its result.

pub(crate) mod comments;
pub(crate) mod planned;
pub(crate) mod reader;
pub(crate) mod result;
pub(crate) mod rig;
pub(crate) mod row_reader;
pub(crate) mod writer;
