//! The table of a campaign: one row of CSV for each point that was flown.

use std::collections::HashMap;
use std::path::Path;

use hoverlock_reports::journal;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{CampaignError, FlownPoint};

/// Writes a point as a row without a header.
pub(super) fn to_row(point: &impl Serialize) -> Result<String, csv::Error> {
    Ok(String::from_utf8_lossy(&bytes(point, false)?).into_owned())
}

/// Reads a point from a row without a header.
pub(super) fn from_row<T: DeserializeOwned>(row: &str) -> Result<T, CampaignError> {
    let mut table = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
    Ok(table.deserialize().next().ok_or(CampaignError::EmptyRow)??)
}

/// Reads the points of a table by their keys; no points if there is no file.
pub(super) fn read(table: &Path) -> Result<HashMap<String, FlownPoint>, CampaignError> {
    let text = journal::read(table)?;
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let points = rows.deserialize().map(|row| {
        let point: FlownPoint = row.map_err(|source| CampaignError::Table { path: table.into(), source })?;
        Ok((point.point().key(), point))
    });
    points.collect()
}

/// Appends a point. An empty table receives its header first.
pub(super) fn append(table: &Path, point: &FlownPoint) -> Result<(), CampaignError> {
    journal::append(table, |is_empty| Ok(bytes(point, is_empty)?))
}

fn bytes(point: &impl Serialize, with_header: bool) -> Result<Vec<u8>, csv::Error> {
    let mut rows = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.serialize(point)?;
    rows.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}
