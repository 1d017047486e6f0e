//! The flight program, in this process or as the ARM binary under qemu: messages in, one line per frame out.

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Output, Stdio};
use std::thread::{JoinHandle, spawn};

use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use hoverlock_arm::framing::Decoder;
use hoverlock_arm::navigator::Navigator;
use hoverlock_reference::motion::model::Pair;

/// Names the ARM binary, in place of that of `make arm`.
const VARIABLE: &str = "HOVERLOCK_NAV";

/// The binary of `make arm` in the target folder.
const BINARY: &str = "arm/armv7-unknown-linux-gnueabihf/release/hoverlock-nav";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Program {
    /// The flight program's code in this process
    Host,
    /// Its ARM binary under qemu-arm, a Cortex-A9, fed through a pipe; its lines are compared with the host's
    Arm,
}

/// The flight program's code in this process.
#[derive(Default)]
pub struct Host {
    decoder: Decoder,
    navigator: Navigator,
}

/// A line, and the pairs of which its estimate was made.
pub struct Written {
    pub line: String,
    pub inliers: Vec<Pair>,
}

impl Host {
    /// Takes a message; the lines that it completes.
    pub fn take(&mut self, message: &[u8]) -> Result<Vec<Written>> {
        let mut rest = message;
        let mut lines = Vec::new();
        while !rest.is_empty() {
            self.decoder.read(&mut rest)?;
            while let Some(raw) = self.decoder.message() {
                self.navigator.take(&raw, &mut |line| {
                    let mut text = Vec::new();
                    line.write(&mut text);
                    lines.push(String::from_utf8_lossy(text.trim_ascii_end()).into_owned());
                })?;
            }
        }
        let inliers = self.navigator.inliers();
        Ok(lines.into_iter().map(|line| Written { line, inliers: inliers.to_vec() }).collect())
    }
}

/// The ARM binary, in progress.
pub struct Arm {
    stdin: ChildStdin,
    end: JoinHandle<std::io::Result<Output>>,
}

impl Arm {
    /// Starts it.
    pub fn start() -> Result<Self> {
        let binary = binary()?;
        let child = Command::new("qemu-arm")
            .args(["-cpu", "cortex-a9"])
            .arg(&binary)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = match child {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!("--estimator arm: qemu-arm is not installed; `make arm` installs it")
            }
            child => child.context("--estimator arm: qemu-arm cannot be run")?,
        };
        let stdin = child.stdin.take().ok_or_else(|| anyhow!("--estimator arm: no pipe to the flight program"))?;
        Ok(Self { stdin, end: spawn(|| child.wait_with_output()) })
    }

    /// Sends a message. Why the program has ended, if it has, is told at the end.
    pub fn send(&mut self, message: &[u8]) -> Result<()> {
        match self.stdin.write_all(message) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other.context("--estimator arm: the flight program takes no more messages"),
        }
    }

    /// Ends the stream; all lines.
    pub fn finish(self) -> Result<Vec<String>> {
        drop(self.stdin);
        let output = self.end.join().map_err(|_| anyhow!("the reader of the flight program has panicked"))?;
        let output = output.context("--estimator arm: the flight program's lines cannot be read")?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it says nothing");
            bail!("--estimator arm: the flight program has failed ({}): {last}", output.status);
        }
        Ok(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
    }
}

/// The ARM binary: what the variable names, or what `make arm` makes in the target folder of this command.
fn binary() -> Result<PathBuf> {
    if let Some(named) = std::env::var_os(VARIABLE).map(PathBuf::from) {
        if named.is_file() {
            return Ok(named);
        }
        bail!("--estimator arm: {VARIABLE}={}: no such file; `make arm` makes the ARM binary", named.display());
    }
    let command = std::env::current_exe().context("--estimator arm: this command's own folder is not known")?;
    let beside = command.ancestors().nth(2).map(|target| target.join(BINARY));
    let here = Path::new("target").join(BINARY);
    match beside.into_iter().chain([here.clone()]).find(|path| path.is_file()) {
        Some(path) => Ok(path),
        None => bail!(
            "--estimator arm: no ARM binary at {}; make it with `make arm`, or name it in {VARIABLE}",
            here.display()
        ),
    }
}
