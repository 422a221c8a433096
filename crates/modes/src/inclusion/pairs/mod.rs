//! All roots of a system at once, from approximate roots and shapes, in O(n³).
//!
//! The pencil A − λB with A = diag(K, −M) and B = −[C M; M 0] has the roots of
//! Q(λ) = λ²M + λC + K, with vectors z = (x, λx) on the right and w = (y, λy), yᵀQ = 0, on the left (Tisseur & Meerbergen
//! 2001, *SIAM Review* 43, §3.4). Coordinates without mass have no λx there: states are as many as there are coordinates, and
//! once more those with mass, say N, and B is regular where so many roots are finite. For N columns Z = [X; XΛ] and W = [Y; YΛ] it has those of WᵀAZ − λWᵀBZ as well, of
//! entries
//!
//! a_ij = y_iᵀKx_j − λ_iλ_j y_iᵀMx_j and b_ij = −(y_iᵀCx_j + (λ_i + λ_j) y_iᵀMx_j),
//!
//! which good roots and shapes make nearly diagonal: M, C and K are needed in three products only. Of symmetric systems
//! Y = X. With ρ_i any numbers near a_ii/b_ii and scales τ, Gershgorin's theorem for row i divided by b_ii
//! says that a root λ has, for some i,
//!
//! |λ − ρ_i| ≤ Σ_j (|h_ij| + |λ − ρ_i||e_ij|) τ_j/τ_i, h_ij = (a_ij − ρ_ib_ij)/b_ii, e_ij = b_ij/b_ii − δ_ij,
//!
//! so that it lies in the disc about ρ_i of radius H_i/(1 − E_i), H and E being those sums. The sums
//! only shrink as all that is off the diagonal is let go to 0; so as long as E_i < 1, k discs that
//! touch no others hold k roots: all are accounted for. With τ_i made t times larger the disc of row i is
//! nearly t times smaller, while no other grows by more than t·h_ji does; the largest t for which
//! they stay apart makes the radius one of the second order in what is off the diagonal. What
//! remains is the rounding of the row's own two sums.
//!
//! Roots and shapes are first refined to double-double ([`refine`]). What the rows leave off the diagonal also bounds how
//! much the shapes are still mixed ([`mixing`]).
//!
//! Motions d that nothing holds, K d = C d = 0 and dᵀK = dᵀC = 0, are taken out exactly where their entries are short: the rest moves in the
//! complement xᵀMd = dᵀMx = 0. Those that only dampers hold are columns of their own with λ = 0, where h vanishes. All other shapes of
//! roots at 0 are given approximately ([`slow`](super::slow)), and their roots are counted.

mod discs;
mod enclose;
mod mixing;
mod pair;
mod refine;
mod ritz;
mod rounded;
mod rows;
mod separate;
mod span;
#[cfg(test)]
mod tests;

use crate::modes::Mode;
use crate::system::System;

use super::slow::Slow;
use pair::Pairs;
pub(crate) use rounded::Paired;

/// Proves a disc for every nonzero root of a system in which each coordinate with mass has two roots and each without has
/// one, given all its modes approximately, and bounds of the shapes of single roots, which more digits make relative to every component
/// as far as they reach. `None` where no proof was reached, as for defective roots.
pub(crate) fn certify(
    system: &System,
    modes: &[Mode],
    slow: Option<&Slow>,
    tolerance: f64,
) -> Option<Vec<Paired>> {
    let structure = system.structure();
    let mut pairs = Pairs::of(system, modes, slow)?;
    let rows = pairs.refine()?;
    let discs = pairs.enclosed(rows, structure, tolerance)?;
    pairs.found(structure, discs)
}
