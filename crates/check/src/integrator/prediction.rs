//! How many steps an integration is going to take.

/// How many steps an integration is going to take, predicted without running it to its end.
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
    /// Nearly all steps are as long as stability allows.
    Stability,
    /// Steps are as long as the accuracy allows, predicted from longer ones of a looser tolerance. Where
    /// even those do not reach the end, the rest is taken to go on like their second half: a motion
    /// that dies down later takes fewer, one whose loads set in later may take more.
    Accuracy,
}
