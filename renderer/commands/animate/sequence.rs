//! Which frames are asked for.

use std::str::FromStr;

/// So that a slip of the finger does not ask for four billion files.
const MOST_FRAMES: u32 = 1_000_000;

/// Frames `first` to `last`, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    pub first: u32,
    pub last: u32,
}

impl Frames {
    /// Those of a shard, in order.
    pub fn of(self, shard: Shard) -> impl Iterator<Item = u32> {
        (self.first..=self.last).skip(shard.index as usize - 1).step_by(shard.count as usize)
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const WANTED: &str = "wanted are the first and the last frame, such as 0..47, or one frame";
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        let number = |text: &str| text.parse::<u32>().map_err(|_| WANTED);
        let frames = Frames { first: number(first)?, last: number(last)? };
        if frames.last < frames.first {
            return Err(format!("the last frame comes before the first; {WANTED}"));
        }
        if frames.last - frames.first >= MOST_FRAMES {
            return Err(format!("these are more than {MOST_FRAMES} frames"));
        }
        Ok(frames)
    }
}

/// One of `count` interleaved parts of a sequence, 1 to `count`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Shard {
    pub index: u32,
    pub count: u32,
}

impl Shard {
    /// The sequence undivided.
    pub const WHOLE: Shard = Shard { index: 1, count: 1 };
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || format!("wanted are the part and the number of parts, such as 1/4, at most {MOST_FRAMES}");
        let (index, count) = text.split_once('/').ok_or_else(wanted)?;
        let (Ok(index), Ok(count)) = (index.parse(), count.parse()) else { return Err(wanted()) };
        if (1..=count).contains(&index) && count <= MOST_FRAMES { Ok(Shard { index, count }) } else { Err(wanted()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_out_every_frame_once() {
        for (frames, count) in [("0..47", 2), ("5..11", 3), ("4", 3), ("0..1", 7)] {
            let frames: Frames = frames.parse().unwrap();
            let mut all: Vec<u32> = (1..=count).flat_map(|index| frames.of(Shard { index, count })).collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(frames.first..=frames.last), "{frames:?} in {count}");
        }
        assert!(Frames { first: 3, last: 9 }.of(Shard { index: 2, count: 3 }).eq([4, 7]));
    }
}
