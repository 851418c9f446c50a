// Zeros of the objective along one arc.
#include "technique/mnee/arcs.glsl"
#include "technique/mnee/objective.glsl"

// Intervals that an arc is looked at in. An arc is within one triangle, where normals vary linearly: more than two zeros
// take an inflection of the objective, and a pair that a quarter does not separate is looked for at the extremum.
const uint INTERVALS = 4u;

// Of false position; an arc of a wave takes four to six, and the bisections among twelve bring any to 1e-3 of its interval.
const uint REFINEMENTS = 12u;

// Of the parabola towards an extremum.
const uint EXTREMUM_STEPS = 3u;

// The objective's own, in single precision.
const float OBJECTIVE_ROUNDING = 2e-7;

// Of the objective at a zero, itself or relative to the values at the interval's ends. At a change of sign that is none
// (the plane's normal turns round where the curve meets the line PL) it is as large as the bend that refraction makes.
const float ZERO = 5e-6;
const float RELATIVE_ZERO = 1e-4;

// On an arc that begins on the line PL, the nearest that the plane is taken there, in parts of the arc. Newton's method
// looks for roots nearer than this.
const float NEAREST_PART = 1e-4;

float objective_on(Query query, Facet facet, Arc arc, float part, out vec2 place) {
    if (arc.pierced && arc.round) {
        float turn = mix(arc.to.x, arc.to.y, part);
        float kept = clamp(abs(turn), NEAREST_PART, 1.0 - NEAREST_PART) * (arc.to.x + arc.to.y < 0.0 ? -1.0 : 1.0);
        part += (kept - turn) / (arc.to.y - arc.to.x);
    } else if (arc.pierced) {
        part = max(part, NEAREST_PART);
    }
    place = arc_point(facet, arc, part);
    vec3 at = facet_point(facet, weights(place));
    vec3 plane = plane_normal(query, arc.pierced ? facet_step(facet, arc.from, place) : at);
    return objective(query, at, facet_normal(facet, weights(place)), plane);
}

// A part of an arc at whose ends the objective has opposite signs.
struct Interval {
    float a;
    float value_a;
    float b;
    float value_b;
};

// Intervals with a zero each. Where the sign never changes, the extremum of the parabola through the three values nearest
// to zero decides: two zeros that nearly meet make the brightest lines.
uint intervals_of(Query query, Facet facet, Arc arc, out Interval found[INTERVALS]) {
    uint number = 0u;
    float values[INTERVALS + 1u];
    vec2 place;
    uint nearest = 1u;
    for (uint i = 0u; i <= INTERVALS; i++) {
        float part = float(i) / float(INTERVALS);
        values[i] = objective_on(query, facet, arc, part, place);
        if (i > 0u && (values[i] < 0.0) != (values[i - 1u] < 0.0)) {
            found[number++] = Interval(part - 1.0 / float(INTERVALS), values[i - 1u], part, values[i]);
        }
        if (i > 0u && i < INTERVALS && abs(values[i]) < abs(values[nearest])) nearest = i;
    }
    if (number > 0u) return number;
    float a = float(nearest - 1u) / float(INTERVALS);
    float b = float(nearest + 1u) / float(INTERVALS);
    float middle = float(nearest) / float(INTERVALS);
    float value_a = values[nearest - 1u];
    float value = values[nearest];
    float value_b = values[nearest + 1u];
    for (uint i = 0u; i < EXTREMUM_STEPS; i++) {
        // The parabola's vertex, from divided differences.
        float slope_a = (value - value_a) / (middle - a);
        float slope_b = (value_b - value) / (b - middle);
        float bend = (slope_b - slope_a) / (b - a);
        if (!(bend * value > 0.0)) return 0u; // it turns away from zero
        float vertex = 0.5 * (a + middle) - 0.5 * slope_a / bend;
        if (!(vertex > a && vertex < b) || abs(vertex - middle) < 1e-4) return 0u;
        float value_vertex = objective_on(query, facet, arc, vertex, place);
        if ((value_vertex < 0.0) != (value < 0.0)) {
            found[0] = Interval(0.0, values[0], vertex, value_vertex);
            found[1] = Interval(vertex, value_vertex, 1.0, values[INTERVALS]);
            return 2u;
        }
        // The three around the lower of the two.
        if (abs(value_vertex) < abs(value)) {
            if (vertex < middle) {
                b = middle;
                value_b = value;
            } else {
                a = middle;
                value_a = value;
            }
            middle = vertex;
            value = value_vertex;
        } else if (vertex < middle) {
            a = vertex;
            value_a = value_vertex;
        } else {
            b = vertex;
            value_b = value_vertex;
        }
    }
    return 0u;
}

// The zero of an interval: false position that halves the weight of an end that stays (the Illinois rule), with a
// bisection now and then where that stalls. False for a change of sign that is no zero.
bool refine(Query query, Facet facet, Arc arc, Interval interval, out vec2 place) {
    float value = 1.0;
    float zero = max(ZERO, RELATIVE_ZERO * max(abs(interval.value_a), abs(interval.value_b)));
    for (uint i = 0u; i < REFINEMENTS; i++) {
        float span = interval.value_b - interval.value_a;
        float part = i % 4u == 3u || span == 0.0
                         ? 0.5 * (interval.a + interval.b)
                         : (interval.a * interval.value_b - interval.b * interval.value_a) / span;
        value = objective_on(query, facet, arc, part, place);
        if (abs(value) < OBJECTIVE_ROUNDING) break;
        if ((value < 0.0) == (interval.value_a < 0.0)) {
            interval.a = part;
            interval.value_a = value;
            interval.value_b *= 0.5;
        } else {
            interval.b = part;
            interval.value_b = value;
            interval.value_a *= 0.5;
        }
    }
    return abs(value) < zero;
}
