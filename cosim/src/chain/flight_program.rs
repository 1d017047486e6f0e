//! The flight program: messages in, one line per frame out. It runs in this process, or as the ARM binary under qemu.

use std::io::{BufRead as _, BufReader, ErrorKind, Lines, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use hoverlock_arm::framing::Decoder;
use hoverlock_arm::hardware::Fpga;
use hoverlock_arm::navigator::Navigator;
use hoverlock_reference::motion::model::Pair;

use super::ChainError;

/// Environment variable that names the ARM binary, in place of the one that `make arm` builds.
pub(super) const NAV_VARIABLE: &str = "HOVERLOCK_NAV";

/// The binary of `make arm`, relative to the target folder.
const BINARY: &str = "arm/armv7-unknown-linux-gnueabihf/release/hoverlock-nav";

/// The flight program in this process.
pub(super) struct Host {
    decoder: Decoder,
    navigator: Navigator,
}

impl Host {
    /// Creates the program. `fpga` is the hardware that it expects.
    pub(super) fn new(fpga: Fpga) -> Self {
        Self { decoder: Decoder::default(), navigator: Navigator::for_fpga(fpga) }
    }

    /// Processes a message and returns the lines that it completes.
    pub(super) fn process(&mut self, message: &[u8]) -> Result<Vec<String>, ChainError> {
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

    /// Returns the inliers of the last estimate.
    pub(super) fn inliers(&self) -> &[Pair] {
        self.navigator.inliers()
    }

    /// Returns the ARINC 429 word that is due for the camera, and clears it.
    pub(super) fn camera_word(&mut self) -> Result<Option<u32>, ChainError> {
        Ok(self.navigator.camera_word()?)
    }
}

/// The ARM binary in progress.
pub(super) struct Arm {
    child: Child,
    stdin: Option<ChildStdin>,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Arm {
    /// Starts the ARM binary under qemu-arm.
    pub(super) fn start() -> Result<Self, ChainError> {
        let binary = arm_binary()?;
        let child = Command::new("qemu-arm")
            .args(["-cpu", "cortex-a9"])
            .arg(&binary)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.map_err(|source| match source.kind() {
            ErrorKind::NotFound => ChainError::QemuMissing,
            _ => ChainError::Arm { step: "qemu-arm cannot be run", source },
        })?;
        let stdout = child.stdout.take().ok_or_else(|| ChainError::Arm {
            step: "no pipe from the flight program",
            source: ErrorKind::BrokenPipe.into(),
        })?;
        Ok(Self { stdin: child.stdin.take(), child, lines: BufReader::new(stdout).lines() })
    }

    /// Sends a message.
    pub(super) fn send(&mut self, message: &[u8]) -> Result<(), ChainError> {
        match self.stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(message)) {
            // The program has ended; its last line on stderr is the reason.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Err(self.failure()),
            other => other.map_err(|source| ChainError::Arm { step: "the flight program takes no messages", source }),
        }
    }

    /// Returns the next line that the program writes.
    pub(super) fn next_line(&mut self) -> Result<String, ChainError> {
        match self.lines.next() {
            Some(line) => line.map_err(|source| ChainError::Arm { step: "its lines cannot be read", source }),
            None => Err(self.failure()),
        }
    }

    /// Waits for the end of the program and returns the reason.
    fn failure(&mut self) -> ChainError {
        drop(self.stdin.take());
        let status = match self.child.wait() {
            Ok(status) => status,
            Err(source) => return ChainError::Arm { step: "the flight program cannot be waited for", source },
        };
        let mut text = String::new();
        if let Some(stderr) = &mut self.child.stderr
            && let Err(source) = stderr.read_to_string(&mut text)
        {
            return ChainError::Arm { step: "its messages cannot be read", source };
        }
        let last = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("no message");
        ChainError::ArmEnded { status, message: last.to_owned() }
    }
}

impl Drop for Arm {
    fn drop(&mut self) {
        // The end of the stream ends the program; without the wait it would remain as a zombie.
        drop(self.stdin.take());
        let _ = self.child.wait();
    }
}

/// Returns the ARM binary: the one that the environment names, or that of `make arm` in the target folder of the
/// running program or of the current folder.
///
/// # Errors
/// There is none, or not the one that the environment names.
pub fn arm_binary() -> Result<PathBuf, ChainError> {
    if let Some(named) = std::env::var_os(NAV_VARIABLE).map(PathBuf::from) {
        return if named.is_file() { Ok(named) } else { Err(ChainError::NamedBinaryMissing(named)) };
    }
    let program = std::env::current_exe()
        .map_err(|source| ChainError::Arm { step: "the folder of this program is unknown", source })?;
    let beside = program.ancestors().nth(2).map(|target| target.join(BINARY));
    let here = Path::new("target").join(BINARY);
    let candidates = beside.into_iter().chain([here.clone()]);
    candidates.into_iter().find(|path| path.is_file()).ok_or(ChainError::BinaryMissing(here))
}
