//! Float features of one 1024x768 frame on one thread: the fast f32 path and the f64 reference.
//!
//! `HOVERLOCK_PICTURE` names a picture; without it the frame is a synthetic texture, so that the benchmark runs
//! anywhere.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use hoverlock_pictures::Picture;
use hoverlock_reference::features::dog::SIGMAS;
use hoverlock_reference::features::extractor::{Selection, extract};
use hoverlock_reference::features::fast::FastExtractor;
use hoverlock_reference::features::maxlbp::Ring;
use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::smoother::Smoother;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sums of random values on grids of 4, 16 and 64 px: detail at every scale the extractor looks at.
fn texture() -> Plane<u16> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut grid = |pitch: usize| Plane::from_fn(1024 / pitch, 768 / pitch, |_, _| random.random_range(0..20_000u16));
    let grids = [4, 16, 64].map(|pitch| (pitch, grid(pitch)));
    Plane::from_fn(1024, 768, |x, y| grids.iter().map(|(pitch, grid)| grid[(x / pitch, y / pitch)]).sum())
}

fn frame() -> Plane<u16> {
    match std::env::var_os("HOVERLOCK_PICTURE") {
        Some(path) => Picture::open(path).expect("HOVERLOCK_PICTURE names a picture").crop(1024, 768).luma,
        None => texture(),
    }
}

fn float_features(c: &mut Criterion) {
    let frame = frame();
    let selection = Selection::default();
    let mut extractor = FastExtractor::new(selection).expect("the default sigmas have poles");
    let features = extractor.extract(&frame).len();
    let mut group = c.benchmark_group(format!("float features, {features}"));
    group.bench_function("f32", |b| b.iter(|| extractor.extract(black_box(&frame))));
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    let clear = |plane: &Plane<f64>, sigma| Smoother::first_order(sigma).expect("a pole").smooth(plane, Border::Held);
    group.sample_size(20);
    group.bench_function("f64, clear", |b| {
        b.iter(|| one_thread.install(|| extract(black_box(&frame), &SIGMAS, &Ring::defaults(), clear, &selection)))
    });
    group.finish();
}

criterion_group!(benches, float_features);
criterion_main!(benches);
