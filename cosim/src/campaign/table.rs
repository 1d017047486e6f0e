//! The table of a campaign: one row of CSV for each flight.

use std::collections::HashMap;
use std::path::Path;

use hoverlock_reports::journal;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::CampaignError;

/// Writes a point as a row without a header.
pub(super) fn to_row(point: &impl Serialize) -> Result<String, csv::Error> {
    Ok(String::from_utf8_lossy(&bytes(point, false)?).into_owned())
}

/// Reads a point from a row without a header.
pub(super) fn from_row<T: DeserializeOwned>(row: &str) -> Result<T, CampaignError> {
    let mut table = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
    Ok(table.deserialize().next().ok_or(CampaignError::EmptyRow)??)
}

/// Reads the rows of a table by their keys; none if there is no file.
pub(super) fn read<T: DeserializeOwned>(
    table: &Path,
    key: impl Fn(&T) -> String,
) -> Result<HashMap<String, T>, CampaignError> {
    let text = journal::read(table)?;
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let rows = rows.deserialize().map(|row| {
        let row: T = row.map_err(|source| CampaignError::Table { path: table.into(), source })?;
        Ok((key(&row), row))
    });
    rows.collect()
}

/// Appends a row. An empty table receives its header first.
pub(super) fn append(table: &Path, row: &impl Serialize) -> Result<(), CampaignError> {
    journal::append(table, |is_empty| Ok(bytes(row, is_empty)?))
}

fn bytes(row: &impl Serialize, with_header: bool) -> Result<Vec<u8>, csv::Error> {
    let mut rows = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.serialize(row)?;
    rows.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}
