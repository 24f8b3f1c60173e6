/* SPDX-License-Identifier: Apache-2.0 */
#include "lens/lens_file.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "lens/lens.h"

/* --- radius or curvature --- */

static void read_as(mcv_lens *l, mcv_lens_shape shape) {
    for (int i = 0; i < l->count; ++i) {
        mcv_lens_surface *s = l->surfaces + i;
        if (s->unsure && shape == MCV_LENS_SHAPE_RADIUS) s->curvature = 1 / s->curvature;
        s->unsure = false;
    }
}

/* The relative difference of two lengths; INFINITY if one is missing. */
static double difference(double a, double b) {
    return isnan(a) || isnan(b) || b == 0 ? INFINITY : fabs(a / b - 1);
}

/*
 * Chooses the reading if the file does not state it: the one that focuses within a tenth of the
 * stated image distance, or has the stated focal length. If both or none do, the one whose surfaces
 * are wide enough for the bundle.
 */
static mcv_result choose_shape(mcv_lens *l, mcv_error *error) {
    bool unsure = false, near[2], possible[2];
    double distance[2];
    for (int i = 0; i < l->count; ++i) unsure = unsure || l->surfaces[i].unsure;
    if (!unsure) return MCV_OK;
    mcv_lens *copy = malloc(sizeof *copy);
    if (!copy) return mcv_fail(error, MCV_FAILED, "%s: no memory for it", l->path);
    for (int k = 0; k < 2; ++k) {
        *copy = *l;
        read_as(copy, k ? MCV_LENS_SHAPE_CURVATURE : MCV_LENS_SHAPE_RADIUS);
        const mcv_lens_first_order f = mcv_lens_trace(copy, false);
        distance[k] = f.image_distance;
        near[k] = difference(distance[k], f.stated_image_distance) < 0.1 ||
                  (l->focal_length > 0 && difference(f.focal_length, l->focal_length) < 0.1);
        possible[k] = mcv_lens_is_possible(copy);
    }
    free(copy);
    const bool *says = near[0] != near[1] ? near : possible;
    if (says[0] == says[1])
        return mcv_lens_fail(
            l, 0, -1, error,
            "does not state by RDM whether its surfaces are given by radius or curvature (the "
            "image would be at %.4g or %.4g): give --curvature radius or --curvature curvature",
            distance[0], distance[1]);
    read_as(l, says[0] ? MCV_LENS_SHAPE_RADIUS : MCV_LENS_SHAPE_CURVATURE);
    mcv_lens_warn(l, "%s: its surfaces are read as %s, although it has no RDM: %s", l->path,
                  says[0] ? "radii" : "curvatures",
                  says == near ? "only in this reading the image lies where the file has it"
                               : "only in this reading they are wide enough for the bundle");
    return MCV_OK;
}

/* --- semi-diameters that fit the bodies --- */

/* The radius at which a surface becomes vertical, times `share`. */
static double largest_radius(const mcv_lens_surface *s, double share) {
    const double square = (1 + s->conic) * s->curvature * s->curvature;
    return square > 0 ? share / sqrt(square) : INFINITY;
}

static double sag(const mcv_lens_surface *s, double r) {
    const double c = s->curvature;
    double z = c * r * r / (1 + sqrt(fmax(1 - (1 + s->conic) * c * c * r * r, 0)));
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i) z += s->asphere[i] * pow(r, 2 * i + 4);
    return z;
}

/* The largest radius at which b is still behind a. */
static double touching_radius(const mcv_lens_surface *a, const mcv_lens_surface *b, double edge) {
    const double least = 1e-6 * edge;
    while (a->thickness + sag(b, edge) - sag(a, edge) < 0 && edge > 0)
        edge = edge > least ? 0.98 * edge : 0;
    return edge;
}

static double edge_of(const mcv_lens_surface *front) {
    return fmax(front->semi_diameter, front[1].semi_diameter);
}

/* Reduces the body behind a surface to the radius `edge`. */
static void cut_body(mcv_lens *l, int i, double edge, const char *why) {
    mcv_lens_surface *front = l->surfaces + i;
    if (edge >= edge_of(front)) return;
    mcv_lens_warn(
        l, "%s: line %d: surface %d: its lens is made %.4g mm wide instead of %.4g mm: beyond, %s",
        l->path, front->line, i, 2e3 * edge * l->unit, 2e3 * edge_of(front) * l->unit, why);
    front->semi_diameter = fmin(front->semi_diameter, edge);
    front[1].semi_diameter = fmin(front[1].semi_diameter, edge);
}

/* Makes both faces of a body reach its edge without overlaps between bodies, whatever
 * semi-diameters the file gives. */
static void cut_given(mcv_lens *l, int i) {
    const mcv_lens_surface *a = l->surfaces + i, *b = a + 1;
    if (*a->glass.name) {
        const double edge =
            fmin(edge_of(a), fmin(largest_radius(a, 0.99), largest_radius(b, 0.99)));
        cut_body(l, i, touching_radius(a, b, edge), "its faces have no common edge");
    } else if (*a[-1].glass.name && *b->glass.name) {
        const double edge = fmin(edge_of(a - 1), edge_of(b)),
                     touching = touching_radius(a, b, edge);
        if (touching < edge)
            cut_body(l, edge_of(a - 1) < edge_of(b) ? i - 1 : i + 1, touching,
                     "it touches the next one");
    }
}

/* Keeps a thickness between two surfaces, glass or air, up to their edges: an unvignetted bundle
 * may need more. */
static void fit_semi_diameters(mcv_lens *l, int first, int end, const bool *given) {
    for (int pass = 0; pass < 4; ++pass)
        for (int i = first; i + 1 < end; ++i) {
            mcv_lens_surface *a = l->surfaces + i, *b = a + 1;
            const bool glass = *a->glass.name;
            if (given[i] || given[i + 1]) {
                cut_given(l, i);
                continue;
            }
            double edge = glass ? fmax(a->semi_diameter, b->semi_diameter)
                                : fmin(a->semi_diameter, b->semi_diameter);
            if (glass) edge = fmin(edge, fmin(largest_radius(a, 0.95), largest_radius(b, 0.95)));
            edge = touching_radius(a, b, edge);
            a->semi_diameter = glass ? edge : fmin(a->semi_diameter, fmax(edge, 0));
            b->semi_diameter = glass ? edge : b->semi_diameter;
        }
}

/* --- the file as a whole --- */

/* The surfaces to write: from the first to the last one of glass, and the stop. */
static mcv_result find_extent(const mcv_lens *l, int *first, int *end, mcv_error *error) {
    *first = -1;
    for (int i = 0; i < l->count; ++i) {
        const mcv_lens_surface *s = l->surfaces + i;
        if (!*s->glass.name) continue;
        if (i == 0 || i + 1 == l->count)
            return mcv_lens_fail(l, s->line, i, error,
                                 i ? "its glass has no surface behind it: the file is truncated"
                                   : "objects in glass are not supported");
        if (*first < 0) *first = i;
        *end = i + 2;
        if (!(isfinite(s->thickness) && s->thickness >= 0))
            return mcv_lens_fail(l, s->line, i, error,
                                 "the thickness of its glass must be 0 or more");
    }
    if (*first < 0)
        return mcv_lens_fail(l, 0, -1, error, "has no surface with a glass: it is not a lens");
    if (*end == l->count)
        return mcv_lens_fail(
            l, l->surfaces[*end - 2].line, *end - 2, error,
            "its glass reaches the image: the file is truncated, or a surface is missing");
    if (l->stop > 0 &&
        l->stop <
            l->count -
                1) { /* a stop before the first glass or behind the last one belongs to the lens */
        *first = l->stop < *first ? l->stop : *first;
        *end = l->stop < *end ? *end : l->stop + 1;
    }
    for (int i = *first; i < *end - 1; ++i)
        if (!isfinite(l->surfaces[i].thickness))
            return mcv_lens_fail(l, l->surfaces[i].line, i, error,
                                 "the distance to the next surface must be finite");
    return MCV_OK;
}

/* The number in "f=100 mm" or "f/2" in the lens's name, as makers write it; 0 if there is none. */
static double number_in_name(const char *name, char sign, const char *unit) {
    for (const char *c = name; *c; ++c) {
        const char *at = c + 1;
        char *end;
        if (tolower((unsigned char)*c) != 'f' || (c > name && isalnum((unsigned char)c[-1])))
            continue;
        at += strspn(at, " ");
        if (*at++ != sign) continue;
        const double value = strtod(at, &end);
        end += strspn(end, " ");
        if (isfinite(value) && value > 0 && strncasecmp(end, unit, strlen(unit)) == 0) return value;
    }
    return 0;
}

static void fill_report(const mcv_lens *l, const mcv_lens_first_order *stated,
                        const mcv_lens_first_order *written) {
    const double named = number_in_name(l->name, '=', "mm"),
                 f_named = number_in_name(l->name, '/', "");
    const bool finite = isfinite(stated->object_distance);
    mcv_lens_report *report = l->report;
    report->wavelength = l->wavelength;
    report->focal_length = stated->focal_length * l->unit;
    report->stated_focal_length = l->focal_length > 0 ? l->focal_length * l->unit
                                  : named > 0         ? named * 1e-3
                                                      : NAN;
    report->back_focus = stated->back_focus * l->unit;
    report->object_distance = stated->object_distance * l->unit;
    report->image_distance = stated->image_distance * l->unit;
    report->stated_image_distance = stated->stated_image_distance * l->unit;
    report->working = finite && (l->aperture_is == MCV_LENS_WORKING_F_NUMBER ||
                                 l->aperture_is == MCV_LENS_OBJECT_SLOPE);
    report->f_number = report->working ? written->working_f_number : written->f_number;
    report->stated_f_number = l->aperture_is != MCV_LENS_STOP_SIZE
                                  ? (report->working ? stated->working_f_number : stated->f_number)
                              : f_named > 0 ? f_named
                                            : NAN;
}

/* Warns if figures that the file states differ by more than 1 % from those of the lens as
 * written. */
static void compare_report(mcv_lens *l) {
    const mcv_lens_report *r = l->report;
    const double tolerance = 0.01;
    if (fabs(r->focal_length / r->stated_focal_length - 1) > tolerance)
        mcv_lens_warn(l, "%s: the focal length is %.5g mm, but the file states %.5g mm", l->path,
                      1e3 * r->focal_length, 1e3 * r->stated_focal_length);
    if (fabs(r->image_distance / r->stated_image_distance - 1) > tolerance)
        mcv_lens_warn(l,
                      "%s: the image is %.5g mm behind the last surface of glass, but the file has "
                      "it at %.5g mm",
                      l->path, 1e3 * r->image_distance, 1e3 * r->stated_image_distance);
    if (fabs(r->f_number / r->stated_f_number - 1) > tolerance)
        mcv_lens_warn(l, "%s: the lens as written is f/%.4g, but the file states f/%.4g: %s",
                      l->path, r->f_number, r->stated_f_number,
                      l->stop > 0 && !mcv_lens_bounds_glass(l, l->stop)
                          ? "its semi-diameters say so"
                          : "it has no stop in air, so the edges of the glass limit the light");
}

/* Checks that a scene accepts the numbers in metres. */
static mcv_result check_numbers(const mcv_lens *l, int first, int end, mcv_error *error) {
    for (int i = first; i < end; ++i) {
        const mcv_lens_surface *s = l->surfaces + i;
        bool finite = isfinite(s->curvature) && s->semi_diameter * l->unit <= 1e6 &&
                      fabs(s->thickness) * l->unit <= 1e6;
        if (i + 1 == end && !*s->glass.name)
            finite = isfinite(s->curvature) && s->semi_diameter * l->unit <= 1e6;
        for (int k = 0; k < MCV_ASPHERE_TERMS; ++k)
            finite = finite && isfinite(s->asphere[k] * pow(l->unit, -2 * k - 3));
        if (!finite)
            return mcv_lens_fail(l, s->line, i, error, "its numbers are too large for a scene");
        if (mcv_lens_bounds_glass(l, i) && !(s->semi_diameter > 0))
            return mcv_lens_fail(l, s->line, i, error,
                                 "its lens overlaps the next one already on the axis");
    }
    return MCV_OK;
}

static mcv_result convert(mcv_lens *l, const mcv_lens_options *options, json_t **scene,
                          mcv_error *error) {
    bool given[MCV_LENS_SURFACES];
    int first = -1, end = 0;
    MCV_TRY(mcv_lens_find_glasses(l, options->indices, options->index_count, error));
    MCV_TRY(find_extent(l, &first, &end, error));
    MCV_TRY(choose_shape(l, error));
    if (!(l->wavelength >= 100e-9 && l->wavelength <= 100e-6))
        return mcv_lens_fail(l, 0, -1, error,
                             "its wavelength of %.4g nm must be from 100 nm to 100 um",
                             1e9 * l->wavelength);
    if (l->wavelength < 350e-9 || l->wavelength > 2e-6)
        mcv_lens_warn(
            l,
            "%s: the glasses' formulas hold from 350 to 2000 nm, not at its wavelength of %.4g nm",
            l->path, 1e9 * l->wavelength);
    mcv_lens_solve_image(l);
    const mcv_lens_first_order stated = mcv_lens_trace(l, false);
    for (int i = 0; i < l->count; ++i) given[i] = l->surfaces[i].semi_diameter > 0;
    MCV_TRY(mcv_lens_find_semi_diameters(l, first, end, given, error));
    fit_semi_diameters(l, first, end, given);
    const mcv_lens_first_order written = mcv_lens_trace(l, true);
    fill_report(l, &stated, &written);
    compare_report(l);
    MCV_TRY(check_numbers(l, first, end, error));
    *scene = mcv_lens_write(l, first, end);
    return *scene ? MCV_OK : mcv_fail(error, MCV_FAILED, "%s: no memory to convert it", l->path);
}

/* Refuses binary files of the same programs. */
static mcv_result refuse_format(const char *path, mcv_error *error) {
    static const char *const known[][2] = {
        {".zar", "is an archive of Zemax OpticStudio: extract it there (File, Load Archive), or "
                 "save the lens as .zmx"},
        {".zos", "is a project of Zemax OpticStudio: save the lens there as .zmx"},
        {".len",
         "is a binary file of CODE V: save the lens there as a sequence, .seq (File, Export)"}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i)
        if (mcv_ends_in(path, known[i][0]))
            return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, known[i][1]);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: must be a .zmx or .seq file", path);
}

mcv_result mcv_lens_file_read(const char *path, const mcv_lens_options *options, json_t **scene,
                              mcv_lens_report *report, mcv_error *error) {
    const bool zemax = mcv_ends_in(path, ".zmx");
    char *text = NULL;
    *scene = NULL;
    *report = (mcv_lens_report){0};
    if (!zemax && !mcv_ends_in(path, ".seq")) return refuse_format(path, error);
    if (zemax && options->shape != MCV_LENS_SHAPE_AUTO)
        return mcv_fail(error, MCV_USAGE,
                        "%s: --curvature is for .seq files: a .zmx file always gives curvatures",
                        path);
    MCV_TRY(mcv_lens_text_load(path, &text, error));
    mcv_lens *l = calloc(1, sizeof *l);
    mcv_result result = l ? MCV_OK : mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    if (l) {
        l->path = path;
        l->report = report;
        l->line = 1;
        l->unit = 1e-3;
        l->wavelength = 587.5618e-9;
        result = zemax ? mcv_lens_zemax_read(l, text, error)
                       : mcv_lens_codev_read(l, options->shape, text, error);
        if (result == MCV_OK) result = convert(l, options, scene, error);
    }
    free(l);
    free(text);
    return result;
}
