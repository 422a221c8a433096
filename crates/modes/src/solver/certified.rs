//! From modes in doubles to modes with proven bounds.

use eigentone_digits::sort_by_number;
use num_complex::Complex;

use crate::inclusion::bounded_shape::Shape;
use crate::inclusion::quadratic::Damped;
use crate::inclusion::slow::Slow;
use crate::inclusion::{
    Approximation, at_rest, certify, classical as classically, congruence, pairs, rayleigh,
    shapes_at, springless,
};
use crate::modes::{Bounds, Mode, ModePlan, Modes, Repeats};
use crate::quality::real_forms::Entries;
use crate::system::System;

use super::mode_solver::ModeSolver;
use super::proof::{Proof, looseness, width};
use super::roots::{Root, collect, collect_proven};
use super::springless::with_dampers_for_springs;
use super::{classical, rigid};

/// Above this many coordinates the O(n⁴) of an elimination at every root is too expensive.
const LARGEST: usize = 64;

/// Below this many determinants with 32 digits are as quick as what takes O(n³).
const SMALLEST: usize = 24;

/// So many operations may go into determinants: some seconds.
const MOST_WORK: f64 = 4e9;

/// The same modes with eigenvalues that carry proven bounds, or the modes as they are, with the
/// reason in their plan.
pub(crate) fn certified(
    solver: &dyn ModeSolver,
    system: &System,
    modes: Modes,
    tolerance: f64,
) -> Modes {
    let structure = system.structure();
    let n = system.len();
    let proof = proof(&Question {
        solver,
        system,
        modes: modes.as_slice(),
        tolerance,
    });
    let Some(Proof {
        mut roots,
        mut claim,
        shapes_may_gain,
    }) = proof
    else {
        let reason = if n > LARGEST {
            format!(
                "no separate discs from roots and shapes in 32 digits; {n} coordinates are more than \
                 the {LARGEST} for which there are more"
            )
        } else {
            "no separate discs were reached with the digits at hand".to_owned()
        };
        return without_proof(modes, reason);
    };
    if roots.is_empty() {
        claim = "every root is exactly 0".to_owned();
    }
    // The proof excludes 0 from its discs; how many roots lie there is known exactly.
    let zeros = structure.zero_roots().unwrap_or(0);
    let shapes = || {
        let floating = rigid::shapes(system);
        let at_zero = modes
            .iter()
            .filter(|mode| mode.eigenvalue().value.norm() == 0.0);
        let solved: Vec<_> = at_zero.map(|mode| mode.shape().to_vec()).collect();
        if floating.is_empty() {
            solved
        } else {
            floating
        }
    };
    if n <= LARGEST {
        let wanted = |root: &Root| {
            if shapes_may_gain {
                looseness(root) > 0.5 * tolerance
            } else {
                root.shape_bound.is_none()
            }
        };
        let open = |root: &&mut Root| root.repeats == Some(Repeats::SIMPLE) && wanted(root);
        let open = roots.iter_mut().filter(open).collect();
        enclose_shapes(system, open, tolerance);
    }
    if zeros > 0 {
        let mut still = rigid::roots(shapes(), zeros);
        if let [root] = still.as_mut_slice() {
            enclose_at_rest(system, root, tolerance);
        }
        roots.extend(still);
    }
    with_plan(modes.plan, &claim, collect_proven(solver, system, roots))
}

fn with_plan(mut plan: ModePlan, claim: &str, modes: Modes) -> Modes {
    plan.bounds = format!("proven: {claim}");
    Modes { plan, ..modes }
}

/// The modes of few coordinates, none of which is at rest, from their roots as a solver leaves them: the proof improves what it
/// proves. `None` where it proves not every root to be simple and within the tolerance.
pub(crate) fn one_by_one(
    solver: &dyn ModeSolver,
    plan: ModePlan,
    system: &System,
    roots: &[Root],
    tolerance: f64,
) -> Option<Modes> {
    if system.len() >= SMALLEST {
        return None;
    }
    let proof = in_discs(system, roots, tolerance, 0.0)?;
    if proof.roots.iter().any(|root| root.shape_bound.is_none()) {
        return None;
    }
    let modes = collect_proven(solver, system, proof.roots);
    Some(with_plan(plan, &proof.claim, modes))
}

/// The modes of a system that doubles do not solve, from no more than guesses at the sizes of its roots; `None` where
/// not every root is proved, with its shape.
pub(crate) fn from_guesses(
    solver: &dyn ModeSolver,
    system: &System,
    tolerance: f64,
) -> Option<Modes> {
    let structure = system.structure();
    let zeros = structure.zero_roots()?;
    let count = structure.finite_roots()? - zeros;
    if system.len() > LARGEST || count == 0 {
        return None;
    }
    let mut sizes = lone_sizes(system);
    sort_by_number(&mut sizes, |size| *size);
    // Conjugate pairs all about 0, and one real root where their number is odd.
    let guess = |pair: usize| {
        let size = sizes
            .get(2 * pair * sizes.len() / count)
            .copied()
            .unwrap_or(1.0);
        let turn = if 2 * pair + 1 == count {
            0.0
        } else {
            0.4 + 2.6 * pair as f64 / count as f64
        };
        let mut shape = vec![Complex::ZERO; system.len()];
        shape[pair % system.len()] = Complex::ONE;
        let value = -Complex::from_polar(size, -turn);
        Root::simple(
            if turn == 0.0 {
                Complex::from(-size)
            } else {
                value
            },
            shape,
        )
    };
    let mut guesses = collect(solver, system, (0..count.div_ceil(2)).map(guess).collect());
    guesses.plan.solver = "simultaneous iteration";
    guesses.plan.reason =
        "doubles do not solve it: all roots at once, from guesses at their sizes, \
                           with more digits"
            .to_owned();
    // What doubles hide in the matrices shapes show only at roots that are known far better.
    const CLOSE: f64 = 1e-24;
    let modes = certified(solver, system, guesses, tolerance.min(CLOSE));
    // Shapes that are not bounded are still those of guesses.
    let is_known =
        |mode: &Mode| mode.eigenvalue().value.norm() == 0.0 || mode.shape_bound().is_some();
    let is_proven = modes.bounds() == Bounds::Proven && modes.iter().all(is_known);
    is_proven.then_some(modes)
}

/// Bounds the shapes of simple roots that their proof left without, or with wide ones.
fn enclose_shapes(system: &System, open: Vec<&mut Root>, tolerance: f64) {
    let bound = |root: &Root| root.error.map_or(f64::INFINITY, |(bound, _)| bound);
    let discs: Vec<(Complex<f64>, f64)> =
        open.iter().map(|root| (root.value, bound(root))).collect();
    let found = shapes_at(system, &discs, tolerance);
    for (root, shapes) in open.into_iter().zip(found) {
        if let Some(shapes) = shapes
            && shapes.right.looseness() < looseness(root)
        {
            root.enclose(shapes);
        }
    }
}

/// Bounds the shape at λ = 0, where there is one alone.
fn enclose_at_rest(system: &System, root: &mut Root, tolerance: f64) {
    let moves_whole =
        matches!(system.structure().null_vectors().as_slice(), [vector] if vector.is_whole());
    // What proved the other roots at once found as many elastic shapes as leave one for λ = 0.
    let counted = system.len() > LARGEST && moves_whole;
    let found = (system.len() <= LARGEST)
        .then(|| at_rest(system, tolerance))
        .flatten();
    if moves_whole && (counted || found.is_some()) {
        root.shape_bound = Some(vec![0.0; system.len()]);
    } else if let Some(found) = found {
        root.shape = found.right.shape;
        root.shape_bound = Some(found.right.bounds);
    }
}

/// The modes that are to be proved, in doubles, and how closely.
#[derive(Clone, Copy)]
struct Question<'a> {
    solver: &'a dyn ModeSolver,
    system: &'a System,
    modes: &'a [Mode],
    tolerance: f64,
}

/// The best that proofs give for each root, the quickest first, until all roots are within the tolerance.
fn proof(question: &Question<'_>) -> Option<Proof> {
    let n = question.system.len();
    let is_open = |best: &Option<Proof>| {
        let best = best.as_ref();
        best.is_none_or(|best| !best.is_within(question.tolerance))
    };
    let better = |best: Option<Proof>, found: Option<Proof>| match (best, found) {
        (Some(best), Some(found)) => Some(best.merged(found, question.tolerance)),
        (best, found) => best.or(found),
    };
    let mut best = by_real_shapes(question);
    // Where all shapes are real, pairs of them know no more.
    let undamped = best.is_some() && question.system.structure().is_undamped();
    if n >= SMALLEST && is_open(&best) && !undamped {
        let one_by_one = (n <= LARGEST)
            .then(|| {
                in_discs(
                    question.system,
                    &moving(question.modes),
                    question.tolerance,
                    0.0,
                )
            })
            .flatten();
        best = better(best, one_by_one);
        if is_open(&best) {
            best = better(best, by_pairs(question));
        }
    }
    // What damping by modes leaves open, such as a pair at a ratio of 1, the rounding of its matrix would decide.
    let rounded = best.is_some() && question.system.structure().is_by_modes();
    if n <= LARGEST && is_open(&best) && !rounded {
        let found = by_determinants(question, best.as_ref());
        best = better(best, found);
    }
    best
}

/// By undamped shapes, or by those of λM + C without springs.
fn by_real_shapes(question: &Question<'_>) -> Option<Proof> {
    at_once(question)
        .or_else(|| without_springs(question))
        .or_else(|| by_undamped_shapes(question))
}

/// Whether some roots are so small beside the largest that doubles hardly know them.
fn has_unknown(modes: &[Mode]) -> bool {
    /// Of the largest root.
    const UNKNOWN: f64 = 1e-7;
    let sizes = modes.iter().map(|mode| mode.eigenvalue().value.norm());
    let largest = sizes.clone().fold(0.0, f64::max);
    let is_unknown = |size: f64| size > 0.0 && size <= UNKNOWN * largest;
    sizes.into_iter().any(is_unknown)
}

/// By roots and shapes, as they are given, with the slow ones from a system of their own, or of damping taken to be classical,
/// which it may be but for rounding.
fn by_pairs(question: &Question<'_>) -> Option<Proof> {
    let (system, modes) = (question.system, question.modes);
    let given = || paired(system, modes, None, question.tolerance);
    let with_slow = || {
        let slow = slow(question.solver, system)?;
        let modes = with_slow_roots(question.solver, system, &slow, modes);
        paired(system, &modes, Some(&slow), question.tolerance)
    };
    let found = if has_unknown(modes) {
        with_slow().or_else(given)
    } else {
        given().or_else(with_slow)
    };
    found.or_else(|| {
        let modes = uncoupled(question.solver, system)?;
        paired(system, &modes, None, question.tolerance)
    })
}

/// By discs about the roots that are proved already; where these are not isolated, about those given, the slow ones from a system
/// of their own where doubles hardly know them, or about those of damping taken to be classical.
fn by_determinants(question: &Question<'_>, known: Option<&Proof>) -> Option<Proof> {
    let (solver, system) = (question.solver, question.system);
    let tolerance = question.tolerance;
    // Doubles know more of the roots in a wide disc than that they lie there.
    let is_vague = |root: &Root| root.repeats != Some(Repeats::SIMPLE) && width(root) > tolerance;
    let known = known.filter(|known| !known.roots.iter().any(is_vague));
    if let Some(known) = known {
        return in_discs(system, &known.roots, tolerance, MOST_WORK);
    }
    let about = |modes: &[Mode]| in_discs(system, &moving(modes), tolerance, MOST_WORK);
    // Points far from their roots creep there, sweep by sweep and level by level.
    let with_slow = || {
        if !has_unknown(question.modes) {
            return None;
        }
        let one_by_one = in_discs(system, &moving(question.modes), tolerance, 0.0);
        one_by_one.or_else(|| {
            let modes = with_slow_roots(solver, system, &slow(solver, system)?, question.modes);
            let values = |modes: &[Mode]| -> Vec<Complex<f64>> {
                modes.iter().map(|mode| mode.eigenvalue().value).collect()
            };
            let is_new = values(&modes) != values(question.modes);
            is_new.then(|| about(&modes)).flatten()
        })
    };
    with_slow()
        .or_else(|| about(question.modes))
        .or_else(|| about(&uncoupled(solver, system)?))
}

/// The roots of modes that are not at rest.
fn moving(modes: &[Mode]) -> Vec<Root> {
    let root = |mode: &Mode| Root {
        count: mode.roots(),
        error: mode.eigenvalue().bound.map(|bound| (bound, f64::INFINITY)),
        ..Root::simple(mode.eigenvalue().value, mode.shape().to_vec())
    };
    let moving = modes
        .iter()
        .filter(|mode| mode.eigenvalue().value.norm() > 0.0);
    moving.map(root).collect()
}

/// Of an undamped system, by its shapes.
fn at_once(question: &Question<'_>) -> Option<Proof> {
    let found = congruence::certify(question.system, question.modes, question.tolerance)?;
    let claim =
        "what K and M have off the diagonal in coordinates of the modes, computed with 32 digits";
    Some(each_alone(found, claim))
}

/// Of a system that is classically damped, or would be but for nodes without mass, by its undamped shapes.
fn by_undamped_shapes(question: &Question<'_>) -> Option<Proof> {
    let Question {
        solver,
        system,
        tolerance,
        ..
    } = *question;
    let structure = system.structure();
    if structure.is_undamped() {
        return None;
    }
    if !structure.is_classical() {
        structure.law_with_massless()?;
        let undamped = System::from(system.model().without_dampers());
        let shapes = elastic_shapes(solver, &undamped)?;
        return in_proportion(system, &undamped, shapes, tolerance);
    }
    let shapes = elastic_shapes(solver, system)?;
    in_proportion(system, system, shapes.clone(), tolerance).or_else(|| {
        let found = classically::certify(system, shapes, tolerance)?;
        let claim = "what K, C and M have off the diagonal in coordinates of the undamped modes, computed with 32 digits";
        Some(each_alone(found, claim))
    })
}

fn in_proportion(
    system: &System,
    undamped: &System,
    shapes: Vec<Vec<f64>>,
    tolerance: f64,
) -> Option<Proof> {
    let found = rayleigh::certify(system, undamped, shapes, tolerance)?;
    let claim = "what K and M have off the diagonal in coordinates of the undamped modes, computed with 32 digits; \
                 the damping follows exactly";
    Some(each_alone(found, claim))
}

/// Of a system without springs, by the shapes of the undamped one that has the dampers for springs:
/// λ = −ω².
fn without_springs(question: &Question<'_>) -> Option<Proof> {
    let undamped = with_dampers_for_springs(question.system)?;
    let shapes = elastic_shapes(question.solver, &undamped)?;
    let found = springless::certify(&undamped, shapes, question.tolerance)?;
    let claim = "what the shapes of λM + C leave of C and M off the diagonal, with 32 digits";
    Some(each_alone(found, claim))
}

/// Undamped shapes that K resists.
fn elastic_shapes(solver: &dyn ModeSolver, system: &System) -> Option<Vec<Vec<f64>>> {
    let modes = classical::real_modes(solver, system, Entries::Exact).ok()?;
    let elastic = modes.into_iter().filter(|mode| !mode.rigid);
    Some(elastic.map(|mode| mode.shape).collect())
}

/// The proof of modes that move each by itself.
fn each_alone(found: Vec<Damped>, claim: &str) -> Proof {
    let root = |found: Damped| Root {
        count: found.roots,
        repeats: Some(match found.coincide {
            true => Repeats::Exactly {
                count: found.multiplicity,
                defective: Some(false),
            },
            false => of_disc(found.multiplicity),
        }),
        error: Some((found.bound, found.real_bound)),
        ..with_shape(found.value, found.shape)
    };
    Proof {
        roots: found.into_iter().map(root).collect(),
        claim: claim.to_owned(),
        shapes_may_gain: false,
    }
}

/// Of a system with a mass or a damper wherever it moves, by its roots and shapes.
fn paired(system: &System, modes: &[Mode], slow: Option<&Slow>, tolerance: f64) -> Option<Proof> {
    let mut roots = Vec::new();
    for found in pairs::certify(system, modes, slow, tolerance)? {
        let count = found.members.len();
        for member in found.members {
            let shape = || Shape {
                components: modes[member].shape().to_vec(),
                bounds: None,
            };
            let (left, left_bound) = match found.left.clone() {
                Some(left) => (Some(left.components), left.bounds),
                None => (None, None),
            };
            roots.push(Root {
                repeats: Some(of_disc(count)),
                error: Some((found.bound, found.real_bound)),
                left,
                left_bound,
                ..with_shape(found.value, found.shape.clone().unwrap_or_else(shape))
            });
        }
    }
    Some(Proof {
        roots,
        claim: "what roots and shapes leave of M, C and K off the diagonal of the states, with 32 \
                digits"
            .to_owned(),
        shapes_may_gain: true,
    })
}

/// Of any system, by discs about approximate roots, until those that are not within the tolerance yet are.
fn in_discs(system: &System, known: &[Root], tolerance: f64, most_work: f64) -> Option<Proof> {
    let (found, digits) = discs(system, known, tolerance, most_work)?;
    Some(Proof {
        roots: found.into_iter().flat_map(|disc| disc.roots).collect(),
        claim: format!(
            "discs in the complex plane that contain all roots, computed with {digits} digits"
        ),
        shapes_may_gain: false,
    })
}

/// What a disc holds.
pub(super) struct InDisc {
    /// The approximate roots that its own ones belong to.
    pub(super) owners: Vec<usize>,
    pub(super) roots: Vec<Root>,
}

/// The same by discs, and the decimal digits that it took.
pub(super) fn discs(
    system: &System,
    known: &[Root],
    tolerance: f64,
    most_work: f64,
) -> Option<(Vec<InDisc>, usize)> {
    // Approximations of all nonzero roots, and the one that each belongs to.
    let mut approximations = Vec::new();
    let mut owner = Vec::new();
    for (index, root) in known.iter().enumerate() {
        let value = root.value;
        // The points of a cluster start on a circle as wide as it is uncertain, those of all roots with one value on the same.
        let alike = |other: &&Root| other.value == value;
        let roots = |roots: &[Root]| {
            roots
                .iter()
                .filter(alike)
                .map(|root| root.count)
                .sum::<usize>()
        };
        let (count, before) = (roots(known), roots(&known[..index]));
        let reach = root.error.map_or(f64::INFINITY, |(bound, _)| bound);
        let reach = reach.min(0.1 * value.norm());
        let is_wanted = width(root) > tolerance;
        for turn in before..before + root.count {
            let angle = 0.4 + std::f64::consts::TAU * turn as f64 / count as f64;
            let offset = if count > 1 {
                Complex::from_polar(reach, angle)
            } else {
                Complex::ZERO
            };
            let point = value + offset;
            let approximation = Approximation {
                value: point,
                is_wanted,
                shape: if count == 1 { &root.shape } else { &[] },
            };
            approximations.push(approximation);
            owner.push(index);
            if value.im != 0.0 {
                approximations.push(Approximation {
                    value: point.conj(),
                    ..approximation
                });
                owner.push(index);
            }
        }
    }
    let (found, digits) = certify(system, &approximations, tolerance, most_work)?;
    let each = found.into_iter().map(|certificate| {
        let members = certificate.members.iter();
        let mut owners: Vec<usize> = members.map(|member| owner[*member]).collect();
        owners.sort_unstable();
        owners.dedup();
        let count = certificate.members.len();
        // As many shapes as roots: they coincide, but nothing is missing.
        let complete = owners.len() == count;
        let entries = if complete { count } else { 1 };
        let mut shapes = certificate.shapes.filter(|_| entries == 1);
        let root = |owner: &usize| {
            let mut found = Root {
                count: count / entries,
                repeats: Some(of_disc(count)),
                error: Some((certificate.bound, certificate.real_bound)),
                ..Root::simple(certificate.value, Vec::new())
            };
            match shapes.take() {
                Some(shapes) => found.enclose(shapes),
                None => found.shape = known[*owner].shape.clone(),
            }
            found
        };
        let roots = owners.iter().take(entries).map(root).collect();
        InDisc { owners, roots }
    });
    Some((each.collect(), digits))
}

/// Modes as if C did not couple the undamped shapes: crude, but of the right size however stiff the
/// system, where its state matrix has lost all digits.
fn uncoupled(solver: &dyn ModeSolver, system: &System) -> Option<Vec<Mode>> {
    if system.structure().is_undamped() {
        return None;
    }
    let roots = classical::uncoupled_roots(solver, system)?;
    Some(collect(solver, system, roots).as_slice().to_vec())
}

/// Shapes that K hardly resists, of a damped system with symmetric M and K.
fn slow(solver: &dyn ModeSolver, system: &System) -> Option<Slow> {
    let structure = system.structure();
    if structure.is_undamped() {
        return None;
    }
    // Nodes without mass that dampers hold back would not follow at once.
    if structure.is_symmetric() && structure.damped_massless().is_empty() {
        return Slow::of(system, elastic_shapes(solver, system)?);
    }
    let undamped = System::from(system.model().without_dampers());
    if !undamped.structure().is_symmetric() {
        return None;
    }
    Slow::of(system, elastic_shapes(solver, &undamped)?)
}

/// The same modes with the smallest roots as shapes that K hardly resists have them by themselves, where these are as
/// many.
fn with_slow_roots(
    solver: &dyn ModeSolver,
    system: &System,
    slow: &Slow,
    modes: &[Mode],
) -> Vec<Mode> {
    /// Of the least frequency of other shapes.
    const LIMITS: [f64; 4] = [1e-2, 1e-3, 1e-4, 0.1];
    let reduced = slow
        .reduced(system)
        .and_then(|reduced| reduced.modes().ok());
    let Some(reduced) = reduced else {
        return modes.to_vec();
    };
    let size = |mode: &Mode| mode.eigenvalue().value.norm();
    let roots = |modes: &[Mode], limit: f64| -> usize {
        let small = modes
            .iter()
            .filter(|mode| size(mode) > 0.0 && size(mode) <= limit);
        let count = |mode: &Mode| match mode.eigenvalue().value.im {
            0.0 => mode.roots(),
            _ => 2 * mode.roots(),
        };
        small.map(count).sum()
    };
    let limits = LIMITS.map(|part| part * slow.elastic);
    let equal = |limit: &f64| roots(modes, *limit) == roots(reduced.as_slice(), *limit);
    let Some(limit) = limits.into_iter().find(equal) else {
        return modes.to_vec();
    };
    let larger = modes.iter().filter(|mode| size(mode) > limit);
    let larger = larger.map(|mode| Root {
        left: mode.left_shape().map(<[_]>::to_vec),
        ..Root::simple(mode.eigenvalue().value, mode.shape().to_vec())
    });
    let small = reduced
        .iter()
        .filter(|mode| size(mode) > 0.0 && size(mode) <= limit);
    let small: Vec<&Mode> = small.collect();
    let small = small.iter().flat_map(|mode| {
        let value = mode.eigenvalue().value;
        let is_opposite = |other: &&Mode| {
            let sum = other.eigenvalue().value + value;
            sum.norm() <= 1e-2 * value.norm()
        };
        let hidden = value.norm() <= slow.stand_in();
        let values = if hidden && value.im != 0.0 {
            vec![slow.stand_in(), -slow.stand_in()]
        } else if hidden && small.iter().copied().any(|other| is_opposite(&other)) {
            vec![slow.stand_in().copysign(value.re)]
        } else {
            Vec::new()
        };
        let shape = slow.shape(mode.shape());
        if values.is_empty() {
            let left = mode.left_shape().map(|left| slow.shape(left));
            return vec![Root {
                left,
                ..Root::simple(value, shape)
            }];
        }
        let shape: Vec<Complex<f64>> = shape.iter().map(|x| Complex::from(x.re)).collect();
        let stand_in = |value| Root::simple(Complex::from(value), shape.clone());
        values.into_iter().map(stand_in).collect()
    });
    collect(solver, system, larger.chain(small).collect())
        .as_slice()
        .to_vec()
}

/// The sizes of the roots that each coordinate has by itself, all others held: right wherever one coordinate rules a motion.
fn lone_sizes(system: &System) -> Vec<f64> {
    let matrices = [
        system.mass_matrix(),
        system.damping_matrix(),
        system.stiffness_matrix(),
    ];
    let roots = (0..system.len()).flat_map(|i| {
        let [m, c, k] = matrices.each_ref().map(|matrix| matrix[(i, i)]);
        classical::scalar_roots(m, c, k)
    });
    roots.map(|root| root.norm()).collect()
}

fn with_shape(value: Complex<f64>, shape: Shape) -> Root {
    Root {
        shape_bound: shape.bounds,
        ..Root::simple(value, shape.components)
    }
}

/// What a disc that holds so many roots proves of them.
fn of_disc(count: usize) -> Repeats {
    match count {
        1 => Repeats::SIMPLE,
        count => Repeats::Cluster(count),
    }
}

fn without_proof(mut modes: Modes, reason: String) -> Modes {
    modes.plan.bounds = format!("estimated in doubles, not proven: {reason}");
    modes
}
