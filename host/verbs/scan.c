/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/scan.h"

#include "analysis/speckle.h"
#include "io/exr_make.h"
#include "scene/laser.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "verbs/grey_picture.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const mcv_scan_run mcv_scan_runs[MCV_SCAN_RUNS] = {
    [MCV_SCAN_ALL] =
        {.noise = true, .speckle = true, .bits = true, .calibrated = true, .undistorted = true},
    [MCV_SCAN_NOISE] = {.noise = true},
    [MCV_SCAN_SPECKLE] = {.speckle = true},
    [MCV_SCAN_BITS] = {.bits = true},
    [MCV_SCAN_CALIBRATED] = {.calibrated = true},
    [MCV_SCAN_UNDISTORTED] = {.undistorted = true},
    [MCV_SCAN_AGAIN] = {.again = true},
    [MCV_SCAN_DIRECT] = {.direct = true},
    [MCV_SCAN_STRAIGHT] = {.straight = true},
    [MCV_SCAN_IDEAL] = {.again = true, .direct = true, .straight = true},
};

bool mcv_scan_needs(const mcv_scan *s, int run) {
    const mcv_scan_run *r = mcv_scan_runs + run;
    if (run == MCV_SCAN_ALL) return true;
    return s->budget && !(r->speckle && s->command.scan_speckle) &&
           !(r->calibrated && !s->command.calibration) &&
           !(r->undistorted && !s->command.distortion_known) &&
           !(r->straight && !r->direct && s->straight);
}

/* --- the head --- */

static mcv_result check_options(const mcv_command *c, mcv_error *error) {
    if (c->profile_count > 1 && c->feed[0] == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--feed is missing, or 0: say how far the part moves between the %llu "
                        "profiles, as in --feed 0.1mm",
                        (unsigned long long)c->profile_count);
    if (c->profile_count == 1 && c->feed[0] != 0)
        return mcv_fail(error, MCV_USAGE,
                        "--feed is from profile to profile: give their number by --profiles N");
    return MCV_OK;
}

/* --pose D,A. */
static mcv_result read_pose(const mcv_command *c, double pose[2], mcv_error *error) {
    const char *comma = c->pose ? strchr(c->pose, ',') : NULL;
    char length[64];
    const size_t size = comma ? (size_t)(comma - c->pose) : 0;
    if (!c->pose) return MCV_OK;
    if (!c->budget)
        return mcv_fail(error, MCV_USAGE, "--pose is a cause of the budget: give --budget, too");
    memcpy(length, c->pose, size < sizeof length ? size : 0);
    length[size < sizeof length ? size : 0] = '\0';
    if (comma && mcv_parse_quantity(length, MCV_PARAM_length, pose) &&
        mcv_parse_quantity(comma + 1, MCV_PARAM_angle, pose + 1) && pose[0] >= 0 && pose[1] >= 0)
        return MCV_OK;
    return mcv_fail(error, MCV_USAGE,
                    "--pose %s: must be D,A, standard uncertainties of a length and of an angle, "
                    "as in 10um,0.005deg",
                    c->pose);
}

/* The wavelength of the laser's light. */
static mcv_result read_light(const mcv_scene *scene, mcv_scan *s, mcv_error *error) {
    double wavelength, linewidth;
    if (!mcv_scene_is_laser_lit(scene, &wavelength, &linewidth))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: a scan is of lasers of one wavelength alone: switch off other lamps, "
                        "as by --set emitters/NAME/radiance=0, or give single images to `mcvisi "
                        "triangulate`",
                        scene->path);
    for (int c = 0; c < 3; ++c) s->camera.wavelength[c] = wavelength;
    s->straight = true;
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        if (scene->emitters[i].type == MCV_EMITTER_LASER)
            s->straight = s->straight && scene->emitters[i].as.laser.straightness == 0;
    return MCV_OK;
}

/* The nodes, and how many sub-pixels the grains need. */
static mcv_result read_head(const mcv_scene *scene, uint32_t sensor, mcv_scan *s,
                            mcv_error *error) {
    const mcv_placement *node;
    mcv_error why = {""};
    MCV_TRY(mcv_camera_model_of(scene, scene->sensors + sensor, &s->model, error));
    mcv_result result = mcv_camera_model_check_places(&s->model, "scan", &why);
    if (result == MCV_OK)
        result = mcv_camera_model_node(&s->model, s->command.laser, "--laser", &node, &why);
    if (result != MCV_OK) return mcv_fail(error, result, "%s: %s", scene->path, why.text);
    if (!mcv_transform_rigid(&node->to_world, &s->laser))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: --laser %s has no axes: its scale is 0",
                        scene->path, s->command.laser);
    s->subpixels = 1;
    if (s->command.scan_speckle) return MCV_OK;
    if (!(s->model.f_number > 0))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: sensor %s has no stop, which makes the grains of speckle: use a "
                        "thinLens or telecentric sensor, or --speckle off",
                        scene->path, scene->sensors[sensor].name);
    s->subpixels = mcv_speckle_subpixels(fmax(s->model.pixel[0], s->model.pixel[1]),
                                         s->camera.wavelength[0], s->model.f_number);
    return MCV_OK;
}

/*
 * The way of the image during an exposure, over the first zero of the grains' covariance, and one:
 * so many patterns follow on one another. The place is that of the light in the film's middle.
 */
static mcv_result read_motion(mcv_scan *s, mcv_error *error) {
    const mcv_command *c = &s->command;
    const double middle[2] = {s->model.size[0] / 2.0, s->model.size[1] / 2.0};
    double world[3], from[2], to[2];
    s->motion = 1;
    if (!(c->profile_rate > 0)) return MCV_OK;
    if (c->feed[0] == 0 || !(c->exposure_time > 0))
        return mcv_fail(error, MCV_USAGE,
                        "--profile-rate needs --feed and --exposure-time: they tell how far the "
                        "part moves during an exposure");
    if (!(c->exposure_time * c->profile_rate <= 1))
        return mcv_fail(error, MCV_USAGE,
                        "--profile-rate %g: --exposure-time %g s is longer than the time from "
                        "profile to profile, %g s",
                        c->profile_rate, c->exposure_time, 1 / c->profile_rate);
    const double way = c->feed[0] * c->profile_rate * c->exposure_time;
    if (c->scan_speckle || !mcv_triangulate(&s->model, &s->laser, middle, world) ||
        !mcv_camera_model_project(&s->model, world, from))
        return MCV_OK;
    for (int k = 0; k < 3; ++k) world[k] += way * s->laser.m[3 * k + 1];
    if (!mcv_camera_model_project(&s->model, world, to)) return MCV_OK;
    s->motion +=
        hypot((to[0] - from[0]) * s->model.pixel[0], (to[1] - from[1]) * s->model.pixel[1]) /
        (1.22 * s->camera.wavelength[0] * s->model.f_number);
    s->camera.speckle_patterns *= s->motion;
    return MCV_OK;
}

mcv_result mcv_scan_begin(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                          mcv_scan *s, mcv_error *error) {
    *s = (mcv_scan){.command = *command,
                    .camera = mcv_camera_settings_of(command),
                    .name = scene->path,
                    .axis = command->line_across ? 0 : 1,
                    .budget = command->budget};
    MCV_TRY(check_options(command, error));
    MCV_TRY(read_pose(command, s->pose, error));
    MCV_TRY(read_light(scene, s, error));
    MCV_TRY(mcv_filter_read(command, s, &s->filter, error));
    MCV_TRY(mcv_camera_check_settings(&s->camera, error));
    if (!command->laser) s->command.laser = "laser";
    /* The images state their noise themselves. */
    s->command.gain = s->command.read_noise = 0;
    for (int run = 0; run < MCV_SCAN_RUNS; ++run) {
        MCV_TRY(mcv_profiles_begin(&s->command, (mcv_texts){NULL, 0}, s->profiles + run, error));
        mcv_profiles *p = s->profiles + run;
        p->count = (uint32_t)command->profile_count;
        p->calibrated = p->calibrated && mcv_scan_runs[run].calibrated;
        p->undistorted = p->undistorted && mcv_scan_runs[run].undistorted;
    }
    MCV_TRY(read_head(scene, sensor, s, error));
    return read_motion(s, error);
}

void mcv_scan_free(mcv_scan *s) {
    for (int run = 0; run < MCV_SCAN_RUNS; ++run) mcv_profiles_free(s->profiles + run);
    mcv_camera_model_free(&s->model);
}

/* --- light --- */

mcv_result mcv_film_bin(const mcv_film *fine, uint32_t q, mcv_film *binned, mcv_error *error) {
    const uint32_t width = fine->width / q, height = fine->height / q;
    MCV_TRY(mcv_film_new(binned, width, height, fine->channels, fine->replicates, error));
    binned->samples = fine->samples * q * q;
    for (size_t plane = 0; plane < (size_t)fine->replicates * fine->channels; ++plane)
        for (size_t row = 0; row < (size_t)height * q; ++row) {
            const double *from = fine->sums + (plane * fine->height + row) * fine->width;
            double *to = binned->sums + (plane * height + row / q) * width;
            for (size_t column = 0; column < (size_t)width * q; ++column)
                to[column / q] += from[column];
        }
    return MCV_OK;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median of what is above 0. */
static double median_lit(const double *light, uint32_t count, double *sorted) {
    uint32_t lit = 0;
    for (uint32_t i = 0; i < count; ++i)
        if (light[i] > 0) sorted[lit++] = light[i];
    qsort(sorted, lit, sizeof *sorted, ascending);
    return lit ? sorted[lit / 2] : 0;
}

/* The light of a pixel, at most that of its brightest neighbour: a single sample of light that has
 * met several mirrors may be far brighter than the line. */
static double light_at(const mcv_film *film, uint32_t column, uint32_t row) {
    const double *at = film->sums + (size_t)row * film->width + column;
    double brightest = 0;
    for (int j = row > 0 ? -1 : 0; j <= (row + 1 < film->height ? 1 : 0); ++j)
        for (int i = column > 0 ? -1 : 0; i <= (column + 1 < film->width ? 1 : 0); ++i)
            if (i || j) brightest = fmax(brightest, at[j * (ptrdiff_t)film->width + i]);
    return fmin(*at, brightest);
}

/* The brightest light of each column and row, by the first channel. */
static void find_peaks(const mcv_film *film, double *columns, double *rows) {
    for (uint32_t row = 0; row < film->height; ++row)
        for (uint32_t column = 0; column < film->width; ++column) {
            const double light = light_at(film, column, row);
            columns[column] = fmax(columns[column], light);
            rows[row] = fmax(rows[row], light);
        }
}

mcv_result mcv_scan_window(const mcv_scan *s, const mcv_film *film, uint32_t window[2],
                           mcv_error *error) {
    /* A third of what belongs to the line: bright grains are thrice as bright as their mean, but
     * for one of twenty. */
    enum { FAINTER = 3, GRAINS = 8 };
    const uint32_t size[2] = {film->width, film->height}, count = size[s->axis],
                   length = size[!s->axis];
    double *peaks = calloc((size_t)count + 2 * length, sizeof *peaks);
    if (!peaks) return mcv_fail(error, MCV_FAILED, "%s: no memory for a scan", s->name);
    double *along = peaks + count;
    find_peaks(film, s->axis ? along : peaks, s->axis ? peaks : along);
    const double least =
        s->command.line_threshold / FAINTER * median_lit(along, length, along + length);
    uint32_t first = count, last = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (!(peaks[i] > least)) continue;
        first = i < first ? i : first;
        last = i;
    }
    free(peaks);
    const double blur = s->model.f_number > 0 ? GRAINS * s->camera.wavelength[0] *
                                                    s->model.f_number / s->model.pixel[s->axis]
                                              : 0;
    const uint32_t margin = (uint32_t)s->command.line_window / 2 + 1 + (uint32_t)ceil(blur);
    if (first > last) first = last = count / 2;
    window[0] = first > margin ? first - margin : 0;
    window[1] = last + 1 + margin < count ? last + 1 + margin : count;
    return MCV_OK;
}

/* --- exposure --- */

static mcv_camera_settings settings_of(const mcv_scan *s, int run, uint32_t profile,
                                       const mcv_exr *laser) {
    const mcv_scan_run *r = mcv_scan_runs + run;
    mcv_camera_settings settings = s->camera;
    settings.camera.seed += profile;
    settings.speckle_exposure = profile; /* several profiles are of a part that moves */
    settings.camera.noise_free = settings.camera.noise_free || !r->noise;
    if (!r->bits) {
        settings.camera.bits = MCV_CAMERA_MAX_BITS;
        settings.camera.gain = 0;
        settings.camera.black_level = 0;
    }
    if (r->speckle && !s->command.scan_speckle) {
        settings.speckle = s->name;
        settings.speckle_light = laser;
    }
    return settings;
}

static mcv_result expose(mcv_scan *s, const mcv_camera_settings *settings, const mcv_exr *light,
                         mcv_exr *grey, mcv_error *error) {
    mcv_exr blurred;
    mcv_read_out out;
    MCV_TRY(mcv_exr_copy(light, &blurred, error)); /* in place */
    const mcv_result result = mcv_grey_expose(settings, s->name, &blurred, &out, grey, error);
    mcv_exr_free(&blurred);
    if (result != MCV_OK || !(s->camera.expose_to > 0)) return result;
    /* All profiles have the exposure of the first. */
    s->camera.expose_to = 0;
    memcpy(s->camera.electrons_per_unit, out.camera.electrons_per_unit,
           sizeof out.camera.electrons_per_unit);
    return result;
}

/* Writes the grey values of a profile, where they are asked for. */
static mcv_result write_raw(const mcv_scan *s, uint32_t profile, const mcv_exr *grey,
                            mcv_error *error) {
    char path[PATH_MAX];
    if (!s->command.raw_images) return MCV_OK;
    const int length = snprintf(path, sizeof path, "%s%04u.exr", s->command.raw_images, profile);
    if (length < 0 || (size_t)length >= sizeof path)
        return mcv_fail(error, MCV_USAGE, "--images: the path of its files is too long");
    return mcv_exr_write(path, grey->parts, grey->part_count, grey->attributes,
                         grey->attribute_count, error);
}

mcv_result mcv_scan_find(mcv_scan *s, int run, uint32_t profile, const mcv_exr *light,
                         const mcv_exr *laser, mcv_profiles *profiles, mcv_error *error) {
    const mcv_camera_settings settings = settings_of(s, run, profile, laser);
    mcv_picture picture = {.path = s->name};
    MCV_TRY(expose(s, &settings, light, &picture.exr, error));
    mcv_result result = mcv_profiles_add(profiles, &picture, error);
    if (result == MCV_OK && run == MCV_SCAN_ALL)
        result = write_raw(s, profile, &picture.exr, error);
    mcv_exr_free(&picture.exr);
    return result;
}

mcv_result mcv_scan_expose(mcv_scan *s, int run, uint32_t profile, const mcv_exr *light,
                           const mcv_exr *laser, uint32_t first, mcv_error *error) {
    mcv_profiles *p = s->profiles + run;
    MCV_TRY(mcv_scan_find(s, run, profile, light, laser, p, error));
    for (uint32_t i = 0; i < p->length; ++i)
        p->points[(size_t)(p->added - 1) * p->length + i].line.place += first;
    return MCV_OK;
}
