/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/line.h"

#include "analysis/form.h"
#include "core/basics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- a line through several edges --- */

mcv_result mcv_line_parse(const char *text, size_t number, const mcv_image *image, mcv_line *line,
                          mcv_error *error) {
    *line = (mcv_line){0};
    return mcv_boxes_parse("line", text, number, image, MCV_LINE_BOXES, line->edge.name,
                           line->boxes, &line->box_count, error);
}

/* What the line takes of each edge: its place in its middle row, its slope, and how many rows those
 * are from. */
typedef struct sums {
    double count, row, place, spread, slope;
} sums;

static sums add_up(const mcv_edge_rows *edges, size_t count) {
    sums s = {0};
    for (size_t i = 0; i < count; ++i) {
        s.count += edges[i].count;
        s.row += edges[i].count * edges[i].middle;
        s.place += edges[i].count * edges[i].at;
    }
    s.row /= s.count;
    s.place /= s.count;
    for (size_t i = 0; i < count; ++i) {
        const double off = edges[i].middle - s.row;
        s.spread += edges[i].spread + edges[i].count * off * off;
        s.slope +=
            edges[i].spread * edges[i].slope + edges[i].count * off * (edges[i].at - s.place);
    }
    s.slope /= s.spread;
    return s;
}

/* The distances of all rows' places from the line: those from their own edge's, and those of the
 * edges from the line. */
static mcv_scatter scatter_of(const mcv_edge_rows *edges, size_t count, const sums *s) {
    mcv_scatter all = {.count = s->count};
    for (size_t i = 0; i < count; ++i) {
        const mcv_edge_rows *e = edges + i;
        const double off = e->middle - s->row, from = e->at - s->place - s->slope * off,
                     turned = e->slope - s->slope;
        /* The line takes out two sums over many rows. */
        const double own = e->noise - 2 * e->shared, own2 = e->noise2 - 2 * e->shared * e->shared,
                     at = e->count * e->variance_at *
                          (1 - e->count * (1 / s->count + off * off / s->spread)),
                     slope = e->spread * e->variance_slope * (1 - e->spread / s->spread);
        all.squares += e->squares + e->count * from * from + e->spread * turned * turned;
        all.noise += own + at + slope;
        all.variance += 2 * (own2 + at * at + slope * slope);
        all.crossed += 4 * (fmax(0, e->squares - own) * e->shared +
                            e->count * from * from * e->count * e->variance_at +
                            e->spread * turned * turned * e->spread * e->variance_slope);
    }
    return all;
}

static void fit(const mcv_edge_rows *edges, size_t count, double freedom, mcv_line *line) {
    const sums s = add_up(edges, count);
    mcv_scatter scatter = scatter_of(edges, count, &s);
    mcv_edge *e = &line->edge;
    double at = 0, slope = 0;
    for (size_t i = 0; i < count; ++i) {
        const double share = edges[i].count / s.count,
                     lever = edges[i].count * (edges[i].middle - s.row) / s.spread;
        at += share * share * edges[i].variance_at;
        slope += lever * lever * edges[i].variance_at +
                 pow(edges[i].spread / s.spread, 2) * edges[i].variance_slope;
    }
    /* Places that scatter by clearly more than their noise say by how much (Birge's ratio). */
    const double clearly = scatter.noise + 3 * sqrt(scatter.variance),
                 misfit = scatter.squares / scatter.noise;
    const double wide = mcv_widening(freedom) * (scatter.squares > clearly ? sqrt(misfit) : 1),
                 cosine = 1 / sqrt(1 + s.slope * s.slope);
    const int across = e->across_rows ? 0 : 1;
    const double sign = e->normal[across] < 0 ? -1 : 1;
    e->point[across] = s.place;
    e->point[!across] = s.row;
    e->normal[across] = sign * cosine;
    e->normal[!across] = -sign * cosine * s.slope;
    e->position = (mcv_quantity){s.place, sqrt(at) * wide};
    e->tilt = (mcv_quantity){atan(s.slope), sqrt(slope) * cosine * cosine * wide};
    line->straightness = mcv_form_deviation(&scatter, freedom);
    line->straightness.value *= cosine;
    line->straightness.uncertainty *= cosine;
}

mcv_result mcv_line_locate(mcv_readings *readings, double least, mcv_line *line, mcv_error *error) {
    mcv_edge_rows *rows = malloc(line->box_count * sizeof *rows);
    mcv_result result = MCV_OK;
    double freedom = INFINITY;
    if (!rows)
        return mcv_fail(error, MCV_FAILED, "line %s: no memory for its edges", line->edge.name);
    for (size_t i = 0; result == MCV_OK && i < line->box_count; ++i) {
        mcv_edge edge = {.box = line->boxes[i]};
        snprintf(edge.name, sizeof edge.name, "%.*s, box %zu",
                 mcv_whole_characters(line->edge.name, 40), line->edge.name, i + 1);
        result = mcv_edge_locate(readings, least, &edge, error);
        if (result != MCV_OK) break;
        rows[i] = edge.rows;
        freedom = fmin(freedom, edge.freedom);
        memcpy(edge.name, line->edge.name, sizeof edge.name);
        if (i == 0) line->edge = edge;
        const mcv_edge *first = &line->edge;
        const double turn = edge.normal[0] * first->normal[0] + edge.normal[1] * first->normal[1];
        if (edge.across_rows != first->across_rows || turn < 0)
            result = mcv_fail(
                error, MCV_FAILED,
                "line %s: the edges in box %zu and in the first box must form one line: they must "
                "have one direction and be bright on the same side",
                first->name, i + 1);
    }
    if (result == MCV_OK) fit(rows, line->box_count, freedom, line);
    free(rows);
    return result;
}

/* --- a width --- */

mcv_result mcv_caliper_parse(const char *text, size_t number, const mcv_image *image,
                             mcv_caliper *caliper, mcv_error *error) {
    size_t count;
    *caliper = (mcv_caliper){0};
    MCV_TRY(mcv_boxes_parse("caliper", text, number, image, 1, caliper->name, &caliper->box, &count,
                            error));
    if (caliper->box.width == caliper->box.height)
        return mcv_fail(error, MCV_USAGE,
                        "caliper %s is square: make it longer in the direction of the width", text);
    return MCV_OK;
}

/* The mean over the shorter side, along the longer one. */
static void find_profile(const mcv_image *image, const mcv_pixel_box *box, double *profile) {
    const bool lying = box->width > box->height;
    const uint32_t length = lying ? box->width : box->height,
                   depth = lying ? box->height : box->width;
    for (uint32_t i = 0; i < length; ++i) {
        profile[i] = 0;
        for (uint32_t k = 0; k < depth; ++k) {
            const uint32_t x = box->x + (lying ? i : k), y = box->y + (lying ? k : i);
            profile[i] += (double)image->pixels[(size_t)y * image->width + x] / depth;
        }
    }
}

static double mean_of(const double *values, uint32_t from, uint32_t to) {
    double sum = 0;
    for (uint32_t i = from; i < to; ++i) sum += values[i];
    return sum / (to - from);
}

/*
 * The pixels of the profile in which the two edges are. A tilted edge's profile is a ramp without a
 * steepest place. Between the profile's strongest rise and fall, the middle third gives one
 * plateau, the outer halves give the other. The edge is where a step between them would have the
 * same light. False where there is no room.
 */
static bool find_middles(const double *profile, uint32_t length, uint32_t middles[2]) {
    double most[2] = {0, 0};
    uint32_t steepest[2] = {0, 0};
    for (uint32_t i = 1; i + 1 < length; ++i) {
        const double rise = profile[i + 1] - profile[i - 1];
        for (int sign = 0; sign < 2; ++sign) {
            if (!((sign ? -rise : rise) > most[sign])) continue;
            most[sign] = sign ? -rise : rise;
            steepest[sign] = i;
        }
    }
    const uint32_t low = steepest[0] < steepest[1] ? steepest[0] : steepest[1],
                   high = steepest[0] + steepest[1] - low;
    if (low < 5 || high + 5 >= length || high < low + 9) return false;
    const uint32_t third = (high - low) / 3, half = (low + high) / 2;
    const double inner = mean_of(profile, low + third, high - third),
                 before = mean_of(profile, 0, low / 2),
                 behind = mean_of(profile, high + (length - high) / 2, length);
    const double first = half * (mean_of(profile, 0, half) - inner) / (before - inner),
                 second = length - (length - half) * (mean_of(profile, half, length) - inner) /
                                       (behind - inner);
    if (!(first >= 4 && first < half && second > half && second < length - 4)) return false;
    middles[0] = (uint32_t)first;
    middles[1] = (uint32_t)second;
    return true;
}

mcv_result mcv_caliper_locate(mcv_readings *readings, double least, mcv_caliper *caliper,
                              mcv_error *error) {
    const mcv_pixel_box *box = &caliper->box;
    const bool lying = box->width > box->height;
    const uint32_t length = lying ? box->width : box->height;
    uint32_t middles[2] = {0, 0};
    double *profile = malloc(length * sizeof *profile);
    if (!profile)
        return mcv_fail(error, MCV_FAILED, "caliper %s: no memory for its profile", caliper->name);
    find_profile(&readings->values, box, profile);
    const bool found = find_middles(profile, length, middles);
    free(profile);
    const uint32_t low = middles[0], high = middles[1],
                   half = found ? (high - low - 1) / 2 : 0; /* no pixel belongs to both */
    for (int i = 0; i < 2; ++i) {
        /* About each edge as far as the box reaches and the other edge lets it. */
        const uint32_t middle = i ? high : low, beside = i ? length - 1 - high : low,
                       reach = half < beside ? half : beside;
        mcv_edge *edge = caliper->edges + i;
        *edge = (mcv_edge){.box = *box};
        snprintf(edge->name, sizeof edge->name, "%.*s, %s edge",
                 mcv_whole_characters(caliper->name, 40), caliper->name, i ? "second" : "first");
        if (reach < 5)
            return mcv_fail(
                error, MCV_FAILED,
                "caliper %s: the box must hold two opposite edges across its longer side, at least "
                "10 pixels apart, and at least 5 pixels beyond each",
                caliper->name);
        *(lying ? &edge->box.x : &edge->box.y) += middle - reach;
        *(lying ? &edge->box.width : &edge->box.height) = 2 * reach + 1;
        MCV_TRY(mcv_edge_locate(readings, least, edge, error));
        MCV_TRY(mcv_edge_is_straight(edge, error));
        if (edge->across_rows != lying)
            return mcv_fail(error, MCV_FAILED,
                            "caliper %s: its edges must run across its longer side", caliper->name);
    }
    const mcv_edge *a = caliper->edges, *b = a + 1;
    caliper->width = mcv_edge_distance(a, b);
    caliper->width.value = fabs(caliper->width.value);
    caliper->angle = (mcv_quantity){b->tilt.value - a->tilt.value,
                                    hypot(a->tilt.uncertainty, b->tilt.uncertainty)};
    return MCV_OK;
}
