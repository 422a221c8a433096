//! What the polynomials and squarings of the exponential ask of a matrix.

/// The matrices that a method computes with: dense ones, dual ones that carry a derivative along,
/// or those of a structure that sums and products keep.
///
/// Elements come from a pool and go back to it, so that a long run of squarings allocates nothing.
pub(super) trait Algebra {
    /// A matrix.
    type Element;

    /// Sums of terms factor · element, at least one term each, in one pass.
    fn combine<const SUMS: usize>(
        &mut self,
        terms: [&[(f64, &Self::Element)]; SUMS],
    ) -> [Self::Element; SUMS];

    /// sum + x·y.
    fn multiply_add(
        &mut self,
        sum: Self::Element,
        x: &Self::Element,
        y: &Self::Element,
    ) -> Self::Element;

    /// x·y.
    fn multiply(&mut self, x: &Self::Element, y: &Self::Element) -> Self::Element;

    /// Takes back an element that is no longer needed.
    fn recycle(&mut self, element: Self::Element);
}

/// Elements with an n × n matrix of doubles inside, column by column, and perhaps more beside it
/// that is in proportion to it.
pub(super) trait Explicit: Algebra {
    /// n.
    fn order(&self) -> usize;

    /// The matrix itself.
    fn value(element: &Self::Element) -> &[f64];

    /// The matrix itself, to change it by a constant.
    fn value_mut(element: &mut Self::Element) -> &mut [f64];

    /// Multiplies the element.
    fn rescale(element: &mut Self::Element, factor: f64);

    /// SX + XS for a diagonal matrix S.
    fn twice(&mut self, x: &Self::Element, s: &[f64]) -> Self::Element;
}
