//! The register map as C header, Rust constants and Markdown.
//!
//! `banner` is the beginning of the file: licence, and by what it is generated.

use crate::{Access, Field, Register};

/// Text of the Markdown file between the banner and the rows of the table.
const INTRODUCTION: &str = include_str!("introduction.md");

/// Returns the register map as a table in Markdown.
pub fn markdown(map: &[Register], banner: &str) -> String {
    let mut text = format!("{banner}\n{INTRODUCTION}");
    for register in map {
        for (i, field) in register.fields.iter().enumerate() {
            let (address, name) = if i == 0 {
                (format!("0x{:02x}", register.offset), register.name.as_str())
            } else {
                Default::default()
            };
            let bits = match field.bits {
                1 => field.low.to_string(),
                _ => format!("{}:{}", field.low + field.bits - 1, field.low),
            };
            text += &format!(
                "| {address} | {name} | {bits} | {} | {} | {} | {} |\n",
                field.name,
                rights(field.access),
                reset(field),
                field.description
            );
        }
    }
    text
}

/// Returns the byte offsets, shifts and masks as a C header.
pub fn c_header(map: &[Register], banner: &str) -> String {
    let mut text = format!("{banner}\n#ifndef HOVERLOCK_REGISTERS_H\n#define HOVERLOCK_REGISTERS_H\n\n");
    for register in map {
        let name = register.name.to_uppercase();
        text += &format!("#define HOVERLOCK_{name} 0x{:02x}u\n", register.offset);
        if let Some(value) = fixed_value(register) {
            text += &format!("#define HOVERLOCK_{name}_VALUE 0x{value:08x}u // what it reads\n");
        }
        for field in &register.fields {
            let (field_name, mask) = (field.name.to_uppercase(), field.mask());
            text += &format!("#define HOVERLOCK_{name}_{field_name}_SHIFT {}\n", field.low);
            text += &format!("#define HOVERLOCK_{name}_{field_name}_MASK 0x{mask:08x}u // {}\n", field.description);
        }
    }
    text + "\n#endif\n"
}

/// Returns the byte offsets and masks as Rust constants.
pub fn rust_constants(map: &[Register], banner: &str) -> String {
    let mut text = format!("{banner}\n//! Byte addresses and masks of the registers.\n\n");
    for register in map {
        let name = register.name.to_uppercase();
        text +=
            &format!("/// Byte address of `{}`.\npub const {name}: u32 = 0x{:02x};\n", register.name, register.offset);
        if let Some(value) = fixed_value(register) {
            text += &format!(
                "/// What `{}` reads in this hardware.\npub const {name}_VALUE: u32 = 0x{value:08x};\n",
                register.name
            );
        }
        for field in &register.fields {
            text += &format!(
                "/// Mask of `{}`: {} ({}).\npub const {name}_{}: u32 = 0x{:08x};\n",
                field.name,
                field.description,
                rights(field.access),
                field.name.to_uppercase(),
                field.mask()
            );
        }
    }
    let coefficients: Vec<_> = map.iter().filter(|register| register.is_coefficient()).collect();
    text += &format!(
        "/// Byte address and value of each coefficient of the design point.\n\
         pub const COEFFICIENTS: [(u32, u32); {}] = [\n",
        coefficients.len()
    );
    for register in coefficients {
        text += &format!("    ({}, {}),\n", register.name.to_uppercase(), register.reset());
    }
    text + "];\n"
}

fn rights(access: Access) -> &'static str {
    match access {
        Access::Read => "read",
        Access::ReadWrite => "read, write",
        Access::Clear => "write 1 to clear",
        Access::Pulse => "write 1",
        Access::Request => "write 1 to set",
    }
}

/// Returns a single bit as a digit, a number in hex with all digits of its field.
fn reset(field: &Field) -> String {
    match field.bits {
        1 => field.reset.to_string(),
        bits => format!("0x{:0digits$x}", field.reset, digits = bits.div_ceil(4) as usize),
    }
}

/// Returns the value of a register that never changes, by which software identifies the hardware; `None` for others.
fn fixed_value(register: &Register) -> Option<u32> {
    match &register.fields[..] {
        [Field { access: Access::Read, bits: 32, reset, .. }] if *reset != 0 => Some(*reset),
        _ => None,
    }
}
