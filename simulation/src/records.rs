//! The record comparisons: records that the datapath writes against `bit_true`, and records that leave the FIFO against
//! those written.
//!
//! Features of `bit_true`'s list that the record limit lets through may be missing if the FIFO had no room, which needs
//! a sink that pauses, or the queue of candidates; the trailer must count exactly those. The two checks locate a fault:
//! a record that is wrong when written is an error before the FIFO, one that changes later an error of the FIFO.

use std::collections::VecDeque;

use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_registers::record::{
    FLAG_BRIGHT, FLAG_SCALE, FLAG_TEN_WORDS, FLAG_THIRD, FLAG_TRAILER, RECORD_WORDS, record_words,
};

use hoverlock_design::DesignPoint;

use crate::{
    expect::Expected,
    job::{Job, Streams},
    outcome::{Outcome, Position},
};

/// A record of the hardware: eight or ten 32-bit words, the others 0.
pub(super) type Words = [u32; RECORD_WORDS];

/// Lines within which a candidate leaves the queue: 15 and some steps, see the header of `candidate_queue.v`.
const QUEUE_LINES: usize = 17;

/// The flag bits of the scale pair.
const SCALE: u16 = FLAG_SCALE | FLAG_THIRD;

fn is_trailer(words: &Words) -> bool {
    words[1] >> 16 & u32::from(FLAG_TRAILER) != 0
}

fn position(frame: usize, words: &Words) -> Position {
    Position { frame, x: (words[0] & 0xffff) as usize, y: (words[0] >> 16) as usize }
}

/// One beat of the feature stream.
pub(super) struct Taken {
    pub words: Words,
    pub first: bool,
    pub last: bool,
}

/// The records of a run.
#[derive(Default)]
pub(super) struct Records {
    /// LSB of a response, DN.
    lsb: f64,
    /// Words of a record.
    words: usize,
    /// Candidates that wait for their rings at most.
    queue: usize,
    /// The sink takes a record in every cycle, so the FIFO always has room.
    sink_flows: bool,
    /// The frame whose records are written, and that of trailer number 0.
    frame: usize,
    origin: usize,
    /// Of its list: the number of records already matched or skipped, and the indices of the skipped ones.
    past: usize,
    missing: Vec<usize>,
    /// Records written and not yet read.
    fifo: VecDeque<Words>,
    /// The frame whose records are taken.
    pub done: usize,
    inside: bool,
}

impl Records {
    /// Creates the records of a run before its first.
    pub fn of(design: &DesignPoint, streams: Streams) -> Self {
        Self {
            lsb: design.dog().lsb(),
            words: record_words(design.pairs()),
            queue: design.candidate_queue as usize,
            sink_flows: streams.sink_flows(),
            ..Self::default()
        }
    }

    /// Returns the frame whose records are written next.
    pub fn writing(&self) -> usize {
        self.frame
    }

    /// Returns the number of frames taken since the pipeline was last emptied.
    pub fn frames(&self) -> usize {
        self.done - self.origin
    }

    /// Starts again with a frame, after the pipeline was emptied.
    pub fn restart(&mut self, frame: usize) {
        let Self { lsb, words, queue, sink_flows, .. } = *self;
        *self = Self { frame, origin: frame, done: frame, lsb, words, queue, sink_flows, ..Self::default() };
    }

    /// Compares a record that the datapath writes with the model.
    pub fn written(&mut self, words: Words, job: &Job, expected: &Expected, cycle: u64, outcome: &mut Outcome) {
        let lsb = self.lsb;
        self.fifo.push_back(words);
        if is_trailer(&words) {
            self.trailer(&words, job, expected, cycle, outcome);
            (self.frame, self.past) = (self.frame + 1, 0);
            self.missing.clear();
            return;
        }
        let rest = &expected.records[self.past.min(expected.records.len())..];
        let same_position = |feature: &&FeatureRecord| {
            let packed = feature.pack();
            packed[0] == words[0] && (packed[1] ^ words[1]) >> 16 & u32::from(SCALE) == 0
        };
        let found = rest.iter().position(|feature| feature.pack() == words);
        match found.or_else(|| rest.iter().position(|feature| same_position(&feature))) {
            Some(ahead) => {
                if found.is_none() {
                    let [stage, texts @ ..] = differences(&rest[ahead].pack(), &words, lsb);
                    outcome.differ(&stage, position(self.frame, &words), cycle, || texts);
                }
                self.missing.extend(self.past..self.past + ahead);
                self.past += ahead + 1;
            }
            None => {
                let next = || rest.first().map_or("no more features".into(), |next| described(next, lsb));
                let actual = || {
                    FeatureRecord::unpack(&words[..self.words]).map_or(format!("{words:08x?}"), |r| described(&r, lsb))
                };
                outcome
                    .differ("decision", position(self.frame, &words), cycle, || ["feature".into(), next(), actual()]);
            }
        }
    }

    fn trailer(&mut self, words: &Words, job: &Job, expected: &Expected, cycle: u64, outcome: &mut Outcome) {
        let list = &expected.records;
        self.missing.extend(self.past..list.len());
        let dropped = words[3] as usize;
        if dropped < self.missing.len() {
            let first = &list[self.missing[dropped]];
            let at = Position { frame: self.frame, x: first.x.into(), y: first.y.into() };
            outcome.differ("decision", at, cycle, || {
                ["feature".into(), described(first, self.lsb), format!("none, and {dropped} counted as dropped")]
            });
        }
        let has_room = |at: &&usize| self.sink_flows && !self.may_fill_queue(list, **at, job.size().0);
        if let Some(&at) = self.missing.iter().find(has_room) {
            let first = &list[at];
            let at = Position { frame: self.frame, x: first.x.into(), y: first.y.into() };
            outcome.differ("trailer", at, cycle, || {
                ["dropped".into(), described(first, self.lsb), "none, although queue and FIFO have room".into()]
            });
        }
        let ten_words = expected.thresholds.len() > 2;
        let flags = FLAG_TRAILER | if ten_words { FLAG_TEN_WORDS } else { 0 };
        let threshold_words = halves(&expected.thresholds);
        let fields = [
            ("frame number", (self.frame - self.origin) as u32, words[0]),
            ("flags and errors", u32::from(flags) << 16 | job.errors(), words[1]),
            ("features", (list.len() - self.missing.len()) as u32, words[2]),
            ("dropped", self.missing.len() as u32, words[3]),
            ("thresholds", threshold_words[0], words[4]),
            ("threshold 2", threshold_words[1], words[5]),
            ("withheld", expected.withheld as u32, words[6]),
            ("reserved", 0, words[7..].iter().fold(0, |all, word| all | word)),
        ];
        if let Some((field, want, got)) = fields.into_iter().find(|(_, want, got)| want != got) {
            let at = Position { frame: self.frame, x: 0, y: 0 };
            let text = |word: u32| format!("0x{word:08x}, {word}");
            outcome.differ("trailer", at, cycle, || [field.into(), text(want), text(got)]);
        }
        if let Some(frame) = outcome.frames.get_mut(self.frame) {
            frame.model_features = list.len() as u64;
            frame.thresholds = expected.thresholds.clone();
        }
    }

    /// Returns `true` if the queue may be full when the feature at this place of its frame's list comes: if at least as
    /// many candidates as it holds came before, and may still wait.
    fn may_fill_queue(&self, list: &[FeatureRecord], at: usize, width: usize) -> bool {
        let step = |feature: &FeatureRecord| usize::from(feature.y) * width + usize::from(feature.x);
        let now = step(&list[at]);
        let mut waiting: Vec<usize> =
            list[..at].iter().map(step).filter(|before| *before < now && *before + QUEUE_LINES * width > now).collect();
        // A feature of several scale pairs is one candidate.
        waiting.dedup();
        waiting.len() >= self.queue
    }

    /// Compares a record that the sink takes with the one that was written.
    pub fn taken(&mut self, beat: &Taken, cycle: u64, outcome: &mut Outcome) {
        let at = position(self.done, &beat.words);
        match self.fifo.pop_front() {
            Some(words) if words == beat.words => {}
            Some(words) => {
                let [_, texts @ ..] = differences(&words, &beat.words, self.lsb);
                outcome.differ("feature FIFO", at, cycle, || texts);
            }
            None => outcome.differ("feature FIFO", at, cycle, || {
                ["record".into(), "none was written".into(), format!("{:08x?}", beat.words)]
            }),
        }
        let last = is_trailer(&beat.words);
        for (field, want, got) in [("start of packet", !self.inside, beat.first), ("end of packet", last, beat.last)] {
            if want != got {
                outcome.differ("feature FIFO", at, cycle, || {
                    [field.into(), u8::from(want).to_string(), u8::from(got).to_string()]
                });
            }
        }
        self.inside = !last;
        if let Some(frame) = outcome.frames.get_mut(self.done) {
            match last {
                true => {
                    frame.dropped = beat.words[3].into();
                    outcome.dropped += frame.dropped;
                    outcome.model_features += frame.model_features;
                }
                false => {
                    frame.features += 1;
                    frame.records.extend(FeatureRecord::unpack(&beat.words[..self.words]));
                    outcome.features += 1;
                }
            }
        }
        self.done += usize::from(last);
    }
}

/// Returns thresholds of 16 bits in 32-bit words, the first lowest.
pub(super) fn halves(thresholds: &[u32]) -> [u32; 2] {
    let half = |k: usize| thresholds.get(k).copied().unwrap_or_default();
    [half(1) << 16 | half(0), half(2)]
}

/// Describes a record in one line.
fn described(record: &FeatureRecord, lsb: f64) -> String {
    let FeatureRecord { x, y, response, scale, .. } = record;
    let sign = if record.bright { '+' } else { '-' };
    let dn = f64::from(*response) * lsb;
    format!("({x}, {y}), scale pair {scale}, response 0x{response:04x}, {sign}{dn} DN")
}

/// Returns the faulty stage, and all fields that differ with their expected and actual values.
fn differences(want: &Words, got: &Words, lsb: f64) -> [String; 4] {
    let half = |words: &Words, word: usize, high: bool| if high { words[word] >> 16 } else { words[word] & 0xffff };
    let plain = |value: u32| format!("0x{value:04x}, {value}");
    let half_dn = |value: u32| format!("0x{value:04x}, {} DN", f64::from(value) * lsb);
    let mut fields: Vec<(String, String, String)> = Vec::new();
    let mut stage = "descriptor";
    let halves = [
        ("x", 0, false),
        ("y", 0, true),
        ("response", 1, false),
        ("left neighbour", 2, false),
        ("right neighbour", 2, true),
        ("upper neighbour", 3, false),
        ("lower neighbour", 3, true),
    ];
    for (name, word, high) in halves {
        let (want, got) = (half(want, word, high), half(got, word, high));
        if want != got {
            let text = |value: u32| if word == 0 { plain(value) } else { half_dn(value) };
            fields.push((name.into(), text(want), text(got)));
        }
    }
    let (flags, other) = (half(want, 1, true), half(got, 1, true));
    let bits = [("scale pair", SCALE), ("polarity", FLAG_BRIGHT), ("flags", !(SCALE | FLAG_BRIGHT))];
    for (name, mask) in bits {
        let (want, got) = (flags & u32::from(mask), other & u32::from(mask));
        if want != got {
            fields.push((name.into(), format!("flags 0x{want:04x}"), format!("flags 0x{got:04x}")));
        }
    }
    if !fields.is_empty() {
        stage = "record";
    }
    for (word, name) in (4..).zip(["MaxLBP 0", "MaxLBP 1", "sign 0", "sign 1", "MaxLBP 2", "sign 2"]) {
        let wrong = want[word] ^ got[word];
        if wrong != 0 {
            let list: Vec<_> = (0..32).filter(|bit| wrong >> bit & 1 == 1).map(|bit: u32| bit.to_string()).collect();
            let points = if wrong == !0 { "every ring point".into() } else { format!("ring point {}", list.join(" ")) };
            let name = format!("{name}, {points}");
            fields.push((name, format!("0x{:08x}", want[word]), format!("0x{:08x}", got[word])));
        }
    }
    let join = |part: fn(&(String, String, String)) -> &String| {
        fields.iter().map(part).map(String::as_str).collect::<Vec<_>>().join("; ")
    };
    [stage.into(), join(|field| &field.0), join(|field| &field.1), join(|field| &field.2)]
}
