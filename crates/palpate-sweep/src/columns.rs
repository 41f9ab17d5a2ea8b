//! The columns of a table of results: what each row of a sweep has to say, by name.

use crate::job::Outcome;
use crate::job::row::Row;

/// A column: its name, and where its values come from.
struct Column {
    name: &'static str,
    of: Of,
}

/// What a column holds, and the field of the row that it holds.
enum Of {
    Count(fn(&Row) -> u64),
    MaybeCount(fn(&Row) -> Option<u64>),
    Number(fn(&Row) -> Option<f64>),
    Flag(fn(&Row) -> bool),
    MaybeFlag(fn(&Row) -> Option<bool>),
    Text(fn(&Row) -> &str),
    MaybeText(fn(&Row) -> Option<&str>),
}

/// The values of a column, row by row.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<'a> {
    /// Counts.
    Counts(Vec<u64>),
    /// Counts that may be unknown.
    MaybeCounts(Vec<Option<u64>>),
    /// Numbers that may be unknown.
    Numbers(Vec<Option<f64>>),
    /// Yes or no.
    Flags(Vec<bool>),
    /// The same, or unknown.
    MaybeFlags(Vec<Option<bool>>),
    /// Text.
    Texts(Vec<&'a str>),
    /// Text that may be missing.
    MaybeTexts(Vec<Option<&'a str>>),
}

impl Column {
    fn values<'a>(&self, outcomes: &'a [Outcome]) -> Values<'a> {
        let rows = outcomes.iter().map(|outcome| &outcome.row);
        match self.of {
            Of::Count(of) => Values::Counts(rows.map(of).collect()),
            Of::MaybeCount(of) => Values::MaybeCounts(rows.map(of).collect()),
            Of::Number(of) => Values::Numbers(rows.map(of).collect()),
            Of::Flag(of) => Values::Flags(rows.map(of).collect()),
            Of::MaybeFlag(of) => Values::MaybeFlags(rows.map(of).collect()),
            Of::Text(of) => Values::Texts(rows.map(of).collect()),
            Of::MaybeText(of) => Values::MaybeTexts(rows.map(of).collect()),
        }
    }
}

/// Declares a column under the name of its field.
macro_rules! column {
    ($kind:ident, $field:ident) => {
        Column { name: stringify!($field), of: Of::$kind(|row| row.$field) }
    };
}

/// All columns, in order; [`Row`] says what they mean.
const COLUMNS: [Column; 43] = [
    column!(Count, job),
    Column { name: "status", of: Of::Text(|row| row.status.name()) },
    column!(MaybeCount, seed),
    Column { name: "object", of: Of::Text(|row| &row.object) },
    column!(Number, mean_radius_m),
    Column { name: "motion", of: Of::MaybeText(|row| row.motion.as_deref()) },
    column!(Number, noise_sd_m),
    column!(Number, counts_per_inch),
    column!(Number, angle_noise_sd_rad),
    column!(Number, dropout),
    column!(MaybeCount, samples),
    column!(MaybeCount, jumps),
    column!(MaybeCount, jumps_found),
    column!(Number, coverage),
    column!(Flag, certified),
    column!(Flag, com_certified),
    column!(MaybeFlag, solved),
    column!(MaybeFlag, wrong),
    column!(MaybeFlag, beyond_error_bars),
    column!(Number, rms_r_m),
    column!(Number, rms_form_m),
    column!(Number, hausdorff_m),
    column!(Number, rms_psi_rad),
    column!(Number, rms_com_m),
    column!(Number, inside_band),
    column!(Number, reference_rms_r_m),
    column!(Number, reference_rms_psi_rad),
    column!(Number, reference_coverage),
    column!(Number, bound_r_m),
    column!(MaybeCount, harmonics),
    column!(MaybeCount, alternatives),
    column!(MaybeCount, symmetry_order),
    column!(MaybeFlag, symmetry_mirror),
    column!(Number, chi2_per_dof),
    column!(Number, sensor_sd_m),
    column!(Number, constants_inside_band),
    column!(Number, worst_constant_sds),
    column!(Number, com_error_sds),
    column!(Number, friction_inside_band),
    column!(Number, worst_friction_error),
    column!(Number, worst_friction_sds),
    column!(Number, gyration_error_sds),
    Column { name: "reason", of: Of::Text(|row| &row.reason) },
];

/// Names of the columns of `results.parquet`.
pub fn column_names() -> impl Iterator<Item = &'static str> {
    COLUMNS.iter().map(|column| column.name)
}

/// The columns of `results.parquet` by name.
pub fn columns(outcomes: &[Outcome]) -> impl Iterator<Item = (&'static str, Values<'_>)> {
    COLUMNS.iter().map(|column| (column.name, column.values(outcomes)))
}
