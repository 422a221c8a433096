//! Sums of amplitudes at one frequency, with proven bounds and as many digits as these take.

use eigentone_digits::{Ball, DoubleDouble, Magnitude, Real, Wide, WideComplex, decimal_digits};
use num_complex::Complex;

use super::dynamic_stiffness::{Block, Frequency};
use super::elimination::{Factor, Outcome, scaled};
use super::function::FrequencyMethod;
use super::inverse::Inverse;
use super::modal_functions::ModalFunctions;
use super::modal_sum::{Matrices, ModalSum};
use super::ports::{Push, Reading};
use super::refinement::ApproximateInverse;

/// All that acts at a frequency, on one block, and what is asked of it.
pub(super) struct Question<'a> {
    pub(super) block: &'a Block,
    /// What is tried first, if there is one.
    pub(super) modes: Option<&'a ModalSum>,
    /// For each right-hand side what modes make of its readings, which is tried before; or nothing.
    pub(super) modal: &'a [ModalFunctions<'a>],
    pub(super) frequency: Frequency,
    /// For each right-hand side what acts, and the readings.
    pub(super) columns: &'a [(&'a [Push], &'a [Reading])],
    pub(super) asked: Asked,
}

/// What is asked of each reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Asked {
    /// The value to the last digit.
    Value,
    /// The same, and the steepness with its sign.
    Steepness,
    /// No more than the sign of the steepness.
    Sign,
}

/// A value, and how far it may be off.
#[derive(Clone, Copy, Debug)]
pub(super) struct Value {
    pub(super) value: Complex<f64>,
    pub(super) bound: f64,
    /// d ln|value| / dΩ, and how far that may be off; `None` where it is not asked for, or the value may be 0.
    pub(super) steepness: Option<(f64, f64)>,
}

/// What is known at a frequency.
#[derive(Debug)]
pub(super) enum Enclosed {
    /// For each right-hand side the values of all readings, with proven bounds, and how they were found.
    Values(Vec<Vec<Value>>, FrequencyMethod),
    /// The matrix is proved to be singular.
    Singular,
    /// So many digits do not distinguish it from a singular one.
    Undecided(usize),
}

/// The answer in one precision, and the products it took.
type Attempt = fn(&Question<'_>) -> (Answer, u64);

/// Each precision, by its limbs, and the answer in it.
const LADDER: [(usize, Attempt); 6] = [
    (2, answer::<DoubleDouble>),
    (4, answer::<Wide<4>>),
    (8, answer::<Wide<8>>),
    (16, answer::<Wide<16>>),
    (32, answer::<Wide<32>>),
    (64, answer::<Wide<64>>),
];

/// Limbwise products that a rung beyond the first may take.
pub(super) const MOST_WORK: u64 = 1_000_000_000;

/// What one precision gives.
enum Answer {
    /// Values with bounds, and whether they are as good as doubles can be.
    Found(Vec<Vec<Value>>, bool),
    /// The matrix is proved to be singular.
    Singular,
    /// It may be singular.
    Unknown,
}

/// For each right-hand side, all of which act on the block alone, the values of its readings.
pub(super) fn enclose(question: &Question<'_>) -> Enclosed {
    let mut found = None;
    if let Some(values) = by_series(question) {
        return Enclosed::Values(values, FrequencyMethod::Modes);
    }
    if let Some(modes) = question.modes
        && let Some(Answer::Found(mut values, mut good)) =
            by_modes(modes, modes.matrices(), question)
    {
        if !good
            && question.frequency.radius == 0.0
            && let Some(Answer::Found(more, known)) =
                by_modes(modes, modes.wide_matrices(), question)
        {
            (values, good) = (more, known);
        }
        if good {
            return Enclosed::Values(values, FrequencyMethod::Modes);
        }
        found = Some((values, FrequencyMethod::Modes));
    }
    if found.is_none()
        && question.block.fills_up()
        && let Some(Answer::Found(values, good)) = by_inverse(question)
    {
        if good {
            return Enclosed::Values(values, FrequencyMethod::Inverse);
        }
        found = Some((values, FrequencyMethod::Inverse));
    }
    let (mut digits, mut work) = (0, 0u64);
    // What a whole range of frequencies leaves unknown, no digits decide.
    let rungs = if question.frequency.radius > 0.0 {
        2
    } else {
        LADDER.len()
    };
    for (limbs, answer) in &LADDER[..rungs] {
        if work.saturating_mul((limbs * limbs + 20) as u64) > MOST_WORK {
            break;
        }
        let (answer, products) = answer(question);
        (digits, work) = (decimal_digits(*limbs), products);
        match answer {
            Answer::Found(values, good) => {
                found = Some((values, FrequencyMethod::Elimination));
                if good {
                    break;
                }
            }
            Answer::Singular => return Enclosed::Singular,
            Answer::Unknown => {}
        }
    }
    let values = |(values, method)| Enclosed::Values(values, method);
    found.map_or(Enclosed::Undecided(digits), values)
}

/// All values by series from modes, where these show as much as is asked for.
fn by_series(question: &Question<'_>) -> Option<Vec<Vec<Value>>> {
    /// Bounds of values are as good as those by more digits.
    const UNSEEN: i64 = -64;
    let unseen = Magnitude::power_of_two(UNSEEN);
    let Question { modal, asked, .. } = question;
    if modal.len() < question.columns.len() {
        return None;
    }
    let columns = modal.iter().map(|functions| {
        let numbers = functions.enclosed(question.frequency)?.into_iter();
        let values = numbers.map(|[sum, change]| {
            let change = (*asked != Asked::Value).then_some(change);
            let value = Value::of(sum, change);
            let known = *asked == Asked::Sign || sum.radius() <= sum.lower() * unseen;
            (known && value.rises(*asked)).then_some(value)
        });
        values.collect()
    });
    columns.collect()
}

/// One rung: the values in the precision of T, and the products it took.
fn answer<T: Real>(question: &Question<'_>) -> (Answer, u64) {
    let (block, frequency) = (question.block, question.frequency);
    let (rows, exponents) = block.rows::<T>(frequency);
    let place = |coordinate: usize| block.coordinates().binary_search(&coordinate).ok();
    let (outcome, mut work) = Factor::of(rows);
    let factor = match outcome {
        Outcome::Regular(factor) => factor,
        Outcome::Singular(determinant) => {
            let shift: i64 = exponents.iter().map(|power| 2 * power).sum();
            let grain = block.grain(frequency);
            let least = grain.map(|grain| Magnitude::power_of_two(grain - shift));
            let answer = match least.is_some_and(|least| determinant < least) {
                true => Answer::Singular,
                false => Answer::Unknown,
            };
            return (answer, work);
        }
    };
    let solve = |right| by_scaled(&exponents, right, |right| Some(factor.solve(right)));
    work += 4 * (exponents.len() * question.columns.len()) as u64;
    let slope = |x: &[Ball<T>]| block.slope(frequency, x);
    let answer = read(question, exponents.len(), place, solve, slope);
    (answer.expect("a factor solves all"), work)
}

/// The solution by that of scaled rows.
pub(super) fn by_scaled<T: Real>(
    exponents: &[i64],
    right: Vec<Ball<T>>,
    solve: impl Fn(Vec<Ball<T>>) -> Option<Vec<Ball<T>>>,
) -> Option<Vec<Ball<T>>> {
    let down = right.into_iter().zip(exponents);
    let right = down.map(|(value, power)| scaled(value, -power)).collect();
    let x = solve(right)?.into_iter().zip(exponents);
    Some(x.map(|(x, power)| scaled(x, -power)).collect())
}

/// The same by an inverse in doubles.
fn by_inverse(question: &Question<'_>) -> Option<Answer> {
    let (block, frequency) = (question.block, question.frequency);
    let (rows, exponents) = block.rows(frequency);
    let inverse = Inverse::of(&rows)?;
    let place = |coordinate: usize| block.coordinates().binary_search(&coordinate).ok();
    let solve = |right| by_scaled(&exponents, right, |right| inverse.solve(&right));
    let slope = |x: &[Ball<DoubleDouble>]| block.slope(frequency, x);
    read(question, exponents.len(), place, solve, slope)
}

/// The same by modes, of the whole system, with K, C and M.
fn by_modes<T: Real>(
    modes: &ModalSum,
    matrices: &Matrices<T>,
    question: &Question<'_>,
) -> Option<Answer> {
    let at = modes.at(question.frequency, matrices)?;
    let solve = |right: Vec<Ball<T>>| at.solve(&right);
    let slope = |x: &[Ball<T>]| at.slope(x);
    read(question, modes.coordinates(), Some, solve, slope)
}

/// Values and steepness, by what solves Z x = f and multiplies by Z′, for `n` coordinates with their places.
fn read<T: Real>(
    question: &Question<'_>,
    n: usize,
    place: impl Fn(usize) -> Option<usize>,
    solve: impl Fn(Vec<Ball<T>>) -> Option<Vec<Ball<T>>>,
    slope: impl Fn(&[Ball<T>]) -> Vec<Ball<T>>,
) -> Option<Answer> {
    let frequency = question.frequency;
    let steepness = question.asked != Asked::Value;
    let mut good = true;
    let values = question.columns.iter().map(|(pushes, readings)| {
        let mut right = vec![Ball::<T>::ZERO; n];
        let mut change = right.clone();
        for push in *pushes {
            let at = place(push.coordinate).expect("it acts on the block");
            let phase = push.phase.factor();
            right[at] = right[at] + push.part.value::<T>(frequency) * phase;
            if let (true, Some(part)) = (steepness, push.part.derivative()) {
                change[at] = change[at] + part.value::<T>(frequency) * phase;
            }
        }
        let x = solve(right)?;
        let rates = match steepness {
            true => Some(solve(
                change
                    .into_iter()
                    .zip(slope(&x))
                    .map(|(a, b)| a - b)
                    .collect(),
            )?),
            false => None,
        };
        let largest = x.iter().map(|x| x.lower());
        let largest = largest.fold(Magnitude::ZERO, |a, b| if a < b { b } else { a });
        let read = |reading: &Reading| {
            let (mut sum, mut size) = (Ball::ZERO, Magnitude::ZERO);
            let mut change = Ball::ZERO;
            for (coordinate, part) in &reading.of {
                let factor = part.value::<T>(frequency);
                let Some(at) = place(*coordinate) else {
                    continue;
                };
                sum = sum + factor * x[at];
                size = size + factor.upper() * largest;
                if let Some(rates) = &rates {
                    change = change + factor * rates[at];
                    if let Some(part) = part.derivative() {
                        change = change + part.value::<T>(frequency) * x[at];
                    }
                }
            }
            for part in &reading.more {
                let more = part.value::<T>(frequency);
                sum = sum + more;
                size = size + more.upper();
                if let (true, Some(part)) = (steepness, part.derivative()) {
                    change = change + part.value::<T>(frequency);
                }
            }
            let value = Value::of(sum, steepness.then_some(change));
            good &= value.rises(question.asked);
            good &= question.asked == Asked::Sign || is_good(sum, size, frequency.radius > 0.0);
            value
        };
        Some(readings.iter().map(read).collect())
    });
    let values = values.collect::<Option<_>>()?;
    Some(Answer::Found(values, good))
}

impl Value {
    /// A number, with its derivative where that is asked for.
    pub(super) fn of<T: Real>(sum: Ball<T>, change: Option<Ball<T>>) -> Value {
        let (value, bound) = rounded(sum);
        let ratio = change.and_then(|change| change.checked_div(sum));
        let steepness = ratio.map(|ratio| {
            let value = ratio.middle().re.to_f64();
            let rounding = Magnitude::from(value.abs()) * Magnitude::power_of_two(-52);
            (value, (ratio.radius() + rounding).to_f64())
        });
        Value {
            value,
            bound,
            steepness,
        }
    }

    /// Whether the sign of the steepness is known, if it is asked for.
    fn rises(&self, asked: Asked) -> bool {
        match self.steepness {
            Some((value, off)) => value.abs() > off,
            None => asked == Asked::Value,
        }
    }
}

/// Whether a number is known to a double's last digit, or may be 0 and is nothing beside what it might be. In a range of
/// frequencies it need not be 0 for that: values differ there.
fn is_good<T: Real>(x: Ball<T>, size: Magnitude, range: bool) -> bool {
    const LAST_DIGIT: i64 = -56;
    const NOTHING: [f64; 2] = [1e-30, 1e-18];
    x.radius() <= x.lower() * Magnitude::power_of_two(LAST_DIGIT)
        || (range || x.lower() == Magnitude::ZERO)
            && x.radius() <= size * Magnitude::from(NOTHING[usize::from(range)])
}

/// The double nearest to a ball's middle, each part 0 if it cannot be distinguished from 0, and how far the
/// ball reaches from that.
pub(super) fn rounded<T: Real>(x: Ball<T>) -> (Complex<f64>, f64) {
    let middle = x.middle();
    let part = |part: T| {
        if part.magnitude() <= x.radius() {
            0.0
        } else {
            part.to_f64()
        }
    };
    let value = Complex::new(part(middle.re), part(middle.im));
    let back = Ball::from(WideComplex {
        re: T::from(value.re),
        im: T::from(value.im),
    });
    (value, (x - back).upper().to_f64())
}
