/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray against exact surfaces (mcvisi/surfaces/solid.h), and what lies where it meets one.
 *
 * Along a ray p + t d, in the frame of the solid and about the foot of the perpendicular from its middle, so that t is no larger than the
 * solid, a conic of revolution c (r² + (1 + k) z²) = 2 z is A t² - 2 G t + F = 0 with
 *
 *     A = c (L² + M² + (1 + k) N²)   G = N - c (L x + M y + (1 + k) N z)   F = c (r² + (1 + k) z²) - 2 z
 *     t = F/(G + sgn(G) √(G² - A F)) and (G + sgn(G) √(G² - A F))/A
 *
 * without cancellation in either root and stable as c goes to 0. A root counts on the sheet of the vertex, 1 > (1 + k) c z. A ray that
 * starts on the surface has F = 0, whatever rounds: only the other root, 2 G/A, is left, and it needs no offset.
 *
 * An asphere is marched: with g the height above it and M a bound of |g''| along the ray nothing is met within the h that solves
 * |g| + s g' h - M h²/2 = 0, s the sign of g. The steps end at the surface as fast as Newton's and cannot leave it out.
 */
#ifndef MCVISI_KERNELS_SOLIDS_H
#define MCVISI_KERNELS_SOLIDS_H

#include "surface.h"

/*
 * Where along a ray a condition holds: from enter to exit, or up to exit and again from enter where that is the larger one.
 */
typedef struct mcv_span {
    float enter, exit;
} mcv_span;

MCV_FUNCTION mcv_span mcv_span_of(float enter, float exit) {
    mcv_span span;
    span.enter = enter;
    span.exit = exit;
    return span;
}

MCV_FUNCTION mcv_span mcv_everywhere(void) { return mcv_span_of(-INFINITY, INFINITY); }
MCV_FUNCTION mcv_span mcv_nowhere(void) { return mcv_span_of(INFINITY, -INFINITY); }

MCV_FUNCTION int mcv_span_holds(mcv_span span, float t) {
    return span.enter <= span.exit ? t >= span.enter && t <= span.exit : t <= span.exit || t >= span.enter;
}

/* Where the condition ends for a ray on which it holds at 0, though rounding may say that it does not, quite. */
MCV_FUNCTION float mcv_span_end(mcv_span span) {
    if (span.enter <= span.exit) return span.exit > 0.0f ? span.exit : 0.0f;
    if (span.exit >= 0.0f) return span.exit;
    return span.enter > 0.0f && -span.exit < span.enter ? 0.0f : INFINITY;
}

/* ---- sides ------------------------------------------------------------------------------------------------------ */

/* `on`: the ray starts on the side; `up`: and goes outwards. */
static mcv_span mcv_cylinder_span(float radius, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float a = mcv_fma(d.x, d.x, d.y * d.y);
    const float b = mcv_fma(d.x, p.x, d.y * p.y);
    if (on) {
        if (up) return mcv_nowhere();
        const float other = -2.0f * b / a;
        return mcv_span_of(-INFINITY, a > 0.0f ? (other > 0.0f ? other : 0.0f) : INFINITY);
    }
    const float c = mcv_fma(p.x, p.x, mcv_difference_of_products(p.y, p.y, radius, radius));
    const float cross = mcv_difference_of_products(p.x, d.y, p.y, d.x);
    const float discriminant = mcv_difference_of_products(a * radius, radius, cross, cross);
    if (!(a > 0.0f)) return c <= 0.0f ? mcv_everywhere() : mcv_nowhere();
    if (!(discriminant > 0.0f)) return mcv_nowhere();
    const float root = mcv_sqrt(discriminant);
    const float q = b > 0.0f ? -b - root : root - b;
    return b > 0.0f ? mcv_span_of(q / a, c / q) : mcv_span_of(c / q, q / a);
}

static mcv_span mcv_sphere_span(float radius, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float b = mcv_dot(p, d);
    if (on) return up ? mcv_nowhere() : mcv_span_of(-INFINITY, b < 0.0f ? -2.0f * b : 0.0f);
    const mcv_vec3 foot = mcv_along(p, -b, d);
    const float distance = mcv_sqrt(mcv_dot(foot, foot));
    const float discriminant = (radius - distance) * (radius + distance);
    if (!(discriminant > 0.0f)) return mcv_nowhere();
    const float root = mcv_sqrt(discriminant);
    return mcv_span_of(-b - root, root - b);
}

static mcv_span mcv_box_span(__global const float *half_size, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float at[2] = {p.x, p.y};
    const float along[2] = {d.x, d.y};
    float enter = -INFINITY, exit = INFINITY;
    if (on && up) return mcv_nowhere();
    for (int k = 0; k < 2; ++k) {
        if (along[k] == 0.0f) {
            if (!on && mcv_abs(at[k]) > half_size[k]) return mcv_nowhere();
            continue;
        }
        const float first = (-half_size[k] - at[k]) / along[k];
        const float second = (half_size[k] - at[k]) / along[k];
        enter = fmax(enter, fmin(first, second));
        exit = fmin(exit, fmax(first, second));
    }
    if (on) return mcv_span_of(-INFINITY, exit > 0.0f ? exit : 0.0f);
    return enter <= exit ? mcv_span_of(enter, exit) : mcv_nowhere();
}

/* ---- caps: where the ray is above one --------------------------------------------------------------------------- */

/* `within`: a place inside of the side; `on`: the ray starts on the cap; `up`: and goes above it. z counts from the vertex. */
static mcv_span mcv_conic_above(__global const mcv_device_cap *cap, mcv_vec3 p, mcv_vec3 d, float within, int on, int up) {
    const float c = cap->curvature;
    const float w = cap->across;
    const float e = 1.0f + cap->conic;
    const float a = c * mcv_fma(w * d.x, d.x, mcv_fma(d.y, d.y, e * d.z * d.z));
    const float g = mcv_fma(-c, mcv_fma(w * d.x, p.x, mcv_fma(d.y, p.y, e * d.z * p.z)), d.z);
    if (on) {
        const float other = 2.0f * g / a;
        const float meets = 1.0f - e * c * mcv_fma(other, d.z, p.z) > 0.0f ? (other > 0.0f ? other : 0.0f) : INFINITY;
        if (up) return mcv_span_of(-INFINITY, a > 0.0f ? meets : INFINITY);
        return a < 0.0f && meets < INFINITY ? mcv_span_of(meets, INFINITY) : mcv_nowhere();
    }
    const float f = mcv_fma(c, mcv_fma(w * p.x, p.x, mcv_fma(p.y, p.y, e * p.z * p.z)), -2.0f * p.z);
    const float discriminant = mcv_difference_of_products(g, g, a, f);
    float rise = -INFINITY, fall = INFINITY; /* where it comes above, where below */
    if (discriminant > 0.0f) {
        const float root = mcv_sqrt(discriminant);
        const float q = g >= 0.0f ? g + root : g - root;
        const float first = f / q, second = q / a;
        const float t_rise = g >= 0.0f ? first : second;
        const float t_fall = g >= 0.0f ? second : first;
        if (mcv_abs(t_rise) < INFINITY && mcv_fma(-e * c, mcv_fma(t_rise, d.z, p.z), 1.0f) > 0.0f) rise = t_rise;
        if (mcv_abs(t_fall) < INFINITY && mcv_fma(-e * c, mcv_fma(t_fall, d.z, p.z), 1.0f) > 0.0f) fall = t_fall;
    }
    if (rise > -INFINITY || fall < INFINITY) return mcv_span_of(rise, fall);
    /* No crossing: it is on the same side everywhere. */
    const mcv_vec3 m = mcv_along(p, within, d);
    const float bent = e * c * m.z;
    const float height = mcv_fma(c, mcv_fma(w * m.x, m.x, mcv_fma(m.y, m.y, e * m.z * m.z)), -2.0f * m.z);
    const int above = bent < 1.0f ? height < 0.0f : e * c > 0.0f;
    return above ? mcv_everywhere() : mcv_nowhere();
}

/* dz/dr² of a cap at r², and *height its z. */
static float mcv_cap_slope(__global const mcv_device_cap *cap, float r2, float *height) {
    const float c = cap->curvature;
    const float u = cap->scale * r2;
    const float under = mcv_fma(-(1.0f + cap->conic) * c * c, r2, 1.0f);
    const float root = mcv_sqrt(under > 0.0f ? under : 0.0f);
    float value = 0.0f, slope = 0.0f;
    for (uint i = cap->terms; i > 0; --i) {
        slope = mcv_fma(slope, u, (float)(i + 1u) * cap->term[i - 1u]);
        value = mcv_fma(value, u, cap->term[i - 1u]);
    }
    *height = c * r2 / (1.0f + root) + value * u * u;
    return mcv_fma(slope * u, cap->scale, 0.5f * c / root);
}

/* The height above an asphere at t and its derivative along the ray. */
static float mcv_height_above(__global const mcv_device_cap *cap, mcv_vec3 p, mcv_vec3 d, float t, float *derivative) {
    const mcv_vec3 at = mcv_along(p, t, d);
    const float w = cap->across;
    float height;
    const float slope = mcv_cap_slope(cap, mcv_fma(w * at.x, at.x, at.y * at.y), &height);
    *derivative = mcv_fma(-2.0f * slope, mcv_fma(w * at.x, d.x, at.y * d.y), d.z);
    return at.z - height;
}

#define MCV_MARCHES 64

/* From low to high, the part of the ray within the side; its first two crossings there. */
static mcv_span mcv_asphere_above(__global const mcv_device_cap *cap, float bound, mcv_vec3 p, mcv_vec3 d, float low, float high, int on,
                                  int up) {
    /* z, the height and what leads to them are at most twice the bound and round 6 times: less than that is no height. */
    const float zero = 2.0f * MCV_GAMMA(6) * bound;
    const float bend = cap->bend * mcv_fma(cap->across * d.x, d.x, d.y * d.y);
    const float least = mcv_sqrt(2.0f * zero / bend); /* it can bend by `zero` */
    float t = on ? 0.0f : low;
    float crossing[2] = {INFINITY, INFINITY};
    float derivative;
    const float height = mcv_height_above(cap, p, d, t, &derivative);
    const int above = on ? up : height > 0.0f;
    float sign = above ? 1.0f : -1.0f;
    float distance = on ? 0.0f : mcv_abs(height);
    float speed = on ? fmax(sign * derivative, 0.0f) : sign * derivative; /* with which the distance grows */
    int found = 0;
    for (int i = 0; i < MCV_MARCHES; ++i) {
        if (distance <= zero && speed < 0.0f) {
            t += distance / -speed;
            if (!(t <= high)) break;
            crossing[found++] = t;
            if (found == 2) break;
            sign = -sign;
            (void)mcv_height_above(cap, p, d, t, &derivative);
            distance = 0.0f;
            speed = fmax(sign * derivative, 0.0f);
        }
        const float root = mcv_sqrt(mcv_fma(speed, speed, 2.0f * bend * distance));
        const float step = speed < 0.0f ? 2.0f * distance / (root - speed) : (root + speed) / bend;
        t += speed >= 0.0f && distance <= zero ? fmax(step, least) : step;
        if (!(t <= high)) break;
        distance = fmax(sign * mcv_height_above(cap, p, d, t, &derivative), 0.0f);
        speed = sign * derivative;
    }
    if (found == 0) return above ? mcv_everywhere() : mcv_nowhere();
    return above ? mcv_span_of(crossing[1], crossing[0]) : mcv_span_of(crossing[0], crossing[1]);
}

/* ---- solids ----------------------------------------------------------------------------------------------------- */

MCV_FUNCTION mcv_vec3 mcv_into_frame(__global const mcv_device_solid *solid, mcv_vec3 v) {
    __global const float *m = solid->axes;
    return mcv_vec(mcv_dot(mcv_vec(m[0], m[1], m[2]), v), mcv_dot(mcv_vec(m[3], m[4], m[5]), v), mcv_dot(mcv_vec(m[6], m[7], m[8]), v));
}

MCV_FUNCTION mcv_vec3 mcv_out_of_frame(__global const mcv_device_solid *solid, mcv_vec3 v) {
    __global const float *m = solid->axes;
    return mcv_along(mcv_along(mcv_scale(mcv_vec(m[0], m[1], m[2]), v.x), v.y, mcv_vec(m[3], m[4], m[5])), v.z, mcv_vec(m[6], m[7], m[8]));
}

MCV_FUNCTION mcv_vec3 mcv_from_middle(__global const mcv_device_solid *solid, mcv_vec3 point) {
    return mcv_sub(point, mcv_vec(solid->origin[0], solid->origin[1], solid->origin[2]));
}

MCV_FUNCTION uint mcv_surface_of_piece(__global const mcv_device_solid *solid, uint number, uint piece) {
    return piece == MCV_PIECE_SIDE ? 4u * number + piece : solid->cap[piece].surface;
}

/* The surface of the piece that a hit is on. */
MCV_FUNCTION uint mcv_exact_surface(mcv_world world, uint hit) {
    const uint number = (hit & ~MCV_EXACT) >> 2;
    return mcv_surface_of_piece(world.solids + number, number, hit & 3u);
}

static mcv_span mcv_cap_above(__global const mcv_device_solid *solid, uint k, mcv_vec3 p, mcv_vec3 d, mcv_span side, float start, int on,
                              int up) {
    __global const mcv_device_cap *cap = solid->cap + k;
    const mcv_vec3 from_vertex = mcv_vec(p.x, p.y, p.z - cap->z);
    const float low = fmax(side.enter, fmax(start, -solid->bound));
    const float high = fmin(side.exit, 2.0f * solid->bound);
    if (cap->terms > 0u) return mcv_asphere_above(cap, solid->bound, from_vertex, d, low, high, on, up);
    return mcv_conic_above(cap, from_vertex, d, 0.5f * (fmax(side.enter, -2.0f * solid->bound) + high), on, up);
}

/* Replaces *hit by a closer one; one at the same distance on the same surface is kept beside it: the two bodies are in contact. */
MCV_FUNCTION void mcv_take_exact_hit(mcv_world world, float t, uint number, uint piece, mcv_hit *hit) {
    const uint here = MCV_EXACT | 4u * number | piece;
    if (t < hit->t) {
        hit->t = t;
        hit->u = hit->v = 0.0f;
        hit->triangle = here;
    } else if (t == hit->t && hit->triangle != MCV_NONE && hit->triangle >= MCV_EXACT &&
               mcv_exact_surface(world, hit->triangle) == mcv_exact_surface(world, here)) {
        hit->u = (float)(number + 1u);
    }
}

static void mcv_intersect_solid(mcv_world world, uint number, mcv_vec3 origin, mcv_vec3 direction, uint left, mcv_hit *hit) {
    __global const mcv_device_solid *solid = world.solids + number;
    const mcv_vec3 from = mcv_from_middle(solid, origin);
    const float nearest = -mcv_dot(from, direction);
    const mcv_vec3 foot = mcv_along(from, nearest, direction);
    if (mcv_dot(foot, foot) > solid->bound * solid->bound) return;
    if (nearest + solid->bound < 0.0f || nearest - solid->bound > hit->t) return;

    /* All solids of a lens take the ray from the same place: what they share is met at the same distance, to the last bit. */
    const int here = left != MCV_NONE && world.solids[left >> 3].group == solid->group;
    const int up = (int)(left & 1u);
    int on[MCV_PIECE_COUNT];
    for (uint k = 0; k < MCV_PIECE_COUNT; ++k) on[k] = here && left >> 1 == mcv_surface_of_piece(solid, number, k);
    if (solid->convex && ((on[0] && !up) || (on[1] && up) || (on[2] && up))) return;
    const float shift = here ? 0.0f : nearest;
    const mcv_vec3 p = mcv_into_frame(solid, here ? from : foot);
    const mcv_vec3 d = mcv_into_frame(solid, direction);
    const float start = -shift;

    /* A disc is a plane: of all there is to know of it little is needed, and stops stand in the way of most rays. */
    if (solid->side == MCV_SIDE_OPEN && solid->cap[0].terms == 0u && solid->cap[0].curvature == 0.0f) {
        const float at = (solid->cap[0].z - p.z) / d.z;
        const mcv_vec3 there = mcv_along(p, at, d);
        const float squared = mcv_fma(there.x, there.x, there.y * there.y);
        if (!on[0] && at > start && at < INFINITY && squared <= solid->radius * solid->radius && squared >= solid->hole * solid->hole)
            mcv_take_exact_hit(world, shift + at, number, 0u, hit);
        return;
    }

    /* Within the side, above the first cap, below the second. */
    mcv_span span[MCV_PIECE_COUNT];
    const mcv_span side = solid->side == MCV_SIDE_SPHERE ? mcv_sphere_span(solid->radius, p, d, on[2], up)
                          : solid->side == MCV_SIDE_BOX  ? mcv_box_span(solid->extent, p, d, on[2], up)
                                                         : mcv_cylinder_span(solid->radius, p, d, on[2], up);
    if (!(side.enter <= side.exit)) return;
    span[MCV_PIECE_SIDE] = side;
    span[0] = span[1] = mcv_everywhere();
    if (solid->side != MCV_SIDE_SPHERE) span[0] = mcv_cap_above(solid, 0, p, d, side, start, on[0], up);
    if (solid->side == MCV_SIDE_OPEN) {
        const float at[2] = {span[0].enter, span[0].exit};
        for (int k = 0; k < 2; ++k) {
            const mcv_vec3 there = mcv_along(p, at[k], d);
            if (!(mcv_abs(at[k]) < INFINITY) || !(on[0] ? at[k] >= start : at[k] > start) || !mcv_span_holds(side, at[k])) continue;
            if (mcv_fma(there.x, there.x, there.y * there.y) < solid->hole * solid->hole) continue;
            mcv_take_exact_hit(world, shift + at[k], number, 0u, hit);
        }
        return;
    }
    if (solid->side != MCV_SIDE_SPHERE) {
        const mcv_span above = mcv_cap_above(solid, 1, p, d, side, start, on[1], up);
        span[1] = mcv_span_of(above.exit, above.enter);
    }

    /* A ray that goes inwards from its surface is inside: it leaves where the first of them ends. */
    if ((on[0] && up) || (on[1] && !up) || (on[2] && !up)) {
        float end = INFINITY;
        uint piece = 0u;
        for (uint k = 0; k < MCV_PIECE_COUNT; ++k) {
            const float other = mcv_span_end(span[k]);
            if (other < end) {
                end = other;
                piece = k;
            }
        }
        if (end < INFINITY) mcv_take_exact_hit(world, end, number, piece, hit);
        return;
    }
    /* Where one begins and the others hold, or, from inside, where one ends. What is as thin as rounding begins first. */
    float first = INFINITY;
    uint piece = 0u;
    for (uint i = 0; i < 2u * MCV_PIECE_COUNT; ++i) {
        const uint k = i % MCV_PIECE_COUNT;
        const float at = i < MCV_PIECE_COUNT ? span[k].enter : span[k].exit;
        if (!(on[k] ? at >= start : at > start) || !(at < first)) continue;
        if (!mcv_span_holds(span[(k + 1u) % MCV_PIECE_COUNT], at) || !mcv_span_holds(span[(k + 2u) % MCV_PIECE_COUNT], at)) continue;
        first = at;
        piece = k;
    }
    if (first < INFINITY) mcv_take_exact_hit(world, shift + first, number, piece, hit);
}

/* The closer of a hit (or miss, with its t_max) on triangles and one on exact surfaces. */
static __attribute__((noinline)) mcv_hit mcv_meet_solids(mcv_world world, mcv_vec3 origin, mcv_vec3 direction, uint left, mcv_hit hit) {
    for (uint i = 0; i < world.frame->solid_count; ++i) mcv_intersect_solid(world, i, origin, direction, left, &hit);
    return hit;
}

/* The same along a way of any length, in which distances are. */
MCV_FUNCTION mcv_hit mcv_meet_solids_along(mcv_world world, mcv_vec3 origin, mcv_vec3 way, uint left, mcv_hit hit) {
    const float length = mcv_sqrt(mcv_dot(way, way));
    mcv_hit unit = hit;
    unit.t *= length;
    unit = mcv_meet_solids(world, origin, mcv_scale(way, 1.0f / length), left, unit);
    if (unit.triangle != hit.triangle) {
        hit = unit;
        hit.t /= length;
    }
    return hit;
}

/* ---- where a ray has met one ------------------------------------------------------------------------------------ */

/* The unit gradient of a piece's equation at p, outwards, and how far p lies outside of it. */
static mcv_vec3 mcv_piece_gradient(__global const mcv_device_solid *solid, uint piece, mcv_vec3 p, float *outside) {
    if (piece == MCV_PIECE_SIDE) {
        if (solid->side == MCV_SIDE_BOX) {
            const float x = mcv_abs(p.x) - solid->extent[0], y = mcv_abs(p.y) - solid->extent[1];
            *outside = fmax(x, y);
            return x > y ? mcv_vec(p.x < 0.0f ? -1.0f : 1.0f, 0.0f, 0.0f) : mcv_vec(0.0f, p.y < 0.0f ? -1.0f : 1.0f, 0.0f);
        }
        const mcv_vec3 out = mcv_vec(p.x, p.y, solid->side == MCV_SIDE_SPHERE ? p.z : 0.0f);
        *outside = mcv_sqrt(mcv_dot(out, out)) - solid->radius;
        return mcv_normalize(out);
    }
    __global const mcv_device_cap *cap = solid->cap + piece;
    const float w = cap->across, c = cap->curvature, e = 1.0f + cap->conic;
    const float z = p.z - cap->z;
    mcv_vec3 down; /* towards the height's fall */
    float height;
    if (cap->terms > 0u) {
        float at;
        const float slope = 2.0f * mcv_cap_slope(cap, mcv_fma(w * p.x, p.x, p.y * p.y), &at);
        down = mcv_vec(slope * w * p.x, slope * p.y, -1.0f);
        height = z - at;
    } else {
        down = mcv_vec(c * w * p.x, c * p.y, mcv_fma(e * c, z, -1.0f));
        height = z - 0.5f * c * mcv_fma(w * p.x, p.x, mcv_fma(p.y, p.y, e * z * z));
    }
    const float inverse = 1.0f / mcv_sqrt(mcv_dot(down, down));
    const float sign = piece == MCV_PIECE_FIRST_CAP ? inverse : -inverse;
    *outside = -height * sign;
    return mcv_scale(down, sign);
}

static mcv_surface mcv_exact_surface_at(mcv_world world, uint met, float u, mcv_vec3 origin, mcv_vec3 direction, float t) {
    const uint number = (met & ~MCV_EXACT) >> 2, piece = met & 3u;
    __global const mcv_device_solid *solid = world.solids + number;
    mcv_surface surface;
    float outside;
    mcv_vec3 p = mcv_into_frame(solid, mcv_along(mcv_from_middle(solid, origin), t, direction));
    mcv_vec3 normal = mcv_piece_gradient(solid, piece, p, &outside);
    /* What t has rounded: back along the ray, or straight onto a surface that it grazes. */
    const mcv_vec3 d = mcv_into_frame(solid, direction);
    const float slant = mcv_dot(d, normal);
    p = mcv_abs(slant) > 0.25f ? mcv_along(p, -outside / slant, d) : mcv_along(p, -outside, normal);
    normal = mcv_piece_gradient(solid, piece, p, &outside);
    surface.point = mcv_add(mcv_vec(solid->origin[0], solid->origin[1], solid->origin[2]), mcv_out_of_frame(solid, p));
    surface.error = mcv_vec(0.0f, 0.0f, 0.0f); /* a ray knows the surface that it starts on */
    surface.face = surface.normal = mcv_renormalize(mcv_out_of_frame(solid, normal));
    surface.area = 0.0f;
    surface.triangle = met;
    surface.instance = solid->instance[piece];
    surface.u = u;
    surface.v = 0.0f;
    surface.corners.x = surface.corners.y = surface.corners.z = 0u;
    surface.corners.w = surface.instance;
    return surface;
}

/* What a ray remembers that leaves a surface in this direction. */
MCV_FUNCTION uint mcv_leave(mcv_world world, mcv_surface surface, mcv_vec3 direction) {
    if (surface.triangle < MCV_EXACT) return MCV_NONE;
    const uint outwards = mcv_dot(direction, surface.face) > 0.0f;
    return mcv_exact_surface(world, surface.triangle) << 1 | ((surface.triangle & 3u) == MCV_PIECE_FIRST_CAP ? 1u - outwards : outwards);
}

#endif
