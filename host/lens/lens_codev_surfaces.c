/* SPDX-License-Identifier: Apache-2.0 */
/* Statements of CODE V sequences about a surface: shape, thickness, glass, aperture, asphere. */
#include "lens/lens_codev.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* 0 and infinite values are planes. */
static void set_shape(mcv_lens_surface *s, double value, mcv_lens_shape shape) {
    if (fabs(value) > 1e30 || fabs(value) < 1e-30) value = 0;
    s->unsure = shape == MCV_LENS_SHAPE_AUTO && value != 0;
    s->curvature = shape != MCV_LENS_SHAPE_RADIUS ? value : value != 0 ? 1 / value : 0;
}

mcv_result mcv_codev_set_glass(mcv_codev *c, int surface, const char *name, mcv_error *error) {
    mcv_lens_glass *glass = &c->l->surfaces[surface].glass;
    if (mcv_codev_means(name, "REFL"))
        return mcv_codev_fail(
            c, surface, error,
            "mirrors in lens files are not supported: give them as a \"surface\" in the scene", "");
    *glass = (mcv_lens_glass){0};
    if (!mcv_lens_is(name, "AIR") && !mcv_lens_is(name, "REFR"))
        mcv_lens_copy_name(glass->name, name);
    return MCV_OK;
}

mcv_result mcv_codev_read_surface(mcv_codev *c, char **words, int n, mcv_error *error) {
    mcv_lens *l = c->l;
    const char kind = (char)toupper((unsigned char)words[0][1]);
    const bool numbered = isdigit((unsigned char)kind);
    int number = numbered ? (int)fmin((double)strtol(words[0] + 1, NULL, 10), 1e6) : 0;
    double value = 0;
    if (l->count == 0 &&
        (numbered ? number != 0
                  : kind != 'O')) { /* the object is at infinity unless the file says another */
        MCV_TRY(mcv_lens_add_surface(l, error));
        l->surfaces[0].thickness = INFINITY;
    }
    if (!numbered && kind != 'O') number = l->count - (kind == 'I' && c->image);
    if (number > l->count)
        return mcv_codev_fail(
            c, -1, error, "surface numbers must be consecutive, but one is missing: ", words[0]);
    if (number == l->count) {
        if (c->image)
            return mcv_codev_fail(c, -1, error,
                                  "there is a surface behind the image, SI: ", words[0]);
        MCV_TRY(mcv_lens_add_surface(l, error));
    }
    mcv_lens_surface *s = l->surfaces + number;
    c->image = c->image || kind == 'I';
    if (n > 1) {
        MCV_TRY(mcv_lens_distance(l, words[1], &value, error));
        set_shape(s, value, c->shape);
    }
    if (n > 2) MCV_TRY(mcv_lens_distance(l, words[2], &s->thickness, error));
    for (int i = 3; i < n; ++i) MCV_TRY(mcv_codev_set_glass(c, number, words[i], error));
    return MCV_OK;
}

mcv_result mcv_codev_read_shape(mcv_codev *c, const mcv_codev_statement *s, mcv_lens_shape shape,
                                mcv_error *error) {
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    for (int i = s->first; i <= s->last; ++i) {
        mcv_lens_surface *surface = c->l->surfaces + i;
        if (isalpha((unsigned char)s->words[0][0])) {
            if (surface->curvature == 0 && !mcv_codev_means(s->words[0], "PIK"))
                return mcv_codev_fail(
                    c, i, error,
                    "its curvature is solved, but no value stands in its S statement: "
                    "save the lens from CODE V, solve ",
                    s->words[0]);
            continue;
        }
        MCV_TRY(mcv_lens_distance(c->l, s->words[0], &value, error));
        set_shape(surface, value, shape);
    }
    return MCV_OK;
}

mcv_result mcv_codev_read_thickness(mcv_codev *c, const mcv_codev_statement *s, mcv_error *error) {
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    for (int i = s->first; i <= s->last; ++i) {
        mcv_lens_surface *surface = c->l->surfaces + i;
        if (mcv_codev_means(s->words[0], "PIM") ||
            (mcv_codev_means(s->words[0], "HMY") && s->count > 1 && strtod(s->words[1], NULL) == 0))
            surface->image_solve = true;
        else if (!isalpha((unsigned char)s->words[0][0])) {
            MCV_TRY(mcv_lens_distance(c->l, s->words[0], &value, error));
            surface->thickness = value;
        }
    }
    return MCV_OK;
}

mcv_result mcv_codev_read_aperture(mcv_codev *c, const mcv_codev_statement *s, mcv_error *error) {
    double value;
    int at = 0;
    bool edge = false;
    for (; at < s->count && isalpha((unsigned char)s->words[at][0]); ++at) {
        if (mcv_codev_means(s->words[at], "OBS") || mcv_codev_means(s->words[at], "HOL"))
            return mcv_codev_fail(c, s->first, error,
                                  "only the radius of a round aperture is supported, not CIR ",
                                  s->words[at]);
        edge = edge || mcv_codev_means(s->words[at], "EDG");
    }
    if (at == s->count || s->zoom) return MCV_OK;
    MCV_TRY(mcv_lens_number(c->l, s->words[at], &value, error));
    for (int i = s->first; i <= s->last; ++i)
        if (!edge || c->l->surfaces[i].semi_diameter == 0)
            c->l->surfaces[i].semi_diameter = fabs(value);
    return MCV_OK;
}

mcv_result mcv_codev_read_coefficient(mcv_codev *c, const char *key, const mcv_codev_statement *s,
                                      mcv_error *error) {
    const int letter = toupper((unsigned char)*key), term = letter - 'A' - (letter == 'J');
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    MCV_TRY(mcv_lens_number(c->l, s->words[0], &value, error));
    for (int i = s->first; i <= s->last; ++i) {
        if (letter == 'K')
            c->l->surfaces[i].conic = value;
        else if (term < MCV_ASPHERE_TERMS)
            c->l->surfaces[i].asphere[term] = value;
        else if (value != 0)
            return mcv_codev_fail(c, i, error, "aspheres have terms from r^4 to r^18, A to H, not ",
                                  key);
    }
    return MCV_OK;
}
