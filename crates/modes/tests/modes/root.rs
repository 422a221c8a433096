//! Known roots beside the ones found.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{Eigenvalue, GROUND, Modes, System};

pub const U: f64 = f64::EPSILON / 2.0;

/// A root known to 30 digits.
#[derive(Clone, Copy, Debug)]
pub struct Root {
    pub re: DoubleDouble,
    pub im: DoubleDouble,
}

impl Root {
    pub fn new(re: impl Into<DoubleDouble>, im: impl Into<DoubleDouble>) -> Root {
        let (re, im) = (re.into(), im.into());
        Root { re, im }
    }

    pub fn conjugate(self) -> Root {
        Root {
            im: -self.im,
            ..self
        }
    }

    pub fn size(self) -> f64 {
        self.re.to_f64().hypot(self.im.to_f64())
    }

    fn error(self, found: &Eigenvalue) -> (f64, f64) {
        let re = (self.re - found.value.re.into()).to_f64();
        let im = (self.im - found.value.im.into()).to_f64();
        (re.hypot(im), re.abs())
    }
}

/// Both roots of s² + 2ζω s + ω², without cancellation.
pub fn quadratic(omega: DoubleDouble, zeta: DoubleDouble) -> [Root; 2] {
    let one = DoubleDouble::from(1.0);
    let rest = (one - zeta) * (one + zeta);
    if rest < DoubleDouble::ZERO {
        let fast = -(omega * (zeta + (-rest).sqrt()));
        [Root::new(fast, 0.0), Root::new(omega * omega / fast, 0.0)]
    } else {
        let root = Root::new(-(zeta * omega), omega * rest.sqrt());
        [root, root.conjugate()]
    }
}

/// Pairs each root, largest first, with the nearest one that is left, and asserts that errors stay
/// within `units` of |λ|, twice that of Re λ, and every bound.
pub fn assert_roots(roots: &[Root], modes: &Modes, units: f64, what: &str) {
    let mut left = modes.eigenvalues().to_vec();
    assert_eq!(left.len(), roots.len(), "{what}: number of finite roots");
    let mut order = roots.to_vec();
    order.sort_by(|a, b| b.size().total_cmp(&a.size()));
    for root in order {
        let rank = |found: &Eigenvalue| {
            let (error, real_error) = root.error(found);
            let (bound, real_bound) = (found.bound, found.real_bound);
            let holds = bound >= Some(error) && real_bound >= Some(real_error);
            (error, !holds, bound.unwrap_or(f64::INFINITY))
        };
        let nearest = (0..left.len())
            .min_by(|&a, &b| {
                let (a, b) = (rank(&left[a]), rank(&left[b]));
                let nearer = a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
                nearer.then(a.2.total_cmp(&b.2))
            })
            .expect("as many are left as there are");
        let found = left.swap_remove(nearest);
        let (error, real_error) = root.error(&found);
        let (size, re) = (root.size(), root.re.to_f64().abs());
        let what = format!("{what}: {root:?} found as {found:?}");
        assert!(
            error <= units * U * size,
            "{what}: {:e} u",
            error / size / U
        );
        assert!(
            real_error <= 2.0 * units * U * re,
            "{what}: {:e} u of Re λ",
            real_error / re / U
        );
        assert!(found.bound >= Some(error), "{what}: {error:e}");
        assert!(
            found.real_bound >= Some(real_error),
            "{what}: {real_error:e}"
        );
    }
}

/// An element between masses counted from 1, 0 being the ground.
pub type Join = (usize, usize, f64);

pub fn network(masses: &[f64], springs: &[Join], dampers: &[Join]) -> System {
    let name = |i: usize| match i {
        0 => GROUND.to_owned(),
        i => format!("m{i}"),
    };
    let mut builder = System::builder();
    for (i, mass) in masses.iter().enumerate() {
        builder = builder.mass(name(i + 1), *mass);
    }
    for &(a, b, stiffness) in springs {
        builder = builder.spring(name(a), name(b), stiffness);
    }
    for &(a, b, damping) in dampers {
        builder = builder.damper(name(a), name(b), damping);
    }
    builder.build().expect("a regular system")
}
