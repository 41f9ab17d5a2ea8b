//! CSV tables: text by line and column, columns with their units, numbers as they are written.

pub(crate) mod bytes;
pub(crate) mod columns;
pub(crate) mod metadata;
pub(crate) mod name;
pub(crate) mod number;
pub(crate) mod table;
pub(crate) mod text;
pub(crate) mod unit;
