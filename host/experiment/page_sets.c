/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/page_parts.h"

#include "experiment/run_set.h"
#include "io/exr.h"
#include "io/html.h"
#include "io/thumbnail.h"
#include "options/option_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- the command --- */

/* A word as shells read it. */
static void put_word(FILE *out, const char *word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "_-./:=,%+@";
    if (*word && !word[strspn(word, plain)]) {
        fputs(word, out);
        return;
    }
    fputc('\'', out);
    for (; *word; ++word) {
        const char one[2] = {*word, '\0'};
        if (*word == '\'')
            fputs("'\\''", out);
        else
            mcv_html_text(out, one);
    }
    fputc('\'', out);
}

static void put_option(FILE *out, const char *name, const json_t *value) {
    char words[64];
    const json_t *item;
    size_t i;
    json_array_foreach((json_t *)value, i, item) { put_option(out, name, item); }
    if (json_is_array(value)) return;
    fprintf(out, " --%s", name);
    if (json_is_true(value)) return;
    if (json_is_integer(value))
        snprintf(words, sizeof words, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        mcv_exact_words(json_real_value(value), words);
    fputc(' ', out);
    put_word(out, json_is_string(value) ? json_string_value(value) : words);
}

/* Options that end a render early: the samples that a set has taken stand in their place. Of light
 * paths, see put_sampling. */
static bool is_replaced(const char *name) {
    return strcmp(name, "spp") == 0 || strcmp(name, "time") == 0 || strcmp(name, "error") == 0 ||
           strcmp(name, "light-paths") == 0;
}

/* What a render decides by a pilot, and a sweep does not. */
static void put_sampling(FILE *out, const mcv_experiment *e) {
    fprintf(out, " --adaptive off --light-paths %s", e->render.no_light_paths ? "off" : "on");
}

/* What the render of a set shares with all others; seeds: not the seed. */
static void put_shared(FILE *out, const mcv_experiment *e, bool seeds) {
    const char *name;
    json_t *value;
    json_object_foreach(e->settings, name, value) {
        const bool own_seed = seeds && strcmp(name, "seed") == 0;
        if (!is_replaced(name) && !own_seed && mcv_option_find(MCV_VERB_RENDER, name, strlen(name)))
            put_option(out, name, value);
    }
}

static void put_command(FILE *out, const mcv_page *page, size_t row) {
    const mcv_sweep *s = page->sweep;
    const mcv_experiment *e = s->experiment;
    const double samples =
        s->table.rows[row * s->table.columns + mcv_row_fixed(&s->table, MCV_ROW_SAMPLES)];
    const size_t set = page->plots.sets[row];
    double numbers[MCV_DESIGN_PARAMETERS];
    mcv_error ignored;
    bool wanted;
    /* The plan's own numbers: a table that was read again has ten digits. */
    if (mcv_plan_set(&s->plan, set, numbers, &wanted, &ignored) != MCV_OK) return;
    fputs("<pre>mcvisi render ", out);
    put_word(out, e->rig);
    put_shared(out, e, s->plan.seeds != NULL);
    if (s->plan.seeds) fprintf(out, " --seed %u", e->render.seed + s->plan.seeds[set]);
    for (size_t i = 0; i < s->plan.count; ++i) {
        const mcv_parameter *p = s->plan.parameters + i;
        char text[512];
        mcv_value_text words;
        if (mcv_judge_has(p)) continue; /* it is not the scene's */
        if (p->levels.named)
            mcv_parameter_text(p, numbers[i], 17, words);
        else
            mcv_exact_words(numbers[i], words);
        snprintf(text, sizeof text, "%.*s=%s", p->path_length, p->item, words);
        fputs(" --set ", out);
        put_word(out, text);
    }
    put_sampling(out, e);
    if (isfinite(samples)) fprintf(out, " --spp %.0f", samples);
    if (mcv_camera_wanted(&e->measuring.camera)) fprintf(out, " --camera set-%05zu.tif", set);
    fprintf(out, " -o set-%05zu.exr</pre>", set);
}

/* --- the picture --- */

static void put_picture(FILE *out, const mcv_page *page, size_t row) {
    const mcv_experiment *e = page->sweep->experiment;
    const size_t set = page->plots.sets[row];
    char path[PATH_MAX], label[32];
    mcv_error ignored;
    mcv_exr exr;
    if (!e->images || page->sweep->table.messages[row] ||
        mcv_set_image_path(e, set, path, &ignored) != MCV_OK ||
        mcv_exr_read(path, &exr, &ignored) != MCV_OK)
        return;
    snprintf(label, sizeof label, "set %zu", set);
    mcv_thumbnail_put(out, &exr.parts[0].image, label);
    mcv_exr_free(&exr);
}

void mcv_page_put_set(FILE *out, const mcv_page *page, size_t row) {
    put_picture(out, page, row);
    put_command(out, page, row);
}

/* --- the table --- */

static void put_row(FILE *out, const mcv_page *page, size_t row) {
    const mcv_plots *p = &page->plots;
    const double *numbers = mcv_plots_row(p, row);
    const char *message = page->sweep->table.messages[row];
    fprintf(out, "<tr id=\"s%zu\"%s><td><a href=\"#s%zu\">%zu</a>", p->sets[row],
            row == p->best ? " class=\"best\"" : "", p->sets[row], p->sets[row]);
    for (size_t i = 0; i < p->parameter_count; ++i) {
        mcv_value_text value;
        const mcv_parameter *of = page->sweep->plan.parameters + i;
        fprintf(out, "<td>%s", mcv_parameter_text(of, numbers[i], 6, value));
    }
    for (size_t i = 0; i < p->metric_count; ++i) {
        char words[48];
        mcv_value_words(mcv_plots_value(p, i, row), mcv_plots_uncertainty(p, i, row), words);
        fprintf(out, "<td>%s", words);
    }
    if (message) {
        fputs("<td class=\"failed\">", out);
        mcv_html_text(out, message);
    }
    fprintf(out, "<tr class=\"more\"><td colspan=\"%zu\">",
            2 + p->parameter_count + p->metric_count);
    mcv_page_put_set(out, page, row);
    fputs("\n", out);
}

void mcv_page_put_sets(FILE *out, const mcv_page *page) {
    const mcv_plots *p = &page->plots;
    fputs("<h2 id=\"all\">All sets</h2>\n<p>A set's number, like its point, leads to its command",
          out);
    fputs(page->sweep->experiment->images
              ? " and its picture.\nEach picture has its own white.</p>\n"
              : ".</p>\n",
          out);
    fputs("<div class=\"wide\"><table id=\"sets\"><thead><tr><th>set", out);
    for (size_t i = 0; i < p->parameter_count; ++i) {
        fputs("<th>", out);
        mcv_html_text(out, p->parameters[i].name);
    }
    for (size_t i = 0; i < p->metric_count; ++i) {
        fputs("<th>", out);
        mcv_html_text(out, p->metrics[i]);
    }
    if (mcv_table_failed(&page->sweep->table)) fputs("<th>message", out);
    fputs("</thead><tbody>\n", out);
    for (size_t row = 0; row < p->row_count; ++row) put_row(out, page, row);
    fputs("</tbody></table></div>\n", out);
}
