/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/found.h"

#include <math.h>
#include <string.h>

/* Rounding to whole numbers makes that much. */
static double least_noise(bool whole) { return whole ? sqrt(1.0 / 12) : 0; }

void mcv_know_noise(mcv_readings *readings, bool known, bool whole, mcv_roi *region) {
    if (!known) mcv_roi_estimate_noise(readings, region, least_noise(whole));
}

mcv_result mcv_locate(mcv_readings *readings, bool known, bool whole, unsigned form,
                      const char *text, size_t number, mcv_found *found, mcv_error *error) {
    const double least = known ? NAN : least_noise(whole);
    const mcv_image *image = &readings->values;
    *found = (mcv_found){.form = form};
    switch (form) {
    case MCV_FORM_EDGE:
        MCV_TRY(mcv_edge_parse(text, number, image, &found->as.edge, error));
        MCV_TRY(mcv_edge_locate(readings, least, &found->as.edge, error));
        return mcv_edge_is_straight(&found->as.edge, error);
    case MCV_FORM_LINE:
        MCV_TRY(mcv_line_parse(text, number, image, &found->as.line, error));
        return mcv_line_locate(readings, least, &found->as.line, error);
    case MCV_FORM_CALIPER:
        MCV_TRY(mcv_caliper_parse(text, number, image, &found->as.caliper, error));
        return mcv_caliper_locate(readings, least, &found->as.caliper, error);
    default:
        MCV_TRY(mcv_circle_parse(text, number, image, form == MCV_FORM_CIRCLE, &found->as.circle,
                                 error));
        return mcv_circle_locate(readings, least, &found->as.circle, error);
    }
}

const mcv_edge *mcv_found_straight(const mcv_found *found) {
    return found->form == MCV_FORM_EDGE   ? &found->as.edge
           : found->form == MCV_FORM_LINE ? &found->as.line.edge
                                          : NULL;
}

bool mcv_found_is_round(const mcv_found *found) {
    return found->form == MCV_FORM_CIRCLE || found->form == MCV_FORM_ARC;
}

const char *mcv_found_name(const mcv_found *found) {
    const mcv_edge *straight = mcv_found_straight(found);
    return straight                          ? straight->name
           : found->form == MCV_FORM_CALIPER ? found->as.caliper.name
                                             : found->as.circle.name;
}

/* Within 10°: between others no distance is meant, and what stands between two boxes would depend
 * on where they lie. */
static bool are_parallel(const mcv_edge *a, const mcv_edge *b) {
    return fabs(a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1]) >= cos(10 * M_PI / 180);
}

mcv_quantity mcv_found_distance(const mcv_found *a, const mcv_found *b, double direction[2]) {
    const mcv_edge *line = mcv_found_straight(a), *other = mcv_found_straight(b);
    mcv_quantity d;
    if (line) {
        d = !other                      ? mcv_edge_to_circle(line, &b->as.circle)
            : are_parallel(line, other) ? mcv_edge_distance(line, other)
                                        : (mcv_quantity){NAN, NAN};
        memcpy(direction, line->normal, sizeof line->normal);
    } else {
        d = mcv_circle_distance(&a->as.circle, &b->as.circle);
        const double x = b->as.circle.column.value - a->as.circle.column.value,
                     y = b->as.circle.row.value - a->as.circle.row.value;
        direction[0] = x == 0 && y == 0 ? 1 : x / hypot(x, y);
        direction[1] = x == 0 && y == 0 ? 0 : y / hypot(x, y);
    }
    d.value = fabs(d.value);
    return d;
}

double mcv_scale_along(const double pixel[2], const double direction[2]) {
    if (!(pixel[0] > 0)) return NAN;
    if (direction) return hypot(direction[0] * pixel[0], direction[1] * pixel[1]);
    return fabs(pixel[1] - pixel[0]) <= 1e-9 * pixel[0] ? pixel[0] : NAN;
}
