//! Waves: of all signals (written by Verilator), of chosen signals (by the harness), or of the time before a failure.
//!
//! | what | build | cost |
//! |---|---|---|
//! | [`Recording::everything`] | `.trace(Trace::Vcd)` or `Fst` | 20 to 60 times slower while it records |
//! | [`Recording::signals`] | any | a comparison for each signal and step |
//! | [`Recording::before_failure`] | any | a copy of each signal and step, written only if a run fails |
//!
//! Beside each file a view for GTKWave (`.gtkw`) is written, with the signals in their order.

mod vcd;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use vcd::{Channel, Writer};

use crate::engine::error::RecordingError;
use crate::engine::model::Model;
use crate::engine::time::Time;

/// What is recorded, from when to when, and into which file.
#[derive(Debug, Clone)]
pub struct Recording {
    path: PathBuf,
    kind: Kind,
    from: Time,
    until: Time,
    has_view: bool,
}

#[derive(Debug, Clone)]
enum Kind {
    Everything { scope: String, levels: u32 },
    Signals(Vec<String>),
    BeforeFailure(Vec<String>, usize),
}

impl Recording {
    /// Records every signal of the design, written by Verilator in the format of the build's
    /// [`Trace`](crate::engine::build::Trace).
    pub fn everything(path: impl Into<PathBuf>) -> Recording {
        Recording::new(path, Kind::Everything { scope: String::new(), levels: 0 })
    }

    /// Records the signals of a scope (`top.u_core`) and `levels` levels below it (0: all), written by Verilator. The
    /// first recording of a model decides the scope of all its later ones.
    pub fn scope(path: impl Into<PathBuf>, scope: &str, levels: u32) -> Recording {
        Recording::new(path, Kind::Everything { scope: scope.to_owned(), levels })
    }

    /// Records ports and public internals by name, as VCD; all of them if none is named.
    pub fn signals<N: Into<String>>(path: impl Into<PathBuf>, names: impl IntoIterator<Item = N>) -> Recording {
        Recording::new(path, Kind::Signals(names.into_iter().map(Into::into).collect()))
    }

    /// Records the last `steps` time steps before a failure (two for each clock cycle), as VCD. Nothing is written if
    /// no run fails.
    pub fn before_failure<N: Into<String>>(
        path: impl Into<PathBuf>,
        names: impl IntoIterator<Item = N>,
        steps: usize,
    ) -> Recording {
        Recording::new(path, Kind::BeforeFailure(names.into_iter().map(Into::into).collect(), steps.max(1)))
    }

    fn new(path: impl Into<PathBuf>, kind: Kind) -> Recording {
        Recording { path: path.into(), kind, from: Time::ZERO, until: Time::fs(u64::MAX), has_view: true }
    }

    /// Records only from `from` to `until`, both included.
    pub fn window(mut self, from: Time, until: Time) -> Recording {
        (self.from, self.until) = (from, until);
        self
    }

    /// Writes no view for GTKWave, for benches that write their own.
    pub fn without_view(mut self) -> Recording {
        self.has_view = false;
        self
    }
}

/// A recording in progress; see [`Dut::stop_waves`](crate::sim::Dut::stop_waves).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordingId(u32);

enum Recorder {
    Everything,
    Signals(Writer),
    BeforeFailure {
        channels: Vec<Channel>,
        kept: VecDeque<(Time, Vec<u32>)>,
        steps: usize,
        has_view: bool,
        path: PathBuf,
        top: String,
        precision: Time,
    },
}

struct Running {
    id: u32,
    from: Time,
    until: Time,
    /// The time of the last sample. A time step that continues in a second run replaces its sample.
    last: Option<Time>,
    recorder: Recorder,
}

/// All recordings of a simulation.
#[derive(Default)]
pub(crate) struct Waves {
    running: Vec<Running>,
    next: u32,
}

impl Waves {
    /// Begins a recording.
    pub fn start(&mut self, model: &mut Model, recording: &Recording) -> Result<RecordingId, RecordingError> {
        let top = model.library().top().to_owned();
        let precision = model.precision();
        let recorder = match &recording.kind {
            Kind::Everything { scope, levels } => {
                let scope = if scope.is_empty() { String::new() } else { format!("TOP.{scope}") };
                model.trace_open(&recording.path, *levels, &scope)?;
                let channels = vcd::channels(model, &[])?;
                if recording.has_view {
                    vcd::write_view(&recording.path, &format!("TOP.{top}"), &channels)?;
                }
                Recorder::Everything
            }
            Kind::Signals(names) => {
                let channels = vcd::channels(model, names)?;
                if recording.has_view {
                    vcd::write_view(&recording.path, &top, &channels)?;
                }
                Recorder::Signals(Writer::create(&recording.path, &top, precision, channels)?)
            }
            Kind::BeforeFailure(names, steps) => Recorder::BeforeFailure {
                channels: vcd::channels(model, names)?,
                kept: VecDeque::new(),
                steps: *steps,
                has_view: recording.has_view,
                path: recording.path.clone(),
                top,
                precision,
            },
        };
        self.next += 1;
        self.running.push(Running {
            id: self.next,
            from: recording.from,
            until: recording.until,
            last: None,
            recorder,
        });
        Ok(RecordingId(self.next))
    }

    /// Ends a recording and completes its file.
    pub fn stop(&mut self, model: &mut Model, id: RecordingId) -> Result<(), RecordingError> {
        let Some(at) = self.running.iter().position(|r| r.id == id.0) else { return Ok(()) };
        match self.running.remove(at).recorder {
            Recorder::Everything => model.trace_close()?,
            Recorder::Signals(writer) => writer.finish()?,
            Recorder::BeforeFailure { .. } => {}
        }
        Ok(())
    }

    pub fn is_empty(&self) -> bool {
        self.running.is_empty()
    }

    /// Ends all recordings and completes their files; gives the first error.
    pub fn stop_all(&mut self, model: &mut Model) -> Result<(), RecordingError> {
        let ids: Vec<_> = self.running.iter().map(|running| RecordingId(running.id)).collect();
        let ends: Vec<_> = ids.into_iter().map(|id| self.stop(model, id)).collect();
        ends.into_iter().collect()
    }

    /// Samples the settled values of a time step. A recording whose file cannot be written ends.
    pub fn sample(&mut self, model: &mut Model, now: Time) -> Result<(), RecordingError> {
        for at in 0..self.running.len() {
            let running = &mut self.running[at];
            if now < running.from || now > running.until {
                continue;
            }
            let again = running.last.replace(now) == Some(now);
            let written = match &mut running.recorder {
                // Verilator's files take one sample for each time.
                Recorder::Everything if again => Ok(()),
                Recorder::Everything => model.trace_dump(now),
                Recorder::Signals(writer) => writer.sample(now),
                Recorder::BeforeFailure { channels, kept, steps, .. } => {
                    let reused = if again { kept.pop_back() } else { None };
                    let reused = reused.or_else(|| if kept.len() >= *steps { kept.pop_front() } else { None });
                    let mut words = reused.map_or(Vec::new(), |(_, words)| words);
                    words.clear();
                    channels.iter().for_each(|c| c.append_words(&mut words));
                    kept.push_back((now, words));
                    Ok(())
                }
            };
            if let Err(error) = written {
                self.running.remove(at);
                return Err(error);
            }
        }
        Ok(())
    }

    /// Writes the recordings that are kept for a failed run.
    pub fn failed(&mut self, model: &mut Model) -> Result<(), RecordingError> {
        for running in &mut self.running {
            if let Recorder::BeforeFailure { channels, kept, has_view, path, top, precision, .. } =
                &mut running.recorder
            {
                let mut writer = Writer::create(path, top, *precision, channels.clone())?;
                for (time, words) in kept.drain(..) {
                    writer.sample_words(time, &words)?;
                }
                writer.finish()?;
                if *has_view {
                    vcd::write_view(path, top, channels)?;
                }
            }
        }
        self.flush(model)
    }

    /// Flushes everything recorded so far to the files.
    pub fn flush(&mut self, model: &mut Model) -> Result<(), RecordingError> {
        self.running.iter_mut().try_for_each(|r| match &mut r.recorder {
            Recorder::Everything => model.trace_flush(),
            Recorder::Signals(writer) => writer.flush(),
            Recorder::BeforeFailure { .. } => Ok(()),
        })
    }
}

fn file_error(path: &Path) -> impl Fn(std::io::Error) -> RecordingError {
    let path = path.to_owned();
    move |source| RecordingError::File { path: path.clone(), source }
}
