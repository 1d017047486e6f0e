//! Counter-examples as lists of steps, and as tests that replay them in the Rust harness.
//!
//! `yosys-smtbmc` writes a counter-example as a test bench in Verilog: the registers of the first state, and the inputs
//! of the wrapper in each step. The test clocks this bench around the same wrapper and sources. It fails as long as the
//! property is violated.
//!
//! The replay differs from the model of the proof in two ways. Verilator does not support `hierconn`, so a copy of the
//! wrapper uses hierarchical names. Modules and products that the claim abstracts (`cut`, `cut_products`) have their
//! real values.

use std::fs;
use std::path::{Path, PathBuf};

use crate::claim::Claim;
use crate::engine::{EngineError, at_path};
use crate::library::used_by;

/// The files of a replayed counter-example.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    /// Path of the test; the Verilog that it needs is in the same folder.
    pub test: PathBuf,
    /// Inputs of the wrapper, one line per step.
    pub steps: Vec<String>,
}

/// Writes the test that replays a counter-example, with its Verilog, into a folder. `bench` is the test bench that
/// `yosys-smtbmc` has written.
///
/// # Errors
/// If a file cannot be read or written.
pub fn write(claim: &Claim, sources: &[PathBuf], bench: &Path, folder: &Path) -> Result<Replay, EngineError> {
    fs::create_dir_all(folder).map_err(at_path(folder))?;
    let folder = std::path::absolute(folder).map_err(at_path(folder))?;
    let put = |name: &str, text: &str| {
        let file = folder.join(name);
        fs::write(&file, text).map_err(at_path(&file))
    };
    let bench = fs::read_to_string(bench).map_err(at_path(bench))?;
    let steps = steps(&bench, claim);
    // The bench declares `genclock` twice where Verilator reads it.
    let once = bench.replacen("  reg genclock = 1;\n", "", 1).replacen(
        "  reg clock;\n",
        "  reg clock;\n  reg genclock = 1;\n",
        1,
    );
    put("bench.v", &once)?;
    put("properties.sv", &without_hierconn(&claim.properties))?;
    let mut names = vec!["bench.v".to_owned(), "properties.sv".to_owned()];
    for (name, text) in used_by(&claim.properties) {
        names.push(format!("{name}.sv"));
        put(&format!("{name}.sv"), &without_hierconn(text))?;
    }
    for source in sources {
        let name = source.file_name().map_or("source.v".into(), |name| name.to_string_lossy().into_owned());
        fs::copy(source, folder.join(&name)).map_err(at_path(source))?;
        names.push(name);
    }
    put("steps.txt", &(steps.join("\n") + "\n"))?;
    put("replay.rs", &test(&claim.name, &folder, &names, &steps))?;
    Ok(Replay { test: folder.join("replay.rs"), steps })
}

/// The inputs of each step of a bench: name, hexadecimal value and, where the claim has a unit, the value in it.
fn steps(bench: &str, claim: &Claim) -> Vec<String> {
    let mut steps: Vec<String> = Vec::new();
    for line in bench.lines().map(str::trim) {
        if line.starts_with("// state ") {
            steps.push(format!("step {}:", steps.len()));
        }
        let Some((step, line)) = steps.last_mut().zip(line.strip_prefix("UUT.").or(line.strip_prefix("PI_"))) else {
            continue;
        };
        let Some((name, bits)) = line.split_once('=').and_then(|(name, value)| {
            Some((name.trim_end_matches([' ', '<']), value.trim_end_matches(';').split_once("'b")?.1))
        }) else {
            continue;
        };
        *step += &format!(" {name}=0x{}", hexadecimal(bits));
        if let (Some(unit), Ok(raw)) = (claim.units.get(name), u64::from_str_radix(bits, 2)) {
            *step += &format!(" ({} {})", raw as f64 * unit.lsb, unit.unit);
        }
    }
    steps
}

/// Converts binary digits of any number into hexadecimal ones.
fn hexadecimal(bits: &str) -> String {
    let padded = format!("{}{bits}", "0".repeat((4 - bits.len() % 4) % 4));
    let digits = padded.as_bytes().chunks(4).map(|four| {
        let value = four.iter().fold(0, |value, bit| 2 * value + u32::from(*bit == b'1'));
        char::from_digit(value, 16).unwrap_or('0')
    });
    digits.collect()
}

/// Replaces `(* hierconn *) wire [3:0] \a.b ;` by `wire [3:0] \a.b = a.b;`.
fn without_hierconn(text: &str) -> String {
    let line = |line: &str| {
        let Some((before, rest)) = line.split_once("(* hierconn *)") else { return format!("{line}\n") };
        match rest.split_once('\\').and_then(|(kind, rest)| Some((kind, rest.split_once(';')?))) {
            Some((kind, (name, after))) => format!("{before}{kind}\\{} = {};{after}\n", name, name.trim()),
            None => format!("{line}\n"),
        }
    };
    text.lines().map(line).collect()
}

/// Returns the source of the test.
fn test(name: &str, folder: &Path, files: &[String], steps: &[String]) -> String {
    let listing: String = steps.iter().map(|step| format!("//! {step}\n")).collect();
    let files: String = files.iter().map(|file| format!("{file:?}, ")).collect();
    let function: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    format!(
        "//! A run that violates a property of `{name}`; it fails as long as it does. Put it into `tests/` of a\n\
         //! crate with the dependency `hoverlock-harness`.\n//!\n{listing}\n\
         use hoverlock_harness::Time;\nuse hoverlock_harness::build::Build;\nuse hoverlock_harness::sim::Sim;\n\n\
         #[test]\nfn replay_of_{function}() {{\n    \
         let folder = std::path::Path::new({folder:?});\n    \
         let files = [{}].map(|file| folder.join(file));\n    \
         let build = Build::new(\"testbench\").sources(files);\n    \
         let build = build.verilator_flag(\"-Wno-lint\").warnings_are_errors(false);\n    \
         let mut sim = Sim::new(build.compile().unwrap().instance().unwrap()).unwrap();\n    \
         let dut = sim.dut();\n    \
         dut.clock(\"clock\", Time::ns(10)).unwrap();\n    \
         let clock = dut.signal(\"clock\").unwrap();\n    \
         let outcome = sim.run(async {{\n        clock.cycles({}).await;\n        \
         Ok::<(), hoverlock_harness::Error>(())\n    }});\n    \
         assert!(outcome.is_ok(), \"{{}}\", outcome.unwrap_err());\n}}\n",
        files.trim_end_matches(", "),
        steps.len() + 1
    )
}
