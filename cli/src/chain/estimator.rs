//! The flight program, in this process or as the ARM binary under qemu: messages in, one line per frame out.

use std::io::{BufRead as _, BufReader, ErrorKind, Lines, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use hoverlock_arm::framing::Decoder;
use hoverlock_arm::hardware::Fpga;
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

impl Program {
    /// Whether it can be had, before anything is computed.
    pub fn find(self) -> Result<()> {
        (self == Self::Arm).then(binary).transpose().map(|_| ())
    }
}

/// The flight program's code in this process.
pub struct Host {
    decoder: Decoder,
    navigator: Navigator,
}

impl Host {
    /// For an FPGA.
    pub fn of(fpga: Fpga) -> Self {
        Self { decoder: Decoder::default(), navigator: Navigator::for_fpga(fpga) }
    }

    /// Takes a message; the lines that it completes.
    pub fn take(&mut self, message: &[u8]) -> Result<Vec<String>> {
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
        Ok(lines)
    }

    /// The pairs that the last estimate was made of.
    pub fn inliers(&self) -> &[Pair] {
        self.navigator.inliers()
    }

    /// The word that has become due for the camera, once.
    pub fn camera_word(&mut self) -> Result<Option<u32>> {
        Ok(self.navigator.camera_word()?)
    }
}

/// The ARM binary, in progress.
pub struct Arm {
    child: Child,
    stdin: Option<ChildStdin>,
    lines: Lines<BufReader<ChildStdout>>,
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
        let stdout = child.stdout.take().ok_or_else(|| anyhow!("--estimator arm: no pipe from the flight program"))?;
        Ok(Self { stdin: child.stdin.take(), child, lines: BufReader::new(stdout).lines() })
    }

    /// Sends a message, of which it makes no line.
    pub fn send(&mut self, message: &[u8]) -> Result<()> {
        match self.stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(message)) {
            // It has ended, and tells why.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => self.failed(),
            other => other.context("--estimator arm: the flight program takes no more messages"),
        }
    }

    /// The next line that it writes.
    pub fn line(&mut self) -> Result<String> {
        match self.lines.next() {
            Some(line) => line.context("--estimator arm: the flight program's lines cannot be read"),
            None => Err(self.failed().err().unwrap_or_else(|| anyhow!("--estimator arm: a line is missing"))),
        }
    }

    /// Why it has ended: its last words.
    fn failed(&mut self) -> Result<()> {
        drop(self.stdin.take());
        let status = self.child.wait().context("--estimator arm: the flight program is lost")?;
        let mut said = String::new();
        if let Some(stderr) = &mut self.child.stderr {
            stderr.read_to_string(&mut said).context("--estimator arm: the flight program's words cannot be read")?;
        }
        let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it says nothing");
        bail!("--estimator arm: the flight program has failed ({status}): {last}");
    }
}

impl Drop for Arm {
    fn drop(&mut self) {
        // The end of the stream ends the program; a status that nobody waits for would leave a zombie.
        drop(self.stdin.take());
        let _ = self.child.wait();
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
