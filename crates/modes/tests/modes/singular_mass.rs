//! Mass matrices that are singular beyond massless nodes, beside roots known to 32 digits.
//!
//! Those in `singular-mass.txt` come from det(λ²M + λC + K), expanded exactly, split into its
//! factors and isolated in ball arithmetic by FLINT 3 (python-flint 0.9) at 600 bits. A system is
//! its name and size, the rows of M, C and K, and its finite roots: re, im, each as a sum of two
//! doubles, and the multiplicity.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Bounds, Precision, System};
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
