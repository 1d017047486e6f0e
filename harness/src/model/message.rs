//! What the Verilog says while it is evaluated.

/// What the Verilog said during an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// A line of `$display` and its kin, `$error` and `$warning` included.
    Text(String),
    /// `$finish`.
    Finish {
        /// The Verilog file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// `$stop`, `$error`, `$fatal` or a failed assertion; what it said is in the text before it.
    Stop {
        /// The Verilog file.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// The model cannot go on, for instance because it does not settle.
    Fatal {
        /// What it says.
        message: String,
        /// The file.
        file: String,
        /// The line in it.
        line: u32,
    },
}
