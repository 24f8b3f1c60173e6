/* SPDX-License-Identifier: Apache-2.0 */
#include "triangulation/laser_line.h"

#include <math.h>

const char *const mcv_line_states[MCV_LINE_STATE_COUNT] = {
#define MCV_X(NAME, word) word,
    MCV_LINE_STATES(MCV_X)
#undef MCV_X
};

bool mcv_line_has_place(int state) { return state == MCV_LINE_SEEN || state == MCV_LINE_DOUBLE; }

/* One column or row. */
typedef struct profile {
    const mcv_line_settings *settings;
    const float *values, *deviations;
    size_t count, stride;
} profile;

static double at(const profile *p, ptrdiff_t i) {
    return (double)p->values[(size_t)i * p->stride] - p->settings->background;
}

/* What an extractor finds: the place from the middle of the brightest pixel, and the change of the
 * place with the value of each pixel from `first` on. */
typedef struct found {
    double place, weights[MCV_LINE_WINDOW];
    ptrdiff_t first;
    int count;
} found;

/* Are there pixels for `reach` of them on both sides? */
static bool is_inside(const profile *p, ptrdiff_t middle, ptrdiff_t reach) {
    return middle >= reach && middle + reach < (ptrdiff_t)p->count;
}

/* --- extractors --- */

static int take_centre(const profile *p, ptrdiff_t middle, found *f) {
    const ptrdiff_t reach = p->settings->window / 2;
    double sum = 0, moment = 0;
    if (!is_inside(p, middle, reach)) return MCV_LINE_CUT;
    for (ptrdiff_t k = -reach; k <= reach; ++k) {
        sum += at(p, middle + k);
        moment += (double)k * at(p, middle + k);
    }
    if (!(sum > 0)) return MCV_LINE_UNFIT;
    f->place = moment / sum;
    f->first = middle - reach;
    f->count = (int)(2 * reach + 1);
    for (int k = 0; k < f->count; ++k) f->weights[k] = (double)(k - reach) / sum - f->place / sum;
    return MCV_LINE_SEEN;
}

/* The top of a parabola through three values, and its change with each. */
static int take_top(const double v[3], double *top, double weights[3]) {
    const double bend = v[0] - 2 * v[1] + v[2];
    if (!(bend < 0)) return MCV_LINE_UNFIT;
    *top = (v[0] - v[2]) / (2 * bend);
    weights[0] = (0.5 - *top) / bend;
    weights[1] = 2 * *top / bend;
    weights[2] = (-0.5 - *top) / bend;
    return fabs(*top) <= 1 ? MCV_LINE_SEEN : MCV_LINE_UNFIT;
}

static int take_parabola(const profile *p, ptrdiff_t middle, bool of_logarithms, found *f) {
    double v[3], scale[3];
    if (!is_inside(p, middle, 1)) return MCV_LINE_CUT;
    for (int k = 0; k < 3; ++k) {
        const double value = at(p, middle + k - 1);
        if (of_logarithms && !(value > 0)) return MCV_LINE_UNFIT;
        v[k] = of_logarithms ? log(value) : value;
        scale[k] = of_logarithms ? 1 / value : 1;
    }
    f->first = middle - 1;
    f->count = 3;
    if (take_top(v, &f->place, f->weights) != MCV_LINE_SEEN) return MCV_LINE_UNFIT;
    for (int k = 0; k < 3; ++k) f->weights[k] *= scale[k];
    return MCV_LINE_SEEN;
}

/* Blais and Rioux's difference at a pixel: falls through 0 at the line. */
static double difference(const profile *p, ptrdiff_t i) {
    return at(p, i + 2) + at(p, i + 1) - at(p, i - 1) - at(p, i - 2);
}

static int take_crossing(const profile *p, ptrdiff_t middle, found *f) {
    static const int signs[] = {-1, -1, 0, 1, 1};
    if (!is_inside(p, middle, 3)) return MCV_LINE_CUT;
    const double here = difference(p, middle);
    const ptrdiff_t left = here >= 0 ? middle : middle - 1;
    const double from = difference(p, left), to = difference(p, left + 1), fall = from - to;
    if (!(from >= 0 && to <= 0 && fall > 0)) return MCV_LINE_UNFIT;
    f->place = (double)(left - middle) + from / fall;
    f->first = left - 2;
    f->count = 6;
    for (int k = 0; k < 6; ++k) {
        const int of_from = k < 5 ? signs[k] : 0, of_to = k > 0 ? signs[k - 1] : 0;
        f->weights[k] = (of_to * from - of_from * to) / (fall * fall);
    }
    return MCV_LINE_SEEN;
}

/*
 * Steger's ridge across the line: where Σ v t g(t) = 0, t being the distance of a pixel from the
 * place and g a Gaussian. That is the top of the values smoothed by g. Mean shift goes there from
 * afar, by Newton's steps where the values are bent like a top.
 */
static int take_ridge(const profile *p, ptrdiff_t middle, found *f) {
    enum { STEPS = 100 };
    const ptrdiff_t reach = p->settings->window / 2;
    const double sigma = p->settings->window / 8.0;
    double place = 0, bend = 0, change = 1;
    if (!is_inside(p, middle, reach)) return MCV_LINE_CUT;
    for (int step = 0; step < STEPS && fabs(change) > 1e-12; ++step) {
        double sum = 0, moment = 0;
        bend = 0;
        for (ptrdiff_t k = -reach; k <= reach; ++k) {
            const double t = ((double)k - place) / sigma,
                         light = at(p, middle + k) * exp(-t * t / 2);
            sum += light;
            moment += light * t * sigma;
            bend += light * (t * t - 1);
        }
        if (!(sum > 0)) return MCV_LINE_UNFIT;
        change = bend < -0.1 * sum ? -moment / bend : moment / sum;
        place += change;
    }
    if (!(bend < 0) || !(fabs(place) <= (double)reach / 2)) return MCV_LINE_UNFIT;
    f->place = place;
    f->first = middle - reach;
    f->count = (int)(2 * reach + 1);
    for (int k = 0; k < f->count; ++k) {
        const double t = ((double)(k - reach) - place) / sigma;
        f->weights[k] = -t * sigma * exp(-t * t / 2) / bend;
    }
    return MCV_LINE_SEEN;
}

/* --- the fit --- */

/* A Gaussian line integrated over pixel k, and its derivatives by amplitude, centre and sigma. */
static double model(const double line[3], double k, double by[3]) {
    const double scale = M_SQRT1_2 / line[2], low = (k - 0.5 - line[1]) * scale,
                 high = (k + 0.5 - line[1]) * scale, share = (erf(high) - erf(low)) / 2;
    const double rim_low = exp(-low * low) / sqrt(M_PI), rim_high = exp(-high * high) / sqrt(M_PI);
    by[0] = share;
    by[1] = line[0] * (rim_low - rim_high) * scale;
    by[2] = line[0] * (low * rim_low - high * rim_high) / line[2];
    return line[0] * share;
}

/* The inverse of a symmetric matrix of positive diagonal; false where it has none. */
static bool invert(double m[3][3], double inverse[3][3]) {
    double determinant = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            inverse[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    for (int i = 0; i < 3; ++i) determinant += m[0][i] * inverse[i][0];
    for (int i = 0; i < 9; ++i) inverse[i / 3][i % 3] /= determinant;
    return fabs(determinant) > 0 && isfinite(1 / determinant);
}

/* Sums of a step: JᵀJ, Jᵀr and r², r being the residuals. */
static double add_up(const profile *p, ptrdiff_t middle, const double line[3], double jj[3][3],
                     double jr[3]) {
    const ptrdiff_t reach = p->settings->window / 2;
    double squares = 0, by[3];
    for (int i = 0; i < 3; ++i) jr[i] = jj[i][0] = jj[i][1] = jj[i][2] = 0;
    for (ptrdiff_t k = -reach; k <= reach; ++k) {
        const double rest = at(p, middle + k) - model(line, (double)k, by);
        squares += rest * rest;
        for (int i = 0; i < 3; ++i) {
            jr[i] += by[i] * rest;
            for (int j = 0; j < 3; ++j) jj[i][j] += by[i] * by[j];
        }
    }
    return squares;
}

/* Levenberg and Marquardt's steps from a line that is about right. */
static bool fit(const profile *p, ptrdiff_t middle, double line[3]) {
    enum { STEPS = 60 };
    double jj[3][3], jr[3], inverse[3][3], damping = 1e-3;
    double squares = add_up(p, middle, line, jj, jr);
    for (int step = 0; step < STEPS; ++step) {
        double next[3], next_jj[3][3], next_jr[3], damped[3][3], change = 0;
        for (int i = 0; i < 9; ++i)
            damped[i / 3][i % 3] = jj[i / 3][i % 3] * (i % 4 ? 1 : 1 + damping);
        if (!invert(damped, inverse)) return false;
        for (int i = 0; i < 3; ++i) {
            next[i] = line[i];
            for (int j = 0; j < 3; ++j) next[i] += inverse[i][j] * jr[j];
        }
        change = fabs(next[1] - line[1]);
        const double then = next[2] > 0 ? add_up(p, middle, next, next_jj, next_jr) : INFINITY;
        const bool better = then <= squares;
        damping *= better ? 0.1 : 10;
        if (better) {
            squares = then;
            for (int i = 0; i < 9; ++i) jj[i / 3][i % 3] = next_jj[i / 3][i % 3];
            for (int i = 0; i < 3; ++i) line[i] = next[i], jr[i] = next_jr[i];
        }
        if (change < 1e-10 && isfinite(then)) return true;
        if (damping > 1e12) return better; /* rounding alone is left */
    }
    return true;
}

static int take_fit(const profile *p, ptrdiff_t middle, double sigma, found *f) {
    const ptrdiff_t reach = p->settings->window / 2;
    double jj[3][3], jr[3], inverse[3][3], by[3];
    double line[3] = {at(p, middle) * sigma * sqrt(2 * M_PI), 0, sigma};
    if (!is_inside(p, middle, reach)) return MCV_LINE_CUT;
    if (!fit(p, middle, line) || !(fabs(line[1]) <= (double)reach)) return MCV_LINE_UNFIT;
    add_up(p, middle, line, jj, jr);
    if (!invert(jj, inverse)) return MCV_LINE_UNFIT;
    f->place = line[1];
    f->first = middle - reach;
    f->count = (int)(2 * reach + 1);
    for (int k = 0; k < f->count; ++k) {
        model(line, (double)(k - reach), by);
        f->weights[k] = inverse[1][0] * by[0] + inverse[1][1] * by[1] + inverse[1][2] * by[2];
    }
    return MCV_LINE_SEEN;
}

/* --- peaks --- */

/* Pixels above the threshold, near to each other. */
typedef struct peak {
    ptrdiff_t brightest, last, end; /* equal neighbours from brightest to last are its top */
    double sum, moment, square;
} peak;

/* The next peak from a pixel on; false where there is none. */
static bool next_peak(const profile *p, ptrdiff_t from, peak *found_peak) {
    const ptrdiff_t count = (ptrdiff_t)p->count;
    ptrdiff_t i = from;
    while (i < count && !(at(p, i) > p->settings->threshold)) ++i;
    if (i == count) return false;
    *found_peak = (peak){.brightest = i, .last = i};
    const ptrdiff_t gap = p->settings->window / 2;
    for (ptrdiff_t above = i; i < count && i - above <= gap; ++i) {
        const double value = at(p, i), k = (double)i;
        if (!(value > p->settings->threshold)) continue;
        above = i;
        if (value > at(p, found_peak->brightest))
            found_peak->brightest = found_peak->last = i;
        else if (value == at(p, found_peak->brightest) && found_peak->last == i - 1)
            found_peak->last = i;
        found_peak->sum += value;
        found_peak->moment += k * value;
        found_peak->square += k * k * value;
    }
    found_peak->brightest = (found_peak->brightest + found_peak->last) / 2;
    found_peak->end = i;
    return true;
}

static int extract(const profile *p, ptrdiff_t middle, double sigma, found *f) {
    switch (p->settings->extractor) {
    case MCV_LINE_COG:
        return take_centre(p, middle, f);
    case MCV_LINE_PARABOLA:
        return take_parabola(p, middle, false, f);
    case MCV_LINE_LOG_GAUSS:
        return take_parabola(p, middle, true, f);
    case MCV_LINE_BLAIS_RIOUX:
        return take_crossing(p, middle, f);
    case MCV_LINE_STEGER:
        return take_ridge(p, middle, f);
    default:
        return take_fit(p, middle, sigma, f);
    }
}

static double uncertainty_of(const profile *p, const found *f) {
    double squares = 0;
    if (!p->deviations) return NAN;
    for (int k = 0; k < f->count; ++k) {
        const double one =
            f->weights[k] * (double)p->deviations[(size_t)(f->first + k) * p->stride];
        squares += one * one;
    }
    return sqrt(squares);
}

mcv_line_place mcv_line_find(const mcv_line_settings *settings, const float *values,
                             const float *deviations, size_t count, size_t stride) {
    const profile p = {settings, values, deviations, count, stride};
    mcv_line_place line = {
        .state = MCV_LINE_MISSING, .place = NAN, .sigma = NAN, .uncertainty = NAN};
    peak one, best = {.brightest = -1};
    double second = 0;
    for (ptrdiff_t from = 0; next_peak(&p, from, &one); from = one.end) {
        second = fmax(second, fmin(one.sum, best.sum));
        if (one.sum > best.sum) best = one;
    }
    if (best.brightest < 0) return line;
    found f;
    const double mean = best.moment / best.sum;
    line.peak = at(&p, best.brightest);
    line.sum = best.sum;
    line.sigma = sqrt(fmax(best.square / best.sum - mean * mean, 0));
    line.state = extract(&p, best.brightest, fmax(line.sigma, 0.3), &f);
    if (line.state != MCV_LINE_SEEN) return line;
    if (second >= best.sum / 2) line.state = MCV_LINE_DOUBLE;
    line.place = (double)best.brightest + 0.5 + f.place;
    line.uncertainty = uncertainty_of(&p, &f);
    return line;
}
