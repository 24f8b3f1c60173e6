/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/set_picture.h"

#include "experiment/run_set.h"
#include "io/thumbnail.h"

mcv_result mcv_set_picture(const mcv_sweep *sweep, mcv_scene *scene, mcv_image *image,
                           mcv_error *error) {
    const mcv_experiment *e = sweep->experiment;
    mcv_render_options options = e->render;
    mcv_render_stats stats = {.stage_count = 0};
    mcv_film film = {0};
    uint32_t sensor;
    mcv_result result = mcv_set_sensor(e, scene, &sensor, error);
    if (result == MCV_OK)
        result = e->render_with ? e->render_with(scene, sensor, &options, &film, &stats, error)
                                : mcv_renderer_render(sweep->renderer, scene, sensor, &options,
                                                      &film, &stats, error);
    if (result == MCV_OK) result = mcv_film_develop(&film, image, NULL, error);
    mcv_film_free(&film);
    return result;
}

static void put_picture(FILE *out, const mcv_sweep *sweep, size_t row, const char *label) {
    const mcv_table *table = &sweep->table;
    mcv_set_texts texts;
    mcv_scene *scene = NULL;
    mcv_image image = {0};
    mcv_error ignored;
    if (table->messages[row] ||
        mcv_load_set(sweep, table->rows + row * table->columns, texts, &scene, &ignored) != MCV_OK)
        return;
    if (mcv_set_picture(sweep, scene, &image, &ignored) == MCV_OK)
        mcv_thumbnail_put(out, &image, label);
    mcv_image_free(&image);
    mcv_scene_free(scene);
}

void mcv_put_set_pictures(FILE *out, const mcv_sweep *sweep, size_t shown) {
    const mcv_sweep_calls *calls = &sweep->experiment->calls;
    if (calls->interrupted && calls->interrupted(calls->user) != MCV_OK) return;
    const bool compares = sweep->shown > 1; /* the first row is another set */
    fputs("<h2>What the camera sees</h2>\n<p>Light without the camera's noise. Each picture has a "
          "white of its own.</p>\n<table class=\"told\">\n<tr><th>",
          out);
    fputs(compares ? "this rig<th>the first one that was tried\n<tr><td>" : "this rig\n<tr><td>",
          out);
    put_picture(out, sweep, shown, "what the camera sees of this rig");
    if (compares) fputs("<td>", out);
    if (compares) put_picture(out, sweep, 0, "what it saw of the first one");
    fputs("\n</table>\n", out);
}
