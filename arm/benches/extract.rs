//! `hoverlock-extract WIDTH HEIGHT PIXELS T0 T1`: extracts features in software, as the FPGA does in hardware, to count
//! the instructions. PIXELS is a file of 16-bit samples, least significant byte first, row by row; T0 and T1 are the
//! thresholds.
//!
//! It runs the integer SIMD model of the hardware, compiled for NEON, with the same features bit for bit. The frame is
//! processed twice and only the second pass is counted, when all memory is allocated. The records are written to
//! standard output in the format of the hardware.

use hoverlock_design::KT27;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::mark::{Part, mark};
use hoverlock_registers::record::TWO_PAIR_WORDS;
use std::error::Error;
use std::io::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [width, height, pixels, thresholds @ ..] = &arguments[..] else {
        return Err("usage: hoverlock-extract WIDTH HEIGHT PIXELS T0 T1".into());
    };
    let (width, height) = (width.parse::<usize>()?, height.parse::<usize>()?);
    let thresholds: Vec<u32> = thresholds.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    if thresholds.len() != 2 {
        return Err("two thresholds".into());
    }
    let bytes = std::fs::read(pixels)?;
    if width == 0 || height == 0 || bytes.len() != 2 * width * height {
        return Err(format!("{pixels} has {} bytes, not 2 x {width} x {height}", bytes.len()).into());
    }
    let frame = Plane::from_fn(width, height, |x, y| {
        let at = 2 * (y * width + x);
        u16::from_le_bytes([bytes[at], bytes[at + 1]])
    });
    let mut model = SimdBitTrue::new(&KT27)?;
    model.portable_frame(&frame, &thresholds);
    mark(Part::Extraction);
    model.portable_frame(&frame, &thresholds);
    mark(Part::End);
    let words = model.features().iter().flat_map(|feature| feature.pack().into_iter().take(TWO_PAIR_WORDS));
    let records: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
    std::io::stdout().write_all(&records)?;
    Ok(())
}
