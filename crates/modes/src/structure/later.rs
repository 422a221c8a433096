//! Facts that are proved when they are first asked for, and remembered.

use std::sync::OnceLock;

/// Such a fact. It follows from what is stored beside it, which is compared in its place.
#[derive(Clone, Debug)]
pub(crate) struct Later<T>(OnceLock<T>);

impl<T> Later<T> {
    pub(crate) fn new() -> Later<T> {
        Later(OnceLock::new())
    }

    pub(crate) fn get(&self, prove: impl FnOnce() -> T) -> &T {
        self.0.get_or_init(prove)
    }
}

impl<T> PartialEq for Later<T> {
    fn eq(&self, _: &Later<T>) -> bool {
        true
    }
}
