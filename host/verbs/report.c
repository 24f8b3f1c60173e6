/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/report.h"

#include "core/basics.h"
#include "core/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LABEL_WIDTH = 24 };

void mcv_report_begin(mcv_report *report, bool json, mcv_report_told *told) {
    *report = (mcv_report){
        .open = {json ? json_object() : NULL}, .json = json, .told = told, .out = stdout};
}

mcv_result mcv_report_keep(mcv_report *report, bool json, mcv_error *error) {
    *report = (mcv_report){.open = {json ? json_object() : NULL}, .json = json};
    report->notes = json_array();
    if (!json) report->out = open_memstream(&report->text, &report->size);
    return report->notes && (json ? report->open[0] != NULL : report->out != NULL)
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "no memory for the report");
}

void mcv_report_tell(mcv_report *report, const char *severity, const char *text) {
    if (report->told)
        report->told(severity, text);
    else
        json_array_append_new(report->notes, json_pack("{s:s, s:o}", "severity", severity, "text",
                                                       mcv_json_text(text)));
}

mcv_result mcv_report_end(mcv_report *report, mcv_error *error) {
    if (!report->json) return MCV_OK;
    const int failed =
        json_dumpf(report->open[0], stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    mcv_report_free(report);
    putchar('\n');
    return failed ? mcv_fail(error, MCV_FAILED, "the JSON could not be written to standard output")
                  : MCV_OK;
}

/* What was told comes before the report, a line each: "warning: SENTENCE". */
static char *take_text(mcv_report *report) {
    char *text = NULL;
    size_t size = 0, i;
    const json_t *note;
    FILE *out = open_memstream(&text, &size);
    const bool kept = mcv_text_close(report->out, &report->text);
    if (out && kept) {
        json_array_foreach(report->notes, i, note) {
            fprintf(out, "%s: %s\n", json_string_value(json_object_get(note, "severity")),
                    json_string_value(json_object_get(note, "text")));
        }
        fputs(report->text, out);
    }
    (void)mcv_text_close(out, &text);
    if (!kept) {
        free(text);
        text = NULL;
    }
    report->out = NULL;
    return text;
}

mcv_result mcv_report_take(mcv_report *report, char **text, mcv_error *error) {
    if (!report->json) {
        *text = take_text(report);
    } else {
        if (json_array_size(report->notes) > 0)
            json_object_set(report->open[0], "notes", report->notes);
        *text = report->failed
                    ? NULL
                    : json_dumps(report->open[0], JSON_COMPACT | JSON_REAL_PRECISION(17));
    }
    mcv_report_free(report);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the report");
}

void mcv_report_free(mcv_report *report) {
    json_decref(report->open[0]);
    json_decref(report->notes);
    if (report->out && report->out != stdout) fclose(report->out);
    free(report->text);
    *report = (mcv_report){.json = report->json};
}

/* Puts a value (owned) into the innermost object or list; false without memory, which
 * mcv_report_take tells. */
static bool put(mcv_report *report, const char *key, json_t *value) {
    json_t *into = report->open[report->depth];
    const bool done = (json_is_array(into) ? json_array_append_new(into, value)
                                           : json_object_set_new(into, key, value)) == 0;
    report->failed = report->failed || !done;
    return done;
}

void mcv_report_value(mcv_report *report, const char *key, json_t *value) {
    if (report->json)
        put(report, key, value);
    else
        json_decref(value);
}

static void enter(mcv_report *report, const char *key, json_t *value) {
    const bool done = !report->json || put(report, key, value);
    report->open[++report->depth] = done ? value : NULL;
}

void mcv_report_open(mcv_report *report, const char *key) {
    if (!report->json) fprintf(report->out, "%*s%s\n", 2 * report->depth, "", key);
    enter(report, key, report->json ? json_object() : NULL);
}

void mcv_report_list(mcv_report *report, const char *key) {
    if (!report->json) fprintf(report->out, "%*s%s\n", 2 * report->depth, "", key);
    enter(report, key, report->json ? json_array() : NULL);
}

void mcv_report_element(mcv_report *report, const char *name, const char *type) {
    if (!report->json) {
        fprintf(report->out, "%*s", 2 * report->depth, "");
        mcv_print_line(report->out, name);
        fprintf(report->out, "%s%s\n", name[0] ? ": " : "", type);
    }
    enter(report, NULL, report->json ? json_object() : NULL);
    if (!report->json) return;
    mcv_report_text(report, "name", name);
    mcv_report_text(report, "type", type);
}

void mcv_report_close(mcv_report *report) { --report->depth; }

static void print_label(const mcv_report *report, const char *key) {
    int at = fprintf(report->out, "%*s", 2 * report->depth, "");
    for (const char *c = key; *c; ++c, ++at) fputc(*c == '_' ? ' ' : *c, report->out);
    fprintf(report->out, "%*s", at < LABEL_WIDTH ? LABEL_WIDTH - at : 1, "");
}

void mcv_report_text(mcv_report *report, const char *key, const char *text) {
    if (report->json) {
        put(report, key, mcv_json_text(text));
    } else {
        print_label(report, key);
        mcv_print_line(report->out, text);
        fputc('\n', report->out);
    }
}

void mcv_report_flag(mcv_report *report, const char *key, bool value) {
    if (report->json)
        put(report, key, json_boolean(value));
    else
        mcv_report_text(report, key, value ? "yes" : "no");
}

/* Integers stay integers in JSON, as far as a double represents them. */
static json_t *number(double value) {
    if (!isfinite(value)) return json_null();
    return value == floor(value) && fabs(value) < 0x1p53 ? json_integer((json_int_t)value)
                                                         : json_real(value);
}

/* The unit that suits the largest value. */
static const char *handy_unit(const char *unit, const double *values, size_t count,
                              double *factor) {
    static const struct {
        const char *name;
        double factor;
    } lengths[4] = {{"m", 1}, {"mm", 1e3}, {"µm", 1e6}, {"nm", 1e9}},
      sizes[4] = {{"GiB", 0x1p-30}, {"MiB", 0x1p-20}, {"KiB", 0x1p-10}, {"B", 1}};
    const bool length = strcmp(unit, "m") == 0;
    double most = 0;
    for (size_t i = 0; i < count; ++i)
        if (isfinite(values[i])) most = fmax(most, fabs(values[i]));
    *factor = 1;
    if (strcmp(unit, "rad") == 0) {
        *factor = 180 / M_PI;
        return "°";
    }
    if (!length && strcmp(unit, "B") != 0) return unit;
    size_t i = most == 0 ? 1 : 0;
    while (most > 0 && i < 3 && most * (length ? lengths : sizes)[i].factor < 1) ++i;
    *factor = (length ? lengths : sizes)[i].factor;
    return (length ? lengths : sizes)[i].name;
}

void mcv_report_numbers(mcv_report *report, const char *key, const char *unit, const char *between,
                        const double *values, size_t count) {
    if (isnan(values[0])) return;
    if (report->json) {
        json_t *list = json_array();
        for (size_t i = 0; i < count; ++i) json_array_append_new(list, number(values[i]));
        put(report, key, list);
        return;
    }
    double factor, largest = 0;
    for (size_t i = 0; i < count; ++i) largest = fmax(largest, fabs(values[i]));
    const char *name = handy_unit(unit, values, count, &factor);
    print_label(report, key);
    for (size_t i = 0; i < count; ++i) {
        if (i) fputs(between, report->out);
        if (isfinite(values[i])) /* a rounded 0 is printed as 0; + 0: no -0 */
            fprintf(report->out, "%.6g",
                    fabs(values[i]) > 1e-14 * largest || !isfinite(largest)
                        ? values[i] * factor + 0.0
                        : 0);
        else
            fputs("infinite", report->out);
    }
    fprintf(report->out, "%s%s\n", name[0] ? " " : "", name);
}

void mcv_report_number(mcv_report *report, const char *key, const char *unit, double value) {
    if (isnan(value)) return;
    if (report->json)
        put(report, key, number(value));
    else
        mcv_report_numbers(report, key, unit, "", &value, 1);
}

void mcv_report_quantity(mcv_report *report, const char *key, const char *unit, double value,
                         double uncertainty) {
    if (isnan(value)) return;
    if (report->json) {
        json_t *object = json_object();
        json_object_set_new(object, "value", number(value));
        json_object_set_new(object, "uncertainty", number(uncertainty));
        put(report, key, object);
        return;
    }
    double factor;
    const char *name = handy_unit(unit, &value, 1, &factor);
    print_label(report, key);
    fprintf(report->out, "%.6g", value * factor + 0.0);
    if (isfinite(uncertainty)) fprintf(report->out, " ± %.2g", uncertainty * factor);
    fprintf(report->out, "%s%s\n", name[0] ? " " : "", name);
}

void mcv_report_spectrum(mcv_report *report, const char *key, const char *unit,
                         const double spectrum[3]) {
    const bool grey = spectrum[0] == spectrum[1] && spectrum[1] == spectrum[2];
    mcv_report_numbers(report, key, unit, ", ", spectrum, grey && !report->json ? 1 : 3);
}
