//! Classically damped modes: real shapes, and one scalar quadratic for each.

use eigentone_digits::{DoubleDouble, Real, sort_by_number};
use faer::{Mat, MatRef};
use num_complex::Complex;

use crate::model::MatrixKind;
use crate::modes::Modes;
use crate::quality::real_forms::{Entries, RealForms};
use crate::system::System;

use super::modal_damping::modal_damping;
use super::mode_solver::{ModeSolver, ModesError, admit};
use super::real_mode::{RealMode, unit_shapes};
use super::roots::{Root, collect};
use super::{rigid, spring_factor, springless, symmetric};

/// The undamped modes, and for each the roots of mλ² + cλ + k with the modal mass, damping and
/// stiffness: for systems with C M⁻¹ K = K M⁻¹ C (Caughey & O'Kelly 1965, *J. Appl. Mech.* 32),
/// proved exactly.
#[derive(Clone, Copy, Debug)]
pub struct Classical;

impl ModeSolver for Classical {
    fn name(&self) -> &'static str {
        "classical modes"
    }

    fn refuses(&self, system: &System) -> Option<String> {
        let structure = system.structure();
        if structure.is_undamped() {
            return Some("there is no damping".to_owned());
        }
        if !structure.is_classical() {
            return Some(structure.why_not_classical().to_owned());
        }
        spring_factor::refuses_springs(system).and_then(|_| symmetric::refuses_matrices(system))
    }

    fn reason(&self) -> &'static str {
        "classically damped: damping leaves the undamped shapes as they are and couples none of them"
    }

    fn solve(&self, system: &System) -> Result<Modes, ModesError> {
        admit(self, system)?;
        let roots = modal_roots(self, system)?;
        Ok(collect(self, system, roots))
    }
}

/// The roots that each undamped shape has by itself; all there are where the damping is classical.
fn modal_roots(solver: &dyn ModeSolver, system: &System) -> Result<Vec<Root>, ModesError> {
    let mut roots = Vec::new();
    let mut at_rest = Vec::new();
    let mut all = modal_forms(solver, system, Entries::Plain)?;
    // How many motions at rest no damper holds is known; rounding leaves them the smallest c/m.
    let is_rigid = |mode: &&mut ModalForms| mode.rigid;
    let rigid = all.iter().filter(|mode| mode.rigid).count();
    let zeros = system.structure().zero_roots().unwrap_or(rigid).max(rigid);
    let mut held: Vec<&mut ModalForms> = all.iter_mut().filter(is_rigid).collect();
    let rate = |mode: &ModalForms| (mode.forms.c / mode.forms.m).to_f64().abs();
    sort_by_number(&mut held, |mode| rate(mode));
    for mode in held.into_iter().take(zeros - rigid) {
        mode.forms.c = DoubleDouble::ZERO;
    }
    let couplings = couplings(system, &all);
    let each = all.into_iter().zip(couplings);
    for (mode, coupling) in each {
        let ModalForms {
            shape,
            forms,
            rigid,
            error,
        } = mode;
        let [m_off, c_off, k_off] = forms.rounding;
        let (k, k_off) = if rigid {
            (DoubleDouble::ZERO, 0.0)
        } else {
            (forms.k, k_off)
        };
        let quadratic = Quadratic {
            m: forms.m,
            c: forms.c,
            k,
            rounding: [m_off, c_off, k_off],
        };
        if rigid {
            at_rest.push(complex(&shape));
        }
        let found = quadratic
            .roots((system.len() > 1).then_some(coupling))
            .into_iter()
            .filter(|root| root.value.norm() != 0.0);
        roots.extend(found.map(|mut root| {
            let least = error * root.value.norm();
            root.error = (root.error.0.max(least), root.error.1.max(least));
            root.with_shape(complex(&shape))
        }));
    }
    roots.extend(rigid::roots(at_rest, zeros));
    Ok(roots)
}

/// How far c/m of each shape may be off by what C couples it to others: those of nearly its frequency may be mixed in any
/// way. Of another a part θ is in it, so that C couples them by θΔ and c/m is off by θ²Δ, Δ being the difference of theirs.
fn couplings(system: &System, modes: &[ModalForms]) -> Vec<f64> {
    let square = |mode: &ModalForms| (mode.forms.k / mode.forms.m).to_f64();
    let near =
        |a: &ModalForms, b: &ModalForms| !a.rigid && !b.rigid && are_near(square(a), square(b));
    let groups = modes.chunk_by(near).enumerate();
    let group: Vec<usize> = groups
        .flat_map(|(number, group)| std::iter::repeat_n(number, group.len()))
        .collect();
    let unit = |mode: &ModalForms| -> Vec<f64> {
        let size = mode.forms.m.to_f64().sqrt();
        mode.shape.iter().map(|x| x / size).collect()
    };
    let shapes: Vec<Vec<f64>> = modes.iter().map(unit).collect();
    let gamma = modal_damping(system, shapes.iter().map(Vec::as_slice));
    let rate = |mode: &ModalForms| (mode.forms.c / mode.forms.m).to_f64();
    let rates: Vec<f64> = modes.iter().map(rate).collect();
    let off = |p: usize, q: usize| {
        let coupled = gamma[(p, q)].abs();
        let apart = (rates[p] - rates[q]).abs();
        if group[p] == group[q] {
            coupled
        } else {
            let turned = 2.0 * coupled / (apart + apart.hypot(2.0 * coupled)) * coupled;
            // Neither couples nor differs: 0/0.
            turned.min(apart)
        }
    };
    let others = |p: usize| (0..modes.len()).filter(move |q| *q != p);
    (0..modes.len())
        .map(|p| others(p).map(|q| off(p, q)).sum())
        .collect()
}

fn complex(shape: &[f64]) -> Vec<Complex<f64>> {
    shape.iter().map(|x| Complex::from(*x)).collect()
}

/// The roots that each undamped shape would have by itself, whatever the damping; `None` where
/// there are no real shapes.
pub(crate) fn uncoupled_roots(solver: &dyn ModeSolver, system: &System) -> Option<Vec<Root>> {
    let refused =
        || spring_factor::refuses_springs(system).and_then(|_| symmetric::refuses_matrices(system));
    if !system.structure().massless().is_empty() || refused().is_some() {
        return None;
    }
    modal_roots(solver, system).ok()
}

/// The real shapes of an undamped or classically damped system with their modal masses, dampings
/// and stiffnesses: m q″ + c q′ + k q = shape · f for each, by itself.
#[derive(Clone, Debug)]
pub struct ClassicalModes {
    shapes: Mat<f64>,
    mass: Vec<f64>,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
    rates: Vec<[DoubleDouble; 2]>,
}

impl ClassicalModes {
    /// The real modes, or `None` where the damping is not proved to be classical or M and K have
    /// none.
    ///
    /// # Errors
    /// [`ModesError`] where an iteration fails.
    pub fn of(system: &System) -> Result<Option<ClassicalModes>, ModesError> {
        ClassicalModes::by(system, Entries::Exact)
    }

    /// The same with shapes right to the last digit, which costs as much as proving them.
    pub(crate) fn refined(system: &System) -> Result<Option<ClassicalModes>, ModesError> {
        ClassicalModes::by(system, Entries::Refined)
    }

    fn by(system: &System, entries: Entries) -> Result<Option<ClassicalModes>, ModesError> {
        let structure = system.structure();
        let undamped = structure.is_undamped()
            && (spring_factor::refuses_springs(system).is_none()
                || symmetric::refuses_matrices(system).is_none());
        if !undamped && Classical.refuses(system).is_some() {
            return Ok(None);
        }
        let forms = modal_forms(&Classical, system, entries)?;
        let shapes = Mat::from_fn(system.len(), forms.len(), |i, j| forms[j].shape[i]);
        let value = |pick: fn(&ModalForms) -> f64| forms.iter().map(pick).collect();
        let rates = forms.iter().map(|mode| {
            let (m, c, k) = (mode.forms.m, mode.forms.c, mode.forms.k);
            let stiffness = if mode.rigid { DoubleDouble::ZERO } else { k };
            [stiffness / m, c / m]
        });
        Ok(Some(ClassicalModes {
            rates: rates.collect(),
            shapes,
            mass: value(|mode| mode.forms.m.to_f64()),
            damping: value(|mode| mode.forms.c.to_f64()),
            stiffness: value(|mode| {
                if mode.rigid {
                    0.0
                } else {
                    mode.forms.k.to_f64()
                }
            }),
        }))
    }

    /// The shapes (n × modes), each with largest entry 1, by rising frequency.
    pub fn shapes(&self) -> MatRef<'_, f64> {
        self.shapes.as_ref()
    }

    /// Modal masses in kg.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Modal dampings in N·s/m.
    pub fn damping(&self) -> &[f64] {
        &self.damping
    }

    /// Modal stiffnesses in N/m; exactly 0 for rigid-body modes.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// k/m in 1/s² and c/m in 1/s of each mode, from the elements in double-double: as Rayleigh
    /// quotients they err by the square of what the shapes do, so that a motion of very many
    /// periods keeps its phase.
    pub fn rates(&self) -> &[[DoubleDouble; 2]] {
        &self.rates
    }
}

/// A real shape with its forms.
struct ModalForms {
    /// Its largest entry is exactly 1, which keeps the forms of a single mass exact.
    shape: Vec<f64>,
    forms: RealForms,
    rigid: bool,
    /// The least relative error that a root is given.
    error: f64,
}

/// The undamped modes, from the springs where the system is built of them.
pub(crate) fn undamped_modes(
    solver: &dyn ModeSolver,
    system: &System,
    entries: Entries,
) -> Result<Vec<RealMode>, ModesError> {
    match spring_factor::refuses_springs(system) {
        None => {
            let modes = spring_factor::real_modes(solver, system)?;
            match entries {
                Entries::Refined => symmetric::with_right_shapes(solver, system, modes),
                Entries::Plain | Entries::Exact => Ok(modes),
            }
        }
        Some(_) => symmetric::real_modes(solver, system, entries),
    }
}

/// The same; among those of one frequency, ones that C does not couple. Those of nearly one frequency are mixed too, which
/// only a C that couples none of another frequency allows.
pub(crate) fn real_modes(
    solver: &dyn ModeSolver,
    system: &System,
    entries: Entries,
) -> Result<Vec<RealMode>, ModesError> {
    let mut modes = undamped_modes(solver, system, entries)?;
    separate(system, &mut modes, entries);
    Ok(modes)
}

/// The real shapes that neither K nor C couples.
fn modal_forms(
    solver: &dyn ModeSolver,
    system: &System,
    entries: Entries,
) -> Result<Vec<ModalForms>, ModesError> {
    if let Some(undamped) = springless::with_dampers_for_springs(system) {
        return relaxing_forms(solver, system, &undamped, entries);
    }
    let modes = real_modes(solver, system, entries)?;
    // Where C or K all but annuls a shape, its form is what the shape's error makes of it: some roundings of each entry, squared.
    let slip = |kind: MatrixKind| {
        let mut sums = vec![0.0; system.len()];
        for term in system.terms(kind) {
            sums[term.row] += term.value.abs();
        }
        let largest = sums.into_iter().fold(0.0, f64::max);
        16.0 * system.len() as f64 * f64::EPSILON * f64::EPSILON * largest
    };
    let [of_damping, of_stiffness] = [MatrixKind::Damping, MatrixKind::Stiffness].map(slip);
    let form = |mode: RealMode| {
        let mut forms = mode.forms;
        if mode.is_exact {
            return ModalForms {
                shape: mode.shape,
                forms,
                rigid: mode.rigid,
                error: 0.0,
            };
        }
        let size: f64 = mode.shape.iter().map(|x| x * x).sum();
        forms.rounding[1] += of_damping * size;
        // A square beyond the range of doubles says nothing of the quotient.
        if !mode.square.is_normal() || mode.is_confirmed_by(forms.k / forms.m) {
            forms.rounding[2] += of_stiffness * size;
        } else {
            forms.k = forms.m * mode.square;
            forms.rounding[2] = 2.0 * mode.doubt * forms.k.to_f64().abs();
        }
        ModalForms {
            shape: mode.shape,
            forms,
            rigid: mode.rigid,
            error: 0.0,
        }
    };
    Ok(modes.into_iter().map(form).collect())
}

/// Those of a system without springs, given the undamped one that has the dampers for springs.
/// Shapes as near to each other as those of stiff dampers do not determine c: unless they confirm its
/// ratio to m, that is what the dampers' factor makes it.
fn relaxing_forms(
    solver: &dyn ModeSolver,
    system: &System,
    undamped: &System,
    entries: Entries,
) -> Result<Vec<ModalForms>, ModesError> {
    let modes = real_modes(solver, undamped, entries)?;
    let shapes = modes.iter().map(|mode| mode.shape.clone()).collect();
    let formed = unit_shapes(system, shapes, entries);
    let form = |(mode, (shape, mut forms)): (&RealMode, (Vec<f64>, RealForms))| {
        if mode.rigid || !mode.is_confirmed_by(forms.c / forms.m) {
            forms.c = forms.m * mode.square;
        }
        ModalForms {
            shape,
            forms,
            rigid: true,
            error: mode.square_error(),
        }
    };
    Ok(modes.iter().zip(formed).map(form).collect())
}

/// Among shapes of (nearly) one frequency any mixture solves the undamped problem; rotates them to
/// those that C does not couple.
fn separate(system: &System, modes: &mut [RealMode], entries: Entries) {
    sort_by_number(modes, |mode| mode.square);
    let near = |a: &RealMode, b: &RealMode| are_near(a.square, b.square);
    // Each mode is near the one before it.
    for group in modes.chunk_by_mut(near) {
        if group.len() > 1 {
            uncouple(system, group, near, entries);
        }
    }
}

fn are_near(a: f64, b: f64) -> bool {
    const NEAR: f64 = 1e-6;
    (b - a).abs() <= NEAR * b.abs().max(a.abs())
}

/// Jacobi's rotations of shapes of modal mass 1 until C couples none that are near.
fn uncouple(
    system: &System,
    modes: &mut [RealMode],
    near: impl Fn(&RealMode, &RealMode) -> bool,
    entries: Entries,
) {
    const COUPLED: f64 = 1e-13;
    const SWEEPS: usize = 30;
    let normalised = modes
        .iter()
        .map(|mode| mode.clone().mass_normalised().shape);
    let mut shapes: Vec<Vec<f64>> = normalised.collect();
    let mut gamma = modal_damping(system, shapes.iter().map(Vec::as_slice));
    // K of the shapes but for the same multiple of M, of which rounding leaves small squares nothing.
    let first = modes[0].square;
    let mut squares = Mat::from_fn(modes.len(), modes.len(), |i, j| match i == j {
        true => modes[i].square - first,
        false => 0.0,
    });
    let mut rotated = false;
    for _ in 0..SWEEPS {
        let mut again = false;
        for q in 1..shapes.len() {
            for p in (0..q).filter(|p| near(&modes[*p], &modes[q])) {
                let (a, b, g) = (gamma[(p, p)], gamma[(q, q)], gamma[(p, q)]);
                if g.abs() <= COUPLED * (a.abs() + b.abs()) {
                    continue;
                }
                again = true;
                let zeta = (b - a) / (2.0 * g);
                let t = zeta.signum() / (zeta.abs() + 1f64.hypot(zeta));
                let cosine = 1.0 / 1f64.hypot(t);
                let sine = cosine * t;
                let turn = |x: &mut f64, y: &mut f64| {
                    (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
                };
                let (before, rest) = shapes.split_at_mut(q);
                let both = before[p].iter_mut().zip(rest[0].iter_mut());
                both.for_each(|(x, y)| turn(x, y));
                for form in [&mut gamma, &mut squares] {
                    for i in 0..form.nrows() {
                        let (mut x, mut y) = (form[(i, p)], form[(i, q)]);
                        turn(&mut x, &mut y);
                        (form[(i, p)], form[(i, q)]) = (x, y);
                    }
                    for i in 0..form.nrows() {
                        let (mut x, mut y) = (form[(p, i)], form[(q, i)]);
                        turn(&mut x, &mut y);
                        (form[(p, i)], form[(q, i)]) = (x, y);
                    }
                }
            }
        }
        rotated |= again;
        if !again {
            break;
        }
        // From the shapes anew, so that rounding does not build up.
        gamma = modal_damping(system, shapes.iter().map(Vec::as_slice));
    }
    if rotated {
        let doubt = modes
            .iter()
            .fold(0.0, |most: f64, mode| most.max(mode.doubt));
        let turned = unit_shapes(system, shapes, entries).enumerate();
        for (mode, (i, (shape, forms))) in modes.iter_mut().zip(turned) {
            (mode.shape, mode.forms, mode.doubt) = (shape, forms, doubt);
            mode.is_exact = false;
            mode.square = first + squares[(i, i)];
        }
    }
}

/// The nonzero roots of mλ² + cλ + k with Im ≥ 0, where m or c is positive.
pub(crate) fn scalar_roots(m: f64, c: f64, k: f64) -> Vec<Complex<f64>> {
    if m == 0.0 {
        return if c == 0.0 || k == 0.0 {
            Vec::new()
        } else {
            vec![Complex::from(-k / c)]
        };
    }
    let [m, c, k] = [m, c, k].map(DoubleDouble::from);
    let quadratic = Quadratic {
        m,
        c,
        k,
        rounding: [0.0; 3],
    };
    let roots = quadratic.roots(None).into_iter();
    let each = roots.flat_map(|root| std::iter::repeat_n(root.value, root.count));
    each.filter(|value| value.norm() != 0.0 && value.is_finite())
        .collect()
}

/// mλ² + cλ + k with m > 0.
struct Quadratic {
    m: DoubleDouble,
    c: DoubleDouble,
    k: DoubleDouble,
    /// About how far m, c and k may be off beyond the rounding to doubles.
    rounding: [f64; 3],
}

/// A root of a [`Quadratic`] with Im ≥ 0.
struct ScalarRoot {
    value: Complex<f64>,
    count: usize,
    error: (f64, f64),
}

impl ScalarRoot {
    fn with_shape(self, shape: Vec<Complex<f64>>) -> Root {
        Root {
            count: self.count,
            error: Some(self.error),
            ..Root::simple(self.value, shape)
        }
    }
}

impl Quadratic {
    /// The roots without cancellation. A discriminant that the coefficients' own error hides is
    /// taken for critical damping. Coefficients are exact, or known to rounding, what else they are off by, and c/m to a
    /// coupling more.
    fn roots(&self, coupling: Option<f64>) -> Vec<ScalarRoot> {
        const HIDDEN: f64 = 1e-28;
        let Quadratic { m, c, k, rounding } = *self;
        // In units in which the larger of c and √(mk) is about 1 and m too: squares stay within the doubles.
        let log2 = |x: DoubleDouble| x.to_f64().abs().log2();
        let unit = log2(c).max(0.5 * (log2(m) + log2(k))).round();
        let unit = if unit.is_finite() { unit as i64 } else { 0 };
        let of_mass = log2(m).round() as i64;
        let (c1, m1, k1) = (
            c.scale(-unit),
            m.scale(-of_mass),
            k.scale(of_mass - 2 * unit),
        );
        let discriminant = c1 * c1 - m1 * k1 * 4.0;
        let hidden = coupling.map_or(0.0, |_| HIDDEN);
        let size = (c1 * c1).to_f64().max((m1 * k1).to_f64().abs());
        let ulp = 4.0 * f64::EPSILON;
        let [m_off, c_off, k_off] = rounding;
        // What the coefficients may be off, relative, moves the roots the more the nearer they are to each other.
        let error = |value: f64| {
            let rounding = ulp * value.abs() + f64::from_bits(1);
            let Some(coupling) = coupling else {
                return rounding;
            };
            let (m1, c1, k1) = (m1.to_f64(), c1.to_f64().abs(), k1.to_f64().abs());
            let scaled = value.abs().scale(of_mass - unit);
            let coupling = coupling.scale(of_mass - unit);
            let off = m_off.scale(-of_mass) * scaled * scaled
                + c_off.scale(-unit) * scaled
                + k_off.scale(of_mass - 2 * unit);
            let change = (ulp * (scaled * c1 + k1) + off) / m1 + scaled * coupling;
            let gap = discriminant.to_f64().abs().sqrt() / m1;
            let moved = if 16.0 * change <= gap * gap {
                2.0 * change / gap
            } else {
                0.5 * gap + (0.25 * gap * gap + change).sqrt()
            };
            rounding.max(moved.scale(unit - of_mass))
        };
        // A root that is not 0 keeps its sign where it leaves the range of doubles.
        let rounded = |value: DoubleDouble, is_positive: bool| match value.to_f64() {
            0.0 => f64::from_bits(1).copysign(if is_positive { 1.0 } else { -1.0 }),
            value => value,
        };
        if discriminant.to_f64().abs() <= hidden * size {
            let value = (-c / (m * 2.0)).to_f64();
            let error = error(value);
            return vec![ScalarRoot {
                value: Complex::from(value),
                count: 2,
                error: (error, error),
            }];
        }
        if discriminant.to_f64() < 0.0 {
            let re = (-c / (m * 2.0)).to_f64();
            let im = ((-discriminant).sqrt().scale(unit) / (m * 2.0)).to_f64();
            let value = Complex::new(re, im);
            let whole = error(value.norm());
            // That of c/m, as long as the roots stay complex.
            let [m, c] = [m, c].map(DoubleDouble::to_f64);
            let off = (c_off + m_off * (c / m).abs()) / m + coupling.unwrap_or(0.0);
            let quotient = ulp * re.abs() + off;
            let real = if whole < im { quotient } else { whole };
            return vec![ScalarRoot {
                value,
                count: 1,
                error: (whole, real),
            }];
        }
        let root = discriminant.sqrt().scale(unit);
        let sum = if c.to_f64() < 0.0 {
            root - c
        } else {
            -c - root
        };
        let grows = |x: DoubleDouble| x > DoubleDouble::ZERO;
        let large = rounded(sum / (m * 2.0), grows(sum));
        let small = if k == DoubleDouble::ZERO {
            0.0
        } else {
            rounded(k * 2.0 / sum, grows(k) == grows(sum))
        };
        [large, small]
            .map(|value| ScalarRoot {
                value: Complex::from(value),
                count: 1,
                error: (error(value), error(value)),
            })
            .into()
    }
}
