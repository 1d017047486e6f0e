//! `hoverlock orthophoto`: a picture as seen straight from above.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::ValueHint;
use hoverlock_arm::message::Telemetry;
use hoverlock_cosim::sequence::{png, telemetry};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::model::transfer;
use hoverlock_reference::motion::orthophoto::raster::Raster;
use hoverlock_reference::motion::orthophoto::{Camera, View};
use nalgebra::Vector2;
use serde::Serialize;

use crate::Verdict;
use crate::choice::between;
use crate::output::{prepare_target, print, print_json, shown, write_file};
use crate::picture::{Limit, open_of_sensor};

/// Columns and rows of the places at which the error is evaluated.
const GRID: usize = 32;

/// Warp a picture to the level plane through the point that the laser hits.
///
/// The orthophoto has the size of the picture, and on the optical axis its scale. Pixels that the camera does not see
/// are 0. Ground that is off the plane is displaced; the error is that of ground lower by --relief, along each ray.
///
/// Examples:
///   hoverlock orthophoto frame.png --telemetry row.csv
///   hoverlock orthophoto frame.png --telemetry row.csv --relief 3 --out above.png --json
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = include_str!("../help/telemetry.txt"))]
pub struct Args {
    /// The picture: PNG, JPEG, TIFF, BMP, PNM or WebP; - reads it from standard input
    #[arg(value_name = "PICTURE")]
    picture: PathBuf,
    /// Where it was taken from, one row
    #[arg(long, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    telemetry: PathBuf,
    /// Height of the plane over the ground for which the error is stated, m
    #[arg(long, value_name = "DH", default_value = "10", allow_negative_numbers = true,
        value_parser = between(0.0, 1000.0))]
    relief: f64,
    /// The PNG to write
    #[arg(long, value_name = "FILE.png", default_value = "out/orthophoto.png", value_hint = ValueHint::FilePath)]
    out: PathBuf,
    #[command(flatten)]
    limit: Limit,
    /// One JSON object on stdout: metres_per_pixel error_m error_max_m height_m out
    #[arg(long)]
    json: bool,
}

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report {
    metres_per_pixel: f64,
    /// Displacement of a point by the relief, m: the mean over the picture.
    error_m: f64,
    /// The largest.
    error_max_m: f64,
    height_m: f64,
    #[serde(serialize_with = "crate::output::lossy")]
    out: PathBuf,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let _folder = prepare_target("--out", &args.out, &["png"], &[Path::new(&args.picture), &args.telemetry])?;
    let rows = telemetry::read(&args.telemetry, 1)?;
    let Telemetry { attitude, range, field_of_view, .. } = rows[0];
    let picture = open_of_sensor(&args.picture, &args.limit, 1, None)?.luma;
    let camera = Camera::with_field_of_view(picture.width(), picture.height(), field_of_view)?;
    let view = View::new(camera, attitude, range)?;
    let raster = Raster::of(&view, picture.width(), picture.height());
    let photo = raster.warp(&picture, &view, 0);
    write_file(&args.out, &png(&photo).context("the orthophoto cannot be encoded")?)?;
    let errors = errors(&view, &picture, args.relief);
    let report = Report {
        metres_per_pixel: raster.pixel,
        error_m: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
        error_max_m: errors.iter().copied().fold(0.0, f64::max),
        height_m: view.height(),
        out: args.out.clone(),
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(&format!(
            "{:.3} mm a pixel, from {:.1} m\nground lower by {} m is displaced by {:.2} m on average, {:.2} m at \
             most\n{}\n",
            1e3 * report.metres_per_pixel,
            report.height_m,
            args.relief,
            report.error_m,
            report.error_max_m,
            shown(&args.out)
        ))?;
    }
    Ok(Verdict::Pass)
}

/// Returns the displacement (m) of places all over the ground in a picture, for ground that is lower by `dh` (m).
fn errors(view: &View, picture: &Plane<u16>, dh: f64) -> Vec<f64> {
    let [width, height] = [picture.width(), picture.height()].map(|size| size as f64);
    let places = (0..GRID * GRID).map(|i| {
        let part = |k: usize| (k as f64 + 0.5) / GRID as f64;
        Vector2::new(width * part(i % GRID), height * part(i / GRID))
    });
    let to_level = view.attitude().rotation();
    places
        .filter_map(|place| transfer(&view.camera().inverse(), place))
        .map(|ray| to_level * ray.push(1.0))
        // The ground is below the horizon.
        .filter(|ray| ray.z > 0.0)
        .map(|ray| dh * ray.xy().norm() / ray.z)
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use hoverlock_reference::motion::orthophoto::{Attitude, height_error};

    use super::*;

    /// Formula (1), which is about one axis, is the displacement along that axis.
    #[test]
    fn in_the_plane_of_the_roll_the_error_is_that_of_the_formula() {
        let camera = Camera::with_field_of_view(1024, 1, 1.0).unwrap();
        let view = View::new(camera, Attitude { roll: 0.4, pitch: 0.0, yaw: 0.0 }, 50.0).unwrap();
        let found = errors(&view, &Plane::filled(1024, 1, 0), 10.0);
        let ends = [0.5, GRID as f64 - 0.5].map(|at| (2.0 * at / GRID as f64 - 1.0) * 0.5f64.tan());
        let [left, right] = ends.map(|x: f64| height_error(10.0, 0.4, x.atan()).abs());
        // The centres of pixels are half a pixel off the grid.
        let is_near = |found: f64, formula: f64| (found - formula).abs() < 0.02;
        assert!(is_near(found[0], left) && is_near(found[GRID - 1], right), "{found:?} {left} {right}");
    }

    /// The optical axis is at the angle `acos(cos roll cos pitch)` to the vertical, where the formula has 5.15 m.
    #[test]
    fn tilted_about_both_axes_the_error_is_that_along_the_ray() {
        let camera = Camera::with_field_of_view(1, 1, 1e-3).unwrap();
        let tilt = 20f64.to_radians();
        let view = View::new(camera, Attitude { roll: tilt, pitch: tilt, yaw: 0.0 }, 50.0).unwrap();
        let expected = 10.0 * (tilt.cos() * tilt.cos()).acos().tan();
        let found = errors(&view, &Plane::filled(1, 1, 0), 10.0);
        assert!(found.iter().all(|found| (found - expected).abs() < 0.02), "{expected} {found:?}");
    }

    #[test]
    fn places_above_the_horizon_have_no_error() {
        let picture = Plane::filled(1024, 768, 0);
        let camera = Camera::with_field_of_view(1024, 768, FRAC_PI_2).unwrap();
        let count = |roll: f64, pitch: f64| {
            let [roll, pitch] = [roll, pitch].map(f64::to_radians);
            let view = View::new(camera, Attitude { roll, pitch, yaw: 0.0 }, 50.0).unwrap();
            errors(&view, &picture, 10.0).len()
        };
        // Rolled by 60 degrees, the horizon is 30 degrees off the axis: (1 + tan 30) / 2 of the columns show ground.
        assert_eq!([count(0.0, 0.0), count(60.0, 0.0)], [GRID * GRID, GRID * 25]);
        // The sky fills a corner, where x sin 40 cos 40 + y sin 40 > cos^2 40, though neither axis reaches it.
        assert_eq!(count(40.0, 40.0), 946);
    }
}
