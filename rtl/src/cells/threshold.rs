//! The threshold of a frame: manual, or from the responses of the frame before, as
//! [`hoverlock_fixed_point::model::threshold`] defines it.
//!
//! All eligible maxima of at least the floor are counted in bins, eight an octave, in a small memory. Two maxima of a
//! row are at least four steps apart, so a count is written back before the next is read. When the next frame enters
//! the window the bins are added up from the highest down and cleared, one a step, at most 80 of them. The threshold
//! is set 3 lines and 10 steps later, at the marker of the window stage: at least 202 steps. No maximum comes in
//! between, because the first and the last 18 rows of a frame have none.

use rust_hdl::prelude::*;

use super::{Response, low, zeros};
use crate::design::DOG_BITS;

/// Octaves that the bins leave out, because their responses are below the floor of `2^DOG_BITS >> 10`.
const FIRST_OCTAVE: usize = DOG_BITS.saturating_sub(12);

/// The floor as a power of two.
const FLOOR_BIT: usize = DOG_BITS.saturating_sub(10);

/// The highest bin. Bins count from the first of the octave [`FIRST_OCTAVE`].
const TOP_BIN: u64 = 8 * (DOG_BITS - 3 - FIRST_OCTAVE) as u64 + 7;

/// The bin of the floor.
const FLOOR_BIN: u64 = if FLOOR_BIT < 3 { 1 << FLOOR_BIT } else { 0 };

/// Memories of the bins, chosen by the lowest bits of a bin. With four each is small enough for logic: Yosys takes a
/// block memory from 512 bits on.
const BANKS: u64 = 4;

/// Bins of the widest responses.
const MOST_BINS: u64 = 80;

/// Most maxima that a bin counts.
const MAX_COUNT: u64 = 0xffff;

/// `T` of a frame.
#[derive(LogicBlock)]
pub struct Threshold {
    /// Clock: registers sample at its rising edge.
    pub clock: Signal<In, Clock>,
    /// Synchronous reset, active high.
    pub reset: Signal<In, Bit>,
    /// Clock enable: one step.
    pub advance: Signal<In, Bit>,
    /// A frame enters the window: the bins of the frame before are complete. At least 86 steps before `start`.
    pub enters: Signal<In, Bit>,
    /// A frame begins at the window stage.
    pub start: Signal<In, Bit>,
    /// A maximum was found, whether it reaches the threshold or not.
    pub maximum: Signal<In, Bit>,
    /// A feature was found (counted before drops).
    pub hit: Signal<In, Bit>,
    /// Response in the step of `maximum`.
    pub centre: Signal<In, Response>,
    /// Automatic mode: the threshold follows the responses.
    pub follow: Signal<In, Bit>,
    /// Threshold in manual mode.
    pub manual: Signal<In, Response>,
    /// Target number of features `N`, stable from `enters` to `start`.
    pub target: Signal<In, Bits<16>>,
    /// `T` of this frame.
    pub threshold: Signal<Out, Response>,
    /// Features of this frame so far.
    pub count: Signal<Out, Bits<20>>,
    _follows: bool,
    _memory: Vec<u64>,
    /// The bin that is read, the one that is written, and the one that was added last.
    _bins: [u64; 3],
    /// A count rises: it is read, raised, written.
    _counting: [bool; 3],
    /// The bins are added up: one is read, one is cleared, the sum is compared.
    _summing: [bool; 3],
    /// The count that was read last, and the one added last.
    _words: [u64; 2],
    /// The count that is written next.
    _written: u64,
    _sum: u64,
    /// The sum has reached the target: in this bin with this count, with this surplus.
    _reached: bool,
    _last: u64,
    _inside: u64,
    _surplus: u64,
    _quarters: u64,
    _few: bool,
    /// Seven and nine times the target: eight times the features of a frame that has met it are between them.
    _limits: [u64; 2],
    _met: bool,
    _wanted: u64,
    _lowest: u64,
    _next: u64,
}

impl Default for Threshold {
    fn default() -> Self {
        Self {
            clock: Signal::default(),
            reset: Signal::default(),
            advance: Signal::default(),
            enters: Signal::default(),
            start: Signal::default(),
            maximum: Signal::default(),
            hit: Signal::default(),
            centre: Signal::default(),
            follow: Signal::default(),
            manual: Signal::default(),
            target: Signal::default(),
            threshold: Signal::default(),
            count: Signal::default(),
            _follows: false,
            _memory: vec![0; 128],
            _bins: [0; 3],
            _counting: [false; 3],
            _summing: [false; 3],
            _words: [0; 2],
            _written: 0,
            _sum: 0,
            _reached: false,
            _last: 0,
            _inside: 0,
            _surplus: 0,
            _quarters: 0,
            _few: false,
            _limits: [0; 2],
            _met: false,
            _wanted: 0,
            _lowest: 0,
            _next: 0,
        }
    }
}

/// Returns the bin of a response of at least the floor: its octave above the three bits below its highest.
fn bin_of(response: u64) -> u64 {
    let octave = (response.ilog2() as usize).saturating_sub(2);
    let mantissa = response >> octave.saturating_sub(1) & 7;
    8 * (octave - FIRST_OCTAVE) as u64 + mantissa
}

/// Returns the response some quarters of a bin above its edge.
fn within(bin: u64, quarters: u64) -> u64 {
    let (octave, mantissa) = ((bin >> 3) as usize + FIRST_OCTAVE, bin & 7);
    if octave == 0 { mantissa } else { (32 | mantissa << 2 | quarters) << (octave - 1) >> 2 }
}

impl Threshold {
    /// The registers that settle between the last sum and `start`, the last of them first.
    fn settle(&mut self) {
        let (threshold, count, target) =
            (self.threshold.val().to_u64(), self.count.val().to_u64(), self.target.val().to_u64());
        self._next = if self._met { threshold } else { self._wanted.max(self._lowest) };
        self._lowest = if self._few { threshold - (threshold >> 6) } else { threshold >> 3 };
        self._wanted = if self._reached { within(self._last, self._quarters) } else { 1 << FLOOR_BIT };
        self._quarters = (1..4).filter(|part| 4 * self._surplus >= part * self._inside).count() as u64;
        self._few = !self._reached && 8 * self._sum < target;
        let [least, most] = self._limits;
        self._met = (least..=most).contains(&(8 * count));
        self._limits = [7 * target, 9 * target];
    }

    /// The bins: a sum or a count, the last step first.
    fn step(&mut self) {
        let target = self.target.val().to_u64();
        let reached = self._reached;
        if self._summing[2] && !reached {
            (self._reached, self._last, self._inside) = (self._sum >= target, self._bins[2], self._words[1]);
            self._surplus = low(self._sum.wrapping_sub(target), 16);
        }
        if self._summing[1] && !reached {
            self._sum += self._words[0];
        }
        if self.enters.val() {
            (self._sum, self._reached) = (0, false);
        }
        let read = self._memory[self._bins[0] as usize];
        if self._summing[2] || self._counting[2] {
            self._memory[self._bins[2] as usize] = self._written;
        }
        self._written = if self._summing[1] { 0 } else { (self._words[0] + 1).min(MAX_COUNT) };
        self._words = [read, self._words[0]];
        let centre = self.centre.val().to_u64();
        let (bin, is_lowest) = (self._bins[0], self._bins[0] == FLOOR_BIN);
        let counts = self.maximum.val() && centre >> FLOOR_BIT != 0;
        let next = match (self.enters.val(), self._summing[0]) {
            (true, _) => TOP_BIN,
            (_, true) => low(bin.wrapping_sub(1), 7),
            _ if counts => bin_of(centre),
            _ => bin,
        };
        self._bins = [next, self._bins[0], self._bins[1]];
        self._counting = [counts, self._counting[0], self._counting[1]];
        let summing = self.enters.val() || (self._summing[0] && !is_lowest);
        self._summing = [summing, self._summing[0], self._summing[1]];
    }

    /// A frame begins, with this threshold if it follows.
    fn begin(&mut self, next: u64) {
        self.count.next = 0u64.into();
        let manual = self.manual.val().to_u64().max(1);
        self.threshold.next = if self.follow.val() && self._follows { next } else { manual }.into();
        self._follows = self.follow.val();
    }
}

impl Logic for Threshold {
    fn update(&mut self) {
        if !self.clock.pos_edge() {
            return;
        }
        let advance = self.advance.val();
        // An output that is written reads as the new value.
        let next = self._next;
        self.settle();
        if self.reset.val() {
            self.count.next = 0u64.into();
            self.threshold.next = 0u64.into();
            self._follows = false;
            (self._counting, self._summing) = ([false; 3], [false; 3]);
        } else if advance && self.start.val() {
            self.begin(next);
        } else if advance && self.hit.val() {
            self.count.next = low(self.count.val().to_u64() + 1, 20).into();
        }
        if advance && !self.reset.val() {
            self.step();
        }
    }

    fn connect(&mut self) {
        self.threshold.connect();
        self.count.connect();
    }

    fn hdl(&self) -> Verilog {
        let memory = format!("(* ramstyle = \"MLAB\" *) reg [15:0] counts_i [0:{}];\n", MOST_BINS / BANKS - 1);
        let numbers = [
            ("MEMORIES", (0..BANKS).map(|i| memory.replace("_i", &format!("_{i}"))).collect()),
            ("WRITES", (0..BANKS).map(write).collect()),
            (
                "REACHES_FLOOR",
                if FLOOR_BIT == 0 {
                    "maximum".into()
                } else {
                    format!("maximum & (centre[DOG_BITS-1:{FLOOR_BIT}] != {})", zeros(DOG_BITS - FLOOR_BIT))
                },
            ),
            ("BIN_OF_CENTRE", bin_of_centre()),
            ("WITHIN", within_text()),
            ("FLOOR_BIN", format!("7'd{FLOOR_BIN}")),
            ("FLOOR", format!("DOG_BITS'd{}", 1 << FLOOR_BIT)),
            ("TOP_BIN", format!("7'd{TOP_BIN}")),
            ("A_64TH", if DOG_BITS > 6 { "{6'd0, threshold[DOG_BITS-1:6]}".into() } else { zeros(DOG_BITS) }),
        ];
        Verilog::Custom(numbers.iter().fold(TEXT.to_owned(), |text, (name, number)| text.replace(name, number)))
    }
}

/// The Verilog with the places of numbers in capitals.
const TEXT: &str = "\
// module: threshold
MEMORIES
reg [6:0]  bin;
reg [6:0]  bin_1;
reg [6:0]  bin_2;
reg        counting;
reg        counting_1;
reg        counting_2;
reg        summing;
reg        summing_1;
reg        summing_2;
reg [15:0] word;
reg [15:0] word_1;
reg [15:0] written;
reg [17:0] sum;
reg        reached;
reg [6:0]  last;
reg [15:0] last_count;
reg [15:0] surplus;
reg        follows;

// A count rises at a maximum of at least the floor; all are cleared while they are added up.
reg [6:0]  bin_of_centre;
wire       counts = REACHES_FLOOR;
wire [15:0] read_low = bin[0] ? counts_1[bin[6:2]] : counts_0[bin[6:2]];
wire [15:0] read_high = bin[0] ? counts_3[bin[6:2]] : counts_2[bin[6:2]];
wire       write = counting_2 | summing_2;

always @(*)
BIN_OF_CENTRE
always @(posedge clock)
  if (reset) begin
    counting   <= 1'b0;
    counting_1 <= 1'b0;
    counting_2 <= 1'b0;
    summing    <= 1'b0;
    summing_1  <= 1'b0;
    summing_2  <= 1'b0;
  end else if (advance) begin
    counting   <= counts;
    counting_1 <= counting;
    counting_2 <= counting_1;
    summing    <= enters | (summing & (bin != FLOOR_BIN));
    summing_1  <= summing;
    summing_2  <= summing_1;
  end

always @(posedge clock)
  if (advance & ~reset) begin
    bin    <= enters ? TOP_BIN : summing ? bin - 7'd1 : counts ? bin_of_centre : bin;
    bin_1  <= bin;
    bin_2  <= bin_1;
    word   <= bin[1] ? read_high : read_low;
    word_1 <= word;
    written <= summing_1 ? 16'd0 : word + {15'd0, word != 16'hffff};
  end

WRITES// The first sum that reaches the target, from the highest bin down.
wire [15:0] over = sum[15:0] - target;

always @(posedge clock)
  if (advance & ~reset) begin
    if (enters) begin
      sum     <= 18'd0;
      reached <= 1'b0;
    end else if (~reached) begin
      if (summing_1)
        sum   <= sum + {2'd0, word};
      reached <= summing_2 & (sum >= {2'd0, target});
    end
    if (summing_2 & ~reached) begin
      last       <= bin_2;
      last_count <= word_1;
      surplus    <= over;
    end
  end

// The threshold that follows, registered in steps: it is ready before the frame begins.
reg        quarter_1;
reg        quarter_2;
reg        quarter_3;
reg        few;
reg [18:0] least; // seven times the target
reg [19:0] most;  // nine times
reg        met;
reg [DOG_BITS-1:0] from_bins;
reg [DOG_BITS-1:0] wanted;
reg [DOG_BITS-1:0] lowest;
reg [DOG_BITS-1:0] next;
wire [1:0] quarters = {quarter_2, quarter_3 | (quarter_1 & ~quarter_2)};
wire [22:0] eight_counts = {count, 3'd0};
wire [18:0] eight_targets = {target, 3'd0};
wire [DOG_BITS-1:0] fallen = threshold - A_64TH;

always @(*)
WITHIN
always @(posedge clock) begin
  quarter_1 <= {surplus, 2'd0} >= {2'd0, last_count};
  quarter_2 <= {surplus, 1'b0} >= {1'b0, last_count};
  quarter_3 <= {surplus, 2'd0} >= {2'd0, last_count} + {1'b0, last_count, 1'b0};
  few       <= ~reached & ({sum, 3'd0} < {5'd0, target});
  least     <= eight_targets - {3'd0, target};
  most      <= {1'b0, eight_targets} + {4'd0, target};
  met       <= (eight_counts >= {4'd0, least}) & (eight_counts <= {3'd0, most});
  wanted    <= reached ? from_bins : FLOOR;
  lowest    <= few ? fallen : {3'd0, threshold[DOG_BITS-1:3]};
  next      <= met ? threshold : wanted > lowest ? wanted : lowest;
end

always @(posedge clock)
  if (reset) begin
    count     <= 20'd0;
    follows   <= 1'b0;
    threshold <= DOG_BITS'd0;
  end else if (advance) begin
    if (start) begin
      count   <= 20'd0;
      follows <= follow;
      if (follow & follows)
        threshold <= next;
      else
        threshold <= manual == DOG_BITS'd0 ? DOG_BITS'd1 : manual;
    end else if (hit)
      count <= count + 20'd1;
  end
";

/// Returns the Verilog that writes a memory of bins.
fn write(bank: u64) -> String {
    format!(
        "always @(posedge clock)
  if (advance & ~reset & write & (bin_2[1:0] == 2'd{bank}))
    counts_{bank}[bin_2[6:2]] <= written;

"
    )
}

/// Returns the Verilog of [`bin_of`].
fn bin_of_centre() -> String {
    let mut text = String::from("  ");
    for octave in (1..=TOP_BIN as usize / 8).rev() {
        let top = octave + FIRST_OCTAVE + 2;
        let bits = format!("centre[{}:{}]", top - 1, top - 3);
        text += &format!("if (centre[{top}])\n    bin_of_centre = {{4'd{octave}, {bits}}};\n  else ");
    }
    // The lowest octave, or the responses below 8.
    let low = FIRST_OCTAVE.max(1);
    format!("{}\n    bin_of_centre = {{4'd0, centre[{}:{}]}};\n", text.trim_end(), low + 1, low - 1)
}

/// Returns the Verilog of [`within`].
fn within_text() -> String {
    let mut text = String::from("  case (last[6:3])\n");
    for octave in 0..=TOP_BIN as usize / 8 {
        let shift = octave + FIRST_OCTAVE;
        let (value, bits) = match shift {
            0 => ("last[2:0]".to_owned(), 3),
            1 => ("1'b1, last[2:0]".to_owned(), 4),
            2 => ("1'b1, last[2:0], quarters[1]".to_owned(), 5),
            3 => ("1'b1, last[2:0], quarters".to_owned(), 6),
            _ => (format!("1'b1, last[2:0], quarters, {}", zeros(shift - 3)), shift + 3),
        };
        let pad = if bits < DOG_BITS { format!("{}, ", zeros(DOG_BITS - bits)) } else { String::new() };
        let label = if octave == TOP_BIN as usize / 8 { "default".to_owned() } else { format!("4'd{octave}") };
        text += &format!("    {label}: from_bins = {{{pad}{value}}};\n");
    }
    text + "  endcase\n"
}
