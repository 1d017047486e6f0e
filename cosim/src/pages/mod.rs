//! The pages of flights: each is one HTML file with its style, plots and pictures inside.

pub(crate) mod animation;
pub(crate) mod campaign;
pub(crate) mod estimates;
pub(crate) mod flight;
pub(crate) mod hover;
pub(crate) mod random;
pub(crate) mod still;

use std::collections::BTreeSet;

/// Returns the commits of the programs that flew, each once.
fn flown_by<'a>(commits: impl Iterator<Item = &'a str>) -> String {
    commits.collect::<BTreeSet<&str>>().into_iter().collect::<Vec<_>>().join(", ")
}
