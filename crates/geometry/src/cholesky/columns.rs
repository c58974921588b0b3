//! A sparse matrix.

/// A sparse matrix by columns; of a symmetric one the lower triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    /// One more entry than there are columns: where each column begins.
    pub offsets: Vec<usize>,
    /// The row of each entry.
    pub rows: Vec<u32>,
    /// The value of each entry.
    pub values: Vec<f64>,
}

impl Columns {
    /// The rows and values of column `j`.
    pub fn column(&self, j: usize) -> (&[u32], &[f64]) {
        let range = self.offsets[j]..self.offsets[j + 1];
        (&self.rows[range.clone()], &self.values[range])
    }

    /// Adds a column.
    pub fn push(&mut self, entries: impl IntoIterator<Item = (u32, f64)>) {
        for (row, value) in entries {
            self.rows.push(row);
            self.values.push(value);
        }
        self.offsets.push(self.rows.len());
    }

    /// Adds the columns of another one.
    pub fn append(&mut self, other: Self) {
        let first = self.rows.len();
        self.offsets.extend(other.offsets[1..].iter().map(|offset| first + offset));
        self.rows.extend(other.rows);
        self.values.extend(other.values);
    }
}

/// Without a column.
impl Default for Columns {
    fn default() -> Self {
        Self { offsets: vec![0], rows: Vec::new(), values: Vec::new() }
    }
}
