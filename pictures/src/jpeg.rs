//! What a JPEG says of itself, and whether it is whole: its markers, and the blocks that its scans really hold.
//!
//! ITU-T T.81: a file is a sequence of segments, each begun by a marker `FF xx`; entropy-coded data follow a start of
//! scan. The decoder fills what a scan lacks with grey and says nothing, and data may follow the end of the image
//! (motion photos, previews), so neither the decoder's silence nor the last two bytes tell. Here every Huffman code of
//! every scan is read, without any transform, and its blocks are counted. Refining passes of a progressive file are
//! not: which bits they hold depends on the coefficients before them.

use std::ops::Range;

/// Scans that a file may have; the decoder has the same limit.
const SCANS: usize = 100;

const CUT: &str = "the JPEG is cut short";

/// The frame header, and the metadata before it.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) width: usize,
    pub(super) height: usize,
    /// The bytes of the Exif segment, from its TIFF header on.
    pub(super) exif: Option<Range<usize>>,
}

/// Reads the segments up to the frame header, or to the first scan, so that the Exif segment is found wherever it is.
pub(super) fn header(bytes: &[u8]) -> Result<Header, String> {
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
    let frame = size.ok_or(CUT)?;
    Ok(Header { width: frame.width, height: frame.height, exif })
}

/// The length of the image up to and with its end marker; what follows is not part of it.
///
/// # Errors
/// Where a scan holds fewer blocks than the frame, or codes that its tables do not have, or a component has no scan.
pub(super) fn whole(bytes: &[u8]) -> Result<usize, String> {
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
                interval = usize::from(u16::from_be_bytes([*segment.first().ok_or(CUT)?, *segment.get(1).ok_or(CUT)?]))
            }
            0xda => {
                scans += 1;
                if scans > SCANS {
                    return Err(format!("the JPEG has more than {SCANS} scans"));
                }
                let frame = frame.as_mut().ok_or("the JPEG has a scan before its frame header")?;
                let scan = Scan::new(frame, segment)?;
                scan.count(frame, &tables, interval, &mut segments)?;
            }
            0xd9 => {
                let complete = frame.is_some_and(|frame| frame.components.iter().all(|component| component.scanned));
                return if complete { Ok(segments.at) } else { Err(CUT.into()) };
            }
            _ => {}
        }
    }
    Err(CUT.into())
}

/// The segments of a file, one after the other.
struct Segments<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Segments<'_> {
    /// The next marker and the range of its segment, which is empty for the end of the image; nothing where the file
    /// ends.
    fn next(&mut self) -> Result<Option<(u8, Range<usize>)>, String> {
        loop {
            // Whatever stands between segments is skipped, as every decoder does.
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
            let length = self.bytes.get(self.at + 1..self.at + 3).ok_or(CUT)?;
            let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
            let body = self.at + 3..self.at + 1 + length;
            if length < 2 || body.end > self.bytes.len() {
                return Err(CUT.into());
            }
            self.at = body.end;
            return Ok(Some((marker, body)));
        }
    }
}

/// What the frame header says.
struct Frame {
    progressive: bool,
    width: usize,
    height: usize,
    components: Vec<Component>,
}

/// A colour component of the frame.
struct Component {
    id: u8,
    /// Blocks of one MCU, across and down.
    across: usize,
    down: usize,
    /// Whether a scan held its first pass whole.
    scanned: bool,
}

impl Frame {
    fn new(segment: &[u8]) -> Result<Self, String> {
        let [_, h1, h0, w1, w0, count, rest @ ..] = segment else { return Err(CUT.into()) };
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
        let sampled = |component: &Component| (1..=4).contains(&component.across) && (1..=4).contains(&component.down);
        if frame.width == 0 || frame.height == 0 || *count == 0 || frame.components.len() != usize::from(*count) {
            return Err("its frame header has no size or no components".into());
        }
        if !frame.components.iter().all(sampled) {
            return Err("its frame header has a sampling factor that is not in 1 to 4".into());
        }
        Ok(frame)
    }

    /// Largest sampling factors, across and down.
    fn most(&self) -> (usize, usize) {
        let most = |of: fn(&Component) -> usize| self.components.iter().map(of).max().unwrap_or(1);
        (most(|component| component.across), most(|component| component.down))
    }
}

/// A Huffman table in canonical form.
#[derive(Clone)]
struct Table {
    /// For each length of a code: the first value, left-justified in 16 bits, above the codes of this length.
    limit: [u32; 16],
    /// For each length: what to add to a code for its place in `symbols`.
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

/// The tables as they stand before a scan.
#[derive(Default)]
struct Tables {
    dc: [Option<Table>; 4],
    ac: [Option<Table>; 4],
}

impl Tables {
    fn define(&mut self, mut segment: &[u8]) -> Result<(), String> {
        while let [of, rest @ ..] = segment {
            let (counts, rest) = rest.split_first_chunk::<16>().ok_or(CUT)?;
            let symbols: usize = counts.iter().map(|&count| usize::from(count)).sum();
            let (symbols, rest) = rest.split_at_checked(symbols).ok_or(CUT)?;
            let class = if of >> 4 == 0 { &mut self.dc } else { &mut self.ac };
            *class.get_mut(usize::from(of & 15)).ok_or("it defines more than four Huffman tables")? =
                Some(Table::new(counts, symbols));
            segment = rest;
        }
        Ok(())
    }
}

/// What a scan header says.
struct Scan {
    /// Index of each component, and its tables, DC and AC.
    components: Vec<(usize, usize, usize)>,
    /// First and last coefficient.
    from: u8,
    to: u8,
    /// Whether bits of an earlier pass are refined.
    refines: bool,
}

impl Scan {
    fn new(frame: &Frame, segment: &[u8]) -> Result<Self, String> {
        let (&count, rest) = segment.split_first().ok_or(CUT)?;
        let (entries, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or(CUT)?;
        let [from, to, steps, ..] = *rest else { return Err(CUT.into()) };
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

    /// Reads the scan's data, and marks its components where every block is there.
    fn count(
        &self,
        frame: &mut Frame,
        tables: &Tables,
        interval: usize,
        segments: &mut Segments,
    ) -> Result<(), String> {
        if self.refines && self.from > 0 {
            return Ok(());
        }
        let (across, down) = frame.most();
        let (units, blocks): (usize, Vec<(usize, usize, usize)>) = match self.components[..] {
            // One component alone: a unit is a block, and only blocks with a pixel of the picture are coded.
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
            let many = interval.min(units - done);
            let mut unit = 0;
            while unit < many {
                let mut skipped = 1;
                for &(count, dc, ac) in &blocks {
                    for _ in 0..count {
                        let run = pass.block(&mut bits, tables.dc.get(dc), tables.ac.get(ac))?;
                        // Blocks that an end-of-band run leaves empty take no bits.
                        skipped += run;
                    }
                }
                unit += skipped;
            }
            done += many;
        }
        segments.at = bits.at_marker();
        if self.from == 0 {
            for &(index, ..) in &self.components {
                frame.components[index].scanned = true;
            }
        }
        Ok(())
    }
}

/// Which codes a block has.
#[derive(Clone, Copy)]
enum Pass {
    Sequential,
    Dc,
    RefinedDc,
    Ac { from: usize, to: usize },
}

impl Pass {
    /// Reads one block; the number of blocks after it that have no codes.
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

/// The bits of entropy-coded data, stuffing removed, up to the next marker.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The next bits, at the top.
    buffer: u64,
    left: u32,
    /// Whether a marker stands at `at`, or the file ends there.
    marker: bool,
}

impl Bits<'_> {
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

    fn skip(&mut self, count: u32) -> Result<(), String> {
        self.take(count).map(|_| ())
    }

    /// The next `count` bits, at most 16.
    fn take(&mut self, count: u32) -> Result<u32, String> {
        if self.left < count {
            self.fill();
            if self.left < count {
                return Err(CUT.into());
            }
        }
        let value = (self.buffer >> 48) as u32 >> (16 - count);
        self.buffer <<= count;
        self.left -= count;
        Ok(value)
    }

    fn symbol(&mut self, table: &Table) -> Result<u8, String> {
        if self.left < 16 {
            self.fill();
        }
        let next = (self.buffer >> 48) as u32;
        let Some(length) = table.limit.iter().position(|&limit| next < limit) else {
            return Err(if self.left < 16 { CUT.into() } else { "its scan holds a code that no table has".into() });
        };
        let code = (next >> (15 - length)) as i32;
        self.take(length as u32 + 1)?;
        let symbol = table.symbols.get((code + table.offset[length]) as usize);
        symbol.copied().ok_or_else(|| "its Huffman tables are damaged".into())
    }

    /// Goes on after the restart marker that must follow.
    fn restart(&mut self) -> Result<(), String> {
        let at = self.at_marker();
        match self.bytes.get(at..) {
            Some([0xff, 0xd0..=0xd7, ..]) => {
                *self = Bits { at: at + 2, buffer: 0, left: 0, marker: false, bytes: self.bytes };
                Ok(())
            }
            _ => Err(CUT.into()),
        }
    }

    /// Where the next marker stands; what is left of the data before it is padding.
    fn at_marker(&self) -> usize {
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

    /// Where the data of the last scan begin.
    fn data(bytes: &[u8]) -> usize {
        let marker = bytes.windows(2).rposition(|pair| pair == [0xff, 0xda]).unwrap();
        marker + 2 + usize::from(u16::from_be_bytes([bytes[marker + 2], bytes[marker + 3]]))
    }

    #[test]
    fn a_whole_file_ends_at_its_end_marker_whatever_follows() {
        for (width, height) in [(1, 1), (8, 8), (17, 9), (64, 48), (333, 127)] {
            let mut bytes = encoded(width, height);
            let length = bytes.len();
            assert_eq!(whole(&bytes), Ok(length), "{width} x {height}");
            // A film, another JPEG, and half of one.
            for after in [&b"\0\0\0 ftypmp42"[..], &encoded(20, 20), &encoded(64, 64)[..700]] {
                bytes.extend(after);
                assert_eq!(whole(&bytes), Ok(length), "{width} x {height}");
            }
            let header = header(&bytes).unwrap();
            assert_eq!((header.width, header.height), (width as usize, height as usize));
        }
    }

    #[test]
    fn a_scan_cut_anywhere_is_not_whole_even_with_an_end_marker() {
        let bytes = encoded(64, 48);
        let (from, to) = (data(&bytes), bytes.len() - 2);
        for cut in from..to {
            assert!(whole(&bytes[..cut]).is_err(), "{cut} of {to}");
            let mut closed = bytes[..cut].to_vec();
            // The last byte may hold padding and no code.
            if cut + 1 < to {
                // A zero takes the place of a stuffed byte that the cut leaves bare.
                closed.extend_from_slice(if closed.ends_with(&[0xff]) { &[0, 0xff, 0xd9] } else { &[0xff, 0xd9] });
                assert_eq!(whole(&closed), Err(CUT.to_owned()), "{cut} of {to}");
            }
        }
        for cut in 2..from {
            assert!(whole(&bytes[..cut]).is_err(), "{cut} of {to}");
        }
    }

    #[test]
    fn no_bytes_bring_it_down() {
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
            let _ = (header(&damaged), whole(&damaged));
        }
    }
}
