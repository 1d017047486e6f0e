//! Names of signals, as handles show them.

use hoverlock_harness::model::Direction;

/// Returns the direction as Python has it, such as `input`.
pub fn direction_name(direction: Direction) -> &'static str {
    match direction {
        Direction::Input => "input",
        Direction::Output => "output",
        Direction::Inout => "inout",
        Direction::Internal => "internal",
    }
}

/// Returns a name without the names of the instances that contain it.
pub fn own_name(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

/// Returns the path of a name, from the top module.
pub fn path(top: &str, name: &str) -> String {
    format!("{top}.{name}")
}
