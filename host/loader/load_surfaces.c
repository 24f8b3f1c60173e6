/* SPDX-License-Identifier: Apache-2.0 */
/* MCVISI_surfaces: lenses and simple bodies with exact surfaces, and the nodes that place them. */
#include "loader/loader.h"

#include "scene/params.h"
#include "scene/solid.h"
#include "scene/surfaces.h"
#include "scene/transform.h"

#include <stdlib.h>

/* --- parameters --- */

#define MCV_X(name, key, NAME) \
    typedef struct mcv_##name##_params { \
        MCV_BODY_##NAME##_PARAMS(MCV_DEFINE_FIELD) char end; \
    } mcv_##name##_params;
MCV_BODIES(MCV_X)
#undef MCV_X

typedef struct lens_surface_params {
    MCV_LENS_SURFACE_PARAMS(MCV_DEFINE_FIELD)
} lens_surface_params;

const char *const mcv_body_types[MCV_BODY_COUNT] = {
#define MCV_X(name, key, NAME) key,
    MCV_BODIES(MCV_X)
#undef MCV_X
};

#define MCV_X(name, key, NAME) \
    static mcv_param_table name##_table(void) { \
        typedef mcv_##name##_params element_params; \
        static const mcv_param rows[] = { \
            MCV_BODY_##NAME##_PARAMS(MCV_PARAM_ROW){MCV_PARAM_number, NULL, 0, 0, 0, 0, NULL}}; \
        return (mcv_param_table){rows, sizeof rows / sizeof rows[0] - 1, sizeof(element_params)}; \
    }
MCV_BODIES(MCV_X)
#undef MCV_X

mcv_param_table mcv_body_table(uint32_t type) {
    switch (type) {
#define MCV_X(name, key, NAME) \
    case MCV_BODY_##NAME: \
        return name##_table();
        MCV_BODIES(MCV_X)
#undef MCV_X
    default:
        return (mcv_param_table){0};
    }
}

mcv_param_table mcv_lens_surface_table(void) {
    typedef lens_surface_params element_params;
    static const mcv_param rows[] = {MCV_LENS_SURFACE_PARAMS(MCV_PARAM_ROW)};
    return (mcv_param_table){rows, sizeof rows / sizeof rows[0], sizeof(element_params)};
}

/* --- one optical surface --- */

static mcv_result read_asphere(const json_t *object, mcv_cap *cap, const mcv_json_path *place,
                               mcv_error *error) {
    json_t *array;
    MCV_TRY(mcv_json_array(object, "asphere", &array, place, error));
    const mcv_json_path here = mcv_json_path_key(place, "asphere");
    const size_t n = json_array_size(array);
    if (n > MCV_ASPHERE_TERMS)
        return mcv_fail_at(&here, error,
                           "has %zu coefficients: at most %d are supported, of r^4 to r^%d", n,
                           MCV_ASPHERE_TERMS, 2 * MCV_ASPHERE_TERMS + 2);
    if (n == 1) { /* mcv_json_numbers reads one number without its array */
        if (!json_is_number(json_array_get(array, 0)))
            return mcv_fail_at(&here, error, "must be an array of numbers");
        cap->asphere[0] = json_number_value(json_array_get(array, 0));
        return MCV_OK;
    }
    return n ? mcv_json_numbers(object, "asphere", n, -DBL_MAX, DBL_MAX, cap->asphere, place, error)
             : MCV_OK;
}

/* Makes a cap from the radius or the curvature. */
static mcv_result make_cap(double radius, double curvature, double conic, bool cylindrical,
                           const json_t *object, mcv_cap *cap, const mcv_json_path *place,
                           mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "radius");
    if (radius == 0) return mcv_fail_at(&here, error, "must not be 0: leave it out for a plane");
    if (!isnan(radius) && !isnan(curvature) && fabs(radius * curvature - 1) > 1e-6)
        return mcv_fail_at(&here, error, "%g m contradicts curvature %g/m: give one of them",
                           radius, curvature);
    *cap = (mcv_cap){.conic = conic, .cylindrical = cylindrical};
    cap->curvature = !isnan(radius) ? 1 / radius : !isnan(curvature) ? curvature : 0;
    return read_asphere(object, cap, place, error);
}

/* --- lenses --- */

typedef struct lens_surface {
    lens_surface_params params;
    mcv_cap cap;
    uint32_t material; /* up to the next surface; MCV_NONE: a gap */
} lens_surface;

static mcv_result read_lens_surface(const mcv_loader *loader, const json_t *object,
                                    lens_surface *surface, const mcv_json_path *place,
                                    mcv_error *error) {
    static const char *const others[] = {"asphere", "material", "name", "extras", NULL};
    if (!json_is_object(object)) return mcv_fail_at(place, error, "must be an object");
    mcv_params_set_defaults(mcv_lens_surface_table(), &surface->params);
    MCV_TRY(
        mcv_params_parse(mcv_lens_surface_table(), object, others, &surface->params, place, error));
    MCV_TRY(mcv_params_check(mcv_lens_surface_table(), &surface->params, place, error));
    const lens_surface_params *p = &surface->params;
    MCV_TRY(make_cap(p->radius, p->curvature, p->conic, p->cylindrical, object, &surface->cap,
                     place, error));
    MCV_TRY(mcv_cap_check(&surface->cap, p->semiDiameter, place, error));
    return mcv_load_find_material(loader, object, "material", &surface->material, place, error);
}

/* The bodies between surfaces with a material. */
static mcv_result assemble_lens(const lens_surface *surfaces, uint32_t n, uint32_t rim,
                                mcv_body *body, const mcv_json_path *place, mcv_error *error) {
    for (uint32_t i = 0; i < n; ++i) {
        const mcv_json_path here = mcv_place_index(place, i);
        const lens_surface *a = surfaces + i, *b = a + 1;
        if (a->material == MCV_NONE) continue;
        if (i + 1 == n)
            return mcv_fail_at(&here, error, "its material needs another surface behind it");
        mcv_solid *solid = body->solids + body->count;
        *solid = (mcv_solid){.side = MCV_SIDE_CYLINDER,
                             .radius = fmax(a->params.semiDiameter, b->params.semiDiameter),
                             .caps = {a->cap, b->cap},
                             .cemented = i > 0 && surfaces[i - 1].material != MCV_NONE,
                             .to_world = mcv_transform_identity()};
        for (int k = 0; k < 2; ++k) {
            const mcv_json_path at = mcv_place_index(place, i + (uint32_t)k);
            MCV_TRY(mcv_cap_check(solid->caps + k, solid->radius, &at, error));
        }
        MCV_TRY(mcv_solid_check(solid, &here, error));
        body->materials[2 * body->count] = a->material;
        body->materials[2 * body->count++ + 1] = rim;
    }
    /* A gap between two bodies must have a width. */
    for (uint32_t i = 1; i + 2 < n; ++i) {
        const mcv_json_path here = mcv_place_index(place, i);
        const mcv_solid gap = {
            .side = MCV_SIDE_CYLINDER,
            .radius = fmin(surfaces[i].params.semiDiameter, surfaces[i + 1].params.semiDiameter),
            .caps = {surfaces[i].cap, surfaces[i + 1].cap},
            .to_world = mcv_transform_identity()};
        const bool between = surfaces[i].material == MCV_NONE &&
                             surfaces[i - 1].material != MCV_NONE &&
                             surfaces[i + 1].material != MCV_NONE;
        if (between) MCV_TRY(mcv_solid_check(&gap, &here, error));
    }
    return body->count ? MCV_OK
                       : mcv_fail_at(place, error,
                                     "no surface has a material: name one of the file's materials");
}

static mcv_result define_lens(mcv_loader *loader, const json_t *object, mcv_body *body,
                              const mcv_json_path *place, mcv_error *error) {
    json_t *array;
    uint32_t rim;
    MCV_TRY(mcv_json_array(object, "surfaces", &array, place, error));
    const mcv_json_path here = mcv_json_path_key(place, "surfaces");
    const uint32_t n = (uint32_t)json_array_size(array);
    if (n < 2 || n > MCV_MAX_SOLIDS)
        return mcv_fail_at(&here, error, "must be an array of 2 to %d surfaces", MCV_MAX_SOLIDS);
    MCV_TRY(mcv_load_find_material(loader, object, "rim", &rim, place, error));
    if (rim == MCV_NONE) MCV_TRY(mcv_load_absorber(loader, &rim, error));
    lens_surface *surfaces = calloc(n, sizeof *surfaces);
    body->solids = calloc(n, sizeof *body->solids);
    body->materials = calloc(n, 2 * sizeof *body->materials);
    const bool memory = surfaces && body->solids && body->materials;
    mcv_result result = memory ? MCV_OK : mcv_fail_memory(place, error);
    double z = 0;
    for (uint32_t i = 0; i < n && memory && result == MCV_OK; ++i) {
        const mcv_json_path at = mcv_place_index(&here, i);
        result = read_lens_surface(loader, json_array_get(array, i), surfaces + i, &at, error);
        surfaces[i].cap.z = z;
        z += surfaces[i].params.thickness;
    }
    if (memory && result == MCV_OK) result = assemble_lens(surfaces, n, rim, body, &here, error);
    free(surfaces);
    return result;
}

/* --- other bodies --- */

/* One solid; its params have been checked. */
static mcv_result make_solid(uint32_t type, const void *params, const json_t *object,
                             mcv_solid *solid, const mcv_json_path *place, mcv_error *error) {
    *solid = (mcv_solid){.to_world = mcv_transform_identity()};
    if (type == MCV_BODY_OPEN_SURFACE) {
        const mcv_open_surface_params *p = params;
        solid->side = MCV_SIDE_OPEN;
        solid->radius = p->semiDiameter;
        solid->hole = p->holeRadius;
        return make_cap(p->radius, p->curvature, p->conic, p->cylindrical, object, solid->caps,
                        place, error);
    }
    if (type == MCV_BODY_DISC) {
        const mcv_disc_params *p = params;
        solid->side = MCV_SIDE_OPEN;
        solid->radius = p->radius;
        solid->hole = p->holeRadius;
    } else if (type == MCV_BODY_BOX) {
        const mcv_box_params *p = params;
        solid->side = MCV_SIDE_BOX;
        solid->half[0] = p->width / 2;
        solid->half[1] = p->height / 2;
        solid->caps[0].z = -p->depth / 2;
        solid->caps[1].z = p->depth / 2;
    } else if (type == MCV_BODY_CYLINDER) {
        const mcv_cylinder_params *p = params;
        solid->side = MCV_SIDE_CYLINDER;
        solid->radius = p->radius;
        solid->caps[0].z = -p->length / 2;
        solid->caps[1].z = p->length / 2;
    } else {
        solid->side = MCV_SIDE_SPHERE;
        solid->radius = ((const mcv_sphere_params *)params)->radius;
    }
    return MCV_OK;
}

static mcv_result define_body(mcv_loader *loader, const json_t *object, mcv_body *body,
                              const mcv_json_path *place, mcv_error *error) {
    static const char *const others[] = {"name", "type", "material", "extras", "extensions", NULL};
    static const char *const of_lens[] = {"name",   "type",       "surfaces", "rim",
                                          "extras", "extensions", NULL};
    static const char *const of_surface[] = {"name",   "type",       "asphere", "material",
                                             "extras", "extensions", NULL};
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_BODIES(MCV_X)
#undef MCV_X
    } params;
    uint32_t type;
    body->name = mcv_json_name(object);
    MCV_TRY(mcv_element_type(object, mcv_body_types, MCV_BODY_COUNT, &type, place, error));
    const mcv_param_table table = mcv_body_table(type);
    const char *const *keys = type == MCV_BODY_LENS           ? of_lens
                              : type == MCV_BODY_OPEN_SURFACE ? of_surface
                                                              : others;
    mcv_params_set_defaults(table, &params);
    MCV_TRY(mcv_params_parse(table, object, keys, &params, place, error));
    MCV_TRY(mcv_params_check(table, &params, place, error));
    if (type == MCV_BODY_LENS) return define_lens(loader, object, body, place, error);
    body->solids = calloc(1, sizeof *body->solids);
    body->materials = calloc(2, sizeof *body->materials);
    if (!body->solids || !body->materials) return mcv_fail_memory(place, error);
    body->count = 1;
    MCV_TRY(make_solid(type, &params, object, body->solids, place, error));
    MCV_TRY(mcv_solid_check(body->solids, place, error));
    MCV_TRY(mcv_load_find_material(loader, object, "material", body->materials, place, error));
    body->materials[1] = body->materials[0];
    return MCV_OK;
}

mcv_result mcv_load_bodies(mcv_loader *loader, mcv_error *error) {
    json_t *array;
    MCV_TRY(mcv_load_array(loader, "MCVISI_surfaces", "surfaces", &array, error));
    const size_t count = json_array_size(array);
    loader->bodies = calloc(count + 1, sizeof *loader->bodies);
    if (!loader->bodies) return mcv_fail_memory(&loader->file, error);
    loader->body_count = count;
    const mcv_json_path place = mcv_json_path_key(&loader->file, "surfaces");
    for (size_t i = 0; i < count; ++i) {
        const json_t *object = json_array_get(array, i);
        const mcv_json_path here = mcv_json_path_element(&place, mcv_json_name(object), i);
        MCV_TRY(define_body(loader, object, loader->bodies + i, &here, error));
    }
    return MCV_OK;
}

void mcv_load_free_bodies(mcv_loader *loader) {
    for (size_t i = 0; i < loader->body_count; ++i) {
        free(loader->bodies[i].solids);
        free(loader->bodies[i].materials);
    }
    free(loader->bodies);
}

/* --- what a node places --- */

mcv_result mcv_load_body(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                         const mcv_json_path *place, mcv_error *error) {
    uint32_t index;
    mcv_transform frame;
    MCV_TRY(mcv_load_reference(node, "MCVISI_surfaces", "surface", loader->body_count, "surfaces",
                               &index, place, error));
    if (index == MCV_NONE) return MCV_OK;
    const mcv_body *body = loader->bodies + index;
    if (!mcv_transform_rigid(to_world, &frame))
        return mcv_fail_at(place, error, "its scale must not be 0");
    for (uint32_t i = 0; i < body->count; ++i) {
        uint32_t material = body->materials[2 * i], rim = body->materials[2 * i + 1];
        mcv_solid solid = body->solids[i];
        if (material == MCV_NONE) MCV_TRY(mcv_load_plain(loader, &material, error));
        if (rim == MCV_NONE) rim = material;
        MCV_TRY(mcv_solid_check_materials(&solid, loader->scene, material, rim, place, error));
        solid.to_world = frame;
        MCV_TRY(
            mcv_scene_add_solid(loader->scene, &solid, mcv_json_name(node), material, rim, error));
    }
    return MCV_OK;
}
