//! Mass matrices that are singular beyond massless nodes, beside roots known to 32 digits.
//!
//! Those in `singular-mass.txt` come from det(λ²M + λC + K), expanded exactly, split into its
//! factors and isolated in ball arithmetic by FLINT 3 (python-flint 0.9) at 600 bits. A system is
//! its name and size, the rows of M, C and K, and its finite roots: re, im, each as a sum of two
//! doubles, and the multiplicity.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Bounds, Eigenvalue, GROUND, Precision, System};
use faer::Mat;

use crate::root::{Root, assert_roots};

struct Case {
    name: String,
    system: System,
    roots: Vec<Root>,
}

fn cases() -> Vec<Case> {
    let mut lines = include_str!("singular-mass.txt").lines();
    let mut cases = Vec::new();
    while let Some(head) = lines.next() {
        let words: Vec<&str> = head.split_whitespace().collect();
        let n: usize = words[2].parse().unwrap();
        let numbers = |line: &str| -> Vec<f64> {
            let words = line.split_whitespace();
            words.map(|word| word.parse().unwrap()).collect()
        };
        let [m, c, k] = [(); 3].map(|()| {
            let rows: Vec<Vec<f64>> = lines.by_ref().take(n).map(numbers).collect();
            Mat::from_fn(n, n, |i, j| rows[i][j])
        });
        let count = lines.next().unwrap().strip_prefix("roots ").unwrap();
        let listed = lines.by_ref().take(count.parse().unwrap()).map(numbers);
        let roots = listed.flat_map(|root| {
            let part = |at: usize| DoubleDouble::new(root[at], root[at + 1]);
            vec![Root::new(part(0), part(2)); root[4] as usize]
        });
        cases.push(Case {
            name: words[1].to_owned(),
            roots: roots.collect(),
            system: System::from_matrices(m.as_ref(), c.as_ref(), k.as_ref()).unwrap(),
        });
    }
    assert_eq!(cases.len(), 8);
    cases
}

#[test]
fn all_finite_roots_are_proven() {
    for Case {
        name,
        system,
        roots,
    } in cases()
    {
        let modes = system
            .modes()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(modes.bounds(), Bounds::Proven, "{name}: {}", modes.plan());
        assert_eq!(modes.infinite(), 2 * system.len() - roots.len(), "{name}");
        assert_roots(&roots, &modes, 4.0, &name);
        for mode in &modes {
            let error = mode.backward_error();
            assert!(error <= 1e-14, "{name}: {error:e}");
            let bound = mode.eigenvalue().bound.unwrap();
            assert!(
                bound <= 1e-13 * mode.eigenvalue().value.norm(),
                "{name}: {bound:e}"
            );
        }
    }
}

#[test]
fn doubles_find_as_many_and_solve_a_system_close_by() {
    for Case {
        name,
        system,
        roots,
    } in cases()
    {
        let modes = system.modes_to(Precision::Double).unwrap();
        assert_eq!(modes.eigenvalues().len(), roots.len(), "{name}");
        let zero = |roots: &[f64]| roots.iter().filter(|size| **size == 0.0).count();
        let found: Vec<f64> = modes.eigenvalues().iter().map(|z| z.value.norm()).collect();
        let known: Vec<f64> = roots.iter().map(|root| root.size()).collect();
        assert_eq!(zero(&found), zero(&known), "{name}");
        for mode in modes.iter().filter(|mode| mode.roots() == 1) {
            assert!(
                mode.backward_error() <= 1e-10,
                "{name}: {:e}",
                mode.backward_error()
            );
        }
    }
}

/// A spring is two of twice its stiffness with a massless node between them: beyond 64 coordinates, stiff beside soft, free and
/// held, with and without a dashpot.
#[test]
fn massless_nodes_within_springs_change_no_root() {
    const MASSES: usize = 70;
    let stiffness = |i: usize| [1.0, 3e4, 0.25, 40.0][i % 4] * (1.0 + i as f64 / 64.0);
    for (held, damping) in [(true, 0.0), (false, 0.0), (true, 0.7), (false, 0.7)] {
        let chain = |split: bool| {
            let mut builder = System::builder();
            for i in 0..MASSES {
                builder = builder.mass(format!("m{i}"), 1.0 + (i % 5) as f64);
            }
            let mut springs: Vec<(String, String, f64)> = (1..MASSES)
                .map(|i| (format!("m{}", i - 1), format!("m{i}"), stiffness(i)))
                .collect();
            if held {
                springs.push((GROUND.to_owned(), "m0".to_owned(), 2.0));
            }
            for (at, (a, b, k)) in springs.into_iter().enumerate() {
                builder = if split {
                    let between = format!("n{at}");
                    builder
                        .mass(&between, 0.0)
                        .spring(a, &between, 2.0 * k)
                        .spring(between, b, 2.0 * k)
                } else {
                    builder.spring(a, b, k)
                };
            }
            if damping > 0.0 {
                builder = builder.damper("m3", format!("m{}", MASSES - 1), damping);
            }
            builder.build().expect("a chain")
        };
        let [whole, split] = [false, true].map(|split| chain(split).modes().expect("modes"));
        for modes in [&whole, &split] {
            assert_eq!(modes.bounds(), Bounds::Proven, "{}", modes.plan().bounds);
        }
        assert_eq!(whole.eigenvalues().len(), split.eigenvalues().len());
        let mut left: Vec<_> = whole.eigenvalues().to_vec();
        for b in split.eigenvalues() {
            let is_met = |a: &Eigenvalue| {
                let [first, second] = [a, b].map(|root| root.bound.expect("a proven bound"));
                (a.value - b.value).norm() <= first + second
            };
            let met = left.iter().position(is_met);
            left.swap_remove(met.unwrap_or_else(|| panic!("{b:?}")));
            assert!(
                b.bound.expect("a proven bound") <= 1e-9 * b.value.norm(),
                "{b:?}"
            );
        }
    }
}

/// A cantilever of Euler–Bernoulli elements whose mass is lumped, so that rotations have none: M and K.
fn lumped_cantilever(elements: usize) -> [Mat<f64>; 2] {
    let (h, n) = (2.0 / elements as f64, 2 * (elements + 1));
    let rows = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
    ];
    let (mut mass, mut stiffness) = (Mat::<f64>::zeros(n, n), Mat::<f64>::zeros(n, n));
    for first in (0..elements).map(|element| 2 * element) {
        for (i, row) in rows.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                stiffness[(first + i, first + j)] += 1500.0 / h.powi(3) * entry;
            }
        }
        mass[(first, first)] += 3.1 * h / 2.0;
        mass[(first + 2, first + 2)] += 3.1 * h / 2.0;
    }
    [mass, stiffness].map(|matrix| matrix.submatrix(2, 2, n - 2, n - 2).to_owned())
}

/// With C = βK exactly, λ² + βω²λ + ω² = 0 for every ω of the undamped beam, and every rotation has a root −1/β.
#[test]
fn rotations_without_mass_relax_together_under_stiffness_proportional_damping() {
    let beta = 2f64.powi(-13);
    for elements in [33, 40] {
        let [mass, stiffness] = lumped_cantilever(elements);
        let modes = |damping: Mat<f64>| {
            let system = System::from_matrices(mass.as_ref(), damping.as_ref(), stiffness.as_ref());
            system.expect("a beam").modes().expect("modes")
        };
        let undamped = modes(Mat::zeros(2 * elements, 2 * elements));
        let damped = modes(&stiffness * faer::Scale(beta));
        assert_eq!(undamped.bounds(), Bounds::Proven);
        assert_eq!(damped.bounds(), Bounds::Proven, "{}", damped.plan());
        let mut expected = vec![-1.0 / beta; elements];
        let mut oscillating = Vec::new();
        for mode in &undamped {
            let square = mode.eigenvalue().value.im.powi(2);
            let half = 0.5 * beta * square;
            if half * half < square {
                oscillating.push((-half, (square - half * half).sqrt()));
            } else {
                let slow = -square / (half + (half * half - square).sqrt());
                expected.extend([slow, square / slow]);
            }
        }
        let mut real = Vec::new();
        let mut complex = Vec::new();
        for Eigenvalue { value, bound, .. } in damped.eigenvalues() {
            let bound = bound.expect("a bound");
            if value.im == 0.0 {
                real.push((value.re, bound));
            } else if value.im > 0.0 {
                complex.push((value.re, value.im, bound));
            }
        }
        real.sort_by(|a, b| a.0.total_cmp(&b.0));
        expected.sort_by(f64::total_cmp);
        complex.sort_by(|a, b| a.1.total_cmp(&b.1));
        oscillating.sort_by(|a, b| a.1.total_cmp(&b.1));
        assert_eq!(
            (real.len(), complex.len()),
            (expected.len(), oscillating.len())
        );
        for ((root, bound), expected) in real.iter().zip(&expected) {
            let off = (root - expected).abs();
            assert!(
                off <= bound + 1e-11 * expected.abs(),
                "{root} for {expected}"
            );
            assert!(*bound <= 1e-13 * root.abs(), "{root} ± {bound}");
        }
        for ((re, im, bound), (decay, frequency)) in complex.iter().zip(&oscillating) {
            // Near critical damping the square root above loses digits.
            let rounding = 1e-15 * (decay * decay / frequency + frequency);
            let off = (re - decay).hypot(im - frequency);
            assert!(
                off <= bound + 8.0 * rounding,
                "{re} ± {im}i for {decay} ± {frequency}i"
            );
        }
    }
}
