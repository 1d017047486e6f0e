//! The design of a run: `--design`, changed by `--config`.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use hoverlock_design::{DesignPoint, KT27, SHIPPED};
use hoverlock_fixed_point::model::design::{other_smoother, short_look_aheads};
use hoverlock_rtl::emission::verilog::verilog;
use hoverlock_rtl::emission::{File, files_of};

use crate::output::{quoted, say, shown};
use crate::progress::spinning;

/// The arguments that choose a design.
#[derive(clap::Args)]
pub struct Chosen {
    /// The design: kt27, hd1080, small, three_scales, or a design file with all keys
    #[arg(long, value_name = "NAME|FILE")]
    design: Option<OsString>,
    /// Change the design: a TOML file with some keys, or one key like dog_bits=12 or state=u16.4
    #[arg(long, value_name = "FILE|KEY=VALUE")]
    config: Vec<OsString>,
}

/// Returns the emitted files of a design. For a design other than the default the emitter is compiled the first time.
///
/// # Errors
/// If the design cannot be built, or its emitter cannot.
pub fn emitted(design: &DesignPoint) -> Result<Vec<File>> {
    if design.of_hardware() == *KT27 {
        return Ok(files_of(design)?);
    }
    Ok(spinning("compiling the emitter for the design (once; later runs find what it emits)", || files_of(design))?)
}

/// Returns the Verilog files of a design, or those of `folder`. For a design other than the default the emitter is
/// compiled the first time. Says on stderr if they are not those of the current folder, which has its own.
///
/// # Errors
/// If the design cannot be built or emitted, or the folder has no Verilog.
pub fn verilog_of(design: &DesignPoint, folder: Option<&Path>) -> Result<Vec<PathBuf>> {
    if folder.is_some() {
        return Ok(verilog(design, folder)?);
    }
    emitted(design)?;
    let files = verilog(design, None)?;
    let folder = files.first().and_then(|file| file.parent()).filter(|_| *design == *KT27);
    if let Some(folder) = folder.filter(|folder| is_other_checkout(folder)) {
        say(&format!(
            "the Verilog is that of {}, where this command was built; --rtl rtl/verilog takes that of this folder",
            shown(folder)
        ));
    }
    Ok(files)
}

/// Returns `true` if the current folder has committed Verilog of its own, in another place than `folder`.
fn is_other_checkout(folder: &Path) -> bool {
    let canonical = |path: &Path| path.canonicalize().ok();
    canonical(Path::new("rtl/verilog")).is_some_and(|here| {
        here.join("hoverlock_top.v").exists() && canonical(folder).is_some_and(|folder| folder != here)
    })
}

impl Chosen {
    /// Returns the design with its changes; `kt27` if none is named. Says on stderr if a sigma is too large for its
    /// look-ahead, and what another smoother does not change.
    pub fn design(&self) -> Result<DesignPoint> {
        let design = self
            .design
            .as_deref()
            .map_or_else(|| Ok(KT27.clone()), |name| DesignPoint::load(name).context("--design"))?;
        let design = design.with_changes(&self.config).context("--config")?;
        short_look_aheads(&design).iter().chain(&other_smoother(&design)).for_each(|remark| say(remark));
        Ok(design)
    }

    /// Returns the options that choose the design again.
    pub fn options(&self) -> String {
        let design = self.design.iter().map(|design| format!(" --design {}", quoted(Path::new(design))));
        design.collect::<String>() + &self.changes()
    }

    /// Returns the options that change the design.
    fn changes(&self) -> String {
        self.config.iter().map(|change| format!(" --config {}", quoted(Path::new(change)))).collect()
    }

    /// Returns the name of the design for folders that are named after it.
    pub fn name(&self) -> String {
        let path = Path::new(self.design.as_deref().unwrap_or(OsStr::new(SHIPPED[0].0)));
        path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
    }

    /// Returns the name of the design and its changes.
    pub fn described(&self) -> String {
        self.name() + &self.changes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_design_is_described_with_its_changes() {
        let config = vec!["dog_bits=14".into(), "look_ahead=[2,2,2]".into()];
        let chosen = Chosen { design: Some("designs/small.toml".into()), config };
        assert_eq!(chosen.described(), "small --config dog_bits=14 --config 'look_ahead=[2,2,2]'");
        assert_eq!(Chosen { design: None, config: Vec::new() }.described(), "kt27");
    }
}
