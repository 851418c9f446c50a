// The baselines: paths found by Newton's method on the surface, from the walk's start (Hanika et al. 2015) or from random
// ones (specular manifold sampling, Zeltner et al. 2020), with the walk's contribution and test of visibility.
//
// One loop in which each turn traces one ray, whatever it is for: there is one trace call, and neighbours that are at
// different stages do not wait for each other.
#include "technique/mnee/query.glsl"
#include "technique/mnee/areas.glsl"
#include "technique/mnee/manifold.glsl"
#include "technique/mnee/roots.glsl"

layout(set = 2, binding = 12, std430) buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform NewtonPush {
    uint first_slot;
    uint items;
    uint light;
    uint sample_index;
    uint solver;
    uint trials;   // random starts, or the most that a path is searched for again
    uint surfaces; // that starts may be on
    float width; // pixels from a fold within which irradiance is a mean
} push;

const uint SOLVER_NEWTON = 0u;
const uint SOLVER_BIASED = 1u;
const uint SOLVER_UNBIASED = 2u;

// Of Newton's method, failed proposals among them: what Zeltner et al. use.
const uint MAX_ITERATIONS = 20u;

// Of the residual at a root. Rounding leaves 2e-7, and where light is focused a hundredfold this is 1 mm at 2 m.
const float TOLERANCE = 2e-6;

// Roots this far apart are one, in parts of their distance from P.
const float SAME = 5e-4;

// Surfaces that a start's ray may meet before the first that serves; as in start.comp.glsl.
const uint MAX_MEETINGS = 8u;

// What a turn's ray is for.
const uint SEEK = 0u;    // the surface, where a trial starts
const uint PROJECT = 1u; // a proposal back onto the surface
const uint TEST = 2u;    // what is in the way of a path
const uint DONE = 3u;

// Whether light from one medium can come to the other through a hit surface, on the side that it was hit from.
bool serves(Hit hit, vec3 direction, uint point_medium, uint light_medium) {
    if (hit.instance == NO_INSTANCE) return false;
    SpecularInstance instance = specular_instances[hit.instance];
    if (instance.first_triangle == NO_TRIANGLE) return false;
    uvec3 corner = specular_triangles[instance.first_triangle + hit.primitive].corner;
    vec3 a = specular_vertices[corner.x].position;
    vec3 face = cross(specular_vertices[corner.y].position - a, specular_vertices[corner.z].position - a);
    bool from_front = (dot(direction, face) < 0.0) != (instances[hit.instance].mirrored != 0u);
    Material material = materials[instances[hit.instance].material];
    return (from_front ? material.front : material.back) == point_medium &&
           (from_front ? material.back : material.front) == light_medium;
}

void main() {
    uint item = linear_index();
    if (item >= push.items) return;
    uint slot = push.first_slot + item;
    if (push.light == 0u) sample_irradiance[slot] = vec4(0.0);
    VisiblePoint point = visible_points[slot];
    Light light = lights[push.light];
    if (point.instance == NO_INSTANCE || point.medium == light.medium) return;
    count(COUNT_POINTS, 1u);
    Query query = query_at(point, light);
    uint pixels = view.width * view.rows;
    uint seed = combine(combine(view.seed, slot % pixels + view.first_row * view.width), slot / pixels);
    seed = combine(combine(combine(seed, push.sample_index), push.light), 0x6d6e6565u);

    uint trials = push.solver == SOLVER_BIASED ? push.trials : 1u;
    uint most = push.solver == SOLVER_UNBIASED ? trials + push.trials : trials;
    uint turns = most * (MAX_MEETINGS + MAX_ITERATIONS) + 2u * MAX_PATHS;
    uint phase = SEEK;
    uint trial = 0u;
    bool again = false; // the unbiased solver has a path, and counts the trials until it comes to it again
    bool begins = true;
    vec3 towards = query.light;
    float reach = 1e30;
    float from = 0.0;
    uint met = 0u;
    Guess guess = Guess(vec3(0.0), NO_TRIANGLE, vec2(0.0), vec3(0.0), vec2(0.0), 0.0);
    uint instance = NO_INSTANCE;
    float shorten = 1.0;
    uint iterations = 0u;
    Root roots[MAX_PATHS];
    uint number = 0u;
    uint segment = 0u;
    Path path;
    vec3 sum = vec3(0.0);
    uint paths = 0u;
    uint starts = 0u;
    uint projections = 0u;
    uint failures = 0u;

    for (uint turn = 0u; turn < turns && phase != DONE; turn++) {
        if (begins) {
            begins = false;
            from = 0.0;
            met = 0u;
            if (push.solver == SOLVER_NEWTON) {
                reach = query.directional ? 1e30 : 1.0;
            } else if (!sample_area(query, push.surfaces, point.medium, light.medium, combine(seed, trial), towards)) {
                break;
            }
        }
        if (phase == TEST && (segment & 1u) == 0u) {
            path = path_at(query, point, light, roots[segment / 2u].triangle, roots[segment / 2u].place,
                           push.width * point.footprint);
            if (path.rejected != 0u) count(path.rejected, 1u);
        }
        bool wanted = phase != TEST || path.rejected == 0u;
        Ray ray = Ray(query.point, from, towards, reach);
        if (phase == PROJECT) ray = Ray(query.point, 0.0, guess.at + shorten * guess.step, 1e30);
        if (phase == TEST) ray = segment_of(query, path, (segment & 1u) != 0u);
        if (!wanted) ray.direction = vec3(0.0); // traces nothing
        Hit hit = trace(ray, phase == TEST ? MASK_ALL : MASK_SPECULAR, phase == TEST);

        if (phase == TEST) {
            if (wanted) {
                path.rejected = obstacle(hit);
                if (path.rejected != 0u) {
                    count(path.rejected, 1u);
                } else if ((segment & 1u) != 0u) {
                    sum += path.irradiance;
                    paths++;
                }
            }
            segment++;
            if (segment < 2u * number) continue;
            again = push.solver == SOLVER_UNBIASED && paths > 0u;
            begins = again;
            phase = again ? SEEK : DONE;
            continue;
        }

        bool arrived = serves(hit, ray.direction, point.medium, light.medium);
        bool ended = false;
        if (phase == SEEK) {
            if (arrived) {
                starts++;
                phase = PROJECT;
                instance = hit.instance;
                shorten = 1.0;
                iterations = 0u;
            } else {
                from = hit.t * (1.0 + 1e-6) + 1e-7;
                met++;
                ended = hit.instance == NO_INSTANCE || met == MAX_MEETINGS;
            }
        } else {
            arrived = arrived && hit.instance == instance;
            shorten = arrived ? min(1.0, 2.0 * shorten) : 0.5 * shorten;
            iterations++;
            projections++;
        }
        bool found = false;
        if (arrived) {
            guess = guess_at(query, specular_instances[instance].first_triangle + hit.primitive, hit.barycentrics);
            found = guess.residual < TOLERANCE;
        }
        ended = ended || found || (phase == PROJECT && iterations == MAX_ITERATIONS);
        if (!ended) continue;

        if (!found) failures++;
        trial++;
        float same = SAME * length(guess.at);
        if (again) {
            // The chance to find the path is the same in each trial, so the number of trials that it takes is on average
            // its inverse.
            bool recovered = found && distance(guess.at, roots[0].at) < same;
            if (recovered || trial == most) {
                sum *= float(trial - trials);
                if (!recovered) count(COUNT_TRIALS_CAPPED, 1u);
                phase = DONE;
                continue;
            }
        } else {
            if (found) keep(roots, number, Root(guess.at, guess.triangle, guess.place), same);
            if (trial == trials) {
                sort(roots, number);
                phase = number > 0u ? TEST : DONE;
                continue;
            }
        }
        begins = true;
        phase = SEEK;
    }
    count(COUNT_TRIALS, trial);
    count(COUNT_STARTS, starts);
    count(COUNT_PROJECTIONS, projections);
    count(COUNT_NOT_CONVERGED, failures);
    count(COUNT_ROOTS, number);
    count(COUNT_PATHS, paths);
    sample_irradiance[slot].rgb += sum;
}
