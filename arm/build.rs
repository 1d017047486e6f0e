//! What the hardware's read-only registers say, taken from the committed Verilog, so that program and hardware cannot
//! disagree unnoticed.

use std::path::Path;
use std::{env, fs};

/// Wires of the register block with a constant value, and the names they get here.
const WIRES: [(&str, &str); 3] =
    [("identification_letters", "IDENTIFICATION"), ("version_number", "VERSION"), ("emission_hash", "EMISSION")];

fn main() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rtl/verilog/csr.v");
    println!("cargo::rerun-if-changed={}", source.display());
    let verilog = fs::read_to_string(&source).unwrap_or_else(|error| panic!("{}: {error}", source.display()));
    let mut constants = String::new();
    for (wire, name) in WIRES {
        let value = constant(&verilog, wire)
            .unwrap_or_else(|| panic!("{}: no line `wire [31:0] {wire} = 32'h..;`", source.display()));
        constants += &format!("/// What `{wire}` reads.\npub const {name}: u32 = 0x{value:08x};\n");
    }
    let folder = env::var_os("OUT_DIR").expect("cargo gives build scripts an OUT_DIR");
    fs::write(Path::new(&folder).join("hardware.rs"), constants).expect("OUT_DIR can be written");
}

fn constant(verilog: &str, wire: &str) -> Option<u32> {
    let digits = verilog.split_once(&format!("wire [31:0] {wire} = 32'h"))?.1.split_once(';')?.0;
    u32::from_str_radix(digits, 16).ok()
}
