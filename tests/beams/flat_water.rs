//! The light under flat water in beams.

use glam::{DVec3, dvec3};
use nephroid::technique::beams::beam::Beam;

use super::{Edge, beam};

/// Refracts the lamp of `flat_water.toml` at the water above (x, z): the edge from there to the floor at y = -2.
fn refracted_edge(x: f64, z: f64) -> (Edge, f64) {
    let lamp = dvec3(1.5, 6.0, -1.0);
    let ray = |x: f64, z: f64| {
        let start = dvec3(x, 0.0, z);
        let before = (start - lamp).normalize();
        let across = dvec3(before.x, 0.0, before.z) / 1.33;
        (start, across - DVec3::Y * (1.0 - across.length_squared()).sqrt())
    };
    let transmitted = {
        let (start, way) = ray(x, z);
        let (c1, c2) = (-(start - lamp).normalize().y, -way.y);
        let perpendicular = ((c1 - 1.33 * c2) / (c1 + 1.33 * c2)).powi(2);
        let parallel = ((1.33 * c1 - c2) / (1.33 * c1 + c2)).powi(2);
        1.0 - 0.5 * (perpendicular + parallel)
    };
    let flux_through = {
        // 100 W/sr through a square metre of the water here.
        let way = dvec3(x, 0.0, z) - lamp;
        100.0 * 6.0 / way.length().powi(3) * transmitted
    };
    let (start, way) = ray(x, z);
    // What a square of the water spreads out to, across the way; quadratic in the length, so three lengths tell it.
    let small = 1e-3;
    let area = |l: f64| {
        let at = |dx: f64, dz: f64| {
            let (s, w) = ray(x + dx, z + dz);
            s + w * ((start + way * l - s).dot(way) / w.dot(way))
        };
        let (u, v) = (at(small, 0.0) - at(-small, 0.0), at(0.0, -small) - at(0.0, small));
        u.cross(v).dot(way).abs() / (4.0 * small * small)
    };
    let (a0, a1, a2) = (area(0.0), area(1.0), area(2.0));
    let square = 0.5 * (a2 - 2.0 * a1 + a0);
    let edge = Edge { start, way, length: 2.0 / -way.y, area: [a0, a1 - a0 - square, square], flux: flux_through };
    (edge, flux_through)
}

/// Beams through a grid of `cells` x `cells` squares of the water.
pub fn flat_water_beams(cells: u32) -> Vec<Beam> {
    let at = |i: u32| -5.0 + 10.0 * f64::from(i) / f64::from(cells);
    let side = 10.0 / f64::from(cells);
    let mut all = Vec::new();
    // In squares of 4 x 4, so that beams that follow each other are near each other.
    let squares = cells.div_ceil(4);
    for square in 0..squares * squares {
        for cell in 0..16 {
            let (row, column) = (square / squares * 4 + cell / 4, square % squares * 4 + cell % 4);
            if row >= cells || column >= cells {
                continue;
            }
            let corner = |dx: u32, dz: u32| refracted_edge(at(column + dx), at(row + dz));
            let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
            for three in [[a, b, c], [a, c, d]] {
                // The flux over a triangle, by the mean of its corners.
                let flux = three.iter().map(|(_, flux)| flux).sum::<f64>() / 3.0 * 0.5 * side * side;
                all.push(beam(three.map(|(edge, _)| edge), flux, 1));
            }
        }
    }
    all
}
