//! The cost of an upset in the hardware: what the flight program makes of the frames that come out.
//!
//! A camera stands at places beside each other, 0.4 m apart, 50 m above a scene and looks straight down; a frame a
//! second, so that the first, the reference, is confirmed by the second. The frames go through the hardware, with a
//! fault or without, and what comes out goes to the flight program, with the attitude and the range of the simulator
//! and their usual standard errors. There is no IMU: at a frame a second the program searches each frame from its
//! keyframe, with the budget of a flight. Frames of three scale pairs have too many features for that.

use hoverlock_arm::framing::Decoder;
use hoverlock_arm::line::{Line, Status};
use hoverlock_arm::message::{self, Command, Telemetry};
use hoverlock_arm::navigator::Navigator;
use hoverlock_arm::source::Source;
use hoverlock_design::DesignPoint;
use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::Renderer;
use hoverlock_edss::world::still;
use hoverlock_fixed_point::model::design::camera_samples;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::observation::SensorErrors;
use hoverlock_reference::motion::orthophoto::Attitude;
use nalgebra::{Vector2, Vector3};

use crate::hover::{HoverError, load_scene};

/// Size of a frame, px: the middle of the camera's.
pub const SIZE: (usize, usize) = (512, 384);

/// Field of view of the whole camera across its columns, degrees.
const FIELD_OF_VIEW_DEG: f64 = 50.0;

/// Height above the mean ground, m.
const HEIGHT_M: f64 = 50.0;

/// From one frame to the next along `X_e` and `Y_e`, m.
const STEP_M: [f64; 2] = [0.35, -0.2];

/// Time from one frame to the next, microseconds.
const FRAME_US: u64 = 1_000_000;

/// Standard errors of the readings: 0.2 degrees of tilt, 0.5 of heading, 5 cm of range.
const SENSORS: SensorErrors = SensorErrors { tilt: 0.0035, heading: 0.0087, range: 0.05 };

/// Frames of a hover, with the readings and the true displacement of each.
pub struct HoverFrames {
    frames: Vec<Plane<u16>>,
    telemetry: Vec<Telemetry>,
    truth: Vec<Vector2<f64>>,
}

/// The place of a frame by the flight program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Place along `X_e` and `Y_e`, m: the estimate from the frame that the program captured, whose place is known.
    pub place_m: Vector2<f64>,
    /// Protection level of the estimate, m.
    pub protection_level_m: f64,
}

/// The cost of one upset: the estimates of the flight program beside those without it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Frames that have no estimate because of the upset.
    pub withheld: usize,
    /// Largest change of an estimate, m.
    pub shift_m: f64,
    /// Estimates that are further from the truth than their protection level.
    pub misleading: usize,
}

impl HoverFrames {
    /// Renders frames of a scene, by name or file, for the camera of a design. `seed` is that of scene and noise.
    ///
    /// # Errors
    /// If the scene cannot be read or rendered.
    pub fn new(design: &DesignPoint, scene: &str, frames: usize, seed: u64) -> Result<Self, HoverError> {
        let file = load_scene(scene)?;
        let renderer =
            Renderer::new(&file, seed).map_err(|source| HoverError::Render { name: scene.to_owned(), source })?;
        let mut hover = Self { frames: Vec::new(), telemetry: Vec::new(), truth: Vec::new() };
        for frame in 0..frames {
            let at = Vector2::from(STEP_M) * frame as f64;
            let pose = Pose { position: Vector3::new(at.x, at.y, -HEIGHT_M), attitude: Attitude::default() };
            let whole = still(&renderer, &pose, FIELD_OF_VIEW_DEG, seed + frame as u64)?;
            hover.frames.push(camera_samples(design, &middle(&whole)));
            // The range is along the optical axis; a scene without ground there has no picture either.
            let range = renderer.range(0.0, pose.position, Vector3::z()).unwrap_or(HEIGHT_M);
            let half = (FIELD_OF_VIEW_DEG / 2.0).to_radians().tan() * SIZE.0 as f64 / whole.width() as f64;
            hover.telemetry.push(Telemetry {
                frame: frame as u32,
                time_us: FRAME_US * frame as u64,
                attitude: Attitude::default(),
                range,
                field_of_view: 2.0 * half.atan(),
                sensors: SENSORS,
            });
            hover.truth.push(at);
        }
        Ok(hover)
    }

    /// Returns the frames, in steps of the camera.
    pub fn frames(&self) -> &[Plane<u16>] {
        &self.frames
    }

    /// Returns the place of each frame that the flight program finds from the packets of the hardware, as words; `None`
    /// for a frame without an estimate, or without a packet that it takes. The first frame that it takes is its origin.
    pub fn fixes(&self, packets: &[Vec<u32>]) -> Vec<Option<Fix>> {
        let mut source = Source::default();
        let mut fixes = vec![None; self.frames.len()];
        // The messages before the frames are never too long.
        if source.send_registers(SIZE.0, SIZE.1).is_err()
            || source.send(message::COMMAND, &Command::Capture.encode()).is_err()
        {
            return fixes;
        }
        for (telemetry, packet) in self.telemetry.iter().zip(packets) {
            let payload: Vec<u8> = packet.iter().flat_map(|word| word.to_le_bytes()).collect();
            // A packet that is too long for a message is lost.
            let _ = source.send(message::TELEMETRY, &telemetry.encode());
            let _ = source.send(message::FRAME, &payload);
        }
        let mut origin = None;
        let mut keep = |line: &Line| {
            let Some((fix, at)) = line.frame.and_then(|frame| {
                let frame = frame as usize;
                Some((fixes.get_mut(frame)?, self.truth.get(frame)?))
            }) else {
                return;
            };
            if line.status == Status::Reference && origin.is_none() {
                origin = Some(*at);
            }
            *fix = line.estimate.as_ref().zip(origin).map(|(estimate, origin)| Fix {
                place_m: origin + Vector2::new(estimate.x_e_m, estimate.y_e_m),
                protection_level_m: estimate.protection_level_m,
            });
        };
        let (bytes, mut decoder, mut navigator) = (source.messages.concat(), Decoder::default(), Navigator::default());
        let mut rest = &bytes[..];
        while let Ok(more) = decoder.read(&mut rest) {
            while let Some(raw) = decoder.message() {
                if navigator.take(&raw, &mut keep).is_err() {
                    break;
                }
            }
            if !more {
                break;
            }
        }
        navigator.finish(&mut keep);
        fixes
    }

    /// Compares the places of a run with a fault with those of the run without.
    pub fn cost(&self, golden: &[Option<Fix>], faulty: &[Option<Fix>]) -> Cost {
        let mut cost = Cost::default();
        for ((golden, faulty), truth) in golden.iter().zip(faulty).zip(&self.truth) {
            cost.withheld += usize::from(golden.is_some() && faulty.is_none());
            let Some(faulty) = faulty else { continue };
            cost.misleading += usize::from((faulty.place_m - truth).norm() > faulty.protection_level_m);
            if let Some(golden) = golden {
                cost.shift_m = cost.shift_m.max((faulty.place_m - golden.place_m).norm());
            }
        }
        cost
    }
}

/// Returns the middle of a frame.
fn middle(whole: &Plane<u16>) -> Plane<u16> {
    let (left, top) = ((whole.width() - SIZE.0) / 2, (whole.height() - SIZE.1) / 2);
    Plane::from_fn(SIZE.0, SIZE.1, |x, y| whole[(left + x, top + y)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use hoverlock_design::KT27;
    use hoverlock_fixed_point::model::fastest::FastestModel;
    use hoverlock_registers::record::{ERROR_UPSET, trailer};

    /// Packets of the bit-true model.
    fn packets(hover: &HoverFrames) -> Vec<Vec<u32>> {
        let mut model = FastestModel::new(&KT27).unwrap();
        let thresholds = model.settled(&hover.frames[0]);
        let packet = |(number, frame): (usize, &Plane<u16>)| {
            let features = model.features(frame, &thresholds);
            let unsent = message::Unsent::default();
            let bytes = message::encode_frame(number as u32, &features, 0, unsent, &thresholds);
            bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
        };
        hover.frames.iter().enumerate().map(packet).collect()
    }

    #[test]
    fn a_hover_is_estimated_and_a_marked_frame_is_not() {
        let hover = HoverFrames::new(&KT27, "field", 4, 1).unwrap();
        let packets = packets(&hover);
        let golden = hover.fixes(&packets);
        assert!(golden[0].is_none(), "the reference");
        for (fix, truth) in golden.iter().zip(&hover.truth).skip(1) {
            let fix = fix.unwrap();
            let miss = (fix.place_m - truth).norm();
            assert!(miss < 0.1 && miss < fix.protection_level_m, "{miss} m: {fix:?}");
        }
        assert_eq!(hover.cost(&golden, &golden), Cost::default());

        let marked = |frame: usize| {
            let mut packets = packets.clone();
            let trailer_at = packets[frame].len() - 8;
            trailer::ERRORS.put(&mut packets[frame][trailer_at..], ERROR_UPSET.into());
            hover.fixes(&packets)
        };
        let faulty = marked(2);
        assert!(faulty[2].is_none() && faulty[3].is_some());
        assert_eq!(hover.cost(&golden, &faulty).withheld, 1);
        // Without its first frame the program captures the second, and places are counted from there.
        let faulty = marked(0);
        let cost = hover.cost(&golden, &faulty);
        assert!(faulty[1].is_none() && cost.misleading == 0 && cost.shift_m < 0.1, "{cost:?}");

        let mut moved = golden.clone();
        moved[3].as_mut().unwrap().place_m.x += 5.0;
        let cost = hover.cost(&golden, &moved);
        assert!((cost.shift_m - 5.0).abs() < 1e-9 && cost.misleading == 1, "{cost:?}");
        assert!(hover.fixes(&[vec![0; 100_000], Vec::new()]).iter().all(Option::is_none));
    }
}
