//! What has been computed of a problem, for the next who needs it.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// One value of each type: this room knows none of those that compute. A copy keeps nothing, as it may become another problem.
#[derive(Default)]
pub(super) struct Kept(Arc<Mutex<HashMap<TypeId, Arc<dyn Any + Send + Sync>>>>);

impl Kept {
    /// The same, for a problem of which all that is kept is true as well.
    pub(super) fn shared(&self) -> Kept {
        Kept(Arc::clone(&self.0))
    }

    /// The value of this type, made when it is first asked for.
    pub(super) fn get<V: Send + Sync + 'static>(&self, make: impl FnOnce() -> V) -> Arc<V> {
        let id = TypeId::of::<V>();
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&id).cloned();
        let value = found.unwrap_or_else(|| {
            let made = Arc::new(make());
            known().entry(id).or_insert(made).clone()
        });
        value.downcast().expect("kept by its type")
    }
}

impl Clone for Kept {
    fn clone(&self) -> Kept {
        Kept::default()
    }
}

impl fmt::Debug for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Kept")
    }
}
