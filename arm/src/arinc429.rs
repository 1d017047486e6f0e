//! ARINC 429 words that control the camera: label, SDI, data, SSM, odd parity.
//!
//! | bits | part | |
//! |---|---|---|
//! | 1-8 | label | an octal number, its most significant bit first |
//! | 9-10 | SDI | which camera; 0 is all of them |
//! | 11-29 | data | |
//! | 30-31 | SSM | 3 is normal operation in a binary word (BNR), 0 in a discrete one |
//! | 32 | parity | the number of ones in the word is odd |
//!
//! Bit 1 is the first on the wire, and bit 0 of the `u32` here. So the low byte is the label with its bits reversed,
//! and a transmitter that shifts the least significant bit out first sends the word as it is.
//!
//! | label | word | data |
//! |---|---|---|
//! | 0o301 | zoom | BNR: bit 29 the sign, 0; bits 28-11 the field of view, bit 28 worth 32 degrees; 5.4 to 50 degrees |
//! | 0o302 | exposure | BNR: bit 29 the sign, 0; bits 28-11 the time, bit 28 worth 65536 us; 1 to 66 667 us |
//! | 0o303 | mode | discrete: bits 12-11 the mode, the others 0: 0 standby, 1 free run, 2 triggered |
//!
//! The interface document of the camera is not public. Labels and scales are assumptions and are defined only in this
//! file. The layout of words is that of ARINC specification 429 part 1.

/// The camera to which a word is addressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Camera {
    /// All cameras, SDI 0.
    All,
    /// The camera with this SDI: 1, 2 or 3.
    One(u8),
}

/// A setting of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// Field of view across the columns, degrees; a multiple of 2^-12.
    Zoom(f64),
    /// Exposure time, microseconds; a multiple of 0.5.
    Exposure(f64),
    /// Trigger mode.
    Mode(Mode),
}

/// The trigger mode of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// No frames are taken.
    Standby,
    /// Frames are taken at the camera's own rate.
    FreeRun,
    /// A frame is taken at each trigger.
    Triggered,
}

/// The reason why a word cannot be encoded or decoded.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WordError {
    /// The number of ones in the word is even.
    #[error("word 0x{0:08x} has even parity")]
    Parity(u32),
    /// The label is not in the table of the module.
    #[error("label 0o{0:03o} is not a control of the camera")]
    Label(u8),
    /// The sign/status bits mark the data as invalid.
    #[error("SSM {0} is not that of normal operation")]
    Ssm(u32),
    /// The value is outside the camera's range.
    #[error("{what} of {value} {unit} is outside {min} to {max}")]
    Range {
        /// Name of the quantity, with its article.
        what: &'static str,
        /// Value that was given.
        value: f64,
        /// Unit of the value and its limits.
        unit: &'static str,
        /// Smallest value that the camera accepts.
        min: f64,
        /// Largest value that the camera accepts.
        max: f64,
    },
    /// The data bits of a mode word are not a mode.
    #[error("data 0x{0:05x} is not a mode")]
    Mode(u32),
    /// The sign bit is set.
    #[error("the value is negative")]
    Negative,
    /// No SDI addresses this camera alone: SDI has two bits, and 0 means all cameras.
    #[error("camera {0} is not one of 1, 2 and 3")]
    Camera(u8),
}

/// The format of a binary (BNR) word: label, value of bit 11, and the range that the camera accepts.
struct Binary {
    label: u8,
    what: &'static str,
    unit: &'static str,
    lsb: f64,
    min: f64,
    max: f64,
}

const ZOOM: Binary =
    Binary { label: 0o301, what: "a field of view", unit: "degrees", lsb: 1.0 / 4096.0, min: 5.4, max: 50.0 };
const EXPOSURE: Binary =
    Binary { label: 0o302, what: "an exposure", unit: "microseconds", lsb: 0.5, min: 1.0, max: 66_667.0 };
const MODE_LABEL: u8 = 0o303;

/// SSM of a binary word in normal operation.
const BINARY_NORMAL: u32 = 3;
/// SSM of a discrete word in normal operation.
const DISCRETE_NORMAL: u32 = 0;

impl Binary {
    /// Returns the data bits of the nearest value that can be sent.
    fn data(&self, value: f64) -> Result<u32, WordError> {
        let steps = (value / self.lsb).round();
        self.check(steps * self.lsb, value)?;
        Ok(steps as u32)
    }

    fn value(&self, data: u32) -> Result<f64, WordError> {
        if data >> 18 != 0 {
            return Err(WordError::Negative);
        }
        let value = f64::from(data) * self.lsb;
        self.check(value, value)?;
        Ok(value)
    }

    /// Accepts half a step beyond the range, so that the ends of the range can be sent.
    fn check(&self, nearest: f64, value: f64) -> Result<(), WordError> {
        let Self { what, unit, lsb, min, max, .. } = *self;
        let within = nearest >= min - lsb / 2.0 && nearest <= max + lsb / 2.0;
        if within { Ok(()) } else { Err(WordError::Range { what, value, unit, min, max }) }
    }
}

/// Encodes a setting as a word. Values are rounded to the nearest step.
///
/// # Errors
/// If the value is outside the camera's range or the camera number is not 1, 2 or 3.
pub fn encode(camera: Camera, control: Control) -> Result<u32, WordError> {
    let sdi = match camera {
        Camera::All => 0,
        Camera::One(number @ 1..=3) => u32::from(number),
        Camera::One(number) => return Err(WordError::Camera(number)),
    };
    let (label, data, ssm) = match control {
        Control::Zoom(degrees) => (ZOOM.label, ZOOM.data(degrees)?, BINARY_NORMAL),
        Control::Exposure(time) => (EXPOSURE.label, EXPOSURE.data(time)?, BINARY_NORMAL),
        Control::Mode(mode) => (MODE_LABEL, mode as u32, DISCRETE_NORMAL),
    };
    let word = u32::from(label.reverse_bits()) | sdi << 8 | data << 10 | ssm << 29;
    let parity = u32::from(word.count_ones().is_multiple_of(2));
    Ok(word | parity << 31)
}

/// Decodes a word into the addressed camera and the setting.
///
/// # Errors
/// If [`encode`] cannot produce the word.
pub fn decode(word: u32) -> Result<(Camera, Control), WordError> {
    if word.count_ones().is_multiple_of(2) {
        return Err(WordError::Parity(word));
    }
    let label = (word as u8).reverse_bits();
    let camera = match (word >> 8 & 3) as u8 {
        0 => Camera::All,
        number => Camera::One(number),
    };
    let (data, ssm) = (word >> 10 & 0x7_ffff, word >> 29 & 3);
    let normal = |expected: u32| if ssm == expected { Ok(()) } else { Err(WordError::Ssm(ssm)) };
    let control = if label == ZOOM.label {
        normal(BINARY_NORMAL)?;
        Control::Zoom(ZOOM.value(data)?)
    } else if label == EXPOSURE.label {
        normal(BINARY_NORMAL)?;
        Control::Exposure(EXPOSURE.value(data)?)
    } else if label == MODE_LABEL {
        normal(DISCRETE_NORMAL)?;
        let modes = [Mode::Standby, Mode::FreeRun, Mode::Triggered];
        Control::Mode(*modes.get(data as usize).ok_or(WordError::Mode(data))?)
    } else {
        return Err(WordError::Label(label));
    };
    Ok((camera, control))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn control() -> impl Strategy<Value = Control> {
        prop_oneof![
            (5.4..=50.0).prop_map(Control::Zoom),
            (1.0..=66_667.0).prop_map(Control::Exposure),
            prop::sample::select(vec![Mode::Standby, Mode::FreeRun, Mode::Triggered]).prop_map(Control::Mode),
        ]
    }

    fn camera() -> impl Strategy<Value = Camera> {
        prop_oneof![Just(Camera::All), (1..=3u8).prop_map(Camera::One)]
    }

    /// Built bit by bit from the table, not by the code's shifts: first on the wire first.
    #[test]
    fn the_wire_has_the_bits_of_the_table() {
        let wire = |word: u32| -> String { (0..32).map(|i| if word >> i & 1 == 1 { '1' } else { '0' }).collect() };
        // Label 0o301 = 11 000 001; SDI 2, its low bit first; 32 degrees is bit 28 alone; SSM 3; seven ones, so
        // parity 0.
        let word = encode(Camera::One(2), Control::Zoom(32.0)).unwrap();
        assert_eq!(wire(word), "11000001 01 0000000000000000010 11 0".replace(' ', ""));
        // Label 0o303 = 11 000 011; all; triggered is 2; SSM 0; five ones, so parity 0.
        let word = encode(Camera::All, Control::Mode(Mode::Triggered)).unwrap();
        assert_eq!(wire(word), "11000011 00 0100000000000000000 00 0".replace(' ', ""));
        // Label 0o302 = 11 000 010; 0.5 microseconds a step, 3 us = 6 steps; SSM 3; seven ones.
        let word = encode(Camera::All, Control::Exposure(3.0)).unwrap();
        assert_eq!(wire(word), "11000010 00 0110000000000000000 11 0".replace(' ', ""));
        // One more one, so parity 1.
        let word = encode(Camera::One(1), Control::Exposure(3.0)).unwrap();
        assert_eq!(wire(word), "11000010 10 0110000000000000000 11 1".replace(' ', ""));
    }

    #[test]
    fn values_out_of_range_are_not_sent() {
        for control in [
            Control::Zoom(5.3),
            Control::Zoom(50.1),
            Control::Zoom(f64::NAN),
            Control::Exposure(0.0),
            Control::Exposure(1e9),
        ] {
            assert!(matches!(encode(Camera::All, control), Err(WordError::Range { .. })), "{control:?}");
        }
        for number in [0, 4] {
            assert_eq!(encode(Camera::One(number), Control::Zoom(10.0)), Err(WordError::Camera(number)));
        }
        for end in [5.4, 50.0] {
            assert!(decode(encode(Camera::All, Control::Zoom(end)).unwrap()).is_ok());
        }
    }

    /// Each fault in a valid word, with corrected parity so that the fault itself is detected.
    #[test]
    fn each_fault_is_reported() {
        let mended = |word: u32| word ^ u32::from(word.count_ones().is_multiple_of(2)) << 31;
        let zoom = encode(Camera::All, Control::Zoom(20.0)).unwrap();
        assert_eq!(decode(zoom ^ 1 << 31), Err(WordError::Parity(zoom ^ 1 << 31)));
        for ssm in 0..3 {
            assert_eq!(decode(mended(zoom & !(3 << 29) | ssm << 29)), Err(WordError::Ssm(ssm)));
        }
        assert_eq!(decode(mended(zoom | 1 << 28)), Err(WordError::Negative));
        assert!(matches!(decode(mended(zoom | 1 << 27)), Err(WordError::Range { .. })));
        assert_eq!(decode(mended(zoom ^ 1 << 7)), Err(WordError::Label(0o300)));
        let mode = encode(Camera::All, Control::Mode(Mode::Standby)).unwrap();
        assert_eq!(decode(mended(mode | 3 << 10)), Err(WordError::Mode(3)));
        assert_eq!(decode(mended(mode | 1 << 28)), Err(WordError::Mode(1 << 18)));
    }

    proptest! {
        #[test]
        fn what_is_sent_is_received(camera in camera(), control in control()) {
            let (to, received) = decode(encode(camera, control).unwrap()).unwrap();
            prop_assert_eq!(to, camera);
            match (control, received) {
                (Control::Zoom(sent), Control::Zoom(got)) => prop_assert!((sent - got).abs() <= ZOOM.lsb / 2.0),
                (Control::Exposure(sent), Control::Exposure(got)) => {
                    prop_assert!((sent - got).abs() <= EXPOSURE.lsb / 2.0);
                }
                _ => prop_assert_eq!(control, received),
            }
        }

        /// Every word is refused or encodes back to itself; a single wrong bit is always refused.
        #[test]
        fn a_malformed_word_is_refused(
            word in any::<u32>(), camera in camera(), control in control(), bit in 0..32u32,
        ) {
            if let Ok((camera, control)) = decode(word) {
                prop_assert_eq!(encode(camera, control), Ok(word));
            }
            prop_assert!(decode(encode(camera, control).unwrap() ^ 1 << bit).is_err());
        }
    }
}
