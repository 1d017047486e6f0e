//! Real nadir pictures, cropped to the frame of the design point, through the bit-true model and the SIMD model.

use hoverlock_design::KT27;
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_fixed_point::model::threshold::{ThresholdController, count_per_scale};
use hoverlock_pictures::{Picture, data_dir};
use std::io::Write as _;

#[test]
#[ignore = "some seconds: sixteen real pictures through the generic model"]
fn simd_and_bit_true_agree_on_every_texture_and_thresholds_settle() {
    let Some(folder) = data_dir() else {
        writeln!(
            std::io::stderr(),
            "SKIPPED: simd_and_bit_true_agree_on_every_texture_and_thresholds_settle: \
             set HOVERLOCK_DATA to the picture folder"
        )
        .expect("stderr is open");
        return;
    };
    let files = std::fs::read_dir(folder.join("textures")).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.filter(|path| path.extension().is_some_and(|extension| extension == "png")).collect();
    files.sort();
    assert!(!files.is_empty());
    let model = BitTrue::new(&KT27).unwrap();
    let mut simd = SimdBitTrue::new(&KT27).unwrap();
    let mut portable = simd.clone();
    for path in files {
        let frame = Picture::open(&path).unwrap().crop(KT27.width as usize, KT27.height as usize).luma;
        let planes = model.planes(&frame);
        assert_eq!(planes.saturated, [0, 0], "{}", path.display());
        let mut controller = ThresholdController::new(&KT27);
        let mut settled = None;
        for round in 0..60 {
            let thresholds = controller.thresholds().to_vec();
            let features = planes.features(&thresholds);
            if round < 2 {
                assert_eq!(simd.frame(&frame, &thresholds), features, "{}", path.display());
                assert_eq!(portable.portable_frame(&frame, &thresholds), features, "{}", path.display());
                assert!(*simd.planes() == planes && *portable.planes() == planes, "{}", path.display());
            }
            controller.finish_frame(&planes.maxima());
            if controller.thresholds() == thresholds {
                settled = Some((round, thresholds, count_per_scale(&features)));
                break;
            }
        }
        let (round, thresholds, counts) = settled.unwrap_or_else(|| panic!("{} never settles", path.display()));
        println!("{}: settled after {round} frames at {thresholds:?} with {counts:?}", path.display());
    }
}
