/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/edge.h"

#include "analysis/form.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_edge_parse(const char *text, size_t number, const mcv_image *image, mcv_edge *edge,
                          mcv_error *error) {
    size_t count;
    *edge = (mcv_edge){0};
    return mcv_boxes_parse("edge", text, number, image, 1, edge->name, &edge->box, &count, error);
}

/* --- the rectangle, turned so that the edge is nearer to vertical
 * ------------------------------------------------- */

typedef struct patch {
    const mcv_readings *readings;
    const mcv_edge *edge;
    size_t columns, rows;
} patch;

static size_t index_of(const patch *p, size_t column, size_t row) {
    const size_t x = p->edge->box.x + (p->edge->across_rows ? column : row),
                 y = p->edge->box.y + (p->edge->across_rows ? row : column);
    return y * p->readings->values.width + x;
}

static double value_at(const patch *p, size_t column, size_t row) {
    return p->readings->values.pixels[index_of(p, column, row)];
}

static double variance_at(const patch *p, size_t column, size_t row) {
    const double u = p->readings->deviation.pixels[index_of(p, column, row)];
    return u * u;
}

static patch make_patch(const mcv_readings *readings, const mcv_edge *edge) {
    patch p = {
        .readings = readings, .edge = edge, .columns = edge->box.width, .rows = edge->box.height};
    if (!edge->across_rows) {
        p.columns = edge->box.height;
        p.rows = edge->box.width;
    }
    return p;
}

/* Noise adds alike to both sums. */
static bool is_across_rows(const mcv_readings *readings, const mcv_edge *edge) {
    const mcv_image *image = &readings->values;
    double dx = 0, dy = 0;
    for (size_t y = edge->box.y; y < edge->box.y + edge->box.height - 1; ++y)
        for (size_t x = edge->box.x; x < edge->box.x + edge->box.width - 1; ++x) {
            const float *v = image->pixels + y * image->width + x;
            dx += pow((double)v[1] - v[0] + v[image->width + 1] - v[image->width], 2);
            dy += pow((double)v[image->width] - v[0] + v[image->width + 1] - v[1], 2);
        }
    return dx >= dy;
}

/* --- the line
 * ---------------------------------------------------------------------------------------------------
 */

/* Of the patch: column = at + slope (row - middle), both of pixel centres; `left` and `right`
 * plateaus; window: half of what a row sums. */
typedef struct line {
    double at, slope, middle, window;
    double variance_at, variance_slope;
    mcv_quantity left, right;
} line;

static double line_column(const line *l, double row) {
    return l->at + l->slope * (row - l->middle);
}

double mcv_overlap(size_t pixel, double from, double to) {
    return fmax(0, fmin(to, (double)pixel + 1) - fmax(from, (double)pixel));
}

/* Plateaus from the pixels beyond the window. False where either has fewer than the rows. */
static bool find_plateaus(const patch *p, line *l) {
    double sums[2] = {0}, variances[2] = {0}, counts[2] = {0};
    for (size_t row = 0; row < p->rows; ++row) {
        const double middle = line_column(l, (double)row + 0.5);
        for (size_t column = 0; column < p->columns; ++column) {
            const double off = (double)column + 0.5 - middle;
            if (fabs(off) < l->window + 0.5) continue;
            sums[off > 0] += value_at(p, column, row);
            variances[off > 0] += variance_at(p, column, row);
            ++counts[off > 0];
        }
    }
    l->left = (mcv_quantity){sums[0] / counts[0], sqrt(variances[0]) / counts[0]};
    l->right = (mcv_quantity){sums[1] / counts[1], sqrt(variances[1]) / counts[1]};
    return fmin(counts[0], counts[1]) >= (double)p->rows;
}

/* Where an ideal step would hold the row's light inside the window; its variance by the row's own
 * pixels, and its slopes by the plateaus.
 */
static bool find_row(const patch *p, const line *l, size_t row, double *place, double *variance,
                     double by_plateau[2]) {
    const double middle = line_column(l, (double)row + 0.5), from = middle - l->window,
                 to = middle + l->window;
    const double step = l->right.value - l->left.value;
    if (from < 0 || to > (double)p->columns) return false;
    double bright = 0;
    *variance = 0;
    for (size_t column = (size_t)from; column < p->columns && (double)column < to; ++column) {
        const double share = mcv_overlap(column, from, to);
        bright += share * (value_at(p, column, row) - l->left.value) / step;
        *variance += share * share * variance_at(p, column, row) / (step * step);
    }
    *place = to - bright;
    by_plateau[0] = (2 * l->window - bright) / step;
    by_plateau[1] = bright / step;
    return true;
}

/* Least squares through the rows' places. False where fewer than half of the rows have room for
 * their window. */
static bool fit_line(const patch *p, line *l) {
    double n = 0, sum = 0, rows = 0;
    double row_variance = 0, plateau[2] = {0}, place, variance, slope[2];
    for (size_t row = 0; row < p->rows; ++row) {
        if (!find_row(p, l, row, &place, &variance, slope)) continue;
        ++n;
        rows += (double)row + 0.5;
        sum += place;
        row_variance += variance;
        for (int i = 0; i < 2; ++i) plateau[i] += slope[i];
    }
    if (2 * n < (double)p->rows || n < 3) return false;
    const double middle = rows / n;
    double xx = 0, xy = 0, vxx = 0;
    for (size_t row = 0; row < p->rows; ++row) {
        const double off = (double)row + 0.5 - middle;
        if (!find_row(p, l, row, &place, &variance, slope)) continue;
        xx += off * off;
        xy += off * (place - sum / n);
        vxx += off * off * variance;
    }
    *l = (line){.at = sum / n,
                .slope = xy / xx,
                .middle = middle,
                .window = l->window,
                .variance_at = row_variance / (n * n) +
                               pow(plateau[0] / n * l->left.uncertainty, 2) +
                               pow(plateau[1] / n * l->right.uncertainty, 2),
                .variance_slope = vxx / (xx * xx),
                .left = l->left,
                .right = l->right};
    return true;
}

/* --- the edge spread function
 * ------------------------------------------------------------------------------------- */

/* Bins of 1/4 pixel along the normal, the edge between bins `half - 1` and `half`. */
typedef struct bins {
    size_t half;
    double *count, *sum, *variance, *place, *place2;
} bins;

static void bins_free(bins *b) { free(b->count); }

/* As far as every row reaches. NULL without memory or room. */
static bool fill_bins(const patch *p, const line *l, bins *b) {
    const double cosine = 1 / sqrt(1 + l->slope * l->slope), first = line_column(l, 0.5),
                 last = line_column(l, (double)p->rows - 0.5);
    const double reach = fmin(fmin(first, last), (double)p->columns - fmax(first, last)) * cosine;
    *b = (bins){.half = reach > 1 ? (size_t)(reach * MCV_ESF_PER_PIXEL) : 0};
    b->count = b->half ? calloc(10 * b->half, sizeof *b->count) : NULL;
    if (!b->count) return false;
    b->sum = b->count + 2 * b->half;
    b->variance = b->sum + 2 * b->half;
    b->place = b->variance + 2 * b->half;
    b->place2 = b->place + 2 * b->half;
    for (size_t row = 0; row < p->rows; ++row)
        for (size_t column = 0; column < p->columns; ++column) {
            const double off = ((double)column + 0.5 - line_column(l, (double)row + 0.5)) * cosine;
            const double bin = floor(off * MCV_ESF_PER_PIXEL) + (double)b->half;
            if (bin < 0 || bin >= 2 * (double)b->half) continue;
            const size_t i = (size_t)bin;
            ++b->count[i];
            b->sum[i] += value_at(p, column, row);
            b->variance[i] += variance_at(p, column, row);
            b->place[i] += off;
            b->place2[i] += off * off;
        }
    return true;
}

/* The spread function's level in a bin. */
static double level_of(const bins *b, const line *l, size_t bin) {
    return (b->sum[bin] / b->count[bin] - l->left.value) / (l->right.value - l->left.value);
}

/* The next bin that holds pixels, from `bin` outwards or back; SIZE_MAX where there is none. */
static size_t next_bin(const bins *b, size_t bin, int direction) {
    do bin += (size_t)direction;
    while (bin < 2 * b->half && b->count[bin] == 0);
    return bin < 2 * b->half ? bin : SIZE_MAX;
}

/*
 * Where the spread function passes a level between its plateaus, the nearest to the edge: noise may
 * pass it anywhere. Between two bins it rises, nobody knows how; their distance times what it rises
 * is taken as the width of a uniform distribution.
 */
static mcv_quantity crossing(const bins *b, const line *l, double level) {
    const int outwards = level < 0.5 ? -1 : 1;
    size_t inner = next_bin(b, b->half - 1, 1);
    while (inner != SIZE_MAX && (level_of(b, l, inner) - level) * outwards >= 0)
        inner = next_bin(b, inner, -outwards);
    for (size_t outer; inner != SIZE_MAX; inner = outer) {
        outer = next_bin(b, inner, outwards);
        if (outer == SIZE_MAX) break;
        const double here = level_of(b, l, inner), there = level_of(b, l, outer);
        if ((there - level) * outwards < 0) continue;
        const double place = b->place[inner] / b->count[inner],
                     gap = b->place[outer] / b->count[outer] - place, slope = (there - here) / gap;
        const double noise = fmax(b->variance[inner] / pow(b->count[inner], 2),
                                  b->variance[outer] / pow(b->count[outer], 2));
        const double step = l->right.value - l->left.value, shape = gap * (there - here);
        return (mcv_quantity){place + (level - here) / slope,
                              sqrt(noise / pow(slope * step, 2) + shape * shape / 12)};
    }
    return (mcv_quantity){NAN, NAN};
}

/* The pixels within a reach of a place on the normal, and the parabola through them. Levels are
 * shares of the step. */
typedef struct nearby {
    double count, variance; /* of one pixel, in the mean */
    double level, slope,
        share; /* in the place: the parabola's, and how much of a pixel's variance its level has */
    double misfit; /* the variance about the parabola over that of the noise */
} nearby;

/* False where the parabola does not tell the level better than one pixel in the place would. */
static bool look_near(const patch *p, const line *l, double place, double reach, nearby *n) {
    const double cosine = 1 / sqrt(1 + l->slope * l->slope), step = l->right.value - l->left.value;
    double s[5] = {0}, r[3] = {0}, squares = 0;
    *n = (nearby){0};
    for (size_t row = 0; row < p->rows; ++row) {
        const double middle = line_column(l, (double)row + 0.5) - 0.5,
                     last = middle + (place + reach) / cosine;
        for (double column = fmax(0, ceil(middle + (place - reach) / cosine));
             column <= last && column < (double)p->columns; ++column) {
            const double t = ((column - middle) * cosine - place) / reach,
                         level = (value_at(p, (size_t)column, row) - l->left.value) / step;
            const double powers[5] = {1, t, t * t, t * t * t, t * t * t * t};
            for (int k = 0; k < 5; ++k) s[k] += powers[k];
            for (int k = 0; k < 3; ++k) r[k] += powers[k] * level;
            squares += level * level;
            n->variance += variance_at(p, (size_t)column, row) / (step * step);
        }
    }
    n->count = s[0];
    n->variance /= n->count;
    /* The inverse of the normal equations. */
    const double i00 = s[2] * s[4] - s[3] * s[3], i01 = s[2] * s[3] - s[1] * s[4],
                 i02 = s[1] * s[3] - s[2] * s[2], i11 = s[0] * s[4] - s[2] * s[2],
                 i12 = s[1] * s[2] - s[0] * s[3], i22 = s[0] * s[2] - s[1] * s[1];
    const double determinant = s[0] * i00 + s[1] * i01 + s[2] * i02;
    const double linear = (i01 * r[0] + i11 * r[1] + i12 * r[2]) / determinant,
                 bend = (i02 * r[0] + i12 * r[1] + i22 * r[2]) / determinant;
    n->level = (i00 * r[0] + i01 * r[1] + i02 * r[2]) / determinant;
    n->slope = linear / reach;
    n->share = i00 / determinant;
    n->misfit = n->count > 3 ? (squares - n->level * r[0] - linear * r[1] - bend * r[2]) /
                                   ((n->count - 3) * n->variance)
                             : 1;
    return n->share > 0 && n->share <= 1;
}

/*
 * Bins are too wide for the bends that a sharp edge has at its foot: pixels right around the
 * crossing tell, by a parabola, which follows a round foot. A bend within its reach h misleads it
 * by up to 0.02 h; h is so short that this is a fifth of what the noise σ of M pixels per pixel of
 * the normal does, 1.5 σ/√(2hM), but holds 8 pixels, or 6 where they are sparse. With those, where
 * the parabola misses them by clearly more than their noise, that is what is uncertain (Birge's
 * ratio).
 */
static mcv_quantity refine(const patch *p, const line *l, double target, mcv_quantity rough) {
    enum { ROUNDS = 6 };
    const double bin = 1.0 / MCV_ESF_PER_PIXEL, most = 2 * bin;
    mcv_quantity found = rough;
    for (int round = 0; round < ROUNDS; ++round) {
        nearby here;
        if (!look_near(p, l, found.value, bin, &here) || !(here.slope > 0)) return rough;
        const double density = here.count / (2 * bin), noise = sqrt(here.variance) / here.slope;
        const double least = fmax(3 / density, fmin(4 / density, 0.5 * bin));
        double reach = cbrt(pow(15 * noise, 2) / (2 * density));
        const bool bound = reach < least;
        reach = fmax(reach, least);
        while (reach < most && !look_near(p, l, found.value, reach, &here)) reach *= 1.25;
        if (reach >= most && !look_near(p, l, found.value, most, &here)) return rough;
        if (!(here.slope > 0)) return rough;
        const double clearly = 1 + sqrt(2 / fmax(1, here.count - 3)),
                     misfit = bound && here.misfit > clearly ? here.misfit : 1;
        found = (mcv_quantity){found.value + (target - here.level) / here.slope,
                               sqrt(here.share * here.variance * misfit) / here.slope};
        if (fabs(found.value - rough.value) > 2 * bin) return rough; /* noise leads it away */
    }
    return found;
}

static bool find_width(const patch *p, const line *l, mcv_quantity *width) {
    bins b;
    if (!fill_bins(p, l, &b)) return false;
    const mcv_quantity low = refine(p, l, 0.1, crossing(&b, l, 0.1)),
                       high = refine(p, l, 0.9, crossing(&b, l, 0.9));
    *width = (mcv_quantity){high.value - low.value, hypot(low.uncertainty, high.uncertainty)};
    bins_free(&b);
    return isfinite(width->value);
}

/* --- finding
 * ----------------------------------------------------------------------------------------------------
 */

static mcv_result fail_edge(const mcv_edge *edge, mcv_error *error, const char *why) {
    return mcv_fail(error, MCV_FAILED, "edge %s: %s", edge->name, why);
}

/* From the outer eighths of each row as plateaus and all between them as the window. */
static bool begin(const patch *p, line *l) {
    *l = (line){.at = 0.5 * (double)p->columns,
                .middle = 0.5 * (double)p->rows,
                .window = 0.375 * (double)p->columns};
    return find_plateaus(p, l) && l->left.value != l->right.value && fit_line(p, l);
}

/* The widest window that leaves the plateaus two pixels in every row. */
static double room_of(const patch *p, const line *l) {
    const double first = line_column(l, 0.5), last = line_column(l, (double)p->rows - 0.5);
    return fmin(fmin(first, last), (double)p->columns - fmax(first, last)) - 2.5;
}

static mcv_result find_line(const patch *p, line *l, mcv_quantity *width, mcv_error *error) {
    enum { ROUNDS = 12 };
    if (!begin(p, l))
        return fail_edge(
            p->edge, error,
            "no edge crosses the rectangle: it must pass all of its length, near the middle");
    l->window = fmax(1, fmin(l->window, room_of(p, l)));
    for (int round = 0; round < ROUNDS; ++round) {
        const line before = *l;
        if (!find_plateaus(p, l))
            return fail_edge(
                p->edge, error,
                "too little room beside it: the rectangle must hold more of both sides");
        const double noise = hypot(l->left.uncertainty, l->right.uncertainty),
                     step = fabs(l->right.value - l->left.value);
        if (!(step > 5 * noise))
            return fail_edge(p->edge, error, "no edge: both sides are equally bright");
        if (!fit_line(p, l))
            return fail_edge(
                p->edge, error,
                "too little room beside it: the rectangle must hold more of both sides");
        if (!find_width(p, l, width))
            return fail_edge(p->edge, error, "no edge: its sides have no level between them");
        const double cosine = 1 / sqrt(1 + l->slope * l->slope);
        const double least = (width->value + 1) / cosine, most = 0.375 * (double)p->columns;
        l->window = fmin(fmax(fmin((1.5 * width->value + 2) / cosine, room_of(p, l)), least), most);
        if (l->window == before.window && l->at == before.at && l->slope == before.slope)
            break; /* further rounds change nothing */
    }
    return MCV_OK;
}

/* One row's place about the line, and a polynomial there with that of one degree less. */
typedef struct row_place {
    double off, from, variance, polynomial, before;
} row_place;

/*
 * The places by polynomials that are orthogonal on the rows, each with its coefficient (Forsythe
 * 1957). That of the second degree is the arc. The next six tell what deviations of such lengths
 * come from anything but an arc and the noise of independent pixels, as of a corner behind a blur:
 * where they are clearly larger than that noise, they are the arc's uncertainty.
 */
static void find_sagitta(row_place *rows, size_t n, mcv_quantity *sagitta) {
    enum { ARC = 2, LAST = 8 };
    double norm = 1, arc = 0, others = 0, expected = 0, count = 0;
    for (size_t i = 0; i < n; ++i)
        rows[i] = (row_place){rows[i].off, rows[i].from, rows[i].variance, 1, 0};
    for (int degree = 0; degree <= LAST && (size_t)degree + 2 < n; ++degree) {
        double square = 0, moment = 0, product = 0, noise = 0;
        for (size_t i = 0; i < n; ++i) {
            const double q = rows[i].polynomial;
            square += q * q;
            moment += q * q * rows[i].off;
            product += q * rows[i].from;
            noise += q * q * rows[i].variance;
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

/* The rows' places about their line. False without memory. */
static bool find_form(const patch *p, const line *l, mcv_edge *edge) {
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
        double place, variance, slope[2];
        if (!find_row(p, l, row, &place, &variance, slope)) continue;
        const double from = place - line_column(l, (double)row + 0.5);
        places[n++] = (row_place){.off = off, .from = from, .variance = variance};
        rows->spread += off * off;
        rows->squares += from * from;
        rows->noise += variance;
        rows->noise2 += variance * variance;
    }
    rows->count = (double)n;
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

mcv_result mcv_edge_find(const mcv_readings *readings, mcv_edge *edge, mcv_error *error) {
    line l;
    edge->freedom = INFINITY;
    edge->across_rows = is_across_rows(readings, edge);
    const patch p = make_patch(readings, edge);
    MCV_TRY(find_line(&p, &l, &edge->width_10_90, error));
    const int across = edge->across_rows ? 0 : 1;
    const uint32_t corner[2] = {edge->box.x, edge->box.y};
    const double row = 0.5 * (double)p.rows, off = row - l.middle,
                 cosine = 1 / sqrt(1 + l.slope * l.slope);
    const double sign = l.right.value > l.left.value ? 1 : -1;
    edge->point[across] = corner[across] + line_column(&l, row);
    edge->point[!across] = corner[!across] + row;
    edge->normal[across] = sign * cosine;
    edge->normal[!across] = -sign * cosine * l.slope;
    edge->position =
        (mcv_quantity){edge->point[across], sqrt(l.variance_at + off * off * l.variance_slope)};
    edge->tilt = (mcv_quantity){atan(l.slope), sqrt(l.variance_slope) * cosine * cosine};
    edge->dark = sign > 0 ? l.left : l.right;
    edge->bright = sign > 0 ? l.right : l.left;
    edge->window = l.window;
    if (!find_form(&p, &l, edge)) return fail_edge(edge, error, "no memory for its rows");
    edge->rows.at += corner[across];
    edge->rows.middle += corner[!across];
    return MCV_OK;
}

/* --- noise that is not known
 * -------------------------------------------------------------------------------------- */

/*
 * The noise of the pixels at the signed distance `from` or more to the right of the edge (or to its
 * left), in the axis across it. NaN without memory, or where no pixel has all its neighbours there.
 */
static double side_noise(mcv_readings *readings, const mcv_edge *edge, bool right, double from,
                         double least, uint64_t *differences) {
    const mcv_image *image = &readings->values;
    mcv_roi side = {.width = image->width,
                    .height = image->height,
                    .inside = calloc((size_t)image->width * image->height, 1)};
    const patch p = make_patch(readings, edge);
    const uint32_t corner[2] = {edge->across_rows ? edge->box.x : edge->box.y,
                                edge->across_rows ? edge->box.y : edge->box.x};
    if (!side.inside) return NAN;
    for (size_t row = 0; row < p.rows; ++row) {
        const double middle =
            edge->rows.at - corner[0] +
            edge->rows.slope * ((double)row + 0.5 + corner[1] - edge->rows.middle);
        for (size_t column = 0; column < p.columns; ++column) {
            const double off = ((double)column + 0.5 - middle) * (right ? 1 : -1);
            if (!(off >= from) || isnan(value_at(&p, column, row))) continue;
            side.inside[index_of(&p, column, row)] = 1;
            ++side.count;
        }
    }
    const double noise = side.count ? mcv_roi_estimate_noise(readings, &side, least) : NAN;
    *differences = side.estimated;
    free(side.inside);
    return noise;
}

mcv_result mcv_edge_locate(mcv_readings *readings, double least, mcv_edge *edge, mcv_error *error) {
    double noise[2];
    uint64_t count[2] = {0};
    if (isnan(least)) return mcv_edge_find(readings, edge, error);
    (void)side_noise(readings, edge, true, -INFINITY, least,
                     count); /* of the whole box, to begin with */
    MCV_TRY(mcv_edge_find(readings, edge, error));
    for (int i = 0; i < 2; ++i)
        noise[i] = side_noise(readings, edge, i, edge->window + 0.5, least, count + i);
    if (!(noise[0] >= 0 && noise[1] >= 0))
        return fail_edge(edge, error,
                         "too little room beside it to see the image's noise: make the rectangle "
                         "larger, or give --noise");
    const patch p = make_patch(readings, edge);
    const double left =
        edge->normal[edge->across_rows ? 0 : 1] > 0 ? edge->dark.value : edge->bright.value;
    const double step = edge->dark.value + edge->bright.value - 2 * left;
    for (size_t row = 0; row < p.rows; ++row)
        for (size_t column = 0; column < p.columns; ++column) {
            /* Between the plateaus the variance goes with the grey value, as that of light does. */
            const double share = fmin(1, fmax(0, (value_at(&p, column, row) - left) / step));
            readings->deviation.pixels[index_of(&p, column, row)] =
                (float)sqrt((1 - share) * noise[0] * noise[0] + share * noise[1] * noise[1]);
        }
    MCV_TRY(mcv_edge_find(readings, edge, error));
    edge->freedom =
        mcv_noise_freedom((const double[]){noise[0] * noise[0], noise[1] * noise[1]}, count);
    const double widening = mcv_widening(edge->freedom);
    mcv_quantity *const all[] = {&edge->position, &edge->tilt,        &edge->dark,
                                 &edge->bright,   &edge->width_10_90, &edge->sagitta};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i) all[i]->uncertainty *= widening;
    return MCV_OK;
}

mcv_quantity mcv_edge_distance(const mcv_edge *a, const mcv_edge *b) {
    const double turn = a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1] < 0 ? -1 : 1;
    const double sum[2] = {a->normal[0] + turn * b->normal[0], a->normal[1] + turn * b->normal[1]},
                 length = hypot(sum[0], sum[1]);
    const double off[2] = {b->point[0] - a->point[0], b->point[1] - a->point[1]};
    const double along = (off[1] * sum[0] - off[0] * sum[1]) / length;
    /* Positions count along an axis; tilts turn the mean normal by half. */
    const double pa = a->position.uncertainty * cos(a->tilt.value),
                 pb = b->position.uncertainty * cos(b->tilt.value);
    const double turned = 0.5 * along * hypot(a->tilt.uncertainty, b->tilt.uncertainty);
    return (mcv_quantity){(off[0] * sum[0] + off[1] * sum[1]) / length,
                          sqrt(pa * pa + pb * pb + turned * turned)};
}

/* --- the modulation transfer function
 * ----------------------------------------------------------------------------- */

/* 1 up to three quarters of the reach, from there falling to 0: a hard end would ring. */
static double window_at(double place, double reach) {
    const double share = fabs(place) / reach;
    return share <= 0.75 ? 1 : share >= 1 ? 0 : 0.5 + 0.5 * cos(M_PI * (share - 0.75) / 0.25);
}

static double sinc(double x) { return x == 0 ? 1 : sin(M_PI * x) / (M_PI * x); }

/* F(ν) = Σ window (E_{k+1} - E_k) e^{-2πi ν x}, linear in the E_k, and what becomes of the bins'
 * variances. */
static mcv_quantity modulation_at(const mcv_edge_mtf *m, double frequency, double reach,
                                  double scatter) {
    double re = 0, im = 0, total = 0;
    const size_t n = m->count;
    for (size_t i = 0; i + 1 < n; ++i) {
        const double x = 0.5 * (m->place[i] + m->place[i + 1]),
                     d = window_at(x, reach) * (m->esf[i + 1].value - m->esf[i].value);
        re += d * cos(2 * M_PI * frequency * x);
        im -= d * sin(2 * M_PI * frequency * x);
        total += d;
    }
    const double length = hypot(re, im);
    double across = 0, variance = 0, before[3] = {0};
    for (size_t i = 0; i < n; ++i) {
        double here[3] = {0};
        if (i + 1 < n) {
            const double x = 0.5 * (m->place[i] + m->place[i + 1]), w = window_at(x, reach);
            here[0] = w * cos(2 * M_PI * frequency * x);
            here[1] = -w * sin(2 * M_PI * frequency * x);
            here[2] = w;
        }
        const double c[3] = {before[0] - here[0], before[1] - here[1], before[2] - here[2]},
                     v = m->esf[i].uncertainty * m->esf[i].uncertainty;
        const double slope =
            (re * c[0] + im * c[1]) / (length * total) - length * c[2] / (total * total);
        variance += v * slope * slope;
        across += v * pow((re * c[1] - im * c[0]) / length, 2);
        memcpy(before, here, sizeof before);
    }
    /*
     * Noise at right angles to F lengthens it; what that leaves uncertain is second order, and all
     * there is where F is no more than noise: the factor 2 lets the interval of a length without
     * signal (Rayleigh) hold 0 in 95 % of cases. Bins average over places that scatter, differences
     * over the step between bins.
     */
    const double corrected = fmax(0, length - across / (2 * length)) / fabs(total);
    const double loss =
        (1 - 0.5 * pow(2 * M_PI * frequency, 2) * scatter) * sinc(frequency / MCV_ESF_PER_PIXEL);
    variance += 2 * pow(across / (length * total), 2);
    return (mcv_quantity){corrected / loss, sqrt(variance) / loss};
}

static void find_mtf50(mcv_edge_mtf *m, double reach, double scatter) {
    m->mtf50 = (mcv_quantity){NAN, NAN};
    for (int k = 1; k < MCV_MTF_COUNT; ++k) {
        if (m->modulation[k].value > 0.5) continue;
        double low = m->frequency[k - 1], high = m->frequency[k];
        for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (low + high);
            if (modulation_at(m, middle, reach, scatter).value > 0.5)
                low = middle;
            else
                high = middle;
        }
        /* Over half of the way, or the noise would make the slope. */
        const double slope = (modulation_at(m, 0.75 * low, reach, scatter).value -
                              modulation_at(m, 1.25 * low, reach, scatter).value) /
                             (0.5 * low);
        m->mtf50 =
            (mcv_quantity){low, modulation_at(m, low, reach, scatter).uncertainty / fabs(slope)};
        return;
    }
}

static mcv_result spread(const mcv_edge *edge, const bins *b, const line *l, mcv_edge_mtf *m,
                         mcv_error *error) {
    double scatter = 0;
    const double step = l->right.value - l->left.value;
    m->count = 2 * b->half;
    m->place = calloc(m->count, sizeof *m->place);
    m->esf = calloc(m->count, sizeof *m->esf);
    m->lsf = calloc(m->count, sizeof *m->lsf);
    if (!m->place || !m->esf || !m->lsf)
        return fail_edge(edge, error, "no memory for its spread function");
    for (size_t i = 0; i < m->count; ++i) {
        const double n = b->count[i];
        if (n == 0)
            return fail_edge(
                edge, error,
                "its tilt leaves phases of the pixel grid unseen: tilt it by 2° to 10°");
        m->place[i] = b->place[i] / n;
        m->esf[i] = (mcv_quantity){(b->sum[i] / n - l->left.value) / step,
                                   sqrt(b->variance[i]) / (n * fabs(step))};
        scatter += (b->place2[i] / n - m->place[i] * m->place[i]) / (double)m->count;
    }
    for (size_t i = 0; i + 1 < m->count; ++i)
        m->lsf[i] = (m->esf[i + 1].value - m->esf[i].value) / (m->place[i + 1] - m->place[i]);
    const double reach = (double)b->half / MCV_ESF_PER_PIXEL;
    for (int k = 0; k < MCV_MTF_COUNT; ++k) {
        m->frequency[k] = (double)k / (MCV_MTF_COUNT - 1);
        m->modulation[k] = modulation_at(m, m->frequency[k], reach, scatter);
    }
    find_mtf50(m, reach, scatter);
    const double widening = mcv_widening(edge->freedom);
    for (size_t i = 0; i < m->count; ++i) m->esf[i].uncertainty *= widening;
    for (int k = 0; k < MCV_MTF_COUNT; ++k) m->modulation[k].uncertainty *= widening;
    m->mtf50.uncertainty *= widening;
    m->nyquist = m->modulation[MCV_MTF_COUNT / 2];
    return MCV_OK;
}

mcv_result mcv_edge_spread(const mcv_readings *readings, const mcv_edge *edge, mcv_edge_mtf *mtf,
                           mcv_error *error) {
    const patch p = make_patch(readings, edge);
    const double turn = edge->across_rows ? edge->normal[0] : edge->normal[1];
    const uint32_t corner = edge->across_rows ? edge->box.x : edge->box.y;
    line l = {.at = edge->position.value - corner,
              .slope = tan(edge->tilt.value),
              .middle = 0.5 * (double)p.rows};
    l.left = turn > 0 ? edge->dark : edge->bright;
    l.right = turn > 0 ? edge->bright : edge->dark;
    bins b;
    *mtf = (mcv_edge_mtf){0};
    if (fabs(l.slope) * (double)p.rows < 1)
        return fail_edge(
            edge, error,
            "it runs along the pixel grid, so its sharpness cannot be seen: tilt it by 2° to 10°");
    if (!fill_bins(&p, &l, &b))
        return fail_edge(edge, error, "too little room beside it for its spread function");
    const mcv_result result = spread(edge, &b, &l, mtf, error);
    bins_free(&b);
    if (result != MCV_OK) mcv_edge_mtf_free(mtf);
    return result;
}

void mcv_edge_mtf_free(mcv_edge_mtf *mtf) {
    free(mtf->place);
    free(mtf->esf);
    free(mtf->lsf);
    mtf->place = mtf->lsf = NULL;
    mtf->esf = NULL;
}
