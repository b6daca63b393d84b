//! `rig.toml` to [`Rig`].

use std::{collections::BTreeMap, path::Path};

use toml_edit::{DocumentMut, Item, Table, TableLike};

use super::effects::parameter_names;
use super::key::default_text;
use super::{EffectEntry, Machine, Rig, RigKind, Value, paths};
use crate::recording::bounded;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{error::RigError, transfer_path::TransmissionPath};

const KINDS: &str = "\"bearing-5dof\" or \"sdof\"";

impl Rig {
    /// Reads a rig.
    ///
    /// # Errors
    ///
    /// Unknown and missing keys, wrong types, impossible values.
    pub fn read(path: &Path) -> Result<Self, RigError> {
        let bytes = bounded::settings(path).map_err(|source| RigError::Io { path: path.into(), source })?;
        Self::parse(&String::from_utf8_lossy(&bytes), path)
    }

    /// A rig from the text of a file; `path` is for messages.
    ///
    /// # Errors
    ///
    /// Errors of [`Rig::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        let document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
            let start = error.span().map_or(0, |span| span.start.min(text.len()));
            let row = text.as_bytes()[..start].iter().filter(|&&b| b == b'\n').count() + 1;
            RigError::Syntax { path: path.into(), row, found: error.message().into() }
        })?;
        let read = Read { path };
        let model = read.model(&document)?;
        let unknown = read.unknown(&document, &model)?;
        let effects = read.effects(&document)?;
        let paths = read.paths(&document)?;
        let rig = Self { model, unknown, effects, paths, document };
        rig.check_as(path)?;
        Ok(rig)
    }
}

struct Read<'a> {
    path: &'a Path,
}

impl Read<'_> {
    fn unknown_key(&self, key: &str, expected: String) -> RigError {
        RigError::UnknownKey { path: self.path.into(), key: key.into(), expected }
    }

    fn missing(&self, key: &str, expected: &str) -> RigError {
        RigError::MissingKey { path: self.path.into(), key: key.into(), expected: expected.into() }
    }

    fn bad(&self, key: &str, found: &Item, expected: &str) -> RigError {
        let found = match found {
            Item::Value(value) => value.clone().decorated("", "").to_string(),
            Item::Table(_) => "a table".into(),
            Item::ArrayOfTables(_) => "an array of tables".into(),
            Item::None => "nothing".into(),
        };
        // One line, however long the value.
        let mut short: String = found.chars().take(60).map(|c| if c.is_control() { ' ' } else { c }).collect();
        if found.chars().count() > 60 {
            short.push('…');
        }
        RigError::BadValue { path: self.path.into(), key: key.into(), found: short, expected: expected.into() }
    }

    fn model(&self, document: &Table) -> Result<Machine, RigError> {
        let kind = match document.get("kind") {
            None => RigKind::Bearing5Dof,
            Some(item) => item.as_str().and_then(RigKind::parse).ok_or_else(|| self.bad("kind", item, KINDS))?,
        };
        let mut model = Machine::blank(kind);
        self.refuse_unknown(document, &model)?;
        for key in model.keys() {
            let expected = key.domain().describe();
            let Some(item) = find(document, key.name()) else {
                let value = key.default_value().ok_or_else(|| self.missing(key.name(), &expected))?;
                model.set_number(*key, value);
                continue;
            };
            let value = number(item).filter(|value| key.domain().holds(*value));
            model.set_number(*key, value.ok_or_else(|| self.bad(key.name(), item, &expected))?);
        }
        for key in model.texts() {
            let Some(item) = find(document, key) else {
                let text = default_text(key).ok_or_else(|| self.missing(key, "a name"))?;
                model.set_text(key, text).map_err(|expected| self.missing(key, &expected))?;
                continue;
            };
            let text = item.as_str().ok_or_else(|| self.bad(key, item, "a name"))?;
            model.set_text(key, text).map_err(|expected| self.bad(key, item, &expected))?;
        }
        Ok(model)
    }

    fn refuse_unknown(&self, document: &Table, model: &Machine) -> Result<(), RigError> {
        let names = || model.keys().iter().map(|key| key.name()).chain(model.texts().iter().copied());
        let mut top = vec!["kind", "unknown", "effect", "path"];
        for name in names() {
            let section = name.split_once('.').map_or(name, |(section, _)| section);
            if !top.contains(&section) {
                top.push(section);
            }
        }
        for (section, item) in document {
            if !top.contains(&section) {
                return Err(self.unknown_key(section, format!("one of {}", top.join(", "))));
            }
            let in_section = |name: &&str| name.split_once('.').is_some_and(|(s, _)| s == section);
            let keys: Vec<&str> = names().filter(in_section).map(|name| &name[section.len() + 1..]).collect();
            if keys.is_empty() {
                continue;
            }
            let table = item.as_table_like().ok_or_else(|| self.bad(section, item, "a table"))?;
            for (key, _) in table.iter() {
                if !keys.contains(&key) {
                    let expected = format!("one of {}", keys.join(", "));
                    return Err(self.unknown_key(&format!("{section}.{key}"), expected));
                }
            }
        }
        Ok(())
    }

    fn unknown(&self, document: &Table, model: &Machine) -> Result<Vec<String>, RigError> {
        const EXPECTED: &str = "a list of sections or keys of this file whose values are numbers";
        let Some(item) = document.get("unknown") else {
            return Ok(Vec::new());
        };
        let list = item.as_array().ok_or_else(|| self.bad("unknown", item, EXPECTED))?;
        let mut names = Vec::with_capacity(list.len());
        for value in list {
            let known = |name: &&str| {
                model
                    .keys()
                    .iter()
                    .any(|k| k.name() == *name || k.name().split_once('.').is_some_and(|(s, _)| s == *name))
            };
            let name = value.as_str().filter(known);
            let name = name.ok_or_else(|| self.bad("unknown", &Item::Value(value.clone()), EXPECTED))?;
            names.push(name.to_owned());
        }
        Ok(names)
    }

    fn effects(&self, document: &Table) -> Result<Vec<EffectEntry>, RigError> {
        const EXPECTED: &str = "[[effect]] tables";
        let Some(item) = document.get("effect") else {
            return Ok(Vec::new());
        };
        let tables: Vec<&dyn TableLike> = match (item.as_array_of_tables(), item.as_array()) {
            (Some(tables), _) => tables.iter().map(|table| table as &dyn TableLike).collect(),
            (_, Some(array)) => {
                let tables = array.iter().map(|value| value.as_inline_table().map(|table| table as &dyn TableLike));
                tables.collect::<Option<_>>().ok_or_else(|| self.bad("effect", item, EXPECTED))?
            }
            _ => return Err(self.bad("effect", item, EXPECTED)),
        };
        let mut effects = Vec::with_capacity(tables.len());
        for (index, table) in tables.into_iter().enumerate() {
            let place = |key: &str| format!("effect[{}].{key}", index + 1);
            let name = table.get("name").ok_or_else(|| self.missing(&place("name"), "a name of the vocabulary"))?;
            let kind = name.as_str().and_then(EffectKind::parse).ok_or_else(|| {
                let names: Vec<_> = EffectKind::ALL.iter().map(|kind| kind.name()).collect();
                self.bad(&place("name"), name, &format!("one of {}", names.join(", ")))
            })?;
            let mut parameters = BTreeMap::new();
            for (key, item) in table.iter().filter(|(key, _)| *key != "name") {
                let known = ParameterKey::parse(key);
                let known = known.ok_or_else(|| self.unknown_key(&place(key), parameter_names(kind.definition())))?;
                let text = item.as_str().map(|text| Value::Text(text.into()));
                let value = text.or_else(|| number(item).map(Value::Number));
                parameters.insert(known, value.ok_or_else(|| self.bad(&place(key), item, "a number or a name"))?);
            }
            effects.push(EffectEntry { kind, parameters });
        }
        Ok(effects)
    }

    fn paths(&self, document: &Table) -> Result<Vec<TransmissionPath>, RigError> {
        let Some(item) = document.get("path") else {
            return Ok(Vec::new());
        };
        let tables = item.as_array_of_tables().ok_or_else(|| self.bad("path", item, "[[path]] tables"))?;
        let mut found: Vec<TransmissionPath> = Vec::new();
        for (index, table) in tables.iter().enumerate() {
            let place = |key: &str| format!("path[{}].{key}", index + 1);
            let path = paths::read(table).map_err(|(key, expected)| match table.get(&key) {
                Some(_) if !paths::KEYS.contains(&key.as_str()) => self.unknown_key(&place(&key), expected),
                Some(item) => self.bad(&place(&key), item, &expected),
                None => self.missing(&place(&key), &expected),
            })?;
            if found.iter().any(|other| other.channel == path.channel) {
                return Err(self.bad(&place("channel"), &table["channel"], "a channel that has no path yet"));
            }
            found.push(path);
        }
        Ok(found)
    }
}

fn find<'a>(document: &'a Table, name: &str) -> Option<&'a Item> {
    match name.split_once('.') {
        Some((section, key)) => document.get(section)?.as_table_like()?.get(key),
        None => document.get(name),
    }
}

fn number(item: &Item) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|i| i as f64))
}
