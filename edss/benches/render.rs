//! Time to render a frame of 1024 x 768 of each scene from 100 m, 50 degrees wide, on one thread.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use hoverlock_edss::pose::Pose;
use hoverlock_edss::render::{Lens, Renderer, Shot};
use hoverlock_edss::scene::Scene;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::motion::orthophoto::{Attitude, Camera};
use nalgebra::Vector3;

fn benchmark(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let camera = Camera::with_field_of_view(1024, 768, 50f64.to_radians()).expect("a camera");
    let attitude = Attitude { roll: 0.05, pitch: -0.03, yaw: 0.3 };
    let pose = Pose { position: Vector3::new(3.0, -2.0, -100.0), attitude };
    let shot = Shot { lens: Lens { camera, k1: 0.0, k2: 0.0 }, first: pose, last: pose, time: 1.0 };
    let mut frame = Plane::filled(1024, 768, 0f32);
    for name in Scene::NAMES {
        let text = Scene::named(name).expect("a scene that comes with the simulator");
        let scene = match Scene::parse(text, Path::new("")) {
            Ok(scene) => scene,
            Err(error) => {
                eprintln!("skipped: scene {name} {error}");
                continue;
            }
        };
        let renderer = Renderer::new(&scene, 1).expect("a sound scene");
        criterion.bench_function(&format!("{name} at 100 m"), |bencher| {
            bencher.iter(|| pool.install(|| renderer.render(black_box(&shot), &mut frame)));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = benchmark
}
criterion_main!(benches);
