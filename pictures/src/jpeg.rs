//! Header of a JPEG, and a check that its scans are complete.
//!
//! ITU-T T.81: a file is a sequence of segments, each started by a marker `FF xx`; entropy-coded data follow a start of
//! scan. The decoders replace missing blocks by grey and report no error if the file ends with an end marker, and other
//! data may follow the image (motion photos, previews). So neither the result of the decoder nor the last two bytes
//! show that a file is complete. The check reads every Huffman code of every scan, without any transform, and counts
//! the blocks. Refinement passes of a progressive file are skipped, because the number of their bits depends on the
//! coefficients of earlier passes.

use std::ops::Range;

/// Largest number of scans of a file; the decoder has the same limit.
const MAX_SCANS: usize = 100;

const TRUNCATED: &str = "the JPEG is cut short";

/// The size in the frame header, and the position of the Exif data.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Range of the Exif data in the file, from its TIFF header on.
    pub(super) exif: Option<Range<usize>>,
}

/// Reads the segments before the first scan, so that the Exif segment is found before or after the frame header.
///
/// # Errors
/// There is no frame header, or a segment is damaged.
pub(super) fn read_header(bytes: &[u8]) -> Result<Header, String> {
    let mut segments = Segments { bytes, at: 2 };
    let (mut size, mut exif) = (None, None);
    while let Some((marker, body)) = segments.next()? {
        match marker {
            0xc0..=0xc2 => size = Some(Frame::new(&bytes[body])?),
            0xe1 if exif.is_none() && bytes[body.clone()].starts_with(b"Exif\0\0") => {
                exif = Some(body.start + 6..body.end);
            }
            0xda => break,
            _ => {}
        }
    }
    let frame = size.ok_or(TRUNCATED)?;
    Ok(Header { width: frame.width, height: frame.height, exif })
}

/// Checks that all scans are complete. Returns the length of the image including its end marker, bytes; later data are
/// not part of the image.
///
/// # Errors
/// A scan has fewer blocks than the frame or codes that are not in its tables, or a component has no scan.
pub(super) fn check_complete(bytes: &[u8]) -> Result<usize, String> {
    let mut segments = Segments { bytes, at: 2 };
    let mut frame: Option<Frame> = None;
    let mut tables = Tables::default();
    let (mut interval, mut scans) = (0, 0);
    while let Some((marker, body)) = segments.next()? {
        let segment = &bytes[body];
        match marker {
            0xc0..=0xc2 => frame = Some(Frame { progressive: marker == 0xc2, ..Frame::new(segment)? }),
            0xc4 => tables.define(segment)?,
            0xdd => {
                interval = usize::from(u16::from_be_bytes([
                    *segment.first().ok_or(TRUNCATED)?,
                    *segment.get(1).ok_or(TRUNCATED)?,
                ]))
            }
            0xda => {
                scans += 1;
                if scans > MAX_SCANS {
                    return Err(format!("the JPEG has more than {MAX_SCANS} scans"));
                }
                let frame = frame.as_mut().ok_or("the JPEG has a scan before its frame header")?;
                let scan = Scan::new(frame, segment)?;
                scan.check(frame, &tables, interval, &mut segments)?;
            }
            0xd9 => {
                let complete = frame.is_some_and(|frame| frame.components.iter().all(|component| component.scanned));
                return if complete { Ok(segments.at) } else { Err(TRUNCATED.into()) };
            }
            _ => {}
        }
    }
    Err(TRUNCATED.into())
}

/// The segments of a file, one after the other.
struct Segments<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Segments<'_> {
    /// Returns the next marker and the range of its segment, which is empty for the end of the image. `None` at the end
    /// of the file.
    fn next(&mut self) -> Result<Option<(u8, Range<usize>)>, String> {
        loop {
            // Other bytes between segments are skipped, as all decoders do.
            let Some(found) = self.bytes.get(self.at..).and_then(|rest| rest.iter().position(|&byte| byte == 0xff))
            else {
                return Ok(None);
            };
            self.at += found + 1;
            let Some(&marker) = self.bytes.get(self.at) else { return Ok(None) };
            match marker {
                // Stuffing, fill bytes, and markers without a segment.
                0xff => continue,
                0x00 | 0x01 | 0xd0..=0xd8 => {
                    self.at += 1;
                    continue;
                }
                0xd9 => {
                    self.at += 1;
                    return Ok(Some((marker, self.at..self.at)));
                }
                0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                    return Err("it is a lossless, hierarchical or arithmetic-coded JPEG".into());
                }
                _ => {}
            }
            let length = self.bytes.get(self.at + 1..self.at + 3).ok_or(TRUNCATED)?;
            let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
            let body = self.at + 3..self.at + 1 + length;
            if length < 2 || body.end > self.bytes.len() {
                return Err(TRUNCATED.into());
            }
            self.at = body.end;
            return Ok(Some((marker, body)));
        }
    }
}

/// The fields of a frame header that the check needs: size in pixels and components.
struct Frame {
    progressive: bool,
    width: usize,
    height: usize,
    components: Vec<Component>,
}

/// A colour component of the frame.
struct Component {
    id: u8,
    /// Blocks of one MCU, horizontally and vertically.
    across: usize,
    down: usize,
    /// `true` once a scan with its first pass was complete.
    scanned: bool,
}

impl Frame {
    fn new(segment: &[u8]) -> Result<Self, String> {
        let [_, h1, h0, w1, w0, count, rest @ ..] = segment else { return Err(TRUNCATED.into()) };
        let components: Vec<Component> = rest
            .chunks_exact(3)
            .take(usize::from(*count))
            .map(|entry| Component {
                id: entry[0],
                across: usize::from(entry[1] >> 4),
                down: usize::from(entry[1] & 15),
                scanned: false,
            })
            .collect();
        let frame = Self {
            progressive: false,
            width: usize::from(u16::from_be_bytes([*w1, *w0])),
            height: usize::from(u16::from_be_bytes([*h1, *h0])),
            components,
        };
        let is_sampled =
            |component: &Component| (1..=4).contains(&component.across) && (1..=4).contains(&component.down);
        if frame.width == 0 || frame.height == 0 || *count == 0 || frame.components.len() != usize::from(*count) {
            return Err("its frame header has no size or no components".into());
        }
        if !frame.components.iter().all(is_sampled) {
            return Err("its frame header has a sampling factor that is not in 1 to 4".into());
        }
        Ok(frame)
    }

    /// Returns the largest sampling factors, horizontally and vertically.
    fn max_sampling(&self) -> (usize, usize) {
        let max = |of: fn(&Component) -> usize| self.components.iter().map(of).max().unwrap_or(1);
        (max(|component| component.across), max(|component| component.down))
    }
}

/// A Huffman table in canonical form.
#[derive(Clone)]
struct Table {
    /// For each length of a code: the smallest value, left-justified in 16 bits, above all codes of this length.
    limit: [u32; 16],
    /// For each length: the difference of the index in `symbols` and the code.
    offset: [i32; 16],
    symbols: Vec<u8>,
}

impl Table {
    fn new(counts: &[u8; 16], symbols: &[u8]) -> Self {
        let (mut code, mut first) = (0u32, 0i32);
        let (mut limit, mut offset) = ([0; 16], [0; 16]);
        for (length, &count) in counts.iter().enumerate() {
            offset[length] = first - code as i32;
            code += u32::from(count);
            first += i32::from(count);
            limit[length] = code << (15 - length);
            code <<= 1;
        }
        Self { limit, offset, symbols: symbols.to_vec() }
    }
}

/// The tables that are defined before a scan.
#[derive(Default)]
struct Tables {
    dc: [Option<Table>; 4],
    ac: [Option<Table>; 4],
}

impl Tables {
    fn define(&mut self, mut segment: &[u8]) -> Result<(), String> {
        while let [of, rest @ ..] = segment {
            let (counts, rest) = rest.split_first_chunk::<16>().ok_or(TRUNCATED)?;
            let symbols: usize = counts.iter().map(|&count| usize::from(count)).sum();
            let (symbols, rest) = rest.split_at_checked(symbols).ok_or(TRUNCATED)?;
            let class = if of >> 4 == 0 { &mut self.dc } else { &mut self.ac };
            *class.get_mut(usize::from(of & 15)).ok_or("it defines more than four Huffman tables")? =
                Some(Table::new(counts, symbols));
            segment = rest;
        }
        Ok(())
    }
}

/// The fields of a scan header that the check needs.
struct Scan {
    /// Index of each component, of its DC table and of its AC table.
    components: Vec<(usize, usize, usize)>,
    /// First and last coefficient.
    from: u8,
    to: u8,
    /// `true` if the scan refines bits of an earlier pass.
    refines: bool,
}

impl Scan {
    fn new(frame: &Frame, segment: &[u8]) -> Result<Self, String> {
        let (&count, rest) = segment.split_first().ok_or(TRUNCATED)?;
        let (entries, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or(TRUNCATED)?;
        let [from, to, steps, ..] = *rest else { return Err(TRUNCATED.into()) };
        let component = |entry: &[u8]| {
            let index = frame.components.iter().position(|component| component.id == entry[0]);
            let index = index.ok_or("a scan names a component that the frame has not")?;
            Ok((index, usize::from(entry[1] >> 4), usize::from(entry[1] & 15)))
        };
        let components = entries.chunks_exact(2).map(component).collect::<Result<Vec<_>, String>>()?;
        if components.is_empty() || components.len() > 4 {
            return Err("a scan has no components, or more than four".into());
        }
        Ok(Self { components, from, to, refines: frame.progressive && steps >> 4 != 0 })
    }

    /// Reads the entropy-coded data and marks the components of the scan as complete.
    ///
    /// # Errors
    /// A block is missing, or a code is not in its table.
    fn check(
        &self,
        frame: &mut Frame,
        tables: &Tables,
        interval: usize,
        segments: &mut Segments,
    ) -> Result<(), String> {
        if self.refines && self.from > 0 {
            return Ok(());
        }
        let (across, down) = frame.max_sampling();
        let (units, blocks): (usize, Vec<(usize, usize, usize)>) = match self.components[..] {
            // With a single component a unit is a block, and only blocks with a pixel of the picture are coded.
            [(index, dc, ac)] => {
                let component = &frame.components[index];
                let wide = (frame.width * component.across).div_ceil(8 * across);
                let tall = (frame.height * component.down).div_ceil(8 * down);
                (wide * tall, vec![(1, dc, ac)])
            }
            _ => {
                let units = frame.width.div_ceil(8 * across) * frame.height.div_ceil(8 * down);
                let blocks = |&(index, dc, ac): &(usize, usize, usize)| {
                    let component = &frame.components[index];
                    (component.across * component.down, dc, ac)
                };
                (units, self.components.iter().map(blocks).collect())
            }
        };
        let pass = match (frame.progressive, self.from) {
            (false, _) => Pass::Sequential,
            (true, 0) if self.refines => Pass::RefinedDc,
            (true, 0) => Pass::Dc,
            (true, from) => Pass::Ac { from: usize::from(from), to: usize::from(self.to) },
        };
        let mut bits = Bits { bytes: segments.bytes, at: segments.at, buffer: 0, left: 0, marker: false };
        let interval = if interval == 0 { units } else { interval };
        let mut done = 0;
        while done < units {
            if done > 0 {
                bits.restart()?;
            }
            let count = interval.min(units - done);
            let mut unit = 0;
            while unit < count {
                let mut skipped = 1;
                for &(blocks_per_unit, dc, ac) in &blocks {
                    for _ in 0..blocks_per_unit {
                        let run = pass.block(&mut bits, tables.dc.get(dc), tables.ac.get(ac))?;
                        // Blocks within an end-of-band run have no bits.
                        skipped += run;
                    }
                }
                unit += skipped;
            }
            done += count;
        }
        segments.at = bits.marker_position();
        if self.from == 0 {
            for &(index, ..) in &self.components {
                frame.components[index].scanned = true;
            }
        }
        Ok(())
    }
}

/// The kind of codes that the blocks of a scan have.
#[derive(Clone, Copy)]
enum Pass {
    Sequential,
    Dc,
    RefinedDc,
    Ac { from: usize, to: usize },
}

impl Pass {
    /// Reads one block. Returns the number of blocks after it that have no codes.
    fn block(self, bits: &mut Bits, dc: Option<&Option<Table>>, ac: Option<&Option<Table>>) -> Result<usize, String> {
        let missing = "a scan uses a Huffman table that the file does not define";
        let (dc, ac) = (dc.and_then(Option::as_ref), ac.and_then(Option::as_ref));
        match self {
            Self::RefinedDc => bits.skip(1)?,
            Self::Dc | Self::Sequential => {
                let size = bits.symbol(dc.ok_or(missing)?)?;
                bits.skip(u32::from(size.min(16)))?;
            }
            Self::Ac { .. } => {}
        }
        let (mut at, end) = match self {
            Self::Sequential => (1, 63),
            Self::Ac { from, to } => (from, to.min(63)),
            Self::Dc | Self::RefinedDc => return Ok(0),
        };
        let ac = ac.ok_or(missing)?;
        while at <= end {
            let symbol = bits.symbol(ac)?;
            let (run, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            match (run, size) {
                (15, 0) => at += 16,
                (_, 0) if matches!(self, Self::Ac { .. }) => {
                    return Ok((1usize << run) - 1 + bits.take(run as u32)? as usize);
                }
                (_, 0) => break,
                _ => {
                    bits.skip(size)?;
                    at += run + 1;
                }
            }
        }
        Ok(0)
    }
}

/// A reader of the bits of entropy-coded data. It removes the stuffing and stops at the next marker.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Next bits, in the most significant positions.
    buffer: u64,
    left: u32,
    /// `true` if there is a marker or the end of the file at `at`.
    marker: bool,
}

impl Bits<'_> {
    /// Fills the buffer to at least 49 bits, or up to the marker.
    fn fill(&mut self) {
        while self.left <= 48 && !self.marker {
            let byte = match self.bytes.get(self.at..) {
                Some([0xff, 0x00, ..]) => {
                    self.at += 1;
                    0xff
                }
                Some([0xff, ..] | []) | None => {
                    self.marker = true;
                    return;
                }
                Some([byte, ..]) => *byte,
            };
            self.at += 1;
            self.buffer |= u64::from(byte) << (56 - self.left);
            self.left += 8;
        }
    }

    /// Skips `count` bits, at most 16.
    fn skip(&mut self, count: u32) -> Result<(), String> {
        self.take(count).map(|_| ())
    }

    /// Reads `count` bits, at most 16.
    fn take(&mut self, count: u32) -> Result<u32, String> {
        if self.left < count {
            self.fill();
            if self.left < count {
                return Err(TRUNCATED.into());
            }
        }
        let value = (self.buffer >> 48) as u32 >> (16 - count);
        self.buffer <<= count;
        self.left -= count;
        Ok(value)
    }

    /// Reads one Huffman code and returns its symbol.
    fn symbol(&mut self, table: &Table) -> Result<u8, String> {
        if self.left < 16 {
            self.fill();
        }
        let next = (self.buffer >> 48) as u32;
        let Some(length) = table.limit.iter().position(|&limit| next < limit) else {
            return Err(if self.left < 16 {
                TRUNCATED.into()
            } else {
                "its scan holds a code that no table has".into()
            });
        };
        let code = (next >> (15 - length)) as i32;
        self.take(length as u32 + 1)?;
        let symbol = table.symbols.get((code + table.offset[length]) as usize);
        symbol.copied().ok_or_else(|| "its Huffman tables are damaged".into())
    }

    /// Skips the restart marker, which must follow.
    fn restart(&mut self) -> Result<(), String> {
        let at = self.marker_position();
        match self.bytes.get(at..) {
            Some([0xff, 0xd0..=0xd7, ..]) => {
                *self = Bits { at: at + 2, buffer: 0, left: 0, marker: false, bytes: self.bytes };
                Ok(())
            }
            _ => Err(TRUNCATED.into()),
        }
    }

    /// Returns the position of the next marker; the data before it are padding.
    fn marker_position(&self) -> usize {
        let mut at = self.at;
        while let Some(pair) = self.bytes.get(at..at + 2) {
            match pair {
                [0xff, 0x00] => at += 2,
                // A fill byte.
                [0xff, 0xff] => at += 1,
                [0xff, _] => return at,
                _ => at += 1,
            }
        }
        self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageBuffer, Rgb};

    fn encoded(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = ImageBuffer::from_fn(width, height, |x, y| Rgb([(x * y) as u8, (3 * x) as u8, (5 * y) as u8]));
        DynamicImage::ImageRgb8(picture).write_to(&mut bytes, image::ImageFormat::Jpeg).unwrap();
        bytes.into_inner()
    }

    /// Returns the position of the data of the last scan.
    fn scan_data(bytes: &[u8]) -> usize {
        let marker = bytes.windows(2).rposition(|pair| pair == [0xff, 0xda]).unwrap();
        marker + 2 + usize::from(u16::from_be_bytes([bytes[marker + 2], bytes[marker + 3]]))
    }

    #[test]
    fn the_length_of_a_complete_file_excludes_later_data() {
        for (width, height) in [(1, 1), (8, 8), (17, 9), (64, 48), (333, 127)] {
            let mut bytes = encoded(width, height);
            let length = bytes.len();
            assert_eq!(check_complete(&bytes), Ok(length), "{width} x {height}");
            // The start of a film, another JPEG, and half of one.
            for after in [&b"\0\0\0 ftypmp42"[..], &encoded(20, 20), &encoded(64, 64)[..700]] {
                bytes.extend(after);
                assert_eq!(check_complete(&bytes), Ok(length), "{width} x {height}");
            }
            let header = read_header(&bytes).unwrap();
            assert_eq!((header.width, header.height), (width as usize, height as usize));
        }
    }

    #[test]
    fn a_scan_truncated_anywhere_is_incomplete_even_with_an_end_marker() {
        let bytes = encoded(64, 48);
        let (from, to) = (scan_data(&bytes), bytes.len() - 2);
        for cut in from..to {
            assert!(check_complete(&bytes[..cut]).is_err(), "{cut} of {to}");
            let mut closed = bytes[..cut].to_vec();
            // The last byte may have padding and no code.
            if cut + 1 < to {
                // The zero restores the stuffing if the cut is after 0xff.
                closed.extend_from_slice(if closed.ends_with(&[0xff]) { &[0, 0xff, 0xd9] } else { &[0xff, 0xd9] });
                assert_eq!(check_complete(&closed), Err(TRUNCATED.to_owned()), "{cut} of {to}");
            }
        }
        for cut in 2..from {
            assert!(check_complete(&bytes[..cut]).is_err(), "{cut} of {to}");
        }
    }

    #[test]
    fn damaged_bytes_cause_no_panic() {
        let bytes = encoded(64, 48);
        let mut random = 1u32;
        let mut next = move || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as usize
        };
        for _ in 0..3000 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + next() % 4 {
                let at = next() % damaged.len();
                damaged[at] = next() as u8;
            }
            let _ = (read_header(&damaged), check_complete(&damaged));
        }
    }
}
