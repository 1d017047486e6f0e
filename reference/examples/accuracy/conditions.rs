//! The thirteen conditions of the benchmark: a flight, and what air and camera do to CUR and REF.

use crate::scene::Course;
use hoverlock_pictures::conditions::Condition;

/// One row of the benchmark.
pub struct Case {
    /// Name in the table.
    pub name: &'static str,
    /// How the flight is drawn.
    pub course: Course,
    /// Air and camera when REF is taken.
    pub reference: Condition,
    /// Air and camera when CUR is taken.
    pub current: Condition,
}

const CLEAR: Condition = Condition { name: "nominal", contrast: 1.0, blur: 0.0, gain_spread: 0.1, full_well: 20_000.0 };
const WIDE: Course =
    Course { field_of_view: 50.0, tilt: 5.0, tilt_between: 5.0, yaw: 3.0, drift: 4.0, climb: 1.0, relief: 0.0 };
const NARROW: Course = Course { field_of_view: 10.0, tilt_between: 0.7, drift: 0.8, ..WIDE };
const NOMINAL: Case = Case { name: "nominal", course: WIDE, reference: CLEAR, current: CLEAR };
const NOISY: Condition = Condition { full_well: 2_000.0, ..CLEAR };

/// Which half of the textures, by name, serves for tuning: every other one in alphabetical order, the first included.
pub fn is_tuning(texture: usize) -> bool {
    texture.is_multiple_of(2)
}

/// The conditions, the nominal one first.
pub const CASES: [Case; 13] = [
    NOMINAL,
    Case { name: "gain", current: Condition { gain_spread: 0.4, ..CLEAR }, ..NOMINAL },
    Case { name: "noise", reference: NOISY, current: NOISY, ..NOMINAL },
    Case { name: "blur", current: Condition { blur: 1.5, ..CLEAR }, ..NOMINAL },
    Case { name: "mist .5", current: Condition { contrast: 0.5, ..CLEAR }, ..NOMINAL },
    Case { name: "mist .25", current: Condition { contrast: 0.25, ..CLEAR }, ..NOMINAL },
    Case {
        name: "combined",
        current: Condition { contrast: 0.3, blur: 1.5, gain_spread: 0.2, full_well: 4_000.0, ..CLEAR },
        ..NOMINAL
    },
    Case { name: "altitude", course: Course { climb: 5.0, ..WIDE }, ..NOMINAL },
    Case { name: "yaw", course: Course { yaw: 15.0, ..WIDE }, ..NOMINAL },
    Case { name: "drift", course: Course { drift: 12.0, ..WIDE }, ..NOMINAL },
    Case { name: "relief", course: Course { relief: 3.0, ..WIDE }, ..NOMINAL },
    Case { name: "narrow", course: NARROW, ..NOMINAL },
    Case { name: "narrow noisy", course: NARROW, reference: NOISY, current: NOISY },
];
