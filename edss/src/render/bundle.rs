//! Eight rays at once, one a lane: neighbouring pixels of a row, or the samples within a pixel. Objects are tested with
//! all of them in the same loops, which become vector instructions.
//!
//! A lane without a ray, or whose ray is decided, has a limit of minus infinity, which no hit undercuts: loops need no
//! masks.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use multiversion::multiversion;
use nalgebra::Vector3;

use super::object::Object;
use super::row::KNOT_SPACING;

/// Number of rays of a bundle.
pub const RAYS: usize = KNOT_SPACING;

/// A number of each ray.
pub type Lanes = [f32; RAYS];

/// A vector of each ray, an array per axis.
#[derive(Debug, Clone, Copy)]
pub struct Vectors {
    pub x: Lanes,
    pub y: Lanes,
    pub z: Lanes,
}

impl Vectors {
    /// Returns the same vector for all rays.
    #[inline(always)]
    pub fn all(vector: &Vector3<f32>) -> Self {
        Self { x: [vector.x; RAYS], y: [vector.y; RAYS], z: [vector.z; RAYS] }
    }

    /// Returns the vector of a ray.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vector3<f32> {
        Vector3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Sets the vector of a ray.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, vector: &Vector3<f32>) {
        (self.x[lane], self.y[lane], self.z[lane]) = (vector.x, vector.y, vector.z);
    }

    /// Returns the vectors with one subtracted from all.
    #[inline(always)]
    pub fn minus(&self, vector: &Vector3<f32>) -> Self {
        let mut moved = *self;
        for l in 0..RAYS {
            moved.x[l] -= vector.x;
            moved.y[l] -= vector.y;
            moved.z[l] -= vector.z;
        }
        moved
    }

    /// Returns the squared lengths.
    #[inline(always)]
    pub fn norm_squared(&self) -> Lanes {
        let mut squares = [0.0; RAYS];
        for l in 0..RAYS {
            squares[l] = self.x[l] * self.x[l] + self.y[l] * self.y[l] + self.z[l] * self.z[l];
        }
        squares
    }

    /// Returns the scalar products with one vector.
    #[inline(always)]
    pub fn dot(&self, vector: &Vector3<f32>) -> Lanes {
        let mut products = [0.0; RAYS];
        for l in 0..RAYS {
            products[l] = vector.x * self.x[l] + vector.y * self.y[l] + vector.z * self.z[l];
        }
        products
    }
}

/// Rays from points, in directions whose squared lengths are kept.
pub struct Rays {
    pub from: Vectors,
    pub direction: Vectors,
    pub square: Lanes,
}

impl Rays {
    /// Returns the rays from points in directions.
    #[inline(always)]
    pub fn new(from: Vectors, direction: Vectors) -> Self {
        Self { from, direction, square: direction.norm_squared() }
    }

    /// Returns the rays relative to a point.
    #[inline(always)]
    pub fn about(&self, origin: &Vector3<f32>) -> Self {
        Self { from: self.from.minus(origin), ..*self }
    }

    /// Returns `limit` where the line of a ray passes within `radius` of the origin, and minus infinity elsewhere.
    #[inline(always)]
    pub fn limit_within(&self, radius: f32, limit: &Lanes) -> Lanes {
        let (from, direction) = (&self.from, &self.direction);
        let mut within = [f32::NEG_INFINITY; RAYS];
        for l in 0..RAYS {
            // Squared distance of the line, times the squared length of the direction.
            let x = from.y[l] * direction.z[l] - from.z[l] * direction.y[l];
            let y = from.z[l] * direction.x[l] - from.x[l] * direction.z[l];
            let z = from.x[l] * direction.y[l] - from.y[l] * direction.x[l];
            let near = x * x + y * y + z * z <= radius * radius * self.square[l];
            within[l] = if near { limit[l] } else { f32::NEG_INFINITY };
        }
        within
    }
}

/// Returns `true` if the number of any ray is not negative. Signs are combined as integers, which the compiler may
/// reorder, unlike comparisons of floating-point numbers.
#[inline(always)]
pub fn any_positive(lanes: &Lanes) -> bool {
    let mut all = u32::MAX;
    for l in 0..RAYS {
        all &= lanes[l].to_bits();
    }
    all >> 31 == 0
}

/// An object at its place.
pub struct Placed<'a> {
    pub object: &'a Object,
    /// Centre relative to the origin of the rays, m.
    pub centre: Vector3<f32>,
}

/// The first surface on each ray, in progress.
pub struct FirstHits {
    /// Distance along the ray, in lengths of its direction; the limit of a ray that has not hit anything.
    pub along: Lanes,
    /// Code of the surface; 0 of a ray that has not hit anything.
    codes: [u32; RAYS],
}

/// Bits of a code that count the parts of an object; the others count the objects from 1 on.
const PART_BITS: u32 = 8;

impl FirstHits {
    /// Records the distance and the code of what a ray hits, if it `hits`.
    #[inline(always)]
    pub fn record(&mut self, lane: usize, hits: bool, along: f32, code: u32) {
        self.along[lane] = if hits { along } else { self.along[lane] };
        self.codes[lane] = if hits { code } else { self.codes[lane] };
    }

    /// Returns the object, by its place in the list, and its part that a ray hits; `None` if it hits nothing.
    #[inline(always)]
    pub fn surface(&self, lane: usize) -> Option<(usize, u32)> {
        let code = self.codes[lane];
        let object = (code >> PART_BITS).checked_sub(1)?;
        Some((object as usize, code & ((1 << PART_BITS) - 1)))
    }
}

/// Returns the first hit of each ray from the origin before the distance `limit`.
#[multiversion(targets("x86_64+avx2"))]
pub fn first_hits(objects: &[Placed<'_>], direction: &Vectors, limit: &Lanes) -> FirstHits {
    let mut hits = FirstHits { along: *limit, codes: [0; RAYS] };
    let rays = Rays::new(Vectors::all(&Vector3::zeros()), *direction);
    for (k, placed) in objects.iter().enumerate() {
        placed.object.enter(&rays.about(&placed.centre), &mut hits, (k as u32 + 1) << PART_BITS);
    }
    hits
}

/// Which surfaces a shadow is tested for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shadow {
    /// Surfaces of objects and of the ground: a point inside a solid or on its face is not shaded by it.
    OfSurface,
    /// Composed ground: a point inside a wall counts as dark, or smoothing would brighten the foot of the wall.
    OfGround,
}

/// Returns which of the points that are `open` are shaded by one of the objects.
#[multiversion(targets("x86_64+avx2"))]
pub fn shaded(
    objects: &[Placed<'_>],
    points: &Vectors,
    to_sun: &Vector3<f32>,
    shadow: Shadow,
    open: [bool; RAYS],
) -> [bool; RAYS] {
    let rays = Rays::new(*points, Vectors::all(to_sun));
    let mut left = [f32::NEG_INFINITY; RAYS];
    for l in 0..RAYS {
        left[l] = if open[l] { f32::INFINITY } else { f32::NEG_INFINITY };
    }
    for placed in objects {
        if !any_positive(&left) {
            break;
        }
        placed.object.shade(&rays.about(&placed.centre), shadow, &mut left);
    }
    let mut dark = open;
    for l in 0..RAYS {
        dark[l] &= left[l] == f32::NEG_INFINITY;
    }
    dark
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::scene::{Building, Roof, Tree};

    fn direction() -> impl Strategy<Value = Vector3<f32>> {
        (-0.5f32..0.5, -0.5f32..0.5).prop_map(|(x, y)| Vector3::new(x, y, 1.0))
    }

    proptest! {
        /// A ray hits and a point is shaded as if it were alone, and a hit is on the surface that it names.
        #[test]
        fn rays_do_not_know_of_each_other(
            directions in proptest::array::uniform8(direction()),
            height_m in 5.0f64..20.0,
            yaw_deg in 0.0f64..180.0,
            seed in any::<u32>(),
            sun in (-1.0f32..1.0, -1.0f32..1.0),
        ) {
            let to_sun = Vector3::new(sun.0, sun.1, -0.5).normalize();
            let roof = if seed & 1 == 0 { Roof::Flat } else { Roof::Gable };
            let mut building =
                Object::building(&Building { at_m: [0.0; 2], size_m: [14.0, 9.0], height_m, yaw_deg, roof });
            building.set_sun(&to_sun);
            let tree = Object::tree(&Tree { at_m: [0.0; 2], radius_m: 3.0, height_m: 9.0 }, seed);
            let placed = [
                Placed { object: &building, centre: Vector3::new(2.0, 0.0, 30.0) },
                Placed { object: &tree, centre: Vector3::new(-5.0, 1.0, 28.0) },
            ];
            let mut together = Vectors::all(&Vector3::z());
            directions.iter().enumerate().for_each(|(lane, direction)| together.set(lane, direction));
            let hits = first_hits(&placed, &together, &[35.0; RAYS]);
            let mut points = together;
            for lane in 0..RAYS {
                let alone = first_hits(&placed, &Vectors::all(&directions[lane]), &[35.0; RAYS]);
                prop_assert_eq!(hits.along[lane].to_bits(), alone.along[0].to_bits());
                prop_assert_eq!(hits.surface(lane), alone.surface(0));
                let point = directions[lane] * hits.along[lane];
                points.set(lane, &point);
                if let Some((index, part)) = hits.surface(lane) {
                    let normal = placed[index].object.surface(part, &(point - placed[index].centre)).normal;
                    prop_assert!((normal.norm() - 1.0).abs() < 1e-3 && normal.dot(&directions[lane]) < 1e-3);
                }
            }
            let open = std::array::from_fn(|lane| lane != 3);
            let dark = shaded(&placed, &points, &to_sun, Shadow::OfSurface, open);
            prop_assert!(!dark[3]);
            for lane in (0..RAYS).filter(|&lane| open[lane]) {
                let alone = shaded(&placed, &Vectors::all(&points.get(lane)), &to_sun, Shadow::OfSurface, [true; RAYS]);
                prop_assert_eq!(dark[lane], alone[0]);
            }
        }
    }
}
