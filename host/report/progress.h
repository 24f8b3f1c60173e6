/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Progress of a render with the time left: on a terminal one line that rewrites itself, elsewhere a
 * plain line every 10 s. Without colours or escape sequences, so NO_COLOR is always honoured.
 */
#ifndef MCVISI_HOST_REPORT_PROGRESS_H
#define MCVISI_HOST_REPORT_PROGRESS_H

#include "render/render.h"

#include <signal.h>
#include <stdio.h>

typedef struct mcv_progress_line {
    FILE *stream;
    bool terminal;
    const char *label;   /* what is rendered, such as the sensor's name */
    const char *picture; /* path of a preview that is there before the image; NULL: none yet */
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

/* An mcv_pass_told whose user is the mcv_progress_line. error: relative, so far; NaN or 0: not
 * known. */
mcv_pass_told mcv_progress_report;

/* Clears the line on the terminal. */
void mcv_progress_end(mcv_progress_line *line);

#endif
