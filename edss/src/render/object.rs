//! The objects on the ground: convex solids (buildings, cars), balls of leaves (trees), and paint.
//!
//! A convex solid is the set `n_i . p <= c_i` over all faces; a ray is inside between the last entry and the first exit
//! of these half spaces (Kay and Kajiya 1986). For the balls see [`crown`](super::crown). Paint covers the part
//! `1/2 - d / w` of a pixel of width `w`, with `d` the signed distance to its edge, so that one sample per pixel is
//! enough.

// Lanes are counted, not iterated: only plain loops become vector instructions of the caller's instruction set.
#![allow(clippy::needless_range_loop)]

use nalgebra::{Vector2, Vector3};

use super::bundle::{FirstHits, Lanes, RAYS, Rays, Shadow, any_positive};
use super::crown::{BALLS_PER_CROWN, Crown};
use crate::scene::{Building, Car, Helipad, Roof, Tree, point};

/// An object on the ground.
pub struct Object {
    path: Path,
    /// Height of the centre of its bounding sphere over the ground, m.
    rise: f64,
    /// Radius of the bounding sphere, m.
    pub radius: f32,
    /// Shape relative to that centre, `Z` downwards, m.
    pub form: Form,
}

/// The position of an object over time.
enum Path {
    Still(Vector2<f64>),
    Drive { from: Vector2<f64>, along: Vector2<f64>, length: f64, speed: f64, start: f64 },
}

/// The shape of an object.
pub enum Form {
    /// Convex solids: buildings and cars.
    Solids(Vec<Solid>),
    /// Balls of leaves: a tree.
    Balls(Box<Crown>),
    /// Paint on the ground; later marks cover earlier ones.
    Paint(Vec<PaintMark>),
}

/// A convex solid with its bounding sphere.
pub struct Solid {
    faces: Vec<Face>,
    centre: Vector3<f32>,
    radius: f32,
    /// Corners of the bounding box.
    corners: [Vector3<f32>; 8],
    /// Faces prepared for rays to the sun, by [`Object::set_sun`].
    shade: Vec<SunFace>,
}

/// A face prepared for rays to the sun: one from `p` crosses it at the distance `offset - normal . p`.
#[derive(Debug, Clone, Copy)]
struct SunFace {
    normal: Vector3<f32>,
    offset: f32,
    side: Crossing,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Crossing {
    Enters,
    Leaves,
    /// The ray is parallel to the face; the distance is that of `p` inside the face.
    Along,
}

/// A face of a convex solid: inside is `normal . p <= offset`.
#[derive(Debug, Clone, Copy)]
pub struct Face {
    normal: Vector3<f32>,
    offset: f32,
    albedo: f32,
    /// Spacing of courses of tiles, m; 0 for a plain face.
    course: f32,
}

/// A albedo_with_paint mark on the ground.
#[derive(Debug, Clone, Copy)]
pub struct PaintMark {
    centre: Vector2<f32>,
    shape: Shape,
    albedo: f32,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    Ring { inner: f32, outer: f32 },
    Bar { along: Vector2<f32>, half: [f32; 2] },
}

/// The surface of an object at a point.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceAt {
    /// Outward normal.
    pub normal: Vector3<f32>,
    /// Part of the light that is reflected.
    pub albedo: f32,
    /// Spacing of courses of tiles, m; 0 for a plain face.
    pub course: f32,
    /// `true` for leaves.
    pub leaves: bool,
}

/// Most faces of a solid. A part of an object of solids is a face, numbered solid by solid.
const FACES_PER_SOLID: usize = 8;

/// Depth to which buildings continue into the ground, m, so that they have no gap on a slope.
const FOUNDATION_DEPTH_M: f32 = 4.0;

impl Object {
    /// Returns the centre at `time` (s), m; `ground` returns the height of the ground at a point.
    pub fn centre(&self, time: f64, ground: impl Fn(Vector2<f64>) -> f64) -> Vector3<f64> {
        let at = match &self.path {
            Path::Still(at) => *at,
            Path::Drive { from, along, length, speed, start } => {
                let way = start + speed * time;
                from + along * (way - length * (way / length).floor())
            }
        };
        at.push(-ground(at) - self.rise)
    }

    /// Returns `true` if the object has volume and casts a shadow.
    pub fn is_solid(&self) -> bool {
        !matches!(self.form, Form::Paint(_))
    }

    /// Records the parts that rays hit before what `hits` has, as `code` plus the number of the part. The rays begin at
    /// points relative to the centre, m.
    #[inline(always)]
    pub fn enter(&self, rays: &Rays, hits: &mut FirstHits, code: u32) {
        let mut limit = rays.limit_within(self.radius, &hits.along);
        if !any_positive(&limit) {
            return;
        }
        let mut record = |l, is_hit, along, part| hits.record(l, is_hit, along, code + part);
        match &self.form {
            Form::Solids(solids) => {
                for (k, solid) in solids.iter().enumerate() {
                    solid.enter(rays, &mut limit, |l, is_hit, along, face| {
                        record(l, is_hit, along, (FACES_PER_SOLID * k) as u32 + face);
                    });
                }
            }
            Form::Balls(crown) => crown.enter(rays, &mut limit, record),
            Form::Paint(_) => {}
        }
    }

    /// Returns the surface of a part at a point relative to the centre, m.
    pub fn surface(&self, part: u32, point: &Vector3<f32>) -> SurfaceAt {
        match &self.form {
            Form::Solids(solids) => {
                let Face { normal, albedo, course, .. } =
                    solids[part as usize / FACES_PER_SOLID].faces[part as usize % FACES_PER_SOLID];
                SurfaceAt { normal, albedo, course, leaves: false }
            }
            Form::Balls(crown) => {
                let ball = part as usize;
                // Neighbouring balls differ in brightness, or a crown would be one smooth dome.
                let albedo = 0.19 + 0.022 * (ball * 7 % 5) as f32;
                SurfaceAt { normal: crown.normal(ball, point), albedo, course: 0.0, leaves: true }
            }
            Form::Paint(_) => unreachable!("no ray hits paint"),
        }
    }

    /// Returns a bounding volume: the convex hull of spheres about points relative to the centre, with the radius given
    /// second, m.
    pub fn bounding_spheres(&self) -> (Vec<Vector3<f32>>, f32) {
        match &self.form {
            Form::Solids(solids) => (solids.iter().flat_map(|solid| solid.corners).collect(), 0.0),
            Form::Balls(_) | Form::Paint(_) => (vec![Vector3::zeros()], self.radius),
        }
    }

    /// Prepares the shadow of the object for a direction of the sun.
    pub fn set_sun(&mut self, to_sun: &Vector3<f32>) {
        if let Form::Solids(solids) = &mut self.form {
            solids.iter_mut().for_each(|solid| solid.set_sun(to_sun));
        }
    }

    /// Sets the limit of the rays to the sun that enter the object to minus infinity. The rays begin at points relative
    /// to the centre, m.
    #[inline(always)]
    pub fn shade(&self, rays: &Rays, shadow: Shadow, left: &mut Lanes) {
        let mut limit = rays.limit_within(self.radius, left);
        if !any_positive(&limit) {
            return;
        }
        match &self.form {
            Form::Solids(solids) => {
                for solid in solids {
                    solid.shade(rays, shadow, &limit, left);
                }
            }
            Form::Balls(crown) => crown.enter(rays, &mut limit, |l, enters, _, _| {
                left[l] = if enters { f32::NEG_INFINITY } else { left[l] };
            }),
            Form::Paint(_) => {}
        }
    }

    /// Returns `true` if the object never moves.
    pub fn is_static(&self) -> bool {
        match self.path {
            Path::Still(_) => true,
            Path::Drive { speed, .. } => speed == 0.0,
        }
    }

    /// Returns the albedo of ground of albedo `albedo` with the paint on it, at a point relative to the centre, for a
    /// pixel of `width` m.
    pub fn albedo_with_paint(&self, p: Vector2<f32>, width: f32, albedo: f32) -> f32 {
        let Form::Paint(marks) = &self.form else { return albedo };
        marks.iter().fold(albedo, |below, mark| {
            let cover = mark.cover(p - mark.centre, width);
            // Paint is thin: the grain of the ground shows through.
            let paint = mark.albedo * (0.75 + 0.6 * albedo);
            below + cover * (paint - below)
        })
    }

    /// Creates a building.
    pub fn building(building: &Building) -> Self {
        let (sin, cos) = libm::sincosf(building.yaw_deg.to_radians() as f32);
        let half = building.size_m.map(|side| side as f32 / 2.0);
        let height = building.height_m as f32;
        let tone = 0.5 + 0.5 * libm::sinf(1.7 * building.at_m[0] as f32 + 2.3 * building.at_m[1] as f32);
        let wall = 0.45 + 0.25 * tone;
        let (walls, top) = match building.roof {
            Roof::Flat => (height, 0.0),
            // Roofs of 35 degrees.
            Roof::Gable => {
                let top = (0.7 * half[1]).min(0.5 * height);
                (height - top, top)
            }
        };
        let rise = height / 2.0;
        let mut faces = prism(cos, sin, half, wall, rise + FOUNDATION_DEPTH_M);
        if top > 0.0 {
            let slope = top / half[1];
            let length = libm::hypotf(slope, 1.0);
            for side in [-1.0, 1.0f32] {
                // The roof falls from the ridge, at `height`, to the walls, along the second axis.
                let across = Vector3::new(-sin * side * slope, cos * side * slope, -1.0) / length;
                let albedo = 0.24 + 0.16 * tone;
                faces.push(Face { normal: across, offset: (height - rise) / length, albedo, course: 0.4 });
            }
        } else {
            faces.push(Face { normal: -Vector3::z(), offset: walls - rise, albedo: 0.30 + 0.40 * tone, course: 0.0 });
        }
        let root = Vector3::z() * (0.5 * FOUNDATION_DEPTH_M);
        let mut solids = vec![Solid::new(faces, [cos, sin], root, [half[0], half[1], rise + 0.5 * FOUNDATION_DEPTH_M])];
        if top == 0.0 && half[0] > 4.0 && half[1] > 4.0 {
            // A lift head and an air conditioner.
            for (k, size) in [1.6f32, 1.0].into_iter().enumerate() {
                let at = [0.45 * half[0] * (1.0 - 2.0 * k as f32), 0.3 * half[1]];
                let centre = Vector2::new(cos * at[0] - sin * at[1], sin * at[0] + cos * at[1]);
                solids.push(box_at(cos, sin, centre, [size, size], [walls - rise, walls - rise + 1.6], [0.5, 0.6]));
            }
        }
        let reach = libm::hypotf(libm::hypotf(half[0], half[1]), rise + FOUNDATION_DEPTH_M) + 1.7;
        Self::still(building.at_m, rise.into(), reach, Form::Solids(solids))
    }

    /// Creates a tree whose crown is a dozen balls, drawn from `seed`.
    pub fn tree(tree: &Tree, seed: u32) -> Self {
        let (radius, height) = (tree.radius_m as f32, tree.height_m as f32);
        let draw = |k: u32| super::noise::unit(k, 77, seed);
        let crown = radius.min(0.5 * height);
        let ball = |k: usize| {
            // The golden angle spreads them, each drawn a little away.
            let (drawn, k) = (4 * k as u32, k as f32);
            let (turn, out) = (2.4 * k + draw(drawn), (k / BALLS_PER_CROWN as f32).sqrt() * 0.66 * radius);
            let (sin, cos) = libm::sincosf(turn);
            let size = radius * (0.30 + 0.16 * draw(drawn + 1));
            let lift = 0.45 * crown * (1.0 - (out / radius).powi(2)) * (0.6 + 0.8 * draw(drawn + 2));
            (Vector3::new(cos * out, sin * out, -lift), size)
        };
        let balls = Box::new(Crown::new(std::array::from_fn(ball)));
        Self::still(tree.at_m, f64::from((height - crown).max(0.3 * height)), 1.25 * radius, Form::Balls(balls))
    }

    /// Creates a car; `start` is its position along its line at time 0, m.
    pub fn car(car: &Car, start: f64) -> Self {
        let (from, to) = (point(car.from_m), point(car.to_m));
        let length = (to - from).norm();
        let along = (to - from) / length;
        let (cos, sin) = (along.x as f32, along.y as f32);
        let tone = 0.5 + 0.5 * libm::sin(3.1 * car.from_m[0] + 1.9 * car.from_m[1] + 0.7 * start) as f32;
        let paint = if tone > 0.5 { 0.35 + 0.5 * tone } else { 0.06 + 0.3 * tone };
        let rise = 0.7;
        let back = Vector2::new(cos, sin) * -0.25;
        let solids = vec![
            box_at(cos, sin, Vector2::zeros(), [2.15, 0.88], [0.25 - rise, 0.85 - rise], [paint, paint]),
            // Windows around, roof above.
            box_at(cos, sin, back, [1.25, 0.76], [0.85 - rise, 1.25 - rise], [0.06, 0.06]),
            box_at(cos, sin, back, [0.85, 0.66], [1.25 - rise, 1.42 - rise], [paint, paint]),
        ];
        let path = Path::Drive { from, along, length, speed: car.speed_m_per_s, start };
        Self { path, rise: rise.into(), radius: 2.5, form: Form::Solids(solids) }
    }

    /// Creates a helipad: pavement, a white ring, and an H of half the diameter.
    pub fn helipad(pad: &Helipad) -> Self {
        let radius = pad.diameter_m as f32 / 2.0;
        let (sin, cos) = libm::sincosf(pad.heading_deg.to_radians() as f32);
        let (up, side) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let (pavement, white) = (0.20, 0.80);
        let ring = |inner: f32, outer: f32, albedo| PaintMark {
            centre: Vector2::zeros(),
            shape: Shape::Ring { inner, outer },
            albedo,
        };
        let bar = |centre: Vector2<f32>, half: [f32; 2]| PaintMark {
            centre: centre * radius,
            shape: Shape::Bar { along: up, half: half.map(|h| h * radius) },
            albedo: white,
        };
        let marks = vec![
            ring(-1.0, radius, pavement),
            ring(0.86 * radius, 0.94 * radius, white),
            bar(side * 0.27, [0.45, 0.07]),
            bar(side * -0.27, [0.45, 0.07]),
            bar(Vector2::zeros(), [0.07, 0.22]),
        ];
        Self::still(pad.at_m, 0.0, radius, Form::Paint(marks))
    }

    /// Creates a albedo_with_paint bar; `half` is its half length along `along` and its half width, m.
    pub fn bar(at: Vector2<f64>, along: Vector2<f32>, half: [f32; 2], albedo: f32) -> Self {
        let mark = PaintMark { centre: Vector2::zeros(), shape: Shape::Bar { along, half }, albedo };
        Self::still([at.x, at.y], 0.0, libm::hypotf(half[0], half[1]), Form::Paint(vec![mark]))
    }

    fn still(at: [f64; 2], rise: f64, radius: f32, form: Form) -> Self {
        Self { path: Path::Still(point(at)), rise, radius, form }
    }
}

/// Returns the four upright faces of a box, and its bottom `below` m under its centre.
fn prism(cos: f32, sin: f32, half: [f32; 2], albedo: f32, below: f32) -> Vec<Face> {
    let sides = [(cos, sin, half[0]), (-cos, -sin, half[0]), (-sin, cos, half[1]), (sin, -cos, half[1])];
    let side = |(x, y, offset)| Face { normal: Vector3::new(x, y, 0.0), offset, albedo, course: 0.0 };
    let mut faces: Vec<Face> = sides.into_iter().map(side).collect();
    faces.push(Face { normal: Vector3::z(), offset: below, albedo, course: 0.0 });
    faces
}

/// Creates a box about a point, between two heights over the centre, with the albedo of sides and top.
fn box_at(cos: f32, sin: f32, at: Vector2<f32>, half: [f32; 2], heights: [f32; 2], albedo: [f32; 2]) -> Solid {
    let mut faces = prism(cos, sin, half, albedo[0], -heights[0]);
    faces.push(Face { normal: -Vector3::z(), offset: heights[1], albedo: albedo[1], course: 0.0 });
    for face in &mut faces {
        face.offset += face.normal.dot(&at.push(0.0));
    }
    let centre = at.push(-0.5 * (heights[0] + heights[1]));
    Solid::new(faces, [cos, sin], centre, [half[0], half[1], 0.5 * (heights[1] - heights[0])])
}

impl Solid {
    /// Creates a solid that a box about `centre` bounds; `half` are half its sides along `(cos, sin)`, across it, and
    /// vertically.
    fn new(faces: Vec<Face>, [cos, sin]: [f32; 2], centre: Vector3<f32>, half: [f32; 3]) -> Self {
        let corner = |k: usize| {
            let side = |bit: usize| if k >> bit & 1 == 0 { half[bit] } else { -half[bit] };
            let (a, b) = (side(0), side(1));
            centre + Vector3::new(cos * a - sin * b, sin * a + cos * b, side(2))
        };
        let radius = Vector3::from(half).norm();
        Self { faces, centre, radius, corners: std::array::from_fn(corner), shade: Vec::new() }
    }

    /// Passes the face through which each ray enters before its limit to `record`: lane, whether it enters, distance in
    /// lengths of the direction, and index of the face. Limits become the distances.
    #[inline(always)]
    fn enter(&self, rays: &Rays, limit: &mut Lanes, mut record: impl FnMut(usize, bool, f32, u32)) {
        let mut last = rays.about(&self.centre).limit_within(self.radius, limit);
        if !any_positive(&last) {
            return;
        }
        let (mut first, mut through) = ([0f32; RAYS], [u32::MAX; RAYS]);
        for (k, face) in self.faces.iter().enumerate() {
            let (rate, inside) = (rays.direction.dot(&face.normal), rays.from.dot(&face.normal));
            for l in 0..RAYS {
                let room = face.offset - inside[l];
                let crossing = room / rate[l];
                let enters = rate[l] < 0.0 && crossing > first[l];
                first[l] = if enters { crossing } else { first[l] };
                through[l] = if enters { k as u32 } else { through[l] };
                let leaves = rate[l] > 0.0 && crossing < last[l];
                last[l] = if leaves { crossing } else { last[l] };
                let misses = rate[l] == 0.0 && room < 0.0;
                last[l] = if misses { f32::NEG_INFINITY } else { last[l] };
            }
        }
        for l in 0..RAYS {
            let enters = first[l] <= last[l] && through[l] != u32::MAX;
            limit[l] = if enters { first[l] } else { limit[l] };
            record(l, enters, first[l], through[l]);
        }
    }

    fn set_sun(&mut self, to_sun: &Vector3<f32>) {
        let shade = |face: &Face| {
            let rate = face.normal.dot(to_sun);
            if rate.abs() < 1e-6 {
                return SunFace { normal: face.normal, offset: face.offset, side: Crossing::Along };
            }
            let side = if rate < 0.0 { Crossing::Enters } else { Crossing::Leaves };
            SunFace { normal: face.normal / rate, offset: face.offset / rate, side }
        };
        self.shade = self.faces.iter().map(shade).collect();
    }

    /// Sets `left` of the rays to the sun that enter the solid to minus infinity, as far as `limit` lets them.
    #[inline(always)]
    fn shade(&self, rays: &Rays, shadow: Shadow, limit: &Lanes, left: &mut Lanes) {
        let mut last = rays.about(&self.centre).limit_within(self.radius, limit);
        if !any_positive(&last) {
            return;
        }
        let mut first = [0f32; RAYS];
        for shade in &self.shade {
            let inside = rays.from.dot(&shade.normal);
            for l in 0..RAYS {
                let crossing = shade.offset - inside[l];
                match shade.side {
                    Crossing::Enters => first[l] = if crossing > first[l] { crossing } else { first[l] },
                    Crossing::Leaves => last[l] = if crossing < last[l] { crossing } else { last[l] },
                    Crossing::Along => last[l] = if crossing < 0.0 { f32::NEG_INFINITY } else { last[l] },
                }
            }
        }
        for l in 0..RAYS {
            let outside = shadow == Shadow::OfGround || first[l] > 0.0;
            left[l] = if first[l] <= last[l] && outside { f32::NEG_INFINITY } else { left[l] };
        }
    }
}

impl PaintMark {
    /// Returns the part of a pixel of `width` m that the mark covers.
    #[inline]
    fn cover(&self, p: Vector2<f32>, width: f32) -> f32 {
        let part = |distance: f32| (0.5 - distance / width).clamp(0.0, 1.0);
        match self.shape {
            Shape::Ring { inner, outer } => {
                let r = p.norm();
                part(r - outer) * part(inner - r)
            }
            Shape::Bar { along, half } => {
                let (a, b) = (p.dot(&along).abs(), (along.x * p.y - along.y * p.x).abs());
                // The product of both directions keeps bars that are thinner than a pixel as bright as they are wide.
                let side = |v: f32, half: f32| part(v - half) - part(v + half);
                side(a, half[0]) * side(b, half[1])
            }
        }
    }
}
