//! From a design file to the constants and the wiring that depend on it.
//!
//! rust-hdl has widths in its types, so the emitter is compiled for a design: `HOVERLOCK_DESIGN` names the design file,
//! the default design if it is not set. Four files are written for `include!` and `include_str!`:
//!
//! - `design.toml`: the design file itself;
//! - `design.rs`: the numbers of the file as plain constants;
//! - `smoothers.rs`: a smoother type for each look-ahead, and the smoothers with the delays that align them;
//! - `extractor.rs`: which smoothers each scale pair subtracts.
//!
//! A `#[hdl_gen]` body can depend on numbers only. The number of smoothers and of delays changes the fields and the
//! wiring, so both are generated.

mod smoothers;

use std::error::Error;
use std::path::{Path, PathBuf};

use hoverlock_design::{DesignPoint, KEYS, KT27, KeyValue, MAX_RING_RADIUS, Protection, smoother_names};

fn main() {
    if let Err(error) = run() {
        eprintln!("the design file: {error}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=HOVERLOCK_DESIGN");
    let design = match std::env::var_os("HOVERLOCK_DESIGN").filter(|path| !path.is_empty()) {
        Some(path) => {
            // Cargo runs a build script in the folder of its package; a name is relative to the workspace.
            let path = &Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
            println!("cargo:rerun-if-changed={}", path.display());
            let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
            DesignPoint::from_file(&text)?
        }
        None => KT27.clone(),
    };
    design.check_buildable()?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("design.toml"), design.to_toml())?;
    std::fs::write(out.join("design.rs"), constants(&design))?;
    std::fs::write(out.join("smoothers.rs"), smoothers::module(&design))?;
    std::fs::write(out.join("extractor.rs"), extractor(&design))?;
    Ok(())
}

/// Returns the constants of a design in Rust: `WIDTH` for the key `width`, `STATE_BITS` and `STATE_FRACTION_BITS` for
/// the format `state`, an array for a list of whole numbers. `KEY_CONSTANTS` lists the numbers with their names.
fn constants(design: &DesignPoint) -> String {
    let mut text = String::new();
    let mut names = Vec::new();
    for key in &KEYS {
        let name = key.name.to_uppercase();
        let mut number = |name: String, meaning: &str, unit: &str, value: u32| {
            text += &format!("/// {meaning} Unit: {unit}.\npub const {name}: usize = {value};\n");
            names.push(name);
        };
        match key.value(design) {
            KeyValue::Whole(value) => number(name, key.meaning, key.unit, value),
            KeyValue::Format(format) => {
                number(format!("{name}_BITS"), key.meaning, "bits", format.bits());
                let fraction_bits = format.fraction_bits().unsigned_abs().into();
                number(format!("{name}_FRACTION_BITS"), key.meaning, "bits after the point", fraction_bits);
            }
            KeyValue::Wholes(values) => {
                let (meaning, unit, length) = (key.meaning, key.unit, values.len());
                text += &format!("/// {meaning} Unit: {unit}.\npub const {name}: [usize; {length}] = {values:?};\n");
            }
            // The hardware has no numbers with a point, and one smoother.
            KeyValue::Reals(_) | KeyValue::Name(_) => {}
        }
    }
    let parity = u32::from(design.protection == Protection::Parity);
    text += &format!(
        "/// Parity bits of a sample in a block memory, and flags of an upset that a module outputs: 1 in a protected \
         design, else 0.\npub const PARITY: usize = {parity};\n"
    );
    names.push("PARITY".into());
    let pairs: Vec<String> = names.iter().map(|name| format!("(\"{name}\", {name})")).collect();
    text + &format!(
        "/// The numbers of the design file with their names.\npub const KEY_CONSTANTS: &[(&str, usize)] = &[{}];\n",
        pairs.join(", ")
    )
}

/// Returns the call of the macro that wires the module `extractor`: the scale pairs with their smoothers, then those
/// whose ring does not reach the newest row, then those whose ring does.
fn extractor(design: &DesignPoint) -> String {
    let pairs = smoother_names(design.smoothers()).windows(2).enumerate();
    let smoothers: Vec<String> =
        pairs.map(|(k, pair)| format!("{k} {} {} THRESHOLD_{k}_AT", pair[0], pair[1])).collect();
    let (wide, narrow): (Vec<usize>, Vec<usize>) =
        (0..smoothers.len()).partition(|k| design.ring_radii[*k] == MAX_RING_RADIUS);
    let wide: Vec<String> = wide.iter().map(|k| format!("{k} ring_lines_{k} ring_rows_{k}")).collect();
    let narrow: Vec<String> = narrow.iter().map(|k| format!("{k} ring_lines_{k}")).collect();
    format!("extractor!([{}] [{}] [{}]);\n", smoothers.join(", "), narrow.join(", "), wide.join(", "))
}
