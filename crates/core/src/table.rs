//! A row-major table: rows of equally many elements, one after the other.
use crate::{Error, Result};
use rayon::prelude::*;
use std::ops::Range;

/// A row-major table of rows × columns elements.
///
/// A table without columns still knows how many rows it has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table<T> {
    rows: usize,
    columns: usize,
    elements: Vec<T>,
}

impl<T> Table<T> {
    /// The table of rows × columns `elements`, row after row.
    ///
    /// # Panics
    /// If there are not rows × columns of them, which is a mistake of the caller. Use [`Table::try_new`] for
    /// elements from outside.
    pub fn new(rows: usize, columns: usize, elements: Vec<T>) -> Self {
        let found = elements.len();
        assert_eq!(
            rows.checked_mul(columns),
            Some(found),
            "a table of {rows} × {columns} has {found} elements"
        );
        Self { rows, columns, elements }
    }

    /// As [`Table::new`], for elements whose number is not known.
    ///
    /// # Errors
    /// [`Error::Input`] if there are not rows × columns of them.
    pub fn try_new(rows: usize, columns: usize, elements: Vec<T>) -> Result<Self> {
        let found = elements.len();
        if rows.checked_mul(columns) != Some(found) {
            return Err(Error::mismatch(format!(
                "a table has {found} elements, expected {rows} × {columns}"
            )));
        }
        Ok(Self { rows, columns, elements })
    }

    /// The table without elements that has this many rows.
    pub fn without_columns(rows: usize) -> Self {
        Self { rows, columns: 0, elements: Vec::new() }
    }

    /// The table with the same element everywhere.
    pub fn filled(rows: usize, columns: usize, element: T) -> Self
    where
        T: Clone,
    {
        Self { rows, columns, elements: vec![element; rows * columns] }
    }

    /// How many rows there are.
    pub fn height(&self) -> usize {
        self.rows
    }

    /// How many elements each row has.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Row `i`.
    ///
    /// # Panics
    /// If there is no such row and there are columns.
    pub fn row(&self, i: usize) -> &[T] {
        &self.elements[i * self.columns..][..self.columns]
    }

    /// Row `i`.
    ///
    /// # Panics
    /// As [`Table::row`].
    pub fn row_mut(&mut self, i: usize) -> &mut [T] {
        &mut self.elements[i * self.columns..][..self.columns]
    }

    /// All rows. In a table without columns they are empty.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[T]> + DoubleEndedIterator + Clone {
        (0..self.rows).map(|i| self.row(i))
    }

    /// All rows. A table without columns gives none, since there is nothing to write.
    pub fn rows_mut(&mut self) -> impl ExactSizeIterator<Item = &mut [T]> {
        self.elements.chunks_exact_mut(self.columns.max(1))
    }

    /// The elements of these rows, row after row.
    ///
    /// # Panics
    /// If there are no such rows and there are columns.
    pub fn of_rows(&self, rows: Range<usize>) -> &[T] {
        &self.elements[rows.start * self.columns..rows.end * self.columns]
    }

    /// All elements, row after row.
    pub fn as_slice(&self) -> &[T] {
        &self.elements
    }

    /// All elements, row after row.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.elements
    }

    /// All elements, row after row.
    pub fn into_vec(self) -> Vec<T> {
        self.elements
    }

    /// The table with `of` applied to each element.
    pub fn map<U: Send>(&self, of: impl Fn(&T) -> U + Sync + Send) -> Table<U>
    where
        T: Sync,
    {
        Table { rows: self.rows, columns: self.columns, elements: self.elements.par_iter().map(of).collect() }
    }

    /// The rows of `chosen`, in that order.
    ///
    /// # Panics
    /// As [`Table::row`].
    pub fn chosen(&self, chosen: impl ExactSizeIterator<Item = usize>) -> Self
    where
        T: Clone,
    {
        let rows = chosen.len();
        let mut elements = Vec::with_capacity(rows * self.columns);
        chosen.for_each(|i| elements.extend_from_slice(self.row(i)));
        Self { rows, columns: self.columns, elements }
    }
}

impl<T: Copy> Table<T> {
    /// Writes row `from` over row `to`.
    pub fn copy_row(&mut self, from: usize, to: usize) {
        let columns = self.columns;
        self.elements.copy_within(from * columns..(from + 1) * columns, to * columns);
    }
}

impl<T: Sync> Table<T> {
    /// All rows, for several threads. In a table without columns they are empty.
    pub fn par_rows(&self) -> impl IndexedParallelIterator<Item = &[T]> {
        (0..self.rows).into_par_iter().map(|i| self.row(i))
    }
}

impl<T: Send> Table<T> {
    /// All rows, for several threads. A table without columns gives none, since there is nothing to write.
    pub fn par_rows_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [T]> {
        self.elements.par_chunks_exact_mut(self.columns.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_where_they_were_put() {
        let mut table = Table::new(2, 3, vec![1, 2, 3, 4, 5, 6]);
        table.row_mut(1)[0] = 9;
        let rows: Vec<&[i32]> = table.rows().collect();
        assert_eq!(rows, [[1, 2, 3], [9, 5, 6]]);
        assert_eq!(table.par_rows().collect::<Vec<_>>(), rows);
        assert_eq!(table.of_rows(1..2), [9, 5, 6]);
        assert_eq!(table.chosen([1, 1, 0].into_iter()).as_slice(), [9, 5, 6, 9, 5, 6, 1, 2, 3]);
        table.par_rows_mut().for_each(<[i32]>::reverse);
        table.rows_mut().for_each(|row| row[0] = 7);
        assert_eq!(table.map(|x| x + 1), Table::new(2, 3, vec![8, 3, 2, 8, 6, 10]));
        assert_eq!(table.into_vec(), [7, 2, 1, 7, 5, 9]);
    }

    #[test]
    fn without_columns_there_are_as_many_rows() {
        let mut table = Table::new(3, 0, Vec::<u8>::new());
        assert_eq!(table, Table::without_columns(3));
        assert_ne!(table, Table::without_columns(2));
        assert_eq!((table.height(), table.columns(), table.is_empty()), (3, 0, true));
        assert_eq!(table.rows().collect::<Vec<_>>(), [[0u8; 0]; 3]);
        assert_eq!(table.par_rows().map(<[u8]>::len).collect::<Vec<_>>(), [0; 3]);
        assert_eq!(table.rows_mut().len(), 0);
        assert_eq!(table.par_rows_mut().len(), 0);
        assert_eq!(table.chosen([2, 0].into_iter()), Table::without_columns(2));
    }

    #[test]
    fn what_was_not_counted_is_refused() {
        let error = Table::try_new(2, 2, vec![0; 3]).unwrap_err().to_string();
        assert!(error.contains("3 elements, expected 2 × 2"), "{error}");
        assert!(Table::try_new(usize::MAX, 2, vec![0; 3]).is_err());
        assert_eq!(Table::try_new(1, 2, vec![0; 2]).unwrap(), Table::filled(1, 2, 0));
    }
}
