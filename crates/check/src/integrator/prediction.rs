//! How many steps an integration is going to take.

/// How many steps an integration is going to take, told without running it to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The steps, those that will be tried and rejected among them.
    pub steps: f64,
    /// What the number rests on.
    pub basis: Basis,
}

/// What a [`Prediction`] rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Basis {
    /// The steps are counted, not estimated: they have a fixed length, or a trial came to the end.
    Counted,
    /// From the end of a trial on, steps are about as long as stability allows: a bound from below,
    /// near to what is taken unless the accuracy asks for more later on.
    Stability,
    /// From the end of a trial on, steps are as long as in its second half. A motion that dies down
    /// later takes fewer, one whose loads set in later may take more.
    Accuracy,
}
