//! Words that name a choice, as scenarios have them.

use pyo3::PyResult;
use serde::de::DeserializeOwned;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};

use crate::error::bad;

/// The choice of that name.
pub fn named<T: DeserializeOwned>(key: &str, name: &str) -> PyResult<T> {
    let word: StrDeserializer<'_, Error> = name.into_deserializer();
    T::deserialize(word).map_err(|error| bad(format!("{key}: {error}")))
}
