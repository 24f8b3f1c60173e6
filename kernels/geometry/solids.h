/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray against exact surfaces (mcvisi/surfaces/solid.h), and what lies where it meets one.
 *
 * Along a ray p + t d, in the frame of the solid and about the foot of the perpendicular from its
 * middle, so that t is no larger than the solid, a conic of revolution c (r² + (1 + k) z²) = 2 z is
 * A t² - 2 G t + F = 0 with
 *
 *     A = c (L² + M² + (1 + k) N²)   G = N - c (L x + M y + (1 + k) N z)   F = c (r² + (1 + k) z²)
 * - 2 z t = F/(G + sgn(G) √(G² - A F)) and (G + sgn(G) √(G² - A F))/A
 *
 * without cancellation in either root and stable as c goes to 0. A root counts on the sheet of the
 * vertex, 1 > (1 + k) c z. A ray that starts on the surface has F = 0, whatever rounds: only the
 * other root, 2 G/A, is left, and it needs no offset.
 *
 * An asphere is marched: with g the height above it and M a bound of |g''| along the ray nothing is
 * met within the h that solves |g| + s g' h - M h²/2 = 0, s the sign of g. The steps end at the
 * surface as fast as Newton's and cannot leave it out.
 *
 * Most solids are discs, balls, boxes and cylinders with conics as caps. Their functions choose
 * between values and do not branch, so that the tile schedule meets them with many rays at once.
 */
#ifndef MCVISI_KERNELS_SOLIDS_H
#define MCVISI_KERNELS_SOLIDS_H

#include "geometry/surface.h"

/*
 * Where along a ray a condition holds: from enter to exit, or up to exit and again from enter where
 * that is the larger one.
 */
typedef struct mcv_span {
    float enter, exit;
} mcv_span;

MCV_LOOP_FUNCTION mcv_span mcv_span_of(float enter, float exit) {
    mcv_span span;
    span.enter = enter;
    span.exit = exit;
    return span;
}

MCV_LOOP_FUNCTION mcv_span mcv_everywhere(void) { return mcv_span_of(-INFINITY, INFINITY); }
MCV_LOOP_FUNCTION mcv_span mcv_nowhere(void) { return mcv_span_of(INFINITY, -INFINITY); }

MCV_LOOP_FUNCTION mcv_span mcv_choose_span(int first, mcv_span a, mcv_span b) {
    return mcv_span_of(first ? a.enter : b.enter, first ? a.exit : b.exit);
}

MCV_LOOP_FUNCTION int mcv_span_holds(mcv_span span, float t) {
    const int entered = t >= span.enter, stays = t <= span.exit;
    return span.enter <= span.exit ? entered & stays : entered | stays;
}

/* Where the condition ends for a ray on which it holds at 0, though rounding may say that it does
 * not, quite. */
MCV_LOOP_FUNCTION float mcv_span_end(mcv_span span) {
    const float end = span.exit > 0.0f ? span.exit : 0.0f;
    const float gap_end = ((span.enter > 0.0f) & (-span.exit < span.enter)) ? 0.0f : INFINITY;
    return ((span.enter <= span.exit) | (span.exit >= 0.0f)) ? end : gap_end;
}

/* ---- sides
 * ------------------------------------------------------------------------------------------------------
 */

/* `on`: the ray starts on the side; `up`: and goes outwards. */
MCV_LOOP_FUNCTION mcv_span mcv_cylinder_span(float radius, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float a = mcv_fma(d.x, d.x, d.y * d.y);
    const float b = mcv_fma(d.x, p.x, d.y * p.y);
    const int along = !(a > 0.0f);
    const float other = -2.0f * b / a;
    const mcv_span inside = mcv_span_of(-INFINITY, along ? INFINITY : other > 0.0f ? other : 0.0f);
    const float c = mcv_fma(p.x, p.x, mcv_difference_of_products(p.y, p.y, radius, radius));
    const float cross = mcv_difference_of_products(p.x, d.y, p.y, d.x);
    const float discriminant = mcv_difference_of_products(a * radius, radius, cross, cross);
    const float root = mcv_sqrt(discriminant);
    const float q = b > 0.0f ? -b - root : root - b;
    const float at_q = q / a, at_c = c / q;
    const mcv_span crossed = mcv_span_of(b > 0.0f ? at_q : at_c, b > 0.0f ? at_c : at_q);
    const int holds = along ? c <= 0.0f : discriminant > 0.0f;
    const mcv_span met = mcv_choose_span(along, mcv_everywhere(), crossed);
    return mcv_choose_span(on ? !up : holds, mcv_choose_span(on, inside, met), mcv_nowhere());
}

MCV_LOOP_FUNCTION mcv_span mcv_sphere_span(float radius, mcv_vec3 p, mcv_vec3 d, int on, int up) {
    const float b = mcv_dot(p, d);
    const mcv_span inside = mcv_span_of(-INFINITY, b < 0.0f ? -2.0f * b : 0.0f);
    const mcv_vec3 foot = mcv_along(p, -b, d);
    const float distance = mcv_sqrt(mcv_dot(foot, foot));
    const float discriminant = (radius - distance) * (radius + distance);
    const float root = mcv_sqrt(discriminant);
    return mcv_choose_span(on ? !up : discriminant > 0.0f,
                           mcv_choose_span(on, inside, mcv_span_of(-b - root, root - b)),
                           mcv_nowhere());
}

/* Between two planes. */
MCV_LOOP_FUNCTION mcv_span mcv_slab_span(float half_size, float at, float along, int on) {
    const float first = (-half_size - at) / along, second = (half_size - at) / along;
    const mcv_span crossed =
        mcv_span_of(first < second ? first : second, first < second ? second : first);
    const mcv_span parallel =
        mcv_choose_span(!on & (mcv_abs(at) > half_size), mcv_nowhere(), mcv_everywhere());
    return mcv_choose_span(along == 0.0f, parallel, crossed);
}

MCV_LOOP_FUNCTION mcv_span mcv_box_span(__global const float *half_size, mcv_vec3 p, mcv_vec3 d,
                                        int on, int up) {
    const mcv_span x = mcv_slab_span(half_size[0], p.x, d.x, on),
                   y = mcv_slab_span(half_size[1], p.y, d.y, on);
    const float enter = x.enter > y.enter ? x.enter : y.enter;
    const float exit = x.exit < y.exit ? x.exit : y.exit;
    const mcv_span inside = mcv_span_of(-INFINITY, exit > 0.0f ? exit : 0.0f);
    return mcv_choose_span(on ? !up : enter <= exit,
                           mcv_choose_span(on, inside, mcv_span_of(enter, exit)), mcv_nowhere());
}

/* ---- caps: where the ray is above one
 * --------------------------------------------------------------------------- */

/* `within`: a place inside of the side; `on`: the ray starts on the cap; `up`: and goes above it. z
 * counts from the vertex. */
MCV_LOOP_FUNCTION mcv_span mcv_conic_above(__global const mcv_device_cap *cap, mcv_vec3 p,
                                           mcv_vec3 d, float within, int on, int up) {
    const float c = cap->curvature;
    const float w = cap->across;
    const float e = 1.0f + cap->conic;
    const float a = c * mcv_fma(w * d.x, d.x, mcv_fma(d.y, d.y, e * d.z * d.z));
    const float g = mcv_fma(-c, mcv_fma(w * d.x, p.x, mcv_fma(d.y, p.y, e * d.z * p.z)), d.z);

    const float other = 2.0f * g / a;
    const float meets =
        1.0f - e * c * mcv_fma(other, d.z, p.z) > 0.0f ? (other > 0.0f ? other : 0.0f) : INFINITY;
    const mcv_span rising = mcv_span_of(-INFINITY, a > 0.0f ? meets : INFINITY);
    const mcv_span falling = mcv_choose_span((a < 0.0f) & (meets < INFINITY),
                                             mcv_span_of(meets, INFINITY), mcv_nowhere());

    const float f =
        mcv_fma(c, mcv_fma(w * p.x, p.x, mcv_fma(p.y, p.y, e * p.z * p.z)), -2.0f * p.z);
    const float discriminant = mcv_difference_of_products(g, g, a, f);
    const float root = mcv_sqrt(discriminant);
    const float q = g >= 0.0f ? g + root : g - root;
    const float first = f / q, second = q / a;
    const float t_rise = g >= 0.0f ? first : second;
    const float t_fall = g >= 0.0f ? second : first;
    const int crosses = discriminant > 0.0f;
    const int rises = crosses & (mcv_abs(t_rise) < INFINITY) &
                      (mcv_fma(-e * c, mcv_fma(t_rise, d.z, p.z), 1.0f) > 0.0f);
    const int falls = crosses & (mcv_abs(t_fall) < INFINITY) &
                      (mcv_fma(-e * c, mcv_fma(t_fall, d.z, p.z), 1.0f) > 0.0f);
    const mcv_span crossed = mcv_span_of(rises ? t_rise : -INFINITY, falls ? t_fall : INFINITY);
    /* No crossing: it is on the same side everywhere. */
    const mcv_vec3 m = mcv_along(p, within, d);
    const float bent = e * c * m.z;
    const float height =
        mcv_fma(c, mcv_fma(w * m.x, m.x, mcv_fma(m.y, m.y, e * m.z * m.z)), -2.0f * m.z);
    const int above = bent < 1.0f ? height < 0.0f : e * c > 0.0f;
    const mcv_span met = mcv_choose_span(rises | falls, crossed,
                                         mcv_choose_span(above, mcv_everywhere(), mcv_nowhere()));
    return mcv_choose_span(on, mcv_choose_span(up, rising, falling), met);
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
static float mcv_height_above(__global const mcv_device_cap *cap, mcv_vec3 p, mcv_vec3 d, float t,
                              float *derivative) {
    const mcv_vec3 at = mcv_along(p, t, d);
    const float w = cap->across;
    float height;
    const float slope = mcv_cap_slope(cap, mcv_fma(w * at.x, at.x, at.y * at.y), &height);
    *derivative = mcv_fma(-2.0f * slope, mcv_fma(w * at.x, d.x, at.y * d.y), d.z);
    return at.z - height;
}

#define MCV_MARCHES 64

/* From low to high, the part of the ray within the side; its first two crossings there. */
static mcv_span mcv_asphere_above(__global const mcv_device_cap *cap, float bound, mcv_vec3 p,
                                  mcv_vec3 d, float low, float high, int on, int up) {
    /* z, the height and what leads to them are at most twice the bound and round 6 times: less than
     * that is no height. */
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
    float speed =
        on ? fmax(sign * derivative, 0.0f) : sign * derivative; /* with which the distance grows */
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

/* ---- solids
 * -----------------------------------------------------------------------------------------------------
 */

MCV_LOOP_FUNCTION mcv_vec3 mcv_into_frame(__global const mcv_device_solid *solid, mcv_vec3 v) {
    __global const float *m = solid->axes;
    return mcv_vec(mcv_dot(mcv_vec(m[0], m[1], m[2]), v), mcv_dot(mcv_vec(m[3], m[4], m[5]), v),
                   mcv_dot(mcv_vec(m[6], m[7], m[8]), v));
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_out_of_frame(__global const mcv_device_solid *solid, mcv_vec3 v) {
    __global const float *m = solid->axes;
    return mcv_along(
        mcv_along(mcv_scale(mcv_vec(m[0], m[1], m[2]), v.x), v.y, mcv_vec(m[3], m[4], m[5])), v.z,
        mcv_vec(m[6], m[7], m[8]));
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_from_middle(__global const mcv_device_solid *solid, mcv_vec3 point) {
    return mcv_sub(point, mcv_vec(solid->origin[0], solid->origin[1], solid->origin[2]));
}

MCV_LOOP_FUNCTION uint mcv_surface_of_piece(__global const mcv_device_solid *solid, uint number,
                                            uint piece) {
    return piece == MCV_PIECE_SIDE ? 4u * number + piece : solid->cap[piece].surface;
}

/* The surface of the piece that a hit is on. */
MCV_LOOP_FUNCTION uint mcv_exact_surface(mcv_world world, uint hit) {
    const uint number = mcv_solid_of(hit);
    return mcv_surface_of_piece(world.solids + number, number, mcv_piece_of(hit));
}

/* A ray in a solid's frame: the place `shift` along it is p. */
typedef struct mcv_solid_ray {
    mcv_vec3 p, d;
    float shift;
    int on[MCV_PIECE_COUNT]; /* 1: it starts on that piece */
    int up;                  /* and goes to +z of a cap or out of the side */
    int inside;              /* it goes inwards from a piece */
    int away;                /* it cannot meet the solid again */
} mcv_solid_ray;

/* All solids of a lens take the ray from the same place: what they share is met at the same
 * distance, to the last bit. */
MCV_LOOP_FUNCTION mcv_solid_ray mcv_make_solid_ray(mcv_world world, uint number, mcv_vec3 origin,
                                                   mcv_vec3 direction, uint origin_surface) {
    __global const mcv_device_solid *solid = world.solids + number;
    mcv_solid_ray ray;
    const mcv_vec3 from = mcv_from_middle(solid, origin);
    const float nearest = -mcv_dot(from, direction);
    const uint started = origin_surface == MCV_NONE ? number : origin_surface >> 3;
    const int here = (origin_surface != MCV_NONE) & (world.solids[started].group == solid->group);
    ray.up = (int)(origin_surface & 1u);
    ray.on[0] = here & (origin_surface >> 1 == mcv_surface_of_piece(solid, number, 0u));
    ray.on[1] = here & (origin_surface >> 1 == mcv_surface_of_piece(solid, number, 1u));
    ray.on[2] = here & (origin_surface >> 1 == mcv_surface_of_piece(solid, number, 2u));
    ray.inside = (ray.on[0] & ray.up) | (ray.on[1] & !ray.up) | (ray.on[2] & !ray.up);
    ray.away = (solid->convex != 0u) &
               ((ray.on[0] & !ray.up) | (ray.on[1] & ray.up) | (ray.on[2] & ray.up));
    ray.shift = here ? 0.0f : nearest;
    ray.p = mcv_into_frame(solid, mcv_choose(here, from, mcv_along(from, nearest, direction)));
    ray.d = mcv_into_frame(solid, direction);
    return ray;
}

/* Does a ray meet the ball that holds the solid, before it ends? */
MCV_LOOP_FUNCTION int mcv_reaches_solid(__global const mcv_device_solid *solid, mcv_vec3 origin,
                                        mcv_vec3 direction, float end) {
    const mcv_vec3 from = mcv_from_middle(solid, origin);
    const float nearest = -mcv_dot(from, direction);
    const mcv_vec3 foot = mcv_along(from, nearest, direction);
    const int misses =
        (mcv_dot(foot, foot) > solid->bound * solid->bound) | (nearest + solid->bound < 0.0f);
    return !(misses | (nearest - solid->bound > end));
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_from_vertex(mcv_vec3 p, __global const mcv_device_cap *cap) {
    return mcv_vec(p.x, p.y, p.z - cap->z);
}

/* A place on the ray within the side and the solid's ball. */
MCV_LOOP_FUNCTION float mcv_within(mcv_span side, float bound) {
    return 0.5f * ((side.enter > -2.0f * bound ? side.enter : -2.0f * bound) +
                   (side.exit < 2.0f * bound ? side.exit : 2.0f * bound));
}

static mcv_span mcv_cap_above(__global const mcv_device_solid *solid, uint k,
                              const mcv_solid_ray *ray, mcv_span side) {
    __global const mcv_device_cap *cap = solid->cap + k;
    const mcv_vec3 p = mcv_from_vertex(ray->p, cap);
    if (cap->terms == 0u)
        return mcv_conic_above(cap, p, ray->d, mcv_within(side, solid->bound), ray->on[k], ray->up);
    const float low = fmax(side.enter, fmax(-ray->shift, -solid->bound));
    const float high = fmin(side.exit, 2.0f * solid->bound);
    return mcv_asphere_above(cap, solid->bound, p, ray->d, low, high, ray->on[k], ray->up);
}

/* Where a ray meets a solid, and its piece; t is infinite where it does not. */
typedef struct mcv_piece_hit {
    float t;
    uint piece;
} mcv_piece_hit;

/* A crossing of one span's end where the two others hold, if it is the first one so far. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_earlier(mcv_piece_hit first, float at, uint piece, float start,
                                            int on, mcv_span a, mcv_span b) {
    const int ahead = on ? at >= start : at > start;
    const int counts = ahead & (at < first.t) & mcv_span_holds(a, at) & mcv_span_holds(b, at);
    first.t = counts ? at : first.t;
    first.piece = counts ? piece : first.piece;
    return first;
}

MCV_LOOP_FUNCTION mcv_piece_hit mcv_earlier_end(mcv_piece_hit first, mcv_span span, uint piece) {
    const float end = mcv_span_end(span);
    const int counts = end < first.t;
    first.t = counts ? end : first.t;
    first.piece = counts ? piece : first.piece;
    return first;
}

/* `above` the first cap, `below` the second one. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_spans(mcv_solid_ray ray, mcv_span above,
                                                    mcv_span below, mcv_span side) {
    const float start = -ray.shift;
    mcv_piece_hit none, first, end;
    none.t = INFINITY;
    none.piece = 0u;
    /* A ray that goes inwards from its surface is inside: it leaves where the first of them ends.
     */
    end = mcv_earlier_end(none, above, MCV_PIECE_FIRST_CAP);
    end = mcv_earlier_end(end, below, MCV_PIECE_SECOND_CAP);
    end = mcv_earlier_end(end, side, MCV_PIECE_SIDE);
    /* Where one begins and the others hold, or, from inside, where one ends. What is as thin as
     * rounding begins first. */
    first = mcv_earlier(none, above.enter, MCV_PIECE_FIRST_CAP, start, ray.on[0], below, side);
    first = mcv_earlier(first, below.enter, MCV_PIECE_SECOND_CAP, start, ray.on[1], side, above);
    first = mcv_earlier(first, side.enter, MCV_PIECE_SIDE, start, ray.on[2], above, below);
    first = mcv_earlier(first, above.exit, MCV_PIECE_FIRST_CAP, start, ray.on[0], below, side);
    first = mcv_earlier(first, below.exit, MCV_PIECE_SECOND_CAP, start, ray.on[1], side, above);
    first = mcv_earlier(first, side.exit, MCV_PIECE_SIDE, start, ray.on[2], above, below);
    const int misses = ray.away | !(side.enter <= side.exit);
    first.t = misses ? INFINITY : ray.shift + (ray.inside ? end.t : first.t);
    first.piece = ray.inside ? end.piece : first.piece;
    return first;
}

/* ---- the solids that are met without branches
 * ------------------------------------------------------------------- */

enum { MCV_SHAPE_DISC, MCV_SHAPE_BALL, MCV_SHAPE_BOX, MCV_SHAPE_CONICS, MCV_SHAPE_OTHER };

MCV_FUNCTION uint mcv_shape(__global const mcv_device_solid *solid) {
    if (solid->side == MCV_SIDE_SPHERE) return MCV_SHAPE_BALL;
    if (solid->side == MCV_SIDE_OPEN && solid->cap[0].terms == 0u &&
        solid->cap[0].curvature == 0.0f)
        return MCV_SHAPE_DISC;
    if (solid->side == MCV_SIDE_BOX) return MCV_SHAPE_BOX;
    if (solid->side == MCV_SIDE_CYLINDER && solid->cap[0].terms == 0u && solid->cap[1].terms == 0u)
        return MCV_SHAPE_CONICS;
    return MCV_SHAPE_OTHER;
}

/* A disc is a plane: of all there is to know of it little is needed, and stops stand in the way of
 * most rays. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_disc(__global const mcv_device_solid *solid,
                                                   mcv_solid_ray ray) {
    mcv_piece_hit met;
    const float at = (solid->cap[0].z - ray.p.z) / ray.d.z;
    const mcv_vec3 there = mcv_along(ray.p, at, ray.d);
    const float squared = mcv_fma(there.x, there.x, there.y * there.y);
    const int ahead = !ray.on[0] & (at > -ray.shift) & (at < INFINITY);
    const int within =
        (squared <= solid->radius * solid->radius) & (squared >= solid->hole * solid->hole);
    met.t = (ahead & within) ? ray.shift + at : INFINITY;
    met.piece = MCV_PIECE_FIRST_CAP;
    return met;
}

/* A ball is all side. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_ball(__global const mcv_device_solid *solid,
                                                   mcv_solid_ray ray) {
    const mcv_span side = mcv_sphere_span(solid->radius, ray.p, ray.d, ray.on[2], ray.up);
    const float start = -ray.shift;
    const int enters = ray.on[2] ? side.enter >= start : side.enter > start,
              leaves = ray.on[2] ? side.exit >= start : side.exit > start;
    const float first = enters ? side.enter : leaves ? side.exit : INFINITY;
    const int misses = ray.away | !(side.enter <= side.exit);
    mcv_piece_hit met;
    met.t = misses ? INFINITY : ray.shift + (ray.inside ? mcv_span_end(side) : first);
    met.piece = MCV_PIECE_SIDE;
    return met;
}

/* Two conics within a side. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_conics(__global const mcv_device_solid *solid,
                                                     mcv_solid_ray ray, mcv_span side) {
    const float within = mcv_within(side, solid->bound);
    const mcv_span first = mcv_conic_above(solid->cap, mcv_from_vertex(ray.p, solid->cap), ray.d,
                                           within, ray.on[0], ray.up);
    const mcv_span second = mcv_conic_above(solid->cap + 1, mcv_from_vertex(ray.p, solid->cap + 1),
                                            ray.d, within, ray.on[1], ray.up);
    return mcv_intersect_spans(ray, first, mcv_span_of(second.exit, second.enter), side);
}

MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_shape(__global const mcv_device_solid *solid,
                                                    uint shape, mcv_solid_ray ray) {
    if (shape == MCV_SHAPE_DISC) return mcv_intersect_disc(solid, ray);
    if (shape == MCV_SHAPE_BALL) return mcv_intersect_ball(solid, ray);
    if (shape == MCV_SHAPE_BOX)
        return mcv_intersect_conics(solid, ray,
                                    mcv_box_span(solid->extent, ray.p, ray.d, ray.on[2], ray.up));
    return mcv_intersect_conics(solid, ray,
                                mcv_cylinder_span(solid->radius, ray.p, ray.d, ray.on[2], ray.up));
}

/* ---- any solid
 * --------------------------------------------------------------------------------------------------
 */

/* Replaces *hit by a closer one; one at the same distance on the same surface is kept beside it:
 * the two bodies are in contact. */
MCV_FUNCTION void mcv_take_exact_hit(mcv_world world, float t, uint number, uint piece,
                                     mcv_hit *hit) {
    const uint here = mcv_exact_hit(number, piece);
    if (t < hit->t) {
        hit->t = t;
        hit->u = hit->v = 0.0f;
        hit->triangle = here;
    } else if (t == hit->t && hit->triangle != MCV_NONE && hit->triangle >= MCV_EXACT &&
               mcv_exact_surface(world, hit->triangle) == mcv_exact_surface(world, here)) {
        hit->u = (float)(number + 1u);
    }
}

/* A curved surface by itself: both places where a ray meets its cap may lie within the side. */
static mcv_piece_hit mcv_intersect_open(__global const mcv_device_solid *solid,
                                        const mcv_solid_ray *ray, mcv_span side) {
    mcv_piece_hit met;
    const mcv_span above = mcv_cap_above(solid, 0u, ray, side);
    const float at[2] = {above.enter, above.exit};
    const float start = -ray->shift;
    met.t = INFINITY;
    met.piece = MCV_PIECE_FIRST_CAP;
    for (int k = 0; k < 2; ++k) {
        const mcv_vec3 there = mcv_along(ray->p, at[k], ray->d);
        if (!(mcv_abs(at[k]) < INFINITY) || !(ray->on[0] ? at[k] >= start : at[k] > start) ||
            !mcv_span_holds(side, at[k]))
            continue;
        if (mcv_fma(there.x, there.x, there.y * there.y) < solid->hole * solid->hole) continue;
        if (ray->shift + at[k] < met.t) met.t = ray->shift + at[k];
    }
    return met;
}

static mcv_piece_hit mcv_intersect_other(__global const mcv_device_solid *solid,
                                         const mcv_solid_ray *ray) {
    const mcv_span side = mcv_cylinder_span(solid->radius, ray->p, ray->d, ray->on[2], ray->up);
    if (ray->away || !(side.enter <= side.exit)) {
        const mcv_piece_hit none = {INFINITY, 0u};
        return none;
    }
    if (solid->side == MCV_SIDE_OPEN) return mcv_intersect_open(solid, ray, side);
    const mcv_span above = mcv_cap_above(solid, 0u, ray, side);
    const mcv_span second = mcv_cap_above(solid, 1u, ray, side);
    return mcv_intersect_spans(*ray, above, mcv_span_of(second.exit, second.enter), side);
}

static void mcv_intersect_solid(mcv_world world, uint number, mcv_vec3 origin, mcv_vec3 direction,
                                uint origin_surface, mcv_hit *hit) {
    __global const mcv_device_solid *solid = world.solids + number;
    if (!mcv_reaches_solid(solid, origin, direction, hit->t)) return;
    const mcv_solid_ray ray = mcv_make_solid_ray(world, number, origin, direction, origin_surface);
    const uint shape = mcv_shape(solid);
    const mcv_piece_hit met = shape == MCV_SHAPE_OTHER ? mcv_intersect_other(solid, &ray)
                                                       : mcv_intersect_shape(solid, shape, ray);
    mcv_take_exact_hit(world, met.t, number, met.piece, hit);
}

/* The closer of a hit (or miss, with its t_max) on triangles and one on exact surfaces. */
static __attribute__((noinline)) mcv_hit mcv_intersect_solids(mcv_world world, mcv_vec3 origin,
                                                              mcv_vec3 direction,
                                                              uint origin_surface, mcv_hit hit) {
    for (uint i = 0; i < world.frame->solid_count; ++i)
        mcv_intersect_solid(world, i, origin, direction, origin_surface, &hit);
    return hit;
}

/* The same along a way of any length, in which distances are. */
MCV_FUNCTION mcv_hit mcv_intersect_solids_along(mcv_world world, mcv_vec3 origin, mcv_vec3 way,
                                                uint origin_surface, mcv_hit hit) {
    const float length = mcv_sqrt(mcv_dot(way, way));
    mcv_hit unit = hit;
    unit.t *= length;
    unit = mcv_intersect_solids(world, origin, mcv_scale(way, 1.0f / length), origin_surface, unit);
    if (unit.triangle != hit.triangle) {
        hit = unit;
        hit.t /= length;
    }
    return hit;
}

/* ---- where a ray has met one
 * ------------------------------------------------------------------------------------ */

/* The unit gradient of a piece's equation at p, outwards, and how far p lies outside of it; of a
 * conic, a cylinder or a ball. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_quadric_gradient(__global const mcv_device_solid *solid, uint piece,
                                                mcv_vec3 p, float *outside) {
    const int side = piece == MCV_PIECE_SIDE;
    const mcv_vec3 out = mcv_vec(p.x, p.y, solid->side == MCV_SIDE_SPHERE ? p.z : 0.0f);
    const float distance = mcv_sqrt(mcv_dot(out, out)) - solid->radius;
    __global const mcv_device_cap *cap = solid->cap + (side ? 0u : piece);
    const float w = cap->across, c = cap->curvature, e = 1.0f + cap->conic;
    const float z = p.z - cap->z;
    const mcv_vec3 down =
        mcv_vec(c * w * p.x, c * p.y, mcv_fma(e * c, z, -1.0f)); /* towards the height's fall */
    const float height = z - 0.5f * c * mcv_fma(w * p.x, p.x, mcv_fma(p.y, p.y, e * z * z));
    const float inverse = 1.0f / mcv_sqrt(mcv_dot(down, down));
    const float sign = piece == MCV_PIECE_FIRST_CAP ? inverse : -inverse;
    *outside = side ? distance : -height * sign;
    return mcv_choose(side, mcv_normalize(out), mcv_scale(down, sign));
}

MCV_FUNCTION int mcv_is_quadric(__global const mcv_device_solid *solid, uint piece) {
    return piece == MCV_PIECE_SIDE ? solid->side != MCV_SIDE_BOX : solid->cap[piece].terms == 0u;
}

/* The same of any piece. */
static mcv_vec3 mcv_piece_gradient(__global const mcv_device_solid *solid, uint piece, mcv_vec3 p,
                                   float *outside) {
    if (mcv_is_quadric(solid, piece)) return mcv_quadric_gradient(solid, piece, p, outside);
    if (piece == MCV_PIECE_SIDE) {
        const float x = mcv_abs(p.x) - solid->extent[0], y = mcv_abs(p.y) - solid->extent[1];
        *outside = fmax(x, y);
        return x > y ? mcv_vec(p.x < 0.0f ? -1.0f : 1.0f, 0.0f, 0.0f)
                     : mcv_vec(0.0f, p.y < 0.0f ? -1.0f : 1.0f, 0.0f);
    }
    __global const mcv_device_cap *cap = solid->cap + piece;
    float at;
    const float slope = 2.0f * mcv_cap_slope(cap, mcv_fma(cap->across * p.x, p.x, p.y * p.y), &at);
    const mcv_vec3 down = mcv_vec(slope * cap->across * p.x, slope * p.y, -1.0f);
    const float inverse = 1.0f / mcv_sqrt(mcv_dot(down, down));
    const float sign = piece == MCV_PIECE_FIRST_CAP ? inverse : -inverse;
    *outside = (at - (p.z - cap->z)) * sign;
    return mcv_scale(down, sign);
}

/* The place on a piece; where it is a quadric without branches. */
MCV_LOOP_FUNCTION mcv_surface mcv_exact_surface_on(mcv_world world, uint met, float u,
                                                   mcv_vec3 origin, mcv_vec3 direction, float t,
                                                   int quadric) {
    const uint number = mcv_solid_of(met), piece = mcv_piece_of(met);
    __global const mcv_device_solid *solid = world.solids + number;
    mcv_surface surface;
    float outside;
    mcv_vec3 p = mcv_into_frame(solid, mcv_along(mcv_from_middle(solid, origin), t, direction));
    mcv_vec3 normal = quadric ? mcv_quadric_gradient(solid, piece, p, &outside)
                              : mcv_piece_gradient(solid, piece, p, &outside);
    /* What t has rounded: back along the ray, or straight onto a surface that it grazes. */
    const mcv_vec3 d = mcv_into_frame(solid, direction);
    const float slant = mcv_dot(d, normal);
    p = mcv_choose(mcv_abs(slant) > 0.25f, mcv_along(p, -outside / slant, d),
                   mcv_along(p, -outside, normal));
    normal = quadric ? mcv_quadric_gradient(solid, piece, p, &outside)
                     : mcv_piece_gradient(solid, piece, p, &outside);
    surface.point = mcv_add(mcv_vec(solid->origin[0], solid->origin[1], solid->origin[2]),
                            mcv_out_of_frame(solid, p));
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

static mcv_surface mcv_exact_surface_at(mcv_world world, uint met, float u, mcv_vec3 origin,
                                        mcv_vec3 direction, float t) {
    return mcv_exact_surface_on(world, met, u, origin, direction, t, 0);
}

/* What a ray remembers that leaves a surface in this direction. */
MCV_LOOP_FUNCTION uint mcv_mark_origin_surface(mcv_world world, mcv_surface surface,
                                               mcv_vec3 direction) {
    if (surface.triangle < MCV_EXACT) return MCV_NONE;
    const uint outwards = mcv_dot(direction, surface.face) > 0.0f;
    return mcv_exact_surface(world, surface.triangle) << 1 |
           (mcv_piece_of(surface.triangle) == MCV_PIECE_FIRST_CAP ? 1u - outwards : outwards);
}

#endif
