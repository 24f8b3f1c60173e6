/* SPDX-License-Identifier: Apache-2.0 */
#include "core/output_file.h"

#include "core/memory_limit.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_TEMPORARIES = 1000 };
static const uint64_t LARGEST_INPUT = (uint64_t)1 << 32; /* or half of the memory */

/* Checks what exists at path: only nothing or a regular, writable file may be replaced. */
static mcv_result check_target(const char *path, mcv_error *error) {
    struct stat status;
    if (path[0] == '\0')
        return mcv_fail(error, MCV_BAD_INPUT, "the name of the output file is empty: give a path");
    if (lstat(path, &status) != 0) {
        if (errno == ENOENT) return MCV_OK;
        return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be written: %s", path, strerror(errno));
    }
    if (S_ISDIR(status.st_mode))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: is a directory; give the path of a file", path);
    if (!S_ISREG(status.st_mode)) {
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: is a link, device or pipe; give the path of a regular file", path);
    }
    if (access(path, W_OK) != 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be overwritten: %s", path,
                        strerror(errno));
    return MCV_OK;
}

/* The length of path's directory with its slash, 0 if there is none. */
static int directory_length(const char *path) {
    // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): an output that is open has a path
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash - path) + 1 : 0;
}

static void forget(mcv_output *output) {
    free(output->path);
    free(output->temporary);
    *output = (mcv_output){.descriptor = -1};
}

/* A new file, locked as long as somebody writes it; -1 with the reason in errno. A file system
 * without locks does without: nobody removes its files then. */
static int open_temporary(const char *path) {
    struct stat status;
    const int descriptor = open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor < 0) return -1;
    const bool taken = flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!taken && fstat(descriptor, &status) == 0 && status.st_nlink > 0) return descriptor;
    /* Another process has just taken it for left over. */
    close(descriptor);
    errno = EEXIST;
    return -1;
}

/* Whether a name is that of a temporary file of `base`: base.PROCESS-NUMBER.part. */
static bool is_temporary(const char *name, const char *base) {
    static const char digits[] = "0123456789";
    const size_t length = strlen(base);
    if (strncmp(name, base, length) != 0 || name[length] != '.') return false;
    const char *process = name + length + 1, *dash = process + strspn(process, digits);
    if (dash == process || *dash != '-') return false;
    const char *end = dash + 1 + strspn(dash + 1, digits);
    return end > dash + 1 && strcmp(end, ".part") == 0;
}

/* Removes what killed processes have left of this file: temporary files that nobody has locked. */
static void remove_left(const char *path) {
    const int length = directory_length(path);
    char *folder = length ? strndup(path, (size_t)length) : strdup(".");
    DIR *directory = folder ? opendir(folder) : NULL;
    for (const struct dirent *entry; directory && (entry = readdir(directory));) {
        struct stat status;
        if (!is_temporary(entry->d_name, path + length)) continue;
        const int at = dirfd(directory),
                  descriptor =
                      openat(at, entry->d_name, O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (descriptor < 0) continue;
        if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) &&
            flock(descriptor, LOCK_EX | LOCK_NB) == 0)
            unlinkat(at, entry->d_name, 0);
        close(descriptor);
    }
    if (directory) closedir(directory);
    free(folder);
}

mcv_result mcv_output_open(mcv_output *output, const char *path, mcv_error *error) {
    *output = (mcv_output){.descriptor = -1};
    MCV_TRY(check_target(path, error));
    const size_t capacity = strlen(path) + 48;
    output->path = strdup(path);
    output->temporary = malloc(capacity);
    if (!output->path || !output->temporary) {
        forget(output);
        return mcv_fail(error, MCV_FAILED, "%s: no memory to write the file", path);
    }
    errno = EEXIST;
    for (int i = 0; output->descriptor < 0 && errno == EEXIST && i < MAX_TEMPORARIES; ++i) {
        snprintf(output->temporary, capacity, "%s.%ld-%d.part", path, (long)getpid(), i);
        output->descriptor = open_temporary(output->temporary);
    }
    if (output->descriptor >= 0) return MCV_OK;
    const int reason = errno;
    forget(output);
    const int length = directory_length(path);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be written in the directory %.*s: %s", path,
                    length ? length : 1, length ? path : ".", strerror(reason));
}

bool mcv_same_file(const char *a, const char *b) {
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

mcv_result mcv_output_check(const char *path, mcv_error *error) {
    mcv_output output;
    MCV_TRY(mcv_output_open(&output, path, error));
    mcv_output_discard(&output);
    remove_left(path);
    return MCV_OK;
}

mcv_result mcv_output_write_at(mcv_output *output, const void *bytes, size_t count, uint64_t offset,
                               mcv_error *error) {
    const char *next = bytes;
    while (count > 0) {
        const ssize_t written = pwrite(output->descriptor, next, count, (off_t)offset);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) {
            return mcv_fail(error, MCV_FAILED, "%s: writing failed: %s", output->path,
                            strerror(written < 0 ? errno : ENOSPC));
        }
        next += written;
        count -= (size_t)written;
        offset += (uint64_t)written;
    }
    if (offset > output->size) output->size = offset;
    return MCV_OK;
}

mcv_result mcv_output_write(mcv_output *output, const void *bytes, size_t count, mcv_error *error) {
    return mcv_output_write_at(output, bytes, count, output->size, error);
}

/* Makes the new name survive a power cut. Not every file system can do this; the file itself is
 * whole in any case. */
static void flush_directory(const char *path) {
    const int length = directory_length(path);
    char *directory = length ? strndup(path, (size_t)length) : strdup(".");
    const int descriptor = directory ? open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (descriptor >= 0) {
        fsync(descriptor);
        close(descriptor);
    }
    free(directory);
}

mcv_result mcv_output_commit(mcv_output *output, mcv_error *error) {
    bool written = fsync(output->descriptor) == 0;
    int reason = errno;
    /* The lock stays until the file has its name. */
    const int lock = fcntl(output->descriptor, F_DUPFD_CLOEXEC, 0);
    if (close(output->descriptor) != 0 && written) {
        written = false;
        reason = errno;
    }
    output->descriptor = -1;
    if (written && rename(output->temporary, output->path) != 0) {
        written = false;
        reason = errno;
    }
    if (lock >= 0) close(lock);
    if (!written) {
        mcv_fail(error, MCV_FAILED, "%s: writing failed: %s", output->path, strerror(reason));
        mcv_output_discard(output);
        return MCV_FAILED;
    }
    flush_directory(output->path);
    forget(output);
    return MCV_OK;
}

void mcv_output_discard(mcv_output *output) {
    if (output->descriptor >= 0) close(output->descriptor);
    if (output->temporary) unlink(output->temporary);
    forget(output);
}

/* O_NONBLOCK: otherwise a pipe without a writer would block here. Regular files ignore it. */
static mcv_result open_regular(const char *path, int *descriptor, uint64_t *size,
                               mcv_error *error) {
    struct stat status;
    *descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (*descriptor < 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
    const bool known = fstat(*descriptor, &status) == 0;
    if (known && S_ISREG(status.st_mode)) {
        *size = (uint64_t)status.st_size;
        return MCV_OK;
    }
    close(*descriptor);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: is %s", path,
                    known && S_ISDIR(status.st_mode) ? "a directory, but must be a regular file"
                                                     : "not a regular file");
}

mcv_result mcv_file_open(const char *path, FILE **file, uint64_t *size, mcv_error *error) {
    int descriptor;
    *file = NULL;
    MCV_TRY(open_regular(path, &descriptor, size, error));
    *file = fdopen(descriptor, "rb");
    if (*file) return MCV_OK;
    close(descriptor);
    return mcv_fail(error, MCV_FAILED, "%s: no memory to read it", path);
}

mcv_result mcv_file_load(const char *path, uint8_t **bytes, size_t *size, mcv_error *error) {
    int descriptor;
    uint64_t whole = 0;
    mcv_result result = MCV_OK;
    *bytes = NULL;
    MCV_TRY(open_regular(path, &descriptor, &whole, error));
    const uint64_t half = mcv_memory_default(), most = half < LARGEST_INPUT ? half : LARGEST_INPUT;
    if (whole > most) {
        result = mcv_fail(error, MCV_BAD_INPUT,
                          "%s: is larger than %.4g MB, the limit for a file: 4 GiB, or half of the "
                          "memory of the machine or process",
                          path, 1e-6 * (double)most);
    } else if (!(*bytes = malloc((size_t)whole + 1))) {
        result = mcv_fail(error, MCV_FAILED, "%s: no memory for its %llu bytes", path,
                          (unsigned long long)whole);
    }
    *size = 0;
    while (result == MCV_OK && *size < (size_t)whole) {
        const ssize_t count = read(descriptor, *bytes + *size, (size_t)whole - *size);
        if (count < 0 && errno != EINTR)
            result =
                mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be read: %s", path, strerror(errno));
        if (count == 0) break;
        if (count > 0) *size += (size_t)count;
    }
    close(descriptor);
    if (result != MCV_OK) {
        free(*bytes);
        *bytes = NULL;
    }
    return result;
}

mcv_result mcv_output_whole(const char *path, const void *bytes, size_t count, mcv_error *error) {
    mcv_output output;
    MCV_TRY(mcv_output_open(&output, path, error));
    const mcv_result result = mcv_output_write(&output, bytes, count, error);
    if (result == MCV_OK) return mcv_output_commit(&output, error);
    mcv_output_discard(&output);
    return result;
}
