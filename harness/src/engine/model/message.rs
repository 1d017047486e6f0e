//! Messages of the Verilog.

/// A message of the Verilog during an evaluation.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(missing_docs, reason = "the fields are the message and its place in the Verilog")]
pub enum Message {
    /// A line of `$display`, `$write`, `$info`, `$warning` or `$error`.
    Text(String),
    /// `$finish`.
    Finish { file: String, line: u32 },
    /// `$stop`, `$error`, `$fatal` or a failed assertion; its text is the message before it.
    Stop { file: String, line: u32 },
    /// The model cannot be evaluated any more, for instance because it does not settle.
    Fatal { message: String, file: String, line: u32 },
}
