//! Parser of decimal numbers, correctly rounded.

/// Finite decimal number at `at`, and its end.
#[inline]
pub(super) fn number(bytes: &[u8], at: usize) -> Option<(f64, usize)> {
    // Powers of ten up to 10^22 and integers below 2^53 are exact in f64, so that one division
    // of them rounds correctly (Clinger 1990); 15 digits stay below both limits.
    const MAX_DIGITS: usize = 15;
    const POWERS: [f64; MAX_DIGITS + 1] =
        [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let negative = bytes.get(at) == Some(&b'-');
    let mut end = at + usize::from(negative);
    let mut mantissa = 0_u64;
    let mut digits = 0;
    let mut decimals = 0;
    let mut in_fraction = false;
    while let Some(&byte) = bytes.get(end) {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            digits += 1;
            decimals += usize::from(in_fraction);
        } else if byte == b'.' && !in_fraction {
            in_fraction = true;
        } else if matches!(byte, b'e' | b'E') {
            return long_number(bytes, at);
        } else {
            break;
        }
        end += 1;
    }
    if digits == 0 {
        return None;
    }
    if digits > MAX_DIGITS {
        return long_number(bytes, at);
    }
    let magnitude = mantissa as f64 / POWERS[decimals];
    Some((if negative { -magnitude } else { magnitude }, end))
}

fn long_number(bytes: &[u8], at: usize) -> Option<(f64, usize)> {
    let (value, length) = fast_float2::parse_partial::<f64, _>(&bytes[at..]).ok()?;
    value.is_finite().then_some((value, at + length))
}

/// Number of a whole field; NaN and infinities count as numbers.
pub(super) fn parse(field: &[u8]) -> Option<f64> {
    fast_float2::parse(field).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Invariant: the fast path rounds as the standard library does.
    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let mut state = 7_u64;
        let mut texts: Vec<String> =
            ["0", "-0", "1.", ".5", "-.5", "2.1254e+05", "1E-3", "5e-324"].map(String::from).to_vec();
        for digits in 1..20 {
            for point in 0..=digits {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(99);
                let number = format!("{:0>20}", state);
                let (whole, fraction) = number[..digits].split_at(point);
                texts.push(format!("-{whole}.{fraction}"));
            }
        }
        for text in texts {
            let (value, end) = number(format!("{text},").as_bytes(), 0).expect(&text);
            assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text}");
            assert_eq!(end, text.len(), "{text}");
        }
    }
}
