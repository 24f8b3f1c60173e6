/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi render: every sensor of a scene, or one, into OpenEXR and PNG. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/verbs.h"

#include <math.h>
#include <stdio.h>

/* What is shown while it renders. */
typedef struct shown {
    const mcv_command *command;
    mcv_progress_line line;
    bool open; /* the line is of the sensor that is rendered */
} shown;

static void end_line(shown *s) {
    if (s->open) mcv_progress_end(&s->line);
    s->open = false;
}

/* Interrupts are watched from the begin of a sensor's render on: before, a signal ends the program
 * at once. */
static bool on_progress(void *user, const mcv_progress *progress) {
    shown *s = user;
    if (progress->writing) {
        end_line(s);
        mcv_interrupt_watch(true);
        return mcv_interrupt == 0;
    }
    if (!s->open) {
        mcv_interrupt_watch(false);
        s->line = mcv_progress_stderr(progress->sensor, &mcv_interrupt);
        s->open = true;
        return mcv_interrupt == 0;
    }
    if (mcv_interrupt_take_save()) {
        mcv_error ignored;
        (void)mcv_progress_save(progress, &ignored);
    }
    if (!isnan(progress->fraction)) mcv_interrupt_watch(false);
    s->line.picture = progress->preview;
    return mcv_progress_report(&s->line, progress->fraction, progress->seconds, progress->error);
}

static bool on_told(void *user, const char *report) {
    const shown *s = user;
    if (!s->command->json)
        mcv_client_text(report);
    else if (mcv_client_notes(report))
        mcv_client_line(report);
    return mcv_interrupt == 0;
}

mcv_result mcv_verb_render(const mcv_command *command, mcv_error *error) {
    shown s = {.command = command};
    mcv_client client;
    mcv_interrupt_keep_saves();
    mcv_result result = mcv_client_open(command, command->argument, &client, error);
    if (result == MCV_OK)
        result = mcv_session_render_files(client.session, client.rig, client.options, on_progress,
                                          on_told, &s, error);
    end_line(&s);
    mcv_client_close(&client);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}
