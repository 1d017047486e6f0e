//! A test bench for a counter and one for a FIFO.

mod counter;
mod fifo;
