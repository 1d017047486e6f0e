//! Coefficients as text for other tools: Verilog header, Intel memory initialisation file, C header, Rust constants,
//! Markdown.
//!
//! Each function returns the whole text of one file. All use [`CoefficientSet::words`], so that the files agree. Names
//! are `SMOOTHER<i>_<name>`, `i` from 0 in the order of the sigmas.

use super::set::{CoefficientSet, Word};
use hoverlock_design::comment;
use std::fmt::Write as _;

/// An export file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// File name without folder.
    pub name: &'static str,
    /// Content of the file.
    pub text: String,
}

/// Returns all export files. `command` is the command line, which each file names as its origin in a [`comment`].
pub fn all(sets: &[CoefficientSet], command: &str) -> Vec<File> {
    let command = &comment(command);
    vec![
        File { name: "coefficients.vh", text: verilog(sets, command) },
        File { name: "coefficients.mif", text: mif(sets, command) },
        File { name: "coefficients.h", text: c(sets, command) },
        File { name: "coefficients.rs", text: rust(sets, command) },
        File { name: "coefficients.md", text: markdown(sets, command) },
    ]
}

/// Describes the design of a set in one line.
fn title(set: &CoefficientSet) -> String {
    let (width, signed) = set.word_format();
    let format = if signed {
        format!("two's complement, {width} bits, {} after the point", set.quantised.frac_bits)
    } else {
        format!("u0.{}", set.quantised.frac_bits)
    };
    format!("sigma {} px, {} of order {}, {} fit, {format}", set.sigma, set.method, set.order, set.fit)
}

/// Returns the value of a coefficient.
fn value(set: &CoefficientSet, word: &Word) -> f64 {
    word.raw as f64 * (-f64::from(set.quantised.frac_bits)).exp2()
}

/// Returns the text of a Verilog header of `localparam`s. Include it in each module that needs it: a guard would leave
/// the second module of a compilation without them.
pub fn verilog(sets: &[CoefficientSet], command: &str) -> String {
    let mut text = format!(
        "// Written by: {command}\n// Include it in each module that needs it.\nlocalparam SMOOTHERS = {};\n",
        sets.len()
    );
    for (i, set) in sets.iter().enumerate() {
        let (width, signed) = set.word_format();
        let (sign, base) = if signed { (" signed", "sd") } else { ("", "d") };
        let _ = writeln!(text, "\n// {}", title(set));
        let _ = writeln!(text, "localparam SMOOTHER{i}_FRACTION_BITS = {};", set.quantised.frac_bits);
        if let Some(lerp) = &set.quantised.lerp {
            let _ = writeln!(text, "localparam SMOOTHER{i}_LOOK_AHEAD = {};", lerp.look_ahead);
        }
        for word in set.words() {
            let minus = if word.raw < 0 { "-" } else { "" };
            let _ = writeln!(
                text,
                "localparam{sign} [{}:0] SMOOTHER{i}_{} = {minus}{width}'{base}{}; // {:.9}: {}",
                width - 1,
                word.name,
                word.raw.unsigned_abs(),
                value(set, &word),
                word.meaning
            );
        }
    }
    text
}

/// Writes an Intel memory initialisation file: the coefficients of all sets in order, in memory words of the largest
/// width.
pub fn mif(sets: &[CoefficientSet], command: &str) -> String {
    let width = sets.iter().map(|set| set.word_format().0).max().unwrap_or(1);
    let depth: usize = sets.iter().map(|set| set.words().len()).sum();
    let digits = width.div_ceil(4) as usize;
    let mut text = format!(
        "-- Written by: {command}\nWIDTH = {width};\nDEPTH = {depth};\nADDRESS_RADIX = UNS;\nDATA_RADIX = HEX;\n\
         CONTENT BEGIN\n"
    );
    let mut address = 0;
    for (i, set) in sets.iter().enumerate() {
        let _ = writeln!(text, "-- {}", title(set));
        for word in set.words() {
            let bits = word.raw as u64 & (u64::MAX >> (64 - width));
            let _ = writeln!(
                text,
                "  {address} : {bits:0digits$X}; -- SMOOTHER{i}_{} = {:.9}",
                word.name,
                value(set, &word)
            );
            address += 1;
        }
    }
    text += "END;\n";
    text
}

/// Writes a C header of macros.
pub fn c(sets: &[CoefficientSet], command: &str) -> String {
    let mut text = format!(
        "/* Written by: {command} */\n#ifndef HOVERLOCK_COEFFICIENTS_H\n#define HOVERLOCK_COEFFICIENTS_H\n\
         #include <stdint.h>\n#define HOVERLOCK_SMOOTHERS {}\n",
        sets.len()
    );
    for (i, set) in sets.iter().enumerate() {
        let (_, signed) = set.word_format();
        let macro_name = if signed { "INT64_C" } else { "UINT32_C" };
        let _ = writeln!(text, "\n/* {} */", title(set));
        let _ = writeln!(text, "#define HOVERLOCK_SMOOTHER{i}_FRACTION_BITS {}", set.quantised.frac_bits);
        if let Some(lerp) = &set.quantised.lerp {
            let _ = writeln!(text, "#define HOVERLOCK_SMOOTHER{i}_LOOK_AHEAD {}", lerp.look_ahead);
        }
        for word in set.words() {
            let _ = writeln!(
                text,
                "#define HOVERLOCK_SMOOTHER{i}_{} {macro_name}({}) /* {:.9}: {} */",
                word.name,
                word.raw,
                value(set, &word),
                word.meaning
            );
        }
    }
    text += "\n#endif\n";
    text
}

/// Writes Rust constants.
pub fn rust(sets: &[CoefficientSet], command: &str) -> String {
    let mut text =
        format!("// Written by: {command}\n\n/// Number of smoothers.\npub const SMOOTHERS: usize = {};\n", sets.len());
    for (i, set) in sets.iter().enumerate() {
        let (_, signed) = set.word_format();
        let kind = if signed { "i64" } else { "u32" };
        let _ = writeln!(text, "\n/// Fraction bits: {}.", title(set));
        let _ = writeln!(text, "pub const SMOOTHER{i}_FRACTION_BITS: u32 = {};", set.quantised.frac_bits);
        if let Some(lerp) = &set.quantised.lerp {
            let _ = writeln!(text, "/// Stages of the look-ahead.");
            let _ = writeln!(text, "pub const SMOOTHER{i}_LOOK_AHEAD: u32 = {};", lerp.look_ahead);
        }
        for word in set.words() {
            let _ = writeln!(text, "/// {:.9}: {}.", value(set, &word), word.meaning);
            let _ = writeln!(text, "pub const SMOOTHER{i}_{}: {kind} = {};", word.name, word.raw);
        }
    }
    text
}

/// Writes Markdown tables.
pub fn markdown(sets: &[CoefficientSet], command: &str) -> String {
    let mut text = format!(
        "# Filter coefficients\n\nWritten by `{command}`.\n\n\
         Approximation: the unquantised filter against the sampled Gaussian of its sigma.\n\n\
         | sigma, px | method | order | fit | parameter | effective sigma, px | l2 error, % | \
         largest error, % of peak |\n\
         |---|---|---|---|---|---|---|---|\n"
    );
    for set in sets {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} = {:.6} | {:.4} | {:.3} | {:.3} |",
            set.sigma,
            set.method,
            set.order,
            set.fit,
            set.parameter.name,
            set.parameter.value,
            set.sigma_eff,
            100.0 * set.l2,
            100.0 * set.linf
        );
    }
    text += "\nQuantisation: the raw coefficients against the unquantised filter.\n\n\
             | sigma, px | form | fraction bits | effective sigma, px | l2 error, % | DC gain |\n\
             |---|---|---|---|---|---|\n";
    for set in sets {
        let q = &set.quantised;
        let mut row = |form: String, sigma_eff: f64, l2: f64, dc: f64| {
            let _ = writeln!(
                text,
                "| {} | {form} | {} | {sigma_eff:.5} | {:.5} | {dc} |",
                set.sigma,
                q.frac_bits,
                100.0 * l2
            );
        };
        row("direct".to_owned(), q.sigma_eff, q.l2, q.dc_gain);
        if let Some(lerp) = &q.lerp {
            // Exactly 1 by construction: every stage is y = p + c (q - p).
            row(
                format!("lerp, vertical, look-ahead {}", lerp.look_ahead),
                lerp.columns.sigma_eff,
                lerp.columns.l2,
                1.0,
            );
            row(format!("lerp, horizontal, look-ahead {}", lerp.look_ahead), lerp.rows.sigma_eff, lerp.rows.l2, 1.0);
        }
    }
    for (i, set) in sets.iter().enumerate() {
        let _ =
            writeln!(text, "\n## Smoother {i}: {}\n\n| name | raw | value | meaning |\n|---|---|---|---|", title(set));
        for word in set.words() {
            let _ = writeln!(text, "| `{}` | {} | {:.9} | {} |", word.name, word.raw, value(set, &word), word.meaning);
        }
    }
    text
}
