//! A CSV file as a table: header, columns found by name and unit, cells with their place in the file. Shared by palm logs, truth
//! folders and result folders.

use std::borrow::Cow;

use crate::csv::name::{self, plain};
use crate::csv::text;
use crate::csv::unit::{Dimension, Unit};
use crate::read_error::{MissingColumn, ReadError, ReadProblem};

/// Most cells in a line: far more than any log has columns, few enough that a line is never large in memory.
const MAX_COLUMNS: usize = 4096;

/// Most bytes of a file that its header is looked for in.
const HEADER_WITHIN: usize = 64 << 10;

/// Whether the first line of a file that is no comment names this quantity: what kind of file it is, before it is read.
pub(crate) fn header_has(bytes: &[u8], quantity: Quantity) -> bool {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(HEADER_WITHIN)]);
    let header = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    header.is_some_and(|header| header.to_lowercase().contains(quantity.stem))
}

/// Something a column may hold; the column is named `stem_unit`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quantity {
    /// Name without the unit, lower case.
    pub(crate) stem: &'static str,
    /// Other names of it, for files that do not have the first.
    also: &'static [&'static str],
    pub(crate) dimension: Option<Dimension>,
    /// What an empty cell says, in words that follow "where"; empty where there must be a number.
    pub(crate) empty: &'static str,
}

impl Quantity {
    /// A quantity with a number in every row.
    pub(crate) const fn new(stem: &'static str, dimension: Dimension) -> Self {
        Self { stem, also: &[], dimension: Some(dimension), empty: "" }
    }

    /// A quantity whose cells may be empty where `empty`.
    pub(crate) const fn or_empty(stem: &'static str, dimension: Dimension, empty: &'static str) -> Self {
        Self { stem, also: &[], dimension: Some(dimension), empty }
    }

    /// A plain number, its column named `stem` alone.
    pub(crate) const fn count(stem: &'static str) -> Self {
        Self { stem, also: &[], dimension: None, empty: "" }
    }

    /// The same quantity under other names as well.
    pub(crate) const fn also_named(self, also: &'static [&'static str]) -> Self {
        Self { also, ..self }
    }

    /// The unit that the end of a column name stands for.
    fn unit(&self, suffix: &str) -> Option<Unit> {
        self.dimension?.units().iter().copied().find(|unit| unit.suffix() == suffix)
    }

    /// The column names that are understood, under this stem.
    fn names(&self, stem: &str) -> String {
        let units = self.dimension.map_or(&[][..], Dimension::units);
        if units.is_empty() { stem.to_string() } else { names_in(stem, units.iter().copied()) }
    }

    /// All its stems, the first one first.
    fn stems(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.stem).chain(self.also.iter().copied())
    }

    /// The stem that `name`, made plain, begins with, if it is one of this quantity.
    pub(crate) fn stem_in(&self, name: &str) -> Option<&'static str> {
        self.stems().filter(|stem| rest(name, stem).is_some()).max_by_key(|stem| stem.len())
    }
}

/// What follows the stem in `name`, made plain: nothing, or `_` and more.
fn rest<'n>(name: &'n str, stem: &str) -> Option<&'n str> {
    name.strip_prefix(stem).filter(|rest| rest.is_empty() || rest.starts_with('_'))
}

/// The names with one stem in several units; empty without a unit.
fn names_in(stem: &str, units: impl IntoIterator<Item = Unit>) -> String {
    let mut names: Vec<String> = units.into_iter().map(|unit| format!("{stem}_{}", unit.suffix())).collect();
    let Some(last) = names.pop() else { return String::new() };
    if names.is_empty() { last } else { format!("{} or {last}", names.join(", ")) }
}

/// A column that was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    pub(crate) quantity: Quantity,
    pub(crate) unit: Option<Unit>,
    index: usize,
}

/// A parsed file. Every row has as many cells as the header.
#[derive(Clone, Debug)]
pub(crate) struct Table<'a> {
    file: &'a str,
    header_line: usize,
    names: Vec<String>,
    /// Columns are not separated by commas, so that a comma in a number is a decimal mark.
    decimal_commas: bool,
    /// Row after row.
    cells: Vec<Cow<'a, str>>,
    /// Line of each row, from 1.
    lines: Vec<usize>,
    /// `# key: value` lines in the order of the file.
    pub(crate) metadata: Vec<(String, String)>,
    /// The last line of the file has no line break.
    pub(crate) unended: bool,
}

impl<'a> Table<'a> {
    /// Takes a file apart. `example` is a header to suggest when there is none.
    pub(crate) fn parse(file: &'a str, bytes: &'a [u8], example: &'static str) -> Result<Self, ReadError> {
        let text = decode(file, bytes)?;
        let line_break = if text.contains('\n') { '\n' } else { '\r' };
        let mut table = Self {
            file,
            header_line: 0,
            names: Vec::new(),
            decimal_commas: false,
            cells: Vec::new(),
            lines: Vec::new(),
            metadata: Vec::new(),
            unended: !text.ends_with(line_break),
        };
        let mut delimiter = ',';
        // What a line `sep=;` above the header says.
        let mut said = None;
        let mut comments = false;
        // A row that ends early; it is the last one unless another follows.
        let mut short_row: Option<(usize, usize)> = None;
        let too_short =
            |line, cells, columns| ReadError::in_line(file, line, ReadProblem::RowTooShort { cells, columns });
        for (index, content) in text.split(line_break).enumerate() {
            let line = index + 1;
            let content = content.trim_end_matches('\r');
            let trimmed = content.trim();
            if let Some(comment) = trimmed.strip_prefix('#') {
                comments = true;
                table.metadata.extend(metadata(comment));
                continue;
            }
            if trimmed.is_empty() {
                continue;
            }
            if table.names.is_empty() {
                if let Some(mark) = separator_said(content) {
                    if !SEPARATORS.contains(&mark) {
                        let mark = text::quoted(&mark.to_string());
                        return Err(ReadError::in_line(file, line, ReadProblem::UnknownSeparator { mark }));
                    }
                    said = Some(mark);
                    continue;
                }
                delimiter = said.unwrap_or_else(|| separator_of(trimmed));
                table.decimal_commas = delimiter != ',';
            }
            let marks = content.matches(delimiter).count();
            if marks >= MAX_COLUMNS {
                let problem = ReadProblem::TooManyColumns { cells: marks + 1, limit: MAX_COLUMNS };
                return Err(ReadError::in_line(file, line, problem));
            }
            let before = table.cells.len();
            if !split_cells(content, delimiter, &mut table.cells) {
                return Err(ReadError::in_line(file, line, ReadProblem::Quote));
            }
            let row = &table.cells[before..];
            let cells = row.len();
            if row.iter().all(|cell| cell.is_empty()) {
                // Spreadsheets leave rows of nothing but separators behind.
                table.cells.truncate(before);
                continue;
            }
            if table.names.is_empty() {
                if row.iter().all(|cell| cell.is_empty() || parse_number(cell, table.decimal_commas).is_some()) {
                    return Err(ReadError::in_line(file, line, ReadProblem::NoHeader { example }));
                }
                if cells == 1 && row[0].contains(char::is_whitespace) {
                    return Err(ReadError::in_line(file, line, ReadProblem::Blanks));
                }
                table.names = table.cells.drain(..).map(Cow::into_owned).collect();
                table.header_line = line;
                continue;
            }
            let columns = table.names.len();
            if table.lines.is_empty() && cells <= columns && row.iter().all(|cell| cell.is_empty() || is_unit(cell)) {
                for (name, unit) in table.names.iter_mut().zip(table.cells.drain(before..)) {
                    if !unit.is_empty() && !plain(name).ends_with(&format!("_{}", plain(&unit))) {
                        *name = format!("{name} ({unit})");
                    }
                }
                continue;
            }
            if let Some((line, cells)) = short_row {
                return Err(too_short(line, cells, columns));
            }
            if cells > columns {
                return Err(ReadError::in_line(file, line, ReadProblem::RowTooLong { cells, columns }));
            }
            if cells < columns {
                short_row = Some((line, cells));
                table.cells.truncate(before);
                continue;
            }
            table.lines.push(line);
        }
        if table.names.is_empty() {
            let problem = if comments { ReadProblem::OnlyComments } else { ReadProblem::Empty };
            return Err(ReadError::in_file(file, problem));
        }
        if let Some((line, cells)) = short_row {
            let problem = ReadProblem::CutOff { cells, columns: table.names.len() };
            return Err(ReadError::in_line(file, line, problem));
        }
        Ok(table)
    }

    /// A table of columns in memory, whose lines are its rows, counted from 0.
    pub(crate) fn from_columns(file: &'a str, columns: &'a [(String, Vec<String>)]) -> Result<Self, ReadError> {
        let rows = columns.first().map_or(0, |(_, cells)| cells.len());
        if let Some((name, cells)) = columns.iter().find(|(_, cells)| cells.len() != rows) {
            let problem = ReadProblem::UnequalColumns { cells: cells.len(), rows };
            return Err(ReadError { line: None, ..ReadError::in_column(file, 0, name, problem) });
        }
        let row = |row: usize| columns.iter().map(move |(_, cells)| Cow::Borrowed(cells[row].trim()));
        Ok(Self {
            file,
            header_line: 0,
            names: columns.iter().map(|(name, _)| name.trim().to_owned()).collect(),
            decimal_commas: false,
            cells: (0..rows).flat_map(row).collect(),
            lines: (0..rows).collect(),
            metadata: Vec::new(),
            unended: false,
        })
    }

    /// Refuses a table without rows.
    pub(crate) fn require_rows(&self) -> Result<(), ReadError> {
        if self.lines.is_empty() {
            return Err(ReadError::in_line(self.file, self.header_line, ReadProblem::OnlyHeader));
        }
        Ok(())
    }

    /// Number of rows below the header.
    pub(crate) fn rows(&self) -> usize {
        self.lines.len()
    }

    /// Line of a row in the file, from 1.
    pub(crate) fn line(&self, row: usize) -> usize {
        self.lines[row]
    }

    /// The column of `quantity`, in whatever unit; `all` are the quantities that this kind of file may have. One under another of its
    /// names counts where there is none of the first.
    ///
    /// # Errors
    /// There are two, or its unit is missing or unknown. A name with an unknown unit beside a good one is an extra column.
    pub(crate) fn find(&self, quantity: Quantity, all: &[Quantity]) -> Result<Option<Column>, ReadError> {
        let mut first_problem = None;
        for stem in quantity.stems() {
            match self.find_named(quantity, stem, all) {
                Ok(None) => {}
                Err(error) if !matches!(*error.problem, ReadProblem::TwoColumns { .. }) => {
                    first_problem = first_problem.or(Some(error));
                }
                found => return found,
            }
        }
        first_problem.map_or(Ok(None), Err)
    }

    /// The same under one of its names.
    fn find_named(
        &self,
        quantity: Quantity,
        stem: &'static str,
        all: &[Quantity],
    ) -> Result<Option<Column>, ReadError> {
        let mut found: Option<Column> = None;
        let mut doubtful: Option<(&str, ReadProblem)> = None;
        for (index, name) in self.names.iter().enumerate() {
            let plain = plain(name);
            if stem_of(&plain, all) != Some((quantity, stem)) {
                continue;
            }
            let suffix = rest(&plain, stem).unwrap_or_default().trim_start_matches('_');
            let unit = quantity.unit(suffix);
            if unit.is_some() || (quantity.dimension.is_none() && suffix.is_empty()) {
                if let Some(first) = found {
                    let problem = ReadProblem::TwoColumns {
                        quantity: quantity.stem,
                        first: text::quoted(&self.names[first.index]),
                        second: text::quoted(name),
                    };
                    return Err(ReadError::in_line(self.file, self.header_line, problem));
                }
                found = Some(Column { quantity, unit, index });
            } else if doubtful.is_none() && quantity.dimension.is_some() {
                let names = quantity.names(stem);
                let first =
                    self.cells.get(index).filter(|cell| quantity.dimension == Some(Dimension::Time) && is_date(cell));
                let problem = if let Some(date) = first {
                    ReadProblem::Date { text: text::quoted(date) }
                } else if suffix.is_empty() {
                    ReadProblem::NoUnit { names }
                } else {
                    ReadProblem::UnknownUnit { unit: text::quoted(suffix), names }
                };
                doubtful = Some((name, problem));
            }
        }
        match (found, doubtful) {
            (None, Some((name, problem))) => Err(ReadError::in_column(self.file, self.header_line, name, problem)),
            (found, _) => Ok(found),
        }
    }

    /// The column of `quantity`, which must be there.
    pub(crate) fn require(&self, quantity: Quantity, all: &[Quantity]) -> Result<Column, ReadError> {
        let [column] = self.require_all([quantity], all)?;
        Ok(column)
    }

    /// The columns of several quantities, which must all be there.
    pub(crate) fn require_all<const N: usize>(
        &self,
        quantities: [Quantity; N],
        all: &[Quantity],
    ) -> Result<[Column; N], ReadError> {
        let mut found = [None; N];
        // Names of a quantity without a unit that is understood.
        let mut doubtful: Vec<(Quantity, ReadError)> = Vec::new();
        for (column, quantity) in found.iter_mut().zip(quantities) {
            match self.find(quantity, all) {
                Err(error)
                    if matches!(*error.problem, ReadProblem::NoUnit { .. } | ReadProblem::UnknownUnit { .. }) =>
                {
                    doubtful.push((quantity, error));
                }
                found => *column = found?,
            }
        }
        let missing: Vec<Quantity> = quantities
            .into_iter()
            .zip(&found)
            .filter(|(_, column)| column.is_none())
            .map(|(quantity, _)| quantity)
            .collect();
        if let Some(columns) = all_of(found) {
            return Ok(columns);
        }
        if let ([_], [(_, error)]) = (missing.as_slice(), doubtful.as_slice()) {
            return Err(error.clone());
        }
        // What is a known column, or may be one of those, cannot be meant to be another.
        let free = || self.names.iter().filter(|name| stem_of(&plain(name), all).is_none());
        let of = |quantity: &Quantity| MissingColumn {
            quantity: quantity.stem,
            names: quantity.names(quantity.stem),
            meant: doubtful.iter().find(|(of, _)| of == quantity).map_or_else(
                || name::meant(quantity.stem, quantity.dimension, free().map(String::as_str)).map(text::quoted),
                |(_, error)| error.column.clone(),
            ),
        };
        let problem = ReadProblem::MissingColumns {
            missing: missing.iter().map(of).collect(),
            found: text::list(self.names.iter().map(String::as_str)),
        };
        Err(ReadError::in_line(self.file, self.header_line, problem))
    }

    /// A length, unless it is beyond this limit, either way.
    pub(crate) fn within(&self, row: usize, column: Column, length_m: f64, limit_m: f64) -> Result<f64, ReadError> {
        if length_m.abs() <= limit_m {
            return Ok(length_m);
        }
        let problem = ReadProblem::TooLong {
            text: self.shown(row, column),
            unit: column.unit.map_or("", Unit::suffix),
            limit_m,
            others: self.names_of_smaller_units(column),
        };
        Err(self.error(row, column, problem))
    }

    /// Refuses decimal commas beside decimal points, of which one must be a mark between thousands.
    pub(crate) fn require_one_decimal_mark(&self, columns: &[Column]) -> Result<(), ReadError> {
        if !self.decimal_commas {
            return Ok(());
        }
        let mut first: Option<(usize, Column, char)> = None;
        for row in 0..self.rows() {
            for &column in columns {
                let Some(mark) = self.cell(row, column).chars().find(|mark| ",.".contains(*mark)) else { continue };
                let Some((other_row, other, of_first)) = first else {
                    first = Some((row, column, mark));
                    continue;
                };
                if mark != of_first {
                    let problem = ReadProblem::MixedDecimalMarks {
                        text: self.shown(row, column),
                        mark: if mark == ',' { "comma" } else { "point" },
                        other: self.shown(other_row, other),
                        other_line: self.line(other_row),
                    };
                    return Err(self.error(row, column, problem));
                }
            }
        }
        Ok(())
    }

    /// The name of a column if it were in this unit.
    pub(crate) fn name_in(&self, column: Column, unit: Unit) -> String {
        names_in(self.stem(column), [unit])
    }

    /// The names of a column in units that are larger than its own; empty where there are none.
    pub(crate) fn names_of_larger_units(&self, column: Column) -> String {
        self.names_of_units(column, |unit, own| unit.to_si(1.0) > own.to_si(1.0))
    }

    /// The same for smaller units.
    pub(crate) fn names_of_smaller_units(&self, column: Column) -> String {
        self.names_of_units(column, |unit, own| unit.to_si(1.0) < own.to_si(1.0))
    }

    fn names_of_units(&self, column: Column, wanted: impl Fn(Unit, Unit) -> bool) -> String {
        let Some((dimension, own)) = column.quantity.dimension.zip(column.unit) else { return String::new() };
        names_in(self.stem(column), dimension.units().iter().copied().filter(|unit| wanted(*unit, own)))
    }

    /// A column's name in the header without its unit, in plain letters.
    fn stem(&self, column: Column) -> &'static str {
        column.quantity.stem_in(&plain(self.name(column))).unwrap_or(column.quantity.stem)
    }

    /// A problem with a column as a whole.
    pub(crate) fn column_error(&self, column: Column, problem: ReadProblem) -> ReadError {
        let error = ReadError::in_column(self.file, self.header_line, self.name(column), problem);
        // Columns in memory have no header line.
        if self.header_line == 0 { ReadError { line: None, ..error } } else { error }
    }

    /// The names of all columns that are not among `used`.
    pub(crate) fn names_beside(&self, used: &[Column]) -> Vec<&str> {
        let unused = |index| used.iter().all(|column| column.index != index);
        self.names.iter().enumerate().filter(|(index, _)| unused(*index)).map(|(_, name)| name.as_str()).collect()
    }

    /// A column's name as the header has it.
    pub(crate) fn name(&self, column: Column) -> &str {
        &self.names[column.index]
    }

    /// The text of a cell, as messages show it.
    pub(crate) fn shown(&self, row: usize, column: Column) -> String {
        text::quoted(self.cell(row, column))
    }

    /// A problem with one cell.
    pub(crate) fn error(&self, row: usize, column: Column, problem: ReadProblem) -> ReadError {
        ReadError::in_column(self.file, self.lines[row], &self.names[column.index], problem)
    }

    /// A cell in SI; `None` where it is empty or NaN.
    ///
    /// # Errors
    /// Text, or an infinite number.
    pub(crate) fn value(&self, row: usize, column: Column) -> Result<Option<f64>, ReadError> {
        let cell = self.cell(row, column);
        let empty = column.quantity.empty;
        match self.parse_cell(row, column)? {
            Some(value) if value.is_infinite() => {
                Err(self.error(row, column, ReadProblem::Infinite { text: text::quoted(cell), empty }))
            }
            value => Ok(value),
        }
    }

    /// A cell in SI that must be a finite number.
    ///
    /// # Errors
    /// Text, an empty cell, NaN, or an infinite number.
    pub(crate) fn number(&self, row: usize, column: Column) -> Result<f64, ReadError> {
        self.value(row, column)?
            .ok_or_else(|| self.error(row, column, ReadProblem::NoNumber { text: self.shown(row, column) }))
    }

    /// A cell in SI that may be NaN or infinite; an empty cell is NaN.
    ///
    /// # Errors
    /// Text.
    pub(crate) fn any_number(&self, row: usize, column: Column) -> Result<f64, ReadError> {
        Ok(self.parse_cell(row, column)?.unwrap_or(f64::NAN))
    }

    /// Refuses a value that is not above the one in the row before.
    pub(crate) fn require_increase(
        &self,
        row: usize,
        column: Column,
        previous: f64,
        value: f64,
        what: &'static str,
    ) -> Result<(), ReadError> {
        if value > previous {
            return Ok(());
        }
        let text = self.shown(row, column);
        let previous_line = self.line(row - 1);
        let problem = if value < previous {
            ReadProblem::Backwards { what, text, previous: self.shown(row - 1, column), previous_line }
        } else {
            ReadProblem::Repeated { what, text, previous_line }
        };
        Err(self.error(row, column, problem))
    }

    /// The text of a cell.
    pub(crate) fn cell(&self, row: usize, column: Column) -> &str {
        &self.cells[row * self.names.len() + column.index]
    }

    /// `None` for an empty cell or NaN.
    fn parse_cell(&self, row: usize, column: Column) -> Result<Option<f64>, ReadError> {
        let cell = self.cell(row, column);
        if cell.is_empty() {
            return Ok(None);
        }
        match parse_number(cell, self.decimal_commas) {
            Some(value) if value.is_nan() => Ok(None),
            Some(value) => Ok(Some(column.unit.map_or(value, |unit| unit.to_si(value)))),
            None => {
                let text = text::quoted(cell);
                let has_comma = cell.contains(',') && cell.replace(',', "").parse::<f64>().is_ok();
                let problem = if has_comma {
                    ReadProblem::DecimalComma { text }
                } else if column.quantity.dimension == Some(Dimension::Time) && is_date(cell) {
                    ReadProblem::Date { text }
                } else {
                    ReadProblem::NotANumber { text, empty: column.quantity.empty }
                };
                Err(self.error(row, column, problem))
            }
        }
    }
}

/// Whether a text is a date, a time of day or both, such as 2026-01-31T12:00:00.5Z.
fn is_date(text: &str) -> bool {
    let may_be_in_it = |c: char| c.is_ascii_digit() || "-/.:, TZ+".contains(c);
    // Marks between thousands have three digits after them.
    let is_day = |mark: &char| {
        let parts: Vec<&str> = text.split(*mark).collect();
        parts.len() == 3 && parts[1].len() <= 2
    };
    let has_parts = text.contains(':') || ['-', '/', '.'].iter().any(is_day);
    text.starts_with(|c: char| c.is_ascii_digit()) && text.chars().all(may_be_in_it) && has_parts
}

/// The quantity with the longest stem that begins `name`, and that stem, so that `s1_sd_mm` is no `s1` in the unit `sd_mm`.
fn stem_of(name: &str, all: &[Quantity]) -> Option<(Quantity, &'static str)> {
    let of = |quantity: &Quantity| Some((*quantity, quantity.stem_in(name)?));
    all.iter().filter_map(of).max_by_key(|(_, stem)| stem.len())
}

/// All of them, if there are all.
fn all_of<const N: usize>(found: [Option<Column>; N]) -> Option<[Column; N]> {
    let columns: Vec<Column> = found.into_iter().flatten().collect();
    columns.try_into().ok()
}

/// What may separate columns; of those that occur equally often, the first does.
const SEPARATORS: [char; 3] = [',', ';', '\t'];

/// What separates the columns of a header.
fn separator_of(header: &str) -> char {
    let count = |mark: &char| header.matches(*mark).count();
    SEPARATORS.into_iter().rev().max_by_key(count).unwrap_or(',')
}

/// The separator that a line `sep=;` of a spreadsheet names.
fn separator_said(line: &str) -> Option<char> {
    let line = line.trim_start().trim_matches('"');
    let (key, mark) = line.split_at_checked(4)?;
    key.eq_ignore_ascii_case("sep=").then(|| mark.chars().next()).flatten()
}

/// Whether a cell names a unit, in brackets or not, as in a row of units below a header.
fn is_unit(cell: &str) -> bool {
    let all = [Dimension::Time, Dimension::Angle, Dimension::Length, Dimension::Force];
    let text = plain(cell);
    all.into_iter().flat_map(Dimension::units).any(|unit| unit.suffix() == text)
}

/// A number as it is written in a cell; with a decimal comma where columns are not separated by commas.
fn parse_number(cell: &str, decimal_commas: bool) -> Option<f64> {
    match cell.split_once(',') {
        Some((whole, decimals)) if decimal_commas && !cell.contains('.') => format!("{whole}.{decimals}").parse().ok(),
        _ => cell.parse().ok(),
    }
}

/// The text of a file, without its byte order mark.
fn decode<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a str, ReadError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(ReadError::in_file(file, ReadProblem::Utf16));
    }
    if bytes.contains(&0) {
        return Err(ReadError::in_file(file, ReadProblem::Binary));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count() + 1;
        ReadError::in_line(file, line, ReadProblem::NotUtf8)
    })
}

/// `key: value` out of a comment. A key begins with a letter and goes on in letters, digits, spaces, `_`, `-` and `.`; the colon
/// is followed by a blank or by nothing, so that a time of day or an address is no key.
pub(crate) fn metadata(comment: &str) -> Option<(String, String)> {
    let (key, value) = comment.split_once(':')?;
    let key = key.trim();
    let is_key = key.starts_with(char::is_alphabetic)
        && key.chars().all(|character| character.is_alphanumeric() || " _-.".contains(character));
    let is_apart = value.is_empty() || value.starts_with(char::is_whitespace);
    (is_key && is_apart).then(|| (key.to_string(), value.trim().to_string()))
}

/// Appends the cells of a line, trimmed and without quotes. False when a quote has no partner.
fn split_cells<'a>(line: &'a str, delimiter: char, cells: &mut Vec<Cow<'a, str>>) -> bool {
    if !line.contains('"') {
        cells.extend(line.split(delimiter).map(|cell| Cow::Borrowed(cell.trim())));
        return true;
    }
    let is_blank = |character: char| character.is_whitespace() && character != delimiter;
    let mut rest = line;
    loop {
        rest = rest.trim_start_matches(is_blank);
        if let Some(mut quoted) = rest.strip_prefix('"') {
            let mut cell = String::new();
            loop {
                let Some((inside, after)) = quoted.split_once('"') else { return false };
                cell.push_str(inside);
                // Two quotes in a row stand for one.
                match after.strip_prefix('"') {
                    Some(more) => {
                        cell.push('"');
                        quoted = more;
                    }
                    None => {
                        rest = after.trim_start_matches(is_blank);
                        break;
                    }
                }
            }
            cells.push(Cow::Owned(cell.trim().to_string()));
            if rest.is_empty() {
                return true;
            }
            let Some(after) = rest.strip_prefix(delimiter) else { return false };
            rest = after;
        } else {
            match rest.split_once(delimiter) {
                Some((cell, after)) => {
                    cells.push(Cow::Borrowed(cell.trim()));
                    rest = after;
                }
                None => {
                    cells.push(Cow::Borrowed(rest.trim()));
                    return true;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(line: &str, delimiter: char) -> Option<Vec<String>> {
        let mut cells = Vec::new();
        split_cells(line, delimiter, &mut cells).then(|| cells.into_iter().map(Cow::into_owned).collect())
    }

    #[test]
    fn quoted_cells_are_freed_of_their_quotes() {
        assert_eq!(
            cells(r#" a , "b, c" ,"d ""e""","#, ','),
            Some(vec!["a".into(), "b, c".into(), "d \"e\"".into(), String::new()])
        );
        assert_eq!(cells("\"a\"\t\"b\"\t", '\t'), Some(vec!["a".into(), "b".into(), String::new()]));
        assert_eq!(cells(r#""a,b"#, ','), None);
        assert_eq!(cells(r#""a"b,c"#, ','), None);
    }

    #[test]
    fn a_row_of_units_below_the_header_is_of_the_columns() {
        let names =
            |text: &str| Table::parse("log", text.as_bytes(), "").map(|table| (table.names.clone(), table.rows()));
        let with_units = "time,phi1 (deg),note,s1_mm\ns,deg,,[mm]\n0,1,2,3\n";
        let expected = ["time (s)", "phi1 (deg)", "note", "s1_mm"].map(str::to_owned);
        assert_eq!(names(with_units), Ok((expected.into(), 1)));
        // Below a row of numbers, or with a word among them, it is a row like any other.
        assert_eq!(names("a,b\n1,2\ns,mm\n").map(|(_, rows)| rows), Ok(2));
        assert_eq!(names("a,b\ns,feet\n").map(|(_, rows)| rows), Ok(1));
    }

    #[test]
    fn metadata_has_a_key_and_a_blank_after_the_colon() {
        let pair = |key: &str, value: &str| Some((key.to_string(), value.to_string()));
        assert_eq!(metadata(" robot: left hand "), pair("robot", "left hand"));
        assert_eq!(metadata("seed:"), pair("seed", ""));
        assert_eq!(metadata(" link: https://example.org"), pair("link", "https://example.org"));
        assert_eq!(metadata(" see https://example.org"), None);
        assert_eq!(metadata(" 12:30"), None);
        assert_eq!(metadata(" just words"), None);
    }
}
