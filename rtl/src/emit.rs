//! Everything the RTL folder holds that is made by a program: Verilog, file list, C header, Rust constants, register table.

use std::path::{Path, PathBuf};

use rust_hdl::prelude::{Block, generate_verilog_unchecked};
use sha2::{Digest, Sha256};

use crate::{
    emission::{EmissionError, Module, readable},
    headers::header,
    registers::{Access, Register, registers},
    top::Top,
};
use hoverlock_fixed_point::model::coefficients::CoefficientError;

/// A file, its path below `rtl/`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Path, `/` between its parts.
    pub path: String,
    /// All of its text.
    pub text: String,
}

/// Why there is no emission: a fault of the sources.
#[derive(Debug, thiserror::Error)]
pub enum EmitError {
    /// The printed Verilog breaks the conventions.
    #[error(transparent)]
    Emission(#[from] EmissionError),
    /// The design point has no coefficients.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
}

/// The command that mends stale files.
pub const MEND: &str = "hoverlock rtl emit";

/// All generated files.
///
/// # Errors
/// Where the sources are at fault.
pub fn files() -> Result<Vec<File>, EmitError> {
    let hash = emission()?;
    let mut files: Vec<File> = Vec::new();
    let modules = modules(hash)?;
    for module in &modules {
        files.push(File {
            path: format!("verilog/{}.v", module.name),
            text: format!("{}\n{}{}", banner("//"), header(&module.name), module.text),
        });
    }
    let mut list: Vec<String> = modules.iter().map(|module| format!("{}.v\n", module.name)).collect();
    list.sort();
    files.push(File { path: "verilog/hoverlock.f".into(), text: format!("{}\n{}", banner("//"), list.concat()) });
    let map = registers()?;
    files.push(File { path: "registers/hoverlock_registers.h".into(), text: c_header(&map) });
    files.push(File { path: "registers/hoverlock_registers.rs".into(), text: rust_constants(&map) });
    files.push(File { path: "registers/REGISTERS.md".into(), text: markdown(&map) });
    Ok(files)
}

/// The committed Verilog files of the project this was built in, in order; nothing where it is not there any more.
pub fn committed() -> Option<Vec<PathBuf>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("verilog");
    let entries = std::fs::read_dir(folder).ok()?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<_> = paths.filter(|path| path.extension().is_some_and(|extension| extension == "v")).collect();
    files.sort();
    (!files.is_empty()).then_some(files)
}

/// The modules with a hash in their register.
///
/// # Errors
/// Where the sources are at fault.
pub fn modules(hash: u32) -> Result<Vec<Module>, EmitError> {
    let mut top = Top::new(hash)?;
    top.connect_all();
    Ok(readable(&generate_verilog_unchecked(&top))?)
}

/// The hash that the hardware's `emission` register shows.
///
/// # Errors
/// Where the sources are at fault.
pub fn emission() -> Result<u32, EmitError> {
    Ok(hash(&modules(0)?))
}

fn hash(modules: &[Module]) -> u32 {
    let mut digest = Sha256::new();
    modules.iter().for_each(|module| digest.update(module.text.as_bytes()));
    digest.finalize().iter().take(4).fold(0, |hash, byte| hash << 8 | u32::from(*byte))
}

fn banner(comment: &str) -> String {
    format!(
        "{comment} Made by `{MEND}` from the Rust sources in rtl/src. Do not edit: the check would find it stale.\n"
    )
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

fn markdown(map: &[Register]) -> String {
    let mut text = format!(
        "<!-- Made by `{MEND}`; do not edit. -->\n\n# Registers\n\n32-bit words on an Avalon-MM slave; byte addresses.\n\n`size`, `threshold`, `target`, \
         the coefficients and `control.automatic` are a *set*. Software writes them at any time, then writes 1 to `commit`.\nThe next \
         frame that begins takes the whole set over; without a commit it keeps the set of the frame before. Writing one of these registers \
         withdraws a\ncommit that no frame has taken yet, so no frame ever takes a part of a set. After reset the values of the table are \
         committed; if they are changed and\nnot committed, the first frame has no set and is refused.\n\n\
         | address | register | bits | field | access | after reset | what it is |\n|---|---|---|---|---|---|---|\n"
    );
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
                field.reset,
                field.what
            );
        }
    }
    text
}

fn c_header(map: &[Register]) -> String {
    let mut text = format!("{}\n#ifndef HOVERLOCK_REGISTERS_H\n#define HOVERLOCK_REGISTERS_H\n\n", banner("//"));
    for register in map {
        let name = register.name.to_uppercase();
        text += &format!("#define HOVERLOCK_{name} 0x{:02x}u\n", register.offset);
        for field in &register.fields {
            let mask = ((1u64 << field.bits) - 1) << field.low;
            let field_name = field.name.to_uppercase();
            text += &format!("#define HOVERLOCK_{name}_{field_name}_SHIFT {}\n", field.low);
            text += &format!("#define HOVERLOCK_{name}_{field_name}_MASK 0x{mask:08x}u // {}\n", field.what);
        }
    }
    text + "\n#endif\n"
}

fn rust_constants(map: &[Register]) -> String {
    let mut text = format!("{}\n//! Byte addresses and masks of the registers.\n\n", banner("//"));
    for register in map {
        let name = register.name.to_uppercase();
        text +=
            &format!("/// Byte address of `{}`.\npub const {name}: u32 = 0x{:02x};\n", register.name, register.offset);
        for field in &register.fields {
            let mask = ((1u64 << field.bits) - 1) << field.low;
            text += &format!(
                "/// {} ({}).\npub const {name}_{}: u32 = 0x{mask:08x};\n",
                field.what,
                rights(field.access),
                field.name.to_uppercase()
            );
        }
    }
    text
}
