//! Prints the measurements of the acceptance bounds as CSV, for every picture of the folders, every condition and
//! several seeds: `cargo run --release -p hoverlock-fixed-point --example calibrate -- FOLDER.. >
//! fixed_point/calibration.csv`
//!
//! The limits of the contrast classes were set from this table.

use std::path::{Path, PathBuf};

use hoverlock_design::KT27;
use hoverlock_fixed_point::analysis::acceptance::Comparison;
use hoverlock_fixed_point::analysis::bounds::Bounds;
use hoverlock_fixed_point::analysis::errors::BitKind;
use hoverlock_fixed_point::analysis::levels::Levels;
use hoverlock_pictures::Picture;
use hoverlock_pictures::conditions::CONDITIONS;

fn pictures(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder)?.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            pictures(&path, found)?;
        } else if path.extension().is_some_and(|extension| extension == "png" || extension == "jpg") {
            found.push(path);
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bounds = Bounds::acceptance();
    let levels = Levels::new(&KT27)?;
    let mut found = Vec::new();
    for folder in std::env::args_os().skip(1) {
        pictures(Path::new(&folder), &mut found)?;
    }
    println!(
        "picture,condition,seed,scale,threshold_lsb,rms_lsb,error_max,error_rms,whole_frame_max,sqnr_db,\
         maxlbp_flips_percent,sign_flips_percent,features,same_pixel_percent,within_one_px_percent"
    );
    for path in found {
        let frame = Picture::open(&path)?.crop(KT27.width as usize, KT27.height as usize).luma;
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
        let name = format!("{folder}/{}", path.file_stem().unwrap_or_default().to_string_lossy());
        for condition in CONDITIONS {
            for seed in [bounds.seeds.of(&condition), 1001, 1002] {
                let Some(comparison) = Comparison::of_frame(&levels, &condition.apply(&frame, seed), bounds) else {
                    eprintln!("{name}: too small, skipped");
                    continue;
                };
                for (k, scale) in comparison.scales.iter().enumerate() {
                    println!(
                        "{name},{},{seed},{k},{},{:.1},{:.2},{:.4},{:.2},{:.2},{:.4},{:.4},{},{:.2},{:.2}",
                        condition.name,
                        scale.threshold_lsb,
                        scale.interior.reference_rms,
                        scale.interior.max,
                        scale.interior.rms,
                        scale.whole_frame.max,
                        scale.interior.sqnr_db,
                        comparison.flips.percent(BitKind::Maxlbp),
                        comparison.flips.percent(BitKind::Sign),
                        scale.kept.reference,
                        scale.kept.same_pixel_percent,
                        scale.kept.within_one_px_percent
                    );
                }
            }
        }
    }
    Ok(())
}
