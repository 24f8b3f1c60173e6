/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/mesh.h"

#include "scene/transform.h"

#include <stdlib.h>

static mcv_result check_finite(const float *values, uint32_t count, uint32_t components,
                               const char *key, const mcv_json_path *place, mcv_error *error) {
    if (!values) return MCV_OK;
    const mcv_json_path here = mcv_json_path_key(place, key);
    for (size_t i = 0; i < (size_t)count * components; ++i)
        if (!isfinite(values[i]))
            return mcv_fail_at(&here, error, "vertex %zu has the coordinate %g, but must be finite",
                               i / components, (double)values[i]);
    return MCV_OK;
}

/* Adds to each vertex the normals of the faces around it, by their area. */
static void add_faces(const mcv_mesh *mesh, double *sums) {
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->indices + 3 * t;
        double edge[2][3], normal[3];
        for (int i = 0; i < 3; ++i) {
            const double origin = mesh->positions[3 * (size_t)v[0] + i];
            edge[0][i] = mesh->positions[3 * (size_t)v[1] + i] - origin;
            edge[1][i] = mesh->positions[3 * (size_t)v[2] + i] - origin;
        }
        mcv_cross3(edge[0], edge[1], normal);
        for (int corner = 0; corner < 3; ++corner)
            for (int i = 0; i < 3; ++i) sums[3 * (size_t)v[corner] + i] += normal[i];
    }
}

/* Replaces normals of length 0 by the sum of the faces' normals around the vertex, or by z if that
 * is 0 too. */
static mcv_result repair_normals(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error) {
    double *sums = calloc(mesh->vertex_count, 3 * sizeof *sums);
    if (!sums) return mcv_fail_memory(place, error);
    add_faces(mesh, sums);
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        float *n = mesh->normals + 3 * v;
        double unit[3] = {0, 0, 1};
        if (n[0] != 0 || n[1] != 0 || n[2] != 0) continue;
        mcv_normalize3(sums + 3 * v, unit);
        for (int i = 0; i < 3; ++i) n[i] = (float)unit[i];
    }
    free(sums);
    return MCV_OK;
}

mcv_result mcv_mesh_check(mcv_mesh *mesh, uint32_t *repaired, const mcv_json_path *place,
                          mcv_error *error) {
    MCV_TRY(check_finite(mesh->positions, mesh->vertex_count, 3, "POSITION", place, error));
    MCV_TRY(check_finite(mesh->normals, mesh->vertex_count, 3, "NORMAL", place, error));
    MCV_TRY(check_finite(mesh->texcoords, mesh->vertex_count, 2, "TEXCOORD_0", place, error));
    MCV_TRY(check_finite(mesh->texcoords1, mesh->vertex_count, 2, "TEXCOORD_1", place, error));
    MCV_TRY(check_finite(mesh->tangents, mesh->vertex_count, 4, "TANGENT", place, error));
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i)
        if (mesh->indices[i] >= mesh->vertex_count) {
            const mcv_json_path here = mcv_json_path_key(place, "indices");
            return mcv_fail_at(&here, error,
                               "index %u of triangle %zu does not exist: vertices go from 0 to %u",
                               mesh->indices[i], i / 3, mesh->vertex_count - 1);
        }
    *repaired = 0;
    for (size_t v = 0; mesh->normals && v < mesh->vertex_count; ++v) {
        float *n = mesh->normals + 3 * v;
        double unit[3] = {n[0], n[1], n[2]};
        if (!mcv_normalize3(unit, unit)) ++*repaired;
        for (int i = 0; i < 3; ++i) n[i] = (float)unit[i];
    }
    return *repaired ? repair_normals(mesh, place, error) : MCV_OK;
}

/* Adds to the sums of three vertices the derivatives of the position with respect to u and v,
 * weighed by the triangle's area in u and v. */
static void add_gradients(const mcv_mesh *mesh, const uint32_t v[3], double *sums) {
    double edge[2][3], du[2], dv[2];
    for (int e = 0; e < 2; ++e) {
        for (int i = 0; i < 3; ++i)
            edge[e][i] = (double)mesh->positions[3 * (size_t)v[e + 1] + i] -
                         mesh->positions[3 * (size_t)v[0] + i];
        du[e] = (double)mesh->texcoords[2 * (size_t)v[e + 1]] - mesh->texcoords[2 * (size_t)v[0]];
        dv[e] = (double)mesh->texcoords[2 * (size_t)v[e + 1] + 1] -
                mesh->texcoords[2 * (size_t)v[0] + 1];
    }
    const double sign = du[0] * dv[1] - du[1] * dv[0] < 0 ? -1 : 1;
    for (int corner = 0; corner < 3; ++corner)
        for (int i = 0; i < 3; ++i) {
            sums[6 * (size_t)v[corner] + i] += sign * (dv[1] * edge[0][i] - dv[0] * edge[1][i]);
            sums[6 * (size_t)v[corner] + 3 + i] += sign * (du[0] * edge[1][i] - du[1] * edge[0][i]);
        }
}

mcv_result mcv_mesh_make_tangents(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error) {
    double *sums =
        calloc(mesh->vertex_count, 9 * sizeof *sums); /* ∂p/∂u, ∂p/∂v; then the faces' normals */
    mesh->tangents = malloc(4 * sizeof(float) * mesh->vertex_count);
    if (!sums || !mesh->tangents) {
        free(sums);
        return mcv_fail_memory(place, error);
    }
    double *normals = sums + 6 * (size_t)mesh->vertex_count;
    for (size_t t = 0; mesh->texcoords && t < mesh->triangle_count; ++t)
        add_gradients(mesh, mesh->indices + 3 * t, sums);
    add_faces(mesh, normals);
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        double unit[3] = {1, 0, 0}, bitangent[3];
        const double *across = sums + 6 * v + 3;
        const bool given = mcv_normalize3(sums + 6 * v, unit);
        mcv_cross3(normals + 3 * v, unit, bitangent);
        const bool mirrored =
            given &&
            bitangent[0] * across[0] + bitangent[1] * across[1] + bitangent[2] * across[2] < 0;
        for (int i = 0; i < 3; ++i) mesh->tangents[4 * v + i] = (float)unit[i];
        mesh->tangents[4 * v + 3] = mirrored ? -1 : 1;
    }
    free(sums);
    return MCV_OK;
}

/* Gives each corner of a triangle a value of its own; NULL stays. */
static bool separate_values(float **values, size_t width, const mcv_mesh *mesh) {
    const size_t count = 3 * (size_t)mesh->triangle_count;
    if (!*values) return true;
    float *separate = malloc((width * count + 1) * sizeof *separate);
    if (!separate) return false;
    for (size_t i = 0; i < count; ++i)
        memcpy(separate + width * i, *values + width * mesh->indices[i], width * sizeof *separate);
    free(*values);
    *values = separate;
    return true;
}

mcv_result mcv_mesh_separate(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error) {
    free(mesh->normals);
    mesh->normals = NULL;
    if (!separate_values(&mesh->positions, 3, mesh) ||
        !separate_values(&mesh->texcoords, 2, mesh) ||
        !separate_values(&mesh->texcoords1, 2, mesh) || !separate_values(&mesh->tangents, 4, mesh))
        return mcv_fail_memory(place, error);
    mesh->vertex_count = 3 * mesh->triangle_count;
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) mesh->indices[i] = i;
    return MCV_OK;
}

void mcv_mesh_free(mcv_mesh *mesh) {
    free(mesh->name);
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->texcoords);
    free(mesh->texcoords1);
    free(mesh->tangents);
    free(mesh->indices);
    *mesh = (mcv_mesh){0};
}
