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

use crate::columns::{Values, columns};
use crate::job::Outcome;
use crate::sweep_error::SweepError;

/// Name of the table of results.
pub const RESULTS_FILE: &str = "results.parquet";
/// Name of the table of seconds.
pub const SECONDS_FILE: &str = "seconds.csv";
/// Both of them.
pub const FILES: [&str; 2] = [RESULTS_FILE, SECONDS_FILE];

/// Rows that are written together; readers take in as many at once.
const GROUP: usize = 100_000;

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
    let fields = columns(&[]).map(|(name, values)| {
        let (physical, repetition) = match values {
            Values::Counts(_) => (Physical::INT64, Repetition::REQUIRED),
            Values::MaybeCounts(_) => (Physical::INT64, Repetition::OPTIONAL),
            Values::Numbers(_) => (Physical::DOUBLE, Repetition::OPTIONAL),
            Values::Flags(_) => (Physical::BOOLEAN, Repetition::REQUIRED),
            Values::MaybeFlags(_) => (Physical::BOOLEAN, Repetition::OPTIONAL),
            Values::Texts(_) => (Physical::BYTE_ARRAY, Repetition::REQUIRED),
            Values::MaybeTexts(_) => (Physical::BYTE_ARRAY, Repetition::OPTIONAL),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
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
