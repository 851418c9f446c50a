//! A bitmap over part of a chart, and its bits merged into cells.

use std::ops::Range;

use glam::DVec2;

/// Bisections for the number of cells; the coarseness is then known to a part in a thousand.
const BISECTIONS: u32 = 14;

/// In (u, v) coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Rectangle {
    pub lower: DVec2,
    pub upper: DVec2,
}

impl Rectangle {
    pub const EMPTY: Rectangle = Rectangle { lower: DVec2::INFINITY, upper: DVec2::NEG_INFINITY };

    pub fn include(&mut self, point: DVec2) {
        self.lower = self.lower.min(point);
        self.upper = self.upper.max(point);
    }

    pub fn is_empty(&self) -> bool {
        self.lower.x > self.upper.x
    }

    /// By `margin` on all sides, but not past +-`limit`.
    pub fn widened(self, margin: f64, limit: Option<f64>) -> Rectangle {
        let limit = DVec2::splat(limit.unwrap_or(f64::INFINITY));
        Rectangle { lower: (self.lower - margin).max(-limit), upper: (self.upper + margin).min(limit) }
    }

    pub fn extent(&self) -> DVec2 {
        self.upper - self.lower
    }
}

/// One bit for each of `columns` x `rows` equal fine cells.
pub struct Grid {
    /// As in [`EmissionCell`](super::EmissionCell).
    pub face: usize,
    area: Rectangle,
    /// Size of a fine cell.
    step: DVec2,
    columns: usize,
    rows: usize,
    /// A row starts at a word.
    words_per_row: usize,
    bits: Vec<u64>,
}

impl Grid {
    /// All clear; `step` is about the side of a fine cell. The area must not be empty.
    pub fn new(face: usize, area: Rectangle, step: f64) -> Self {
        let count = (area.extent() / step).ceil().max(DVec2::ONE);
        let (columns, rows) = (count.x as usize, count.y as usize);
        let words_per_row = columns.div_ceil(64);
        Grid {
            face,
            area,
            step: area.extent() / count,
            columns,
            rows,
            words_per_row,
            bits: vec![0; words_per_row * rows],
        }
    }

    /// Sets the fine cells that a convex polygon, widened by `margin` along u and v, has a part in.
    ///
    /// What a row of cells cuts out of a convex polygon is convex: the cells that it meets are those between its
    /// least and its greatest u.
    pub fn mark(&mut self, polygon: &[DVec2], margin: f64) {
        let mut around = Rectangle::EMPTY;
        polygon.iter().for_each(|&point| around.include(point));
        let around = around.widened(margin, None);
        let rows = cells_between(around.lower.y, around.upper.y, self.area.lower.y, self.step.y, self.rows);
        for row in rows {
            let low = self.area.lower.y + row as f64 * self.step.y;
            if let Some([left, right]) = span(polygon, low - margin, low + self.step.y + margin) {
                let columns =
                    cells_between(left - margin, right + margin, self.area.lower.x, self.step.x, self.columns);
                let first = row * self.words_per_row;
                for (word, mask) in masks(columns) {
                    self.bits[first + word] |= mask;
                }
            }
        }
    }

    /// The blocks of about `coarseness` by `coarseness` fine cells with a set one, along a Hilbert curve.
    pub fn blocks_in_order(&self, coarseness: f64) -> Vec<Rectangle> {
        let [columns, rows] = self.blocks_a_side(coarseness);
        let order = columns.max(rows).next_power_of_two().trailing_zeros();
        let mut blocks = Vec::new();
        self.for_each_block(coarseness, |column, row| {
            let corner = |column: usize, row: usize| {
                let fine = DVec2::new((column * self.columns / columns) as f64, (row * self.rows / rows) as f64);
                let fraction = fine / DVec2::new(self.columns as f64, self.rows as f64);
                // Not lower + fraction * extent: its rounding could end short of a face's border.
                self.area.lower * (1.0 - fraction) + self.area.upper * fraction
            };
            let block = Rectangle { lower: corner(column, row), upper: corner(column + 1, row + 1) };
            blocks.push((hilbert(order, column as u64, row as u64), block));
        });
        blocks.sort_unstable_by_key(|&(key, _)| key);
        blocks.into_iter().map(|(_, block)| block).collect()
    }

    fn blocks_a_side(&self, coarseness: f64) -> [usize; 2] {
        [self.columns, self.rows].map(|fine| ((fine as f64 / coarseness).round() as usize).clamp(1, fine))
    }

    fn for_each_block(&self, coarseness: f64, mut visit: impl FnMut(usize, usize)) {
        let [columns, rows] = self.blocks_a_side(coarseness);
        let mut merged = vec![0; self.words_per_row];
        for row in 0..rows {
            merged.fill(0);
            for fine in row * self.rows / rows..(row + 1) * self.rows / rows {
                let line = &self.bits[fine * self.words_per_row..][..self.words_per_row];
                merged.iter_mut().zip(line).for_each(|(merged, word)| *merged |= word);
            }
            for column in 0..columns {
                let fine = column * self.columns / columns..(column + 1) * self.columns / columns;
                if masks(fine).any(|(word, mask)| merged[word] & mask != 0) {
                    visit(column, row);
                }
            }
        }
    }
}

/// How many fine cells a side of a block takes for the blocks of all `grids` to be about `target`; at least 1.
pub fn coarseness(grids: &[Grid], target: f64) -> f64 {
    let longest = grids.iter().map(|grid| grid.columns.max(grid.rows)).max().unwrap_or(1);
    let (mut finest, mut coarsest) = (1.0_f64, longest as f64);
    let (mut best, mut best_ratio) = (coarsest, f64::INFINITY);
    for _ in 0..BISECTIONS {
        let middle = (finest * coarsest).sqrt();
        let mut count = 0.0_f64;
        grids.iter().for_each(|grid| grid.for_each_block(middle, |_, _| count += 1.0));
        let ratio = (count / target).max(target / count);
        if ratio < best_ratio {
            (best, best_ratio) = (middle, ratio);
        }
        *(if count > target { &mut finest } else { &mut coarsest }) = middle;
    }
    best
}

/// Indices of the cells that [low, high] touches, of `count` that start at `origin`; at least one.
fn cells_between(low: f64, high: f64, origin: f64, step: f64, count: usize) -> Range<usize> {
    // A cast to an unsigned type clamps to 0 from below.
    let [first, last] = [low, high].map(|at| (((at - origin) / step) as usize).min(count - 1));
    first..last + 1
}

/// Words and the bits in them that make up a range of bits.
fn masks(bits: Range<usize>) -> impl Iterator<Item = (usize, u64)> {
    let last = bits.end - 1;
    (bits.start / 64..=last / 64).map(move |word| {
        let from = if word == bits.start / 64 { u64::MAX << (bits.start % 64) } else { u64::MAX };
        let to = if word == last / 64 { u64::MAX >> (63 - last % 64) } else { u64::MAX };
        (word, from & to)
    })
}

/// Least and greatest u of a polygon's part with v in [low, high].
fn span(polygon: &[DVec2], low: f64, high: f64) -> Option<[f64; 2]> {
    let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut from = *polygon.last()?;
    for &to in polygon {
        if from.y.min(to.y) <= high && from.y.max(to.y) >= low {
            for (end, other) in [(from, to), (to, from)] {
                let v = end.y.clamp(low, high);
                let t = if v == end.y { 0.0 } else { (v - end.y) / (other.y - end.y) };
                let u = end.x + t * (other.x - end.x);
                least = least.min(u);
                greatest = greatest.max(u);
            }
        }
        from = to;
    }
    (least <= greatest).then_some([least, greatest])
}

/// How far along the Hilbert curve through 2^order by 2^order cells a cell is.
///
/// From the largest quadrant down: its number on the curve, then the cell as seen from the quadrant, whose curve is a
/// copy turned so that it starts next to the end of the one before.
fn hilbert(order: u32, x: u64, y: u64) -> u64 {
    let (mut x, mut y, mut distance) = (x, y, 0);
    for bit in (0..order).rev() {
        let (right, top) = (x >> bit & 1, y >> bit & 1);
        distance = distance << 2 | ((3 * right) ^ top);
        let mask = (1 << bit) - 1;
        (x, y) = (x & mask, y & mask);
        if top == 0 {
            (x, y) = if right == 1 { (mask - y, mask - x) } else { (y, x) };
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hilbert_curve_visits_every_cell_without_a_jump() {
        let order = 4;
        let side = 1 << order;
        let mut cells = vec![None; side * side];
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            assert!(cells[hilbert(order, x as u64, y as u64) as usize].replace((x, y)).is_none());
        }
        for pair in cells.windows(2) {
            let ((x, y), (next_x, next_y)) = (pair[0].unwrap(), pair[1].unwrap());
            assert_eq!(x.abs_diff(next_x) + y.abs_diff(next_y), 1);
        }
    }

    #[test]
    fn a_polygon_marks_the_cells_that_it_overlaps_and_no_other() {
        let area = Rectangle { lower: DVec2::ZERO, upper: DVec2::new(70.0, 3.0) };
        let mut triangle = [DVec2::new(0.5, 0.5), DVec2::new(66.5, 0.5), DVec2::new(0.5, 2.5)];
        for _winding in 0..2 {
            let mut grid = Grid::new(0, area, 1.0);
            grid.mark(&triangle, 1e-9);
            let mut marked = [0; 3];
            grid.for_each_block(1.0, |_, row| marked[row] += 1);
            // The slanted side is at u = 50 where v = 1 and at u = 17 where v = 2; widened, it takes the cell beyond.
            assert_eq!(marked, [67, 51, 18]);
            triangle.reverse();
        }
    }
}
