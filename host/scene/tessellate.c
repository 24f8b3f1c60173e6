/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact surfaces as meshes (scene/solid.h). A disc is a hexagon of rings, of which ring k has 6 k
 * vertices; all pieces have the same number of rings, so that their rims, and the faces of cemented
 * lenses, have the same vertices.
 */
#include "scene/solid.h"

#include "scene/geometry.h"
#include "scene/mesh.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How far chords may lie off the surface [m]: a tenth of a wavelength. More rings than these are
 * not made: a disc then has 400 000 triangles, a ball 500 000. */
static const double chord = 50e-9;
enum { MOST_RINGS = 256 };

typedef struct building {
    mcv_mesh mesh;
    uint32_t rings; /* of a disc */
    bool failed;
} building;

/* --- what a mesh is made of --- */

/* Room for so many more; false without memory. */
static bool reserve(building *b, size_t vertices, size_t triangles) {
    mcv_mesh *m = &b->mesh;
    float *positions =
        realloc(m->positions, 3 * sizeof(float) * (m->vertex_count + vertices) + sizeof(float));
    if (positions) m->positions = positions;
    float *normals =
        realloc(m->normals, 3 * sizeof(float) * (m->vertex_count + vertices) + sizeof(float));
    if (normals) m->normals = normals;
    uint32_t *indices = realloc(m->indices, 3 * sizeof *indices * (m->triangle_count + triangles) +
                                                sizeof *indices);
    if (indices) m->indices = indices;
    b->failed = b->failed || !positions || !normals || !indices;
    return !b->failed;
}

static void add_vertex(building *b, const double position[3], const double normal[3]) {
    const size_t at = 3 * (size_t)b->mesh.vertex_count++;
    double unit[3];
    if (!mcv_normalize3(normal, unit)) unit[0] = unit[1] = 0, unit[2] = 1;
    for (size_t k = 0; k < 3; ++k) {
        b->mesh.positions[at + k] = (float)position[k];
        b->mesh.normals[at + k] = (float)unit[k];
    }
}

static bool same_place(const building *b, uint32_t i, uint32_t k) {
    return memcmp(b->mesh.positions + 3 * (size_t)i, b->mesh.positions + 3 * (size_t)k,
                  3 * sizeof(float)) == 0;
}

/* Counter-clockwise, or `turned`. One that is an edge, as where a lens has no rim, is left out. */
static void add_triangle(building *b, uint32_t i, uint32_t j, uint32_t k, bool turned) {
    uint32_t *to = b->mesh.indices + 3 * (size_t)b->mesh.triangle_count;
    if (same_place(b, i, j) || same_place(b, j, k) || same_place(b, k, i)) return;
    to[0] = i;
    to[1] = turned ? k : j;
    to[2] = turned ? j : k;
    ++b->mesh.triangle_count;
}

/* --- caps --- */

/* The angle of the sphere in its vertex at which it has this radius: rings lie evenly along it. */
static double angle_of(const mcv_cap *cap, double radius) {
    return asin(fmin(1, fabs(cap->curvature) * radius));
}

static double ring_radius(const mcv_cap *cap, double radius, double share) {
    const double angle = angle_of(cap, radius);
    return share < 1 && angle > 1e-6 ? radius * sin(angle * share) / sin(angle) : radius * share;
}

/* Rings with which a chord of the cap errs by less. */
static double rings_of_cap(const mcv_cap *cap, double radius) {
    const double angle = angle_of(cap, radius),
                 width = angle > 1e-6 ? radius * angle / sin(angle) : radius;
    /* Ellipsoids across the axis bend more at the rim, others most in the vertex. */
    const double bend = mcv_cap_is_asphere(cap) || cap->conic > 0 ? mcv_cap_bend(cap, radius)
                                                                  : fabs(cap->curvature);
    return width * sqrt(bend / (5.4 * chord)); /* a triangle's circle has 0.61 widths */
}

/* A vertex of the cap at (x, y). A hemisphere's rim is vertical: its radius may be rounded up. */
static void add_cap_vertex(building *b, const mcv_cap *cap, double x, double y, double front) {
    const double within = 1 - 1e-14, u = x * within, v = y * within,
                 r2 = (cap->cylindrical ? 0 : u * u) + v * v, c = cap->curvature;
    double slope = c / sqrt(1 - (1 + cap->conic) * c * c * r2), power = r2;
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i, power *= r2)
        slope += (2 * i + 4) * cap->asphere[i] * power;
    const double position[3] = {x, y, mcv_cap_height(cap, u, v)},
                 normal[3] = {cap->cylindrical ? 0 : -front * slope * u, -front * slope * v, front};
    add_vertex(b, position, normal);
}

/* A place on ring k of n, by its number; those on the rim are the same for all caps. */
static void ring_place(const mcv_cap *cap, double radius, uint32_t k, uint32_t n, uint32_t number,
                       double place[2]) {
    const double r = ring_radius(cap, radius, k < n ? (double)k / n : 1),
                 angle = number * (M_PI / 3) / fmax(k, 1);
    place[0] = r * cos(angle);
    place[1] = r * sin(angle);
}

static uint32_t ring_vertex(uint32_t first, uint32_t k, uint32_t number) {
    return k == 0 ? first : first + 1 + 3 * k * (k - 1) + number % (6 * k);
}

static void add_disc(building *b, const mcv_cap *cap, double radius, double front) {
    const uint32_t n = b->rings, first = b->mesh.vertex_count;
    const bool turned = front < 0;
    if (!reserve(b, 1 + 3 * (size_t)n * (n + 1), 6 * (size_t)n * n)) return;
    for (uint32_t k = 0; k <= n; ++k)
        for (uint32_t i = 0; i < (k ? 6 * k : 1); ++i) {
            double at[2];
            ring_place(cap, radius, k, n, i, at);
            add_cap_vertex(b, cap, at[0], at[1], front);
        }
    for (uint32_t k = 1; k <= n; ++k)
        for (uint32_t sector = 0; sector < 6; ++sector)
            for (uint32_t i = 0; i < k; ++i) {
                const uint32_t outer = ring_vertex(first, k, sector * k + i),
                               next = ring_vertex(first, k, sector * k + i + 1),
                               inner = ring_vertex(first, k - 1, sector * (k - 1) + i),
                               beside = ring_vertex(first, k - 1, sector * (k - 1) + i + 1);
                add_triangle(b, outer, next, inner, turned);
                if (i + 1 < k) add_triangle(b, inner, next, beside, turned);
            }
}

/* An open surface with a hole. */
static void add_ring(building *b, const mcv_cap *cap, double hole, double radius, double front) {
    const uint32_t around = 6 * b->rings, first = b->mesh.vertex_count;
    const uint32_t n = 1 + (uint32_t)(b->rings * (1 - hole / radius));
    if (!reserve(b, (n + 1) * (size_t)around, 2 * (size_t)n * around)) return;
    for (uint32_t k = 0; k <= n; ++k)
        for (uint32_t i = 0; i < around; ++i) {
            const double r = k < n ? hole + (radius - hole) * k / n : radius,
                         angle = 2 * M_PI * i / around;
            add_cap_vertex(b, cap, r * cos(angle), r * sin(angle), front);
        }
    for (uint32_t k = 0; k < n; ++k)
        for (uint32_t i = 0; i < around; ++i) {
            const uint32_t a = first + k * around + i, c = first + k * around + (i + 1) % around;
            add_triangle(b, a, a + around, c + around, front < 0);
            add_triangle(b, a, c + around, c, front < 0);
        }
}

/* --- sides --- */

static void add_cylinder(building *b, const mcv_solid *s) {
    const uint32_t n = b->rings, around = 6 * n, first = b->mesh.vertex_count;
    if (!reserve(b, 2 * (size_t)around, 2 * (size_t)around)) return;
    for (int cap = 0; cap < 2; ++cap)
        for (uint32_t i = 0; i < around; ++i) {
            double at[2];
            ring_place(s->caps + cap, s->radius, n, n, i, at);
            const double within = 1 - 1e-14, /* as add_cap_vertex */
                position[3] = {at[0], at[1],
                               mcv_cap_height(s->caps + cap, at[0] * within, at[1] * within)},
                         normal[3] = {at[0], at[1], 0};
            add_vertex(b, position, normal);
        }
    for (uint32_t i = 0; i < around; ++i) {
        const uint32_t a = first + i, c = first + (i + 1) % around;
        add_triangle(b, a, c, c + around, false);
        add_triangle(b, a, c + around, a + around, false);
    }
}

static void add_box(building *b, const mcv_solid *s) {
    if (!reserve(b, 24, 12)) return;
    const double lower[3] = {-s->half[0], -s->half[1], s->caps[0].z},
                 upper[3] = {s->half[0], s->half[1], s->caps[1].z};
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const bool front = face % 2;
        const uint32_t first = b->mesh.vertex_count;
        double normal[3] = {0, 0, 0};
        normal[axis] = front ? 1 : -1;
        for (int corner = 0; corner < 4; ++corner) {
            double p[3];
            p[axis] = front ? upper[axis] : lower[axis];
            for (int side = 0; side < 2; ++side) {
                const int k = (axis + 1 + side) % 3;
                p[k] = corner >> side & 1 ? upper[k] : lower[k];
            }
            add_vertex(b, p, normal);
        }
        add_triangle(b, first, first + 1, first + 3, !front);
        add_triangle(b, first, first + 3, first + 2, !front);
    }
}

/* An octahedron whose faces are divided; the vertices on their edges are the same on both sides. */
static void add_sphere(building *b, double radius) {
    const uint32_t n = b->rings;
    for (int face = 0; face < 8; ++face) {
        const uint32_t first = b->mesh.vertex_count;
        const int sign[3] = {face & 1 ? -1 : 1, face & 2 ? -1 : 1, face & 4 ? -1 : 1};
        const bool turned = sign[0] * sign[1] * sign[2] < 0;
        if (!reserve(b, (n + 1) * (size_t)(n + 2) / 2, (size_t)n * n)) return;
        for (uint32_t k = 0; k <= n; ++k) /* row k has k + 1 vertices */
            for (uint32_t i = 0; i <= k; ++i) {
                const double share[3] = {n - k, k - i, i};
                double position[3], unit[3] = {0, 0, 1};
                for (int j = 0; j < 3; ++j) /* sin: nearly even angles */
                    position[j] = sign[j] * sin(M_PI / 2 * share[j] / n);
                mcv_normalize3(position, unit);
                for (int j = 0; j < 3; ++j) position[j] = radius * unit[j];
                add_vertex(b, position, unit);
            }
        for (uint32_t k = 0; k < n; ++k)
            for (uint32_t i = 0; i <= k; ++i) {
                const uint32_t a = first + k * (k + 1) / 2 + i, below = a + k + 1;
                add_triangle(b, a, below, below + 1, turned);
                if (i < k) add_triangle(b, a, below + 1, a + 1, turned);
            }
    }
}

/* --- all pieces --- */

static double rings_of(const mcv_solid *s) {
    if (s->side == MCV_SIDE_BOX) return 1;
    /* The plane of a triangle lies up to 0.826 R/n² inside. */
    if (s->side == MCV_SIDE_SPHERE) return 0.909 * sqrt(s->radius / chord);
    double most = 0.37 * sqrt(s->radius / chord); /* π/(6 √2): 6 n chords about the rim */
    for (int i = 0; i < (s->side == MCV_SIDE_OPEN ? 1 : 2); ++i)
        most = fmax(most, rings_of_cap(s->caps + i, s->radius));
    return most;
}

static void build_caps(building *b, const mcv_solid *s) {
    if (s->side == MCV_SIDE_BOX) {
        add_box(b, s);
    } else if (s->side == MCV_SIDE_SPHERE) {
        add_sphere(b, s->radius);
    } else if (s->side == MCV_SIDE_OPEN && s->hole > 0) {
        add_ring(b, s->caps, s->hole, s->radius, -1);
    } else {
        add_disc(b, s->caps, s->radius, -1);
        if (s->side == MCV_SIDE_CYLINDER) add_disc(b, s->caps + 1, s->radius, 1);
    }
}

/* A mesh for the caps, and another one for a side of another material. */
static mcv_result replace(mcv_scene *scene, const mcv_solid *s, uint32_t rings, mcv_error *error) {
    const uint32_t body = s->instances[MCV_PIECE_FIRST_CAP], rim = s->instances[MCV_PIECE_SIDE];
    building b[2] = {{.rings = rings}, {.rings = rings}};
    mcv_mesh *old = scene->meshes + scene->instances[body].mesh;
    build_caps(b, s);
    if (s->side == MCV_SIDE_CYLINDER) add_cylinder(b + (rim != body), s);
    for (int i = 0; i < 2; ++i)
        if (b[i].failed || !(b[i].mesh.name = strdup(old->name))) {
            for (int k = 0; k < 2; ++k) mcv_mesh_free(&b[k].mesh);
            return mcv_fail(error, MCV_FAILED, "%s: no memory for the mesh of \"%s\"", scene->path,
                            scene->instances[body].name);
        }
    if (rim == body) mcv_mesh_free(&b[1].mesh);
    MCV_TRY(mcv_scene_take_mesh(scene, &b[0].mesh, error));
    old = scene->meshes + scene->instances[body].mesh; /* the box, which both pieces have */
    mcv_mesh_free(old);
    *old = scene->meshes[--scene->mesh_count];
    if (rim == body) return MCV_OK;
    scene->instances[rim].mesh = scene->mesh_count;
    scene->instances[rim].closes_previous = true;
    return mcv_scene_take_mesh(scene, &b[1].mesh, error);
}

static uint64_t triangles_of(const mcv_solid *s, uint64_t n) {
    if (s->side == MCV_SIDE_BOX) return 12;
    if (s->side == MCV_SIDE_SPHERE) return 8 * n * n;
    if (s->side == MCV_SIDE_CYLINDER) return 12 * n * n + 12 * n;
    return s->hole > 0 ? 12 * n * (n + 1) : 6 * n * n;
}

static bool is_among(const mcv_solid *s, const uint32_t instances[2]) {
    return s->instances[0] >= instances[0] && s->instances[0] < instances[1];
}

/* All have the same number, for the faces of cemented lenses. */
static uint32_t rings_of_all(const mcv_scene *scene, const uint32_t instances[2]) {
    double rings = 1;
    for (uint32_t i = 0; i < scene->solid_count; ++i)
        if (is_among(scene->solids + i, instances))
            rings = fmax(rings, rings_of(scene->solids + i));
    return (uint32_t)fmin(ceil(rings), MOST_RINGS);
}

uint64_t mcv_scene_solid_triangles(const mcv_scene *scene, const uint32_t instances[2]) {
    const uint32_t rings = rings_of_all(scene, instances);
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < scene->solid_count; ++i)
        if (is_among(scene->solids + i, instances))
            triangles += triangles_of(scene->solids + i, rings);
    return triangles;
}

mcv_result mcv_scene_mesh_solids(mcv_scene *scene, const uint32_t instances[2],
                                 const mcv_json_path *place, mcv_error *error) {
    const uint32_t rings = rings_of_all(scene, instances);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < scene->solid_count; ++i) {
        const mcv_solid *s = scene->solids + i;
        if (!is_among(s, instances)) continue;
        if (s->cemented && s->radius != scene->solids[i - 1].radius)
            return mcv_fail_at(place, error,
                               "lies on a cemented lens whose parts have the semi-diameters %g m "
                               "and %g m: give them one semi-diameter",
                               scene->solids[i - 1].radius, s->radius);
    }
    for (uint32_t i = 0; i < scene->solid_count; ++i) {
        const mcv_solid s = scene->solids[i];
        if (is_among(&s, instances))
            MCV_TRY(replace(scene, &s, rings, error));
        else
            scene->solids[kept++] = s;
    }
    scene->solid_count = kept;
    return mcv_scene_number_triangles(scene, place, error);
}
