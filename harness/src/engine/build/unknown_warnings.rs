//! Warnings that this Verilator does not have, and that a design or its flags turn off because a newer one has them.

use std::collections::BTreeSet;

/// The names of such warnings. Verilator refuses both ways to turn one off; `-Wfuture-NAME` makes it ignore the
/// comments in the Verilog.
#[derive(Default)]
pub(super) struct UnknownWarnings(BTreeSet<String>);

impl UnknownWarnings {
    /// Adds the names that the output of a failed run has; returns `true` if there are new ones.
    pub fn add_from(&mut self, stderr: &str) -> bool {
        let quoted = |text: &str| text.strip_prefix('\'')?.split_once('\'').map(|(name, _)| name.to_owned());
        let word = |text: &str| text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').next().map(str::to_owned);
        let in_comments = stderr.split("Unknown verilator lint message code: ").skip(1).filter_map(quoted);
        let in_flags = stderr.split("Unknown warning specified: -Wno-").skip(1).filter_map(word);
        let before = self.0.len();
        self.0.extend(in_comments.chain(in_flags).filter(|name| !name.is_empty()));
        self.0.len() > before
    }

    /// Returns the arguments of a run that turns none of these warnings off, and ignores comments that do.
    pub fn ignored_in(&self, mut arguments: Vec<String>) -> Vec<String> {
        arguments.retain(|argument| argument.strip_prefix("-Wno-").is_none_or(|name| !self.0.contains(name)));
        arguments.extend(self.0.iter().map(|name| format!("-Wfuture-{name}")));
        arguments
    }

    /// Returns a line, as Verilator's own warnings are, that names the warnings; empty if there are none.
    pub fn line(&self) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let names: Vec<&str> = self.0.iter().map(String::as_str).collect();
        format!("%Warning: this Verilator does not have the warnings that are turned off: {}", names.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_from_comments_and_flags() {
        let mut unknown = UnknownWarnings::default();
        assert!(
            !unknown.add_from("%Error: a.v:1:1: syntax error, unexpected endmodule\n") && unknown.line().is_empty()
        );
        let text = "%Error: a.v:20:5: Unknown verilator lint message code: 'AB_C', in '/*verilator lint_off AB_C*/'\n\
                    %Error: Unknown warning specified: -Wno-DEF... Suggested alternative: '-Wno-D'\n";
        assert!(unknown.add_from(text) && !unknown.add_from(text));
        let arguments = ["-Wno-DEF", "-Wno-DEFG", "-O3", "a.v"].map(str::to_owned).to_vec();
        assert_eq!(unknown.ignored_in(arguments), ["-Wno-DEFG", "-O3", "a.v", "-Wfuture-AB_C", "-Wfuture-DEF"]);
        assert!(unknown.line().ends_with("turned off: AB_C, DEF"));
    }
}
