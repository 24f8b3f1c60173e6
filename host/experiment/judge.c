/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/judge.h"

#include "core/basics.h"
#include "experiment/experiment.h"
#include "experiment/judge_images.h"
#include "statistics/rate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct mcv_judge {
    const mcv_sweep *sweep;
    mcv_judge_images images;
    mcv_program programs[MCV_METRICS];
    size_t program_of[MCV_METRICS]; /* of each metric; MCV_METRICS: none */
    size_t program_count;
    double known[MCV_ROW_MOST]; /* the row of the exposures */
    uint64_t scene;             /* of them */
    bool exposed;
};

bool mcv_judge_has(const mcv_parameter *p) { return strncmp(p->item, "process/", 8) == 0; }

uint64_t mcv_judge_scene(const mcv_sweep *s, const double *numbers) {
    uint64_t hash = MCV_HASH_BEGIN;
    for (size_t i = 0; i < s->plan.count; ++i)
        if (!mcv_judge_has(s->plan.parameters + i))
            hash = mcv_hash_bytes(hash, numbers + i, sizeof *numbers);
    return hash;
}

/* --- programs --- */

static mcv_result add_program(mcv_judge *j, size_t metric, mcv_error *error) {
    const mcv_metric *m = j->sweep->measurement.metrics;
    j->program_of[metric] = MCV_METRICS;
    if (!mcv_program_named(m[metric].expression)) return MCV_OK;
    for (size_t i = 0; i < metric; ++i)
        if (strcmp(m[i].expression, m[metric].expression) == 0) {
            j->program_of[metric] = j->program_of[i];
            return MCV_OK;
        }
    mcv_program *p = j->programs + j->program_count;
    j->program_of[metric] = j->program_count++;
    MCV_TRY(mcv_program_read(m[metric].expression, p, error));
    p->limit = j->sweep->experiment->measuring.exec_time;
    return MCV_OK;
}

mcv_result mcv_judge_new(const mcv_sweep *sweep, mcv_judge **judge, mcv_error *error) {
    const mcv_measuring *asked = &sweep->experiment->measuring;
    bool wanted = false;
    *judge = NULL;
    for (size_t i = 0; i < sweep->measurement.count; ++i)
        wanted = wanted || mcv_program_named(sweep->measurement.metrics[i].expression);
    for (size_t i = 0; i < sweep->plan.count && !wanted; ++i)
        if (mcv_judge_has(sweep->plan.parameters + i))
            return mcv_fail(error, MCV_USAGE,
                            "--vary %s: no program takes it: give one, as in --metric "
                            "\"found:=exec(python3 judge.py)\"",
                            sweep->plan.parameters[i].item);
    if (!wanted) return MCV_OK;
    if (!asked->allow_exec)
        return mcv_fail(error, MCV_USAGE,
                        "--metric has exec() or worker(), which run a program: allow it by "
                        "--allow-exec, outside of any file");
    if (!mcv_camera_wanted(&asked->camera))
        return mcv_fail(error, MCV_USAGE,
                        "exec() and worker() get the grey values of a camera: give "
                        "--exposure-time, --electrons-per-unit or --expose-to");
    mcv_judge *j = *judge = calloc(1, sizeof *j);
    if (!j) return mcv_fail(error, MCV_FAILED, "no memory for programs");
    j->sweep = sweep;
    for (size_t i = 0; i < sweep->measurement.count; ++i) MCV_TRY(add_program(j, i, error));
    return mcv_judge_images_open(&j->images, asked, error);
}

void mcv_judge_free(mcv_judge *judge) {
    if (!judge) return;
    for (size_t i = 0; i < judge->program_count; ++i) mcv_program_free(judge->programs + i);
    mcv_judge_images_close(&judge->images);
    free(judge);
}

/* --- exposures --- */

const double *mcv_judge_known(const mcv_judge *j, uint64_t scene) {
    return j->exposed && j->scene == scene ? j->known : NULL;
}

mcv_result mcv_judge_expose(mcv_judge *j, uint64_t scene, const mcv_scene *of, uint32_t sensor,
                            const mcv_film *film, const double *row, mcv_error *error) {
    j->exposed = false;
    MCV_TRY(mcv_judge_images_make(&j->images, scene, of, sensor, film, error));
    memcpy(j->known, row, j->sweep->table.columns * sizeof *row);
    j->scene = scene;
    j->exposed = true;
    return MCV_OK;
}

/* --- questions and answers --- */

static char *question(const mcv_judge *j, size_t set, size_t exposure, const double *row) {
    const mcv_plan *plan = &j->sweep->plan;
    char path[PATH_MAX];
    json_t *document = json_object(), *parameters = json_object();
    mcv_judge_image_path(&j->images, exposure, path);
    for (size_t i = 0; i < plan->count; ++i)
        json_object_set_new(parameters, plan->parameters[i].name,
                            mcv_parameter_json(plan->parameters + i, row[i]));
    json_object_set_new(document, "image", json_string(path));
    json_object_set_new(document, "set", json_integer((json_int_t)set));
    json_object_set_new(document, "exposure", json_integer((json_int_t)exposure));
    json_object_set_new(document, "parameters", parameters);
    json_object_set_new(document, "bits", json_integer((json_int_t)j->images.bits));
    json_object_set(document, "camera_model", j->images.model ? j->images.model : json_null());
    char *line = json_dumps(document, JSON_COMPACT), *whole = NULL;
    json_decref(document);
    if (line && asprintf(&whole, "%s\n", line) < 0) whole = NULL;
    free(line);
    return whole;
}

/* The members of the answer that are this program's metrics. */
static mcv_result take_answer(const mcv_judge *j, size_t program, const char *text,
                              double values[MCV_METRICS], mcv_error *error) {
    const char *name = j->programs[program].name;
    json_error_t wrong;
    json_t *answer = json_loads(text, JSON_DISABLE_EOF_CHECK, &wrong);
    if (!json_is_object(answer)) {
        json_decref(answer);
        return mcv_fail(error, MCV_FAILED,
                        "the program %s answered \"%.*s\": must be a JSON object on one line", name,
                        mcv_whole_characters(text, 60), text);
    }
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < j->sweep->measurement.count; ++i) {
        const char *metric = j->sweep->measurement.metrics[i].name;
        const json_t *value = json_object_get(answer, metric);
        if (j->program_of[i] != program) continue;
        values[i] = json_is_boolean(value) ? json_is_true(value) : json_number_value(value);
        if (!json_is_number(value) && !json_is_boolean(value) && result == MCV_OK)
            result = mcv_fail(error, MCV_FAILED,
                              "the program %s answered without a number \"%s\": \"%.*s\"", name,
                              metric, mcv_whole_characters(text, 60), text);
    }
    json_decref(answer);
    return result;
}

static mcv_result ask(mcv_judge *j, size_t program, size_t set, size_t exposure, const double *row,
                      double values[MCV_METRICS], mcv_error *error) {
    const mcv_sweep_calls *calls = &j->sweep->experiment->calls;
    char *answer = NULL, *line = question(j, set, exposure, row);
    if (!line) return mcv_fail(error, MCV_FAILED, "no memory for a question");
    mcv_result result = mcv_program_ask(j->programs + program, line, calls->interrupted,
                                        calls->user, &answer, error);
    if (result == MCV_OK) result = take_answer(j, program, answer, values, error);
    free(line);
    free(answer);
    return result;
}

/* Mean and standard uncertainty of the exposures. Of decisions, 0 or 1, it is half the width of
 * Wilson's interval of 68.27 %: that of ten hits of ten is not 0. */
static void take_mean(double sum, double squares, size_t ones, size_t count, double number[2]) {
    const double n = (double)count, mean = sum / n;
    number[0] = mean;
    number[1] = NAN;
    if (count < 2) return;
    if ((double)ones == sum && squares == sum) {
        const mcv_interval w = mcv_wilson(sum, n, 0.6827);
        number[1] = 0.5 * (w.high - w.low);
    } else {
        number[1] = sqrt(fmax(0, squares - n * mean * mean) / (n - 1) / n);
    }
}

mcv_result mcv_judge_decide(mcv_judge *j, size_t set, double *row, mcv_error *error) {
    const size_t metrics = j->sweep->measurement.count, exposures = j->images.count;
    double sums[MCV_METRICS] = {0}, squares[MCV_METRICS] = {0}, values[MCV_METRICS] = {0};
    size_t ones[MCV_METRICS] = {0};
    for (size_t k = 0; k < exposures; ++k) {
        for (size_t p = 0; p < j->program_count; ++p)
            MCV_TRY(ask(j, p, set, k, row, values, error));
        for (size_t i = 0; i < metrics; ++i) {
            sums[i] += values[i];
            squares[i] += values[i] * values[i];
            ones[i] += values[i] == 1;
        }
    }
    for (size_t i = 0; i < metrics; ++i)
        if (j->program_of[i] < MCV_METRICS)
            take_mean(sums[i], squares[i], ones[i], exposures,
                      row + mcv_row_metric(&j->sweep->table, i));
    return MCV_OK;
}
