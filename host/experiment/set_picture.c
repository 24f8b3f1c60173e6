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
    options.progress = mcv_sweep_goes_on;
    options.user = (void *)sweep;
    mcv_result result = mcv_set_sensor(e, scene, &sensor, error);
    if (result == MCV_OK)
        result = e->render_with ? e->render_with(scene, sensor, &options, &film, &stats, error)
                                : mcv_renderer_render(sweep->renderer, scene, sensor, &options,
                                                      &film, &stats, error);
    if (result == MCV_OK) result = mcv_sweep_stopped(sweep, error);
    if (result == MCV_OK) result = mcv_film_develop(&film, image, NULL, error);
    mcv_film_free(&film);
    return result;
}

/* The picture of a row; none of a set that cannot be rendered. Fails only after an interruption. */
static mcv_result make_picture(const mcv_sweep *sweep, size_t row, mcv_image *image,
                               mcv_error *error) {
    const mcv_table *table = &sweep->table;
    mcv_set_texts texts;
    mcv_scene *scene = NULL;
    mcv_error ignored;
    if (!table->messages[row] &&
        mcv_load_set(sweep, table->rows + row * table->columns, texts, &scene, &ignored) == MCV_OK)
        mcv_set_picture(sweep, scene, image, &ignored);
    mcv_scene_free(scene);
    return mcv_sweep_stopped(sweep, error);
}

static void put_pictures(FILE *out, const mcv_image *images, bool compares) {
    fputs("<h2>What the camera sees</h2>\n<p>Light without the camera's noise. Each picture has a "
          "white of its own.</p>\n<table class=\"told\">\n<tr><th>",
          out);
    fputs(compares ? "this rig<th>the first one that was tried\n<tr><td>" : "this rig\n<tr><td>",
          out);
    if (images[0].pixels) mcv_thumbnail_put(out, images, "what the camera sees of this rig");
    if (compares) fputs("<td>", out);
    if (images[1].pixels) mcv_thumbnail_put(out, images + 1, "what it saw of the first one");
    fputs("\n</table>\n", out);
}

mcv_result mcv_put_set_pictures(FILE *out, const mcv_sweep *sweep, size_t shown, mcv_error *error) {
    const bool compares = sweep->shown > 1; /* the first row is another set */
    mcv_image images[2] = {{0}};
    mcv_result result = mcv_sweep_stopped(sweep, error);
    if (result == MCV_OK) result = make_picture(sweep, shown, images, error);
    if (result == MCV_OK && compares) result = make_picture(sweep, 0, images + 1, error);
    if (result == MCV_OK) put_pictures(out, images, compares);
    for (int i = 0; i < 2; ++i) mcv_image_free(images + i);
    return result;
}
