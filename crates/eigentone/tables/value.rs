//! A number whose printed digits are all right.

use std::fmt;

use eigentone_check::Ball;

/// The significant digits of every number in a table.
pub const DIGITS: usize = 15;

/// Plain notation reaches from 10^−4 up to 10^14; beyond, the power of ten is written.
const PLAIN: std::ops::Range<i64> = -4..DIGITS as i64;

/// A number rounded once, to nearest, to [`DIGITS`] significant decimal digits, from an enclosure that
/// leaves no other rounding. It prints with all of them: `0.125000000000000`, `-1.00000000000000e-7`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Value(Kind);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Kind {
    /// 0, proved.
    Zero,
    /// 1, by the convention that scales it.
    One,
    /// Digits without their point, and the power of ten of the first.
    Decimal {
        negative: bool,
        digits: String,
        exponent: i64,
    },
    /// Of no greater size than this power of ten, and not distinguished from 0.
    Below(i64),
}

impl Value {
    pub(super) const ZERO: Value = Value(Kind::Zero);
    pub(super) const ONE: Value = Value(Kind::One);

    /// The rounding that `ball` decides, if it does.
    pub(super) fn decided(ball: &Ball) -> Option<Value> {
        if ball.is_exactly_zero() {
            return Some(Value(Kind::Zero));
        }
        let text = ball.decided(DIGITS)?;
        let (mantissa, exponent) = text.split_once('e')?;
        Some(Value(Kind::Decimal {
            negative: mantissa.starts_with('-'),
            digits: mantissa.chars().filter(char::is_ascii_digit).collect(),
            exponent: exponent.parse().ok()?,
        }))
    }

    /// What is left to say of a number that cannot be distinguished from 0.
    pub(super) fn below(ball: &Ball) -> Option<Value> {
        let close = ball.may_be_zero().then(|| ball.ceiling()).flatten();
        close.map(|power| Value(Kind::Below(power)))
    }

    /// Whether it is 0 without doubt.
    pub fn is_zero(&self) -> bool {
        self.0 == Kind::Zero
    }

    /// Whether it is less than 0.
    pub fn is_negative(&self) -> bool {
        matches!(self.0, Kind::Decimal { negative: true, .. })
    }

    /// Whether it is given by a bound of its size only, for it cannot be distinguished from 0; it prints as
    /// `<1e-60`.
    pub fn is_open(&self) -> bool {
        matches!(self.0, Kind::Below(_))
    }

    /// The double nearest to what is printed; 0 where only a bound is known.
    pub fn to_f64(&self) -> f64 {
        match self.0 {
            Kind::Zero | Kind::Below(_) => 0.0,
            _ => self.to_string().parse().unwrap_or(f64::NAN),
        }
    }

    /// The same without zeros at its end, for numbers that people chose.
    pub(super) fn trimmed(&self) -> String {
        let text = self.to_string();
        match text.split_once('e') {
            Some((mantissa, exponent)) => format!("{}e{exponent}", trim(mantissa)),
            None => trim(&text).to_owned(),
        }
    }

    /// As LaTeX in mathematical mode.
    pub(super) fn latex(&self) -> String {
        match &self.0 {
            Kind::Below(power) => format!("$<10^{{{power}}}$"),
            _ => match self.to_string().split_once('e') {
                Some((mantissa, exponent)) => format!("${mantissa}\\cdot 10^{{{exponent}}}$"),
                None => format!("${self}$"),
            },
        }
    }

    /// As JSON: a number, or `{"below": 1e-60}`.
    pub(super) fn json(&self) -> String {
        match &self.0 {
            Kind::Below(power) => format!("{{\"below\":1e{power}}}"),
            _ => self.to_string(),
        }
    }
}

fn trim(text: &str) -> &str {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (negative, digits, exponent) = match &self.0 {
            Kind::Zero => return f.write_str("0"),
            Kind::One => return f.write_str("1"),
            Kind::Below(power) => return write!(f, "<1e{power}"),
            Kind::Decimal {
                negative,
                digits,
                exponent,
            } => (*negative, digits.as_str(), *exponent),
        };
        let sign = if negative { "-" } else { "" };
        if !PLAIN.contains(&exponent) {
            let (first, rest) = digits.split_at(1);
            return write!(f, "{sign}{first}.{rest}e{exponent}");
        }
        match usize::try_from(exponent) {
            Err(_) => {
                let zeros = "0".repeat((-exponent - 1) as usize);
                write!(f, "{sign}0.{zeros}{digits}")
            }
            Ok(exponent) => match digits.split_at(exponent + 1) {
                (whole, "") => write!(f, "{sign}{whole}"),
                (whole, fraction) => write!(f, "{sign}{whole}.{fraction}"),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(negative: bool, digits: &str, exponent: i64) -> Value {
        Value(Kind::Decimal {
            negative,
            digits: digits.to_owned(),
            exponent,
        })
    }

    #[test]
    fn all_digits_are_written_whatever_the_size() {
        let digits = "123456789012345";
        let cases = [
            (0, "1.23456789012345"),
            (5, "123456.789012345"),
            (14, "123456789012345"),
            (15, "1.23456789012345e15"),
            (-1, "0.123456789012345"),
            (-4, "0.000123456789012345"),
            (-5, "1.23456789012345e-5"),
        ];
        for (exponent, text) in cases {
            let found = value(false, digits, exponent);
            assert_eq!(found.to_string(), text);
            assert_eq!(
                value(true, digits, exponent).to_string(),
                format!("-{text}")
            );
            assert_eq!(found.to_f64(), text.parse::<f64>().expect("a number"));
        }
    }

    #[test]
    fn other_forms_have_the_same_digits() {
        let number = value(true, "250000000000000", -7);
        assert_eq!(number.latex(), "$-2.50000000000000\\cdot 10^{-7}$");
        assert_eq!(number.trimmed(), "-2.5e-7");
        assert_eq!(value(false, "300000000000000", 1).trimmed(), "30");
        assert_eq!(
            value(false, "100000000000000", 14).trimmed(),
            "100000000000000"
        );
        let open = Value(Kind::Below(-60));
        assert_eq!(
            (open.to_string(), open.json()),
            ("<1e-60".to_owned(), "{\"below\":1e-60}".to_owned())
        );
        assert!(open.is_open() && !open.is_zero());
    }
}
