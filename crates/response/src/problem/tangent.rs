//! The derivative of a motion by a number that its equations depend on.
//!
//! With rates M′, C′, K′ of the matrices, M x″ + C x′ + K x = f and M y″ + C y′ + K y = f′ − M′x″ − C′x′ − K′x are the equations of one
//! system, [M 0; M′ M] and so on: its state matrix is block-triangular, and its exponential has the derivative of the exponential
//! beside it (Van Loan 1978, *IEEE Trans. Autom. Control* 23; Najfeld & Havel 1995, *Adv. Appl. Math.* 16).

use eigentone_digits::DoubleDouble;
use eigentone_modes::{BuildError, MatrixKind, System};
use faer::Mat;

use super::channel::Channel;
use super::combination::Source;
use super::question::Problem;

const KINDS: [MatrixKind; 3] = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];

/// Where in a list of numbers those of each part are.
#[derive(PartialEq)]
struct Layout {
    n: usize,
    supports: usize,
    channels: usize,
    sources: usize,
}

impl Layout {
    fn of(problem: &Problem<'_>) -> Layout {
        Layout {
            n: problem.system().len(),
            supports: problem.system().supports().len(),
            channels: problem.channels().len(),
            sources: problem.sources().len(),
        }
    }

    fn matrix(&self, kind: usize) -> usize {
        kind * self.n * self.n
    }

    fn initial(&self, order: usize) -> usize {
        3 * self.n * self.n + order * self.n
    }

    fn channel(&self, channel: usize, order: usize) -> usize {
        self.initial(2) + (3 * channel + order) * self.n
    }

    fn source(&self, source: usize, order: usize) -> usize {
        self.channel(self.channels, 0) + (3 * source + order) * (self.n + self.supports)
    }

    fn len(&self) -> usize {
        self.source(self.sources, 0)
    }
}

impl<'a> Problem<'a> {
    /// The numbers of its equations: M, C, K, the initial state, where signals act, and what combinations are made of, in an order
    /// that is the same for problems alike but for numbers.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = vec![0.0; Layout::of(self).len()];
        self.each_number(|at, by| numbers[at] += by);
        numbers
    }

    /// By how much these numbers are more than those of another problem: what springs and dampers add to both is no part of the
    /// rounding. `None` for one with other matrices, signals or combinations than in number.
    pub fn numbers_beyond(&self, other: &Problem<'_>) -> Option<Vec<f64>> {
        let (layout, others) = (Layout::of(self), Layout::of(other));
        if layout != others {
            return None;
        }
        let mut numbers = vec![DoubleDouble::from(0.0); layout.len()];
        self.each_number(|at, by| numbers[at] += by.into());
        other.each_number(|at, by| numbers[at] -= by.into());
        Some(numbers.into_iter().map(DoubleDouble::to_f64).collect())
    }

    /// What each number is the sum of.
    fn each_number(&self, mut add: impl FnMut(usize, f64)) {
        let layout = Layout::of(self);
        for (k, kind) in KINDS.into_iter().enumerate() {
            let start = layout.matrix(k);
            for term in self.system().terms(kind) {
                add(start + term.row * layout.n + term.column, term.value);
            }
        }
        let initial = [self.initial_displacement(), self.initial_velocity()];
        for (order, values) in initial.into_iter().enumerate() {
            let start = layout.initial(order);
            (start..).zip(values).for_each(|(at, by)| add(at, *by));
        }
        for (at, channel) in self.channels().iter().enumerate() {
            for (order, direction) in channel.directions.iter().enumerate() {
                let start = layout.channel(at, order);
                direction.iter().for_each(|(row, by)| add(start + row, *by));
            }
        }
        for (at, source) in self.sources().iter().enumerate() {
            for (order, terms) in source.terms.iter().enumerate() {
                let start = layout.source(at, order);
                terms.iter().for_each(|(i, [a, b])| add(start + i, a * b));
            }
        }
    }

    /// The system of a motion beside its derivative, where its [`numbers`](Self::numbers) change at these rates. Of its 2n coordinates
    /// the first n are those of the motion, the others their derivatives.
    ///
    /// # Errors
    /// [`BuildError`] for a system that is [large](System::is_large), and for rates that are not finite.
    ///
    /// # Panics
    /// If there are not as many rates as numbers.
    pub fn tangent_system(&self, rates: &[f64]) -> Result<System, BuildError> {
        let layout = Layout::of(self);
        assert_eq!(rates.len(), layout.len(), "rates of other numbers");
        let n = layout.n;
        let mut builder = System::builder();
        for i in 0..2 * n {
            builder = builder.mass(format!("x{i}"), 0.0);
        }
        for i in 0..layout.supports {
            builder = builder.support(format!("u{i}"));
        }
        for (k, kind) in KINDS.into_iter().enumerate() {
            let mut matrix = Mat::<f64>::zeros(2 * n, 2 * n);
            for term in self.system().terms(kind) {
                matrix[(term.row, term.column)] += term.value;
                matrix[(n + term.row, n + term.column)] += term.value;
            }
            let start = layout.matrix(k);
            for i in 0..n {
                for j in 0..n {
                    matrix[(n + i, j)] = rates[start + i * n + j];
                }
            }
            builder = builder.matrix(kind, matrix.as_ref());
        }
        builder.build()
    }

    /// The motion beside its derivative, where the [`numbers`](Self::numbers) of the problem change at these rates, and loads and motions
    /// of supports do not: of the [`tangent_system`](Self::tangent_system) of the same rates. What the combinations of this problem are there are
    /// their derivatives.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, System};
    /// use eigentone_response::{Response, ResponsePlan, Step};
    ///
    /// let system = |k: f64| System::builder().mass("m", 1.0).spring(GROUND, "m", k).build();
    /// let (here, there) = (system(4.0)?, system(5.0)?);
    /// let question = |system| Response::of(system).load("m", Step::of(1.0)).every(0.5).until(2.0).problem();
    /// let (here, there) = (question(&here)?, question(&there)?);
    /// let rates = there.numbers_beyond(&here).expect("alike");
    /// let system = here.tangent_system(&rates)?;
    /// let problem = here.tangent(&system, &rates);
    /// let motion = ResponsePlan::of(&problem)?.run(&problem)?;
    /// // x = (1 − cos ωt)/k with ω² = k.
    /// let slope = (2f64.cos() - 1.0) / 16.0 + 2f64.sin() / 16.0;
    /// assert!((motion.displacement()[(1, 2)] - slope).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// If the system is that of another problem, or there are not as many rates as numbers.
    pub fn tangent<'b>(&self, system: &'b System, rates: &[f64]) -> Problem<'b> {
        let layout = Layout::of(self);
        let n = layout.n;
        assert!(
            rates.len() == layout.len() && system.len() == 2 * n,
            "of another problem"
        );
        let initial = [self.initial_displacement(), self.initial_velocity()];
        let initial = [0, 1].map(|order| {
            let start = layout.initial(order);
            [initial[order], &rates[start..start + n]].concat()
        });
        let channels = self.channels().iter().enumerate();
        let channels = channels.map(|(at, channel)| {
            let mut directions = channel.directions.clone();
            for (order, direction) in directions.iter_mut().enumerate() {
                let start = layout.channel(at, order);
                let changes = (0..n).map(|i| (n + i, rates[start + i]));
                direction.extend(changes.filter(|(_, by)| *by != 0.0));
            }
            Channel {
                directions,
                ..channel.clone()
            }
        });
        let sources = self.sources().iter().enumerate();
        let sources = sources.map(|(at, source)| {
            let mut changed = Source::default();
            for (order, terms) in source.terms.iter().enumerate() {
                let own = terms.iter().filter(|(i, _)| *i < n);
                changed.terms[order].extend(own.map(|(i, factors)| (n + i, *factors)));
                let start = layout.source(at, order);
                for i in 0..n + layout.supports {
                    let rate = rates[start + i];
                    let place = if i < n { i } else { n + i };
                    if rate != 0.0 {
                        changed.terms[order].push((place, [rate, 1.0]));
                    }
                }
            }
            changed
        });
        self.doubled(system, initial, channels.collect(), sources.collect())
    }
}
