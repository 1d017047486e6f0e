//! The table of a hover: truth, estimate and sensors of each frame, in SI units and radians.

use serde::Serialize;

use super::summary::Row;

/// File name of the table.
pub const TABLE: &str = "hover.csv";

/// The columns beside those of the truth. The names of the file format are kept.
#[derive(Serialize)]
struct Record<'a> {
    status: &'a str,
    reason: Option<&'a str>,
    reference: Option<usize>,
    estimate_x: Option<f64>,
    estimate_y: Option<f64>,
    estimate_z: Option<f64>,
    sigma_x: Option<f64>,
    sigma_y: Option<f64>,
    estimate_vx: Option<f64>,
    estimate_vy: Option<f64>,
    sigma_vx: Option<f64>,
    sigma_vy: Option<f64>,
    protection_level: Option<f64>,
    quality: Option<u8>,
    inliers: Option<usize>,
    matches: Option<usize>,
    features: usize,
    told_roll: f64,
    told_pitch: f64,
    told_yaw: f64,
    told_range: f64,
    field_of_view: f64,
    blind_x: f64,
    blind_y: f64,
}

impl<'a> Record<'a> {
    fn new(row: &'a Row) -> Self {
        let Row { line, telemetry, blind, .. } = row;
        let sigma = |i: usize| line.covariance_m2.map(|covariance| covariance[i].sqrt());
        let velocity = line.velocity();
        Self {
            status: &line.status,
            reason: line.reason.as_deref(),
            reference: line.reference,
            estimate_x: line.x_e_m,
            estimate_y: line.y_e_m,
            estimate_z: line.z_e_m,
            sigma_x: sigma(0),
            sigma_y: sigma(3),
            estimate_vx: velocity.map(|(velocity, _)| velocity.x),
            estimate_vy: velocity.map(|(velocity, _)| velocity.y),
            sigma_vx: velocity.map(|(_, covariance)| covariance.m11.sqrt()),
            sigma_vy: velocity.map(|(_, covariance)| covariance.m22.sqrt()),
            protection_level: line.protection_level_m,
            quality: line.quality,
            inliers: line.inliers,
            matches: line.matches,
            features: line.features,
            told_roll: telemetry.attitude.roll,
            told_pitch: telemetry.attitude.pitch,
            told_yaw: telemetry.attitude.yaw,
            told_range: telemetry.range,
            field_of_view: telemetry.field_of_view,
            blind_x: blind.x,
            blind_y: blind.y,
        }
    }
}

/// Returns rows of a hover as CSV with a header.
///
/// # Errors
/// A value has no form in CSV, which is a defect of this program.
pub fn table(rows: &[Row]) -> Result<String, csv::Error> {
    let mut truths = csv::Writer::from_writer(Vec::new());
    let mut records = csv::Writer::from_writer(Vec::new());
    for row in rows {
        truths.serialize(row.truth)?;
        records.serialize(Record::new(row))?;
    }
    let text = |table: csv::Writer<Vec<u8>>| -> Result<String, csv::Error> {
        let bytes = table.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    };
    let (truths, records) = (text(truths)?, text(records)?);
    // No field contains a line break, so each row is one line.
    Ok(truths.lines().zip(records.lines()).map(|(truth, record)| format!("{truth},{record}\n")).collect())
}
