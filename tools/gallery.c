/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gallery of wrong and right set-ups.
 *
 *     gallery list                    a line for each image that it needs: STEM ARGUMENTS, what
 *                                     follows `mcvisi`
 *     gallery draw RENDERS PICTURES   reads RENDERS/STEM.exr and .png, writes PICTURES/NAME.png and
 *                                     the section of scenes/README.md to stdout
 *
 * Each number is computed from the float image, as its function here says.
 */
#include "io/exr.h"
#include "io/figure.h"
#include "io/png.h"
#include "scene/scene.h"
#include "scene/sensors.h"
#include "scene/texture.h"
#include "loader/load.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_IMAGES = 4, MAX_PANELS = 3, TEXT = 128 };

/* --- numbers --- */

/* The images of one panel, one channel each (the mean of what there were), the first one's standard
 * error, and that one in colour. */
typedef struct images {
    mcv_image of[MAX_IMAGES], error, coloured;
} images;

static double value(const mcv_image *image, uint32_t column, uint32_t row) {
    return image->pixels[(size_t)row * image->width + column];
}

static double mean_of_column(const mcv_image *image, uint32_t column, uint32_t first_row,
                             uint32_t last_row) {
    double sum = 0;
    for (uint32_t row = first_row; row < last_row; ++row) sum += value(image, column, row);
    return sum / (last_row - first_row);
}

/* Where rows' mean falls through half the backlight, walking from one column to another; between
 * columns linearly. */
static double edge_from(const mcv_image *image, int from, int to, uint32_t first_row,
                        uint32_t last_row) {
    const int step = from < to ? 1 : -1;
    const double level = 0.5 * mean_of_column(image, (uint32_t)from, first_row, last_row);
    double before = 2 * level;
    for (int column = from; column != to; column += step) {
        const double here = mean_of_column(image, (uint32_t)column, first_row, last_row);
        if (here < level) return column - step * (level - here) / (before - here);
        before = here;
    }
    return NAN;
}

/* The plain part of the shanks, in rows 78 to 87: the near one is in the left half, the far one in
 * the right. */
static void say_widths(const images *seen, char *text) {
    const mcv_image *image = seen->of;
    const int middle = (int)image->width / 2, last = (int)image->width - 1;
    const double near = edge_from(image, middle, 0, 78, 87) - edge_from(image, 0, middle, 78, 87);
    const double far =
        edge_from(image, last, middle, 78, 87) - edge_from(image, middle, last, 78, 87);
    snprintf(text, TEXT, "near %.2f px, far %.2f px: %+.2f px", near, far, near - far);
}

/* Which of two regions a place on the part belongs to [m]; what is in neither does not count. */
typedef enum region { REGION_NONE, REGION_DEFECT, REGION_SURROUNDINGS } region;
typedef region region_of(double x, double y);

/* A camera's full well: what is white in the picture fills it, and more is lost. */
static const double electrons_at_white = 10000;

/*
 * Contrast to noise |μ1 - μ2|/σ2 of a defect and its surroundings. Noise is what is uneven in
 * these, and the shot noise of a camera's electrons; that of the render is taken off by its
 * standard errors. The axis is in the middle.
 */
static double contrast_to_noise(const images *seen, double pitch, region_of *classify) {
    const mcv_image *image = seen->of;
    const double white = mcv_preview_white(image);
    double n[3] = {0}, sum[3] = {0}, squares[3] = {0}, errors[3] = {0};
    for (uint32_t row = 0; row < image->height; ++row)
        for (uint32_t column = 0; column < image->width; ++column) {
            const double v = fmin(value(image, column, row), white),
                         error = value(&seen->error, column, row);
            const region r = classify((column + 0.5 - 0.5 * image->width) * pitch,
                                      (0.5 * image->height - row - 0.5) * pitch);
            n[r] += 1;
            sum[r] += v;
            squares[r] += v * v;
            errors[r] += error * error;
        }
    const double around = sum[REGION_SURROUNDINGS] / n[REGION_SURROUNDINGS];
    const double seen_variance =
        squares[REGION_SURROUNDINGS] / n[REGION_SURROUNDINGS] - around * around;
    const double uneven =
        fmax(seen_variance - errors[REGION_SURROUNDINGS] / n[REGION_SURROUNDINGS], 0);
    return fabs(sum[REGION_DEFECT] / n[REGION_DEFECT] - around) /
           sqrt(uneven + white * around / electrons_at_white);
}

static const double part_pitch = 51e-6; /* of the cameras in scenes/setups.py: 25.5 µm at m = 1/2 */

/* The scratch's middle line as scenes/setups.py cuts it, within 40 µm; beside it from 0.3 to 2 mm.
 */
static region about_scratch(double x, double y) {
    const double off = fabs(y - (0.25 * x + 25 * x * x - 0.0008));
    if (fabs(x) > 0.0045) return REGION_NONE;
    return off < 40e-6                  ? REGION_DEFECT
           : off > 0.3e-3 && off < 2e-3 ? REGION_SURROUNDINGS
                                        : REGION_NONE;
}

/* The letters' strokes and what is around them, 0.2 mm off every edge. Cells are millimetres, as in
 * scenes/setups.py. */
static region about_letters(double x, double y) {
    static const char *const letters[] = {"X...X..XX", "X...X.X.X", "X...X...X", "XXXXX...X",
                                          "X...X...X", "X...X...X", "X...X...X"};
    const double across = x / 1e-3 + 4.5, down = 3.5 - y / 1e-3;
    bool all = true, any = false;
    if (across < -1 || across > 10 || down < -1 || down > 8) return REGION_NONE;
    for (int corner = 0; corner < 4; ++corner) {
        const int column = (int)floor(across + (corner & 1 ? 0.2 : -0.2)),
                  row = (int)floor(down + (corner & 2 ? 0.2 : -0.2));
        const bool milled =
            column >= 0 && column < 9 && row >= 0 && row < 7 && letters[row][column] == 'X';
        all = all && milled;
        any = any || milled;
    }
    return all ? REGION_DEFECT : any ? REGION_NONE : REGION_SURROUNDINGS;
}

static void say_scratch(const images *seen, char *text) {
    snprintf(text, TEXT, "contrast to noise %.1f",
             contrast_to_noise(seen, part_pitch, about_scratch));
}

static void say_letters(const images *seen, char *text) {
    snprintf(text, TEXT, "contrast to noise %.1f",
             contrast_to_noise(seen, part_pitch, about_letters));
}

/* The phase of the pattern from its four steps. */
static double phase(const images *seen, uint32_t column, uint32_t row) {
    return atan2(value(seen->of + 1, column, row) - value(seen->of + 3, column, row),
                 value(seen->of, column, row) - value(seen->of + 2, column, row));
}

/*
 * How far the step, 4 mm high, shifts the pattern against the plate: the mean phase between a row
 * of the step and one of the plate in the same columns, over the phase from column to column on the
 * plate.
 */
static void say_shift(const images *seen, char *text) {
    enum { FIRST = 95, LAST = 185, STEP_ROW = 145, PLATE_ROW = 60, ROWS = 30 };
    double shift[2] = {0, 0}, slope[2] = {0, 0};
    for (uint32_t i = 0; i < ROWS; ++i)
        for (uint32_t column = FIRST; column < LAST; ++column) {
            const double plate = phase(seen, column, PLATE_ROW + i),
                         step = phase(seen, column, STEP_ROW - ROWS / 2 + i);
            const double next = phase(seen, column + 1, PLATE_ROW + i);
            shift[0] += cos(step - plate), shift[1] += sin(step - plate);
            slope[0] += cos(next - plate), slope[1] += sin(next - plate);
        }
    snprintf(text, TEXT, "the step shifts the stripes by %.1f px",
             fabs(atan2(shift[1], shift[0]) / atan2(slope[1], slope[0])));
}

/* The display of scenes/light-field.gltf, and the value (mean of R, G, B) of its pixel. */
static double displayed(const mcv_texture *texture, uint32_t column, uint32_t row) {
    double sum = 0;
    for (uint32_t k = 0; k < 3; ++k)
        sum += mcv_srgb_decode(texture->rgba[4 * ((size_t)row * texture->width + column) + k]);
    return sum / 3;
}

static uint32_t cell(double share, uint32_t count) {
    return (uint32_t)fmin(fmax(floor(share * count), 0), count - 1.0);
}

/*
 * What differs between the image and the display: the root of the mean square over that of the
 * display. The camera faces the display in the depth in focus, so its macro pixel looks at the one
 * opposite; its pixel's middle says through where on the lens, and that in which direction the
 * display's pixel shines (include/mcvisi/emitters/light_field.h).
 */
static void say_display(const images *seen, char *text) {
    mcv_scene *scene;
    mcv_error error;
    double difference = 0, power = 0;
    snprintf(text, TEXT, "no scene");
    if (mcv_scene_load("scenes/light-field.gltf", (mcv_overrides){NULL, 0}, &scene, &error) !=
        MCV_OK)
        return;
    const mcv_light_field_params *camera = &scene->sensors[0].as.light_field;
    const mcv_light_field_emitter_params *display = &scene->emitters[0].as.light_field_emitter;
    const uint32_t *macro = display->spatialResolution, *angular = display->angularResolution;
    const double distance = -scene->sensors[0].to_world.m[11];
    for (uint32_t row = 0; row < seen->of->height; ++row)
        for (uint32_t column = 0; column < seen->of->width; ++column) {
            const uint32_t m = macro[0] - 1 - column / angular[0], n = row / angular[1];
            const double u = (column % angular[0] + 0.5) / angular[0],
                         v = (row % angular[1] + 0.5) / angular[1];
            const double x = -(2 * u - 1) * camera->lensDiameter / 2 -
                             ((m + 0.5) / macro[0] - 0.5) * display->size[0];
            const double y = -(2 * v - 1) * camera->lensDiameter / 2 -
                             (0.5 - (n + 0.5) / macro[1]) * display->size[1];
            const double scale =
                1 / (sqrt(x * x + y * y + distance * distance) * display->angularRange);
            const uint32_t j = cell((x * scale + 1) / 2, angular[0]),
                           k = cell((1 - y * scale) / 2, angular[1]);
            const double shown = displayed(scene->textures + scene->emitters[0].texture,
                                           m * angular[0] + j, n * angular[1] + k);
            const double off = value(seen->of, column, row) - shown;
            difference += off * off;
            power += shown * shown;
        }
    snprintf(text, TEXT, "differs from the display by %.0f %%", 100 * sqrt(difference / power));
    mcv_scene_free(scene);
}

static int compare_values(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/*
 * The tenth brightest pixel where the ball's axis along the light meets the paper, and off the
 * ball's highlight, over what the picture shows most of: paper.
 */
static void say_peak(const images *seen, char *text) {
    enum { LEFT = 118, RIGHT = 165, TOP = 100, BOTTOM = 140, RANK = 10 };
    float around[(RIGHT - LEFT) * (BOTTOM - TOP)] = {0}, *pixels = seen->of->pixels;
    const size_t count = (size_t)seen->of->width * seen->of->height,
                 near = sizeof around / sizeof around[0];
    for (uint32_t i = 0; i < near; ++i)
        around[i] = (float)value(seen->of, LEFT + i % (RIGHT - LEFT), TOP + i / (RIGHT - LEFT));
    qsort(around, near, sizeof *around, compare_values);
    qsort(pixels, count, sizeof *pixels, compare_values);
    snprintf(text, TEXT, "the focus is %.0f times the paper",
             (double)around[near - RANK] / (double)pixels[count / 2]);
}

/* One channel of the first image. */
static mcv_image channel_of(const images *seen, uint32_t channel) {
    mcv_image plane = seen->coloured;
    if (channel >= plane.channels) channel = 0; /* grey */
    plane.pixels += (size_t)channel * plane.width * plane.height;
    plane.channels = 1;
    return plane;
}

/* Where the left edge of the rightmost bar but one lies in red and in blue. */
static void say_fringe(const images *seen, char *text) {
    const mcv_image red = channel_of(seen, 0), blue = channel_of(seen, 2);
    snprintf(text, TEXT, "red and blue are %.2f px apart",
             fabs(edge_from(&red, 172, 206, 60, 108) - edge_from(&blue, 172, 206, 60, 108)));
}

/* Of all the light, that of the strongest channel of each place. */
static void say_purity(const images *seen, char *text) {
    const size_t pixels = (size_t)seen->coloured.width * seen->coloured.height;
    double strongest = 0, all = 0;
    for (size_t i = 0; i < pixels; ++i) {
        double most = 0;
        for (size_t c = 0; c < seen->coloured.channels; ++c) {
            const double v = (double)seen->coloured.pixels[c * pixels + i];
            most = fmax(most, v);
            all += v;
        }
        strongest += most;
    }
    snprintf(text, TEXT, "%.0f %% of the light is of one wavelength", 100 * strongest / all);
}

/* The bubble of scenes/optics.py within 0.2 mm of its middle, the rod around it from 0.5 to 2 mm.
 */
static region about_bubble(double x, double y) {
    const double off = hypot(x - 0.002, y - 0.0025);
    return off < 0.2e-3                 ? REGION_DEFECT
           : off > 0.5e-3 && off < 2e-3 ? REGION_SURROUNDINGS
                                        : REGION_NONE;
}

static void say_bubble(const images *seen, char *text) {
    snprintf(text, TEXT, "contrast to noise %.1f", contrast_to_noise(seen, 64e-6, about_bubble));
}

typedef struct window {
    uint32_t left, right, top, bottom;
} window;

static double mean_of(const mcv_image *image, window w) {
    double sum = 0;
    for (uint32_t column = w.left; column < w.right; ++column)
        sum += mean_of_column(image, column, w.top, w.bottom);
    return sum / (w.right - w.left);
}

/* Where the lamp is mirrored, against the same place on the other side of the chart's middle. */
static void say_glare(const images *seen, char *text) {
    const double lamp = mean_of(seen->of, (window){122, 158, 64, 102}),
                 none = mean_of(seen->of, (window){66, 102, 64, 102});
    snprintf(text, TEXT, "the lamp adds %.0f %% to the chart", 100 * (lamp / none - 1));
}

/* The panels that face the camera. */
static void say_tape(const images *seen, char *text) {
    const double tape = mean_of(seen->of, (window){24, 72, 26, 84}),
                 paint = mean_of(seen->of, (window){24, 72, 116, 174});
    snprintf(text, TEXT, "the tape has %.2f times the paint", tape / paint);
}

/* Deviation over mean in the middle of the picture, that of the render taken off. */
static void say_evenness(const images *seen, char *text) {
    const mcv_image *image = seen->of;
    double n = 0, sum = 0, squares = 0, errors = 0;
    for (uint32_t row = image->height / 8; row < image->height - image->height / 8; ++row)
        for (uint32_t column = image->width / 8; column < image->width - image->width / 8;
             ++column) {
            const double v = value(image, column, row), e = value(&seen->error, column, row);
            n += 1;
            sum += v;
            squares += v * v;
            errors += e * e;
        }
    const double mean = sum / n;
    snprintf(text, TEXT, "uneven by %.0f %%",
             100 * sqrt(fmax(squares / n - mean * mean - errors / n, 0)) / mean);
}

/* The modulation of the bars on the bottle, in rows and columns that show them in both pictures. */
static void say_bars(const images *seen, char *text) {
    double least = INFINITY, most = 0;
    for (uint32_t row = 92; row < 112; ++row) {
        const double light = mean_of(seen->of, (window){126, 142, row, row + 1});
        least = fmin(least, light);
        most = fmax(most, light);
    }
    snprintf(text, TEXT, "the bars have a contrast of %.0f %%",
             100 * (most - least) / (most + least));
}

/* The slope of the dent in scenes/deflectometry.py is largest 2 mm from its middle. The camera sees
 * x from 25° aside. */
static region about_dent(double x, double y) {
    const double off = hypot(x / cos(25 * 3.14159265358979 / 180) - 0.004, y - 0.003);
    return off > 1.5e-3 && off < 2.5e-3 ? REGION_DEFECT
           : off > 8e-3                 ? REGION_SURROUNDINGS
                                        : REGION_NONE;
}

/* Pixels are 0.15 mm of the mirror. */
static void say_dent(const images *seen, char *text) {
    const mcv_image *image = seen->of;
    double n[3] = {0}, sum[3] = {0}, squares[3] = {0};
    for (uint32_t row = 0; row < image->height; ++row)
        for (uint32_t column = 0; column < image->width; ++column) {
            const double v = value(image, column, row);
            const region r = about_dent((column + 0.5 - 0.5 * image->width) * 0.15e-3,
                                        (0.5 * image->height - row - 0.5) * 0.15e-3);
            n[r] += 1;
            sum[r] += v;
            squares[r] += v * v;
        }
    const double around = sum[REGION_SURROUNDINGS] / n[REGION_SURROUNDINGS];
    snprintf(text, TEXT, "contrast to deviation %.1f",
             fabs(sum[REGION_DEFECT] / n[REGION_DEFECT] - around) /
                 sqrt(squares[REGION_SURROUNDINGS] / n[REGION_SURROUNDINGS] - around * around));
}

/* The dent of scenes/deflectometry.py's window turns light most at 1 mm from its middle. Pixels see
 * 0.125 mm. */
static region about_schlieren(double x, double y) {
    const double off = hypot(x, y);
    return off > 0.6e-3 && off < 1.4e-3 ? REGION_DEFECT
           : off > 3.5e-3               ? REGION_SURROUNDINGS
                                        : REGION_NONE;
}

static void say_schlieren(const images *seen, char *text) {
    snprintf(text, TEXT, "contrast to noise %.1f",
             contrast_to_noise(seen, 0.125e-3, about_schlieren));
}

/* The line of scenes/laser-head.gltf on plastic (columns 10 to 150) and on steel (175 to 270). */
enum { PLASTIC_BEGIN = 10, PLASTIC_END = 150, STEEL_BEGIN = 175, STEEL_END = 270 };

static uint32_t brightest_row(const mcv_image *image, uint32_t column) {
    uint32_t best = 0;
    for (uint32_t row = 0; row < image->height; ++row)
        if (value(image, column, row) > value(image, column, best)) best = row;
    return best;
}

static double mean_of_peaks(const mcv_image *image, uint32_t begin, uint32_t end) {
    double sum = 0;
    for (uint32_t column = begin; column < end; ++column)
        sum += value(image, column, brightest_row(image, column));
    return sum / (end - begin);
}

static void say_glare_of_steel(const images *seen, char *text) {
    snprintf(text, TEXT, "steel is %.2g times as bright as plastic",
             mean_of_peaks(seen->of, STEEL_BEGIN, STEEL_END) /
                 mean_of_peaks(seen->of, PLASTIC_BEGIN, PLASTIC_END));
}

/* The standard deviation of the centres of gravity, 10 rows to each side of the brightest one. */
static void say_scatter(const images *seen, char *text) {
    double sum = 0, squares = 0, n = PLASTIC_END - PLASTIC_BEGIN;
    for (uint32_t column = PLASTIC_BEGIN; column < PLASTIC_END; ++column) {
        const uint32_t peak = brightest_row(seen->of, column);
        double light = 0, moment = 0;
        for (uint32_t row = peak < 10 ? 0 : peak - 10; row < peak + 11 && row < seen->of->height;
             ++row) {
            light += value(seen->of, column, row);
            moment += value(seen->of, column, row) * row;
        }
        sum += moment / light;
        squares += moment / light * (moment / light);
    }
    snprintf(text, TEXT, "the line's centre scatters by %.2f px",
             sqrt(squares / n - sum / n * (sum / n)));
}

#define DIRECT " --set nodes/laser/elevation=90deg --set nodes/camera/elevation=60deg"
#define LASER_HEAD "render scenes/laser-head.gltf --spp 64 --light-paths off"
#define SPECKLE " | --wavelength 660nm --expose-to 0.3 --noise-free"

/* --- the gallery --- */

typedef struct panel {
    const char *caption;
    const char *arguments; /* of mcvisi, without -o; behind " | " the options of `mcvisi camera
                              --speckle` with which the picture is read */
    const char
        *each; /* the --set that tells its images apart, without the number; NULL: one image */
} panel;

typedef struct entry {
    const char *name, *title, *text;
    panel panels[MAX_PANELS];
    void (*say)(const images *seen, char *text);
} entry;

static const entry entries[] = {
    {"bolts",
     "Entocentric and telecentric",
     "Two equal bolts, one 20 mm nearer. An entocentric lens shows the nearer one larger, "
     "a telecentric lens shows both at the same size. The numbers are widths of the plain "
     "shank.",
     {{"wrong: entocentric lens", "render scenes/bolts.gltf --sensor entocentric --spp 64", NULL},
      {"right: telecentric lens", "render scenes/bolts.gltf --sensor telecentric --spp 64", NULL}},
     say_widths},
    {"conveyor",
     "A TDI sensor and its belt",
     "A bottle passes a line-scan camera with 64 TDI stages. Its charges travel by a row per "
     "line time. When the bottle travels 6 % farther, bars of half a millimetre are gone.",
     {{"wrong: 0.265 mm per line",
       "render scenes/conveyor.gltf --set sensors/camera/stages=64 --set "
       "sensors/camera/lineTime=530e-6 "
       "--spp 128",
       NULL},
      {"right: 0.25 mm per line, a pixel",
       "render scenes/conveyor.gltf --set sensors/camera/stages=64 --spp 128", NULL}},
     say_bars},
    {"laser-geometry",
     "Direct and look-away geometry of a laser head",
     "A laser line on white plastic, left, and on a wedge of steel that slopes by 15° towards the "
     "camera. With the laser upright the wedge mirrors its light into the camera. With laser and "
     "camera on the same side, 15° and 45° aside, it does not: one exposure fits both.",
     {{"wrong: direct", LASER_HEAD DIRECT, NULL}, {"right: look-away", LASER_HEAD, NULL}},
     say_glare_of_steel},
    {"laser-aperture",
     "Speckle with a narrow and a wide aperture",
     "The grains of a laser's speckle are as large as the lens's diffraction makes them: a wide "
     "aperture has small ones, of which a pixel's light averages more. The centre of the line is "
     "known better. Both take the light as polarised.",
     {{"wrong: f/22", LASER_HEAD " --set sensors/camera/fNumber=22" SPECKLE, NULL},
      {"right: f/8", LASER_HEAD SPECKLE, NULL}},
     say_scatter},
    {"laser-material",
     "Speckle on steel and on plastic",
     "Bare steel keeps the light's polarisation, and its speckle has the contrast 1. Plastic "
     "scatters within and makes two independent patterns: 0.71. Here the plate is of either.",
     {{"steel",
       LASER_HEAD " --set meshes/plate/primitives/0/material=1 | --wavelength 660nm --expose-to 2 "
                  "--noise-free",
       NULL},
      {"plastic", LASER_HEAD SPECKLE " --speckle-polarization 0", NULL}},
     say_scatter},
    {"light-field",
     "A light field display before a light field camera",
     "The display shows a disk at another position in each direction. Focused on the "
     "display, each pixel of the camera sees one pixel of the display. Focused 107 mm "
     "behind it, a macro pixel mixes neighbours.",
     {{"wrong: focused behind the display",
       "render scenes/light-field.gltf --set sensors/camera/imageDistance=57mm --spp 32", NULL},
      {"right: focused on the display", "render scenes/light-field.gltf --spp 32", NULL}},
     say_display},
    {"structured-light",
     "Position of a projector",
     "A step 4 mm high under the first of four phase-shifted patterns. The shift of the "
     "stripes grows with the tangent of the angle between projector and camera. The "
     "numbers are computed from the phase of all four patterns.",
     {{"wrong: 2° beside the camera",
       "render scenes/structured-light.gltf --set nodes/projector/azimuth=-2deg --spp 32",
       "emitters/projector/index"},
      {"right: 30° beside it", "render scenes/structured-light.gltf --spp 32",
       "emitters/projector/index"}},
     say_shift},
    {"scratch",
     "Bright field and dark field",
     "A scratch 100 µm wide in stained steel. Light from the direction of the camera "
     "shows stains and scratch. Light from a low ring shows the scratch alone.",
     {{"wrong: bright field (coaxial light)",
       "render scenes/scratch.gltf --set emitters/ring/radiance=0 --spp 1024", NULL},
      {"right: dark field (low ring)",
       "render scenes/scratch.gltf --set emitters/coaxial/radiance=0 --spp 256", NULL}},
     say_scratch},
    {"engraved",
     "Ring, dome and coaxial light",
     "Engraved steel, ground and not quite even. A ring light makes glare where the "
     "surface reflects it. A dome lights the letters as evenly as the rest. Coaxial light "
     "is reflected by the flat surface and lost in the milled letters.",
     {{"wrong: ring light", "render scenes/engraved-ring.gltf --spp 256", NULL},
      {"better: dome light", "render scenes/engraved-dome.gltf --spp 256", NULL},
      {"right: coaxial light", "render scenes/engraved-coaxial.gltf --spp 2048", NULL}},
     say_letters},
    {"caustic",
     "A caustic on paper",
     "A glass ball under a lamp of the same power. The more parallel the light, the "
     "sharper the focus of the ball. Camera paths would not find the lamp behind the "
     "ball: light paths do.",
     {{"wrong: a wide cone, 16°",
       "render scenes/caustic.gltf --set emitters/lamp/halfAngle=8deg --spp 256", NULL},
      {"right: a narrow one, 0.5°", "render scenes/caustic.gltf --spp 256", NULL}},
     say_peak},
    {"loupe",
     "A single lens and an achromat",
     "Bars on a light table through two loupes of 100 mm: a single lens of N-SF11, and a "
     "cemented doublet of N-BK7 and SF5. Both have exact surfaces and catalogue glass. "
     "The numbers are for the bar at the right.",
     {{"wrong: a single lens of flint", "render scenes/loupe.gltf --sensor singlet --spp 256",
       NULL},
      {"right: an achromat", "render scenes/loupe.gltf --sensor achromat --spp 256", NULL}},
     say_fringe},
    {"prism",
     "Dispersion by a prism",
     "A white beam falls through a prism of N-SF11 onto a screen 150 mm behind it. Light "
     "paths draw a line for each of the scene's wavelengths, as wide as the beam.",
     {{"wrong: a beam of 8 mm",
       "render scenes/prism.gltf --set emitters/beam/size=[0.008,0.008] --spp 64", NULL},
      {"right: a slit of 0.5 mm", "render scenes/prism.gltf --spp 64", NULL}},
     say_purity},
    {"immersion",
     "Immersion in a fluid of equal index",
     "A glass rod with a bubble of 0.6 mm in a cuvette before a backlight. In water the "
     "rod is a lens that hides the bubble. In a fluid with the index of the glass only "
     "the bubble is visible.",
     {{"wrong: in water", "render scenes/immersion.gltf --set materials/fluid/ior=1.333 --spp 128",
       NULL},
      {"right: in fluid of n = 1.5168", "render scenes/immersion.gltf --spp 128", NULL}},
     say_bubble},
    {"window",
     "A coated window",
     "A chart behind a window that reflects a lamp. A coating with a reflectance of 0.4 % "
     "removes nine tenths of the glare.",
     {{"wrong: bare glass", "render scenes/window.gltf --set materials/pane/coating=0 --spp 512",
       NULL},
      {"right: coated", "render scenes/window.gltf --spp 512", NULL}},
     say_glare},
    {"tape",
     "Light for a retroreflector",
     "Retroreflecting tape above, white paint below, turned by 0, 20, 40 and 60°. Tape "
     "sends light back to its source. It is dark under a lamp at the side, and bright "
     "under light from a half mirror before the camera.",
     {{"wrong: a lamp at the side",
       "render scenes/tape.gltf --set emitters/coaxial/radiance=0 --set emitters/lamp/radiance=20 "
       "--spp "
       "256",
       NULL},
      {"right: coaxial light", "render scenes/tape.gltf --spp 256", NULL}},
     say_tape},
    {"diffuser",
     "Lamps behind a plate",
     "Sixteen lamps in a white box behind a plate: a clear plate, and an opal one, which "
     "transmits 60 % diffusely.",
     {{"wrong: a clear plate",
       "render scenes/diffuser.gltf --set "
       "materials/plate/extensions/MCVISI_materials={\"type\":\"sheet\"} --spp 256",
       NULL},
      {"right: an opal plate", "render scenes/diffuser.gltf --spp 256", NULL}},
     say_evenness},
    {"brushed",
     "Turned metal under a lamp and in a tent",
     "Turned discs of aluminium, copper and gold on brushed steel. A lamp makes a streak "
     "across the grooves, which turns with them. Light from all sides shows the metals' "
     "colours.",
     {{"wrong: a small lamp", "render scenes/brushed.gltf --spp 128", NULL},
      {"right: light from all around",
       "render scenes/brushed.gltf --set emitters/lamp/radiance=0 --set emitters/sky/radiance=1 "
       "--spp 128",
       NULL}},
     say_evenness},
    {"deflectometry",
     "A dent of a micrometre",
     "A mirror with a dent 1 µm deep and 8 mm wide, in which a camera sees fringes on a screen. "
     "They hide it. Deflectometry decodes them: bright is a large slope. The numbers are the "
     "dent's contrast over the deviation of its surroundings.",
     {{"wrong: the camera's picture", "render scenes/dented-mirror.gltf --spp 64", NULL},
      {"right: the slopes",
       "deflectometry scenes/dented-mirror.gltf --plane table --remove-form plane --spp 64", NULL}},
     say_dent},
    {"schlieren",
     "A dent in a window by the directions of a display",
     "A window with a dent 4 µm deep and 4 mm wide before a display. Where all directions are lit, "
     "what the dent turns aside is replaced. Where only those are lit that the camera accepts "
     "through a flawless window, the dent is dark.",
     {{"wrong: all directions",
       "render scenes/schlieren.gltf --set emitters/display/image=white --spp 256", NULL},
      {"right: those of a flawless window", "render scenes/schlieren.gltf --spp 256", NULL}},
     say_schlieren},
};
enum { ENTRIES = sizeof entries / sizeof entries[0] };

static int count_panels(const entry *e) {
    int count = 0;
    while (count < MAX_PANELS && e->panels[count].caption) ++count;
    return count;
}

static int count_images(const panel *p) { return p->each ? MAX_IMAGES : 1; }

static void list(void) {
    for (int i = 0; i < ENTRIES; ++i)
        for (int k = 0; k < count_panels(entries + i); ++k) {
            const panel *p = entries[i].panels + k;
            for (int n = 0; n < count_images(p); ++n) {
                printf("%s-%d-%d %s", entries[i].name, k, n, p->arguments);
                if (p->each) printf(" --set %s=%d", p->each, n);
                putchar('\n');
            }
        }
}

/* The mean of its channels. */
static mcv_result grey_of(const mcv_image *image, mcv_image *grey, mcv_error *error) {
    const size_t pixels = (size_t)image->width * image->height;
    MCV_TRY(mcv_image_new(grey, image->width, image->height, 1, error));
    for (size_t i = 0; i < pixels; ++i) {
        double sum = 0;
        for (uint32_t c = 0; c < image->channels; ++c) sum += image->pixels[c * pixels + i];
        grey->pixels[i] = (float)(sum / image->channels);
    }
    return MCV_OK;
}

/* Of what deflectometry writes: the slopes. */
static bool shows_slopes(const panel *p) {
    return strncmp(p->arguments, "deflectometry ", strlen("deflectometry ")) == 0;
}

/* The sizes of the slopes in STEM.exr take the heights' place, and are drawn as STEM.png. */
static mcv_result read_slopes(const char *path, mcv_image *image, mcv_error *error) {
    mcv_exr exr;
    char picture[4096];
    const size_t plane = (size_t)image->width * image->height;
    mcv_preview preview = {.white = 0};
    MCV_TRY(mcv_exr_read(path, &exr, error));
    const float *slopes = NULL;
    for (uint32_t i = 0; i < exr.part_count; ++i)
        if (strcmp(exr.parts[i].name, "slope") == 0) slopes = exr.parts[i].image.pixels;
    const mcv_result result =
        slopes ? MCV_OK : mcv_fail(error, MCV_BAD_INPUT, "%s: has no slopes", path);
    for (size_t i = 0; i < plane && slopes; ++i)
        image->pixels[i] = hypotf(slopes[i], slopes[plane + i]);
    mcv_exr_free(&exr);
    snprintf(picture, sizeof picture, "%.*s.png", (int)(strlen(path) - strlen(".exr")), path);
    return result == MCV_OK ? mcv_png_write_preview(picture, image, "rad", &preview, error)
                            : result;
}

static mcv_result read_image(const char *path, mcv_image *image, mcv_image *coloured,
                             mcv_image *error_image, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_exr_read(path, &exr, error));
    mcv_result result = grey_of(&exr.parts[0].image, image, error);
    if (result == MCV_OK && error_image)
        result = exr.part_count > 1
                     ? grey_of(&exr.parts[1].image, error_image, error)
                     : mcv_fail(error, MCV_BAD_INPUT, "%s: has no standard errors", path);
    if (result == MCV_OK && coloured) {
        *coloured = exr.parts[0].image;
        exr.parts[0].image.pixels = NULL;
    }
    mcv_exr_free(&exr);
    return result;
}

/* The size of the image that a panel's arguments ask for: SCENE and perhaps --sensor NAME, or the
 * first. */
static mcv_result size_of(const panel *p, uint32_t *width, uint32_t *height, mcv_error *error) {
    char path[256], name[256] = "";
    mcv_scene *scene;
    const char *option = strstr(p->arguments, "--sensor ");
    sscanf(p->arguments, "%*s %255s", path);
    if (option) sscanf(option, "--sensor %255s", name);
    MCV_TRY(mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, error));
    uint32_t sensor = 0;
    while (name[0] && sensor < scene->sensor_count &&
           strcmp(scene->sensors[sensor].name, name) != 0)
        ++sensor;
    const bool there = sensor < scene->sensor_count;
    if (there) mcv_sensor_film_size(&scene->sensors[sensor], width, height);
    mcv_scene_free(scene);
    return there ? MCV_OK : mcv_fail(error, MCV_BAD_INPUT, "%s: has no sensor \"%s\"", path, name);
}

static mcv_result say_number(const entry *e, int number, const char *renders, char *text,
                             mcv_error *error) {
    images seen = {0};
    uint32_t width = 0, height = 0;
    mcv_result result = size_of(e->panels + number, &width, &height, error);
    for (int n = 0; n < count_images(e->panels + number) && result == MCV_OK; ++n) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s-%d-%d.exr", renders, e->name, number, n);
        result = read_image(path, seen.of + n, n == 0 ? &seen.coloured : NULL,
                            n == 0 ? &seen.error : NULL, error);
        const mcv_image *image = seen.of + n;
        if (result == MCV_OK && (image->width != width || image->height != height ||
                                 seen.error.width != width || seen.error.height != height))
            result = mcv_fail(
                error, MCV_BAD_INPUT, "%s: is of %u x %u pixels, not of the %u x %u of `mcvisi %s`",
                path, image->width, image->height, width, height, e->panels[number].arguments);
    }
    if (result == MCV_OK && shows_slopes(e->panels + number)) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s-%d-0.exr", renders, e->name, number);
        result = read_slopes(path, seen.of, error);
    }
    if (result == MCV_OK) e->say(&seen, text);
    for (int n = 0; n < MAX_IMAGES; ++n) mcv_image_free(seen.of + n);
    mcv_image_free(&seen.error);
    mcv_image_free(&seen.coloured);
    return result;
}

enum { WIDTH = 224, HEIGHT = 168, MARGIN = 8, LINES = 40, LETTERS = 11 };

static mcv_result draw_panel(cairo_t *page, int x, const entry *e, int number, const char *renders,
                             const char *text, mcv_error *error) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s-%d-0.png", renders, e->name, number);
    cairo_surface_t *picture = cairo_image_surface_create_from_png(path);
    const cairo_status_t status = cairo_surface_status(picture);
    cairo_save(page);
    cairo_translate(page, x, MARGIN);
    cairo_scale(page, (double)WIDTH / cairo_image_surface_get_width(picture),
                (double)HEIGHT / cairo_image_surface_get_height(picture));
    cairo_set_source_surface(page, picture, 0, 0);
    cairo_pattern_set_filter(cairo_get_source(page), cairo_image_surface_get_width(picture) < WIDTH
                                                         ? CAIRO_FILTER_NEAREST
                                                         : CAIRO_FILTER_GOOD);
    cairo_paint(page);
    cairo_restore(page);
    cairo_surface_destroy(picture);
    mcv_page_text(page, x + WIDTH / 2.0, MARGIN + HEIGHT + 16, 0.5, e->panels[number].caption);
    mcv_page_text(page, x + WIDTH / 2.0, MARGIN + HEIGHT + 31, 0.5, text);
    return status == CAIRO_STATUS_SUCCESS
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%s: cairo: %s", path, cairo_status_to_string(status));
}

/* Grey where the page is, which takes less room than cairo's PNG. Frees the page. */
static mcv_result write_page(cairo_t *page, const char *path, mcv_error *error) {
    cairo_surface_t *surface = cairo_get_target(page);
    cairo_surface_flush(surface);
    const uint32_t width = (uint32_t)cairo_image_surface_get_width(surface),
                   height = (uint32_t)cairo_image_surface_get_height(surface);
    const size_t pixels = (size_t)width * height,
                 stride = (size_t)cairo_image_surface_get_stride(surface);
    const unsigned char *data = cairo_image_surface_get_data(surface);
    mcv_image image;
    mcv_result result = mcv_image_new(&image, width, height, 3, error);
    bool grey = true;
    for (size_t i = 0; i < pixels && result == MCV_OK; ++i) {
        uint32_t rgb;
        memcpy(&rgb, data + i / width * stride + 4 * (i % width), sizeof rgb);
        for (int k = 0; k < 3; ++k)
            image.pixels[(size_t)k * pixels + i] = (float)(rgb >> (16 - 8 * k) & 255);
        grey = grey && (rgb >> 16 & 255) == (rgb >> 8 & 255) && (rgb & 255) == (rgb >> 8 & 255);
    }
    if (grey) image.channels = 1;
    if (result == MCV_OK) result = mcv_png_write_values(path, &image, 8, error);
    mcv_image_free(&image);
    cairo_destroy(page);
    return result;
}

/* Nothing is drawn before everything that it takes is there. */
static mcv_result check_renders(const entry *e, const char *renders, mcv_error *error) {
    for (int k = 0; k < count_panels(e); ++k)
        for (int n = 0; n < count_images(e->panels + k); ++n)
            for (int picture = 0; picture < (n == 0 ? 2 : 1); ++picture) {
                char path[4096];
                snprintf(path, sizeof path, "%s/%s-%d-%d.%s", renders, e->name, k, n,
                         picture ? "png" : "exr");
                if (access(path, R_OK) != 0)
                    return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, strerror(errno));
            }
    return MCV_OK;
}

static mcv_result draw(const entry *e, const char *renders, const char *pictures,
                       mcv_error *error) {
    const int panels = count_panels(e);
    char texts[MAX_PANELS][TEXT], path[4096];
    cairo_t *page;
    for (int k = 0; k < panels; ++k) MCV_TRY(say_number(e, k, renders, texts[k], error));
    MCV_TRY(mcv_page_new(&page, (uint32_t)(MARGIN + panels * (WIDTH + MARGIN)),
                         HEIGHT + MARGIN + LINES, LETTERS, error));
    mcv_result result = MCV_OK;
    for (int k = 0; k < panels && result == MCV_OK; ++k)
        result = draw_panel(page, MARGIN + k * (WIDTH + MARGIN), e, k, renders, texts[k], error);
    snprintf(path, sizeof path, "%s/%s.png", pictures, e->name);
    if (result == MCV_OK)
        MCV_TRY(write_page(page, path, error));
    else
        cairo_destroy(page);
    printf("\n### %s\n\n%s\n\n![%s](../%s)\n\n", e->title, e->text, e->title, path);
    for (int k = 0; k < panels; ++k) {
        const panel *p = e->panels + k;
        const char *camera = strstr(p->arguments, " | ");
        printf("- %s: %s (`mcvisi %.*s`)%s\n", p->caption, texts[k],
               (int)(camera ? camera - p->arguments : (long)strlen(p->arguments)), p->arguments,
               camera ? "." : "");
        if (camera)
            printf(
                "  Its speckle: the same with `--lasers 4 --spp 8`, and `mcvisi camera --speckle "
                "%s`.\n",
                camera + strlen(" | "));
    }
    return result;
}

int main(int argc, char **argv) {
    mcv_error error = {""};
    mcv_result result = MCV_OK;
    if (argc == 2 && strcmp(argv[1], "list") == 0) {
        list();
        return MCV_OK;
    }
    if (argc != 4 || strcmp(argv[1], "draw") != 0) {
        fputs("gallery list\ngallery draw RENDERS PICTURES\n", stderr);
        return MCV_USAGE;
    }
    for (int i = 0; i < ENTRIES && result == MCV_OK; ++i)
        result = check_renders(entries + i, argv[2], &error);
    for (int i = 0; i < ENTRIES && result == MCV_OK; ++i)
        result = draw(entries + i, argv[2], argv[3], &error);
    if (result != MCV_OK) fprintf(stderr, "gallery: %s\n", error.text);
    return (int)result;
}
