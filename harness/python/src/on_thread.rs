//! Values that stay on the thread on which they were made, checked at each use.
//!
//! The contents of handles and triggers (reference counts, pointers into a model) belong to one thread. pyo3's
//! `unsendable` checks that too, but it panics on another thread, and it gets the thread's identity by a counted
//! reference, which costs a tenth of a simulated cycle.

use std::mem::ManuallyDrop;

use pyo3::prelude::*;

use crate::errors::SimulationError;

/// Returns the address of the thread's control block, which differs between threads that live at the same time. The
/// address of a thread-local variable would do too, but a shared library gets that by a function call.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[inline(always)]
fn here() -> usize {
    let here;
    // SAFETY: reads the word that `fs` points to, which is its own address in every thread (System V ABI, thread-local
    // storage), and nothing else.
    unsafe {
        std::arch::asm!("mov {}, fs:0", out(reg) here, options(pure, readonly, nostack, preserves_flags));
    }
    here
}

/// Returns the address of a thread-local variable, which differs between threads that live at the same time.
#[cfg(not(all(target_arch = "x86_64", target_os = "linux")))]
#[inline(always)]
fn here() -> usize {
    thread_local! {
        static HERE: u8 = const { 0 };
    }
    HERE.with(|here| std::ptr::from_ref(here) as usize)
}

const WRONG_THREAD: &str = "an object of a simulation was used on another thread than the simulation's";

#[cold]
fn wrong_thread() -> PyErr {
    SimulationError::new_err(WRONG_THREAD)
}

/// A value of one thread, inside an object that Python may pass to any thread.
pub struct OnThread<T> {
    owner: usize,
    value: ManuallyDrop<T>,
}

// SAFETY: the value is reached only through `get`, which refuses other threads, and is dropped only on its own thread.
// A thread that got the address of an ended one finds values that nobody else uses any more.
unsafe impl<T> Send for OnThread<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for OnThread<T> {}

impl<T> OnThread<T> {
    /// Binds the value to this thread.
    pub fn new(value: T) -> OnThread<T> {
        OnThread { owner: here(), value: ManuallyDrop::new(value) }
    }

    /// Returns the value.
    ///
    /// # Errors
    /// `SimulationError` on another thread than the value's.
    #[inline(always)]
    pub fn get(&self) -> PyResult<&T> {
        if self.owner == here() { Ok(&self.value) } else { Err(wrong_thread()) }
    }

    /// Returns the value, for code that a simulation calls.
    ///
    /// # Panics
    /// On another thread than the value's; a simulation never leaves its thread.
    #[inline(always)]
    pub fn own(&self) -> &T {
        assert!(self.owner == here(), "{WRONG_THREAD}");
        &self.value
    }
}

impl<T> Drop for OnThread<T> {
    fn drop(&mut self) {
        // On another thread the value is leaked: dropping it there would be a race.
        if self.owner == here() {
            // SAFETY: dropped once, here, and not used again.
            unsafe { ManuallyDrop::drop(&mut self.value) };
        }
    }
}
