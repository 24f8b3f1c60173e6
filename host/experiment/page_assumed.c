/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/page_parts.h"

#include "io/html.h"

#include <string.h>

static void put_line(FILE *out, const char *name, const char *text) {
    fputs("<tr><th>", out);
    mcv_html_text(out, name);
    fputs("<td>", out);
    mcv_html_text(out, text);
    fputs("\n", out);
}

/* A line for each value of an option. */
static void put_setting(FILE *out, const char *name, const json_t *value) {
    char words[64] = "";
    const json_t *item;
    size_t i;
    json_array_foreach((json_t *)value, i, item) { put_setting(out, i ? "" : name, item); }
    if (json_is_array(value)) return;
    if (json_is_integer(value))
        snprintf(words, sizeof words, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        mcv_exact_words(json_real_value(value), words);
    else if (json_is_true(value))
        snprintf(words, sizeof words, "on");
    put_line(out, name, json_is_string(value) ? json_string_value(value) : words);
}

static void put_settings(FILE *out, const mcv_sweep *s) {
    const char *name;
    json_t *value;
    fputs("<h3>As it was ordered</h3>\n<table class=\"told\">\n", out);
    put_line(out, "rig", s->experiment->rig);
    json_object_foreach(s->experiment->settings, name, value) {
        if (strcmp(name, "title") != 0 && strcmp(name, "note") != 0) put_setting(out, name, value);
    }
    fputs("</table>\n", out);
}

void mcv_page_put_assumed(FILE *out, const mcv_page *page, const mcv_scene *scene) {
    const mcv_sweep *s = page->sweep;
    const bool grey = mcv_camera_wanted(&s->experiment->measuring.camera);
    fputs("<h2>What was assumed</h2>\n<ul>\n"
          "<li>12.3(4) means 12.3 with a standard uncertainty of 0.4. Error bars show it to both "
          "sides.\n"
          "<li>The uncertainty is that of ",
          out);
    fputs(s->experiment->measuring.in_gradient ? "the spread inside a region"
          : grey                               ? "the camera's noise and the render's"
                                               : "the render's noise",
          out);
    fputs(json_object_get(s->experiment->settings, "tolerance")
              ? ". Beside it only the tolerances that are listed below vary.\n<li>"
              : ". It holds no difference between the rig here and the one that is built.\n<li>",
          out);
    fputs(s->plan.seeds ? "Sets have random numbers of their own where the method needs it."
                        : "All sets use the same random numbers. Their differences are less noisy "
                          "than each value.",
          out);
    fputs("\n<li>Light goes along rays. What the scene does not state, such as dirt, wear or the "
          "aberrations of a lens, is in no figure.",
          out);
    fputs("\n<li>Numbers have the units in which they were given. A parameter without a unit is in "
          "SI units.\n",
          out);
    for (uint32_t i = 0; scene && i < scene->warning_count; ++i) {
        fputs("<li class=\"warning\">", out);
        mcv_html_text(out, scene->warnings[i]);
        fputs("\n", out);
    }
    fputs("</ul>\n", out);
    put_settings(out, s);
}
