/* SPDX-License-Identifier: Apache-2.0 */
/* How the places of the rows lie about the line: their scatter, and the sagitta of an arc. */
#include "analysis/edge_line.h"

#include <math.h>
#include <stdlib.h>

/* One row's place about the line, and a polynomial there with that of one degree less. */
typedef struct row_place {
    double off, from, shared, polynomial, before;
} row_place;

/*
 * Fits the places by polynomials that are orthogonal on the rows (Forsythe 1957). The coefficient
 * of the second degree is the arc. The next six estimate deviations of such lengths from other
 * causes than an arc and the noise of independent pixels, such as a blurred corner. Where they are
 * clearly larger than that noise, they are the arc's uncertainty.
 */
static void find_sagitta(row_place *rows, size_t n, mcv_quantity *sagitta) {
    enum { ARC = 2, LAST = 8 };
    double norm = 1, arc = 0, others = 0, expected = 0, count = 0;
    for (size_t i = 0; i < n; ++i)
        rows[i] = (row_place){rows[i].off, rows[i].from, rows[i].shared, 1, 0};
    for (int degree = 0; degree <= LAST && (size_t)degree + 2 < n; ++degree) {
        double square = 0, moment = 0, product = 0, noise = 0;
        for (size_t i = 0; i < n; ++i) {
            const double q = rows[i].polynomial;
            square += q * q;
            moment += q * q * rows[i].off;
            product += q * rows[i].from;
            noise += q * q * rows[i].shared;
        }
        if (degree == ARC) *sagitta = (mcv_quantity){product / square, sqrt(noise) / square};
        if (degree > ARC) {
            others += product * product / square;
            expected += noise / square;
            ++count;
        }
        if (degree == ARC) arc = square;
        const double back = degree ? square / norm : 0;
        norm = square;
        for (size_t i = 0; i < n; ++i) {
            const double next =
                (rows[i].off - moment / square) * rows[i].polynomial - back * rows[i].before;
            rows[i].before = rows[i].polynomial;
            rows[i].polynomial = next;
        }
    }
    if (count > 0 && others > expected * (1 + 3 * sqrt(2 / count)))
        sagitta->uncertainty = sqrt(others / (count * arc));
}

bool mcv_edge_find_form(const mcv_edge_patch *p, const mcv_edge_line *l, mcv_edge *edge) {
    row_place *places = malloc(p->rows * sizeof *places);
    mcv_edge_rows *rows = &edge->rows;
    size_t n = 0;
    if (!places) return false;
    *rows = (mcv_edge_rows){.middle = l->middle,
                            .at = l->at,
                            .slope = l->slope,
                            .variance_at = l->variance_at,
                            .variance_slope = l->variance_slope};
    for (size_t row = 0; row < p->rows; ++row) {
        const double off = (double)row + 0.5 - l->middle;
        mcv_edge_row found;
        if (!mcv_edge_find_row(p, l, row, &found)) continue;
        const double from = found.place - mcv_edge_line_column(l, (double)row + 0.5);
        places[n++] = (row_place){.off = off, .from = from, .shared = found.shared};
        rows->spread += off * off;
        rows->squares += from * from;
        rows->noise += found.variance;
        rows->noise2 += mcv_readings_squared_covariance(p->readings, found.variance, found.shared);
        rows->shared += found.shared;
    }
    rows->count = (double)n;
    rows->shared /= rows->count;
    find_sagitta(places, n, &edge->sagitta);
    free(places);
    /* x² rises by a quarter of the chord's square from the middle to its ends; along the normal
     * that is less. */
    const double turn = l->right.value > l->left.value ? -1 : 1,
                 arc = 0.25 * (double)(n * n) / sqrt(1 + l->slope * l->slope);
    edge->sagitta.value *= turn * arc;
    edge->sagitta.uncertainty *= arc;
    return true;
}

mcv_result mcv_edge_is_straight(const mcv_edge *edge, mcv_error *error) {
    const mcv_quantity s = edge->sagitta;
    const double cosine = cos(edge->tilt.value), chord = edge->rows.count / cosine;
    if (!(fabs(s.value) > fmax(4 * s.uncertainty, 0.01))) return MCV_OK;
    return mcv_fail(error, MCV_FAILED,
                    "edge %s is curved: its sagitta is %.3g ± %.2g pixels over %.0f, a radius of "
                    "about %.3g; measure it by --circle or --arc, "
                    "or in a shorter rectangle",
                    edge->name, fabs(s.value), s.uncertainty, chord,
                    chord * chord / (8 * fabs(s.value)));
}
