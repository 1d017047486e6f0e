//! The signals of a stream, and how symbols lie in a beat.

use super::{Dialect, Frame};
use crate::bench::bus::{Random, optional};
use crate::bench::error::Error;
use crate::bench::sim::{Core, Dut, Signal};
use crate::engine::error::ModelError;
use crate::engine::model::{Direction, SignalInfo, Storage, load};

/// The widest `data`, in 64-bit words.
pub(super) const WORDS: usize = 8;

/// A beat: the payload that is transferred at one edge. `data` has `W` 64-bit words, 1 or [`WORDS`]: most streams are
/// narrow, and a beat is read, compared and copied in every cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Beat<const W: usize> {
    pub data: [u64; W],
    pub first: bool,
    pub last: bool,
    /// Lanes in use: bit 0 is the lane of the first symbol.
    pub keep: u64,
    pub channel: u64,
    pub error: u64,
    pub destination: u64,
}

/// A data port of up to 512 bits.
#[derive(Clone)]
struct DataPort {
    name: String,
    data: *mut u8,
    storage: Storage,
    index: u32,
    width: u32,
}

impl DataPort {
    fn find(dut: &Dut, name: &str) -> Result<DataPort, ModelError> {
        let model = dut.core().model.borrow();
        let id = model.find(name)?;
        let info: &SignalInfo = model.info(id);
        if info.range.is_some() || info.width as usize > 64 * WORDS {
            return Err(ModelError::TooWide { signal: info.name.clone(), width: info.width });
        }
        Ok(DataPort {
            name: info.name.clone(),
            data: info.data,
            storage: info.storage,
            index: id.index() as u32,
            width: info.width,
        })
    }

    #[inline(always)]
    fn get<const W: usize>(&self) -> [u64; W] {
        let mut words = [0; W];
        // SAFETY: the agent that owns this port lives inside the core that owns the model.
        unsafe {
            match self.storage {
                Storage::Wide(count) => {
                    for at in 0..count as usize {
                        words[at / 2] |= u64::from(*self.data.cast::<u32>().add(at)) << (32 * (at % 2));
                    }
                }
                storage => words[0] = load(self.data, storage),
            }
        }
        words
    }

    #[inline(always)]
    fn put<const W: usize>(&self, core: &Core, value: &[u64; W]) -> Result<(), ModelError> {
        match self.storage {
            Storage::Wide(count) => {
                let words: [u32; 2 * WORDS] = std::array::from_fn(|at| (value[at / 2] >> (32 * (at % 2))) as u32);
                core.write_words(self.index, &words[..count as usize])
            }
            _ => core.write(self.index, value[0]),
        }
    }

    fn put_random(&self, core: &Core, random: &mut Random) -> Result<(), ModelError> {
        let words = self.width.div_ceil(64) as usize;
        let mut value = [0; WORDS];
        value[..words].fill_with(|| random.bits());
        value[words - 1] &= u64::MAX >> (64 * words as u32 - self.width);
        self.put(core, &value)
    }
}

/// The signals of a stream.
#[derive(Clone)]
pub struct Ports {
    pub(super) name: String,
    pub(super) dialect: Dialect,
    pub(super) valid: Signal,
    pub(super) ready: Option<Signal>,
    data: DataPort,
    pub(super) first: Option<Signal>,
    pub(super) last: Option<Signal>,
    pub(super) empty: Option<Signal>,
    pub(super) keep: Option<Signal>,
    pub(super) channel: Option<Signal>,
    pub(super) error: Option<Signal>,
    pub(super) destination: Option<Signal>,
    pub(super) symbol_bits: u32,
    pub(super) lanes: u32,
}

impl Ports {
    /// Finds the signals whose names begin with `prefix` (such as `in_`, `s_axis_` or `video$`). All but `valid` and
    /// `data` may be missing. A symbol is a byte if the width of `data` is a multiple of 8, otherwise the whole of
    /// `data`; see [`Ports::symbols_of`].
    ///
    /// # Errors
    /// If `valid` or `data` is missing, `data` is wider than 512 bits, or the ready latency is over 64 cycles.
    pub fn find(dut: &Dut, prefix: &str, dialect: Dialect) -> Result<Ports, Error> {
        dialect.check()?;
        let t = if dialect == Dialect::Axi { "t" } else { "" };
        let some = |name: &str| optional(dut, prefix, name);
        let avalon = |name: &str| if dialect == Dialect::Axi { Ok(None) } else { some(name) };
        let axi = |name: &str| if dialect == Dialect::Axi { some(name) } else { Ok(None) };
        let data = DataPort::find(dut, &format!("{prefix}{t}data"))?;
        let symbol_bits = if data.width.is_multiple_of(8) { 8 } else { data.width };
        let ports = Ports {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            dialect,
            valid: dut.signal(&format!("{prefix}{t}valid"))?,
            ready: some(&format!("{t}ready"))?,
            first: avalon("startofpacket")?,
            last: if dialect == Dialect::Axi { axi("tlast")? } else { avalon("endofpacket")? },
            empty: avalon("empty")?,
            keep: axi("tkeep")?,
            channel: if dialect == Dialect::Axi { axi("tid")? } else { avalon("channel")? },
            error: if dialect == Dialect::Axi { axi("tuser")? } else { avalon("error")? },
            destination: axi("tdest")?,
            symbol_bits: 0,
            lanes: 0,
            data,
        };
        ports.symbols_of(symbol_bits)
    }

    /// Returns these ports with symbols of `bits` bits.
    ///
    /// # Errors
    /// If symbols of that width do not fill `data`, or are wider than 64 bits.
    pub fn symbols_of(mut self, bits: u32) -> Result<Ports, Error> {
        if bits == 0 || bits > 64 || !self.data.width.is_multiple_of(bits) || self.data.width / bits > 64 {
            return Err(Error::bench(format!(
                "symbols of {bits} bits do not fill '{}', which is {} bits wide",
                self.data.name, self.data.width
            )));
        }
        self.symbol_bits = bits;
        self.lanes = self.data.width / bits;
        Ok(self)
    }

    /// Returns `true` if `data` has at most 64 bits.
    pub(super) fn is_narrow(&self) -> bool {
        self.data.width <= 64
    }

    /// Returns how many symbols a beat has.
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    pub(super) fn latency(&self) -> u32 {
        match self.dialect {
            Dialect::Avalon { ready_latency } => ready_latency,
            Dialect::Axi => 0,
        }
    }

    fn all_lanes(&self) -> u64 {
        u64::MAX >> (64 - self.lanes)
    }

    /// Returns the bit position of a beat's symbol number `at`.
    fn lane_shift(&self, at: u32) -> u32 {
        match self.dialect {
            Dialect::Avalon { .. } => (self.lanes - 1 - at) * self.symbol_bits,
            Dialect::Axi => at * self.symbol_bits,
        }
    }

    fn insert(&self, data: &mut [u64], at: u32, symbol: u64) {
        let shift = self.lane_shift(at);
        let (word, bit) = ((shift / 64) as usize, shift % 64);
        data[word] |= symbol << bit;
        if bit + self.symbol_bits > 64 {
            data[word + 1] |= symbol >> (64 - bit);
        }
    }

    #[inline]
    pub(super) fn extract(&self, data: &[u64], at: u32) -> u64 {
        let shift = self.lane_shift(at);
        let (word, bit) = ((shift / 64) as usize, shift % 64);
        let mut symbol = data[word] >> bit;
        if bit + self.symbol_bits > 64 {
            symbol |= data[word + 1] << (64 - bit);
        }
        symbol & (u64::MAX >> (64 - self.symbol_bits))
    }

    /// Returns the number of beats of a frame, or an error if it cannot be sent.
    pub(super) fn beats(&self, frame: &Frame) -> Result<usize, Error> {
        let lanes = self.lanes as usize;
        let count = frame.symbols.len().div_ceil(lanes);
        if count == 0 {
            return Err(Error::bench(format!("{}: a frame without symbols cannot be sent", self.name)));
        }
        let partial = !frame.symbols.len().is_multiple_of(lanes);
        if partial && self.keep.is_none() && self.empty.is_none() {
            return Err(Error::bench(format!(
                "{}: {} symbols do not fill beats of {lanes}, and there is neither `empty` nor `tkeep`",
                self.name,
                frame.symbols.len()
            )));
        }
        for (what, signal, value) in [
            ("channel", &self.channel, frame.channel),
            ("error", &self.error, frame.error),
            ("destination", &self.destination, frame.destination),
        ] {
            let fits = signal.as_ref().map_or(value == 0, |s| value & !s.mask() == 0);
            if !fits {
                return Err(Error::bench(format!("{}: {what} {value} does not fit its signal", self.name)));
            }
        }
        let largest = u64::MAX >> (64 - self.symbol_bits);
        if let Some(symbol) = frame.symbols.iter().find(|symbol| **symbol > largest) {
            return Err(Error::bench(format!("{}: symbol {symbol} does not fit {} bits", self.name, self.symbol_bits)));
        }
        Ok(count)
    }

    /// Returns the beat that begins with symbol number `at` of a frame.
    #[inline(always)]
    pub(super) fn beat<const W: usize>(&self, frame: &Frame, at: usize) -> Beat<W> {
        let end = frame.symbols.len().min(at + self.lanes as usize);
        let symbols = &frame.symbols[at..end];
        let mut beat = Beat {
            data: [0; W],
            first: at == 0 && !frame.sending.omit_start,
            last: end == frame.symbols.len() && !frame.sending.omit_end,
            keep: u64::MAX >> (64 - symbols.len()),
            channel: frame.channel,
            error: frame.error,
            destination: frame.destination,
        };
        if self.lanes == 1 {
            beat.data[0] = symbols[0];
        } else {
            (0..).zip(symbols).for_each(|(lane, symbol)| self.insert(&mut beat.data, lane, *symbol));
        }
        beat
    }

    #[inline(always)]
    pub(super) fn put<const W: usize>(&self, core: &Core, beat: &Beat<W>) -> Result<(), Error> {
        self.valid.set(1)?;
        self.data.put(core, &beat.data)?;
        put(&self.first, u64::from(beat.first))?;
        put(&self.last, u64::from(beat.last))?;
        put(&self.empty, u64::from(self.lanes - beat.keep.count_ones()))?;
        put(&self.keep, beat.keep)?;
        put(&self.channel, beat.channel)?;
        put(&self.error, beat.error)?;
        put(&self.destination, beat.destination)?;
        Ok(())
    }

    /// Writes random values to all signals but `valid`.
    #[cold]
    pub(super) fn put_random(&self, core: &Core, random: &mut Random) -> Result<(), Error> {
        self.data.put_random(core, random)?;
        let others = [&self.first, &self.last, &self.empty, &self.keep, &self.channel, &self.error, &self.destination];
        Ok(others.into_iter().try_for_each(|signal| put(signal, random.bits()))?)
    }

    #[inline(always)]
    pub(super) fn get<const W: usize>(&self) -> Beat<W> {
        let empty = get(&self.empty, 0).min(64) as u32;
        let last = get(&self.last, 0) != 0;
        let used = match (&self.keep, &self.empty) {
            (Some(keep), _) => keep.get(),
            (None, Some(_)) if last => self.all_lanes() >> empty.min(self.lanes),
            _ => self.all_lanes(),
        };
        Beat {
            data: self.data.get(),
            first: get(&self.first, 0) != 0,
            last,
            keep: used,
            channel: get(&self.channel, 0),
            error: get(&self.error, 0),
            destination: get(&self.destination, 0),
        }
    }

    #[inline(always)]
    pub(super) fn is_ready(&self) -> bool {
        self.ready.as_ref().is_none_or(Signal::is_high)
    }

    pub(super) fn require_input(&self, signal: &Signal) -> Result<(), Error> {
        let info = signal.info();
        if info.direction == Direction::Output {
            return Err(ModelError::NotWritable { signal: info.name, top: "the design".into() }.into());
        }
        Ok(())
    }
}

/// Reads an optional signal of a stream; `missing` is the value that its absence means.
#[inline(always)]
fn get(signal: &Option<Signal>, missing: u64) -> u64 {
    match signal {
        Some(signal) => signal.get(),
        None => missing,
    }
}

/// Writes a signal that a stream may have.
#[inline(always)]
fn put(signal: &Option<Signal>, value: u64) -> Result<(), ModelError> {
    match signal {
        Some(signal) => signal.set(value & signal.mask()),
        None => Ok(()),
    }
}

/// The values of `ready` in the last 64 cycles.
#[derive(Clone, Copy, Default)]
pub(in crate::bench::bus) struct ReadyHistory(u64);

impl ReadyHistory {
    pub fn push(&mut self, ready: bool) {
        self.0 = self.0 << 1 | u64::from(ready);
    }

    /// Returns `true` if `ready` was 1 `latency` cycles before the next cycle.
    pub fn before(self, latency: u32) -> bool {
        self.0 >> (latency - 1) & 1 == 1
    }
}
