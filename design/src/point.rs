//! The design point: all parameters of the hardware, with the table of their keys.

use serde::Serialize;

use crate::key::{Field, IntegerBits, Key, Kind, Length, NamedField, field, named};
use crate::{Format, Protection, SmootherKind};

/// Integer bits of a DoG magnitude in DN: its range is `FS/4 = 2^14` DN.
const DOG_RANGE_BITS: i8 = 14;

/// Bits of full scale in DN.
const DN_BITS: u32 = 16;

/// Largest number of scale pairs.
pub const MAX_SCALE_PAIRS: u32 = 3;

/// Largest radius of a ring, px.
pub const MAX_RING_RADIUS: u32 = 16;

/// Largest number of fraction bits of a filter coefficient. Its product with a 32-bit sample plus the rounding half
/// fits 64 bits.
pub const MAX_FRACTION_BITS: u32 = 31;

/// Target and initial value of the automatic threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct AutomaticThreshold {
    /// Number of features of one scale pair in one frame that the threshold is adjusted to.
    pub target: u32,
    /// Threshold of the first frame, LSB of the DoG. Values above the largest DoG magnitude are clipped to it.
    pub initial: u32,
}

/// The parameters of the model levels, the bit-true model and the hardware.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignPoint {
    /// Largest width of a frame, px.
    pub width: u32,
    /// Largest height of a frame, px.
    pub height: u32,
    /// Format of a camera sample, `u8.0` to `u16.0`, in steps of the camera.
    pub pixel: Format,
    /// Format of the filter state and of the line memories, in steps of the camera. It has the integer bits of the
    /// pixel.
    pub state: Format,
    /// Format of the filter coefficients `g` and `g_j`.
    pub coefficient: Format,
    /// Number of scale pairs, 1 to 3. Pair `k` is the difference of smoothers `k` and `k + 1`.
    pub scale_pairs: u32,
    /// `sigma` of each smoother, px, rising.
    pub sigmas: Vec<f64>,
    /// Family of the smoothers at the levels `recursive` and `quantised`. The other levels are first-order.
    pub smoother: SmootherKind,
    /// Look-ahead `m` of each smoother, stages: `m` stages span `2^m - 1` samples.
    pub look_ahead: Vec<u32>,
    /// `N`: bits of a DoG magnitude, without its sign, over the range `FS/4`.
    pub dog_bits: u32,
    /// Radius of the ring of each scale pair, px.
    pub ring_radii: Vec<u32>,
    /// The automatic threshold.
    pub threshold: AutomaticThreshold,
    /// Capacity of the queue of candidates that wait for their rings, a power of two.
    pub candidate_queue: u32,
    /// Capacity of the FIFO of records that wait for the DMA, a power of two.
    pub record_fifo: u32,
    /// What the block memories keep besides the data.
    pub protection: Protection,
}

/// The keys of a design file, in the order of a file.
pub static KEYS: [Key; 16] = [
    Key {
        name: "width",
        unit: "px",
        meaning: "Columns of the largest frame. The line memories hold the next power of two.",
        kind: Kind::Whole(1..=4096, field!(width)),
    },
    Key {
        name: "height",
        unit: "px",
        meaning: "Rows of the camera's frame. Pictures are cut to it.",
        kind: Kind::Whole(1..=4096, field!(height)),
    },
    Key {
        name: "pixel",
        unit: "step of the camera",
        meaning: "Camera sample.",
        kind: Kind::Format { integer: IntegerBits::Range(8..=16), fraction: 0..=0, field: field!(pixel) },
    },
    Key {
        name: "state",
        unit: "step of the camera",
        meaning: "Filter state and line memories: the integer bits of the pixel, and fraction bits.",
        kind: Kind::Format { integer: IntegerBits::OfPixel, fraction: 0..=12, field: field!(state) },
    },
    Key {
        name: "coefficient",
        unit: "1",
        meaning: "Filter coefficients g and g_j.",
        kind: Kind::Format {
            integer: IntegerBits::Range(0..=0),
            fraction: 4..=MAX_FRACTION_BITS as i8,
            field: field!(coefficient),
        },
    },
    Key {
        name: "scale_pairs",
        unit: "scale pairs",
        meaning: "Pair k is the difference of smoothers k and k + 1, so there is one more smoother than scale pairs.",
        kind: Kind::Whole(1..=MAX_SCALE_PAIRS, field!(scale_pairs)),
    },
    Key {
        name: "sigmas",
        unit: "px",
        meaning: "sigma of each smoother, rising.",
        kind: Kind::Reals(0.5..=64.0, Length::PerSmoother, field!(sigmas)),
    },
    Key {
        name: "smoother",
        unit: "family",
        meaning: "Smoother of the levels recursive and quantised. The bit-true model and the hardware are first-order.",
        kind: named!(SmootherKind, smoother),
    },
    Key {
        name: "look_ahead",
        unit: "stages",
        meaning: "Look-ahead m of each smoother: m stages reach 2^m - 1 px.",
        kind: Kind::Wholes(1..=10, Length::PerSmoother, field!(look_ahead)),
    },
    Key {
        name: "dog_bits",
        unit: "bits",
        meaning: "Bits of a response without its sign, over a quarter of full scale: one LSB is 2^(14 - dog_bits) DN.",
        kind: Kind::Whole(2..=16, field!(dog_bits)),
    },
    Key {
        name: "ring_radii",
        unit: "px",
        meaning: "Radius of the ring of each scale pair.",
        kind: Kind::Wholes(4..=MAX_RING_RADIUS, Length::PerScalePair, field!(ring_radii)),
    },
    Key {
        name: "threshold_target",
        unit: "features",
        meaning: "Features of one scale pair in a frame that the automatic threshold is adjusted to.",
        kind: Kind::Whole(1..=65535, field!(threshold.target)),
    },
    Key {
        name: "threshold_initial",
        unit: "LSB of the response",
        meaning: "Threshold of the first frame.",
        kind: Kind::Whole(1..=65535, field!(threshold.initial)),
    },
    Key {
        name: "candidate_queue",
        unit: "candidates",
        meaning: "Candidates that can wait for their rings. More are dropped and counted.",
        kind: Kind::PowerOfTwo(64..=4096, field!(candidate_queue)),
    },
    Key {
        name: "record_fifo",
        unit: "records",
        meaning: "Records that can wait for the DMA. The last 16 entries are reserved for the ends of frames.",
        kind: Kind::PowerOfTwo(64..=4096, field!(record_fifo)),
    },
    Key {
        name: "protection",
        unit: "kind",
        meaning: "What block memories keep besides the data. It changes no record; a flipped bit marks its frame.",
        kind: named!(Protection, protection),
    },
];

impl DesignPoint {
    /// Returns the design before a file with every key sets all its fields.
    pub(crate) fn unset() -> Self {
        Self {
            width: 0,
            height: 0,
            pixel: Format::unsigned(16, 0),
            state: Format::unsigned(16, 0),
            coefficient: Format::unsigned(0, 16),
            scale_pairs: 0,
            sigmas: Vec::new(),
            smoother: SmootherKind::FirstOrder,
            look_ahead: Vec::new(),
            dog_bits: 0,
            ring_radii: Vec::new(),
            threshold: AutomaticThreshold { target: 0, initial: 0 },
            candidate_queue: 0,
            record_fifo: 0,
            protection: Protection::Off,
        }
    }

    /// Returns the design with the smoother of the hardware: what is emitted, simulated and sized for this design.
    pub fn of_hardware(&self) -> Self {
        Self { smoother: SmootherKind::FirstOrder, ..self.clone() }
    }

    /// Returns the number of scale pairs, which is that of the DoG planes.
    pub fn pairs(&self) -> usize {
        self.scale_pairs as usize
    }

    /// Returns the number of smoothers: neighbouring scale pairs share one.
    pub fn smoothers(&self) -> usize {
        self.pairs() + 1
    }

    /// Returns `n`, where one step of the camera is `2^n` DN.
    pub fn step_bits(&self) -> u32 {
        DN_BITS - self.pixel.bits()
    }

    /// Returns the format of the pixel in DN: the same bits, `u16.-8` for 8 of them.
    pub fn pixel_dn(&self) -> Format {
        self.in_dn(self.pixel)
    }

    /// Returns the format of the state in DN.
    pub fn state_dn(&self) -> Format {
        self.in_dn(self.state)
    }

    fn in_dn(&self, format: Format) -> Format {
        let shift = self.step_bits() as i8;
        Format::unsigned(format.integer_bits() + shift, format.fraction_bits() - shift)
    }

    /// Returns the format of a DoG magnitude and of MaxDOG, in DN.
    pub fn dog(&self) -> Format {
        Format::unsigned(DOG_RANGE_BITS, self.dog_bits as i8 - DOG_RANGE_BITS)
    }

    /// Returns the largest raw DoG magnitude, `2^N - 1`.
    pub fn max_dog(&self) -> u32 {
        (1 << self.dog_bits) - 1
    }

    /// Returns `s`, where one LSB of the DoG is `2^s` LSB of the state. It is negative if the LSB of the DoG is the
    /// finer one.
    pub fn dog_shift(&self) -> i32 {
        i32::from(self.state_dn().fraction_bits()) + i32::from(DOG_RANGE_BITS) - self.dog_bits as i32
    }
}

/// Returns the names of the smoothers of a design in Verilog and in the register map, the narrowest first.
pub fn smoother_names(smoothers: usize) -> &'static [&'static str] {
    match smoothers {
        2 => &["narrow", "wide"],
        3 => &["narrow", "middle", "wide"],
        _ => &["narrow", "middle", "wide", "widest"],
    }
}

#[cfg(test)]
mod tests {
    use crate::KT27;

    #[test]
    fn a_camera_of_eight_bits_has_steps_of_256_dn() {
        let design = KT27.with_override("pixel=u8.0").unwrap();
        assert_eq!((design.state.to_string(), design.step_bits()), ("u8.2".into(), 8));
        assert_eq!((design.pixel_dn().to_string(), design.state_dn().to_string()), ("u16.-8".into(), "u16.-6".into()));
        // An LSB of the DoG stays half a DN, now 2^7 times smaller than an LSB of the state.
        assert_eq!((design.dog().lsb(), design.dog_shift()), (0.5, -7));
    }
}
