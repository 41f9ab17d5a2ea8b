//! What can be wrong with a file that is read: where, what, and what to do, in one message.

use std::io;
use std::path::Path;

use crate::csv::text;

/// A file that cannot be used: its name, the place in it, and the problem. Shown as one paragraph.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {problem}", place(file, *line, column.as_deref()))]
pub struct ReadError {
    /// File name as given, control characters escaped.
    pub file: String,
    /// Line in the file, from 1, where the problem has one.
    pub line: Option<usize>,
    /// Name of the column as the header has it, control characters escaped and cut after 40, where the problem has one.
    pub column: Option<String>,
    /// What is wrong, and what to do.
    pub problem: Box<ReadProblem>,
}

/// What is wrong with a file. Text taken from the file has its control characters escaped and is cut after 40 characters, as shown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadProblem {
    /// No file of that name.
    #[error("no such file; check the path")]
    Missing,
    /// No folder of that name.
    #[error("no such folder; check the path")]
    MissingFolder,
    /// A comment `# rig: …` that says nothing that can be understood.
    #[error(
        "the comment \"# rig:\" above the header does not say what rig wrote the log ({problem}); remove it, or give --rig or --calibrated"
    )]
    RigComment {
        /// What is wrong with it.
        problem: String,
    },
    /// A folder where a file is expected.
    #[error("this is a folder; give the CSV file in it")]
    IsFolder,
    /// A file where a folder is expected.
    #[error("this is a file; give the folder that holds shape.csv and motion.csv")]
    IsFile,
    /// The operating system refused.
    #[error("cannot be read: {message}")]
    Io {
        /// Kind of the failure.
        kind: io::ErrorKind,
        /// What the operating system said.
        message: String,
    },
    /// More than a log can reasonably be.
    #[error("the file is larger than {limit_mib} MiB; split it, or log at a lower rate")]
    TooLarge {
        /// Largest file that is read, in MiB.
        limit_mib: u64,
    },
    /// A compressed file that unpacks to more than a log can reasonably be.
    #[error("the compressed file holds more than {limit_mib} MiB; split the log, or log at a lower rate")]
    UnpacksTooLarge {
        /// Most that is unpacked, in MiB.
        limit_mib: u64,
    },
    /// A compressed file that cannot be unpacked to its end.
    #[error("the gzip file is damaged or cut off; copy it again, or unpack what is left of it with gunzip")]
    DamagedGzip,
    /// No bytes, or only blank lines.
    #[error("the file is empty; it needs a header line with the column names and a line for each sample")]
    Empty,
    /// Comments, but no header.
    #[error("the file holds only comments; it needs a header line with the column names and a line for each sample")]
    OnlyComments,
    /// A header, but nothing below it.
    #[error("there is only a header and no line below it; was the recording stopped before it began?")]
    OnlyHeader,
    /// The first line that is no comment holds numbers only.
    #[error(
        "there are numbers where the header should be; put a line with the column names above them, such as {example}"
    )]
    NoHeader {
        /// A header that would do.
        example: &'static str,
    },
    /// Bytes that no text has.
    #[error("this is a binary file, not text; export it as CSV")]
    Binary,
    /// UTF-16 text.
    #[error("the text is encoded in UTF-16; save it as CSV in UTF-8")]
    Utf16,
    /// Text in another encoding than UTF-8.
    #[error("the text is not UTF-8; save the file as CSV in UTF-8")]
    NotUtf8,
    /// Columns separated by blanks.
    #[error("the column names are separated by blanks; separate names and numbers by commas, semicolons or tabs")]
    Blanks,
    /// A quote that is opened and not closed, or closed too early.
    #[error("a double quote is not closed; remove the quotes, numbers need none")]
    Quote,
    /// Required columns are absent.
    #[error("{} (the header has: {found})", missing_told(missing))]
    MissingColumns {
        /// What is absent, in the order of the documentation.
        missing: Vec<MissingColumn>,
        /// The names that are there.
        found: String,
    },
    /// A log of another rig: its columns are those of strokes over one pad.
    #[error(
        "this is a log of strokes over one pad and not of two palms; `palpate reconstruct` takes it as it is, in Python it is for \
         palpate.reconstruct_strokes, in Rust for palpate_io::read_strokes"
    )]
    Strokes,
    /// A known quantity without a unit.
    #[error("the name has no unit; name the column {names}")]
    NoUnit {
        /// The names that would do.
        names: String,
    },
    /// A known quantity in a unit that is not understood.
    #[error("the unit \"{unit}\" is unknown; convert the column and name it {names}")]
    UnknownUnit {
        /// The unit in the name.
        unit: String,
        /// The names that would do.
        names: String,
    },
    /// A quantity twice.
    #[error("the header has {quantity} twice, as {first} and {second}; remove one of the columns")]
    TwoColumns {
        /// Name of the quantity, without a unit.
        quantity: &'static str,
        /// First column of it.
        first: String,
        /// Second column of it.
        second: String,
    },
    /// The last row ends early.
    #[error("the last row has {cells} of {columns} cells, the file looks cut off; copy it again, or delete that row")]
    CutOff {
        /// Cells in the row.
        cells: usize,
        /// Columns of the header.
        columns: usize,
    },
    /// A row in the middle that ends early.
    #[error("the row has {cells} cells, the header has {columns}; complete the row or delete it")]
    RowTooShort {
        /// Cells in the row.
        cells: usize,
        /// Columns of the header.
        columns: usize,
    },
    /// A row with more cells than the header.
    #[error(
        "the row has {cells} cells, the header has {columns}; name every column in the header, and write numbers with a decimal point, not a decimal comma"
    )]
    RowTooLong {
        /// Cells in the row.
        cells: usize,
        /// Columns of the header.
        columns: usize,
    },
    /// A column in memory that is shorter or longer than the first.
    #[error("the column has {cells} values, the first one has {rows}; give one value for each sample")]
    UnequalColumns {
        /// Values in the column.
        cells: usize,
        /// Values in the first column.
        rows: usize,
    },
    /// Text where a number belongs.
    #[error("\"{text}\" is not a number; write one such as 12.5{}", empty_means(empty))]
    NotANumber {
        /// The text.
        text: String,
        /// What an empty cell would mean here; empty where there must be a number.
        empty: &'static str,
    },
    /// A date or a time of day where a number belongs.
    #[error(
        "\"{text}\" is a date or a time of day; write the seconds since the start, such as 12.5, under the name time_s"
    )]
    Date {
        /// The text.
        text: String,
    },
    /// A comma in a number of a file whose columns are separated by commas, or marks between thousands.
    #[error(
        "\"{text}\" has a comma in a number; write it with a decimal point and without marks between thousands, or separate the columns by semicolons"
    )]
    DecimalComma {
        /// The text.
        text: String,
    },
    /// Decimal commas and decimal points in one file.
    #[error(
        "\"{text}\" has a decimal {mark}, unlike {other} in line {other_line}; write all numbers with a decimal point and without marks between thousands"
    )]
    MixedDecimalMarks {
        /// The text.
        text: String,
        /// Its decimal mark, `comma` or `point`.
        mark: &'static str,
        /// A number with the other one.
        other: String,
        /// Its line.
        other_line: usize,
    },
    /// A line `sep=` with a mark that is not understood.
    #[error("the columns are said to be separated by \"{mark}\"; separate them by commas, semicolons or tabs")]
    UnknownSeparator {
        /// The mark.
        mark: String,
    },
    /// More columns than any log has.
    #[error("the line has {cells} cells, more than {limit}; is it a log?")]
    TooManyColumns {
        /// Cells in the line.
        cells: usize,
        /// Most cells that are read.
        limit: usize,
    },
    /// An empty cell, or NaN, where there must be a number.
    #[error("{} where a number must be; fill it in, or delete the row", if text.is_empty() { "the cell is empty".to_string() } else { format!("{text} stands") })]
    NoNumber {
        /// The text, empty for an empty cell.
        text: String,
    },
    /// Text that is no contact mode.
    #[error("{text} is no contact mode; it is stick, slide+ or slide-, or empty where nothing is known")]
    NoContactMode {
        /// The text.
        text: String,
    },
    /// An infinite number, or one beyond the range of a double.
    #[error("\"{text}\" is infinite; delete the row{}", empty_means(empty))]
    Infinite {
        /// The text.
        text: String,
        /// What an empty cell would mean here; empty where there must be a number.
        empty: &'static str,
    },
    /// A value that should increase from row to row decreases.
    #[error(
        "{text} comes after {previous} (line {previous_line}), {what} decreases; sort the rows, or split the file where it starts again"
    )]
    Backwards {
        /// What should increase.
        what: &'static str,
        /// The value.
        text: String,
        /// The value before.
        previous: String,
        /// Line of the value before.
        previous_line: usize,
    },
    /// A value that should increase from row to row stands still.
    #[error(
        "{text} occurs twice, first in line {previous_line}; delete one of the two rows, or write {what} with more digits"
    )]
    Repeated {
        /// What should increase.
        what: &'static str,
        /// The value.
        text: String,
        /// Line of the value before.
        previous_line: usize,
    },
    /// An angle in radians that must be meant in degrees.
    #[error("{text} rad looks like degrees; if it is, name the column {degrees}")]
    LooksLikeDegrees {
        /// The value.
        text: String,
        /// The name for degrees.
        degrees: String,
    },
    /// Palms too parallel to hold an object between them.
    #[error(
        "{text} {unit} makes the palms parallel; the angle from palm 1 to palm 2 must lie between 0 and pi (180 deg), and not within 0.001 rad of either"
    )]
    ParallelPalms {
        /// The value.
        text: String,
        /// Its unit.
        unit: &'static str,
    },
    /// The angle between the palms has the wrong sign.
    #[error(
        "{text} {unit} is negative; this is the angle from palm 1 to palm 2, counter-clockwise, between 0 and pi (180 deg): {remedy}"
    )]
    NegativePalmAngle {
        /// The value.
        text: String,
        /// Its unit.
        unit: &'static str,
        /// What to do: by the palms of the whole log, where these tell.
        remedy: String,
    },
    /// The angle between the palms is more than half a turn, or palm 1 is more than two turns away.
    #[error("{text} {unit} is out of range; {range}")]
    AngleOutOfRange {
        /// The value.
        text: String,
        /// Its unit.
        unit: &'static str,
        /// The range, in words.
        range: &'static str,
    },
    /// A length that is negative where it cannot be.
    #[error("{text} {unit} is negative; {meaning}")]
    NegativeLength {
        /// The value.
        text: String,
        /// Its unit.
        unit: &'static str,
        /// What the length is.
        meaning: &'static str,
    },
    /// A normal force that pulls.
    #[error(
        "{text} is negative; a palm only pushes: reverse the sign of the column, or leave the cell empty where the sensor drifts"
    )]
    NegativeForce {
        /// The value.
        text: String,
    },
    /// A standard deviation that is zero or negative.
    #[error("{text} {unit} is not a standard deviation, which must be above 0; omit the column if it is unknown")]
    NotAStandardDeviation {
        /// The value.
        text: String,
        /// Its unit.
        unit: &'static str,
    },
    /// A length beyond anything two palms can hold.
    #[error("{text} {unit} is more than {limit_m} m; correct it{}", or_name(others))]
    TooLong {
        /// The value.
        text: String,
        /// Its unit.
        unit: &'static str,
        /// Longest length accepted, metres.
        limit_m: f64,
        /// The names for smaller units; empty where there are none.
        others: String,
    },
    /// Contacts that are all closer to the base than a pad can tell.
    #[error(
        "no contact is more than {farthest} {unit} from the base of its palm, and palms shorter than {limit_mm} mm feel nothing; correct the column{}",
        or_name(others)
    )]
    TooShort {
        /// Distance of the farthest contact, in the unit of the column.
        farthest: String,
        /// Its unit.
        unit: &'static str,
        /// What it must be at least, millimetres.
        limit_mm: f64,
        /// The names for larger units; empty where there are none.
        others: String,
    },
    /// Palms that are all but closed at all times.
    #[error(
        "the palms never open wider than {widest} {unit}, too little for an object between them; correct the column{}",
        or_name(radians)
    )]
    TooNarrow {
        /// The widest angle, in the unit of the column.
        widest: String,
        /// Its unit.
        unit: &'static str,
        /// The name for radians where the column is in degrees; else empty.
        radians: String,
    },
    /// Base points too far apart to hold one object.
    #[error(
        "the base points of the palms are {apart_m:.1} m apart, more than {limit_m} m; correct them{}",
        or_name(others)
    )]
    BasesApart {
        /// Distance between them, metres.
        apart_m: f64,
        /// Largest distance accepted, metres.
        limit_m: f64,
        /// The names for smaller units; empty where there are none.
        others: String,
    },
    /// A log that lasts longer than anyone carries an object.
    #[error(
        "the log lasts {duration} {unit}, more than {limit_s} s; correct the times, or split the log{}",
        or_name(others)
    )]
    TooLasting {
        /// Time from first to last sample, in the unit of the column.
        duration: String,
        /// Its unit.
        unit: &'static str,
        /// Longest duration accepted, seconds.
        limit_s: f64,
        /// The names for smaller units; empty where there are none.
        others: String,
    },
    /// More samples per second than any sensor takes.
    #[error(
        "the samples follow each other every {step} {unit}, more than {limit_hz} per second; correct the times{}",
        or_name(others)
    )]
    TooFast {
        /// Mean time between samples, in the unit of the column.
        step: String,
        /// Its unit.
        unit: &'static str,
        /// Highest rate accepted, hertz.
        limit_hz: f64,
        /// The names for larger units; empty where there are none.
        others: String,
    },
    /// An outline in a size that no object between palms has.
    #[error(
        "the outline is {across_m} m across, and must be from {least_m} m to {most_m} m; correct its unit{}",
        or_name(others)
    )]
    OutlineSize {
        /// Its size, metres.
        across_m: f64,
        /// Smallest size accepted, metres.
        least_m: f64,
        /// Largest size accepted, metres.
        most_m: f64,
        /// The names for units that may be meant; empty where there are none.
        others: String,
    },
    /// Fewer points than have an area between them.
    #[error("there are {points} points, and an outline needs at least {needed}, in order round the object")]
    TooFewPoints {
        /// Points there.
        points: usize,
        /// Points needed.
        needed: usize,
    },
    /// More points than a fit can tell apart.
    #[error("the outline has {points} points, more than {limit}; leave some out")]
    TooManyPoints {
        /// Points there, or those that were counted.
        points: usize,
        /// Most points that are read.
        limit: usize,
    },
    /// No drawing that can be read.
    #[error("not an SVG drawing that can be read ({message}); export the outline as one path in plain SVG")]
    Svg {
        /// What is wrong with it.
        message: String,
    },
    /// A drawing without an outline.
    #[error("the drawing has no path, polygon, rect, circle or ellipse with an area; convert text and copies to paths")]
    NoOutline,
    /// Not enough to solve for a shape.
    #[error(
        "{both} of its {samples} samples have a contact on both palms, and at least {needed} are needed to solve for a shape; record longer, or check the touch threshold"
    )]
    TooFewSamples {
        /// Samples with both contacts.
        both: usize,
        /// Samples in all.
        samples: usize,
        /// Fewest that can be solved.
        needed: usize,
    },
    /// The period of swinging above a log of strokes is no period.
    #[error("swing_period_s is {text}; write the period of small swings of the lifted object in seconds, such as 0.41")]
    SwingPeriod {
        /// What it says.
        text: String,
    },
    /// The orientation at the start above a motion of palms is none.
    #[error(
        "start_psi_rad is {text}; write the orientation at which the object is let go in radians, such as 1.2, or delete the line"
    )]
    StartPsi {
        /// What it says.
        text: String,
    },
    /// The number of a stroke that does not follow from the row before.
    #[error(
        "{text} is no number of a stroke here; number the strokes 1, 2, 3 and so on, the rows of each together and in order"
    )]
    StrokeNumber {
        /// The text.
        text: String,
    },
    /// A force of the arm that is not that of the stroke, or none.
    #[error(
        "{text} is no force for this stroke; write one number from 0 on, in weights of the object, in all rows of a stroke"
    )]
    Press {
        /// The text.
        text: String,
    },
    /// A file of the rig of a pivoting grasp cannot be understood.
    #[error(
        "{message}; a rig of a pivoting grasp has the tables pad, calibration and tolerances, and reading_sd_m and arm_sd_m"
    )]
    PivotRig {
        /// What the reader says.
        message: String,
    },
    /// Too few rows in a table of a truth or result folder.
    #[error("there are {rows} rows, and at least {needed} are needed; write it again")]
    TooFewRows {
        /// Rows there.
        rows: usize,
        /// Rows needed.
        needed: usize,
    },
    /// JSON that is not what it should be.
    #[error("not the summary of a palpate result: {message}; reconstruct again")]
    Json {
        /// What the parser said.
        message: String,
    },
}

/// A column that should be there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingColumn {
    /// Name of the quantity, without a unit.
    pub quantity: &'static str,
    /// The names that would do.
    pub names: String,
    /// The column that may be meant to be it.
    pub meant: Option<String>,
}

impl ReadError {
    /// A problem with the file as a whole.
    pub(crate) fn in_file(name: &str, problem: ReadProblem) -> Self {
        Self { file: text::file_name(name), line: None, column: None, problem: Box::new(problem) }
    }

    /// A problem in one line.
    pub(crate) fn in_line(name: &str, line: usize, problem: ReadProblem) -> Self {
        Self { line: Some(line), ..Self::in_file(name, problem) }
    }

    /// A problem in one column of one line.
    pub(crate) fn in_column(name: &str, line: usize, column: &str, problem: ReadProblem) -> Self {
        Self { column: Some(text::quoted(column)), ..Self::in_line(name, line, problem) }
    }

    /// What the operating system said about opening or reading `path`.
    pub(crate) fn io(path: &Path, error: &io::Error) -> Self {
        let problem = match error.kind() {
            io::ErrorKind::NotFound => ReadProblem::Missing,
            io::ErrorKind::IsADirectory => ReadProblem::IsFolder,
            kind => ReadProblem::Io { kind, message: io_message(error) },
        };
        Self::in_file(&path.to_string_lossy(), problem)
    }
}

/// What the operating system said, and what to do about it where that is plain.
pub(crate) fn io_message(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::PermissionDenied => {
            "permission denied; change the permissions, or choose another place".to_string()
        }
        io::ErrorKind::StorageFull => "the disk is full; make room, or choose another place".to_string(),
        io::ErrorKind::ReadOnlyFilesystem => "the disk is read-only; choose another place".to_string(),
        io::ErrorKind::ResourceBusy => {
            "it is in use or a mount point; choose another place, or a folder inside it".to_string()
        }
        _ => error.to_string(),
    }
}

fn place(file: &str, line: Option<usize>, column: Option<&str>) -> String {
    let mut place = file.to_string();
    if let Some(line) = line {
        place += &format!(", line {line}");
    }
    if let Some(column) = column {
        place += &format!(", column {}", if column.is_empty() { "(no name)" } else { column });
    }
    place
}

fn empty_means(empty: &str) -> String {
    if empty.is_empty() { String::new() } else { format!(", or leave the cell empty where {empty}") }
}

fn missing_told(missing: &[MissingColumn]) -> String {
    let named = |column: &MissingColumn| match &column.meant {
        Some(meant) => format!("{} (did you mean {meant}?)", column.names),
        None => column.names.clone(),
    };
    let names: Vec<String> = missing.iter().map(named).collect();
    let quantities: Vec<&str> = missing.iter().map(|column| column.quantity).collect();
    match quantities[..] {
        [quantity] => format!("there is no column for {quantity}; it must be named {}", names.concat()),
        [ref others @ .., last] => {
            format!(
                "there are no columns for {} and {last}; they must be named {}",
                others.join(", "),
                names.join(", and ")
            )
        }
        [] => String::new(),
    }
}

fn or_name(names: &str) -> String {
    if names.is_empty() { String::new() } else { format!(", or name the column {names} if that is its unit") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_says_comes_with_what_to_do() {
        let message = |kind: io::ErrorKind| ReadError::io(Path::new("a.csv"), &kind.into()).to_string();
        let place = "or choose another place";
        let expected = format!("a.csv: cannot be read: permission denied; change the permissions, {place}");
        assert_eq!(message(io::ErrorKind::PermissionDenied), expected);
        let message = |kind: io::ErrorKind| crate::WriteError::io(Path::new("out"), &kind.into()).to_string();
        assert_eq!(
            message(io::ErrorKind::StorageFull),
            format!("out: cannot be written: the disk is full; make room, {place}")
        );
        assert_eq!(message(io::ErrorKind::BrokenPipe), "out: cannot be written: broken pipe");
    }
}
