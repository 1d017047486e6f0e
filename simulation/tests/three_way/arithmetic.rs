//! Cells that calculate: lerp, difference, maxima, comparisons, thresholds.

use hoverlock_design::KT27;
use hoverlock_design::pipeline::{LERP_STEPS, window_maximum_steps};
use hoverlock_fixed_point::model::lerp::lerp;
use hoverlock_fixed_point::model::threshold::{Maxima, ThresholdController};
use hoverlock_harness::model::SignalId;
use hoverlock_rtl::cells::{
    decision::Decision,
    difference::Difference,
    lerp::Lerp,
    maximum::{ColumnMaximum, Maximum, WindowMaximum},
    ring::RingComparator,
};
use rand::{RngExt, SeedableRng};
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
                if let Some(operands) = past.len().checked_sub(LERP_STEPS as usize) {
                    let ((p, q), g) = (past[operands], coefficients[operands + 1]);
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
    for (module, numbers) in family("window_maximum") {
        let samples = numbers[1];
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
                    let late = window_maximum_steps(samples as u64) as usize - 1;
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
        [maximum, hit],
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
                let maximum = cell.eligible.val() && p > cell.strict.val().to_u64() && p >= cell.loose.val().to_u64();
                assert_eq!(cell.maximum.val(), maximum);
                assert_eq!(cell.hit.val(), maximum && p >= cell.threshold.val().to_u64());
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

/// Steps from the entry of a frame to its threshold, as few as the cell allows.
const SETTLING_STEPS: usize = 86;

/// The cell `threshold` alone, driven frame by frame.
struct ThresholdBench {
    model: Model,
    clock: SignalId,
    /// Reset, advance, enters, start, maximum, hit, centre, follow, manual, target.
    inputs: [SignalId; 10],
    threshold: SignalId,
}

impl ThresholdBench {
    fn new() -> Self {
        let model = instance();
        let find = |name: &str| model.find(&format!("threshold__{name}")).unwrap();
        let inputs =
            ["reset", "advance", "enters", "start", "maximum", "hit", "centre", "follow", "manual", "target"].map(find);
        let (clock, threshold) = (model.find("clock").unwrap(), find("threshold"));
        let mut bench = Self { model, clock, inputs, threshold };
        bench.cycle(&[(0, 1), (1, 1), (2, 0), (3, 0), (4, 0), (5, 0)]);
        bench.cycle(&[(0, 0), (2, 1)]);
        bench.cycle(&[(2, 0)]);
        (0..SETTLING_STEPS).for_each(|_| _ = bench.cycle(&[]));
        bench
    }

    /// Sets inputs by their number, and returns the threshold after one clock.
    fn cycle(&mut self, inputs: &[(usize, u64)]) -> u64 {
        inputs.iter().for_each(|(input, value)| self.model.set(self.inputs[*input], *value).unwrap());
        for level in [0, 1] {
            self.model.set(self.clock, level).unwrap();
            self.model.eval().unwrap();
        }
        self.model.get(self.threshold)
    }

    /// Returns the threshold after a frame with the threshold `t` and these maxima, for a target.
    fn followed(&mut self, t: u64, target: u64, maxima: &[u16], spacing: usize) -> u64 {
        assert_eq!(self.cycle(&[(3, 1), (7, 0), (8, t), (9, target)]), t.max(1));
        // The first that follows takes the manual one too.
        assert_eq!(self.cycle(&[(7, 1)]), t.max(1));
        self.cycle(&[(3, 0)]);
        for response in maxima {
            self.cycle(&[(4, 1), (5, (u64::from(*response) >= t).into()), (6, (*response).into())]);
            self.cycle(&[(4, 0), (5, 0)]);
            (2..spacing).for_each(|_| _ = self.cycle(&[]));
        }
        (0..3).for_each(|_| _ = self.cycle(&[]));
        self.cycle(&[(2, 1)]);
        self.cycle(&[(2, 0)]);
        (2..SETTLING_STEPS).for_each(|_| _ = self.cycle(&[]));
        let threshold = self.cycle(&[(3, 1)]);
        self.cycle(&[(3, 0)]);
        threshold
    }

    fn check(&mut self, t: u64, target: u64, maxima: Vec<u16>, spacing: usize) {
        let actual = self.followed(t, target, &maxima, spacing);
        let mut design = KT27.clone();
        design.threshold.target = target as u32;
        let mut control = ThresholdController::resumed(&design, &[t.max(1) as u32]);
        let count = maxima.len();
        control.finish_frame(&[Maxima::new(maxima)]);
        assert_eq!(actual, u64::from(control.thresholds()[0]), "from {t}, {count} maxima, target {target}");
    }
}

pub fn every_threshold_moves_as_the_model_says() {
    if !is_driven("threshold") {
        return;
    }
    let mut bench = ThresholdBench::new();
    // Every response alone is in its bin: a target of one puts the threshold at its edge.
    for response in 1..=0x7fffu16 {
        bench.check(1, 1, vec![response; 2], 3);
    }
    let mut draw = ChaCha8Rng::seed_from_u64(26);
    let any = |draw: &mut ChaCha8Rng, bits: u32| (draw.random_range(1..=1u32 << bits) - 1).clamp(1, 0x7fff) as u16;
    for _ in 0..3000 {
        let bits = draw.random_range(1..=15);
        let (count, near) = (draw.random_range(0..150), draw.random_range(0..=bits));
        let centre = any(&mut draw, bits);
        let maxima: Vec<u16> = (0..count)
            .map(|_| if draw.random() { any(&mut draw, bits) } else { (centre + any(&mut draw, near) - 1).min(0x7fff) })
            .collect();
        let bits = draw.random_range(1..=15);
        let t = if draw.random() { any(&mut draw, bits) } else { *maxima.first().unwrap_or(&1) };
        let reached = maxima.iter().filter(|response| **response >= t).count() as u64;
        // In the band, at its edges, anywhere, far beyond.
        let target = match draw.random_range(0..5) {
            0 => (8 * reached / 7 + draw.random_range(0..3)).saturating_sub(1),
            1 => (8 * reached / 9 + draw.random_range(0..3)).saturating_sub(1),
            2 | 3 => draw.random_range(0..=count + count / 8),
            _ => draw.random_range(0..=8 * count + 9),
        };
        let spacing = draw.random_range(3..=5);
        bench.check(t.into(), target, maxima, spacing);
    }
    // A bin counts to 65535: a surplus of 5535 of 65535, where 65540 maxima would be one of 5540.
    bench.check(1, 60_000, vec![1100; 65_540], 3);
    bench.check(1, 49_000, vec![1100; 65_540], 3);
    bench.check(1, 0xffff, vec![1100; 65_540], 3);
}
