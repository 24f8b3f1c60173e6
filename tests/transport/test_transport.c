/* SPDX-License-Identifier: Apache-2.0 */
/* Light transport matrices of scenes, by the public interface: closed forms, and images that are
 * relit against images that are rendered. */
#include "facing_rig.h"
#include "transport.h"

#include <math.h>
#include <unistd.h>

/* --- a telecentric projector that looks into a telecentric camera --- */

enum { COLUMNS = 12, ROWS = 10, ACROSS = 8, DOWN = 6 };

/* Where two intervals overlap. */
static double overlap(double a, double b, double c, double d) {
    return fmax(0, fmin(b, d) - fmax(a, c));
}

/*
 * The share of a camera's pixel that an element covers. The projector emits along -z, its columns
 * run along x, its rows along -y; the camera looks along +z, so that its columns run along -x.
 */
static double covered(int column, int row, int across, int down) {
    const double pitch = 0.5, width = 6.0 / ACROSS, height = 5.0 / DOWN;
    const double right = -(column - COLUMNS / 2.0) * pitch, top = -(row - ROWS / 2.0) * pitch;
    const double left = 0.3 - 3 + across * width, upper = -0.2 + 2.5 - down * height;
    return overlap(right - pitch, right, left, left + width) *
           overlap(top - pitch, top, upper - height, upper) / (pitch * pitch);
}

/*
 * T_ij over the value of a pixel that is lit whole is the share of pixel i that element j covers.
 * The N = 2^m = 4096 points of a replicate are a (0, m, 2)-net in base 2, of which a box at the
 * corner holds its share of the points but for (m + 3)/2 (Niederreiter, Random Number Generation
 * and Quasi-Monte Carlo Methods, SIAM 1992, 4.1). Any box is the difference of four such boxes.
 */
static void test_overlap_of_pixels(void **state) {
    const double most = 4 * (12 + 3) / 2.0 / 4096;
    double largest = 0, brightest = 0, wrong = 0;
    int partial = 0;
    (void)state;
    write_grey(ACROSS, DOWN);
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = open_text("transport-facing.gltf", facing_rig);
    mcv_transport *transport =
        transport_of(session, rig, "{\"spp\": 16384, \"output\": \"transport-facing.npz\"}");
    const mcv_matrix_entries e = entries_of(transport);
    assert_int_equal(e.element_count, ACROSS * DOWN);
    assert_int_equal(e.row_count, COLUMNS * ROWS);
    for (size_t row = 0; row < e.row_count; ++row) {
        double sum = 0;
        for (uint64_t i = e.row_begins[row]; i < e.row_begins[row + 1]; ++i) sum += e.values[i];
        brightest = fmax(brightest, sum);
    }
    for (int p = 0; p < COLUMNS * ROWS; ++p) {
        double found[ACROSS * DOWN] = {0};
        for (uint64_t i = e.row_begins[p]; i < e.row_begins[p + 1]; ++i)
            found[e.columns[i]] = e.values[i] / brightest;
        for (int j = 0; j < ACROSS * DOWN; ++j) {
            const double expected = covered(p % COLUMNS, p / COLUMNS, j % ACROSS, j / ACROSS);
            wrong = fmax(wrong, fabs(found[j] - expected));
            largest = fmax(largest, expected);
            partial += expected > 0 && expected < 1;
            if (!(fabs(found[j] - expected) <= most))
                fail_msg("pixel %d, element %d: %g, covered %g", p, j, found[j], expected);
        }
    }
    print_message("%d parts of pixels, at most %.2g wrong\n", partial, wrong);
    assert_true(largest > 0.9 && partial > 100);
    mcv_transport_free(transport);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* --- a scene's light by lamps and by a pattern --- */

/* The white image is the sum of the rows to the bit, thinned or not; a file gives the same image.
 */
static void check_white(mcv_session *session, const mcv_rig *rig) {
    mcv_transport *thin =
        transport_of(session, rig,
                     "{\"spp\": 16, \"keep\": 0.8, \"output\": \"transport-thin.npz\", \"white\": "
                     "\"transport-white.exr\"}");
    mcv_transport *whole = transport_of(session, rig, "{\"spp\": 16}"), *read = NULL;
    mcv_picture *white = NULL, *relit = NULL, *again = NULL;
    const mcv_matrix_entries e = entries_of(whole), t = entries_of(thin);
    WELL(mcv_picture_read("transport-white.exr", &white, &error));
    const float *planes = planes_of(white, 0);
    assert_true(t.entry_count < e.entry_count);
    for (size_t row = 0; row < e.row_count; ++row) {
        double sum = 0;
        for (uint64_t i = e.row_begins[row]; i < e.row_begins[row + 1]; ++i) sum += e.values[i];
        if (planes[row] != (float)sum)
            fail_msg("row %zu: sum %.9g, white %.9g", row, sum, (double)planes[row]);
    }
    WELL(mcv_transport_read("transport-thin.npz", &read, &error));
    WELL(mcv_transport_relight(thin, NULL, 0, NULL, &relit, NULL, &error));
    WELL(mcv_transport_relight(read, NULL, 0, NULL, &again, NULL, &error));
    assert_memory_equal(planes_of(relit, 0), planes_of(again, 0), e.row_count * sizeof(float));
    assert_memory_equal(planes_of(relit, 1), planes_of(again, 1), e.row_count * sizeof(float));
    mcv_picture_free(white);
    mcv_picture_free(relit);
    mcv_picture_free(again);
    mcv_transport_free(read);
    mcv_transport_free(whole);
    mcv_transport_free(thin);
}

/* Columns of 4 pixels are the sums of theirs. Sums in units of the matrix are exact, but for the
 * rounding of each entry to one. */
static void check_bins(mcv_session *session, const mcv_rig *rig) {
    enum { BIN = 4 };
    mcv_transport *whole = transport_of(session, rig, "{\"spp\": 16}"),
                  *binned = transport_of(session, rig, "{\"spp\": 16, \"bin\": 4}");
    const mcv_matrix_entries e = entries_of(whole), b = entries_of(binned);
    assert_int_equal(b.element_count, e.element_count / BIN);
    for (size_t row = 0; row < e.row_count; ++row) {
        double sums[64] = {0}, all = 0;
        for (uint64_t i = e.row_begins[row]; i < e.row_begins[row + 1]; ++i) {
            sums[e.columns[i] / BIN] += e.values[i];
            all += e.values[i];
        }
        for (uint64_t i = b.row_begins[row]; i < b.row_begins[row + 1]; ++i) {
            if (!(fabs(sums[b.columns[i]] - b.values[i]) <= 0x1p-48 * all))
                fail_msg("row %zu, column %u: %.17g, its pixels %.17g", row, b.columns[i],
                         b.values[i], sums[b.columns[i]]);
            sums[b.columns[i]] = 0;
        }
        for (size_t i = 0; i < 64; ++i) assert_true(sums[i] == 0);
    }
    mcv_transport_free(whole);
    mcv_transport_free(binned);
}

/* The scene's own pattern gives the image that a render with another seed gives. */
static void check_relit(mcv_session *session, const mcv_rig *rig) {
    mcv_transport *transport =
        transport_of(session, rig, "{\"spp\": 64, \"replicates\": 16, \"seed\": 1}");
    mcv_picture *relit = NULL, *rendered = NULL;
    bool different = true;
    char *report = NULL;
    WELL(mcv_transport_relight(transport, NULL, 0, NULL, &relit, NULL, &error));
    WELL(mcv_session_render(session, rig, "{\"spp\": 64, \"replicates\": 16, \"seed\": 2}", NULL,
                            NULL, &rendered, NULL, &error));
    WELL(mcv_picture_compare(relit, rendered, NULL, &different, NULL, &report, &error));
    if (different) fail_msg("relit and rendered differ: %s", report);
    mcv_text_free(report);
    mcv_picture_free(relit);
    mcv_picture_free(rendered);
    mcv_transport_free(transport);
}

/* A sequence shows what scenes show: its first image is that of the scene's pattern, to the bit,
 * and a code's image and its inverse, B = 6 images later, add up to white but for their rounding.
 */
static void check_sequence(mcv_session *session, const mcv_rig *rig) {
    enum { BITS = 6 };
    const char options[] = "{\"sequence\": \"{\\\"type\\\": \\\"grayCode\\\"}\", "
                           "\"output\": \"sequence.exr\"}";
    mcv_transport *transport = transport_of(session, rig, "{\"spp\": 16}");
    mcv_picture *pictures[2 * BITS], *relit = NULL, *read = NULL;
    const mcv_matrix_entries e = entries_of(transport);
    size_t count = 0;
    WELL(mcv_transport_sequence(transport, options, NULL, 0, &count, NULL, &error));
    assert_int_equal(count, 2 * BITS);
    FAILS(MCV_USAGE, "there is room for 11",
          mcv_transport_sequence(transport, options, pictures, 11, &count, NULL, &error));
    WELL(mcv_transport_sequence(transport, options, pictures, count, &count, NULL, &error));
    WELL(mcv_transport_relight(transport, NULL, 0, NULL, &relit, NULL, &error));
    assert_memory_equal(planes_of(relit, 0), planes_of(pictures[0], 0),
                        e.row_count * sizeof(float));
    for (size_t row = 0; row < e.row_count; ++row)
        for (int k = 0; k < BITS; ++k) {
            double white = 0;
            for (uint64_t i = e.row_begins[row]; i < e.row_begins[row + 1]; ++i)
                white += e.values[i];
            assert_true(fabs((double)planes_of(pictures[k], 0)[row] +
                             (double)planes_of(pictures[BITS + k], 0)[row] - white) <=
                        0x1p-23 * white);
        }
    WELL(mcv_picture_read("sequence-11.exr", &read, &error));
    assert_memory_equal(planes_of(read, 0), planes_of(pictures[11], 0),
                        e.row_count * sizeof(float));
    for (size_t i = 0; i < count; ++i) mcv_picture_free(pictures[i]);
    mcv_picture_free(relit);
    mcv_picture_free(read);
    mcv_transport_free(transport);
}

static void refuse_sequences(const mcv_transport *transport) {
    static const char *const wrong[][2] = {
        {"{\"sequence\": \"{\"}", "must be a pattern as in scenes"},
        {"{\"sequence\": \"{\\\"type\\\": \\\"phaseShift\\\"}\"}", "is missing"},
        {"{\"sequence\": \"lamp={}\"}", "the matrix has pixels of \"projector\""},
        {"{\"sequence\": \"{\\\"type\\\": \\\"grayCode\\\", \\\"resolution\\\": [8, 8]}\"}",
         "resolution is 8 x 8"},
        {"{\"sequence\": \"{\\\"type\\\": \\\"grayCode\\\", \\\"orientation\\\": "
         "\\\"horizontal\\\"}\"}",
         "one pixel across the stripes"},
        {"{}", "must be a pattern"},
    };
    size_t count;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i)
        FAILS(MCV_USAGE, wrong[i][1],
              mcv_transport_sequence(transport, wrong[i][0], NULL, 0, &count, NULL, &error));
}

/* A camera in the dark: the matrix would have no column. */
static void refuse_dark(mcv_session *session) {
    mcv_transport *transport = NULL;
    mcv_rig *rig = open_text(
        "transport-dark.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"extensionsUsed\":[\"MCVISI_sensors\"],\"extensions\":{\"MCVISI_sensors\":{\"sensors\":"
        "[{\"name\":\"cam\",\"type\":\"telecentric\",\"magnification\":1,\"workingDistance\":0.1,"
        "\"fNumber\":8,\"resolution\":[8,8],\"pixelSize\":5e-5}]}},\"nodes\":[{\"name\":\"cam\","
        "\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}}]}");
    FAILS(MCV_BAD_INPUT, "transport-dark.gltf: the scene has no emitter",
          mcv_session_transport(session, rig, "{\"output\": \"dark.npz\"}", NULL, NULL, &transport,
                                NULL, &error));
    assert_null(transport);
    assert_true(access("dark.npz", F_OK) != 0);
    mcv_rig_free(rig);
}

static void refuse(mcv_session *session, const mcv_rig *rig) {
    mcv_transport *transport = NULL;
    mcv_picture *picture = NULL;
    const float pattern[] = {1, 2};
    FAILS(MCV_USAGE, "must end in .npz or .mtx",
          mcv_session_transport(session, rig, "{\"output\": \"a.exr\"}", NULL, NULL, &transport,
                                NULL, &error));
    FAILS(MCV_USAGE, "the reference renderer records no elements",
          mcv_session_transport(session, rig, "{\"device\": \"reference\"}", NULL, NULL, &transport,
                                NULL, &error));
    FAILS(MCV_BAD_INPUT, "absent.npz", mcv_transport_read("absent.npz", &transport, &error));
    transport = transport_of(session, rig, "{\"spp\": 4}");
    FAILS(MCV_USAGE, "a pattern of 2 values: must be 64",
          mcv_transport_relight(transport, pattern, 2, NULL, &picture, NULL, &error));
    FAILS(MCV_USAGE, "the matrix has pixels of \"projector\"",
          mcv_transport_relight(transport, NULL, 0, "{\"pattern\": [\"lamp=a.exr\"]}", &picture,
                                NULL, &error));
    FAILS(MCV_BAD_INPUT, "has 90 x 60 pixels, the image of emitter \"projector\" 64 x 1",
          mcv_transport_relight(transport, NULL, 0, "{\"pattern\": [\"transport-white.exr\"]}",
                                &picture, NULL, &error));
    FAILS(MCV_USAGE, "brightness of emitters alone",
          mcv_transport_relight(transport, NULL, 0, "{\"set\": [\"sensors/camera/fNumber=4\"]}",
                                &picture, NULL, &error));
    FAILS(MCV_USAGE, "the matrix has the emitters \"projector\"",
          mcv_transport_relight(transport, NULL, 0, "{\"set\": [\"emitters/sun/radiance=4\"]}",
                                &picture, NULL, &error));
    FAILS(MCV_USAGE, "give --region and --background",
          mcv_transport_relight(transport, NULL, 0, "{\"fit\": \"contrast\"}", &picture, NULL,
                                &error));
    refuse_sequences(transport);
    FAILS(MCV_BAD_INPUT, "is of another set-up: its image has 12 x 10 pixels",
          mcv_transport_inverse(
              transport, "{\"good_image\": \"good.exr\", \"defect\": \"transport-facing.npz\"}",
              &picture, NULL, &error));
    assert_true(access("good.exr", F_OK) != 0);
    mcv_transport_free(transport);
}

static void test_pattern_of_a_scene(void **state) {
    mcv_rig *rig = NULL;
    mcv_session *session = open_session(NULL);
    (void)state;
    WELL(mcv_rig_open(MCV_SOURCE_DIR "/scenes/gray-code.gltf", &rig, &error));
    check_white(session, rig);
    check_bins(session, rig);
    check_relit(session, rig);
    check_sequence(session, rig);
    refuse(session, rig);
    refuse_dark(session);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_overlap_of_pixels),
        cmocka_unit_test(test_pattern_of_a_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
