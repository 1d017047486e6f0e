//! One stream of a transfer: its signals by address, and the sides that send and receive.

use super::Options;
use super::half_cycle::put_now;
use crate::bench::bus::stream::{Dialect, ReadyHistory};
use crate::bench::bus::{Pause, optional};
use crate::bench::error::Error;
use crate::bench::sim::{Dut, Signal};
use crate::engine::error::ModelError;
use crate::engine::model::{Direction, Storage, Word};

/// A type of the elements of a slice: the one in which Verilator stores `data`.
pub trait Element: Word {
    /// Returns the value in 64 bits.
    fn widen(self) -> u64;
}

impl Element for u8 {
    fn widen(self) -> u64 {
        u64::from(self)
    }
}
impl Element for u16 {
    fn widen(self) -> u64 {
        u64::from(self)
    }
}
impl Element for u32 {
    fn widen(self) -> u64 {
        u64::from(self)
    }
}
impl Element for u64 {
    fn widen(self) -> u64 {
        self
    }
}

/// The signals of a stream.
pub(super) struct StreamSignals<T: Word> {
    pub name: String,
    /// Elements in a beat: more than one only if `data` is wider than 64 bits.
    pub parts: usize,
    pub last: Option<Signal>,
    valid: Signal,
    ready: Option<Signal>,
    first: Option<Signal>,
    data: *mut T,
    /// A mask of the bits of a beat's last element that belong to `data`.
    top_mask: u64,
    latency: u32,
}

impl<T: Element> StreamSignals<T> {
    pub fn find(dut: &Dut, prefix: &str, dialect: Dialect, driven: bool) -> Result<StreamSignals<T>, Error> {
        let t = if dialect == Dialect::Axi { "t" } else { "" };
        let (first, last) = if dialect == Dialect::Axi { ("", "tlast") } else { ("startofpacket", "endofpacket") };
        let some = |name: &str| if name.is_empty() { Ok(None) } else { optional(dut, prefix, name) };
        let info = dut.wide(&format!("{prefix}{t}data"))?.info();
        let (bits, parts) = match info.storage {
            Storage::U8 => (8, 1),
            Storage::U16 => (16, 1),
            Storage::U32 => (32, 1),
            Storage::U64 => (64, 1),
            Storage::Wide(parts) => (32, parts as usize),
        };
        if bits != T::BITS {
            return Err(Error::bench(format!(
                "'{}' is {} bits wide: its elements are of {bits} bits, not of {} bits",
                info.name,
                info.width,
                T::BITS
            )));
        }
        let in_last = info.width - 32 * (parts as u32 - 1);
        if driven && (info.direction == Direction::Output || info.is_overridden()) {
            return Err(ModelError::NotWritable { signal: info.name, top: dut.top() }.into());
        }
        Ok(StreamSignals {
            name: prefix.trim_end_matches(['_', '$', '.']).to_owned(),
            parts,
            last: some(last)?,
            valid: dut.signal(&format!("{prefix}{t}valid"))?,
            ready: some(&format!("{t}ready"))?,
            first: some(first)?,
            data: info.data.cast(),
            top_mask: u64::MAX >> (64 - in_last),
            latency: match dialect {
                Dialect::Avalon { ready_latency } => ready_latency,
                Dialect::Axi => 0,
            },
        })
    }

    /// Returns the first element that does not fit `data`.
    pub fn first_too_large(&self, elements: &[T]) -> Option<u64> {
        let tops = elements.iter().skip(self.parts - 1).step_by(self.parts);
        tops.map(|element| element.widen()).find(|element| element & !self.top_mask != 0)
    }

    #[inline(always)]
    fn is_ready(&self) -> bool {
        self.ready.as_ref().is_none_or(Signal::is_high)
    }

    /// Returns `true` if a valid beat is transferred at the edge: with a ready latency always, because `ready` allowed
    /// it that many cycles before.
    #[inline(always)]
    fn moves(&self) -> bool {
        self.latency > 0 || self.is_ready()
    }

    /// Puts the beat with that number into `data`.
    ///
    /// # Safety
    /// `elements` must have that beat, the model must be alive and nobody reading.
    #[inline(always)]
    unsafe fn put(&self, elements: &[T], number: usize) {
        // SAFETY: as the caller promises; `data` has `parts` elements.
        unsafe {
            if self.parts == 1 {
                *self.data = *elements.get_unchecked(number);
            } else {
                std::ptr::copy_nonoverlapping(elements.as_ptr().add(number * self.parts), self.data, self.parts);
            }
        }
    }

    /// Appends the beat in `data`.
    ///
    /// # Safety
    /// The model must be alive.
    #[inline(always)]
    unsafe fn take(&self, into: &mut Vec<T>) {
        // SAFETY: as the caller promises; `data` has `parts` elements.
        unsafe {
            if self.parts == 1 {
                into.push(*self.data);
            } else {
                into.extend_from_slice(std::slice::from_raw_parts(self.data, self.parts));
            }
        }
    }
}

#[inline(always)]
unsafe fn put_if(signal: &Option<Signal>, value: bool) {
    if let Some(signal) = signal {
        // SAFETY: as the caller promises.
        unsafe { put_now(signal, u64::from(value)) };
    }
}

/// The side that sends: what a source does in each cycle.
pub(super) struct Sender<'a, I: Element> {
    signals: &'a StreamSignals<I>,
    elements: &'a [I],
    /// Beats to send.
    count: usize,
    /// Beats that the design has accepted.
    pub sent: usize,
    /// Beats in a packet.
    packet: usize,
    /// Beats until the packet's end, counted down so that no division is in the loop.
    left_in_packet: usize,
    is_offered: bool,
    idle: Pause,
    history: ReadyHistory,
}

impl<'a, I: Element> Sender<'a, I> {
    pub fn new(signals: &'a StreamSignals<I>, elements: &'a [I], options: &Options) -> Sender<'a, I> {
        let count = elements.len() / signals.parts;
        let packet = if options.packet == 0 { count.max(1) } else { options.packet };
        Sender {
            signals,
            elements,
            count,
            sent: 0,
            packet,
            left_in_packet: packet,
            is_offered: false,
            idle: options.idle.clone(),
            history: ReadyHistory::default(),
        }
    }

    #[inline(always)]
    pub fn is_done(&self) -> bool {
        self.sent == self.count
    }

    /// Puts `valid` low.
    ///
    /// # Safety
    /// The model must be alive and nobody reading.
    pub unsafe fn withdraw(&mut self) {
        // SAFETY: as the caller promises.
        unsafe { put_now(&self.signals.valid, 0) };
    }

    /// Offers the next beat, unless one is offered already or the source pauses.
    ///
    /// # Safety
    /// As [`Sender::withdraw`].
    #[inline(always)]
    pub unsafe fn offer(&mut self) {
        if self.is_offered {
            return;
        }
        let signals = self.signals;
        let allowed = signals.latency == 0 || self.history.before(signals.latency);
        self.is_offered = self.sent < self.count && allowed && !self.idle.next_cycle();
        // SAFETY: as the caller promises; `sent` is below the number of beats where one is offered.
        unsafe {
            put_now(&signals.valid, u64::from(self.is_offered));
            if self.is_offered {
                signals.put(self.elements, self.sent);
                put_if(&signals.first, self.left_in_packet == self.packet);
                put_if(&signals.last, self.left_in_packet == 1 || self.sent + 1 == self.count);
            }
        }
    }

    /// Looks, just before the rising edge, whether that edge takes the beat.
    #[inline(always)]
    pub fn sample(&mut self) {
        if self.signals.latency > 0 {
            self.history.push(self.signals.is_ready());
        }
        if self.is_offered && self.signals.moves() {
            self.sent += 1;
            self.is_offered = false;
            self.left_in_packet = if self.left_in_packet == 1 { self.packet } else { self.left_in_packet - 1 };
        }
    }
}

/// The side that receives: what a sink does in each cycle.
pub(super) struct Receiver<'a, O: Element> {
    signals: &'a StreamSignals<O>,
    received: &'a mut Vec<O>,
    /// Beats that the design has sent.
    pub beats: usize,
    /// Packets that the design has completed.
    pub packets: usize,
    expect: usize,
    expect_packets: usize,
    stall: Pause,
}

impl<'a, O: Element> Receiver<'a, O> {
    pub fn new(signals: &'a StreamSignals<O>, received: &'a mut Vec<O>, options: &Options) -> Receiver<'a, O> {
        received.reserve(options.expect * signals.parts);
        Receiver {
            signals,
            received,
            beats: 0,
            packets: 0,
            expect: options.expect,
            expect_packets: options.packets,
            stall: options.stall.clone(),
        }
    }

    #[inline(always)]
    pub fn is_done(&self) -> bool {
        self.beats >= self.expect && self.packets >= self.expect_packets
    }

    /// Puts `ready` low.
    ///
    /// # Safety
    /// The model must be alive and nobody reading.
    pub unsafe fn withdraw(&mut self) {
        // SAFETY: as the caller promises.
        unsafe { put_if(&self.signals.ready, false) };
    }

    /// Sets `ready` to 1, or to 0 if the sink stalls.
    ///
    /// # Safety
    /// As [`Receiver::withdraw`].
    #[inline(always)]
    pub unsafe fn offer(&mut self) {
        // SAFETY: as the caller promises.
        unsafe { put_if(&self.signals.ready, !self.stall.next_cycle()) };
    }

    /// Takes the beat, if the rising edge that follows moves one.
    ///
    /// # Safety
    /// The model must be alive.
    #[inline(always)]
    pub unsafe fn sample(&mut self) {
        if self.signals.valid.is_high() && self.signals.moves() {
            // SAFETY: as the caller promises.
            unsafe { self.signals.take(self.received) };
            self.beats += 1;
            self.packets += usize::from(self.signals.last.as_ref().is_some_and(Signal::is_high));
        }
    }
}
