//! The table of `--set technique.key=value`: what each technique can be told, in what range.

use super::{TechniqueError, TechniqueKind};
use crate::scene::Scene;

/// One setting of a technique.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    pub key: &'static str,
    pub kind: SettingKind,
    pub default: &'static str,
    /// What the number counts; empty for a choice.
    pub unit: &'static str,
    pub help: &'static str,
}

/// The values that a setting takes.
#[derive(Debug, Clone, Copy)]
pub enum SettingKind {
    Integer {
        min: i64,
        max: i64,
    },
    Number {
        min: f64,
        max: f64,
    },
    Choice(&'static [&'static str]),
    /// The name of a file, from the working directory.
    File,
}

impl SettingKind {
    /// The allowed values, for messages and help.
    pub fn allowed(&self) -> String {
        match self {
            SettingKind::Integer { min, max } => format!("an integer from {min} to {max}"),
            SettingKind::Number { min, max } => format!("a number from {min} to {max}"),
            SettingKind::Choice(values) => format!("one of {}", values.join(", ")),
            SettingKind::File => "the name of a file".to_string(),
        }
    }

    /// Whether a setting of this kind can be `value`.
    pub fn accepts(&self, value: &str) -> bool {
        match self {
            SettingKind::Integer { min, max } => value.parse::<i64>().is_ok_and(|v| (*min..=*max).contains(&v)),
            SettingKind::Number { min, max } => value.parse::<f64>().is_ok_and(|v| (*min..=*max).contains(&v)),
            SettingKind::Choice(values) => values.contains(&value),
            SettingKind::File => !value.is_empty(),
        }
    }
}

/// The settings of one technique, each checked and filled in.
#[derive(Debug, Clone)]
pub struct Settings(Vec<(&'static str, String)>);

impl Settings {
    /// Those of `kind` for a scene, which may have defaults of its own; `items` win over them.
    pub fn of(kind: TechniqueKind, scene: &Scene, items: &[String]) -> Result<Self, TechniqueError> {
        let own = scene.settings.iter().filter(|setting| setting.technique == kind);
        let mut all: Vec<String> = own.map(|setting| setting.item()).collect();
        all.extend_from_slice(items);
        Self::parse(kind, &all)
    }

    /// Reads `technique.key=value` items for `kind`. Later items win.
    pub fn parse(kind: TechniqueKind, items: &[String]) -> Result<Self, TechniqueError> {
        let table = kind.settings();
        let mut values: Vec<_> = table.iter().map(|s| (s.key, s.default.to_string())).collect();
        for item in items {
            let (key, value) = split(kind, item)?;
            let position = table.iter().position(|s| s.key == key).ok_or_else(|| TechniqueError::UnknownSetting {
                technique: kind.name(),
                found: key.to_string(),
                allowed: if table.is_empty() {
                    "none".to_string()
                } else {
                    table.iter().map(|s| s.key).collect::<Vec<_>>().join(", ")
                },
            })?;
            if !table[position].kind.accepts(value) {
                return Err(TechniqueError::SettingValue {
                    setting: format!("{}.{key}", kind.name()),
                    found: value.to_string(),
                    allowed: table[position].kind.allowed(),
                });
            }
            values[position].1 = value.to_string();
        }
        Ok(Settings(values))
    }

    fn text(&self, key: &str) -> &str {
        self.0.iter().find(|(k, _)| *k == key).map_or("", |(_, v)| v)
    }

    pub fn integer(&self, key: &str) -> u32 {
        self.text(key).parse().unwrap_or_default()
    }

    pub fn number(&self, key: &str) -> f32 {
        self.text(key).parse().unwrap_or_default()
    }

    pub fn choice(&self, key: &str) -> &str {
        self.text(key)
    }

    /// As given and filled in, for the record.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.0.iter().map(|(k, v)| (*k, v.as_str()))
    }
}

/// `reference.photons=1000` for the technique `reference` is (`photons`, `1000`).
fn split(kind: TechniqueKind, item: &str) -> Result<(&str, &str), TechniqueError> {
    let malformed = || TechniqueError::MalformedSetting { found: item.to_string() };
    let (path, value) = item.split_once('=').ok_or_else(malformed)?;
    let (technique, key) = path.split_once('.').ok_or_else(malformed)?;
    let of = TechniqueKind::parse(technique.trim())?;
    if of != kind {
        return Err(TechniqueError::OtherTechnique { item: item.to_string(), technique: kind.name() });
    }
    Ok((key.trim(), value.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(item: &str) -> String {
        Settings::parse(TechniqueKind::Reference, &[item.to_string()]).unwrap_err().to_string()
    }

    #[test]
    fn settings_are_checked_against_the_table() {
        let settings = Settings::parse(TechniqueKind::Reference, &["reference.photons=1000".to_string()]).unwrap();
        assert_eq!(settings.integer("photons"), 1000);
        assert_eq!(settings.choice("fresnel"), "chance");
        assert_eq!(
            message("reference.photon=1"),
            "the technique reference has no setting \"photon\"; it has: photons, reuse, radius, neighbours, alpha, volume_photons, volume_neighbours, fresnel, paths"
        );
        assert!(message("reference.photons=0").starts_with("reference.photons is \"0\"; allowed is an integer from"));
        assert!(message("photons=0").contains("is not of the form technique.key=value"));
        assert!(message("none.x=1").contains("is for another technique than reference"));
        assert!(message("reference.alpha=nan").contains("allowed is a number"));
    }

    #[test]
    fn defaults_are_allowed_values() {
        for kind in TechniqueKind::ALL {
            for setting in kind.settings() {
                assert!(setting.kind.accepts(setting.default), "{} {}", kind.name(), setting.key);
            }
        }
    }

    /// Of the techniques that README.md has a table for.
    #[test]
    fn the_readme_has_every_setting_with_its_default() {
        let readme = include_str!("../../README.md");
        for kind in [TechniqueKind::Reference, TechniqueKind::Beams, TechniqueKind::Photons, TechniqueKind::Eikonal] {
            let heading = format!("### Settings of `{}`", kind.name());
            let section = readme.split(&heading).nth(1).and_then(|rest| rest.split("\n#").next()).unwrap();
            let rows: Vec<Vec<&str>> = section.lines().map(|line| line.split('|').map(str::trim).collect()).collect();
            for setting in kind.settings() {
                let key = format!("`{}`", setting.key);
                let row = rows.iter().find(|cells| cells.get(1).is_some_and(|keys| keys.contains(&key)));
                let default = row.and_then(|cells| cells.get(2)).map(|cell| cell.trim_matches('`'));
                assert_eq!(default, Some(setting.default), "{} {key}", kind.name());
            }
        }
    }
}
