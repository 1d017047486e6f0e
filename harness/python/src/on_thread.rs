//! Values that stay on the thread they were made on, checked at each use.
//!
//! What handles and triggers hold (reference counts, pointers into a model) belongs to one thread. pyo3's `unsendable`
//! checks that too, but it panics on another thread, and it asks for the thread's identity by a counted reference: a
//! tenth of the time of a whole simulated cycle.

use std::mem::ManuallyDrop;

use pyo3::prelude::*;

use crate::errors::SimulationError;

/// Where the system keeps what belongs to the thread: different for threads that live at the same time. A variable of
/// the thread has an address like that too, but in a shared library it is asked for by a call.
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

/// The address of a thread-local: different for threads that live at the same time.
#[cfg(not(all(target_arch = "x86_64", target_os = "linux")))]
#[inline(always)]
fn here() -> usize {
    thread_local! {
        static HERE: u8 = const { 0 };
    }
    HERE.with(|here| std::ptr::from_ref(here) as usize)
}

const REFUSED: &str = "an object of a simulation was used on another thread than the simulation's";

#[cold]
fn refused() -> PyErr {
    SimulationError::new_err(REFUSED)
}

/// A value of one thread, inside an object that Python may hand to any.
pub struct OnThread<T> {
    owner: usize,
    value: ManuallyDrop<T>,
}

// SAFETY: the value is reached only through `get`, which refuses other threads, and is dropped only on its own. A
// thread that got the address of an ended one finds values nobody else uses any more.
unsafe impl<T> Send for OnThread<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for OnThread<T> {}

impl<T> OnThread<T> {
    pub fn new(value: T) -> OnThread<T> {
        OnThread { owner: here(), value: ManuallyDrop::new(value) }
    }

    /// The value.
    ///
    /// # Errors
    /// On another thread than its own.
    #[inline(always)]
    pub fn get(&self) -> PyResult<&T> {
        if self.owner == here() { Ok(&self.value) } else { Err(refused()) }
    }

    /// The value, for what runs below a simulation.
    ///
    /// # Panics
    /// On another thread than its own, which no simulation leaves.
    #[inline(always)]
    pub fn own(&self) -> &T {
        assert!(self.owner == here(), "{REFUSED}");
        &self.value
    }
}

impl<T> Drop for OnThread<T> {
    fn drop(&mut self) {
        // On another thread it is leaked: to drop it there would be a race.
        if self.owner == here() {
            // SAFETY: dropped once, here, and not used again.
            unsafe { ManuallyDrop::drop(&mut self.value) };
        }
    }
}
