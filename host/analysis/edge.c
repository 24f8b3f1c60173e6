/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/edge_line.h"

#include <math.h>
#include <stdlib.h>

mcv_result mcv_edge_parse(const char *text, size_t number, const mcv_image *image, mcv_edge *edge,
                          mcv_error *error) {
    size_t count;
    *edge = (mcv_edge){0};
    return mcv_boxes_parse("edge", text, number, image, 1, edge->name, &edge->box, &count, error);
}

mcv_result mcv_edge_fail(const mcv_edge *edge, mcv_error *error, const char *why) {
    return mcv_fail(error, MCV_FAILED, "edge %s: %s", edge->name, why);
}

/* From the outer eighths of each row as plateaus and all between them as the window. */
static bool begin(const mcv_edge_patch *p, mcv_edge_line *l) {
    *l = (mcv_edge_line){.at = 0.5 * (double)p->columns,
                         .middle = 0.5 * (double)p->rows,
                         .window = 0.375 * (double)p->columns};
    return mcv_edge_find_plateaus(p, l) && l->left.value != l->right.value &&
           mcv_edge_fit_line(p, l);
}

/* The widest window that leaves the plateaus two pixels in every row. */
static double room_of(const mcv_edge_patch *p, const mcv_edge_line *l) {
    const double first = mcv_edge_line_column(l, 0.5),
                 last = mcv_edge_line_column(l, (double)p->rows - 0.5);
    return fmin(fmin(first, last), (double)p->columns - fmax(first, last)) - 2.5;
}

static mcv_result find_line(const mcv_edge_patch *p, mcv_edge_line *l, mcv_quantity *width,
                            mcv_error *error) {
    enum { ROUNDS = 12 };
    if (!begin(p, l))
        return mcv_edge_fail(
            p->edge, error,
            "no edge crosses the rectangle: the edge must pass its whole length, near the middle");
    l->window = fmax(1, fmin(l->window, room_of(p, l)));
    for (int round = 0; round < ROUNDS; ++round) {
        const mcv_edge_line before = *l;
        if (!mcv_edge_find_plateaus(p, l))
            return mcv_edge_fail(p->edge, error,
                                 "the rectangle holds too little of one side: make it larger");
        const double noise = hypot(l->left.uncertainty, l->right.uncertainty),
                     step = fabs(l->right.value - l->left.value);
        if (!(step > 5 * noise))
            return mcv_edge_fail(p->edge, error, "no edge: both sides are equally bright");
        if (!mcv_edge_fit_line(p, l))
            return mcv_edge_fail(p->edge, error,
                                 "the rectangle holds too little of one side: make it larger");
        if (!mcv_edge_find_width(p, l, width))
            return mcv_edge_fail(p->edge, error, "no edge: its sides have no level between them");
        const double cosine = 1 / sqrt(1 + l->slope * l->slope);
        const double least = (width->value + 1) / cosine, most = 0.375 * (double)p->columns;
        l->window = fmin(fmax(fmin((1.5 * width->value + 2) / cosine, room_of(p, l)), least), most);
        if (l->window == before.window && l->at == before.at && l->slope == before.slope)
            break; /* further rounds change nothing */
    }
    return MCV_OK;
}

mcv_result mcv_edge_find(const mcv_readings *readings, mcv_edge *edge, mcv_error *error) {
    mcv_edge_line l;
    edge->freedom = INFINITY;
    edge->across_rows = mcv_edge_is_across_rows(readings, edge);
    const mcv_edge_patch p = mcv_patch_of(readings, edge);
    MCV_TRY(find_line(&p, &l, &edge->width_10_90, error));
    const int across = edge->across_rows ? 0 : 1;
    const uint32_t corner[2] = {edge->box.x, edge->box.y};
    const double row = 0.5 * (double)p.rows, off = row - l.middle,
                 cosine = 1 / sqrt(1 + l.slope * l.slope);
    const double sign = l.right.value > l.left.value ? 1 : -1;
    edge->point[across] = corner[across] + mcv_edge_line_column(&l, row);
    edge->point[!across] = corner[!across] + row;
    edge->normal[across] = sign * cosine;
    edge->normal[!across] = -sign * cosine * l.slope;
    edge->position =
        (mcv_quantity){edge->point[across], sqrt(l.variance_at + off * off * l.variance_slope)};
    edge->tilt = (mcv_quantity){atan(l.slope), sqrt(l.variance_slope) * cosine * cosine};
    edge->dark = sign > 0 ? l.left : l.right;
    edge->bright = sign > 0 ? l.right : l.left;
    edge->window = l.window;
    if (!mcv_edge_find_form(&p, &l, edge))
        return mcv_edge_fail(edge, error, "no memory for its rows");
    edge->rows.at += corner[across];
    edge->rows.middle += corner[!across];
    return MCV_OK;
}

/* --- noise that is not known --- */

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
    const mcv_edge_patch p = mcv_patch_of(readings, edge);
    const uint32_t corner[2] = {edge->across_rows ? edge->box.x : edge->box.y,
                                edge->across_rows ? edge->box.y : edge->box.x};
    if (!side.inside) return NAN;
    for (size_t row = 0; row < p.rows; ++row) {
        const double middle =
            edge->rows.at - corner[0] +
            edge->rows.slope * ((double)row + 0.5 + corner[1] - edge->rows.middle);
        for (size_t column = 0; column < p.columns; ++column) {
            const double off = ((double)column + 0.5 - middle) * (right ? 1 : -1);
            if (!(off >= from) || isnan(mcv_patch_value(&p, column, row))) continue;
            side.inside[mcv_patch_index(&p, column, row)] = 1;
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
        return mcv_edge_fail(
            edge, error,
            "the rectangle shows too little beside it to estimate the image's noise: make it "
            "larger, or give --noise");
    const mcv_edge_patch p = mcv_patch_of(readings, edge);
    const double left =
        edge->normal[edge->across_rows ? 0 : 1] > 0 ? edge->dark.value : edge->bright.value;
    const double step = edge->dark.value + edge->bright.value - 2 * left;
    for (size_t row = 0; row < p.rows; ++row)
        for (size_t column = 0; column < p.columns; ++column) {
            /* Between the plateaus the variance goes with the grey value, as that of light does. */
            const double share = fmin(1, fmax(0, (mcv_patch_value(&p, column, row) - left) / step));
            const size_t i = mcv_patch_index(&p, column, row);
            readings->deviation.pixels[i] =
                (float)sqrt((1 - share) * noise[0] * noise[0] + share * noise[1] * noise[1] +
                            mcv_readings_render_variance(readings, i));
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
