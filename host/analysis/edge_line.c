/* SPDX-License-Identifier: Apache-2.0 */
/* The box, turned so that its edge is nearer to vertical, and the straight line through the places
 * of the edge in its rows. */
#include "analysis/edge_line.h"

#include <math.h>

mcv_edge_patch mcv_patch_of(const mcv_readings *readings, const mcv_edge *edge) {
    mcv_edge_patch p = {
        .readings = readings, .edge = edge, .columns = edge->box.width, .rows = edge->box.height};
    if (!edge->across_rows) {
        p.columns = edge->box.height;
        p.rows = edge->box.width;
    }
    return p;
}

bool mcv_edge_is_across_rows(const mcv_readings *readings, const mcv_edge *edge) {
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

double mcv_overlap(size_t pixel, double from, double to) {
    return fmax(0, fmin(to, (double)pixel + 1) - fmax(from, (double)pixel));
}

bool mcv_edge_find_plateaus(const mcv_edge_patch *p, mcv_edge_line *l) {
    double sums[2] = {0}, variances[2] = {0}, counts[2] = {0};
    for (size_t row = 0; row < p->rows; ++row) {
        const double middle = mcv_edge_line_column(l, (double)row + 0.5);
        for (size_t column = 0; column < p->columns; ++column) {
            const double off = (double)column + 0.5 - middle;
            if (fabs(off) < l->window + 0.5) continue;
            sums[off > 0] += mcv_patch_value(p, column, row);
            variances[off > 0] += mcv_patch_summed_variance(p, column, row, 2);
            ++counts[off > 0];
        }
    }
    l->left = (mcv_quantity){sums[0] / counts[0], sqrt(variances[0]) / counts[0]};
    l->right = (mcv_quantity){sums[1] / counts[1], sqrt(variances[1]) / counts[1]};
    return fmin(counts[0], counts[1]) >= (double)p->rows;
}

bool mcv_edge_find_row(const mcv_edge_patch *p, const mcv_edge_line *l, size_t row,
                       mcv_edge_row *found) {
    const double middle = mcv_edge_line_column(l, (double)row + 0.5), from = middle - l->window,
                 to = middle + l->window;
    const double step = l->right.value - l->left.value;
    if (from < 0 || to > (double)p->columns) return false;
    double bright = 0;
    *found = (mcv_edge_row){0};
    for (size_t column = (size_t)from; column < p->columns && (double)column < to; ++column) {
        const double share = mcv_overlap(column, from, to), part = share * share / (step * step);
        bright += share * (mcv_patch_value(p, column, row) - l->left.value) / step;
        found->variance += part * mcv_patch_summed_variance(p, column, row, 1);
        found->shared += part * mcv_patch_summed_variance(p, column, row, 2);
    }
    found->place = to - bright;
    found->by_plateau[0] = (2 * l->window - bright) / step;
    found->by_plateau[1] = bright / step;
    return true;
}

bool mcv_edge_fit_line(const mcv_edge_patch *p, mcv_edge_line *l) {
    double n = 0, sum = 0, rows = 0, row_variance = 0, plateau[2] = {0};
    mcv_edge_row found;
    for (size_t row = 0; row < p->rows; ++row) {
        if (!mcv_edge_find_row(p, l, row, &found)) continue;
        ++n;
        rows += (double)row + 0.5;
        sum += found.place;
        row_variance += found.shared;
        for (int i = 0; i < 2; ++i) plateau[i] += found.by_plateau[i];
    }
    if (2 * n < (double)p->rows || n < 3) return false;
    const double middle = rows / n;
    double xx = 0, xy = 0, vxx = 0;
    for (size_t row = 0; row < p->rows; ++row) {
        const double off = (double)row + 0.5 - middle;
        if (!mcv_edge_find_row(p, l, row, &found)) continue;
        xx += off * off;
        xy += off * (found.place - sum / n);
        vxx += off * off * found.shared;
    }
    *l = (mcv_edge_line){.at = sum / n,
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
