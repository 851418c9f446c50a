//! `motion` of a height field.

use super::animation::{Drop, MOST_DAMPING_PER_STEP, MOST_STEPS_PER_FRAME, Rain, Simulation, WaterMotion};
use super::error::SceneError;
use super::height_field::{Bump, HeightField};
use super::object::{BUMP_KEYS, read_bump, read_each};
use super::value::{COORDINATE, LENGTH, Limit, Node, Table};

const WAVES_KEYS: &[&str] = &["kind", "depth"];
const SIMULATED_KEYS: &[&str] = &["kind", "speed", "damping", "drops", "rain"];

const SPEED: Limit = Limit { holds: |v| (1e-3..=1e3).contains(&v), words: "from 1e-3 to 1e3" };
const DAMPING: Limit = Limit { holds: |d| (0.0..=1e3).contains(&d), words: "from 0 to 1e3" };
const DROP_TIME: Limit = Limit { holds: |t| (0.0..=1e6).contains(&t), words: "from 0 to 1e6" };
const RATE: Limit = Limit { holds: |rate| (1e-3..=1e3).contains(&rate), words: "from 1e-3 to 1e3" };

#[derive(Clone, Copy)]
enum Kind {
    Waves,
    Simulated,
}

/// What moves `field`, which is shown at `fps` frames per second.
pub(super) fn read(node: &Node, field: &HeightField, fps: f64) -> Result<WaterMotion, SceneError> {
    let kinds = [("waves", Kind::Waves), ("simulated", Kind::Simulated)];
    let kind = node.any_table("`motion`")?.need("kind", "\"waves\", \"simulated\"")?.choice(&kinds)?;
    match kind {
        Kind::Waves => {
            let table = node.table("`motion` by waves", WAVES_KEYS)?;
            Ok(WaterMotion::Waves { depth: table.get("depth").map(|node| node.number(LENGTH)).transpose()? })
        }
        Kind::Simulated => {
            let table = node.table("simulated `motion`", SIMULATED_KEYS)?;
            Ok(WaterMotion::Simulated(read_simulation(&table, field, fps)?))
        }
    }
}

fn read_simulation(table: &Table, field: &HeightField, fps: f64) -> Result<Simulation, SceneError> {
    let speed_node = table.need("speed", "metres per second")?;
    let mut simulation = Simulation {
        speed: speed_node.number(SPEED)?,
        damping: table.or("damping", 0.0, |node| node.number(DAMPING))?,
        drops: read_each(table, "drops", read_drop)?,
        rain: table.get("rain").map(|node| read_rain(&node)).transpose()?,
    };
    simulation.drops.sort_by(|a, b| a.time.total_cmp(&b.time));
    if (Simulation { damping: 0.0, ..simulation.clone() }).steps_per_frame(field, fps) > MOST_STEPS_PER_FRAME {
        return Err(speed_node.refuse(format!(
            "at most {} with quads of this size at {fps} frames per second: a wave may cross half a quad in a step, and \
             {MOST_STEPS_PER_FRAME} steps are the most between two frames",
            (Simulation::fastest(field, fps) * 1e3).floor() / 1e3
        )));
    }
    if simulation.steps_per_frame(field, fps) > MOST_STEPS_PER_FRAME {
        return Err(table.need("damping", "")?.refuse(format!(
            "at most {} at {fps} frames per second: damping times the length of a step may be {MOST_DAMPING_PER_STEP}, \
             and {MOST_STEPS_PER_FRAME} steps are the most between two frames",
            (Simulation::most_damping(fps) * 1e3).floor() / 1e3
        )));
    }
    Ok(simulation)
}

fn read_drop(node: &Node) -> Result<Drop, SceneError> {
    let table = node.table("a drop", &[&["time"], BUMP_KEYS].concat())?;
    let time = table.need("time", "a number of seconds")?.number(DROP_TIME)?;
    let Bump { centre, height, radius } = read_bump(&table)?;
    Ok(Drop { time, centre, height, radius })
}

fn read_rain(node: &Node) -> Result<Rain, SceneError> {
    let table = node.table("`rain`", &["rate", "height", "radius", "seed"])?;
    Ok(Rain {
        rate: table.need("rate", "drops per second")?.number(RATE)?,
        height: table.need("height", "a number of metres")?.number(COORDINATE)?,
        radius: table.need("radius", "a number of metres")?.number(LENGTH)?,
        seed: table.or("seed", 0, |node| node.whole(0, u32::MAX))?,
    })
}
