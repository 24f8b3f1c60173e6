/* SPDX-License-Identifier: Apache-2.0 */
/* relativeIllumination of a telecentric camera: before an even sky each pixel has the table's share
 * of what an ideal lens gives it, and what is refused. */
#include "program.h"

#include "io/exr.h"

#include <math.h>

#define SCENE(more) \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}]," \
    "\"extensionsUsed\":[\"MCVISI_sensors\",\"MCVISI_emitters\"],\"extensions\":{" \
    "\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"cam\",\"type\":\"telecentric\"," \
    "\"magnification\":0.2,\"workingDistance\":0.1,\"fNumber\":8,\"resolution\":[16,12]," \
    "\"pixelSize\":1e-4" more "}]},\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"sky\"," \
    "\"type\":\"environment\",\"radiance\":2}]}},\"nodes\":[{\"name\":\"camera\"," \
    "\"extensions\":{\"MCVISI_sensors\":{\"sensor\":0}}},{\"name\":\"sky\",\"extensions\":{" \
    "\"MCVISI_emitters\":{\"emitter\":0}}}]}"
#define IRRADIANCE ",\"radiometry\":\"irradiance\""
#define TABLE ",\"relativeIllumination\":[[0,1],[\"0.5mm\",0.9],[1e-3,0.6]]"
#define RENDER "--spp 64 --replicates 1 --seed 5 "

static double table_at(double r) {
    return r < 0.5e-3 ? 1 - 0.1 * r / 0.5e-3 : 0.9 - 0.3 * (r - 0.5e-3) / 0.5e-3;
}

/* The mean over a pixel. */
static double share_of(uint32_t column, uint32_t row) {
    enum { FINE = 32 };
    double sum = 0;
    for (int j = 0; j < FINE; ++j)
        for (int i = 0; i < FINE; ++i)
            sum +=
                table_at(1e-4 * hypot(column + (i + 0.5) / FINE - 8, row + (j + 0.5) / FINE - 6));
    return sum / FINE / FINE;
}

/* Both renders have the same samples. The table falls by at most 0.06 over a pixel, of 64 samples:
 * five times 0.06/√12/√64, and float's rounding. */
static void must_fall(const char *with, const char *without) {
    mcv_exr a = {0}, b = {0};
    mcv_error error = {""};
    double worst = 0;
    if (mcv_exr_read(with, &a, &error) != MCV_OK || mcv_exr_read(without, &b, &error) != MCV_OK) {
        fail_msg("%s", error.text);
        return; /* for the analyzer: fail_msg does not come back */
    }
    const mcv_image *falls = &a.parts[0].image, *even = &b.parts[0].image;
    for (uint32_t i = 0; i < 16 * 12; ++i) {
        const double share = (double)falls->pixels[i] / (double)even->pixels[i],
                     off = share - share_of(i % 16, i / 16);
        worst = fmax(worst, fabs(off));
        if (!(fabs(off) < 5 * 0.06 / sqrt(12 * 64)))
            fail_msg("pixel %u, %u has %.4f of the light, must have %.4f", i % 16, i / 16, share,
                     share_of(i % 16, i / 16));
    }
    print_message("  %s: at most %.2g off\n", with, worst);
    mcv_exr_free(&a);
    mcv_exr_free(&b);
}

static void test_the_table_is_the_fall_off(void **state) {
    (void)state;
    write_file("even.gltf", SCENE(IRRADIANCE));
    write_file("falls.gltf", SCENE(IRRADIANCE TABLE));
    program_well("render even.gltf " RENDER "-o even.exr");
    program_well("render falls.gltf " RENDER "-o falls.exr");
    must_fall("falls.exr", "even.exr");
    program_well("render even.gltf --device reference " RENDER "-o even-r.exr");
    program_well("render falls.gltf --device reference " RENDER "-o falls-r.exr");
    must_fall("falls-r.exr", "even-r.exr");
    /* The same with a lens that distorts too little to see. */
    program_well("render even.gltf --set sensors/cam/k1=1e-9 " RENDER "-o even-k.exr");
    program_well("render falls.gltf --set sensors/cam/k1=1e-9 " RENDER "-o falls-k.exr");
    must_fall("falls-k.exr", "even-k.exr");
}

static void test_check_shows_the_table(void **state) {
    (void)state;
    write_file("falls.gltf", SCENE(IRRADIANCE TABLE));
    program_well("check falls.gltf");
    if (!strstr(said, "3 pairs, 1 on the axis to 0.6 at 0.001 m")) fail_msg("%s", said);
}

static void must_refuse(const char *scene, const char *why) {
    write_file("bad.gltf", scene);
    program_fails("check bad.gltf", 3, why);
}

static void test_bad_input(void **state) {
    (void)state;
#define BAD(table) SCENE(IRRADIANCE ",\"relativeIllumination\":" table)
    must_refuse(SCENE(TABLE), "radiometry");
    must_refuse(BAD("0.5"), "2 to 16 pairs");
    must_refuse(BAD("[[0,1]]"), "2 to 16 pairs");
    must_refuse(BAD("[[0,1],[1e-3]]"), "must be a pair");
    must_refuse(BAD("[[0.1,1],[1,1]]"), "on the axis");
    must_refuse(BAD("[[0,1],[0.5e-3,1],[0.5e-3,1]]"), "that of the pair before");
    must_refuse(BAD("[[0,1],[2e-3,0]]"), "above 0");
    must_refuse(BAD("[[0,1],[\"2kg\",1]]"), "2kg");
    must_refuse(BAD("[[0,1],[0.9e-3,0.5]]"), "film's corner is 0.001 m away");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_the_table_is_the_fall_off),
                                       cmocka_unit_test(test_check_shows_the_table),
                                       cmocka_unit_test(test_bad_input)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
