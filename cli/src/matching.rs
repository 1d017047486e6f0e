//! `hoverlock match`: the motion between two pictures.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use hoverlock_arm::line::Reason;
use hoverlock_arm::two_views::{self, Picture as View};
use hoverlock_cosim::chain::{clear_float_features, float_features};
use hoverlock_cosim::sequence::{calibration, telemetry};
use hoverlock_design::DesignPoint;
use hoverlock_fixed_point::analysis::levels::{Level, Levels};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_fixed_point::model::fastest::FastestModel;
use hoverlock_fixed_point::model::record::FeatureRecord;
use hoverlock_pictures::{Crop, Picture};
use hoverlock_reference::features::extractor::Selection;
use hoverlock_reference::features::feature::{Feature, MAX_PAIRS};
use hoverlock_reference::features::maxima::strongest_per_cell;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::estimate::Estimate;
use hoverlock_reference::motion::estimator::Estimator;
use hoverlock_reference::motion::matching::{Distance, Matching, matched_pairs};
use hoverlock_reference::motion::model::{Model, transfer};
use hoverlock_reference::motion::ransac::{Functional, Ransac, RansacError};
use hoverlock_reference::motion::refine::refined;
use hoverlock_reports::overlay::Overlay;
use hoverlock_simulation::{Job, Mismatch, Simulator, Streams, Trace, run as simulate};
use nalgebra::Vector2;
use serde::Serialize;

use crate::Verdict;
use crate::choice::between;
use crate::design::Chosen;
use crate::output::{prepare_target, print, print_json, verdict, write_file};
use crate::picture::{Limit, open, open_of_sensor};
use crate::progress::spinning;

/// Largest number of features of a picture, spread over it. This is twice the thousand used in flight: between two
/// seasons of one place only one match in ten is correct, so 2000 features give 55 correct matches, 1000 give 29, and
/// 250 give none that differ from chance.
const MAX_FEATURES: usize = 2000;

/// Smallest width and height of a picture with a feature, px: a ring of radius 16, two more for its windows, and the
/// centre.
const MIN_SIDE: usize = 37;

/// Smallest width and height of a frame of the hardware, px.
const MIN_HARDWARE_SIDE: usize = 64;

/// Find the motion between two pictures of the ground.
///
/// The homography maps a pixel of REF to CUR, (0, 0) the centre of the top-left pixel. It is fitted to the matches that
/// agree, after each was refined on the pictures themselves. Status 1 if there is no estimate.
///
/// Examples:
///   hoverlock match ref.png cur.png --overlay match.png
///   hoverlock match ref.png cur.png --telemetry two_rows.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_long_help = include_str!("../help/telemetry.txt"))]
pub struct Args {
    /// The reference picture: PNG, JPEG, TIFF, BMP, PNM or WebP; - reads it from standard input
    #[arg(value_name = "REF")]
    reference: PathBuf,
    /// The current picture
    #[arg(value_name = "CUR")]
    current: PathBuf,
    /// Kind of motion
    #[arg(long, value_enum, default_value = "homography")]
    model: Kind,
    /// Where features come from: floating point, the bit-true model, or the emitted Verilog under Verilator (for the
    /// last two, pictures larger than the frame of the design are cropped)
    #[arg(long, value_enum, default_value = "float")]
    features: Source,
    /// Compute the features by the clear code of a model level: ideal in f64 with Gaussians, recursive and quantised in
    /// f64 with the design's smoother, the second with rounded coefficients; bit_true in integers
    #[arg(long, value_enum, conflicts_with = "features")]
    level: Option<ClearLevel>,
    /// Words of the descriptors that are compared
    #[arg(long, value_enum, default_value = "full")]
    descriptor: Words,
    /// Distance of two descriptors
    #[arg(long, value_enum, default_value = "lexicographic")]
    distance: DistanceKind,
    /// Weight C of the squared difference of the responses in --distance sum, one over squared DN
    #[arg(long, value_name = "C", required_if_eq("distance", "sum"), allow_negative_numbers = true,
        value_parser = between(0.0, 1e6))]
    contrast: Option<f64>,
    /// Quality functional of the search; least squares on the inliers follow, after which it hardly matters
    #[arg(long, value_enum, default_value = "msac")]
    functional: FunctionalKind,
    #[command(flatten)]
    chosen: Chosen,
    #[command(flatten)]
    limit: Limit,
    /// Where REF and CUR were taken from, two rows: also the displacement of the camera in metres, from attitude, range
    /// and the matches that agree
    #[arg(long, value_name = "FILE.csv")]
    telemetry: Option<PathBuf>,
    /// The camera's calibration, as beside the frames of hoverlock cosim; without it the covariance of the displacement
    /// is that of a camera that nobody has calibrated
    #[arg(long, value_name = "FILE.toml", requires = "telemetry")]
    calibration: Option<PathBuf>,
    /// Draw both pictures, the matches and the displaced frame into this PNG
    #[arg(long, value_name = "FILE.png")]
    overlay: Option<PathBuf>,
    /// One JSON object on stdout: ok model homography[9] matches inliers displacement_px[2] sigma_px displacement_m[2]
    /// covariance_m2[4] protection_level_m quality rms_px features[2] reason
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    /// A translation
    Shift,
    /// Translation, rotation and scale
    Similarity,
    /// A linear map and a translation
    Affine,
    /// The motion of a plane between two views
    Homography,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Source {
    /// The reference in floating point
    Float,
    /// The bit-true integer model
    Fixed,
    /// The hardware, simulated; every plane and record is compared with the bit-true model on the way
    Rtl,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Words {
    /// MaxLBP and signs, 64 bits a scale pair
    Full,
    /// MaxLBP alone, 32 bits a scale pair
    Strict,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum DistanceKind {
    /// Hamming distance; the difference of the responses decides between equal ones
    Lexicographic,
    /// Hamming distance plus C times the squared difference of the responses
    Sum,
}

#[derive(Clone, Copy, ValueEnum)]
enum FunctionalKind {
    /// Votes alone
    Count,
    /// Votes plus K times the sum of the squared errors, as usually printed
    Plus,
    /// Votes minus K times that sum
    Minus,
    /// Votes minus the sum over the largest squared error of a vote
    Msac,
}

/// A model level whose clear code extracts features.
#[derive(Clone, Copy, ValueEnum)]
enum ClearLevel {
    /// True Gaussians in f64
    Ideal,
    /// The recursive smoother in f64
    Recursive,
    /// The same with rounded coefficients
    Quantised,
    /// The integer model, one cell at a time
    #[value(name = "bit_true")]
    BitTrue,
}

#[derive(Serialize)]
struct Report {
    ok: bool,
    model: &'static str,
    /// Row-major; `None` without an estimate.
    homography: Option<[f64; 9]>,
    matches: usize,
    inliers: usize,
    displacement_px: Option<[f64; 2]>,
    /// Standard error of the displacement at the centre, both axes together.
    sigma_px: Option<f64>,
    /// Displacement of the camera along `X_e` and `Y_e`, m; `None` without telemetry.
    displacement_m: Option<[f64; 2]>,
    /// Covariance of the displacement: xx, xy, yx, yy, m^2.
    covariance_m2: Option<[f64; 4]>,
    /// Radius that the error of the displacement exceeds once in 100 000 pictures, m.
    protection_level_m: Option<f64>,
    quality: u8,
    rms_px: Option<f64>,
    features: [usize; 2],
    /// Why there is no estimate.
    reason: Option<String>,
}

pub fn run(args: &Args) -> Result<Verdict> {
    let inputs: Vec<&Path> =
        [Some(&args.reference), Some(&args.current), args.telemetry.as_ref(), args.calibration.as_ref()]
            .into_iter()
            .flatten()
            .map(PathBuf::as_path)
            .collect();
    let target = |path: &PathBuf| prepare_target("--overlay", path, &["png"], &inputs);
    let _folder = args.overlay.as_ref().map(target).transpose()?;
    if [&args.reference, &args.current].iter().all(|path| *path == Path::new("-")) {
        bail!("- stands for standard input, which can be read once; name the other picture as a file");
    }
    let telemetry = args.telemetry.as_deref().map(|path| telemetry::read(path, 2)).transpose()?;
    let calibration = args.calibration.as_deref().map(calibration::read).transpose()?.unwrap_or_default();
    let source = match args.level {
        None => args.features,
        Some(ClearLevel::Ideal | ClearLevel::Recursive | ClearLevel::Quantised) => Source::Float,
        Some(ClearLevel::BitTrue) => Source::Fixed,
    };
    let design = args.chosen.design()?;
    let frame = (source != Source::Float).then_some((design.width as usize, design.height as usize));
    let open = if telemetry.is_some() { open_of_sensor } else { open };
    let open = |path: &Path| open(path, &args.limit, source.min_side(), frame);
    let (reference, current) = (open(&args.reference)?, open(&args.current)?);
    let [from, to] = source.extract(&design, [&reference, &current], args.level)?;
    let wanted = args.model.model();
    let ransac = Ransac { model: wanted, functional: args.functional.functional(), ..Ransac::default() };
    let estimator = Estimator { matching: args.matching()?, ransac };
    let outcome = match estimator.estimate(&from, &to) {
        Ok(estimate) => Ok(estimate),
        Err(error) if error.is_no_estimate() => Err(error),
        Err(error) => return Err(error.into()),
    };
    let (matched, inliers) = match &outcome {
        Ok(Estimate { pairs, inliers, .. }) => (pairs.clone(), inliers.clone()),
        Err(_) => {
            let matches = estimator.matching.matches(&from, &to);
            (matched_pairs(&matches, &from, &to).collect::<Vec<_>>(), Vec::new())
        }
    };
    let motion = outcome
        .as_ref()
        .ok()
        .map(|estimate| refined(estimate.clone(), &reference.luma, &current.luma, estimator.ransac.max_squared_error));
    let centre = centre(&reference.luma);
    let sigma = match (&motion, &outcome) {
        (Some(motion), Ok(search)) => motion.standard_error(search, centre),
        _ => f64::INFINITY,
    };
    let quality = motion.as_ref().map_or(0, |motion| motion.quality_within(sigma));
    let undetermined = (motion.is_some() && quality == 0).then(|| UNDETERMINED.to_owned());
    // Nothing is stated of a motion that is no estimate.
    let motion = motion.filter(|_| quality > 0);
    let homography = motion.as_ref().map(|motion| motion.homography);
    if let Some(path) = &args.overlay {
        let (reference, current) = (&reference.luma, &current.luma);
        let overlay = Overlay { reference, current, pairs: &matched, inliers: &inliers, homography };
        let png = overlay.png().with_context(|| format!("{}: cannot be encoded", path.display()))?;
        write_file(path, &png)?;
    }
    let pose = telemetry.as_ref().zip(motion.as_ref()).map(|(readings, _)| {
        let view = |i: usize, features, picture| View { telemetry: &readings[i], features, pixels: picture };
        two_views::estimate([view(0, &from, &reference.luma), view(1, &to, &current.luma)], &calibration)
    });
    let (pose, refused) = match pose {
        Some(Ok(pose)) => (Some(pose), None),
        Some(Err(Reason::View(error))) => return Err(error.into()),
        Some(Err(reason)) => (None, Some(reason.to_string())),
        None => (None, None),
    };
    let report = Report {
        ok: quality > 0 && refused.is_none(),
        model: name(outcome.as_ref().map_or(wanted, |estimate| estimate.model)),
        homography: homography.map(|h| std::array::from_fn(|i| h[(i / 3, i % 3)])),
        matches: matched.len(),
        inliers: inliers.len(),
        displacement_px: homography.and_then(|h| transfer(&h, centre)).map(|moved| (moved - centre).into()),
        sigma_px: motion.as_ref().map(|_| sigma),
        displacement_m: pose.map(|pose| [pose.x_e_m, pose.y_e_m]),
        covariance_m2: pose.map(|pose| pose.covariance_m2),
        protection_level_m: pose.map(|pose| pose.protection_level_m),
        quality,
        rms_px: motion.as_ref().map(|motion| motion.rms),
        features: [from.len(), to.len()],
        reason: outcome.as_ref().err().map(RansacError::to_string).or(undetermined).or(refused),
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.text())?;
    }
    Ok(report.ok.into())
}

/// The reason why matches that agree are no estimate.
const UNDETERMINED: &str =
    "the matches that agree do not determine the centre of the picture: they cover too little of it";

/// A threshold that lets every maximum through: the strongest are taken afterwards.
const ALL: [u32; MAX_PAIRS] = [1; MAX_PAIRS];

impl Source {
    /// Features of both pictures, whole or their centres, in coordinates of the whole; by the clear code of a level,
    /// or by the fast path of this source. The fast paths give the features of `recursive` to 0.015 DN of a response,
    /// and of `bit_true` bit for bit.
    fn extract(
        self,
        design: &DesignPoint,
        pictures: [&Picture; 2],
        clear: Option<ClearLevel>,
    ) -> Result<[Vec<Feature>; 2]> {
        if self == Self::Float {
            let selection = Selection { count: MAX_FEATURES, ..Selection::default() };
            let level = match clear {
                Some(ClearLevel::Ideal) => Some(Level::Ideal),
                Some(ClearLevel::Quantised) => Some(Level::Quantised),
                _ => None,
            };
            if let Some(level) = level {
                let (levels, thresholds) = (Levels::new(design)?, vec![selection.threshold; design.pairs()]);
                return Ok(pictures.map(|picture| {
                    let planes = levels.planes(level, &picture.luma);
                    strongest_per_cell(&levels.features(&planes, &thresholds), selection.count)
                }));
            }
            let mut features = match clear {
                Some(_) => clear_float_features(design, selection)?,
                None => float_features(design, selection)?,
            };
            return Ok(pictures.map(|picture| features(&picture.luma)));
        }
        let frames = pictures.map(|picture| {
            let frame = picture.crop(design.width as usize, design.height as usize);
            Crop { luma: camera_samples(design, &frame.luma), ..frame }
        });
        let records: Vec<Vec<FeatureRecord>> = match self {
            Self::Rtl => simulated(design, &frames)?,
            _ if clear.is_some() => {
                let model = BitTrue::new(design)?;
                frames.iter().map(|frame| model.planes(&frame.luma).features(&ALL)).collect()
            }
            _ => {
                let mut model = FastestModel::new(design)?;
                frames.iter().map(|frame| model.features(&frame.luma, &ALL)).collect()
            }
        };
        Ok(std::array::from_fn(|i| {
            let features: Vec<Feature> = records[i].iter().map(|record| record.feature(design.dog().lsb())).collect();
            let mut features = strongest_per_cell(&features, MAX_FEATURES);
            for feature in &mut features {
                feature.x += frames[i].x as u32;
                feature.y += frames[i].y as u32;
            }
            features
        }))
    }

    /// Returns the smallest width and height of a picture, px.
    fn min_side(self) -> usize {
        if self == Self::Rtl { MIN_HARDWARE_SIDE } else { MIN_SIDE }
    }
}

/// Returns the records that the hardware sends for each frame, in one simulation.
fn simulated(design: &DesignPoint, frames: &[Crop]) -> Result<Vec<Vec<FeatureRecord>>> {
    let all = &ALL[..design.pairs()];
    let job = |frame: &Crop| {
        // The strongest are taken afterwards, so nothing is withheld.
        Job::of(design, frame.luma.clone(), all).map(|job| Job { record_limit: u16::MAX.into(), ..job })
    };
    let jobs = frames.iter().map(job).collect::<Result<Vec<_>, _>>()?;
    let build = || Simulator::of_design(design, None, Trace::None);
    let simulator = spinning("building the Verilated model (once; later runs find it)", build)?;
    let outcome = simulate(&simulator, &jobs, Streams::default())?;
    if let Some(first) = outcome.first_mismatch {
        let Mismatch { stage, x, y, .. } = first;
        bail!("the Verilog differs from the bit-true model, first in {stage} at ({x}, {y}); `hoverlock sim` says more");
    }
    Ok(outcome.frames.into_iter().map(|frame| frame.records).collect())
}

fn centre(picture: &Plane<u16>) -> Vector2<f64> {
    Vector2::new(picture.width() as f64 - 1.0, picture.height() as f64 - 1.0) / 2.0
}

impl Args {
    /// Returns the matching of the estimator, with the distance and the words that were asked for.
    fn matching(&self) -> Result<Matching> {
        let distance = match (self.distance, self.contrast) {
            (DistanceKind::Sum, Some(c)) => Distance::Sum(c),
            (_, None) => Distance::Lexicographic,
            (DistanceKind::Lexicographic, Some(_)) => bail!("--contrast is a part of --distance sum; name both"),
        };
        Ok(Matching { distance, strict: self.descriptor == Words::Strict, ..Estimator::default().matching })
    }
}

impl FunctionalKind {
    fn functional(self) -> Functional {
        match self {
            Self::Count => Functional::Count,
            Self::Plus => Functional::Added(None),
            Self::Minus => Functional::Subtracted(None),
            Self::Msac => Functional::Msac,
        }
    }
}

impl Kind {
    fn model(self) -> Model {
        match self {
            Self::Shift => Model::Shift,
            Self::Similarity => Model::Similarity,
            Self::Affine => Model::Affine,
            Self::Homography => Model::Homography,
        }
    }
}

fn name(model: Model) -> &'static str {
    match model {
        Model::Shift => "shift",
        Model::Similarity => "similarity",
        Model::Affine => "affine",
        Model::Homography => "homography",
    }
}

impl Report {
    /// Describes the displacement of the camera, or the reason why there is none although telemetry is given.
    fn metres(&self) -> String {
        let level = self.protection_level_m.map(|level| format!("            protection level {level:.2} m\n"));
        let level = level.unwrap_or_default();
        match (self.displacement_m, self.covariance_m2, &self.reason) {
            (Some([x, y]), Some([xx, _, _, yy]), _) => format!(
                "camera      {x:+.3} m along X_e, {y:+.3} m along Y_e, standard errors {:.3} m and {:.3} m\n{level}",
                xx.sqrt(),
                yy.sqrt()
            ),
            (_, _, Some(reason)) => format!("camera      {}\n", verdict(false, reason)),
            _ => String::new(),
        }
    }

    fn text(&self) -> String {
        // Without an estimate the reason states how many agree.
        let agree = self.homography.map(|_| format!(", of which {} agree", self.inliers)).unwrap_or_default();
        let counts = format!(
            "features    {} and {}\nmatches     {}{agree}\nquality     {} of 255\n",
            self.features[0], self.features[1], self.matches, self.quality
        );
        let (Some([dx, dy]), Some(h), Some(rms), Some(sigma)) =
            (self.displacement_px, self.homography, self.rms_px, self.sigma_px)
        else {
            let reason = self.reason.as_deref().unwrap_or("no estimate");
            return format!("{counts}{}\n", verdict(false, reason));
        };
        format!(
            "displaced   {dx:+.2} px right, {dy:+.2} px down, at the centre of the picture, standard error {sigma:.2} \
             px\n\
             {}{counts}\
             residual    {rms:.2} px rms\n\
             {:<10}  {:12.6} {:12.6} {:12.4}\n\
             {:12}{:12.6} {:12.6} {:12.4}\n\
             {:12}{:12.3e} {:12.3e} {:12.4}\n",
            self.metres(),
            self.model,
            h[0],
            h[1],
            h[2],
            "",
            h[3],
            h[4],
            h[5],
            "",
            h[6],
            h[7],
            h[8]
        )
    }
}
