//! What stands above each emitted module: purpose, equation, latency.

/// The comment above a module.
pub fn header(module: &str) -> String {
    let text = HEADERS.iter().filter(|(name, _)| module.starts_with(name)).max_by_key(|(name, _)| name.len());
    text.map(|(_, text)| text.lines().map(|line| format!("// {line}").trim_end().to_owned() + "\n").collect())
        .unwrap_or_default()
}

/// By the longest beginning of the name that fits.
const HEADERS: &[(&str, &str)] = &[
    (
        "hoverlock_top",
        "The feature extractor: Avalon-ST video in, Avalon-ST feature records out, Avalon-MM registers, an interrupt.\nOne clock, one pixel a clock, latency 81 lines and some 175 pixels from a pixel to its record.",
    ),
    (
        "hoverlock_core",
        "The extractor between its two streams: sequencer, datapath, FIFO.\n`advance` is the clock enable of the whole datapath: one step. Every latency below it is in steps.",
    ),
    ("extractor", "From pixels to records: smoothers, two scale pairs, window, ring, records."),
    (
        "smoothers",
        "The three smoothers on the same pixels, aligned: the two short ones wait 32 lines and 44 steps for the long one.\n63 lines and 139 steps from `pixel` to `narrow`, `middle` and `wide`. `start` and `start_out` are one step before the first sample.",
    ),
    (
        "smoother_",
        "One two-sided first-order smoother: recursion down the columns, m look-ahead stages up them, then m stages towards the past and\nm towards the future along the rows; every cell a lerp.\n2^m - 1 lines and 3 + 12 m + 2^m steps. Markers are one step before the sample they belong to.",
    ),
    (
        "column_stage",
        "Column look-ahead stage j: y[r] = lerp(p = u[min(r + 2^j, H - 1)], q = u[r], g_j).\n`x` is u[r + 2^j]; y[r] leaves 4 steps later, so 2^j lines and 4 steps after its own sample came.\n  step 1  p, q   step 2  |q - p|   step 3  product   step 4  y",
    ),
    (
        "look_back_stage",
        "Row stage j towards the past: y[c] = lerp(p = u[max(c - 2^j, 0)], q = u[c], g_j). 4 steps.\n  step 1  p, q   step 2  |q - p|   step 3  product   step 4  y",
    ),
    (
        "look_ahead_stage",
        "Row stage j towards the future: y[c] = lerp(p = u[min(c + 2^j, W - 1)], q = u[c], g_j). 2^j + 4 steps.\n  step 1  p, q   step 2  |q - p|   step 3  product   step 4  y",
    ),
    (
        "lerp",
        "y = p + round(g (q - p) / 2^16) on sign and magnitude, rounding half away from p; y lies between p and q. 3 steps.\n  step 1  distance = |q - p|   step 2  product = distance * g   step 3  y\nOne 18 x 18 multiplier, registered at its inputs and its output. `g` is taken with step 2.",
    ),
    (
        "column_border",
        "The operands of a column cell: the border's sample in place of a neighbour outside the frame. 1 step.",
    ),
    (
        "look_back_border",
        "The operands of a row cell towards the past: the row's first sample in place of what lies before it. 1 step.",
    ),
    (
        "look_ahead_border",
        "The operands of a row cell towards the future: the row's last sample in place of what lies behind it. 1 step.",
    ),
    ("coefficient_register", "The coefficient of a stage, taken over when the marker of a frame passes."),
    (
        "line_delay",
        "y[n] = x[n - k W]: all rows of a column are one memory word, read, shifted by one row and written back.\nThe address counts steps modulo W, so a frame may begin at any of them. Only what a frame wrote itself is ever used.",
    ),
    ("delay_", "y[n] = x[n - N], N the number after the x: registers up to 3 steps, a small memory beyond."),
    ("flag_delay", "y[n] = x[n - N], N the number in the name; reset clears what is under way."),
    ("pulse_delay", "A pulse N steps later, N the number in the name, by counting: at least N steps between pulses."),
    (
        "frame_delay",
        "A marker L W + N steps later, LxN the numbers in the name, by counting: at least as long between markers.",
    ),
    ("cursor", "Column and row of the sample that is here, from the marker one step before a frame's first."),
    ("address_counter", "The address of all line memories: steps modulo W, and the same some steps before."),
    (
        "tail_counter",
        "Which column stage needs the held last row: stage j for 2^j <= n < 2^(j+1) lines after that row, 4 j steps later each.",
    ),
    (
        "held_row",
        "The last row of a frame as it left the recursion, one read port for all stages: no two need it together.",
    ),
    ("pixel_state", "A camera word u16.0 as a state u16.2."),
    ("signed_response", "A response with its sign above it."),
    ("neighbours", "Left, right, upper and lower neighbour, 15 bits each from the lowest."),
    ("ring_rows", "The newest row of the wide ring before its older ones."),
    (
        "difference",
        "DOG = min((|narrow - wide| + 1) >> 1, 2^15 - 1) and the sign of narrow - wide before rounding. 2 steps.",
    ),
    (
        "layer",
        "One scale pair: DOG, the maxima of its 7x7 window apart by raster order, and MaxDOG of 5x5.\n  step 2   response        step 5   maxima of a column      step 9   strict, loose and p of the centre (3 lines, 3 columns back)\n  step 8   ring (2 lines, 2 columns back)                  step 10  centre and its neighbours",
    ),
    (
        "column_maximum",
        "Maxima over the rows of one column: later than the middle, earlier, and the five newest. 3 steps.",
    ),
    ("window_maximum", "y[n] = max(x[n] .. x[n - N + 1]), N the number in the name, by doubling. ceil(log2 N) steps."),
    ("maximum", "y = max(a, b). 1 step."),
    ("eligible", "18 <= x < W - 18 and 18 <= y < H - 18: no ring of such a centre leaves the frame."),
    (
        "decision",
        "A feature: greater than what comes earlier in the window, at least what comes later, at least the threshold. 1 step.",
    ),
    (
        "threshold",
        "The threshold of a frame: manual, or up or down by an eighth and one from the last frame's count.\nTaken over at the marker of the window stage, when the last frame's count is complete.",
    ),
    ("candidate_word", "A candidate as one word."),
    (
        "candidate_queue",
        "Candidates wait until their ring is complete, 15 lines and some steps, and are found again by their place.\n512 can wait; what finds no place is dropped and counted.",
    ),
    (
        "ring_taps",
        "The 32 points of a ring side by side: row by row from a line delay, then as many steps as each point's column asks for.",
    ),
    ("ring_comparator", "maxlbp[i] = centre >= MaxDOG(o_i), sign[i] = sign(o_i). 1 step."),
    (
        "record_writer",
        "Feature records of 256 bits, scale pair 0 before 1, and the trailer that ends a frame: frame number, errors, count, dropped, thresholds.",
    ),
    (
        "record_fifo",
        "512 records before the sink. Features are dropped and counted where fewer than 16 places are left; trailers never are.",
    ),
    (
        "sequencer",
        "From Avalon-ST beats to steps: every frame that enters the datapath is whole, a short one is padded with its last pixel.\nBetween frames empty steps drain the pipeline, 96 lines at most; a new size waits for that, the same size does not.",
    ),
    ("csr", "The registers of registers/REGISTERS.md behind an Avalon-MM slave."),
    ("bank", "What a frame takes with it: 19 coefficients, thresholds, target, mode; 16 bits each."),
];
