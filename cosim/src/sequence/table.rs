//! What tables with a row for each frame or sample have in common.

/// Largest time of a row, s: clocks may count from 1970.
pub(super) const MAX_TIME_S: f64 = 1e10;

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
