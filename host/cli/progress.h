/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Progress of a render with the time left: on a terminal one line that rewrites itself, elsewhere a
 * plain line every 10 s. Without colours or escape sequences, so NO_COLOR is always honoured.
 */
#ifndef MCVISI_HOST_CLI_PROGRESS_H
#define MCVISI_HOST_CLI_PROGRESS_H

#include "mcvisi/mcvisi.h"

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>

typedef struct mcv_progress_line {
    FILE *stream;
    bool terminal;
    const char *label;   /* what is rendered, such as the sensor's name */
    const char *picture; /* of a preview that comes while kernels compile; NULL: none does */
    const volatile sig_atomic_t
        *stop;       /* a signal handler's flag: not 0 stops the render; may be NULL */
    double reported; /* seconds of the last line; negative: none yet */
    double first[2]; /* fraction and seconds at the first samples; the time before does not predict
                        the rest */
    bool begun;      /* `first` is set */
    int width;       /* width of the line on the terminal, which the next one overwrites */
} mcv_progress_line;

/* A line on stderr; it counts as a terminal if its cursor can return to the start of the line. */
mcv_progress_line mcv_progress_stderr(const char *label, const volatile sig_atomic_t *stop);

/* Tells how far the render is: fraction 0 … 1, NaN while kernels are compiled; seconds so far;
 * error: relative, so far; NaN or 0: not known. False where it must stop. */
bool mcv_progress_report(mcv_progress_line *line, double fraction, double seconds, double error);

/* The progress of a call of the library: its callback, with `user` one of these, which begins with
 * {.open = false}. Where it is open in the end, its line is to be ended. */
typedef struct mcv_progress_shown {
    mcv_progress_line line;
    bool open;
} mcv_progress_shown;

bool mcv_progress_show(void *user, const mcv_progress *progress);

/* Clears the line on the terminal. */
void mcv_progress_end(mcv_progress_line *line);

#endif
