/* SPDX-License-Identifier: Apache-2.0 */
/* Placing the scene: boxes, the centre, vertices and triangles of instances, the sensor. */
#include "device/pack_steps.h"

#include <math.h>
#include <string.h>

#include "scene/mesh.h"
#include "scene/transform.h"
#include "scene/geometry.h"

mcv_box3d mcv_box3d_empty(void) {
    return (mcv_box3d){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

void mcv_box3d_extend(mcv_box3d *b, const double p[3]) {
    for (int k = 0; k < 3; ++k) {
        if (p[k] < b->lower[k]) b->lower[k] = p[k];
        if (p[k] > b->upper[k]) b->upper[k] = p[k];
    }
}

bool mcv_boxes_overlap(const mcv_box3d *a, const mcv_box3d *b) {
    for (int k = 0; k < 3; ++k) {
        const double margin = 1e-6 * (a->upper[k] - a->lower[k] + b->upper[k] - b->lower[k]);
        if (a->upper[k] + margin < b->lower[k] || b->upper[k] + margin < a->lower[k]) return false;
    }
    return true;
}

void mcv_find_centre(const mcv_box3d *boxes, uint32_t count, double centre[3]) {
    mcv_box3d all = mcv_box3d_empty();
    double size = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (!(boxes[i].lower[0] <= boxes[i].upper[0])) continue;
        mcv_box3d_extend(&all, boxes[i].lower);
        mcv_box3d_extend(&all, boxes[i].upper);
    }
    for (int k = 0; k < 3; ++k) size = fmax(size, all.upper[k] - all.lower[k]);
    const double grid = size > 0 && isfinite(size) ? exp2(floor(log2(size)) - 3) : 0;
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * (all.lower[k] + all.upper[k]);
        centre[k] = !isfinite(middle) ? 0 : grid > 0 ? grid * round(middle / grid) : middle;
    }
}

void mcv_pack_normal(const mcv_scene *scene, uint32_t instance, uint32_t vertex, double n[3]) {
    const mcv_instance *placed = &scene->instances[instance];
    const float *from = scene->meshes[placed->mesh].normals + 3 * (size_t)vertex;
    mcv_transform_normal(&placed->to_world, (const double[3]){from[0], from[1], from[2]}, n);
    if (!mcv_normalize3(n, n)) memset(n, 0, 3 * sizeof *n);
}

void mcv_pack_instance(const mcv_scene *scene, mcv_packed *packed, uint32_t index,
                       uint32_t first_vertex) {
    const mcv_instance *instance = &scene->instances[index];
    const mcv_mesh *mesh = &scene->meshes[instance->mesh];
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const size_t to = first_vertex + (size_t)v;
        double p[3];
        mcv_scene_vertex(scene, index, v, p);
        for (int k = 0; k < 3; ++k)
            packed->positions[3 * to + k] = (float)(p[k] - packed->centre[k]);
        if (packed->normals && mesh->normals) {
            double n[3];
            mcv_pack_normal(scene, index, v, n);
            for (int k = 0; k < 3; ++k) packed->normals[3 * to + k] = (float)n[k];
        }
        if (packed->tangents && mesh->tangents) {
            double t[4];
            mcv_scene_tangent(scene, index, v, t);
            for (int k = 0; k < 4; ++k) packed->tangents[4 * to + k] = (float)t[k];
        }
        if (packed->texcoords && mesh->texcoords)
            memcpy(packed->texcoords + 2 * to, mesh->texcoords + 2 * (size_t)v, 2 * sizeof(float));
        if (packed->texcoords && packed->texcoord_sets > 1 && mesh->texcoords1)
            memcpy(packed->texcoords + 2 * (packed->vertex_count + to),
                   mesh->texcoords1 + 2 * (size_t)v, 2 * sizeof(float));
    }
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const size_t to = instance->first_triangle + (size_t)t;
        uint32_t corners[3];
        mcv_scene_triangle(scene, index, t, corners);
        for (int k = 0; k < 3; ++k) {
            packed->indices[3 * to + k] = first_vertex + corners[k];
            packed->triangles[4 * to + k] = first_vertex + corners[k];
        }
        packed->triangles[4 * to + 3] = index;
    }
}

double mcv_packed_size(const mcv_packed *packed) {
    mcv_box3d all = mcv_box3d_empty();
    for (uint32_t i = 0; i < packed->instance_count; ++i) {
        mcv_box3d_extend(&all, packed->boxes[i].lower);
        mcv_box3d_extend(&all, packed->boxes[i].upper);
    }
    const double size =
        sqrt(pow(all.upper[0] - all.lower[0], 2) + pow(all.upper[1] - all.lower[1], 2) +
             pow(all.upper[2] - all.lower[2], 2));
    return isfinite(size) ? size : 0;
}

void mcv_pack_placement(const mcv_packed *packed, const mcv_transform *to_world,
                        float placement[12], float low[12]) {
    const double *m = to_world->m;
    for (int r = 0; r < 3; ++r) {
        /* The optical axis is the node's -z. */
        const double row[4] = {m[3 * r], m[3 * r + 1], -m[3 * r + 2], m[9 + r] - packed->centre[r]};
        for (int k = 0; k < 4; ++k) {
            const int to = k < 3 ? 3 * r + k : 9 + r;
            placement[to] = (float)row[k];
            low[to] = (float)(row[k] - placement[to]);
        }
    }
}
