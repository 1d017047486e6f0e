//! The numbers of a design that claims depend on.

/// Values of the default design after a reset, by the register map: identification, version, size, thresholds, target,
/// commit, limit, coefficients.
const KT27_RESETS: [(u32, u32); 26] = [
    (0, 0x484c_434b),
    (1, 0x2_0001),
    (5, 0x3000400),
    (6, 0x8000800),
    (7, 512),
    (12, 1),
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

/// Modules with parameters of the default design, with the numbers of their instances.
const KT27_VARIANTS: &[(&str, &[u32])] = &[
    ("delay", &[15, 1]),
    ("delay", &[15, 5]),
    ("delay", &[16, 1]),
    ("delay", &[16, 4]),
    ("delay", &[16, 7]),
    ("delay", &[16, 10]),
    ("delay", &[16, 11]),
    ("delay", &[18, 1]),
    ("delay", &[18, 2]),
    ("delay", &[18, 4]),
    ("delay", &[18, 8]),
    ("delay", &[18, 16]),
    ("delay", &[18, 20]),
    ("delay", &[18, 32]),
    ("delay", &[64, 4]),
    ("flag_delay", &[1]),
    ("flag_delay", &[2]),
    ("flag_delay", &[3]),
    ("flag_delay", &[4]),
    ("flag_delay", &[7]),
    ("flag_delay", &[8]),
    ("flag_delay", &[11]),
    ("flag_delay", &[15]),
    ("flag_delay", &[19]),
    ("frame_delay", &[1, 4, 11]),
    ("frame_delay", &[2, 4, 11]),
    ("frame_delay", &[3, 10, 11]),
    ("frame_delay", &[4, 4, 11]),
    ("frame_delay", &[8, 4, 11]),
    ("frame_delay", &[8, 7, 11]),
    ("frame_delay", &[15, 13, 11]),
    ("frame_delay", &[48, 1, 11]),
    ("line_delay", &[16, 6, 0x3f, 6, 10, 2]),
    ("line_delay", &[16, 28, 0xed2_a5b8, 15, 10, 1]),
    ("line_delay", &[16, 32, 0xd524_9255, 14, 10, 1]),
    ("line_delay", &[18, 1, 1, 1, 10, 1]),
    ("pulse_delay", &[5]),
    ("pulse_delay", &[6]),
    ("pulse_delay", &[8]),
    ("pulse_delay", &[12]),
    ("pulse_delay", &[20]),
    ("pulse_delay", &[24]),
    ("pulse_delay", &[36]),
    ("row_look_ahead", &[1]),
    ("row_look_ahead", &[2]),
    ("row_look_ahead", &[4]),
    ("row_look_ahead", &[8]),
    ("row_look_ahead", &[16]),
    ("row_look_ahead", &[32]),
    ("row_look_ahead_border", &[18, 1]),
    ("row_look_ahead_border", &[18, 2]),
    ("row_look_ahead_border", &[18, 4]),
    ("row_look_ahead_border", &[18, 8]),
    ("row_look_ahead_border", &[18, 16]),
    ("row_look_ahead_border", &[18, 32]),
    ("row_look_back", &[1]),
    ("row_look_back", &[2]),
    ("row_look_back", &[4]),
    ("row_look_back", &[8]),
    ("row_look_back", &[16]),
    ("row_look_back", &[32]),
    ("row_look_back_border", &[18, 1]),
    ("row_look_back_border", &[18, 2]),
    ("row_look_back_border", &[18, 4]),
    ("row_look_back_border", &[18, 8]),
    ("row_look_back_border", &[18, 16]),
    ("row_look_back_border", &[18, 32]),
    ("window_maximum", &[15, 3]),
    ("window_maximum", &[15, 5]),
    ("window_maximum", &[15, 7]),
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
    /// Modules with parameters, and the numbers that an instance of them has, in the order of the module's header.
    pub variants: Vec<(String, Vec<u32>)>,
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
            variants: KT27_VARIANTS.iter().map(|(module, numbers)| ((*module).to_owned(), numbers.to_vec())).collect(),
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

    /// Returns a wrapper for this design: macros for its numbers, then the text with its blocks unrolled. A line that
    /// begins with `each pair` is repeated for each of the `{pairs}` scale pairs: `{k}`, and `{next}` the one after it.
    pub(crate) fn wrapper(&self, text: &str) -> String {
        let resets: Vec<String> =
            self.resets.iter().map(|(address, value)| format!("6'd{address}: after_reset = 32'd{value};")).collect();
        let lines = self.unrolled(text).into_iter().flat_map(|line| self.pairs_of(&line)).map(|line| {
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
            // Eight words for one or two scale pairs.
            ("RECORD", 128 + 64 * pairs.max(2)),
        ]
    }

    /// Returns the lines of a text. Those from `for {a} {b}: A B, C D` to `end` are repeated for each row of values,
    /// which replace the names. The rows of `each MODULE` are the numbers of the module's instances, those of
    /// `each MODULE FROM..TO` where the last of them is in the range.
    pub(crate) fn unrolled(&self, text: &str) -> Vec<String> {
        let mut lines = Vec::new();
        let mut rest = text.lines();
        while let Some(line) = rest.next() {
            let Some((names, rows)) = line.strip_prefix("for ").and_then(|head| head.split_once(':')) else {
                lines.push(line.to_owned());
                continue;
            };
            let block: Vec<&str> = rest.by_ref().take_while(|line| *line != "end").collect();
            let rows: Vec<String> = match rows.trim().strip_prefix("each ") {
                Some(which) => self.rows_of(which),
                None => rows.split(',').map(str::to_owned).collect(),
            };
            for row in &rows {
                let values = || names.split_whitespace().zip(row.split_whitespace());
                let filled =
                    |line: &&str| values().fold((*line).to_owned(), |line, (name, value)| line.replace(name, value));
                lines.extend(block.iter().map(filled));
            }
        }
        lines
    }

    /// Returns the numbers of the instances of a module, `MODULE` or `MODULE FROM..TO`.
    fn rows_of(&self, which: &str) -> Vec<String> {
        let (module, range) = which.split_once(' ').unwrap_or((which, ".."));
        let (from, to) = range.split_once("..").unwrap_or_default();
        let range = from.parse().unwrap_or(0)..=to.parse().unwrap_or(u32::MAX);
        let of_module = self.variants.iter().filter(|(known, _)| known == module).map(|(_, numbers)| numbers);
        let in_range = of_module.filter(|numbers| numbers.last().is_some_and(|last| range.contains(last)));
        in_range.map(|numbers| numbers.iter().map(|number| format!("{number} ")).collect()).collect()
    }
}

/// Returns the number of bits of a number.
fn bits(number: u32) -> u32 {
    u32::BITS - number.leading_zeros()
}
