/* SPDX-License-Identifier: Apache-2.0 */
/* The media of dielectric bodies, and which of them surround a point. */
#include "device/pack_steps.h"

#include <math.h>
#include <stdlib.h>

#include "device/albedo.h"
#include "device/pack_glossy.h"
#include "scene/mesh.h"
#include "scene/solid.h"
#include "scene/geometry.h"
#include "scene/materials.h"

/* One medium; bodies of one material that do not touch share it. */
typedef struct body_medium {
    uint32_t material;
    double priority;
} body_medium;

static bool comes_before(const body_medium *a, const body_medium *b) {
    return a->priority != b->priority ? a->priority < b->priority : a->material < b->material;
}

/* Media 0 … count for one channel; m > 0 is of the material materials[m]. */
static void pack_media(const mcv_scene *scene, mcv_packed *packed, uint32_t count,
                       const uint32_t *materials, int channel) {
    double index[MCV_MAX_MEDIA + 1] = {1.0};
    for (uint32_t m = 1; m <= count; ++m) {
        const mcv_medium_params *params = &scene->materials[materials[m]].as.medium;
        index[m] = params->ior[channel];
        for (int k = 0; k < 3; ++k)
            packed->medium_table[channel][m].absorption[k] = (float)params->absorption[k];
    }
    for (uint32_t a = 0; a <= count; ++a) {
        packed->medium_table[channel][a].inverse_index_squared = (float)(1 / (index[a] * index[a]));
        for (uint32_t b = 0; b <= count; ++b) {
            mcv_device_interface *between =
                &packed->interfaces[channel][a * (MCV_MAX_MEDIA + 1) + b];
            between->eta = (float)(index[a] / index[b]);
            between->delta =
                (float)((index[b] - index[a]) * (index[b] + index[a]) / (index[b] * index[b]));
            /* The later medium owns the surface between two: it has the higher priority. */
            const uint32_t owner = a > b ? a : b, other = a > b ? b : a;
            double scale, offset;
            mcv_coat(owner > 0
                         ? mcv_material_coating(&scene->materials[materials[owner]], index[other])
                         : 0,
                     index[a], index[b], &scale, &offset);
            between->scale = (float)scale;
            between->offset = (float)offset;
        }
    }
}

/*
 * Gives each dielectric instance a medium. A path then stores the set of bodies that it is in as
 * bits, the highest priority on top. Bodies of one material whose boxes do not touch share a bit.
 */
mcv_result mcv_pack_media(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                          mcv_error *error) {
    const mcv_box3d *boxes = packed->boxes;
    body_medium media[MCV_MAX_MEDIA];
    uint32_t count = 0;
    uint32_t *medium_of = calloc(scene->instance_count + 1,
                                 sizeof *medium_of); /* 1 + index into media before sorting */
    if (!medium_of) return mcv_fail(error, MCV_FAILED, "%s: no memory for the media", scene->path);
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const uint32_t material = scene->instances[i].material;
        if (!mcv_material_has_medium(scene->materials[material].type)) continue;
        uint32_t taken = 0; /* bits of media that this body must not share */
        for (uint32_t j = 0; j < i; ++j) {
            if (medium_of[j] > 0 && mcv_boxes_overlap(&boxes[i], &boxes[j]))
                taken |= 1u << (medium_of[j] - 1);
        }
        for (uint32_t m = 0; m < count && medium_of[i] == 0; ++m) {
            if (media[m].material == material && !(taken >> m & 1)) medium_of[i] = m + 1;
        }
        if (medium_of[i] > 0) continue;
        if (count == MCV_MAX_MEDIA) {
            free(medium_of);
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: nodes: more than %d dielectric bodies differ in material or "
                            "overlap: join those of one material into one mesh",
                            scene->path, MCV_MAX_MEDIA);
        }
        media[count] = (body_medium){material, scene->materials[material].as.medium.priority};
        medium_of[i] = ++count;
    }

    /* Sorted by priority; a table maps old indices to new ones. Equal priorities keep their
     * order. */
    uint32_t place[MCV_MAX_MEDIA] = {0}; /* new index of each old one */
    body_medium sorted[MCV_MAX_MEDIA] = {{0}};
    for (uint32_t m = 0; m < count; ++m) {
        place[m] = 0;
        for (uint32_t o = 0; o < count; ++o) {
            if (comes_before(&media[o], &media[m]) ||
                (o < m && !comes_before(&media[m], &media[o])))
                ++place[m];
        }
        sorted[place[m]] = media[m];
    }
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        packed->instances[i].medium = medium_of[i] > 0 ? place[medium_of[i] - 1] + 1 : 0;
    free(medium_of);

    uint32_t materials[MCV_MAX_MEDIA + 1] = {0};
    for (uint32_t m = 0; m < count; ++m) materials[m + 1] = sorted[m].material;
    for (int channel = 0; channel < 3; ++channel)
        pack_media(scene, packed, count, materials, channel);
    if (!packed->glossy) return MCV_OK;
    double index[MCV_MAX_MEDIA + 1] = {1.0};
    for (uint32_t m = 1; m <= count; ++m)
        index[m] = scene->materials[materials[m]].as.medium.ior[MCV_ALBEDO_CHANNEL];
    return mcv_pack_interfaces(scene, earlier, packed, count, materials, index, error);
}

/*
 * Does the closed surface enclose the point? The solid angles of its triangles at the point (van
 * Oosterom and Strackee 1983) add up to ±4π or to 0. Unlike a ray, this has no special cases at
 * edges. An open surface has less than half and encloses nothing.
 */
static bool surrounds(const mcv_scene *scene, uint32_t instance, const double point[3]) {
    for (uint32_t i = 0; i < scene->solid_count; ++i)
        if (scene->solids[i].instances[0] == instance)
            return mcv_solid_holds(scene->solids + i, point);
    const uint32_t triangles = scene->meshes[scene->instances[instance].mesh].triangle_count;
    double half_angle = 0;
    for (uint32_t t = 0; t < triangles; ++t) {
        double c[3][3];
        double length[3];
        mcv_scene_corners(scene, instance, t, c);
        for (int v = 0; v < 3; ++v) {
            for (int k = 0; k < 3; ++k) c[v][k] -= point[k];
            length[v] = sqrt(c[v][0] * c[v][0] + c[v][1] * c[v][1] + c[v][2] * c[v][2]);
        }
        const double ab = c[0][0] * c[1][0] + c[0][1] * c[1][1] + c[0][2] * c[1][2];
        const double bc = c[1][0] * c[2][0] + c[1][1] * c[2][1] + c[1][2] * c[2][2];
        const double ca = c[2][0] * c[0][0] + c[2][1] * c[0][1] + c[2][2] * c[0][2];
        const double volume = c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) +
                              c[0][1] * (c[1][2] * c[2][0] - c[1][0] * c[2][2]) +
                              c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
        half_angle += atan2(volume, length[0] * length[1] * length[2] + ab * length[2] +
                                        bc * length[0] + ca * length[1]);
    }
    return fabs(half_angle) > M_PI;
}

uint32_t mcv_media_around(const mcv_scene *scene, const mcv_packed *packed, const double point[3]) {
    uint32_t media = 0;
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        if (packed->instances[i].medium == 0) continue;
        const mcv_box3d b = packed->boxes[i];
        bool maybe = true;
        for (int k = 0; k < 3; ++k)
            maybe = maybe && point[k] >= b.lower[k] && point[k] <= b.upper[k];
        if (maybe && surrounds(scene, i, point)) media |= 1u << (packed->instances[i].medium - 1);
    }
    return media;
}
