//! Flies points on a Dask cluster, through a Python module that passes them to its workers.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _, Seek as _, Write as _};
use std::process::{Command, Stdio};

use super::{CampaignError, FlownPoint, Point, table};
use crate::monitor::Monitor;

/// The Python module. It reads points from stdin and writes results to stdout, both as rows of CSV.
const MODULE: &str = "hoverlock_models.sweep";

/// The beginning of a line of the module that is a remark, not a result.
const REMARK: &str = "# ";

/// A Dask cluster.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cluster {
    /// Address of the scheduler, such as `tcp://cluster:8786`.
    pub scheduler: String,
    /// Python interpreter that has the module and the packages of its extra `dask`. The workers need the module too.
    pub python: OsString,
}

impl Cluster {
    /// Flies points and passes each to `keep` in the order in which they are finished. Remarks of the module, such as
    /// that there are no workers, go to `monitor`.
    pub(super) fn fly_all(
        &self,
        points: &[Point],
        monitor: &dyn Monitor,
        keep: &mut dyn FnMut(FlownPoint) -> Result<(), CampaignError>,
    ) -> Result<(), CampaignError> {
        if points.is_empty() {
            return Ok(());
        }
        let failed = |step: &'static str| move |source| CampaignError::Python { step, source };
        // A file, because nothing reads a pipe while the results arrive, and a full pipe would block the module.
        let mut stderr = tempfile::tempfile().map_err(failed("no temporary file"))?;
        let child = Command::new(&self.python)
            .args(["-m", MODULE, "--scheduler", &self.scheduler])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(stderr.try_clone().map_err(failed("no temporary file"))?)
            .spawn();
        let mut child = child.map_err(|source| match source.kind() {
            ErrorKind::NotFound => CampaignError::PythonMissing { python: self.python.clone(), module: MODULE },
            _ => CampaignError::Python { step: "Python cannot be run", source },
        })?;
        let mut rows = String::new();
        for point in points {
            rows += &table::to_row(point)?;
        }
        if let Some(mut stdin) = child.stdin.take() {
            match stdin.write_all(rows.as_bytes()) {
                // The module has ended; its last line on stderr is the reason.
                Err(error) if error.kind() == ErrorKind::BrokenPipe => {}
                written => written.map_err(failed("the Python module takes no points"))?,
            }
        }
        if let Some(stdout) = child.stdout.take() {
            for line in BufReader::new(stdout).lines() {
                let line = line.map_err(failed("the results cannot be read"))?;
                match line.strip_prefix(REMARK) {
                    Some(remark) => monitor.remark(remark),
                    None => keep(table::from_row(&line)?)?,
                }
            }
        }
        let status = child.wait().map_err(failed("the Python module cannot be waited for"))?;
        if status.success() {
            return Ok(());
        }
        let message = last_line(&mut stderr).map_err(failed("the messages of the Python module cannot be read"))?;
        let python = self.python.to_string_lossy().into_owned();
        Err(CampaignError::PythonFailed { scheduler: self.scheduler.clone(), python, status, message })
    }
}

/// Returns the last line of a file that is not empty.
fn last_line(file: &mut File) -> Result<String, std::io::Error> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    Ok(text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("no message").to_owned())
}
