//! How long passes took, sample by sample.

use std::collections::VecDeque;

use super::state::Followed;
use crate::stats::PassTotal;

/// Samples that are remembered.
pub const LENGTH: usize = 80;

/// The latest samples of one picture.
#[derive(Default)]
pub struct History {
    /// Names in the order they were first met; a column's times are in this order.
    pub names: Vec<String>,
    /// Milliseconds, oldest sample first.
    pub columns: VecDeque<Vec<f32>>,
    totals: Vec<PassTotal>,
}

impl History {
    /// Takes the sample since the last call in, given what passes took in all. Totals that fell were reset.
    pub fn add(&mut self, totals: &[PassTotal]) {
        let mut column = vec![0.0; self.names.len()];
        for total in totals {
            let before = self.totals.iter().find(|t| t.name == total.name && t.calls <= total.calls);
            let before = before.and_then(|t| t.milliseconds).unwrap_or(0.0);
            let taken = (total.milliseconds.unwrap_or(0.0) - before).max(0.0) as f32;
            match self.names.iter().position(|name| *name == total.name) {
                Some(index) => column[index] += taken,
                None => {
                    self.names.push(total.name.clone());
                    column.push(taken);
                }
            }
        }
        self.totals = totals.to_vec();
        self.columns.push_back(column);
        if self.columns.len() > LENGTH {
            self.columns.pop_front();
        }
    }

    /// Samples begin anew. Going to a frame is time of the sample after it; what else passes have taken before is left
    /// out, and another technique begins another history.
    pub fn restart(&mut self, followed: Followed, totals: &[PassTotal]) {
        match followed {
            Followed::Already => {}
            Followed::Restarted => self.totals = totals.to_vec(),
            Followed::Posed => self.totals.clear(),
            Followed::Technique => *self = History { totals: totals.to_vec(), ..Default::default() },
        }
    }

    /// Mean milliseconds of each pass over the last `count` samples that are remembered.
    pub fn means(&self, count: usize) -> Vec<f32> {
        let columns: Vec<&Vec<f32>> = self.columns.iter().rev().take(count).collect();
        let mean = |index: usize| {
            let sum: f32 = columns.iter().filter_map(|column| column.get(index)).sum();
            sum / columns.len().max(1) as f32
        };
        (0..self.names.len()).map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(name: &str, calls: u32, milliseconds: f64) -> PassTotal {
        PassTotal { name: name.to_string(), calls, milliseconds: Some(milliseconds) }
    }

    #[test]
    fn a_column_is_what_was_added() {
        let mut history = History::default();
        history.add(&[total("a", 1, 2.0)]);
        history.add(&[total("a", 2, 5.0), total("b", 1, 1.0)]);
        assert_eq!(history.columns[1], [3.0, 1.0]);
        assert_eq!(history.means(2), [2.5, 0.5]);
        history.restart(Followed::Restarted, &[total("a", 3, 9.0), total("b", 1, 1.0)]);
        history.add(&[total("a", 4, 10.0), total("b", 1, 1.0)]);
        assert_eq!(history.columns[2], [1.0, 0.0]);
        // As many calls as before, all of them new.
        history.restart(Followed::Posed, &[total("b", 1, 0.5)]);
        history.add(&[total("a", 4, 6.0), total("b", 1, 0.5)]);
        assert_eq!((history.columns.len(), &history.columns[3]), (4, &vec![6.0, 0.5]));
        history.restart(Followed::Technique, &[]);
        assert!(history.names.is_empty() && history.columns.is_empty());
    }
}
