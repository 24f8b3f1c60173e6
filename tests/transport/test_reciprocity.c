/* SPDX-License-Identifier: Apache-2.0 */
/* A projector and a camera change places: the light transport matrix becomes its transpose. */
#include "transport.h"

#include <math.h>

/* What looks at a block on a table, both diffuse, from one of two sides: pixels in the plane that
 * is in focus, and a cone about its normal. */
typedef struct view {
    uint32_t columns, rows;
    double width, height; /* of a pixel [mm] */
    double distance;      /* of that plane [mm] */
    double azimuth;       /* [degrees] */
    double aperture;      /* sine of the cone's half angle */
} view;

static const view views[2] = {{6, 5, 3, 3, 60, 0, 0.02}, {7, 4, 2.5, 3, 70, 40, 0.03}};

static double etendue_of(const view *v) { return v->width * v->height * v->aperture * v->aperture; }

static mcv_transport *exchanged(mcv_session *session, const view *camera, const view *projector) {
    char text[4096];
    const int length = snprintf(
        text, sizeof text,
        "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1, 2, 3]}],"
        " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": [{\"name\": \"camera\","
        " \"type\": \"telecentric\", \"magnification\": 0.1, \"workingDistance\": \"100mm\","
        " \"numericalAperture\": %.17g, \"resolution\": [%u, %u], \"pixelSize\": [%.17g, %.17g],"
        " \"radiometry\": \"radiance\"}]},"
        " \"MCVISI_emitters\": {\"emitters\": [{\"name\": \"projector\","
        " \"type\": \"telecentricProjector\", \"size\": [%.17g, %.17g], \"halfAngle\": %.17g,"
        " \"radiance\": 1, \"image\": \"picture\"}]},"
        " \"MCVISI_surfaces\": {\"surfaces\": ["
        "{\"type\": \"box\", \"width\": 0.06, \"height\": 0.06, \"depth\": 0.002,"
        " \"material\": \"white\"}, {\"type\": \"box\", \"width\": 0.006, \"height\": 0.006,"
        " \"depth\": 0.005, \"material\": \"grey\"}]}},"
        " \"images\": [{\"name\": \"picture\", \"uri\": \"transport-grey.png\"}],"
        " \"samplers\": [{\"magFilter\": 9728}],"
        " \"materials\": [{\"name\": \"white\", \"extensions\": {\"MCVISI_materials\":"
        " {\"type\": \"diffuse\", \"reflectance\": 0.9}}},"
        " {\"name\": \"grey\", \"extensions\": {\"MCVISI_materials\":"
        " {\"type\": \"diffuse\", \"reflectance\": 0.6}}}],"
        " \"nodes\": [{\"name\": \"camera\", \"extensions\": {\"MCVISI_pose\": {\"target\": [0, 0, "
        "0],"
        " \"distance\": %.17g, \"azimuth\": \"%.17gdeg\"}, \"MCVISI_sensors\": {\"sensor\": 0}}},"
        " {\"name\": \"projector\", \"extensions\": {\"MCVISI_pose\": {\"target\": [0, 0, 0],"
        " \"distance\": %.17g, \"azimuth\": \"%.17gdeg\"}, \"MCVISI_emitters\": {\"emitter\": 0}}},"
        " {\"name\": \"table\", \"translation\": [0, 0, -0.001],"
        "  \"extensions\": {\"MCVISI_surfaces\": {\"surface\": 0}}},"
        " {\"name\": \"block\", \"translation\": [0.001, 0.002, 0.0025],"
        "  \"extensions\": {\"MCVISI_surfaces\": {\"surface\": 1}}}]}",
        camera->aperture, camera->columns, camera->rows, camera->width * 1e-4,
        camera->height * 1e-4, projector->columns * projector->width * 1e-3,
        projector->rows * projector->height * 1e-3, asin(projector->aperture),
        camera->distance * 1e-3 + 0.1, camera->azimuth, projector->distance * 1e-3,
        projector->azimuth);
    assert_true(length < (int)sizeof text);
    write_grey(projector->columns, projector->rows);
    mcv_rig *rig = open_text("transport-exchanged.gltf", text);
    mcv_transport *transport = transport_of(session, rig, "{\"spp\": 8192, \"replicates\": 16}");
    mcv_rig_free(rig);
    return transport;
}

/* An entry and the variance of its replicates' mean. */
static double entry_of(const mcv_matrix_entries *e, size_t row, uint32_t column, double *variance) {
    *variance = 0;
    for (uint64_t i = e->row_begins[row]; i < e->row_begins[row + 1]; ++i) {
        if (e->columns[i] != column) continue;
        for (uint32_t r = 0; r < e->replicate_count; ++r)
            *variance += pow((double)e->replicates[i * e->replicate_count + r] - e->values[i], 2) /
                         (e->replicate_count * (e->replicate_count - 1.0));
        return e->values[i];
    }
    return 0;
}

/*
 * Helmholtz: what a pixel of a projector sends to a pixel of a camera is what it gets from there,
 * when both change places. Values are radiances, so that T_ij times the étendue of pixel i is the
 * same. The difference over its standard error has the mean square 1.07 (Student's t, some 30
 * degrees of freedom), over some 800 entries ± 0.06; small angles have the cosine 1 to 5e-4. Of so
 * many values 6 deviations are not passed.
 */
static void test_reciprocity(void **state) {
    (void)state;
    mcv_session *session = open_session(NULL);
    mcv_transport *there = exchanged(session, &views[0], &views[1]),
                  *back = exchanged(session, &views[1], &views[0]);
    const mcv_matrix_entries a = entries_of(there), b = entries_of(back);
    double squares = 0, flux[2] = {0, 0}, worst = 0;
    uint32_t count = 0;
    assert_int_equal(a.row_count, b.element_count);
    assert_int_equal(b.row_count, a.element_count);
    for (uint32_t i = 0; i < a.row_count; ++i)
        for (uint32_t j = 0; j < b.row_count; ++j) {
            double va, vb;
            const double ga = etendue_of(&views[0]), gb = etendue_of(&views[1]),
                         x = ga * entry_of(&a, i, j, &va), y = gb * entry_of(&b, j, i, &vb),
                         deviation = sqrt(ga * ga * va + gb * gb * vb);
            flux[0] += x;
            flux[1] += y;
            if (!(deviation > 0)) continue;
            ++count;
            squares += pow((x - y) / deviation, 2);
            worst = fmax(worst, fabs(x - y) / deviation);
        }
    print_message("%u entries: mean square %.3f, worst %.2f, sums %.5g %.5g\n", count,
                  squares / count, worst, flux[0], flux[1]);
    assert_true(count > 400);
    assert_float_equal(squares / count, 1.07, 0.3);
    assert_true(worst < 6);
    assert_float_equal(flux[0] / flux[1], 1, 0.01);
    mcv_transport_free(there);
    mcv_transport_free(back);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_reciprocity)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
