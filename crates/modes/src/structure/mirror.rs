//! A mirror symmetry: a permutation of coordinates, some with their signs turned, that is its own
//! inverse and leaves M, C and K exactly as they are. Motions that it leaves alone and motions that
//! it reverses do not mix.
//!
//! It is looked for by refining classes of coordinates that cannot be distinguished by the sizes of
//! their entries and the classes these lead to (Weisfeiler & Leman 1968), until no class splits.
//! Halves of a mirror image then share a class, which most often is a pair. Signs follow from entry
//! to entry. What is found is checked entry by entry, so nothing rests on the search.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use crate::exact::matrix::ExactMatrix;
use crate::exact::sum::ExactSum;

/// The most entries that are looked at in refining classes.
const MOST_LOOKS: usize = 20_000_000;

/// The mirror image of each coordinate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mirror {
    partner: Vec<usize>,
    reversed: Vec<bool>,
}

impl Mirror {
    /// The first of M, C and K that is found, if it moves any coordinate.
    pub(crate) fn of(parts: [&ExactMatrix; 3]) -> Option<Mirror> {
        let partner = partners(&parts)?;
        let moves = partner.iter().enumerate().any(|(i, &j)| i != j);
        let reversed = moves.then(|| signs(&parts, &partner))??;
        let mirror = Mirror { partner, reversed };
        parts
            .iter()
            .all(|part| mirror.keeps(part))
            .then_some(mirror)
    }

    /// Whether every entry equals its image.
    fn keeps(&self, matrix: &ExactMatrix) -> bool {
        (0..matrix.len()).all(|i| {
            matrix.row(i).all(|(j, terms)| {
                let image = matrix.entry(self.partner[i], self.partner[j]);
                equal(terms, image, self.reversed[i] != self.reversed[j])
            })
        })
    }

    /// The dimension of the motions that are reversed, or of those that are kept, if none of them
    /// meets a force of this symmetric matrix: a subspace of its null space that (M, K) keep. Only
    /// coordinates that are `counted` add to it; the mirror must not mix these with others.
    pub(crate) fn untouched(&self, matrix: &ExactMatrix, counted: impl Fn(usize) -> bool) -> usize {
        let side = |reverses: bool| {
            let mut dimension = 0;
            for (i, &image) in self.partner.iter().enumerate() {
                // e_i ± its image, each once; a coordinate that is its own image is on one side.
                let turned = self.reversed[i] != reverses;
                if image < i || image == i && turned {
                    continue;
                }
                dimension += usize::from(counted(i));
                let free = if image == i {
                    matrix.row(i).next().is_none()
                } else {
                    [i, image].iter().all(|&row| {
                        matrix.row(row).all(|(j, terms)| {
                            equal(terms, matrix.entry(i + image - row, j), !turned)
                        })
                    })
                };
                if !free {
                    return 0;
                }
            }
            dimension
        };
        side(true).max(side(false))
    }
}

/// Whether two sums of doubles are equal, or opposite.
fn equal(a: &[f64], b: &[f64], opposite: bool) -> bool {
    if a == b && !opposite {
        return true;
    }
    let mut sum = ExactSum::of(a);
    b.iter()
        .for_each(|&term| sum.add(if opposite { term } else { -term }));
    sum.sign() == Ordering::Equal
}

/// An entry of a row: its column, which matrix it is of, and its size.
type Entry = (usize, usize, u64);

/// For each coordinate one of its own class, the first for the last, and so on.
fn partners(parts: &[&ExactMatrix; 3]) -> Option<Vec<usize>> {
    let n = parts[0].len();
    let entries: Vec<Vec<Entry>> = (0..n)
        .map(|i| {
            let of = |(kind, part): (usize, &&ExactMatrix)| {
                let size = |terms| ExactSum::rounded(terms, 0).high().abs().to_bits();
                part.row(i)
                    .map(|(j, terms)| (j, kind, size(terms)))
                    .collect::<Vec<_>>()
            };
            parts.iter().enumerate().flat_map(of).collect()
        })
        .collect();
    let all: usize = entries.iter().map(Vec::len).sum();
    let mut class = vec![0; n];
    let mut count = 1;
    for _ in 0..MOST_LOOKS / all.max(1) {
        let mut classes = BTreeMap::new();
        let refined: Vec<usize> = (0..n)
            .map(|i| {
                let seen = entries[i]
                    .iter()
                    .map(|&(j, kind, size)| (class[j], kind, size, i == j));
                let mut seen: Vec<_> = seen.collect();
                seen.sort_unstable();
                let next = classes.len();
                *classes.entry((class[i], seen)).or_insert(next)
            })
            .collect();
        if classes.len() == count {
            let mut members = vec![Vec::new(); count];
            (0..n).for_each(|i| members[class[i]].push(i));
            let mut partner = vec![0; n];
            for members in members {
                for (&i, &j) in members.iter().zip(members.iter().rev()) {
                    partner[i] = j;
                }
            }
            return Some(partner);
        }
        (class, count) = (refined, classes.len());
    }
    None
}

/// Which coordinates are reversed, so that the signs of entries and their images agree. `None`
/// where they cannot.
fn signs(parts: &[&ExactMatrix; 3], partner: &[usize]) -> Option<Vec<bool>> {
    let n = partner.len();
    let mut reversed: Vec<Option<bool>> = vec![None; n];
    for start in 0..n {
        if reversed[start].is_some() {
            continue;
        }
        reversed[start] = Some(false);
        let mut waiting = vec![start];
        while let Some(i) = waiting.pop() {
            let mine = reversed[i]?;
            let mut follow = |j: usize, sign: bool| match reversed[j] {
                Some(known) => known == sign,
                None => {
                    reversed[j] = Some(sign);
                    waiting.push(j);
                    true
                }
            };
            let agree = follow(partner[i], mine)
                && parts.iter().all(|part| {
                    part.row(i).all(|(j, terms)| {
                        let image = part.entry(partner[i], partner[j]);
                        let turned = ExactSum::of(terms).sign() != ExactSum::of(image).sign();
                        follow(j, mine != turned)
                    })
                });
            if !agree {
                return None;
            }
        }
    }
    reversed.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::super::coefficients::Coefficients;
    use super::super::samples::{chain, free_beam, matrices, network};
    use super::*;
    use crate::system::System;
    use faer::Mat;

    fn mirror(system: &System) -> Option<Mirror> {
        Coefficients::of(system.model()).mirror().cloned()
    }

    #[test]
    fn a_chain_is_turned_end_for_end() {
        let masses = [0.1, 0.2, 0.3, 0.2, 0.1];
        let springs = [0.7, 0.3, 0.5, 0.5, 0.3, 0.7];
        let found = mirror(&chain(&masses, &springs, &[0.0; 6])).expect("it is symmetric");
        assert_eq!(found.partner, [4, 3, 2, 1, 0]);
        assert_eq!(found.reversed, [false; 5]);
        let mut off = springs;
        off[5] = off[5].next_up();
        assert_eq!(mirror(&chain(&masses, &off, &[0.0; 6])), None);
        assert_eq!(
            mirror(&chain(&masses, &springs, &[0.1, 0.0, 0.0, 0.0, 0.0, 0.2])),
            None
        );
    }

    #[test]
    fn the_order_of_coordinates_does_not_matter() {
        let springs = [(0, 3, 1.0), (3, 1, 2.0), (1, 2, 2.0), (2, 0, 1.0)];
        let found = mirror(&network(&[5.0, 3.0, 3.0], &springs, &[])).expect("it is symmetric");
        assert_eq!(found.partner, [0, 2, 1]);
    }

    #[test]
    fn rotations_of_a_beam_are_reversed() {
        let n = 10;
        let beam = matrices(Mat::identity(n, n), Mat::zeros(n, n), free_beam(4));
        let found = mirror(&beam).expect("it is symmetric");
        assert_eq!(found.partner, [8, 9, 6, 7, 4, 5, 2, 3, 0, 1]);
        let rotations: Vec<bool> = (0..n).map(|i| i % 2 == 1).collect();
        assert_eq!(found.reversed, rotations);
        // Damping that acts on the middle alone, first on its displacement, then on its rotation.
        for (at, dimension) in [(4, 5), (5, 5), (2, 0)] {
            let mut damping = Mat::<f64>::zeros(n, n);
            damping[(at, at)] = 1.0;
            let part =
                Coefficients::of(matrices(Mat::identity(n, n), damping, free_beam(4)).model());
            assert_eq!(found.untouched(&part.damping.matrix, |_| true), dimension);
        }
    }
}
