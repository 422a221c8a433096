//! The first odd power of x that |h|² may have, for h = c A⁻¹ b + d with polynomials in x and losses in some places.
//!
//! With losses times ε, the conjugates of the equations are those of −x and −ε, up to the signs of rows. So |h|² has terms of
//! even order in both together alone, and an odd power of x comes with a factor ε: with the least power of h by one factor, and
//! that by the other through a place of a loss, or a larger one.
//!
//! A⁻¹ is a sum of products A₀⁻¹E A₀⁻¹E … A₀⁻¹, with A = A₀ + E and E = O(x). A₀⁻¹ joins only what entries of A₀ join, so that the least
//! power of x from input to output is the length of the shortest way through the parts of A₀, on which each entry of E is as long as its power.

use std::collections::VecDeque;

use super::dynamic_stiffness::parts;
use super::power_series::Entry;

/// Row, column and power of x.
pub(super) type Place = (usize, usize, usize);

/// Those of |h|² and of |1/h|², where n rows and columns are bordered by input and output; `lost` are the places of losses, any of the
/// entries where they are not given.
pub(super) fn first_odd(n: usize, entries: &[Entry], lost: Option<&[Place]>) -> [usize; 2] {
    let places = entries.iter().flat_map(|(row, column, polynomial)| {
        let powers = (0..).zip(polynomial).filter(|(_, part)| !part.is_zero());
        powers.map(|(power, _)| (*row, *column, power))
    });
    let places: Vec<Place> = places.collect();
    let lost = lost.unwrap_or(&places);
    [n, n + 1].map(|size| {
        let ways = Ways::of(n, size, &places);
        let through = |all: &[Place]| all.iter().map(|place| ways.through(*place)).min();
        let least = match through(&places) {
            Some(least) => least.saturating_add(through(lost).unwrap_or(usize::MAX)),
            None => usize::MAX,
        };
        least | 1
    })
}

/// The shortest ways between input, parts and output; `usize::MAX` where there is none.
struct Ways {
    /// How many rows and columns have no ends of a way.
    size: usize,
    /// Of each row, and then of each column.
    part: Vec<usize>,
    /// By parts.
    from_input: Vec<usize>,
    to_output: Vec<usize>,
}

impl Ways {
    fn of(n: usize, size: usize, places: &[Place]) -> Ways {
        let within = places
            .iter()
            .filter(|(row, column, _)| *row < size && *column < size);
        let joints = within.clone().filter(|(.., power)| *power == 0);
        let part = parts(
            2 * size,
            joints.map(|(row, column, _)| (*row, size + column)),
        );
        // From what a column does to what acts on a row.
        let steps = within.filter(|(.., power)| *power > 0);
        let steps = steps.map(|(row, column, power)| (part[size + column], part[*row], *power));
        let steps: Vec<Place> = steps.collect();
        let [mut from_input, mut to_output] =
            [vec![usize::MAX; 2 * size], vec![usize::MAX; 2 * size]];
        match size > n {
            // Between the last column and the last row, and back.
            true => (from_input[part[n]], to_output[part[size + n]]) = (0, 0),
            false => {
                for (row, column, power) in places {
                    if *column == n && *row < n {
                        let known = &mut from_input[part[*row]];
                        *known = (*known).min(*power);
                    }
                    if *row == n && *column < n {
                        let known = &mut to_output[part[size + column]];
                        *known = (*known).min(*power);
                    }
                }
            }
        }
        spread(&mut from_input, steps.iter().copied());
        spread(
            &mut to_output,
            steps.iter().map(|(a, b, power)| (*b, *a, *power)),
        );
        Ways {
            size,
            part,
            from_input,
            to_output,
        }
    }

    /// The shortest way through an entry.
    fn through(&self, (row, column, power): Place) -> usize {
        let before = match column < self.size {
            true => self.from_input[self.part[self.size + column]],
            false => 0,
        };
        let after = match row < self.size {
            true => self.to_output[self.part[row]],
            false => 0,
        };
        before.saturating_add(power).saturating_add(after)
    }
}

/// Lengths of shortest ways from what has one, by steps from, to and how long.
fn spread(lengths: &mut [usize], steps: impl Iterator<Item = Place>) {
    let mut next: Vec<Vec<(usize, usize)>> = vec![Vec::new(); lengths.len()];
    for (from, to, length) in steps {
        next[from].push((to, length));
    }
    let known = (0..lengths.len()).filter(|part| lengths[*part] < usize::MAX);
    let mut open: VecDeque<usize> = known.collect();
    while let Some(from) = open.pop_front() {
        for &(to, length) in &next[from] {
            let length = lengths[from].saturating_add(length);
            if length < lengths[to] {
                lengths[to] = length;
                open.push_back(to);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::power_series::{Number, real};
    use super::*;

    /// A spring with losses within a chain of masses on dampers, in 1/Ω: mass at power 0, damper at 1, spring at 2.
    #[test]
    fn an_odd_power_comes_with_a_loss_on_the_way() {
        let [mass, damper, spring] = [0, 1, 2].map(|power| {
            let mut polynomial = [Number::ZERO; 3];
            polynomial[power] = real(1.0);
            polynomial
        });
        // Input by a damper at the first of three, output at the last.
        let mut entries = vec![(0, 3, damper), (3, 2, mass)];
        entries.extend((0..3).map(|i| (i, i, mass)));
        entries.extend([
            (0, 1, damper),
            (1, 0, damper),
            (1, 2, spring),
            (2, 1, spring),
        ]);
        // The way is of 1 + 1 + 2 powers.
        let of = |lost: &[Place]| first_odd(3, &entries, Some(lost))[0];
        assert_eq!(of(&[(2, 1, 2)]), 4 + 5);
        assert_eq!(of(&[(1, 2, 2)]), 4 + 9);
        // There and back, through 0 or 2.
        assert_eq!(of(&[(1, 1, 2)]), 4 + 7);
        assert_eq!(of(&[(0, 0, 1)]), 4 + 5);
        assert_eq!(of(&[(0, 3, 2)]), 4 + 5);
        assert_eq!(first_odd(3, &entries, None)[0], 9);
        // No way leads there.
        let apart: Vec<Entry> = entries
            .iter()
            .filter(|entry| entry.0 != 1)
            .copied()
            .collect();
        assert_eq!(first_odd(3, &apart, Some(&[(0, 0, 1)]))[0], usize::MAX);
    }

    /// What input and output cancel of 1/h has power 0, and a loss behind it that of the way there and back.
    #[test]
    fn the_inverse_has_its_own_powers() {
        let [one, square] = [0, 2].map(|power| {
            let mut polynomial = [Number::ZERO; 3];
            polynomial[power] = real(1.0);
            polynomial
        });
        let entries = [
            (0, 0, one),
            (1, 1, one),
            (0, 1, square),
            (1, 0, square),
            (0, 2, one),
            (2, 0, one),
        ];
        assert_eq!(first_odd(2, &entries, Some(&[(0, 0, 1)])), [1, 1]);
        assert_eq!(first_odd(2, &entries, Some(&[(1, 1, 1)])), [5, 5]);
    }
}
