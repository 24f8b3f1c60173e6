/* SPDX-License-Identifier: Apache-2.0 */
/* The page and the drawing of an explained pixel: its routes, and their strongest paths in the
 * set-up. */
#include "explain/routes.h"

#include <stdio.h>
#include <stdlib.h>

#include "check/setup_drawing.h"
#include "check/setup_page.h"
#include "io/html.h"

/* Classes of rays that the style knows. */
enum { RAY_COLOURS = 3 };

/* What the drawings get in addition. */
typedef struct drawn {
    const mcv_routes *routes;
    size_t count;
} drawn;

/* The path from the lens to the emitter; to a far one it leaves the drawing. */
static void put_path(const mcv_drawing *c, const mcv_contribution *path, size_t number) {
    const uint32_t surfaces =
        path->surface_count < MCV_PATH_SURFACES ? path->surface_count : MCV_PATH_SURFACES;
    const double size = c->depth[1] - c->depth[0] + c->height[1] - c->height[0];
    const double *last = surfaces > 0 ? path->surfaces[surfaces - 1].position : path->sensor;
    double end[3];
    for (int k = 0; k < 3; ++k)
        end[k] = path->is_far ? last[k] + size * path->from[k] : path->from[k];
    fprintf(c->out, "<path class=\"ray chief ray%zu\" d=\"", number % RAY_COLOURS);
    mcv_drawing_point p = mcv_drawing_project(c, path->sensor);
    fprintf(c->out, "M%.1f %.1f", mcv_drawing_x(c, p.depth), mcv_drawing_y(c, p.height));
    for (uint32_t i = 0; i <= surfaces; ++i) {
        p = mcv_drawing_project(c, i < surfaces ? path->surfaces[i].position : end);
        fprintf(c->out, "L%.1f %.1f", mcv_drawing_x(c, p.depth), mcv_drawing_y(c, p.height));
    }
    fprintf(c->out, "\"><title>route %zu</title></path>\n", number + 1);
}

static void put_paths(const mcv_drawing *c, void *user) {
    const drawn *d = user;
    for (size_t i = d->count; i-- > 0;) put_path(c, &d->routes->items[i].strongest, i);
}

static bool put_table(FILE *out, const mcv_scene *scene, uint32_t sensor, const drawn *d) {
    fputs("<table><tr><th>route<th>share<th>from the camera to the light\n", out);
    for (size_t i = 0; i < d->count; ++i) {
        const mcv_route *route = d->routes->items + i;
        char *words = mcv_route_words(scene, sensor, route);
        if (!words) return false;
        fprintf(out, "<tr><td>%zu<td>%.3g&nbsp;&plusmn;&nbsp;%.2g&nbsp;%%&emsp;<td>", i + 1,
                100 * route->share, 100 * route->share_error);
        mcv_html_text(out, words);
        fputs("\n", out);
        free(words);
    }
    fputs("</table>\n", out);
    return true;
}

typedef struct page {
    const mcv_scene *scene;
    uint32_t sensor;
    const uint32_t *pixel;
    drawn drawn;
} page;

static bool put_page(FILE *out, void *user) {
    page *p = user;
    char title[80];
    snprintf(title, sizeof title, "Where the light of pixel %u, %u comes from", p->pixel[0],
             p->pixel[1]);
    mcv_html_begin(out, title, false, "");
    fputs("<p class=\"file\">", out);
    mcv_html_text(out, p->scene->path);
    fputs("</p>\n", out);
    if (!put_table(out, p->scene, p->sensor, &p->drawn)) return false;
    for (int above = 0; above < 2; ++above)
        if (!mcv_setup_put_view(out, p->scene, p->sensor, above, put_paths, &p->drawn))
            return false;
    fputs(
        "<p class=\"file\">Of each route its strongest path is drawn, projected onto the plane of "
        "the drawing. Bodies are drawn as their convex hulls.</p>\n</body></html>\n",
        out);
    return true;
}

mcv_result mcv_explain_page_write(const char *path, const mcv_scene *scene, uint32_t sensor,
                                  const uint32_t pixel[2], const mcv_routes *routes, size_t shown,
                                  mcv_error *error) {
    page p = {scene, sensor, pixel, {routes, routes->count < shown ? routes->count : shown}};
    return mcv_html_write(path, put_page, &p, error);
}

static bool put_file(FILE *out, void *user) {
    page *p = user;
    return mcv_setup_put_file(out, p->scene, p->sensor, put_paths, &p->drawn);
}

mcv_result mcv_explain_drawing_write(const char *path, const mcv_scene *scene, uint32_t sensor,
                                     const mcv_routes *routes, size_t shown, mcv_error *error) {
    page p = {scene, sensor, NULL, {routes, routes->count < shown ? routes->count : shown}};
    return mcv_html_write(path, put_file, &p, error);
}
