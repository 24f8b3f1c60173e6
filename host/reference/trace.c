/* SPDX-License-Identifier: Apache-2.0 */
/* mcv_reference_trace: single paths, deterministic at interfaces. */
#include <stdlib.h>

#include "reference/gloss.h"
#include "reference/interface.h"
#include "reference/path.h"
#include "reference/plate.h"
#include "reference/reference.h"
#include "reference/retroreflector.h"
#include "reference/texture.h"
#include "scene/materials.h"

typedef struct vertices {
    mcv_vertex *items;
    size_t count, capacity;
} vertices;

static mcv_result append(vertices *all, mcv_vertex vertex, mcv_error *error) {
    if (all->count == all->capacity) {
        const size_t capacity = all->capacity ? 2 * all->capacity : 1024;
        mcv_vertex *items = realloc(all->items, capacity * sizeof *items);
        if (!items)
            return mcv_fail(error, MCV_FAILED,
                            "trace: no memory for %zu vertices; trace fewer rays at a time",
                            capacity);
        all->items = items;
        all->capacity = capacity;
    }
    all->items[all->count++] = vertex;
    return MCV_OK;
}

static void store(double out[3], ref_vec v) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

/* The surface of a body: as bend, but for the direction of reflected rays. */
static void bend_at_glass(const mcv_scene *scene, const mcv_material *material,
                          const ref_interaction *interaction, const ref_hits *hits,
                          ref_vec *direction, ref_media *media, mcv_vertex *vertex) {
    ref_media beyond;
    ref_media_cross_all(media, &beyond, hits->count, hits->instances, hits->fronts);
    const double from = ref_media_ior(ref_media_filling(media, scene), 0),
                 to = ref_media_ior(ref_media_filling(&beyond, scene), 0);
    if (mcv_material_is_rough(material) && from != to) return;
    double reflectance = ref_reflectance(interaction, from, to);
    if (from != to)
        reflectance = ref_coated(
            reflectance, mcv_material_coating(material, interaction->front ? from : to), from, to);
    vertex->event = reflectance == 1 ? MCV_EVENT_REFLECT
                    : from == to     ? MCV_EVENT_PASS
                                     : MCV_EVENT_REFRACT;
    if (vertex->event == MCV_EVENT_REFLECT) return;
    vertex->transmittance *= 1 - reflectance;
    *direction = ref_refract(interaction, from, to);
    *media = beyond;
}

/* Reflects or refracts the ray at a surface and completes the vertex: direction, event,
 * transmittance. False: the path ends. */
static bool bend(const mcv_scene *scene, const ref_surface *surface, const ref_hits *hits,
                 ref_vec *direction, ref_media *media, mcv_vertex *vertex) {
    const mcv_material *material = &scene->materials[scene->instances[surface->instance].material];
    const double ior = ref_media_ior(ref_media_filling(media, scene), 0);
    double texture[3];
    ref_texture_lookup(scene, material->texture, surface->texcoord, texture);
    const ref_interaction interaction = ref_make_interaction(surface, *direction);
    vertex->event = MCV_EVENT_NON_SPECULAR;
    store(vertex->normal, interaction.normal);
    switch (material->type) {
    case MCV_MATERIAL_MIRROR:
        vertex->event = MCV_EVENT_REFLECT;
        vertex->transmittance *= material->as.mirror.reflectance[0] * texture[0];
        break;
    case MCV_MATERIAL_RETROREFLECTOR:
        if (material->as.retroreflector.divergence > 0) break;
        vertex->event = MCV_EVENT_REFLECT;
        vertex->transmittance *=
            material->as.retroreflector.reflectance[0] *
            ref_retroreflector_efficiency(
                &material->as.retroreflector,
                (ref_vec){ref_length(ref_cross(*direction, interaction.normal)), 0,
                          -ref_dot(*direction, interaction.normal)});
        *direction = ref_scale(-1, *direction);
        return true;
    case MCV_MATERIAL_CONDUCTOR:
        if (mcv_material_is_rough(material)) break;
        vertex->event = MCV_EVENT_REFLECT;
        vertex->transmittance *= ref_conductor_reflectance(
            material->as.conductor.n[0] / ior, material->as.conductor.k[0] / ior,
            fmin(-ref_dot(*direction, interaction.normal), 1));
        break;
#define MCV_X(name, key, NAME) case MCV_MATERIAL_##NAME:
        MCV_PLATES(MCV_X)
#undef MCV_X
        {
            const ref_plate plate = ref_plate_at(material, &interaction, ior, texture);
            const bool all = plate.reflected[0] == 1; /* as under total reflection */
            vertex->event = all ? MCV_EVENT_REFLECT : MCV_EVENT_PASS;
            if (!all) vertex->transmittance *= plate.passed[0];
            break;
        }
    case MCV_MATERIAL_DIELECTRIC:
        bend_at_glass(scene, material, &interaction, hits, direction, media, vertex);
        break;
    default:
        break;
    }
    if (vertex->event == MCV_EVENT_REFLECT) *direction = ref_reflect(&interaction);
    return vertex->event != MCV_EVENT_NON_SPECULAR;
}

static mcv_result trace_ray(const ref_world *world, ref_media media, uint32_t ray, ref_vec origin,
                            ref_vec direction, vertices *all, mcv_error *error) {
    const mcv_scene *scene = world->scene;
    mcv_vertex vertex = {
        .ray = ray, .primitive = MCV_NONE, .event = MCV_EVENT_START, .transmittance = 1};
    store(vertex.position, origin);
    store(vertex.direction, direction);
    vertex.ior = ref_media_ior(ref_media_filling(&media, scene), 0);
    MCV_TRY(append(all, vertex, error));
    bool goes_on = true;
    ref_skip skip = {0};
    while (goes_on && vertex.index < world->depth) {
        const mcv_medium_params *filling = ref_media_filling(&media, scene);
        const double squared = vertex.ior * vertex.ior;
        ref_hit hit;
        ++vertex.index;
        if (ref_next_hit(&world->geometry, origin, direction, &skip, &hit)) {
            const ref_surface surface = ref_surface_at(&world->geometry, &hit);
            double emitted[3];
            ref_emitted(scene, &surface, ref_scale(-1, direction), emitted);
            const ref_hits hits = ref_hits_at(&world->geometry, origin, direction, &skip, &hit);
            skip = hits.numbers;
            origin = surface.position;
            vertex.distance = hit.distance;
            vertex.primitive = surface.number;
            vertex.radiance = emitted[0] / squared;
            if (filling) vertex.transmittance *= exp(-filling->absorption[0] * hit.distance);
            store(vertex.position, origin);
            goes_on = bend(scene, &surface, &hits, &direction, &media, &vertex);
        } else {
            goes_on = false;
            vertex.distance = INFINITY;
            vertex.primitive = MCV_NONE;
            vertex.event = MCV_EVENT_MISS;
            double sky[3];
            ref_environment(scene, &world->emitters, direction, sky);
            vertex.radiance = sky[0] / squared;
            if (filling && filling->absorption[0] > 0) vertex.transmittance = 0;
            store(vertex.normal, (ref_vec){0, 0, 0});
        }
        store(vertex.direction, goes_on ? direction : (ref_vec){0, 0, 0});
        vertex.ior = ref_media_ior(ref_media_filling(&media, scene), 0);
        MCV_TRY(append(all, vertex, error));
    }
    return MCV_OK;
}

static mcv_result trace_rays(const ref_world *world, const mcv_trace_ray *rays, size_t ray_count,
                             int *winding, vertices *all, mcv_error *error) {
    for (size_t i = 0; i < ray_count; ++i) {
        const ref_vec origin = ref_from(rays[i].origin), direction = ref_from(rays[i].direction);
        const double length = ref_length(direction);
        ref_media media;
        if (!isfinite(ref_length(origin)) || !isfinite(length) || !(length > 0))
            return mcv_fail(
                error, MCV_BAD_INPUT,
                "trace: ray %zu has no finite origin and direction; the direction must not be 0",
                i);
        MCV_TRY(ref_media_at(&world->geometry, origin, winding, &media, error));
        MCV_TRY(trace_ray(world, media, (uint32_t)i, origin, ref_scale(1 / length, direction), all,
                          error));
    }
    return MCV_OK;
}

mcv_result mcv_reference_trace(const mcv_scene *scene, const mcv_trace_ray *rays, size_t ray_count,
                               const mcv_render_options *options, mcv_vertex **vertices_out,
                               size_t *vertex_count, mcv_error *error) {
    ref_world world = {.scene = scene, .depth = options->depth};
    vertices all = {0};
    int *winding = calloc(scene->instance_count + (size_t)1, sizeof *winding);
    *vertices_out = NULL;
    *vertex_count = 0;
    mcv_result result = winding ? MCV_OK
                                : mcv_fail(error, MCV_FAILED,
                                           "trace: no memory for the instances of %s", scene->path);
    if (result == MCV_OK) result = ref_geometry_new(scene, &world.geometry, error);
    if (result == MCV_OK) result = ref_emitters_new(scene, &world.emitters, error);
    if (result == MCV_OK) result = trace_rays(&world, rays, ray_count, winding, &all, error);
    if (result == MCV_OK) {
        *vertices_out = all.items;
        *vertex_count = all.count;
    } else {
        free(all.items);
    }
    ref_emitters_free(&world.emitters);
    ref_geometry_free(&world.geometry);
    free(winding);
    return result;
}
