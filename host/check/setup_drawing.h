/* SPDX-License-Identifier: Apache-2.0 */
/* The drawing of one sensor's set-up, from the side or from above (check/setup_page.c): what its
 * parts share. */
#ifndef MCVISI_HOST_CHECK_SETUP_DRAWING_H
#define MCVISI_HOST_CHECK_SETUP_DRAWING_H

#include "check/find.h"

#include <stdio.h>

/* CSS pixels above a drawing, and of each row of dimensions below it; number of named parts. Other
 * parts show their names under the pointer. */
enum { MCV_DRAWING_TOP = 10, MCV_DRAWING_ROW = 30, MCV_DRAWING_NAMES = 32 };

/* A point of a drawing [m]: depth from the lens, height above the axis. */
typedef struct mcv_drawing_point {
    double depth, height;
} mcv_drawing_point;

/* Puts what lies over a drawing. */
typedef struct mcv_drawing mcv_drawing;
typedef void mcv_drawing_overlay(const mcv_drawing *c, void *user);

/* One drawing: its contents, its place, and the names on it. */
struct mcv_drawing {
    FILE *out;
    const mcv_scene *scene;
    const mcv_view *view;
    bool from_above;
    bool alone;      /* a file of its own instead of a figure on a page */
    double film[2];  /* of the view, along the drawing's height */
    double focus;    /* depth of the plane in focus, or NaN */
    double film_at;  /* depth of the film [m], negative */
    double lens;     /* half its width [m] */
    double depth[2]; /* what is shown [m] */
    double height[2];
    double scale[2]; /* CSS pixels per metre along depth and height */
    double left, bottom;
    int number, rows;
    struct {
        double x, y, half; /* [CSS pixels] */
    } names[MCV_DRAWING_NAMES];
    int name_count;
    mcv_drawing_overlay *overlay; /* or NULL */
    void *user;                   /* of it */
};

static inline double mcv_drawing_x(const mcv_drawing *c, double depth) {
    return c->left + (depth - c->depth[0]) * c->scale[0];
}
static inline double mcv_drawing_y(const mcv_drawing *c, double height) {
    return MCV_DRAWING_TOP + (c->height[1] - height) * c->scale[1];
}

/* From above, what is to the right of the camera is drawn below its axis. */
static inline mcv_drawing_point mcv_drawing_project(const mcv_drawing *c, const double world[3]) {
    double local[3];
    mcv_view_point(c->view, world, local);
    return (mcv_drawing_point){local[2], c->from_above ? -local[0] : local[1]};
}

/* setup_drawing.c */

bool mcv_put_drawing(mcv_drawing *c);

/* setup_style.c: the style of a drawing that is a file of its own. Colours stand in it as they are
 * on a light page: few programs beside browsers know variables of CSS. */
void mcv_put_drawing_style(FILE *out);

/* setup_outline.c */

/* Omits points that cannot be distinguished from the one before. */
void mcv_put_points(const mcv_drawing *c, const mcv_drawing_point *points, size_t count);
void mcv_put_label(const mcv_drawing *c, const char *class, double x, double y, const char *anchor,
                   const char *text);

/* The position of a text's middle that keeps it inside the drawing. */
double mcv_drawing_inside(const mcv_drawing *c, double x, const char *text);

/* Puts a name above a point, unless it would overlap another name. */
void mcv_put_name(mcv_drawing *c, double x, double y, const char *name);

/* The convex hull of an instance's vertices in the drawing (Andrew 1979); NULL without memory. */
mcv_drawing_point *mcv_drawing_hull(const mcv_drawing *c, uint32_t instance, size_t *count);
void mcv_put_outline(mcv_drawing *c, uint32_t instance, bool labelled);

/* setup_rays.c */

/* The light of a surface: drawn from its two ends over a part of the drawing, with the half-angle
 * of its cone. */
void mcv_put_beam(const mcv_drawing *c, uint32_t emitter);

/* Lights without extent. */
void mcv_put_source(mcv_drawing *c, const mcv_emitter *e);

/* Rays of a point of the film, at `film` in the view's units, through the middle and the edges of
 * the pupil. */
void mcv_put_rays(const mcv_drawing *c, int colour, double film);
void mcv_put_camera(mcv_drawing *c);

/* setup_dimensions.c */

void mcv_put_field(const mcv_drawing *c);
void mcv_put_dimensions(mcv_drawing *c, const double parts[2]);

#endif
