//! The table of a campaign: one row of CSV for each flight.

use std::collections::HashMap;
use std::fs::{self, File, Permissions};
use std::io::{Read as _, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use hoverlock_reports::journal::{self, JournalError};
use serde::de::value::Error as ValueError;
use serde::de::{DeserializeOwned, Deserializer, Error as _, Visitor};
use serde::{Serialize, forward_to_deserialize_any};

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

/// Reads the rows of a table by their keys; none if there is no file. A file with another header stays as it is. The
/// table is locked ([`journal::Lock`]), as a line that was cut off is removed from it.
pub(super) fn read<T: DeserializeOwned>(
    table: &Path,
    key: impl Fn(&T) -> String,
) -> Result<HashMap<String, T>, CampaignError> {
    check_header::<T>(table)?;
    let text = journal::read(table)?;
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let rows = rows.deserialize().map(|row| {
        let row: T = row.map_err(|source| CampaignError::Table { path: table.into(), source })?;
        Ok((key(&row), row))
    });
    rows.collect()
}

/// Checks that a file that exists begins with the header of the table, or with a part of it that was cut off.
fn check_header<T: DeserializeOwned>(table: &Path) -> Result<(), CampaignError> {
    if !table.exists() {
        return Ok(());
    }
    let header = columns::<T>().join(",") + "\n";
    let mut begin = Vec::new();
    let read = File::open(table).and_then(|file| file.take(header.len() as u64).read_to_end(&mut begin));
    read.map_err(|source| JournalError::Read { path: table.into(), source })?;
    if header.as_bytes().starts_with(&begin) { Ok(()) } else { Err(CampaignError::OtherFile(table.into())) }
}

/// Returns the columns of a table of `T`: the names of its fields.
fn columns<T: DeserializeOwned>() -> &'static [&'static str] {
    let mut columns: &[&str] = &[];
    // It ends with an error as soon as the fields are known.
    let _ = T::deserialize(Columns(&mut columns));
    columns
}

/// A deserialiser that has no values and takes the names of the fields of a struct.
struct Columns<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Columns<'_> {
    type Error = ValueError;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, ValueError> {
        *self.0 = fields;
        Err(ValueError::custom("no values"))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, ValueError> {
        Err(ValueError::custom("not a struct"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
        seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// Appends a row. An empty table receives its header first.
pub(super) fn append(table: &Path, row: &impl Serialize) -> Result<(), CampaignError> {
    journal::append(table, |is_empty| Ok(bytes(row, is_empty)?))
}

/// Replaces the table by these rows. It is complete at any time, and keeps its permissions.
pub(super) fn replace<'a, T: Serialize + 'a>(
    table: &Path,
    rows: impl Iterator<Item = &'a T>,
) -> Result<(), CampaignError> {
    let mut text = csv::Writer::from_writer(Vec::new());
    rows.into_iter().try_for_each(|row| text.serialize(row))?;
    let bytes = text.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    // A link stays one: its target is replaced.
    let target = table.canonicalize().unwrap_or_else(|_| table.to_owned());
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let permissions = fs::metadata(&target).map_or_else(|_| Permissions::from_mode(0o644), |there| there.permissions());
    let write = || -> std::io::Result<()> {
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.as_file().set_permissions(permissions)?;
        file.write_all(&bytes)?;
        file.persist(&target)?;
        Ok(())
    };
    Ok(write().map_err(|source| JournalError::Write { path: table.into(), source })?)
}

fn bytes(row: &impl Serialize, with_header: bool) -> Result<Vec<u8>, csv::Error> {
    let mut rows = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.serialize(row)?;
    rows.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_reports::journal::Lock;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Row {
        name: String,
        rms_m: f64,
    }

    #[test]
    fn a_file_with_another_header_is_refused_and_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let table = folder.path().join("table.csv");
        let key = |row: &Row| row.name.clone();
        // A text without a newline would be removed as a line that was cut off.
        for text in ["notes", "rms_m,name\n0.1,a\n", "name,rms_m,more\n"] {
            std::fs::write(&table, text).unwrap();
            assert!(matches!(read(&table, key), Err(CampaignError::OtherFile(_))), "{text}");
            assert_eq!(std::fs::read_to_string(&table).unwrap(), text);
        }
        for text in ["", "name,rm"] {
            std::fs::write(&table, text).unwrap();
            assert_eq!(read(&table, key).unwrap().len(), 0);
            append(&table, &Row { name: "a".into(), rms_m: 0.1 }).unwrap();
            assert_eq!(read(&table, key).unwrap()["a"], Row { name: "a".into(), rms_m: 0.1 });
        }
        let rows = ["b", "a"].map(|name| Row { name: name.into(), rms_m: 0.2 });
        replace(&table, rows.iter()).unwrap();
        assert_eq!(std::fs::read_to_string(&table).unwrap(), "name,rms_m\nb,0.2\na,0.2\n");

        let link = folder.path().join("link.csv");
        std::os::unix::fs::symlink("table.csv", &link).unwrap();
        std::fs::set_permissions(&table, Permissions::from_mode(0o664)).unwrap();
        replace(&link, rows[..1].iter()).unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read_to_string(&table).unwrap(), "name,rms_m\nb,0.2\n");
        assert_eq!(std::fs::metadata(&table).unwrap().permissions().mode() & 0o777, 0o664);
    }

    #[test]
    fn a_table_is_locked_while_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let [table, link] = ["table.csv", "link.csv"].map(|name| folder.path().join(name));
        let row = Row { name: "a".into(), rms_m: 0.1 };
        let is_locked = |path: &Path| matches!(Lock::new(path), Err(JournalError::Locked(_)));
        // An empty table is not left.
        let lock = Lock::new(&table).unwrap();
        assert!(table.exists() && is_locked(&table));
        drop(lock);
        assert!(!table.exists());
        std::os::unix::fs::symlink("table.csv", &link).unwrap();
        assert!(matches!(Lock::new(&link), Err(JournalError::LinkToNothing(_))) && link.is_symlink());
        assert!(matches!(Lock::new(folder.path()), Err(JournalError::NotAFile(_))));

        let lock = Lock::new(&table).unwrap();
        append(&table, &row).unwrap();
        assert!(is_locked(&link));
        replace(&table, [&row].into_iter()).unwrap();
        drop(lock);
        assert_eq!(std::fs::read_to_string(&table).unwrap(), "name,rms_m\na,0.1\n");
        drop(Lock::new(&link).unwrap());
    }
}
