//! The tables of bounds: the worst case of each bound, and every picture under every condition.

use hoverlock_fixed_point::analysis::bounds::{Bounds, Class, Sense};
use serde::Serialize;

use crate::study::{BoundRow, Study};

/// One bound, summarised over all pictures and conditions.
#[derive(Debug, Serialize)]
pub(super) struct BoundGroup<'a> {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) sign: &'static str,
    /// One limit, or three if the limit depends on the contrast class.
    pub(super) limits: Vec<f64>,
    pub(super) checked: usize,
    pub(super) passed: usize,
    pub(super) worst: &'a BoundRow,
}

/// One picture under one condition, with its check of every bound.
#[derive(Debug, Serialize)]
pub(super) struct MatrixRow<'a> {
    picture: &'a str,
    condition: &'a str,
    /// Rms of the streaming DoG of each scale, LSB.
    rms: Vec<f64>,
    cells: Vec<Option<&'a BoundRow>>,
}

/// Returns one entry for each bound, in the order of the first check. A failed check is worse than any passed check.
pub(super) fn groups(rows: &[BoundRow]) -> Vec<BoundGroup<'_>> {
    let mut groups: Vec<BoundGroup<'_>> = Vec::new();
    for row in rows {
        let check = &row.check;
        match groups.iter_mut().find(|group| group.name == check.name) {
            Some(group) => {
                group.checked += 1;
                group.passed += usize::from(check.pass);
                let rank = |row: &BoundRow| (!row.check.pass, row.check.used);
                if rank(row) > rank(group.worst) {
                    group.worst = row;
                }
            }
            None => groups.push(BoundGroup {
                name: check.name,
                unit: check.unit,
                sign: if check.sense == Sense::AtMost { "≤" } else { "≥" },
                limits: limits(check.name).unwrap_or_else(|| vec![check.limit]),
                checked: 1,
                passed: usize::from(check.pass),
                worst: row,
            }),
        }
    }
    groups
}

/// Returns the limits of the classes nominal, combined and fog for a bound whose limit depends on the class.
fn limits(name: &str) -> Option<Vec<f64>> {
    let bounds = Bounds::acceptance();
    let columns = [Class::Nominal, Class::Combined, Class::Fog].map(|class| bounds.column(class));
    let of = |limit: fn(&hoverlock_fixed_point::analysis::bounds::Column) -> f64| Some(columns.map(limit).to_vec());
    match name {
        "DoG SQNR" => of(|column| column.sqnr_db),
        "MaxLBP bits flipped" => of(|column| column.maxlbp_flips_percent),
        "sign bits flipped" => of(|column| column.sign_flips_percent),
        "features at the same pixel" => of(|column| column.same_pixel_percent),
        "features within 1 px" => of(|column| column.within_one_px_percent),
        _ => None,
    }
}

/// Returns one row for each picture and condition. `None` stands for a bound that was not checked there.
pub(super) fn matrix<'a>(study: &'a Study, groups: &[BoundGroup<'_>]) -> Vec<MatrixRow<'a>> {
    let rows = study.pictures.iter().flat_map(|picture| picture.conditions.iter().map(move |of| (picture, of)));
    rows.map(|(picture, of)| {
        let of_row = |row: &&BoundRow| {
            row.picture.as_deref() == Some(picture.name.as_str()) && row.condition == Some(of.condition.name)
        };
        let cell = |group: &BoundGroup<'_>| study.bounds.iter().filter(of_row).find(|row| row.check.name == group.name);
        MatrixRow {
            picture: &picture.name,
            condition: of.condition.name,
            rms: of.comparison.scales.iter().map(|scale| scale.interior.reference_rms).collect(),
            cells: groups.iter().filter(|group| group.worst.condition.is_some()).map(cell).collect(),
        }
    })
    .collect()
}
