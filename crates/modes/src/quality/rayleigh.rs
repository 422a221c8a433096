//! Roots from shapes: the two-sided Rayleigh functional, summed over the elements.
//!
//! With m = y*Mx, c = y*Cx, k = y*Kx the root of mλ² + cλ + k near an approximation is stationary
//! in x and y: errors ε of the shapes enter λ as ε² (Lancaster 1966, *Lambda-matrices and
//! vibrating systems*, §5.5). A spring contributes k·(y_a − y_b)*(x_a − x_b), which keeps soft
//! springs beside stiff ones, as the assembled K does not.

use eigentone_digits::{ComplexDoubleDouble, DoubleDouble, Lanes, Real, WideComplex};
use num_complex::Complex;
use pulp::Arch;

use crate::model::{Element, MatrixKind, Node, Square};
use crate::system::System;

use super::pencil::applied;

/// y*Mx, y*Cx and y*Kx, or for a real shape x = y their real values, in the precision of T.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forms<T = DoubleDouble> {
    pub(crate) m: WideComplex<T>,
    pub(crate) c: WideComplex<T>,
    pub(crate) k: WideComplex<T>,
}

impl<T: Real> Forms<T> {
    /// The three forms of shapes x and y.
    pub(crate) fn of(system: &System, y: &[Complex<f64>], x: &[Complex<f64>]) -> Forms<T> {
        Forms::given(system, y, x, [None; 3])
    }

    /// The same, given what the added matrices that are not sums of squares make of x where that is known.
    fn given(
        system: &System,
        y: &[Complex<f64>],
        x: &[Complex<f64>],
        applied: [Option<&[Complex<f64>]>; 3],
    ) -> Forms<T> {
        let mut forms = Forms {
            m: WideComplex::ZERO,
            c: element_form(system.dampers(), y, x),
            k: element_form(system.springs(), y, x),
        };
        for ((mass, y), x) in system.masses().iter().zip(y).zip(x) {
            if *mass != 0.0 {
                forms.m += wide::<T>(y.conj()) * wide(*x) * *mass;
            }
        }
        let each = KINDS.into_iter().zip(applied);
        for ((kind, applied), form) in each.zip([&mut forms.m, &mut forms.c, &mut forms.k]) {
            let Some(matrix) = system.added(kind) else {
                continue;
            };
            if let Some(squares) = system.model().added_whole(kind).squares() {
                for Square {
                    coefficient,
                    form: a,
                } in squares
                {
                    let along = |shape: &[Complex<f64>]| {
                        a.iter().fold(WideComplex::<T>::ZERO, |sum, (i, times)| {
                            sum + wide(shape[*i]) * *times
                        })
                    };
                    *form += along(y).conj() * along(x) * *coefficient;
                }
                continue;
            }
            if let Some(applied) = applied {
                for (y, ax) in y.iter().zip(applied) {
                    *form += wide::<T>(y.conj()) * wide(*ax);
                }
            } else {
                for (j, xj) in x.iter().enumerate() {
                    let mut column = WideComplex::<T>::ZERO;
                    for (entry, yi) in matrix.col(j).iter().zip(y) {
                        if *entry != 0.0 {
                            column += wide::<T>(yi.conj()) * *entry;
                        }
                    }
                    *form += column * wide(*xj);
                }
            }
            for tail in system.model().tails(kind) {
                let [y, x] = [y[tail.row].conj(), x[tail.column]];
                *form += wide::<T>(y) * wide(x) * tail.value;
            }
        }
        forms
    }

    /// The root of mλ² + cλ + k to which Newton's method leads from `start`, or `None` where the
    /// root is nearly double. Its residuals are taken in double-double: they cancel.
    pub(crate) fn root(&self, start: Complex<f64>) -> Option<Complex<f64>> {
        let part = |x: T| {
            let high = x.to_f64();
            DoubleDouble::new(high, (x - T::from(high)).to_f64())
        };
        let [m, c, k] = [self.m, self.c, self.k].map(|z| ComplexDoubleDouble {
            re: part(z.re),
            im: part(z.im),
        });
        let plain = |z: ComplexDoubleDouble| Complex::new(z.re.to_f64(), z.im.to_f64());
        let exact = |z: Complex<f64>| ComplexDoubleDouble::new(z.re, z.im);
        let mut lambda = exact(start);
        for _ in 0..6 {
            let near = plain(lambda);
            let slope = plain(m) * near * 2.0 + plain(c);
            let step = plain((m * lambda + c) * lambda + k) / slope;
            let size = step.norm();
            if !size.is_finite() || size > 0.5 * near.norm() {
                return None;
            }
            lambda = lambda - exact(step);
            if size <= f64::EPSILON * f64::EPSILON * near.norm() {
                break;
            }
        }
        Some(plain(lambda))
    }
}

const KINDS: [MatrixKind; 3] = [MatrixKind::Mass, MatrixKind::Damping, MatrixKind::Stiffness];

impl Forms<f64> {
    /// Those of many shapes x, with y for each, by products of whole matrices.
    pub(crate) fn of_many(
        system: &System,
        left: &[Vec<Complex<f64>>],
        shapes: &[&[Complex<f64>]],
    ) -> Vec<Forms<f64>> {
        let by_kind = KINDS.map(|kind| {
            let whole = system.model().added_whole(kind).squares().is_none();
            let matrix = system.added(kind).filter(|_| whole)?;
            Some(applied(matrix, shapes))
        });
        let form = |at: usize| {
            let products = by_kind.each_ref();
            let products = products.map(|all| all.as_ref().map(|all| all[at].as_slice()));
            Forms::given(system, &left[at], shapes[at], products)
        };
        (0..shapes.len()).map(form).collect()
    }
}

/// Shapes that are taken at a time.
const LANES: usize = 4;

/// Real and imaginary parts of one component of so many shapes.
type Component = [[f64; LANES]; 2];

impl Forms<DoubleDouble> {
    /// xᵀMx, xᵀCx and xᵀKx of many shapes, together: those of y = x̄. Of elements alone.
    pub(crate) fn of_elements(system: &System, shapes: &[&[Complex<f64>]]) -> Vec<Forms> {
        let by_itself = |x: &[Complex<f64>]| {
            let y: Vec<Complex<f64>> = x.iter().map(|entry| entry.conj()).collect();
            Forms::of(system, &y, x)
        };
        let mut components: Vec<Component> = vec![[[0.0; LANES]; 2]; system.len()];
        let mut all = Vec::with_capacity(shapes.len());
        for block in shapes.chunks(LANES) {
            for (lane, x) in block.iter().enumerate() {
                for (component, x) in components.iter_mut().zip(*x) {
                    component[0][lane] = x.re;
                    component[1][lane] = x.im;
                }
            }
            let [m, c, k] = Arch::new().dispatch(|| element_sums(system, &components));
            all.extend(block.iter().enumerate().map(|(lane, x)| {
                let form = |[re, im]: &[Lanes<LANES>; 2]| WideComplex {
                    re: re.get(lane),
                    im: im.get(lane),
                };
                let forms = Forms {
                    m: form(&m),
                    c: form(&c),
                    k: form(&k),
                };
                let parts = [forms.m, forms.c, forms.k].map(|z| z.re + z.im);
                if parts.iter().all(|part| part.to_f64().is_finite()) {
                    forms
                } else {
                    by_itself(x)
                }
            }));
        }
        all
    }
}

/// The elements' shares of the three forms, real parts before imaginary ones.
#[inline(always)]
fn element_sums(system: &System, components: &[Component]) -> [[Lanes<LANES>; 2]; 3] {
    const GROUND: Component = [[0.0; LANES]; 2];
    let at = |node: Node| node.coordinate().map_or(&GROUND, |i| &components[i]);
    let sum = |elements: &[Element]| {
        let [mut re, mut im] = [Lanes::ZERO; 2];
        for element in elements {
            let (first, second) = (at(element.first), at(element.second));
            re.add_complex_square(&mut im, element.coefficient, first, second);
        }
        [re, im]
    };
    let [mut re, mut im] = [Lanes::ZERO; 2];
    for (mass, component) in system.masses().iter().zip(components) {
        re.add_complex_square(&mut im, *mass, component, &GROUND);
    }
    [[re, im], sum(system.dampers()), sum(system.springs())]
}

fn wide<T: Real>(z: Complex<f64>) -> WideComplex<T> {
    WideComplex::new(z.re, z.im)
}

fn element_form<T: Real>(
    elements: &[Element],
    y: &[Complex<f64>],
    x: &[Complex<f64>],
) -> WideComplex<T> {
    let at =
        |shape: &[Complex<f64>], node: Node| node.coordinate().map_or(Complex::ZERO, |i| shape[i]);
    let stretch = |shape: &[Complex<f64>], element: &Element| {
        wide::<T>(at(shape, element.first)) - wide(at(shape, element.second))
    };
    let mut sum = WideComplex::ZERO;
    for element in elements {
        sum += stretch(y, element).conj() * stretch(x, element) * element.coefficient;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::samples::network;

    /// 1 N/m at the ground beside 1e20: both masses together stretch the soft spring alone, k = 1, which
    /// the assembled K has lost; 2^-40 apart they stretch the other one by that.
    #[test]
    fn a_soft_spring_beside_a_stiff_one_keeps_its_digits() {
        let system = network(&[2.0, 3.0], &[(0, 1, 1.0), (1, 2, 1e20)], &[(2, 0, 0.5)]);
        let apart = 2f64.powi(-40);
        for (second, k) in [(1.0, 1.0), (1.0 + apart, 1.0 + 1e20 * apart * apart)] {
            let shape = [Complex::ONE, Complex::from(second)];
            let forms = Forms::<DoubleDouble>::of(&system, &shape, &shape);
            assert_eq!((forms.k.re.to_f64(), forms.k.im.to_f64()), (k, 0.0));
            assert_eq!(forms.m.re.to_f64(), 2.0 + 3.0 * second * second);
            assert_eq!(forms.c.re.to_f64(), 0.5 * second * second);
        }
    }

    /// y*Cx of a damper between two masses, y conjugated and both ends with their signs.
    #[test]
    fn the_left_shape_is_conjugated() {
        let system = network(&[1.0; 2], &[], &[(1, 2, 3.0)]);
        let x = [Complex::new(1.0, 2.0), Complex::new(0.5, -1.0)];
        let y = [Complex::new(0.25, 1.0), Complex::new(-1.0, 0.5)];
        let forms = Forms::<DoubleDouble>::of(&system, &y, &x);
        let expected = (y[0] - y[1]).conj() * (x[0] - x[1]) * 3.0;
        let found = Complex::new(forms.c.re.to_f64(), forms.c.im.to_f64());
        assert_eq!(found, expected);
        // λ² + 4 from 1.5i, a shape of one component.
        let one = network(&[1.0], &[(0, 1, 4.0)], &[]);
        let forms = Forms::<DoubleDouble>::of(&one, &[Complex::ONE], &[Complex::ONE]);
        let root = forms.root(Complex::new(0.0, 1.5)).unwrap();
        assert_eq!(root, Complex::new(0.0, 2.0));
        // Too far to be led anywhere.
        assert!(forms.root(Complex::new(0.0, 0.1)).is_none());
    }
}
