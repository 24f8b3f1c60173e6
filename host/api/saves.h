/* SPDX-License-Identifier: Apache-2.0 */
/* Checkpoints of a render while it runs (verbs/checkpoint.h): when they are written, and going on
 * with one. */
#ifndef MCVISI_HOST_API_SAVES_H
#define MCVISI_HOST_API_SAVES_H

#include "verbs/checkpoint.h"

/* Of the checkpoint's name, as long as its render runs: a file beside it, since the checkpoint is
 * replaced by each save. */
typedef struct mcv_saves_lock {
    char *path; /* NULL: none */
    int descriptor;
} mcv_saves_lock;

/* MCV_BAD_INPUT tells who has it. After success mcv_saves_unlock must follow. */
mcv_result mcv_saves_lock_take(mcv_saves_lock *lock, const char *path, mcv_error *error);

/* Removes the file; nothing where there is no lock. */
void mcv_saves_unlock(mcv_saves_lock *lock);

typedef struct mcv_saves {
    const char *path;
    bool by_default; /* nobody has named it: nothing is written in the first minute */
    json_t *identity;
    double begun, next;        /* the next one is due */
    bool asked;                /* somebody wants one now */
    bool exists;               /* one of this render lies under the name */
    mcv_checkpoint checkpoint; /* that the render goes on with */
    bool resumes;
    mcv_error failure; /* of the last one, else empty */
} mcv_saves;

/* Without a path: there are none. mcv_saves_end must follow. */
void mcv_saves_begin(mcv_saves *saves, const char *path, bool by_default, json_t *identity);

/* Reads the checkpoint, to go on with it; nothing where there is none. */
mcv_result mcv_saves_resume(mcv_saves *saves, mcv_error *error);

/* Whether one is to be written now. `ending`: the render ends before it is done. */
bool mcv_saves_due(const mcv_saves *saves, bool ending);

/* Writes one. */
void mcv_saves_write(mcv_saves *saves, const mcv_unfinished *unfinished);

/* Frees; `done`: the render is finished, and the file of its checkpoint is removed. */
void mcv_saves_end(mcv_saves *saves, bool done);

#endif
