//! Caches of a Cortex-A9 in an Arria V SoC: 32 KiB of four ways each for code and data, then 512 KiB of eight ways for
//! both, lines of 32 bytes; the least recently used line is replaced. Addresses are those of the program.

const LINE_BITS: u32 = 5;

/// A cache of `WAYS` ways.
pub struct Cache<const WAYS: usize> {
    /// For each set, the lines in the order of their use, the latest first; a line number is stored plus one.
    sets: Vec<[u64; WAYS]>,
}

impl<const WAYS: usize> Cache<WAYS> {
    /// Creates an empty cache of a size, bytes.
    pub fn new(bytes: usize) -> Self {
        Self { sets: vec![[0; WAYS]; bytes >> LINE_BITS >> WAYS.ilog2()] }
    }

    /// Uses a line. Returns `true` if the cache had it.
    pub fn has(&mut self, line: u64) -> bool {
        let count = self.sets.len() as u64;
        let set = &mut self.sets[(line % count) as usize];
        let at = set.iter().position(|other| *other == line + 1);
        set[..=at.unwrap_or(WAYS - 1)].rotate_right(1);
        set[0] = line + 1;
        at.is_some()
    }
}

/// All caches, with their misses.
pub struct Caches {
    code: Cache<4>,
    data: Cache<4>,
    second: Cache<8>,
    /// Lines that the first level did not have.
    pub first_misses: u64,
    /// Lines that the second level did not have either.
    pub second_misses: u64,
}

impl Caches {
    /// Creates empty caches.
    pub fn new() -> Self {
        Self {
            code: Cache::new(32 << 10),
            data: Cache::new(32 << 10),
            second: Cache::new(512 << 10),
            first_misses: 0,
            second_misses: 0,
        }
    }

    /// Uses the bytes from `address` on, as code or as data.
    pub fn touch(&mut self, address: u64, bytes: u64, is_code: bool) {
        for line in address >> LINE_BITS..=(address + bytes.max(1) - 1) >> LINE_BITS {
            let first = if is_code { &mut self.code } else { &mut self.data };
            if !first.has(line) {
                self.first_misses += 1;
                self.second_misses += u64::from(!self.second.has(line));
            }
        }
    }
}
