/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes of runs of triangles: what lies far from a defect is passed over (facets.h). */
#include "defects/facets.h"

#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void add_point(mcv_box *box, const float p[3]) {
    for (int i = 0; i < 3; ++i) {
        box->lower[i] = fminf(box->lower[i], p[i]);
        box->upper[i] = fmaxf(box->upper[i], p[i]);
    }
}

static const mcv_box empty = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

/* Grows the boxes to hold the runs from the one of triangle `from` on. False without memory. */
static bool extend(mcv_mesh_boxes *boxes, const mcv_mesh *mesh, uint32_t from) {
    const size_t first = from / MCV_BOX_TRIANGLES,
                 count = (mesh->triangle_count + (size_t)MCV_BOX_TRIANGLES - 1) / MCV_BOX_TRIANGLES;
    if (count > boxes->room || !boxes->items) {
        const size_t room = count + boxes->room + 1;
        mcv_box *larger = realloc(boxes->items, room * sizeof *larger);
        if (!larger) return false;
        boxes->items = larger;
        boxes->room = room;
    }
    if (from == 0) boxes->all = empty;
    for (size_t run = first; run < count; ++run) {
        mcv_box *box = boxes->items + run;
        *box = empty;
        const size_t begin = 3 * (size_t)MCV_BOX_TRIANGLES * run,
                     all = 3 * (size_t)mesh->triangle_count,
                     end = begin + 3 * (size_t)MCV_BOX_TRIANGLES;
        for (size_t i = begin; i < end && i < all; ++i)
            add_point(box, mesh->positions + 3 * (size_t)mesh->indices[i]);
        add_point(&boxes->all, box->lower);
        add_point(&boxes->all, box->upper);
    }
    boxes->triangles = mesh->triangle_count;
    return true;
}

mcv_known_mesh *mcv_known_mesh_of(mcv_known_meshes *known, const mcv_scene *scene, uint32_t mesh) {
    if (mesh >= known->count) {
        const size_t count = 2 * (size_t)scene->mesh_count;
        mcv_known_mesh *larger = realloc(known->items, count * sizeof *larger);
        if (!larger) return NULL;
        memset(larger + known->count, 0, (count - known->count) * sizeof *larger);
        known->items = larger;
        known->count = count;
    }
    return known->items + mesh;
}

const mcv_mesh_boxes *mcv_known_boxes(mcv_known_meshes *known, const mcv_scene *scene,
                                      uint32_t mesh) {
    mcv_known_mesh *one = mcv_known_mesh_of(known, scene, mesh);
    if (!one) return NULL;
    mcv_mesh_boxes *boxes = &one->boxes;
    const mcv_mesh *of = scene->meshes + mesh;
    if ((!boxes->items || boxes->triangles < of->triangle_count) &&
        !extend(boxes, of, boxes->items ? boxes->triangles : 0))
        return NULL;
    return boxes;
}

mcv_spread mcv_box_spread(const mcv_box *box, const mcv_transform *to_world, const double origin[3],
                          const double axes[3][3]) {
    mcv_spread spread;
    double half[3], centre[3], world[3], size = 0;
    for (int i = 0; i < 3; ++i) {
        half[i] = 0.5 * ((double)box->upper[i] - box->lower[i]);
        centre[i] = 0.5 * ((double)box->upper[i] + box->lower[i]);
    }
    const double *m = to_world->m;
    mcv_transform_point(to_world, centre, world);
    for (int i = 0; i < 3; ++i) {
        size += fabs(m[9 + i]) + fabs(origin[i]);
        for (int j = 0; j < 3; ++j) size += fabs(m[3 * i + j]) * (fabs(centre[j]) + half[j]);
    }
    for (int k = 0; k < 3; ++k) {
        spread.middle[k] = 0;
        spread.half[k] = 1e-12 * size; /* more than what rounding does to a corner */
        for (int i = 0; i < 3; ++i) spread.middle[k] += (world[i] - origin[i]) * axes[k][i];
        for (int j = 0; j < 3; ++j)
            spread.half[k] +=
                half[j] * fabs(axes[k][0] * m[j] + axes[k][1] * m[3 + j] + axes[k][2] * m[6 + j]);
    }
    return spread;
}

void mcv_known_meshes_free(mcv_known_meshes *known) {
    for (size_t i = 0; i < known->count; ++i) {
        free(known->items[i].boxes.items);
        free(known->items[i].gone);
    }
    for (size_t i = 0; i < known->area_count; ++i) free(known->areas[i]);
    free(known->items);
    free((void *)known->areas);
    *known = (mcv_known_meshes){0};
}
