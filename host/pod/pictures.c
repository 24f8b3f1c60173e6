/* SPDX-License-Identifier: Apache-2.0 */
#include "pod/pictures.h"

#include "core/basics.h"

#include "check/findings.h"
#include "check/setup_page.h"
#include "experiment/judge.h"
#include "experiment/run_set.h"
#include "experiment/set_picture.h"
#include "experiment/units.h"
#include "io/html.h"
#include "io/thumbnail.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A set of the study whose parts are shown, and the scene that it belongs to. */
typedef struct shown {
    mcv_sweep *sweep;
    size_t size;  /* the parameter */
    size_t *rows; /* those that have not failed, by size */
    size_t count;
    json_t *flawless; /* the rig's tree without defects, or NULL */
} shown;

/* --- which sets --- */

static int compare_numbers(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Rows in the order of their sizes. */
static bool sort_rows(shown *s) {
    const mcv_table *table = &s->sweep->table;
    double(*sizes)[2] = malloc((table->row_count + 1) * sizeof *sizes);
    s->rows = malloc((table->row_count + 1) * sizeof *s->rows);
    if (!sizes || !s->rows) {
        free(sizes);
        return false;
    }
    for (size_t i = 0; i < table->row_count; ++i) {
        if (table->messages[i]) continue;
        sizes[s->count][0] = table->rows[i * table->columns + s->size];
        sizes[s->count++][1] = (double)i;
    }
    qsort(sizes, s->count, sizeof *sizes, compare_numbers);
    for (size_t i = 0; i < s->count; ++i) s->rows[i] = (size_t)sizes[i][1];
    free(sizes);
    return true;
}

static bool is_of_defect(const char *item) { return strncmp(item, "defects/", 8) == 0; }

/* The size of a defect, else another of its parameters, else the first of all. */
static size_t find_size(const mcv_plan *plan) {
    size_t found = 0;
    for (size_t i = plan->count; i-- > 0;)
        if (is_of_defect(plan->parameters[i].item)) found = i;
    for (size_t i = plan->count; i-- > 0;) {
        const mcv_parameter *p = plan->parameters + i;
        if (is_of_defect(p->item) && p->path_length > 5 &&
            strncmp(p->item + p->path_length - 5, "/size", 5) == 0)
            found = i;
    }
    return found;
}

/* --- the scene of a set, and the same without its defects --- */

static mcv_result load_flawless(const shown *s, const mcv_set_texts texts, mcv_scene **scene,
                                mcv_error *error) {
    const mcv_experiment *e = s->sweep->experiment;
    const size_t most = e->set.count + s->sweep->plan.count;
    const char **items = malloc((most + 1) * sizeof *items);
    assert(e->document); /* else s->flawless is NULL, has no defects, and nobody asks */
    mcv_document document = *e->document;
    size_t count = 0;
    if (!items) return mcv_fail(error, MCV_FAILED, "no memory for a set of parameters");
    for (size_t i = 0; i < most; ++i) {
        const bool given = i < e->set.count;
        const char *item = given ? e->set.items[i] : texts[i - e->set.count];
        if (!given && mcv_judge_has(s->sweep->plan.parameters + i - e->set.count)) continue;
        if (!is_of_defect(item)) items[count++] = item;
    }
    document.root = s->flawless;
    const mcv_result result = mcv_scene_load_document(&document, (mcv_overrides){items, count},
                                                      e->memory, s->sweep->assets, scene, error);
    free((void *)items);
    return result;
}

static mcv_result make_pair(const shown *s, size_t row, mcv_image images[2], mcv_error *error) {
    const mcv_table *table = &s->sweep->table;
    mcv_set_texts texts;
    for (int without = 0; without < 2; ++without) {
        mcv_scene *scene = NULL;
        MCV_TRY(without ? load_flawless(s, (const char(*)[512])texts, &scene, error)
                        : mcv_load_set(s->sweep, table->rows + row * table->columns, texts, &scene,
                                       error));
        const mcv_result result = mcv_set_picture(s->sweep, scene, images + without, error);
        mcv_scene_free(scene);
        MCV_TRY(result);
    }
    return MCV_OK;
}

/* --- what is put --- */

static mcv_shown_unit unit_of_size(const shown *s) {
    return mcv_unit_of_parameter(s->sweep->plan.parameters + s->size);
}

static void put_pair(FILE *out, const shown *s, size_t row, const mcv_image images[2]) {
    const mcv_table *table = &s->sweep->table;
    const size_t count = (size_t)images[0].width * images[0].height * images[0].channels;
    mcv_image difference;
    mcv_error ignored;
    if (mcv_image_new(&difference, images[0].width, images[0].height, images[0].channels,
                      &ignored) != MCV_OK)
        return;
    for (size_t i = 0; i < count; ++i)
        difference.pixels[i] = fabsf(images[0].pixels[i] - images[1].pixels[i]);
    fprintf(out, "<tr><th>%.4g<td>",
            table->rows[row * table->columns + s->size] * unit_of_size(s).per_si);
    mcv_thumbnail_put(out, images, "with the defect");
    fputs("<td>", out);
    mcv_thumbnail_put(out, images + 1, "without it");
    fputs("<td>", out);
    mcv_thumbnail_put(out, &difference, "their difference");
    fputs("\n", out);
    mcv_image_free(&difference);
}

/* The smallest, the middle and the largest. */
static mcv_result put_pairs(FILE *out, const shown *s, mcv_error *error) {
    enum { PAIRS = 3 };
    const mcv_shown_unit unit = unit_of_size(s);
    char size[128];
    mcv_name_with_unit(s->sweep->plan.parameters[s->size].name, &unit, size, sizeof size);
    fprintf(out,
            "<h2>What the camera sees</h2>\n<p>Light without the camera's noise. Each picture has "
            "a white of its own; the differences are stretched.</p>\n<table "
            "class=\"told\">\n<tr><th>%s<th>with<th>without<th>difference\n",
            size);
    for (size_t i = 0; i < PAIRS && i < s->count; ++i) {
        mcv_image images[2] = {{0}};
        const size_t row = s->rows[i * (s->count - 1) / (PAIRS - 1)];
        const mcv_result result = make_pair(s, row, images, error);
        if (result == MCV_OK) put_pair(out, s, row, images);
        for (int k = 0; k < 2; ++k) mcv_image_free(images + k);
        MCV_TRY(result);
    }
    fputs("</table>\n", out);
    return MCV_OK;
}

/* What `check` says of the defects of the smallest size: rays may be no model of it. */
static mcv_result put_doubts(FILE *out, const shown *s, mcv_error *error) {
    const mcv_sweep_calls *calls = &s->sweep->experiment->calls;
    const mcv_table *table = &s->sweep->table;
    mcv_findings findings;
    mcv_set_texts texts;
    mcv_scene *scene = NULL;
    MCV_TRY(
        mcv_load_set(s->sweep, table->rows + s->rows[0] * table->columns, texts, &scene, error));
    const mcv_result result = mcv_warnings_of(scene, &findings, error);
    fputs("<ul>\n", out);
    for (size_t i = 0; result == MCV_OK && i < findings.count; ++i) {
        const char *sentence = findings.items[i].sentence;
        if (strncmp(findings.items[i].path, "defects/", 8) != 0) continue;
        fputs("<li class=\"warning\"><b>the smallest size</b>", out);
        mcv_html_text(out, sentence);
        fputs("\n", out);
        if (calls->warning) calls->warning(calls->user, sentence);
    }
    fputs("</ul>\n", out);
    if (result == MCV_OK) mcv_findings_free(&findings);
    mcv_scene_free(scene);
    return result;
}

/* The rig from the side, as in the set of the middle size. */
static mcv_result put_setup(FILE *out, const shown *s, mcv_error *error) {
    const mcv_table *table = &s->sweep->table;
    const size_t row = s->rows[(s->count - 1) / 2];
    mcv_set_texts texts;
    mcv_scene *scene = NULL;
    uint32_t sensor;
    MCV_TRY(mcv_load_set(s->sweep, table->rows + row * table->columns, texts, &scene, error));
    mcv_result result = mcv_set_sensor(s->sweep->experiment, scene, &sensor, error);
    if (result == MCV_OK) {
        fputs("<h2>The set-up</h2>\n", out);
        if (!mcv_setup_put_view(out, scene, sensor, false, NULL, NULL))
            result = mcv_fail(error, MCV_FAILED, "no memory for the drawing of the set-up");
    }
    mcv_scene_free(scene);
    return result;
}

static mcv_result put_all(FILE *out, shown *s, mcv_error *error) {
    json_t *extensions = json_object_get(s->flawless, "extensions");
    const bool has_defects = json_object_del(extensions, "MCVISI_defects") == 0;
    if (s->count == 0) return MCV_OK;
    if (has_defects) MCV_TRY(put_pairs(out, s, error));
    if (has_defects) MCV_TRY(put_doubts(out, s, error));
    return put_setup(out, s, error);
}

mcv_result mcv_pod_pictures(mcv_sweep *sweep, char **text, mcv_error *error) {
    shown s = {.sweep = sweep, .size = find_size(&sweep->plan)};
    size_t length;
    *text = NULL;
    s.flawless =
        sweep->experiment->document ? json_deep_copy(sweep->experiment->document->root) : NULL;
    FILE *out = open_memstream(text, &length);
    const bool memory = out && sort_rows(&s);
    mcv_result result = memory ? put_all(out, &s, error)
                               : mcv_fail(error, MCV_FAILED, "no memory for a study's pictures");
    if (!mcv_text_close(out, text) && result == MCV_OK)
        result = mcv_fail(error, MCV_FAILED, "no memory for a study's pictures");
    json_decref(s.flawless);
    free(s.rows);
    if (result == MCV_OK) return MCV_OK;
    free(*text);
    *text = NULL;
    return result;
}
