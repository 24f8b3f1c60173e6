/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/progress.h"

#include "cli/interrupt.h"

#include "core/basics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Seconds between two lines. */
#define TERMINAL_INTERVAL 0.1
#define PLAIN_INTERVAL 10.0

mcv_progress_line mcv_progress_stderr(const char *label, const volatile sig_atomic_t *stop) {
    const char *kind = getenv("TERM");
    return (mcv_progress_line){.stream = stderr,
                               .terminal =
                                   isatty(STDERR_FILENO) && !(kind && strcmp(kind, "dumb") == 0),
                               .label = label,
                               .stop = stop,
                               .reported = -1};
}

/* "1 h 05 min", "3 min 20 s", "7 s" */
static void format_duration(char *text, size_t size, double seconds) {
    const double whole = ceil(seconds);
    if (whole >= 3600) {
        snprintf(text, size, "%.0f h %02.0f min", floor(whole / 3600),
                 floor(fmod(whole, 3600) / 60));
    } else if (whole >= 60) {
        snprintf(text, size, "%.0f min %02.0f s", floor(whole / 60), fmod(whole, 60));
    } else {
        snprintf(text, size, "%.0f s", whole);
    }
}

bool mcv_progress_report(mcv_progress_line *line, double fraction, double seconds, double error) {
    const bool go_on = !line->stop || *line->stop == 0;
    if (!line->begun && !isnan(fraction)) {
        line->begun = true;
        line->first[0] = fraction;
        line->first[1] = seconds;
    }
    const double since = seconds - (line->reported < 0 ? 0 : line->reported);
    /* Plain lines: none in the first 10 s, so that short renders are silent in logs. */
    if (since < (line->terminal ? (line->reported < 0 ? 0 : TERMINAL_INTERVAL) : PLAIN_INTERVAL))
        return go_on;
    line->reported = seconds;

    char spent[32], left[40] = "", reached[40] = "", text[256];
    int width;
    format_duration(spent, sizeof spent, seconds);
    if (fraction > line->first[0] && fraction <= 1) {
        char duration[32];
        format_duration(duration, sizeof duration,
                        (seconds - line->first[1]) * (1 - fraction) / (fraction - line->first[0]));
        snprintf(left, sizeof left, ", %s left", duration);
    }
    if (isfinite(error) && error > 0)
        snprintf(reached, sizeof reached, ", error %.2g %%", 100 * error);
    if (isnan(fraction))
        width = snprintf(text, sizeof text, "%s: compiling kernels%s%s", line->label,
                         line->picture ? "; a coarse preview comes in " : "",
                         line->picture ? line->picture : "");
    else
        width = snprintf(text, sizeof text, "%s: %3.0f %%%s, %s%s", line->label,
                         100 * fmin(fraction, 1), reached, spent, left);
    if (width >= (int)sizeof text) width = (int)sizeof text - 1;
    if (line->terminal) fputc('\r', line->stream);
    mcv_print_line(line->stream, text);
    if (!line->terminal)
        fputc('\n', line->stream);
    else
        fprintf(line->stream, "%*s", width < line->width ? line->width - width : 0, "");
    if (line->terminal) line->width = width;
    fflush(line->stream);
    return go_on;
}

void mcv_progress_end(mcv_progress_line *line) {
    if (line->terminal && line->width > 0) fprintf(line->stream, "\r%*s\r", line->width, "");
    fflush(line->stream);
    line->width = 0;
}

bool mcv_progress_show(void *user, const mcv_progress *progress) {
    mcv_progress_shown *s = user;
    if (!s->open) {
        mcv_interrupt_watch(false);
        s->line = mcv_progress_stderr(progress->sensor, &mcv_interrupt);
        s->open = true;
        return mcv_interrupt == 0;
    }
    return mcv_progress_report(&s->line, progress->fraction, progress->seconds, progress->error);
}
