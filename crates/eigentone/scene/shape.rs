//! The few shapes of JSON that a scene is made of, each read strictly.
//!
//! Derived readers alone would take an array for an object and `null` for something left out.

use std::collections::HashSet;
use std::fmt;
use std::marker::PhantomData;

use eigentone_modes as modes;
use eigentone_response as response;
use serde::de::value::StringDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, forward_to_deserialize_any};

use super::words::{did_you_mean, excerpt};

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
    Count,
    Text,
    Column,
    Matrix,
    OneOrMore,
    Two<T>,
    List<T>,
    Values<T>,
    Ratios<T>,
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

/// A number of pieces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Count(pub(super) usize);

impl Shape<'_> for Count {
    const EXPECTED: &'static str = "a whole number from 1 to 10000000";

    fn from_number<E: Error>(number: f64) -> Result<Self, E> {
        match number.fract() == 0.0 && (1.0..=1e7).contains(&number) {
            true => Ok(Count(number as usize)),
            false => Err(unexpected::<Self, E>(&format!("the number {number}"))),
        }
    }
}

/// A column of a file by its name or its number, or the only one there is.
#[derive(Clone, Debug, Default)]
pub(super) enum Column {
    #[default]
    Only,
    Name(String),
    /// From 1.
    Number(usize),
}

impl Shape<'_> for Column {
    const EXPECTED: &'static str = "the name of a column or its number, from 1 on";

    fn from_number<E: Error>(number: f64) -> Result<Self, E> {
        match number.fract() == 0.0 && (1.0..=1e6).contains(&number) {
            true => Ok(Column::Number(number as usize)),
            false => Err(unexpected::<Self, E>(&format!("the number {number}"))),
        }
    }

    fn from_text<E: Error>(text: String) -> Result<Self, E> {
        Ok(Column::Name(text))
    }
}

/// Two of a kind: the names that a spring or damper joins, or the ends of a beam.
#[derive(Debug)]
pub(super) struct Two<T>(pub(super) [T; 2]);

impl<'de, T: Deserialize<'de>> Shape<'de> for Two<T> {
    const EXPECTED: &'static str = "a list of two names";

    fn from_list<A: SeqAccess<'de>>(mut list: A) -> Result<Self, A::Error> {
        let first: Option<T> = list.next_element()?;
        let second: Option<T> = list.next_element()?;
        let mut beyond = 0;
        while list.next_element::<IgnoredAny>()?.is_some() {
            beyond += 1;
        }
        match (first, second, beyond) {
            (Some(first), Some(second), 0) => Ok(Two([first, second])),
            (first, second, _) => {
                let count = first.iter().count() + second.iter().count() + beyond;
                Err(unexpected::<Self, A::Error>(&format!("a list of {count}")))
            }
        }
    }
}

/// Readers of texts that are one of a few words.
macro_rules! words {
    ($($(#[$attribute:meta])* $name:ident($value:ty): $expected:literal, $($word:literal => $means:expr),+;)+) => {$(
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug)]
        pub(super) struct $name(pub(super) $value);

        impl Shape<'_> for $name {
            const EXPECTED: &'static str = $expected;

            fn from_text<E: Error>(text: String) -> Result<Self, E> {
                match text.as_str() {
                    $($word => Ok($name($means)),)+
                    _ => Err(unexpected::<Self, E>(&format!("the text {:?}", excerpt(&text)))),
                }
            }
        }

        deserialize_by_shape!($name);
    )+};
}
words! {
    /// What a sampled force does between its samples.
    Hold(response::Hold): "\"zero\" or \"first\"",
        "zero" => response::Hold::Zero, "first" => response::Hold::First;
    /// Whether frequencies are evenly spread on a linear scale.
    #[derive(Default)]
    Spacing(bool): "\"log\" or \"linear\"",
        "log" => false, "linear" => true;
    /// Whether a coordinate is a rotation.
    #[derive(Default)]
    Unit(bool): "\"m\" or \"rad\"",
        "m" => false, "rad" => true;
    /// Whether the mass of a beam or rod is lumped at its nodes.
    #[derive(Default)]
    MassKind(bool): "\"consistent\" or \"lumped\"",
        "consistent" => false, "lumped" => true;
    /// Whether a controlled damper follows the clipped law.
    DamperLaw(bool): "\"on-off skyhook\" or \"clipped skyhook\"",
        "on-off skyhook" => false, "clipped skyhook" => true;
    /// How an end of a beam is held.
    BeamEnd(modes::BeamEnd): "\"clamped\", \"pinned\", \"guided\" or \"free\"",
        "clamped" => modes::BeamEnd::Clamped, "pinned" => modes::BeamEnd::Pinned,
        "guided" => modes::BeamEnd::Guided, "free" => modes::BeamEnd::Free;
    /// How an end of a rod is held.
    RodEnd(modes::RodEnd): "\"fixed\" or \"free\"",
        "fixed" => modes::RodEnd::Fixed, "free" => modes::RodEnd::Free;
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

/// The values of samples, or where they are.
#[derive(Debug)]
pub(super) enum Values<T> {
    Here(Vec<Number>),
    There(T),
}

impl<'de, T: Deserialize<'de>> Shape<'de> for Values<T> {
    const EXPECTED: &'static str = "a list of numbers, or an object with \"file\" and \"column\"";

    fn from_list<A: SeqAccess<'de>>(list: A) -> Result<Self, A::Error> {
        Ok(Values::Here(List::from_list(list)?.0))
    }

    fn from_object<A: MapAccess<'de>>(object: A) -> Result<Self, A::Error> {
        Ok(Values::There(Object::from_object(object)?.0))
    }
}

/// A number or a list of them.
#[derive(Debug)]
pub(super) struct OneOrMore(pub(super) Vec<f64>);

impl<'de> Shape<'de> for OneOrMore {
    const EXPECTED: &'static str = "a number or a list of numbers";

    fn from_number<E: Error>(number: f64) -> Result<Self, E> {
        Ok(OneOrMore(vec![number]))
    }

    fn from_list<A: SeqAccess<'de>>(list: A) -> Result<Self, A::Error> {
        let numbers: List<Number> = List::from_list(list)?;
        Ok(OneOrMore(numbers.0.iter().map(|number| number.0).collect()))
    }
}

/// Ratios by themselves, or with more that is said of them.
#[derive(Debug)]
pub(super) enum Ratios<T> {
    Plain(OneOrMore),
    More(T),
}

impl<'de, T: Deserialize<'de>> Shape<'de> for Ratios<T> {
    const EXPECTED: &'static str = "a number, a list of numbers, or an object with \"ratios\"";

    fn from_number<E: Error>(number: f64) -> Result<Self, E> {
        OneOrMore::from_number(number).map(Ratios::Plain)
    }

    fn from_list<A: SeqAccess<'de>>(list: A) -> Result<Self, A::Error> {
        OneOrMore::from_list(list).map(Ratios::Plain)
    }

    fn from_object<A: MapAccess<'de>>(object: A) -> Result<Self, A::Error> {
        Ok(Ratios::More(Object::from_object(object)?.0))
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
    const EXPECTED: &'static str = "an object whose keys are names, as {\"m1\": …}";

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
    format!(
        "the key {key_excerpt:?} is unknown: {}",
        did_you_mean(key, fields)
    )
}
