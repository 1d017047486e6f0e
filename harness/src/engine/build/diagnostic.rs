//! Verilator's messages as data: `%Warning-WIDTH: fifo.v:12:5: text`, with the lines after it as context.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The severity of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Severity {
    /// Verilator refuses the Verilog.
    Error,
    /// Verilator accepts it, but something looks wrong.
    Warning,
}

/// One message of Verilator.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// Verilator's code, such as `WIDTH`; empty if it gave none.
    pub code: String,
    /// The file; empty if it gave none.
    pub file: String,
    /// The line in it, from 1; 0 if it gave none.
    pub line: u32,
    /// The column in it, from 1; 0 if it gave none.
    pub column: u32,
    /// The message.
    pub message: String,
    /// The lines that belong to the message: the source line, the instance.
    pub context: Vec<String>,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        if !self.file.is_empty() {
            write!(f, "{}:{}:{}: ", self.file, self.line, self.column)?;
        }
        if self.code.is_empty() {
            write!(f, "{severity}: {}", self.message)
        } else {
            write!(f, "{severity} {}: {}", self.code, self.message)
        }
    }
}

/// Parses all messages in Verilator's output: errors first, otherwise in their order.
pub fn parse(output: &str) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    for line in output.lines() {
        let (severity, rest) = if let Some(rest) = line.strip_prefix("%Error") {
            (Severity::Error, rest)
        } else if let Some(rest) = line.strip_prefix("%Warning") {
            (Severity::Warning, rest)
        } else {
            if line.starts_with(' ')
                && let Some(last) = found.last_mut()
            {
                last.context.push(line.trim_end().to_owned());
            }
            continue;
        };
        let Some((code, text)) = rest.split_once(": ") else { continue };
        let text = text.trim();
        if text.starts_with("Exiting due to") || text.starts_with("Command Failed") {
            continue;
        }
        let (file, line, column, message) = split_place(text).unwrap_or(("", 0, 0, text));
        found.push(Diagnostic {
            severity,
            code: code.trim_start_matches('-').to_owned(),
            file: file.to_owned(),
            line,
            column,
            message: message.to_owned(),
            context: Vec::new(),
        });
    }
    found.sort_by_key(|d| d.severity);
    found
}

/// Splits `file:12:5: message` into its parts.
fn split_place(text: &str) -> Option<(&str, u32, u32, &str)> {
    for (at, _) in text.match_indices(':') {
        let mut fields = text[at + 1..].splitn(3, ':');
        let (line, column) = (fields.next()?.parse(), fields.next().map(str::parse));
        if let (Ok(line), Some(Ok(column)), Some(message)) = (line, column, fields.next()) {
            return Some((&text[..at], line, column, message.trim_start()));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_code_and_context_are_taken_apart() {
        let text = "%Warning-WIDTH: /a/b.v:4:57: Operator ADD expects 8 bits\n\
                    \x20                                : ... In instance counter\n\
                    \x20   4 |   count <= count + 1;\n\
                    %Error: /a/b.v:9:1: syntax error, unexpected endmodule\n\
                    %Error: Exiting due to 1 error(s)\n";
        let found = parse(text);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].severity, found[0].line, found[0].column), (Severity::Error, 9, 1));
        assert_eq!(found[0].message, "syntax error, unexpected endmodule");
        assert_eq!(found[1].code, "WIDTH");
        assert_eq!(found[1].context.len(), 2);
        assert_eq!(found[1].to_string(), "/a/b.v:4:57: warning WIDTH: Operator ADD expects 8 bits");
    }

    #[test]
    fn a_message_without_a_place_stays_whole() {
        let found = parse("%Error: Specified --top-module 'x' was not found in design.");
        assert_eq!(found[0].file, "");
        assert_eq!(found[0].message, "Specified --top-module 'x' was not found in design.");
    }
}
