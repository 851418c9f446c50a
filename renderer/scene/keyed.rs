//! `keys`, `interpolation` and `repeat` of a camera, object or light.

use std::ops::Range;

use super::animation::{Interpolation, Keys, Pose, Timeline};
use super::error::SceneError;
use super::value::{Limit, Node, Table};

/// What a table of something that keys can move has besides its own keys.
pub(super) const KEYED: &[&str] = &["keys", "interpolation", "repeat"];

const TIME: Limit = Limit { holds: |t| (-1e6..=1e6).contains(&t), words: "from -1e6 to 1e6" };

/// Seconds from key to key, at least: velocities stay finite.
const LEAST_STEP: f64 = 1e-6;

/// The keys of the things `of`. A key has `fields` besides its `time`; `read` reads a key's pose from node and table.
pub(super) fn read<P: Pose>(
    table: &Table,
    of: Range<usize>,
    title: &str,
    fields: &[&str],
    read: impl Fn(&Node, &Table) -> Result<P, SceneError>,
) -> Result<Option<Keys<P>>, SceneError> {
    let Some(list) = table.get("keys") else {
        let stray = KEYED.iter().find_map(|key| table.get(key));
        return stray.map_or(Ok(None), |node| Err(node.refuse("this key beside `keys` only")));
    };
    let interpolations =
        [("smooth", Interpolation::Smooth), ("linear", Interpolation::Linear), ("step", Interpolation::Step)];
    let interpolation = table.or("interpolation", Interpolation::default(), |node| node.choice(&interpolations))?;

    let (mut times, mut poses) = (Vec::new(), Vec::new());
    for node in list.list("tables, each with a `time`")? {
        let key = node.table(title, &[&["time"], fields].concat())?;
        let time_node = key.need("time", "a number of seconds")?;
        let time = time_node.number(TIME)?;
        if let Some(before) = times.last().filter(|&before| time - before < LEAST_STEP) {
            return Err(time_node.refuse(format!("a time at least {LEAST_STEP:e} after the key's before, {before}")));
        }
        let pose = read(&node, &key)?;
        let turns = interpolation != Interpolation::Step;
        if turns && poses.last().is_some_and(|before: &P| !before.leads_to(&pose)) {
            return Err(node.refuse("a rotation less than half a turn from the key before"));
        }
        poses.push(pose);
        times.push(time);
    }
    let (Some(first), Some(last)) = (poses.first(), poses.last()) else {
        return Err(list.refuse("at least one key, or no `keys`"));
    };
    let repeat = table.or("repeat", false, |node| {
        let repeat = node.flag()?;
        let joined = poses.len() > 1 && last.joins(first);
        if repeat && !joined {
            Err(node.refuse("false, or true where the last of several keys is as the first"))
        } else {
            Ok(repeat)
        }
    })?;
    Ok(Some(Keys { of, timeline: Timeline { times, interpolation, repeat }, poses }))
}
