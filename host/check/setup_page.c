/* SPDX-License-Identifier: Apache-2.0 */
#include "check/setup_page.h"

#include "check/setup_drawing.h"
#include "io/html.h"
#include "scene/params.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void put_row(FILE *out, const char *key, const char *value) {
    fprintf(out, "<tr><th>%s<td>", key);
    mcv_html_text(out, value);
    fputs("\n", out);
}

static void put_numbers(FILE *out, const mcv_view *view) {
    const mcv_optics *o = &view->optics;
    uint32_t width, height;
    char text[2][32], words[96];
    mcv_sensor_film_size(view->sensor, &width, &height);
    fputs("<table>\n", out);
    snprintf(words, sizeof words, "%u x %u pixels", width, height);
    put_row(out, "image", words);
    if (isfinite(o->field[0])) {
        snprintf(words, sizeof words, "%s x %s", mcv_length_in_words(o->field[0], text[0]),
                 mcv_length_in_words(o->field[1], text[1]));
        put_row(out, "field in focus", words);
        put_row(out,
                view->sensor->type == MCV_SENSOR_LIGHT_FIELD ? "a macro pixel there"
                                                             : "a pixel there",
                mcv_length_in_words(mcv_view_pixel(view, fabs(o->focused_depth)), text[0]));
    }
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"magnification", o->magnification},
                   {"f-number, working", o->f_number},
                   {"numerical aperture", o->numerical_aperture}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        snprintf(words, sizeof words, "%.4g", numbers[i].value);
        if (!isnan(numbers[i].value)) put_row(out, numbers[i].key, words);
    }
    fputs("</table>\n", out);
}

/* Puts a drawing, of which its way out and its overlay are given. */
static bool put_view(mcv_drawing c, const mcv_scene *scene, uint32_t index, bool above) {
    const mcv_sensor *sensor = scene->sensors + index;
    const mcv_view view = mcv_view_of(sensor);
    if (isnan(view.film[0][0])) return true;
    const int axis = above ? 0 : 1;
    c.scene = scene;
    c.view = &view;
    c.from_above = above;
    c.focus = view.optics.focused_depth;
    c.number = (int)(2 * index) + above;
    c.film[0] = above ? -view.film[axis][1] : view.film[axis][0];
    c.film[1] = above ? -view.film[axis][0] : view.film[axis][1];
    switch (sensor->type) {
    case MCV_SENSOR_THIN_LENS:
        c.film_at = -sensor->as.thin_lens.imageDistance;
        break;
    case MCV_SENSOR_LIGHT_FIELD:
        c.film_at = -sensor->as.light_field.imageDistance;
        break;
    case MCV_SENSOR_TELECENTRIC:
        c.film_at = -sensor->as.telecentric.imageDistance;
        break;
    default:
        c.film_at = -sensor->as.pinhole.imageDistance;
    }
    c.lens = sensor->type == MCV_SENSOR_LIGHT_FIELD ? sensor->as.light_field.lensDiameter / 2
                                                    : mcv_lens_radius(sensor);
    return mcv_put_drawing(&c);
}

bool mcv_setup_put_view(FILE *out, const mcv_scene *scene, uint32_t sensor, bool from_above,
                        mcv_drawing_overlay *overlay, void *user) {
    const mcv_drawing c = {.out = out, .overlay = overlay, .user = user};
    return put_view(c, scene, sensor, from_above);
}

bool mcv_setup_put_file(FILE *out, const mcv_scene *scene, uint32_t sensor,
                        mcv_drawing_overlay *overlay, void *user) {
    const mcv_drawing c = {.out = out, .alone = true, .overlay = overlay, .user = user};
    return put_view(c, scene, sensor, false);
}

bool mcv_setup_is_known(const mcv_scene *scene, uint32_t sensor) {
    return !isnan(mcv_view_of(scene->sensors + sensor).film[0][0]);
}

static bool put_sensor(FILE *out, const mcv_scene *scene, uint32_t index) {
    const mcv_sensor *sensor = scene->sensors + index;
    const mcv_view view = mcv_view_of(sensor);
    if (isnan(view.film[0][0])) return true; /* a type of sensor without known optics */
    fputs("<section><h2>", out);
    mcv_html_text(out, sensor->name);
    fprintf(out, " <small>%s</small></h2>\n", mcv_sensor_types[mcv_sensor_told_type(sensor)]);
    put_numbers(out, &view);
    for (int above = 0; above < 2; ++above)
        if (!mcv_setup_put_view(out, scene, index, above, NULL, NULL)) return false;
    fputs("</section>\n", out);
    return true;
}

/* --- the page --- */

typedef struct page {
    const mcv_scene *scene;
    const mcv_findings *findings;
} page;

static bool put_page(FILE *out, void *user) {
    const page *p = user;
    const mcv_scene *scene = p->scene;
    const mcv_findings *findings = p->findings;
    const char *slash = strrchr(scene->path, '/');
    mcv_html_begin(out, slash ? slash + 1 : scene->path, false, "");
    fprintf(out, "<p class=\"file\">%u triangles, %u %s, %u %s</p>\n", scene->triangle_count,
            scene->sensor_count, scene->sensor_count == 1 ? "sensor" : "sensors",
            scene->emitter_count, scene->emitter_count == 1 ? "emitter" : "emitters");
    if (findings->count == 0) fputs("<p>No findings.</p>\n", out);
    fputs("<ul>\n", out);
    for (mcv_severity severity = MCV_SEVERITY_ERROR + 1; severity-- > 0;)
        for (size_t i = 0; i < findings->count; ++i) {
            if (findings->items[i].severity != severity) continue;
            fprintf(out, "<li class=\"%s\"><b>%s</b>", mcv_severities[severity],
                    mcv_severities[severity]);
            mcv_html_text(out, findings->items[i].sentence);
            if (*findings->items[i].path) {
                fputs("<code>", out);
                mcv_html_text(out, findings->items[i].path);
                fputs("</code>", out);
            }
            fputs("</li>\n", out);
        }
    fputs("</ul>\n", out);
    for (uint32_t i = 0; i < scene->sensor_count; ++i)
        if (!put_sensor(out, scene, i)) return false;
    fputs("<p class=\"file\">Rays are those of first-order optics, from the edges and the middle "
          "of the film; bodies are drawn as their convex "
          "hulls, and glass does not bend rays here.</p>\n</body></html>\n",
          out);
    return true;
}

mcv_result mcv_setup_page_write(const char *path, const mcv_scene *scene,
                                const mcv_findings *findings, mcv_error *error) {
    page p = {scene, findings};
    return mcv_html_write(path, put_page, &p, error);
}
