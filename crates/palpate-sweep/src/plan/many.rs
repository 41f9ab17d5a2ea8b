//! A value of a plan that may be a list: one of them, or several in brackets.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, IntoDeserializer, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// One value or several, never none.
#[derive(Clone, Debug, PartialEq)]
pub struct Many<T>(pub(crate) Vec<T>);

impl<T> From<T> for Many<T> {
    fn from(value: T) -> Self {
        Self(vec![value])
    }
}

/// Written by hand rather than as an untagged enum, which would forget where in the file a value stood.
impl<'de, T: Deserialize<'de>> Deserialize<'de> for Many<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrList<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrList<T> {
            type Value = Many<T>;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("a value or a list of values")
            }

            fn visit_bool<E: Error>(self, value: bool) -> Result<Many<T>, E> {
                T::deserialize(value.into_deserializer()).map(Many::from)
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Many<T>, E> {
                T::deserialize(value.into_deserializer()).map(Many::from)
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Many<T>, E> {
                T::deserialize(value.into_deserializer()).map(Many::from)
            }

            fn visit_str<E: Error>(self, value: &str) -> Result<Many<T>, E> {
                T::deserialize(value.into_deserializer()).map(Many::from)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Many<T>, A::Error> {
                let values = Vec::deserialize(SeqAccessDeserializer::new(list))?;
                if values.is_empty() { Err(A::Error::custom("the list is empty")) } else { Ok(Many(values)) }
            }
        }

        deserializer.deserialize_any(OneOrList(PhantomData))
    }
}
