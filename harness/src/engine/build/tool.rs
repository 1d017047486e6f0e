//! The programs that a build runs: Verilator and the C++ compiler.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::UNIX_EPOCH;

use crate::engine::error::BuildError;

/// The oldest version that can be used: 5.000 changed the scheduler, 5.002 mended its first faults.
pub const OLDEST_USABLE: (u32, u32) = (5, 2);
/// The newest version that this harness was tested with. Any other must pass a trial.
const NEWEST_KNOWN: (u32, u32) = (5, 20);
/// The first version that describes the design as JSON; the description as XML went some versions later.
const FIRST_WITH_JSON: (u32, u32) = (5, 24);

/// An installation of Verilator.
#[derive(Debug, Clone)]
pub struct Verilator {
    /// The program.
    pub path: PathBuf,
}

/// The version that a Verilator reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Version {
    /// As it is printed in messages.
    pub text: String,
    /// Major and minor number; `None` if the text has none.
    pub number: Option<(u32, u32)>,
}

impl Version {
    /// Returns `true` if the harness was tested with this version; any other is tried before its first use.
    pub fn is_known(&self) -> bool {
        self.number.is_some_and(|number| (OLDEST_USABLE..=NEWEST_KNOWN).contains(&number))
    }

    /// Returns `true` if this version describes a design as JSON instead of XML.
    pub fn has_json(&self) -> bool {
        self.number.is_none_or(|number| number >= FIRST_WITH_JSON)
    }
}

/// Returns major and minor number of a text like `5.006`.
fn number_in(text: &str) -> Option<(u32, u32)> {
    let (major, minor) = text.split_once('.')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

impl Verilator {
    /// Finds `$VERILATOR`, or `verilator` on the path.
    pub fn find(asked: Option<&Path>) -> Result<Verilator, BuildError> {
        let name = match asked {
            Some(path) => path.to_owned(),
            None => std::env::var_os("VERILATOR").map_or_else(|| PathBuf::from("verilator"), PathBuf::from),
        };
        let path = find_program(&name).ok_or_else(|| BuildError::ToolMissing {
            tool: name.display().to_string(),
            hint: "install it (Debian: apt-get install verilator) or set VERILATOR to its path".into(),
        })?;
        Ok(Verilator { path })
    }

    /// Returns the program's version, or an error if it is too old.
    pub fn version(&self) -> Result<Version, BuildError> {
        let output = run(Command::new(&self.path).arg("--version"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let mut words = text.split_whitespace();
        let said = words.next().zip(words.next()).filter(|(product, _)| *product == "Verilator");
        let version = match said {
            Some((_, number)) => Version { text: number.to_owned(), number: number_in(number) },
            // Builds from a tree without a history, such as PyPI's, have the number in a header only.
            None => {
                let header = self.root().and_then(|root| {
                    let path = root.join("include/verilated_config.h");
                    std::fs::read_to_string(&path).map_err(|source| BuildError::Source { path, source })
                });
                let line = header.unwrap_or_default();
                let quoted =
                    line.lines().find_map(|l| l.strip_prefix("#define VERILATOR_VERSION \"")?.split('"').next());
                let number = quoted.and_then(|q| number_in(q.split_whitespace().next()?));
                let text = format!("{} ({})", quoted.unwrap_or("of unknown version"), text.trim());
                Version { text, number }
            }
        };
        match version.number {
            Some(number) if number < OLDEST_USABLE => Err(BuildError::VersionUnsupported {
                found: version.text,
                path: self.path.clone(),
                reason: format!("{}.{:03} or newer is needed", OLDEST_USABLE.0, OLDEST_USABLE.1),
            }),
            _ => Ok(version),
        }
    }

    /// Returns the folder with `include/verilated.h`: the one that the program reports, else the one that contains the
    /// program.
    pub fn root(&self) -> Result<PathBuf, BuildError> {
        let output = run(Command::new(&self.path).args(["--getenv", "VERILATOR_ROOT"]))?;
        let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        let real = self.path.canonicalize().unwrap_or_else(|_| self.path.clone());
        let around = real.parent().and_then(Path::parent).map(Path::to_owned).filter(|_| said.is_empty());
        let root = around.unwrap_or_else(|| PathBuf::from(&said));
        if root.join("include/verilated.h").is_file() {
            Ok(root)
        } else {
            Err(BuildError::ToolMissing {
                tool: "verilated.h".into(),
                hint: match said.as_str() {
                    "" => format!(
                        "{} --getenv VERILATOR_ROOT names no folder, so this installation is broken: install \
                         Verilator again",
                        self.path.display()
                    ),
                    _ => format!("{} is not the root of a complete Verilator: install it again", root.display()),
                },
            })
        }
    }
}

/// Finds `$CXX`, `g++` or `clang++`, in this order.
pub fn find_compiler() -> Result<PathBuf, BuildError> {
    if let Some(asked) = std::env::var_os("CXX").filter(|c| !c.is_empty()) {
        return find_program(Path::new(&asked)).ok_or_else(|| BuildError::ToolMissing {
            tool: asked.to_string_lossy().into_owned(),
            hint: "CXX names a C++ compiler that does not exist".into(),
        });
    }
    ["g++", "clang++"].iter().find_map(|name| find_program(Path::new(name))).ok_or_else(|| BuildError::ToolMissing {
        tool: "g++".into(),
        hint: "install a C++ compiler (Debian: apt-get install g++) or set CXX".into(),
    })
}

/// Returns path, size and modification time of a program, which identify an installation without running it.
pub fn fingerprint(program: &Path) -> String {
    let real = program.canonicalize().unwrap_or_else(|_| program.to_owned());
    let stamp = std::fs::metadata(&real).ok().map(|m| {
        let changed = m.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok()).map_or(0, |d| d.as_nanos());
        (m.len(), changed)
    });
    // Verilator is a script beside the real program.
    let beside = real.with_file_name("verilator_bin");
    let inner = if real.file_name() == Some(OsStr::new("verilator")) && beside.exists() {
        fingerprint(&beside)
    } else {
        String::new()
    };
    format!("{} {stamp:?} {inner}", real.display())
}

/// Runs a program and collects its output.
pub fn run(command: &mut Command) -> Result<Output, BuildError> {
    command
        .stdin(std::process::Stdio::null())
        .output()
        .map_err(|source| BuildError::Spawn { program: command.get_program().to_string_lossy().into_owned(), source })
}

fn find_program(name: &Path) -> Option<PathBuf> {
    if name.components().count() > 1 {
        return is_program(name).then(|| name.to_owned());
    }
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|candidate| is_program(candidate))
}

fn is_program(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_decides_on_description_and_trial() {
        let of = |text: &str| Version { text: text.into(), number: number_in(text) };
        assert!(of("5.006").is_known() && !of("5.006").has_json());
        assert!(!of("5.048").is_known() && of("5.048").has_json());
        assert!(!of("5.022").is_known() && !of("5.022").has_json());
        assert!(!of("devel").is_known() && of("devel").has_json());
    }
}
