/* SPDX-License-Identifier: Apache-2.0 */
/* The plane in focus in the drawing of a set-up, and the dimensions below it. */
#include "check/setup_drawing.h"

#include "core/basics.h"
#include "scene/emitters.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ROWS = 6 };

/* An arrow between two depths in the next row below the drawing. */
static void put_dimension(mcv_drawing *c, const char *class, double from, double to,
                          const char *text) {
    const double y = c->bottom + 24 + MCV_DRAWING_ROW * c->rows++, a = mcv_drawing_x(c, from),
                 b = mcv_drawing_x(c, to),
                 width = c->left + (c->depth[1] - c->depth[0]) * c->scale[0];
    const double letters = 7.0 * (double)strlen(text);
    fprintf(c->out,
            "<path class=\"dimension %s\" d=\"M%.1f %.1fH%.1fM%.1f %.1fv12M%.1f %.1fv12\"/>\n",
            class, a, y, b, a, y - 6, b, y - 6);
    if (b - a > letters + 12)
        mcv_put_label(c, "over", (a + b) / 2, y - 5, "middle", text);
    else if (b + letters + 12 < width)
        mcv_put_label(c, "size", b + 8, y + 4, "start", text);
    else
        mcv_put_label(c, "size", a - 8, y + 4, "end", text);
}

void mcv_put_field(const mcv_drawing *c) {
    const double depth = c->view->is_telecentric ? 1 : c->focus, low = c->film[0] * depth,
                 high = c->film[1] * depth;
    char text[2][32], words[96];
    const double x = mcv_drawing_x(c, c->focus), *dof = c->view->optics.depth_of_field;
    if (isfinite(dof[0])) {
        const double from = mcv_drawing_x(c, fmax(dof[0], c->depth[0])),
                     to = mcv_drawing_x(c, fmin(dof[1], c->depth[1]));
        fprintf(c->out,
                "<rect class=\"sharp\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" "
                "height=\"%.1f\"><title>depth of field</title></rect>\n",
                from, mcv_drawing_y(c, high), fmax(1, to - from),
                mcv_drawing_y(c, low) - mcv_drawing_y(c, high));
    }
    fprintf(c->out,
            "<path class=\"focus\" d=\"M%.1f %.1fV%.1fm-5 0h10M%.1f %.1fh10\"><title>plane in "
            "focus</title></path>\n",
            x, mcv_drawing_y(c, high), mcv_drawing_y(c, low), x - 5, mcv_drawing_y(c, high));
    snprintf(words, sizeof words, "field %s%s", mcv_length_in_words(high - low, text[0]),
             c->from_above ? " wide" : " high");
    mcv_put_label(c, "focus-text", mcv_drawing_inside(c, x, words),
                  fmin(mcv_drawing_y(c, low) + 16, c->bottom - 3), "middle", words);
}

void mcv_put_dimensions(mcv_drawing *c, const double parts[2]) {
    const mcv_optics *o = &c->view->optics;
    char text[2][32], words[160];
    if (isfinite(c->focus) && c->focus > 0) {
        snprintf(words, sizeof words, "working distance %s",
                 mcv_length_in_words(c->focus, text[0]));
        put_dimension(c, "of-focus", 0, c->focus, words);
        const double far = o->depth_of_field[1];
        snprintf(words, sizeof words, "depth of field %s to %s",
                 mcv_length_in_words(o->depth_of_field[0], text[0]),
                 isfinite(far) ? mcv_length_in_words(far, text[1]) : "infinity");
        if (isfinite(o->depth_of_field[0]))
            put_dimension(c, "of-focus", fmax(o->depth_of_field[0], c->depth[0]),
                          fmin(far, c->depth[1]), words);
    }
    if (parts[0] < parts[1]) {
        const bool thin = parts[1] - parts[0] < 1e-3 * parts[1];
        mcv_length_in_words(parts[0], text[0]);
        snprintf(words, sizeof words, "parts %s %s%s%s", thin ? "at" : "from", text[0],
                 thin ? "" : " to ", thin ? "" : mcv_length_in_words(parts[1], text[1]));
        put_dimension(c, "of-part", fmax(parts[0], c->depth[0]), fmin(parts[1], c->depth[1]),
                      words);
    }
    for (uint32_t i = 0; i < c->scene->emitter_count && c->rows < MOST_ROWS; ++i) {
        const mcv_emitter *e = c->scene->emitters + i;
        double at;
        if (e->instance != MCV_NONE)
            at = mcv_view_extent(c->view, c->scene, e->instance).middle[2];
        else if (mcv_emitter_has_place(e->type))
            at = mcv_drawing_project(c, e->to_world.m + 9).depth;
        else
            continue;
        const char *name = *e->name ? e->name : "light";
        snprintf(words, sizeof words, "%.*s at %s", mcv_whole_characters(name, 60), name,
                 mcv_length_in_words(fabs(at), text[0]));
        if (at < 0)
            snprintf(words + strlen(words), sizeof words - strlen(words), " behind the lens");
        if (at > c->depth[0] && at < c->depth[1])
            put_dimension(c, "of-light", fmin(0, at), fmax(0, at), words);
    }
}
