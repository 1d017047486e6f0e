//! `hoverlock rtl estimate` as a user runs it.

use std::process::Command;

#[test]
fn without_yosys_it_says_so_in_one_line_with_status_2() {
    let output = Command::new(env!("CARGO_BIN_EXE_hoverlock"))
        .args(["rtl", "estimate", "--json"])
        .env("PATH", "")
        .output()
        .expect("the command runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    assert!(said.contains("yosys cannot be started") && said.contains("Debian's package yosys"), "{said}");
    assert!(output.stdout.is_empty());
}
