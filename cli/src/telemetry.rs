//! What IMU, laser and zoom read at each frame: a CSV table, one row a frame.

use std::fs::File;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use hoverlock_arm::message::Telemetry;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use serde::Deserialize;

/// The table as the help of a verb tells it.
macro_rules! telemetry_help {
    () => {
        "\
Telemetry is a CSV file: a header, then one row a frame, in order. Lines that begin with # are comments.

  roll_deg, pitch_deg
      tilt of the optical axis to the right and to the bottom of the picture
  yaw_deg
      turn of the camera, clockwise seen from above
  range_m
      laser rangefinder, along the optical axis
  fov_deg
      field of view across the columns of the picture as it is in the file
  tilt_se_deg, heading_se_deg, range_se_m
      standard errors of roll and pitch, of yaw, and of range; 0.2, 1 and 0.1 where left out
      (over rough ground that of the range is the relief)
  time_s
      15 frames a second where left out

Displacement is that of the camera from the reference, in the level frame: X_e and Y_e point to the right and to the \
         bottom of the picture where yaw is 0, Z_e points down."
    };
}

/// The same as a constant.
pub const HELP: &str = telemetry_help!();

/// Frames a second where the table has no time.
const FRAME_RATE: f64 = 15.0;

/// The standard errors of a row that names none.
const USUAL: [f64; 3] = [0.2, 1.0, 0.1];

const COLUMNS: [&str; 9] =
    ["time_s", "roll_deg", "pitch_deg", "yaw_deg", "range_m", "fov_deg", "tilt_se_deg", "heading_se_deg", "range_se_m"];

#[derive(Deserialize)]
struct Row {
    time_s: Option<f64>,
    roll_deg: f64,
    pitch_deg: f64,
    yaw_deg: f64,
    range_m: f64,
    fov_deg: f64,
    tilt_se_deg: Option<f64>,
    heading_se_deg: Option<f64>,
    range_se_m: Option<f64>,
}

/// Reads the rows of a table for so many frames, numbered from 0.
pub fn read(path: &Path, frames: usize) -> Result<Vec<Telemetry>> {
    let name = path.display();
    let file = File::open(path).with_context(|| format!("{name}: the telemetry cannot be read"))?;
    // A device or a FIFO may never end.
    if !file.metadata().is_ok_and(|about| about.is_file()) {
        bail!("{name}: the telemetry is not a regular file");
    }
    let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(file);
    let header = table.headers().with_context(|| format!("{name}: the telemetry is no table"))?.clone();
    if let Some(unknown) = header.iter().find(|column| !COLUMNS.contains(column)) {
        bail!("{name}: no column of telemetry is named `{unknown}`; the columns are {}", COLUMNS.join(", "));
    }
    let mut rows = Vec::new();
    for row in table.deserialize::<Row>() {
        let number = rows.len();
        let row =
            row.map_err(|error| anyhow!("{name}: row {} of the telemetry: {}", number + 1, told(&error, &header)))?;
        row.check().with_context(|| format!("{name}: row {} of the telemetry", number + 1))?;
        rows.push(row.telemetry(number as u32));
    }
    if rows.len() != frames {
        bail!("{name}: {} rows of telemetry for {frames} pictures; give one row for each, in order", rows.len());
    }
    if let Some(late) = rows.windows(2).position(|pair| pair[1].time_us <= pair[0].time_us) {
        bail!("{name}: row {} of the telemetry: time_s does not grow", late + 2);
    }
    Ok(rows)
}

/// What is wrong with a row, the column by its name.
fn told(error: &csv::Error, header: &csv::StringRecord) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => match err.field().and_then(|field| header.get(field as usize)) {
            Some(column) => format!("{column} is no number"),
            None => err.kind().to_string(),
        },
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} fields, and the header has {expected_len}")
        }
        _ => error.to_string(),
    }
}

impl Row {
    /// The readings are such as sensors give.
    fn check(&self) -> Result<()> {
        let error = |value: Option<f64>| value.unwrap_or(1.0);
        let bounds = [
            ("time_s", self.time_s.unwrap_or(0.0), 0.0, 1e9),
            ("roll_deg", self.roll_deg, -80.0, 80.0),
            ("pitch_deg", self.pitch_deg, -80.0, 80.0),
            ("yaw_deg", self.yaw_deg, -360.0, 360.0),
            ("range_m", self.range_m, 0.1, 1e4),
            ("fov_deg", self.fov_deg, 0.1, 170.0),
            ("tilt_se_deg", error(self.tilt_se_deg), 1e-6, 90.0),
            ("heading_se_deg", error(self.heading_se_deg), 1e-6, 180.0),
            ("range_se_m", error(self.range_se_m), 1e-6, 1e4),
        ];
        match bounds.into_iter().find(|(_, value, least, most)| !(least..=most).contains(&value)) {
            Some((column, value, least, most)) => bail!("{column} is {value}, and must be {least} to {most}"),
            None => Ok(()),
        }
    }

    fn telemetry(&self, frame: u32) -> Telemetry {
        let [tilt, heading, range] = USUAL;
        Telemetry {
            frame,
            time_us: (1e6 * self.time_s.unwrap_or(f64::from(frame) / FRAME_RATE)).round() as u64,
            attitude: Attitude {
                roll: self.roll_deg.to_radians(),
                pitch: self.pitch_deg.to_radians(),
                yaw: self.yaw_deg.to_radians(),
            },
            range: self.range_m,
            field_of_view: self.fov_deg.to_radians(),
            sensors: SensorErrors {
                tilt: self.tilt_se_deg.unwrap_or(tilt).to_radians(),
                heading: self.heading_se_deg.unwrap_or(heading).to_radians(),
                range: self.range_se_m.unwrap_or(range),
            },
        }
    }
}
