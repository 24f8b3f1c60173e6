/* SPDX-License-Identifier: Apache-2.0 */
#include "rig/rig_part.h"

#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Default films: 1.3 megapixels, 6.1 mm x 4.9 mm; the same with 8 x 8 directions; the report's. */
static const struct {
    uint32_t resolution[2], directions;
    double pixel;
} films[MCV_RIG_KIND_COUNT] = {{{1280, 1024}, 1, 4.8e-6},
                               {{1280, 1024}, 1, 4.8e-6},
                               {{160, 128}, 8, 4.8e-6},
                               {{160, 120}, 9, 4e-6},
                               {{1280, 256}, 1, 4.8e-6}};

static const double margin = 1.15; /* field over part */

const char *const mcv_rig_kinds[] = {
#define MCV_X(NAME, word) word,
    MCV_RIG_KINDS(MCV_X)
#undef MCV_X
};
const char *const mcv_rig_lights[] = {
#define MCV_X(NAME, word) word,
    MCV_RIG_LIGHTS(MCV_X)
#undef MCV_X
};

/* --- the view --- */

static mcv_result read_view(const char *text, double direction[3], mcv_error *error) {
    static const char *const words[] = {"right", "left", "top", "bottom", "front", "back", NULL};
    const int word = mcv_rig_word_index(text, words);
    char end = '\0';
    for (int i = 0; i < 3; ++i) direction[i] = word / 2 == i && word >= 0 ? (word % 2 ? -1 : 1) : 0;
    if (word >= 0) return MCV_OK;
    const bool numbers = text[strspn(text, "0123456789.eE+-,")] == '\0';
    const int count =
        // NOLINTNEXTLINE(cert-err34-c): digits only, and what is out of range is not finite
        numbers ? sscanf(text, "%lf,%lf,%lf%c", direction, direction + 1, direction + 2, &end) : 0;
    if (count == 3) {
        const double length = hypot(hypot(direction[0], direction[1]), direction[2]);
        for (int i = 0; i < 3; ++i) direction[i] /= length;
        if (isfinite(length) && length > 0) return MCV_OK;
    }
    const char *nearest = mcv_nearest_word(text, words, 6);
    if (nearest) return mcv_fail(error, MCV_USAGE, "--view %s: did you mean %s?", text, nearest);
    return mcv_fail(error, MCV_USAGE,
                    "--view %s: must be front, back, left, right, top, bottom, or a direction "
                    "X,Y,Z from the part",
                    text);
}

/* Chooses the view. By default it is along the part's shortest dimension, so that the largest face
 * is seen; its longer side is horizontal. */
static mcv_result look(mcv_rig_design *r, mcv_error *error) {
    double size[3], to_camera[3] = {0, 0, 0}, right[3] = {1, 0, 0}, up[3], extent[3] = {0, 0, 0};
    int axis = 2;
    for (int i = 0; i < 3; ++i) {
        size[i] = r->upper[i] - r->lower[i];
        r->centre[i] = 0.5 * (r->lower[i] + r->upper[i]);
    }
    for (int i = 2; i >= 0; --i)
        if (size[i] < size[axis] * (1 - 1e-6)) axis = i;
    to_camera[axis] = 1;
    if (r->wishes.view) MCV_TRY(read_view(r->wishes.view, to_camera, error));
    const double level = hypot(to_camera[0], to_camera[2]);
    if (level > 0) right[0] = to_camera[2] / level, right[2] = -to_camera[0] / level;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        up[i] = to_camera[j] * right[k] - to_camera[k] * right[j];
    }
    for (int i = 0; i < 3; ++i) {
        extent[0] += size[i] * fabs(right[i]);
        extent[1] += size[i] * fabs(up[i]);
        extent[2] += size[i] * fabs(to_camera[i]);
    }
    const double degrees = 180 / M_PI;
    r->azimuth = level > 0 ? degrees * atan2(to_camera[0], to_camera[2]) : 0;
    r->elevation = degrees * atan2(to_camera[1], level);
    const bool turned = extent[1] > extent[0] && r->wishes.kind != MCV_RIG_LASER;
    r->roll = turned ? 90 : 0;
    r->across[0] = turned ? extent[1] : extent[0];
    r->across[1] = turned ? extent[0] : extent[1];
    r->depth = extent[2];
    return MCV_OK;
}

/* --- the lens --- */

double mcv_rig_usual(double x, bool above) {
    static const double series[] = {1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10};
    enum { COUNT = sizeof series / sizeof series[0] };
    const double decade = pow(10, floor(log10(x) + 1e-12));
    const double tiny = 1e-9; /* a member of the series stays, up to rounding */
    for (int i = 0; i < COUNT && above; ++i)
        if (series[i] * decade >= x * (1 - tiny)) return series[i] * decade;
    for (int i = COUNT; i-- > 0 && !above;)
        if (series[i] * decade <= x * (1 + tiny)) return series[i] * decade;
    return above ? 10 * decade : decade;
}

static double film_side(const mcv_rig_design *r, int axis) { return r->pixels[axis] * r->pixel; }

static void set_field(mcv_rig_design *r) {
    for (int i = 0; i < 2; ++i) r->field[i] = film_side(r, i) / r->magnification;
}

/*
 * The smallest standard f-number at which the whole part is blurred by at most a pixel, or the
 * largest. To first order, a depth z from the plane in focus is blurred by z m²/N in the image.
 */
static double choose_f_number(const mcv_rig_design *r) {
    static const double usual[] = {4, 5.6, 8, 11, 16};
    enum { COUNT = sizeof usual / sizeof usual[0] };
    const double m = r->magnification;
    if (r->wishes.f_number > 0) return r->wishes.f_number;
    if (r->wishes.kind == MCV_RIG_LIGHT_FIELD) return 4;
    if (r->wishes.kind == MCV_RIG_TRANSPARENT) return 2.8;
    if (r->wishes.kind == MCV_RIG_LASER) return 5.6; /* the plane of the light is in focus */
    for (int i = 0; i < COUNT; ++i)
        if (0.5 * r->depth * m * m / usual[i] <= r->pixel) return usual[i];
    return usual[COUNT - 1];
}

/* The wished magnification, given as such or as the field's width; 0 without. */
static double wished_magnification(const mcv_rig_design *r) {
    return r->wishes.field_of_view > 0 ? film_side(r, 0) / r->wishes.field_of_view
                                       : r->wishes.magnification;
}

/* `least`: the smallest working distance that leaves room for the light. */
static void choose_telecentric(mcv_rig_design *r, double least) {
    const double wished = wished_magnification(r),
                 needed[2] = {margin * r->across[0],
                              margin * fmax(r->across[1], 1e-3 * r->across[0])};
    r->magnification =
        wished > 0
            ? wished
            : mcv_rig_usual(fmin(film_side(r, 0) / needed[0], film_side(r, 1) / needed[1]), false);
    set_field(r);
    const double m = r->magnification;
    r->working_distance =
        r->wishes.working_distance > 0 ? r->wishes.working_distance
        : r->wishes.focal_length > 0
            ? r->wishes.focal_length * (1 + m) / m
            : mcv_rig_usual(fmax(least, fmax(2 * r->field[0], 2 * r->depth)), true);
    r->focal_length = r->working_distance * m / (1 + m);
}

/* The distance at which a focal length frames the part. Its nearest face must fit: the field there
 * is (W - depth/2)/W of that in focus. */
static double framing_distance(const mcv_rig_design *r, double f, double scale) {
    /* W - depth/2 = scale b with b = W f/(W - f): the larger root of W² - (scale f + f + depth/2) W
     * + f depth/2 = 0. */
    const double half = 0.5 * r->depth, p = 0.5 * (scale * f + f + half);
    return p + sqrt(fmax(0, p * p - f * half));
}

/* Is the camera far enough away: three fields, for a mild perspective, and with room for the
 * light? */
static bool is_far_enough(const mcv_rig_design *r, double f, double distance, double field,
                          double least) {
    const double lens = f / (distance - f) * distance / choose_f_number(r); /* b/N */
    if (distance < fmax(least, 3 * field + r->depth)) return false;
    /* If the lens is wider than the panel's cone, the panel lights that cone from everywhere in the
     * field (light.c). */
    return r->wishes.kind != MCV_RIG_TRANSPARENT ||
           lens >= 1.2 * field * hypot(1, film_side(r, 1) / film_side(r, 0));
}

static void choose_entocentric(mcv_rig_design *r, double least) {
    static const double usual[] = {4e-3,  6e-3,  8e-3,   12e-3,  16e-3,  25e-3, 35e-3,
                                   50e-3, 75e-3, 100e-3, 150e-3, 200e-3, 300e-3};
    enum { LONGEST = sizeof usual / sizeof usual[0] };
    const int count = r->wishes.kind == MCV_RIG_TRANSPARENT || least > 0 ? LONGEST : LONGEST - 3;
    /* A triangulation head sees heights in the image's other direction. */
    const double other = r->wishes.kind == MCV_RIG_LASER
                             ? r->depth * sin(MCV_RIG_ANGLE * (M_PI / 180))
                             : r->across[1];
    const double needed[2] = {margin * r->across[0], margin * fmax(other, 1e-3 * r->across[0])};
    const double scale = fmax(needed[0] / film_side(r, 0), needed[1] / film_side(r, 1)),
                 m = wished_magnification(r);
    double f = r->wishes.focal_length, distance = r->wishes.working_distance;
    if (distance > 0 && m > 0) f = distance * m / (1 + m);
    if (distance > 0 && !(f > 0)) { /* the longest that frames the part */
        const double b = (distance - 0.5 * r->depth) / scale, longest = b / (1 + b / distance);
        f = longest;
        for (int i = 0; i < count; ++i)
            if (usual[i] <= longest) f = usual[i];
    }
    const double field = m > 0 ? film_side(r, 0) / m : needed[0];
    for (int i = 0; !(f > 0) && i < count; ++i) {
        distance = m > 0 ? usual[i] * (1 + 1 / m) : framing_distance(r, usual[i], scale);
        if (is_far_enough(r, usual[i], distance, field, least) || i + 1 == count) f = usual[i];
    }
    if (!(distance > 0)) distance = m > 0 ? f * (1 + 1 / m) : framing_distance(r, f, scale);
    r->focal_length = f;
    r->working_distance = distance;
    r->magnification = f / (distance - f);
    set_field(r);
}

/* --- all of it --- */

static mcv_result check_wishes(const mcv_rig_design *r, mcv_error *error) {
    const mcv_rig_wishes *w = &r->wishes;
    const bool scale = w->magnification > 0 || w->field_of_view > 0;
    if (w->magnification > 0 && w->field_of_view > 0)
        return mcv_fail(
            error, MCV_USAGE,
            "--magnification and --field-of-view determine each other: give one of them");
    if (w->kind == MCV_RIG_TELECENTRIC && w->focal_length > 0 && w->working_distance > 0)
        return mcv_fail(error, MCV_USAGE,
                        "--focal-length follows from the working distance and the magnification of "
                        "a telecentric camera: leave it out");
    if (w->kind != MCV_RIG_TELECENTRIC && scale && w->focal_length > 0 && w->working_distance > 0)
        return mcv_fail(error, MCV_USAGE,
                        "focal length, working distance and magnification depend on each other: "
                        "give two of them");
    if (w->kind == MCV_RIG_LASER && w->light != MCV_RIG_LIGHT_AUTO)
        return mcv_fail(error, MCV_USAGE,
                        "--light %s: a triangulation head has its laser: leave it out, or choose "
                        "another kind of rig",
                        mcv_rig_lights[w->light]);
    if (w->kind == MCV_RIG_TRANSPARENT && w->light != MCV_RIG_LIGHT_AUTO &&
        w->light != MCV_RIG_LIGHT_BACKLIGHT)
        return mcv_fail(
            error, MCV_USAGE,
            "--light %s: a transparent part is lit from behind: leave it out, or choose another "
            "kind of rig",
            mcv_rig_lights[w->light]);
    return MCV_OK;
}

mcv_result mcv_rig_choose(const mcv_rig_wishes *wishes, mcv_rig_design *r, mcv_error *error) {
    *r = (mcv_rig_design){.wishes = *wishes,
                          .directions = films[wishes->kind].directions,
                          .pixel = films[wishes->kind].pixel};
    MCV_TRY(check_wishes(r, error));
    MCV_TRY(mcv_rig_read_part(r, error));
    MCV_TRY(mcv_rig_choose_material(r, error));
    MCV_TRY(look(r, error));
    if (wishes->pixel_size > 0) r->pixel = wishes->pixel_size;
    for (int i = 0; i < 2; ++i)
        r->pixels[i] = r->directions * (wishes->resolution[0] ? wishes->resolution[i]
                                                              : films[wishes->kind].resolution[i]);
    enum { TRIES = 12 };
    double least = 0;
    for (int i = 0; i < TRIES; ++i) {
        if (wishes->kind == MCV_RIG_TELECENTRIC)
            choose_telecentric(r, least);
        else
            choose_entocentric(r, least);
        r->f_number = choose_f_number(r);
        if (!(r->magnification > 1e-6 && r->magnification < 1e4 &&
              r->working_distance - 0.5 * r->depth > r->focal_length))
            return mcv_fail(
                error, MCV_BAD_INPUT,
                "%s: no standard lens frames a part of %.3g m x %.3g m x %.3g m%s: is the unit "
                "%s right?",
                wishes->part, r->across[0], r->across[1], r->depth,
                wishes->working_distance > 0 || wishes->focal_length > 0 ? " as wished" : "",
                wishes->unit ? wishes->unit : "m");
        mcv_rig_choose_light(r);
        if (r->light.reach <= r->working_distance) return MCV_OK;
        least = fmin(1.05 * r->light.reach, 1.5 * r->working_distance);
    }
    return mcv_fail(
        error, MCV_USAGE,
        "a %s light for this part extends %s towards the camera, whose lens is %s away: give "
        "a larger --f-number, a longer --working-distance or --focal-length",
        mcv_rig_lights[r->light.type], mcv_rig_length(r->light.reach, 3),
        mcv_rig_length(r->working_distance, 3));
}
