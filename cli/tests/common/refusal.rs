//! What a refusal looks like.

use std::process::Output;

/// Status 2 and one line that names the file or the argument; nothing on stdout.
#[track_caller]
pub fn assert_refused(output: &Output, named: &str) {
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{named}: {line}");
    assert!(line.contains(named) && line.trim_end().lines().count() == 1, "{named}: {line}");
    assert!(output.stdout.is_empty());
}
