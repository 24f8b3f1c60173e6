/* SPDX-License-Identifier: Apache-2.0 */
#include "api/saves.h"

#include "core/basics.h"
#include "core/file_lock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Seconds between two; longer where writing one would take more than this share of the time. */
static const double INTERVAL = 60, LARGEST_SHARE = 0.005;

mcv_result mcv_saves_lock_take(mcv_saves_lock *lock, const char *path, mcv_error *error) {
    static const char ending[] = ".lock";
    const size_t size = strlen(path) + sizeof ending;
    *lock = (mcv_saves_lock){.path = malloc(size), .descriptor = -1};
    if (!lock->path) return mcv_fail(error, MCV_FAILED, "%s: no memory for its name", path);
    snprintf(lock->path, size, "%s%s", path, ending);
    const mcv_result result =
        mcv_file_lock(lock->path, path, "-o or --checkpoint", &lock->descriptor, error);
    if (result == MCV_OK) return MCV_OK;
    free(lock->path);
    lock->path = NULL;
    return result;
}

/* Removed while it is held: whoever has opened it meanwhile finds that it has no name. A file with
 * contents is not ours. */
void mcv_saves_unlock(mcv_saves_lock *lock) {
    struct stat status;
    if (!lock->path) return;
    if (stat(lock->path, &status) == 0 && status.st_size == 0) unlink(lock->path);
    close(lock->descriptor);
    free(lock->path);
    lock->path = NULL;
}

void mcv_saves_begin(mcv_saves *s, const char *path, bool by_default, json_t *identity) {
    const double now = mcv_seconds();
    *s = (mcv_saves){.path = path,
                     .by_default = by_default,
                     .identity = identity,
                     .begun = now,
                     .next = now + INTERVAL};
}

mcv_result mcv_saves_resume(mcv_saves *s, mcv_error *error) {
    if (!s->path || access(s->path, F_OK) != 0) return MCV_OK;
    MCV_TRY(mcv_checkpoint_read(s->path, s->identity, &s->checkpoint, error));
    s->resumes = s->exists = true;
    return MCV_OK;
}

bool mcv_saves_due(const mcv_saves *s, bool ending) {
    const double now = mcv_seconds();
    if (!s->path) return false;
    if (s->asked || now >= s->next) return true;
    return ending && (!s->by_default || s->exists || now - s->begun >= INTERVAL);
}

void mcv_saves_write(mcv_saves *s, const mcv_unfinished *unfinished) {
    const double begun = mcv_seconds();
    s->failure.text[0] = '\0';
    if (mcv_checkpoint_write(s->path, s->identity, unfinished, &s->failure) == MCV_OK)
        s->exists = true;
    const double now = mcv_seconds();
    s->asked = false;
    s->next = now + fmax(INTERVAL, (now - begun) / LARGEST_SHARE);
}

void mcv_saves_end(mcv_saves *s, bool done) {
    if (done && s->exists) unlink(s->path);
    if (s->resumes) mcv_checkpoint_free(&s->checkpoint);
    json_decref(s->identity);
    *s = (mcv_saves){.path = NULL};
}
