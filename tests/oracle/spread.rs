//! How far neighbouring rays are apart after one refraction, by differentials and by differences.

use glam::{DVec2, DVec3};

use super::{Light, Patch, Query};

/// A ray's start and unit direction, or their change.
type Ray = (DVec3, DVec3);

/// R of erratum 6, signed: area across the path at the point over solid angle at a point light, or over area across a
/// directional light's rays.
pub fn light_side(patch: &Patch, query: &Query, at: DVec2) -> f64 {
    let crossing = patch.position(at);
    let eta = query.light_index / query.point_index;
    match query.light {
        Light::Point(position) => fan(patch, at, position, query.point, eta),
        Light::Directional(direction) => {
            let changes = across(direction).map(|step| (step, DVec3::ZERO));
            spread(patch, at, (crossing, direction), changes, query.point, eta)
        }
    }
}

/// D of Eq. 25: area across the path at a point light over solid angle at the point.
pub fn point_side(patch: &Patch, query: &Query, at: DVec2) -> Option<f64> {
    let Light::Point(position) = query.light else { return None };
    Some(fan(patch, at, query.point, position, query.point_index / query.light_index))
}

/// Area across the path at `to` over solid angle at `from`.
fn fan(patch: &Patch, at: DVec2, from: DVec3, to: DVec3, eta: f64) -> f64 {
    let direction = (patch.position(at) - from).normalize();
    let changes = across(direction).map(|turn| (DVec3::ZERO, turn));
    spread(patch, at, (from, direction), changes, to, eta)
}

/// Signed area that the ends of two changed rays span, across the refracted ray through `to`.
///
/// Eqs. 28 to 31 of Granizo-Hidalgo and Holzschuch 2024 in the one convention of erratum 5: `w` goes with the ray, eta
/// is the index before over the index behind, the plane is the triangle's, and the shading normal's change is that of
/// the *normalised* interpolation. The printed form is off by 0.3 % on the known answer.
fn spread(patch: &Patch, at: DVec2, (start, w): Ray, changes: [Ray; 2], to: DVec3, eta: f64) -> f64 {
    let crossing = patch.position(at);
    let (leg_before, leg_behind) = (crossing.distance(start), to.distance(crossing));
    let normal = patch.normal(at);
    let n = normal.normalize();
    let out = refract(w, n, eta).expect("a root obeys Snell's law");
    let mu = out.dot(n) - eta * w.dot(n);
    let [first, second] = changes.map(|(step, turn)| {
        let moved = step + leg_before * turn;
        let moved = moved - moved.dot(patch.geometric) / w.dot(patch.geometric) * w;
        let swing = patch.turn(patch.weights(moved));
        let n_change = (swing - swing.dot(n) * n) / normal.length();
        let mu_change = (eta * eta * w.dot(n) / out.dot(n) - eta) * (turn.dot(n) + w.dot(n_change));
        let out_change = eta * turn + mu_change * n + mu * n_change;
        moved - moved.dot(out) * out + leg_behind * out_change
    });
    first.cross(second).dot(out)
}

/// R by central differences: four rays from the light, `step` apart (radians, or metres where it is directional),
/// through the plane that the triangle lies in. `None` where a ray misses that plane or is totally reflected.
pub fn finite_difference(patch: &Patch, query: &Query, at: DVec2, step: f64) -> Option<f64> {
    let crossing = patch.position(at);
    let end = (query.point - crossing).normalize();
    let eta = query.light_index / query.point_index;
    let land = |(start, w): Ray| {
        let along = (patch.corner - start).dot(patch.geometric) / w.dot(patch.geometric);
        let through = start + along * w;
        let out = refract(w, patch.normal(patch.weights(through - patch.corner)).normalize(), eta)?;
        let landed = through + (query.point - through).dot(end) / out.dot(end) * out;
        landed.is_finite().then_some(landed)
    };
    let central = |ray: &dyn Fn(f64) -> Ray| Some((land(ray(step))? - land(ray(-step))?) / (2.0 * step));
    let [first, second] = match query.light {
        Light::Point(light) => {
            let w = (crossing - light).normalize();
            across(w).map(|side| central(&|t: f64| (light, w * t.cos() + side * t.sin())))
        }
        Light::Directional(w) => across(w).map(|side| central(&|t| (crossing - w + t * side, w))),
    };
    Some(first?.cross(second?).dot(end))
}

/// Snell's law with a unit normal on either side; `eta` is the index before over the index behind.
pub fn refract(w: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let before = w.dot(n);
    let behind = 1.0 - eta * eta * (1.0 - before * before);
    (behind > 0.0).then(|| eta * w + (behind.sqrt().copysign(before) - eta * before) * n)
}

/// Unpolarised; `eta` is the index on the side of `cosine` over the other. 0 at total reflection.
pub fn fresnel_transmittance(cosine: f64, eta: f64) -> f64 {
    let behind = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if behind <= 0.0 {
        return 0.0;
    }
    let behind = behind.sqrt();
    let perpendicular = (eta * cosine - behind) / (eta * cosine + behind);
    let parallel = (cosine - eta * behind) / (cosine + eta * behind);
    1.0 - 0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Two unit vectors perpendicular to a unit vector and to each other, right-handed with it.
fn across(w: DVec3) -> [DVec3; 2] {
    let side = w.any_orthonormal_vector();
    [side, w.cross(side)]
}
