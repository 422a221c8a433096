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

    /// The value of this type, once it has been made.
    pub(super) fn found<V: Send + Sync + 'static>(&self) -> Option<Arc<V>> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.get(&TypeId::of::<V>()).cloned();
        found.map(|value| value.downcast().expect("kept by its type"))
    }

    /// The same, made when it is first asked for.
    pub(super) fn get<V: Send + Sync + 'static>(&self, make: impl FnOnce() -> V) -> Arc<V> {
        self.found().unwrap_or_else(|| {
            let made = Arc::new(make());
            let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let kept = known.entry(TypeId::of::<V>()).or_insert(made).clone();
            kept.downcast().expect("kept by its type")
        })
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
