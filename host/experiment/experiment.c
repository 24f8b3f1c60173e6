/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/experiment.h"

#include "core/output_file.h"
#include "experiment/page.h"
#include "experiment/run_set.h"
#include "experiment/set_order.h"
#include "experiment/sidecar.h"
#include "scene/sensor_find.h"
#include "loader/load.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

mcv_result mcv_experiment_load(const mcv_sweep *s, mcv_overrides set, mcv_scene **scene,
                               mcv_error *error) {
    const mcv_experiment *e = s->experiment;
    return e->document
               ? mcv_scene_load_document(e->document, set, e->memory, s->assets, scene, error)
               : mcv_scene_load_cached(e->rig, set, e->memory, s->assets, scene, error);
}

static const char *unit_of_values(const mcv_experiment *e, const mcv_sensor *sensor) {
    if (e->measuring.in_gradient) return "";
    if (mcv_camera_wanted(&e->measuring.camera)) return "DN";
    return mcv_sensor_measures_irradiance(sensor) ? "W/m^2" : "W/(m^2 sr)";
}

/* Checks the scene without a set's overrides: its errors would occur in every set. */
static mcv_result check_rig(mcv_sweep *s, mcv_error *error) {
    const mcv_experiment *e = s->experiment;
    mcv_scene *scene;
    uint32_t sensor = 0;
    MCV_TRY(mcv_experiment_load(s, e->set, &scene, error));
    snprintf(s->fingerprint, sizeof s->fingerprint, "%016" PRIx64, scene->fingerprint);
    for (uint32_t i = 0; i < scene->warning_count && e->calls.warning; ++i)
        e->calls.warning(e->calls.user, scene->warnings[i]);
    mcv_result result = scene->sensor_count
                            ? MCV_OK
                            : mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", e->rig);
    if (result == MCV_OK && e->sensor) result = mcv_sensor_find(scene, e->sensor, &sensor, error);
    if (result == MCV_OK && !e->sensor && scene->sensor_count > 1)
        result = mcv_fail(error, MCV_USAGE, "%s has %u sensors: choose one by --sensor", e->rig,
                          scene->sensor_count);
    if (result == MCV_OK) s->unit = unit_of_values(e, scene->sensors + sensor);
    mcv_scene_free(scene);
    return result;
}

/* Whether an error is that of a path, whatever the value: the path leads nowhere, or nothing knows
 * the key at its end. */
static bool is_of_path(const mcv_sweep *s, const char *text) {
    static const char unknown[] = ": unknown key \"";
    const char *key = strstr(text, unknown);
    if (!key) return strstr(text, ": --set ") != NULL;
    key += sizeof unknown - 1;
    for (size_t i = 0; i < s->plan.count; ++i) {
        const mcv_parameter *p = s->plan.parameters + i;
        size_t length = 0;
        while (length < (size_t)p->path_length && p->item[p->path_length - 1 - length] != '/')
            ++length;
        if (strncmp(key, p->item + p->path_length - length, length) == 0 && key[length] == '"')
            return true;
    }
    return false;
}

/* Checks the paths: a wrong path fails in every set, but a value out of range may fail in one set
 * only. */
static mcv_result check_paths(const mcv_sweep *s, mcv_error *error) {
    double numbers[MCV_DESIGN_PARAMETERS];
    bool wanted;
    mcv_set_texts texts;
    mcv_scene *scene = NULL;
    MCV_TRY(mcv_plan_set(&s->plan, 0, numbers, &wanted, error));
    const mcv_result result = mcv_load_set(s, numbers, texts, &scene, error);
    mcv_scene_free(scene);
    if (result != MCV_OK && is_of_path(s, error->text)) return result;
    error->text[0] = '\0';
    return MCV_OK;
}

static mcv_result plan_files(mcv_sweep *s, mcv_error *error) {
    const mcv_experiment *e = s->experiment;
    struct stat status;
    MCV_TRY(mcv_table_plan(&s->table, e->table, &s->plan, &s->measurement, error));
    if (e->file && e->table && mcv_same_file(s->table.sidecar, e->file))
        return mcv_fail(error, MCV_USAGE, "%s is the experiment: give the table another name by -o",
                        s->table.sidecar);
    if (e->images && mkdir(e->images, 0777) != 0 &&
        (errno != EEXIST || stat(e->images, &status) != 0 || !S_ISDIR(status.st_mode)))
        return mcv_fail(error, MCV_BAD_INPUT, "--images %s: the folder cannot be made", e->images);
    return MCV_OK;
}

mcv_metric_units mcv_sweep_units(const mcv_sweep *s) {
    const char *step = s->measurement.bound.unit;
    return (mcv_metric_units){.values = s->unit, .step = step ? step : ""};
}

/* The bound of a parameter takes a second render, with the noise of a camera. */
static mcv_result plan_bound(mcv_sweep *s, mcv_error *error) {
    const mcv_experiment *e = s->experiment;
    const char *item = e->measuring.bound;
    if (!mcv_camera_wanted(&e->measuring.camera))
        return mcv_fail(error, MCV_USAGE,
                        "--bound %s: is against the noise of a camera: give its exposure, as by "
                        "--expose-to 0.8",
                        item);
    if (e->render.replicates < 2)
        return mcv_fail(error, MCV_USAGE,
                        "--bound %s: needs uncertainties: give --replicates 2 or more", item);
    if (e->measuring.until.count || e->measuring.in_gradient)
        return mcv_fail(error, MCV_USAGE,
                        "--bound %s: takes two whole renders: leave out --until and --in", item);
    return mcv_bound_read(item, &s->plan, e->document, e->set, &s->measurement.bound, error);
}

mcv_result mcv_experiment_plan(const mcv_experiment *e, mcv_sweep *s, mcv_error *error) {
    *s = (mcv_sweep){.experiment = e, .table = {.descriptor = -1}};
    if (mcv_camera_wanted(&e->measuring.camera))
        MCV_TRY(mcv_camera_check_settings(&e->measuring.camera, error));
    if (e->measuring.until.count && e->render.replicates < 2)
        return mcv_fail(error, MCV_USAGE,
                        "--until needs uncertainties: give --replicates 2 or more");
    MCV_TRY(mcv_plan_parameters(&e->variation, &s->plan, error));
    MCV_TRY(mcv_measurement_read(&e->measuring, &s->measurement, error));
    if (e->measuring.bound) MCV_TRY(plan_bound(s, error));
    MCV_TRY(mcv_plan_sets(&e->variation, &s->plan, error));
    if (e->own_noise) MCV_TRY(mcv_set_seeds(s, error));
    s->done = calloc(s->plan.set_count, sizeof *s->done);
    s->renderer = e->renderer ? e->renderer : mcv_renderer_new();
    s->assets = e->assets ? e->assets : mcv_asset_cache_new();
    if (!s->done || !s->renderer || !s->assets)
        return mcv_fail(error, MCV_FAILED, "no memory for %zu sets", s->plan.set_count);
    MCV_TRY(mcv_judge_new(s, &s->judge, error));
    MCV_TRY(plan_files(s, error));
    MCV_TRY(check_rig(s, error));
    return check_paths(s, error);
}

mcv_result mcv_experiment_open_table(mcv_sweep *s, mcv_error *error) {
    const mcv_sidecar sidecar = {.path = s->table.sidecar,
                                 .table = s->table.path,
                                 .rig = s->experiment->rig,
                                 .fingerprint = s->fingerprint,
                                 .settings = s->experiment->settings};
    bool exists;
    if (!s->experiment->table) return MCV_OK;
    MCV_TRY(mcv_table_lock(&s->table, &exists, error));
    if (exists && !s->experiment->resume && !s->experiment->force)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s exists already: continue it by --resume, begin it again by "
                        "--force, or give another name by -o",
                        s->table.path);
    if (!exists && !s->experiment->force) MCV_TRY(mcv_sidecar_is_free(s->table.sidecar, error));
    const char *const files[] = {s->table.path, s->table.sidecar, s->table.page};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i)
        MCV_TRY(mcv_output_check(files[i], error));
    if (exists && s->experiment->resume) {
        MCV_TRY(mcv_sidecar_check(&sidecar, error));
        return mcv_table_resume(&s->table, s->done, error);
    }
    MCV_TRY(mcv_sidecar_write(&sidecar, error));
    return mcv_table_begin(&s->table, error);
}

static mcv_result run_in_order(mcv_sweep *s, const mcv_set_place *order, mcv_error *error) {
    const size_t *share = s->experiment->share;
    double row[MCV_ROW_MOST];
    bool wanted = false;
    for (size_t i = 0; i < s->plan.set_count; ++i) {
        const size_t set = order ? order[i].set : i;
        if (share[1] > 0 && set % share[1] != share[0]) continue;
        MCV_TRY(mcv_plan_set(&s->plan, set, row, &wanted, error));
        if (wanted && !s->done[set]) MCV_TRY(mcv_run_set(s, set, row, error));
    }
    return MCV_OK;
}

static mcv_result run_sets(mcv_sweep *s, mcv_error *error) {
    mcv_set_place *order = NULL;
    if (s->judge) MCV_TRY(mcv_set_order(s, &order, error));
    const mcv_result result = run_in_order(s, order, error);
    free(order);
    return result;
}

mcv_result mcv_experiment_run(mcv_sweep *s, mcv_error *error) {
    mcv_error later = {""};
    const mcv_result result = run_sets(s, error);
    if (s->table.row_count == 0 || !s->experiment->table) return result;
    const mcv_result paged = mcv_experiment_page(s, result == MCV_OK ? error : &later);
    return result == MCV_OK ? paged : result;
}

void mcv_experiment_free(mcv_sweep *s) {
    mcv_judge_free(s->judge);
    mcv_table_free(&s->table);
    mcv_plan_free(&s->plan);
    if (!s->experiment->renderer) mcv_renderer_free(s->renderer);
    if (!s->experiment->assets) mcv_asset_cache_free(s->assets);
    free(s->done);
    *s = (mcv_sweep){.table = {.descriptor = -1}};
}
