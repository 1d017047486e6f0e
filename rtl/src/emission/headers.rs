//! The comment above each emitted module without a file of its own: purpose, equation, pipeline, latency.
//!
//! `{m}` is the look-ahead in a smoother's name, `{m-1}` one less. `<NAME>` is a number of the design or of the
//! pipeline.

use crate::design::{
    CANDIDATE_QUEUE, COEFFICIENT_BITS, COEFFICIENTS, DOG_BITS, DOG_SHIFT, LOOK_AHEAD, MAX_LOOK_AHEAD, MAX_WIDTH,
    PIXEL_BITS, RECORD_BITS, RECORD_FIFO, SCALE_PAIRS, SMOOTHER_LINES, SMOOTHER_STEPS, STATE_BITS, STATE_FRACTION_BITS,
};
use hoverlock_design::pipeline::{self, CELL_STEPS, row_steps};
use hoverlock_design::{MAX_RING_RADIUS, smoother_names};

/// Returns the comment above a module.
pub fn header(module: &str) -> String {
    let text = HEADERS.iter().filter(|(name, _)| module.starts_with(name)).max_by_key(|(name, _)| name.len());
    let text = text.map(|(_, text)| *text).unwrap_or_default();
    let filled = filled(&of_design(text), module);
    filled.lines().map(|line| format!("// {line}").trim_end().to_owned() + "\n").collect()
}

/// Puts the look-ahead of a smoother, the number in the module's name, in its places.
fn filled(text: &str, module: &str) -> String {
    let Ok(look_ahead) = module.trim_start_matches(|c: char| !c.is_ascii_digit()).parse::<u64>() else {
        return text.to_owned();
    };
    text.replace("{m}", &look_ahead.to_string())
        .replace("{m-1}", &look_ahead.saturating_sub(1).to_string())
        .replace("{m-2}", &look_ahead.saturating_sub(2).to_string())
        .replace("{row_steps}", &row_steps(look_ahead).to_string())
}

/// Puts the numbers of the design in their places.
fn of_design(text: &str) -> String {
    let half = if DOG_SHIFT == 0 { 0 } else { 1 << (DOG_SHIFT - 1) };
    let numbers = [
        ("LINES", SMOOTHER_LINES),
        ("STEPS", SMOOTHER_STEPS),
        ("PIXEL_BITS", PIXEL_BITS),
        ("FRACTION_BITS", STATE_FRACTION_BITS),
        ("SCALE", 1 << STATE_FRACTION_BITS),
        ("STATE_BITS", STATE_BITS),
        ("COEFFICIENT_BITS", COEFFICIENT_BITS),
        ("COEFFICIENTS", COEFFICIENTS),
        ("DOG_BITS", DOG_BITS),
        ("DOG_SHIFT", DOG_SHIFT),
        ("FLOOR", 1 << DOG_BITS.saturating_sub(10)),
        ("HALF", half),
        ("CANDIDATE_QUEUE", CANDIDATE_QUEUE),
        ("RECORD_FIFO", RECORD_FIFO),
        ("MAX_WIDTH", MAX_WIDTH),
        ("RECORD_BITS", RECORD_BITS),
    ];
    let k = SCALE_PAIRS - 1;
    let names: Vec<String> = smoother_names(LOOK_AHEAD.len()).iter().map(|name| format!("`{name}`")).collect();
    let (last, others) =
        names.split_last().map_or((String::new(), String::new()), |(last, others)| (last.clone(), others.join(", ")));
    let wide_rings = if SCALE_PAIRS > 2 { "wide rings" } else { "coarse ring" };
    let words = [
        ("ALIGNED", aligned()),
        ("ALL_PAIRS", ["the scale pair", "both scale pairs", "all scale pairs"][k].into()),
        ("THRESHOLDS", ["one threshold", "two thresholds", "three thresholds"][k].into()),
        ("PAIR_ORDER", ["", ", scale pair 0 before 1", ", the finer scale pair first"][k].into()),
        ("RECORD_STEPS", ["", "   step 4  record of pair 1", "   step 4  record of the next pair"][k].into()),
        ("SMOOTHED", format!("{others} and {last}")),
        ("WIDE_RINGS", wide_rings.into()),
    ];
    let steps = latencies();
    let numbers = numbers.into_iter().chain(steps.iter().map(|(name, steps)| (*name, *steps as usize)));
    let text = words.iter().fold(text.to_owned(), |text, (name, word)| text.replace(&format!("<{name}>"), word));
    numbers.fold(text, |text, (name, number)| text.replace(&format!("<{name}>"), &number.to_string()))
}

/// Returns the lines, steps and clocks of the headers.
fn latencies() -> [(&'static str, u64); 27] {
    let longest = MAX_LOOK_AHEAD as u64;
    let (lines, smoothed) = (pipeline::lines(longest), pipeline::smoothed_at(longest));
    let response = smoothed + pipeline::DIFFERENCE_STEPS;
    let ring = pipeline::ring_at(longest);
    // Of a scale pair, from its two smoothed samples on.
    let columns = pipeline::DIFFERENCE_STEPS + pipeline::COLUMN_MAXIMUM_STEPS;
    let decided = pipeline::DIFFERENCE_STEPS + pipeline::WINDOW_STEPS;
    [
        ("BORDER_STEPS", pipeline::BORDER_STEPS),
        ("LERP_STEPS", pipeline::LERP_STEPS),
        ("CELL_STEPS", CELL_STEPS),
        ("TREE_STEPS", pipeline::TREE_STEPS),
        ("CURSOR_STEPS", pipeline::CURSOR_STEPS),
        ("DIFFERENCE_STEPS", pipeline::DIFFERENCE_STEPS),
        ("COLUMN_MAXIMUM_STEPS", pipeline::COLUMN_MAXIMUM_STEPS),
        ("MAXIMUM_STEPS", pipeline::MAXIMUM_STEPS),
        ("QUEUE_STEPS", pipeline::QUEUE_STEPS),
        ("WRITER_STEPS", pipeline::WRITER_STEPS),
        ("SEQUENCER_CLOCKS", pipeline::SEQUENCER_CLOCKS),
        ("FIFO_CLOCKS", pipeline::FIFO_CLOCKS),
        ("BUS_CLOCKS", pipeline::SEQUENCER_CLOCKS + pipeline::FIFO_CLOCKS),
        ("SMOOTHED_AT", smoothed),
        ("RESPONSE_AT", response),
        ("RING_SAMPLE_LINES", lines + pipeline::MAX_DOG_RADIUS),
        ("RING_SAMPLE_AT", response + pipeline::MAX_DOG_STEPS),
        ("WINDOW_LINES", lines + pipeline::WINDOW_RADIUS),
        ("WINDOW_AT", response + pipeline::WINDOW_STEPS),
        ("RING_LINES", lines + pipeline::RING_LINES),
        ("RING_AT", ring),
        ("RECORD_AT", ring + pipeline::RECORD_STEPS),
        ("PAIR_COLUMNS", columns),
        ("PAIR_RING", columns + pipeline::window_maximum_steps(2 * pipeline::MAX_DOG_RADIUS + 1)),
        ("PAIR_WINDOW", decided - pipeline::WINDOW_RADIUS),
        ("PAIR_DECIDED", decided),
        ("RING_REACH", MAX_RING_RADIUS.into()),
    ]
}

/// Describes how the smoothers are aligned.
fn aligned() -> String {
    let longest = MAX_LOOK_AHEAD;
    let count = ["two", "three", "four"][SCALE_PAIRS - 1];
    // Look-ahead rises from the narrowest smoother to the widest.
    let mut shorter: Vec<usize> = LOOK_AHEAD.into_iter().filter(|m| *m != longest).collect();
    shorter.dedup();
    let delays: Vec<String> = shorter
        .iter()
        .map(|m| {
            let rows = CELL_STEPS as usize * (longest - m);
            let output = row_steps(longest as u64) - row_steps(*m as u64);
            format!("\n  look-ahead {m}   pixels {rows} steps later, output {output} steps later")
        })
        .collect();
    format!(
        "The {count} smoothers on the same pixels. Their column stages share one line memory and end in the same \
         step.{}",
        delays.concat()
    )
}

/// Texts by name prefix; the longest matching prefix counts.
const HEADERS: &[(&str, &str)] = &[
    (
        "hoverlock_top",
        "The feature extractor: Avalon-ST video in, Avalon-ST feature records out, Avalon-MM registers, an interrupt.
  registers   control and status registers; a frame captures a committed set as it begins
  core        everything between the two streams
One clock, one pixel per clock. A step is a clock edge with `advance` high in the core: one pixel, or none while the
pipeline drains.
Latency: <RING_LINES> lines, <RECORD_AT> steps and <BUS_CLOCKS> clocks from a pixel to its record; \
one clock from `csr_read` to read data.",
    ),
    (
        "hoverlock_core",
        "The extractor between its two streams.
  sequencer   beats to steps, every frame complete
  frame_bank  the committed set as captured by the frame that enters
  extractor   pixels to records
  fifo        <RECORD_FIFO> records
`advance` is the clock enable of the whole datapath. A step is a clock edge with `advance` high; latencies are in
steps and lines of W steps.
Latency: <SEQUENCER_CLOCKS> clocks in the sequencer, <RING_LINES> lines and <RECORD_AT> steps in the extractor, \
<FIFO_CLOCKS> clocks in the FIFO.",
    ),
    (
        "extractor",
        "From pixels to records.
  lines       steps   from the pixel
  0               1   input of the smoothers
  <LINES>            <SMOOTHED_AT>   smoothed states
  <LINES>            <RESPONSE_AT>   response DOG and its sign, <ALL_PAIRS>
  <RING_SAMPLE_LINES>            <RING_SAMPLE_AT>   MaxDOG and sign, input of the ring's line memories
  <WINDOW_LINES>            <WINDOW_AT>   operands of the decision at the centre of the 7x7 window; \
candidates enter the queue
  <RING_LINES>            <RING_AT>   position of the candidate, whose ring is complete one step later
  <RING_LINES>            <RECORD_AT>   its record
Latency: <RING_LINES> lines and <RECORD_AT> steps from a pixel to the record at `record`.",
    ),
    (
        "smoothers",
        "<ALIGNED>
  line_memory   rows of pixels for the two longest column stages of a smoother, rows of states for the others
  held          the last row of a frame, in place of the rows below it
  bank          the register values of the frame that reaches the column stages
`start` and `start_out` are one step before the first sample of a frame.
Latency: <LINES> lines and <STEPS> steps from `pixel` to <SMOOTHED>.",
    ),
    (
        "smoother_",
        "One two-sided first-order smoother of look-ahead m = {m}; every cell is a lerp, y = p + g (q - p).
  first_stage, second_stage   column_look_ahead_j, j = {m-1}, {m-2}, on pixels of four rows   <TREE_STEPS> steps
  column_look_ahead_j   u[r] = lerp(p = u[min(r + 2^j, H-1)], q = u[r], g_j)   \
2^j lines and <CELL_STEPS> steps, j = m-3 .. 0
  recursion             s[r] = lerp(p = s[r-1], q = u[r], g)                          <CELL_STEPS> steps
  row_look_back_j       u[c] = lerp(p = u[max(c - 2^j, 0)], q = u[c], g_j)            <CELL_STEPS> steps
  row_look_ahead_j      u[c] = lerp(p = u[min(c + 2^j, W-1)], q = u[c], g_j)    2^j + <CELL_STEPS> steps
Latency: {row_steps} steps from the state of the recursion to y.",
    ),
    (
        "column_look_ahead",
        "A column look-ahead stage: y[r] = lerp(p = u[min(r + 2^j, H - 1)], q = u[r], g_j).
`x` is u[r + 2^j], arriving; `delayed` is u[r], from the line memory; `held` is row H - 1 for the last 2^j rows.
  step 1  p, q   step 2  |q - p|   step 3  product   step 4  y
Latency: <CELL_STEPS> steps from `delayed` to its y.",
    ),
    (
        "column_memory",
        "Rows of all column look-ahead stages: taps_i[n] = pixel[n - k_i W], y_i[n] = x_i[n - l_i W]. All rows of
a column are one memory word, read, shifted by one row and written back. The address counts steps modulo W.
Latency: the lines of the output.",
    ),
    (
        "repeated_rows",
        "Pixels of the rows r, r + q, r + 2 q and r + 3 q of a column, the first lowest; `held`, the last row of the
frame, in place of rows outside it.
Latency: <BORDER_STEPS> step.",
    ),
    (
        "row_look_back",
        "Row look-back stage j, DISTANCE = 2^j: y[c] = lerp(p = u[max(c - DISTANCE, 0)], q = u[c], g_j).
  step 1  p, q   step 2  |q - p|   step 3  product   step 4  y
Latency: <CELL_STEPS> steps.",
    ),
    (
        "row_look_ahead",
        "Row look-ahead stage j, DISTANCE = 2^j: y[c] = lerp(p = u[min(c + DISTANCE, W - 1)], q = u[c], g_j).
  step 1  p, q   step 2  |q - p|   step 3  product   step 4  y, counted from DISTANCE steps after u[c]
Latency: DISTANCE + <CELL_STEPS> steps.",
    ),
    (
        "lerp",
        "y = p + round(g (q - p) / 2^<COEFFICIENT_BITS>) on sign and magnitude, rounding half away from p; \
y lies between p and q.
  step 1  distance = |q - p|   step 2  product = distance * g   step 3  y
One 18 x 18 multiplier, registered at its inputs and its output. `g` belongs to step 2.
Latency: <LERP_STEPS> steps.",
    ),
    (
        "column_border",
        "The operands of a column cell: q = x, p = the neighbour, or the border sample where the neighbour lies outside
the frame.
Latency: <BORDER_STEPS> step.",
    ),
    (
        "coefficient_register",
        "The coefficient of a stage, loaded when the marker of a frame passes.
Latency: 1 step.",
    ),
    (
        "cursor",
        "Column x and row y of the current sample, counted from the marker one step before a frame's first sample:
0 <= x < W and 0 <= y < H.
Latency: <CURSOR_STEPS> step from `start` to position (0, 0); the border flags are combinational.",
    ),
    (
        "address_counter",
        "The address of all line memories, address[n] = n mod W, counted in steps, and the addresses at which they are
written: the address when the word was read.
Latency: none; the counter is a register. A new `width` counts after two clocks without a step.",
    ),
    (
        "tail_counter",
        "Counts the lines n after the last row of a frame. A row that is used k lines late beside one K lines late is
outside the frame for k < n <= K: three rows for each look-ahead of a smoother, then the arriving row of each stage.
Latency: none; the counters are registers.",
    ),
    (
        "held_row",
        "The last row of a frame, one line of pixels. A lerp of equal samples is that sample, so row H - 1 is the same
after every column look-ahead stage.
Latency: one line or more.",
    ),
    (
        "pixel_state",
        "A camera sample u<PIXEL_BITS>.0 as a state u<PIXEL_BITS>.<FRACTION_BITS>: y = <SCALE> x.
Latency: none.",
    ),
    ("signed_response", "A response with its sign in bit <DOG_BITS>: y = {positive, magnitude}.\nLatency: none."),
    (
        "neighbours",
        "Left, right, upper and lower neighbour, <DOG_BITS> bits each from the lowest, without signs.
Latency: none.",
    ),
    (
        "ring_rows",
        "The newest row of the <WIDE_RINGS> in the lowest bits, the older rows above: y = {older, newest}.
Latency: none.",
    ),
    (
        "difference",
        "DOG = min((|narrow - wide| + <HALF>) >> <DOG_SHIFT>, 2^<DOG_BITS> - 1), \
and the sign of narrow - wide before rounding.
  step 1  distance = |narrow - wide|   step 2  rounded, saturated at 2^<DOG_BITS> - 1
Latency: <DIFFERENCE_STEPS> steps.",
    ),
    (
        "scale_pair",
        "One scale pair: DOG, the maxima of its 7x7 window split by raster order, and MaxDOG of 5x5.
  step <DIFFERENCE_STEPS>  response                          step <PAIR_COLUMNS>  maxima of a column
  step <PAIR_RING>  ring (2 lines, 2 columns ago)     step <PAIR_WINDOW>  \
strict, loose and p of the centre (3 lines, 3 columns ago)
The centre and its neighbours follow one step later.
Latency: <DIFFERENCE_STEPS> steps to the response, 3 lines and <PAIR_DECIDED> steps from a pixel's states to the \
operands of its decision.",
    ),
    (
        "column_maximum",
        "Maxima over the rows of one column, v0 the newest: later = max(v0 .. v2), middle = v3, earlier = max(v4 ..
v6), five = max(v0 .. v4).
  step 1  maxima of two   step 2  maxima of three   step 3  outputs
Latency: <COLUMN_MAXIMUM_STEPS> steps.",
    ),
    ("maximum", "y = max(a, b).\nLatency: <MAXIMUM_STEPS> step."),
    (
        "eligible",
        "18 <= x < W - 18 and 18 <= y < H - 18: the ring of such a centre lies inside the frame.
Latency: none for `eligible`, 1 step for `position`.",
    ),
    (
        "decision",
        "A maximum: p > strict (samples earlier in raster order), p >= loose (later samples), and eligible. A feature is
a maximum of at least the threshold.
Latency: 1 step.",
    ),
    (
        "threshold",
        "The threshold T of a frame: manual, at least 1; or by the maxima of the frame before, its T, its n features and
the target N. F = <FLOOR>; bins of maxima of at least F, eight an octave, count to 65535.
  8 |n - N| <= N        T
  else                  max(W, D)
  W   where the sum of the bins, from the highest down, reaches N: 0 to 3 quarters of that bin above its edge, as
      the surplus is below 1/4, 1/2, 3/4 of its count or not; F where it never does
  D   T - (T >> 6) where eight times the sum of all bins is below N, else T >> 3
`enters` starts the sum, one bin a step, and clears the bins. `start` sets T. The first automatic frame uses the
manual threshold.
Latency: 1 step from `start`; at least 86 steps from `enters` to `start`, without a maximum.",
    ),
    (
        "record_limit",
        "The ceiling on the records of a frame: a feature of pair k is passed on if its response reaches gate_k and
the allowance `left` lasts; others are withheld and counted.
L is the register record_limit, a band has ceil((H - 36) / 64) rows from row 18 on.
  row 17 ends   left = L - 63 (L >> 6), gate_k = T_k      a feature is passed on   left - 1
  a band ends   left + (L >> 6), gate_k - (gate_k >> 2) - 1, at least T_k
  none left     gate_k + (gate_k >> 2) + 1, at most 2^<DOG_BITS> - 1, where a feature reaches its gate
p_k comes a step before hit_k and is compared then, with gate_k and with the higher one: a feature may raise the
gates of the next step.
Latency: 1 step from `p` to `keep`, none from `hit`; 1 step to `withheld`.",
    ),
    ("candidate_word", "A candidate as one memory word: neighbours, centres, hits, position.\nLatency: none."),
    (
        "candidate_queue",
        "Candidates wait until their ring is complete, 15 lines and some steps, and are matched by their position.
The memory has <CANDIDATE_QUEUE> entries and there are two output registers. Candidates are dropped and \
counted while the memory is
full.
Latency: <QUEUE_STEPS> step from the position of the ring to `found` and `candidate`.",
    ),
    (
        "ring_taps",
        "The 32 points of a ring in parallel: o_i = round(R (cos, sin)(2 pi i / 32)), row by row from a line delay,
then delayed by the column of each point; the points of one row share a delay chain.
Its memories are read as in a delay: old words.
Latency: <RING_REACH> - R steps for the rightmost point, <RING_REACH> + R for the leftmost.",
    ),
    ("ring_comparator", "maxlbp[i] = centre >= MaxDOG(o_i), sign[i] = sign(o_i), i = 0 .. 31.\nLatency: 1 step."),
    (
        "record_writer",
        "Feature records of <RECORD_BITS> bits<PAIR_ORDER>, and the trailer that ends a frame: frame number, errors,
count, dropped, withheld, thresholds.
  step 1  candidate waits   step 2  ring bits arrive   step 3  record of pair 0<RECORD_STEPS>
Latency: <WRITER_STEPS> steps from `found` to `write`.",
    ),
    (
        "record_fifo",
        "FIFO of <RECORD_FIFO> records. `room`: more than 16 entries are free, features may be written. \
`stall`: 3 or fewer are
free, the datapath stalls.
Without room features are dropped and counted; trailers never are.
Latency: <FIFO_CLOCKS> clocks from `write` to `valid` when empty.",
    ),
    (
        "sequencer",
        "From Avalon-ST beats to steps: every frame that enters the datapath is complete, a short one is padded with
its last pixel.
  IDLE   waits for a start of packet and drops other beats; steps without pixels drain the pipeline, 96 lines at most
  FRAME  one step per beat, until the last pixel
  PAD    one step per clock, until the last pixel
A frame of the same size begins at once, one of another size when the pipeline has drained. A skid buffer of two
beats makes `ready` registered.
Latency: <SEQUENCER_CLOCKS> clocks from a beat to its step.",
    ),
    (
        "csr",
        "The registers of registers/REGISTERS.md behind an Avalon-MM slave without wait states. Status bits are set by
hardware and cleared by writing 1; if both happen in one clock the bit stays set. A software reset clears the
pipeline for one clock and leaves the registers.
`committed`: the registers are a complete set for the next frame that begins; a write to one of them withdraws it.
Latency: 1 clock from `read` to `readdata`.",
    ),
    (
        "bank",
        "The register values of a frame, 16 bits each from the lowest: <COEFFICIENTS> coefficients,
<THRESHOLDS>, target, mode, record limit.
Latency: 1 clock from `load`.",
    ),
];
