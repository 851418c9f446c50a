//! `[technique.NAME]`: settings of techniques that go with a scene.

use super::error::SceneError;
use super::value::Node;
use super::{Scene, SceneSetting};
use crate::technique::TechniqueKind;

/// Reads the settings of all techniques, in the order of the techniques' tables.
pub(super) fn read(node: &Node, scene: &mut Scene) -> Result<(), SceneError> {
    let names: Vec<&str> = TechniqueKind::ALL.iter().map(|kind| kind.name()).collect();
    let all = node.table("[technique]", &names)?;
    for &technique in TechniqueKind::ALL {
        let Some(node) = all.get(technique.name()) else { continue };
        let table = technique.settings();
        let keys: Vec<&str> = table.iter().map(|setting| setting.key).collect();
        let given = node.table(&format!("[technique.{}]", technique.name()), &keys)?;
        for setting in table {
            let Some(node) = given.get(setting.key) else { continue };
            let value = node.words().filter(|value| setting.kind.accepts(value));
            let value = value.ok_or_else(|| node.refuse(setting.kind.allowed()))?;
            scene.settings.push(SceneSetting { technique, key: setting.key, value });
        }
    }
    Ok(())
}
