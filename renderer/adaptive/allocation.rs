//! How many samples each pixel gets after the pilot.
//!
//! For a given budget the picture's squared error is least where a pixel's samples go by its standard deviation
//! (Neyman). Stratified samples of a smooth pixel or of a lone edge converge faster than that supposes, which would ask
//! for the variance to the power of 2/5; but most of a caustic's error comes from pixels in which light rises without
//! bound towards a fold, and on the pool's floor, 16 samples a pixel, 1/2 left 1.87 % of error, 2/5 2.08 %.
//!
//! **No bias.** A pixel's count must tell nothing of its own values: the mean of a number of samples that was chosen
//! because of what they showed is biased, and more so where spikes are rare. So pixels are divided like the fields of a
//! chessboard. Counts of white pixels follow from pilot samples of black ones alone, counts of black pixels from white
//! ones', each colour with its own half of the budget; and every pixel's samples come from a sequence of its own, so
//! that what a neighbour saw says nothing of where in the pixel samples fall. Whatever its count, the mean of all of a
//! pixel's samples, the pilot's included, is then unbiased.

use super::PixelPlan;

/// Pixels a count is decided from, as steps from the pixel, and their weights: those of the other colour within two
/// steps. In a simulation of the pool's floor, 16 samples a pixel, they left 7 to 9 % more error than all nine
/// pixels would with the pixel itself among them, and up to 7 % less than the nearest four.
const NEIGHBOURS: [(i64, i64, f64); 12] = [
    (1, 0, 1.0),
    (-1, 0, 1.0),
    (0, 1, 1.0),
    (0, -1, 1.0),
    (2, 1, 0.25),
    (2, -1, 0.25),
    (-2, 1, 0.25),
    (-2, -1, 0.25),
    (1, 2, 0.25),
    (1, -2, 0.25),
    (-1, 2, 0.25),
    (-1, -2, 0.25),
];

/// Of the variance, for counts; see the top.
const EXPONENT: f64 = 0.5;
/// Of the mean variance, what every pixel is taken to have at least: a pilot can miss a detail.
const LEAST_VARIANCE: f64 = 1e-3;
/// A pixel's samples over the mean number, at most: one invocation merges all that a pixel has in a round. 16 left 2.36 %
/// of error on the pool's floor where 64 and 256 left 1.87 %.
const MOST: f64 = 64.0;

/// Samples a pixel of the pilot, of `samples` a pixel in all: half, since what the pilot finds of rare spikes steers the
/// rest. On the pool's floor, 16 in all, a pilot of 4 left 1.87 % of error, of 6 1.72 %, of 8 1.69 %. Two are needed for
/// a variance.
pub fn pilot(samples: u32) -> u32 {
    (samples / 2).clamp(2, 32).min(samples)
}

/// Samples of each pixel after the pilot, `samples - pilot` a pixel in the mean, exactly, over each colour and so over
/// the picture. `squares`: sums of squared deviations from the mean of the pilot's radiance, row by row.
pub fn extra_samples(squares: &[f32], width: u32, pilot: u32, samples: u32) -> Vec<u32> {
    let width = i64::from(width);
    let rows = squares.len() as i64 / width.max(1);
    let variance: Vec<f64> =
        squares.iter().map(|&s| f64::from(s.min(f32::MAX)) / f64::from(pilot.max(2) - 1)).collect();
    let mut extra = vec![0; squares.len()];
    for colour in 0..2 {
        let of = |wanted: i64| (0..squares.len()).filter(move |&p| (p as i64 % width + p as i64 / width) % 2 == wanted);
        let others: Vec<f64> = of(1 - colour).map(|p| variance[p]).collect();
        let least = LEAST_VARIANCE * others.iter().sum::<f64>() / others.len().max(1) as f64;
        let weight = |pixel: usize| -> f64 {
            let (x, y) = (pixel as i64 % width, pixel as i64 / width);
            let (mut sum, mut weights) = (0.0, 0.0);
            for (dx, dy, weight) in NEIGHBOURS {
                let (x, y) = (x + dx, y + dy);
                if (0..width).contains(&x) && (0..rows).contains(&y) {
                    sum += weight * variance[(y * width + x) as usize];
                    weights += weight;
                }
            }
            (sum / f64::max(weights, 1.0) + least).powf(EXPONENT)
        };
        let own: Vec<usize> = of(colour).collect();
        let weights: Vec<f64> = own.iter().map(|&p| weight(p)).collect();
        for (pixel, count) in own.into_iter().zip(divide(&weights, pilot, samples)) {
            extra[pixel] = count;
        }
    }
    extra
}

/// Divides `samples - pilot` times the number of weights so that pilot and share together go by weight, as far as the
/// pilot is not too much already.
fn divide(weights: &[f64], pilot: u32, samples: u32) -> Vec<u32> {
    let budget = u64::from(samples - pilot) * weights.len() as u64;
    let (pilot, most) = (f64::from(pilot), MOST * f64::from(samples));
    let share = |weight: f64, scale: f64| (weight * scale - pilot).clamp(0.0, most);
    let total = |scale: f64| weights.iter().map(|&w| share(w, scale)).sum::<f64>();
    // Halving the logarithm's range a hundred times leaves nothing of it. Without any variance all share alike.
    let (mut low, mut high) = (1e-30f64, 1e30f64);
    for _ in 0..100 {
        let middle = (low * high).sqrt();
        if total(middle) < budget as f64 { low = middle } else { high = middle }
    }
    let mut shares: Vec<f64> = weights.iter().map(|&w| share(w, high)).collect();
    let mut sum = shares.iter().sum::<f64>();
    if sum <= 0.0 {
        shares.fill(1.0);
        sum = weights.len() as f64;
    }
    // Rounding the running sum instead of each share spends the budget to the last sample.
    let (mut running, mut spent) = (0.0, 0);
    let count = shares.len();
    let whole = shares.into_iter().enumerate().map(|(i, share)| {
        running += share * budget as f64 / sum;
        let until = if i + 1 == count { budget } else { (running.round() as u64).clamp(spent, budget) };
        let share = until - spent;
        spent = until;
        share as u32
    });
    whole.collect()
}

/// Where each pixel's samples stand in the line that rounds of `extra.len()` samples are taken from.
pub fn line(extra: &[u32]) -> Vec<PixelPlan> {
    let pixels = extra.len() as u64;
    let mut start = 0u64;
    let plans = extra.iter().map(|&count| {
        let end = start + u64::from(count);
        // The last sample's round, so that `last_place` is never 0 unless nothing is left to take.
        let last = if count > 0 { (end - 1) / pixels } else { start / pixels };
        let plan = PixelPlan {
            first_round: (start / pixels) as u32,
            first_place: (start % pixels) as u32,
            last_round: last as u32,
            last_place: (end - last * pixels) as u32,
        };
        start = end;
        plan
    });
    plans.collect()
}

/// Samples that a pixel has of the line after `rounds` rounds.
pub fn taken(plan: &PixelPlan, rounds: u32, pixels: u32) -> u32 {
    let place = |round: u32, place: u32| u64::from(round) * u64::from(pixels) + u64::from(place);
    let start = place(plan.first_round, plan.first_place);
    (place(rounds, 0).min(place(plan.last_round, plan.last_place)).saturating_sub(start)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: u32 = 31;
    const PIXELS: usize = 31 * 17;

    /// Sums of squares over six orders of magnitude, in no order.
    fn squares() -> Vec<f32> {
        (0..PIXELS as u32).map(|p| 10f32.powi((crate::random::mix_bits(p) % 7) as i32 - 3)).collect()
    }

    #[test]
    fn the_budget_is_spent_to_the_last_sample() {
        for squares in [squares(), vec![0.0; PIXELS], vec![f32::INFINITY; PIXELS], vec![1.0; 31], vec![1.0]] {
            for samples in [2, 3, 8, 64, 1000] {
                let pilot = pilot(samples);
                let extra = extra_samples(&squares, WIDTH.min(squares.len() as u32), pilot, samples);
                let sum = extra.iter().map(|&n| u64::from(n)).sum::<u64>();
                assert_eq!(sum, u64::from(samples - pilot) * squares.len() as u64, "{samples} samples");
            }
        }
    }

    #[test]
    fn a_pixels_count_does_not_depend_on_its_own_colour() {
        let before = extra_samples(&squares(), WIDTH, 4, 16);
        let mut changed = squares();
        let white = |p: usize| (p % WIDTH as usize + p / WIDTH as usize).is_multiple_of(2);
        changed.iter_mut().enumerate().filter(|(p, _)| white(*p)).for_each(|(_, s)| *s = 1.0 / *s);
        let after = extra_samples(&changed, WIDTH, 4, 16);
        assert!((0..PIXELS).filter(|&p| white(p)).all(|p| before[p] == after[p]), "white pixels kept their counts");
        assert!((0..PIXELS).any(|p| !white(p) && before[p] != after[p]), "black ones did not");
    }

    #[test]
    fn samples_go_where_the_variance_is() {
        // One column in the middle varies ten thousand times as much: counts near it are 10000^0.5 = 100 times as high.
        let squares: Vec<f32> = (0..PIXELS).map(|p| if p % 31 == 15 { 1e4 } else { 1.0 }).collect();
        let extra = extra_samples(&squares, WIDTH, 2, 16);
        let column = |x: usize| -> u32 { (0..17).map(|y| extra[y * 31 + x]).sum::<u32>() / 17 };
        assert!(column(15) > 5 * column(5).max(1), "{} against {}", column(15), column(5));
    }

    #[test]
    fn the_line_is_walked_once_without_gaps() {
        let extra = extra_samples(&squares(), WIDTH, 2, 12);
        let plans = line(&extra);
        let pixels = PIXELS as u32;
        for rounds in 0..=10 {
            let taken: u64 = plans.iter().map(|p| u64::from(taken(p, rounds, pixels))).sum();
            assert_eq!(taken, u64::from(rounds) * u64::from(pixels), "after {rounds} rounds");
        }
        // What the kernels read from a plan: places of each round, each held by one pixel.
        for round in 0..10 {
            let mut held = vec![0; PIXELS];
            for plan in plans.iter().filter(|p| (p.first_round..=p.last_round).contains(&round)) {
                let from = if round == plan.first_round { plan.first_place } else { 0 };
                let to = if round == plan.last_round { plan.last_place } else { pixels };
                (from..to).for_each(|place| held[place as usize] += 1);
            }
            assert!(held.iter().all(|&n| n == 1), "round {round}");
        }
    }
}
