//! Numbers for people: six significant digits, and what says "none".

/// What stands where there is no number.
pub(crate) const NONE: &str = "–";

/// Significant digits of a number in a table.
const DIGITS: i32 = 6;

/// Plain notation reaches from 10^−4 up to 10^6; beyond, powers of ten are written.
const PLAIN: std::ops::Range<i32> = -4..6;

/// Powers of ten that a column may span and still have the same decimals.
const SPREAD: i32 = 2;

/// A number with six significant digits, in plain notation where that is readable, as all tables have them.
pub fn significant(value: f64) -> String {
    digits(value, DIGITS)
}

/// A number given by a person, as short as it can be said.
pub(crate) fn short(value: f64) -> String {
    let text = if value == 0.0 || PLAIN.contains(&exponent(value, 17)) {
        format!("{value}")
    } else {
        format!("{value:e}")
    };
    text.replace('-', "−")
}

/// A number with three significant digits and its power of ten, for what spans many of them.
#[cfg(feature = "check")]
pub(crate) fn scientific(value: f64) -> String {
    if value.is_infinite() {
        return "∞".to_owned();
    }
    if value.is_nan() {
        return NONE.to_owned();
    }
    format!("{value:.2e}").replace('-', "−")
}

/// How many there are, and of what.
pub(crate) fn count(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A bound: two significant digits, never rounded below the number.
pub(crate) fn bound(value: f64) -> String {
    let mut up = value;
    while up.is_finite()
        && format!("{up:.1e}")
            .parse()
            .is_ok_and(|read: f64| read < value)
    {
        up *= 1.01;
    }
    digits(up, 2)
}

/// The numbers of one column: with the same decimals, enough for six digits of the smallest, where
/// the column does not span too much; else each by itself.
pub(crate) fn column(values: impl IntoIterator<Item = Option<f64>>) -> Vec<String> {
    let finite = values
        .into_iter()
        .map(|value| value.filter(|value| value.is_finite()));
    let values: Vec<Option<f64>> = finite.collect();
    let exponents = || {
        let present = values.iter().flatten().filter(|value| **value != 0.0);
        present.map(|value| exponent(*value, DIGITS))
    };
    let (Some(least), Some(most)) = (exponents().min(), exponents().max()) else {
        return values.into_iter().map(each).collect();
    };
    if !(PLAIN.contains(&least) && PLAIN.contains(&most) && most - least <= SPREAD) {
        return values.into_iter().map(each).collect();
    }
    let decimals = (DIGITS - 1 - least).max(0) as usize;
    let fixed = values.into_iter().map(|value| match value {
        Some(value) if value != 0.0 => format!("{value:.decimals$}").replace('-', "−"),
        other => each(other),
    });
    fixed.collect()
}

/// What stands for a number that is not distinguished from 0.
const NEARLY_ZERO: &str = "≈0";

/// A number with the digits, six at most, that it has when it may be off by `bound`.
pub(crate) fn known_digits(value: f64, bound: f64) -> String {
    if bound == 0.0 {
        return significant(value);
    }
    if value.abs() <= bound {
        return NEARLY_ZERO.to_owned();
    }
    digits(value, digit_count(value, bound))
}

/// How many digits stand of a number that is larger than what it may be off.
fn digit_count(value: f64, bound: f64) -> i32 {
    let known = (value.abs().log10() - bound.log10()).floor();
    known.clamp(1.0, f64::from(DIGITS)) as i32
}

/// The numbers of one column, each with how far it may be off.
pub(crate) fn known_column(values: impl IntoIterator<Item = Option<(f64, f64)>>) -> Vec<String> {
    let values: Vec<Option<(f64, f64)>> = values.into_iter().collect();
    let is_whole = |&(value, bound): &(f64, f64)| {
        bound == 0.0 || value.abs() > bound && digit_count(value, bound) == DIGITS
    };
    let whole = values.iter().map(|known| known.filter(is_whole));
    let cells = column(whole.map(|known| known.map(|(value, _)| value)));
    let shorter = |(known, cell): (Option<(f64, f64)>, String)| match known {
        Some((value, bound)) if !is_whole(&(value, bound)) => known_digits(value, bound),
        _ => cell,
    };
    values.into_iter().zip(cells).map(shorter).collect()
}

/// The size of a number of which no digit is known for sure: two digits, marked.
pub(crate) fn doubtful(value: f64) -> String {
    format!("{}?", digits(value, 2))
}

fn each(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.to_owned(), significant)
}

/// The power of ten of the leading digit once the number is rounded to `digits` digits.
fn exponent(value: f64, digits: i32) -> i32 {
    let text = format!("{value:.*e}", (digits - 1) as usize);
    let (_, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    exponent.parse().unwrap_or(0) // only a value that is not finite has none
}

/// A number with this many significant digits.
fn digits(value: f64, count: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let leading = exponent(value, count);
    let text = if PLAIN.contains(&leading) {
        format!("{value:.*}", (count - 1 - leading).max(0) as usize)
    } else {
        format!("{value:.*e}", (count - 1) as usize)
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_survive_in_any_range() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (0.220_067_391, "0.220067"),
            (-2.954_328_38, "−2.95433"),
            (0.000_123_456_7, "0.000123457"),
            (0.999_999_9, "1.00000"),
            (123_456.4, "123456"),
            (999_999.7, "1.00000e6"),
            (-1.5e-9, "−1.50000e−9"),
            (6.02e23, "6.02000e23"),
            (f64::INFINITY, NONE),
            (f64::NAN, NONE),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value), text, "{value:e}");
        }
    }

    #[test]
    fn a_column_has_one_number_of_decimals() {
        let values = [Some(-0.105_536_84), Some(-2.954_328_4), None, Some(0.0)];
        assert_eq!(column(values), ["−0.105537", "−2.954328", "–", "0"]);
        // Too wide a span for one number of decimals.
        assert_eq!(column([Some(1e-3), Some(5e4)]), ["0.00100000", "50000.0"]);
        assert_eq!(column([Some(1.5), Some(f64::NAN)]), ["1.50000", NONE]);
    }

    #[test]
    fn digits_end_where_the_bound_begins() {
        let cases = [
            (1.25, 0.0, "1.25000"),
            (1.25, 1e-9, "1.25000"),
            (1.25, 1e-3, "1.25"),
            (-1.25, 0.5, "−1"),
            (2.5e-27, 1e-20, "≈0"),
            (0.0, 1e-30, "≈0"),
            (0.0, 0.0, "0"),
            (-2.0004e11, 3e8, "−2.0e11"),
        ];
        for (value, bound, text) in cases {
            assert_eq!(known_digits(value, bound), text, "{value:e} ± {bound:e}");
        }
        let column = known_column([Some((0.123_456_7, 0.0)), Some((5.0, 0.2)), None]);
        assert_eq!(column, ["0.123457", "5", "–"]);
    }

    #[test]
    fn a_bound_is_never_rounded_below() {
        for value in [1.0, 1.04e-17, 1.05e-17, 9.99e-3, 3.333e200, 5e-324, 0.0] {
            let read: f64 = bound(value).replace('−', "-").parse().expect("a number");
            assert!(read >= value && read <= 1.11 * value, "{value:e} {read:e}");
        }
    }
}
