/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The report's figure from the three light field images of its experiment: what a plain camera sees
 * above the Earth Mover's gradient, one scale a row, with the peak-to-noise ratios of the defect,
 * and the same ratios as JSON.
 */
#include "analysis/contrast.h"
#include "analysis/lightfield_file.h"
#include "io/figure.h"
#include "core/output_file.h"
#include "io/png.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { IMAGES = 3 };
static const char *const names[IMAGES] = {"clean", "bubble", "dent"};

/* Distances from the axis in the plane in focus, where the lens is [m]: the defect, and what it is
 * compared with. */
static const double region_radius = 1.5e-3, background_inner = 2.5e-3, background_outer = 10e-3;

typedef struct result {
    mcv_image plain, emd, emd_mass; /* cropped to a square inside background_outer */
    double peak_plain, peak_emd, peak_emd_mass;
} result;

/*
 * The distance between the points that neighbouring macro pixels look at, in the plane in focus: J
 * l_x f/(b - f), the pitch of the macro pixels over the magnification b/w_z = (b - f)/f.
 */
static mcv_result focused_pitch(const char *path, const mcv_light_field_file *file, double pitch[2],
                                mcv_error *error) {
    double f, b, pixel[2];
    MCV_TRY(mcv_light_field_attribute(path, &file->exr, "mcvisi:focalLength", &f, 1, error));
    MCV_TRY(mcv_light_field_attribute(path, &file->exr, "mcvisi:imageDistance", &b, 1, error));
    MCV_TRY(mcv_light_field_attribute(path, &file->exr, "mcvisi:pixelSize", pixel, 2, error));
    for (int i = 0; i < 2; ++i) pitch[i] = file->angular[i] * pixel[i] * f / (b - f);
    return MCV_OK;
}

/* Keeps the columns and rows whose distance from the centre is at most `outer`. */
static void crop(mcv_image *image, const double pitch[2], double outer) {
    const uint32_t size[2] = {image->width, image->height};
    uint32_t first[2], kept[2];
    for (int i = 0; i < 2; ++i) {
        for (first[i] = 0; (0.5 * size[i] - first[i] - 0.5) * pitch[i] > outer;) ++first[i];
        kept[i] = size[i] - 2 * first[i];
    }
    for (uint32_t row = 0; row < kept[1]; ++row)
        memmove(image->pixels + (size_t)row * kept[0],
                image->pixels + (size_t)(first[1] + row) * size[0] + first[0],
                kept[0] * sizeof *image->pixels);
    image->width = kept[0];
    image->height = kept[1];
}

static mcv_result analyse_file(const char *path, const mcv_light_field_file *file, result *r,
                               mcv_error *error) {
    double pitch[2];
    MCV_TRY(focused_pitch(path, file, pitch, error));
    const mcv_ring region = {.outer = region_radius, .pitch = {pitch[0], pitch[1]}};
    const mcv_ring background = {
        .inner = background_inner, .outer = background_outer, .pitch = {pitch[0], pitch[1]}};
    MCV_TRY(mcv_light_field_plain(&file->image, file->angular, &r->plain, error));
    MCV_TRY(mcv_light_field_gradient(&file->image, file->angular, MCV_EMD_NORMALIZED, 0, &r->emd,
                                     error));
    MCV_TRY(mcv_light_field_gradient(&file->image, file->angular, MCV_EMD_MASS, 0, &r->emd_mass,
                                     error));
    r->peak_plain = mcv_peak_to_noise(&r->plain, &region, &background);
    r->peak_emd = mcv_peak_to_noise(&r->emd, &region, &background);
    r->peak_emd_mass = mcv_peak_to_noise(&r->emd_mass, &region, &background);
    crop(&r->plain, pitch, background_outer * sqrt(0.5));
    crop(&r->emd, pitch, background_outer * sqrt(0.5));
    return MCV_OK;
}

static mcv_result analyse(const char *path, result *r, mcv_error *error) {
    mcv_light_field_file file;
    MCV_TRY(mcv_light_field_read(path, (const uint64_t[]){0, 0}, &file, error));
    const mcv_result analysed = analyse_file(path, &file, r, error);
    mcv_light_field_free(&file);
    return analysed;
}

/* --- the figure --- */

enum { ZOOM = 4, MARGIN = 16, TITLE = 32, LINE = 20 };

/* The second largest of the three images' largest values: the bubble's must not drown the dent's.
 */
static double scale_end(const result *results) {
    double largest[IMAGES];
    for (int i = 0; i < IMAGES; ++i) largest[i] = mcv_image_spread(&results[i].emd, NULL).largest;
    return fmax(fmin(largest[0], largest[1]), fmin(fmax(largest[0], largest[1]), largest[2]));
}

static mcv_result draw(const char *path, const result *results, mcv_error *error) {
    mcv_color_scale plain = {.map = MCV_COLORMAP_GREY};
    const mcv_color_scale emd = {.map = MCV_COLORMAP_VIRIDIS, .high = scale_end(results)};
    const int width = (int)results->plain.width * ZOOM, height = (int)results->plain.height * ZOOM;
    const int second = TITLE + height + MARGIN, text = second + height + LINE;
    cairo_t *page;
    char line[128];
    for (int i = 0; i < IMAGES; ++i) {
        if (results[i].plain.width != results->plain.width ||
            results[i].plain.height != results->plain.height)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: the three images must have the same macro pixels", path);
        plain.high = fmax(plain.high, mcv_preview_white(&results[i].plain));
    }
    const int bar = MARGIN + IMAGES * (width + MARGIN);
    MCV_TRY(mcv_page_new(&page, (uint32_t)(bar + MCV_COLOR_BAR_WIDTH + MARGIN),
                         (uint32_t)(text + LINE + MARGIN), 14, error));
    for (int i = 0; i < IMAGES; ++i) {
        const int x = MARGIN + i * (width + MARGIN);
        const double centre = x + 0.5 * width;
        mcv_page_text(page, centre, TITLE - 10, 0.5, names[i]);
        mcv_page_image(page, x, TITLE, &results[i].plain, ZOOM, &plain);
        mcv_page_image(page, x, second, &results[i].emd, ZOOM, &emd);
        snprintf(line, sizeof line, "peak to noise: plain %.3g, gradient %.3g",
                 results[i].peak_plain, results[i].peak_emd);
        mcv_page_text(page, centre, text, 0.5, line);
        snprintf(line, sizeof line, "(its form `mass`: %.3g)", results[i].peak_emd_mass);
        mcv_page_text(page, centre, text + LINE, 0.5, line);
    }
    mcv_page_color_bar(page, bar, TITLE, height, "plain image (sum over macro pixels)", &plain);
    mcv_page_color_bar(page, bar, second, height, "Earth Mover's gradient (fraction of the pupil)",
                       &emd);
    return mcv_page_write(page, path, error);
}

/* --- the summary --- */

static json_t *number(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static mcv_result summarise(const char *path, const result *results, double seconds,
                            mcv_error *error) {
    json_t *root = json_object();
    for (int i = 0; i < IMAGES; ++i) {
        json_t *object = json_object();
        json_object_set_new(object, "peak_to_noise_plain", number(results[i].peak_plain));
        json_object_set_new(object, "peak_to_noise_emd", number(results[i].peak_emd));
        json_object_set_new(object, "peak_to_noise_emd_mass", number(results[i].peak_emd_mass));
        json_object_set_new(root, names[i], object);
    }
    json_object_set_new(root, "seconds", number(seconds));
    char *text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(6));
    json_decref(root);
    if (!text) return mcv_fail(error, MCV_FAILED, "%s: no memory for the summary", path);
    mcv_output output;
    mcv_result written = mcv_output_open(&output, path, error);
    if (written == MCV_OK) {
        written = mcv_output_write(&output, text, strlen(text), error);
        if (written == MCV_OK) written = mcv_output_write(&output, "\n", 1, error);
        if (written == MCV_OK)
            written = mcv_output_commit(&output, error);
        else
            mcv_output_discard(&output);
    }
    free(text);
    return written;
}

int main(int argc, char **argv) {
    mcv_error error = {""};
    result results[IMAGES] = {{.peak_plain = 0}};
    mcv_result done = MCV_OK;
    char *end = NULL;
    const double seconds = argc == 7 ? strtod(argv[6], &end) : 0;
    if (argc != 7 || end == argv[6] || *end) {
        fputs("report_figure CLEAN.exr BUBBLE.exr DENT.exr FIGURE.png SUMMARY.json SECONDS\n"
              "SECONDS is what the demo has taken so far; it goes into the summary.\n",
              stderr);
        return MCV_USAGE;
    }
    for (int i = 0; i < IMAGES && done == MCV_OK; ++i)
        done = analyse(argv[1 + i], results + i, &error);
    if (done == MCV_OK) done = draw(argv[4], results, &error);
    if (done == MCV_OK) done = summarise(argv[5], results, seconds, &error);
    for (int i = 0; i < IMAGES; ++i) {
        mcv_image_free(&results[i].plain);
        mcv_image_free(&results[i].emd);
        mcv_image_free(&results[i].emd_mass);
    }
    if (error.text[0]) fprintf(stderr, "report_figure: %s\n", error.text);
    return (int)done;
}
