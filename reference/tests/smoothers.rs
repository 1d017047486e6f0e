//! Properties of every smoother: constants pass unchanged, the impulse response is symmetric and sums to
//! 1, smoothing is linear, and constant extension equals a long padding with the border sample.

use hoverlock_reference::image::plane::Plane;
use hoverlock_reference::smoothing::recursive::border::Border;
use hoverlock_reference::smoothing::recursive::{Family, Recursive};
use hoverlock_reference::smoothing::smoother::Smoother;
use proptest::prelude::*;

fn any_smoother() -> impl Strategy<Value = Smoother> {
    let recursive =
        (prop::sample::select(Family::all().collect::<Vec<_>>()), any::<prop::sample::Index>(), 0.5..12.0f64).prop_map(
            |(family, fit, sigma)| {
                Smoother::Recursive(Recursive::design(family, *fit.get(family.fits()), sigma).unwrap())
            },
        );
    prop_oneof![
        1 => (0.5..12.0f64).prop_map(|sigma| Smoother::gaussian(sigma).unwrap()),
        6 => recursive,
    ]
}

fn any_border() -> impl Strategy<Value = Border> {
    prop_oneof![Just(Border::Held), Just(Border::ConstantExtension)]
}

/// Sizes from 1x1 up, lines and columns of one sample, odd ones, most of them narrower than the reach.
fn any_plane() -> impl Strategy<Value = Plane<f64>> {
    (1..40usize, 1..40usize)
        .prop_flat_map(|(width, height)| (Just(width), prop::collection::vec(0.0..65535.0f64, width * height)))
        .prop_map(|(width, samples)| Plane::from_vec(width, samples.len() / width, samples).unwrap())
}

/// Returns the largest difference, DN.
fn distance(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
    a.as_slice().iter().zip(b.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Extends the plane with its border sample repeated `margin` times on every side.
fn padded(plane: &Plane<f64>, margin: usize) -> Plane<f64> {
    let clamp = |i: usize, n: usize| i.saturating_sub(margin).min(n - 1);
    Plane::from_fn(plane.width() + 2 * margin, plane.height() + 2 * margin, |x, y| {
        plane[(clamp(x, plane.width()), clamp(y, plane.height()))]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn constants_pass_to_the_last_bit(
        smoother in any_smoother(), border in any_border(), (w, h) in (1..40usize, 1..40usize),
        value in 0.0..65535.0f64,
    ) {
        let constant = Plane::filled(w, h, value);
        prop_assert_eq!(smoother.smooth(&constant, border), constant);
    }

    #[test]
    fn smoothing_is_linear(
        smoother in any_smoother(), border in any_border(), plane in any_plane(), k in -3.0..3.0f64,
    ) {
        let mirrored = Plane::from_fn(plane.width(), plane.height(), |x, y| {
            plane[(plane.width() - 1 - x, plane.height() - 1 - y)]
        });
        let of_sum = smoother.smooth(&plane.zip_map(&mirrored, |a, b| a + k * b), border);
        let sum_of = smoother.smooth(&plane, border).zip_map(&smoother.smooth(&mirrored, border), |a, b| a + k * b);
        // Values up to 4 x 65535, each rounded to 2^-53 of that about a hundred times: far below 1e-8.
        prop_assert!(distance(&of_sum, &sum_of) < 1e-8);
    }

    #[test]
    fn constant_extension_is_long_padding(smoother in any_smoother(), plane in any_plane()) {
        // Less than 2^-53 of the impulse response is beyond the reach: the far border has no effect for either rule.
        let margin = smoother.impulse_response().len();
        let wanted = smoother.smooth(&padded(&plane, margin), Border::Held)
            .crop(margin, margin, plane.width(), plane.height()).unwrap();
        let got = smoother.smooth(&plane, Border::ConstantExtension);
        prop_assert!(distance(&got, &wanted) <= 1e-12 * 65535.0, "{} DN", distance(&got, &wanted));
    }

    #[test]
    fn impulse_responses_are_symmetric_and_sum_to_one(smoother in any_smoother(), border in any_border()) {
        let half = smoother.impulse_response();
        let reach = half.len() - 1;
        let mut line = vec![0.0; 2 * reach + 1];
        line[reach] = 1.0;
        let response = smoother.smooth_line(&line, border);
        for n in 0..=reach {
            prop_assert!((response[reach - n] - response[reach + n]).abs() < 1e-14);
            prop_assert!((response[reach + n] - half[n]).abs() < 1e-15);
        }
        prop_assert!((smoother.residuals().dc_gain - 1.0).abs() < 1e-12);
    }

    #[test]
    fn frequency_response_is_that_of_the_impulse_response(
        smoother in any_smoother(), omega in 0.0..std::f64::consts::PI,
    ) {
        let half = smoother.impulse_response();
        let sum: f64 = half.iter().enumerate().skip(1).map(|(n, h)| 2.0 * h * (omega * n as f64).cos()).sum();
        prop_assert!((half[0] + sum - smoother.frequency_response(omega)).abs() < 1e-12);
    }

    #[test]
    fn rows_and_columns_are_treated_alike(smoother in any_smoother(), border in any_border(), plane in any_plane()) {
        // Columns first, then rows: the order changes only the rounding, because the filter is separable.
        let turned = smoother.smooth(&plane.transposed(), border).transposed();
        prop_assert!(distance(&smoother.smooth(&plane, border), &turned) < 1e-9);
    }
}

#[test]
fn a_held_border_repeats_the_input_of_each_pass() {
    // By hand for a = first-order pole: s = lerp towards x, started on x[0]; y the same from the right, started on
    // s[N-1].
    let smoother = Smoother::first_order(2.0).unwrap();
    let g = 1.0 - hoverlock_reference::smoothing::recursive::first_order::pole(2.0).unwrap();
    let x = [3.0, 100.0, 7.0, 50.0];
    let mut s = x;
    for n in 1..4 {
        s[n] = s[n - 1] + g * (x[n] - s[n - 1]);
    }
    let mut y = s;
    for n in (0..3).rev() {
        y[n] = y[n + 1] + g * (s[n] - y[n + 1]);
    }
    for (got, want) in smoother.smooth_line(&x, Border::Held).iter().zip(y) {
        assert!((got - want).abs() < 1e-12, "{got} {want}");
    }
    assert_ne!(smoother.smooth_line(&x, Border::ConstantExtension), smoother.smooth_line(&x, Border::Held));
}
