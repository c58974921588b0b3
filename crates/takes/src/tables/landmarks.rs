//! Which handles of two faces are at the same place: `from,to`.
use super::rows::Rows;
use rhytid_core::text::quoted;
use rhytid_core::{Error, InputErrorKind, Result, input_file};
use std::path::Path;

/// Reads pairs of labels from a CSV file: column `from` for the first face and `to` for the second. Rows
/// without one of them are skipped. Other columns do not matter.
///
/// # Errors
/// [`Error::Input`]: no such columns, a label that occurs twice in its column, no pairs. [`Error::Io`].
pub fn read_landmarks(path: &Path) -> Result<Vec<(String, String)>> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    decode(&bytes, &path.display().to_string())
}

fn decode(bytes: &[u8], name: &str) -> Result<Vec<(String, String)>> {
    let mut rows = Rows::open(bytes, name)?;
    let place = |name: &str| rows.header().iter().position(|cell| cell == name);
    let (Some(from), Some(to)) = (place("from"), place("to")) else {
        return Err(rows.error(&format!(
            "the header is {}, expected columns “from” and “to”: labels of the first face and of the second",
            quoted(&rows.header().join(","))
        )));
    };
    let mut pairs: Vec<(String, String)> = Vec::new();
    while rows.next()? {
        let pair = (rows.text(from)?.to_owned(), rows.text(to)?.to_owned());
        if pair.0.is_empty() || pair.1.is_empty() {
            continue;
        }
        if let Some(other) = pairs.iter().find(|other| other.0 == pair.0 || other.1 == pair.1) {
            return Err(rows
                .error(&format!(
                    "{} belongs to {}, but {} belongs to {} already; each label may have one partner only",
                    quoted(&pair.0),
                    quoted(&pair.1),
                    quoted(&other.0),
                    quoted(&other.1)
                ))
                .of_kind(InputErrorKind::Conflict));
        }
        pairs.push(pair);
    }
    if pairs.is_empty() {
        return Err(Error::empty(format!("{name}: has no pairs, expected a row from,to for each landmark")));
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_read_and_mistakes_are_named() {
        let pairs = [("chin", "M1"), ("brow", "M2")].map(|(a, b)| (a.to_owned(), b.to_owned()));
        assert_eq!(decode(b"to,note,from\nM1,x,chin\nM9,,\nM2,,brow\n", "table.csv").unwrap(), pairs);
        for (text, expected) in [
            ("a,b\nchin,M1\n", "table.csv, line 1: the header is \"a,b\", expected columns"),
            (
                "from,to\nchin,M1\nchin,M2\n",
                "line 3: \"chin\" belongs to \"M2\", but \"chin\" belongs to \"M1\" already",
            ),
            ("from,to\nchin,\n", "table.csv: has no pairs"),
        ] {
            let message = decode(text.as_bytes(), "table.csv").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
