//! Messages on a byte stream that may lose, repeat, insert or change bytes.
//!
//! All numbers are little-endian; the size of every part is a multiple of four bytes:
//!
//! | bytes | part | |
//! |---|---|---|
//! | 4 | magic | `HLNV` |
//! | 4 | kind | see [`crate::message`] |
//! | 4 | length | bytes of the payload, a multiple of 4, at most [`MAX_PAYLOAD_BYTES`] |
//! | 4 | sequence | counts the messages of a source from 0 |
//! | 4 | header check | CRC-32 of the 16 bytes before |
//! | length | payload | |
//! | 4 | check | CRC-32 of everything before, from the magic on |
//!
//! CRC-32 is that of IEEE 802.3 (polynomial 0x04c11db7, reflected, all ones before and after).
//!
//! **Resynchronisation.** A header is valid only with its check, so the decoder never waits for a corrupted length. If
//! a check fails, the search for the next magic resumes one byte after the failed one, even inside a presumed message.
//! Damage therefore costs only the messages it touched. If bytes are missing from a payload, the bytes after the gap
//! are first read as the rest of it, so the message after the gap is delayed by at most one message. At the end of the
//! stream nothing is held back.

use std::io::{self, Read};

/// The first four bytes of every message.
const MAGIC: [u8; 4] = *b"HLNV";

/// Size of the part before the payload.
const HEADER_BYTES: usize = 20;

/// Size of the check after the payload.
const CHECK_BYTES: usize = 4;

/// Size of the longest payload: 4095 features and a trailer, 32 bytes each.
pub const MAX_PAYLOAD_BYTES: usize = 4096 * 32;

/// Size of the longest message with header and check.
const MAX_MESSAGE_BYTES: usize = HEADER_BYTES + MAX_PAYLOAD_BYTES + CHECK_BYTES;

/// A message whose checks have passed, borrowed from the decoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawMessage<'a> {
    /// Kind of the payload, see [`crate::message`].
    pub kind: u32,
    /// Number that the source gave the message, counted from 0.
    pub sequence: u32,
    /// The final CRC-32. Together with the sequence number it identifies a repeated message.
    pub check: u32,
    /// The payload, at most [`MAX_PAYLOAD_BYTES`].
    pub payload: &'a [u8],
}

/// The payload is longer than [`MAX_PAYLOAD_BYTES`] or not a multiple of 4 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a message with a payload of {bytes} bytes; it must be a multiple of 4, at most {MAX_PAYLOAD_BYTES}")]
pub struct PayloadError {
    /// Size of the payload.
    pub bytes: usize,
}

/// Appends a message with header and checks to `out`.
///
/// # Errors
/// If the payload has no length of a message. Nothing is appended then.
pub fn encode(kind: u32, sequence: u32, payload: &[u8], out: &mut Vec<u8>) -> Result<(), PayloadError> {
    if payload.len() > MAX_PAYLOAD_BYTES || !payload.len().is_multiple_of(4) {
        return Err(PayloadError { bytes: payload.len() });
    }
    let start = out.len();
    out.extend(MAGIC);
    for word in [kind, payload.len() as u32, sequence] {
        out.extend(word.to_le_bytes());
    }
    out.extend(crc32fast::hash(&out[start..]).to_le_bytes());
    out.extend(payload);
    out.extend(crc32fast::hash(&out[start..]).to_le_bytes());
    Ok(())
}

/// A decoder that finds the messages in a stream of bytes. It allocates once, for two messages.
pub struct Decoder {
    buffer: Box<[u8]>,
    start: usize,
    end: usize,
    finished: bool,
    skipped: u64,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            buffer: vec![0; 2 * MAX_MESSAGE_BYTES].into_boxed_slice(),
            start: 0,
            end: 0,
            finished: false,
            skipped: 0,
        }
    }
}

/// The result of looking for a message at the first unread byte.
enum Scan {
    /// A valid message with this many bytes of payload.
    Message(usize),
    /// The bytes so far may be the beginning of a message.
    Incomplete,
    /// No message begins here.
    NoMessage,
}

impl Decoder {
    /// Reads once from `source`; returns `false` at the end of the stream. Call it when [`Decoder::message`] returns
    /// `None`: then there is room in the buffer.
    ///
    /// # Errors
    /// If reading fails.
    pub fn read(&mut self, source: &mut impl Read) -> io::Result<bool> {
        self.buffer.copy_within(self.start..self.end, 0);
        (self.start, self.end) = (0, self.end - self.start);
        let read = loop {
            match source.read(&mut self.buffer[self.end..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                outcome => break outcome?,
            }
        };
        self.end += read;
        self.finished = read == 0;
        Ok(read > 0)
    }

    /// Returns how many bytes so far belonged to no message.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Returns the next message of the bytes read so far, or `None` if another read is needed.
    pub fn message(&mut self) -> Option<RawMessage<'_>> {
        let length = loop {
            match self.scan() {
                Scan::Message(length) => break length,
                Scan::Incomplete if !self.finished => return None,
                _ if self.start == self.end => return None,
                _ => {
                    // The next byte at which a magic can begin.
                    let rest = &self.buffer[self.start + 1..self.end];
                    let step = 1 + rest.iter().position(|byte| *byte == MAGIC[0]).unwrap_or(rest.len());
                    self.start += step;
                    self.skipped += step as u64;
                }
            }
        };
        let start = self.start;
        self.start += HEADER_BYTES + length + CHECK_BYTES;
        let message = &self.buffer[start..self.start];
        Some(RawMessage {
            kind: word(message, 4),
            sequence: word(message, 12),
            check: word(message, HEADER_BYTES + length),
            payload: &message[HEADER_BYTES..HEADER_BYTES + length],
        })
    }

    fn scan(&self) -> Scan {
        let bytes = &self.buffer[self.start..self.end];
        let known = bytes.len().min(MAGIC.len());
        if bytes[..known] != MAGIC[..known] {
            return Scan::NoMessage;
        }
        if bytes.len() < HEADER_BYTES {
            return Scan::Incomplete;
        }
        let length = word(bytes, 8) as usize;
        let sound = crc32fast::hash(&bytes[..HEADER_BYTES - 4]) == word(bytes, HEADER_BYTES - 4);
        if !sound || length > MAX_PAYLOAD_BYTES || !length.is_multiple_of(4) {
            return Scan::NoMessage;
        }
        let total = HEADER_BYTES + length + CHECK_BYTES;
        if bytes.len() < total {
            return Scan::Incomplete;
        }
        let sound = crc32fast::hash(&bytes[..total - CHECK_BYTES]) == word(bytes, total - CHECK_BYTES);
        if sound { Scan::Message(length) } else { Scan::NoMessage }
    }
}

/// Reads the little-endian word at a byte offset.
fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns sequence number and payload of the messages in `bytes`, read in pieces of at most `piece` bytes, and the
    /// number of bytes outside messages.
    fn decoded(mut bytes: &[u8], piece: usize) -> (Vec<(u32, Vec<u8>)>, u64) {
        let mut decoder = Decoder::default();
        let mut messages = Vec::new();
        loop {
            let mut part = &bytes[..bytes.len().min(piece)];
            let length = part.len();
            let more = decoder.read(&mut part).unwrap();
            bytes = &bytes[length - part.len()..];
            while let Some(raw) = decoder.message() {
                messages.push((raw.sequence, raw.payload.to_vec()));
            }
            if !more {
                return (messages, decoder.skipped());
            }
        }
    }

    #[test]
    fn the_check_is_the_usual_crc_32() {
        let mut out = Vec::new();
        encode(1, 2, &[], &mut out).unwrap();
        assert_eq!(crc32fast::hash(b"123456789"), 0xcbf4_3926);
        assert_eq!(out[..16], [b'H', b'L', b'N', b'V', 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(out.len(), HEADER_BYTES + CHECK_BYTES);
    }

    #[test]
    fn the_longest_message_passes_and_a_longer_length_is_rejected() {
        let payload = vec![0x48; MAX_PAYLOAD_BYTES];
        let mut bytes = Vec::new();
        encode(3, 7, &payload, &mut bytes).unwrap();
        assert_eq!(decoded(&bytes, 1000), (vec![(7, payload)], 0));
        for wrong in [MAX_PAYLOAD_BYTES + 4, 6] {
            assert_eq!(encode(3, 7, &vec![0; wrong], &mut bytes), Err(PayloadError { bytes: wrong }));
            assert_eq!(bytes.len(), MAX_MESSAGE_BYTES);
        }
        // A header that is valid except for its length.
        let mut long = MAGIC.to_vec();
        [3, MAX_PAYLOAD_BYTES as u32 + 4, 0].iter().for_each(|word: &u32| long.extend(word.to_le_bytes()));
        long.extend(crc32fast::hash(&long).to_le_bytes());
        let mut bytes = long.clone();
        encode(3, 8, &[1, 2, 3, 4], &mut bytes).unwrap();
        assert_eq!(decoded(&bytes, usize::MAX), (vec![(8, vec![1, 2, 3, 4])], long.len() as u64));
    }

    /// A message, or a fault in its place.
    #[derive(Debug, Clone)]
    enum Piece {
        Good(Vec<u8>),
        Flipped(Vec<u8>, prop::sample::Index),
        CutAt(Vec<u8>, prop::sample::Index),
        Noise(Vec<u8>),
        Magic(Vec<u8>),
    }

    fn piece() -> impl Strategy<Value = Piece> {
        let payload = || prop::collection::vec(any::<u8>(), 0..20).prop_map(|words| words.repeat(4));
        let index = any::<prop::sample::Index>;
        prop_oneof![
            4 => payload().prop_map(Piece::Good),
            1 => (payload(), index()).prop_map(|(p, i)| Piece::Flipped(p, i)),
            1 => (payload(), index()).prop_map(|(p, i)| Piece::CutAt(p, i)),
            1 => prop::collection::vec(any::<u8>(), 0..50).prop_map(Piece::Noise),
            1 => prop::collection::vec(any::<u8>(), 0..8).prop_map(|rest| Piece::Magic([&MAGIC[..], &rest].concat())),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// All intact messages arrive in order, whatever is between them, and every other byte is counted.
        #[test]
        fn no_intact_message_is_lost(pieces in prop::collection::vec(piece(), 0..12), size in 1..300usize) {
            let (mut bytes, mut good, mut other) = (Vec::new(), Vec::new(), 0);
            for (sequence, piece) in pieces.into_iter().enumerate() {
                let mut message = Vec::new();
                match piece {
                    Piece::Good(payload) => {
                        encode(1, sequence as u32, &payload, &mut message).unwrap();
                        good.push((sequence as u32, payload));
                        bytes.extend(message);
                        continue;
                    }
                    Piece::Flipped(payload, at) => {
                        encode(1, sequence as u32, &payload, &mut message).unwrap();
                        let at = at.index(8 * message.len());
                        message[at / 8] ^= 1 << (at % 8);
                    }
                    Piece::CutAt(payload, at) => {
                        encode(1, sequence as u32, &payload, &mut message).unwrap();
                        // If only one byte were missing, one in 256 of the following bytes would complete the message.
                        message.truncate(at.index(message.len() - CHECK_BYTES));
                    }
                    Piece::Noise(noise) | Piece::Magic(noise) => message = noise,
                }
                other += message.len() as u64;
                bytes.extend(message);
            }
            prop_assert_eq!(decoded(&bytes, size), (good, other));
        }
    }
}
