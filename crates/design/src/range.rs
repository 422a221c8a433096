//! The values that one parameter takes.

use std::str::FromStr;

use thiserror::Error;

/// The values that a parameter takes, as text: `1:10:50` are 50 evenly spread ones from 1 to 10, `1:10:50:log` the same in
/// equal ratios, and `1,2,5` those listed.
///
/// ```
/// use eigentone_design::Range;
///
/// let range: Range = "1:100:3:log".parse()?;
/// assert_eq!(range.values(), [1.0, 10.0, 100.0]);
/// # Ok::<(), eigentone_design::RangeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Range(Vec<f64>);

/// What is wrong with a range.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RangeError {
    /// It is none of the forms.
    #[error(
        "{text:?} is no range: write FROM:TO:COUNT, FROM:TO:COUNT:log, or values with commas between them, as 1,2.5"
    )]
    Form {
        /// The text.
        text: String,
    },
    /// A value is no finite number.
    #[error("{text:?} is not a finite number")]
    Number {
        /// Its text.
        text: String,
    },
    /// The count is no number of values.
    #[error("{text:?} is no count: it must be a whole number from 2 to {MOST}")]
    Count {
        /// Its text.
        text: String,
    },
    /// A logarithmic range through 0.
    #[error(
        "from {from:?} to {to:?} there are no equal ratios: give two numbers of one sign, neither of them 0"
    )]
    Ratios {
        /// The first value.
        from: f64,
        /// The last value.
        to: f64,
    },
    /// The difference of the ends is beyond the doubles.
    #[error("from {from:?} to {to:?} is farther than doubles reach: take \"log\", or nearer ends")]
    Far {
        /// The first value.
        from: f64,
        /// The last value.
        to: f64,
    },
}

/// The most values of one range.
const MOST: usize = 10_000_000;

impl Range {
    /// All values, the first and the last as they were given.
    pub fn values(&self) -> &[f64] {
        &self.0
    }
}

impl FromStr for Range {
    type Err = RangeError;

    fn from_str(text: &str) -> Result<Range, RangeError> {
        let parts: Vec<&str> = text.split(':').collect();
        let (ends, count, is_even) = match parts[..] {
            [list] => {
                let values: Result<Vec<f64>, RangeError> = list.split(',').map(number).collect();
                return values.map(Range);
            }
            [from, to, count] => ([from, to], count, true),
            [from, to, count, "log"] => ([from, to], count, false),
            _ => {
                let text = text.to_owned();
                return Err(RangeError::Form { text });
            }
        };
        let [from, to] = [number(ends[0])?, number(ends[1])?];
        let known = count.trim().parse().ok();
        let known: Option<usize> = known.filter(|count| (2..=MOST).contains(count));
        let count = known.ok_or_else(|| RangeError::Count {
            text: count.to_owned(),
        })?;
        if !is_even && (from == 0.0 || to == 0.0 || (from < 0.0) != (to < 0.0)) {
            return Err(RangeError::Ratios { from, to });
        }
        if is_even && !(to - from).is_finite() {
            return Err(RangeError::Far { from, to });
        }
        let at = |k: usize| {
            let share = k as f64 / (count - 1) as f64;
            match k {
                0 => from,
                k if k == count - 1 => to,
                _ if is_even => from + share * (to - from),
                // A quotient of the ends may leave the doubles where their logarithms do not.
                _ => {
                    let [low, high] = [from, to].map(|end| end.abs().log10());
                    10f64.powf(low + share * (high - low)).copysign(from)
                }
            }
        };
        Ok(Range((0..count).map(at).collect()))
    }
}

fn number(text: &str) -> Result<f64, RangeError> {
    let value = text.trim().parse().ok();
    let value = value.filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| RangeError::Number {
        text: text.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_those_given() {
        let range: Range = "0.1:0.7:7".parse().unwrap();
        assert_eq!((range.values()[0], range.values()[6]), (0.1, 0.7));
        let range: Range = "-1e300:-1e-300:601:log".parse().unwrap();
        assert_eq!(range.values().len(), 601);
        assert_eq!((range.values()[0], range.values()[600]), (-1e300, -1e-300));
        assert!(range.values().windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!("3, 1,2".parse::<Range>().unwrap().values(), [3.0, 1.0, 2.0]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        let error = |text: &str| text.parse::<Range>().unwrap_err();
        assert!(matches!(error(""), RangeError::Number { .. }));
        assert!(matches!(error("1:2"), RangeError::Form { .. }));
        assert!(matches!(error("1:2:3:lin"), RangeError::Form { .. }));
        assert!(matches!(error("1:nan:3"), RangeError::Number { .. }));
        assert!(matches!(error("1:2:1"), RangeError::Count { .. }));
        assert!(matches!(error("1:2:2.5"), RangeError::Count { .. }));
        assert!(matches!(error("-1:2:3:log"), RangeError::Ratios { .. }));
        assert!(matches!(error("-1e308:1e308:3"), RangeError::Far { .. }));
    }
}
