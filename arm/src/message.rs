//! The messages: registers, telemetry, the records of a frame, commands.
//!
//! | kind | message | payload, little-endian |
//! |---|---|---|
//! | 1 | registers | pairs of `u32`: byte address, value. The source sends all registers when it starts |
//! | 2 | telemetry | `u32` frame, `u32` 0, `u64` time in microseconds, then eight `f64`, see below |
//! | 3 | frame | the records of a packet as the hardware emits them, eight or ten `u32` each, the trailer last |
//! | 4 | command | `u32`: 1 capture a reference, 2 wide view, 3 narrow view, 4 stop, 5 renew the reference |
//! | 5 | inertial | samples of the IMU, each a `u64` time in microseconds and six `f64`, see below |
//! | 6 | pixels | `u32` frame, `u16` first row, `u16` rows, then the rows of the frame, `u16` each pixel, see below |
//! | 7 | calibration | 21 `f64`, see [`crate::calibration`] |
//!
//! The eight numbers: roll, pitch, yaw (radians), range (m), field of view (radians), and the standard errors of tilt,
//! heading (radians) and range (m). Telemetry holds the sensor readings at the exposure of the frame with that number:
//! roll, pitch and yaw as in [`hoverlock_reference::motion::orthophoto`], range along the optical axis, field of view
//! across the columns. It may arrive before or after its frame. The standard errors are the present ones of IMU and
//! laser; over rough ground the laser's includes the relief.
//!
//! The six numbers of a sample: angular velocity (rad/s) about and specific force (acceleration minus gravity, m/s^2)
//! along the camera's axes, at the time at which they were measured. The samples up to a frame are sent before its
//! telemetry, 100 to 200 of them a second. They are optional. With a bore-sight in the calibration, the axes of samples
//! and attitude are those of the inertial sensor.
//!
//! Pixels are those that the camera sends, at most 65535. The rows of a frame come in order, in as many messages as
//! they need, before its records; an odd number of pixels is followed by a zero. They are optional: where they lie in
//! memory that FPGA and processor share, the program refines positions on them, and without them it takes those of the
//! records.
//!
//! A calibration holds until the next one. One that differs from the present one makes the program forget its
//! reference, which was seen with another camera. It is optional.

use crate::framing::MAX_PAYLOAD_BYTES;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_reference::features::feature::MAX_PAIRS;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use hoverlock_registers::record::{
    FLAG_TEN_WORDS, FLAG_TRAILER, RECORD_WORDS, RecordField, TWO_PAIR_WORDS, record_words, trailer,
};

/// Kind of a message with a register block.
pub const REGISTERS: u32 = 1;
/// Kind of a message with telemetry.
pub const TELEMETRY: u32 = 2;
/// Kind of a message with the records of a frame.
pub const FRAME: u32 = 3;
/// Kind of a message with a command.
pub const COMMAND: u32 = 4;
/// Kind of a message with samples of the IMU.
pub const INERTIAL: u32 = 5;
/// Kind of a message with rows of pixels.
pub const PIXELS: u32 = 6;
/// Kind of a message with the calibration of camera and IMU.
pub const CALIBRATION: u32 = 7;

/// Size of the shorter record, that of one or two scale pairs.
pub const MIN_RECORD_BYTES: usize = 4 * TWO_PAIR_WORDS;

/// Size of a sample of the IMU.
const SAMPLE_BYTES: usize = 56;

/// Largest angular velocity of a valid sample, rad/s, and largest specific force, m/s^2.
const SAMPLE_LIMITS: [f64; 2] = [20.0, 200.0];

/// Most features that a trailer counts as dropped, and as withheld: the counters have 20 bits.
const MAX_UNSENT: u32 = (1 << 20) - 1;

/// Size of a telemetry payload.
const TELEMETRY_BYTES: usize = 80;

/// The reason to refuse a message whose checks have passed: its source is faulty or of another version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// The kind is not in the table of the module.
    #[error("message of unknown kind {0}")]
    Kind(u32),
    /// The length of the payload is not that of its kind.
    #[error("message of kind {kind} with a payload of {bytes} bytes")]
    Length {
        /// Kind of the message.
        kind: u32,
        /// Size of its payload.
        bytes: usize,
    },
    /// The command is not in the table of the module.
    #[error("unknown command {0}")]
    Command(u32),
    /// A reading, given by its name, is outside its range.
    #[error("{0} is out of its range")]
    Reading(&'static str),
    /// The last record is not a trailer, or one of its counts is not possible.
    #[error("records without their trailer")]
    Trailer,
    /// The record with this index is not a valid feature.
    #[error("record {0} is not a feature")]
    Record(usize),
}

/// A block of register values, borrowed from a payload.
#[derive(Debug, Clone, Copy)]
pub struct Registers<'a>(&'a [u8]);

impl<'a> Registers<'a> {
    /// Wraps a payload, without copying it.
    ///
    /// # Errors
    /// If the length of the payload is not a multiple of 8 bytes.
    pub fn parse(payload: &'a [u8]) -> Result<Self, MessageError> {
        let valid = payload.len().is_multiple_of(8);
        if valid { Ok(Self(payload)) } else { Err(MessageError::Length { kind: REGISTERS, bytes: payload.len() }) }
    }

    /// Returns the value of the register at a byte address, or `None` if the block does not contain it.
    pub fn get(&self, address: u32) -> Option<u32> {
        self.0.chunks_exact(8).find(|pair| word(pair, 0) == address).map(|pair| word(pair, 1))
    }
}

/// Encodes pairs of byte address and value as the payload of a register block.
pub fn encode_registers(registers: &[(u32, u32)]) -> Vec<u8> {
    registers.iter().flat_map(|(address, value)| [*address, *value]).flat_map(u32::to_le_bytes).collect()
}

/// The sensor readings at the exposure of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telemetry {
    /// Number of the frame, as in its trailer.
    pub frame: u32,
    /// Time of the exposure, microseconds.
    pub time_us: u64,
    /// Attitude of the camera, radians.
    pub attitude: Attitude,
    /// Range along the optical axis, m.
    pub range: f64,
    /// Field of view across the columns, radians.
    pub field_of_view: f64,
    /// Standard errors of the readings.
    pub sensors: SensorErrors,
}

impl Telemetry {
    /// Decodes a payload.
    ///
    /// # Errors
    /// If the length is wrong, or a reading is out of range: not finite, roll or pitch of a right angle or more, yaw
    /// above a full turn, a range outside (0, 100) km, a field of view outside 1 mrad to 180 degrees, a standard error
    /// of 0 or less.
    pub fn parse(payload: &[u8]) -> Result<Self, MessageError> {
        let bytes: &[u8; TELEMETRY_BYTES] =
            payload.try_into().map_err(|_| MessageError::Length { kind: TELEMETRY, bytes: payload.len() })?;
        let long = |i: usize| u64::from(word(bytes, i)) | u64::from(word(bytes, i + 1)) << 32;
        let reading = |i: usize, name: &'static str, valid: fn(f64) -> bool| {
            let value = f64::from_bits(long(4 + 2 * i));
            if value.is_finite() && valid(value) { Ok(value) } else { Err(MessageError::Reading(name)) }
        };
        let error: fn(f64) -> bool = |sigma| sigma > 0.0;
        let tilt: fn(f64) -> bool = |angle| angle.abs() < std::f64::consts::FRAC_PI_2;
        Ok(Self {
            frame: word(bytes, 0),
            time_us: long(2),
            attitude: Attitude {
                roll: reading(0, "roll", tilt)?,
                pitch: reading(1, "pitch", tilt)?,
                yaw: reading(2, "yaw", |angle| angle.abs() <= std::f64::consts::TAU)?,
            },
            range: reading(3, "range", |range| range > 0.0 && range < 1e5)?,
            field_of_view: reading(4, "field of view", |angle| angle > 1e-3 && angle < std::f64::consts::PI)?,
            sensors: SensorErrors {
                tilt: reading(5, "the standard error of tilt", error)?,
                heading: reading(6, "the standard error of heading", error)?,
                range: reading(7, "the standard error of range", error)?,
            },
        })
    }

    /// Encodes the telemetry as a payload.
    pub fn encode(&self) -> Vec<u8> {
        let Attitude { roll, pitch, yaw } = self.attitude;
        let mut payload = Vec::with_capacity(TELEMETRY_BYTES);
        payload.extend(u64::from(self.frame).to_le_bytes());
        payload.extend(self.time_us.to_le_bytes());
        let SensorErrors { tilt, heading, range } = self.sensors;
        let readings = [roll, pitch, yaw, self.range, self.field_of_view, tilt, heading, range];
        payload.extend(readings.iter().flat_map(|reading| reading.to_le_bytes()));
        payload
    }
}

/// Angular velocity and specific force at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialSample {
    /// Time of the measurement, microseconds.
    pub time_us: u64,
    /// Angular velocity about the camera's axes, rad/s.
    pub rates: [f64; 3],
    /// Specific force (acceleration minus gravity) along the camera's axes, m/s^2.
    pub force: [f64; 3],
}

/// Samples of the IMU, borrowed from a payload.
#[derive(Debug, Clone, Copy)]
pub struct Inertial<'a>(&'a [u8]);

impl<'a> Inertial<'a> {
    /// Wraps a payload, without copying it.
    ///
    /// # Errors
    /// If the payload has no whole number of samples, or a value is not finite or above its limit: 20 rad/s, 200
    /// m/s^2.
    pub fn parse(payload: &'a [u8]) -> Result<Self, MessageError> {
        if !payload.len().is_multiple_of(SAMPLE_BYTES) {
            return Err(MessageError::Length { kind: INERTIAL, bytes: payload.len() });
        }
        let inertial = Self(payload);
        let within = |values: &[f64; 3], limit: f64| values.iter().all(|value| value.abs() <= limit);
        let [rate, force] = SAMPLE_LIMITS;
        if !inertial.samples().all(|sample| within(&sample.rates, rate)) {
            return Err(MessageError::Reading("the angular velocity"));
        }
        if !inertial.samples().all(|sample| within(&sample.force, force)) {
            return Err(MessageError::Reading("the specific force"));
        }
        Ok(inertial)
    }

    /// Returns the samples in order.
    pub fn samples(&self) -> impl Iterator<Item = InertialSample> + use<'a> {
        self.0.chunks_exact(SAMPLE_BYTES).map(|bytes| {
            let long = |i: usize| u64::from(word(bytes, 2 * i)) | u64::from(word(bytes, 2 * i + 1)) << 32;
            let three = |first: usize| std::array::from_fn(|axis| f64::from_bits(long(first + axis)));
            InertialSample { time_us: long(0), rates: three(1), force: three(4) }
        })
    }
}

/// Samples of the IMU that a message can hold.
pub const MAX_INERTIAL_SAMPLES: usize = MAX_PAYLOAD_BYTES / SAMPLE_BYTES;

/// Encodes samples of the IMU, at most [`MAX_INERTIAL_SAMPLES`], as a payload.
pub fn encode_inertial(samples: &[InertialSample]) -> Vec<u8> {
    let values = |sample: &InertialSample| sample.rates.into_iter().chain(sample.force);
    let bytes = |sample| values(sample).flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    samples.iter().flat_map(|sample| sample.time_us.to_le_bytes().into_iter().chain(bytes(sample))).collect()
}

/// Size of what precedes the pixels in a message.
const STRIP_HEADER_BYTES: usize = 8;

/// Rows of a frame, borrowed from a payload.
#[derive(Debug, Clone, Copy)]
pub struct Strip<'a> {
    /// Number of the frame, as in its trailer.
    pub frame: u32,
    /// Index of the first row.
    pub first_row: usize,
    /// Number of rows.
    pub rows: usize,
    samples: &'a [u8],
}

impl<'a> Strip<'a> {
    /// Reads a payload of rows that have `columns` pixels.
    ///
    /// # Errors
    /// If its length is not that of its rows.
    pub fn parse(payload: &'a [u8], columns: usize) -> Result<Self, MessageError> {
        let wrong = MessageError::Length { kind: PIXELS, bytes: payload.len() };
        let (header, samples) = payload.split_at_checked(STRIP_HEADER_BYTES).ok_or(wrong)?;
        let rows = (word(header, 1) >> 16) as usize;
        let bytes = 2 * rows * columns;
        if samples.len() != bytes.next_multiple_of(4) {
            return Err(wrong);
        }
        let first_row = (word(header, 1) & 0xffff) as usize;
        Ok(Self { frame: word(header, 0), first_row, rows, samples: &samples[..bytes] })
    }

    /// Returns the pixels in raster order.
    pub fn pixels(&self) -> impl Iterator<Item = u16> + use<'a> {
        self.samples.chunks_exact(2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]))
    }
}

/// Encodes a frame of at most 65535 rows as the payloads of messages with rows of pixels.
pub fn encode_pixels(frame: u32, picture: &Plane<u16>) -> Vec<Vec<u8>> {
    let columns = picture.width();
    let rows = ((MAX_PAYLOAD_BYTES - STRIP_HEADER_BYTES) / (2 * columns)).max(1);
    let strip = |(index, samples): (usize, &[u16])| {
        let place = ((samples.len() / columns) << 16) | (index * rows);
        let mut payload: Vec<u8> = [frame, place as u32].into_iter().flat_map(u32::to_le_bytes).collect();
        payload.extend(samples.iter().flat_map(|pixel| pixel.to_le_bytes()));
        payload.resize(payload.len().next_multiple_of(4), 0);
        payload
    };
    picture.as_slice().chunks(rows * columns).enumerate().map(strip).collect()
}

/// Thresholds of the scale pairs in a trailer.
const THRESHOLDS: [RecordField; MAX_PAIRS] = [trailer::THRESHOLD_0, trailer::THRESHOLD_1, trailer::THRESHOLD_2];

/// The trailer: the last record of a frame's packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trailer {
    /// Frame number: frames finished since reset.
    pub frame: u32,
    /// Error bits, `ERROR_..` of [`hoverlock_registers::record`]. With any of them the features are unusable.
    pub errors: u16,
    /// Features in the packet.
    pub count: u32,
    /// Features that the hardware had to drop for lack of room.
    pub dropped: u32,
    /// Features that the hardware withheld because of the register `record_limit`.
    pub withheld: u32,
    /// Threshold of each scale pair, LSB of the response; 0 for pairs that the design does not have.
    pub thresholds: [u16; MAX_PAIRS],
}

impl Trailer {
    /// Reads the bytes of a record of `words` words; returns `None` if it is not a trailer.
    fn parse(bytes: &[u8], words: usize) -> Option<Self> {
        let record: [u32; TWO_PAIR_WORDS] = std::array::from_fn(|index| word(bytes, index));
        let half = |field: RecordField| field.get(&record) as u16;
        let is_count = |field: RecordField| field.get(&record) <= MAX_UNSENT;
        let is_trailer = trailer::FLAGS.get(&record) == trailer_flags(words)
            && is_count(trailer::DROPPED)
            && is_count(trailer::WITHHELD);
        is_trailer.then(|| Self {
            frame: trailer::FRAME.get(&record),
            errors: half(trailer::ERRORS),
            count: trailer::FEATURES.get(&record),
            dropped: trailer::DROPPED.get(&record),
            withheld: trailer::WITHHELD.get(&record),
            thresholds: THRESHOLDS.map(half),
        })
    }

    fn pack(&self, words: usize) -> [u32; RECORD_WORDS] {
        let mut record = [0; RECORD_WORDS];
        trailer::FRAME.put(&mut record, self.frame);
        trailer::ERRORS.put(&mut record, self.errors.into());
        trailer::FLAGS.put(&mut record, trailer_flags(words));
        trailer::FEATURES.put(&mut record, self.count);
        trailer::DROPPED.put(&mut record, self.dropped);
        trailer::WITHHELD.put(&mut record, self.withheld);
        for (field, threshold) in THRESHOLDS.into_iter().zip(self.thresholds) {
            field.put(&mut record, threshold.into());
        }
        record
    }
}

/// Returns the flags in the trailer of a packet whose records have `words` words.
fn trailer_flags(words: usize) -> u32 {
    u32::from(if words == RECORD_WORDS { FLAG_TRAILER | FLAG_TEN_WORDS } else { FLAG_TRAILER })
}

/// The packet of a frame: its feature records and trailer, borrowed from a payload.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// The trailer, decoded.
    pub trailer: Trailer,
    records: &'a [u8],
    /// Words of each record, 8 or 10.
    words: usize,
}

impl<'a> Frame<'a> {
    /// Reads a payload: whole records, the trailer last, with as many features as it counts. The length of the records
    /// follows from the trailer: in one of ten words, the word at the place of the flags of one of eight words is the
    /// count of dropped features. That count has 20 bits, so it cannot equal the flags.
    ///
    /// # Errors
    /// If the payload has no whole number of records, no trailer, or another number of features than the trailer
    /// counts.
    pub fn parse(payload: &'a [u8]) -> Result<Self, MessageError> {
        let whole = |words: &usize| !payload.is_empty() && payload.len().is_multiple_of(4 * words);
        let lengths = [TWO_PAIR_WORDS, RECORD_WORDS].into_iter().filter(whole);
        if lengths.clone().next().is_none() {
            return Err(MessageError::Length { kind: FRAME, bytes: payload.len() });
        }
        let parsed = |words: usize| {
            let (records, last) = payload.split_at(payload.len() - 4 * words);
            Trailer::parse(last, words).map(|trailer| Self { trailer, records, words })
        };
        let frame = lengths.clone().find_map(parsed).ok_or(MessageError::Trailer)?;
        if frame.trailer.count as usize != frame.records.len() / (4 * frame.words) {
            return Err(MessageError::Trailer);
        }
        Ok(frame)
    }

    /// Returns the features in order. A record that is not a feature gives an error with its index.
    pub fn features(&self) -> impl Iterator<Item = Result<FeatureRecord, MessageError>> {
        let words = self.words;
        let records = self.records.chunks_exact(4 * words).enumerate();
        records.map(move |(i, bytes)| {
            let record: [u32; RECORD_WORDS] = std::array::from_fn(|at| if at < words { word(bytes, at) } else { 0 });
            FeatureRecord::unpack(&record[..words]).ok_or(MessageError::Record(i))
        })
    }
}

/// Returns the largest number of features that a message holds beside the trailer. A packet of three scale pairs has
/// longer records.
pub const fn max_features(pairs: usize) -> usize {
    MAX_PAYLOAD_BYTES / (4 * record_words(pairs)) - 1
}

/// Features that the hardware found and did not send.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Unsent {
    /// Dropped for lack of room.
    pub dropped: u32,
    /// Withheld because of the register `record_limit`.
    pub withheld: u32,
}

/// Encodes the payload of a frame: its features, then the trailer. `thresholds` has one element for each scale pair;
/// records of three pairs have ten words, others eight. Features beyond [`max_features`] are left out, and counted as
/// withheld.
pub fn encode_frame(
    frame: u32,
    features: &[FeatureRecord],
    errors: u16,
    unsent: Unsent,
    thresholds: &[u32],
) -> Vec<u8> {
    let words = record_words(thresholds.len());
    let (features, beyond) = features.split_at(features.len().min(max_features(thresholds.len())));
    let (count, beyond) = (features.len() as u32, beyond.len() as u32);
    let thresholds = std::array::from_fn(|k| thresholds.get(k).map_or(0, |threshold| *threshold as u16));
    let Unsent { dropped, withheld } = unsent;
    let trailer = Trailer { frame, errors, count, dropped, withheld: withheld + beyond, thresholds };
    let records = features.iter().map(FeatureRecord::pack).chain([trailer.pack(words)]);
    records.flat_map(|record| record.into_iter().take(words)).flat_map(u32::to_le_bytes).collect()
}

/// A command of the pilot or the control system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// The next frame becomes the reference, and the origin of the displacement.
    Capture,
    /// The next frame with an estimate becomes the reference; the origin of the displacement stays.
    Renew,
    /// The camera zooms to its wide view.
    Wide,
    /// The camera zooms to its narrow view.
    Narrow,
    /// The program ends.
    Stop,
}

impl Command {
    /// Decodes a payload.
    ///
    /// # Errors
    /// If the length is wrong or the command is not in the table of the module.
    pub fn parse(payload: &[u8]) -> Result<Self, MessageError> {
        let bytes: [u8; 4] =
            payload.try_into().map_err(|_| MessageError::Length { kind: COMMAND, bytes: payload.len() })?;
        match u32::from_le_bytes(bytes) {
            1 => Ok(Self::Capture),
            2 => Ok(Self::Wide),
            3 => Ok(Self::Narrow),
            4 => Ok(Self::Stop),
            5 => Ok(Self::Renew),
            other => Err(MessageError::Command(other)),
        }
    }

    /// Encodes the command as a payload.
    pub fn encode(self) -> [u8; 4] {
        let code: u32 = match self {
            Self::Capture => 1,
            Self::Wide => 2,
            Self::Narrow => 3,
            Self::Stop => 4,
            Self::Renew => 5,
        };
        code.to_le_bytes()
    }
}

/// Reads the little-endian word with an index.
fn word(bytes: &[u8], index: usize) -> u32 {
    let at = 4 * index;
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TELEMETRY: Telemetry = Telemetry {
        frame: 7,
        time_us: 1 << 40,
        attitude: Attitude { roll: 0.01, pitch: -0.02, yaw: 3.0 },
        range: 100.0,
        field_of_view: 0.87,
        sensors: SensorErrors { tilt: 0.0035, heading: 0.01, range: 0.1 },
    };

    proptest! {
        /// No payload makes a reader panic.
        #[test]
        fn any_payload_is_read_or_refused(
            payload in prop::collection::vec(any::<u8>(), 0..200), columns in 0..70_000usize,
        ) {
            let _ = Telemetry::parse(&payload);
            let _ = Strip::parse(&payload, columns).map(|strip| strip.pixels().count());
            let _ = Command::parse(&payload);
            if let Ok(block) = Registers::parse(&payload) {
                block.get(0);
            }
            if let Ok(frame) = Frame::parse(&payload) {
                frame.features().count();
            }
        }
    }

    #[test]
    fn decoding_inverts_encoding() {
        assert_eq!(Telemetry::parse(&TELEMETRY.encode()), Ok(TELEMETRY));
        for command in [Command::Capture, Command::Wide, Command::Narrow, Command::Stop, Command::Renew] {
            assert_eq!(Command::parse(&command.encode()), Ok(command));
        }
        let payload = encode_registers(&[(0x10, 5), (0x14, 6)]);
        let block = Registers::parse(&payload).unwrap();
        assert_eq!([block.get(0x10), block.get(0x14), block.get(0x18)], [Some(5), Some(6), None]);
        let mut words = [3, 1 << 16 | 9, 0, 0, 1, 2, 3, 4];
        let feature = FeatureRecord::unpack(&words).unwrap();
        let payload = encode_frame(4, &[feature], 2, Unsent { dropped: 6, withheld: 7 }, &[100, 200]);
        let frame = Frame::parse(&payload).unwrap();
        assert_eq!(
            frame.trailer,
            Trailer { frame: 4, errors: 2, count: 1, dropped: 6, withheld: 7, thresholds: [100, 200, 0] }
        );
        assert!(frame.features().eq([Ok(feature)]));
        // Bit 20 is a flag that no feature has.
        words[1] |= 1 << 20;
        let payload: Vec<u8> =
            words.iter().flat_map(|w| w.to_le_bytes()).chain(payload[MIN_RECORD_BYTES..].iter().copied()).collect();
        assert!(Frame::parse(&payload).unwrap().features().eq([Err(MessageError::Record(0))]));
    }

    proptest! {
        /// The rows of a frame are those that were encoded, in order, and no other length of a row reads them.
        #[test]
        fn rows_of_pixels_are_read_as_they_were_sent(width in 1..5000usize, height in 1..80usize, seed: u16) {
            let picture = Plane::from_fn(width, height, |x, y| (x * 31 + y * 7) as u16 ^ seed);
            let (mut pixels, mut next) = (Vec::new(), 0);
            for payload in encode_pixels(9, &picture) {
                prop_assert!(payload.len() <= MAX_PAYLOAD_BYTES && payload.len().is_multiple_of(4));
                let strip = Strip::parse(&payload, width).unwrap();
                prop_assert_eq!((strip.frame, strip.first_row), (9, next));
                next += strip.rows;
                pixels.extend(strip.pixels());
                prop_assert!(Strip::parse(&payload, width + 2).is_err());
            }
            prop_assert_eq!((next, pixels), (height, picture.into_vec()));
        }
    }

    proptest! {
        /// Payloads of both record lengths can have the same size: 4 records of ten words and 5 of eight.
        #[test]
        fn the_trailer_determines_the_length_of_the_records(
            words in prop::array::uniform10(any::<u32>()), ten: bool, features in 0..21usize, dropped in 0..1u32 << 20,
        ) {
            let mut words = words;
            words[1] &= 0x3_ffff;
            if words[1] >> 16 == 3 || !ten {
                words[8..].fill(0);
            }
            let length = if ten { 10 } else { 8 };
            let feature = FeatureRecord::unpack(&words[..length]).unwrap();
            let thresholds = &[5, 6, 7][..if ten { 3 } else { 2 }];
            let payload = encode_frame(9, &vec![feature; features], 0, Unsent { dropped, withheld: 0 }, thresholds);
            prop_assert_eq!(payload.len(), 4 * length * (features + 1));
            let frame = Frame::parse(&payload).unwrap();
            prop_assert_eq!(frame.trailer.thresholds, [5, 6, if ten { 7 } else { 0 }]);
            prop_assert_eq!((frame.trailer.count as usize, frame.trailer.dropped), (features, dropped));
            prop_assert!(frame.features().eq(vec![Ok(feature); features]));
        }
    }

    /// A frame of any number of features has a message, whose trailer counts those that are not in it.
    #[test]
    fn features_beyond_a_message_are_counted() {
        let feature = FeatureRecord::unpack(&[0; 8]).unwrap();
        for thresholds in [&[1, 1][..], &[1, 1, 1]] {
            let most = max_features(thresholds.len());
            for found in [most - 1, most, most + 1, 20_000] {
                let unsent = Unsent { dropped: 3, withheld: 5 };
                let payload = encode_frame(0, &vec![feature; found], 0, unsent, thresholds);
                let trailer = Frame::parse(&payload).unwrap().trailer;
                assert!(payload.len() <= MAX_PAYLOAD_BYTES && trailer.count as usize == found.min(most));
                assert_eq!((trailer.dropped, trailer.withheld as usize), (3, 5 + found.saturating_sub(most)));
            }
        }
    }

    #[test]
    fn readings_out_of_range_are_refused() {
        let refused = |telemetry: Telemetry, name| {
            assert_eq!(Telemetry::parse(&telemetry.encode()), Err(MessageError::Reading(name)));
        };
        refused(Telemetry { range: 0.0, ..TELEMETRY }, "range");
        refused(Telemetry { range: f64::NAN, ..TELEMETRY }, "range");
        refused(Telemetry { field_of_view: 3.2, ..TELEMETRY }, "field of view");
        refused(Telemetry { attitude: Attitude { roll: 1.6, ..TELEMETRY.attitude }, ..TELEMETRY }, "roll");
        refused(Telemetry { attitude: Attitude { pitch: f64::INFINITY, ..TELEMETRY.attitude }, ..TELEMETRY }, "pitch");
        refused(
            Telemetry { sensors: SensorErrors { range: 0.0, ..TELEMETRY.sensors }, ..TELEMETRY },
            "the standard error of range",
        );
        refused(Telemetry { attitude: Attitude { yaw: 7.0, ..TELEMETRY.attitude }, ..TELEMETRY }, "yaw");
    }

    #[test]
    fn a_frame_without_its_trailer_is_refused() {
        let payload = encode_frame(4, &[], 0, Unsent::default(), &[1, 1]);
        assert_eq!(Frame::parse(&payload).map(|f| f.trailer.count), Ok(0));
        let feature = FeatureRecord::unpack(&[0; 8]).unwrap();
        let payload = encode_frame(4, &[feature, feature], 0, Unsent::default(), &[1, 1]);
        assert_eq!(Frame::parse(&payload[MIN_RECORD_BYTES..]).map(|_| ()), Err(MessageError::Trailer));
        assert_eq!(Frame::parse(&payload[..2 * MIN_RECORD_BYTES]).map(|_| ()), Err(MessageError::Trailer));
        assert!(Frame::parse(&payload[4..]).is_err() && Frame::parse(&[]).is_err());
    }

    #[test]
    fn a_count_that_no_counter_reaches_is_refused() {
        for (dropped, withheld) in [(1 << 20, 0), (0, 1 << 20), (u32::MAX, u32::MAX)] {
            let payload = encode_frame(4, &[], 0, Unsent { dropped, withheld }, &[1, 1]);
            assert_eq!(Frame::parse(&payload).map(|_| ()), Err(MessageError::Trailer), "{dropped}, {withheld}");
        }
    }
}
