//! Names that the build script gives in the wiring and the register map repeats: one file, compiled into both.

/// The names of so many smoothers, the narrowest first.
pub fn smoother_names(smoothers: usize) -> &'static [&'static str] {
    match smoothers {
        2 => &["narrow", "wide"],
        3 => &["narrow", "middle", "wide"],
        _ => &["narrow", "middle", "wide", "widest"],
    }
}
