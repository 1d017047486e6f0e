//! Throughput of the SIMD bit-true model on one core: three smoothers, two DoG, maxima and descriptors, all planes
//! stored.
//!
//! The picture is 1024 x 768 of noise at several scales, with thresholds that give 512 features per
//! scale, the target of the automatic threshold. `cargo bench -p hoverlock-fixed-point` prints `thrpt` in elements
//! (pixels) per second.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use hoverlock_design::KT27;
use hoverlock_fixed_point::model::simd::SimdBitTrue;
use hoverlock_reference::features::maxima::nth_strongest;
use hoverlock_reference::features::maxlbp::Layer;
use hoverlock_reference::image::plane::Plane;

/// Noise at several scales: the sum of octaves of smoothed random lattices.
fn textured() -> Plane<u16> {
    let lattice = |x: i64, y: i64, octave: i64| {
        let mixed = (x + 4096 * y + 16_777_216 * octave).wrapping_mul(0x9E37_79B9_7F4A_7C15u64 as i64);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9u64 as i64);
        ((mixed >> 33) & 0xffff) as f64 / 65535.0
    };
    let octave = |x: usize, y: usize, octave: u32| {
        let step = f64::from(1u32 << octave);
        let (u, v) = (x as f64 / step, y as f64 / step);
        let (i, j) = (u.floor(), v.floor());
        let blend = |from: f64, to: f64, t: f64| from + (to - from) * t * t * (3.0 - 2.0 * t);
        let at = |di: i64, dj: i64| lattice(i as i64 + di, j as i64 + dj, i64::from(octave));
        blend(blend(at(0, 0), at(1, 0), u - i), blend(at(0, 1), at(1, 1), u - i), v - j)
    };
    Plane::from_fn(1024, 768, |x, y| {
        let sum: f64 = (1..7).map(|level| octave(x, y, level) * f64::from(1u32 << level)).sum();
        (10_000.0 + 300.0 * sum) as u16
    })
}

fn bit_true(criterion: &mut Criterion) {
    let picture = textured();
    let mut simd = SimdBitTrue::new(&KT27).expect("the simd model supports the design point");
    simd.frame(&picture, &[1; 2]);
    let strongest = |layer: &Layer<u16>| nth_strongest(&layer.dog.magnitude, 1, 512).expect("noise has many maxima");
    let thresholds = simd.planes().layers.iter().map(|layer| u32::from(strongest(layer))).collect::<Vec<_>>();
    let features = simd.frame(&picture, &thresholds).len();
    assert!(features >= 800, "only {features} features: the picture has too little texture");
    println!("{features} features in 1024 x 768 pixels");

    let mut group = criterion.benchmark_group("bit_true");
    group.throughput(Throughput::Elements(1024 * 768));
    group.bench_function("best instructions", |bencher| bencher.iter(|| simd.frame(&picture, &thresholds).len()));
    group.bench_function("portable", |bencher| bencher.iter(|| simd.portable_frame(&picture, &thresholds).len()));
    group.finish();
}

criterion_group!(benches, bit_true);
criterion_main!(benches);
