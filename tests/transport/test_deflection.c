/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Deflections of light against closed forms. A telecentric camera looks along -z through a body
 * onto a light field emitter with J = 1024 directions in x, so that each sight ray has one
 * direction: its bin is at most half a bin, a/J, off.
 */
#include "../api/api.h"

#include <math.h>

enum { COLUMNS = 16, ROWS = 2, DIRECTIONS = 1024 };

static const double pixel = 0.5e-3; /* of the object */

/* The camera's pixels, column by column, lie at these x. */
static double place(double column) { return (column - COLUMNS / 2.0) * pixel; }

static void write_white(const char *path) {
    static float grey[DIRECTIONS];
    mcv_picture *picture = NULL;
    for (int i = 0; i < DIRECTIONS; ++i) grey[i] = 255;
    WELL(mcv_picture_make(DIRECTIONS, 1, 1, grey, NULL, "{\"mcvisi:bits\": 8}", &picture, &error));
    WELL(mcv_picture_write(picture, path, "{\"preview\": true}", &error));
    mcv_picture_free(picture);
}

/* A rig about a body, by the members of its node and of the file; range: a of the emitter. */
static mcv_rig *rig_of(double range, const char *node, const char *members) {
    static const char text[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 1, 2]}],"
        " \"extensions\": {\"MCVISI_sensors\": {\"sensors\": [{\"name\": \"camera\","
        " \"type\": \"telecentric\", \"magnification\": 1, \"workingDistance\": \"100mm\","
        " \"fNumber\": 1000, \"resolution\": [16, 2], \"pixelSize\": \"500um\","
        " \"radiometry\": \"radiance\"}]},"
        " \"MCVISI_emitters\": {\"emitters\": [{\"name\": \"display\", \"type\": \"lightField\","
        " \"size\": [\"60mm\", \"60mm\"], \"radiance\": 2, \"image\": \"white\","
        " \"spatialResolution\": [1, 1], \"angularResolution\": [1024, 1],"
        " \"angularRange\": %g}]}%s},"
        " \"images\": [{\"name\": \"white\", \"uri\": \"deflection-white.png\"}],"
        " \"materials\": [{\"name\": \"glass\", \"extensions\": {\"MCVISI_materials\":"
        " {\"type\": \"dielectric\", \"ior\": 1.5}}}],"
        " \"nodes\": [{\"name\": \"camera\", \"translation\": [0, 0, 0.1],"
        "   \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}}},"
        "  {\"name\": \"display\", \"translation\": [0, 0, -0.05], \"rotation\": [0, 1, 0, 0],"
        "   \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}}},"
        "  {\"name\": \"part\"%s}]}";
    const size_t room = sizeof text + strlen(node) + strlen(members) + 64;
    char *whole = malloc(room);
    mcv_rig *rig = NULL;
    write_white("deflection-white.png");
    snprintf(whole, room, text, range, members, node);
    FILE *file = fopen("deflection.gltf", "w");
    assert_non_null(file);
    fputs(whole, file);
    fclose(file);
    WELL(mcv_rig_open("deflection.gltf", &rig, &error));
    free(whole);
    return rig;
}

/* Paths of three segments: none is reflected inside of the body and leaves it. */
static mcv_transport *transport_of(mcv_session *session, mcv_rig *rig) {
    mcv_transport *transport = NULL;
    WELL(mcv_session_transport(session, rig, "{\"spp\": 256, \"depth\": 3}", NULL, NULL, &transport,
                               NULL, &error));
    mcv_rig_free(rig);
    return transport;
}

static const float *planes_of(const mcv_picture *picture, uint32_t part) {
    mcv_part found = {.size = sizeof found};
    WELL(mcv_picture_part(picture, part, &found, &error));
    return found.planes;
}

/* The deflection in x of a sight ray at x; and of a pixel, over which it is averaged. */
typedef double closed_form(double x, double y);

static double over_pixel(closed_form *form, int column, int row) {
    enum { PARTS = 32 };
    double sum = 0;
    for (int i = 0; i < PARTS * PARTS; ++i)
        sum += form(place(column + (i % PARTS + 0.5) / PARTS),
                    (row - ROWS / 2.0 + (i / PARTS + 0.5) / PARTS) * pixel);
    return sum / (PARTS * PARTS);
}

/* `beyond`: what the closed form leaves out, as a share of it. */
static void check(const char *what, double range, const char *node, const char *members,
                  closed_form *form, double beyond, double transmitted) {
    mcv_session *session = open_session(NULL);
    mcv_transport *transport = transport_of(session, rig_of(range, node, members));
    mcv_picture *picture = NULL, *histogram = NULL;
    double worst = 0, largest = 0;
    WELL(mcv_transport_deflection(transport, NULL, NULL, &picture, &histogram, NULL, &error));
    const float *x = planes_of(picture, 0), *shares = planes_of(picture, 4),
                *bins = planes_of(histogram, 0);
    for (int i = 0; i < COLUMNS * ROWS; ++i) {
        const double expected = over_pixel(form, i % COLUMNS, i / COLUMNS),
                     off = fabs((double)x[i] - expected);
        double sum = 0;
        worst = fmax(worst, off);
        largest = fmax(largest, fabs(expected));
        if (!(off <= range / DIRECTIONS + beyond * fabs(expected)))
            fail_msg("%s: pixel %d: %g, must be %g", what, i, (double)x[i], expected);
        for (int j = 0; j < DIRECTIONS; ++j) sum += (double)bins[i * DIRECTIONS + j];
        /* Floats of 2^-24 each. */
        assert_true(fabs(sum - 1) < 1e-6);
        assert_true(fabs((double)shares[i] - transmitted) < 0.002 * transmitted);
    }
    print_message("%s: up to %.4g, at most %.2g off\n", what, largest, worst);
    mcv_picture_free(picture);
    mcv_picture_free(histogram);
    mcv_transport_free(transport);
    mcv_session_close(session);
}

/* --- bodies --- */

static double undeflected(double x, double y) {
    (void)x, (void)y;
    return 0;
}

/* T4: a ball of R turns a ray at h by 2 (I - I') to its axis, sin I = h/R = n sin I'. */
static double by_ball(double x, double y) {
    const double h = hypot(x, y), i = asin(h / 40e-3), o = asin(h / 40e-3 / 1.5);
    return h > 0 ? -tan(2 * (i - o)) * x / h : 0;
}

/* T2 for a ray that meets the first face head on: δ = asin(n sin A) - A, to the thick end. */
static double by_prism(double x, double y) {
    const double apex = 10 * M_PI / 180;
    (void)x, (void)y;
    return tan(asin(1.5 * sin(apex)) - apex);
}

/* -h/f of two equal faces R at the distance t: 1/f = (n - 1)(2/R - (n - 1) t/(n R²)). */
static double by_lens(double x, double y) {
    const double r = 0.310, t = 0.006;
    (void)y;
    return -x * 0.5 * (2 / r - 0.5 * t / (1.5 * r * r));
}

/* Of light that meets the faces nearly head on, (1 - 0.04)² goes through, and the radiance of each
 * path is that of the emitter: the index is 1 on both sides. */
#define THROUGH (0.96 * 0.96)

static void test_nothing(void **state) {
    (void)state;
    check("nothing", 0.02, "", "", undeflected, 0, 1);
}

/* A reference has the same directions. */
static void test_another_set_up(void **state) {
    (void)state;
    mcv_session *session = open_session(NULL);
    mcv_transport *matrix = transport_of(session, rig_of(0.02, "", "")),
                  *wider = transport_of(session, rig_of(0.021, "", ""));
    mcv_picture *picture = NULL;
    FAILS(MCV_BAD_INPUT, "is of another set-up",
          mcv_transport_deflection(matrix, wider, NULL, &picture, NULL, NULL, &error));
    mcv_transport_free(matrix);
    mcv_transport_free(wider);
    mcv_session_close(session);
}

static void test_ball(void **state) {
    (void)state;
    check("ball", 0.2, ", \"extensions\": {\"MCVISI_surfaces\": {\"surface\": 0}}",
          ", \"MCVISI_surfaces\": {\"surfaces\": [{\"type\": \"sphere\", \"radius\": \"40mm\","
          " \"material\": \"glass\"}]}",
          by_ball, 0, THROUGH);
}

static const char lens_node[] = ", \"extensions\": {\"MCVISI_surfaces\": {\"surface\": 0}}",
                  lens_surfaces[] =
                      ", \"MCVISI_surfaces\": {\"surfaces\": [{\"type\": \"lens\", \"surfaces\": ["
                      "{\"radius\": \"310mm\", \"semiDiameter\": \"14mm\", \"thickness\": \"6mm\","
                      " \"material\": \"glass\"}, {\"radius\": \"-310mm\", \"semiDiameter\": "
                      "\"14mm\"}]}]}";

/* Aberrations of third order are (h/R)² of the slope, 1.7e-4, times a number below 5. */
static void test_thin_lens(void **state) {
    (void)state;
    check("lens", 0.02, lens_node, lens_surfaces, by_lens, 1e-3, THROUGH);
}

/* The histograms of a lens by random points, and their stated errors. */
static mcv_picture *histogram_of(mcv_session *session, const char *options) {
    mcv_rig *rig = rig_of(0.02, lens_node, lens_surfaces);
    mcv_transport *transport = NULL;
    mcv_picture *picture = NULL, *histogram = NULL;
    WELL(mcv_session_transport(session, rig, options, NULL, NULL, &transport, NULL, &error));
    WELL(mcv_transport_deflection(transport, NULL, NULL, &picture, &histogram, NULL, &error));
    mcv_picture_free(picture);
    mcv_transport_free(transport);
    mcv_rig_free(rig);
    return histogram;
}

/*
 * Bins of a place are multinomial: each of n = 256 random rays falls into one of them, so that a
 * share has the variance p(1 - p)/n. Over the bins of a place these add up to (1 - Σp²)/n, which is
 * compared with the squares of differences of two seeds, and with the stated errors. A pixel sees
 * 500 µm/f = 1.6 mrad, 41 bins of 39 µrad: over 32 pixels some 1300 shares, whose squares add up
 * with a relative deviation of √(2/1300) = 0.04, and of √(2/3/1300) = 0.023 for errors from 4
 * replicates. Four and a half of these.
 */
static void test_bins_are_multinomial(void **state) {
    (void)state;
    enum { RAYS = 256, PLACES = COLUMNS * ROWS };
    mcv_session *session = open_session(NULL);
    mcv_picture *one =
                    histogram_of(session, "{\"spp\": 256, \"depth\": 3, \"sampler\": \"random\"}"),
                *other =
                    histogram_of(session, "{\"spp\": 256, \"depth\": 3, \"sampler\": \"random\","
                                          " \"seed\": 1}");
    const float *a = planes_of(one, 0), *b = planes_of(other, 0), *errors = planes_of(one, 1);
    double apart = 0, stated = 0, squares = 0;
    for (int i = 0; i < PLACES * DIRECTIONS; ++i) {
        apart += pow((double)a[i] - (double)b[i], 2) / 2;
        stated += pow((double)errors[i], 2);
        squares += (double)a[i] * (double)b[i]; /* independent: its mean is p² */
    }
    const double expected = (PLACES - squares) / RAYS;
    print_message("variances of bins: %.3f of the multinomial's, stated %.3f\n", apart / expected,
                  stated / expected);
    assert_float_equal(apart / expected, 1, 4.5 * 0.04);
    assert_float_equal(stated / expected, 1, 4.5 * 0.023);
    mcv_picture_free(one);
    mcv_picture_free(other);
    mcv_session_close(session);
}

/* A wedge: a face across the axis, behind it one that is tilted by 10° and thick at +x. */
static void write_wedge(const char *path) {
    static const uint16_t corners[] = {0, 1, 3, 0, 3, 2, 4, 7, 5, 4, 6, 7, 0, 5, 1, 0, 4, 5,
                                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    float points[8][3];
    for (int i = 0; i < 8; ++i) {
        points[i][0] = i & 1 ? 0.01f : -0.01f;
        points[i][1] = i & 2 ? 0.01f : -0.01f;
        points[i][2] = i & 4 ? -(float)(5e-3 + (double)points[i][0] * tan(10 * M_PI / 180)) : 0;
    }
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fwrite(points, sizeof points, 1, file);
    fwrite(corners, sizeof corners, 1, file);
    fclose(file);
}

#define WEDGE_NODE ", \"mesh\": 0"
#define WEDGE_MEMBERS \
    "}, \"buffers\": [{\"uri\": \"deflection.bin\", \"byteLength\": 168}], \"bufferViews\": [" \
    "{\"buffer\": 0, \"byteLength\": 96}, {\"buffer\": 0, \"byteOffset\": 96," \
    " \"byteLength\": 72}], \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126," \
    " \"count\": 8, \"type\": \"VEC3\", \"min\": [-0.01, -0.01, -0.0068]," \
    " \"max\": [0.01, 0.01, 0]}, {\"bufferView\": 1, \"componentType\": 5123, \"count\": 36," \
    " \"type\": \"SCALAR\"}], \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": " \
    "0}, \"indices\": 1, \"material\": 0}]}], \"extras\": {"

static void test_prism(void **state) {
    (void)state;
    write_wedge("deflection.bin");
    check("prism", 0.15, WEDGE_NODE, WEDGE_MEMBERS, by_prism, 0, THROUGH);
}

/* The camera turned by 90° about its axis sees +x below: what turned light to the right turns it
 * downwards, to larger rows. */
static void test_prism_turned(void **state) {
    (void)state;
    mcv_session *session = open_session(NULL);
    mcv_picture *picture = NULL;
    const double range = 0.15, expected = by_prism(0, 0);
    write_wedge("deflection.bin");
    mcv_rig *rig = rig_of(range, WEDGE_NODE, WEDGE_MEMBERS);
    WELL(mcv_rig_set(rig, "nodes/camera/rotation",
                     "[0, 0, 0.70710678118654752, 0.70710678118654752]", &error));
    mcv_transport *transport = transport_of(session, rig);
    WELL(mcv_transport_deflection(transport, NULL, NULL, &picture, NULL, NULL, &error));
    const float *x = planes_of(picture, 0), *y = x + COLUMNS * ROWS;
    for (int i = 0; i < COLUMNS * ROWS; ++i)
        if (!(fabs((double)x[i]) <= 1e-7 && fabs((double)y[i] - expected) <= range / DIRECTIONS))
            fail_msg("pixel %d: %g, %g, must be 0, %g", i, (double)x[i], (double)y[i], expected);
    mcv_picture_free(picture);
    mcv_transport_free(transport);
    mcv_session_close(session);
}

/* --- a light field camera before the report's lens with a dent --- */

enum { PLACES_X = 24, PLACES_Y = 16 };

static mcv_transport *report_of(mcv_session *session, const char *defect) {
    char path[512];
    mcv_rig *rig = NULL;
    mcv_transport *transport = NULL;
    snprintf(path, sizeof path, "%s/scenes/report-%s.glb", MCV_SOURCE_DIR, defect);
    WELL(mcv_rig_open(path, &rig, &error));
    WELL(mcv_session_transport(
        session, rig,
        "{\"spp\": 256, \"set\": [\"sensors/camera/regionOfInterest=[68,52,24,16]\","
        " \"sensors/camera/angularResolution=[63,1]\","
        " \"sensors/camera/pixelSize=[5.714285714e-7,36e-6]\"]}",
        NULL, NULL, &transport, NULL, &error));
    mcv_rig_free(rig);
    return transport;
}

/* The slope (n - 1) d x/s² exp(-r²/2s²) of light that leaves a dent, 0.6065 (n - 1) d/s at most;
 * its centre is 80, 60 in macro pixels of 180 µm. */
static double by_dent(int column, int row) {
    enum { PARTS = 8 };
    double sum = 0;
    for (int i = 0; i < PARTS * PARTS; ++i) {
        const double x = 180e-6 * (68 + column + (i % PARTS + 0.5) / PARTS - 80),
                     y = 180e-6 * (52 + row + (i / PARTS + 0.5) / PARTS - 60), s = 0.5e-3;
        sum += 0.5168 * 2.5e-6 * x / (s * s) * exp(-(x * x + y * y) / (2 * s * s));
    }
    return sum / (PARTS * PARTS);
}

/*
 * The factor on the closed form that fits best is 1. Its standard error is 0.006; five of these,
 * and 0.7 % as the dent lies 2 mm before the plane in focus at 300 mm.
 */
static void test_dent(void **state) {
    mcv_session *session = open_session(NULL);
    mcv_transport *clean = report_of(session, "clean"), *dent = report_of(session, "dent");
    mcv_picture *picture = NULL;
    double product = 0, square = 0, variance = 0, largest = 0;
    (void)state;
    WELL(mcv_transport_deflection(dent, clean, NULL, &picture, NULL, NULL, &error));
    const float *x = planes_of(picture, 0), *errors = planes_of(picture, 1);
    for (int i = 0; i < PLACES_X * PLACES_Y; ++i) {
        const double expected = by_dent(i % PLACES_X, i / PLACES_X);
        product += expected * (double)x[i];
        square += expected * expected;
        variance += pow(expected * (double)errors[i], 2);
        largest = fmax(largest, fabs((double)x[i]));
    }
    print_message("%.4f +- %.4f of the closed form, largest %.4g\n", product / square,
                  sqrt(variance) / square, largest);
    assert_true(sqrt(variance) / square < 0.01);
    if (!(fabs(product / square - 1) <= 5 * 0.006 + 0.007))
        fail_msg("%.4f of the closed form", product / square);
    mcv_picture_free(picture);
    FAILS(MCV_USAGE, "must end in .exr",
          mcv_transport_deflection(dent, clean, "{\"output\": \"a.png\"}", &picture, NULL, NULL,
                                   &error));
    mcv_transport_free(clean);
    mcv_transport_free(dent);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing),
        cmocka_unit_test(test_another_set_up),
        cmocka_unit_test(test_ball),
        cmocka_unit_test(test_thin_lens),
        cmocka_unit_test(test_prism),
        cmocka_unit_test(test_dent),
        cmocka_unit_test(test_bins_are_multinomial),
        cmocka_unit_test(test_prism_turned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
