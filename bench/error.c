/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Error against time: bench_error [--quick] [--only TEXT] [OUTPUT.json], by default beside the
 * program; the plot stands beside it as .png. --quick has 1 to 256 samples and leaves out the
 * reference. docs/benchmarks.md has the method.
 *
 * Five scenes have few pixels and 1 to 16384 samples a pixel. They are rendered as usual, with each
 * technique replaced or left out, with none, and by the reference, which has random points only.
 * The truth is the device's image of 16 times the most samples with another seed. Seconds are those
 * of rendering alone, kernels compiled; each point is one image. The summary holds the slopes of
 * RMSE over samples: -1/2 for random numbers.
 *
 * The second part is the cost of a measurement: the error of an edge's position in telecentric
 * views, against the samples' seconds. The true position follows from the geometry.
 */
#include "analysis/edge.h"
#include "convergence.h"
#include "harness.h"
#include "io/figure.h"
#include "loader/load.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>

enum { SCENES = 5 };

static const char *const scene_files[SCENES] = {"report-clean.glb", "part-backlight.gltf",
                                                "caustic.gltf", "glasses.gltf",
                                                "telecentric-edge.gltf"};

enum { SOBOL, RANDOM, NO_SPLIT, NO_LIGHT_PATHS, ADAPTIVE, MIXED, NONE, REFERENCE, SERIES };

/* The first is the usual one; each of the others differs from it in what its name says. */
static const struct {
    const char *name;
    uint32_t sampler, precision;
    bool no_split, no_light_paths, adaptive;
    double red, green, blue;
} series[SERIES] = {
    [SOBOL] = {.name = "sobol", .green = 0.45, .blue = 0.7},
    [RANDOM] = {.name = "random", .sampler = MCV_SAMPLER_RANDOM, .red = 0.84, .green = 0.37},
    [NO_SPLIT] =
        {.name = "no splitting", .no_split = true, .red = 0.8, .green = 0.47, .blue = 0.65},
    [NO_LIGHT_PATHS] = {.name = "no light paths",
                        .no_light_paths = true,
                        .red = 0.34,
                        .green = 0.71,
                        .blue = 0.91},
    [ADAPTIVE] = {.name = "adaptive", .adaptive = true, .red = 0.2, .green = 0.2, .blue = 0.2},
    [MIXED] = {.name = "mixed precision",
               .precision = MCV_PRECISION_MIXED,
               .green = 0.62,
               .blue = 0.45},
    [NONE] = {.name = "none of these",
              .sampler = MCV_SAMPLER_RANDOM,
              .no_split = true,
              .no_light_paths = true,
              .red = 0.6,
              .green = 0.6,
              .blue = 0.6},
    [REFERENCE] = {.name = "reference",
                   .precision = MCV_PRECISION_DOUBLE,
                   .sampler = MCV_SAMPLER_RANDOM,
                   .red = 0.9,
                   .green = 0.62}};

typedef struct curve {
    int steps;
    double x[2][CONVERGENCE_STEPS], y[CONVERGENCE_STEPS]; /* samples and seconds */
} curve;

typedef struct plot {
    char title[80];
    curve curves[SERIES];
} plot;

/* A line through the logarithms of a curve, over samples or seconds. */
typedef struct law {
    double x, y, slope;
} law;

static law law_of(const curve *c, bool over_time) {
    law l = {0, 0, 0};
    double xx = 0, xy = 0;
    for (int i = 0; i < c->steps; ++i) {
        l.x += log(c->x[over_time][i]) / c->steps;
        l.y += log(c->y[i]) / c->steps;
    }
    for (int i = 0; i < c->steps; ++i) {
        const double x = log(c->x[over_time][i]) - l.x;
        xx += x * x;
        xy += x * (log(c->y[i]) - l.y);
    }
    l.slope = xy / xx;
    return l;
}

/* Where the curve first falls to the error, between two points; where it does not, by its law. */
static double seconds_to(const curve *c, double target) {
    const double *x = c->x[1], *y = c->y;
    int i = 1;
    while (i < c->steps && y[i] > target) ++i;
    if (i < c->steps && y[i - 1] > target)
        return x[i - 1] * pow(x[i] / x[i - 1], log(target / y[i - 1]) / log(y[i] / y[i - 1]));
    const law l = law_of(c, true);
    return exp(l.x + (log(target) - l.y) / l.slope);
}

/* Which earlier one has the same images, or s: what it leaves out or puts in place the scene has no
 * use for. */
static int first_like(const plot *p, int s) {
    const curve *c = p->curves;
    int like = 0;
    while (like < s && (c[like].steps != c[s].steps ||
                        memcmp(c[like].y, c[s].y, sizeof *c->y * (size_t)c[s].steps) != 0))
        ++like;
    return like;
}

static mcv_render_options options_of(int s) {
    mcv_render_options o = mcv_render_defaults();
    o.replicates = 1;
    o.precision = series[s].precision;
    o.sampler = series[s].sampler;
    o.no_split = series[s].no_split;
    o.no_light_paths = series[s].no_light_paths;
    o.adaptive = series[s].adaptive;
    return o;
}

/* --- plot
 * -------------------------------------------------------------------------------------------------------
 */

typedef struct axes {
    double x, y, width, height; /* of the frame */
    double low[2], high[2];     /* decades */
} axes;

static double place_x(const axes *a, double value) {
    return a->x + a->width * (log10(value) - a->low[0]) / (a->high[0] - a->low[0]);
}
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
            mcv_page_text(page, k == 0 ? at : a->x - 6, k == 0 ? a->y + a->height + 16 : at + 4,
                          k == 0 ? 0.5 : 1, text);
        }
    }
    cairo_rectangle(page, a->x, a->y, a->width, a->height);
    cairo_stroke(page);
    mcv_page_text(page, a->x, a->y - 8, 0, title);
    mcv_page_text(page, a->x + a->width / 2, a->y + a->height + 34, 0.5, x_label);
}

static void widen(axes *a, int k, double value) {
    a->low[k] = fmin(a->low[k], floor(log10(value)));
    a->high[k] = fmax(a->high[k], ceil(log10(value)));
}

/* Error over samples or seconds. The usual way is drawn last and thickest. */
static void draw_plot(cairo_t *page, const plot *p, bool over_time, double x, double y) {
    axes a = {x, y, 360, 270, {INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (int s = 0; s < SERIES; ++s)
        for (int i = 0; i < p->curves[s].steps; ++i) {
            widen(&a, 0, p->curves[s].x[over_time][i]);
            widen(&a, 1, p->curves[s].y[i]);
        }
    draw_axes(page, &a, p->title, over_time ? "seconds" : "samples per pixel");
    for (int s = SERIES; s-- > 0;) {
        const curve *c = &p->curves[s];
        cairo_set_source_rgb(page, series[s].red, series[s].green, series[s].blue);
        cairo_set_line_width(page, s == 0 ? 3 : 1.5);
        for (int i = 0; i < c->steps; ++i)
            cairo_line_to(page, place_x(&a, c->x[over_time][i]), place_y(&a, c->y[i]));
        cairo_stroke(page);
    }
    cairo_set_source_rgb(page, 0, 0, 0);
}

/* Beside the plots: names, and the slopes over samples. */
static void draw_legend(cairo_t *page, const plot *p, double x, double y) {
    char text[80];
    for (int s = 0; s < SERIES; ++s) {
        if (p->curves[s].steps == 0) continue;
        cairo_set_source_rgb(page, series[s].red, series[s].green, series[s].blue);
        cairo_rectangle(page, x, y - 9, 10, 10);
        cairo_fill(page);
        cairo_set_source_rgb(page, 0, 0, 0);
        snprintf(text, sizeof text, "%s: slope %.2f", series[s].name,
                 law_of(&p->curves[s], false).slope);
        mcv_page_text(page, x + 16, y, 0, text);
        y += 18;
    }
}

static mcv_result draw(const plot *plots, int count, const char *path, mcv_error *error) {
    cairo_t *page;
    MCV_TRY(mcv_page_new(&page, 1120, 40 + 350 * (uint32_t)count, 12, error));
    for (int i = 0; i < count; ++i) {
        for (int over_time = 0; over_time < 2; ++over_time)
            draw_plot(page, plots + i, over_time, 60 + 420 * over_time, 40 + 350 * i);
        draw_legend(page, plots + i, 880, 60 + 350 * i);
    }
    return mcv_page_write(page, path, error);
}

/* --- images
 * -------------------------------------------------------------------------------------------------------
 */

/* A key of the summary: the words with _ between them. */
static void note_key(bench *b, double value, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void note_key(bench *b, double value, const char *format, ...) {
    char key[96];
    va_list words;
    va_start(words, format);
    vsnprintf(key, sizeof key, format, words);
    va_end(words);
    for (char *c = key; *c; ++c) *c = isalnum((unsigned char)*c) ? *c : '_';
    bench_summary(b, key, value);
}

/* A row for each number of samples, and the slope over them; of what changes nothing, neither. */
static void note_curve(bench *b, plot *p, const char *what, int s, const char *unit) {
    curve *c = &p->curves[s];
    const int like = first_like(p, s);
    if (like < s) {
        printf("%s, %s: the images of %s\n", what, series[s].name, series[like].name);
        c->steps = 0;
    }
    for (int i = 0; i < c->steps; ++i) {
        bench_number(b, c->y[i], NAN, unit, "%s, %s, %.0f samples", what, series[s].name,
                     c->x[0][i]);
        bench_more(b, "samples", c->x[0][i]);
        bench_more(b, "seconds", c->x[1][i]);
    }
    if (c->steps)
        note_key(b, law_of(c, false).slope, "slope %.*s %s", (int)strcspn(what, "."), what,
                 series[s].name);
}

/* Compiles what the first measurement would have to wait for. */
static mcv_result warm(const mcv_scene *scene, int s, mcv_error *error) {
    mcv_render_options options = options_of(s);
    mcv_render_stats stats;
    mcv_film film;
    options.last = 1;
    if (series[s].precision == MCV_PRECISION_DOUBLE) return MCV_OK;
    MCV_TRY(mcv_render(scene, 0, &options, &film, &stats, error));
    mcv_film_free(&film);
    return MCV_OK;
}

static mcv_result measure_series(bench *b, plot *p, const mcv_scene *scene, const char *file,
                                 const mcv_film *truth, mcv_error *error) {
    const int steps = b->quick ? 5 : CONVERGENCE_STEPS;
    for (int s = 0; s < SERIES; ++s) {
        convergence_point points[CONVERGENCE_STEPS];
        curve *c = &p->curves[s];
        if (b->quick && s == REFERENCE) continue;
        MCV_TRY(warm(scene, s, error));
        MCV_TRY(converge_with(scene, options_of(s), truth, steps, points, error));
        for (int i = 0; i < steps; ++i) {
            c->x[0][c->steps] = (double)points[i].samples;
            c->x[1][c->steps] = points[i].seconds;
            c->y[c->steps++] = points[i].errors.rmse / mcv_film_mean(truth);
        }
        note_curve(b, p, file, s, "RMSE/mean");
    }
    return MCV_OK;
}

static mcv_result measure_scene(bench *b, plot *p, const char *file, mcv_error *error) {
    mcv_scene *scene;
    mcv_film truth;
    mcv_render_stats stats;
    MCV_TRY(load_small(file, &scene, error));
    mcv_result result =
        render_truth(scene, b->quick ? 5 : CONVERGENCE_STEPS, &truth, &stats, error);
    if (result == MCV_OK) {
        printf("%-20s truth: %u x %u pixels, %llu samples, mean %.4g, standard error %.2g, %.1f s, "
               "%s\n",
               file, truth.width, truth.height,
               (unsigned long long)truth.samples * truth.replicates, mcv_film_mean(&truth),
               mcv_film_relative_error(&truth) * mcv_film_mean(&truth), stats.seconds_render,
               stats.device);
        snprintf(p->title, sizeof p->title, "%s: RMSE / mean", file);
        result = measure_series(b, p, scene, file, &truth, error);
    }
    mcv_film_free(&truth);
    mcv_scene_free(scene);
    return result;
}

/* --- an edge
 * ------------------------------------------------------------------------------------------------------
 */

/*
 * telecentric-edge, moved by 1.3 µm so that nothing is symmetric: at the magnification of 1/2 and
 * pixels of 4.8 µm the edge passes the middle line 0.135 pixels right of the middle of 96 columns,
 * in focus or not, for what blurs it is symmetric.
 */
enum { EDGE_STEPS = 6, EDGE_IMAGES = 8 };
static const char *const edge_file = "telecentric-edge.gltf", *const edge_box = "12,4,72,56";
static const double true_edge = 48 + 0.5 * 1.3e-6 / 4.8e-6;

/* How far off the edge is [pixel]. */
static mcv_result edge_error(const mcv_film *film, double *off, mcv_error *error) {
    mcv_readings readings = {0};
    mcv_edge edge;
    mcv_result result = mcv_film_develop(film, &readings.values, NULL, error);
    if (result == MCV_OK)
        result = mcv_image_new(&readings.deviation, film->width, film->height, 1, error);
    for (size_t i = 0; result == MCV_OK && i < film_values(film); ++i)
        readings.deviation.pixels[i] = 1e-6f * readings.values.pixels[i];
    if (result == MCV_OK) result = mcv_edge_parse(edge_box, 1, &readings.values, &edge, error);
    if (result == MCV_OK) result = mcv_edge_find(&readings, &edge, error);
    if (result == MCV_OK) *off = edge.position.value - true_edge;
    mcv_image_free(&readings.values);
    mcv_image_free(&readings.deviation);
    return result;
}

/* The root mean square over images of other seeds, and the mean of their seconds. */
static mcv_result measure_edge(const mcv_scene *scene, mcv_render_options options, double *rms,
                               double *seconds, mcv_error *error) {
    double squares = 0;
    *seconds = 0;
    for (options.seed = 1; options.seed <= EDGE_IMAGES; ++options.seed) {
        mcv_render_stats stats;
        mcv_film film;
        double off = 0;
        MCV_TRY(mcv_render(scene, 0, &options, &film, &stats, error));
        const mcv_result result = edge_error(&film, &off, error);
        mcv_film_free(&film);
        if (result != MCV_OK) return result;
        squares += off * off / EDGE_IMAGES;
        *seconds += stats.seconds_render / EDGE_IMAGES;
    }
    *rms = sqrt(squares);
    return MCV_OK;
}

/* And the seconds until the edge is off by a thousandth of a pixel. */
static void note_edge_curve(bench *b, plot *p, int s) {
    note_curve(b, p, "telecentric-edge position", s, "pixel");
    if (p->curves[s].steps > 0)
        note_key(b, seconds_to(&p->curves[s], 1e-3), "edge seconds %s", series[s].name);
}

static mcv_result measure_edges(bench *b, plot *p, mcv_error *error) {
    static const char *const moved[] = {"nodes/plate/translation/x=1.3e-6"};
    const int steps = b->quick ? 4 : EDGE_STEPS;
    char path[1024];
    mcv_scene *scene;
    mcv_result result = MCV_OK;
    snprintf(path, sizeof path, MCV_SOURCE_DIR "/scenes/%s", edge_file);
    snprintf(p->title, sizeof p->title, "%s: the edge is off by [pixel]", edge_file);
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){moved, 1}, &scene, error));
    for (int s = 0; s < SERIES && result == MCV_OK; ++s) {
        if (s > RANDOM && s != ADAPTIVE)
            continue; /* the scene has nothing that splits, bends light or needs precision */
        curve *c = &p->curves[s];
        mcv_render_options options = options_of(s);
        result = warm(scene, s, error);
        for (int i = 0; i < steps && result == MCV_OK; ++i) {
            const uint64_t samples = (uint64_t)4 << 2 * i;
            options.last = samples;
            result = measure_edge(scene, options, &c->y[i], &c->x[1][i], error);
            if (result != MCV_OK) break;
            c->x[0][i] = (double)samples;
        }
        c->steps = steps;
        if (result == MCV_OK) note_edge_curve(b, p, s);
    }
    mcv_scene_free(scene);
    return result;
}

static mcv_result run(bench *b, mcv_error *error) {
    static plot plots[SCENES + 1];
    char path[sizeof b->stem + 8];
    int count = 0;
    snprintf(path, sizeof path, "%s.png", b->stem);
    bench_title("Error");
    for (int scene = 0; scene < SCENES; ++scene)
        if (!b->only || strstr(scene_files[scene], b->only))
            MCV_TRY(measure_scene(b, plots + count++, scene_files[scene], error));
    if (!b->only || strstr(edge_file, b->only)) MCV_TRY(measure_edges(b, plots + count++, error));
    return draw(plots, count, path, error);
}

int main(int argc, char **argv) { return bench_main(argc, argv, "error", run); }
