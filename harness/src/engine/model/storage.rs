//! How Verilator stores values, and the functions that read and write its memory.

/// How Verilator stores a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// Up to 8 bits.
    U8,
    /// Up to 16 bits.
    U16,
    /// Up to 32 bits.
    U32,
    /// Up to 64 bits.
    U64,
    /// More, in that many 32-bit words.
    Wide(u32),
}

impl Storage {
    pub(super) fn of(width: u32) -> Storage {
        match width {
            0..=8 => Storage::U8,
            9..=16 => Storage::U16,
            17..=32 => Storage::U32,
            33..=64 => Storage::U64,
            _ => Storage::Wide(width.div_ceil(32)),
        }
    }

    pub(crate) fn bytes(self) -> usize {
        match self {
            Storage::U8 => 1,
            Storage::U16 => 2,
            Storage::U32 => 4,
            Storage::U64 => 8,
            Storage::Wide(words) => 4 * words as usize,
        }
    }
}

/// Reads a value of at most 64 bits.
///
/// # Safety
/// `data` must point to a live value of that storage, which must not be wide.
#[inline(always)]
pub(crate) unsafe fn load(data: *const u8, storage: Storage) -> u64 {
    // SAFETY: as the caller promises; Verilator aligns its variables.
    unsafe {
        match storage {
            Storage::U8 => u64::from(*data),
            Storage::U16 => u64::from(*data.cast::<u16>()),
            Storage::U32 | Storage::U64 | Storage::Wide(_) => load_large(data, storage),
        }
    }
}

/// Reads the sizes that fewer signals have. They are in a function of their own because a read of all sizes becomes a
/// jump table, which costs more than a call.
#[inline(never)]
unsafe fn load_large(data: *const u8, storage: Storage) -> u64 {
    // SAFETY: as the caller of `load` promises.
    unsafe { if storage == Storage::U64 { *data.cast::<u64>() } else { u64::from(*data.cast::<u32>()) } }
}

/// Writes a value of at most 64 bits; bits above the storage are lost.
///
/// # Safety
/// As [`load`], and nobody may be reading.
#[inline(always)]
pub(crate) unsafe fn store(data: *mut u8, storage: Storage, value: u64) {
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::U8 => *data = value as u8,
            Storage::U16 => *data.cast::<u16>() = value as u16,
            Storage::U32 | Storage::U64 | Storage::Wide(_) => store_large(data, storage, value),
        }
    }
}

/// Writes the sizes that fewer signals have; see [`load_large`].
#[inline(never)]
unsafe fn store_large(data: *mut u8, storage: Storage, value: u64) {
    // SAFETY: as the caller of `store` promises.
    unsafe {
        if storage == Storage::U64 {
            *data.cast::<u64>() = value;
        } else {
            *data.cast::<u32>() = value as u32;
        }
    }
}

/// Reads a value of any width as 32-bit words, lowest first.
///
/// # Safety
/// `data` must point to a live value of that storage.
pub(crate) unsafe fn load_words(data: *const u8, storage: Storage) -> Vec<u32> {
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::Wide(words) => std::slice::from_raw_parts(data.cast::<u32>(), words as usize).to_vec(),
            Storage::U64 => {
                let value = load(data, storage);
                vec![value as u32, (value >> 32) as u32]
            }
            _ => vec![load(data, storage) as u32],
        }
    }
}

/// Reads the lowest `N` 32-bit words of a value of any width; words that it does not have are 0.
///
/// # Safety
/// As [`load_words`].
#[inline]
pub(crate) unsafe fn load_array<const N: usize>(data: *const u8, storage: Storage) -> [u32; N] {
    // SAFETY: as the caller promises; a wide value has `words` words.
    unsafe {
        if let Storage::Wide(words) = storage {
            let words = std::slice::from_raw_parts(data.cast::<u32>(), words as usize);
            return std::array::from_fn(|at| words.get(at).copied().unwrap_or(0));
        }
        let value = load(data, storage);
        std::array::from_fn(|at| if at < 2 { (value >> (32 * at)) as u32 } else { 0 })
    }
}

/// Returns `true` if a value of any width equals `words`; words that are not given are 0.
///
/// # Safety
/// As [`load_words`].
pub(crate) unsafe fn has_words(data: *const u8, storage: Storage, words: &[u32]) -> bool {
    let word = |at: usize| words.get(at).copied().unwrap_or(0);
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::Wide(count) => (0..count as usize).all(|at| *data.cast::<u32>().add(at) == word(at)),
            _ => load(data, storage) == u64::from(word(0)) | u64::from(word(1)) << 32,
        }
    }
}

/// Writes a value of any width; words that are not given are 0.
///
/// # Safety
/// As [`load_words`], and nobody may be reading. The words must fit the signal's width.
pub(crate) unsafe fn store_words(data: *mut u8, storage: Storage, words: &[u32]) {
    let word = |at: usize| words.get(at).copied().unwrap_or(0);
    // SAFETY: as the caller promises.
    unsafe {
        match storage {
            Storage::Wide(count) => {
                (0..count as usize).for_each(|at| *data.cast::<u32>().add(at) = word(at));
            }
            _ => store(data, storage, u64::from(word(0)) | u64::from(word(1)) << 32),
        }
    }
}
