//! The design point of a run: the default, changed by `--config`.

use std::ffi::OsString;
use std::path::Path;

use anyhow::{Context, Result, bail};
use hoverlock_fixed_point::model::design::{DesignPoint, KT27};

/// The default design point, changed by files and by single keys in the order given.
pub fn configured(changes: &[OsString]) -> Result<DesignPoint> {
    let mut design = KT27;
    for change in changes {
        let path = Path::new(change);
        design = match change.to_str() {
            Some(change) if change.contains('=') && !path.exists() => design.with_override(change)?,
            _ => {
                let name = path.display();
                // A device or a FIFO may never end.
                if path.exists() && !path.is_file() {
                    bail!("{name}: the configuration is not a regular file");
                }
                let text = std::fs::read_to_string(path)
                    .with_context(|| format!("{name}: the configuration cannot be read"))?;
                design.with_toml(&text).with_context(|| name.to_string())?
            }
        };
    }
    Ok(design)
}
