//! The numbers of a design that claims depend on.

/// Word lengths, sizes and names of a design.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Columns of the largest frame.
    pub width: u32,
    /// Bits of a pixel.
    pub pixel_bits: u32,
    /// Bits of a filter state.
    pub state_bits: u32,
    /// Bits of a response, without its sign.
    pub dog_bits: u32,
    /// Number of filter coefficients.
    pub coefficients: u32,
    /// Names of the smoothers, the narrowest first.
    pub smoothers: Vec<String>,
    /// Radius of the ring of each scale pair, px.
    pub ring_radii: Vec<u32>,
    /// Candidates that the queue's memory holds.
    pub candidate_queue: u32,
    /// Records that the FIFO's memory holds.
    pub record_fifo: u32,
}

impl Shape {
    /// Returns the shape of the default design.
    pub fn kt27() -> Self {
        Self {
            width: 1024,
            pixel_bits: 16,
            state_bits: 18,
            dog_bits: 15,
            coefficients: 19,
            smoothers: ["narrow", "middle", "wide"].map(str::to_owned).to_vec(),
            ring_radii: vec![12, 16],
            candidate_queue: 512,
            record_fifo: 512,
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

    /// Returns the number of the 16-bit field of the register bank that has the threshold of a pair: the first two follow
    /// the coefficients, the third follows the record limit.
    pub(crate) fn threshold_field(&self, pair: usize) -> u32 {
        self.coefficients + [0, 1, 5][pair]
    }

    /// Returns the numbers as parameters of a wrapper, in Verilog.
    pub(crate) fn parameters(&self) -> String {
        let fields = self.coefficients + if self.pairs() == 3 { 6 } else { 5 };
        let column_bits = u32::BITS - (self.width - 1).leading_zeros();
        format!(
            "  localparam P = {}, S = {}, D = {}, R = D + 1, X = {column_bits}, W = X + 1, G = {}, N = {}, B = 16 * \
             {fields};\n  localparam Q = X + 11 + N + N * R + N * 4 * D;\n",
            self.pixel_bits,
            self.state_bits,
            self.dog_bits,
            self.coefficients,
            self.pairs(),
        )
    }
}
