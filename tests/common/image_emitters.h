/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of emitters that project an image share. */
#ifndef MCVISI_TESTS_IMAGE_EMITTERS_H
#define MCVISI_TESTS_IMAGE_EMITTERS_H

#include "estimates.h"
#include "scene_files.h"

#include "io/exr.h"
#include "io/png.h"
#include "reference/reference.h"
#include "render/render.h"

/* An image without any symmetry: red grows with the column, green with the row, blue marks the
 * upper left pixel. */
static inline void value_of(uint32_t width, uint32_t height, uint32_t column, uint32_t row,
                            uint8_t rgb[3]) {
    rgb[0] = (uint8_t)(20 + 230 * column / width);
    rgb[1] = (uint8_t)(20 + 230 * row / height);
    rgb[2] = column + row == 0 ? 255 : 128;
}

static inline double linear(uint8_t value) {
    const double v = value / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* Writes that image as NAME beside the scenes. */
static inline void write_png(const char *name, uint32_t width, uint32_t height) {
    char *path = text_of("%s/tests/%s", MCV_BINARY_DIR, name);
    mcv_image image;
    BUILD(mcv_image_new(&image, width, height, 3, &builder_error));
    for (uint32_t row = 0; row < height; ++row) {
        for (uint32_t column = 0; column < width; ++column) {
            uint8_t rgb[3];
            value_of(width, height, column, row, rgb);
            for (int k = 0; k < 3; ++k)
                image.pixels[((uint32_t)k * height + row) * width + column] = rgb[k];
        }
    }
    BUILD(mcv_png_write_values(path, &image, 8, &builder_error));
    mcv_image_free(&image);
    free(path);
}

/*
 * An emitter that shines along -z of a rig, and a sensor `distance` away that faces it: its right
 * is the emitter's left. `rig` is the rig node's place and rotation.
 */
static inline char *rig_text(const char *rig, const char *emitter, const char *sensor,
                             double distance, const char *png) {
    return text_of("{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                   "\"nodes\":[{%s\"children\":[1,2]},{\"name\":\"emitter\",\"extensions\":{"
                   "\"MCVISI_emitters\":{\"emitter\":0}}},"
                   "{\"rotation\":[0,1,0,0],\"translation\":[0,0,%.17g],\"extensions\":{\"MCVISI_"
                   "sensors\":{\"sensor\":0}}}],"
                   "\"images\":[{\"name\":\"picture\",\"uri\":\"%s\"}],"
                   "\"extensions\":{\"MCVISI_emitters\":{\"emitters\":[{\"name\":\"e\",%s}]},"
                   "\"MCVISI_sensors\":{\"sensors\":[{%s}]}}}",
                   rig, -distance, png, emitter, sensor);
}

/* A sensor where its picture is of no account. */
#define ONE_PIXEL "\"type\":\"pinhole\",\"imageDistance\":1,\"resolution\":[1,1],\"pixelSize\":1e-6"

/* Rigs that need every axis to be right. The rotation has length 1 up to rounding: 0.2² + 0.4² +
 * 0.4² + 0.8² = 1. */
static const char *const rigs[] = {
    "", "\"rotation\":[0.2,0.4,-0.4,0.8],\"translation\":[0.3,-0.2,0.7],"};

static inline mcv_film render_by(bool reference, const mcv_scene *scene, uint32_t sensor,
                                 uint64_t samples, uint32_t seed) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats = {0};
    mcv_film film = {0};
    options.replicates = REPLICATES;
    options.last = samples;
    options.seed = seed;
    BUILD((reference ? mcv_reference_render : render_again)(scene, sensor, &options, &film, &stats,
                                                            &builder_error));
    return film;
}

/* Emitters that must be refused, each in a rig with this image. */
typedef struct bad_emitter {
    const char *emitter, *says;
} bad_emitter;

static inline void refuse_emitters(const bad_emitter *cases, size_t count, const char *png) {
    for (size_t i = 0; i < count; ++i) {
        char *text = rig_text("", cases[i].emitter, ONE_PIXEL, 0.1, png);
        must_refuse("image_emitters_bad.gltf", text, cases[i].says);
        free(text);
    }
}

/* Images of this size that are not there, empty, or hold what is no number, for an emitter that is
 * whole but for its `image`. */
static inline void refuse_images(const char *emitter, uint32_t width, uint32_t height) {
    char *by_index = text_of("%s\"image\":0", emitter),
         *by_uri = text_of("%s\"image\":{\"uri\":\"bad_image.exr\"}", emitter);
    const char *path = MCV_BINARY_DIR "/tests/bad_image.exr";
    remove(path);
    refuse_emitters(&(bad_emitter){by_index, "images/0/uri: "}, 1, "no.png");
    refuse_emitters(&(bad_emitter){by_uri, "emitters/e/image: \"bad_image.exr\" "}, 1, "no.png");
    free(write_bytes("bad_image.png", "", 0));
    refuse_emitters(&(bad_emitter){by_index, "images/0: is neither a PNG nor a JPEG"}, 1,
                    "bad_image.png");
    mcv_image image;
    BUILD(mcv_image_new(&image, width, height, 1, &builder_error));
    image.pixels[width + 1] = NAN;
    const mcv_exr_part part = {.name = "part", .image = image};
    BUILD(mcv_exr_write(path, &part, 1, NULL, 0, &builder_error));
    write_png("bad_image.png", width, height); /* the file's own image, which nothing uses */
    refuse_emitters(
        &(bad_emitter){by_uri,
                       "emitters/e/image: \"bad_image.exr\" has the value nan in column 1, row 1"},
        1, "bad_image.png");
    mcv_image_free(&image);
    free(by_index);
    free(by_uri);
}

/*
 * The light that a floor 0.2 m before the emitter throws back, seen whole from aside by a
 * telecentric camera of this field [m] whose chief rays fall in at 45°, against the power that the
 * scene file states: Φ = π/ρ ∫ L dA, and a pixel of side p sees p²/cos 45° of the floor.
 *
 * `missing` is the share of light that chance finds too seldom to show in the error. float32 adds
 * some 1e-6.
 */
static inline void expect_power(const char *text, const double power[3], double field,
                                double missing, const char *what) {
    enum { PIXELS = 32 };
    const double rho = 0.5, s = sqrt(0.5), flux = M_PI / rho * field * field / s;
    mcv_scene *scene;
    mcv_sensor camera = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    BUILD(load_text("image_emitters_power.gltf", text, NULL, &scene, &builder_error));
    add_rectangle(scene, 4, 4, add_diffuse(scene, rho), looking_up_z(0, 0, -0.2));
    camera.as.telecentric.magnification = 1;
    camera.as.telecentric.workingDistance = 0.5;
    camera.as.telecentric.numericalAperture = 1e-3;
    camera.as.telecentric.resolution[0] = camera.as.telecentric.resolution[1] = PIXELS;
    camera.as.telecentric.pixelSize[0] = camera.as.telecentric.pixelSize[1] = field / PIXELS;
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &camera,
               looking((const double[]){0.5 * s, 0, 0.5 * s - 0.2}, (const double[]){-s, 0, -s},
                       (const double[]){0, 1, 0}));
    mcv_film film = render_by(false, scene, scene->sensor_count - 1, 64, 3);
    assert_int_equal(film.channels, 3);
    for (uint32_t channel = 0; channel < 3; ++channel) {
        char named[128];
        mcv_estimate m = film_estimate(&film, channel * PIXELS * PIXELS, PIXELS * PIXELS);
        m.mean *= flux;
        m.variance *= flux * flux;
        snprintf(named, sizeof named, "%s, channel %u [W]", what, channel);
        expect_estimate(named, m, power[channel], 0.01, missing + 2e-6);
    }
    /* The reference sees the same picture. As many samples for both: replicates of few are skewed,
     * and the rank test would see that. */
    mcv_film_free(&film);
    film = render_by(false, scene, scene->sensor_count - 1, 16, 4);
    mcv_film expected = render_by(true, scene, scene->sensor_count - 1, 16, 5);
    expect_same_picture(what, &film, &expected);
    mcv_film_free(&film);
    mcv_film_free(&expected);
    mcv_scene_free(scene);
}

#endif
