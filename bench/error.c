/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Error against time: bench_error [--quick] [OUTPUT.json], by default beside the program; the plot stands beside it as .png. The quick
 * one has 1 to 256 samples and leaves out the reference.
 *
 * Two scenes at few pixels, rendered by the device with random and with Owen-scrambled Sobol' points, with these in mixed precision, too,
 * and by the reference, which has random points only; 1 to 16384 samples a pixel.
 * The truth is the device's image of 16 times the most samples with another seed. Seconds are those of rendering alone, kernels
 * compiled; one image a point. The summary holds the slopes of RMSE over samples: -1/2 for random numbers.
 */
#include "convergence.h"
#include "harness.h"
#include "output/figure.h"

#include <ctype.h>
#include <stdio.h>

enum { SCENES = 2, SERIES = 4 };

static const char *const scene_files[SCENES] = {"report-clean.glb", "part-backlight.gltf"};

static const struct {
    const char *renderer, *sampler;
    uint32_t precision, sampler_id;
    double red, green, blue;
} series[SERIES] = {{"device", "random", MCV_PRECISION_SINGLE, MCV_SAMPLER_RANDOM, 0.84, 0.37, 0},
                    {"device", "sobol", MCV_PRECISION_SINGLE, MCV_SAMPLER_SOBOL, 0, 0.45, 0.7},
                    {"mixed", "sobol", MCV_PRECISION_MIXED, MCV_SAMPLER_SOBOL, 0, 0.62, 0.45},
                    {"reference", "random", MCV_PRECISION_DOUBLE, MCV_SAMPLER_RANDOM, 0.9, 0.62, 0}};

typedef struct results {
    int series, steps; /* shown: the first … */
    double mean[SCENES];
    convergence_point points[SCENES][SERIES][CONVERGENCE_STEPS];
} results;

/* --- plot ------------------------------------------------------------------------------------------------------- */

typedef struct axes {
    double x, y, width, height; /* of the frame */
    double low[2], high[2];     /* decades */
} axes;

static double place_x(const axes *a, double value) { return a->x + a->width * (log10(value) - a->low[0]) / (a->high[0] - a->low[0]); }
static double place_y(const axes *a, double value) {
    return a->y + a->height * (1 - (log10(value) - a->low[1]) / (a->high[1] - a->low[1]));
}

static void draw_axes(cairo_t *page, const axes *a, const char *title, const char *x_label) {
    char text[32];
    cairo_set_line_width(page, 0.5);
    for (int k = 0; k < 2; ++k) {
        for (double decade = a->low[k]; decade <= a->high[k]; ++decade) {
            const double at = k == 0 ? place_x(a, pow(10, decade)) : place_y(a, pow(10, decade));
            cairo_set_source_rgb(page, 0.8, 0.8, 0.8);
            cairo_move_to(page, k == 0 ? at : a->x, k == 0 ? a->y : at);
            cairo_line_to(page, k == 0 ? at : a->x + a->width, k == 0 ? a->y + a->height : at);
            cairo_stroke(page);
            cairo_set_source_rgb(page, 0, 0, 0);
            snprintf(text, sizeof text, "1e%.0f", decade);
            mcv_page_text(page, k == 0 ? at : a->x - 6, k == 0 ? a->y + a->height + 16 : at + 4, k == 0 ? 0.5 : 1, text);
        }
    }
    cairo_rectangle(page, a->x, a->y, a->width, a->height);
    cairo_stroke(page);
    mcv_page_text(page, a->x, a->y - 8, 0, title);
    mcv_page_text(page, a->x + a->width / 2, a->y + a->height + 34, 0.5, x_label);
}

static double abscissa(const convergence_point *p, bool over_time) { return over_time ? p->seconds : (double)p->samples; }

/* RMSE over samples or seconds of one scene. */
static void draw_scene(cairo_t *page, const results *r, int scene, bool over_time, double x, double y) {
    axes a = {x, y, 330, 250, {INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    char title[128];
    for (int s = 0; s < r->series; ++s) {
        for (int i = 0; i < r->steps; ++i) {
            const convergence_point *p = &r->points[scene][s][i];
            const double decades[2] = {log10(abscissa(p, over_time)), log10(p->errors.rmse / r->mean[scene])};
            for (int k = 0; k < 2; ++k) {
                a.low[k] = fmin(a.low[k], floor(decades[k]));
                a.high[k] = fmax(a.high[k], ceil(decades[k]));
            }
        }
    }
    snprintf(title, sizeof title, "%s: RMSE / mean", scene_files[scene]);
    draw_axes(page, &a, title, over_time ? "seconds" : "samples per pixel");
    for (int s = 0; s < r->series; ++s) {
        cairo_set_source_rgb(page, series[s].red, series[s].green, series[s].blue);
        cairo_set_line_width(page, 2);
        for (int i = 0; i < r->steps; ++i) {
            const convergence_point *p = &r->points[scene][s][i];
            cairo_line_to(page, place_x(&a, abscissa(p, over_time)), place_y(&a, p->errors.rmse / r->mean[scene]));
        }
        cairo_stroke(page);
        if (over_time) continue;
        snprintf(title, sizeof title, "%s, %s: slope %.2f", series[s].renderer, series[s].sampler,
                 slope_of_rmse(r->points[scene][s], r->steps));
        mcv_page_text(page, a.x + 8, a.y + a.height - 8 - 16 * (r->series - 1 - s), 0, title);
    }
    cairo_set_source_rgb(page, 0, 0, 0);
}

static mcv_result draw(const results *r, const char *path, mcv_error *error) {
    cairo_t *page;
    MCV_TRY(mcv_page_new(&page, 820, 700, 12, error));
    for (int scene = 0; scene < SCENES; ++scene) {
        for (int over_time = 0; over_time < 2; ++over_time) draw_scene(page, r, scene, over_time, 60 + 400 * over_time, 40 + 340 * scene);
    }
    return mcv_page_write(page, path, error);
}

/* --- measurement ------------------------------------------------------------------------------------------------ */

/* A row for each number of samples: ours are Sobol' points, their peer the random ones of the same renderer. */
static void note_series(bench *b, const results *r, int scene, int s, const convergence_point points[CONVERGENCE_STEPS]) {
    char key[64];
    for (int i = 0; i < r->steps; ++i) {
        const bool sobol = series[s].sampler_id == MCV_SAMPLER_SOBOL;
        const double random = r->points[scene][0][i].errors.rmse / r->mean[scene];
        bench_number(b, points[i].errors.rmse / r->mean[scene], sobol ? random : NAN, "RMSE/mean", "%s, %s %s, %llu samples",
                     scene_files[scene], series[s].renderer, series[s].sampler, (unsigned long long)points[i].samples);
        bench_more(b, "samples", (double)points[i].samples);
        bench_more(b, "seconds", points[i].seconds);
        bench_more(b, "relative_mse", points[i].errors.relative_mse);
    }
    snprintf(key, sizeof key, "slope %.*s %s %s", (int)strcspn(scene_files[scene], "."), scene_files[scene], series[s].renderer,
             series[s].sampler);
    for (char *c = key; *c; ++c) *c = isalnum((unsigned char)*c) ? *c : '_';
    bench_summary(b, key, slope_of_rmse(points, r->steps));
}

static mcv_result measure_scene(bench *b, results *r, int scene, mcv_error *error) {
    mcv_scene *loaded;
    mcv_film truth;
    mcv_render_stats stats;
    MCV_TRY(load_small(scene_files[scene], &loaded, error));
    /* The truth's render also compiles what the first measurement would have to wait for; the random sampler is a program of its own. */
    mcv_result result = render_truth(loaded, r->steps, &truth, &stats, error);
    if (result == MCV_OK) {
        r->mean[scene] = mcv_film_mean(&truth);
        printf("%-20s truth: %u x %u pixels, %llu samples, mean %.4g, standard error %.2g, %.1f s, %s\n", scene_files[scene], truth.width,
               truth.height, (unsigned long long)truth.samples * truth.replicates, r->mean[scene],
               mcv_film_relative_error(&truth) * r->mean[scene], stats.seconds_render, stats.device);
    }
    for (int s = 0; s < r->series && result == MCV_OK; ++s) {
        convergence_point *points = r->points[scene][s];
        if (series[s].precision != MCV_PRECISION_DOUBLE) {
            mcv_render_options warm = mcv_render_defaults();
            mcv_film film;
            warm.precision = series[s].precision;
            warm.sampler = series[s].sampler_id;
            warm.last = 1;
            result = mcv_render(loaded, 0, &warm, &film, &stats, error);
            mcv_film_free(&film);
        }
        if (result == MCV_OK) result = converge(loaded, series[s].precision, series[s].sampler_id, &truth, r->steps, points, error);
        if (result == MCV_OK) note_series(b, r, scene, s, points);
    }
    mcv_film_free(&truth);
    mcv_scene_free(loaded);
    return result;
}

static mcv_result run(bench *b, mcv_error *error) {
    static results r;
    char plot[sizeof b->stem + 8];
    snprintf(plot, sizeof plot, "%s.png", b->stem);
    r.series = b->quick ? SERIES - 1 : SERIES;
    r.steps = b->quick ? 5 : CONVERGENCE_STEPS;
    bench_title("Error: Sobol' points (ours) and random ones (peer)");
    for (int scene = 0; scene < SCENES; ++scene) MCV_TRY(measure_scene(b, &r, scene, error));
    return draw(&r, plot, error);
}

int main(int argc, char **argv) { return bench_main(argc, argv, "error", run); }
