/* SPDX-License-Identifier: Apache-2.0 */
/* Findings about sensors: what is in their fields, its sharpness, and its size. */
#include "check/find.h"
#include "scene/geometry.h"
#include "scene/materials.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* --- sees_nothing --- */

/* The largest slope of a ray that enters a lens: that of the chief ray in a corner, plus that of
 * the marginal rays. */
static double steepest(const mcv_sensor *sensor) {
    const mcv_view view = mcv_view_of(sensor);
    double corner[2];
    for (int i = 0; i < 2; ++i) corner[i] = fmax(fabs(view.film[i][0]), fabs(view.film[i][1]));
    switch (sensor->type) {
    case MCV_SENSOR_TELECENTRIC:
        return sensor->as.telecentric.stopDiameter / (2 * sensor->as.telecentric.focalLength);
    case MCV_SENSOR_THIN_LENS:
    case MCV_SENSOR_LIGHT_FIELD:
        return hypot(corner[0], corner[1]) +
               fabs(1 / view.optics.focused_depth) * mcv_lens_radius(sensor);
    case MCV_SENSOR_PINHOLE:
        return hypot(corner[0], corner[1]);
    default:
        return INFINITY;
    }
}

/* The middle of an instance's box in the world, and the distance of the farthest vertex from there.
 */
static void ball_of(const mcv_scene *scene, uint32_t instance, double centre[3], double *radius) {
    double lower[3], upper[3], world[3];
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    mcv_scene_box(scene, instance, lower, upper);
    for (int k = 0; k < 3; ++k) centre[k] = (lower[k] + upper[k]) / 2;
    *radius = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        mcv_scene_vertex(scene, instance, v, world);
        for (int k = 0; k < 3; ++k) world[k] -= centre[k];
        *radius = fmax(*radius, sqrt(mcv_dot3(world, world)));
    }
}

/* Does a part of a ball lie within `tangent` of the lens's edge, per depth? Near the edge the
 * answer may be a false yes. */
static bool takes_in(const mcv_sensor *sensor, double tangent, const double centre[3],
                     double radius) {
    const mcv_view view = {.sensor = sensor};
    double local[3];
    mcv_view_point(&view, centre, local);
    const double aside = hypot(local[0], local[1]);
    if (local[2] + radius <= 0) return false;
    return !isfinite(tangent) ||
           aside - mcv_lens_radius(sensor) - tangent * local[2] <= radius * hypot(1, tangent);
}

static bool sees_nothing(const mcv_scene *scene, const mcv_sensor *sensor) {
    const double tangent = steepest(sensor);
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        if (scene->emitters[i].type == MCV_EMITTER_ENVIRONMENT) return false;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        double centre[3], radius;
        ball_of(scene, i, centre, &radius);
        if (takes_in(sensor, tangent, centre, radius)) return false;
    }
    return true;
}

mcv_result mcv_find_sees_nothing(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_sensor *sensor = scene->sensors + i;
        if (sees_nothing(scene, sensor))
            MCV_TRY(mcv_findings_add(
                findings, MCV_SEVERITY_ERROR, "sensors", sensor->name, NULL, error,
                "sensor \"%s\" sees nothing: no part and no emitter lies before it (-z): turn it",
                sensor->name));
    }
    return MCV_OK;
}

/* --- outside --- */

/* Does the image show a mirror? Things seen in it lie elsewhere. */
static bool shows_mirror(const mcv_view *view, const mcv_scene *scene) {
    for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end); i < scene->instance_count;
         i = mcv_next_part(scene, i + 1, &end)) {
        if (!mcv_is_mirror(scene->materials + scene->instances[i].material)) continue;
        const mcv_extent extent = mcv_view_extent(view, scene, i);
        if (mcv_view_shows(view, &extent)) return true;
    }
    return false;
}

/* The distance of a part from the middle of the field, in units of half the field; used to find the
 * nearest part. */
static double remoteness(const mcv_view *view, const mcv_extent *e) {
    if (!(e->depth[1] > 0)) return INFINITY;
    double most = 0;
    for (int i = 0; i < 2; ++i) {
        const double middle = 0.5 * (view->film[i][0] + view->film[i][1]),
                     half = 0.5 * (view->film[i][1] - view->film[i][0]);
        most = fmax(most, fmax(e->film[i][0] - middle, middle - e->film[i][1]) / half);
    }
    return most;
}

static mcv_result report_outside(const mcv_scene *scene, const mcv_view *view, uint32_t part,
                                 mcv_findings *findings, mcv_error *error) {
    const mcv_extent e = mcv_view_extent(view, scene, part);
    const char *camera = view->sensor->name;
    char label[MCV_LABEL], text[4][32];
    mcv_instance_label(scene, part, label);
    if (!(e.depth[1] > 0))
        return mcv_findings_add(findings, MCV_SEVERITY_ERROR, "sensors", camera, NULL, error,
                                "sensor \"%s\" has no part in its field: %s lies behind it by %s "
                                "or more: turn the sensor, which "
                                "looks along its node's -z, or move it",
                                camera, label, mcv_length_in_words(-e.depth[1], text[0]));
    const double scale = view->is_telecentric ? 1 : e.middle[2];
    static const char *const sides[2][2] = {{"to the left of", "to the right of"},
                                            {"below", "above"}};
    char aside[128] = "";
    for (int i = 0; i < 2; ++i) {
        if (e.film[i][1] >= view->film[i][0] && e.film[i][0] <= view->film[i][1]) continue;
        const size_t length = strlen(aside);
        snprintf(aside + length, sizeof aside - length, "%s%s %s", length ? " and " : "",
                 mcv_length_in_words(fabs(e.middle[i]), text[0]), sides[i][e.middle[i] > 0]);
    }
    return mcv_findings_add(
        findings, MCV_SEVERITY_ERROR, "sensors", camera, NULL, error,
        "sensor \"%s\" has no part in its field: the middle of the nearest, %s, lies %s its axis "
        "at a depth of %s, "
        "where the field is %s x %s: move or turn one of them",
        camera, label, aside, mcv_length_in_words(e.middle[2], text[1]),
        mcv_length_in_words(scale * (view->film[0][1] - view->film[0][0]), text[2]),
        mcv_length_in_words(scale * (view->film[1][1] - view->film[1][0]), text[3]));
}

mcv_result mcv_find_outside(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t s = 0; s < scene->sensor_count; ++s) {
        const mcv_view view = mcv_view_of(scene->sensors + s);
        uint32_t nearest = MCV_NONE;
        double least = INFINITY;
        bool shown = false;
        for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end);
             i < scene->instance_count && !shown; i = mcv_next_part(scene, i + 1, &end)) {
            const mcv_extent extent = mcv_view_extent(&view, scene, i);
            shown = mcv_view_shows(&view, &extent);
            const double here = remoteness(&view, &extent);
            if (nearest != MCV_NONE && !(here < least)) continue;
            nearest = i;
            least = here;
        }
        if (shown || nearest == MCV_NONE || sees_nothing(scene, view.sensor) ||
            shows_mirror(&view, scene))
            continue;
        MCV_TRY(report_outside(scene, &view, nearest, findings, error));
    }
    return MCV_OK;
}

/* --- defocus --- */

/* With more blur, an edge was not meant to be sharp [pixels]. */
static const double blurred = 3;

/* The least blur in a range of depths; 0 if the plane in focus lies within. A tilted film is in
 * focus in a range of depths: a part in it counts as sharp. */
static double least_blur(const mcv_view *view, const double depth[2], double *at) {
    const double focus = view->optics.focused_depth, near = fmax(depth[0], 0);
    const double *plane = view->optics.plane_depths;
    if (isfinite(view->optics.object_tilt) && near <= plane[1] && depth[1] >= plane[0]) {
        *at = near;
        return 0;
    }
    *at = focus < near ? near : focus > depth[1] ? depth[1] : focus;
    if (focus < 0) *at = depth[1]; /* focused beyond infinity */
    return mcv_view_blur(view, *at);
}

mcv_result mcv_find_defocus(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t s = 0; s < scene->sensor_count; ++s) {
        const mcv_view view = mcv_view_of(scene->sensors + s);
        double least = INFINITY, at = 0, nearest_glass = INFINITY, farthest = 0;
        uint32_t sharpest = MCV_NONE;
        if (isnan(view.optics.focused_depth) || shows_mirror(&view, scene)) continue;
        for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end); i < scene->instance_count;
             i = mcv_next_part(scene, i + 1, &end)) {
            const mcv_extent extent = mcv_view_extent(&view, scene, i);
            if (!mcv_view_shows(&view, &extent)) continue;
            double depth;
            const double blur = least_blur(&view, extent.depth, &depth);
            if (mcv_material_has_medium(scene->materials[scene->instances[i].material].type))
                nearest_glass = fmin(nearest_glass, extent.depth[1]);
            else
                farthest = fmax(farthest, extent.depth[0]);
            if (!(blur < least)) continue;
            least = blur;
            at = depth;
            sharpest = i;
        }
        /* Seen through a lens of the scene, things away from the plane in focus may be sharp. */
        if (sharpest == MCV_NONE || nearest_glass < farthest || !(least > blurred)) continue;
        const char *key = view.is_telecentric ? "workingDistance" : "focusDistance";
        char label[MCV_LABEL], text[4][32];
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "sensors", view.sensor->name, key, error,
            "nothing in the field of sensor \"%s\" is in focus: its plane in focus lies at %s; the "
            "part nearest to "
            "that, %s at %s, is blurred "
            "over %.*f pixels (%s): move the sensor by %s, or change %s",
            view.sensor->name, mcv_length_in_words(view.optics.focused_depth, text[0]),
            mcv_instance_label(scene, sharpest, label), mcv_length_in_words(at, text[1]),
            least < 10, least, mcv_length_in_words(least * mcv_view_pixel(&view, at), text[2]),
            mcv_length_in_words(fabs(at - view.optics.focused_depth), text[3]), key));
    }
    return MCV_OK;
}

/* --- large_pixel, unit --- */

/* The longest side of the instance's box in the world. */
static double width_of(const mcv_scene *scene, uint32_t instance) {
    double lower[3], upper[3];
    mcv_scene_box(scene, instance, lower, upper);
    return fmax(upper[0] - lower[0], fmax(upper[1] - lower[1], upper[2] - lower[2]));
}

/* The instance of the widest part, or MCV_NONE. */
static uint32_t widest_part(const mcv_scene *scene, double *width) {
    uint32_t widest = MCV_NONE;
    *width = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        if (scene->instances[i].emitter != MCV_NONE) continue;
        const double here = width_of(scene, i);
        if (here <= *width) continue;
        *width = here;
        widest = i;
    }
    return widest;
}

static const double largest_pixel = 100e-6; /* those of cameras have 1 to 50 µm */
static const double least_share = 0.1;      /* of the field: a smaller part is rarely intended */

/* Is a pixel of the film larger than those of cameras, and the field too large for the widest part?
 * *depth gets the part's depth. */
static bool has_large_pixels(const mcv_scene *scene, const mcv_view *view, uint32_t widest,
                             double width, double *field) {
    const mcv_readout readout = mcv_sensor_readout(view->sensor);
    double pitch[2];
    for (int i = 0; i < 2; ++i) pitch[i] = readout.pitch[i] / readout.angular[i];
    const mcv_extent extent = mcv_view_extent(view, scene, widest);
    const double depth = isnan(view->optics.focused_depth) ? fabs(extent.middle[2])
                                                           : fabs(view->optics.focused_depth);
    for (int i = 0; i < 2; ++i)
        field[i] = (view->is_telecentric ? 1 : depth) * (view->film[i][1] - view->film[i][0]);
    return fmax(pitch[0], pitch[1]) > largest_pixel &&
           width < least_share * fmax(field[0], field[1]);
}

mcv_result mcv_find_large_pixel(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    double width;
    const uint32_t widest = widest_part(scene, &width);
    for (uint32_t s = 0; widest != MCV_NONE && s < scene->sensor_count; ++s) {
        const mcv_view view = mcv_view_of(scene->sensors + s);
        const mcv_readout readout = mcv_sensor_readout(view.sensor);
        double field[2];
        char label[MCV_LABEL], text[4][32];
        if (!has_large_pixels(scene, &view, widest, width, field)) continue;
        const double pitch =
            fmax(readout.pitch[0] / readout.angular[0], readout.pitch[1] / readout.angular[1]);
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "sensors", view.sensor->name, "pixelSize", error,
            "pixels of %s make a field of %s x %s, in which the widest part, %s, covers %.2g "
            "pixels: those of cameras have 1 to 50 µm; should it be \"%.3gum\"?",
            mcv_length_in_words(pitch, text[0]), mcv_length_in_words(field[0], text[1]),
            mcv_length_in_words(field[1], text[2]), mcv_instance_label(scene, widest, label),
            width / field[0] * readout.size[0], 1e3 * pitch));
    }
    return MCV_OK;
}

/* A floor may be this much wider than the field. Millimetres read as metres give a factor of a
 * thousand. */
static const double too_wide = 100;
static const double widest_field = 10; /* [m]; `new` frames a part of any size */

mcv_result mcv_find_unit(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    double width;
    const uint32_t widest = widest_part(scene, &width);
    if (widest == MCV_NONE) return MCV_OK;
    const char *name = scene->instances[widest].name;
    char label[MCV_LABEL];
    mcv_instance_label(scene, widest, label);
    for (uint32_t i = 0; i < scene->sensor_count; ++i) {
        const mcv_view view = mcv_view_of(scene->sensors + i);
        const mcv_readout readout = mcv_sensor_readout(view.sensor);
        const double field = fmax(view.optics.field[0], view.optics.field[1]);
        const double pixel = readout.pitch[0] / fabs(view.optics.magnification);
        double seen_by_it[2];
        char part[32], seen[32];
        if (!isfinite(field)) continue;
        const bool large_pixels = has_large_pixels(scene, &view, widest, width, seen_by_it);
        if (width > too_wide * field || (field > widest_field && !large_pixels))
            MCV_TRY(mcv_findings_add(
                findings, MCV_SEVERITY_WARNING, "nodes", name, NULL, error,
                "%s is %s wide in the %s wide field of sensor \"%s\": is its unit mm? give its "
                "asset \"unit\": \"mm\", as `new --unit mm` does",
                label, mcv_length_in_words(width, part), mcv_length_in_words(field, seen),
                view.sensor->name));
        if (width < pixel && !large_pixels)
            MCV_TRY(mcv_findings_add(findings, MCV_SEVERITY_WARNING, "nodes", name, NULL, error,
                                     "%s, the widest part, is %s wide, less than the %s that a "
                                     "pixel of sensor \"%s\" sees: is its "
                                     "unit too small?",
                                     label, mcv_length_in_words(width, part),
                                     mcv_length_in_words(pixel, seen), view.sensor->name));
    }
    return MCV_OK;
}
