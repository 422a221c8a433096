//! The limits of functions for Ω → 0 where the dynamic stiffness Z is singular at 0, with proven bounds.
//!
//! H = N/D with D = det Z, and −N the determinant of Z bordered by input and output: polynomials in Ω. Each of their
//! coefficients is a Gaussian integer times a power of two 2^g, which the doubles in the rows show, and the sizes of all sum
//! to 2^h or less, a product of sums of rows. So with the least powers p of N and q of D, at Ω = 2^−k with
//! k ≥ h_N − g_N + h_D − g_D + 64,
//!
//! 2^(g_N−h_D−2) ≤ |H|·Ω^(q−p) ≤ 2^(h_N−g_D+2),
//!
//! and the size of H says whether p < q, a pole, p > q, the limit 0, or p = q. Then the coefficients N_p and D_q are left,
//! and |N_p/D_q − H| ≤ Ω(|H|·2^h_D + 2^h_N)/2^g_D: the limit is H to more digits than doubles have.

use eigentone_digits::{Ball, Magnitude, Real, Wide};

use super::dynamic_stiffness::{Block, Frequency, Part, RowSize};
use super::elimination::{Factor, Outcome};
use super::enclosure::{MOST_WORK, Value, by_scaled, rounded};
use super::ports::{Push, Reading};

/// What a function tends to for Ω → 0.
#[derive(Clone, Copy, Debug)]
pub(super) enum Limit {
    /// A number.
    Finite(Value),
    /// It is proved that there is none.
    Infinite,
    /// So many digits as are tried do not decide it.
    Unknown,
}

/// For each right-hand side, which acts on the block without a phase, the limits of its readings.
pub(super) fn limits(block: &Block, columns: &[(&[Push], &[Reading])]) -> Vec<Vec<Limit>> {
    /// Each precision, by its limbs.
    const LADDER: [(usize, Attempt); 4] = [
        (8, attempt::<Wide<8>>),
        (16, attempt::<Wide<16>>),
        (32, attempt::<Wide<32>>),
        (64, attempt::<Wide<64>>),
    ];
    let own = block.row_sizes();
    let below = Span::of(&own);
    let above = columns.iter().map(|(pushes, readings)| {
        let spans = readings
            .iter()
            .map(|reading| bordered(block, &own, pushes, reading));
        spans.collect()
    });
    let above: Vec<Vec<Span>> = above.collect();
    let widest = above.iter().flatten().map(|span| span.most - span.least);
    let question = Question {
        block,
        columns,
        below,
        smallness: below.most - below.least + widest.max().unwrap_or(0) + 64,
        above,
    };
    let mut found = columns
        .iter()
        .map(|(_, readings)| vec![Limit::Unknown; readings.len()])
        .collect();
    let mut work = 0u64;
    for (limbs, attempt) in LADDER {
        // Beside 1 stands Ω.
        if 64 * limbs as i64 <= question.smallness {
            continue;
        }
        if work.saturating_mul((limbs * limbs) as u64) > MOST_WORK {
            break;
        }
        let (limits, products) = attempt(&question);
        work = products;
        if let Some((limits, good)) = limits {
            found = limits;
            if good {
                break;
            }
        }
    }
    found
}

/// A determinant as a polynomial in Ω: its coefficients are Gaussian integers times 2^least, and their sizes sum to
/// 2^most or less.
#[derive(Clone, Copy)]
struct Span {
    least: i64,
    most: i64,
}

impl Span {
    fn of(rows: &[RowSize]) -> Span {
        let least = rows.iter().map(|row| row.last_bit.unwrap_or(0)).sum();
        let most = rows.iter().map(|row| row.size.exponent()).sum();
        Span {
            least,
            // What is 0 throughout has no coefficient.
            most: least.max(most),
        }
    }
}

/// That of the matrix with what acts as a further column, and with what is read as a further row.
fn bordered(block: &Block, own: &[RowSize], pushes: &[Push], reading: &Reading) -> Span {
    let mut rows = own.to_vec();
    for push in pushes {
        let at = block.coordinates().binary_search(&push.coordinate);
        rows[at.expect("it acts on the block")].add(&push.part);
    }
    let mut last = RowSize::default();
    let read = reading.of.iter().map(|(_, part)| part);
    read.chain(&reading.more).for_each(|part| last.add(part));
    rows.push(last);
    Span::of(&rows)
}

struct Question<'a> {
    block: &'a Block,
    columns: &'a [(&'a [Push], &'a [Reading])],
    below: Span,
    above: Vec<Vec<Span>>,
    /// k.
    smallness: i64,
}

/// The limits, where the matrix is regular at the small frequency, and whether all are known to a double's last digit.
type Limits = Option<(Vec<Vec<Limit>>, bool)>;

/// What one precision gives, and the products it took.
type Attempt = fn(&Question<'_>) -> (Limits, u64);

fn attempt<T: Real>(question: &Question<'_>) -> (Limits, u64) {
    let block = question.block;
    let frequency = Frequency::small(question.smallness);
    let (rows, exponents) = block.rows::<T>(frequency);
    let (outcome, work) = Factor::of(rows);
    let Outcome::Regular(factor) = outcome else {
        return (None, work);
    };
    let place = |coordinate: usize| block.coordinates().binary_search(&coordinate).ok();
    let mut good = true;
    let columns = question.columns.iter().zip(&question.above);
    let limits = columns.map(|((pushes, readings), above)| {
        let mut right = vec![Ball::<T>::ZERO; exponents.len()];
        for push in *pushes {
            let at = place(push.coordinate).expect("it acts on the block");
            right[at] = right[at] + push.part.value::<T>(frequency);
        }
        let x = by_scaled(&exponents, right, |right| Some(factor.solve(right)))?;
        let read = readings.iter().zip(above).map(|(reading, above)| {
            let value = |part: &Part| part.value::<T>(frequency);
            let moved = reading
                .of
                .iter()
                .filter_map(|(coordinate, part)| Some(value(part) * x[place(*coordinate)?]));
            let all = moved.chain(reading.more.iter().map(value));
            let sum = all.fold(Ball::ZERO, |sum, one| sum + one);
            let (limit, known) = question.limit(*above, sum);
            good &= known;
            limit
        });
        Some(read.collect())
    });
    let limits: Option<Vec<Vec<Limit>>> = limits.collect();
    (limits.map(|limits| (limits, good)), work)
}

impl Question<'_> {
    /// That of a function with this value at the small frequency, and whether it is known to a double's last digit.
    fn limit<T: Real>(&self, above: Span, value: Ball<T>) -> (Limit, bool) {
        /// Between the bounds of a finite limit and those of a pole, or of the limit 0, are 2^60.
        const MARGIN: i64 = 30;
        const LAST_DIGIT: i64 = -56;
        let below = self.below;
        let power = Magnitude::power_of_two;
        let [least, most] = [
            power(above.least - below.most - MARGIN),
            power(above.most - below.least + MARGIN),
        ];
        if value.upper() < least {
            let nothing = Value {
                value: 0.0.into(),
                bound: 0.0,
                steepness: None,
            };
            return (Limit::Finite(nothing), true);
        }
        if value.lower() > most {
            return (Limit::Infinite, true);
        }
        if value.lower() < least || value.upper() > most {
            return (Limit::Unknown, false);
        }
        let sizes = value.upper() * power(below.most) + power(above.most);
        let left = sizes * power(-self.smallness - below.least);
        let limit = Ball::new(value.middle(), value.radius() + left);
        let known = limit.radius() <= limit.lower() * power(LAST_DIGIT);
        let (value, bound) = rounded(limit);
        let limit = Limit::Finite(Value {
            value,
            bound,
            steepness: None,
        });
        (limit, known)
    }
}
