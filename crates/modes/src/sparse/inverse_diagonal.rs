//! The diagonal of A⁻¹ from A = L D Lᵀ without the rest of it (Takahashi, Fagan & Chin 1973; Erisman &
//! Tinney 1975, *Comm. ACM* 18): A⁻¹ = D⁻¹L⁻¹ + (I − Lᵀ)A⁻¹, from the last column back, needs only
//! those entries of A⁻¹ that lie in the pattern of L.

use super::factor::Factor;

/// By nodes.
pub(crate) fn of(factor: &Factor<'_>) -> Vec<f64> {
    let ordering = &factor.pencil.ordering;
    let (starts, rows) = (&ordering.starts, &ordering.rows);
    let n = ordering.nodes.len();
    // Entries of the inverse where L has some, and on the diagonal.
    let mut beside = vec![0.0; rows.len()];
    let mut diagonal = vec![0.0; n];
    let mut sums = Vec::new();
    for j in (0..n).rev() {
        let range = starts[j]..starts[j + 1];
        let pattern = &rows[range.clone()];
        let multipliers = &factor.values[range.clone()];
        sums.clear();
        sums.resize(pattern.len(), 0.0);
        for (a, (&row, multiplier)) in pattern.iter().zip(multipliers).enumerate() {
            sums[a] -= multiplier * diagonal[row as usize];
            // The entries below the diagonal in this row's column, over the rest of the pattern.
            let mut at = starts[row as usize];
            for (b, &lower) in pattern.iter().enumerate().skip(a + 1) {
                while rows[at] < lower {
                    at += 1;
                }
                sums[a] -= multipliers[b] * beside[at];
                sums[b] -= multiplier * beside[at];
            }
        }
        let own: f64 = multipliers.iter().zip(&sums).map(|(l, z)| l * z).sum();
        diagonal[j] = factor.inverses[j] - own;
        beside[range].copy_from_slice(&sums);
    }
    let mut by_node = vec![0.0; n];
    for (&node, value) in ordering.nodes.iter().zip(diagonal) {
        by_node[node as usize] = value;
    }
    by_node
}
