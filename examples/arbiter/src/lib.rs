//! The model of a round-robin arbiter.

/// An arbiter of `requests` requests, as `verilog/arbiter.v` has it.
pub struct Arbiter {
    requests: u32,
    first: u32,
}

impl Arbiter {
    /// Returns an arbiter after its reset: request 0 has the highest priority.
    pub fn new(requests: u32) -> Self {
        Self { requests, first: 0 }
    }

    /// Returns the grant for the requests of one clock, one bit or none.
    pub fn grant(&mut self, request: u64) -> u64 {
        let order = (0..self.requests).map(|step| (self.first + step) % self.requests);
        let Some(granted) = order.into_iter().find(|index| request >> index & 1 == 1) else { return 0 };
        self.first = (granted + 1) % self.requests;
        1 << granted
    }
}
