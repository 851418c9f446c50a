//! TOML values with their place in the file, read strictly: each reader names what it found and what it allows.

use std::path::Path;

use glam::{DVec2, DVec3, Vec3};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{Location, SceneError};

/// A scene file's text, to turn offsets into lines.
#[derive(Clone, Copy)]
pub(super) struct Source<'s> {
    pub path: &'s Path,
    pub text: &'s str,
}

impl Source<'_> {
    pub fn line(&self, offset: usize) -> Location {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        Location { path: self.path.into(), line: line as u32, column: None }
    }

    pub fn line_and_column(&self, offset: usize) -> Location {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
        let column = 1 + String::from_utf8_lossy(&before[start..]).chars().count();
        Location { column: Some(column as u32), ..self.line(offset) }
    }
}

/// The numbers a key takes. `words` follow "a number" in messages.
#[derive(Clone, Copy)]
pub(super) struct Limit {
    pub holds: fn(f64) -> bool,
    pub words: &'static str,
}

/// Coordinates and lengths keep their squares and cubes inside the range of f32.
pub(super) const COORDINATE: Limit = Limit { holds: |x| (-1e6..=1e6).contains(&x), words: "from -1e6 to 1e6" };
/// Sizes, which may not vanish.
pub(super) const LENGTH: Limit = Limit { holds: |x| (1e-6..=1e6).contains(&x), words: "from 1e-6 to 1e6" };
/// Powers, radiances, coefficients.
pub(super) const QUANTITY: Limit = Limit { holds: |x| (0.0..=1e9).contains(&x), words: "from 0 to 1e9" };
pub(super) const FRACTION: Limit = Limit { holds: |x| (0.0..=1.0).contains(&x), words: "from 0 to 1" };
/// Angles in degrees or radians, phases.
pub(super) const ANGLE: Limit = Limit { holds: |x| (-1e4..=1e4).contains(&x), words: "from -1e4 to 1e4" };

/// One value under a key.
#[derive(Clone)]
pub(super) struct Node<'s> {
    pub source: Source<'s>,
    /// Dotted, as in `film.width`.
    pub key: String,
    value: &'s Spanned<DeValue<'s>>,
}

impl<'s> Node<'s> {
    pub fn at(&self) -> Location {
        self.source.line(self.value.span().start)
    }

    /// The error of a value that is not what `allowed` says.
    pub fn refuse(&self, allowed: impl Into<String>) -> SceneError {
        let found = describe(self.value.get_ref());
        SceneError::Value { at: self.at(), key: self.key.clone(), found, allowed: allowed.into() }
    }

    fn scalar(&self) -> Option<f64> {
        match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(_) => self.integer().map(|integer| integer as f64),
            _ => None,
        }
    }

    fn integer(&self) -> Option<i64> {
        let integer = self.value.get_ref().as_integer()?;
        i64::from_str_radix(integer.as_str(), integer.radix()).ok()
    }

    fn within(&self, limit: Limit) -> Option<f64> {
        self.scalar().filter(|&number| (limit.holds)(number))
    }

    fn numbers<const N: usize>(&self, limit: Limit) -> Option<[f64; N]> {
        let items: Vec<f64> = self.items()?.iter().map(|item| item.within(limit)).collect::<Option<_>>()?;
        items.try_into().ok()
    }

    fn items(&self) -> Option<Vec<Node<'s>>> {
        let array = self.value.get_ref().as_array()?;
        let node = |value| Node { source: self.source, key: self.key.clone(), value };
        Some(array.iter().map(node).collect())
    }

    pub fn number(&self, limit: Limit) -> Result<f64, SceneError> {
        self.within(limit).ok_or_else(|| self.refuse(format!("a number {}", limit.words)))
    }

    pub fn whole(&self, low: u32, high: u32) -> Result<u32, SceneError> {
        let integer = self.integer().and_then(|integer| u32::try_from(integer).ok());
        integer
            .filter(|integer| (low..=high).contains(integer))
            .ok_or_else(|| self.refuse(format!("a whole number from {low} to {high}")))
    }

    /// One whole number for both, or a list of two.
    pub fn whole_pair(&self, low: u32, high: u32) -> Result<[u32; 2], SceneError> {
        let allowed = || self.refuse(format!("a whole number from {low} to {high}, or a list of two"));
        let items = self.items().unwrap_or_else(|| vec![self.clone(), self.clone()]);
        let [first, second] = items.as_slice() else {
            return Err(allowed());
        };
        let read = |node: &Node| node.whole(low, high).map_err(|_| allowed());
        Ok([read(first)?, read(second)?])
    }

    pub fn vec2(&self, limit: Limit) -> Result<DVec2, SceneError> {
        let allowed = || self.refuse(format!("a list of two numbers, each {}", limit.words));
        self.numbers(limit).map(DVec2::from_array).ok_or_else(allowed)
    }

    pub fn vec3(&self, limit: Limit) -> Result<DVec3, SceneError> {
        let allowed = || self.refuse(format!("a list of three numbers, each {}", limit.words));
        self.numbers(limit).map(DVec3::from_array).ok_or_else(allowed)
    }

    /// A number for all three, or a list of three.
    pub fn triple(&self, limit: Limit) -> Result<DVec3, SceneError> {
        let allowed = || self.refuse(format!("a number {}, or a list of three", limit.words));
        let grey = self.within(limit).map(DVec3::splat);
        grey.or_else(|| self.numbers(limit).map(DVec3::from_array)).ok_or_else(allowed)
    }

    /// Linear Rec.709, or one number for grey.
    pub fn rgb(&self, limit: Limit) -> Result<Vec3, SceneError> {
        Ok(self.triple(limit)?.as_vec3())
    }

    /// A direction of any length but zero, made unit.
    pub fn direction(&self) -> Result<DVec3, SceneError> {
        let vector = self.vec3(COORDINATE)?;
        let allowed = || self.refuse("a list of three numbers that are not all 0");
        vector.try_normalize().ok_or_else(allowed)
    }

    pub fn flag(&self) -> Result<bool, SceneError> {
        self.value.get_ref().as_bool().ok_or_else(|| self.refuse("true or false"))
    }

    pub fn text(&self) -> Result<&'s str, SceneError> {
        let text = self.value.get_ref().as_str().filter(|text| !text.trim().is_empty());
        text.ok_or_else(|| self.refuse("a text that is not empty"))
    }

    /// A number or a text as the command line would have it.
    pub fn words(&self) -> Option<String> {
        match self.value.get_ref() {
            DeValue::String(text) => Some(text.to_string()),
            DeValue::Integer(_) => self.integer().map(|integer| integer.to_string()),
            DeValue::Float(_) => self.scalar().map(|number| number.to_string()),
            _ => None,
        }
    }

    pub fn choice<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T, SceneError> {
        let text = self.value.get_ref().as_str();
        let chosen = choices.iter().find(|(name, _)| text == Some(name));
        let names = || choices.iter().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
        chosen.map(|(_, value)| *value).ok_or_else(|| self.refuse(names()))
    }

    pub fn list(&self, of_what: &str) -> Result<Vec<Node<'s>>, SceneError> {
        self.items().ok_or_else(|| self.refuse(format!("a list of {of_what}")))
    }

    /// A table with no keys but those `allowed`; `title` is how messages call it, as in `[film]`.
    pub fn table(&self, title: &str, allowed: &[&str]) -> Result<Table<'s>, SceneError> {
        self.any_table(title)?.only(allowed)
    }

    /// A table whose keys are yet to be checked.
    pub fn any_table(&self, title: &str) -> Result<Table<'s>, SceneError> {
        let table = self.value.get_ref().as_table().ok_or_else(|| self.refuse("a table"))?;
        let (title, key) = (title.to_owned(), self.key.clone());
        Ok(Table { source: self.source, title, key, table, node: Some(self.clone()) })
    }
}

/// Keys and values, with the keys checked against those allowed.
#[derive(Clone)]
pub(super) struct Table<'s> {
    source: Source<'s>,
    pub title: String,
    key: String,
    table: &'s DeTable<'s>,
    node: Option<Node<'s>>,
}

impl<'s> Table<'s> {
    /// The whole file.
    pub fn root(source: Source<'s>, table: &'s DeTable<'s>, allowed: &[&str]) -> Result<Self, SceneError> {
        Table { source, title: "the scene file".to_owned(), key: String::new(), table, node: None }.only(allowed)
    }

    /// Refuses the first key, in the file's order, that is not allowed.
    pub fn only(self, allowed: &[&str]) -> Result<Self, SceneError> {
        let unknown = self.table.keys().filter(|key| !allowed.contains(&key.get_ref().as_ref()));
        match unknown.min_by_key(|key| key.span().start) {
            None => Ok(self),
            Some(key) => Err(SceneError::UnknownKey {
                at: self.source.line(key.span().start),
                key: key.get_ref().to_string(),
                table: self.title.clone(),
                allowed: allowed.join(", "),
            }),
        }
    }

    pub fn at(&self) -> Location {
        self.node.as_ref().map_or_else(|| self.source.line(0), Node::at)
    }

    pub fn get(&self, key: &str) -> Option<Node<'s>> {
        let (_, value) = self.table.iter().find(|(name, _)| name.get_ref().as_ref() == key)?;
        let dotted = if self.key.is_empty() { key.to_owned() } else { format!("{}.{key}", self.key) };
        Some(Node { source: self.source, key: dotted, value })
    }

    /// `allowed` says what a missing key should hold.
    pub fn need(&self, key: &str, allowed: &str) -> Result<Node<'s>, SceneError> {
        self.get(key).ok_or_else(|| SceneError::MissingKey {
            at: self.at(),
            table: self.title.clone(),
            key: key.to_owned(),
            allowed: allowed.to_owned(),
        })
    }

    /// Reads a key that may be left out.
    pub fn or<T>(
        &self,
        key: &str,
        default: T,
        read: impl FnOnce(Node<'s>) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        self.get(key).map_or(Ok(default), read)
    }

    /// Reads a key that may be left out where there is a default.
    pub fn or_need<T>(
        &self,
        key: &str,
        allowed: &str,
        default: Option<T>,
        read: impl FnOnce(Node<'s>) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        match default {
            Some(default) => self.or(key, default, read),
            None => read(self.need(key, allowed)?),
        }
    }
}

/// How many values of a list a message repeats.
const SHOWN: usize = 4;

fn describe(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text {:?}", text.as_ref()),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().to_owned(),
        DeValue::Integer(integer) => format!("{} in base {}", integer.as_str(), integer.radix()),
        DeValue::Float(float) => float.as_str().to_owned(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(array) => {
            let items: Vec<String> = array.iter().take(SHOWN).map(|item| describe(item.get_ref())).collect();
            let more = if array.len() > SHOWN { ", ..." } else { "" };
            format!("the list [{}{more}]", items.join(", "))
        }
        DeValue::Table(_) => "a table".to_owned(),
    }
}
