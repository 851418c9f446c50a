//! Values at key times, and what lies between.

use glam::{DQuat, DVec3};

/// What happens between two keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Cubic, with continuous velocity; a number never goes beyond its keys. At rest at the first and at the last key.
    #[default]
    Smooth,
    /// At constant velocity.
    Linear,
    /// At rest until the next key.
    Step,
}

/// Times of keys. Before the first and after the last, the value there holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Timeline {
    /// Seconds, strictly increasing, at least one.
    pub times: Vec<f64>,
    pub interpolation: Interpolation,
    /// The time from the first key to the last is played again and again, before and after as well. There are two keys or
    /// more, and the first and the last have the same value.
    pub repeat: bool,
}

/// A moment among the keys of a [`Timeline`].
#[derive(Debug, Clone, Copy)]
pub struct Span {
    /// The key before `from`, and seconds from one to the other; `None` where the motion starts from rest.
    before: Option<(usize, f64)>,
    /// The key at this moment, or the last one before.
    pub from: usize,
    to: usize,
    /// The key after `to`, likewise.
    after: Option<(usize, f64)>,
    /// From `from` to `to`.
    seconds: f64,
    /// Part of them that has passed, in [0, 1).
    part: f64,
    smooth: bool,
}

impl Timeline {
    /// The moment `time`, seconds.
    pub fn at(&self, time: f64) -> Span {
        let times = &self.times;
        let last = times.len() - 1;
        let period = times[last] - times[0];
        let outside = !(times[0]..times[last]).contains(&time);
        let time = if self.repeat && outside { times[0] + (time - times[0]).rem_euclid(period) } else { time };
        let from = times.partition_point(|&key| key <= time).saturating_sub(1);
        if time < times[0] || from == last || self.interpolation == Interpolation::Step {
            return Span { before: None, from, to: from, after: None, seconds: 1.0, part: 0.0, smooth: false };
        }
        let seconds = |key: usize| times[key + 1] - times[key];
        // When played again, the key before the first is the last but one.
        let before = match from {
            0 => self.repeat.then(|| (last - 1, seconds(last - 1))),
            _ => Some((from - 1, seconds(from - 1))),
        };
        let after = match from + 1 {
            to if to == last => self.repeat.then(|| (1, seconds(0))),
            to => Some((to + 1, seconds(to))),
        };
        let part = (time - times[from]) / seconds(from);
        let smooth = self.interpolation == Interpolation::Smooth;
        Span { before, from, to: from + 1, after, seconds: seconds(from), part, smooth }
    }
}

impl Span {
    pub fn is_at_key(&self) -> bool {
        self.part == 0.0
    }

    /// The number at this moment, `value` being that of a key; exactly the key's at a key's time.
    pub fn number(&self, value: impl Fn(usize) -> f64) -> f64 {
        let (first, last) = (value(self.from), value(self.to));
        let rate = (last - first) / self.seconds;
        let t = self.part;
        if !self.smooth {
            return first + t * (last - first);
        }
        let start = self.before.map_or(0.0, |(key, s)| rate_at_key((first - value(key)) / s, s, rate, self.seconds));
        let end = self.after.map_or(0.0, |(key, s)| rate_at_key(rate, self.seconds, (value(key) - last) / s, s));
        let curve = t * (start + t * (3.0 * rate - 2.0 * start - end + t * (start + end - 2.0 * rate)));
        (first + self.seconds * curve).clamp(first.min(last), first.max(last))
    }

    /// Each coordinate by itself.
    pub fn vector(&self, value: impl Fn(usize) -> DVec3) -> DVec3 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.number(|key| value(key)[axis]));
        DVec3::new(x, y, z)
    }

    /// Turns by less than half a turn from key to key. A smooth turn is a cubic Bezier curve of rotations (Kim, Kim and Shin
    /// 1995); about an axis that stays, its angle is what [`Span::number`] gives.
    pub fn rotation(&self, value: impl Fn(usize) -> DQuat) -> DQuat {
        let (first, last) = (value(self.from), value(self.to));
        let whole = turn(first, last);
        let t = self.part;
        if !self.smooth {
            return first * DQuat::from_scaled_axis(t * whole);
        }
        let rate = whole / self.seconds;
        let both = |a: DVec3, s: f64, b: DVec3, r: f64| {
            DVec3::new(rate_at_key(a.x, s, b.x, r), rate_at_key(a.y, s, b.y, r), rate_at_key(a.z, s, b.z, r))
        };
        let start =
            self.before.map_or(DVec3::ZERO, |(key, s)| both(turn(value(key), first) / s, s, rate, self.seconds));
        let end = self.after.map_or(DVec3::ZERO, |(key, s)| both(rate, self.seconds, turn(last, value(key)) / s, s));
        let [start, end] = [start, end].map(|rate| rate * (self.seconds / 3.0));
        let middle = turn(first * DQuat::from_scaled_axis(start), last * DQuat::from_scaled_axis(-end));
        let rest = 1.0 - t;
        first
            * DQuat::from_scaled_axis((1.0 - rest * rest * rest) * start)
            * DQuat::from_scaled_axis(t * t * (3.0 - 2.0 * t) * middle)
            * DQuat::from_scaled_axis(t * t * t * end)
    }
}

/// The velocity at a key between `a` over the `s` seconds before it and `b` over the `r` seconds after it: 0 where they
/// differ in sign, else their weighted harmonic mean, at most three times the lesser, so that the cubics on both sides are
/// monotone (Fritsch and Butland 1984).
fn rate_at_key(a: f64, s: f64, b: f64, r: f64) -> f64 {
    if a * b <= 0.0 {
        return 0.0;
    }
    3.0 * (s + r) / ((s + 2.0 * r) / a + (2.0 * s + r) / b)
}

/// From `a` to `b` the short way, about axes fixed to the object: axis times angle in radians.
fn turn(a: DQuat, b: DQuat) -> DVec3 {
    let between = a.conjugate() * b;
    if between.w < 0.0 { (-between).to_scaled_axis() } else { between.to_scaled_axis() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: [f64; 5] = [-0.5, 0.3, 1.0, 3.0, 3.5];
    /// Gently down, then steeply: where a mean of both velocities would go beyond the second key.
    const VALUES: [f64; 5] = [2.0, 5.0, 4.9, 1.0, 2.0];

    fn timeline(interpolation: Interpolation, repeat: bool) -> Timeline {
        Timeline { times: TIMES.to_vec(), interpolation, repeat }
    }

    fn rotations(key: usize) -> DQuat {
        let [a, b] = [[0.3, 1.9, -0.4, 2.5, 0.3], [0.0, -1.0, 0.7, 1.0, 0.0]].map(|angles| angles[key]);
        DQuat::from_rotation_y(a) * DQuat::from_rotation_x(b)
    }

    #[test]
    fn keys_are_met_exactly_and_values_hold_outside() {
        for interpolation in [Interpolation::Smooth, Interpolation::Linear, Interpolation::Step] {
            let timeline = timeline(interpolation, false);
            let number = |time| timeline.at(time).number(|key| VALUES[key]);
            for (key, &time) in TIMES.iter().enumerate() {
                assert_eq!(number(time), VALUES[key], "{interpolation:?}");
                assert_eq!(timeline.at(time).rotation(rotations), rotations(key), "{interpolation:?}");
            }
            for (time, value) in [(-1e6, 2.0), (-0.51, 2.0), (3.51, 2.0), (f64::INFINITY, 2.0)] {
                assert_eq!(number(time), value);
            }
        }
    }

    #[test]
    fn linear_goes_straight_and_step_waits() {
        let at = |interpolation, time| timeline(interpolation, false).at(time).number(|key| VALUES[key]);
        assert!((at(Interpolation::Linear, 2.5) - 1.975).abs() < 1e-12);
        assert_eq!(at(Interpolation::Step, 2.999), 4.9);
    }

    #[test]
    fn smooth_has_continuous_velocity_and_stays_between_its_keys() {
        const STEP: f64 = 1e-5;
        // Second derivatives reach some 50, so velocities over a step either side of a key differ by STEP times that.
        const TOLERANCE: f64 = 2e-3;
        for repeat in [false, true] {
            let timeline = timeline(Interpolation::Smooth, repeat);
            let number = |time| timeline.at(time).number(|key| VALUES[key]);
            let turned = |time| timeline.at(time).rotation(rotations);
            for time in TIMES {
                let speeds = [time - STEP, time].map(|from| (number(from + STEP) - number(from)) / STEP);
                assert!((speeds[1] - speeds[0]).abs() < TOLERANCE, "{repeat} {time} {speeds:?}");
                let [before, after] = [time - STEP, time].map(|from| turn(turned(from), turned(from + STEP)) / STEP);
                assert!((after - before).length() < TOLERANCE, "{repeat} {time} {before} {after}");
            }
            // The third key is on a slope, and so is the seam of what repeats: the motion does not stop there.
            let speed = |time| (number(time + STEP) - number(time)) / STEP;
            assert!(speed(1.0) < -0.2 && (speed(-0.5) > 1.0) == repeat, "{} {}", speed(1.0), speed(-0.5));
            for k in 0..400_000 {
                let time = -0.5 + STEP * f64::from(k);
                let from = TIMES.partition_point(|&key| key <= time).saturating_sub(1).min(3);
                let (low, high) = (VALUES[from].min(VALUES[from + 1]), VALUES[from].max(VALUES[from + 1]));
                assert!((low..=high).contains(&number(time)), "{time}");
                assert!((speed(time) - speed(time - STEP)).abs() < TOLERANCE, "{time}");
            }
        }
    }

    #[test]
    fn what_repeats_is_the_same_a_period_later_and_earlier() {
        let timeline = timeline(Interpolation::Smooth, true);
        let number = |time| timeline.at(time).number(|key| VALUES[key]);
        for k in 0..40 {
            let time = -0.45 + 0.1 * f64::from(k);
            for periods in [-3.0, 1.0, 100.0] {
                assert!((number(time) - number(time + 4.0 * periods)).abs() < 1e-9, "{time}");
            }
        }
        assert_eq!((number(3.5), number(7.5)), (2.0, 2.0));
    }

    #[test]
    fn rotations_go_the_short_way() {
        for (from, to, middle) in [(350.0, 10.0, 0.0), (10.0, 350.0, 0.0), (0.0, 170.0, 85.0), (0.0, 190.0, -85.0)] {
            for interpolation in [Interpolation::Smooth, Interpolation::Linear] {
                let timeline = Timeline { times: vec![0.0, 2.0], interpolation, repeat: false };
                let about_y = |degrees: f64| DQuat::from_rotation_y(degrees.to_radians());
                // Minus a quaternion is the same rotation.
                for sign in [1.0, -1.0] {
                    let found = timeline.at(1.0).rotation(|key| [about_y(from), about_y(to) * sign][key]);
                    assert!(found.dot(about_y(middle)).abs() > 1.0 - 1e-12, "{from} {to} {interpolation:?}");
                }
            }
        }
    }

    #[test]
    fn an_angle_about_one_axis_moves_as_a_number_does() {
        let angles = [0.2, 1.1, 1.9, 0.4, -0.6];
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        let timeline = timeline(Interpolation::Smooth, false);
        for k in 0..80 {
            let span = timeline.at(-0.5 + 0.05 * f64::from(k));
            let found = span.rotation(|key| DQuat::from_axis_angle(axis, angles[key]));
            let expected = DQuat::from_axis_angle(axis, span.number(|key| angles[key]));
            assert!(turn(found, expected).length() < 1e-9, "{k}");
        }
    }
}
