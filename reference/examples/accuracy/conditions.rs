//! The fourteen cases of the benchmark: ranges of a flight, and air and camera of REF and CUR.

use crate::scene::FlightRanges;
use hoverlock_pictures::conditions::Condition;

/// A case of the benchmark, one row of its table.
#[derive(Clone, Copy)]
pub struct Case {
    /// Name in the table.
    pub name: &'static str,
    /// Ranges from which the flight is drawn.
    pub ranges: FlightRanges,
    /// Air and camera of REF.
    pub reference: Condition,
    /// Air and camera of CUR.
    pub current: Condition,
}

const CLEAR: Condition = Condition { name: "nominal", contrast: 1.0, blur: 0.0, gain_spread: 0.1, full_well: 20_000.0 };
const WIDE: FlightRanges =
    FlightRanges { field_of_view: 50.0, tilt: 5.0, tilt_between: 5.0, yaw: 3.0, drift: 4.0, climb: 1.0, relief: 0.0 };
const NARROW: FlightRanges = FlightRanges { field_of_view: 10.0, tilt_between: 0.7, drift: 0.8, ..WIDE };
/// Height and attitude are held, as on a stabilised mount: all pixels move by the same fraction of a pixel, so that the
/// error of an interpolation does not average out.
const HOVER: FlightRanges = FlightRanges { tilt_between: 0.05, yaw: 0.05, climb: 0.0, ..WIDE };
const NOMINAL: Case = Case { name: "nominal", ranges: WIDE, reference: CLEAR, current: CLEAR };
const NOISY: Condition = Condition { full_well: 2_000.0, ..CLEAR };

/// Pictures over which the project was tuned, by their names without extension; others are held back.
pub const TUNING_PICTURES: [&str; 8] = [
    "bare_field_rows",
    "conifer_forest_road",
    "dune_scrub",
    "field_road_junction",
    "lake_shore",
    "pasture_low_texture",
    "ph_ground_rock",
    "urban_intersection_a",
];

/// The cases, the nominal one first.
pub const CASES: [Case; 14] = [
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
    Case { name: "altitude", ranges: FlightRanges { climb: 5.0, ..WIDE }, ..NOMINAL },
    Case { name: "yaw", ranges: FlightRanges { yaw: 15.0, ..WIDE }, ..NOMINAL },
    Case { name: "drift", ranges: FlightRanges { drift: 12.0, ..WIDE }, ..NOMINAL },
    Case { name: "relief", ranges: FlightRanges { relief: 3.0, ..WIDE }, ..NOMINAL },
    Case { name: "hover", ranges: HOVER, ..NOMINAL },
    Case { name: "narrow", ranges: NARROW, ..NOMINAL },
    Case { name: "narrow noisy", ranges: NARROW, reference: NOISY, current: NOISY },
];
