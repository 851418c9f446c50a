//! The oracle of refracted paths, held against what is known without it: errata's figures, closed forms, finite
//! differences, symmetries, a search by many starts, and the degree of the refracted map.

mod oracle;

use glam::{Affine3A, DMat2, DVec2, DVec3, Vec3};
use nephroid::scene::shapes;
use nephroid::scene::{Emitter, Instance, load};
use oracle::meshes::{self, AIR, Random, WATER};
use oracle::{
    Light, Patch, Path, Query, Surface, all_paths, finite_difference, fresnel_transmittance, on_start_curve, refract,
};

/// Newton's residual over the triangle's size; a root near a fold is worse by one over its R.
const SAME_ROOT: f64 = 1e-7;
/// Central differences over 1e-5 of a triangle leave 1e-10 by truncation and as much by rounding, times how strongly
/// the normals turn.
const DIFFERENCES: f64 = 1e-5;
/// Closed forms agree to rounding.
const EXACT: f64 = 1e-9;

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs();
    assert!(error < tolerance, "{what}: {found}, but {expected} is known: off by {error:.1e} of it");
}

/// The configuration above the errata.
fn known_triangle() -> (Surface, Query) {
    let positions = [DVec3::ZERO, DVec3::new(1.0, 0.03, 0.1), DVec3::new(0.2, -0.02, 1.0)];
    let normals = [DVec3::new(0.05, 1.0, -0.03), DVec3::new(-0.06, 1.0, 0.02), DVec3::new(0.02, 1.0, 0.07)];
    let surface = Surface::new(positions.into(), normals.map(DVec3::normalize).into(), vec![[0, 1, 2]]);
    let light = Light::Point(DVec3::new(0.9, 5.0, 0.8));
    (surface, Query { point: DVec3::new(0.4, -1.5, 0.3), point_index: WATER, light, light_index: AIR })
}

/// One of each kind, small.
fn surfaces(seed: u64) -> Vec<(&'static str, Surface)> {
    vec![
        ("waves", Surface::of_mesh(&meshes::height_field(seed, 24, 2.0, 0.5))),
        ("steep waves", Surface::of_mesh(&meshes::height_field(seed + 1, 24, 2.0, 1.2))),
        ("waves on a tube", Surface::of_mesh(&meshes::curved_patch(seed, 16, 0.8))),
        ("ball", Surface::of_mesh(&meshes::sphere(24))),
        ("lumpy ball", Surface::of_mesh(&meshes::lumpy_sphere(seed, 32, 1.5))),
        ("triangle", Surface::of_mesh(&meshes::triangle(seed, 0.3))),
        ("wild triangle", Surface::of_mesh(&meshes::triangle(seed + 1, 1.5))),
    ]
}

/// Runs `check` on queries of every kind of surface.
fn each(seed: u64, count: usize, mut check: impl FnMut(&str, &Surface, &Query)) {
    for (name, surface) in surfaces(seed) {
        meshes::queries(seed, &surface, count).iter().for_each(|query| check(name, &surface, query));
    }
}

fn at(path: &Path) -> DVec2 {
    path.barycentrics.into()
}

#[test]
fn the_known_configuration_has_its_known_path() {
    let (surface, query) = known_triangle();
    let paths = all_paths(&surface, &query);
    assert_eq!(paths.len(), 1, "{paths:?}");
    let path = paths[0];
    let known = DVec2::new(0.41839048, 0.35856096);
    assert!(at(&path).distance(known) < 1e-8, "{path:?}");
    close(path.r, 38.239403171, 1e-9, "R");
    let patch = surface.patch(0);
    let d = oracle::point_side(&patch, &query, at(&path)).unwrap().abs();
    close(d, 67.602621222, 1e-9, "D");
    let n = patch.normal(at(&path)).normalize();
    let asymmetry = path.to_point.dot(n) * path.to_light.dot(patch.geometric)
        / (path.to_point.dot(patch.geometric) * path.to_light.dot(n));
    close(d, path.r * (WATER / AIR).powi(2) * asymmetry, EXACT, "D from R by reciprocity");
}

#[test]
fn flat_water_has_its_closed_form() {
    let random = &mut Random::new(1);
    let surface = Surface::of_mesh(&shapes::plane("flat", DVec3::ZERO, DVec2::splat(20.0), [7, 5]));
    for _ in 0..200 {
        let [height, depth] = [random.between(0.5, 6.0), random.between(0.1, 3.0)];
        let angle = random.between(0.0, 0.9);
        let (sin, cos) = angle.sin_cos();
        let below = (sin / WATER).asin();
        let (sin_turn, cos_turn) = random.between(0.0, 6.3).sin_cos();
        let outward = DVec3::new(cos_turn, 0.0, sin_turn);
        let light = DVec3::new(random.between(-1.0, 1.0), height, random.between(-1.0, 1.0));
        let away = height * angle.tan() + depth * below.tan();
        let point = light + away * outward - (height + depth) * DVec3::Y;
        let crossing = light + height * (angle.tan() * outward - DVec3::Y);

        let lamp = Query { point, point_index: WATER, light: Light::Point(light), light_index: AIR };
        let paths = all_paths(&surface, &lamp);
        assert_eq!(paths.len(), 1, "{lamp:?} {paths:?}");
        assert!(paths[0].point.distance(crossing) < EXACT, "{} for {crossing}", paths[0].point);
        let stretch = height / (cos * cos) + depth * cos / (WATER * below.cos().powi(3));
        close(paths[0].r, away / sin * stretch * below.cos(), EXACT, "R under flat water");
        assert_eq!(paths[0].orientation, 1.0);

        let sun = Query { light: Light::Directional((crossing - light).normalize()), ..lamp };
        let paths = all_paths(&surface, &sun);
        assert_eq!(paths.len(), 1, "{sun:?} {paths:?}");
        close(paths[0].r, below.cos() / cos, EXACT, "R of the sun under flat water");
    }
}

#[test]
fn straight_below_a_lamp_r_is_the_square_of_the_reduced_distance() {
    let surface = Surface::of_mesh(&shapes::plane("flat", DVec3::ZERO, DVec2::splat(3.0), [4, 4]));
    let light = Light::Point(DVec3::new(0.1, 3.0, 0.2));
    let query = Query { point: DVec3::new(0.1, -2.0, 0.2), point_index: WATER, light, light_index: AIR };
    let paths = all_paths(&surface, &query);
    assert_eq!(paths.len(), 1);
    close(paths[0].r, (3.0 + 2.0 / WATER).powi(2), EXACT, "R");
    close(paths[0].transmittance, 4.0 * WATER / (WATER + 1.0).powi(2), EXACT, "transmittance");
}

/// Brewster: nothing of one polarisation is reflected where both directions are at right angles. Stokes: both ways alike.
#[test]
fn transmittance_is_fresnels() {
    let brewster = (WATER / AIR).atan();
    let other = 1.0 - 0.5 * ((WATER.powi(2) - 1.0) / (WATER.powi(2) + 1.0)).powi(2);
    close(fresnel_transmittance(brewster.cos(), AIR / WATER), other, EXACT, "at Brewster's angle");
    close(fresnel_transmittance(brewster.sin(), WATER / AIR), other, EXACT, "at Brewster's angle from below");
    assert_eq!(fresnel_transmittance(0.6, WATER / AIR), 0.0, "beyond the critical angle");
}

#[test]
fn every_path_obeys_snell() {
    each(2, 60, |name, surface, query| {
        for path in all_paths(surface, query) {
            let n = surface.patch(path.triangle).normal(at(&path)).normalize();
            let out = refract(-path.to_light, n, query.light_index / query.point_index).unwrap();
            assert!(out.distance(path.to_point) < 1e-9, "{name}: {path:?} for {query:?}");
        }
    });
}

#[test]
fn r_is_what_finite_differences_give() {
    let mut compared = 0;
    each(3, 60, |name, surface, query| {
        for path in all_paths(surface, query) {
            let patch = surface.patch(path.triangle);
            let reach = if path.light_leg.is_finite() { path.light_leg } else { 1.0 };
            let size = patch.edges[0].length().min(patch.edges[1].length());
            let slant = path.to_light.dot(patch.geometric).abs();
            // The footprint of the step is 1e-5 of the triangle's size.
            let step = 1e-5 * size * slant / reach;
            let Some(difference) = finite_difference(&patch, query, at(&path), step) else { continue };
            // R passes through zero at a focus; an error is held against what R is made of.
            let whole = reach * reach + path.point_leg * path.point_leg / slant;
            let error = (difference - path.orientation * path.r).abs();
            assert!(error < DIFFERENCES * whole.max(path.r), "{name}: {difference} for {path:?} of {query:?}");
            compared += 1;
        }
    });
    assert!(compared > 200, "{compared} paths compared");
}

#[test]
fn planted_paths_are_found() {
    for (name, surface) in surfaces(4) {
        let random = &mut Random::new(4);
        for _ in 0..150 {
            let planted = meshes::planted(random, &surface);
            let place = surface.patch(planted.triangle).position(planted.barycentrics);
            let nearest =
                all_paths(&surface, &planted.query).iter().map(|p| p.point.distance(place)).fold(f64::MAX, f64::min);
            assert!(nearest < SAME_ROOT, "{name}: {nearest} m from {place}, triangle {}", planted.triangle);
        }
    }
}

#[test]
fn a_path_through_an_edge_or_a_corner_is_found_once() {
    let surface = Surface::of_mesh(&meshes::height_field(8, 16, 2.0, 0.5));
    let random = &mut Random::new(8);
    let mut asked = 0;
    for _ in 0..600 {
        let along = if random.below(3) == 0 { 0.0 } else { random.unit() };
        let place = [DVec2::new(along, 0.0), DVec2::new(0.0, along), DVec2::new(along, 1.0 - along)][random.below(3)];
        let triangle = random.below(surface.triangles.len());
        let Some(query) = meshes::planted_at(random, &surface, triangle, place) else { continue };
        let crossing = surface.patch(triangle).position(place);
        let paths = all_paths(&surface, &query);
        let here = paths.iter().filter(|path| path.point.distance(crossing) < SAME_ROOT).count();
        assert_eq!(here, 1, "{place} of triangle {triangle}: {paths:?}");
        asked += 1;
    }
    assert!(asked > 400, "{asked} paths asked for");
}

/// By a turn, a mirroring and a factor of two, all exact in f32: lengths double, R of a lamp is four times as large.
#[test]
fn a_placed_surface_has_the_placed_paths() {
    let mesh = meshes::height_field(9, 24, 2.0, 0.5);
    let surface = Surface::of_mesh(&mesh);
    for mirrored in [-2.0, 2.0] {
        let columns = [Vec3::Z * 2.0, Vec3::X * 2.0, Vec3::Y * mirrored];
        let shift = Vec3::new(1.0, -2.0, 0.5);
        let transform = Affine3A::from_cols(columns[0].into(), columns[1].into(), columns[2].into(), shift.into());
        let [x, y, z] = columns.map(|column| column.as_dvec3());
        let put = |p: DVec3| p.x * x + p.y * y + p.z * z + shift.as_dvec3();
        let instance = Instance { name: String::new(), mesh: 0, material: 0, transform };
        let placed = Surface::of_instance(&mesh, &instance);
        for query in meshes::queries(9, &surface, 100) {
            let Light::Point(light) = query.light else { continue };
            let moved = Query { point: put(query.point), light: Light::Point(put(light)), ..query };
            let (paths, others) = (all_paths(&surface, &query), all_paths(&placed, &moved));
            assert_eq!(paths.len(), others.len(), "{query:?}");
            for path in &paths {
                let distance = |other: &&Path| other.point.distance(put(path.point));
                let other = others.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
                assert!(distance(&other) < SAME_ROOT, "{path:?} {other:?}");
                assert!((other.r - 4.0 * path.r).abs() < 1e-6 * (path.light_leg + path.point_leg).powi(2));
                assert!(other.light_in_front == path.light_in_front && other.orientation == path.orientation);
            }
        }
    }
}

#[test]
fn paths_do_not_depend_on_the_direction_of_light() {
    each(5, 40, |name, surface, query| {
        if let Light::Point(_) = query.light {
            let reversed = query.reversed();
            assert_same(name, query, &all_paths(surface, query), &all_paths(surface, &reversed));
        }
    });
}

#[test]
fn cutting_triangles_changes_no_path() {
    for (name, surface) in surfaces(6) {
        let refined = surface.refined();
        for query in meshes::queries(6, &surface, 40) {
            assert_same(name, &query, &all_paths(&surface, &query), &all_paths(&refined, &query));
        }
    }
}

fn assert_same(name: &str, query: &Query, first: &[Path], second: &[Path]) {
    let near = |path: &Path, others: &[Path]| others.iter().any(|other| other.point.distance(path.point) < SAME_ROOT);
    let same = first.len() == second.len() && first.iter().all(|path| near(path, second));
    assert!(same, "{name}, {query:?}: {first:?} and {second:?}");
}

/// Newton's method on another equation, with differences for derivatives, from a grid of starts.
fn search(patch: &Patch, query: &Query) -> Vec<DVec2> {
    const STARTS: u32 = 16;
    let miss = |at: DVec2| {
        let place = patch.position(at);
        let out = refract(-query.toward_light(place).0, patch.normal(at).normalize(), AIR / WATER)?;
        let side = query.toward_point(place).0.any_orthonormal_vector();
        let other = query.toward_point(place).0.cross(side);
        Some((DVec2::new(out.dot(side), out.dot(other)), out, [side, other]))
    };
    let newton = |start: DVec2| {
        let mut at = start;
        for _ in 0..40 {
            let (value, _, sides) = miss(at)?;
            let seen = |at: DVec2| {
                let (_, out, _) = miss(at)?;
                let gap = out - query.toward_point(patch.position(at)).0;
                Some(DVec2::new(gap.dot(sides[0]), gap.dot(sides[1])))
            };
            let slope = |step: DVec2| Some((seen(at + step)? - seen(at - step)?) / 2e-6);
            let slope = DMat2::from_cols(slope(DVec2::new(1e-6, 0.0))?, slope(DVec2::new(0.0, 1e-6))?);
            let step = slope.inverse() * value;
            at -= step * (0.3 / step.length()).min(1.0);
            if step.length() < 1e-12 {
                break;
            }
        }
        let (value, out, _) = miss(at)?;
        let place = patch.position(at);
        let through = out.dot(patch.geometric) * query.toward_light(place).0.dot(patch.geometric) < -1e-9;
        let inside = at.min_element() >= 0.0 && at.x + at.y <= 1.0;
        let forward = out.dot(query.toward_point(place).0) > 0.0;
        (value.length() < 1e-9 && inside && forward && through).then_some(at)
    };
    let starts = (0..STARTS).flat_map(|i| (0..STARTS - i).map(move |j| (i, j)));
    let mut found: Vec<DVec2> = Vec::new();
    for (i, j) in starts {
        let start = (DVec2::new(f64::from(i), f64::from(j)) + 0.3) / f64::from(STARTS);
        if let Some(at) = newton(start)
            && found.iter().all(|other| other.distance(at) > 1e-6)
        {
            found.push(at);
        }
    }
    found
}

#[test]
fn a_search_from_many_starts_finds_nothing_more() {
    let (mut proven, mut searched, mut most) = (0, 0, 0);
    for seed in 0..60 {
        let surface = Surface::of_mesh(&meshes::triangle(seed, 1.5));
        for query in meshes::queries(seed, &surface, 20) {
            let paths = all_paths(&surface, &query);
            let found = search(&surface.patch(0), &query);
            for root in &found {
                let nearest = paths.iter().map(|path| at(path).distance(*root)).fold(f64::MAX, f64::min);
                assert!(nearest < 1e-5, "triangle {seed}: {root} is not among {paths:?} for {query:?}");
            }
            proven += paths.len();
            searched += found.len();
            most = most.max(paths.len());
        }
    }
    println!("{proven} paths, {searched} of them from many starts, {most} at most in one triangle");
    // Both find all that there is, apart from roots whose basins lie between the starts.
    assert!(searched * 100 > proven * 98 && most >= 2, "{proven} paths, {searched} searched, {most} at most");
}

#[test]
fn pairs_of_roots_next_to_a_fold_are_told_apart() {
    let mut closest: f64 = 1.0;
    let mut folds = 0;
    for seed in 0..200 {
        let random = &mut Random::new(seed);
        let surface = Surface::of_mesh(&meshes::triangle(seed, 1.5));
        let Some((point, light)) = focus(&surface.patch(0), random) else { continue };
        let across = random.direction();
        let query = |point| Query { point, point_index: WATER, light: Light::Point(light), light_index: AIR };
        folds += 1;
        for exponent in 5..9 {
            let step = 10f64.powi(-exponent) * across;
            let [before, behind] = [point - step, point + step].map(|point| all_paths(&surface, &query(point)));
            assert_eq!(before.len().abs_diff(behind.len()), 2, "triangle {seed}, step {step}: {before:?} {behind:?}");
            let many = if before.len() > behind.len() { &before } else { &behind };
            let turns: f64 = many.iter().map(|path| path.orientation).sum();
            assert!(turns.abs() < many.len() as f64, "a pair has one root of each orientation: {many:?}");
            for (i, first) in many.iter().enumerate() {
                closest = many[..i].iter().map(|path| at(path).distance(at(first))).fold(closest, f64::min);
            }
        }
    }
    println!("{folds} folds, pairs as close as {closest:.1e} of an edge");
    assert!(folds > 20 && closest < 1e-4, "{folds} folds, pairs as close as {closest}");
}

/// Where light through the middle of a triangle comes to a focus.
fn focus(patch: &Patch, random: &mut Random) -> Option<(DVec3, DVec3)> {
    let middle = DVec2::new(random.between(0.3, 0.36), random.between(0.3, 0.36));
    let crossing = patch.position(middle);
    let light = crossing + 3.0 * (patch.geometric + 0.3 * random.direction());
    let out = refract((crossing - light).normalize(), patch.normal(middle).normalize(), AIR / WATER)?;
    let query = |depth: f64| Query {
        point: crossing + depth * out,
        point_index: WATER,
        light: Light::Point(light),
        light_index: AIR,
    };
    let folded = |depth: f64| oracle::light_side(patch, &query(depth), middle) < 0.0;
    let mut far = (0..40).map(|i| 0.1 * 1.2f64.powi(i)).find(|&depth| folded(depth))?;
    let mut near = far / 1.2;
    for _ in 0..60 {
        let depth = 0.5 * (near + far);
        if folded(depth) { far = depth } else { near = depth }
    }
    Some((query(far).point, light))
}

/// Light through a sheet of waves covers each point below once, counting folded paths negative: the refracted map is
/// continuous, so its degree is one wherever the sheet's border lands elsewhere.
fn assert_covered_once(query: &Query, paths: &[Path]) {
    let cover: f64 = paths.iter().map(|path| path.orientation).sum();
    assert!(cover == 1.0, "{} paths cover the point {cover} times: {query:?} {paths:?}", paths.len());
}

#[test]
fn waves_cover_every_point_below_once() {
    let mut folded = 0;
    for (seed, slope) in [(1, 0.3), (2, 0.6), (3, 0.9), (4, 0.9), (5, 0.9)] {
        let surface = Surface::of_mesh(&meshes::height_field(seed, 48, 4.0, slope));
        let random = &mut Random::new(seed);
        for _ in 0..100 {
            let point = DVec3::new(random.between(-0.3, 0.3), random.between(-6.0, -0.6), random.between(-0.3, 0.3));
            let light = Light::Point(DVec3::new(random.between(-0.3, 0.3), 6.0, random.between(-0.3, 0.3)));
            let query = Query { point, point_index: WATER, light, light_index: AIR };
            let paths = all_paths(&surface, &query);
            assert_covered_once(&query, &paths);
            folded += usize::from(paths.len() >= 3);
        }
    }
    // 157 of 500.
    assert!(folded > 100, "{folded} points on folds");
}

#[test]
fn the_pool_is_covered_once_and_folded_on_little_of_its_floor() {
    const POINTS: usize = 3000;
    let scene = load("scenes/pool.toml".as_ref()).unwrap();
    let water = scene.instances.iter().find(|i| i.name == "water").unwrap();
    let surface = Surface::of_instance(&scene.meshes[water.mesh], water);
    let Emitter::Point { position, .. } = scene.lights[0].emitter else { panic!("the pool's lamp is a point") };
    let light = position.as_dvec3();
    let random = &mut Random::new(1);
    let (mut counts, mut farthest) = ([0; 8], 0.0f64);
    let start = std::time::Instant::now();
    for _ in 0..POINTS {
        let point = DVec3::new(random.between(-4.9, 4.9), -2.0, random.between(-4.9, 4.9));
        let query = Query { point, point_index: WATER, light: Light::Point(light), light_index: AIR };
        let paths = all_paths(&surface, &query);
        assert_covered_once(&query, &paths);
        counts[paths.len()] += 1;
        let straight = point + (light - point) * (-point.y / (light.y - point.y));
        farthest = paths.iter().map(|path| path.point.distance(straight)).fold(farthest, f64::max);
    }
    let each = start.elapsed() / POINTS as u32;
    println!("points by number of paths {counts:?}; farthest {farthest:.3} m from the straight line; {each:?} a point");
    // The lamp sees the corner of the floor at 53 degrees; water bends that by 0.55 m in two metres, waves by the rest.
    assert!(farthest < 1.2 && counts[1] > POINTS * 9 / 10, "{counts:?}, {farthest} m");
}

#[test]
fn a_closed_ball_is_crossed_once_on_the_way_in() {
    let surface = Surface::of_mesh(&meshes::lumpy_sphere(7, 48, 0.5));
    let random = &mut Random::new(7);
    for _ in 0..300 {
        let [a, b] = [0.5 * random.direction(), 2.0 * random.direction()];
        assert!(surface.crossings(a, b, usize::MAX) % 2 == 1, "from {a} to {b}");
        assert!(surface.crossings(-b, b, usize::MAX).is_multiple_of(2), "from {} to {b}", -b);
    }
}

#[test]
fn on_flat_water_the_walk_gets_to_the_path() {
    let surface = Surface::of_mesh(&shapes::plane("flat", DVec3::ZERO, DVec2::splat(20.0), [80, 80]));
    let point = DVec3::new(1.3, -2.0, 0.4);
    let query = Query { point, point_index: WATER, light: Light::Point(DVec3::new(-2.1, 4.0, 1.7)), light_index: AIR };
    assert_eq!(on_start_curve(&surface, &query, &all_paths(&surface, &query), 2), Some(vec![true]));
    let sun = Query { light: Light::Directional(DVec3::new(-1.4, -1.0, 0.9).normalize()), ..query };
    assert_eq!(on_start_curve(&surface, &sun, &all_paths(&surface, &sun), 2), Some(vec![true]));
}

#[test]
fn steep_waves_have_paths_off_the_start_s_curve_however_finely_it_is_drawn() {
    let surface = Surface::of_mesh(&meshes::height_field(5, 48, 4.0, 0.9));
    let random = &mut Random::new(5);
    let (mut reached, mut all, mut differ) = (0, 0, 0);
    for _ in 0..30 {
        let point = DVec3::new(random.between(-0.3, 0.3), random.between(-6.0, -3.0), random.between(-0.3, 0.3));
        let light = Light::Point(DVec3::new(random.between(-0.3, 0.3), 6.0, random.between(-0.3, 0.3)));
        let query = Query { point, point_index: WATER, light, light_index: AIR };
        let paths = all_paths(&surface, &query);
        let [coarse, fine] = [3, 6].map(|cuts| on_start_curve(&surface, &query, &paths, cuts).unwrap());
        differ += coarse.iter().zip(&fine).filter(|(a, b)| a != b).count();
        reached += fine.iter().filter(|&&on| on).count();
        all += fine.len();
    }
    // 92 of 270, and none differs.
    let expected = (all / 5..all / 2).contains(&reached) && differ * 20 < all;
    assert!(expected, "{reached} of {all}, {differ} differ");
}
