/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* The Earth Mover's Distance against POT, a library of others, where `./run deps peers` has put it.
 */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "analysis/emd.h"

enum { SIDE = 9, BINS = SIDE * SIDE, PAIRS = 10000 };

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"

static double histograms[PAIRS][2][BINS];

/* Dense, sparse and tied ones; never empty. */
static void fill_histograms(void) {
    uint64_t state = 20;
    for (size_t i = 0; i < (size_t)PAIRS * 2 * BINS; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const double u = (double)(state >> 32) * 0x1p-32;
        const size_t pair = i / ((size_t)2 * BINS);
        (&histograms[0][0][0])[i] = i % BINS == 40  ? 1
                                    : pair % 3 == 0 ? u
                                    : pair % 3 == 1 ? fmax(0, 10 * u - 8)
                                                    : floor(4 * u);
    }
}

static void expect_near(int pair, const char *form, double ours, double theirs) {
    if (!(fabs(ours - theirs) <= 1e-9 * fabs(theirs)))
        fail_msg("pair %d, %s: %.17g by ours, %.17g by POT, %.3g relative", pair, form, ours,
                 theirs, ours / theirs - 1);
}

static void test_against_pot(void **state) {
    (void)state;
    static const char path[] = "test_emd_peer.bin";
    if (access(PYTHON, X_OK) != 0 || system(PYTHON " -c 'import ot' 2>/dev/null") != 0) {
        puts("POT is not there: `./run deps peers` installs it");
        skip();
    }
    fill_histograms();
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(histograms, sizeof histograms, 1, file), 1);
    assert_int_equal(fclose(file), 0);
    FILE *peer =
        popen(PYTHON " " MCV_SOURCE_DIR "/tests/peers/emd_peer.py test_emd_peer.bin 9 9", "r");
    assert_non_null(peer);
    mcv_emd *emd;
    mcv_error error = {""};
    assert_int_equal(mcv_emd_new(&emd, SIDE, SIDE, &error), MCV_OK);
    for (int i = 0; i < PAIRS; ++i) {
        double theirs[2];
        if (fread(theirs, sizeof theirs, 1, peer) != 1)
            fail_msg("POT gave no distance of pair %d", i);
        expect_near(
            i, "normalized",
            mcv_emd_distance(emd, histograms[i][0], histograms[i][1], MCV_EMD_NORMALIZED, NULL),
            theirs[0]);
        expect_near(i, "mass",
                    mcv_emd_distance(emd, histograms[i][0], histograms[i][1], MCV_EMD_MASS, NULL),
                    theirs[1]);
    }
    mcv_emd_free(emd);
    assert_int_equal(pclose(peer), 0);
    unlink(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_pot)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
