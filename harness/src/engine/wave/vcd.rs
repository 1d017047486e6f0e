//! A value change dump of chosen signals, and GTKWave's view of it.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::file_error;
use crate::engine::error::{ModelError, RecordingError};
use crate::engine::model::{Model, Storage, load};
use crate::engine::time::Time;

/// A recorded signal. It is valid as long as its model, which outlives the recordings.
#[derive(Clone)]
pub(super) struct Channel {
    name: String,
    width: u32,
    data: *const u8,
    storage: Storage,
}

impl Channel {
    fn words(&self) -> usize {
        self.width.div_ceil(32) as usize
    }

    /// Appends the value as 32-bit words, lowest first.
    pub fn append_words(&self, into: &mut Vec<u32>) {
        // SAFETY: the recordings live in the core that owns the model.
        unsafe {
            match self.storage {
                Storage::Wide(count) => {
                    into.extend_from_slice(std::slice::from_raw_parts(self.data.cast::<u32>(), count as usize));
                }
                storage => {
                    let value = load(self.data, storage);
                    into.push(value as u32);
                    if self.width > 32 {
                        into.push((value >> 32) as u32);
                    }
                }
            }
        }
    }
}

/// Returns the channels of the signals named; of all but memories, if none is named.
pub(super) fn channels(model: &Model, names: &[String]) -> Result<Vec<Channel>, RecordingError> {
    let channel = |info: &crate::engine::model::SignalInfo| Channel {
        name: info.name.clone(),
        width: info.width,
        data: info.data,
        storage: info.storage,
    };
    if names.is_empty() {
        return Ok(model.signals().iter().filter(|s| s.range.is_none() && !s.real).map(channel).collect());
    }
    names
        .iter()
        .map(|name| {
            let info = model.info(model.find(name)?);
            let refused = |reason| ModelError::NotRecordable { signal: name.clone(), reason }.into();
            if info.range.is_some() {
                return Err(refused("is a memory: memories are not recorded"));
            }
            if info.real {
                return Err(refused("is a `real`: build the waves in to record it, with .trace(Trace::Vcd)"));
            }
            Ok(channel(info))
        })
        .collect()
}

/// Writes the dump sample by sample.
pub(super) struct Writer {
    out: BufWriter<File>,
    path: PathBuf,
    precision: Time,
    channels: Vec<Channel>,
    last: Vec<u32>,
    now: Vec<u32>,
    begun: bool,
    line: String,
}

impl Writer {
    pub fn create(path: &Path, top: &str, precision: Time, channels: Vec<Channel>) -> Result<Writer, RecordingError> {
        let file = File::create(path).map_err(file_error(path))?;
        let mut writer = Writer {
            out: BufWriter::new(file),
            path: path.to_owned(),
            precision,
            channels,
            last: Vec::new(),
            now: Vec::new(),
            begun: false,
            line: String::new(),
        };
        writer.header(top).map_err(file_error(path))?;
        Ok(writer)
    }

    fn header(&mut self, top: &str) -> std::io::Result<()> {
        let (number, unit) = match self.precision.as_fs() {
            fs if fs >= 1_000_000_000 => (fs / 1_000_000_000, "us"),
            fs if fs >= 1_000_000 => (fs / 1_000_000, "ns"),
            fs if fs >= 1_000 => (fs / 1_000, "ps"),
            fs => (fs, "fs"),
        };
        writeln!(self.out, "$timescale {number}{unit} $end\n$scope module {top} $end")?;
        let mut open: Vec<&str> = Vec::new();
        for (at, channel) in self.channels.iter().enumerate() {
            let mut path: Vec<&str> = channel.name.split('.').collect();
            let name = path.pop().unwrap_or("");
            let shared = open.iter().zip(&path).take_while(|(a, b)| a == b).count();
            for _ in shared..open.len() {
                writeln!(self.out, "$upscope $end")?;
            }
            for scope in &path[shared..] {
                writeln!(self.out, "$scope module {scope} $end")?;
            }
            open = path;
            let range = if channel.width > 1 { format!(" [{}:0]", channel.width - 1) } else { String::new() };
            writeln!(self.out, "$var wire {} {} {name}{range} $end", channel.width, code(at))?;
        }
        for _ in 0..=open.len() {
            writeln!(self.out, "$upscope $end")?;
        }
        writeln!(self.out, "$enddefinitions $end")
    }

    pub fn sample(&mut self, time: Time) -> Result<(), RecordingError> {
        let mut now = std::mem::take(&mut self.now);
        now.clear();
        self.channels.iter().for_each(|c| c.append_words(&mut now));
        let result = self.sample_words(time, &now);
        self.now = now;
        result
    }

    /// Writes the values that differ from the last sample.
    pub fn sample_words(&mut self, time: Time, words: &[u32]) -> Result<(), RecordingError> {
        use std::fmt::Write as _;
        self.line.clear();
        let mut at = 0;
        for (number, channel) in self.channels.iter().enumerate() {
            let count = channel.words();
            let value = &words[at..at + count];
            if !self.begun || self.last[at..at + count] != *value {
                if channel.width == 1 {
                    let _ = writeln!(self.line, "{}{}", value[0] & 1, code(number));
                } else {
                    self.line.push('b');
                    for bit in (0..channel.width).rev() {
                        self.line.push(if value[(bit / 32) as usize] >> (bit % 32) & 1 == 1 { '1' } else { '0' });
                    }
                    let _ = writeln!(self.line, " {}", code(number));
                }
            }
            at += count;
        }
        self.begun = true;
        self.last.clear();
        self.last.extend_from_slice(words);
        if self.line.is_empty() {
            return Ok(());
        }
        let ticks = time.as_fs() / self.precision.as_fs().max(1);
        write!(self.out, "#{ticks}\n{}", self.line).map_err(file_error(&self.path))
    }

    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.out.flush().map_err(file_error(&self.path))
    }

    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.flush()
    }
}

/// Returns the identifier code of signal `number`, in printable characters: `!`, `"`, ... `~`, `!!`.
fn code(number: usize) -> String {
    let mut text = String::new();
    let mut rest = number;
    loop {
        text.push(char::from(b'!' + (rest % 94) as u8));
        rest /= 94;
        if rest == 0 {
            return text;
        }
        rest -= 1;
    }
}

/// Writes GTKWave's view beside a wave file: one-bit signals in binary, others in hexadecimal.
pub(super) fn write_view(waves: &Path, scope: &str, channels: &[Channel]) -> Result<(), RecordingError> {
    let path = waves.with_extension("gtkw");
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut text = format!("[dumpfile] \"{}\"\n[savefile] \"{}\"\n[timestart] 0\n", name(waves), name(&path));
    for channel in channels {
        let range = if channel.width > 1 { format!("[{}:0]", channel.width - 1) } else { String::new() };
        let format = if channel.width > 1 { "@22" } else { "@28" };
        text.push_str(&format!("{format}\n{scope}.{}{range}\n", channel.name));
    }
    std::fs::write(&path, text).map_err(file_error(&path))
}

#[cfg(test)]
mod tests {
    use super::code;

    #[test]
    fn identifier_codes_are_unique() {
        let codes: std::collections::HashSet<String> = (0..20_000).map(code).collect();
        assert_eq!(codes.len(), 20_000);
        assert_eq!((code(0).as_str(), code(93).as_str(), code(94).as_str()), ("!", "~", "!!"));
    }
}
