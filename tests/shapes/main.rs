//! Proven bounds of mode shapes, against shapes known to 34 digits.
//!
//! `truth.json` has, for systems of the gallery and of `tests/extreme`, the shapes of simple roots
//! `root` (of three for systems of 40 coordinates and more), each component as `[re]` or `[re, im]`, the largest 1, the first
//! one on ties, and `left` for the systems that are not symmetric. Their doubles were taken exactly; roots and
//! shapes come from inverse iteration with two-sided Rayleigh quotients in balls of 1400 to 3000 bits (python-flint 0.9), which
//! started from the roots in `truth/NAME.json` there. Random systems are compared with
//! `eigentone::check::Reference`, which evaluates the adjugate of λ²M + λC + K in exact polynomials.

use std::collections::BTreeMap;
use std::path::Path;

use eigentone::check::{Reference, Shape};
use eigentone::gallery::{Decimal, cases};
use eigentone::modes::{Bounds, GROUND, Mode, Modes, System};
use eigentone::scene::Scene;
use eigentone_digits::{ComplexDoubleDouble, DoubleDouble};
use num_complex::Complex;
use proptest::prelude::*;
use serde::Deserialize;

const U: f64 = f64::EPSILON / 2.0;

/// Components below are not distinguished from 0.
const HIDDEN: f64 = 1e-22;

#[derive(Deserialize)]
struct TrueMode {
    root: [Decimal; 2],
    shape: Vec<Vec<Decimal>>,
    left: Option<Vec<Vec<Decimal>>>,
}

fn truth() -> BTreeMap<String, Vec<TrueMode>> {
    serde_json::from_str(include_str!("truth.json")).expect("it was written by a program")
}

fn scene(name: &str) -> Scene {
    let case = cases().iter().find(|case| case.name() == name);
    case.map_or_else(
        || {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/extreme/scenes");
            Scene::read(&folder.join(format!("{name}.json"))).expect("it can be read")
        },
        |case| case.scene(),
    )
}

fn wide(parts: &[Decimal]) -> ComplexDoubleDouble {
    let part = |k: usize| {
        parts.get(k).map_or(DoubleDouble::ZERO, |part| {
            let high = part.to_f64();
            DoubleDouble::new(high, part.minus(high))
        })
    };
    ComplexDoubleDouble {
        re: part(0),
        im: part(1),
    }
}

/// What is wrong with a shape and its bounds, beside the true shape scaled to the same component.
fn faults(
    shape: &[Complex<f64>],
    bounds: &[f64],
    truth: &[Vec<Decimal>],
    units: f64,
) -> Vec<String> {
    let truth: Vec<ComplexDoubleDouble> = truth.iter().map(|parts| wide(parts)).collect();
    let one = (0..shape.len()).find(|i| bounds[*i] == 0.0 && shape[*i] == Complex::ONE);
    let Some(one) = one else {
        return vec!["no component is 1".to_owned()];
    };
    let mut faults = Vec::new();
    if shape[..one].iter().any(|x| x.norm() >= 1.0 + 2.0 * U) || truth[one].norm() < 1.0 - 2.0 * U {
        faults.push(format!("component {one} is not the first of the largest"));
    }
    for (i, (found, bound)) in shape.iter().zip(bounds).enumerate() {
        let scaled = truth[i] / truth[one];
        let error = (scaled - ComplexDoubleDouble::new(found.re, found.im)).norm();
        let size = scaled.norm();
        if error > bound * (1.0 + 1e-12) + 1e-30 * size + 1e-300 {
            let fault = format!("component {i}, {found}: {error:e} is beyond {bound:e}");
            faults.push(fault);
        }
        let loose = if size == 0.0 {
            HIDDEN
        } else {
            units * U * size
        };
        if *bound > loose {
            faults.push(format!("component {i}, {found}: a bound of {bound:e}"));
        }
    }
    faults
}

/// The mode that a root belongs to: of those that may, the one whose shape fits best.
fn mode_of<'a>(modes: &'a Modes, truth: &TrueMode) -> Option<&'a Mode> {
    let [re, im] = &truth.root;
    let may = modes.iter().filter(|mode| {
        let root = mode.eigenvalue();
        let error = re.minus(root.value.re).hypot(im.minus(root.value.im));
        root.bound
            .is_some_and(|bound| error <= bound + 1e-33 * root.value.norm())
    });
    // Scaled to another component, a shape may seem far from what it is.
    let aligned = |mode: &Mode| {
        let pairs = || mode.shape().iter().zip(&truth.shape);
        let wide = |(x, truth): (&Complex<f64>, &Vec<Decimal>)| {
            let im = truth.get(1).map_or(0.0, Decimal::to_f64);
            (*x, Complex::new(truth[0].to_f64(), im))
        };
        let product: Complex<f64> = pairs().map(wide).map(|(x, y)| x.conj() * y).sum();
        let square: f64 = mode.shape().iter().map(Complex::norm_sqr).sum();
        product.norm_sqr() / square
    };
    may.max_by(|a, b| aligned(a).total_cmp(&aligned(b)))
}

#[test]
fn every_component_is_right_to_the_last_digits() {
    let truth = truth();
    let mut wrong = Vec::new();
    let mut left_shapes = 0;
    for (name, rows) in &truth {
        let scene = scene(name);
        let system = scene.system();
        let modes = system.modes().expect("it has modes");
        // Above 64 coordinates there are no more digits than 32.
        let units = if system.len() > 64 {
            f64::INFINITY
        } else {
            4.0
        };
        for row in rows {
            let what = format!(
                "{name}, {} + {}i",
                row.root[0].as_str(),
                row.root[1].as_str()
            );
            let Some(mode) = mode_of(&modes, row) else {
                wrong.push(format!("{what}: no mode"));
                continue;
            };
            let Some(bounds) = mode.shape_bound() else {
                // Twins coupled by 1e-40 of their springs.
                if name != "twins-closest" {
                    wrong.push(format!("{what}: no bounds"));
                }
                continue;
            };
            let mut found = faults(mode.shape(), bounds, &row.shape, units);
            if let (Some(truth), Some(left)) = (&row.left, mode.left_shape()) {
                let bounds = mode.left_shape_bound().expect("beside those of the shape");
                found.extend(faults(left, bounds, truth, units));
                left_shapes += 1;
            }
            wrong.extend(found.into_iter().map(|fault| format!("{what}: {fault}")));
        }
    }
    assert!(
        truth.len() > 70 && left_shapes > 15,
        "{} {left_shapes}",
        truth.len()
    );
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

/// Up to five masses, each tied to the ground or to an earlier one, with some more springs and dampers.
fn any_system() -> impl Strategy<Value = System> {
    let size = |reach: f64| (-reach..reach).prop_map(|power| 10f64.powf(power));
    let links = prop::collection::vec((any::<usize>(), any::<usize>(), size(4.0)), 1..6);
    let dampers = prop::collection::vec((any::<usize>(), any::<usize>(), size(3.0)), 0..4);
    let masses = prop::collection::vec((size(3.0), size(5.0), any::<usize>()), 1..6);
    (masses, links, dampers, any::<bool>()).prop_map(|(masses, links, dampers, whole)| {
        // Whole numbers make symmetric systems, with components that vanish.
        let value = |x: f64| {
            if whole {
                x.log10().abs().ceil().max(1.0)
            } else {
                x
            }
        };
        let n = masses.len();
        let name = |i: usize| match i {
            0 => GROUND.to_owned(),
            i => format!("m{i}"),
        };
        let mut builder = System::builder();
        for (i, (mass, ..)) in masses.iter().enumerate() {
            builder = builder.mass(name(i + 1), value(*mass));
        }
        for (i, (_, spring, to)) in masses.iter().enumerate() {
            builder = builder.spring(name(to % (i + 1)), name(i + 1), value(*spring));
        }
        let pair = |i: usize, j: usize| (i % (n + 1), j % (n + 1));
        for (i, j, spring) in links {
            let (i, j) = pair(i, j);
            if i != j {
                builder = builder.spring(name(i), name(j), value(spring));
            }
        }
        for (i, j, damper) in dampers {
            let (i, j) = pair(i, j);
            if i != j {
                builder = builder.damper(name(i), name(j), value(damper));
            }
        }
        builder.build().expect("names and numbers are in order")
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn random_systems_agree_with_exact_polynomials(system in any_system()) {
        // Components of 1e-40 of the largest one are known to 30 digits too.
        let reference = Reference::with_digits(80);
        let roots = reference.modes(&system).expect("it is small");
        let shapes = reference.shapes(&system, &roots).expect("it is small");
        let modes = system.modes().expect("it has modes");
        prop_assert_eq!(modes.bounds(), Bounds::Proven);
        let decimal = |digits: &eigentone::check::Ball| -> Decimal {
            serde_json::from_value(digits.to_decimal(38).into()).expect("a number")
        };
        for (root, shape) in roots.eigenvalues().iter().zip(shapes) {
            let (re, im) = (decimal(&root.re), decimal(&root.im));
            if root.multiplicity > 1 || im.to_f64() < 0.0 {
                continue;
            }
            let Shape::Determined(components) = shape else {
                continue;
            };
            let shape = components.iter().map(|x| vec![decimal(&x.re), decimal(&x.im)]);
            let truth = TrueMode { root: [re, im], shape: shape.collect(), left: None };
            let mode = mode_of(&modes, &truth);
            prop_assert!(mode.is_some());
            let mode = mode.expect("asserted");
            // Parts that nothing joins may share a root as far as doubles show.
            let Some(bounds) = mode.shape_bound() else {
                prop_assert!(mode.multiplicity() != Some(1), "{:?}", mode);
                continue;
            };
            let found = faults(mode.shape(), bounds, &truth.shape, 4.0);
            prop_assert!(found.is_empty(), "{:?}", found);
        }
    }
}
