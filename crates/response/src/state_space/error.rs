//! Why there is no state-space form.

use eigentone_modes::FirstOrderError;
use thiserror::Error;

/// Why there is no state-space form, or no discrete one.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StateSpaceError {
    /// The system has no first-order form.
    #[error(transparent)]
    FirstOrder(#[from] FirstOrderError),
    /// An input names neither a coordinate nor a point.
    #[error(
        "{name:?} is neither a coordinate nor a point, on which a force could act: known: {known}"
    )]
    UnknownPlace {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// An input names no support.
    #[error("{name:?} is not a support: known: {known}")]
    UnknownSupport {
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// An output that cannot be made.
    #[error("output {name:?}: {reason}")]
    Output {
        /// What it is called.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// An output that follows the derivative of an input.
    #[error(
        "output {output:?} follows a derivative of input {input:?}, which y = C z + D u cannot: take another quantity of it, or the velocity or acceleration of a support as the input"
    )]
    Improper {
        /// The output.
        output: String,
        /// The input.
        input: String,
    },
    /// The step is not a positive number.
    #[error("the step is {step:?}: it must be a finite number greater than 0")]
    Step {
        /// The step given, in s.
        step: f64,
    },
    /// A density of noise that is not a symmetric matrix of one row for each input.
    #[error(
        "the density of the noise is {rows} × {columns}: it must be a symmetric matrix of finite numbers with a row for each input, {inputs} in all"
    )]
    Density {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// How many inputs there are.
        inputs: usize,
    },
    /// Something does not come to rest by itself: noise drives it farther and farther, or what it did at first goes on beside the
    /// noise.
    #[error(
        "the motion under noise does not become stationary, as {what} does not come to rest by itself"
    )]
    NotStationary {
        /// The rigid motion or the undamped modes.
        what: String,
    },
    /// Something grows, or decays so little that no digits in reach decide.
    #[error(
        "no number of digits in reach shows that the motion comes to rest by itself: something grows under noise, or decays next to not at all"
    )]
    NotShownStationary,
    /// The density of a noise is no number, or below 0.
    #[error(
        "the density of the noise on {name:?} is {density:?}: it must be a finite number, 0 or more"
    )]
    NoiseDensity {
        /// What the noise acts on.
        name: String,
        /// The density given.
        density: f64,
    },
    /// The band of a noise is none.
    #[error(
        "the band of the noise on {name:?} is from {low:?} to {high:?} Hz: both must be finite numbers, the first 0 or more and below the second"
    )]
    NoiseBand {
        /// What the noise acts on.
        name: String,
        /// Its lower end, in Hz.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// An entry is beyond the largest double.
    #[error(
        "entry ({row}, {column}) of {matrix} is beyond the largest double: take a shorter step, or units that bring the numbers closer together"
    )]
    Overflow {
        /// Which matrix.
        matrix: &'static str,
        /// The entry's row, from 0.
        row: usize,
        /// The entry's column, from 0.
        column: usize,
    },
    /// Too many states for a proof, or more digits than can be afforded.
    #[error(
        "{states} states would take {operations:.0e} operations, more than {limit:.0e}: take parts of the system, or a shorter step"
    )]
    TooMuchWork {
        /// How many states there are.
        states: usize,
        /// What it would take, in multiplications of doubles.
        operations: f64,
        /// The most that is spent.
        limit: f64,
    },
    /// No number of digits in reach leaves any.
    #[error(
        "no number of digits in reach leaves any of the answer, or distinguishes a matrix to be divided by from a singular one: take a shorter step"
    )]
    Lost,
}
