//! All generated files of the RTL folder: Verilog, file list, C header, Rust constants, register table, component for
//! Platform Designer.
//!
//! | module | content |
//! |---|---|
//! | `mod` | the list of files, the register files, the hash |
//! | [`component`] | the top of the component for Platform Designer, and the files that Quartus is given |
//! | [`post_pass`] | rust-hdl's output to one readable file per module |
//! | [`parameters`] | modules with parameters, and the numbers of their instances |
//! | `headers` | the comment above each module |
//! | [`verilog`] | the Verilog of a design on the disk |
//! | [`other`] | the same files for another design than the one that this was compiled for |

pub mod component;
mod headers;
pub mod other;
pub mod parameters;
pub mod post_pass;
pub mod verilog;

use std::path::{Path, PathBuf};

use hoverlock_registers::{
    Register,
    headers::{c_header, markdown, rust_constants},
};
use rust_hdl::prelude::{Block, generate_verilog_unchecked};
use sha2::{Digest, Sha256};

use self::{
    headers::header,
    post_pass::{EmissionError, Module, readable},
};
use crate::{cells::family, design::compiled, registers::registers, top::Top};
use hoverlock_design::{DesignPoint, Unbuildable};
use hoverlock_fixed_point::model::coefficients::CoefficientError;

/// A generated file.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct File {
    /// Path below `rtl/`, separated by `/`.
    pub path: String,
    /// Content.
    pub text: String,
}

impl File {
    /// Returns the name of the file below `verilog/`, if it is a module of `hoverlock_top`.
    pub fn module(&self) -> Option<&str> {
        self.path.strip_prefix("verilog/").filter(|name| name.ends_with(".v"))
    }
}

/// An error of the emission.
#[derive(Debug, thiserror::Error)]
pub enum EmitError {
    /// The Verilog printed by rust-hdl breaks the conventions.
    #[error(transparent)]
    Emission(#[from] EmissionError),
    /// The design point has no coefficients.
    #[error(transparent)]
    Coefficients(#[from] CoefficientError),
    /// The hardware has no such design.
    #[error(transparent)]
    Unbuildable(#[from] Unbuildable),
    /// A folder without Verilog.
    #[error("{}: no Verilog file (*.v) in this folder", .0.display())]
    NoVerilog(PathBuf),
    /// There is no cache folder.
    #[error(transparent)]
    Cache(#[from] hoverlock_cache::NoCacheFolder),
    /// The Verilog cannot be put where tools read it.
    #[error("cannot write the Verilog to {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The emitter of another design cannot be built or run.
    #[error(transparent)]
    Other(#[from] other::OtherError),
}

/// The command that writes the generated files again.
pub const MEND: &str = "hoverlock rtl emit";

/// Path of the Rust constants below the emission's folder.
const RUST_CONSTANTS: &str = "registers/hoverlock_registers.rs";

/// Returns where the project keeps an emitted file of the default design, relative to its top folder: in `rtl/`, except
/// the Rust constants, which are a module of the crate `hoverlock-registers`.
pub fn project_path(path: &str) -> PathBuf {
    if path == RUST_CONSTANTS { "registers/src/kt27.rs".into() } else { Path::new("rtl").join(path) }
}

/// Returns all generated files of the design that the emitter was compiled for.
///
/// # Errors
/// If the sources have an error.
pub fn files() -> Result<Vec<File>, EmitError> {
    compiled().check_buildable()?;
    let hash = emission()?;
    let mut files: Vec<File> = Vec::new();
    let modules = modules(hash)?;
    for module in &modules {
        // The file of a family begins with its comment.
        let comment = if family(&module.name).is_some() { String::new() } else { header(&module.name) };
        files.push(File {
            path: format!("verilog/{}.v", module.name),
            text: verilog_file(&format!("{comment}{}", module.text)),
        });
    }
    // rust-hdl prints a module after those it is made of.
    let list: Vec<String> = modules.iter().map(|module| format!("{}.v\n", module.name)).collect();
    files.push(File { path: "verilog/hoverlock.f".into(), text: format!("{}\n{}", banner("//"), list.concat()) });
    let mut map = registers(&compiled())?;
    // The hash covers the Verilog, so it is known only now.
    for register in map.iter_mut().filter(|register| register.name == "emission") {
        register.fields.iter_mut().for_each(|field| field.reset = hash);
    }
    files.extend(register_files(&map));
    files.extend(component::files(&compiled()));
    Ok(files)
}

/// Returns all generated files of a design: emitted here if the emitter was compiled for it, else by
/// [`other::files`].
///
/// # Errors
/// If the design cannot be built, or its emitter cannot.
pub fn files_of(design: &DesignPoint) -> Result<Vec<File>, EmitError> {
    design.check_buildable()?;
    let design = &design.of_hardware();
    if *design == compiled() { files() } else { Ok(other::files(design)?) }
}

/// Returns the committed Verilog files of the project that this was built in, sorted; `None` if that folder no longer
/// exists.
pub fn committed() -> Option<Vec<PathBuf>> {
    verilog_in(&Path::new(env!("CARGO_MANIFEST_DIR")).join("verilog"))
}

/// Returns the Verilog files of a folder, sorted by name; `None` if there are none.
pub fn verilog_in(folder: &Path) -> Option<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).ok()?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<_> = paths.filter(|path| path.extension().is_some_and(|extension| extension == "v")).collect();
    files.sort();
    (!files.is_empty()).then_some(files)
}

/// Returns the modules, with `hash` in the `emission` register.
///
/// # Errors
/// If the sources have an error.
pub fn modules(hash: u32) -> Result<Vec<Module>, EmitError> {
    let mut top = Top::new(hash)?;
    top.connect_all();
    Ok(readable(&generate_verilog_unchecked(&top))?)
}

/// Returns the hash that the hardware's `emission` register shows.
///
/// # Errors
/// If the sources have an error.
pub fn emission() -> Result<u32, EmitError> {
    Ok(hash(&modules(0)?))
}

/// Returns the hash of a design.
///
/// # Errors
/// As [`files_of`].
pub fn emission_of(design: &DesignPoint) -> Result<u32, EmitError> {
    if design.of_hardware() == compiled() {
        return emission();
    }
    // Its header has it.
    let value = |file: &File| {
        let line = file.text.lines().find_map(|line| line.strip_prefix("pub const EMISSION_VALUE: u32 = 0x"))?;
        u32::from_str_radix(line.strip_suffix(';')?, 16).ok()
    };
    let found = files_of(design)?.iter().find_map(value);
    found.ok_or_else(|| other::OtherError::Fails("its constants have no EMISSION_VALUE".into()).into())
}

fn hash(modules: &[Module]) -> u32 {
    let mut digest = Sha256::new();
    modules.iter().for_each(|module| digest.update(module.text.as_bytes()));
    digest.finalize().iter().take(4).fold(0, |hash, byte| hash << 8 | u32::from(*byte))
}

/// A module as a file: a name that is not declared is an error in it, and not a wire.
fn verilog_file(module: &str) -> String {
    format!("{}\n`default_nettype none\n\n{module}\n`default_nettype wire\n", banner("//"))
}

fn banner(comment: &str) -> String {
    format!(
        "{comment} SPDX-License-Identifier: MIT OR Apache-2.0\n\
         {comment} Generated by `{MEND}` from the Rust sources in rtl/src. Do not edit.\n"
    )
}

/// Returns the register map as C header, Rust constants and Markdown.
fn register_files(map: &[Register]) -> [File; 3] {
    let markdown_banner =
        format!("<!-- SPDX-License-Identifier: MIT OR Apache-2.0 -->\n<!-- Generated by `{MEND}`. Do not edit. -->\n");
    [
        ("registers/hoverlock_registers.h", c_header(map, &banner("//"))),
        (RUST_CONSTANTS, rust_constants(map, &banner("//"))),
        ("registers/REGISTERS.md", markdown(map, &markdown_banner)),
    ]
    .map(|(path, text)| File { path: path.into(), text })
}
