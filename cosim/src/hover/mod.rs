//! The closed loop: a simulated helicopter in wind holds its position with the camera's estimate alone.

mod checks;
mod fly;
mod outcome;
mod scenario;
mod summary;
mod table;

use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use hoverlock_arm::arinc429::WordError;
use hoverlock_design::{DesignPoint, KT27};
use hoverlock_edss::camera::FRAME_SIZE;
use hoverlock_edss::flight::{Altitude, SetupError};
use hoverlock_edss::render::{RenderError, Renderer};
use hoverlock_edss::scene::{Scene, SceneError};
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::ViewError;
use hoverlock_reports::provenance::sha256;
use nalgebra::Vector2;

pub use checks::{MAX_LOSS_S, MAX_TILT_DEG};
pub use outcome::HoverOutcome;
pub use scenario::{CameraErrors, Event, Scenario};
pub use summary::{Row, Summary};
pub use table::{TABLE, table};

use crate::chain::{Chain, ChainError, FeatureSource, FlightProgram, check_choice};
use crate::monitor::{BoxError, Monitor};

/// Shortest and longest hover, s.
const SECONDS: (f64, f64) = (1.0, 3600.0);

/// The inputs of a hover.
#[derive(Debug, Clone, PartialEq)]
pub struct HoverSettings {
    /// Name of a scene, or a scene file.
    pub scene: String,
    /// The design of the extractor.
    pub design: DesignPoint,
    /// The source of the features.
    pub features: FeatureSource,
    /// The place where the flight program runs.
    pub flight_program: FlightProgram,
    /// Duration, s: 1 to 3600.
    pub seconds: f64,
    /// Seed of wind, sensors, camera and scene.
    pub seed: u64,
    /// Height over the mean ground, m: 10 to 300.
    pub height_m: f64,
    /// Rms of each horizontal component of the gusts, m/s: 0 to 5.
    pub gusts_m_s: f64,
    /// The height over time.
    pub altitude: Altitude,
    /// The field of view of the camera.
    pub view: CameraView,
    /// Time at which the flight program is commanded to renew its reference, s.
    pub renew_after_s: Option<f64>,
    /// Events of the flight, and errors of the camera.
    pub scenario: Scenario,
}

impl Default for HoverSettings {
    /// Returns a hover of 10 s at 50 m over the scene `field` in gusts of 3 m/s, with the design `kt27`.
    fn default() -> Self {
        Self {
            scene: "field".into(),
            design: KT27.clone(),
            features: FeatureSource::default(),
            flight_program: FlightProgram::default(),
            seconds: 10.0,
            seed: 1,
            height_m: 50.0,
            gusts_m_s: 3.0,
            altitude: Altitude::default(),
            view: CameraView::default(),
            renew_after_s: None,
            scenario: Scenario::default(),
        }
    }
}

impl HoverSettings {
    /// Checks the settings that have a range.
    fn check(&self) -> Result<(), HoverError> {
        let (min, max) = SECONDS;
        if !(min..=max).contains(&self.seconds) {
            return Err(HoverError::Seconds(self.seconds));
        }
        Ok(fly::setup(self).check()?)
    }
}

/// The field of view of the camera during a hover.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CameraView {
    /// A field of view of 50 degrees.
    #[default]
    Wide,
    /// A field of view of 50 degrees to acquire the reference, and 10 degrees after 2 s.
    Narrow,
}

impl Display for CameraView {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Wide => "wide",
            Self::Narrow => "narrow",
        })
    }
}

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
    /// There is no scene and no file of this name.
    #[error("scene {0}: no such scene, and no such file; scenes are {names}", names = Scene::NAMES.join(", "))]
    Unknown(String),
    /// The path is a folder, a device or a FIFO.
    #[error("scene {0}: not a regular file")]
    NotAFile(String),
    /// The file could not be read.
    #[error("scene {name}: cannot be read: {source}")]
    Read {
        /// The scene file.
        name: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is not a valid scene.
    #[error("scene {name}: {source}")]
    Scene {
        /// The name or file.
        name: String,
        /// The error of the parser.
        source: SceneError,
    },
}

/// Why a hover was not completed.
#[derive(Debug, thiserror::Error)]
pub enum HoverError {
    /// The duration is out of range.
    #[error("seconds is {0}, and must be {min} to {max}", min = SECONDS.0, max = SECONDS.1)]
    Seconds(f64),
    /// The scene could not be loaded.
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// The scene cannot be rendered.
    #[error("scene {name}: {source}")]
    Render {
        /// The name or file.
        name: String,
        /// The error of the renderer.
        source: RenderError,
    },
    /// The hover begins below the terrain, or in an object.
    #[error(
        "scene {name}: the hover begins {height_m} m over the mean ground, and the surface there is {surface_m:.1} m \
         high; give a greater height"
    )]
    BelowSurface {
        /// The name or file.
        name: String,
        /// Height over the mean ground, m.
        height_m: f64,
        /// Height of terrain or object where the hover begins, m.
        surface_m: f64,
    },
    /// Height or gusts are out of range.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The camera does not see the ground.
    #[error(transparent)]
    View(#[from] ViewError),
    /// Extractor or flight program could not be started or has failed.
    #[error(transparent)]
    Chain(#[from] ChainError),
    /// The flight program has sent a wrong word to the camera.
    #[error(transparent)]
    CameraWord(#[from] WordError),
    /// The monitor has stopped the hover.
    #[error(transparent)]
    Stopped(BoxError),
}

/// Flies a hover. Each frame is rendered from the position of the helicopter, taken by the camera with its noise, and
/// passes through extractor and flight program; the estimate steers the helicopter a tenth of a second later. The same
/// helicopter in the same wind with its IMU only is flown beside it. Equal settings give equal results.
///
/// # Errors
/// A setting is invalid, a tool is missing, extractor or flight program fail, or the monitor stops the hover. A hover
/// that does not hold its position is not an error: its outcome has `pass` false and a reason.
pub fn hover(settings: &HoverSettings, monitor: &dyn Monitor) -> Result<HoverOutcome, HoverError> {
    settings.check()?;
    settings.scenario.remarks(settings.seconds).for_each(|remark| monitor.remark(&remark));
    check_choice(settings.features, &settings.design, settings.flight_program)?;
    let scene = match &settings.scenario.scene {
        Some(scene) => scene.clone(),
        None => load_scene(&settings.scene)?,
    };
    // A frame that shows nothing: a design that the camera's frames do not fit and a missing tool are reported before
    // the scene is made, which takes seconds.
    let (columns, rows) = FRAME_SIZE;
    let (design, dark) = (&settings.design, Plane::filled(columns, rows, 0));
    drop(Chain::start(settings.features, design, settings.flight_program, &dark, None, monitor)?);
    let step = monitor.long_step("making the scene");
    let renderer = Renderer::new(&scene, settings.seed)
        .map_err(|source| HoverError::Render { name: settings.scene.clone(), source })?;
    drop(step);
    let surface_m = renderer.surface(0.0, Vector2::zeros());
    if settings.height_m <= surface_m {
        return Err(HoverError::BelowSurface { name: settings.scene.clone(), height_m: settings.height_m, surface_m });
    }
    fly::fly(settings, &scene, renderer, monitor)
}

/// Loads a scene by its name, or from a scene file.
///
/// # Errors
/// There is neither, or the file is not a valid scene.
pub fn load_scene(name: &str) -> Result<Scene, SceneFileError> {
    if let Some(text) = Scene::named(name) {
        return parse_scene(text, name);
    }
    let path = PathBuf::from(name);
    if !path.exists() {
        return Err(SceneFileError::Unknown(name.into()));
    }
    if !path.is_file() {
        return Err(SceneFileError::NotAFile(name.into()));
    }
    let text = std::fs::read_to_string(&path).map_err(|source| SceneFileError::Read { name: name.into(), source })?;
    parse_scene(&text, name)
}

/// Returns a text that is different for different scenes: their numbers, and the hashes of their picture files. It does
/// not depend on where these files are.
///
/// # Errors
/// A picture file cannot be read.
pub fn scene_identity(scene: &Scene) -> Result<String, SceneFileError> {
    let hash = |path: &Path| {
        let name = path.display().to_string();
        Ok(sha256(std::fs::read(path).map_err(|source| SceneFileError::Read { name, source })?))
    };
    let pictures: String = scene.pictures().into_iter().map(hash).collect::<Result<_, SceneFileError>>()?;
    Ok(format!("{:?}{pictures}", scene.without_paths()))
}

/// Parses a scene; its pictures are searched in the folder of the file `name`.
fn parse_scene(text: &str, name: &str) -> Result<Scene, SceneFileError> {
    let folder = Path::new(name).parent().unwrap_or(Path::new("."));
    Scene::parse(text, folder).map_err(|source| SceneFileError::Scene { name: name.into(), source })
}
