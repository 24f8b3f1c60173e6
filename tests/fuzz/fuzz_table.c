/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of sweeps: columns of a study of detection, parts to join, and rows to go on from. */
#include "fuzz.h"

#include "core/basics.h"
#include "experiment/table.h"
#include "pod/study.h"
#include "verbs/merge_tables.h"

#include <math.h>

static void study(mcv_error *error) {
    static const mcv_column_names names = {"size", "signal", "set"};
    const mcv_pod_asked asked = {.signals = true,
                                 .threshold = 2,
                                 .false_calls = (double)NAN,
                                 .low = (double)NAN,
                                 .high = (double)NAN,
                                 .confidence = 0.95,
                                 .seed = 1};
    mcv_columns columns;
    mcv_pod_study found;
    mcv_result result = mcv_columns_read("in.csv", &names, &columns, error);
    fuzz_sentence(result, error);
    if (result == MCV_OK && columns.count < 64) { /* more only take time */
        result = mcv_pod_study_make(&asked, &columns, &found, error);
        fuzz_sentence(result, error);
        mcv_pod_study_free(&found);
    }
    mcv_columns_free(&columns);
}

static void join(mcv_error *error) {
    static const char *const paths[] = {"in.csv", "other.csv"};
    mcv_report report;
    if (mcv_report_keep(&report, true, error) != MCV_OK) return;
    fuzz_sentence(mcv_tables_join((mcv_texts){paths, 2}, "out.csv", true, &report, error), error);
    mcv_report_free(&report);
}

/* Of a plan with one parameter and one metric. */
static void go_on(mcv_error *error) {
    mcv_plan plan = {.count = 1, .varied = 1, .set_count = 8};
    mcv_measurement measurement = {.count = 1};
    mcv_table table;
    bool done[8] = {false}, exists;
    snprintf(plan.parameters[0].name, sizeof plan.parameters[0].name, "size");
    snprintf(measurement.metrics[0].name, sizeof measurement.metrics[0].name, "signal");
    mcv_result result = mcv_table_plan(&table, "in.csv", &plan, &measurement, error);
    if (result == MCV_OK) result = mcv_table_lock(&table, &exists, error);
    if (result == MCV_OK) result = mcv_table_resume(&table, done, error);
    fuzz_sentence(result, error);
    mcv_table_free(&table);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static void (*const uses[])(mcv_error *) = {study, join, go_on};
    static const char sidecar[] = "{\"metric\": [\"signal\"]}",
                      other[] = "set,size,signal,signal_u,samples,render_error,seconds,message\n"
                                "7,1,2,0,4,0,0,\n";
    mcv_error error = {""};
    if (size < 1) return 0;
    fuzz_file("in.csv", data + 1, size - 1);
    fuzz_file("in.json", (const uint8_t *)sidecar, sizeof sidecar - 1);
    fuzz_file("other.csv", (const uint8_t *)other, sizeof other - 1);
    fuzz_file("other.json", (const uint8_t *)sidecar, sizeof sidecar - 1);
    uses[data[0] % 3](&error);
    return 0;
}
