//! What is asked of a frequency response: from where, to where, at which frequencies.

use std::sync::{Arc, OnceLock};

use eigentone_digits::sort_by_number;
use eigentone_modes::{
    Bounds, ElementKind, Form, GROUND, Precision, SparseDynamicStiffness, SparseError, System,
};
use thiserror::Error;

use super::dynamic_stiffness::{Block, DynamicStiffness, Part, carried, losses};
use super::enclosure::{Asked, Enclosed, Question, Value, enclose};
use super::features::{Features, Glance};
use super::function::{FrequencyFunction, FrequencyFunctions, FrequencyMethod, FrequencyValue};
use super::hessenberg::Hessenberg;
use super::limit::{Limit, limits};
use super::modal_functions::{self, ModalFunctions};
use super::modal_sum::ModalSum;
use super::phasor::Phase;
use super::ports::{Ports, Push, Reading};
use super::sparse_factor;
use super::transfer::Transfer;
use super::turns::{Centers, turns};
use crate::problem::{Combination, Quantity, Source, Sum};

/// The frequency response functions of a system: what swings where, for each unit of what acts.
///
/// An input is a unit force e^{iΩt} on a coordinate or a point, or a unit displacement of a support. An output is the
/// motion of a coordinate, point or support, by the [`quantity`](Self::quantity) asked for, or a [`Combination`], such as
/// the pull of an element. From a force to a displacement that is a *receptance*, to a velocity a *mobility*, to an
/// acceleration an *accelerance*; from a support's displacement to a displacement, a *transmissibility* (Ewins 2000,
/// *Modal Testing*, section 2.6).
///
/// The equations (K − Ω²M + iΩC) X = F are solved in ball arithmetic, from the elements, with as many digits as it takes:
/// every value has a proven bound of a few units in its own last place, beside a resonance as at an antiresonance, unless
/// it is less than 1e-30 of the terms that it is the sum of. Beyond 400 coordinates one sparse factor in doubles, refined
/// with residuals in double-double, answers for each frequency, with estimated bounds.
///
/// ```
/// use eigentone_modes::System;
/// use eigentone_response::FrequencyResponse;
///
/// let car = System::builder()
///     .mass("body", 290.0)
///     .mass("wheel", 59.0)
///     .support("road")
///     .spring("wheel", "body", 16_812.0)
///     .damper("wheel", "body", 1_000.0)
///     .spring("road", "wheel", 190_000.0)
///     .build()?;
/// let answer = FrequencyResponse::of(&car).from("road").to("body").at(&[5.0])?;
/// let (value, bound) = answer.functions()[0].values()[0].known().expect("no pole");
/// assert!((value.re - 1.708_446_956_156_639_8).abs() <= bound.expect("it is proven"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FrequencyResponse<'a> {
    system: &'a System,
    inputs: Vec<String>,
    outputs: Vec<Output>,
    quantity: Quantity,
    loss_factors: Vec<f64>,
    precision: Precision,
    /// Found when first asked for; clones share them. `None` where they do not serve.
    modes: Arc<OnceLock<Option<ModalSum>>>,
}

/// What is looked at.
#[derive(Clone, Debug)]
enum Output {
    Place(String),
    Combination(Combination),
}

/// Why there is no frequency response.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FrequencyError {
    /// A name that is nothing which can move.
    #[error("{name:?} is neither a coordinate nor a point nor a support: known: {known}")]
    UnknownPlace {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// No input was named.
    #[error("no input is named: from which coordinate, point or support?")]
    NoInput,
    /// A combination that cannot be formed.
    #[error("output {name:?}: {reason}")]
    Combination {
        /// What it is called.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A frequency that is negative, infinite or NaN.
    #[error("the frequency is {frequency:?} rad/s: it must be a finite number, 0 or more")]
    Frequency {
        /// The frequency given.
        frequency: f64,
    },
    /// There are not as many loss factors as springs.
    #[error("there are {given} loss factors for {springs} springs")]
    LossFactors {
        /// How many were given.
        given: usize,
        /// How many springs there are.
        springs: usize,
    },
    /// A loss factor is negative, infinite or NaN.
    #[error(
        "the loss factor of spring {index} is {value:?}: it must be a finite number, 0 or more"
    )]
    LossFactor {
        /// The spring's index, from 0.
        index: usize,
        /// The factor given.
        value: f64,
    },
    /// A value exceeds the largest double.
    #[error("from {from:?} to {to:?} at {frequency:?} rad/s: the value exceeds the largest double")]
    OutOfRange {
        /// The input.
        from: String,
        /// The output.
        to: String,
        /// Ω in rad/s.
        frequency: f64,
    },
    /// A system with many coordinates whose dynamic stiffness has no sparse factor.
    #[error(transparent)]
    Sparse(#[from] SparseError),
}

/// Systems with more coordinates than this are solved by a sparse factor for each frequency.
const MOST_DENSE: usize = 400;

impl<'a> FrequencyResponse<'a> {
    /// Of this system: inputs are to be named by [`from`](Self::from). Where no output is named by [`to`](Self::to) or
    /// [`output`](Self::output), all coordinates are.
    pub fn of(system: &'a System) -> FrequencyResponse<'a> {
        FrequencyResponse {
            system,
            inputs: Vec::new(),
            outputs: Vec::new(),
            quantity: Quantity::Displacement,
            loss_factors: Vec::new(),
            precision: Precision::default(),
            modes: Arc::default(),
        }
    }

    /// How far values may be off. In doubles, from 32 coordinates on, one Hessenberg form serves all frequencies, with
    /// estimated bounds; fewer coordinates, many inputs, and frequencies where less than nine digits would be left, are
    /// products of matrices of modes, with bounds that are proven but wide; and where modes prove nothing, elimination answers.
    #[must_use]
    pub fn precision(mut self, precision: Precision) -> FrequencyResponse<'a> {
        self.precision = precision;
        self
    }

    /// Another input: 1 N (or N·m) on this coordinate or point, or 1 m (or rad) of this support.
    #[must_use]
    pub fn from(mut self, name: impl Into<String>) -> FrequencyResponse<'a> {
        self.inputs.push(name.into());
        self
    }

    /// Another output: the motion of this coordinate, point or support.
    #[must_use]
    pub fn to(mut self, name: impl Into<String>) -> FrequencyResponse<'a> {
        self.outputs.push(Output::Place(name.into()));
        self
    }

    /// Another output: this sum of motions, or pull of an element, whatever [`quantity`](Self::quantity) is asked for.
    #[must_use]
    pub fn output(mut self, combination: Combination) -> FrequencyResponse<'a> {
        self.outputs.push(Output::Combination(combination));
        self
    }

    /// Which derivative of the motions is asked for; displacements if nothing is said.
    #[must_use]
    pub fn quantity(mut self, quantity: Quantity) -> FrequencyResponse<'a> {
        self.quantity = quantity;
        self
    }

    /// The loss factors η of the springs, in the order of
    /// [`elements`](System::elements): structural damping, by which a spring is k(1 + iη) at every frequency
    /// (Ewins 2000, section 2.4.2). No motion in time has it.
    #[must_use]
    pub fn loss_factors(mut self, factors: impl Into<Vec<f64>>) -> FrequencyResponse<'a> {
        self.loss_factors = factors.into();
        self
    }

    /// The functions at these frequencies in rad/s.
    ///
    /// # Errors
    /// [`FrequencyError`] naming the first thing that is wrong. A pole without damping is none: there the value says so.
    pub fn at(&self, frequencies: &[f64]) -> Result<FrequencyFunctions, FrequencyError> {
        let unfit = |frequency: &&f64| !(0.0..=f64::MAX).contains(*frequency);
        if let Some(&frequency) = frequencies.iter().find(unfit) {
            return Err(FrequencyError::Frequency { frequency });
        }
        if self.system.len() > MOST_DENSE {
            return self.of_large(frequencies);
        }
        let Some((columns, quick)) = self.by_hessenberg(frequencies)? else {
            return self.proven(frequencies);
        };
        let all = frequencies.iter().zip(&quick);
        let rest: Vec<f64> = all
            .filter_map(|(frequency, values)| values.is_none().then_some(*frequency))
            .collect();
        if rest.len() == frequencies.len() {
            return self.proven(frequencies);
        }
        let rest = match rest.is_empty() {
            true => None,
            false => Some(self.proven(&rest)?),
        };
        let mut functions = self.functions(&columns);
        let mut methods = Vec::with_capacity(quick.len());
        let mut proven = 0;
        for values in quick {
            if let Some(values) = values {
                let values = values.into_iter().flatten();
                for (function, (value, bound)) in functions.iter_mut().zip(values) {
                    let bound = Some(bound);
                    function.push(FrequencyValue::Known { value, bound });
                }
                methods.push(FrequencyMethod::Hessenberg);
            } else if let Some(rest) = &rest {
                for (function, known) in functions.iter_mut().zip(rest.functions()) {
                    function.push(known.values()[proven]);
                }
                methods.push(rest.methods()[proven]);
                proven += 1;
            }
        }
        Ok(FrequencyFunctions::new(
            frequencies.to_vec(),
            functions,
            methods,
            Bounds::Estimated,
        ))
    }

    /// The same with proven bounds, by modes, inverses or elimination.
    fn proven(&self, frequencies: &[f64]) -> Result<FrequencyFunctions, FrequencyError> {
        /// Up to so many coordinates elimination in balls is as quick, and with a few entries in each row up to the second.
        const SMALL: [usize; 2] = [12, 40];
        let (columns, blocks, modes) = self.parts(SMALL)?;
        let names = self.output_names();
        let mut functions = self.functions(&columns);
        let mut methods = vec![FrequencyMethod::Modes; frequencies.len()];
        for (at, block) in blocks.iter().enumerate() {
            let own = || (0..columns.len()).filter(|i| columns[*i].block == at);
            let asked: Vec<(&[Push], &[Reading])> = own()
                .map(|i| (columns[i].pushes.as_slice(), columns[i].readings.as_slice()))
                .collect();
            let modal = modes.and_then(|modes| {
                let all = asked.iter();
                let all = all.map(|(pushes, readings)| ModalFunctions::of(modes, pushes, readings));
                all.collect::<Option<Vec<ModalFunctions<'_>>>>()
            });
            let modal = modal.unwrap_or_default();
            let in_doubles = self.in_doubles(&modal, frequencies);
            for (index, &frequency) in frequencies.iter().enumerate() {
                if let Some(values) = in_doubles.get(index).and_then(Option::as_ref) {
                    let all = own().zip(values);
                    for (column, values) in all {
                        let functions = &mut functions[column * names.len()..][..names.len()];
                        for (function, &(value, bound)) in functions.iter_mut().zip(values) {
                            let bound = Some(bound);
                            function.push(FrequencyValue::Known { value, bound });
                        }
                    }
                    continue;
                }
                let found = enclose(&Question {
                    block,
                    modes,
                    modal: &modal,
                    frequency: frequency.into(),
                    columns: &asked,
                    asked: Asked::Value,
                });
                let method = match &found {
                    Enclosed::Values(_, method) => *method,
                    Enclosed::Singular | Enclosed::Undecided(_) => FrequencyMethod::Elimination,
                };
                // Of several parts the one that takes most.
                if method != FrequencyMethod::Modes
                    && methods[index] != FrequencyMethod::Elimination
                {
                    methods[index] = method;
                }
                let at_zero = match &found {
                    Enclosed::Singular | Enclosed::Undecided(_) if frequency == 0.0 => {
                        Some(self.limits(block, &asked))
                    }
                    _ => None,
                };
                for (k, column) in own().enumerate() {
                    let functions = &mut functions[column * names.len()..][..names.len()];
                    for (at, function) in functions.iter_mut().enumerate() {
                        let limit = at_zero.as_ref().map(|limits| limits[k][at]);
                        let value = match (&found, limit) {
                            (Enclosed::Values(values, _), _) => {
                                known(values[k][at], function, frequency)?
                            }
                            (_, Some(Limit::Finite(value))) => known(value, function, frequency)?,
                            (_, Some(Limit::Infinite)) | (Enclosed::Singular, None) => {
                                FrequencyValue::Pole
                            }
                            (_, Some(Limit::Unknown)) | (Enclosed::Undecided(_), None) => {
                                FrequencyValue::Undecided
                            }
                        };
                        function.push(value);
                    }
                }
            }
        }
        Ok(FrequencyFunctions::new(
            frequencies.to_vec(),
            functions,
            methods,
            Bounds::Proven,
        ))
    }

    /// The [limits] for Ω → 0, not known where the rounding of C decides them.
    fn limits(&self, block: &Block, columns: &[(&[Push], &[Reading])]) -> Vec<Vec<Limit>> {
        if self.system.structure().damps_rigid_motions_by_rounding() {
            let unknown =
                |(_, readings): &(&[Push], &[Reading])| vec![Limit::Unknown; readings.len()];
            return columns.iter().map(unknown).collect();
        }
        limits(block, columns)
    }

    /// The same by one sparse factor for each frequency, with estimated bounds.
    fn of_large(&self, frequencies: &[f64]) -> Result<FrequencyFunctions, FrequencyError> {
        self.check_loss_factors()?;
        let columns = self.columns()?;
        let stiffness = SparseDynamicStiffness::of(self.system, &self.loss_factors)?;
        let mut functions = self.functions(&columns);
        let asked: Vec<(&[Push], &[Reading])> = columns
            .iter()
            .map(|column| (column.pushes.as_slice(), column.readings.as_slice()))
            .collect();
        for &frequency in frequencies {
            let values = sparse_factor::values(&stiffness, self.system.len(), &asked, frequency);
            for (index, function) in functions.iter_mut().enumerate() {
                let value = values.iter().flatten().flatten().nth(index);
                function.push(match value {
                    Some(&(value, bound)) if value.is_finite() => {
                        FrequencyValue::Known { value, bound }
                    }
                    _ => FrequencyValue::Undecided,
                });
            }
        }
        Ok(FrequencyFunctions::new(
            frequencies.to_vec(),
            functions,
            vec![FrequencyMethod::SparseFactor; frequencies.len()],
            Bounds::Estimated,
        ))
    }

    /// One for each input and output, still without values.
    fn functions(&self, columns: &[Column]) -> Vec<FrequencyFunction> {
        let names = self.output_names();
        let each = columns.iter().flat_map(|column| {
            names.iter().map(|(to, quantity)| {
                FrequencyFunction::new(column.name.clone(), to.clone(), *quantity)
            })
        });
        each.collect()
    }

    /// What is notable in each function, in the order of [`at`](Self::at): peaks, dips, the largest gain and asymptotes. Where
    /// it takes too long to prove that peaks and dips are all there are, those between these frequencies in rad/s are
    /// given, such as [`peak_grid`](super::peak_grid) names.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn features(&self, frequencies: &[f64]) -> Result<Vec<Features>, FrequencyError> {
        /// Up to so many coordinates the proof is quick without modes.
        const FEW: usize = 6;
        let mut grid = frequencies.to_vec();
        let unfit = |frequency: &&f64| !(0.0..=f64::MAX).contains(*frequency);
        if let Some(&frequency) = grid.iter().find(unfit) {
            return Err(FrequencyError::Frequency { frequency });
        }
        sort_by_number(&mut grid, |omega| *omega);
        grid.dedup();
        if self.system.len() > MOST_DENSE {
            return self.features_of_large(&grid);
        }
        let (columns, blocks, modes) = self.parts([FEW; 2])?;
        let last = grid.iter().copied().rfind(|last| *last > 0.0);
        let middle = f64::exp2(last.map_or(0.0, |last| last.log2().round().clamp(-500.0, 500.0)));
        let proven = OnceLock::new();
        let functions = columns.iter().flat_map(|column| {
            let (grid, blocks, proven) = (&grid, &blocks, &proven);
            let mut centers = Centers::default();
            column.readings.iter().map(move |reading| {
                let modal = modes.and_then(|modes| {
                    ModalFunctions::of(modes, &column.pushes, std::slice::from_ref(reading))
                });
                let look = |frequency, wanted| {
                    let asked = (column.pushes.as_slice(), std::slice::from_ref(reading));
                    let found = enclose(&Question {
                        block: &blocks[column.block],
                        modes,
                        modal: modal.as_slice(),
                        frequency,
                        columns: &[asked],
                        asked: wanted,
                    });
                    match found {
                        Enclosed::Values(values, _) => Some(values[0][0]),
                        _ if frequency.is_zero() => {
                            match self.limits(&blocks[column.block], &[asked])[0][0] {
                                Limit::Finite(value) => Some(value),
                                Limit::Infinite | Limit::Unknown => None,
                            }
                        }
                        _ => None,
                    }
                };
                let glance = modal.as_ref();
                let glance = glance.map(|known| |frequency: f64| known.glance(frequency));
                let glance = glance.as_ref().map(|glance| glance as &Glance<'_>);
                let block = &blocks[column.block];
                let mut turns = turns(
                    block,
                    &column.pushes,
                    reading,
                    middle,
                    modal.as_ref(),
                    &mut centers,
                );
                for turn in turns.iter_mut().flat_map(|turns| &mut turns.each) {
                    turn.narrow(|| proven.get_or_init(|| self.proven_frequencies()));
                }
                Features::of(&look, glance, grid, turns.as_ref())
            })
        });
        Ok(functions.collect())
    }

    /// The frequencies of modes with their bounds, where those are proven.
    fn proven_frequencies(&self) -> Vec<(f64, f64)> {
        let Ok(modes) = self.system.modes() else {
            return Vec::new();
        };
        if modes.bounds() != Bounds::Proven || !modes.is_complete() {
            return Vec::new();
        }
        let roots = modes.eigenvalues().iter();
        let upper = roots.filter(|root| root.value.im > 0.0);
        upper
            .filter_map(|root| Some((root.value.im, root.bound?)))
            .collect()
    }

    /// The first of the functions in doubles; `None` for more than 400 coordinates.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn transfer(&self) -> Result<Option<Transfer>, FrequencyError> {
        if self.system.len() > MOST_DENSE {
            return Ok(None);
        }
        self.check_loss_factors()?;
        let lossy = self.loss_factors.iter().any(|factor| *factor != 0.0);
        let losses = lossy.then(|| losses(self.system, &self.loss_factors));
        let first = self.columns()?.into_iter().next();
        Ok(first.map(|first| {
            let reading = &first.readings[..1];
            let ports = Ports::of(&first.pushes, reading);
            Transfer::of(self.system, ports, losses)
        }))
    }

    /// The same by sparse factors, with estimates in place of proofs.
    fn features_of_large(&self, grid: &[f64]) -> Result<Vec<Features>, FrequencyError> {
        self.check_loss_factors()?;
        let columns = self.columns()?;
        let stiffness = SparseDynamicStiffness::of(self.system, &self.loss_factors)?;
        let functions = columns.iter().flat_map(|column| {
            column.readings.iter().map(|reading| {
                let asked = (column.pushes.as_slice(), reading);
                let look = |frequency, _| {
                    sparse_factor::look(&stiffness, self.system.len(), asked, frequency)
                };
                Features::of(&look, None, grid, None)
            })
        });
        Ok(functions.collect())
    }

    /// The inputs, the parts of the system that they act on, and its modes where there are parts of more than so many
    /// coordinates, or of more than the second where they are thin.
    fn parts(&self, few: [usize; 2]) -> Result<Parts<'_>, FrequencyError> {
        self.check_loss_factors()?;
        let mut columns = self.columns()?;
        let stiffness = DynamicStiffness::of(self.system, &self.loss_factors);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for column in &mut columns {
            let reached = stiffness.reached(column.pushes.iter().map(|push| push.coordinate));
            // What is not reached stays at rest, and rounding is to have no share in that.
            for reading in &mut column.readings {
                reading
                    .of
                    .retain(|(i, _)| stiffness.is_within(&reached, *i));
            }
            let known = groups.iter().position(|group| *group == reached);
            column.block = known.unwrap_or_else(|| {
                groups.push(reached);
                groups.len() - 1
            });
        }
        let blocks: Vec<Block> = groups.iter().map(|group| stiffness.block(group)).collect();
        let is_large = self.precision == Precision::Double
            || blocks
                .iter()
                .any(|block| block.coordinates().len() > few[usize::from(block.is_thin())]);
        let has_modes = is_large && self.loss_factors.iter().all(|factor| *factor == 0.0);
        let find = || ModalSum::of(self.system, stiffness);
        let modes = has_modes.then(|| self.modes.get_or_init(find).as_ref());
        Ok((columns, blocks, modes.flatten()))
    }

    /// By frequency, the values of all inputs in doubles, where those are asked for; none where too few digits are left.
    fn by_hessenberg(&self, frequencies: &[f64]) -> Result<Option<Quick>, FrequencyError> {
        /// Fewer coordinates are eliminated as quickly.
        const LEAST: usize = 32;
        /// Modes are found once for all inputs.
        const MOST_INPUTS: usize = 8;
        self.check_loss_factors()?;
        let fits = self.system.len() >= LEAST && self.inputs.len() <= MOST_INPUTS;
        if self.precision != Precision::Double || !fits {
            return Ok(None);
        }
        let columns = self.columns()?;
        let Some(form) = Hessenberg::of(self.system, &self.loss_factors) else {
            return Ok(None);
        };
        let enlargements = form.enlargements(frequencies);
        let mut all = vec![Some(Vec::with_capacity(columns.len())); frequencies.len()];
        for column in &columns {
            let (pushes, readings) = (&column.pushes, &column.readings);
            let Some(column) = form.column(pushes, readings, frequencies) else {
                return Ok(None);
            };
            let values = column.values(&form, frequencies, &enlargements);
            for (all, values) in all.iter_mut().zip(values) {
                *all = all.take().zip(values).map(|(mut all, values)| {
                    all.push(values);
                    all
                });
            }
        }
        Ok(Some((columns, all)))
    }

    /// By frequency, the values of all inputs in doubles, where those are asked for and modes prove them.
    fn in_doubles(
        &self,
        functions: &[ModalFunctions<'_>],
        frequencies: &[f64],
    ) -> Vec<Option<Vec<Vec<modal_functions::Value>>>> {
        if self.precision != Precision::Double || functions.is_empty() {
            return Vec::new();
        }
        let mut all = vec![Some(Vec::new()); frequencies.len()];
        for column in functions {
            for (all, values) in all.iter_mut().zip(column.values(frequencies)) {
                *all = all.take().zip(values).map(|(mut all, values)| {
                    all.push(values);
                    all
                });
            }
        }
        all
    }

    fn check_loss_factors(&self) -> Result<(), FrequencyError> {
        let springs = self.system.elements(ElementKind::Spring).len();
        let given = self.loss_factors.len();
        if given != 0 && given != springs {
            return Err(FrequencyError::LossFactors { given, springs });
        }
        let mut factors = self.loss_factors.iter().enumerate();
        let unfit = factors.find(|(_, factor)| !(0.0..=f64::MAX).contains(*factor));
        unfit.map_or(Ok(()), |(index, &value)| {
            Err(FrequencyError::LossFactor { index, value })
        })
    }

    fn form(&self, name: &str) -> Result<Form, FrequencyError> {
        let form = self.system.form(name);
        let form = form.filter(|_| name != GROUND);
        form.ok_or_else(|| {
            let points = self.system.points().iter().map(|point| &point.name);
            let known = self.system.names().iter().chain(points);
            let known: Vec<&str> = known
                .chain(self.system.supports())
                .map(String::as_str)
                .collect();
            FrequencyError::UnknownPlace {
                name: name.to_owned(),
                known: known.join(", "),
            }
        })
    }

    /// Names of the outputs, and the quantity of those that are places.
    fn output_names(&self) -> Vec<(String, Option<Quantity>)> {
        if self.outputs.is_empty() {
            let names = self.system.names().iter();
            return names
                .map(|name| (name.clone(), Some(self.quantity)))
                .collect();
        }
        let outputs = self.outputs.iter().map(|output| match output {
            Output::Place(name) => (name.clone(), Some(self.quantity)),
            Output::Combination(combination) => (combination.name.clone(), None),
        });
        outputs.collect()
    }

    /// What the outputs are in terms of coordinates, and of supports with indices beyond them.
    fn sources(&self) -> Result<Vec<Vec<(usize, Part)>>, FrequencyError> {
        let (n, order) = (self.system.len(), self.quantity as i32);
        let place = |form: Form| -> Vec<(usize, Part)> {
            let supports = form.supports.into_iter().map(|(s, b)| (n + s, b));
            let all = form.coordinates.into_iter().chain(supports);
            all.map(|(i, a)| (i, Part::of(order, [a, 1.0]))).collect()
        };
        if self.outputs.is_empty() {
            let coordinates = (0..n).map(|i| vec![(i, Part::of(order, [1.0; 2]))]);
            return Ok(coordinates.collect());
        }
        let outputs = self.outputs.iter().map(|output| match output {
            Output::Place(name) => Ok(place(self.form(name)?)),
            Output::Combination(combination) => self.combined(combination),
        });
        outputs.collect()
    }

    fn combined(&self, combination: &Combination) -> Result<Vec<(usize, Part)>, FrequencyError> {
        let n = self.system.len();
        let source = Source::of(combination, self.system).map_err(|reason| {
            let name = combination.name.clone();
            FrequencyError::Combination { name, reason }
        })?;
        let orders = source.terms.into_iter().enumerate();
        let mut parts: Vec<(usize, Part)> = orders
            .flat_map(|(order, terms)| {
                let part = move |(i, factors)| (i, Part::of(order as i32, factors));
                terms.into_iter().map(part)
            })
            .collect();
        if let Sum::Pull(name) = &combination.of {
            let spring = self.system.element_of(name);
            let spring = spring.filter(|(kind, _)| *kind == ElementKind::Spring);
            if let Some((kind, index)) = spring
                && let Some(&loss) = self.loss_factors.get(index)
                && loss != 0.0
            {
                let spring = &self.system.elements(kind)[index];
                let supports = spring.stretch.supports.iter().map(|&(s, b)| (n + s, b));
                let all = spring.stretch.coordinates.iter().copied().chain(supports);
                let lost = |(i, a)| (i, Part::loss([loss, spring.coefficient, a, 1.0]));
                parts.extend(all.map(lost));
            }
        }
        Ok(parts)
    }

    /// What each input does, and how the outputs are read off.
    fn columns(&self) -> Result<Vec<Column>, FrequencyError> {
        if self.inputs.is_empty() {
            return Err(FrequencyError::NoInput);
        }
        let n = self.system.len();
        let sources = self.sources()?;
        let column = |name: &String| {
            let support = self.system.supports().iter().position(|own| own == name);
            let acts: Vec<(usize, Part)> = match support {
                Some(support) => carried(self.system, support, &self.loss_factors),
                None => {
                    let form = self.form(name)?.coordinates.into_iter();
                    form.map(|(i, a)| (i, Part::of(0, [a, 1.0]))).collect()
                }
            };
            let push = |(coordinate, part)| Push {
                coordinate,
                part,
                phase: Phase::Zero,
            };
            let reading = |source: &Vec<(usize, Part)>| {
                let own = support.map(|support| n + support);
                let more = source.iter().filter(|(i, _)| Some(*i) == own);
                Reading {
                    of: source.iter().filter(|(i, _)| *i < n).copied().collect(),
                    more: more.map(|(_, part)| *part).collect(),
                }
            };
            Ok(Column {
                name: name.clone(),
                block: 0,
                pushes: acts.into_iter().map(push).collect(),
                readings: sources.iter().map(reading).collect(),
            })
        };
        self.inputs.iter().map(column).collect()
    }
}

/// Inputs, and by frequency what each of them does in doubles.
type Quick = (Vec<Column>, Vec<Option<Vec<Vec<modal_functions::Value>>>>);

/// Inputs, blocks, and modes where they are quicker.
type Parts<'a> = (Vec<Column>, Vec<Block>, Option<&'a ModalSum>);

/// An input.
struct Column {
    name: String,
    /// The index of the block that it acts on.
    block: usize,
    pushes: Vec<Push>,
    readings: Vec<Reading>,
}

fn known(
    value: Value,
    function: &FrequencyFunction,
    frequency: f64,
) -> Result<FrequencyValue, FrequencyError> {
    let Value { value, bound, .. } = value;
    if value.is_finite() && bound.is_finite() {
        let bound = Some(bound);
        return Ok(FrequencyValue::Known { value, bound });
    }
    Err(FrequencyError::OutOfRange {
        from: function.from().to_owned(),
        to: function.to().to_owned(),
        frequency,
    })
}
