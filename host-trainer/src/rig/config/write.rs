//! [`Rig`] to `rig.toml`. What was read keeps its comments and layout; only what has changed is written anew.

use std::path::Path;

use toml_edit::{ArrayOfTables, Item, Table, TableLike, Value as Toml};

use super::{Machine, Rig, Value};
use crate::recording::atomic_write;
use crate::rig::error::RigError;

impl Rig {
    /// The file's text.
    pub fn to_toml(&self) -> String {
        let mut document = self.document.clone();
        let fresh = document.is_empty();
        if fresh && !matches!(self.model, Machine::Bearing(_)) {
            document["kind"] = self.model.kind().name().into();
        }
        let unknown = document.get("unknown").and_then(Item::as_array);
        let same = unknown
            .is_some_and(|list| list.iter().map(|v| v.as_str()).eq(self.unknown.iter().map(|n| Some(n.as_str()))));
        if !(same || unknown.is_none() && self.unknown.is_empty()) {
            document["unknown"] = Item::Value(self.unknown.iter().collect());
        }
        for key in self.model.keys() {
            let value = self.get(*key).unwrap_or_default();
            if !fresh && document.get(key.name()).is_none() && key.default_value() == Some(value) {
                continue;
            }
            let value = match key.domain() {
                super::Domain::Whole(..) => Toml::from(value as i64),
                _ => Toml::from(value),
            };
            put(document.as_table_mut(), key.name(), value);
        }
        for key in self.model.texts() {
            if !fresh && document.get(key).is_none() && super::key::default_text(key) == self.model.text(key) {
                continue;
            }
            put(document.as_table_mut(), key, self.model.text(key).unwrap_or_default().into());
        }
        self.put_effects(document.as_table_mut());
        if self.as_read().is_none_or(|read| read.paths != self.paths) {
            document.remove("path");
            if !self.paths.is_empty() {
                document["path"] = Item::ArrayOfTables(super::paths::write(&self.paths));
            }
        }
        document.to_string()
    }

    /// Writes the file; it appears under its name only once it is whole.
    ///
    /// # Errors
    ///
    /// Errors of the operating system.
    pub fn write(&self, path: &Path) -> Result<(), RigError> {
        atomic_write::write_atomically(path, self.to_toml().as_bytes())
            .map_err(|source| RigError::Io { path: path.into(), source })
    }

    /// Rig as it was read.
    fn as_read(&self) -> Option<Self> {
        Self::parse(&self.document.to_string(), Path::new("")).ok()
    }

    fn put_effects(&self, document: &mut Table) {
        if self.as_read().is_some_and(|read| read.effects == self.effects) {
            return;
        }
        let mut tables = ArrayOfTables::new();
        for effect in &self.effects {
            let mut table = Table::new();
            table["name"] = effect.kind.name().into();
            for (key, value) in &effect.parameters {
                table[key.name()] = match value {
                    Value::Number(number) => (*number).into(),
                    Value::Text(text) => text.as_str().into(),
                };
            }
            tables.push(table);
        }
        if tables.is_empty() {
            document.remove("effect");
        } else {
            document["effect"] = Item::ArrayOfTables(tables);
        }
    }
}

/// Sets a value where it differs from what is there.
fn put(document: &mut Table, name: &str, value: Toml) {
    let (table, key): (&mut dyn TableLike, &str) = match name.split_once('.') {
        Some((section, key)) => {
            let item = document.entry(section).or_insert(Item::Table(Table::new()));
            match item.as_table_like_mut() {
                Some(table) => (table, key),
                None => return,
            }
        }
        None => (document, name),
    };
    match table.get_mut(key) {
        Some(Item::Value(old)) => {
            let number = |v: &Toml| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
            let same = match (number(old), number(&value)) {
                (Some(a), Some(b)) => a == b,
                _ => old.as_str().is_some() && old.as_str() == value.as_str(),
            };
            if !same {
                let decor = old.decor().clone();
                *old = value;
                *old.decor_mut() = decor;
            }
        }
        _ => {
            table.insert(key, Item::Value(value));
        }
    }
}
