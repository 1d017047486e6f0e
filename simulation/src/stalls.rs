//! The pauses of both streams in each clock cycle, drawn from one seed.

use hoverlock_harness::bus::Switch;

use crate::Streams;

/// xorshift64*.
#[derive(Clone, Copy)]
struct Random(u64);

impl Random {
    fn chance(&mut self, p: f64) -> bool {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let draw = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        p > 0.0 && (draw as f64) < p * (1u64 << 53) as f64
    }
}

/// Draws the pauses. The stall pattern of a run follows from its seed alone: every cycle draws for the source, and for
/// the sink once it is open. Held cycles, those of a reset, draw nothing.
pub(crate) struct Stalls {
    streams: Streams,
    random: Random,
    /// The state before the last draw.
    before: Random,
    /// The cycle that is drawn next.
    cycle: u64,
    is_held: bool,
    /// On in the cycles in which the source pauses.
    pub source: Switch,
    /// On in the cycles in which the sink pauses.
    pub sink: Switch,
}

impl Stalls {
    /// Creates the stalls of a run, held.
    pub fn new(streams: Streams) -> Self {
        let random = Random(streams.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let [source, sink] = [Switch::default(), Switch::default()];
        Self { streams, random, before: random, cycle: 0, is_held: true, source, sink }
    }

    /// Draws the pauses of the cycle that follows a clock edge.
    pub fn draw(&mut self) {
        if self.is_held {
            return;
        }
        let Streams { source_pause, sink_pause, sink_opens, .. } = self.streams;
        self.before = self.random;
        self.source.set(self.random.chance(source_pause));
        self.sink.set(self.cycle < sink_opens || self.random.chance(sink_pause));
        self.cycle += 1;
    }

    /// Takes back the draw of the cycle that follows, which becomes the first of a reset.
    pub fn hold(&mut self) {
        self.random = self.before;
        self.is_held = true;
    }

    /// Goes on with the next clock edge, which draws for `cycle`.
    pub fn release(&mut self, cycle: u64) {
        self.cycle = cycle;
        self.is_held = false;
    }
}
