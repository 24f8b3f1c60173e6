/* SPDX-License-Identifier: Apache-2.0 */
/* The flying spot scanner: its beams in both renderers, knife edges and lenses in pictures, the
 * light field of detectors in a Fourier plane, and bad input. */
/* ctest: label truth */
#include "scene_builder.h"
#include "truths.h"

#include "program.h"

#include "io/exr.h"
#include "mcvisi/elements.h"
#include "reference/sensor_ray.h"
#include "scene/sensors.h"

#include <math.h>

/* Beams of M² 4, a waist of 100 µm 0.1 m before the node, 0.25 mm apart; detectors of 9 x 9
 * directions behind the part. */
static const char scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"extensions\":{\"MCVISI_sensors\":{\"sensors\":[{\"name\":\"scanner\",\"type\":"
    "\"flyingSpotScanner\",\"wavelength\":\"660nm\",\"M2\":4,\"beamDiameter\":\"200um\","
    "\"widthMeasure\":\"1/e2\",\"workingDistance\":\"100mm\",\"resolution\":[24,4],"
    "\"pixelSize\":\"0.25mm\"}]},"
    "\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"detectors\",\"type\":\"lightField\",\"image\":"
    "\"white\",\"size\":\"60mm\",\"spatialResolution\":1,\"angularResolution\":9,"
    "\"angularRange\":%s,\"radiance\":1}]},\"MCVISI_surfaces\":{\"surfaces\":[%s]}},"
    "\"images\":[{\"name\":\"white\",\"uri\":\"data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAkAAAAJCAAAAADF+lnMAAAAEUlEQVR4nGP8zwAFTAzUZQEAXCsBEYHdpNQAAAAASUVORK"
    "5CYII=\"}],\"materials\":[{\"name\":\"black\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
    "\"absorber\"}}},{\"name\":\"glass\",\"extensions\":{\"MCVISI_materials\":{\"type\":"
    "\"dielectric\",\"ior\":1.5}}}],"
    "\"nodes\":[{\"name\":\"scanner\",\"translation\":[0,0,0.1],\"extensions\":"
    "{\"MCVISI_sensors\":{\"sensor\":0}}},{\"name\":\"detectors\",\"translation\":[0,0,-0.05],"
    "\"rotation\":[0,1,0,0],\"extensions\":{\"MCVISI_emitters\":{\"emitter\":0}}},"
    "{\"name\":\"part\",\"translation\":[%s],\"extensions\":{\"MCVISI_surfaces\":{\"surface\":0}}}]"
    "}";

static void write_scene(const char *path, const char *range, const char *part, const char *at) {
    char text[8192];
    snprintf(text, sizeof text, scene, range, part, at);
    write_file(path, text);
}

static double radius(double w0, double m2, double from_waist) {
    return hypot(w0, m2 * 660e-9 / (M_PI * w0) * from_waist);
}

/* --- rays --- */

enum { RAYS = 1 << 16 };

static mcv_sensor scanner(void) {
    mcv_sensor s = {.type = MCV_SENSOR_FLYING_SPOT, .to_world = mcv_transform_identity()};
    mcv_flying_spot_params *p = &s.as.flying_spot;
    mcv_params_set_defaults(mcv_sensor_table(s.type), &s.as);
    p->wavelength = 660e-9;
    p->M2[0] = 5, p->M2[1] = 2;
    p->beamDiameter[0] = 4e-4, p->beamDiameter[1] = 3e-4;
    p->widthMeasure = 1;
    p->workingDistance = 0.2;
    p->resolution[0] = 8, p->resolution[1] = 6;
    p->pixelSize[0] = 1e-3, p->pixelSize[1] = 2e-3;
    return s;
}

/* A ray of the pixel (5, 1): of the device's function, or of the reference. */
static void shoot(const mcv_sensor *s, bool reference, const double xi[4], double at[3],
                  double to[3]) {
    if (reference) {
        const ref_sensor_ray ray = ref_sensor_ray_sample(s, 5, 1, xi[0], xi[1], xi[2], xi[3]);
        const double origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z},
                     direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        memcpy(at, origin, sizeof origin);
        for (int k = 0; k < 3; ++k) to[k] = direction[k] / -direction[2];
        return;
    }
    mcv_flying_spot device;
    mcv_flying_spot_prepare(&s->as.flying_spot, &device);
    const mcv_film_sample film = {5, 1, (float)xi[0], (float)xi[1]};
    const mcv_sensor_ray ray = mcv_flying_spot_sample(&device, film, (float)xi[2], (float)xi[3]);
    const float origin[3] = {ray.origin.x, ray.origin.y, -ray.origin.z},
                direction[3] = {ray.direction.x, ray.direction.y, -ray.direction.z};
    for (int k = 0; k < 3; ++k) at[k] = (double)origin[k], to[k] = (double)direction[k];
}

/*
 * At four distances the rays of a pixel have the mean of its axis, (5.5 - 4) · 1 mm and (3 - 1.5) ·
 * 2 mm, and the width of the beam. N numbers know a mean to 1/√N = 0.4 % of a deviation, of which
 * 4.5 are 1.8 %, and a deviation to 0.28 %, of which 4.5 are 1.25 %.
 */
static void test_beams(void **state) {
    (void)state;
    const mcv_sensor s = scanner();
    const double waists[2] = {2e-4, 1.5e-4}, m2[2] = {5, 2}, axis[2] = {1.5e-3, 3e-3},
                 distances[] = {0, 0.2, 0.35, 1};
    for (int reference = 0; reference < 2; ++reference)
        for (size_t d = 0; d < 4; ++d) {
            double sums[2] = {0, 0}, squares[2] = {0, 0};
            ref_random random = ref_random_begin(1, 2, 3, d);
            for (int i = 0; i < RAYS; ++i) {
                double xi[4], at[3], to[3];
                for (int k = 0; k < 4; ++k)
                    xi[k] = (double)(ref_random_bits(&random) >> 40) * 0x1p-24;
                shoot(&s, reference, xi, at, to);
                for (int k = 0; k < 2; ++k) {
                    const double off = at[k] + distances[d] * to[k] - axis[k];
                    sums[k] += off / RAYS;
                    squares[k] += off * off / RAYS;
                }
            }
            for (int k = 0; k < 2; ++k) {
                const double w = radius(waists[k], m2[k], distances[d] - 0.2),
                             seen = 2 * sqrt(squares[k]);
                note_truth("T27 flying spot: radius at four distances",
                           reference ? "reference" : "device", fabs(seen / w - 1), 0.0125);
                if (!(fabs(seen / w - 1) <= 0.0125) || !(fabs(sums[k]) <= 0.018 * w / 2))
                    fail_msg("%s, %g m, axis %d: radius %g m, expected %g; %g m off",
                             reference ? "reference" : "device", distances[d], k, seen, w, sums[k]);
            }
        }
}

/* --- pictures --- */

/* A row of a part of a picture. */
static void read_row(const char *path, uint32_t part, uint32_t row, double values[24]) {
    mcv_exr exr;
    if (mcv_exr_read(path, &exr, &builder_error) != MCV_OK) fail_msg("%s", builder_error.text);
    const mcv_image *image = &exr.parts[part].image;
    assert_true(part < exr.part_count && image->width == 24 && row < image->height);
    for (uint32_t i = 0; i < 24; ++i) values[i] = (double)image->pixels[row * 24 + i];
    mcv_exr_free(&exr);
}

/*
 * A knife edge at x = 0.1 mm, 0.2 m behind the scanner and so 0.1 m behind the waist: what passes
 * is ½ erfc(√2 (0.1 mm - x)/w). Means of 4096 rays know shares to 0.008, of which 4.5 are 0.035;
 * the device's samples are stratified, which is better.
 */
static void test_knife_edge(void **state) {
    (void)state;
    static const char *const devices[] = {"", "--device reference"};
    write_scene("edge.gltf", "0.15",
                "{\"name\":\"part\",\"type\":\"box\",\"width\":\"40mm\",\"height\":\"40mm\","
                "\"depth\":\"1mm\",\"material\":\"black\"}",
                "-0.0199,0,-0.0005");
    for (int reference = 0; reference < 2; ++reference) {
        char line[128];
        double seen[24];
        snprintf(line, sizeof line,
                 "render edge.gltf --spp 1024 %s --set nodes/scanner/shiftZ=100mm -o edge.exr",
                 devices[reference]);
        program_well(line);
        read_row("edge.exr", 0, 1, seen);
        for (int i = 0; i < 24; ++i) {
            const double x = (i - 11.5) * 0.25e-3, w = radius(1e-4, 4, 0.1),
                         share = 0.5 * erfc(M_SQRT2 * (1e-4 - x) / w);
            note_truth("T27 flying spot: share that passes a knife edge",
                       reference ? "reference" : "device", fabs(seen[i] - share), 0.035);
            if (!(fabs(seen[i] - share) <= 0.035))
                fail_msg("%s: %g passes at %g m, expected %g", reference ? "reference" : "device",
                         seen[i], x, share);
        }
    }
}

/*
 * Each position has the histogram of the directions that its light takes to the detectors. A ball
 * of glass of 40 mm has f = n R/(2 (n - 1)) = 30 mm and turns light at the height h by -h/f:
 * heights up to 1 mm have 0.033, that is three bins of 0.05 · 2/9 = 0.011 each. The divergence of
 * 8.4 mrad and the width of 0.1 mm spread the slopes by 4.5e-3, 0.41 bins. So the mean of the bins
 * errs by exp(-2π² 0.41²)/π of a bin, 1.3e-4, and that of 4096 rays by 4.5 times 8e-5. Aberrations
 * of the ball are (h/R)², 0.3 % of 0.029. All of it is 6e-4. What passes a ball is (1 - 0.04)².
 */
static void test_fourier_plane(void **state) {
    (void)state;
    double slope[24], passed[24];
    write_scene("ball.gltf", "0.05",
                "{\"name\":\"part\",\"type\":\"sphere\",\"radius\":\"20mm\",\"material\":"
                "\"glass\"}",
                "0,0,0");
    program_well("deflection ball.gltf --spp 1024 -o ball.exr --histogram light.exr");
    read_row("ball.exr", 0, 1, slope);
    read_row("ball.exr", 4, 1, passed);
    for (int i = 8; i < 16; ++i) {
        const double h = (i - 11.5) * 0.25e-3, expected = -h / 30e-3;
        note_truth("flying spot: a ball's deflection [slope]", "device", fabs(slope[i] - expected),
                   7e-4);
        if (!(fabs(slope[i] - expected) <= 7e-4))
            fail_msg("at %g m the slope is %g, expected %g", h, slope[i], expected);
        if (!(fabs(passed[i] - 0.96 * 0.96) <= 0.02)) fail_msg("%g passes at %g m", passed[i], h);
    }
    /* It is a light field image: the Earth Mover's gradient of a lens is even. */
    json_t *told = program_json("lightfield emd-gradient light.exr --json -o gradient.exr");
    assert_true(number_at(told, "mean") > 0);
    json_decref(told);
}

/* The index of a catalogue's glass is that of the d line, unless the scene says the beam's. */
static void test_wavelength_of_glass(void **state) {
    (void)state;
    static const char warning[] =
        "the beam has 660 nm, but material \"glass\" has the index at 587.6 nm";
    static const char *const sets[] = {"", "--set spectrum/wavelengths=0.66um"};
    for (int own = 0; own < 2; ++own) {
        char line[128];
        snprintf(line, sizeof line, "check ball.gltf --set materials/glass/glass=F2 %s", sets[own]);
        program_well(line);
        if ((strstr(said, warning) == NULL) != own) fail_msg("with \"%s\": %s", sets[own], said);
    }
    program_well("check ball.gltf");
    if (strstr(said, "the beam has")) fail_msg("a fixed index: %s", said);
}

static void test_bad_input(void **state) {
    (void)state;
    static const struct {
        const char *set, *says;
    } cases[] = {
        {"widthMeasure=none", "\"1/e2\" or \"FWHM\""},
        {"M2=0.5", "must lie from 1"},
        {"binning=2", "must be 1: the beam stands at each position by itself"},
        {"beamDiameter=0.2um", "make it wider"},
        {"radiometry=irradiance", "radiometry"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char line[128];
        snprintf(line, sizeof line, "check edge.gltf --set sensors/scanner/%s", cases[i].set);
        program_fails(line, 3, cases[i].says);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_beams),         cmocka_unit_test(test_knife_edge),
        cmocka_unit_test(test_fourier_plane), cmocka_unit_test(test_wavelength_of_glass),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
