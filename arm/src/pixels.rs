//! The pixels of the present frame, gathered from the messages that carry its rows.

use crate::message::{MessageError, Strip};
use hoverlock_reference::image::plane::Plane;

/// A frame of which the first rows have arrived.
pub struct Pixels {
    frame: Plane<u16>,
    /// Its number; `None` before the first row, and after a gap.
    number: Option<u32>,
    /// Rows that have arrived without a gap.
    rows: usize,
}

impl Pixels {
    /// Allocates memory for frames of a size, at least one pixel.
    pub fn with_size(width: usize, height: usize) -> Self {
        Self { frame: Plane::filled(width, height, 0), number: None, rows: 0 }
    }

    /// Takes a message with rows. A frame begins with its first row. Rows of another frame, after a gap or beyond the
    /// last row make it incomplete.
    ///
    /// # Errors
    /// If the length of the payload is not that of its rows.
    pub fn take(&mut self, payload: &[u8]) -> Result<(), MessageError> {
        let columns = self.frame.width();
        let strip = Strip::parse(payload, columns)?;
        if strip.first_row == 0 {
            (self.number, self.rows) = (Some(strip.frame), 0);
        }
        let end = strip.first_row + strip.rows;
        if self.number != Some(strip.frame) || strip.first_row != self.rows || end > self.frame.height() {
            self.number = None;
            return Ok(());
        }
        let rows = &mut self.frame.as_mut_slice()[columns * self.rows..columns * end];
        rows.iter_mut().zip(strip.pixels()).for_each(|(to, pixel)| *to = pixel);
        self.rows = end;
        Ok(())
    }

    /// Returns the pixels of the frame with a number; `None` unless all its rows have arrived.
    pub fn of_frame(&self, number: u32) -> Option<&Plane<u16>> {
        (self.number == Some(number) && self.rows == self.frame.height()).then_some(&self.frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::encode_pixels;

    fn picture(seed: u16) -> Plane<u16> {
        Plane::from_fn(1024, 200, |x, y| (x + 3 * y) as u16 ^ seed)
    }

    #[test]
    fn a_frame_is_complete_with_its_last_row_and_replaced_by_the_next() {
        let mut pixels = Pixels::with_size(1024, 200);
        for (number, seed) in [(7, 1), (8, 2)] {
            for payload in encode_pixels(number, &picture(seed)) {
                assert_eq!(pixels.of_frame(number), None);
                pixels.take(&payload).unwrap();
            }
            assert_eq!(pixels.of_frame(number), Some(&picture(seed)));
            assert_eq!(pixels.of_frame(number - 1), None);
        }
    }

    /// Lost, repeated and exchanged rows, rows of another frame, more rows than the frame has, and another length.
    #[test]
    fn a_frame_with_other_rows_is_no_frame() {
        let [one, other] = [encode_pixels(7, &picture(1)), encode_pixels(8, &picture(2))];
        let taken = |payloads: &[&Vec<u8>]| {
            let mut pixels = Pixels::with_size(1024, 200);
            payloads.iter().for_each(|payload| pixels.take(payload).unwrap());
            pixels.of_frame(7).is_some()
        };
        let [a, b, c, d] = &one[..] else { panic!("{} messages", one.len()) };
        assert!(taken(&[a, b, c, d]) && taken(&[b, a, b, c, d]));
        for wrong in
            [&[a, b, d][..], &[b, c, d], &[a, b, b, c, d], &[a, c, b, d], &[a, b, c, d, d], &[a, b, &other[2], d]]
        {
            assert!(!taken(wrong));
        }
        let mut pixels = Pixels::with_size(1022, 200);
        assert!(pixels.take(a).is_err());
    }
}
