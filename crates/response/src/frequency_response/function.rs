//! Frequency response functions: values at frequencies.

use std::fmt;

use eigentone_modes::Bounds;
use num_complex::Complex;

use crate::problem::Quantity;

/// The value of a frequency response function at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrequencyValue {
    /// A number.
    Known {
        /// The amplitude, as a complex number, for each unit of the input.
        value: Complex<f64>,
        /// How far it may be from the exact value; `None` where nothing is known of that.
        bound: Option<f64>,
    },
    /// It is proved that the frequency is a natural one without damping: there the motion grows, or is not determined. At
    /// 0, a function that has a limit for Ω → 0 has that as its value, and it is proved that this one has none.
    Pole,
    /// The frequency cannot be distinguished from a natural one without damping, even with many digits; or it is 0, a natural
    /// one, and many digits do not decide whether the function has a limit.
    Undecided,
}

impl FrequencyValue {
    /// Value and bound, if it is a number.
    pub fn known(self) -> Option<(Complex<f64>, Option<f64>)> {
        match self {
            FrequencyValue::Known { value, bound } => Some((value, bound)),
            FrequencyValue::Pole | FrequencyValue::Undecided => None,
        }
    }
}

/// One frequency response function, from one input to one output.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyFunction {
    from: String,
    to: String,
    quantity: Option<Quantity>,
    values: Vec<FrequencyValue>,
}

impl FrequencyFunction {
    pub(super) fn new(from: String, to: String, quantity: Option<Quantity>) -> FrequencyFunction {
        FrequencyFunction {
            from,
            to,
            quantity,
            values: Vec::new(),
        }
    }

    pub(super) fn push(&mut self, value: FrequencyValue) {
        self.values.push(value);
    }

    /// The coordinate or point that a unit force acts on, or the support that moves by a unit.
    pub fn from(&self) -> &str {
        &self.from
    }

    /// The coordinate, point, support or combination that is looked at.
    pub fn to(&self) -> &str {
        &self.to
    }

    /// Which derivative of the motion it is; `None` for a combination.
    pub fn quantity(&self) -> Option<Quantity> {
        self.quantity
    }

    /// One value for each frequency.
    pub fn values(&self) -> &[FrequencyValue] {
        &self.values
    }
}

/// How the values at a frequency were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrequencyMethod {
    /// Elimination in ball arithmetic, with as many digits as it takes.
    Elimination,
    /// An inverse in doubles for each frequency, corrected by what it leaves of the equations: quicker than elimination for more
    /// than 16 coordinates that are joined to many others.
    Inverse,
    /// Sums of modes, corrected by what they leave of the equations: quicker than elimination beyond 12 coordinates, or 40 of a
    /// chain; in doubles uncorrected, with bounds of what they leave.
    Modes,
    /// One Hessenberg form for all frequencies, in doubles.
    Hessenberg,
    /// One sparse factor for each frequency, beyond 400 coordinates.
    SparseFactor,
}

impl fmt::Display for FrequencyMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FrequencyMethod::Elimination => {
                "elimination: in ball arithmetic, with as many digits as it takes"
            }
            FrequencyMethod::Inverse => {
                "inverses: one for each frequency in doubles, corrected by what it leaves"
            }
            FrequencyMethod::Modes => {
                "modes: quicker than elimination for so many coordinates, and in doubles"
            }
            FrequencyMethod::Hessenberg => "Hessenberg form: one for all frequencies, in doubles",
            FrequencyMethod::SparseFactor => {
                "sparse factors: one for each frequency, as there are more than 400 coordinates"
            }
        })
    }
}

/// Frequency response functions at the same frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyFunctions {
    frequencies: Vec<f64>,
    functions: Vec<FrequencyFunction>,
    methods: Vec<FrequencyMethod>,
    bounds: Bounds,
}

impl FrequencyFunctions {
    pub(super) fn new(
        frequencies: Vec<f64>,
        functions: Vec<FrequencyFunction>,
        methods: Vec<FrequencyMethod>,
        bounds: Bounds,
    ) -> FrequencyFunctions {
        FrequencyFunctions {
            frequencies,
            functions,
            methods,
            bounds,
        }
    }

    /// The frequencies Ω in rad/s, in the order asked for.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// The functions: of each input in its order, to each output in its order.
    pub fn functions(&self) -> &[FrequencyFunction] {
        &self.functions
    }

    /// By frequency, how the values were found.
    pub fn methods(&self) -> &[FrequencyMethod] {
        &self.methods
    }

    /// Whether the bounds are proven.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}
