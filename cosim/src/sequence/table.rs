//! What is wrong with a row of a table, by the name of the column.

/// Returns the reason why a row could not be parsed, with the name of the column.
pub(super) fn reason(error: &csv::Error, header: &csv::StringRecord) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => match err.field().and_then(|field| header.get(field as usize)) {
            Some(column) => format!("{column} is no number"),
            None => err.kind().to_string(),
        },
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} fields, and the header has {expected_len}")
        }
        _ => error.to_string(),
    }
}
