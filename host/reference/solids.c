/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/solids.h"

#include "mcvisi/surfaces/solid.h"

enum { SAMPLES = 400, HALVINGS = 80 };

static ref_vec column(const mcv_solid *solid, int k) {
    const double *m = solid->to_world.m;
    return (ref_vec){m[k], m[3 + k], m[6 + k]};
}

static ref_vec turn_in(const mcv_solid *solid, ref_vec v) {
    return (ref_vec){ref_dot(column(solid, 0), v), ref_dot(column(solid, 1), v),
                     ref_dot(column(solid, 2), v)};
}

static ref_vec turn_out(const mcv_solid *solid, ref_vec v) {
    return ref_add(ref_scale(v.x, column(solid, 0)),
                   ref_add(ref_scale(v.y, column(solid, 1)), ref_scale(v.z, column(solid, 2))));
}

static ref_vec place_in(const mcv_solid *solid, ref_vec point) {
    return turn_in(solid, ref_sub(point, ref_from(solid->to_world.m + 9)));
}

static ref_vec along(ref_vec p, double t, ref_vec d) { return ref_add(p, ref_scale(t, d)); }

/* --- caps --- */

static double square_radius(const mcv_cap *cap, double x, double y) {
    return cap->cylindrical ? y * y : x * x + y * y;
}

static bool has_terms(const mcv_cap *cap) {
    bool any = false;
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i) any = any || cap->asphere[i] != 0;
    return any;
}

/* Height of the surface over its vertex, and its derivative by r². */
static double height(const mcv_cap *cap, double r2, double *slope) {
    const double c = cap->curvature, root = sqrt(fmax(1 - (1 + cap->conic) * c * c * r2, 0));
    double z = c * r2 / (1 + root);
    if (slope) *slope = c / (2 * root);
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i) {
        z += cap->asphere[i] * pow(r2, i + 2);
        if (slope) *slope += (i + 2) * cap->asphere[i] * pow(r2, i + 1);
    }
    return z;
}

static double above(const mcv_cap *cap, ref_vec p) {
    return p.z - cap->z - height(cap, square_radius(cap, p.x, p.y), NULL);
}

/* The side of the solid as a bound of (x, y). */
static bool within(const mcv_solid *solid, ref_vec p) {
    if (solid->side == MCV_SIDE_BOX)
        return fabs(p.x) <= solid->half[0] && fabs(p.y) <= solid->half[1];
    const double r = hypot(p.x, p.y);
    return r <= solid->radius && (solid->side != MCV_SIDE_OPEN || r >= solid->hole);
}

static double largest_radius(const mcv_solid *solid) {
    return solid->side == MCV_SIDE_BOX ? hypot(solid->half[0], solid->half[1]) : solid->radius;
}

static int meet_conic(const mcv_cap *cap, ref_vec p, ref_vec d, bool on, double roots[2]) {
    const double c = cap->curvature, k = cap->conic, z = p.z - cap->z,
                 x_part = cap->cylindrical ? 0 : 1;
    /* c (x² + y² + (1 + k) z²) - 2 z = second t² + 2 first t + constant */
    const double second = c * (x_part * d.x * d.x + d.y * d.y + (1 + k) * d.z * d.z);
    const double first = c * (x_part * d.x * p.x + d.y * p.y + (1 + k) * d.z * z) - d.z;
    const double constant = on ? 0 : c * (x_part * p.x * p.x + p.y * p.y + (1 + k) * z * z) - 2 * z;
    int n = 0, kept = 0;
    double all[2];
    if (on) {
        if (second != 0) all[n++] = -2 * first / second;
    } else {
        const double discriminant = first * first - second * constant;
        if (discriminant < 0) return 0;
        const double sum = -first - copysign(sqrt(discriminant), first);
        if (sum != 0) all[n++] = constant / sum;
        if (second != 0) all[n++] = sum / second;
    }
    for (int i = 0; i < n; ++i)
        if (1 - (1 + k) * c * (z + all[i] * d.z) > 0)
            roots[kept++] = all[i]; /* not the other sheet, or half */
    return kept;
}

/* The height above an asphere at t; where the ray starts on it, divided by t. */
static double above_at(const mcv_cap *cap, ref_vec p, ref_vec d, bool on, double t) {
    if (on && t == 0) {
        double slope;
        height(cap, square_radius(cap, p.x, p.y), &slope);
        return d.z - 2 * slope * ((cap->cylindrical ? 0 : p.x * d.x) + p.y * d.y);
    }
    return above(cap, along(p, t, d)) / (on ? t : 1);
}

static int meet_asphere(const mcv_solid *solid, const mcv_cap *cap, ref_vec p, ref_vec d, bool on,
                        double roots[REF_MEETINGS]) {
    /* The ray within the cylinder, and the ball about the vertex that holds all of the cap. */
    const double radius = largest_radius(solid),
                 reach = 4 * radius + fabs(height(cap, radius * radius, NULL));
    const ref_vec vertex = {0, 0, cap->z};
    const double middle = ref_dot(ref_sub(vertex, p), d),
                 aside = ref_length(ref_sub(along(p, middle, d), vertex));
    if (aside > reach) return 0;
    const double half = sqrt(reach * reach - aside * aside);
    double low = fmax(middle - half, 0), high = middle + half;
    const double a = d.x * d.x + d.y * d.y, b = p.x * d.x + p.y * d.y,
                 c = p.x * p.x + p.y * p.y - radius * radius;
    if (a > 0) {
        const double discriminant = b * b - a * c;
        if (discriminant <= 0) return 0;
        low = fmax(low, (-b - sqrt(discriminant)) / a - 1e-12 * reach);
        high = fmin(high, (-b + sqrt(discriminant)) / a + 1e-12 * reach);
    } else if (c > 0) {
        return 0;
    }
    int n = 0;
    double t0 = low, g0 = above_at(cap, p, d, on, t0);
    for (int i = 1; i <= SAMPLES && n < REF_MEETINGS && low < high; ++i) {
        const double t1 = low + (high - low) * i / SAMPLES, g1 = above_at(cap, p, d, on, t1);
        if ((g0 > 0) != (g1 > 0)) {
            double left = t0, right = t1;
            for (int k = 0; k < HALVINGS; ++k) {
                const double half_way = (left + right) / 2;
                if ((above_at(cap, p, d, on, half_way) > 0) == (g0 > 0))
                    left = half_way;
                else
                    right = half_way;
            }
            roots[n++] = (left + right) / 2;
        }
        t0 = t1, g0 = g1;
    }
    return n;
}

static int meet_cap(const mcv_solid *solid, int piece, ref_vec p, ref_vec d, bool on,
                    double distances[REF_MEETINGS]) {
    const mcv_cap *cap = solid->caps + piece;
    double roots[REF_MEETINGS];
    const int n = has_terms(cap) ? meet_asphere(solid, cap, p, d, on, roots)
                                 : meet_conic(cap, p, d, on, roots);
    int kept = 0;
    for (int i = 0; i < n; ++i)
        if (roots[i] > 0 && within(solid, along(p, roots[i], d))) distances[kept++] = roots[i];
    return kept;
}

/* --- sides --- */

static bool between_caps(const mcv_solid *solid, ref_vec p) {
    return solid->side == MCV_SIDE_SPHERE ||
           (above(solid->caps, p) >= 0 && above(solid->caps + 1, p) <= 0);
}

static int meet_round_side(const mcv_solid *solid, ref_vec p, ref_vec d, bool on,
                           double distances[REF_MEETINGS]) {
    const double z = solid->side == MCV_SIDE_SPHERE ? 1 : 0;
    const double a = d.x * d.x + d.y * d.y + z * d.z * d.z,
                 b = p.x * d.x + p.y * d.y + z * p.z * d.z;
    const double c = on ? 0 : p.x * p.x + p.y * p.y + z * p.z * p.z - solid->radius * solid->radius;
    const double discriminant = b * b - a * c;
    double roots[2];
    int n = 0, kept = 0;
    if (discriminant < 0 || a == 0) return 0;
    const double sum = -b - copysign(sqrt(discriminant), b);
    if (!on && sum != 0) roots[n++] = c / sum;
    roots[n++] = on ? -2 * b / a : sum / a;
    for (int i = 0; i < n; ++i)
        if (roots[i] > 0 && between_caps(solid, along(p, roots[i], d)))
            distances[kept++] = roots[i];
    return kept;
}

static int meet_box_side(const mcv_solid *solid, ref_vec p, ref_vec d, bool on,
                         double distances[REF_MEETINGS]) {
    const double at[2] = {p.x, p.y}, direction[2] = {d.x, d.y};
    /* The face it starts on: the one that it is nearest to. */
    double nearest = INFINITY;
    int start = -1, kept = 0;
    for (int face = 0; face < 4; ++face) {
        const double off = fabs(at[face / 2] - (face % 2 ? 1 : -1) * solid->half[face / 2]);
        if (on && off < nearest) nearest = off, start = face;
    }
    for (int face = 0; face < 4; ++face) {
        const int axis = face / 2;
        const double t = ((face % 2 ? 1 : -1) * solid->half[axis] - at[axis]) / direction[axis];
        const ref_vec there = along(p, t, d);
        const double other = axis ? there.x : there.y;
        if (face == start || !(t > 0) || !isfinite(t)) continue;
        if (fabs(other) <= solid->half[1 - axis] && between_caps(solid, there))
            distances[kept++] = t;
    }
    return kept;
}

/* --- pieces --- */

int ref_meet_piece(const mcv_solid *solid, int piece, ref_vec origin, ref_vec direction, bool on,
                   double distances[REF_MEETINGS]) {
    const ref_vec p = place_in(solid, origin), d = turn_in(solid, direction);
    if (piece == MCV_PIECE_SIDE) {
        if (solid->side == MCV_SIDE_OPEN) return 0;
        return solid->side == MCV_SIDE_BOX ? meet_box_side(solid, p, d, on, distances)
                                           : meet_round_side(solid, p, d, on, distances);
    }
    if (solid->side == MCV_SIDE_SPHERE || (solid->side == MCV_SIDE_OPEN && piece > 0)) return 0;
    return meet_cap(solid, piece, p, d, on, distances);
}

void ref_on_piece(const mcv_solid *solid, int piece, ref_vec *position, ref_vec *normal) {
    ref_vec p = place_in(solid, *position), n;
    if (piece != MCV_PIECE_SIDE) {
        const mcv_cap *cap = solid->caps + piece;
        double slope;
        height(cap, square_radius(cap, p.x, p.y), &slope);
        /* Towards smaller heights; upright where a hemisphere ends. */
        n = isfinite(slope)
                ? ref_unit((ref_vec){cap->cylindrical ? 0 : 2 * slope * p.x, 2 * slope * p.y, -1})
                : ref_scale(copysign(1, cap->curvature),
                            ref_unit((ref_vec){cap->cylindrical ? 0 : p.x, p.y, 0}));
        p = along(p, above(cap, p) * -n.z, n); /* on the tangent plane, to first order */
        if (piece == MCV_PIECE_SECOND_CAP) n = ref_scale(-1, n);
    } else if (solid->side == MCV_SIDE_BOX) {
        const bool x = fabs(p.x) - solid->half[0] > fabs(p.y) - solid->half[1];
        n = (ref_vec){x ? copysign(1, p.x) : 0, x ? 0 : copysign(1, p.y), 0};
        if (x)
            p.x = copysign(solid->half[0], p.x);
        else
            p.y = copysign(solid->half[1], p.y);
    } else {
        n = ref_unit((ref_vec){p.x, p.y, solid->side == MCV_SIDE_SPHERE ? p.z : 0});
        p = along(p, solid->radius - ref_dot(p, n), n);
    }
    *position = ref_add(ref_from(solid->to_world.m + 9), turn_out(solid, p));
    *normal = turn_out(solid, n);
}

bool ref_solid_holds(const mcv_solid *solid, ref_vec point) {
    const ref_vec p = place_in(solid, point);
    if (solid->side == MCV_SIDE_OPEN) return false;
    if (solid->side == MCV_SIDE_SPHERE) return ref_length(p) < solid->radius;
    return within(solid, p) && between_caps(solid, p);
}
