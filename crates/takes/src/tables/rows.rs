//! The rows of a CSV file under its header.
use rhytid_core::text::line_of;
use rhytid_core::text::quoted;
use rhytid_core::{Error, InputErrorKind, Result};

/// Walks over the rows of a CSV file. Blank lines are skipped; blanks around cells do not count.
pub(crate) struct Rows<'a> {
    bytes: &'a [u8],
    name: &'a str,
    reader: csv::Reader<&'a [u8]>,
    row: csv::ByteRecord,
    header: Vec<String>,
    /// The byte between cells.
    separator: u8,
}

impl<'a> Rows<'a> {
    /// Reads the header. `name` names the file in errors.
    pub(crate) fn open(bytes: &'a [u8], name: &'a str) -> Result<Self> {
        let reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
        let row = csv::ByteRecord::new();
        let mut rows = Self { bytes, name, reader, row, header: Vec::new(), separator: b',' };
        if !rows.advance()? {
            return Err(Error::empty(format!("{name}: the file is empty, expected a header and rows")));
        }
        rows.header = (0..rows.row.len()).map(|i| rows.text(i).map(str::to_owned)).collect::<Result<_>>()?;
        if let [header] = &rows.header[..]
            && let Some(between) =
                [(';', "semicolons"), ('\t', "tabs")].iter().find(|(c, _)| header.contains(*c))
        {
            return Err(rows.error(&format!(
                "the columns are separated by {}, expected commas between columns and points in numbers; \
                 export the table in this form",
                between.1
            )));
        }
        Ok(rows)
    }

    /// Rows of any length under a header, with the separator that the header has: commas, semicolons or tabs.
    ///
    /// # Errors
    /// [`Error::Input`] if the file is empty.
    pub(crate) fn separated(bytes: &'a [u8], name: &'a str) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new();
        let separator = separator(bytes);
        let reader = reader.has_headers(false).flexible(true).delimiter(separator).from_reader(bytes);
        let mut rows =
            Self { bytes, name, reader, row: csv::ByteRecord::new(), header: Vec::new(), separator };
        if !rows.advance()? {
            return Err(Error::empty(format!("{name}: the file is empty, expected a header and rows")));
        }
        rows.header =
            (0..rows.row.len()).map(|i| String::from_utf8_lossy(rows.cell(i)).trim().to_owned()).collect();
        Ok(rows)
    }

    /// Rows of any length without a header, with cells between `separator`. Quotes count only if the
    /// separator is a comma.
    pub(crate) fn without_header(bytes: &'a [u8], name: &'a str, separator: u8) -> Self {
        let reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator)
            .quoting(separator == b',')
            .from_reader(bytes);
        Self { bytes, name, reader, row: csv::ByteRecord::new(), header: Vec::new(), separator }
    }

    /// Whether commas separate the cells.
    pub(crate) fn is_separated_by_commas(&self) -> bool {
        self.separator == b','
    }

    /// The cells of the header.
    pub(crate) fn header(&self) -> &[String] {
        &self.header
    }

    /// The place of each of `wanted` in a header that has these columns and no others.
    pub(crate) fn columns<const N: usize>(&self, wanted: [&str; N]) -> Result<[usize; N]> {
        let expected = wanted.join(",");
        let mut places = [0; N];
        for (place, column) in places.iter_mut().zip(wanted) {
            *place = self.header.iter().position(|cell| cell == column).ok_or_else(|| {
                self.error(&format!(
                    "the header has no column {}, found {}, expected {expected} (separated by commas)",
                    quoted(column),
                    quoted(&self.header.join(","))
                ))
            })?;
        }
        match (0..self.header.len()).find(|i| !places.contains(i)) {
            None => Ok(places),
            Some(other) => Err(self.error(&format!(
                "column {} of the header is {}, expected {expected} and no other column",
                other + 1,
                quoted(&self.header[other])
            ))),
        }
    }

    /// Goes to the next row, which has as many cells as the header; `false` after the last one.
    pub(crate) fn next(&mut self) -> Result<bool> {
        if !self.advance()? {
            return Ok(false);
        }
        if self.row.len() != self.header.len() {
            return Err(self.error(&format!(
                "the row's number of cells is {}, expected {} as in the header; the file may be cut short",
                self.row.len(),
                self.header.len()
            )));
        }
        Ok(true)
    }

    /// Goes to the next row of a table of [`Rows::separated`]; `false` after the last one. Cells behind a
    /// row's end are empty. A last row that lacks cells, and its end of line, is left out with a warning.
    ///
    /// # Errors
    /// [`Error::Input`] if a row has cells beyond those of the header.
    pub(crate) fn next_of_table(&mut self, warnings: &mut Vec<String>) -> Result<bool> {
        if !self.advance()? {
            return Ok(false);
        }
        let (cells, width) = (self.row.len(), self.header.len());
        if cells < width && self.is_cut() {
            warnings.push("the file is cut short in its last row, which is left out".into());
            return Ok(false);
        }
        if (width..cells).any(|column| !self.cell(column).is_empty()) {
            return Err(self.error(&format!(
                "the row has {cells} cells, expected {width} as in the header; if numbers have decimal commas, separate \
                 the cells by semicolons or tabs"
            )));
        }
        Ok(true)
    }

    /// How many cells the current row has.
    pub(crate) fn width(&self) -> usize {
        self.row.len()
    }

    /// Cell `column` of the current row without the blanks around it.
    pub(crate) fn cell(&self, column: usize) -> &[u8] {
        self.row.get(column).unwrap_or_default().trim_ascii()
    }

    /// The number in cell `column` of the current row; `None` for anything else. Where no commas separate
    /// cells, a comma may stand for the decimal point.
    pub(crate) fn number(&self, column: usize) -> Option<f64> {
        let text = std::str::from_utf8(self.cell(column)).ok()?;
        match text.parse() {
            Ok(number) => Some(number),
            Err(_) if self.separator != b',' => text.replacen(',', ".", 1).parse().ok(),
            Err(_) => None,
        }
    }

    /// Whether the current row is the file's last one and has no end of line: the file may be cut short.
    fn is_cut(&self) -> bool {
        let end = self.reader.position().byte() as usize;
        end >= self.bytes.len() && !matches!(self.bytes.last(), Some(b'\n' | b'\r'))
    }

    /// Cell `column` of the current row as text.
    pub(crate) fn text(&self, column: usize) -> Result<&str> {
        std::str::from_utf8(self.cell(column)).map(str::trim).map_err(|_| {
            self.error(&format!(
                "cell {} is {}, expected UTF-8 text; export the table as CSV in UTF-8",
                column + 1,
                quoted(&String::from_utf8_lossy(self.cell(column)))
            ))
        })
    }

    /// The byte at which the current row begins, for [`Rows::line_at`].
    pub(crate) fn offset(&self) -> usize {
        let offset = self.row.position().map_or(0, |p| p.byte() as usize).min(self.bytes.len());
        // The reader counts the blank lines before a row as part of it.
        let blank = self.bytes[offset..].iter().take_while(|b| matches!(b, b'\r' | b'\n')).count();
        offset + blank
    }

    /// The 1-based line of a byte.
    pub(crate) fn line_at(&self, offset: usize) -> usize {
        line_of(self.bytes, offset)
    }

    /// An error in the current row.
    pub(crate) fn error(&self, message: &str) -> Error {
        let line = self.line_at(self.offset());
        Error::malformed(format!("{}, line {line}: {message}", self.name))
            .of_kind(InputErrorKind::Malformed { line: Some(line) })
    }

    /// Goes to the next row, however long it is; `false` after the last one.
    pub(crate) fn advance(&mut self) -> Result<bool> {
        loop {
            let more = self
                .reader
                .read_byte_record(&mut self.row)
                .map_err(|e| Error::malformed(format!("{}: is not a CSV file: {e}", self.name)))?;
            if !more {
                return Ok(false);
            }
            if self.row.len() > 1 || !self.cell(0).is_empty() {
                return Ok(true);
            }
        }
    }
}

/// The separator of a table: the one that its first line has most often.
pub(crate) fn separator(bytes: &[u8]) -> u8 {
    let line = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).find(|line| !line.trim_ascii().is_empty());
    let count = |separator: u8| line.unwrap_or_default().iter().filter(|&&byte| byte == separator).count();
    let others = [b';', b'\t'].into_iter().filter(|&other| count(other) > count(b','));
    others.max_by_key(|&other| count(other)).unwrap_or(b',')
}
