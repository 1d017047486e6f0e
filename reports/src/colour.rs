//! The diverging colour map of signed errors: blue below zero, white at zero, red above.
//!
//! Lightness is symmetric about zero, so that magnitude stays readable in grey-scale print.

/// Red, green and blue, `0 ..= 255`.
pub type Rgb = [u8; 3];

/// Stops of the diverging map from -1 to 1, evenly spaced.
const DIVERGING: [Rgb; 9] = [
    [13, 47, 107],
    [36, 95, 168],
    [92, 151, 208],
    [172, 206, 233],
    [250, 250, 250],
    [246, 194, 168],
    [225, 122, 86],
    [183, 47, 41],
    [110, 10, 28],
];

/// Returns the colour of `value`. A value outside `[-1, 1]` takes the colour of the end; NaN and infinities are grey.
pub fn diverging(value: f64) -> Rgb {
    if !value.is_finite() {
        return [128, 128, 128];
    }
    let last = DIVERGING.len() - 1;
    let position = (value.clamp(-1.0, 1.0) + 1.0) / 2.0 * last as f64;
    let below = (position.floor() as usize).min(last - 1);
    let part = position - below as f64;
    let mix = |channel: usize| {
        let (a, b) = (f64::from(DIVERGING[below][channel]), f64::from(DIVERGING[below + 1][channel]));
        (a + part * (b - a)).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle_are_the_stops() {
        assert_eq!(diverging(-1.0), DIVERGING[0]);
        assert_eq!(diverging(0.0), DIVERGING[4]);
        assert_eq!(diverging(7.0), DIVERGING[8]);
        assert_eq!(diverging(f64::NAN), [128, 128, 128]);
    }

    #[test]
    fn lightness_falls_from_the_middle_to_both_ends() {
        let lightness = |value: f64| diverging(value).iter().map(|&c| u32::from(c)).sum::<u32>();
        for step in 0..20 {
            let (near, far) = (f64::from(step) / 20.0, f64::from(step + 1) / 20.0);
            assert!(lightness(near) >= lightness(far) && lightness(-near) >= lightness(-far), "at {near}");
        }
    }
}
