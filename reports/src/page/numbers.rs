//! Numbers and names as the page prints them.

/// Replaces the ASCII minus sign, `inf` and `NaN` by their typographic forms. `-0.00` becomes `0.00`.
pub(super) fn typeset(text: String) -> String {
    match text.as_str() {
        "inf" => "∞".into(),
        "-inf" => "−∞".into(),
        "NaN" => "—".into(),
        _ => {
            let zero = text.starts_with('-') && !text.contains(|c: char| ('1'..='9').contains(&c));
            if zero { text.replace('-', "") } else { text.replace('-', "−") }
        }
    }
}

/// Formats `value` with `digits` significant digits and no exponent.
pub(super) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return typeset(format!("{value}"));
    }
    let lead = value.abs().log10().floor() as i32;
    let decimals = (digits as i32 - 1 - lead).max(0) as usize;
    typeset(format!("{value:.decimals$}"))
}

/// Formats decimal digits in groups of three, separated by thin spaces.
pub(super) fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Cuts a text to at most `length` characters; a longer text ends in an ellipsis.
pub(super) fn clipped(text: &str, length: usize) -> String {
    if text.chars().count() <= length { text.into() } else { text.chars().take(length - 1).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_typeset_for_print() {
        assert_eq!(significant(0.012345, 2), "0.012");
        assert_eq!(significant(-1234.5, 2), "−1234");
        assert_eq!(significant(f64::INFINITY, 2), "∞");
        assert_eq!(typeset("-0.00".into()), "0.00");
        assert_eq!(typeset(format!("{:.1}", f64::NAN)), "—");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(grouped(999), "999");
    }
}
