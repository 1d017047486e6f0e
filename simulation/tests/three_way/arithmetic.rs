//! Cells that calculate: lerp, difference, maxima, comparisons, thresholds.

use hoverlock_design::KT27;
use hoverlock_fixed_point::model::lerp::lerp;
use hoverlock_fixed_point::model::threshold::ThresholdController;
use hoverlock_harness::model::SignalId;
use hoverlock_rtl::cells::{
    decision::Decision,
    difference::Difference,
    lerp::Lerp,
    maximum::{ColumnMaximum, Maximum, WindowMaximum},
    ring::RingComparator,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rust_hdl::prelude::*;

use super::*;

pub fn lerp_is_the_bit_true_lerp() {
    let mut past: Vec<(u32, u32)> = Vec::new();
    let mut coefficients = Vec::new();
    alike!(
        Lerp::default(),
        "lerp",
        4000,
        [advance, p, q, g],
        [y],
        |_: &mut Lerp, _, _: &mut ChaCha8Rng| {},
        |cell: &Lerp, _| {
            if cell.advance.val() {
                past.push((cell.p.val().to_u32(), cell.q.val().to_u32()));
                coefficients.push(cell.g.val().to_u32());
                if let [.., (p, q), _, _] = past[..] {
                    let g = coefficients[coefficients.len() - 2];
                    assert_eq!(cell.y.val().to_u32(), lerp(p, q, g, 16), "p {p} q {q} g {g}");
                }
            }
        }
    );
}

pub fn difference_rounds_half_up_keeps_the_sign_and_saturates() {
    let mut past: Vec<(i64, i64)> = Vec::new();
    alike!(
        Difference::default(),
        "difference",
        4000,
        [advance, narrow, wide],
        [magnitude, positive, saturated],
        |cell: &mut Difference, _, draw: &mut ChaCha8Rng| {
            // Half of the time close together, as responses are.
            if draw.random() {
                let near = cell.narrow.next.to_u64().saturating_add_signed(draw.random_range(-4..=4)).min(0x3ffff);
                cell.wide.next = near.into();
            }
        },
        |cell: &Difference, _| {
            if cell.advance.val() {
                past.push((cell.narrow.val().to_u64() as i64, cell.wide.val().to_u64() as i64));
                if let [.., (narrow, wide), _] = past[..] {
                    let rounded = ((narrow - wide).unsigned_abs() + 1) >> 1;
                    assert_eq!(cell.magnitude.val().to_u64(), rounded.min(0x7fff));
                    assert_eq!(cell.saturated.val(), rounded > 0x7fff);
                    assert_eq!(cell.positive.val(), narrow >= wide);
                }
            }
        }
    );
}

pub fn window_maxima_are_those_of_the_definition() {
    for (module, samples) in family("window_maximum_") {
        let mut past = Vec::new();
        alike!(
            WindowMaximum::new(samples),
            &module,
            1500,
            [advance, x],
            [y],
            |_: &mut WindowMaximum, _, _: &mut ChaCha8Rng| {},
            |cell: &WindowMaximum, _| {
                if cell.advance.val() {
                    past.push(cell.x.val().to_u64());
                    let late = WindowMaximum::steps(samples) as usize - 1;
                    if past.len() >= samples + late {
                        let window = &past[past.len() - samples - late..past.len() - late];
                        assert_eq!(Some(cell.y.val().to_u64()), window.iter().copied().max());
                    }
                }
            }
        );
    }
}

pub fn maxima_and_comparisons() {
    alike!(
        Maximum::default(),
        "maximum",
        1000,
        [advance, a, b],
        [y],
        |_: &mut Maximum, _, _: &mut ChaCha8Rng| {},
        |cell: &Maximum, _| {
            if cell.advance.val() {
                assert_eq!(cell.y.val().to_u64(), cell.a.val().to_u64().max(cell.b.val().to_u64()));
            }
        }
    );
    let mut past: Vec<Vec<u64>> = Vec::new();
    alike!(
        ColumnMaximum::default(),
        "column_maximum",
        2000,
        [advance, newest, older],
        [later, middle, earlier, five],
        |_: &mut ColumnMaximum, _, _: &mut ChaCha8Rng| {},
        |cell: &ColumnMaximum, _| {
            if cell.advance.val() {
                let older = cell.older.val();
                let rows = (0..6).map(|row| older.get_bits::<15>(16 * row).to_u64());
                past.push(std::iter::once(cell.newest.val().to_u64()).chain(rows).collect());
                if let [.., v, _, _] = &past[..] {
                    let max = |rows: &[u64]| rows.iter().copied().max();
                    assert_eq!(Some(cell.later.val().to_u64()), max(&v[..3]));
                    assert_eq!(cell.middle.val().to_u64(), v[3]);
                    assert_eq!(Some(cell.earlier.val().to_u64()), max(&v[4..]));
                    assert_eq!(Some(cell.five.val().to_u64()), max(&v[..5]));
                }
            }
        }
    );
    alike!(
        Decision::default(),
        "decision",
        4000,
        [reset, advance, eligible, p, strict, loose, threshold],
        [hit],
        |cell: &mut Decision, cycle, draw: &mut ChaCha8Rng| {
            resets!(cell, cycle, draw);
            let p = cell.p.next.to_u64();
            let mut near = |signal: &mut Bits<15>| {
                if draw.random() {
                    *signal = p.saturating_add_signed(draw.random_range(-1..=1)).min(0x7fff).into();
                }
            };
            near(&mut cell.strict.next);
            near(&mut cell.loose.next);
            near(&mut cell.threshold.next);
        },
        |cell: &Decision, _| {
            if cell.advance.val() && !cell.reset.val() {
                let p = cell.p.val().to_u64();
                let hit = p > cell.strict.val().to_u64()
                    && p >= cell.loose.val().to_u64()
                    && p >= cell.threshold.val().to_u64();
                assert_eq!(cell.hit.val(), hit && cell.eligible.val());
            }
        }
    );
    alike!(
        RingComparator::default(),
        "ring_comparator",
        400,
        [advance, centre, points],
        [maxlbp, sign],
        |_: &mut RingComparator, _, _: &mut ChaCha8Rng| {},
        |cell: &RingComparator, _| {
            if cell.advance.val() {
                for i in 0..32 {
                    let point = cell.points.val().get_bits::<16>(16 * i).to_u64();
                    assert_eq!(cell.maxlbp.val().get_bit(i), cell.centre.val().to_u64() >= point & 0x7fff);
                    assert_eq!(cell.sign.val().get_bit(i), point >> 15 == 1);
                }
            }
        }
    );
}

pub fn every_threshold_moves_as_the_model_says() {
    // One frame takes the manual threshold, the next follows a count: three, against a target that is far less, far
    // more, or met.
    if !is_driven("threshold") {
        return;
    }
    let mut model = instance();
    let ports = ["clock", "threshold__reset", "threshold__advance", "threshold__start", "threshold__hit"];
    let [clock, reset, advance, start, hit] = ports.map(|name| model.find(name).unwrap());
    let ports = ["threshold__follow", "threshold__manual", "threshold__target", "threshold__threshold"];
    let [follow, manual, target, threshold] = ports.map(|name| model.find(name).unwrap());
    let mut cycle = |inputs: &[(SignalId, u64)]| {
        inputs.iter().for_each(|(signal, value)| model.set(*signal, *value).unwrap());
        for level in [0, 1] {
            model.set(clock, level).unwrap();
            model.eval().unwrap();
        }
        model.get(threshold)
    };
    cycle(&[(reset, 1), (advance, 1), (start, 0), (hit, 0)]);
    cycle(&[(reset, 0)]);
    for t in 0..=0x7fffu64 {
        for wanted in [0, 4, 2, 1000] {
            assert_eq!(cycle(&[(start, 1), (hit, 0), (follow, 0), (manual, t)]), t.max(1));
            // The first that follows takes the manual one too.
            cycle(&[(follow, 1)]);
            (0..3).for_each(|_| _ = cycle(&[(start, 0), (hit, 1), (target, wanted)]));
            cycle(&[(hit, 0)]);
            let mut design = KT27.clone();
            (design.threshold.target, design.threshold.initial) = (wanted as u32, t.max(1) as u32);
            let mut control = ThresholdController::new(&design);
            control.finish_frame(&[3, 3]);
            assert_eq!(cycle(&[(start, 1)]), u64::from(control.thresholds()[0]), "from {t}, 3 features of {wanted}");
        }
    }
}
