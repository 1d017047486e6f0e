//! A port of one bit that only protected designs have.
//!
//! [`Flag`] is a [`Signal`] in a protected design and [`Absent`] in another, so the same Rust wires both: an assignment
//! in a loop `for _flag in 0..PARITY` is printed in the one, and in the other there is nothing.

use std::marker::PhantomData;

use rust_hdl::prelude::*;

/// The port, a signal or nothing: see [`Presence`].
pub type Flag<D> = <PresentIf<{ crate::design::PARITY }> as Presence>::Port<D>;

/// Stands for a port that exists if `N` is 1, and does not if it is 0.
pub struct PresentIf<const N: usize>;

/// Chooses the type of the port.
pub trait Presence {
    /// The port.
    type Port<D: Direction>;
}

impl Presence for PresentIf<1> {
    type Port<D: Direction> = Signal<D, Bit>;
}

impl Presence for PresentIf<0> {
    type Port<D: Direction> = Absent<D>;
}

/// No port, with the methods of one: it prints nothing and is always low.
pub struct Absent<D> {
    /// Takes an assignment and has no effect.
    pub next: bool,
    direction: PhantomData<D>,
}

impl<D> Default for Absent<D> {
    fn default() -> Self {
        Self { next: false, direction: PhantomData }
    }
}

impl<D> Absent<D> {
    /// Returns `false`.
    pub fn val(&self) -> bool {
        false
    }
}

impl<D> Logic for Absent<D> {
    fn update(&mut self) {}
}

impl<D> Block for Absent<D> {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {}

    fn has_changed(&self) -> bool {
        false
    }

    fn accept(&self, _: &str, _: &mut dyn Probe) {}
}
