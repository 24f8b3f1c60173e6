/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A report, printed for people or as JSON. Keys are those of the JSON; people read them with spaces
 * instead of underscores. Numbers are SI in JSON (null: infinite) and in suitable units for people.
 * NaN means that there is no value, and is omitted.
 */
#ifndef MCVISI_HOST_VERBS_REPORT_H
#define MCVISI_HOST_VERBS_REPORT_H

#include "core/error.h"

#include <jansson.h>
#include <stdio.h>

enum { MCV_REPORT_DEPTH = 8 };

/* Takes a sentence about the work beside its result. */
typedef void mcv_report_told(const char *severity, const char *text);

typedef struct mcv_report {
    json_t *open[MCV_REPORT_DEPTH]; /* objects and arrays, the innermost last; NULL for people */
    int depth;
    bool json;
    bool failed;           /* a value had no memory */
    mcv_report_told *told; /* NULL: such sentences are kept as notes */
    json_t *notes;
    FILE *out;  /* for people; where it is kept: */
    char *text; /* owned by the stream, */
    size_t size;
} mcv_report;

/* A report that is printed to standard output: as JSON in the end, for people as it is made. */
void mcv_report_begin(mcv_report *report, bool json, mcv_report_told *told);

/* A report that is kept for mcv_report_take. It must not be moved. After failure, too, it is freed
 * by mcv_report_free. */
mcv_result mcv_report_keep(mcv_report *report, bool json, mcv_error *error);

/* A sentence about the work: a warning, a note. Of a kept report it is a member of "notes", or a
 * line before the text. */
void mcv_report_tell(mcv_report *report, const char *severity, const char *text);

/* Each of these ends a report; a failure before is the last. Prints the JSON; or gives a kept
 * report as a text, to be freed; or throws it away. MCV_FAILED without memory. */
mcv_result mcv_report_end(mcv_report *report, mcv_error *error);
mcv_result mcv_report_take(mcv_report *report, char **text, mcv_error *error);
void mcv_report_free(mcv_report *report);

/* Opens an object or a list, a member of the surrounding object. */
void mcv_report_open(mcv_report *report, const char *key);
void mcv_report_list(mcv_report *report, const char *key);

/* Opens the next object of a list, with its name and type. */
void mcv_report_element(mcv_report *report, const char *name, const char *type);

/* Closes an object, a list or an element. */
void mcv_report_close(mcv_report *report);

void mcv_report_text(mcv_report *report, const char *key, const char *text);
void mcv_report_flag(mcv_report *report, const char *key, bool value);

/* Puts a value into JSON, which owns it; people do not read it. */
void mcv_report_value(mcv_report *report, const char *key, json_t *value);

/* Puts a number. unit: "m" and "rad" get suitable units for people, "" is none, others follow the
 * number. */
void mcv_report_number(mcv_report *report, const char *key, const char *unit, double value);

/* Puts a measured number and its standard uncertainty (NaN: not known), {"value": …, "uncertainty":
 * …} in JSON. */
void mcv_report_quantity(mcv_report *report, const char *key, const char *unit, double value,
                         double uncertainty);

/* Puts three channels; people read one number if they are equal. */
void mcv_report_spectrum(mcv_report *report, const char *key, const char *unit,
                         const double spectrum[3]);

/* Puts several numbers, separated by e.g. " x " for people; omitted if the first is NaN. */
void mcv_report_numbers(mcv_report *report, const char *key, const char *unit, const char *between,
                        const double *values, size_t count);

#endif
