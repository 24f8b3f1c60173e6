/* SPDX-License-Identifier: Apache-2.0 */
#include "deflectometry/form.h"

#include <lapacke.h>
#include <math.h>

enum { TERMS = 6, TERMS_OF_PLANE = 3 };

/* Lengths are in this unit, so that all terms are about 1. */
static double extent_of(const mcv_shape *s) {
    double most = 0;
    for (size_t i = 0; i < (size_t)s->width * s->height; ++i)
        if (s->valid[i]) most = fmax(most, fmax(fabs(s->x[i]), fabs(s->y[i])));
    return most;
}

static void terms_at(double x, double y, double terms[TERMS]) {
    terms[0] = 1;
    terms[1] = x;
    terms[2] = y;
    terms[3] = 0.5 * x * x;
    terms[4] = x * y;
    terms[5] = 0.5 * y * y;
}

mcv_form mcv_form_fit(const mcv_shape *shape, int kind) {
    const lapack_int terms = kind == MCV_FORM_QUADRIC ? TERMS : TERMS_OF_PLANE;
    const double unit = extent_of(shape);
    double normal[TERMS * TERMS] = {0}, best[TERMS] = {0}, term[TERMS];
    if (!(unit > 0)) return (mcv_form){0};
    for (size_t i = 0; i < (size_t)shape->width * shape->height; ++i) {
        if (!shape->valid[i]) continue;
        terms_at(shape->x[i] / unit, shape->y[i] / unit, term);
        for (int j = 0; j < terms; ++j) {
            best[j] += term[j] * shape->z[i];
            for (int k = 0; k <= j; ++k) normal[j * terms + k] += term[j] * term[k];
        }
    }
    if (LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', terms, normal, terms) != 0) return (mcv_form){0};
    LAPACKE_dtrtrs(LAPACK_ROW_MAJOR, 'L', 'N', 'N', terms, 1, normal, terms, best, 1);
    LAPACKE_dtrtrs(LAPACK_ROW_MAJOR, 'L', 'T', 'N', terms, 1, normal, terms, best, 1);
    mcv_form form = {.height = best[0], .slope = {best[1] / unit, best[2] / unit}};
    for (int k = 0; k < 3; ++k) form.curvature[k] = best[3 + k] / (unit * unit);
    return form;
}

void mcv_form_take(const mcv_form *form, mcv_shape *shape) {
    for (size_t i = 0; i < (size_t)shape->width * shape->height; ++i) {
        const double x = shape->x[i], y = shape->y[i];
        if (!shape->valid[i]) continue;
        const double bend_x = form->curvature[0] * x + form->curvature[1] * y,
                     bend_y = form->curvature[1] * x + form->curvature[2] * y;
        shape->z[i] -= form->height + (form->slope[0] + 0.5 * bend_x) * x +
                       (form->slope[1] + 0.5 * bend_y) * y;
        shape->p[i] -= form->slope[0] + bend_x;
        shape->q[i] -= form->slope[1] + bend_y;
    }
}
