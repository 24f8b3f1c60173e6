/* SPDX-License-Identifier: Apache-2.0 */
/* Defects in meshes: closed meshes stay closed and change their volume by the closed form, normals
 * follow the law, and what cannot be is refused in one sentence. */
#include "defect_parts.h"
#include "loader/load.h"
#include "scene_files.h"

/* What the law adds to the volume: the integral of h over the plane. */
static double law_volume(const mcv_defect *d) {
    const double a = d->size, sign = d->type == MCV_DEFECT_BUMP ? 1 : -1;
    if (d->type != MCV_DEFECT_SCRATCH)
        return sign * d->depth *
               (d->form == MCV_SHAPE_GAUSSIAN ? M_PI * a * a / 8 * (1 - exp(-12.5))
                                              : M_PI * a * a / 4 * (0.5 - 2 / (M_PI * M_PI)));
    /* The area of the sharp groove, whose rounding keeps it, per depth of the rounded one. */
    const bool v = d->form == MCV_PROFILE_V;
    const double area = (v ? 1 : 4.0 / 3) / (v ? 1 - 0.25 / 3 : 1 - 0.0625 / 6) * a / 2;
    return -d->depth * area * (1 - d->pile_up) * (d->length - fmin(3 * a, d->length / 2));
}

static double largest_slope(const mcv_defect *d) {
    if (d->type == MCV_DEFECT_SCRATCH)
        return (d->form == MCV_PROFILE_V ? 1 / (1 - 0.25 / 3) : 2 / (1 - 0.0625 / 6)) * d->depth /
               (d->size / 2);
    return d->form == MCV_SHAPE_GAUSSIAN ? 4 * exp(-0.5) * d->depth / d->size
                                         : M_PI * d->depth / d->size;
}

/* --- properties --- */

static mcv_defect random_defect(uint64_t *state) {
    mcv_defect d = {.name = (char *)"one", .type = (uint32_t)(random_bits(state) % 3)};
    d.size = 0.02 * pow(5, random_unit(state));
    d.depth = d.size * (0.02 + 0.2 * random_unit(state));
    d.form = (int)(random_bits(state) % 2);
    if (d.type != MCV_DEFECT_SCRATCH) return d;
    d.size *= 0.3;
    d.depth *= 0.3;
    d.length = d.size * (2 + 10 * random_unit(state));
    d.pile_up = random_unit(state) < 0.5 ? 0 : random_unit(state);
    return d;
}

/* A direction in the half of the cube's sides that stay clear of the edges, or of the ball. */
static void random_site(part which, uint64_t *state, mcv_defect_site *site) {
    *site = (mcv_defect_site){.node = "part", .by_point = true};
    random_direction(state, site->at);
    random_direction(state, site->direction);
    if (which == BALL) return;
    const int axis = (int)(random_bits(state) % 3);
    for (int i = 0; i < 3; ++i)
        site->at[i] = i == axis ? copysign(0.5, site->at[i]) : 0.6 * (random_unit(state) - 0.5);
}

/* The error of the mesh's interpolated normals against the law, on the plane side of a cube: where
 * the map has moved a point, u and v are those of the point before. */
static double normal_error(const mcv_scene *scene, const mcv_defect *d, uint64_t *state) {
    double worst = 0;
    for (uint32_t t = 0; t < scene->triangle_count; ++t) {
        double c[3][3], n[3][3], at[3] = {0, 0, 0}, normal[3] = {0, 0, 0}, slope[2], local[3][3];
        const double r = sqrt(random_unit(state)), s = random_unit(state);
        const double weights[3] = {1 - r, r * (1 - s), r * s};
        mcv_scene_corners(scene, 0, t, c);
        mcv_scene_vertex_normals(scene, 0, t, n);
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i) {
                local[k][i] = 0;
                for (int j = 0; j < 3; ++j) local[k][i] += (c[k][j] - d->centre[j]) * d->axes[i][j];
                at[i] += weights[k] * local[k][i];
                for (int j = 0; j < 3; ++j) normal[i] += weights[k] * n[k][j] * d->axes[i][j];
            }
        if (fabs(at[2]) > 2 * d->depth || normal[2] < 0.1) continue; /* another side */
        mcv_defect_height(d, at[0], at[1], slope);
        for (int i = 0; i < 2; ++i) worst = fmax(worst, fabs(-normal[i] / normal[2] - slope[i]));
    }
    return worst;
}

/*
 * Volume: between vertices h is linear. Over triangles with edges e that errs by at most e²/8 times
 * the second derivative, which changes sign within the footprint; 1e-3 of the whole groove is far
 * above what is left (2e-4).
 * Normals: linear between vertices of exact normals, in relation to the largest slope.
 *   gaussian  e²/8 h''' = 1.38/0.607/8/64 = 0.45 %
 *   cosine    at the rim h'' jumps by J: J e/4 = 2π/64/4 = 2.5 %
 *   scratch   rounded by a triangle of the half-width 1/4: 16 (e/size)² = 2.8 %; where ridges begin
 *             and end h'' jumps by π²/4 in units of depth and half width: another 5.1 % of pileUp
 * An eighth is added for edges that do not lie along the slope.
 */
static double normal_tolerance(const mcv_defect *d) {
    const double most = d->type == MCV_DEFECT_SCRATCH   ? 0.028 + 0.051 * d->pile_up
                        : d->form == MCV_SHAPE_GAUSSIAN ? 0.0045
                                                        : 0.025;
    return 1.125 * most;
}

static void expect_law(const mcv_scene *scene, const mcv_defect *d, double before, bool plane,
                       uint64_t *state, const char *what) {
    mcv_defect groove = *d;
    groove.pile_up = 0;
    const double change = volume_of(scene) - before, law = law_volume(d),
                 whole = fabs(law_volume(&groove));
    if (!(fabs(change - law) < 1e-3 * whole))
        fail_msg("%s: the volume changes by %g, must be %g", what, change, law);
    if (!plane) return;
    const double slope = largest_slope(d), error = normal_error(scene, d, state) / slope;
    if (!(error < normal_tolerance(d)))
        fail_msg("%s: normals err by %g of the largest slope, may by %g", what, error,
                 normal_tolerance(d));
}

static void keeps_properties(void **state) {
    uint64_t random = 7;
    (void)state;
    for (int i = 0; i < 36; ++i) {
        const part which = (part)(i % PART_COUNT);
        const mcv_transform frame = frame_of(i / PART_COUNT % 3);
        mcv_scene *scene = scene_of(which, &frame);
        mcv_defect d = random_defect(&random);
        mcv_defect_site site;
        char what[256];
        random_site(which, &random, &site);
        const double before = volume_of(scene);
        apply(scene, &site, &d);
        snprintf(what, sizeof what, "%d: %s %d, part %d, size %g, depth %g, length %g, pile-up %g",
                 i, mcv_defect_types[d.type], d.form, which, d.size, d.depth, d.length, d.pile_up);
        expect_closed(scene, what);
        expect_law(scene, &d, before, which != BALL, &random, what);
        mcv_scene_free(scene);
    }
}

/* --- scene files --- */

/* Two nodes with the same mesh, the x side of a cube of 20 mm as its one side; the third emits. */
static char *scene_text(const char *defects) {
    const float positions[12] = {0, -0.01f, -0.01f, 0, 0.01f,  -0.01f,
                                 0, 0.01f,  0.01f,  0, -0.01f, 0.01f};
    const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    char bytes[sizeof positions + sizeof indices];
    memcpy(bytes, positions, sizeof positions);
    memcpy(bytes + sizeof positions, indices, sizeof indices);
    char *data = base64(bytes, sizeof bytes);
    char *text = text_of(
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],"
        "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
        "\"min\":[0,-0.01,-0.01],\"max\":[0,0.01,0.01]},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
        "\"nodes\":[{\"name\":\"plate\",\"mesh\":0,\"scale\":[2,2,2]},"
        "{\"name\":\"other\",\"mesh\":0,\"translation\":[1,0,0]},"
        "{\"name\":\"lamp\",\"mesh\":0,\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}},"
        "{\"name\":\"empty\"}],"
        "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"type\":\"area\",\"radiance\":1}]},"
        "\"MCVISI_defects\":{\"defects\":[%s]}}}",
        data, defects);
    free(data);
    return text;
}

/* Lengths along the axes are metres of the scene: the plate is twice as large as its mesh. */
static void reads_files(void **state) {
    mcv_scene *scene;
    mcv_error error;
    char *text = scene_text(
        "{\"name\":\"nick\",\"type\":\"dent\",\"node\":\"plate\",\"at\":[0,\"15mm\",-0.01],"
        "\"size\":\"1mm\"},{\"name\":\"scar\",\"type\":\"scratch\",\"node\":\"plate\","
        "\"triangle\":1,\"barycentric\":[0.5,0.25,0.25],\"direction\":[0,1,1],\"size\":\"0.5mm\"}");
    (void)state;
    if (load_text("defects.gltf", text, "defects/nick/size=2mm", &scene, &error) != MCV_OK)
        fail_msg("%s", error.text);
    free(text);
    assert_int_equal(scene->defect_count, 2);
    const mcv_defect *nick = scene->defects, *scar = scene->defects + 1;
    assert_string_equal(nick->name, "nick");
    assert_true(fabs(nick->size - 2e-3) < 1e-15);
    assert_true(fabs(nick->depth - 2e-4) < 1e-15);  /* a tenth */
    assert_true(fabs(scar->length - 1e-2) < 1e-15); /* 20 sizes */
    const double middle[3] = {0, 0.015, -0.01}, by_triangle[3] = {0, -0.01, 0};
    for (int i = 0; i < 3; ++i) {
        assert_true(fabs(nick->centre[i] - middle[i]) < 1e-9);
        assert_true(fabs(scar->centre[i] - by_triangle[i]) < 1e-9);
        assert_true(fabs(scar->axes[2][i] - (i == 0)) < 1e-12);
        assert_true(fabs(scar->axes[0][i] - (i == 0 ? 0 : M_SQRT1_2)) < 1e-12);
    }
    /* The other nodes keep their two triangles; the plate has a mesh of its own. */
    assert_true(scene->meshes[scene->instances[0].mesh].triangle_count > 2000);
    for (uint32_t i = 1; i < 3; ++i) {
        assert_int_equal(scene->meshes[scene->instances[i].mesh].triangle_count, 2);
        assert_int_equal(scene->instances[i].first_triangle, scene->triangle_count - 6 + 2 * i);
    }
    mcv_scene_free(scene);
}

static void refuses(const char *defect, const char *says) {
    char *text = scene_text(defect);
    must_refuse("defects-bad.gltf", text, says);
    free(text);
}

#define PLACED "\"node\":\"plate\",\"at\":[0,0,0],"

static void refuses_bad_input(void **state) {
    (void)state;
    refuses("{\"type\":\"dint\"," PLACED "\"size\":1e-3}", "did you mean \"dent\"");
    refuses("{\"type\":\"dent\"," PLACED "\"depth\":1e-3}", "size");
    refuses("{\"type\":\"dent\"," PLACED "\"size\":-1e-3}", "size");
    refuses("{\"type\":\"dent\"," PLACED "\"size\":1e-3,\"lenght\":1}", "lenght");
    refuses("{\"type\":\"dent\"," PLACED "\"size\":1e-3,\"shape\":\"cosin\"}", "\"cosine\"");
    refuses("{\"type\":\"scratch\"," PLACED "\"size\":1e-3,\"length\":1e-4}", "at least the size");
    refuses("{\"type\":\"dent\",\"node\":\"plat\",\"at\":[0,0,0],\"size\":1e-3}",
            "there is no node \"plat\"; did you mean \"plate\"?");
    refuses("{\"type\":\"dent\",\"node\":\"empty\",\"at\":[0,0,0],\"size\":1e-3}", "a mesh");
    refuses("{\"type\":\"dent\",\"node\":3,\"at\":[0,0,0],\"size\":1e-3}", "node");
    refuses("{\"type\":\"dent\",\"at\":[0,0,0],\"size\":1e-3}", "\"node\"");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"size\":1e-3}", "\"at\" or a \"triangle\"");
    refuses("{\"type\":\"dent\"," PLACED "\"triangle\":1,\"size\":1e-3}", "not both");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"triangle\":2,\"size\":1e-3}",
            "triangles go from 0 to 1");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"triangle\":0,\"barycentric\":[1,1,-1],"
            "\"size\":1e-3}",
            "sum is 1");
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"at\":[0,\"1mn\",0],\"size\":1e-3}",
            "three lengths");
    refuses("{\"type\":\"dent\"," PLACED "\"direction\":[1,0,0],\"size\":1e-3}", "its normal");
    /* The nearest point is told, so that it can be copied. */
    refuses("{\"type\":\"dent\",\"node\":\"plate\",\"at\":[0.002,0.003,0],\"size\":1e-3}",
            "lies 0.002 m off the surface of node \"plate\", more than half of the defect's size: "
            "the nearest point is [0, 0.003, 0]");
    refuses("{\"type\":\"dent\",\"node\":\"lamp\",\"at\":[0,0,0],\"size\":1e-3}", "emits light");
    refuses("{\"type\":\"scratch\"," PLACED "\"size\":1e-7,\"length\":0.03}", "triangles");
}

/* A dent on a cube must not reach the next side, nor be so wide that a ball falls away by 60°. */
static void refuses_edges(void **state) {
    const mcv_transform frame = frame_of(0);
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_scene *scene = scene_of(i ? BALL : CUBE, &frame);
        const mcv_defect_site site = {
            .node = "part", .by_point = true, .at = {i ? 1 : 0.5, i ? 0 : 0.48, 0}};
        mcv_defect d = {.name = (char *)"one",
                        .form = MCV_SHAPE_COSINE,
                        .size = i ? 1.8 : 0.1, /* 2 sin 60° = 1.73 */
                        .depth = 0.001};
        assert_int_equal(mcv_defect_locate(scene, &site, &d, &place, &error), MCV_OK);
        assert_int_equal(mcv_defect_apply(scene, &d, &place, &error), MCV_BAD_INPUT);
        if (!strstr(error.text, "round an edge")) fail_msg("%s", error.text);
        mcv_scene_free(scene);
    }
}

/* The back of a plate as thin as a dent is deep stays as it is. */
static void spares_the_back(void **state) {
    const mcv_transform thin = {{1, 0, 0, 0, 1, 0, 0, 0, 0.004, 0, 0, 0}};
    const mcv_defect_site site = {.node = "part", .by_point = true, .at = {0.1, 0.2, 0.002}};
    mcv_defect d = {.name = (char *)"one", .size = 0.05, .depth = 0.003};
    mcv_scene *scene = scene_of(CUBE, &thin);
    (void)state;
    const double before = volume_of(scene);
    apply(scene, &site, &d);
    expect_closed(scene, "a thin plate");
    assert_true(fabs(volume_of(scene) - before - law_volume(&d)) < 1e-3 * -law_volume(&d));
    for (uint32_t v = 0; v < scene->meshes[0].vertex_count; ++v) {
        double world[3];
        mcv_scene_vertex(scene, 0, v, world);
        if (world[2] < -0.0015 && fabs(world[0]) < 0.49 && fabs(world[1]) < 0.49)
            assert_true(fabs(world[2] + 0.002) < 1e-9);
    }
    mcv_scene_free(scene);
}

/* What is deeper than its plate is thick would come out at the back. A bump goes the other way. */
static void refuses_to_go_through(void **state) {
    static const uint32_t types[] = {MCV_DEFECT_DENT, MCV_DEFECT_SCRATCH, MCV_DEFECT_DIG,
                                     MCV_DEFECT_BUMP};
    const mcv_transform thin = {{1, 0, 0, 0, 1, 0, 0, 0, 0.004, 0, 0, 0}};
    const mcv_defect_site site = {.node = "part", .by_point = true, .at = {0.1, 0.2, 0.002}};
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    (void)state;
    for (size_t i = 0; i < 4; ++i)
        for (int deeper = 0; deeper < 2; ++deeper) {
            mcv_scene *scene = scene_of(CUBE, &thin);
            mcv_defect d = {.name = (char *)"one", .type = types[i], .size = 0.05, .length = 0.2};
            d.depth = deeper ? 0.0041 : 0.0039;
            const bool through = deeper && types[i] != MCV_DEFECT_BUMP;
            assert_int_equal(mcv_defect_locate(scene, &site, &d, &place, &error), MCV_OK);
            const mcv_result result = mcv_defect_apply(scene, &d, &place, &error);
            assert_int_equal(result, through ? MCV_BAD_INPUT : MCV_OK);
            if (through && !strstr(error.text, "0.004 m thick")) fail_msg("%s", error.text);
            mcv_scene_free(scene);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_properties),  cmocka_unit_test(reads_files),
        cmocka_unit_test(refuses_bad_input), cmocka_unit_test(refuses_edges),
        cmocka_unit_test(spares_the_back),   cmocka_unit_test(refuses_to_go_through)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
