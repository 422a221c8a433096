//! Which root of one design is which of the next, by continuity along the path between them.
//!
//! The shapes x and y of a root predict it in another design as a root of y*(λ²M + λC + K)x = 0, right to second order
//! (Lancaster 1966, *Lambda-matrices and vibrating systems*, §5.5). A step is taken where each prediction has one root of its
//! own, far from all others, and no two roots can have come close on the way; else it is halved. So a step that jumps over a
//! veering, where shapes look exchanged and roots are not, is refined until the gap is seen.

use std::ops::Range;

use eigentone_digits::sort_by_number;
use eigentone_modes::{MatrixKind, Modes, System};
use faer::Mat;
use num_complex::Complex;
use thiserror::Error;

/// Roots that come nearer to each other than this part of their size cross as their shapes say.
const TOUCH: f64 = 1e-12;

/// The most designs that are solved between two, for each root: a crossing takes about 80.
const MOST: usize = 200;

/// So often a step is halved where [`Station::parts_by_itself`] holds.
const MOST_ALIKE: usize = 53;

/// Keeps each root at its place along a path of designs.
///
/// ```
/// use eigentone_design::Follower;
/// use eigentone_modes::{GROUND, System};
///
/// // Two oscillators that know nothing of each other: one becomes stiffer and passes the other.
/// let solve = |k: f64| {
///     let builder = System::builder().mass("a", 1.0).mass("b", 1.0);
///     let system = builder.spring(GROUND, "a", k).spring(GROUND, "b", 4.0).build().ok()?;
///     Follower::at(&system, &system.modes().ok()?).ok()
/// };
/// let mut follower = solve(1.0).ok_or("no modes")?;
/// assert_eq!(follower.roots()[0].im, 1.0);
/// follower.advance(|t| solve(1.0 + 8.0 * t))?;
/// assert_eq!(follower.roots()[0].im, 3.0);
/// assert_eq!(follower.roots()[2].im, 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Follower {
    here: Station,
    order: Vec<usize>,
}

/// How sure the places are after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Followed {
    /// Each root went its own way.
    Surely,
    /// Roots coincided, or came nearer than doubles or their bounds distinguish: their places are a choice.
    Doubtful,
}

/// Why roots cannot be followed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FollowError {
    /// The design at the end of the step has no modes.
    #[error("the design has no modes to go to")]
    NoDesign,
    /// The designs have different numbers of finite roots, so that some went to infinity.
    #[error(
        "the design has {found} finite roots, the one before it {expected}: mass or damping vanishes between them"
    )]
    Count {
        /// Of the design before.
        expected: usize,
        /// Of this design.
        found: usize,
    },
    /// Some modes are missing.
    #[error("there are {found} modes for {expected} roots: all of them are needed")]
    SomeModes {
        /// Roots.
        expected: usize,
        /// Roots of the modes given.
        found: usize,
    },
}

/// The roots of one design, in places, with the shapes that predict them in others.
#[derive(Clone, Debug)]
struct Station {
    /// M, C, K.
    matrices: [Mat<f64>; 3],
    roots: Vec<Complex<f64>>,
    /// How far off each may be; infinite where it is not known.
    bounds: Vec<f64>,
    /// The shapes of each, one behind the other.
    right: Vec<Complex<f64>>,
    left: Vec<Complex<f64>>,
}

impl Follower {
    /// Starts at a design: roots in the order of its modes, each pair as λ with Im λ > 0 and its conjugate.
    ///
    /// # Errors
    /// [`FollowError::SomeModes`].
    pub fn at(system: &System, modes: &Modes) -> Result<Follower, FollowError> {
        let here = Station::of(system, modes)?;
        let order = (0..here.roots.len()).collect();
        Ok(Follower { here, order })
    }

    /// Every finite root of the design, each at its place.
    pub fn roots(&self) -> &[Complex<f64>] {
        &self.here.roots
    }

    /// How far off the root at each place may be, in 1/s: the bound of its mode, infinite where that is doubtful.
    pub fn bounds(&self) -> &[f64] {
        &self.here.bounds
    }

    /// Which root stands at each place: its index where the design is the [start](Self::at).
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// The same design with root `order[i]` of this one at place i, as the order of another that has come to a design which this
    /// one has come from.
    ///
    /// # Panics
    /// If `order` does not have each place once.
    #[must_use]
    pub fn ordered(self, order: &[usize]) -> Follower {
        assert_eq!(order.len(), self.order.len(), "each place once");
        Follower {
            order: order.iter().map(|at| self.order[*at]).collect(),
            here: self.here.ordered(order),
        }
    }

    /// Goes to the end of a path of designs, of which `solve` gives those at t from 0, exclusive, where this stands, to 1, as
    /// [`at`](Self::at) does. It is asked for t = 1 first, and for others between as far as roots come close to each other.
    /// `None` says that there is no design at t.
    ///
    /// Where a conjugate pair has become two real roots, the first of its places has the larger one.
    ///
    /// # Errors
    /// [`FollowError`]; then it stays where it was.
    pub fn advance(
        &mut self,
        mut solve: impl FnMut(f64) -> Option<Follower>,
    ) -> Result<Followed, FollowError> {
        let goal = solve(1.0).ok_or(FollowError::NoDesign)?.here;
        let (expected, found) = (self.here.roots.len(), goal.roots.len());
        if expected != found {
            return Err(FollowError::Count { expected, found });
        }
        let (here, order, is_sure) = match self.here.certain(&goal) {
            Some(order) => {
                let here = goal.ordered(&order).with_shapes_of(&self.here);
                (here, order, true)
            }
            None => match self.walk(&goal, solve) {
                Some((last, order)) => {
                    let here = goal.ordered(&order).with_shapes_of(&last);
                    (here, order, true)
                }
                None => {
                    let order = self.here.nearest(&goal);
                    (goal.ordered(&order), order, false)
                }
            },
        };
        self.order = order;
        let before = std::mem::replace(&mut self.here, here);
        Ok(
            match is_sure && !coincide(&before.roots, &self.here.roots) {
                true => Followed::Surely,
                false => Followed::Doubtful,
            },
        )
    }

    /// Steps to a goal that one step does not reach surely: the last design before it, and the order of its roots.
    fn walk(
        &self,
        goal: &Station,
        mut solve: impl FnMut(f64) -> Option<Follower>,
    ) -> Option<(Station, Vec<usize>)> {
        // No design between separates roots that are not separated where it begins or ends.
        if !self.here.separates_all() || !goal.separates_all() {
            return None;
        }
        let expected = self.here.roots.len();
        let mut here = self.here.clone();
        let (mut t, mut step, mut spent, mut alike) = (0.0, 0.5, 0, 0);
        loop {
            let is_last = t + step >= 1.0;
            let between = if is_last {
                None
            } else {
                spent += 1;
                let between = solve(t + step).map(|between| between.here);
                between.filter(|between| between.roots.len() == expected)
            };
            let next = match is_last {
                true => Some(goal),
                false => between.as_ref(),
            };
            match next.and_then(|next| here.certain(next)) {
                Some(order) if is_last => return Some((here, order)),
                Some(order) => {
                    // There is a design between: it was distinguished from the one here.
                    here = between?.ordered(&order).with_shapes_of(&here);
                    t += step;
                    step *= 2.0;
                    alike = 0;
                }
                None if spent < MOST * expected && alike < MOST_ALIKE && t + 0.5 * step > t => {
                    step *= 0.5;
                    alike = match next.is_some_and(|next| here.parts_by_itself(next)) {
                        true => alike + 1,
                        false => 0,
                    };
                }
                None => return None,
            }
        }
    }
}

impl Station {
    fn of(system: &System, modes: &Modes) -> Result<Station, FollowError> {
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let matrices = kinds.map(|kind| match kind {
            MatrixKind::Mass => system.mass_matrix(),
            MatrixKind::Damping => system.damping_matrix(),
            MatrixKind::Stiffness => system.stiffness_matrix(),
        });
        let (n, count) = (system.len(), modes.eigenvalues().len());
        let (mut roots, mut bounds) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut right, mut left) = (Vec::with_capacity(n * count), Vec::with_capacity(n * count));
        for mode in modes {
            let value = mode.eigenvalue().value;
            let bound = mode.eigenvalue().bound.unwrap_or(f64::INFINITY);
            for _ in 0..mode.roots() {
                let start = right.len();
                roots.push(value);
                bounds.push(bound);
                right.extend_from_slice(mode.shape());
                match mode.left_shape() {
                    Some(shape) => left.extend_from_slice(shape),
                    None => left.extend(mode.shape().iter().map(Complex::conj)),
                }
                if value.im != 0.0 {
                    roots.push(value.conj());
                    bounds.push(bound);
                    for shapes in [&mut right, &mut left] {
                        for k in start..start + n {
                            shapes.push(shapes[k].conj());
                        }
                    }
                }
            }
        }
        let (expected, found) = (count, roots.len());
        match expected == found {
            true => Ok(Station {
                matrices,
                roots,
                bounds,
                right,
                left,
            }),
            false => Err(FollowError::SomeModes { expected, found }),
        }
    }

    /// Where the shapes of a root stand.
    fn entries(&self, root: usize) -> Range<usize> {
        let n = self.matrices[0].nrows();
        n * root..n * (root + 1)
    }

    /// The same with root `order[i]` at place i.
    fn ordered(self, order: &[usize]) -> Station {
        if order.iter().enumerate().all(|(i, root)| i == *root) {
            return self;
        }
        let shapes = |shapes: &[Complex<f64>]| -> Vec<Complex<f64>> {
            let each = order.iter();
            each.flat_map(|root| &shapes[self.entries(*root)])
                .copied()
                .collect()
        };
        Station {
            roots: order.iter().map(|root| self.roots[*root]).collect(),
            bounds: order.iter().map(|root| self.bounds[*root]).collect(),
            right: shapes(&self.right),
            left: shapes(&self.left),
            matrices: self.matrices,
        }
    }

    /// The same with the shapes of the design before for roots that coincide, of which the own shapes predict nothing.
    fn with_shapes_of(mut self, before: &Station) -> Station {
        for i in 0..self.roots.len() {
            let mut others = self.roots.iter().enumerate().filter(|(k, _)| *k != i);
            if others.any(|(_, other)| touch(self.roots[i], *other)) {
                let own = self.entries(i);
                self.right[own.clone()].copy_from_slice(&before.right[own.clone()]);
                self.left[own.clone()].copy_from_slice(&before.left[own]);
            }
        }
        self
    }

    /// Where the root at each place is to be expected in another design.
    fn predicted(&self, other: &Station) -> Vec<Complex<f64>> {
        let predicted = self.roots.iter().enumerate().map(|(at, root)| {
            let (x, y) = (&self.right[self.entries(at)], &self.left[self.entries(at)]);
            let [m, c, k] = other.matrices.each_ref().map(|matrix| form(y, matrix, x));
            let half = (c * c - m * k * 4.0).sqrt();
            let sum = if (c.conj() * half).re < 0.0 {
                c - half
            } else {
                c + half
            };
            // One root without cancellation, and the other from their product.
            let both = [-sum / (m * 2.0), -k * 2.0 / sum];
            let finite = both.into_iter().filter(|value| value.is_finite());
            let near = |value: &Complex<f64>| (value - root).norm();
            let nearest = finite.min_by(|a, b| near(a).total_cmp(&near(b)));
            nearest.unwrap_or(*root)
        });
        predicted.collect()
    }

    /// The root of another design that each goes to, if all are sure.
    fn certain(&self, other: &Station) -> Option<Vec<usize>> {
        let (from, to, predicted) = (&self.roots, &other.roots, self.predicted(other));
        let n = from.len();
        let mut order = vec![None; n];
        let mut taken = vec![false; n];
        for i in 0..n {
            let (nearest, near, second) = nearest_two(predicted[i], to, &taken);
            // A pair becomes two real roots together, below.
            let alike = (from[i].im == 0.0) == (to[nearest].im == 0.0);
            if near <= 0.25 * second && alike {
                taken[nearest] = true;
                order[i] = Some(nearest);
            }
        }
        for i in 0..n {
            if order[i].is_none() {
                let meeting = Meeting {
                    from,
                    to,
                    predicted: &predicted,
                };
                let (k, [first, second]) = meeting.of(i, &order, &taken)?;
                (order[i], order[k]) = (Some(first), Some(second));
                (taken[first], taken[second]) = (true, true);
            }
        }
        let order: Vec<usize> = order.into_iter().collect::<Option<_>>()?;
        for i in 0..n {
            for k in 0..i {
                let (before, after) = (from[i] - from[k], to[order[i]] - to[order[k]]);
                if !self.separates(i, k) || !other.separates(order[i], order[k]) {
                    return None;
                }
                let touching = touch(from[i], from[k]) || touch(to[order[i]], to[order[k]]);
                let least = least_on_way(before, after);
                if !touching && least < 0.5 * before.norm().min(after.norm()) {
                    return None;
                }
            }
        }
        Some(order)
    }

    /// Whether two roots are distinguished from each other by more than they may be off. What coincides need not be, and a
    /// conjugate pair is.
    fn separates(&self, i: usize, k: usize) -> bool {
        let (a, b) = (self.roots[i], self.roots[k]);
        a == b.conj() || touch(a, b) || size(a - b) > self.bounds[i] + self.bounds[k]
    }

    /// Whether roots that coincide here part in another design, and stay together far from all others: a shorter step shows
    /// the same at a smaller size, without end where the path begins at 0.
    fn parts_by_itself(&self, other: &Station) -> bool {
        let (from, to) = (&self.roots, &other.roots);
        let groups = from.iter().filter_map(|root| {
            let count = from.iter().filter(|other| touch(*root, **other)).count();
            let off = |other: &Complex<f64>| (other - root).norm();
            let mut near: Vec<Complex<f64>> = to.clone();
            sort_by_number(&mut near, off);
            let (own, others) = near.split_at(count);
            let parts = own.iter().any(|one| !touch(*one, own[0]));
            let next = others.first().map_or(f64::INFINITY, off);
            parts.then(|| next >= 4.0 * off(&own[count - 1]))
        });
        let mut groups = groups.peekable();
        groups.peek().is_some() && groups.all(|is_apart| is_apart)
    }

    fn separates_all(&self) -> bool {
        (0..self.roots.len()).all(|i| (0..i).all(|k| self.separates(i, k)))
    }

    /// The nearest root of another design for each, by predictions, each root once.
    fn nearest(&self, other: &Station) -> Vec<usize> {
        let to = &other.roots;
        let mut free: Vec<usize> = (0..to.len()).collect();
        let predicted = self.predicted(other).into_iter();
        let chosen = predicted.map(|expected| {
            let off = |at: &usize| (to[free[*at]] - expected).norm();
            let best = (0..free.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
            // There are as many roots as places.
            free.swap_remove(best.unwrap_or_default())
        });
        chosen.collect()
    }
}

/// y*Ax.
fn form(y: &[Complex<f64>], matrix: &Mat<f64>, x: &[Complex<f64>]) -> Complex<f64> {
    let mut sum = Complex::ZERO;
    for (j, x) in x.iter().enumerate() {
        let column = matrix.col_as_slice(j).iter().zip(y);
        let along: Complex<f64> = column.map(|(entry, y)| y.conj() * *entry).sum();
        sum += along * x;
    }
    sum
}

/// A pair of roots that meets on the real axis within a step.
struct Meeting<'a> {
    from: &'a [Complex<f64>],
    to: &'a [Complex<f64>],
    predicted: &'a [Complex<f64>],
}

impl Meeting<'_> {
    /// The other place of a pair, and the roots that both get, if one design has it as a conjugate pair, the other as two
    /// real roots, and no other root is near.
    fn of(&self, i: usize, order: &[Option<usize>], taken: &[bool]) -> Option<(usize, [usize; 2])> {
        let centre = Complex::from(self.predicted[i].re);
        let mut places: Vec<usize> = (0..order.len()).collect();
        let mut roots = places.clone();
        let off = |value: Complex<f64>| (value - centre).norm();
        places.retain(|k| *k != i);
        sort_by_number(&mut places, |at| off(self.predicted[*at]));
        sort_by_number(&mut roots, |at| off(self.to[*at]));
        let (&k, &[first, second]) = (places.first()?, roots.first_chunk()?);
        // Of two roots at one place the first may have found its way by itself.
        let parting = touch(self.from[i], self.from[k]);
        let free = |root: usize| !taken[root] || parting && order[k] == Some(root);
        if order[k].is_some() && !parting || !free(first) || !free(second) {
            return None;
        }
        let is_pair = |a: Complex<f64>, b: Complex<f64>| a.im != 0.0 && a == b.conj();
        let is_real = |a: Complex<f64>, b: Complex<f64>| a.im == 0.0 && b.im == 0.0;
        let (before, after) = (
            [self.from[i], self.from[k]],
            [self.to[first], self.to[second]],
        );
        let meets = is_pair(before[0], before[1]) && is_real(after[0], after[1])
            || is_real(before[0], before[1]) && is_pair(after[0], after[1])
            || touch(before[0], before[1])
            || touch(after[0], after[1]);
        let own = [self.predicted[i], self.predicted[k], after[0], after[1]];
        let reach = own.map(off).into_iter().fold(0.0, f64::max);
        let others = places[1..].iter().map(|k| off(self.predicted[*k]));
        let others = others.chain(roots[2..].iter().map(|j| off(self.to[*j])));
        if !meets || others.fold(f64::INFINITY, f64::min) < 4.0 * reach {
            return None;
        }
        let key = |value: Complex<f64>| (value.im, value.re);
        let rising = key(after[0]) < key(after[1]);
        let [high, low] = if rising {
            [second, first]
        } else {
            [first, second]
        };
        Some((k, if i < k { [high, low] } else { [low, high] }))
    }
}

fn touch(a: Complex<f64>, b: Complex<f64>) -> bool {
    size(a - b) <= TOUCH * size(a).max(size(b))
}

/// The larger part, which no square takes beyond the doubles.
fn size(value: Complex<f64>) -> f64 {
    value.re.abs().max(value.im.abs())
}

/// Whether two roots are the same but for rounding in both designs.
fn coincide(before: &[Complex<f64>], after: &[Complex<f64>]) -> bool {
    let mut pairs = (0..before.len()).flat_map(|i| (0..i).map(move |k| (i, k)));
    pairs.any(|(i, k)| touch(before[i], before[k]) && touch(after[i], after[k]))
}

/// The nearest of the values that are free, how far it is, and how far the next is that is not the same but for rounding.
fn nearest_two(value: Complex<f64>, all: &[Complex<f64>], taken: &[bool]) -> (usize, f64, f64) {
    let mut best = (0, f64::INFINITY);
    for (j, other) in all.iter().enumerate().filter(|(j, _)| !taken[*j]) {
        let off = (other - value).norm();
        if off < best.1 {
            best = (j, off);
        }
    }
    let others = all.iter().filter(|other| !touch(**other, all[best.0]));
    let second = others.map(|other| (other - value).norm());
    (best.0, best.1, second.fold(f64::INFINITY, f64::min))
}

/// The least distance of two roots that go straight.
fn least_on_way(before: Complex<f64>, after: Complex<f64>) -> f64 {
    let change = after - before;
    let share = -(before * change.conj()).re / change.norm_sqr();
    match share.is_finite() {
        true => (before + change * share.clamp(0.0, 1.0)).norm(),
        false => before.norm(),
    }
}
