//! What the serial buses share: lines of one bit.

use crate::error::Error;
use crate::sim::Signal;

/// Refuses a signal that is wider than a line.
///
/// # Errors
/// If it has more than one bit.
pub(super) fn check(signal: &Signal) -> Result<(), Error> {
    if signal.width() == 1 {
        return Ok(());
    }
    Err(Error::Bench(format!(
        "'{}' has {} bits and a line of a serial bus has one: put one bit of it on a port of its own",
        signal.info().name,
        signal.width()
    )))
}
