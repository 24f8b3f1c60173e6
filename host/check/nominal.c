/* SPDX-License-Identifier: Apache-2.0 */
#include "check/nominal.h"

#include <math.h>

/* The contour is searched within this distance of an edge [pixel]; growth is a few pixels at
 * most. */
static const double reach = 2;

/* The growth of the contour along an edge's line in a box, in pixels. */
static mcv_result growth_by_box(const mcv_part_view *view, const mcv_edge *edge,
                                const mcv_pixel_box *box, mcv_quantity *pixels, mcv_error *error) {
    const double length = edge->across_rows ? box->height : box->width,
                 scale = mcv_scale_along(view->pixel, edge->normal);
    const double middle[2] = {box->x + box->width / 2.0, box->y + box->height / 2.0};
    const double off = (middle[0] - edge->point[0]) * edge->normal[0] +
                       (middle[1] - edge->point[1]) * edge->normal[1];
    const double point[2] = {middle[0] - off * edge->normal[0], middle[1] - off * edge->normal[1]};
    mcv_quantity g;
    MCV_TRY(mcv_growth_at(view->scene, view->model, view->growth, point, edge->normal, length,
                          reach + 3 * view->growth->edge.value / scale, &g, error));
    *pixels = (mcv_quantity){g.value / scale, g.uncertainty / scale};
    return MCV_OK;
}

/*
 * Moves an edge to the part's contour. The growths of two edges have the same causes, so their
 * uncertainties add linearly. Each is taken √2 times; the root of the sum of both squares is then
 * that of a width.
 */
static void put_back(mcv_edge *edge, mcv_quantity pixels) {
    const double along = edge->normal[edge->across_rows ? 0 : 1];
    for (int i = 0; i < 2; ++i) edge->point[i] -= pixels.value * edge->normal[i];
    edge->position.value -= pixels.value / along;
    edge->position.uncertainty =
        hypot(edge->position.uncertainty, M_SQRT2 * pixels.uncertainty / along);
}

static mcv_result take_off_edge(const mcv_part_view *view, mcv_edge *edge, mcv_quantity *pixels,
                                mcv_error *error) {
    MCV_TRY(growth_by_box(view, edge, &edge->box, pixels, error));
    put_back(edge, *pixels);
    return MCV_OK;
}

static mcv_result take_off_line(const mcv_part_view *view, mcv_line *line, mcv_error *error) {
    mcv_quantity mean = {0, 0}, pixels;
    for (size_t i = 0; i < line->box_count; ++i) {
        MCV_TRY(growth_by_box(view, &line->edge, line->boxes + i, &pixels, error));
        mean.value += pixels.value / (double)line->box_count;
        mean.uncertainty += pixels.uncertainty / (double)line->box_count;
    }
    put_back(&line->edge, mean);
    return MCV_OK;
}

static mcv_result take_off_caliper(const mcv_part_view *view, mcv_caliper *caliper,
                                   mcv_error *error) {
    const mcv_edge *first = caliper->edges, *second = first + 1;
    /* Dark between the edges: each normal points away from the other edge. */
    const double across = (second->point[0] - first->point[0]) * first->normal[0] +
                          (second->point[1] - first->point[1]) * first->normal[1];
    const double sign = across < 0 ? -1 : 1;
    mcv_quantity grown[2];
    for (int i = 0; i < 2; ++i) MCV_TRY(take_off_edge(view, caliper->edges + i, grown + i, error));
    caliper->width.value += sign * (grown[0].value + grown[1].value);
    caliper->width.uncertainty =
        hypot(caliper->width.uncertainty, grown[0].uncertainty + grown[1].uncertainty);
    return MCV_OK;
}

static mcv_result take_off_circle(const mcv_part_view *view, mcv_circle *circle, mcv_error *error) {
    const double scale = mcv_scale_along(view->pixel, NULL),
                 centre[2] = {circle->column.value, circle->row.value};
    mcv_quantity g;
    if (isnan(scale))
        return mcv_fail(error, MCV_FAILED,
                        "pixels are not square in the object: a circle has no radius");
    MCV_TRY(mcv_growth_of_circle(view->scene, view->model, view->growth, centre,
                                 circle->radius.value, circle->bright,
                                 reach + 3 * view->growth->edge.value / scale, &g, error));
    const double sign = circle->bright ? 1 : -1, value = g.value / scale,
                 uncertainty = g.uncertainty / scale;
    circle->radius = (mcv_quantity){circle->radius.value + sign * value,
                                    hypot(circle->radius.uncertainty, uncertainty)};
    circle->diameter = (mcv_quantity){circle->diameter.value + 2 * sign * value,
                                      hypot(circle->diameter.uncertainty, 2 * uncertainty)};
    circle->covariance[2][2] += uncertainty * uncertainty;
    return MCV_OK;
}

mcv_result mcv_nominal_put_back(const mcv_part_view *view, mcv_found *found, mcv_error *error) {
    mcv_quantity pixels;
    switch (found->form) {
    case MCV_FORM_EDGE:
        return take_off_edge(view, &found->as.edge, &pixels, error);
    case MCV_FORM_LINE:
        return take_off_line(view, &found->as.line, error);
    case MCV_FORM_CALIPER:
        return take_off_caliper(view, &found->as.caliper, error);
    default:
        return take_off_circle(view, &found->as.circle, error);
    }
}
