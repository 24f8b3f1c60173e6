/* SPDX-License-Identifier: Apache-2.0 */
/* What is inside of the public handles (mcvisi/mcvisi.h). */
#ifndef MCVISI_HOST_API_HANDLES_H
#define MCVISI_HOST_API_HANDLES_H

#include "api/border.h"
#include "loader/load.h"
#include "options/command.h"
#include "render/render.h"
#include "transport/matrix.h"
#include "verbs/picture.h"
#include "verbs/report.h"

#include <stdatomic.h>

struct mcv_session {
    atomic_flag busy;       /* a call is running */
    json_t *defaults;       /* options that count where a call says nothing */
    mcv_renderer *renderer; /* of this device: */
    char *device;           /* as given; NULL: the first */
    mcv_asset_cache *assets;
};

struct mcv_rig {
    mcv_document document;
    char *path, *folder; /* of the file, or "" */
    char **set;          /* what was changed since, PATH=VALUE */
    size_t set_count;
    uint64_t hash;  /* FNV-1a of the file's bytes, or of the text it was made from */
    double seconds; /* that its file took to read */
};

struct mcv_transport {
    mcv_matrix matrix;
    char *path; /* of the file, or of the scene */
};

/* Relight.c: the image of a pattern, [element][channel], as a picture with the header of the
 * render. */
mcv_result mcv_transport_light(const mcv_transport *transport, const float *pattern,
                               mcv_picture **picture, mcv_error *error);

/* A rig of a document, which changes owners, also on failure. */
mcv_result mcv_rig_of(mcv_document *document, const char *path, const char *folder, mcv_rig **rig,
                      mcv_error *error);

/* Changes a tree as the command says, and reports on it. */
typedef mcv_result mcv_rig_edit(const mcv_rig *rig, const mcv_command *command, json_t *root,
                                mcv_report *report, mcv_error *error);

/* Edits a copy of the rig's tree: after failure the rig is as it was. *report may be NULL. */
mcv_result mcv_rig_change(mcv_rig *rig, const mcv_command *command, mcv_rig_edit *edit,
                          char **report, mcv_error *error);

/* What was changed since the document was read, for the header of pictures. */
mcv_overrides mcv_rig_changes(const mcv_rig *rig);

/* Session.c: a call on the session begins, MCV_USAGE while another one runs; it ends. */
mcv_result mcv_session_begin(mcv_session *session, mcv_error *error);
void mcv_session_end(mcv_session *session);

/* The session's renderer on the device of these options. */
mcv_result mcv_session_renderer(mcv_session *session, const char *device, mcv_renderer **renderer,
                                mcv_error *error);

/* The scene of a rig with the option `set` on top; of the session's assets, or without a session.
 */
mcv_result mcv_session_scene(mcv_session *session, const mcv_rig *rig, const mcv_command *command,
                             mcv_scene **scene, mcv_error *error);

/* The sensor of the option `sensor`, else the only one, with the pixels of the option `resolution`.
 */
mcv_result mcv_session_sensor(mcv_scene *scene, const mcv_command *command, uint32_t *sensor,
                              mcv_error *error);

#endif
