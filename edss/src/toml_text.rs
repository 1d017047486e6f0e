//! The place of an error in a TOML text that a user has written: line and key.

use toml::de::{DeTable, DeValue, Error};

/// Returns the line, from 1, of a byte of a text.
pub fn line(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset.min(text.len())].iter().filter(|&&byte| byte == b'\n').count() + 1
}

/// Returns the message of an error on one line. Messages about enumerations and wrong types have several.
pub fn message(error: &Error) -> String {
    error.message().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the key, after those of its tables, whose name or value is at a byte of the text; empty if none is.
pub fn key_at(table: &DeTable<'_>, offset: usize) -> String {
    for (key, value) in table {
        if key.span().contains(&offset) {
            return key.get_ref().to_string();
        }
        let inner = match value.get_ref() {
            DeValue::Table(inner) => key_at(inner, offset),
            DeValue::Array(values) => values
                .iter()
                .enumerate()
                .filter_map(|(i, value)| value.get_ref().as_table().map(|inner| (i, key_at(inner, offset))))
                .find(|(_, inner)| !inner.is_empty())
                .map(|(i, inner)| format!("{i}.{inner}"))
                .unwrap_or_default(),
            _ => String::new(),
        };
        if !inner.is_empty() {
            return format!("{}.{inner}", key.get_ref());
        }
        if value.span().contains(&offset) {
            return key.get_ref().to_string();
        }
    }
    String::new()
}
