//! Words that the readers of text files share: line numbers, quoting, suggestions.

/// The 1-based line of byte `offset`; LF, CR LF and CR end a line.
pub fn line_of(bytes: &[u8], offset: usize) -> usize {
    let before = &bytes[..offset.min(bytes.len())];
    let ends = |i: usize| match bytes[i] {
        b'\n' => true,
        b'\r' => bytes.get(i + 1) != Some(&b'\n'),
        _ => false,
    };
    1 + (0..before.len()).filter(|&i| ends(i)).count()
}

/// `text` in quotes, with control characters escaped and its tail cut off where it is long.
pub fn quoted(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((cut, _)) => format!("{:?}…", &text[..cut]),
        None => format!("{text:?}"),
    }
}

/// Up to eight of `words`, quoted, and how many more there are.
pub fn listed<'a>(words: impl ExactSizeIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 8;
    let more = words.len().saturating_sub(SHOWN);
    let shown = words.take(SHOWN).map(quoted).collect::<Vec<_>>().join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// The characters between an actor and a label, as in `Anna:chin`.
pub const LABEL_SEPARATORS: [char; 2] = [':', '|'];

/// A marker's label without the prefix of its actor, such as `Anna:`, and in lower case.
pub fn bare_label(label: &str) -> String {
    label.rsplit(LABEL_SEPARATORS).next().unwrap_or(label).trim().to_lowercase()
}

/// What stands before the label of [`bare_label`], with its separator, such as `Anna:`; empty if nothing
/// does.
pub fn label_prefix(label: &str) -> &str {
    // Each separator has one byte.
    label.rfind(LABEL_SEPARATORS).map_or("", |at| &label[..=at])
}

/// The word of `known` that was probably meant by `word`: at most a third of its letters differ.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // The comparison takes quadratic time, so longer words are left out.
    const LONGEST: usize = 64;
    if word.len() > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    let limit = (lower.chars().count() / 3).max(1);
    known
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| (strsim::damerau_levenshtein(&lower, &candidate.to_lowercase()), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// ` (did you mean "…"?)`, or nothing where no word of `known` is near.
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map(|near| format!(" (did you mean {}?)", quoted(near))).unwrap_or_default()
}
