//! A stream-to-memory DMA with descriptors: as much of Altera's modular scatter-gather DMA as the feature path needs.
//!
//! A descriptor names a buffer. The DMA fills it record by record and answers with the number of bytes; the
//! end of the packet ends the descriptor early. Without a descriptor `ready` is low, so records wait in the FIFO of
//! the top.

use std::collections::VecDeque;

use crate::records::Words;

/// Bytes that the component for Platform Designer passes on in a clock cycle.
const BEAT: usize = 8;

/// A buffer to be filled: byte offset in the memory and bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    pub offset: usize,
    pub bytes: usize,
}

/// The result of a descriptor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response {
    /// Bytes written.
    pub bytes: usize,
    /// The packet has ended in this buffer; otherwise it goes on in the next.
    pub ended: bool,
}

/// The DMA and the memory it writes.
#[derive(Debug)]
pub struct Dma {
    /// Bytes of a record.
    record: usize,
    memory: Vec<u8>,
    descriptors: VecDeque<Descriptor>,
    responses: VecDeque<Response>,
    /// Bytes written for the first descriptor.
    written: usize,
    /// Beats until the record taken last is in the memory, and whether it ended the packet.
    pending: Option<(usize, bool)>,
}

impl Dma {
    /// Creates a DMA for records of `record` bytes with `bytes` bytes of memory, not written yet.
    pub fn new(record: usize, bytes: usize) -> Self {
        Self {
            record,
            memory: vec![0xa5; bytes],
            descriptors: VecDeque::new(),
            responses: VecDeque::new(),
            written: 0,
            pending: None,
        }
    }

    /// Appends a descriptor.
    pub fn give(&mut self, descriptor: Descriptor) {
        self.descriptors.push_back(descriptor);
    }

    /// Takes the oldest response; `None` if there is none.
    pub fn answer(&mut self) -> Option<Response> {
        self.responses.pop_front()
    }

    /// Returns `true` if there is a response.
    pub fn has_answer(&self) -> bool {
        !self.responses.is_empty()
    }

    /// Returns the first `bytes` bytes of a buffer.
    pub fn read(&self, descriptor: Descriptor, bytes: usize) -> &[u8] {
        &self.memory[descriptor.offset..descriptor.offset + bytes]
    }

    /// Returns the level of `feature_ready`.
    pub fn ready(&self) -> bool {
        self.pending.is_none() && !self.descriptors.is_empty()
    }

    /// Processes a clock edge, with the record that is accepted at it.
    pub fn clock(&mut self, accepted: Option<(Words, bool)>) {
        if let Some((beats, last)) = self.pending {
            self.pending = Some((beats - 1, last)).filter(|(beats, _)| *beats > 0);
            if self.pending.is_none() {
                self.complete(last);
            }
        }
        let Some(((words, last), descriptor)) = accepted.zip(self.descriptors.front()) else { return };
        let at = descriptor.offset + self.written;
        for (bytes, word) in self.memory[at..at + self.record].chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        self.written += self.record;
        self.pending = Some((self.record / BEAT - 1, last));
    }

    /// Completes the write of a record, and the descriptor if the packet or the buffer ends.
    fn complete(&mut self, last: bool) {
        let full = self.descriptors.front().is_some_and(|descriptor| self.written + self.record > descriptor.bytes);
        if last || full {
            self.responses.push_back(Response { bytes: self.written, ended: last });
            self.descriptors.pop_front();
            self.written = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use hoverlock_registers::record::RECORD_WORDS;

    use super::*;

    /// Sends records of a packet while the DMA takes them; returns how many it took within `cycles` cycles.
    fn send(dma: &mut Dma, records: &[u32], cycles: usize) -> usize {
        let mut taken = 0;
        for _ in 0..cycles {
            let record = (dma.ready() && taken < records.len())
                .then(|| ([records[taken]; RECORD_WORDS], taken + 1 == records.len()));
            taken += usize::from(record.is_some());
            dma.clock(record);
        }
        taken
    }

    #[test]
    fn a_packet_ends_its_descriptor_and_a_long_one_goes_on_in_the_next() {
        let mut dma = Dma::new(32, 256);
        let buffers = [0, 128].map(|offset| Descriptor { offset, bytes: 128 });
        assert_eq!(send(&mut dma, &[1], 20), 0, "no descriptor, no record");
        buffers.iter().for_each(|buffer| dma.give(*buffer));
        // A record is in the memory before its response is there.
        assert_eq!(send(&mut dma, &[1, 2], 7), 2);
        assert_eq!(dma.answer(), None);
        dma.clock(None);
        assert_eq!(dma.answer(), Some(Response { bytes: 64, ended: true }));
        assert_eq!(
            dma.read(buffers[0], 64),
            [[1u32; 8], [2; 8]].concat().iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>()
        );
        // Six records: four fill the second buffer, two go into the first, which has been given back.
        dma.give(buffers[0]);
        assert_eq!(send(&mut dma, &[3, 4, 5, 6, 7, 8], 100), 6);
        assert_eq!(dma.answer(), Some(Response { bytes: 128, ended: false }));
        assert_eq!(dma.answer(), Some(Response { bytes: 64, ended: true }));
        assert_eq!((dma.read(buffers[1], 128)[96], dma.read(buffers[0], 64)[0]), (6, 7));
        assert_eq!((dma.answer(), dma.ready()), (None, false));
    }
}
