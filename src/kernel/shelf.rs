//! Values by their type: a room hands on what it need not know, and who put a value there takes it out again.

use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError};

type AnyValue = Arc<dyn Any + Send + Sync>;

/// At most one value of each type.
#[derive(Clone, Default)]
pub(crate) struct Shelf(Vec<AnyValue>);

impl Shelf {
    /// The value of this type, if there is one.
    pub(crate) fn get<T: Any>(&self) -> Option<&T> {
        self.0.iter().find_map(|value| value.downcast_ref())
    }

    /// Puts a value there, in place of the one of its type.
    pub(crate) fn put<T: Any + Send + Sync>(&mut self, value: T) {
        self.0.retain(|other| !other.is::<T>());
        self.0.push(Arc::new(value));
    }

    /// The value of this type, to be changed; the default if there is none.
    ///
    /// # Panics
    /// If a copy of the shelf has it too.
    pub(crate) fn get_mut<T: Any + Send + Sync + Default>(&mut self) -> &mut T {
        if self.get::<T>().is_none() {
            self.put(T::default());
        }
        let own = self.0.iter_mut().find(|value| value.is::<T>());
        let own = own
            .and_then(Arc::get_mut)
            .and_then(|value| value.downcast_mut());
        own.expect("no copy has it")
    }
}

impl std::fmt::Debug for Shelf {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} values", self.0.len())
    }
}

/// A shelf of caches, which look after themselves: one of each type, made when it is first asked for.
#[derive(Debug, Default)]
pub(crate) struct Caches(Mutex<Shelf>);

impl Caches {
    pub(crate) fn of<T: Any + Send + Sync + Default>(&self) -> Arc<T> {
        let mut shelf = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if shelf.get::<T>().is_none() {
            shelf.put(T::default());
        }
        let mut all = shelf.0.iter().cloned();
        let own = all.find_map(|value| value.downcast().ok());
        own.expect("it was put there")
    }
}

/// Values that are lent, at most one of each type.
#[derive(Clone, Copy, Default)]
pub(crate) struct Lent<'a>([Option<&'a (dyn Any + Send + Sync)>; 2]);

impl<'a> Lent<'a> {
    /// These, as far as they are there.
    pub(crate) fn of<A: Any + Send + Sync, B: Any + Send + Sync>(
        first: Option<&'a A>,
        second: Option<&'a B>,
    ) -> Self {
        Self([first.map(|a| a as _), second.map(|b| b as _)])
    }

    /// The value of this type, if there is one.
    pub(crate) fn get<T: Any>(self) -> Option<&'a T> {
        let mut lent = self.0.into_iter().flatten();
        lent.find_map(|value| value.downcast_ref())
    }
}
