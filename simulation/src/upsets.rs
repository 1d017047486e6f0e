//! Faults in the registers and memories of the top while it runs: a sequence of frames with one fault in it, and its
//! packets beside those of the same sequence without.
//!
//! The frames follow each other without a gap, and every record is taken at once. A fault happens while the second
//! enters, the *hit* frame; at that time the first is still in the pipeline.
//!
//! | class | the packets of the run with the fault |
//! |---|---|
//! | hang | fewer of them come, with one frame's time to spare |
//! | masked | all are equal, record by record and trailer by trailer |
//! | detected | some differ, and each of these shows it by itself, see [`is_sound`] |
//! | recovered | some differ without showing it, none later than that of the frame after the hit one |
//! | silent | some differ without showing it, and a later one differs |
//!
//! `irq` and the register bus are not observed: a fault that shows only there is masked.

use std::ops::Range;

use hoverlock_design::DesignPoint;
use hoverlock_fault::class::Class;
use hoverlock_fault::draw::{Fault, Injection, Kind};
use hoverlock_fault::state::State;
use hoverlock_harness::ModelError;
use hoverlock_harness::model::{Direction, InstanceOptions, Model, SignalId, SignalInfo};
use hoverlock_reference::image::plane::Plane;
use hoverlock_registers::record::{FLAG_TEN_WORDS, FLAG_TRAILER, RECORD_WORDS, record_words, trailer};

use crate::job::Map;
use crate::top::RESET_CYCLES;
use crate::{Job, SimulationError, Simulator};

/// The frame during whose pixels a fault happens.
const HIT: usize = 1;

/// The fewest frames of a sequence: one before the hit frame, and two after it.
pub const MIN_FRAMES: usize = HIT + 3;

/// The most states of a run that are kept, at even distances.
const MAX_CHECKPOINTS: u64 = 64;

/// The least distance of these states, cycles: to compare one takes as long as some hundred cycles.
const MIN_DISTANCE: u64 = 2048;

/// The packet of a frame: the words of its records, the trailer last.
pub type Packet = Vec<u32>;

/// A sequence of frames through the top, and what comes out without a fault.
///
/// A run with a fault begins at the last checkpoint before the fault and ends at the first after it at which everything
/// is as without the fault: registers, memories, pixels taken and records given. From there on the run would repeat the
/// one without a fault.
pub struct Upsets {
    simulator: Simulator,
    state: State,
    /// The beats of all frames: pixel, start of packet, end of packet.
    beats: Vec<(u16, bool, bool)>,
    /// Register writes before the first frame: byte address and value.
    writes: Vec<(u32, u32)>,
    golden: Vec<Packet>,
    /// Clock cycles after the register writes in which the hit frame enters.
    window: Range<u64>,
    /// Clock cycles after the register writes until the last packet has come out.
    cycles: u64,
    /// Cycles between checkpoints, and the checkpoints.
    distance: u64,
    checkpoints: Vec<Checkpoint>,
}

/// The state of a run before a cycle.
struct Checkpoint {
    registers: Vec<u8>,
    progress: Progress,
}

/// How far the streams are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Progress {
    /// Beats taken.
    beats: usize,
    /// Packets that are complete, and words of the next.
    packets: usize,
    words: usize,
}

/// The ports of the top.
struct Ports {
    clock: SignalId,
    video_valid: SignalId,
    video_ready: SignalId,
    video_data: SignalId,
    video_first: SignalId,
    video_last: SignalId,
    feature_valid: SignalId,
    feature_data: SignalId,
    feature_last: SignalId,
}

/// The top in a run: pixels are always offered, records always taken. It drives the ports itself, because the bus
/// models of the harness cannot begin in the middle of a run.
struct Run<'a> {
    upsets: &'a Upsets,
    model: Model,
    ports: Ports,
    /// Beats taken.
    position: usize,
    packets: Vec<Packet>,
    open: Packet,
}

impl<'a> Run<'a> {
    /// Resets the top and writes its registers.
    fn start(upsets: &'a Upsets) -> Result<Self, ModelError> {
        let mut run = Self::idle(upsets)?;
        let find = |name: &str| run.model.find(name);
        let (reset, address) = (find("reset")?, find("csr_address")?);
        let (write, data) = (find("csr_write")?, find("csr_writedata")?);
        run.model.set(reset, 1)?;
        for _ in 0..RESET_CYCLES {
            run.clock()?;
        }
        run.model.set(reset, 0)?;
        run.clock()?;
        run.model.set(write, 1)?;
        for (at, value) in &upsets.writes {
            run.model.set(address, u64::from(at / 4))?;
            run.model.set(data, u64::from(*value))?;
            run.clock()?;
        }
        for signal in [write, address, data] {
            run.model.set(signal, 0)?;
        }
        run.model.set(find_ready(&run.model)?, 1)?;
        Ok(run)
    }

    /// Continues the run without a fault from a checkpoint.
    fn resume(upsets: &'a Upsets, from: &Checkpoint) -> Result<Self, ModelError> {
        let mut run = Self::idle(upsets)?;
        run.model.eval()?;
        run.model.load_registers(&from.registers)?;
        run.model.set(find_ready(&run.model)?, 1)?;
        let Progress { beats, packets, words } = from.progress;
        run.position = beats;
        run.packets = upsets.golden[..packets].to_vec();
        run.open = upsets.golden.get(packets).map(|packet| packet[..words].to_vec()).unwrap_or_default();
        Ok(run)
    }

    /// A fresh top with all inputs at 0.
    fn idle(upsets: &'a Upsets) -> Result<Self, ModelError> {
        let simulator = &upsets.simulator;
        let options = InstanceOptions { seed: 1, plusargs: simulator.plusargs().to_vec() };
        let mut model = simulator.library().instance_with(&options)?;
        // Inputs begin at random levels, too.
        let is_input = |info: &&SignalInfo| info.direction == Direction::Input;
        let inputs: Vec<String> = model.signals().iter().filter(is_input).map(|info| info.name.clone()).collect();
        for name in inputs {
            model.set(model.find(&name)?, 0)?;
        }
        let ports = Ports {
            clock: model.find("clock")?,
            video_valid: model.find("video_valid")?,
            video_ready: model.find("video_ready")?,
            video_data: model.find("video_data")?,
            video_first: model.find("video_startofpacket")?,
            video_last: model.find("video_endofpacket")?,
            feature_valid: model.find("feature_valid")?,
            feature_data: model.find("feature_data")?,
            feature_last: model.find("feature_endofpacket")?,
        };
        Ok(Self { upsets, model, ports, position: 0, packets: Vec::new(), open: Vec::new() })
    }

    /// A clock cycle without streams.
    fn clock(&mut self) -> Result<(), ModelError> {
        for level in [0, 1] {
            self.model.set(self.ports.clock, level)?;
            self.model.eval()?;
        }
        Ok(())
    }

    /// A clock cycle: pixel and fault while the clock is low, then what moves at its edge.
    fn cycle(&mut self, cycle: u64, injection: Option<&Injection>) -> Result<(), ModelError> {
        let Ports { clock, video_valid, video_ready, video_data, video_first, video_last, .. } = self.ports;
        let beat = self.upsets.beats.get(self.position).copied();
        let (pixel, first, last) = beat.unwrap_or_default();
        self.model.set(video_valid, u64::from(beat.is_some()))?;
        self.model.set(video_data, u64::from(pixel))?;
        self.model.set(video_first, u64::from(first))?;
        self.model.set(video_last, u64::from(last))?;
        self.model.set(clock, 0)?;
        if let Some(injection) = injection {
            injection.apply(&mut self.model, cycle)?;
        }
        self.model.eval()?;
        self.position += usize::from(beat.is_some() && self.model.get(video_ready) == 1);
        if self.model.get(self.ports.feature_valid) == 1 {
            self.open.extend(self.model.get_words(self.ports.feature_data));
            if self.model.get(self.ports.feature_last) == 1 {
                self.packets.push(std::mem::take(&mut self.open));
            }
        }
        self.model.set(clock, 1)?;
        self.model.eval()
    }

    fn progress(&self) -> Progress {
        Progress { beats: self.position, packets: self.packets.len(), words: self.open.len() }
    }
}

fn find_ready(model: &Model) -> Result<SignalId, ModelError> {
    model.find("feature_ready")
}

impl Upsets {
    /// Runs the frames without a fault. All are of one size, in steps of the camera; their thresholds follow the
    /// responses, from `thresholds` on, LSB of the response, as in flight. The simulator must be that of
    /// [`Simulator::with_registers`].
    ///
    /// # Errors
    /// If there are fewer than [`MIN_FRAMES`], they differ in size or have no features, or the hardware hangs.
    pub fn new(simulator: Simulator, frames: &[Plane<u16>], thresholds: &[u32]) -> Result<Self, SimulationError> {
        let refused = |why| Err(SimulationError::Frames(why));
        let Some(first) = frames.first().filter(|_| frames.len() >= MIN_FRAMES) else {
            return refused("too few frames: one before the fault and three from it on");
        };
        let size = |plane: &Plane<u16>| (plane.width(), plane.height());
        if frames.iter().any(|frame| size(frame) != size(first)) {
            return refused("the frames differ in size");
        }
        let design = simulator.design().clone();
        let mut job = Job::of(&design, first.clone(), thresholds)?;
        job.automatic = Some(design.threshold.target);
        let state = State::of(&simulator.library().instance()?);
        let writes = Map::new(&design)?.writes(&job)?;
        let pixels = first.as_slice().len();
        let beat = |(at, pixel): (usize, &u16)| (*pixel, at == 0, at + 1 == pixels);
        let beats: Vec<_> = frames.iter().flat_map(|frame| frame.as_slice().iter().enumerate().map(beat)).collect();
        // Four times what a working top takes, as the other benches wait.
        let limit = 4 * (beats.len() as u64 + 200_000);
        let distance = (limit / 4 / MAX_CHECKPOINTS).max(MIN_DISTANCE);
        let (golden, window, checkpoints) = (Vec::new(), 0..0, Vec::new());
        let mut upsets = Self { simulator, state, beats, writes, golden, window, cycles: 0, distance, checkpoints };
        let (mut checkpoints, mut begins) = (Vec::new(), Vec::new());
        let mut run = Run::start(&upsets)?;
        let mut cycle = 0;
        while run.packets.len() < frames.len() {
            if cycle > limit {
                return Err(SimulationError::Hangs { frame: run.packets.len(), cycles: cycle });
            }
            if cycle.is_multiple_of(distance) {
                let mut registers = Vec::new();
                run.model.save_registers(&mut registers);
                checkpoints.push(Checkpoint { registers, progress: run.progress() });
            }
            if run.position.is_multiple_of(pixels) && begins.len() <= run.position / pixels {
                begins.push(cycle);
            }
            run.cycle(cycle, None)?;
            cycle += 1;
        }
        let golden = run.packets;
        if golden.iter().any(|packet| packet.len() <= record_words(design.pairs())) {
            return refused("a frame has no features: take a picture with more texture");
        }
        (upsets.golden, upsets.cycles, upsets.checkpoints) = (golden, cycle, checkpoints);
        upsets.window = begins[HIT]..begins[HIT + 1];
        Ok(upsets)
    }

    /// Returns the registers and memories.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the clock cycles after the register writes in which a fault may happen.
    pub fn window(&self) -> Range<u64> {
        self.window.clone()
    }

    /// Returns the clock cycles of the run without a fault, after the register writes.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Returns the features of the frames without a fault.
    pub fn features(&self) -> usize {
        let words = record_words(self.simulator.design().pairs());
        self.golden.iter().map(|packet| (packet.len() / words).saturating_sub(1)).sum()
    }

    /// Returns the packets of the run without a fault.
    pub fn golden(&self) -> &[Packet] {
        &self.golden
    }

    /// Runs the frames with a fault.
    ///
    /// # Errors
    /// As [`Upsets::packets`].
    pub fn run(&self, fault: &Fault) -> Result<Class, SimulationError> {
        Ok(self.class(&self.packets(fault)?))
    }

    /// Returns the class of a run with these packets.
    pub fn class(&self, packets: &[Packet]) -> Class {
        class_of(self.simulator.design(), &self.golden, packets)
    }

    /// Runs the frames with a fault, and returns the packets that come out.
    ///
    /// # Errors
    /// If the model cannot be made, or the fault is not in its state.
    pub fn packets(&self, fault: &Fault) -> Result<Vec<Packet>, SimulationError> {
        let begins = fault.cycle / self.distance;
        let Some(from) = self.checkpoints.get(begins as usize) else {
            return Err(SimulationError::Frames("the fault is later than the last frame"));
        };
        let run = Run::resume(self, from)?;
        self.finish(run, begins * self.distance, fault, fault.kind == Kind::Seu)
    }

    /// Runs all frames with a fault, from the reset to the last packet. The class is that of [`Upsets::run`], which
    /// this is to show.
    ///
    /// # Errors
    /// As [`Upsets::run`].
    pub fn run_whole(&self, fault: &Fault) -> Result<Class, SimulationError> {
        Ok(self.class(&self.finish(Run::start(self)?, 0, fault, false)?))
    }

    /// Runs on with a fault until the packets are out; if `may_end`, until everything is as without the fault.
    fn finish(
        &self,
        mut run: Run<'_>,
        mut cycle: u64,
        fault: &Fault,
        may_end: bool,
    ) -> Result<Vec<Packet>, SimulationError> {
        let injection = Injection::new(&run.model, &self.state, fault)?;
        // As long again as the hit frame takes to enter.
        let limit = self.cycles + (self.window.end - self.window.start);
        let mut registers = Vec::new();
        while run.packets.len() < self.golden.len() && cycle < limit {
            if may_end && cycle > fault.cycle && cycle.is_multiple_of(self.distance) {
                let checkpoint = self.checkpoints.get((cycle / self.distance) as usize);
                if let Some(checkpoint) = checkpoint.filter(|checkpoint| checkpoint.progress == run.progress()) {
                    run.model.save_registers(&mut registers);
                    if registers == checkpoint.registers {
                        let rest = &self.golden[run.packets.len()..];
                        run.open.extend(&rest[0][run.open.len()..]);
                        run.packets.push(run.open);
                        run.packets.extend_from_slice(&rest[1..]);
                        return Ok(run.packets);
                    }
                }
            }
            run.cycle(cycle, Some(&injection))?;
            cycle += 1;
        }
        Ok(run.packets)
    }
}

/// Returns the class of a run: see the table of this module.
fn class_of(design: &DesignPoint, golden: &[Packet], packets: &[Packet]) -> Class {
    if packets.len() < golden.len() {
        return Class::Hang;
    }
    let words = record_words(design.pairs());
    let wrong: Vec<usize> = (0..golden.len()).filter(|i| packets[*i] != golden[*i]).collect();
    let Some(last) = wrong.last() else { return Class::Masked };
    if wrong.iter().all(|i| !is_sound(&packets[*i], *i as u32, words)) {
        Class::Detected
    } else if *last <= HIT + 1 {
        Class::Recovered
    } else {
        Class::Silent
    }
}

/// Returns `true` if a receiver that knows nothing else takes a packet for good: whole records, the last of them a
/// trailer and no other, with the frame's number, without error bits, and with as many features as there are.
pub fn is_sound(packet: &[u32], frame: u32, words: usize) -> bool {
    let mut records = packet.chunks_exact(words);
    let flags = u32::from(FLAG_TRAILER | if words == RECORD_WORDS { FLAG_TEN_WORDS } else { 0 });
    let is_trailer = |record: &[u32]| trailer::FLAGS.get(record) & u32::from(FLAG_TRAILER) != 0;
    let Some(last) = records.next_back() else { return false };
    records.remainder().is_empty()
        && trailer::FLAGS.get(last) == flags
        && trailer::ERRORS.get(last) == 0
        && trailer::FRAME.get(last) == frame
        && trailer::FEATURES.get(last) as usize == records.len()
        && !records.any(is_trailer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;

    /// A packet of two pairs with these responses and the number of its frame.
    fn packet(responses: &[u32], frame: u32) -> Packet {
        let feature = |response: &u32| [7 << 16 | 9, *response, 0, 0, 1, 2, 3, 4];
        let mut words: Packet = responses.iter().flat_map(feature).collect();
        words.extend([frame, u32::from(FLAG_TRAILER) << 16, responses.len() as u32, 0, 0, 0, 0, 0]);
        words
    }

    fn golden() -> Vec<Packet> {
        (0..4).map(|frame| packet(&[5, 6, 7], frame)).collect()
    }

    /// The class of a run in which the packets of these frames are others.
    fn class(changes: &[(usize, Packet)]) -> Class {
        let mut packets = golden();
        changes.iter().for_each(|(at, packet)| packets[*at] = packet.clone());
        class_of(&KT27, &golden(), &packets)
    }

    #[test]
    fn classes_follow_from_the_packets() {
        assert_eq!(class(&[]), Class::Masked);
        assert_eq!(class_of(&KT27, &golden(), &golden()[..3]), Class::Hang);
        let wrong = |frame: u32| (frame as usize, packet(&[5, 9, 7], frame));
        assert_eq!(class(&[wrong(0)]), Class::Recovered);
        assert_eq!(class(&[wrong(1), wrong(2)]), Class::Recovered);
        assert_eq!(class(&[wrong(3)]), Class::Silent);
        assert_eq!(class(&[wrong(1), wrong(3)]), Class::Silent);
        let mut flagged = packet(&[5, 9, 7], 1);
        flagged[25] |= 4;
        assert_eq!(class(&[(1, flagged.clone())]), Class::Detected);
        assert_eq!(class(&[(1, flagged.clone()), wrong(2)]), Class::Recovered, "one of them does not show it");
        assert_eq!(class(&[(1, flagged.clone()), wrong(3)]), Class::Silent);
        let late = {
            let mut packet = packet(&[5], 3);
            packet[9] |= 1;
            packet
        };
        assert_eq!(class(&[(3, late)]), Class::Detected, "however late");
    }

    #[test]
    fn a_packet_shows_what_is_wrong_with_it() {
        let whole = packet(&[5, 6], 3);
        assert!(is_sound(&whole, 3, 8));
        assert!(!is_sound(&whole, 4, 8), "another frame's number");
        assert!(!is_sound(&whole[..23], 3, 8) && !is_sound(&[], 3, 8) && !is_sound(&whole[..16], 3, 8));
        let changed = |at: usize, bits: u32| {
            let mut packet = whole.clone();
            packet[at] ^= bits;
            is_sound(&packet, 3, 8)
        };
        assert!(!changed(17, 1), "an error bit");
        assert!(!changed(17, 1 << 31) && !changed(18, 2), "the flags and the count of the trailer");
        assert!(!changed(1, u32::from(FLAG_TRAILER) << 16), "a trailer among the features");
        assert!(changed(1, 1) && changed(12, 1 << 9) && changed(19, 1), "a response, a descriptor, dropped features");
    }
}
