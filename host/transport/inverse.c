/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/inverse.h"

#include "transport/nonnegative.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_EVALUATIONS = 500 };

/* T without a replicate, as rows of pixels and columns of the emitter's elements. */
typedef struct equations {
    const mcv_matrix *matrix;
    const mcv_element_group *group;
    size_t pixels, elements;
    uint32_t out;    /* the replicate that is left out; their number: none */
    double *values;  /* of each entry; 0 of other emitters */
    double *light;   /* [pixel] */
    double *wanted;  /* [pixel]: 1 where light arrives */
    double *squares; /* [element]: of T's columns */
    double *shown;   /* [element]: of a fit */
    double damping;  /* µ */
} equations;

/* --- products --- */

static double value_of(const equations *s, uint64_t entry) {
    const mcv_matrix *m = s->matrix;
    const float *of = m->replicates_of + entry * m->replicates;
    double sum = 0;
    if (m->columns[entry] - s->group->first >= s->elements) return 0;
    for (uint32_t r = 0; r < m->replicates; ++r)
        if (r != s->out) sum += (double)of[r];
    return sum / (s->out < m->replicates ? m->replicates - 1 : m->replicates) / m->channels;
}

/* Visits the entries of each pixel: light += T x, or x += Tᵀ light. */
static void multiply(const equations *s, const double *x, double *light) {
    const mcv_matrix *m = s->matrix;
    memset(light, 0, s->pixels * sizeof *light);
    for (size_t row = 0; row < m->row_count; ++row)
        for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i)
            if (s->values[i] != 0)
                light[row / m->channels] += s->values[i] * x[m->columns[i] - s->group->first];
}

static void multiply_back(const equations *s, const double *light, double *x) {
    const mcv_matrix *m = s->matrix;
    memset(x, 0, s->elements * sizeof *x);
    for (size_t row = 0; row < m->row_count; ++row)
        for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i)
            if (s->values[i] != 0)
                x[m->columns[i] - s->group->first] += s->values[i] * light[row / m->channels];
}

static void fill_equations(equations *s, uint32_t out) {
    const mcv_matrix *m = s->matrix;
    s->out = out;
    memset(s->squares, 0, s->elements * sizeof *s->squares);
    memset(s->wanted, 0, s->pixels * sizeof *s->wanted);
    for (size_t row = 0; row < m->row_count; ++row)
        for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i) {
            s->values[i] = value_of(s, i);
            if (s->values[i] == 0) continue;
            s->wanted[row / m->channels] = 1;
            s->squares[m->columns[i] - s->group->first] += s->values[i] * s->values[i];
        }
}

/* --- patterns --- */

static void replay(const equations *s, double *x) {
    multiply_back(s, s->wanted, x);
    multiply(s, x, s->light);
    for (size_t i = 0; i < s->pixels; ++i) s->light[i] = s->light[i] > 0 ? 1 / s->light[i] : 0;
    multiply_back(s, s->light, x);
}

/* ½ ‖T x - 1‖² + ½ µ ‖x‖² over the elements that bring light, which are few of a light field's. */
static double misfit(void *user, const double *at, double *slopes) {
    const equations *s = user;
    double value = 0;
    for (size_t e = 0, i = 0; e < s->elements; ++e) s->shown[e] = s->squares[e] > 0 ? at[i++] : 0;
    multiply(s, s->shown, s->light);
    for (size_t i = 0; i < s->pixels; ++i) {
        s->light[i] -= s->wanted[i];
        value += 0.5 * s->light[i] * s->light[i];
    }
    multiply_back(s, s->light, s->shown);
    for (size_t e = 0, i = 0; e < s->elements; ++e) {
        if (!(s->squares[e] > 0)) continue;
        value += 0.5 * s->damping * at[i] * at[i];
        slopes[i] = s->shown[e] + s->damping * at[i];
        ++i;
    }
    return value;
}

/* Fits x, which is the replay. */
static mcv_result fit(equations *s, double damping, double *x, mcv_error *error) {
    double *at = malloc(2 * s->elements * sizeof *at), sum = 0;
    size_t lit = 0;
    if (!at) return mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    double *scale = at + s->elements;
    for (size_t e = 0; e < s->elements; ++e)
        if (s->squares[e] > 0) {
            sum += s->squares[e];
            at[lit++] = x[e];
        }
    s->damping = lit > 0 ? damping * sum / (double)lit : 0;
    for (size_t e = 0, i = 0; e < s->elements; ++e)
        if (s->squares[e] > 0) scale[i++] = 1 / sqrt(s->squares[e] + s->damping);
    const mcv_result result =
        mcv_minimise_nonnegative(misfit, s, scale, lit, MOST_EVALUATIONS, at, error);
    for (size_t e = 0, i = 0; e < s->elements; ++e) x[e] = s->squares[e] > 0 ? at[i++] : 0;
    free(at);
    return result;
}

static mcv_result find(equations *s, const mcv_inverse *inverse, double *x, mcv_error *error) {
    double most = 0;
    if (inverse->dark) {
        for (size_t e = 0; e < s->elements; ++e) x[e] = s->squares[e] > 0 ? 0 : 1;
        return MCV_OK;
    }
    replay(s, x);
    if (inverse->method == MCV_INVERSE_LEAST_SQUARES) MCV_TRY(fit(s, inverse->damping, x, error));
    for (size_t e = 0; e < s->elements; ++e) most = fmax(most, x[e]);
    if (!(most > 0))
        return mcv_fail(error, MCV_BAD_INPUT, "emitter \"%s\" lights no pixel of the matrix",
                        s->group->emitter);
    for (size_t e = 0; e < s->elements; ++e) x[e] /= most;
    return MCV_OK;
}

/* --- the image, with its errors --- */

static double rounded(double value, uint32_t bits) {
    const double codes = exp2(bits) - 1;
    return bits > 0 ? rint(value * codes) / codes : value;
}

/* `all`: [left out][element], the last with all replicates. */
static void put_images(const equations *s, uint32_t bits, const double *all, mcv_image *pattern,
                       mcv_image *deviation) {
    const uint32_t replicates = s->matrix->replicates;
    for (size_t e = 0; e < s->elements; ++e) {
        double mean = 0, squares = 0;
        for (uint32_t r = 0; r < replicates; ++r) mean += all[r * s->elements + e] / replicates;
        for (uint32_t r = 0; r < replicates; ++r)
            squares += pow(all[r * s->elements + e] - mean, 2);
        pattern->pixels[e] = (float)rounded(all[replicates * s->elements + e], bits);
        deviation->pixels[e] =
            replicates > 1 ? (float)sqrt(squares * (replicates - 1) / replicates) : NAN;
    }
}

static mcv_result find_all(equations *s, const mcv_inverse *inverse, double *all,
                           mcv_image *pattern, mcv_image *deviation, mcv_error *error) {
    const uint32_t replicates = s->matrix->replicates;
    for (uint32_t out = replicates > 1 ? 0 : 1; out <= replicates; ++out) {
        fill_equations(s, out);
        MCV_TRY(find(s, inverse, all + (size_t)out * s->elements, error));
    }
    MCV_TRY(mcv_image_new(pattern, s->group->width, s->group->height, 1, error));
    const mcv_result result = mcv_image_new(deviation, s->group->width, s->group->height, 1, error);
    if (result == MCV_OK)
        put_images(s, inverse->bits, all, pattern, deviation);
    else
        mcv_image_free(pattern);
    return result;
}

mcv_result mcv_inverse_pattern(const mcv_matrix *matrix, const mcv_inverse *inverse,
                               mcv_image *pattern, mcv_image *deviation, mcv_error *error) {
    const size_t pixels = (size_t)matrix->width * matrix->height,
                 elements = (size_t)inverse->group->width * inverse->group->height,
                 entries = matrix->row_begins[matrix->row_count];
    double *room =
        calloc(entries + 2 * pixels + elements * (matrix->replicates + 3) + 1, sizeof *room);
    if (!room) return mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    equations s = {.matrix = matrix,
                   .group = inverse->group,
                   .pixels = pixels,
                   .elements = elements,
                   .values = room,
                   .light = room + entries,
                   .wanted = room + entries + pixels,
                   .squares = room + entries + 2 * pixels,
                   .shown = room + entries + 2 * pixels + elements};
    const mcv_result result = find_all(&s, inverse, s.shown + elements, pattern, deviation, error);
    free(room);
    return result;
}
