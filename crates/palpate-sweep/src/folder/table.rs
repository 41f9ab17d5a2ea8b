//! The tables of a sweep: `results.parquet`, whose bytes depend on nothing but the jobs, and `seconds.csv` with what they took.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::job::Outcome;
use crate::job::row::Row;
use crate::sweep_error::SweepError;

/// Name of the table of results.
pub const RESULTS_FILE: &str = "results.parquet";
/// Name of the table of seconds.
pub const SECONDS_FILE: &str = "seconds.csv";
/// Both of them.
pub const FILES: [&str; 2] = [RESULTS_FILE, SECONDS_FILE];

/// Rows that are written together; readers take in as many at once.
const GROUP: usize = 100_000;

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
const COLUMNS: [Column; 42] = [
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

/// Writes both tables into the folder `dir`, each aside first and then renamed.
pub(crate) fn write(dir: &Path, outcomes: &[Outcome]) -> Result<(), SweepError> {
    palpate_io::write_whole(&dir.join(SECONDS_FILE), seconds_csv(outcomes).as_bytes())?;
    palpate_io::write_whole(&dir.join(RESULTS_FILE), &results_parquet(outcomes)?)?;
    Ok(())
}

/// The table of seconds as text.
fn seconds_csv(outcomes: &[Outcome]) -> String {
    outcomes.iter().fold("job,reconstruct_s,job_s\n".to_owned(), |mut csv, outcome| {
        let reconstruct = outcome.reconstruct_s.map(|seconds| format!("{seconds:.6}")).unwrap_or_default();
        // A string takes everything.
        let _ = writeln!(csv, "{},{reconstruct},{:.6}", outcome.row.job, outcome.job_s);
        csv
    })
}

/// The rows of outcomes as a Parquet file.
///
/// # Errors
/// None that a row could cause.
pub fn results_parquet(outcomes: &[Outcome]) -> Result<Vec<u8>, SweepError> {
    encode(outcomes).map_err(|error| SweepError::Encode(error.to_string()))
}

fn encode(outcomes: &[Outcome]) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder().set_created_by(concat!("palpate ", env!("CARGO_PKG_VERSION")).into());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema()?, Arc::new(properties.build()))?;
    for group in outcomes.chunks(GROUP) {
        let mut to = writer.next_row_group()?;
        for (_, values) in columns(group) {
            match values {
                Values::Counts(values) => required::<Int64Type>(&mut to, values.into_iter().map(|n| n as i64)),
                Values::MaybeCounts(values) => {
                    optional::<Int64Type>(&mut to, values.into_iter().map(|n| n.map(|n| n as i64)))
                }
                Values::Numbers(values) => optional::<DoubleType>(&mut to, values.into_iter()),
                Values::Flags(values) => required::<BoolType>(&mut to, values.into_iter()),
                Values::MaybeFlags(values) => optional::<BoolType>(&mut to, values.into_iter()),
                Values::Texts(values) => required::<ByteArrayType>(&mut to, values.into_iter().map(ByteArray::from)),
                Values::MaybeTexts(values) => {
                    optional::<ByteArrayType>(&mut to, values.into_iter().map(|text| text.map(ByteArray::from)))
                }
            }?;
        }
        to.close()?;
    }
    writer.into_inner()
}

fn schema() -> Result<TypePtr, ParquetError> {
    let fields = COLUMNS.iter().map(|column| {
        let (physical, repetition) = match column.of {
            Of::Count(_) => (Physical::INT64, Repetition::REQUIRED),
            Of::MaybeCount(_) => (Physical::INT64, Repetition::OPTIONAL),
            Of::Number(_) => (Physical::DOUBLE, Repetition::OPTIONAL),
            Of::Flag(_) => (Physical::BOOLEAN, Repetition::REQUIRED),
            Of::MaybeFlag(_) => (Physical::BOOLEAN, Repetition::OPTIONAL),
            Of::Text(_) => (Physical::BYTE_ARRAY, Repetition::REQUIRED),
            Of::MaybeText(_) => (Physical::BYTE_ARRAY, Repetition::OPTIONAL),
        };
        let field = Type::primitive_type_builder(column.name, physical).with_repetition(repetition);
        let field = match physical {
            Physical::BYTE_ARRAY => {
                field.with_logical_type(Some(LogicalType::String)).with_converted_type(ConvertedType::UTF8)
            }
            _ => field,
        };
        field.build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    Type::group_type_builder("sweep").with_fields(fields).build().map(Arc::new)
}

type Group<'a> = SerializedRowGroupWriter<'a, Vec<u8>>;

/// Writes the next column, without nulls.
fn required<T: DataType>(to: &mut Group, values: impl Iterator<Item = T::T>) -> Result<(), ParquetError> {
    put::<T>(to, &values.collect::<Vec<_>>(), None)
}

/// Writes the next column, with nulls: those are not among the values, but have a definition level of 0.
fn optional<T: DataType>(to: &mut Group, values: impl Iterator<Item = Option<T::T>>) -> Result<(), ParquetError> {
    let values: Vec<Option<T::T>> = values.collect();
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    put::<T>(to, &values.into_iter().flatten().collect::<Vec<_>>(), Some(&levels))
}

fn put<T: DataType>(to: &mut Group, values: &[T::T], levels: Option<&[i16]>) -> Result<(), ParquetError> {
    let Some(mut column) = to.next_column()? else {
        return Err(ParquetError::General("more columns than the schema has".into()));
    };
    column.typed::<T>().write_batch(values, levels, None)?;
    column.close()
}
