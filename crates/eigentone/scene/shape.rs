//! The few shapes of JSON that a scene is made of, each read strictly.
//!
//! Derived readers alone would take an array for an object and `null` for something left out.

use std::collections::HashSet;
use std::fmt;
use std::marker::PhantomData;

use serde::de::value::StringDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, forward_to_deserialize_any};

use super::words::{excerpt, hint};

/// What can be read from one kind of JSON value; each reader below refuses by default.
trait Shape<'de>: Sized {
    /// What belongs in this place.
    const EXPECTED: &'static str;

    fn from_number<E: Error>(number: f64) -> Result<Self, E> {
        let text = format!("{number:?}");
        let text = text.strip_suffix(".0").unwrap_or(&text);
        Err(unexpected::<Self, E>(&format!("the number {text}")))
    }

    fn from_text<E: Error>(text: String) -> Result<Self, E> {
        let found = format!("the text {:?}", excerpt(&text));
        Err(unexpected::<Self, E>(&found))
    }

    fn from_list<A: SeqAccess<'de>>(_list: A) -> Result<Self, A::Error> {
        Err(unexpected::<Self, A::Error>("a list"))
    }

    fn from_object<A: MapAccess<'de>>(_object: A) -> Result<Self, A::Error> {
        Err(unexpected::<Self, A::Error>("an object"))
    }
}

fn unexpected<'de, S: Shape<'de>, E: Error>(found: &str) -> E {
    E::custom(format_args!("expected {}, found {found}", S::EXPECTED))
}

struct Reader<S>(PhantomData<S>);

impl<'de, S: Shape<'de>> Visitor<'de> for Reader<S> {
    type Value = S;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(S::EXPECTED)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<S, E> {
        Err(unexpected::<S, E>(&value.to_string()))
    }

    fn visit_unit<E: Error>(self) -> Result<S, E> {
        Err(unexpected::<S, E>("null"))
    }

    // Both conversions round to nearest.
    fn visit_u64<E: Error>(self, value: u64) -> Result<S, E> {
        S::from_number(value as f64)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<S, E> {
        S::from_number(value as f64)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<S, E> {
        S::from_number(value)
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<S, E> {
        S::from_text(value.to_owned())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<S, A::Error> {
        S::from_list(list)
    }

    fn visit_map<A: MapAccess<'de>>(self, object: A) -> Result<S, A::Error> {
        S::from_object(object)
    }
}

macro_rules! deserialize_by_shape {
    ($($name:ident $(<$parameter:ident>)?),*) => {$(
        impl<'de $(, $parameter: Deserialize<'de>)?> Deserialize<'de> for $name $(<$parameter>)? {
            fn deserialize<D: Deserializer<'de>>(json: D) -> Result<Self, D::Error> {
                json.deserialize_any(Reader(PhantomData))
            }
        }
    )*};
}
deserialize_by_shape!(
    Number,
    Text,
    Two,
    Hold,
    Matrix,
    List<T>,
    Object<T>,
    ByName<T>
);

/// A key that may be left out but not be `null`: for `deserialize_with` beside `default`.
pub(super) fn given<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    json: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(json).map(Some)
}

/// A finite number: the double nearest to its text.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Number(pub(super) f64);

impl Shape<'_> for Number {
    const EXPECTED: &'static str = "a number";

    fn from_number<E: Error>(number: f64) -> Result<Self, E> {
        Ok(Number(number))
    }
}

/// A string.
#[derive(Debug)]
pub(super) struct Text(pub(super) String);

impl Shape<'_> for Text {
    const EXPECTED: &'static str = "a text in quotes";

    fn from_text<E: Error>(text: String) -> Result<Self, E> {
        Ok(Text(text))
    }
}

/// The two names that a spring or damper joins.
#[derive(Debug)]
pub(super) struct Two(pub(super) [String; 2]);

impl<'de> Shape<'de> for Two {
    const EXPECTED: &'static str = "a list of two names";

    fn from_list<A: SeqAccess<'de>>(mut list: A) -> Result<Self, A::Error> {
        let first: Option<Text> = list.next_element()?;
        let second: Option<Text> = list.next_element()?;
        let mut beyond = 0;
        while list.next_element::<IgnoredAny>()?.is_some() {
            beyond += 1;
        }
        match (first, second, beyond) {
            (Some(first), Some(second), 0) => Ok(Two([first.0, second.0])),
            (first, second, _) => {
                let count = first.iter().count() + second.iter().count() + beyond;
                Err(unexpected::<Self, A::Error>(&format!("a list of {count}")))
            }
        }
    }
}

/// What a sampled force does between its samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold(pub(super) eigentone_response::Hold);

impl Shape<'_> for Hold {
    const EXPECTED: &'static str = "\"zero\" or \"first\"";

    fn from_text<E: Error>(text: String) -> Result<Self, E> {
        match text.as_str() {
            "zero" => Ok(Hold(eigentone_response::Hold::Zero)),
            "first" => Ok(Hold(eigentone_response::Hold::First)),
            _ => {
                let found = format!("the text {:?}", excerpt(&text));
                Err(unexpected::<Self, E>(&found))
            }
        }
    }
}

/// A matrix by its rows, or by the name of a file.
#[derive(Debug)]
pub(super) enum Matrix {
    Rows(Vec<List<Number>>),
    File(String),
}

impl<'de> Shape<'de> for Matrix {
    const EXPECTED: &'static str = "a list of rows of numbers or the name of a Matrix Market file";

    fn from_text<E: Error>(text: String) -> Result<Self, E> {
        Ok(Matrix::File(text))
    }

    fn from_list<A: SeqAccess<'de>>(list: A) -> Result<Self, A::Error> {
        Ok(Matrix::Rows(List::from_list(list)?.0))
    }
}

/// A list.
#[derive(Debug)]
pub(super) struct List<T>(pub(super) Vec<T>);

impl<T> Default for List<T> {
    fn default() -> List<T> {
        List(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Shape<'de> for List<T> {
    const EXPECTED: &'static str = "a list";

    fn from_list<A: SeqAccess<'de>>(mut list: A) -> Result<Self, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(List(values))
    }
}

/// An object whose keys are names, in the order of the file, each once.
#[derive(Debug)]
pub(super) struct ByName<T>(pub(super) Vec<(String, T)>);

impl<T> Default for ByName<T> {
    fn default() -> ByName<T> {
        ByName(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Shape<'de> for ByName<T> {
    const EXPECTED: &'static str = "an object";

    fn from_object<A: MapAccess<'de>>(mut object: A) -> Result<Self, A::Error> {
        let mut seen = HashSet::new();
        let mut values = Vec::new();
        let mut check = |name: &str| match seen.insert(name.to_owned()) {
            true => Ok(()),
            false => Err(repeated(name)),
        };
        while let Some(name) = object.next_key_seed(Key(&mut check))? {
            values.push((name, object.next_value()?));
        }
        Ok(ByName(values))
    }
}

/// An object with the fields of the struct `T` for keys: each once, and no others.
#[derive(Debug)]
pub(super) struct Object<T>(pub(super) T);

impl<'de, T: Deserialize<'de>> Shape<'de> for Object<T> {
    const EXPECTED: &'static str = "an object";

    fn from_object<A: MapAccess<'de>>(object: A) -> Result<Self, A::Error> {
        T::deserialize(Members(object)).map(Object)
    }
}

/// The members of an object, on their way into a struct.
struct Members<A>(A);

impl<'de, A: MapAccess<'de>> Deserializer<'de> for Members<A> {
    type Error = A::Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        visitor.visit_map(Fields {
            object: self.0,
            fields,
            seen: vec![false; fields.len()],
        })
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_map(self.0)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// Members whose keys are checked against the fields of a struct.
struct Fields<A> {
    object: A,
    fields: &'static [&'static str],
    seen: Vec<bool>,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Fields<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        let (fields, seen) = (self.fields, &mut self.seen);
        let mut check = |key: &str| match fields.iter().position(|field| *field == key) {
            Some(index) if seen[index] => Err(repeated(key)),
            Some(index) => {
                seen[index] = true;
                Ok(())
            }
            None => Err(unknown(key, fields)),
        };
        match self.object.next_key_seed(Key(&mut check))? {
            Some(key) => seed.deserialize(StringDeserializer::new(key)).map(Some),
            None => Ok(None),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.object.next_value_seed(seed)
    }
}

/// Reads a key and checks it, so that what is wrong is reported at the key.
struct Key<'a, C>(&'a mut C);

impl<'de, C: FnMut(&str) -> Result<(), String>> DeserializeSeed<'de> for Key<'_, C> {
    type Value = String;

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<String, D::Error> {
        let key = String::deserialize(json)?;
        (self.0)(&key).map_err(D::Error::custom)?;
        Ok(key)
    }
}

fn repeated(key: &str) -> String {
    format!("the key {:?} is here twice: give it once", excerpt(key))
}

fn unknown(key: &str, fields: &[&str]) -> String {
    let key_excerpt = excerpt(key);
    format!("the key {key_excerpt:?} is unknown: {}", hint(key, fields))
}
