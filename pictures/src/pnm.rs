//! Decoder of PGM, PPM and PAM, row by row. Unlike the decoder of `image` it rejects samples above the largest value
//! that the header states.

use std::io::{BufRead, Read};

use image::codecs::pnm::{PnmHeader, SampleEncoding};

use crate::luma::{DecodeError, Decoded, Samples};

/// Decodes the samples that follow a header.
pub(super) fn decode(mut reader: impl BufRead, header: &PnmHeader) -> Result<Decoded, DecodeError> {
    let (width, height) = (header.width() as usize, header.height() as usize);
    let largest = header.maximal_sample();
    let channels = match (header.as_graymap(), header.as_pixmap(), header.as_arbitrary()) {
        (Some(_), ..) => 1,
        (_, Some(_), _) => 3,
        (.., Some(header)) => header.depth as usize,
        _ => return Err(DecodeError::damaged("its header names no kind of sample")),
    };
    if !(1..=65535).contains(&largest) {
        return Err(DecodeError::damaged(format!("its largest sample is {largest}, which is not in 1 to 65535")));
    }
    let binary = matches!(header.subtype().sample_encoding(), SampleEncoding::Binary);
    let wide = largest > 255;
    let full = if wide { 65535.0 } else { 255.0 };
    let scale = full / largest as f32;
    let mut decoded = Decoded::with_capacity(width * height, if wide { 16 } else { 8 });
    let mut bytes = vec![0; width * channels * if wide { 2 } else { 1 }];
    let mut row = vec![0u16; width * channels];
    for y in 0..height {
        if binary {
            reader.read_exact(&mut bytes).map_err(|_| truncated(y, height))?;
            if wide {
                row.iter_mut().zip(bytes.as_chunks().0).for_each(|(to, from)| *to = u16::from_be_bytes(*from));
            } else {
                row.iter_mut().zip(&bytes).for_each(|(to, from)| *to = u16::from(*from));
            }
        } else {
            for sample in &mut row {
                *sample = number(&mut reader, largest)?.ok_or_else(|| truncated(y, height))?;
            }
        }
        for sample in &mut row {
            if u32::from(*sample) > largest {
                return Err(DecodeError::damaged(format!(
                    "row {y} holds a sample of {sample}, and its header says at most {largest}"
                )));
            }
            *sample = (f32::from(*sample) * scale).round() as u16;
        }
        decoded.push(Samples::U16(&row), channels);
    }
    Ok(decoded)
}

/// Returns the error for a file that ends in `row`.
fn truncated(row: usize, rows: usize) -> DecodeError {
    DecodeError::damaged(format!("it is cut short in row {row} of {rows}"))
}

/// Reads the next decimal number. Returns `None` at the end of the file. Comments from `#` to the end of a line are
/// skipped.
fn number(reader: &mut impl BufRead, largest: u32) -> Result<Option<u16>, DecodeError> {
    let mut value: Option<u32> = None;
    let mut comment = false;
    for byte in reader.bytes() {
        let byte = byte.map_err(|error| DecodeError::damaged(error.to_string()))?;
        match byte {
            b'\n' if comment => comment = false,
            _ if comment => {}
            b'#' => comment = true,
            b'0'..=b'9' => {
                let next = 10 * value.unwrap_or(0) + u32::from(byte - b'0');
                if next > 65535 {
                    return Err(DecodeError::damaged(format!("a sample is above {largest}, the most its header says")));
                }
                value = Some(next);
            }
            _ if byte.is_ascii_whitespace() || byte == 0x0b => {
                if value.is_some() {
                    break;
                }
            }
            _ => return Err(DecodeError::damaged("a sample is not a decimal number")),
        }
    }
    Ok(value.map(|value| value as u16))
}
