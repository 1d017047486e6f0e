//! Errors of design files.

use crate::KEYS;

/// The reason why a design file, a configuration or an override is rejected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// The text is not TOML. Holds the line and the parser's message.
    #[error("the design is not TOML: {0}")]
    Syntax(String),
    /// The key is not in [`KEYS`].
    #[error("unknown key `{key}`; the keys are {keys}", keys = key_names())]
    UnknownKey {
        /// The key as written.
        key: String,
    },
    /// The value has the wrong type or is out of range, or does not fit the other values.
    #[error("{key} = {value} is not possible: {allowed}")]
    Value {
        /// The key as written.
        key: &'static str,
        /// The value as written, on one line.
        value: String,
        /// The allowed values.
        allowed: String,
    },
    /// A design file lacks a key.
    #[error("the key `{0}` is missing; a design file has all of {keys}", keys = key_names())]
    Missing(&'static str),
    /// Changes name a key twice.
    #[error("the key `{key}` is changed twice; give each key once")]
    Twice {
        /// The key as written.
        key: String,
    },
    /// An override has no `=`, no key or no value.
    #[error("`{0}` is not of the form KEY=VALUE, like dog_bits=12")]
    Override(String),
}

impl DesignError {
    /// Returns the key that the error is about.
    pub(crate) fn key(&self) -> Option<&str> {
        match self {
            Self::UnknownKey { key } | Self::Twice { key } => Some(key),
            Self::Value { key, .. } | Self::Missing(key) => Some(key),
            Self::Syntax(_) | Self::Override(_) => None,
        }
    }
}

fn key_names() -> String {
    KEYS.each_ref().map(|key| key.name).join(", ")
}
