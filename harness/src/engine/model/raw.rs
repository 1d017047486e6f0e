//! Signals by address, for loops that must be as fast as C++.

/// A type in which Verilator stores values.
pub trait Word: Copy + sealed::Sealed {
    /// The width of the type.
    const BITS: u32;
    /// Whether it is for signals wider than 64 bits, as 32-bit words, lowest first.
    const WIDE: bool = false;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
    impl Sealed for u64 {}
    impl<const N: usize> Sealed for [u32; N] {}
}

impl Word for u8 {
    const BITS: u32 = 8;
}
impl Word for u16 {
    const BITS: u32 = 16;
}
impl Word for u32 {
    const BITS: u32 = 32;
}
impl Word for u64 {
    const BITS: u32 = 64;
}
impl<const N: usize> Word for [u32; N] {
    const BITS: u32 = 32 * N as u32;
    const WIDE: bool = true;
}

/// A signal by its address, without checks.
#[derive(Debug, Clone, Copy)]
pub struct RawSignal<T: Word> {
    pub(super) data: *mut T,
}

impl<T: Word> RawSignal<T> {
    /// Reads the stored value.
    ///
    /// # Safety
    /// The model must be alive and on this thread.
    #[inline(always)]
    pub unsafe fn get(self) -> T {
        // SAFETY: the pointer was taken from the model with this type's size.
        unsafe { *self.data }
    }

    /// Writes the stored value; bits above the signal's width corrupt the model's arithmetic.
    ///
    /// # Safety
    /// The model must be alive and on this thread, and the value within the signal's width.
    #[inline(always)]
    pub unsafe fn set(self, value: T) {
        // SAFETY: as above.
        unsafe { *self.data = value }
    }
}
