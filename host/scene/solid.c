/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/solid.h"

#include "scene/transform.h"
#include "scene/materials.h"
#include "scene/params.h"

#include <math.h>

/* Radii at which a surface is looked at. */
enum { PLACES = 64 };

bool mcv_cap_is_asphere(const mcv_cap *cap) {
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i)
        if (cap->asphere[i] != 0) return true;
    return false;
}

static double sag(const mcv_cap *cap, double r2) {
    const double c = cap->curvature;
    double terms = 0;
    for (int i = MCV_ASPHERE_TERMS - 1; i >= 0; --i) terms = (terms + cap->asphere[i]) * r2;
    return c * r2 / (1 + sqrt(1 - (1 + cap->conic) * c * c * r2)) + terms * r2;
}

double mcv_cap_height(const mcv_cap *cap, double x, double y) {
    return cap->z + sag(cap, (cap->cylindrical ? 0 : x * x) + y * y);
}

double mcv_cap_bend(const mcv_cap *cap, double radius) {
    const double c = cap->curvature;
    double most = 0;
    for (int k = 0; k <= PLACES; ++k) {
        const double r = radius * k / PLACES, root = sqrt(1 - (1 + cap->conic) * c * c * r * r);
        double first = c / root, second = c / (root * root * root), power = r * r;
        for (int i = 0; i < MCV_ASPHERE_TERMS; ++i, power *= r * r) {
            const int n = 2 * i + 4;
            first += n * cap->asphere[i] * power;
            second += n * (n - 1) * cap->asphere[i] * power;
        }
        most = fmax(most, fmax(fabs(first), fabs(second)));
    }
    return most * 1.25; /* polynomials of degree 18 at most, between 64 places */
}

mcv_result mcv_cap_check(const mcv_cap *cap, double radius, const mcv_json_path *place,
                         mcv_error *error) {
    const double c = cap->curvature, rest = 1 - (1 + cap->conic) * c * c * radius * radius;
    const double largest = 1 / (fabs(c) * sqrt(1 + cap->conic));
    if (!isfinite(c) || !isfinite(cap->conic) || !isfinite(cap->z))
        return mcv_fail_at(place, error, "must be finite");
    if (rest < -1e-12) /* a hemisphere whose numbers are rounded */
        return mcv_fail_at(place, error,
                           "a semi-diameter of %g m lies beyond the surface, which ends at %g m "
                           "from the axis (radius %g m, conic %g)",
                           radius, largest, 1 / c, cap->conic);
    if (mcv_cap_is_asphere(cap) && rest < 1e-3)
        return mcv_fail_at(
            place, error,
            "an asphere must end before its base becomes vertical, at %g m from the axis; its "
            "semi-diameter is %g m",
            largest, radius);
    if (!isfinite(
            sag(cap, fmin(radius * radius, isfinite(largest) ? largest * largest : INFINITY))))
        return mcv_fail_at(place, error, "has no finite sag at its semi-diameter of %g m", radius);
    return MCV_OK;
}

static double reach(const mcv_solid *solid) {
    return solid->side == MCV_SIDE_BOX ? hypot(solid->half[0], solid->half[1]) : solid->radius;
}

/* The least and the most of a cap's height within the side. */
static void height_range(const mcv_solid *solid, const mcv_cap *cap, double *low, double *high) {
    *low = INFINITY, *high = -INFINITY;
    for (int k = 0; k <= PLACES; ++k) {
        const double z = mcv_cap_height(cap, 0, reach(solid) * (1 - 1e-15) * k / PLACES);
        *low = fmin(*low, z), *high = fmax(*high, z);
    }
    /* Between two places it bends by this much at most. */
    const double step = reach(solid) / PLACES,
                 more = mcv_cap_is_asphere(cap) ? mcv_cap_bend(cap, reach(solid)) * step * step / 8
                                                : 0;
    *low -= more, *high += more;
}

static mcv_result check_gap(const mcv_solid *solid, const mcv_json_path *place, mcv_error *error) {
    const double edge = reach(solid), rounding = 1e-9 * edge;
    double most = -INFINITY;
    for (int i = 0; i <= PLACES; ++i)
        for (int k = 0;
             k <= (solid->caps[0].cylindrical || solid->caps[1].cylindrical ? PLACES : 0); ++k) {
            const double r = edge * (1 - 1e-15) * i / PLACES, angle = M_PI / 2 * k / PLACES,
                         x = r * sin(angle), y = r * cos(angle);
            const double gap =
                mcv_cap_height(solid->caps + 1, x, y) - mcv_cap_height(solid->caps, x, y);
            most = fmax(most, gap);
            if (!(gap >= -rounding))
                return mcv_fail_at(place, error,
                                   "its surfaces intersect: %g m from the axis the second lies %g "
                                   "m before the first",
                                   r, -gap);
        }
    return most > 0 ? MCV_OK : mcv_fail_at(place, error, "has no thickness");
}

mcv_result mcv_solid_check(const mcv_solid *solid, const mcv_json_path *place, mcv_error *error) {
    if (!(reach(solid) > 0) || !isfinite(reach(solid)))
        return mcv_fail_at(place, error, "must have a size above 0");
    for (int i = 0; i < 12; ++i)
        if (!isfinite(solid->to_world.m[i]))
            return mcv_fail_at(place, error, "its transform must be finite");
    if (solid->side == MCV_SIDE_SPHERE) return MCV_OK;
    if (!(solid->hole < solid->radius) && solid->side == MCV_SIDE_OPEN)
        return mcv_fail_at(place, error,
                           "its hole of radius %g m must be smaller than its own radius, %g m",
                           solid->hole, solid->radius);
    for (int i = 0; i < (solid->side == MCV_SIDE_OPEN ? 1 : 2); ++i)
        MCV_TRY(mcv_cap_check(solid->caps + i, reach(solid), place, error));
    return solid->side == MCV_SIDE_OPEN ? MCV_OK : check_gap(solid, place, error);
}

static mcv_result check_material(const mcv_solid *solid, const mcv_scene *scene, uint32_t material,
                                 const mcv_json_path *place, mcv_error *error) {
    const mcv_material *m = scene->materials + material;
    if (m->texture != MCV_NONE || mcv_material_surface_texture(m) != MCV_NONE)
        return mcv_fail_at(place, error,
                           "material \"%s\" has a texture, but exact surfaces have no texture "
                           "coordinates: choose another",
                           m->name);
    if (mcv_material_roughness(m).anisotropy > 0)
        return mcv_fail_at(
            place, error,
            "material \"%s\" is anisotropic, but exact surfaces have no tangents: choose another",
            m->name);
    if (solid->side == MCV_SIDE_OPEN && mcv_material_has_medium(m->type))
        return mcv_fail_at(
            place, error,
            "material \"%s\" fills a body, but an open surface has no inside: use a lens", m->name);
    return MCV_OK;
}

static bool passes_light(const mcv_material *m) {
    const double *share = mcv_params_find(mcv_material_table(m->type), "transmittance", &m->as);
    if (share) return share[0] + share[1] + share[2] > 0;
    if (m->type == MCV_MATERIAL_METALLIC_ROUGHNESS)
        return m->as.metallic_roughness.transmission > 0 ||
               m->as.metallic_roughness.diffuseTransmission > 0;
    return mcv_material_has_medium(m->type) || mcv_material_is_plate(m->type);
}

/* Light that came out of glass by an edge of something else would not know that it has. */
static mcv_result check_rim(const mcv_scene *scene, uint32_t material, uint32_t rim,
                            const mcv_json_path *place, mcv_error *error) {
    const mcv_material *body = scene->materials + material, *edge = scene->materials + rim;
    if (rim == material || !passes_light(edge) ||
        (!mcv_material_has_medium(body->type) && !mcv_material_has_medium(edge->type)))
        return MCV_OK;
    return mcv_fail_at(
        place, error,
        "the rim \"%s\" transmits light, but is not the body's material: choose an opaque "
        "one or \"%s\"",
        edge->name, body->name);
}

mcv_result mcv_solid_check_materials(const mcv_solid *solid, const mcv_scene *scene, uint32_t body,
                                     uint32_t rim, const mcv_json_path *place, mcv_error *error) {
    if (body >= scene->material_count || rim >= scene->material_count)
        return mcv_fail_at(place, error, "its material does not exist");
    MCV_TRY(check_material(solid, scene, body, place, error));
    MCV_TRY(check_material(solid, scene, rim, place, error));
    return check_rim(scene, body, rim, place, error);
}

void mcv_solid_box(const mcv_solid *solid, float corners[24]) {
    const bool box = solid->side == MCV_SIDE_BOX;
    double lower[3] = {box ? -solid->half[0] : -solid->radius,
                       box ? -solid->half[1] : -solid->radius, -solid->radius};
    double upper[3] = {-lower[0], -lower[1], solid->radius}, unused;
    if (solid->side != MCV_SIDE_SPHERE) {
        height_range(solid, solid->caps, lower + 2, upper + 2);
        if (solid->side != MCV_SIDE_OPEN) height_range(solid, solid->caps + 1, &unused, upper + 2);
    }
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) {
            const float at = (float)((i >> k & 1) ? upper[k] : lower[k]);
            corners[3 * i + k] = nextafterf(at, (i >> k & 1) ? INFINITY : -INFINITY);
        }
}

bool mcv_solid_holds(const mcv_solid *solid, const double point[3]) {
    const double *m = solid->to_world.m,
                 d[3] = {point[0] - m[9], point[1] - m[10], point[2] - m[11]};
    double p[3];
    for (int k = 0; k < 3; ++k) p[k] = m[k] * d[0] + m[3 + k] * d[1] + m[6 + k] * d[2];
    const double r = hypot(p[0], p[1]);
    if (solid->side == MCV_SIDE_OPEN) return false;
    if (solid->side == MCV_SIDE_SPHERE) return hypot(r, p[2]) < solid->radius;
    if (solid->side == MCV_SIDE_BOX ? fabs(p[0]) > solid->half[0] || fabs(p[1]) > solid->half[1]
                                    : r > solid->radius)
        return false;
    return p[2] > mcv_cap_height(solid->caps, p[0], p[1]) &&
           p[2] < mcv_cap_height(solid->caps + 1, p[0], p[1]);
}
