/* SPDX-License-Identifier: Apache-2.0 */
#include "check/setup_page.h"

#include "check/setup_drawing.h"
#include "core/output_file.h"
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

static bool put_sensor(FILE *out, const mcv_scene *scene, uint32_t index) {
    const mcv_sensor *sensor = scene->sensors + index;
    const mcv_view view = mcv_view_of(sensor);
    if (isnan(view.film[0][0])) return true; /* a type of sensor without known optics */
    fputs("<section><h2>", out);
    mcv_html_text(out, sensor->name);
    fprintf(out, " <small>%s</small></h2>\n", mcv_sensor_types[sensor->type]);
    put_numbers(out, &view);
    for (int above = 0; above < 2; ++above) {
        const int axis = above ? 0 : 1;
        mcv_drawing c = {.out = out,
                         .scene = scene,
                         .view = &view,
                         .from_above = above,
                         .focus = view.optics.focused_depth,
                         .number = (int)(2 * index) + above};
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
        if (!mcv_put_drawing(&c)) return false;
    }
    fputs("</section>\n", out);
    return true;
}

/* --- the page --- */

static const char style[] =
    ":root{--ink:#1d2733;--soft:#5b6775;--page:#fff;--ground:#f6f8fa;--line:#c9d1da;--part:#8a94a0;"
    "--glass:#7fb6d9;--light:#e69a00;"
    "--focus:#00856f;--ray0:#0072b2;--ray1:#56789b;--ray2:#b0418f;--bad:#b3261e;--warn:#9a6700;--"
    "note:#3b6ea5}\n"
    "@media(prefers-color-scheme:dark){:root{--ink:#e6ebf0;--soft:#9fabb8;--page:#14191f;--ground:#"
    "1c232b;--line:#3a4550;--part:#77828e;"
    "--glass:#4b86ab;--light:#f0b43c;--focus:#3fc6ac;--ray0:#58b0e8;--ray1:#8fb0d0;--ray2:#e080c0;-"
    "-bad:#ff8f86;--warn:#e3b341;--note:#"
    "86b6ea}}\n"
    "body{font:15px/1.5 system-ui,-apple-system,\"Segoe "
    "UI\",sans-serif;color:var(--ink);background:var(--page);margin:0 "
    "auto;max-width:1080px;"
    "padding:24px 20px 60px}\nh1{font-size:1.5em;margin:0 0 .1em}h2{font-size:1.2em;margin:2em 0 "
    ".4em}small{color:var(--soft);font-weight:400}\n"
    ".file{color:var(--soft);margin:0 0 "
    "1.2em}ul{list-style:none;padding:0;margin:0}li{border-left:4px solid "
    "var(--note);background:var(--ground);"
    "padding:8px 14px;margin:0 0 8px;border-radius:0 6px 6px "
    "0}li.warning{border-color:var(--warn)}li.error{border-color:var(--bad)}\n"
    "li b{color:var(--note);margin-right:.5em}li.warning b{color:var(--warn)}li.error "
    "b{color:var(--bad)}li "
    "code{color:var(--soft);font-size:12px;"
    "display:block}\ntable{border-collapse:collapse;font-size:14px;margin:.4em 0 "
    "1em;font-variant-numeric:tabular-nums}"
    "th{font-weight:400;color:var(--soft);text-align:left;padding:1px 18px 1px 0}td{padding:1px "
    "0}\n"
    "figure{margin:0 0 "
    "22px}figcaption{color:var(--soft);font-size:13px;margin-bottom:2px}svg{width:100%;height:auto;"
    "display:block}\n"
    "svg "
    "text{font-size:12px;fill:var(--ink);paint-order:stroke;stroke:var(--page);stroke-width:3px;"
    "stroke-linejoin:round}\n"
    ".ground{fill:var(--ground);stroke:var(--line)}\n"
    ".part,.housing,.glass,.mirror{fill:var(--part);fill-opacity:.45;stroke:var(--part);stroke-"
    "width:1.2}.glass{fill:var(--glass);"
    "stroke:var(--glass);fill-opacity:.35}.housing{fill-opacity:.1}.mirror{stroke-width:3}\n"
    ".light{fill:var(--light);fill-opacity:.25;stroke:var(--light);stroke-width:4;stroke-linejoin:"
    "round}.beyond{fill:none;stroke:var(--"
    "light);stroke-width:"
    "1.2;opacity:.5}.beam{fill:var(--light);fill-opacity:.16;stroke:"
    "none}\n"
    ".ray{fill:none;stroke-width:1;opacity:.75}.chief{stroke-width:1.8;opacity:1}.ray0{stroke:var(-"
    "-ray0)}.ray1{stroke:var(--ray1)}"
    ".ray2{stroke:var(--ray2)}\n.axis{stroke:var(--soft);stroke-dasharray:14 4 3 "
    "4;fill:none;opacity:.6}.film{stroke:var(--ink);stroke-width:3;"
    "fill:none}.lens{fill:var(--glass);fill-opacity:.45;stroke:var(--ink)}\n"
    ".focus{stroke:var(--focus);stroke-width:2;fill:none}.sharp{fill:var(--focus);fill-opacity:.18}"
    "svg .focus-text{fill:var(--focus)}\n"
    ".dimension{fill:none;stroke:var(--soft);stroke-width:1.2}.of-focus{stroke:var(--focus)}.of-"
    "light{stroke:var(--light)}\n"
    "svg .name{font-weight:600}@media print{body{max-width:none}figure{break-inside:avoid}}\n";

static bool put_page(FILE *out, const mcv_scene *scene, const mcv_findings *findings) {
    const char *slash = strrchr(scene->path, '/'), *name = slash ? slash + 1 : scene->path;
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
          "name=\"viewport\" content=\"width=device-width\">\n"
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
          "'unsafe-inline'\">\n<title>",
          out);
    mcv_html_text(out, name);
    fprintf(out, "</title>\n<style>\n%s</style></head><body>\n<h1>", style);
    mcv_html_text(out, name);
    fprintf(out, "</h1>\n<p class=\"file\">%u triangles, %u %s, %u %s</p>\n", scene->triangle_count,
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
          "of the film; bodies are drawn as their "
          "convex "
          "hulls, and glass does not bend rays here.</p>\n</body></html>\n",
          out);
    return true;
}

mcv_result mcv_setup_page_write(const char *path, const mcv_scene *scene,
                                const mcv_findings *findings, mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    const bool written = stream && put_page(stream, scene, findings);
    if (!stream || fclose(stream) != 0 || !written) {
        free(text);
        return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    }
    const mcv_result result = mcv_output_whole(path, text, size, error);
    free(text);
    return result;
}
