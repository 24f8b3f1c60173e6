/* SPDX-License-Identifier: Apache-2.0 */
/* The probability of detection of the public interface. */
#include "verbs/pod.h"

#include "api/experiments.h"
#include "core/output_file.h"
#include "pod/common_noise.h"
#include "pod/page.h"
#include "pod/pictures.h"

#include <stdlib.h>

static mcv_result study_columns(const mcv_command *command, const char *table, const char *pictures,
                                const mcv_column_names *names, bool hits,
                                const mcv_columns *columns, char **report, mcv_error *error) {
    const mcv_pod_page page = {.table = table,
                               .size_name = names->size,
                               .value_name = names->value,
                               .title = command->pod_title,
                               .note = command->pod_note,
                               .pictures = pictures};
    mcv_pod_asked asked;
    mcv_pod_study study;
    mcv_report r;
    MCV_TRY(mcv_pod_asked_of(command, hits, &asked, error));
    if (command->pod_page) MCV_TRY(mcv_output_check(command->pod_page, error));
    mcv_result result = mcv_pod_study_make(&asked, columns, &study, error);
    if (result == MCV_OK && command->pod_page)
        result = mcv_pod_page_write(command->pod_page, &study, &page, error);
    if (result == MCV_OK) {
        result = mcv_report_keep(&r, command->json, error);
        if (result == MCV_OK) result = mcv_pod_report(&study, &r, error);
        if (result == MCV_OK && table && mcv_pod_common_noise(table, names->value))
            mcv_report_tell(
                &r, "warning",
                "the sets of this sweep have common random numbers, so that all defects "
                "are seen with one noise: its spread is not in the bound; sweep with "
                "--noise own");
        if (result == MCV_OK && command->pod_page) mcv_report_text(&r, "page", command->pod_page);
        if (result == MCV_OK)
            result = mcv_report_take(&r, report, error);
        else
            mcv_report_free(&r);
    }
    mcv_pod_study_free(&study);
    return result;
}

static mcv_result study_table(const mcv_command *command, const char *table, const char *pictures,
                              char **report, mcv_error *error) {
    mcv_column_names names;
    mcv_columns columns;
    bool hits;
    MCV_TRY(mcv_pod_names_of(command, &names, &hits, error));
    mcv_result result = mcv_columns_read(table, &names, &columns, error);
    if (result == MCV_OK)
        result = study_columns(command, table, pictures, &names, hits, &columns, report, error);
    mcv_columns_free(&columns);
    return result;
}

static mcv_result pod_table(const char *table, const char *options, const char *pictures,
                            char **report, mcv_error *error) {
    const char *const arguments[2] = {table};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_POD, arguments, NULL, &given, error));
    const mcv_result result = study_table(&given.command, table, pictures, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_pod_table(const char *table, const char *options, char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(table);
    MCV_INSIDE(result, pod_table(table, options, NULL, report, error));
    return result;
}

static mcv_result pod_values(const mcv_columns *columns, bool hits, const char *options,
                             char **report, mcv_error *error) {
    static const char *const without[] = {"size", "signal", "hit", "defect", NULL};
    const char *const arguments[2] = {"values"};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_POD, arguments, without, &given, error));
    const mcv_result result = study_columns(&given.command, NULL, NULL, &(mcv_column_names){NULL},
                                            hits, columns, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_pod_values(const double *sizes, const double *values, size_t count, bool hits,
                          const char *options, char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(sizes);
    MCV_NEED(values);
    /* Read alone. */
    const mcv_columns columns = {
        .sizes = (double *)sizes, .values = (double *)values, .count = count};
    MCV_INSIDE(result, pod_values(&columns, hits, options, report, error));
    return result;
}

/* --- experiments --- */

/* What the options of an experiment say, apart. */
typedef struct experiment {
    char *sweep, *study; /* the options of each */
    const char *table;   /* inside of object: */
    json_t *object;
} experiment;

static void experiment_free(experiment *e) {
    free(e->sweep);
    free(e->study);
    json_decref(e->object);
}

/* What is wrong with the study is told before the first set is rendered. */
static mcv_result check_study(const experiment *e, mcv_error *error) {
    const char *const arguments[2] = {e->table};
    mcv_options_given given;
    mcv_column_names names;
    mcv_pod_asked asked;
    bool hits;
    MCV_TRY(mcv_options_read(e->study, NULL, MCV_VERB_POD, arguments, NULL, &given, error));
    mcv_result result = mcv_pod_names_of(&given.command, &names, &hits, error);
    if (result == MCV_OK) result = mcv_pod_asked_of(&given.command, hits, &asked, error);
    if (result == MCV_OK && given.command.pod_page)
        result = mcv_output_check(given.command.pod_page, error);
    mcv_options_free(&given);
    return result;
}

static mcv_result experiment_read(const char *options, experiment *e, mcv_error *error) {
    MCV_TRY(mcv_options_object(options, &e->object, error));
    json_t *study = json_object_get(e->object, "pod"), *json = json_object_get(e->object, "json");
    e->table = json_string_value(json_object_get(e->object, "output"));
    if (!e->table)
        return mcv_fail(error, MCV_USAGE,
                        "options: output: is missing: the table of the sets, as in \"study.csv\"");
    if (!json_is_object(study))
        return mcv_fail(error, MCV_USAGE,
                        "options: pod: is missing: what to tell, as in \"pod\": {\"size\": "
                        "\"depth\", \"signal\": \"contrast\", \"threshold\": \"5\"}");
    if (json) json_object_set(study, "json", json);
    e->study = json_dumps(study, JSON_REAL_PRECISION(17));
    json_object_del(e->object, "pod");
    /* With common random numbers all defects would have one noise, and its spread were not seen. */
    if (!json_object_get(e->object, "noise"))
        json_object_set_new(e->object, "noise", json_string("own"));
    e->sweep = json_dumps(e->object, JSON_REAL_PRECISION(17));
    return e->study && e->sweep ? check_study(e, error)
                                : mcv_fail(error, MCV_FAILED, "no memory for the options");
}

/* Renders what the table lacks; *pictures becomes what the page shows of it. */
static mcv_result run_study(const mcv_experiment *asked, const mcv_command *command,
                            char **pictures, mcv_error *error) {
    mcv_sweep s;
    (void)command;
    mcv_result result = mcv_experiment_plan(asked, &s, error);
    if (result == MCV_OK) result = mcv_experiment_open_table(&s, error);
    if (result == MCV_OK) result = mcv_experiment_run(&s, error);
    if (result == MCV_OK) result = mcv_experiment_finished(&s, error);
    if (result == MCV_OK) result = mcv_pod_pictures(&s, pictures, error);
    mcv_experiment_free(&s);
    return result;
}

mcv_result mcv_session_pod(mcv_session *session, const mcv_rig *rig, const char *options,
                           mcv_told_call *told, void *user, char **report, mcv_error *error) {
    experiment e = {NULL};
    char *pictures = NULL;
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_INSIDE(result, experiment_read(options, &e, error));
    if (result == MCV_OK)
        result = mcv_session_experiment(session, rig, MCV_VERB_SWEEP, e.sweep, run_study, told,
                                        user, &pictures, error);
    if (result == MCV_OK) MCV_INSIDE(result, pod_table(e.table, e.study, pictures, report, error));
    free(pictures);
    experiment_free(&e);
    return result;
}
