//! The condition of a system's own exponential.

use eigentone_digits::DoubleDouble;
use eigentone_modes::{EnclosedFirstOrder, System};
use faer::Mat;

use super::condition::expm_condition;
use crate::enclosed::Energy;

/// An estimate of the relative condition of e^{Ah} in the 1-norm, as
/// [`expm_condition`](super::expm_condition) gives it, for the state matrix A of a system and a step
/// of `h` s, in energy coordinates: displacements and velocities weighted so that the square of a
/// state's length is twice its energy.
///
/// In plain coordinates displacements and velocities are of very different size when springs are stiff,
/// and a condition taken there says little about the motion: for a chain with springs of 1e12 it is
/// 1e5 times larger. In energy coordinates a passive system never lengthens a state.
///
/// `None` where the system has no first-order form (see [`FirstOrder`](eigentone_modes::FirstOrder)),
/// where 32 digits do not suffice to take it to these coordinates, and where Ah leaves the range of
/// doubles.
pub fn energy_condition(system: &System, h: f64) -> Option<f64> {
    let form = EnclosedFirstOrder::<DoubleDouble>::of(system).ok()?;
    let structure = system.structure();
    let supported = structure.is_passive() && structure.zero_roots() == Some(0);
    let energy = Energy::of(&form, supported, 1.0 / h)?;
    let moved = energy.r.times(form.a()).times(&energy.y);
    let n = form.states();
    let a = Mat::from_fn(n, n, |i, j| moved.middle(i, j).to_f64() * h);
    expm_condition(a.as_ref()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eigentone_modes::{FirstOrder, GROUND};

    #[test]
    fn energy_tames_a_stiff_chain() {
        let mut chain = System::builder();
        for (name, before, stiffness) in [
            ("a", GROUND, 1.0),
            ("b", "a", 1e12),
            ("c", "b", 1.0),
            ("d", "c", 1e12),
        ] {
            chain = chain.mass(name, 1.0).spring(before, name, stiffness);
        }
        let system = chain.build().expect("a chain");
        let form = FirstOrder::of(&system).expect("regular");
        // Short beside the fastest period, so that the plain condition can be computed in doubles.
        let h = 1e-5;
        let a = form.a() * faer::Scale(h);
        let plain = expm_condition(a.as_ref()).expect("finite");
        let energy = energy_condition(&system, h).expect("it is supported");
        assert!(energy < 1e3, "{energy:e}");
        assert!(plain > 1e5 * energy, "{plain:e} {energy:e}");
    }

    #[test]
    fn a_turning_state_is_as_well_conditioned_as_its_angle() {
        // In energy coordinates e^{Ah} turns by ωh: a relative change of A by ε changes it by ωhε.
        let system = System::builder().mass("m", 3.0).spring(GROUND, "m", 12e8);
        let system = system.build().expect("one mass");
        let angle = 7.0;
        let condition = energy_condition(&system, angle / 2e4).expect("supported");
        assert!((condition - angle).abs() < 1e-12, "{condition}");
    }
}
