/* SPDX-License-Identifier: Apache-2.0 */
/* Vertex normals of STL files by crease angle: smooth where the body is, sharp at its edges, and a
 * tessellated ball that focuses. */
#include "test.h"

#include <float.h>
#include <math.h>

#include "check/facets.h"
#include "check/findings.h"
#include "reference/reference.h"
#include "scene_files.h"
#include "scene/geometry.h"
#include "scene/transform.h"

static mcv_error error;

/* --- STL files
 * --------------------------------------------------------------------------------------------------
 */

typedef struct solid {
    unsigned char *bytes;
    uint32_t count, room;
} solid;

static void add_triangle(solid *s, const double corners[3][3]) {
    if (s->count == s->room) {
        s->room = 2 * s->room + 64;
        s->bytes = realloc(s->bytes, 84 + 50 * (size_t)s->room);
        assert_non_null(s->bytes);
    }
    unsigned char *record = s->bytes + 84 + 50 * (size_t)s->count++;
    memset(record, 0, 50);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 3; ++i) {
            const float value = (float)corners[c][i];
            memcpy(record + 12 + 12 * c + 4 * i, &value, 4);
        }
}

static void add_quad(solid *s, const double a[3], const double b[3], const double c[3],
                     const double d[3]) {
    double corners[3][3];
    memcpy(corners[0], a, sizeof corners[0]);
    memcpy(corners[1], b, sizeof corners[1]);
    memcpy(corners[2], c, sizeof corners[2]);
    add_triangle(s, (const double(*)[3])corners);
    memcpy(corners[1], c, sizeof corners[1]);
    memcpy(corners[2], d, sizeof corners[2]);
    add_triangle(s, (const double(*)[3])corners);
}

/* Loads it as the part of a rig, in mm, with the rest of the entry; frees it. */
static mcv_scene *load_solid(solid *s, const char *rest) {
    memset(s->bytes, 0, 80);
    memcpy(s->bytes + 80, &s->count, 4);
    free(write_bytes("crease.stl", s->bytes, 84 + 50 * (size_t)s->count));
    free(s->bytes);
    *s = (solid){0};
    char *text =
        text_of("{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                "\"materials\":[{\"name\":\"glass\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
                "\"dielectric\",\"ior\":1.5}}}],"
                "\"extensions\":{\"MCVISI_assets\":{\"assets\":[{\"uri\":\"crease.stl\",\"unit\":"
                "\"mm\",\"material\":\"glass\"%s}]}},"
                "\"nodes\":[{\"extensions\":{\"MCVISI_assets\":{\"asset\":0}}}]}",
                rest);
    mcv_scene *scene;
    if (load_text("crease.gltf", text, NULL, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    free(text);
    return scene;
}

static void expect_normal(const mcv_scene *scene, uint32_t triangle, int corner,
                          const double expected[3], double tolerance) {
    double normals[3][3], off = 0;
    mcv_scene_vertex_normals(scene, 0, triangle, normals);
    for (int i = 0; i < 3; ++i) off = fmax(off, fabs(normals[corner][i] - expected[i]));
    if (!(off <= tolerance))
        fail_msg("triangle %u corner %d: normal %.7f %.7f %.7f, must be %.7f %.7f %.7f", triangle,
                 corner, normals[corner][0], normals[corner][1], normals[corner][2], expected[0],
                 expected[1], expected[2]);
}

/* Unit vectors in float32, and a sum of a few. */
static const double rounding = 4 * (double)FLT_EPSILON;

/* --- edges
 * ------------------------------------------------------------------------------------------------------
 */

static solid make_box(void) {
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    solid s = {0};
    for (int f = 0; f < 6; ++f) {
        double p[4][3];
        for (int c = 0; c < 4; ++c)
            for (int i = 0; i < 3; ++i) p[c][i] = faces[f][c] >> i & 1 ? 10 + i : 0;
        add_quad(&s, p[0], p[1], p[2], p[3]);
    }
    return s;
}

static void test_box(void **state) {
    (void)state;
    solid s = make_box();
    mcv_scene *scene = load_solid(&s, "");
    assert_null(scene->meshes[0].normals); /* flat as ever */
    mcv_scene_free(scene);
    s = make_box();
    scene = load_solid(&s, ",\"creaseAngle\":\"89deg\"");
    for (uint32_t t = 0; t < 12; ++t)
        for (int c = 0; c < 3; ++c) {
            double face[3];
            mcv_scene_face_normal(scene, 0, t, face);
            const double length = sqrt(face[0] * face[0] + face[1] * face[1] + face[2] * face[2]);
            for (int i = 0; i < 3; ++i) face[i] /= length;
            expect_normal(scene, t, c, face, rounding);
        }
    mcv_scene_free(scene);
    /* At a corner of a by b by c the three faces weigh 1/(a b) and so on, whether they are one
     * triangle there or two. */
    s = make_box();
    scene = load_solid(&s, ",\"creaseAngle\":\"90deg\"");
    for (uint32_t t = 0; t < 12; ++t)
        for (int c = 0; c < 3; ++c) {
            double corners[3][3], expected[3];
            mcv_scene_corners(scene, 0, t, corners);
            for (int i = 0; i < 3; ++i)
                expected[i] =
                    (corners[c][i] > 0.005 ? 10 + i : -10 - i) / sqrt(10 * 10 + 11 * 11 + 12 * 12);
            expect_normal(scene, t, c, expected, rounding);
        }
    mcv_scene_free(scene);
}

/* A box of eight shared vertices, whose own normals are wrong, in a glTF file. Its texture
 * coordinates are x and y. Loaded as the part of a rig, in mm. */
static mcv_scene *load_gltf_box(const char *rest) {
    enum { VERTICES = 8, INDICES = 36 };
    struct {
        float positions[VERTICES][3], normals[VERTICES][3], texcoords[VERTICES][2];
        uint16_t indices[INDICES];
    } buffer;
    const solid s = make_box();
    for (int v = 0; v < VERTICES; ++v) {
        for (int i = 0; i < 3; ++i) buffer.positions[v][i] = v >> i & 1 ? (float)(10 + i) : 0;
        memcpy(buffer.normals[v], (float[3]){0, 0.6f, 0.8f}, sizeof buffer.normals[v]);
        memcpy(buffer.texcoords[v], buffer.positions[v], sizeof buffer.texcoords[v]);
    }
    for (int k = 0; k < INDICES; ++k) {
        float at[3];
        memcpy(at, s.bytes + 84 + 50 * (k / 3) + 12 + 12 * (k % 3), sizeof at);
        buffer.indices[k] = (uint16_t)((at[0] > 5) + 2 * (at[1] > 5) + 4 * (at[2] > 5));
    }
    free(s.bytes);
    free(write_bytes("crease.bin", &buffer, sizeof buffer));
    char *part = text_of(
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
        "\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
        "\"TEXCOORD_0\":2},\"indices\":3}]}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"min\":[0,0,0],"
        "\"max\":[10,11,12]},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5126,\"count\":8,\"type\":\"VEC2\"},"
        "{\"bufferView\":3,\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,"
        "\"byteLength\":96},{\"buffer\":0,\"byteOffset\":192,\"byteLength\":64},{\"buffer\":0,"
        "\"byteOffset\":256,\"byteLength\":72}],"
        "\"buffers\":[{\"uri\":\"crease.bin\",\"byteLength\":%zu}]}",
        sizeof buffer);
    free(write_bytes("crease_part.gltf", part, strlen(part)));
    free(part);
    char *text =
        text_of("{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                "\"extensions\":{\"MCVISI_assets\":{\"assets\":[{\"uri\":\"crease_part.gltf\","
                "\"unit\":\"mm\"%s}]}},"
                "\"nodes\":[{\"extensions\":{\"MCVISI_assets\":{\"asset\":0}}}]}",
                rest);
    mcv_scene *scene;
    if (load_text("crease.gltf", text, NULL, &scene, &error) != MCV_OK) fail_msg("%s", error.text);
    free(text);
    return scene;
}

/* A glTF file keeps its normals, unless a crease angle makes new ones. Vertices that faces share
 * are parted then, with all their values. */
static void test_gltf(void **state) {
    (void)state;
    mcv_scene *scene = load_gltf_box("");
    assert_int_equal(scene->meshes[0].vertex_count, 8);
    expect_normal(scene, 0, 0, (const double[3]){0, 0.6, 0.8}, rounding);
    mcv_scene_free(scene);
    scene = load_gltf_box(",\"creaseAngle\":\"89deg\"");
    const mcv_mesh *mesh = scene->meshes;
    assert_int_equal(mesh->vertex_count, 36);
    for (uint32_t t = 0; t < 12; ++t)
        for (int c = 0; c < 3; ++c) {
            double face[3], corners[3][3];
            mcv_scene_face_normal(scene, 0, t, face);
            mcv_normalize3(face, face);
            expect_normal(scene, t, c, face, rounding);
            mcv_scene_corners(scene, 0, t, corners);
            const float *uv = mesh->texcoords + 2 * (size_t)mesh->indices[3 * t + (uint32_t)c];
            for (int i = 0; i < 2; ++i)
                if (fabs(1000 * corners[c][i] - uv[i]) > 12 * rounding)
                    fail_msg("triangle %u corner %d: texture coordinate %d is %g, must be %g", t, c,
                             i, uv[i], 1000 * corners[c][i]);
        }
    mcv_scene_free(scene);
}

/* --- a dome on a plate --- */

enum { SECTORS = 48, RINGS = 10 };

/* A point of the dome's profile, in mm: up the bottom and the side, along the flat rim, up the cap
 * of a sphere of radius 40 mm. */
static void profile_at(int k, double *r, double *z) {
    static const double foot[4][2] = {{0, -2}, {14, -2}, {14, 0}, {12, 0}};
    const double slope = asin(12.0 / 40) * (RINGS + 3 - k) / RINGS;
    *r = k < 4 ? foot[k][0] : 40 * sin(slope);
    *z = k < 4 ? foot[k][1] : 40 * cos(slope) - 40 * cos(asin(12.0 / 40));
}

static solid make_dome(void) {
    solid s = {0};
    for (int k = 0; k + 1 < RINGS + 4; ++k)
        for (int j = 0; j < SECTORS; ++j) {
            double p[4][3];
            for (int c = 0; c < 4; ++c) {
                double r, z;
                const double angle = 2 * M_PI / SECTORS * ((j + c / 2) % SECTORS);
                profile_at(k + (c == 1 || c == 2), &r, &z);
                memcpy(p[c], (double[3]){r * cos(angle), r * sin(angle), z}, sizeof p[c]);
            }
            if (k == 0)
                add_triangle(&s, (const double[3][3]){{p[0][0], p[0][1], p[0][2]},
                                                      {p[2][0], p[2][1], p[2][2]},
                                                      {p[1][0], p[1][1], p[1][2]}});
            else if (k == RINGS + 2)
                add_triangle(&s, (const double[3][3]){{p[0][0], p[0][1], p[0][2]},
                                                      {p[3][0], p[3][1], p[3][2]},
                                                      {p[1][0], p[1][1], p[1][2]}});
            else
                add_quad(&s, p[0], p[3], p[2], p[1]);
        }
    return s;
}

/* Does check say that edges are rounded? And of the rim's normals, how far is the worst off the
 * axis? */
static void expect_dome(const char *rest, const char *told, double least, double most) {
    solid s = make_dome();
    mcv_scene *scene = load_solid(&s, rest);
    mcv_findings findings;
    double worst = 0;
    bool found = false;
    assert_int_equal(mcv_findings_of(scene, &findings, &error), MCV_OK);
    for (size_t i = 0; i < findings.count; ++i) {
        found = found || (told && strstr(findings.items[i].sentence, told));
        if (!told && strstr(findings.items[i].sentence, "creaseAngle"))
            fail_msg("%s: %s", rest, findings.items[i].sentence);
    }
    if (told && !found) fail_msg("%s: no finding \"%s\"", rest, told);
    mcv_findings_free(&findings);
    for (uint32_t t = 0; t < scene->meshes[0].triangle_count; ++t) {
        double normals[3][3], face[3];
        mcv_scene_face_normal(scene, 0, t, face);
        mcv_normalize3(face, face);
        mcv_scene_vertex_normals(scene, 0, t, normals);
        for (int c = 0; c < 3 && face[2] > 0.99999; ++c)
            worst = fmax(worst, hypot(normals[c][0], normals[c][1]));
    }
    if (!(worst >= least && worst <= most))
        fail_msg("%s: normals of the flat rim are off by %g, must be from %g to %g", rest, worst,
                 least, most);
    mcv_scene_free(scene);
}

/*
 * A cap of facets of 1.7 degrees, on a flat rim that it meets under 16.6, on a side of facets of
 * 7.5: an edge, although blunter ones are curves elsewhere. An angle above it rounds the rim.
 */
static void test_dome_on_a_plate(void **state) {
    (void)state;
    solid s = make_dome();
    mcv_scene *scene = load_solid(&s, "");
    mcv_facets facets;
    assert_int_equal(mcv_facets_of(scene, 0, &facets, &error), MCV_OK);
    const mcv_bend_range range = mcv_facets_range(&facets);
    mcv_facets_free(&facets);
    mcv_scene_free(scene);
    /* The chord of a ring leans by the middle of its slopes; that of a sector of the last ring by
     * tan' = tan cos of half a sector. Coordinates of 14 mm are rounded to 1e-6 mm, facets are
     * 1 mm: 1e-5. */
    const double slope = asin(12.0 / 40) * (RINGS - 0.5) / RINGS;
    const double side = 2 * M_PI / SECTORS, edge = atan(tan(slope) / cos(side / 2));
    if (!(fabs(range.curved - side) < 1e-5 && fabs(range.edge - edge) < 1e-5))
        fail_msg("curves bend by up to %g, must be %g; edges by %g or more, must be %g",
                 range.curved, side, range.edge, edge);
    assert_true(mcv_crease_degrees(range) == floor(sqrt(side * edge) * 180 / M_PI));
    assert_true(mcv_crease_degrees((mcv_bend_range){0, INFINITY}) == 30);
    assert_true(mcv_crease_degrees((mcv_bend_range){0.2, 0.1}) == 30);
    expect_dome("", "made of flat facets", 0, 0);
    /* At the rim's inner circle the sum of a flat face and the cap's first ring leans. */
    expect_dome(",\"creaseAngle\":\"30deg\"", "round 48 of its edges", 0.05, sin(slope));
    expect_dome(",\"creaseAngle\":\"11deg\"", NULL, 0, rounding);
}

/* Facets of 10 and 20 degrees: their edges are smooth, those of the ends sharp. */
static void test_cylinder(void **state) {
    enum { SIDES = 24 };
    solid s = {0};
    (void)state;
    for (int k = 0; k < SIDES; ++k) {
        double p[4][3];
        for (int c = 0; c < 4; ++c) {
            const double angle =
                M_PI / 12 * ((k + c % 2) % SIDES) +
                M_PI / 36 * ((k + c % 2) % 2); /* the last facet ends where the first begins */
            p[c][0] = 5 * cos(angle);
            p[c][1] = 5 * sin(angle);
            p[c][2] = c < 2 ? 0 : 7;
        }
        add_quad(&s, p[0], p[1], p[3], p[2]);
        add_triangle(&s,
                     (const double[3][3]){{0, 0, 0}, {p[1][0], p[1][1], 0}, {p[0][0], p[0][1], 0}});
        add_triangle(&s,
                     (const double[3][3]){{0, 0, 7}, {p[2][0], p[2][1], 7}, {p[3][0], p[3][1], 7}});
    }
    mcv_scene *scene = load_solid(&s, ",\"creaseAngle\":\"20deg\"");
    for (uint32_t t = 0; t < 4 * SIDES; ++t)
        for (int c = 0; c < 3; ++c) {
            double corners[3][3];
            mcv_scene_corners(scene, 0, t, corners);
            const double radial[3] = {corners[c][0] / 0.005, corners[c][1] / 0.005, 0},
                         axial[3] = {0, 0, t % 4 == 2 ? -1 : 1};
            expect_normal(scene, t, c, t % 4 < 2 ? radial : axial, rounding);
        }
    mcv_scene_free(scene);
}

/*
 * Two planes that meet at 20 degrees, and a triangle as good as without height between them, as CAD
 * programs leave it where edges do not match: past it the planes are one surface, its own
 * direction, which is none, counts nowhere.
 */
static void test_sliver(void **state) {
    const double c = cos(M_PI / 18), d = 10 * sin(M_PI / 18);
    const double a[3] = {0, 0, 0}, b[3] = {0, 10, 0}, middle[3] = {0, 5, 1e-6};
    const double left[3] = {-10 * c, 5, -d}, right[3] = {10 * c, 5, -d};
    solid s = {0};
    (void)state;
    add_triangle(&s, (const double[3][3]){
                         {a[0], a[1], a[2]}, {b[0], b[1], b[2]}, {left[0], left[1], left[2]}});
    add_triangle(&s, (const double[3][3]){{a[0], a[1], a[2]},
                                          {right[0], right[1], right[2]},
                                          {middle[0], middle[1], middle[2]}});
    add_triangle(&s, (const double[3][3]){{middle[0], middle[1], middle[2]},
                                          {right[0], right[1], right[2]},
                                          {b[0], b[1], b[2]}});
    add_triangle(&s, (const double[3][3]){{b[0], b[1], b[2]},
                                          {a[0], a[1], a[2]},
                                          {middle[0], middle[1], middle[2]}});
    mcv_scene *scene = load_solid(&s, ",\"creaseAngle\":\"30deg\"");
    /* At a and b the same angle on both sides, but the edge to the middle is half as long: its
     * plane counts twice. 1e-6 mm of 10 mm turn a plane by 1e-7. */
    const double length = hypot(sin(M_PI / 18), 3 * c),
                 up[3] = {sin(M_PI / 18) / length, 0, 3 * c / length};
    expect_normal(scene, 0, 0, up, 1e-6);
    expect_normal(scene, 0, 1, up, 1e-6);
    expect_normal(scene, 1, 0, up, 1e-6);
    expect_normal(scene, 2, 2, up, 1e-6);
    mcv_scene_free(scene);
}

/* --- a ball lens
 * ------------------------------------------------------------------------------------------------
 */

static void halve(solid *s, const double a[3], const double b[3], const double c[3], int times) {
    double m[3][3];
    if (times == 0) {
        double corners[3][3];
        for (int i = 0; i < 3; ++i)
            corners[0][i] = 5 * a[i], corners[1][i] = 5 * b[i], corners[2][i] = 5 * c[i];
        add_triangle(s, (const double(*)[3])corners);
        return;
    }
    const double *p[4] = {a, b, c, a};
    for (int k = 0; k < 3; ++k) {
        double squared = 0;
        for (int i = 0; i < 3; ++i) {
            m[k][i] = p[k][i] + p[k + 1][i];
            squared += m[k][i] * m[k][i];
        }
        for (int i = 0; i < 3; ++i) m[k][i] /= sqrt(squared);
    }
    halve(s, a, m[0], m[2], times - 1);
    halve(s, m[0], b, m[1], times - 1);
    halve(s, m[2], m[1], c, times - 1);
    halve(s, m[0], m[1], m[2], times - 1);
}

/* An octahedron, its faces cut into 4^times. */
static solid make_ball(int times) {
    solid s = {0};
    for (int f = 0; f < 8; ++f) {
        double p[3][3] = {{f & 1 ? -1 : 1, 0, 0}, {0, f & 2 ? -1 : 1, 0}, {0, 0, f & 4 ? -1 : 1}};
        const bool mirrored = (f & 1) ^ (f >> 1 & 1) ^ (f >> 2 & 1);
        halve(&s, p[0], mirrored ? p[2] : p[1], mirrored ? p[1] : p[2], times);
    }
    return s;
}

enum { RAYS = 200 };

/*
 * The root mean square by which rays parallel to the axis, up to half the radius, miss the place
 * where those through the exact ball of R = 5 mm and n = 1.5 go, in the plane of its paraxial
 * focus, n R/(2 (n - 1)) = 7.5 mm behind its middle.
 */
static double miss(const mcv_scene *scene) {
    const double radius = 5e-3, n = 1.5, focus = 7.5e-3;
    mcv_trace_ray rays[RAYS];
    mcv_render_options options = mcv_render_defaults();
    mcv_vertex *vertices;
    size_t count, rays_through = 0;
    double sum = 0, heights[RAYS], angles[RAYS];
    for (int i = 0; i < RAYS; ++i) {
        heights[i] = 0.5 * radius * sqrt((i + 0.5) / RAYS);
        angles[i] = 2.399963229728653 * i; /* golden: even over the disk */
        rays[i] = (mcv_trace_ray){{heights[i] * cos(angles[i]), heights[i] * sin(angles[i]), 0.02},
                                  {0, 0, -1}};
    }
    if (mcv_reference_trace(scene, rays, RAYS, &options, &vertices, &count, &error) != MCV_OK)
        fail_msg("%s", error.text);
    for (size_t v = 0; v < count; ++v) {
        if (vertices[v].index != 2 || vertices[v].event != MCV_EVENT_REFRACT) continue;
        const double *at = vertices[v].position, *along = vertices[v].direction;
        const double h = heights[vertices[v].ray], angle = angles[vertices[v].ray];
        /* It meets the ball at an angle i, is turned by i - r twice, and leaves at an angle 2 r - i
         * from the axis. */
        const double i = asin(h / radius), r = asin(h / (n * radius)), place = 2 * r - i,
                     turned = 2 * (i - r);
        const double exact = radius * sin(place) - (focus - radius * cos(place)) * tan(turned);
        const double s = (-focus - at[2]) / along[2];
        const double x = at[0] + s * along[0] - exact * cos(angle),
                     y = at[1] + s * along[1] - exact * sin(angle);
        sum += x * x + y * y;
        ++rays_through;
    }
    free(vertices);
    assert_int_equal(rays_through, RAYS);
    return sqrt(sum / RAYS);
}

/*
 * Vertex normals of a ball are exact. Facets of edge h lie up to h²/(8 R) below it and their
 * interpolated normals err by as much over R: the error falls with h², by four for each halving.
 * Without vertex normals a facet's normal is off by h/R, and the error falls with h: no lens.
 */
static void test_ball_focuses(void **state) {
    double smooth[4], flat[4];
    (void)state;
    for (int k = 0; k < 4; ++k) {
        solid s = make_ball(3 + k);
        mcv_scene *scene = load_solid(&s, ",\"creaseAngle\":\"30deg\"");
        smooth[k] = miss(scene);
        mcv_scene_free(scene);
        s = make_ball(3 + k);
        scene = load_solid(&s, "");
        flat[k] = miss(scene);
        mcv_scene_free(scene);
        print_message("%6d triangles: rays miss by %.3g um, flat by %.3g um\n", 8 << 2 * (3 + k),
                      1e6 * smooth[k], 1e6 * flat[k]);
    }
    for (int k = 1; k < 4; ++k) {
        if (!(smooth[k - 1] / smooth[k] > 3 && smooth[k - 1] / smooth[k] < 5))
            fail_msg("falls by %.3g", smooth[k - 1] / smooth[k]);
        if (!(flat[k - 1] / flat[k] < 3)) fail_msg("flat: falls by %.3g", flat[k - 1] / flat[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_box),
                                       cmocka_unit_test(test_gltf),
                                       cmocka_unit_test(test_dome_on_a_plate),
                                       cmocka_unit_test(test_cylinder),
                                       cmocka_unit_test(test_sliver),
                                       cmocka_unit_test(test_ball_focuses)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
