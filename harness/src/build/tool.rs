//! The programs that a build runs: Verilator and the C++ compiler.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::UNIX_EPOCH;

use crate::error::BuildError;

/// The versions this harness was tested with; 5.000 changed the scheduler, 5.022 dropped `--xml-only`'s form.
pub const SUPPORTED: &str = "5.002 to 5.020";

/// Verilator and where its headers are.
#[derive(Debug, Clone)]
pub struct Verilator {
    /// The program.
    pub path: PathBuf,
}

impl Verilator {
    /// `$VERILATOR`, or `verilator` on the path.
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

    /// The program's version; an error if it is not a supported one.
    pub fn check_version(&self) -> Result<String, BuildError> {
        let output = run(Command::new(&self.path).arg("--version"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let version = text.split_whitespace().nth(1).unwrap_or("?").to_owned();
        let number =
            version.split_once('.').and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)));
        match number {
            Some((5u32, minor)) if (2u32..=20).contains(&minor) => Ok(version),
            _ => Err(BuildError::VersionUnsupported { found: version, path: self.path.clone(), supported: SUPPORTED }),
        }
    }

    /// The folder with `include/verilated.h`.
    pub fn root(&self) -> Result<PathBuf, BuildError> {
        let output = run(Command::new(&self.path).args(["--getenv", "VERILATOR_ROOT"]))?;
        let root = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
        if root.join("include/verilated.h").is_file() {
            Ok(root)
        } else {
            Err(BuildError::ToolMissing {
                tool: "verilated.h".into(),
                hint: match root.to_str() {
                    Some("") => format!(
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

/// `$CXX`, `g++` or `clang++`.
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

/// Distinguishes installations of a program without running it: path, size and time of change.
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
