//! What can be proved of a system from its parameters, in exact arithmetic: every double is taken as it is,
//! elements and matrices are summed without rounding, and nothing rests on a tolerance. One proof a file; the
//! structure collects them. It knows `exact` and `model`.

mod by_modes;
mod classical;
pub(crate) mod coefficients;
mod commutator;
pub(crate) mod determinant;
mod distinct;
mod gyroscopic;
mod later;
mod low_rank;
pub(crate) mod massless;
mod mirror;
mod network;
mod overdamped;
mod passive;
mod polynomial;
pub(crate) mod rayleigh;
#[cfg(test)]
pub(crate) mod samples;
mod semidefinite;
#[cfg(feature = "serde")]
mod serial;
mod support;
pub(crate) mod symmetric;
mod undamped;
mod undamped_modes;

use std::fmt;
use std::sync::Arc;

use by_modes::ByModes;
use classical::Verdict;
use coefficients::{Coefficient, Coefficients};
use determinant::Roots;
use distinct::Factor;
use later::Later;
use massless::Massless;
use passive::Passive;
use rayleigh::Proportion;

use crate::exact::null_space::{NullVector, annulled};
use crate::exact::rank::rank;
use crate::model::MAX_DENSE_COORDINATES;
use crate::model::MatrixKind;
use crate::model::Model;
use crate::model::Names;

/// What was proved of a system, by [`System::structure`](crate::System::structure). It prints one
/// fact a line. A fact that is not stated was not proved, which need not make it untrue.
///
/// ```
/// use eigentone_modes::{GROUND, System};
///
/// let system = System::builder()
///     .mass("a", 1.0)
///     .mass("b", 1e20)
///     .spring("a", "b", 1.0)
///     .damper(GROUND, "b", 0.5)
///     .build()?;
/// let structure = system.structure();
/// assert!(structure.is_passive() && !structure.is_classical());
/// // The damper holds the pair, no spring does: it stays where it is put.
/// assert_eq!(structure.zero_roots(), Some(1));
/// assert!(structure.massless().is_empty());
/// // What was proved, in words.
/// println!("{structure}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    names: Names,
    /// With what stands in for C, where a part of it is by modes.
    coefficients: Arc<Coefficients>,
    by_modes: Option<Arc<ByModes>>,
    rigid_rounded: bool,
    undamped: bool,
    gyroscopic: bool,
    passive: Option<Passive>,
    classical: Verdict,
    roots: Roots,
    pub(crate) massless: Massless,
    spring_floating: Vec<Vec<usize>>,
    floating: Vec<Vec<usize>>,
    overdamped: Later<bool>,
    damping_rank: Later<Option<usize>>,
    undamped_modes: Later<Option<usize>>,
    proportion: Later<Option<Proportion>>,
}

impl Structure {
    /// Of a model and its matrices in exact arithmetic.
    pub(crate) fn of(model: &Model, coefficients: Arc<Coefficients>) -> Structure {
        let rigid_rounded = by_modes::damp_rigid_motions(model, &coefficients);
        // What has no mass has no damping by modes: C tells it of them, and how many roots are finite.
        let massless = Massless::of(&coefficients);
        let given = Roots::of(&coefficients);
        let (by_modes, coefficients) = match ByModes::of(model) {
            Some((by_modes, stand_in)) => (Some(Arc::new(by_modes)), Arc::new(stand_in)),
            None => (None, coefficients),
        };
        let roots = match by_modes {
            Some(_) => Roots {
                finite: given.finite,
                ..Roots::of(&coefficients)
            },
            None => given,
        };
        let are_passive = by_modes.as_deref().is_none_or(ByModes::are_passive);
        let [_, damping, stiffness] = coefficients.parts();
        let floating = |parts: &[&Coefficient]| {
            let networks: Option<Vec<_>> = parts.iter().map(|part| part.network.as_ref()).collect();
            networks.map_or(Vec::new(), |networks| support::floating(&networks))
        };
        Structure {
            names: model.names().clone(),
            undamped: undamped::is_undamped(&coefficients),
            gyroscopic: gyroscopic::is_gyroscopic(&coefficients),
            passive: passive::passive(model, &coefficients).filter(|_| are_passive),
            classical: classical::classical(&coefficients),
            roots,
            massless,
            spring_floating: floating(&[stiffness]),
            floating: floating(&[stiffness, damping]),
            overdamped: Later::new(),
            damping_rank: Later::new(),
            undamped_modes: Later::new(),
            proportion: Later::new(),
            by_modes,
            rigid_rounded,
            coefficients,
        }
    }

    /// Whether there are more than [`MAX_DENSE_COORDINATES`] coordinates. Then only what takes
    /// linear time is proved: what follows from the graph of the elements, from single entries, and from narrow factors.
    pub fn is_large(&self) -> bool {
        self.names.len() > MAX_DENSE_COORDINATES
    }

    /// Whether there is no damping: C = 0 exactly.
    pub fn is_undamped(&self) -> bool {
        self.undamped
    }

    /// Whether M, C and K are symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.not_symmetric().next().is_none()
    }

    /// Whether K is symmetric.
    pub(crate) fn has_symmetric_stiffness(&self) -> bool {
        self.coefficients.stiffness.network.is_some()
    }

    fn not_symmetric(&self) -> impl Iterator<Item = MatrixKind> {
        let kinds = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];
        let each = kinds.into_iter().zip(self.coefficients.parts());
        each.filter(|(_, part)| part.network.is_none())
            .map(|(kind, _)| kind)
    }

    /// Whether no part can feed energy in: M, C and K are proved positive semidefinite, so that
    /// Re λ ≤ 0 for every root.
    pub fn is_passive(&self) -> bool {
        self.passive.is_some()
    }

    /// Whether M is positive definite, C and K are symmetric, and C M⁻¹ K = K M⁻¹ C, all proved.
    /// Then the undamped shapes are those of the damped system too (Caughey & O'Kelly 1965,
    /// *J. Appl. Mech.* 32, theorem 2), and each moves by itself.
    pub fn is_classical(&self) -> bool {
        self.classical == Verdict::Proved
    }

    /// Why the damping is not taken for classical, as a clause.
    pub(crate) fn why_not_classical(&self) -> &'static str {
        match self.classical {
            _ if !self.is_symmetric() => "a matrix is not symmetric",
            Verdict::Disproved => "not classically damped: C M⁻¹ K differs from K M⁻¹ C",
            _ if !self.massless().is_empty() => {
                "with massless nodes M has no inverse, which C M⁻¹ K = K M⁻¹ C takes"
            }
            _ => "not proved to be classically damped: C M⁻¹ K = K M⁻¹ C with M positive definite",
        }
    }

    /// Whether C = −Cᵀ ≠ 0, M is positive definite and K positive semidefinite, all proved. Then
    /// Re λ = 0 for every root (Tisseur & Meerbergen 2001, *SIAM Review* 43).
    pub fn is_gyroscopic(&self) -> bool {
        self.gyroscopic
    }

    /// Whether M = Mᵀ, K = Kᵀ and C = −Cᵀ, which may be 0. Then −λ is a root where λ is, as
    /// det(λ²M + λC + K) is that of the transposed matrix too: no motion dies out unless another grows.
    pub fn is_reversible(&self) -> bool {
        let [mass, damping, stiffness] = self.coefficients.parts();
        let is_symmetric = mass.network.is_some() && stiffness.network.is_some();
        self.by_modes.is_none() && is_symmetric && gyroscopic::is_skew(&damping.matrix)
    }

    /// Whether M is positive definite, C and K are positive semidefinite, and
    /// (xᵀCx)² > 4 (xᵀMx)(xᵀKx) for every x ≠ 0, all proved. Then every root is real, semisimple
    /// and ≤ 0 (Guo, Higham & Tisseur 2009, *SIAM J. Matrix Anal. Appl.* 30). Found out when first
    /// asked for, at the cost of a few Cholesky factorisations where C is positive definite.
    pub fn is_overdamped(&self) -> bool {
        *self.overdamped.get(|| match &self.by_modes {
            Some(by_modes) => by_modes.are_overdamped(self.names.len()),
            None => !self.is_large() && overdamped::is_overdamped(&self.coefficients),
        })
    }

    /// The rank of C, in exact arithmetic; dampers ≥ 0 that close a loop add nothing to it. `None`
    /// where it was not proved. Found out when first asked for.
    pub fn damping_rank(&self) -> Option<usize> {
        *self.damping_rank.get(|| {
            let rank = || low_rank::damping_rank(&self.coefficients);
            match &self.by_modes {
                Some(by_modes) => by_modes.counted(rank, |ratio| ratio != 0.0),
                None => (!self.is_large()).then(rank)?,
            }
        })
    }

    /// How many modes with ω ≠ 0 no damper touches: K x = ω²M x with C x = 0. Each gives a pair of
    /// roots ±iω with Re λ = 0, and no other root than these and 0 has Re λ = 0. Rigid motions
    /// without damping are not among them; they are two [zero roots](Structure::zero_roots) each.
    ///
    /// `None` where it was not proved: C and K must be positive semidefinite, M positive definite on
    /// the coordinates that are not massless, and K on those that are. Found out when first asked
    /// for, below a second.
    pub fn undamped_modes(&self) -> Option<usize> {
        *self.undamped_modes.get(|| {
            let massless = &self.massless.nodes;
            let count = || undamped_modes::undamped_modes(&self.coefficients, massless);
            match &self.by_modes {
                Some(by_modes) => by_modes.counted(count, |ratio| ratio == 0.0),
                None => (!self.is_large()).then(count)?,
            }
        })
    }

    /// Whether it is damped by C = αM + βK, with M and K symmetric.
    pub fn is_rayleigh(&self) -> bool {
        !self.is_undamped() && self.proportion().is_some()
    }

    /// α and β of Rayleigh damping C = αM + βK with M and K symmetric, where that is what it is.
    pub(crate) fn proportion(&self) -> Option<Proportion> {
        self.law()
            .filter(|(_, ratios)| ratios.is_empty())
            .map(|(proportion, _)| proportion)
    }

    /// α, β and ratios of damping by which γ = α + βω² + 2ζω of each undamped mode, where that is what it is: one ratio for each with
    /// ω ≠ 0, by rising ω, or none.
    pub(crate) fn law(&self) -> Option<(Proportion, &[f64])> {
        self.law_with_massless().filter(|_| self.is_classical())
    }

    /// The same where there are nodes without mass: where β ≠ 0 there is a root −1/β for each of them.
    pub(crate) fn law_with_massless(&self) -> Option<(Proportion, &[f64])> {
        let proportion = *self.proportion.get(|| {
            let [mass, damping, stiffness] = self.coefficients.parts().map(|part| &part.matrix);
            let rest = self
                .by_modes
                .as_ref()
                .map_or(damping, |by_modes| by_modes.rest());
            let proportion = || match self.by_modes.is_some() && rest.is_zero() {
                true => Some(Proportion::NONE),
                false => rayleigh::proportion([mass, rest, stiffness]),
            };
            let has_massless = !self.massless().is_empty();
            let may_be = self.is_classical() || has_massless && self.is_symmetric();
            may_be.then(proportion).flatten()
        });
        let ratios = self
            .by_modes
            .as_ref()
            .map_or(&[][..], |by_modes| by_modes.ratios());
        Some((proportion?, ratios))
    }

    /// Whether a part of C is by modes, and is therefore rounded.
    pub(crate) fn is_by_modes(&self) -> bool {
        self.by_modes.is_some()
    }

    /// Whether the matrix of [damping by modal ratios](crate::SystemBuilder::modal_damping), as it is rounded, damps motions that need no
    /// force, by some 1e-50, which the ideal one does not.
    pub fn damps_rigid_motions_by_rounding(&self) -> bool {
        self.rigid_rounded
    }

    /// How many roots are exactly 0: two for each rigid-body motion that nothing holds, one for
    /// each that only dampers hold. `None` where it was not proved.
    pub fn zero_roots(&self) -> Option<usize> {
        self.roots.zero
    }

    /// Whether every root other than 0 is proved to have as many shapes as its multiplicity.
    pub(crate) fn is_semisimple(&self) -> bool {
        // M and K, or M and C, are diagonalised by one congruence.
        let pair = self.is_undamped() || self.coefficients.stiffness.matrix.is_zero();
        pair && self.is_symmetric() && self.is_passive() || self.is_overdamped()
    }

    /// How many independent shapes x with (λ²M + λC + K)x = 0 there are for a real λ, in exact arithmetic; `None`
    /// where that was not proved.
    pub(crate) fn shapes_at(&self, value: f64) -> Option<usize> {
        if self.by_modes.is_some() {
            return None;
        }
        let [mass, damping, stiffness] = [
            &self.coefficients.mass,
            &self.coefficients.damping,
            &self.coefficients.stiffness,
        ]
        .map(|coefficient| &coefficient.matrix);
        let slope = mass.times(value)?.plus(damping);
        let whole = slope.times(value)?.plus(stiffness);
        Some(whole.len() - rank(&whole)?)
    }

    /// How many independent shapes K lets move without any force, where K is proved positive
    /// semidefinite.
    pub(crate) fn rigid_motions(&self) -> Option<usize> {
        let stiffness = &self.coefficients.stiffness;
        Some(stiffness.matrix.len() - stiffness.semidefinite_rank()?)
    }

    /// Exact shapes that K lets move without any force: the floating parts, and where those are not all, a basis of
    /// short binary fractions if there is one.
    pub(crate) fn null_vectors(&self) -> Vec<NullVector> {
        let parts = self.spring_floating.iter();
        let whole: Vec<NullVector> = parts.map(|part| NullVector::whole(part)).collect();
        let explained = |zeros| zeros == whole.len() + self.undamped_among(&whole).len();
        if self.is_large() || self.zero_roots().is_some_and(explained) {
            return whole;
        }
        match self.coefficients.stiffness.null_space() {
            Some(all) if all.len() > whole.len() => all.to_vec(),
            _ => whole,
        }
    }

    /// Those shapes x with C x = 0 and xᵀC = 0.
    pub(crate) fn undamped_among(&self, vectors: &[NullVector]) -> Vec<NullVector> {
        let damping = &self.coefficients.damping.matrix;
        let right = annulled(damping, vectors);
        if self.is_symmetric() {
            return right;
        }
        annulled(&damping.transposed(), &right)
    }

    /// How many independent shapes K lets move without any force, where that was proved for any K.
    pub fn rigid_motions_counted(&self) -> Option<usize> {
        let stiffness = &self.coefficients.stiffness;
        self.rigid_motions()
            .or_else(|| Some(stiffness.null_space()?.len()))
            .or_else(|| Some(stiffness.matrix.len() - rank(&stiffness.matrix)?))
    }

    /// How many of the 2n roots are finite: the degree of det(λ²M + λC + K). `None` where it was
    /// not proved.
    pub fn finite_roots(&self) -> Option<usize> {
        self.roots.finite
    }

    /// Whether M is proved positive definite.
    pub(crate) fn has_definite_mass(&self) -> bool {
        let mass = &self.coefficients.mass;
        mass.semidefinite_rank() == Some(mass.matrix.len())
    }

    /// The rank of M, in exact arithmetic. `None` where it was not proved.
    pub fn mass_rank(&self) -> Option<usize> {
        let mass = &self.coefficients.mass;
        let of_any = || (!self.is_large()).then(|| rank(&mass.matrix)).flatten();
        mass.semidefinite_rank().or_else(of_any)
    }

    /// The coordinates whose row and column of M are 0, rising.
    pub fn massless(&self) -> &[usize] {
        &self.massless.nodes
    }

    /// The massless coordinates whose row or column of C is not 0, rising. They have a displacement
    /// of their own, but no free velocity.
    pub fn damped_massless(&self) -> &[usize] {
        &self.massless.damped
    }

    /// The parts that no spring ties to the ground: coordinates that K lets move as one, all by the
    /// same displacement, without any force. Empty unless K is symmetric.
    pub fn spring_floating(&self) -> &[Vec<usize>] {
        &self.spring_floating
    }

    /// The parts that neither springs nor dampers tie to the ground, each made up of whole parts of
    /// [`spring_floating`](Structure::spring_floating). Empty unless C and K are symmetric.
    pub fn floating(&self) -> &[Vec<usize>] {
        &self.floating
    }
}

/// How many different roots other than 0 some systems have together.
pub(crate) struct DistinctRoots<'a> {
    factors: Vec<Factor<'a>>,
}

impl<'a> DistinctRoots<'a> {
    /// Of systems whose finite and zero roots are counted.
    pub(crate) fn of(structures: &[&'a Structure]) -> Option<DistinctRoots<'a>> {
        let mut factors = Vec::with_capacity(structures.len());
        for structure in structures {
            if structure.by_modes.is_some() {
                return None;
            }
            factors.push(Factor {
                coefficients: &structure.coefficients,
                degree: structure.roots.finite?,
                zeros: structure.roots.zero?,
                // λ and −λ are roots together there.
                in_square: structures.iter().all(|structure| structure.is_undamped()),
            });
        }
        Some(DistinctRoots { factors })
    }

    /// Whether they are proved to be no more than `count`, with at most so many multiplications.
    pub(crate) fn are_at_most(&self, count: usize, most_work: u64) -> bool {
        distinct::are_at_most(&self.factors, self.in_units(count), most_work)
    }

    /// Whether they are proved to be no fewer.
    pub(crate) fn are_at_least(&self, count: usize) -> bool {
        distinct::are_at_least(&self.factors, self.in_units(count))
    }

    fn in_units(&self, count: usize) -> usize {
        let in_square = self.factors.iter().any(|factor| factor.in_square);
        if in_square { count / 2 } else { count }
    }
}

impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |nodes: &[usize]| self.list(nodes);
        let kinds: Vec<&str> = self.not_symmetric().map(letter).collect();
        match kinds.as_slice() {
            [] => f.write_str(
                "symmetric: M, C and K equal their transposes; what a load at a does at b, the same load at b does at a",
            )?,
            [kind] => write!(f, "not symmetric: {kind} differs from its transpose")?,
            kinds => write!(
                f,
                "not symmetric: {} differ from their transposes",
                kinds.join(" and ")
            )?,
        }
        match self.passive {
            Some(Passive::Elements) => {
                f.write_str("\npassive: every spring and damper is ≥ 0; no motion gains energy")?
            }
            Some(Passive::Sums) => f.write_str(
                "\npassive: some springs or dampers are < 0, but none together with those parallel to it; \
                 no motion gains energy",
            )?,
            Some(Passive::Matrices) => f.write_str(
                "\npassive: M, C and K are positive semidefinite; no motion gains energy",
            )?,
            None => {}
        }
        self.damping(f)?;
        if self.roots.zero == Some(0) {
            f.write_str(match self.passive {
                Some(Passive::Elements | Passive::Sums) => {
                    "\nsupported: every coordinate reaches the ground through springs"
                }
                _ if self.coefficients.stiffness.semidefinite_rank().is_some() => {
                    "\nsupported: stiffness resists every motion"
                }
                _ => "\nnowhere free: stiffness answers every displacement, but may drive it on",
            })?;
        }
        for part in &self.floating {
            write!(f, "\nunsupported: nothing holds {}", list(part))?;
        }
        for part in self
            .spring_floating
            .iter()
            .filter(|part| !self.floating.contains(part))
        {
            write!(
                f,
                "\nunsupported but for dampers: no spring holds {}",
                list(part)
            )?;
        }
        let of = 2 * self.names.len();
        match self.roots.finite {
            Some(finite) => write!(f, "\nfinite roots: {finite} of {of}")?,
            None => write!(f, "\nfinite roots: not counted, {of} at most")?,
        }
        match self.roots.zero {
            Some(zero) => write!(f, "\nzero roots: {zero}")?,
            None => f.write_str("\nzero roots: not counted")?,
        }
        let Massless {
            nodes,
            damped,
            groups,
        } = &self.massless;
        let undamped: Vec<usize> = nodes
            .iter()
            .copied()
            .filter(|node| !damped.contains(node))
            .collect();
        if !undamped.is_empty() {
            write!(
                f,
                "\nmassless, following from equilibrium: {}",
                list(&undamped)
            )?;
        }
        for group in groups {
            let nodes = list(&group.nodes);
            if group.floating {
                write!(f, "\nmassless, damped against each other alone: {nodes}")?;
            } else {
                write!(f, "\nmassless but damped: {nodes}")?;
            }
        }
        if groups.is_empty() && !damped.is_empty() {
            write!(f, "\nmassless but damped: {}", list(damped))?;
        }
        if self.is_large() {
            write!(
                f,
                "\nmore than {MAX_DENSE_COORDINATES} coordinates: what takes more than linear time is not proved"
            )?;
        }
        Ok(())
    }
}

/// The letter that stands for a matrix.
fn letter(kind: MatrixKind) -> &'static str {
    match kind {
        MatrixKind::Mass => "M",
        MatrixKind::Damping => "C",
        MatrixKind::Stiffness => "K",
    }
}

impl Structure {
    /// The lines on C.
    fn damping(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let n = self.names.len();
        if self.gyroscopic {
            return f.write_str(
                "\ngyroscopic: C = −Cᵀ does no work, M ≻ 0 and K ⪰ 0; every root lies on the \
                 imaginary axis",
            );
        }
        f.write_str(match (self.undamped, self.classical) {
            (true, _) => "\nundamped: C = 0",
            (_, Verdict::Proved) => {
                "\nclassically damped: C M⁻¹ K is symmetric; each undamped shape moves by itself"
            }
            (_, Verdict::Disproved) => {
                "\nnot classically damped: C M⁻¹ K is not symmetric; damping mixes the undamped shapes"
            }
            (_, Verdict::NotProved) => "\nnot proved to be classically damped",
        })?;
        if self.undamped {
            return Ok(());
        }
        if let Some(rank) = self.damping_rank().filter(|&rank| rank < n) {
            write!(f, "\ndamped in part: C has rank {rank} of {n}")?;
        }
        if self.is_overdamped() {
            f.write_str(
                "\noverdamped: λ²M + λC + K is negative definite for some λ < 0; every root is real",
            )?;
        }
        match self.undamped_modes() {
            Some(0) if self.is_overdamped() => Ok(()),
            Some(0) => f.write_str("\nno undamped mode: every vibration moves a damper"),
            Some(1) => f.write_str("\nundamped modes: 1, which moves no damper and does not decay"),
            Some(count) => write!(
                f,
                "\nundamped modes: {count}, which move no damper and do not decay"
            ),
            None => Ok(()),
        }
    }

    /// Their names, the first ones of many.
    fn list(&self, nodes: &[usize]) -> String {
        const SHOWN: usize = 6;
        let names: Vec<&str> = nodes
            .iter()
            .take(SHOWN)
            .map(|&i| self.names[i].as_str())
            .collect();
        match nodes.len() {
            0..=SHOWN => names.join(", "),
            count => format!("{} and {} more", names.join(", "), count - SHOWN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::samples::{
        almost_classical, chain, matrices, network, triple_defect, with_matrices,
    };
    use super::*;
    use crate::system::System;
    use faer::{Mat, mat};

    #[track_caller]
    fn has(text: &str, line: &str) {
        assert!(text.contains(line), "{text}");
    }

    #[test]
    fn a_supported_chain_in_words() {
        let structure = chain(&[10.0; 8], &[1e5; 9], &[50.0; 9]).structure().clone();
        assert!(structure.is_classical() && structure.is_passive() && structure.is_symmetric());
        assert!(!structure.is_undamped());
        assert_eq!(
            structure.to_string(),
            "symmetric: M, C and K equal their transposes; what a load at a does at b, the same load at b does at a\n\
             passive: every spring and damper is ≥ 0; no motion gains energy\n\
             classically damped: C M⁻¹ K is symmetric; each undamped shape moves by itself\n\
             no undamped mode: every vibration moves a damper\n\
             supported: every coordinate reaches the ground through springs\n\
             finite roots: 16 of 16\n\
             zero roots: 0"
        );
    }

    #[test]
    fn floating_parts_in_words() {
        let system = network(
            &[1.0, 2.0, 3.0, 4.0, 5.0],
            &[(1, 2, 1.0), (0, 5, 1.0)],
            &[(2, 3, 1.0), (0, 4, 1.0)],
        );
        let structure = system.structure();
        assert_eq!(structure.zero_roots(), Some(4));
        assert_eq!(structure.floating(), [[0, 1, 2]]);
        assert_eq!(structure.spring_floating(), [vec![0, 1], vec![2], vec![3]]);
        let printed = structure.to_string();
        has(&printed, "unsupported: nothing holds m1, m2, m3\n");
        let held = "unsupported but for dampers: no spring holds m4\n";
        has(&printed, held);
    }

    #[test]
    fn massless_nodes_in_words() {
        let springs = [
            (0, 1, 1.0),
            (1, 2, 2.0),
            (3, 4, 2.0),
            (0, 5, 1.0),
            (0, 6, 1.0),
            (0, 4, 1.0),
        ];
        let system = network(
            &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            &springs,
            &[(2, 3, 1.0), (1, 5, 1.0)],
        );
        let structure = system.structure();
        assert_eq!(structure.massless(), [1, 2, 4, 5]);
        assert_eq!(structure.damped_massless(), [1, 2, 4]);
        assert_eq!(structure.finite_roots(), Some(6));
        let printed = structure.to_string();
        let ending = "massless, following from equilibrium: m6\n\
                      massless, damped against each other alone: m2, m3\n\
                      massless but damped: m5";
        assert!(printed.ends_with(ending), "{printed}");
    }

    #[test]
    fn damping_in_words() {
        let printed = |system: &System| system.structure().to_string();
        let springs = [(0, 1, 1.0), (1, 2, 1.0), (2, 3, 1.0), (0, 3, 1.0)];
        let middle = network(&[1.0; 3], &springs, &[(0, 2, 1.0)]);
        let text = printed(&middle);
        let in_part =
            "\ndamped in part: C has rank 1 of 3\nundamped modes: 1, which moves no damper";
        has(&text, in_part);
        let structure = middle.structure();
        assert_eq!(
            (structure.damping_rank(), structure.undamped_modes()),
            (Some(1), Some(1))
        );
        assert!(!structure.is_overdamped() && !structure.is_gyroscopic());
        let text = printed(&chain(&[1.0], &[1.0], &[3.0]));
        has(&text, "\noverdamped: ");
        assert!(!text.contains("vibration"), "{text}");
        let skew = mat![[0.0, 1.0], [-1.0, 0.0]];
        let rotor = matrices(Mat::identity(2, 2), skew, Mat::identity(2, 2));
        let text = printed(&rotor);
        assert!(
            text.starts_with("not symmetric: C differs from its transpose\ngyroscopic: "),
            "{text}"
        );
        assert!(!text.contains("classically"), "{text}");
    }

    #[test]
    fn asking_again_changes_nothing() {
        let structure = almost_classical().structure().clone();
        let asked = structure.clone();
        let answers = || {
            let counted = (asked.undamped_modes(), asked.damping_rank());
            (asked.is_overdamped(), counted)
        };
        let first = answers();
        assert_eq!(asked, structure);
        assert_eq!(answers(), first);
        let other = chain(&[1.0; 2], &[1.0; 3], &[1.0; 3]);
        assert_ne!(structure, *other.structure());
    }

    #[test]
    fn a_tiny_mass_is_a_mass() {
        let springs = [(0, 1, 1.0), (1, 2, 1.0), (2, 3, 1.0)];
        let structure = network(&[1e300, 1e-300, f64::from_bits(1)], &springs, &[])
            .structure()
            .clone();
        assert!(structure.massless().is_empty());
        assert!(structure.is_undamped());
        assert_eq!(structure.finite_roots(), Some(6));
        assert_eq!(structure.mass_rank(), Some(3));
    }

    #[test]
    fn dampers_that_cancel_leave_a_system_undamped() {
        let undamped = |dampers: &[samples::Join]| {
            network(&[1.0], &[(0, 1, 1.0)], dampers)
                .structure()
                .is_undamped()
        };
        assert!(undamped(&[
            (0, 1, 0.1),
            (0, 1, 0.2),
            (0, 1, -0.1),
            (0, 1, -0.2)
        ]));
        assert!(undamped(&[(0, 1, 0.0)]));
        assert!(!undamped(&[(0, 1, 0.1), (0, 1, 0.2), (0, 1, -0.3)]));
    }

    /// What is said of a spring or damper that is negative is true of it.
    #[test]
    fn words_for_negative_springs_and_dampers() {
        let of = |springs: &[f64], dampers: &[f64]| {
            let joined = |values: &[f64]| -> Vec<(usize, usize, f64)> {
                values.iter().map(|value| (0, 1, *value)).collect()
            };
            let system = network(&[1.0], &joined(springs), &joined(dampers));
            system.structure().to_string()
        };
        let together = of(&[3.0, -1.0], &[-1.0, 1.5]);
        let parallel = "passive: some springs or dampers are < 0, but none together";
        has(&together, parallel);
        has(&together, "supported: every coordinate reaches the ground");
        assert!(!together.contains("every spring and damper"), "{together}");
        let plain = of(&[3.0], &[0.0]);
        has(&plain, "passive: every spring and damper is ≥ 0");
        let pushed = of(&[-1.0], &[]);
        let answers = "nowhere free: stiffness answers every displacement";
        has(&pushed, answers);
        assert!(!pushed.contains("supported"), "{pushed}");
        let driven = of(&[1.0], &[-1.0]);
        has(&driven, "supported: stiffness resists every motion");
    }

    #[test]
    fn passive_by_elements_by_matrices_or_not() {
        let passive = |system: &System| system.structure().is_passive();
        assert!(passive(&triple_defect()));
        assert!(passive(&almost_classical()));
        assert!(passive(&network(&[1.0], &[(0, 1, 2.0), (0, 1, -1.0)], &[])));
        let negative = network(&[1.0], &[(0, 1, 1.0), (0, 1, -2.0)], &[]);
        assert!(!passive(&negative));
        let growing = network(&[1.0, 1.0], &[(0, 1, 1.0)], &[(1, 2, -1e-300)]);
        assert!(!passive(&growing));
        let gyroscopic = mat![[0.0, 1.0], [-1.0, 0.0]];
        let structure = matrices(Mat::identity(2, 2), gyroscopic, Mat::identity(2, 2))
            .structure()
            .clone();
        assert!(!structure.is_passive() && !structure.is_symmetric() && !structure.is_classical());
        assert_eq!(
            (structure.finite_roots(), structure.zero_roots()),
            (Some(4), Some(0))
        );
        // Joined by +1: no network of positive springs, and yet definite.
        let stiffness = mat![[2.0, 1.0], [1.0, 2.0]];
        assert!(passive(&with_matrices(
            &[1.0, 1.0],
            &[(0, 1, 0.5)],
            &[],
            [None, None, Some(stiffness)]
        )));
    }

    #[test]
    fn a_free_beam_has_four_zero_roots() {
        // 60 Hermite elements, 122 coordinates: rotations make K no network.
        let n = 122;
        let stiffness = samples::free_beam(60);
        let structure = matrices(Mat::identity(n, n), Mat::zeros(n, n), stiffness)
            .structure()
            .clone();
        assert!(structure.is_passive());
        assert_eq!(
            (structure.finite_roots(), structure.zero_roots()),
            (Some(2 * n), Some(4))
        );
    }
}
