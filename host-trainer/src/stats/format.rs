//! Numbers as text for reports.

/// A number with `digits` significant digits; a power of ten only outside 1e−3 to 1e6, "–" if not finite.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return "–".into();
    }
    let power = value.abs().log10().floor() as i32;
    let text = if (-3..6).contains(&power) {
        format!("{value:.*}", (digits as i32 - 1 - power).max(0) as usize)
    } else {
        format!("{value:.*e}", digits.saturating_sub(1))
    };
    text.replace('-', "−")
}

/// A number with `digits` decimals and a typographic minus, never that of a negative zero.
pub fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.starts_with('-') && text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if is_zero { text[1..].to_owned() } else { text.replace('-', "−") }
}

/// A value and its 95 % interval as texts, both to two digits of the half-width; "–" for no finite interval.
pub fn with_interval(value: f64, interval95: Option<[f64; 2]>) -> (String, String) {
    let Some([low, high]) = interval95.filter(|i| i.iter().all(|v| v.is_finite())) else {
        return (significant(value, 4), "–".into());
    };
    let half = 0.5 * (high - low).abs();
    let most = [value, low, high].iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let spread = if half > 0.0 { (most / half).log10().floor() } else { 4.0 };
    let digits = (spread + 2.0).clamp(2.0, 7.0) as usize;
    (significant(value, digits), format!("{} to {}", significant(low, digits), significant(high, digits)))
}

/// A share in percent to one decimal, without a sign where it rounds to 0.
pub fn share(share: f64) -> String {
    let tenths = (1000.0 * share).round();
    format!("{:.1} %", if tenths == 0.0 { 0.0 } else { 0.1 * tenths })
}

/// A p-value as text, from `< 1e−30` up.
pub fn chance(p_value: f64) -> String {
    match p_value {
        // No noise model holds that far into its tail.
        p if p < 1e-30 => "< 1e−30".into(),
        p if p < 1e-4 => format!("{p:.0e}").replace('-', "−"),
        p if p < 0.01 => format!("{p:.4}"),
        p => significant(p, 2),
    }
}

/// A p-value as text with its relation: `p = 0.0002`, `p < 1e−30`.
pub fn by_chance(p_value: f64) -> String {
    let text = chance(p_value);
    if text.starts_with('<') { format!("p {text}") } else { format!("p = {text}") }
}

/// A text with its first letter as a capital.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_long_as_they_are_worth() {
        let got = [95.114, -3.2, 0.0, 1.234e8, 0.00012, 20.0].map(|v| significant(v, 3));
        assert_eq!(got, ["95.1", "−3.20", "0", "1.23e8", "1.20e−4", "20.0"]);
        assert_eq!(with_interval(20.391, Some([20.25, 20.55])), ("20.39".into(), "20.25 to 20.55".into()));
        assert_eq!([-0.04, -1.26, 0.0].map(|v| fixed(v, 1)), ["0.0", "−1.3", "0.0"]);
        assert_eq!([-0.0004, 0.0, 0.123].map(share), ["0.0 %", "0.0 %", "12.3 %"]);
        assert_eq!(with_interval(7.0, None), ("7.000".into(), "–".into()));
        assert_eq!(with_interval(7.0, Some([f64::NEG_INFINITY, 1.0])).1, "–");
        assert_eq!([by_chance(0.0002), by_chance(0.0)], ["p = 0.0002", "p < 1e−30"]);
        assert_eq!(["ölfilm", "", "a b"].map(capital), ["Ölfilm", "", "A b"]);
        assert_eq!([chance(0.0002), chance(1e-9), chance(1.0)], ["0.0002", "1e−9", "1.0"]);
    }
}
