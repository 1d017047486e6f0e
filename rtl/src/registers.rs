//! The register map: source of the Verilog, the C header, the Rust constants and the documentation.
//!
//! 32-bit registers on an Avalon-MM slave, read latency of one cycle, no wait states.

use hoverlock_design::{DesignPoint, MIN_SIDE, smoother_names};
use hoverlock_fixed_point::model::coefficients::{CoefficientError, LerpCoefficients};

use crate::design::{HEIGHT_BITS, MAX_HEIGHT};

/// What software may do with a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Read only.
    Read,
    /// Read and write.
    ReadWrite,
    /// Set by hardware, cleared by writing 1.
    Clear,
    /// Writing 1 triggers an action; reads as 0.
    Pulse,
    /// Set by writing 1, cleared by hardware.
    Request,
}

/// A field of a register.
#[derive(Debug, Clone)]
pub struct Field {
    /// Name, lower case.
    pub name: String,
    /// Lowest bit.
    pub low: u32,
    /// Number of bits.
    pub bits: u32,
    /// What software may do.
    pub access: Access,
    /// Value after reset.
    pub reset: u32,
    /// Meaning.
    pub what: String,
}

/// A register.
#[derive(Debug, Clone)]
pub struct Register {
    /// Name, lower case.
    pub name: String,
    /// Byte address.
    pub offset: u32,
    /// Its fields, the lowest first.
    pub fields: Vec<Field>,
}

/// `HLCK`.
pub const IDENTIFICATION: u32 = 0x484c_434b;

/// Major and minor, of one and two scale pairs.
pub const VERSION: u32 = 0x0002_0000;

/// Major and minor of three scale pairs: records of ten words, and a register for the third threshold.
pub const THREE_PAIR_VERSION: u32 = 0x0003_0000;

/// The fields of the thresholds of the scale pairs.
pub const THRESHOLD_FIELDS: [&str; 3] = ["fine", "coarse", "coarsest"];

/// The register that holds the threshold of scale pair `k`, of the two registers that begin with a name.
pub fn threshold_register(name: &'static str, k: usize) -> &'static str {
    match (k, name) {
        (2.., "threshold") => "threshold_2",
        (2.., _) => "threshold_now_2",
        _ => name,
    }
}

/// Byte address of the first coefficient.
pub const COEFFICIENTS_AT: u32 = 0x40;

/// The coefficients of a design, in the order of [`crate::cells::bank`].
///
/// # Errors
/// Where a smoother of the design does not exist.
pub fn default_coefficients(design: &DesignPoint) -> Result<Vec<u32>, CoefficientError> {
    let mut coefficients = Vec::new();
    for (&sigma, &look_ahead) in design.sigmas.iter().zip(&*design.look_ahead) {
        let designed = hoverlock_fixed_point::model::stages::StageCoefficients::from(LerpCoefficients::design(
            sigma,
            look_ahead,
            design.coefficient.bits(),
        )?);
        coefficients.push(designed.g);
        coefficients.extend(designed.g_j);
    }
    Ok(coefficients)
}

/// All registers of a design.
///
/// # Errors
/// As [`default_coefficients`].
pub fn registers(design: &DesignPoint) -> Result<Vec<Register>, CoefficientError> {
    use Access::{Clear, Pulse, Read, ReadWrite, Request};
    let field = |name: &str, low: u32, bits: u32, access: Access, reset: u32, what: &str| Field {
        name: name.into(),
        low,
        bits,
        access,
        reset,
        what: what.into(),
    };
    let register = |name: &str, offset: u32, fields: Vec<Field>| Register { name: name.into(), offset, fields };
    let threshold = design.threshold.initial;
    let width_bits = design.width.next_power_of_two().trailing_zeros() + 1;
    let columns = format!("columns, {MIN_SIDE} to {}", design.width);
    let rows = format!("rows, {MIN_SIDE} to {MAX_HEIGHT}");
    let lsb = design.dog().lsb();
    let dog_bits = design.dog_bits;
    let pairs = design.pairs();
    let of_pair = |k: usize, access: Access, reset: u32, what: &str| {
        field(THRESHOLD_FIELDS[k], 16 * (k as u32 % 2), dog_bits, access, reset, what)
    };
    let manual = |k: usize| of_pair(k, ReadWrite, threshold, &format!("least response of scale pair {k}, in {lsb} DN"));
    let in_use = |k: usize| of_pair(k, Read, 0, &format!("threshold in use, scale pair {k}"));
    let version = if pairs > 2 { THREE_PAIR_VERSION } else { VERSION };
    let mut map = vec![
        register("identification", 0x00, vec![field("letters", 0, 32, Read, IDENTIFICATION, "`HLCK`")]),
        register("version", 0x04, vec![field("number", 0, 32, Read, version, "major above minor, 16 bits each")]),
        register(
            "emission",
            0x08,
            vec![field("hash", 0, 32, Read, 0, "first 32 bits of the SHA-256 of the emitted Verilog")],
        ),
        register(
            "control",
            0x0c,
            vec![
                field("enable", 0, 1, ReadWrite, 0, "frames are accepted; otherwise whole frames are dropped"),
                field(
                    "automatic",
                    1,
                    1,
                    ReadWrite,
                    0,
                    "thresholds follow the feature count of the previous frame; part of the set",
                ),
                field("interrupt_frame", 2, 1, ReadWrite, 0, "interrupt at the end of a frame"),
                field("interrupt_error", 3, 1, ReadWrite, 0, "interrupt at an error"),
                field("reset", 31, 1, Pulse, 0, "clears the pipeline and the FIFO, not the registers"),
            ],
        ),
        register(
            "status",
            0x10,
            vec![
                field("frame", 0, 1, Clear, 0, "a frame was finished"),
                field("short_frame", 1, 1, Clear, 0, "end of packet before the last pixel; the frame was padded"),
                field(
                    "long_frame",
                    2,
                    1,
                    Clear,
                    0,
                    "no end of packet at the last pixel; the following beats were dropped",
                ),
                field("interrupted", 3, 1, Clear, 0, "start of packet before the last pixel; the frame was padded"),
                field("refused", 4, 1, Clear, 0, "a beat outside a frame, or a frame of an invalid size"),
                field("dropped", 5, 1, Clear, 0, "features were dropped"),
                field("saturated", 6, 1, Clear, 0, "a response was saturated"),
                field(
                    "begun",
                    7,
                    1,
                    Clear,
                    0,
                    "a frame has begun, with the set if one was committed; the registers may be written for the next",
                ),
                field("busy", 31, 1, Read, 0, "at least one frame is in the pipeline"),
            ],
        ),
        register(
            "size",
            0x14,
            vec![
                field("width", 0, width_bits, ReadWrite, design.width, &columns),
                field("height", 16, HEIGHT_BITS as u32, ReadWrite, design.height, &rows),
            ],
        ),
        register("threshold", 0x18, (0..pairs.min(2)).map(manual).collect()),
        register(
            "target",
            0x1c,
            vec![field("count", 0, 16, ReadWrite, design.threshold.target, "features per scale pair")],
        ),
        register("threshold_now", 0x20, (0..pairs.min(2)).map(in_use).collect()),
        register("frames", 0x24, vec![field("count", 0, 32, Read, 0, "frames finished since reset")]),
        register("features", 0x28, vec![field("count", 0, 20, Read, 0, "features of the last finished frame")]),
        register(
            "dropped",
            0x2c,
            vec![field("count", 0, 20, Read, 0, "features of the last finished frame that were dropped")],
        ),
    ];
    let what = "write 1: commits the set for the next frame; reads 1 until captured or until the set is written";
    map.push(register("commit", 0x30, vec![field("pending", 0, 1, Request, 1, what)]));
    if pairs > 2 {
        map.push(register("threshold_2", 0x34, vec![manual(2)]));
        map.push(register("threshold_now_2", 0x38, vec![in_use(2)]));
    }
    let names = smoother_names(design.smoothers());
    let mut coefficients = default_coefficients(design)?.into_iter();
    let mut offset = COEFFICIENTS_AT;
    for (smoother, &look_ahead) in names.iter().zip(&*design.look_ahead) {
        for cell in 0..=look_ahead {
            let (name, what) = match cell {
                0 => (format!("{smoother}_g"), format!("`g` of the recursion, {}", design.coefficient)),
                _ => (
                    format!("{smoother}_g{}", cell - 1),
                    format!("`g_{}` of the look-ahead, {}", cell - 1, design.coefficient),
                ),
            };
            let raw = coefficients.next().unwrap_or_default();
            map.push(register(
                &name,
                offset,
                vec![field("value", 0, design.coefficient.bits(), ReadWrite, raw, &what)],
            ));
            offset += 4;
        }
    }
    Ok(map)
}
