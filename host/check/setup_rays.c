/* SPDX-License-Identifier: Apache-2.0 */
/* Light in the drawing of a set-up: emitters and their beams, the camera and its rays. */
#include "check/setup_drawing.h"

#include "io/html.h"
#include "scene/emitters.h"
#include "scene/geometry.h"

#include <math.h>
#include <stdlib.h>

/* The mean normal of an instance, and how uniform its normals are: 1 for a plane, 0 for a ball. */
static double facing(const mcv_scene *scene, uint32_t instance, double normal[3]) {
    const uint32_t triangles = scene->meshes[scene->instances[instance].mesh].triangle_count;
    double area = 0;
    for (int k = 0; k < 3; ++k) normal[k] = 0;
    for (uint32_t t = 0; t < triangles; ++t) {
        double face[3];
        mcv_scene_face_normal(scene, instance, t, face);
        area += sqrt(mcv_dot3(face, face));
        for (int k = 0; k < 3; ++k) normal[k] += face[k];
    }
    const double length = sqrt(mcv_dot3(normal, normal));
    return area > 0 ? length / area : 0;
}

void mcv_put_beam(const mcv_drawing *c, uint32_t emitter) {
    const mcv_emitter *e = c->scene->emitters + emitter;
    double normal[3], world[3];
    size_t count;
    if (e->instance == MCV_NONE || facing(c->scene, e->instance, normal) < 0.9) return;
    const double half_angle = mcv_emitter_half_angle(e);
    const bool collimated = e->type == MCV_EMITTER_COLLIMATED_BEAM;
    for (int k = 0; k < 3; ++k) world[k] = c->view->sensor->to_world.m[9 + k] + normal[k];
    const mcv_drawing_point n = mcv_drawing_project(c, world); /* a direction: seen from the lens */
    const double along = hypot(n.depth, n.height), whole = sqrt(mcv_dot3(normal, normal));
    mcv_drawing_point *hull = along > 0.7 * whole ? mcv_drawing_hull(c, e->instance, &count) : NULL;
    if (!hull) return;
    const double dz = n.depth / along, dh = n.height / along;
    mcv_drawing_point ends[2] = {hull[0], hull[0]};
    for (size_t i = 1; i < count; ++i) {
        const double across = hull[i].height * dz - hull[i].depth * dh;
        if (across < ends[0].height * dz - ends[0].depth * dh) ends[0] = hull[i];
        if (across > ends[1].height * dz - ends[1].depth * dh) ends[1] = hull[i];
    }
    const double angle = collimated ? 0 : isnan(half_angle) ? M_PI / 3 : fmin(half_angle, M_PI / 3);
    const double length =
                     (isnan(half_angle) && !collimated ? 0.06 : 0.2) * (c->depth[1] - c->depth[0]),
                 spread = length * tan(angle);
    const mcv_drawing_point far[2] = {
        {ends[0].depth + length * dz + spread * dh, ends[0].height + length * dh - spread * dz},
        {ends[1].depth + length * dz - spread * dh, ends[1].height + length * dh + spread * dz}};
    fputs("<path class=\"beam\" d=\"", c->out);
    mcv_put_points(c, (const mcv_drawing_point[]){ends[0], far[0], far[1], ends[1]}, 4);
    fputs("Z\"/>\n", c->out);
    free(hull);
}

void mcv_put_source(mcv_drawing *c, const mcv_emitter *e) {
    if (e->instance != MCV_NONE || !mcv_emitter_has_place(e->type)) return;
    const mcv_drawing_point at = mcv_drawing_project(c, e->to_world.m + 9);
    fprintf(c->out, "<circle class=\"light\" cx=\"%.1f\" cy=\"%.1f\" r=\"5\"><title>",
            mcv_drawing_x(c, at.depth), mcv_drawing_y(c, at.height));
    mcv_html_text(c->out, e->name);
    fputs("</title></circle>\n", c->out);
    mcv_put_name(c, mcv_drawing_x(c, at.depth), mcv_drawing_y(c, at.height) - 10, e->name);
}

void mcv_put_rays(const mcv_drawing *c, int colour, double film) {
    const mcv_sensor *sensor = c->view->sensor;
    const double end = c->depth[1], b = -c->film_at;
    for (int k = -1; k <= 1; ++k) {
        double lens, far, image;
        if (c->view->is_telecentric) {
            const mcv_telecentric_params *p = &sensor->as.telecentric;
            const double slope = k * p->stopDiameter / (2 * p->focalLength);
            lens = film - slope * c->focus;
            far = film + slope * (end - c->focus);
            image = -p->magnification * film;
        } else {
            const double kappa = isfinite(c->focus) ? 1 / c->focus : 0;
            lens = k * c->lens;
            far = lens + end * (film - kappa * lens);
            image = -b * film;
        }
        if (k != 0 && c->lens == 0) continue; /* a pinhole */
        fprintf(c->out, "<path class=\"ray ray%d%s\" d=\"", colour, k ? "" : " chief");
        mcv_put_points(c, (const mcv_drawing_point[]){{c->film_at, image}, {0, lens}, {end, far}},
                       3);
        fputs("\"/>\n", c->out);
    }
}

void mcv_put_camera(mcv_drawing *c) {
    const bool telecentric = c->view->is_telecentric;
    const double scale = telecentric ? c->view->sensor->as.telecentric.magnification : -c->film_at;
    const double x = mcv_drawing_x(c, 0), bulge = fmin(14, fmax(4, 0.12 * c->lens * c->scale[1]));
    fprintf(c->out, "<path class=\"film\" d=\"M%.1f %.1fV%.1f\"><title>film</title></path>\n",
            mcv_drawing_x(c, c->film_at), mcv_drawing_y(c, -scale * c->film[0]),
            mcv_drawing_y(c, -scale * c->film[1]));
    if (c->lens > 0)
        fprintf(c->out,
                "<path class=\"lens\" d=\"M%.1f %.1fQ%.1f %.1f %.1f %.1fQ%.1f %.1f %.1f "
                "%.1fZ\"><title>main lens</title></path>\n",
                x, mcv_drawing_y(c, c->lens), x + bulge, mcv_drawing_y(c, 0), x,
                mcv_drawing_y(c, -c->lens), x - bulge, mcv_drawing_y(c, 0), x,
                mcv_drawing_y(c, c->lens));
    else
        fprintf(
            c->out,
            "<path class=\"film\" d=\"M%.1f %.1fv-12m0 28v-12\"><title>pinhole</title></path>\n", x,
            mcv_drawing_y(c, 0) - 2);
    if (telecentric) {
        const mcv_telecentric_params *p = &c->view->sensor->as.telecentric;
        const double at = mcv_drawing_x(c, -p->focalLength), half = p->stopDiameter / 2;
        fprintf(c->out,
                "<path class=\"film\" d=\"M%.1f %.1fV%.1fM%.1f "
                "%.1fV%.1f\"><title>stop</title></path>\n",
                at, mcv_drawing_y(c, half), mcv_drawing_y(c, fmax(half * 1.5, 0.6 * c->lens)), at,
                mcv_drawing_y(c, -half), mcv_drawing_y(c, -fmax(half * 1.5, 0.6 * c->lens)));
    }
    mcv_put_name(c, x, mcv_drawing_y(c, c->lens) - 8, c->view->sensor->name);
}
