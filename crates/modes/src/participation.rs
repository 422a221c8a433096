//! How much of the mass each mode carries when the ground shakes. It knows `model`, `solver` and `system`.

use eigentone_digits::DoubleDouble;
use thiserror::Error;

use crate::model::{CoordinateKind, MatrixKind};
use crate::solver::parts::{groups, joined_by, part};
use crate::solver::{ClassicalModes, ModesError};
use crate::system::System;

/// Participation factors and effective modal masses of the real modes of an undamped or classically
/// damped system (Chopra, *Dynamics of Structures*, §13.1–13.2).
///
/// The influence vector ι holds the displacement of each coordinate when the ground moves by 1: all
/// ones where every coordinate points along the motion. Supports and held ends of beams and rods move with the ground, by 1 too,
/// where they measure what the coordinates that move do; M_s is what their motion adds to M x″. With x_r the shape, m_r = x_rᵀMx_r
/// the modal mass and L_r = x_rᵀ(Mι + M_s), mode r has the participation factor Γ_r = L_r/m_r and the effective
/// mass L_r²/m_r. Over all modes, rigid ones included, the effective masses add up to the [mass](Self::total_mass), but for a part of
/// what supports and held ends carry; massless coordinates add nothing to either side. Among modes of one frequency
/// only the sum is determined.
///
/// ```
/// use eigentone_modes::{GROUND, Participation, System};
///
/// let system = System::builder()
///     .mass("lower", 2.0)
///     .mass("upper", 1.0)
///     .spring(GROUND, "lower", 8.0)
///     .spring("lower", "upper", 3.0)
///     .build()?;
/// let shaken = Participation::of(&system)?;
/// // The effective masses of all modes sum up to the mass.
/// let sum: f64 = shaken.effective_masses().iter().sum();
/// assert!((sum - shaken.total_mass()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Participation {
    modes: ClassicalModes,
    factors: Vec<f64>,
    effective: Vec<f64>,
    total: f64,
    defect: f64,
}

impl Participation {
    /// Participation in a motion that is the same for all coordinates: ι of ones. A spring or damper between two
    /// coordinates of one kind pulls by their difference, so that both have one direction and unit; only where these join
    /// all of them is there such a motion. Elsewhere masses may stand beside moments of inertia, which do not add up:
    /// see [`of_parts`](Self::of_parts).
    ///
    /// # Errors
    /// As [`along`](Self::along), and [`ParticipationError::NoCommonDirection`].
    pub fn of(system: &System) -> Result<Participation, ParticipationError> {
        let participation = Participation::along(system, &vec![1.0; system.len()])?;
        match directions(system).len() {
            1 => Ok(participation),
            _ => Err(ParticipationError::NoCommonDirection),
        }
    }

    /// The same for each direction that there is: coordinates, rising, that springs and dampers show to have one direction
    /// and unit, with the modes of all that is joined to these. An element shows it of two coordinates of one
    /// [kind](System::kind_of) if it pulls by their difference, whatever else stretches it: a wheel and the body above it move along one line, and the pitch of
    /// the body is another direction, of inertias in kg·m². Where a mass or stiffness matrix that was given joins what no
    /// element does, the whole has no common direction.
    ///
    /// ```
    /// use eigentone_modes::{GROUND, Participation, System};
    ///
    /// // A hoist beside a shaft: 300 kg and 5 kg·m².
    /// let system = System::builder()
    ///     .mass("cage", 300.0)
    ///     .mass("rotor", 5.0)
    ///     .spring(GROUND, "cage", 1e5)
    ///     .spring(GROUND, "rotor", 2e4)
    ///     .build()?;
    /// let totals: Vec<f64> = Participation::of_parts(&system)
    ///     .into_iter()
    ///     .map(|(_, part)| Ok(part?.total_mass()))
    ///     .collect::<Result<_, eigentone_modes::ParticipationError>>()?;
    /// assert_eq!(totals, [300.0, 5.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_parts(
        system: &System,
    ) -> Vec<(Vec<usize>, Result<Participation, ParticipationError>)> {
        Participation::of_parts_up_to(system, usize::MAX)
    }

    /// The same without the directions in which more coordinates with mass than `most` are joined, whose modes take longest.
    pub fn of_parts_up_to(
        system: &System,
        most: usize,
    ) -> Vec<(Vec<usize>, Result<Participation, ParticipationError>)> {
        let matrices = [MatrixKind::Mass, MatrixKind::Stiffness];
        let is_given = |kind: &MatrixKind| system.model().added_whole(*kind).is_given;
        let given: Vec<MatrixKind> = matrices.into_iter().filter(is_given).collect();
        if groups(system, &given).len() < groups(system, &[]).len() {
            let whole = (0..system.len()).collect();
            return vec![(whole, Err(ParticipationError::NoCommonDirection))];
        }
        let parts: Vec<(Vec<usize>, System)> = groups(system, &matrices)
            .into_iter()
            .map(|coordinates| {
                let part = part(system, &coordinates);
                (coordinates, part)
            })
            .collect();
        let each = directions(system).into_iter().filter_map(|direction| {
            let (coordinates, part) = parts
                .iter()
                .find(|(coordinates, _)| coordinates.binary_search(&direction[0]).is_ok())
                .expect("each coordinate is in a part");
            if part.len() - part.structure().massless().len() > most {
                return None;
            }
            let moves = |i: &usize| f64::from(u8::from(direction.binary_search(i).is_ok()));
            let whole: Vec<f64> = (0..system.len()).map(|i| moves(&i)).collect();
            let carried = Carried::of(system, &whole);
            let influence: Vec<f64> = coordinates.iter().map(moves).collect();
            let carried = Carried {
                force: coordinates.iter().map(|i| carried.force[*i]).collect(),
                ..carried
            };
            let participation = Participation::with(part, &influence, &carried);
            Some((direction, participation))
        });
        each.collect()
    }

    /// Participation in a motion with influence vector ι, one entry for each coordinate. Supports and held ends take part where
    /// all coordinates that do are of one [kind](System::kind_of): those of that kind.
    ///
    /// # Errors
    /// [`ParticipationError`] where the system has no real modes or ι does not fit it.
    pub fn along(system: &System, influence: &[f64]) -> Result<Participation, ParticipationError> {
        let (expected, found) = (system.len(), influence.len());
        if expected != found {
            return Err(ParticipationError::InfluenceLength { expected, found });
        }
        if let Some(index) = influence.iter().position(|entry| !entry.is_finite()) {
            let value = influence[index];
            return Err(ParticipationError::InfluenceNotFinite { index, value });
        }
        Participation::with(system, influence, &Carried::of(system, influence))
    }

    fn with(
        system: &System,
        influence: &[f64],
        carried: &Carried,
    ) -> Result<Participation, ParticipationError> {
        let modes = ClassicalModes::refined(system)?.ok_or(ParticipationError::NoRealModes)?;
        let inertia = inertia(system, influence);
        let dot = |x: &mut dyn Iterator<Item = f64>, forces: &[DoubleDouble]| {
            x.zip(forces)
                .fold(DoubleDouble::ZERO, |sum, (x, force)| sum + *force * x)
        };
        let own = dot(&mut influence.iter().copied(), &inertia);
        let beside = dot(&mut influence.iter().copied(), &carried.force);
        let total = own + beside + beside + carried.mass;
        let mut factors = Vec::with_capacity(modes.mass().len());
        let mut effective = Vec::with_capacity(modes.mass().len());
        let mut sum = DoubleDouble::ZERO;
        for (r, mass) in modes.mass().iter().enumerate() {
            let shape = || modes.shapes().col(r).iter().copied();
            let own = dot(&mut shape(), &inertia);
            let excitation = own + dot(&mut shape(), &carried.force);
            let factor = excitation / DoubleDouble::from(*mass);
            sum += own / DoubleDouble::from(*mass) * own;
            factors.push(factor.to_f64());
            effective.push((factor * excitation).to_f64());
        }
        let missing = (sum - own).to_f64();
        let defect = if missing == 0.0 {
            0.0
        } else {
            (missing / own.to_f64()).abs()
        };
        let total = total.to_f64();
        let all = factors.iter().chain(&effective);
        if !all.chain([&total, &defect]).all(|value| value.is_finite()) {
            return Err(ParticipationError::OutOfRange);
        }
        Ok(Participation {
            modes,
            factors,
            effective,
            total,
            defect,
        })
    }

    /// The modes, by rising frequency: shapes and modal masses m_r, in kg.
    pub fn modes(&self) -> &ClassicalModes {
        &self.modes
    }

    /// Γ_r, one for each mode. They belong to the shapes' scale, in which the largest entry is 1.
    pub fn factors(&self) -> &[f64] {
        &self.factors
    }

    /// L_r²/m_r in kg, one for each mode; they do not depend on the shapes' scale.
    pub fn effective_masses(&self) -> &[f64] {
        &self.effective
    }

    /// The mass that moves, in kg: ιᵀMι, and what couples to supports and held ends, 2 ιᵀM_s and their own.
    pub fn total_mass(&self) -> f64 {
        self.total
    }

    /// |Σ (x_rᵀMι)²/m_r − ιᵀMι| / ιᵀMι, which only rounding keeps from 0: a check of shapes and of their
    /// completeness.
    pub fn defect(&self) -> f64 {
        self.defect
    }
}

/// Coordinates of one kind, in groups in which elements pull by differences of two.
fn directions(system: &System) -> Vec<Vec<usize>> {
    let kind = |i: usize| system.kind_of(i);
    let elements = system.springs().iter().chain(system.dampers());
    let direct = elements.filter_map(|element| {
        let (i, j) = (element.first.coordinate()?, element.second.coordinate()?);
        (element.coefficient != 0.0 && kind(i) == kind(j)).then_some((i, j))
    });
    let squares = [MatrixKind::Damping, MatrixKind::Stiffness]
        .into_iter()
        .flat_map(|kind| &system.model().added_whole(kind).squares)
        .filter(|square| square.coefficient != 0.0);
    let through_points = squares.flat_map(|square| {
        [CoordinateKind::Displacement, CoordinateKind::Rotation]
            .into_iter()
            .filter_map(move |wanted| {
                let own = square.form.iter().filter(|(i, _)| kind(*i) == wanted);
                match own.copied().collect::<Vec<_>>()[..] {
                    [(i, a), (j, b)] if i != j && a == -b => Some((i, j)),
                    _ => None,
                }
            })
    });
    joined_by(system.len(), direct.chain(through_points))
}

/// What moves with the ground beside the coordinates.
struct Carried {
    /// M_s, one entry for each coordinate.
    force: Vec<DoubleDouble>,
    /// Of what mass couples to the coordinates that move.
    mass: DoubleDouble,
}

impl Carried {
    fn of(system: &System, influence: &[f64]) -> Carried {
        let mut carried = Carried {
            force: vec![DoubleDouble::ZERO; system.len()],
            mass: DoubleDouble::ZERO,
        };
        let moves = |i: usize| influence[i] != 0.0;
        let mut kinds = (0..influence.len())
            .filter(|i| moves(*i))
            .map(|i| system.kind_of(i));
        let (Some(kind), Some(machine)) = (kinds.next(), system.model().machine()) else {
            return carried;
        };
        if kinds.any(|other| other != kind) {
            return carried;
        }
        let mass = MatrixKind::Mass as usize;
        let (supports, held) = (&machine.support_kinds, &machine.held);
        for (kinds, coupling, between) in [
            (
                supports,
                &machine.couplings[mass],
                &machine.between_supports[mass],
            ),
            (&held.kinds, &held.coupling, &held.between),
        ] {
            let mut joined = vec![false; kinds.len()];
            for term in coupling.iter().filter(|term| moves(term.row)) {
                joined[term.column] |= kinds[term.column] == kind;
            }
            for term in coupling.iter().filter(|term| joined[term.column]) {
                carried.force[term.row] += DoubleDouble::from(term.value);
            }
            for term in between
                .iter()
                .filter(|term| joined[term.row] && joined[term.column])
            {
                carried.mass += DoubleDouble::from(term.value);
            }
        }
        carried
    }
}

/// Mι, summed from the elements.
fn inertia(system: &System, influence: &[f64]) -> Vec<DoubleDouble> {
    let lumped = system.masses().iter().zip(influence);
    let mut inertia: Vec<DoubleDouble> = lumped
        .map(|(mass, entry)| DoubleDouble::product(*mass, *entry))
        .collect();
    if let Some(matrix) = system.added(MatrixKind::Mass) {
        for (i, sum) in inertia.iter_mut().enumerate() {
            for (j, entry) in influence.iter().enumerate() {
                *sum += DoubleDouble::product(matrix[(i, j)], *entry);
            }
        }
        for tail in system.model().tails(MatrixKind::Mass) {
            inertia[tail.row] += DoubleDouble::product(tail.value, influence[tail.column]);
        }
    }
    inertia
}

/// Why there are no participation factors.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParticipationError {
    /// The damping is not proved to be classical, or M and K have no real modes.
    #[error(
        "the system is not proved to have real modes: participation needs symmetric M ≻ 0 and K, and no damping or C M⁻¹ K = K M⁻¹ C"
    )]
    NoRealModes,
    /// Not all coordinates have one direction and unit.
    #[error(
        "springs and dampers do not join all coordinates, so that some may have another direction or unit, and no motion is common to them: give the influence vector"
    )]
    NoCommonDirection,
    /// The influence vector has the wrong length.
    #[error("the influence vector has length {found}: it must be {expected}")]
    InfluenceLength {
        /// The number of coordinates.
        expected: usize,
        /// The entries given.
        found: usize,
    },
    /// An entry of the influence vector is infinite or NaN.
    #[error("entry {index} of the influence vector is {value:?}: it must be finite")]
    InfluenceNotFinite {
        /// Which entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// Factors or masses, or what they are sums of, leave the range of doubles.
    #[error(
        "participation factors or effective masses leave the range of doubles: give an influence vector nearer to 1, and masses that are neither so large nor so small"
    )]
    OutOfRange,
    /// The modes could not be computed.
    #[error(transparent)]
    Modes(#[from] ModesError),
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::model::GROUND;
    use crate::structure::samples;
    use crate::system::SystemBuilder;
    use crate::{Beam, BeamEnd, Rod, RodEnd};

    /// Masses and springs of 1 in a row, the first one tied to the ground if `grounded`.
    fn chain(n: usize, grounded: bool) -> SystemBuilder {
        let name = |i: usize| format!("m{i}");
        let mut builder = System::builder();
        for i in 0..n {
            builder = builder.mass(name(i), 1.0);
        }
        for i in 1..n {
            builder = builder.spring(name(i - 1), name(i), 1.0);
        }
        if grounded {
            builder = builder.spring(GROUND, name(0), 1.0);
        }
        builder
    }

    #[test]
    fn a_uniform_shear_building_has_its_known_effective_masses() {
        // Shapes sin jθ_r, θ_r = (2r − 1)π/(2n + 1), give L_r = ½cot(θ_r/2) and m_r = (2n + 1)/4.
        let n = 20;
        let participation = Participation::of(&chain(n, true).build().unwrap()).unwrap();
        assert_eq!(participation.total_mass(), 20.0);
        assert!(participation.defect() < 1e-14);
        for (r, effective) in participation.effective_masses().iter().enumerate() {
            let width = (2 * n + 1) as f64;
            let theta = (2 * r + 1) as f64 * std::f64::consts::PI / width;
            let expected = (theta / 2.0).tan().powi(-2) / width;
            assert!((effective - expected).abs() < 1e-13, "mode {r}");
        }
    }

    #[test]
    fn an_unsupported_system_carries_all_its_mass_in_its_rigid_motion() {
        let system = chain(5, false).build().unwrap();
        let participation = Participation::of(&system).unwrap();
        assert_eq!(participation.modes().stiffness()[0], 0.0);
        assert!((participation.factors()[0] - 1.0).abs() < 1e-15);
        assert!((participation.effective_masses()[0] - 5.0).abs() < 1e-14);
        assert!(
            participation.effective_masses()[1..]
                .iter()
                .all(|m| *m < 1e-28)
        );
        assert!(participation.defect() < 1e-15);
    }

    #[test]
    fn effective_masses_add_up_with_massless_nodes_and_a_full_mass_matrix() {
        let system = samples::chain(&[1e6, 0.0, 1e-3, 2.0], &[3.0, 1e8, 2e-2, 7.0], &[]);
        let participation = Participation::of(&system).unwrap();
        assert_eq!(participation.effective_masses().len(), 3);
        assert!(participation.defect() < 1e-14);

        let mass = Mat::from_fn(4, 4, |i, j| {
            if i == j {
                3.0
            } else {
                1.0 / (1 + i + j) as f64
            }
        });
        let system = chain(4, true)
            .matrix(MatrixKind::Mass, mass.as_ref())
            .build()
            .unwrap();
        let influence = [1.0, -0.5, 0.0, 2.0];
        let participation = Participation::along(&system, &influence).unwrap();
        let total: f64 = (0..4)
            .flat_map(|i| (0..4).map(move |j| (i, j)))
            .map(|(i, j)| influence[i] * system.mass_matrix()[(i, j)] * influence[j])
            .sum();
        assert!((participation.total_mass() - total).abs() < 1e-14 * total);
        assert!(participation.defect() < 1e-14);
    }

    #[test]
    fn classical_damping_changes_nothing() {
        let undamped = Participation::of(&chain(4, true).build().unwrap()).unwrap();
        let mut builder = chain(4, true).damper(GROUND, "m0", 0.5);
        for i in 1..4 {
            builder = builder.damper(format!("m{}", i - 1), format!("m{i}"), 0.5);
        }
        let damped = Participation::of(&builder.build().unwrap()).unwrap();
        let pairs = undamped.factors().iter().zip(damped.factors());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-14));
        assert!(damped.defect() < 1e-14);
    }

    #[test]
    fn factors_expand_the_influence_vector() {
        let system = chain(6, true).build().unwrap();
        let influence = [0.0, 1.0, 0.0, 0.0, -3.0, 1.0];
        let participation = Participation::along(&system, &influence).unwrap();
        let shapes = participation.modes().shapes();
        for (i, entry) in influence.iter().enumerate() {
            let terms = participation.factors().iter().enumerate();
            let sum: f64 = terms.map(|(r, factor)| factor * shapes[(i, r)]).sum();
            assert!((sum - entry).abs() < 1e-14);
        }
    }

    /// Heave in m, pitch in rad, and two wheels: 1000 kg, 1500 kg·m² and 85 kg have no sum.
    #[test]
    fn a_half_car_has_no_total_mass() {
        let (front, rear, a, b) = (18_000.0, 22_000.0, 1.1, 1.4);
        let stiffness = [
            [front + rear, -a * front + b * rear, -front, -rear],
            [
                -a * front + b * rear,
                a * a * front + b * b * rear,
                a * front,
                -b * rear,
            ],
            [-front, a * front, front + 190e3, 0.0],
            [-rear, -b * rear, 0.0, rear + 190e3],
        ];
        let stiffness = Mat::from_fn(4, 4, |i, j| stiffness[i][j]);
        let masses = [
            ("body", 1000.0),
            ("pitch", 1500.0),
            ("fw", 42.5),
            ("rw", 42.5),
        ];
        let car = masses
            .into_iter()
            .fold(System::builder(), |car, (name, mass)| car.mass(name, mass));
        let car = car.matrix(MatrixKind::Stiffness, stiffness.as_ref());
        let car = car.build().unwrap();
        let none = Some(ParticipationError::NoCommonDirection);
        assert_eq!(Participation::of(&car).err(), none);
        let parts = Participation::of_parts(&car);
        assert_eq!((parts.len(), parts[0].1.clone().err()), (1, none));
        // Whoever says which way each one points has an answer.
        let heave = Participation::along(&car, &[1.0, 0.0, 1.0, 1.0]).unwrap();
        assert!((heave.total_mass() - 1085.0).abs() < 1e-9 && heave.defect() < 1e-12);
    }

    /// Parts that only the ground joins have a total each, even where their frequencies are the same.
    #[test]
    fn parts_are_summed_by_themselves() {
        let both = chain(3, true).mass("p", 7.0).mass("q", 9.0);
        let both = both.spring(GROUND, "q", 9.0).spring("p", "q", 2.0);
        let both = both.build().unwrap();
        let parts = Participation::of_parts(&both);
        let found: Vec<(Vec<usize>, f64)> = parts
            .into_iter()
            .map(|(coordinates, part)| (coordinates, part.unwrap().total_mass()))
            .collect();
        assert_eq!(found, [(vec![0, 1, 2], 3.0), (vec![3, 4], 16.0)]);
        let small = Participation::of_parts_up_to(&both, 2);
        assert_eq!((small.len(), &small[0].0), (1, &vec![3, 4]));
        // A node without mass has no mode.
        let more = chain(3, true).mass("n", 0.0).spring("n", GROUND, 1.0);
        let more = more.spring("n", "m2", 1.0).build().unwrap();
        assert_eq!(Participation::of_parts_up_to(&more, 3).len(), 1);
        assert!(Participation::of_parts_up_to(&more, 2).is_empty());
    }

    /// The ground shakes held ends and supports, and what their mass couples to: 8/π² and 8/(9π²) of the mass of a rod, 61.31 % and 18.83 % of
    /// that of a clamped beam (the squares of 0.7830, 0.4339 and 0.2544, which are means of its shapes of mean square 1), in the limit of many elements; by hand for one.
    #[test]
    fn held_ends_and_supports_move_with_the_ground() {
        let rod = |elements: usize| {
            let rod = Rod {
                name: "r".to_owned(),
                length: 1.0,
                elements,
                axial_rigidity: 1.0,
                mass_per_length: 3.0,
                ends: [RodEnd::Fixed, RodEnd::Free],
                lumped: false,
                twists: false,
            };
            let system = System::builder().rod(rod).build().unwrap();
            Participation::of(&system).unwrap()
        };
        let close = |found: f64, expected: f64, within: f64| {
            assert!((found - expected).abs() <= within, "{found} for {expected}");
        };
        // M is 1 and M_s is 1/2.
        let one = rod(1);
        close(one.factors()[0], 1.5, 1e-15);
        close(one.effective_masses()[0], 2.25, 1e-15);
        close(one.total_mass(), 3.0, 1e-15);
        let many = rod(40);
        let pi = std::f64::consts::PI;
        for (r, share) in [(0, 8.0 / pi.powi(2)), (1, 8.0 / (9.0 * pi.powi(2)))] {
            close(many.effective_masses()[r] / 3.0, share, 1e-3);
        }
        let beam = Beam {
            name: "b".to_owned(),
            length: 2.0,
            elements: 20,
            flexural_rigidity: 5.0,
            mass_per_length: 0.7,
            ends: [BeamEnd::Clamped, BeamEnd::Free],
            lumped: false,
        };
        let system = System::builder().beam(beam).build().unwrap();
        let (_, across) = Participation::of_parts(&system).swap_remove(0);
        let across = across.unwrap();
        close(across.total_mass(), 1.4, 1e-14);
        for (r, share) in [(0, 0.61308), (1, 0.18830), (2, 0.06474)] {
            close(across.effective_masses()[r] / 1.4, share, 1e-4);
        }
        // Half of 4 kg follows the support.
        let system = System::builder()
            .mass("x", 1.0)
            .support("s")
            .point("p", [("x", 0.5), ("s", 0.5)], 4.0)
            .spring("s", "x", 1.0)
            .build()
            .unwrap();
        let half = Participation::of(&system).unwrap();
        close(half.factors()[0], 1.5, 1e-15);
        close(half.effective_masses()[0], 4.5, 1e-15);
        close(half.total_mass(), 5.0, 1e-15);
    }

    /// Frequencies of 1 rad/s that are 7e-15 apart, of five masses: as 60 digits have it.
    #[test]
    fn nearly_equal_frequencies_have_their_own_masses() {
        let mut builder = System::builder();
        for i in 0..5 {
            builder = builder.mass(format!("m{i}"), 2.0);
        }
        let springs = [
            (GROUND, "m0", 1.999999999999891),
            ("m0", "m1", 1.999999999999936),
            ("m0", "m2", 1.9999999999999312),
            (GROUND, "m3", 1.9999999999999967),
            ("m2", "m3", 2.000000000000052),
            ("m0", "m4", 2.0),
        ];
        for (from, to, stiffness) in springs {
            builder = builder.spring(from, to, stiffness);
        }
        let found = Participation::of(&builder.build().unwrap()).unwrap();
        let wanted = [
            9.059719437031918,
            0.445663138099339,
            0.354336861900675,
            0.0580354737368065,
            0.0822450892312611,
        ];
        for (found, wanted) in found.effective_masses().iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 1e-13, "{found} {wanted}");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let damped = chain(2, true).damper(GROUND, "m1", 0.3).build().unwrap();
        let refusal = |influence: &[f64]| Participation::along(&damped, influence).err();
        assert_eq!(refusal(&[1.0, 1.0]), Some(ParticipationError::NoRealModes));
        let (expected, found) = (2, 3);
        let length = ParticipationError::InfluenceLength { expected, found };
        assert_eq!(refusal(&[1.0; 3]), Some(length));
        let (index, value) = (1, f64::INFINITY);
        let infinite = ParticipationError::InfluenceNotFinite { index, value };
        assert_eq!(refusal(&[1.0, f64::INFINITY]), Some(infinite));
        let two = chain(2, true).build().unwrap();
        let far = Participation::along(&two, &[1e300, 1.0]);
        assert_eq!(far.err(), Some(ParticipationError::OutOfRange));
    }
}
