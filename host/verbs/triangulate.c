/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/triangulate.h"

#include "analysis/read_speckle.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "io/picture_header.h"
#include "verbs/calibrate.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- options --- */

static mcv_result check_file(const mcv_command *command, const char *path, mcv_texts images,
                             mcv_error *error) {
    static const char *const endings[] = {".csv", ".exr", ".npz", ".npy", ".ply"};
    bool known = false;
    for (size_t i = 0; i < 5; ++i) known = known || mcv_ends_in(path, endings[i]);
    if (!known)
        return mcv_fail(error, MCV_USAGE, "--output %s: must end in .csv, .exr, .npz, .npy or .ply",
                        path);
    if (!command->laser && !mcv_ends_in(path, ".csv"))
        return mcv_fail(error, MCV_USAGE,
                        "--output %s: holds heights: give --laser NODE, or write places into .csv",
                        path);
    for (size_t i = 0; i < images.count; ++i)
        if (mcv_same_file(path, images.items[i]))
            return mcv_fail(error, MCV_USAGE, "%s is one of the images: give another name", path);
    return mcv_output_check(path, error);
}

mcv_result mcv_profiles_begin(const mcv_command *command, mcv_texts images, mcv_profiles *p,
                              mcv_error *error) {
    *p = (mcv_profiles){.command = command, .count = (uint32_t)images.count};
    if (command->line_window % 2 == 0)
        return mcv_fail(error, MCV_USAGE, "--window %d: must be odd, so that it has a middle",
                        (int)command->line_window);
    if (!command->laser && (command->frame || command->feed[0] != 0))
        return mcv_fail(error, MCV_USAGE,
                        "--%s is of heights: give --laser NODE, whose x-z plane is the light",
                        command->frame ? "frame" : "feed");
    for (size_t i = 0; i < command->profiles.count; ++i)
        MCV_TRY(check_file(command, command->profiles.items[i], images, error));
    p->moved = command->feed[0] != 0;
    p->calibrated = command->calibration != NULL;
    p->undistorted = command->distortion_known != 0;
    return mcv_light_plane_begin(command, p, error);
}

/* --- one image --- */

/* What the header says of the laser's light, for speckle. */
static void read_light(const mcv_exr *exr, mcv_aperture_shape *aperture, mcv_mask *mask,
                       mcv_profile_settings *settings) {
    mcv_error ignored;
    const double *contrast = mcv_exr_numbers(exr, MCV_SPECKLE_CONTRAST, 1),
                 *wavelength = mcv_exr_numbers(exr, MCV_LASER_WAVELENGTH, 1);
    if (!contrast || !wavelength || mcv_exr_aperture("", exr, aperture, mask, &ignored) != MCV_OK)
        return;
    if (aperture->shape != MCV_APERTURE_DISC) settings->aperture = aperture;
    settings->contrast = *contrast;
    settings->wavelength = *wavelength;
}

mcv_result mcv_subject_node(const mcv_subject *s, const char *name, const char *option,
                            mcv_transform *rigid, mcv_error *error) {
    const mcv_placement *node;
    mcv_error why = {""};
    if (!s->has_model)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: has no camera model in its header, which tells where the laser is: "
                        "take an image of `mcvisi camera`",
                        s->picture->path);
    mcv_result result = mcv_camera_model_check_places(&s->model, option, &why);
    if (result == MCV_OK) result = mcv_camera_model_node(&s->model, name, option, &node, &why);
    if (result != MCV_OK) return mcv_fail(error, result, "%s: %s", s->picture->path, why.text);
    if (mcv_transform_rigid(&node->to_world, rigid)) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s: %s %s has no axes: its scale is 0", s->picture->path,
                    option, name);
}

/* The node in the axes of another, both without scale. */
static mcv_transform in_axes_of(const mcv_transform *axes, const mcv_transform *node) {
    mcv_transform back = {{0}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            back.m[3 * i + k] = axes->m[3 * k + i];
            back.m[9 + i] -= axes->m[3 * k + i] * axes->m[9 + k];
        }
    return mcv_transform_compose(&back, node);
}

/* But for rounding: an entry sums at most six products of matrices, each of whose entries was
 * itself rounded about as often; `reach` is the largest of their factors. */
static bool are_equal(const mcv_transform *a, const mcv_transform *b, double reach) {
    for (int i = 0; i < 12; ++i)
        if (!(fabs(a->m[i] - b->m[i]) <= 36 * DBL_EPSILON * (i < 9 ? 1 : reach))) return false;
    return true;
}

/* Where laser and frame are in this image. What counts is how they move against each other: a head
 * may pass over a part at rest. */
static mcv_result place_laser(mcv_profiles *p, const mcv_subject *s, mcv_transform *laser,
                              mcv_transform *frame, mcv_error *error) {
    const mcv_command *c = p->command;
    MCV_TRY(mcv_subject_node(s, c->laser, "--laser", laser, error));
    *frame = *laser;
    if (c->frame) MCV_TRY(mcv_subject_node(s, c->frame, "--frame", frame, error));
    const mcv_transform relative = c->frame ? in_axes_of(laser, frame) : mcv_transform_identity();
    double reach = 0;
    for (int k = 9; k < 12; ++k) reach += fabs(laser->m[k]) + fabs(frame->m[k]);
    if (p->added == 0) p->frame = relative;
    const bool stays = are_equal(&relative, &p->frame, reach);
    if (c->feed[0] != 0 && !stays)
        return mcv_fail(error, MCV_USAGE,
                        "--frame %s moves from image to image by itself: leave out --feed",
                        c->frame);
    if (c->feed[0] == 0 && stays && p->added > 0)
        return mcv_fail(error, MCV_USAGE,
                        "%s: nothing tells how far the part has moved from image to image: give "
                        "--feed D, or --frame NODE that moves with it",
                        s->picture->path);
    p->moved = p->moved || !stays;
    return MCV_OK;
}

/* Into the plane of the calibration. */
static mcv_result turn_laser(const mcv_profiles *p, const mcv_subject *s, mcv_transform *laser,
                             mcv_error *error) {
    const mcv_transform node = *laser;
    if (mcv_light_plane_turn(&p->plane, &s->model, &node, laser)) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: lightPlane/normal is the z axis of --laser %s in %s, but the laser shines "
                    "along z within its plane: take the calibration of this camera and laser",
                    p->command->calibration, p->command->laser, s->picture->path);
}

/* The lens has correlated the render's own errors: of what varies slowly across the line, as places
 * do with the values, they have the sum of the correlations in their variance. */
static void correlate(mcv_readings *r) {
    const double more = r->correlation.sum - 1;
    if (!r->render.pixels || !(more > 0)) return;
    for (size_t i = 0; i < (size_t)r->render.width * r->render.height; ++i) {
        const double own = (double)r->render.pixels[i], all = (double)r->deviation.pixels[i];
        r->deviation.pixels[i] = (float)sqrt(all * all + more * own * own);
    }
}

static mcv_result find_profile(mcv_profiles *p, mcv_subject *s, mcv_error *error) {
    const mcv_command *c = p->command;
    const mcv_image *values = &s->readings.values;
    mcv_transform laser, frame;
    mcv_aperture_shape aperture;
    mcv_mask mask;
    if (p->undistorted && s->has_model) mcv_lens_map_forget(&s->model.lens);
    mcv_profile_settings settings = {
        .line = {.extractor = (int)c->extractor, .window = (uint32_t)c->line_window},
        .threshold_share = c->line_threshold,
        .rows = c->line_across != 0,
        .feed = c->feed[0] * p->added};
    if (s->has_model && isfinite(s->model.black_level))
        settings.line.background = s->model.black_level;
    if (!s->picture->values) read_light(&s->picture->exr, &aperture, &mask, &settings);
    if (c->laser) {
        MCV_TRY(place_laser(p, s, &laser, &frame, error));
        if (p->calibrated) MCV_TRY(turn_laser(p, s, &laser, error));
        settings.laser = &laser;
        settings.frame = &frame;
    }
    const uint32_t length = mcv_profile_length(&settings, values);
    if (p->added == 0) {
        p->length = length;
        p->points = calloc((size_t)p->count * length + 1, sizeof *p->points);
        if (!p->points) return mcv_fail(error, MCV_FAILED, "no memory for %u profiles", p->count);
    }
    if (length != p->length)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its profile has %u places, that of the first image %u: all must be "
                        "of one camera",
                        s->picture->path, length, p->length);
    correlate(&s->readings);
    mcv_profile_find(&settings, values, s->noise ? &s->readings.deviation : NULL,
                     s->has_model ? &s->model : NULL, p->points + (size_t)p->added * length);
    p->speckled = settings.contrast > 0 && s->has_model;
    p->noisy = s->noise != NULL;
    ++p->added;
    return c->calibrate ? mcv_light_plane_add(p, s, error) : MCV_OK;
}

mcv_result mcv_profiles_add(mcv_profiles *p, const mcv_picture *picture, mcv_error *error) {
    mcv_subject subject;
    mcv_result result = mcv_subject_read(p->command, picture, &subject, error);
    if (result == MCV_OK) result = find_profile(p, &subject, error);
    mcv_subject_free(&subject);
    return result;
}

/* --- what is told --- */

/* Root of the mean square of a member of the points that have it. */
static double rms_of(const mcv_profiles *p, bool heights) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < (size_t)p->added * p->length; ++i) {
        const double u = heights ? p->points[i].u_z : p->points[i].uncertainty;
        if (isnan(u)) continue;
        sum += u * u;
        ++count;
    }
    return sqrt(sum / count);
}

static void report_heights(const mcv_profiles *p, mcv_report *report) {
    double low = INFINITY, high = -INFINITY;
    uint64_t used;
    for (size_t i = 0; i < (size_t)p->added * p->length; ++i) {
        low = fmin(low, p->points[i].at[2]);
        high = fmax(high, p->points[i].at[2]);
    }
    const double residual =
        mcv_profile_residual(p->points, (size_t)p->added * p->length, p->length, &used);
    if (low <= high) mcv_report_numbers(report, "heights", "m", " … ", (double[]){low, high}, 2);
    mcv_report_number(report, "height_uncertainty", "m", rms_of(p, true));
    mcv_report_number(report, "about_straight_lines", "m", residual);
}

void mcv_profiles_report(const mcv_profiles *p, mcv_report *report) {
    double counts[MCV_LINE_STATE_COUNT] = {0}, sigma = 0, seen = 0;
    for (size_t i = 0; i < (size_t)p->added * p->length; ++i) {
        const mcv_line_place *line = &p->points[i].line;
        ++counts[line->state];
        if (!mcv_line_has_place(line->state)) continue;
        sigma += line->sigma;
        ++seen;
    }
    if (p->noisy && !p->speckled)
        mcv_report_tell(report, "note",
                        "uncertainties are without speckle: `mcvisi camera --speckle` adds it, and "
                        "the header of its OpenEXR file tells it");
    mcv_report_number(report, "profiles", "", p->added);
    mcv_report_number(report, "places", "", p->length);
    for (int i = 0; i < MCV_LINE_STATE_COUNT; ++i)
        mcv_report_number(report, mcv_line_states[i], "", counts[i]);
    mcv_report_number(report, "line_sigma", "pixels", sigma / seen);
    mcv_report_number(report, "place_uncertainty", "pixels", rms_of(p, false));
    if (p->command->laser) report_heights(p, report);
    mcv_light_plane_report(p, report);
}

void mcv_profiles_free(mcv_profiles *p) {
    free(p->points);
    free(p->lit);
}
