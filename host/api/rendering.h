/* SPDX-License-Identifier: Apache-2.0 */
/* What both kinds of render of the public interface share: into memory, and into files. */
#ifndef MCVISI_HOST_API_RENDERING_H
#define MCVISI_HOST_API_RENDERING_H

#include "api/early_preview.h"
#include "api/handles.h"
#include "api/saves.h"
#include "report/summary.h"
#include "transport/matrix.h"
#include "verbs/render_picture.h"

/* A render while it runs, for its callback. */
typedef struct mcv_rendering {
    mcv_progress_call *call; /* or NULL */
    void *user;
    locale_t host;
    mcv_rendered rendered;
    const mcv_rig *rig;
    double begun;
    char sensor[128]; /* its label */
    bool stopped;     /* a callback has said so */
    mcv_early *early; /* previews before the image, or NULL */
    mcv_saves *saves; /* checkpoints, or NULL */
    void (*warn)(struct mcv_rendering *rendering, const char *sentence); /* or NULL */
} mcv_rendering;

/* All that was set: in the rig, and for this render. The caller frees the items. */
mcv_result mcv_rendering_changes(mcv_rendering *r, const mcv_rig *rig, const mcv_command *command,
                                 mcv_error *error);

/* The work of a verb on a rig, with arguments of its own. */
typedef mcv_result mcv_rendering_work(void *own, const mcv_command *command, mcv_rendering *r,
                                      mcv_error *error);

/* Does it, with these options as text, between the beginning and the end of a session's call. */
mcv_result mcv_rendering_verb(mcv_session *session, const mcv_rig *rig, unsigned verb,
                              const char *options, mcv_progress_call *progress, void *user,
                              mcv_rendering_work *work, void *own, mcv_error *error);

/* Tells the callback how far it is. */
void mcv_rendering_tell(mcv_rendering *r, double fraction, double error, bool writing);

/* Begins the checkpoints of a render at this path, NULL: none, and reads the one that --resume goes
 * on with. After success r->saves is to be ended. */
mcv_result mcv_rendering_saves(mcv_rendering *r, const mcv_command *command, const mcv_scene *scene,
                               uint32_t sensor, const char *path, bool by_default, mcv_saves *saves,
                               mcv_error *error);

/* Renders a sensor into the film, which the caller frees, with what r->rendered needs of it. */
mcv_result mcv_rendering_run(mcv_rendering *r, mcv_session *session, const mcv_command *command,
                             const mcv_scene *scene, uint32_t sensor, mcv_render_options *options,
                             mcv_film *film, mcv_render_stats *stats, mcv_error *error);

/* Transport.c: renders the light transport matrix of a sensor (transport/matrix.h). The scene's
 * emitters then show white. The caller frees the matrix, also after failure. */
mcv_result mcv_rendering_matrix(mcv_session *session, const mcv_command *command, mcv_rendering *r,
                                mcv_scene *scene, uint32_t sensor, mcv_matrix *matrix,
                                mcv_error *error);

/* What is told of it. The sensor's label and the scene's path are borrowed. */
mcv_summary mcv_rendering_summary(const mcv_rendering *r, double seconds_load);

#endif
