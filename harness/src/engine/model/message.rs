//! Messages of the Verilog.

/// A message of the Verilog during an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// A line of `$display`, `$write`, `$info`, `$warning` or `$error`.
    Text(String),
    /// `$finish`.
    Finish {
        /// The Verilog file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// `$stop`, `$error`, `$fatal` or a failed assertion; its text is the message before it.
    Stop {
        /// The Verilog file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// The model cannot be evaluated any more, for instance because it does not settle.
    Fatal {
        /// The text.
        message: String,
        /// The file.
        file: String,
        /// The line in it.
        line: u32,
    },
}
