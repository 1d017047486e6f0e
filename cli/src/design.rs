//! The design of a run: `--design`, changed by `--config`.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use anyhow::{Context, Result, bail};
use hoverlock_design::{DesignPoint, KT27, SHIPPED};

use crate::output::quoted;

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

impl Chosen {
    /// The design with its changes; `kt27` where none is named.
    pub fn design(&self) -> Result<DesignPoint> {
        changed(self.design.as_deref().map_or_else(|| Ok(KT27.clone()), named)?, &self.config)
    }

    /// Whether `--config` changes it.
    pub fn is_changed(&self) -> bool {
        !self.config.is_empty()
    }

    /// The options that choose it again.
    pub fn options(&self) -> String {
        let design = self.design.iter().map(|design| format!(" --design {}", quoted(Path::new(design))));
        let config = self.config.iter().map(|change| format!(" --config {}", quoted(Path::new(change))));
        design.chain(config).collect()
    }

    /// What the design is called where files are named after it.
    pub fn name(&self) -> String {
        let path = Path::new(self.design.as_deref().unwrap_or(OsStr::new(SHIPPED[0].0)));
        path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
    }
}

/// A design that is built in, or that of a file.
pub fn named(design: &OsStr) -> Result<DesignPoint> {
    if let Some(shipped) = design.to_str().and_then(DesignPoint::shipped) {
        return Ok(shipped);
    }
    let path = Path::new(design);
    if !path.exists() {
        let names = SHIPPED.map(|(name, _)| name).join(", ");
        bail!("--design {}: no such file, and no design of that name; the names are {names}", path.display());
    }
    DesignPoint::from_file(&text(path, "design")?).with_context(|| path.display().to_string())
}

/// The default design, changed by files and by single keys in the order given.
pub fn configured(changes: &[OsString]) -> Result<DesignPoint> {
    changed(KT27.clone(), changes)
}

fn changed(mut design: DesignPoint, changes: &[OsString]) -> Result<DesignPoint> {
    for change in changes {
        let path = Path::new(change);
        design = match change.to_str() {
            Some(change) if change.contains('=') && !path.exists() => design.with_override(change)?,
            _ => design.with_toml(&text(path, "configuration")?).with_context(|| path.display().to_string())?,
        };
    }
    Ok(design)
}

/// The text of a file that is a `what`.
fn text(path: &Path, what: &str) -> Result<String> {
    let name = path.display();
    // A device or a FIFO may never end.
    if path.exists() && !path.is_file() {
        bail!("{name}: the {what} is not a regular file");
    }
    std::fs::read_to_string(path).with_context(|| format!("{name}: the {what} cannot be read"))
}
