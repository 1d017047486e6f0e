//! The exported coefficient files, read by the tools that use them, have the coefficients of the set.

use hoverlock_fixed_point::model::coefficients::export;
use hoverlock_fixed_point::model::coefficients::set::{CoefficientSet, LookAhead, SmootherSpec};
use hoverlock_reference::smoothing::recursive::{Family, Fit};
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

fn sets(family: Family, fit: Fit) -> Vec<CoefficientSet> {
    let design = |sigma| {
        let spec = SmootherSpec { family, fit, sigma, frac_bits: 16, look_ahead: LookAhead::Error(1e-4) };
        CoefficientSet::design(&spec).unwrap()
    };
    [2.0, 3.2, 5.12].map(design).to_vec()
}

/// Lerp coefficients, signed direct forms in cascade, and signed direct forms in parallel.
fn all_kinds() -> [Vec<CoefficientSet>; 3] {
    [
        sets(Family::FirstOrder, Fit::LeastSquares),
        sets(Family::YoungVanVliet, Fit::Published),
        sets(Family::Deriche { order: 4 }, Fit::Published),
    ]
}

/// `(SMOOTHER<i>_<name>, raw)` of every coefficient.
fn named_words(sets: &[CoefficientSet]) -> Vec<(String, i64)> {
    let of = |(i, set): (usize, &CoefficientSet)| {
        set.words().into_iter().map(move |word| (format!("SMOOTHER{i}_{}", word.name), word.raw)).collect::<Vec<_>>()
    };
    sets.iter().enumerate().flat_map(of).collect()
}

/// Runs a tool in `folder`; skips where the tool is not installed.
fn run(test: &str, folder: &Path, program: &str, arguments: &[&str]) {
    match Command::new(program).args(arguments).current_dir(folder).output() {
        Ok(output) => assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            writeln!(std::io::stderr(), "SKIPPED: {test}: install {program}").expect("stderr is open");
        }
        Err(error) => panic!("{program}: {error}"),
    }
}

#[test]
fn the_memory_file_has_every_coefficient_in_its_width() {
    for sets in all_kinds() {
        let text = export::mif(&sets, "test");
        let field = |name: &str| -> u32 {
            let line = text.lines().find(|line| line.starts_with(name)).unwrap();
            line.split(['=', ';']).nth(1).unwrap().trim().parse().unwrap()
        };
        let (width, depth) = (field("WIDTH"), field("DEPTH"));
        let signed = sets[0].word_format().1;
        let content = text.split("CONTENT BEGIN").nth(1).unwrap();
        let read: Vec<i64> = content
            .lines()
            .filter_map(|line| line.split_once(':').filter(|(address, _)| !address.trim().starts_with("--")))
            .map(|(_, rest)| {
                let bits = i64::from_str_radix(rest.split(';').next().unwrap().trim(), 16).unwrap();
                if signed && bits >> (width - 1) == 1 { bits - (1 << width) } else { bits }
            })
            .collect();
        let want: Vec<i64> = named_words(&sets).into_iter().map(|(_, raw)| raw).collect();
        assert_eq!(read, want);
        assert_eq!(depth as usize, want.len());
        assert!(text.trim_end().ends_with("END;"));
    }
}

#[test]
fn verilog_reads_the_coefficients() {
    for sets in all_kinds() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("coefficients.vh"), export::verilog(&sets, "test")).unwrap();
        // Where a coefficient differs, the generate block instantiates a module that does not exist.
        let checks: String = named_words(&sets)
            .iter()
            .map(|(name, raw)| format!("if ({name} != {raw}) missing wrong_{name}();\n"))
            .collect();
        // Two modules of one compilation include it.
        let first = "module first;\n`include \"coefficients.vh\"\nendmodule\n";
        let top = format!("{first}module top;\nfirst first();\n`include \"coefficients.vh\"\n{checks}endmodule\n");
        std::fs::write(folder.path().join("top.v"), top).unwrap();
        run("verilog_reads_the_coefficients", folder.path(), "verilator", &["--lint-only", "-Wno-WIDTH", "top.v"]);
    }
}

#[test]
fn c_reads_the_coefficients() {
    for sets in all_kinds() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("coefficients.h"), export::c(&sets, "test")).unwrap();
        let checks: String = named_words(&sets)
            .iter()
            .map(|(name, raw)| format!("_Static_assert(HOVERLOCK_{name} == {raw}, \"{name}\");\n"))
            .collect();
        std::fs::write(folder.path().join("check.c"), format!("#include \"coefficients.h\"\n{checks}")).unwrap();
        run(
            "c_reads_the_coefficients",
            folder.path(),
            "cc",
            &["-std=c11", "-Wall", "-Werror", "-fsyntax-only", "check.c"],
        );
    }
}

#[test]
fn rust_reads_the_coefficients() {
    for sets in all_kinds() {
        let folder = tempfile::tempdir().unwrap();
        let checks: String =
            named_words(&sets).iter().map(|(name, raw)| format!("const _: () = assert!({name} == {raw});\n")).collect();
        let text = format!("#![deny(missing_docs)]\n//! Check.\n{}{checks}", export::rust(&sets, "test"));
        std::fs::write(folder.path().join("check.rs"), text).unwrap();
        run(
            "rust_reads_the_coefficients",
            folder.path(),
            "rustc",
            &["--edition=2024", "--crate-type=lib", "--emit=metadata", "check.rs"],
        );
    }
}

#[test]
fn markdown_has_a_row_for_every_coefficient() {
    for sets in all_kinds() {
        let text = export::markdown(&sets, "test");
        for word in sets.iter().flat_map(CoefficientSet::words) {
            assert!(text.contains(&format!("| `{}` | {} |", word.name, word.raw)), "{}", word.name);
        }
        // Every row of a table has as many cells as its head.
        let mut columns = 0;
        for line in text.lines() {
            let cells = line.matches('|').count();
            assert!(cells == 0 || columns == 0 || cells == columns, "{line}");
            columns = cells;
        }
    }
}
