//! The bit-true model of a design in the fastest code that its formats allow.

use hoverlock_reference::image::plane::Plane;

use crate::model::bit_true::BitTrue;
use crate::model::record::FeatureRecord;
use crate::model::simd::{SimdBitTrue, SimdError};
use crate::model::threshold::{Maxima, ThresholdController};
use hoverlock_design::DesignPoint;

/// The fastest model of a design: [`SimdBitTrue`] if it supports the formats, else [`BitTrue`]. Their bits are the
/// same.
pub struct FastestModel {
    design: DesignPoint,
    code: Code,
    maxima: Vec<Maxima>,
}

enum Code {
    Simd(Box<SimdBitTrue>),
    Clear(Box<BitTrue>),
}

impl FastestModel {
    /// Designs the coefficients of a design and makes its model.
    ///
    /// # Errors
    /// The coefficients cannot be designed.
    pub fn new(design: &DesignPoint) -> Result<Self, SimdError> {
        let code = match SimdBitTrue::new(design) {
            Ok(simd) => Code::Simd(Box::new(simd)),
            Err(SimdError::Formats { .. }) => Code::Clear(Box::new(BitTrue::new(design)?)),
            Err(error) => return Err(error),
        };
        Ok(Self { design: design.clone(), code, maxima: Vec::new() })
    }

    /// Returns the features of a frame, in order. `pixels` is in steps of the camera; see
    /// [`camera_samples`](crate::model::design::camera_samples).
    pub fn features(&mut self, pixels: &Plane<u16>, thresholds: &[u32]) -> Vec<FeatureRecord> {
        match &mut self.code {
            Code::Simd(simd) => {
                let features = simd.frame(pixels, thresholds).to_vec();
                self.maxima = simd.maxima().to_vec();
                features
            }
            Code::Clear(model) => {
                let planes = model.planes(pixels);
                self.maxima = planes.maxima();
                planes.features(thresholds)
            }
        }
    }

    /// Returns the maxima of each scale pair in the last frame, which the automatic threshold follows.
    pub fn maxima(&self) -> &[Maxima] {
        &self.maxima
    }

    /// Returns the thresholds, LSB of the DoG, at which the automatic control settles on a still picture. `pixels` is
    /// in steps of the camera.
    pub fn settled(&mut self, pixels: &Plane<u16>) -> Vec<u32> {
        let mut control = ThresholdController::new(&self.design);
        self.features(pixels, control.thresholds());
        control.settle(&self.maxima);
        control.thresholds().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A state of 20 bits is beyond the simd model; that of the default design is not.
    #[test]
    fn both_codes_give_the_bits_of_the_clear_model() {
        let frame = Plane::from_fn(150, 90, |x, y| ((x * x * 37 + y * 911 + x * y * 13) % 65_536) as u16);
        for change in ["state=u16.2", "state=u16.4"] {
            let design = DesignPoint::default().with_override(change).unwrap();
            let mut fastest = FastestModel::new(&design).unwrap();
            assert_eq!(matches!(fastest.code, Code::Simd(_)), change == "state=u16.2");
            let planes = BitTrue::new(&design).unwrap().planes(&frame);
            let mut control = ThresholdController::new(&design);
            control.settle(&planes.maxima());
            assert_eq!(fastest.settled(&frame), control.thresholds(), "{change}");
            let features = fastest.features(&frame, &[200, 200]);
            assert!(!features.is_empty() && features == planes.features(&[200, 200]), "{change}");
        }
    }
}
