//! Files that Verilator's runtime writes: waves of a traced model, and coverage.

use std::ffi::CString;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::Model;
use crate::engine::build::Trace;
use crate::engine::error::{ModelError, RecordingError};
use crate::engine::time::Time;

impl Model {
    /// Starts to write waves of everything below a scope (empty: all), `level` levels deep (0: all).
    ///
    /// # Errors
    /// If the model was built without waves, or the file cannot be written.
    pub fn trace_open(&mut self, path: &Path, level: u32, scope: &str) -> Result<(), RecordingError> {
        let not_built =
            ModelError::NotBuiltIn { what: "a wave file", with: ".trace(Trace::Vcd) or .trace(Trace::Fst)" };
        if self.library.trace() == Trace::None {
            return Err(not_built.into());
        }
        let invalid = |text: &str| RecordingError::File {
            path: path.to_owned(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidInput, text.to_owned()),
        };
        let name = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| invalid("zero byte in the name"))?;
        let scope = CString::new(scope).map_err(|_| invalid("zero byte in the scope"))?;
        self.bind();
        // SAFETY: the strings live through the call.
        match unsafe { (self.functions.hv_trace_open)(self.raw, name.as_ptr(), level as i32, scope.as_ptr()) } {
            1 => {
                path.clone_into(&mut self.trace_path);
                self.recorded()
            }
            0 => Err(not_built.into()),
            _ => Err(RecordingError::File { path: path.to_owned(), source: std::io::Error::last_os_error() }),
        }
    }

    /// Writes the present values into the open wave file; times must increase.
    ///
    /// # Errors
    /// If the file cannot be written, such as on a full disk; it is closed then.
    pub fn trace_dump(&mut self, time: Time) -> Result<(), RecordingError> {
        self.bind();
        // SAFETY: the instance is alive; does nothing without an open file.
        unsafe { (self.functions.hv_trace_dump)(self.raw, time.as_fs() / self.femtoseconds_per_tick) };
        self.recorded()
    }

    pub(crate) fn trace_flush(&mut self) -> Result<(), RecordingError> {
        self.bind();
        // SAFETY: the instance is alive; does nothing without an open file.
        unsafe { (self.functions.hv_trace_flush)(self.raw) };
        self.recorded()
    }

    /// Completes and closes the wave file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn trace_close(&mut self) -> Result<(), RecordingError> {
        self.bind();
        // SAFETY: as above.
        unsafe { (self.functions.hv_trace_close)(self.raw) };
        self.recorded()?;
        let path = std::mem::take(&mut self.trace_path);
        if self.library.trace() == Trace::Fst && !path.as_os_str().is_empty() && !is_whole_fst(&path) {
            let reason = "the waves are not whole: the disk may be full, or the file too large";
            return Err(RecordingError::File { path, source: std::io::Error::other(reason) });
        }
        Ok(())
    }

    /// Returns the error of the runtime's last write to the wave file.
    #[inline]
    fn recorded(&mut self) -> Result<(), RecordingError> {
        if !self.has_messages() {
            return Ok(());
        }
        let Some(reason) = self.take_fatal() else { return Ok(()) };
        // The runtime names its function first.
        let reason = reason.rsplit_once("::bufferFlush: ").map_or(reason.as_str(), |(_, why)| why).to_owned();
        Err(RecordingError::File { path: self.trace_path.clone(), source: std::io::Error::other(reason) })
    }

    /// Writes the coverage counted so far in Verilator's format.
    ///
    /// # Errors
    /// If the model was built without coverage, or the file cannot be written.
    pub fn write_coverage(&mut self, path: &Path) -> Result<(), RecordingError> {
        let name = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| RecordingError::File {
            path: path.to_owned(),
            source: std::io::Error::new(std::io::ErrorKind::InvalidInput, "zero byte in the name"),
        })?;
        self.bind();
        // SAFETY: the string lives through the call.
        if unsafe { (self.functions.hv_coverage_write)(self.raw, name.as_ptr()) } == 0 {
            return Err(ModelError::NotBuiltIn { what: "coverage", with: ".coverage(Coverage::ALL)" }.into());
        }
        std::fs::metadata(path).map(|_| ()).map_err(|source| RecordingError::File { path: path.to_owned(), source })
    }
}

/// Returns `true` if a file of FST waves consists of whole blocks, a header first. A block is one byte of kind, eight
/// bytes of length (themselves included), and data. The runtime does not report a failed write.
fn is_whole_fst(path: &Path) -> bool {
    let blocks = || -> std::io::Result<bool> {
        let mut file = File::open(path)?;
        let size = file.metadata()?.len();
        let (mut at, mut count) = (0, 0);
        while at < size {
            let mut head = [0; 9];
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(&mut head)?;
            let (kind, length) = (head[0], u64::from_be_bytes([1, 2, 3, 4, 5, 6, 7, 8].map(|i: usize| head[i])));
            if length < 8 || (count == 0) != (kind == 0) {
                return Ok(false);
            }
            at = at.saturating_add(1 + length);
            count += 1;
        }
        // Header, values, geometry, hierarchy.
        Ok(at == size && count >= 4)
    };
    blocks().unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_cut_short_is_not_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.fst");
        let block = |kind: u8, bytes: usize| [&[kind][..], &(bytes as u64 + 8).to_be_bytes(), &vec![7; bytes]].concat();
        let whole = [block(0, 321), block(5, 40), block(3, 9), block(4, 30)].concat();
        let is_whole = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            is_whole_fst(&path)
        };
        assert!(is_whole(&whole));
        assert!((0..whole.len()).all(|length| !is_whole(&whole[..length])), "every shorter file");
        assert!(!is_whole(&whole[330..]), "no header");
        assert!(!is_whole(&[&whole[..], &[0; 9]].concat()), "a second header");
        assert!(!is_whole_fst(&folder.path().join("none")));
    }
}
