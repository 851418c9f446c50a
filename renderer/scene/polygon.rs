//! Cutting a flat polygon, convex or not, into triangles.

use glam::{DVec2, DVec3};

/// Triangles, as places in `corners`, that cover the polygon and face as it does; always two fewer than corners.
///
/// Ears are cut off in order, which makes a fan of a convex polygon. Where a crooked polygon leaves no ear, the rest
/// becomes a fan.
pub fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    let flat = flatten(corners);
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len().saturating_sub(2));
    while left.len() > 3 {
        let Some(ear) = (1..=left.len()).map(|k| k % left.len()).find(|&k| is_ear(&flat, &left, k)) else {
            break;
        };
        triangles.push(around(&left, ear));
        left.remove(ear);
    }
    triangles.extend((2..left.len()).map(|k| [left[0], left[k - 1], left[k]]));
    triangles
}

/// The corners in the polygon's own plane, counter-clockwise: Newell's normal holds for polygons of any form.
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    let first = corners.first().copied().unwrap_or_default();
    let next = corners.iter().cycle().skip(1);
    let normal: DVec3 = corners.iter().zip(next).map(|(&a, &b)| (a - first).cross(b - first)).sum();
    let (across, along) = normal.try_normalize().unwrap_or(DVec3::Y).any_orthonormal_pair();
    corners.iter().map(|&corner| DVec2::new((corner - first).dot(across), (corner - first).dot(along))).collect()
}

fn around(left: &[usize], k: usize) -> [usize; 3] {
    let count = left.len();
    [left[(k + count - 1) % count], left[k], left[(k + 1) % count]]
}

/// Whether the corner is convex and its triangle holds no other corner.
fn is_ear(flat: &[DVec2], left: &[usize], k: usize) -> bool {
    let ear = around(left, k);
    let [a, b, c] = ear.map(|corner| flat[corner]);
    let side = |from: DVec2, to: DVec2, point: DVec2| (to - from).perp_dot(point - from);
    if side(a, b, c) <= 0.0 {
        return false;
    }
    let inside = |point: DVec2| side(a, b, point) >= 0.0 && side(b, c, point) >= 0.0 && side(c, a, point) >= 0.0;
    let others = left.iter().filter(|corner| !ear.contains(corner));
    !others.map(|&corner| flat[corner]).any(|point| point != a && point != c && inside(point))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3], triangles: &[[usize; 3]]) -> DVec3 {
        let each = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]) / 2.0;
        triangles.iter().map(each).sum()
    }

    #[test]
    fn a_square_becomes_the_fan_of_its_first_corner() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        assert_eq!(triangulate(&square), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn an_arrowhead_is_covered_once_and_faces_as_before() {
        // The first corner is reflex: most fans would leave the polygon.
        let corners = [[0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.0, 3.0, 0.0], [-2.0, -1.0, 0.0]].map(DVec3::from_array);
        for first in 0..4 {
            let turned: Vec<DVec3> = corners.iter().cycle().skip(first).take(4).copied().collect();
            let triangles = triangulate(&turned);
            assert_eq!(triangles.len(), 2);
            let sum: f64 = triangles.iter().map(|t| area(&turned, &[*t]).length()).sum();
            // Half of base 4 by height 4, less the notch of base 4 by height 1.
            assert!((sum - 6.0).abs() < 1e-12, "{first}: {sum}");
            assert!((area(&turned, &triangles) - DVec3::new(0.0, 0.0, 6.0)).length() < 1e-12, "{first}");
        }
    }
}
