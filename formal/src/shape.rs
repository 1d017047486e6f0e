//! The numbers of a design that claims depend on.

/// Values of the default design after a reset, by the register map: size, thresholds, target, limit, coefficients.
const KT27_RESETS: [(u32, u32); 23] = [
    (5, 0x3000400),
    (6, 0x8000800),
    (7, 512),
    (15, 2046),
    (16, 24536),
    (17, 40315),
    (18, 47101),
    (19, 56830),
    (20, 64033),
    (21, 65500),
    (22, 17102),
    (23, 37685),
    (24, 42386),
    (25, 50478),
    (26, 60180),
    (27, 65021),
    (28, 11450),
    (29, 35905),
    (30, 38984),
    (31, 44768),
    (32, 53931),
    (33, 62636),
    (34, 65396),
];

/// Word lengths, sizes and names of a design.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Columns of the largest frame.
    pub width: u32,
    /// Bits of a pixel.
    pub pixel_bits: u32,
    /// Bits of a filter state.
    pub state_bits: u32,
    /// Bits of a coefficient.
    pub coefficient_bits: u32,
    /// Bits by which a difference of states is shifted to a response.
    pub dog_shift: u32,
    /// Bits of a response, without its sign.
    pub dog_bits: u32,
    /// Number of filter coefficients.
    pub coefficients: u32,
    /// Names of the smoothers, the narrowest first.
    pub smoothers: Vec<String>,
    /// Look-ahead of each smoother, as the exponent of its reach.
    pub look_ahead: Vec<u32>,
    /// Radius of the ring of each scale pair, px.
    pub ring_radii: Vec<u32>,
    /// Candidates that the queue's memory holds.
    pub candidate_queue: u32,
    /// Records that the FIFO's memory holds.
    pub record_fifo: u32,
    /// Registers whose value after a reset is not 0: address in words, and value.
    pub resets: Vec<(u32, u32)>,
}

impl Shape {
    /// Returns the shape of the default design.
    pub fn kt27() -> Self {
        Self {
            width: 1024,
            pixel_bits: 16,
            coefficient_bits: 16,
            dog_shift: 1,
            state_bits: 18,
            dog_bits: 15,
            coefficients: 19,
            smoothers: ["narrow", "middle", "wide"].map(str::to_owned).to_vec(),
            look_ahead: vec![5, 5, 6],
            ring_radii: vec![12, 16],
            candidate_queue: 512,
            record_fifo: 512,
            resets: KT27_RESETS.to_vec(),
        }
    }

    /// Returns the number of scale pairs.
    pub fn pairs(&self) -> usize {
        self.ring_radii.len()
    }

    /// Returns `true` if the ring of a pair reaches the newest row.
    pub(crate) fn is_full_ring(&self, pair: usize) -> bool {
        self.ring_radii[pair] == 16
    }

    /// Bits of a column.
    fn column_bits(&self) -> u32 {
        bits(self.width - 1)
    }

    /// Returns a wrapper for this design: macros for its numbers, then the text with its blocks [`unrolled`], where a line
    /// that begins with `each pair` is repeated for each scale pair `{k}`, `{next}` the next, and `{pairs}` is their
    /// number.
    pub(crate) fn wrapper(&self, text: &str) -> String {
        let resets: Vec<String> =
            self.resets.iter().map(|(address, value)| format!("6'd{address}: after_reset = 32'd{value};")).collect();
        let lines = unrolled(text).into_iter().flat_map(|line| self.pairs_of(&line)).map(|line| {
            line.replace("{pairs}", &self.pairs().to_string()).replace("{resets}", &resets.join("\n      ")) + "\n"
        });
        self.numbers().iter().map(|(name, value)| format!("`define {name} {value}\n")).chain(lines).collect()
    }

    /// Returns a text with the numbers in place of their macros.
    pub(crate) fn filled(&self, text: &str) -> String {
        let mut numbers = self.numbers();
        // A name may begin another one.
        numbers.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
        numbers
            .iter()
            .fold(text.to_owned(), |text, (name, value)| text.replace(&format!("`{name}"), &value.to_string()))
    }

    /// Returns a line, or the line of each scale pair if it begins with `each pair`.
    pub(crate) fn pairs_of(&self, line: &str) -> Vec<String> {
        match line.trim_start().strip_prefix("each pair ") {
            Some(text) => (0..self.pairs()).map(|k| self.of_pair(text, k)).collect(),
            None => vec![line.to_owned()],
        }
    }

    /// Returns a text with the number of a scale pair in it.
    pub(crate) fn of_pair(&self, text: &str, k: usize) -> String {
        text.replace("{k}", &k.to_string()).replace("{next}", &(k + 1).to_string())
    }

    /// Returns the numbers as parameters of a wrapper.
    pub(crate) fn parameters(&self) -> String {
        let numbers: Vec<String> = self.numbers().iter().map(|(name, value)| format!("{name} = {value}")).collect();
        format!("localparam {};", numbers.join(", "))
    }

    /// Returns the numbers by their names in wrappers.
    fn numbers(&self) -> [(&'static str, u32); 21] {
        let (column, pairs) = (self.column_bits(), self.ring_radii.len() as u32);
        let signed = self.dog_bits + 1;
        let longest = self.look_ahead.iter().copied().max().unwrap_or(0);
        let look_aheads = self.look_ahead.iter().fold(0u32, |bits, m| bits | 1 << m);
        [
            ("LONGEST", longest),
            // A bit for each look-ahead that a smoother has.
            ("LOOK_AHEADS", look_aheads),
            // Three rows for each look-ahead, then one for each stage of the longest but its first two.
            ("OUTSIDES", 3 * look_aheads.count_ones() + longest.saturating_sub(2)),
            ("COLUMNS", self.width),
            ("P", self.pixel_bits),
            ("S", self.state_bits),
            ("C", self.coefficient_bits),
            ("SHIFT", self.dog_shift),
            ("D", self.dog_bits),
            ("R", signed),
            ("X", column),
            ("W", column + 1),
            ("G", self.coefficients),
            ("N", pairs),
            ("B", 16 * (self.coefficients + pairs + 3)),
            ("Q", column + 11 + pairs * (1 + signed + 4 * self.dog_bits)),
            ("QUEUE", self.candidate_queue),
            ("QUEUE_BITS", bits(self.candidate_queue - 1)),
            ("FIFO", self.record_fifo),
            ("FIFO_BITS", bits(self.record_fifo - 1)),
            ("RECORD", 128 + 64 * pairs),
        ]
    }
}

/// Returns the lines of a text. Those from `for {a} {b}: A B, C D` to `end` are repeated for each row of values, which
/// replace the names.
pub(crate) fn unrolled(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut rest = text.lines();
    while let Some(line) = rest.next() {
        let Some((names, rows)) = line.strip_prefix("for ").and_then(|head| head.split_once(':')) else {
            lines.push(line.to_owned());
            continue;
        };
        let block: Vec<&str> = rest.by_ref().take_while(|line| *line != "end").collect();
        for row in rows.split(',') {
            let values = || names.split_whitespace().zip(row.split_whitespace());
            let filled =
                |line: &&str| values().fold((*line).to_owned(), |line, (name, value)| line.replace(name, value));
            lines.extend(block.iter().map(filled));
        }
    }
    lines
}

/// Returns the number of bits of a number.
fn bits(number: u32) -> u32 {
    u32::BITS - number.leading_zeros()
}
