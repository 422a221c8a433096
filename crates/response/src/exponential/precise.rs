//! The exponential with as many digits as prove what is asked of it.

use eigentone_digits::{DoubleDouble, Magnitude, Real, Wide};

use crate::enclosed::{Normed, of_any_size, products};

/// An entry x·2^e, row by row.
pub(super) type Entry = (f64, i64);

/// What is asked of e^W.
pub(super) trait Judge {
    type Verdict;

    /// How large an entry below 2^-`least` would have to be to count.
    fn least(&self) -> f64;

    /// The answer from e^W = `power`·2^`exponent`, and whether more digits would change nothing; `None` where the error
    /// is too large for any answer.
    fn judge<T: Real>(&self, power: &Normed<T>, exponent: i64) -> Option<(Self::Verdict, bool)>;
}

/// The most that may be spent, in multiplications of doubles, or nearly as many nanoseconds.
pub(super) const LIMIT: f64 = 4e9;

/// So much may be spent on digits beyond those that suffice.
const SPARE: f64 = 2e7;

/// One number of digits.
struct Rung<J: Judge> {
    /// A multiplication and an addition, in those of doubles.
    cost: f64,
    products: fn(f64) -> f64,
    attempt: Attempt<J>,
}

type Attempt<J> = fn(usize, &[Entry], &J) -> Option<(<J as Judge>::Verdict, bool)>;

impl<J: Judge> Rung<J> {
    fn of<T: Real>(cost: f64) -> Rung<J> {
        Rung {
            cost,
            products: products::<T>,
            attempt: attempt::<T, J>,
        }
    }
}

/// The answer for W of order n, of whose powers at most `filled` entries differ from 0, from as few digits as give one, or a few more where they cost little; `None` where none is found
/// for `limit`, from which the work is taken.
pub(super) fn precisely<J: Judge>(
    n: usize,
    filled: usize,
    entries: &[Entry],
    judge: &J,
    limit: &mut f64,
) -> Option<J::Verdict> {
    let rungs: [Rung<J>; 6] = [
        Rung::of::<DoubleDouble>(8.0),
        Rung::of::<Wide<4>>(40.0),
        Rung::of::<Wide<8>>(100.0),
        Rung::of::<Wide<16>>(300.0),
        Rung::of::<Wide<32>>(1e3),
        Rung::of::<Wide<64>>(4e3),
    ];
    let nonzero = entries.iter().filter(|(value, _)| *value != 0.0);
    let sizes = nonzero.map(|(value, exponent)| value.abs().log2() + *exponent as f64);
    let size = sizes.fold(f64::NEG_INFINITY, f64::max) + (n as f64).log2();
    let (mut best, mut spent) = (None, 0.0);
    for rung in rungs {
        let work = rung.cost * n as f64 * filled as f64 * (rung.products)(size);
        spent += work;
        let affordable = match best {
            Some(_) => spent <= SPARE,
            None => work <= *limit,
        };
        if !affordable {
            break;
        }
        *limit -= work;
        if let Some((verdict, last)) = (rung.attempt)(n, entries, judge) {
            best = Some(verdict);
            if last {
                break;
            }
        }
    }
    best
}

fn attempt<T: Real, J: Judge>(
    n: usize,
    entries: &[Entry],
    judge: &J,
) -> Option<(J::Verdict, bool)> {
    let scaled = entries
        .iter()
        .map(|(value, exponent)| T::from(*value).scale(*exponent));
    let scaled: Vec<T> = scaled.collect();
    let mut pairs = scaled.iter().zip(entries);
    let exact = pairs.all(|(x, (value, exponent))| x.scale(-exponent) == T::from(*value));
    let underflow = match exact {
        true => Magnitude::ZERO,
        false => T::floor() * Magnitude::from(n as f64),
    };
    let w = Normed::new(n, n, scaled, underflow);
    let (power, exponent) = of_any_size(&w, judge.least())?;
    judge.judge(&power, exponent)
}
