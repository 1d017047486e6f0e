//! The claims about the numbers of a design, on a small design computed by hand and one that saturates.

use hoverlock_design::KT27;
use hoverlock_fixed_point::analysis::worst_case::{largest_difference, rounding};
use hoverlock_fixed_point::model::bit_true::BitTrue;
use hoverlock_formal::engine::{Solver, find_program};
use hoverlock_formal::prove::{Status, Task};
use hoverlock_formal::rounding::{Bounds, Design, Smoother, Subject, run};

/// Returns a design of two smoothers with one stage per direction and coefficients of four bits, small enough to
/// compute by hand.
fn design(dog_bits: u32) -> Design {
    let narrow = Smoother { g: 16, g_j: vec![16] };
    let wide = Smoother { g: 8, g_j: vec![8] };
    Design { smoothers: vec![narrow, wide], coefficient_bits: 4, full_scale: 1020, dog_shift: 1, dog_bits }
}

#[test]
fn bounds_are_those_of_the_equations() {
    let bounds = Bounds::of(&design(10));
    // Half an LSB a stage, and 1/2 and 1 LSB of the recursions behind the first.
    assert_eq!(bounds.stages[0], [500_000, 1_000_000, 1_500_000, 2_000_000]);
    assert_eq!(bounds.stages[1], [500_000, 1_500_000, 2_000_000, 2_500_000]);
    assert_eq!(bounds.dog, [2_750_000]);
    // The narrow smoother is the identity, so d is largest where the weight of the sample in the wide one is smallest:
    // away from the upper border, 1/2 of the 1/2 of its look-ahead and 1/4 of the 1/2 in the row above, and along the
    // row 1/2 * 1/2 twice.
    let column = 0.5 * 0.5 + 0.5 * 0.5 * 0.5;
    let row = 0.25 + 0.25;
    let expected = 1020.0 * (1.0 - column * row) + 4.5;
    let largest = bounds.largest[0] as f64 / 1e6;
    assert!(largest >= expected - 0.01 && largest < expected + 1.0, "{largest} {expected}");
}

#[test]
fn a_dog_with_too_few_bits_fails_and_leaves_its_queries() {
    if find_program("yices-smt2").is_none() {
        eprintln!("SKIPPED: no yices-smt2; `make test` installs it");
        return;
    }
    let out = tempfile::tempdir().unwrap();
    let outcome = |bits, subject, task| run(&design(bits), subject, task, Solver::default(), out.path()).unwrap();
    for task in [Task::Proof, Task::Cover] {
        let done = outcome(10, Subject::Rounding, task);
        assert!(done.pass && done.detail.is_empty(), "{done:?}");
    }
    assert_eq!(outcome(10, Subject::Saturation, Task::Proof).status, Status::Proved);
    let failed = outcome(8, Subject::Saturation, Task::Proof);
    assert_eq!((failed.status, failed.detail.as_str()), (Status::Failed, "bound exceeded: DoG 0"));
    let questions = std::fs::read_to_string(failed.trace.unwrap()).unwrap();
    assert!(questions.contains("QF_LRA") && questions.contains("; DoG 0"), "{questions}");
}

/// The reference goes from input to output in f64, the module from output to input in integers.
#[test]
fn bounds_of_the_default_design_are_those_derived_in_floating_point() {
    let model = BitTrue::new(&KT27).unwrap();
    let raw = model.coefficients();
    let smoothers = raw.iter().map(|of| Smoother { g: of.g, g_j: of.g_j.clone() }).collect();
    let full_scale = 65535 * 4;
    let bounds = Bounds::of(&Design { smoothers, coefficient_bits: 16, full_scale, dog_shift: 1, dog_bits: 15 });
    let values = raw.iter().map(|of| of.values(KT27.coefficient)).collect::<Vec<_>>();
    for (of, values) in bounds.stages.iter().zip(&values) {
        let (proved, derived) = (*of.last().unwrap() as f64 / 1e6, rounding(values));
        assert!(proved >= derived && proved < derived + 2e-6, "{proved} {derived}");
    }
    for k in 0..2 {
        let derived = largest_difference(&values[k], &values[k + 1]) * f64::from(full_scale)
            + rounding(&values[k])
            + rounding(&values[k + 1]);
        let proved = bounds.largest[k] as f64 / 1e6;
        // Outward rounding of weights to 2^-31 adds a few LSB at most, and cannot make the bound smaller.
        assert!(proved >= derived - 1e-3 && proved < derived + 4.0, "pair {k}: {proved} {derived}");
    }
}
