//! What is between the scene and the sensor: a cover, a cloud, a sudden light, glare, and drops on the front glass.
//!
//! ```text
//! cover, cloud, light   v <- transmission v + veil mean(v)
//! glare                 v <- v + strength mean(v) exp(-r^2 / 2 R^2)       light that the lens scatters
//! drop                  v <- v + a(r) (w - v)                             w mean of v inside, a from 1 to 0 at the rim
//! ```
//!
//! `r` is the distance from the spot's middle, `R` its radius, `mean(v)` that of the picture. A drop is so near that
//! the lens sees its light as one value.

use hoverlock_reference::image::plane::Plane;

/// Part of the radius over which the rim of a drop fades.
const RIM: f64 = 0.3;

/// What is between scene and sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstruction {
    /// Factor of the radiance of the scene: 0 for a covered lens, above 1 for a sudden light.
    pub transmission: f64,
    /// Uniform radiance that is added, relative to the mean of the scene: that of a cloud.
    pub veil: f64,
    /// Spots that stay where they are in the picture.
    pub spots: Vec<Spot>,
}

/// A spot that stays where it is in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Its middle, as parts of the columns and of the rows.
    pub at: [f64; 2],
    /// Its radius, as a part of the columns.
    pub radius: f64,
    /// Its effect.
    pub effect: Effect,
}

/// The effect of a spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    /// Adds light; in the middle this many times the mean of the picture.
    Glare(f64),
    /// Mixes the light inside.
    Drop,
}

impl Default for Obstruction {
    /// Returns a free view.
    fn default() -> Self {
        Self { transmission: 1.0, veil: 0.0, spots: Vec::new() }
    }
}

impl Obstruction {
    /// Applies the obstruction to the radiance of a picture.
    pub fn apply(&self, radiance: &mut Plane<f32>) {
        if self.transmission != 1.0 || self.veil != 0.0 {
            let (factor, added) = (self.transmission as f32, (self.veil * mean(radiance.as_slice())) as f32);
            radiance.as_mut_slice().iter_mut().for_each(|value| *value = factor * *value + added);
        }
        self.spots.iter().for_each(|spot| spot.apply(radiance));
    }
}

impl Spot {
    fn apply(&self, radiance: &mut Plane<f32>) {
        let (width, height) = (radiance.width(), radiance.height());
        let middle = [self.at[0] * (width as f64 - 1.0), self.at[1] * (height as f64 - 1.0)];
        let radius = (self.radius * width as f64).max(1.0);
        let distance = |x: usize, y: usize| (x as f64 - middle[0]).hypot(y as f64 - middle[1]) / radius;
        match self.effect {
            Effect::Glare(strength) => {
                let light = strength * mean(radiance.as_slice());
                for y in 0..height {
                    for (x, value) in radiance.row_mut(y).iter_mut().enumerate() {
                        *value += (light * libm::exp(-distance(x, y).powi(2) / 2.0)) as f32;
                    }
                }
            }
            Effect::Drop => {
                let (mut sum, mut count) = (0.0, 0.0f64);
                for y in 0..height {
                    let row = radiance.row(y).iter().enumerate();
                    for (_, value) in row.filter(|(x, _)| distance(*x, y) <= 1.0) {
                        (sum, count) = (sum + f64::from(*value), count + 1.0);
                    }
                }
                let inside = sum / count.max(1.0);
                for y in 0..height {
                    for (x, value) in radiance.row_mut(y).iter_mut().enumerate() {
                        let share = ((1.0 - distance(x, y)) / RIM).clamp(0.0, 1.0);
                        *value += (share * (inside - f64::from(*value))) as f32;
                    }
                }
            }
        }
    }
}

/// Returns the mean of samples.
pub(crate) fn mean(samples: &[f32]) -> f64 {
    samples.iter().map(|&value| f64::from(value)).sum::<f64>() / samples.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Plane<f32> {
        Plane::from_fn(100, 60, |x, _| x as f32)
    }

    #[test]
    fn a_drop_mixes_the_light_inside_and_leaves_the_rest() {
        let mut seen = ramp();
        let drop = Spot { at: [0.5, 0.5], radius: 0.1, effect: Effect::Drop };
        Obstruction { spots: vec![drop], ..Obstruction::default() }.apply(&mut seen);
        let row = seen.row(30);
        assert!((row[47] - row[52]).abs() < 0.01 && (row[50] - 49.5).abs() < 0.1, "{row:?}");
        assert_eq!((row[38], row[61]), (38.0, 61.0));
    }

    #[test]
    fn glare_adds_light_that_falls_off_from_its_middle() {
        let mut seen = Plane::filled(101, 61, 2.0f32);
        let glare = Spot { at: [0.5, 0.5], radius: 0.1, effect: Effect::Glare(3.0) };
        Obstruction { spots: vec![glare], ..Obstruction::default() }.apply(&mut seen);
        // At one radius, 10.1 px, exp(-1/2) is left.
        let expected = [8.0, 2.0 + 6.0 * libm::exp(-0.5 * (10.0 / 10.1f64).powi(2))];
        for (x, expected) in [50, 60].into_iter().zip(expected) {
            assert!((f64::from(seen.row(30)[x]) - expected).abs() < 1e-5, "{x}");
        }
    }

    #[test]
    fn a_free_view_changes_nothing_and_a_cloud_lowers_contrast() {
        let mut seen = ramp();
        Obstruction::default().apply(&mut seen);
        assert_eq!(seen, ramp());
        Obstruction { transmission: 0.25, veil: 0.75, ..Obstruction::default() }.apply(&mut seen);
        let row = seen.row(0);
        assert!((row[99] - row[0] - 24.75).abs() < 1e-4 && (mean(seen.as_slice()) - 49.5).abs() < 1e-4);
    }
}
