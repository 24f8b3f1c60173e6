/* SPDX-License-Identifier: Apache-2.0 */
#include "core/file_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

/* The process that holds a lock on a file, as the system lists it; 0: not known. */
static long holder_of(const struct stat *status) {
    char line[256];
    FILE *locks = fopen("/proc/locks", "re");
    long holder = 0;
    while (locks && holder == 0 && fgets(line, sizeof line, locks)) {
        long process;
        unsigned major, minor;
        unsigned long inode;
        const bool read =
            // NOLINTNEXTLINE(cert-err34-c): the kernel's own numbers fit
            sscanf(line, "%*s FLOCK %*s %*s %ld %x:%x:%lu", &process, &major, &minor, &inode) == 4;
        if (read && inode == status->st_ino && major == major(status->st_dev) &&
            minor == minor(status->st_dev))
            holder = process;
    }
    if (locks) fclose(locks);
    return holder;
}

static mcv_result tell_holder(const char *written, const char *option, const struct stat *status,
                              mcv_error *error) {
    const long holder = holder_of(status);
    char who[64] = "another process";
    if (holder == (long)getpid())
        snprintf(who, sizeof who, "another thread of this process");
    else if (holder > 0)
        snprintf(who, sizeof who, "process %ld", holder);
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: is being written by %s: wait until it ends, or give another name by %s",
                    written, who, option);
}

/* MCV_OK with -1: between opening and locking, another process has put another file in its place,
 * or has removed it. */
static mcv_result try_lock(const char *path, const char *written, const char *option,
                           int *descriptor, mcv_error *error) {
    struct stat held, named;
    *descriptor = -1;
    const int opened = open(path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (opened < 0 || fstat(opened, &held) != 0) {
        const int reason = errno;
        if (opened >= 0) close(opened);
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, strerror(reason));
    }
    if (flock(opened, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        const mcv_result result = tell_holder(written, option, &held, error);
        close(opened);
        return result;
    }
    if (stat(path, &named) == 0 && named.st_ino == held.st_ino && named.st_dev == held.st_dev)
        *descriptor = opened;
    else
        close(opened);
    return MCV_OK;
}

mcv_result mcv_file_lock(const char *path, const char *written, const char *option, int *descriptor,
                         mcv_error *error) {
    *descriptor = -1;
    for (int tries = 0; *descriptor < 0 && tries < 100; ++tries)
        MCV_TRY(try_lock(path, written, option, descriptor, error));
    return *descriptor >= 0 ? MCV_OK
                            : mcv_fail(error, MCV_FAILED, "%s: is replaced again and again", path);
}
