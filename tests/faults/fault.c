/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Preloaded into the program: fails the call MCV_FAULT_AT of one kind of call (MCV_FAULT: memory,
 * write, fsync, rename, open), counted from 1, from main() on. At the end it writes how many there
 * were to MCV_FAULT_COUNT. Calls before main() are the dynamic linker's.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long calls;
static long at;
static const char *kind;
static bool ready;

/* The names are glibc's, and those of its parameters are reserved. */
// NOLINTBEGIN(bugprone-reserved-*,cert-dcl*,readability-inconsistent-*)
extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);

static bool fails(const char *of) {
    if (!ready || strcmp(kind, of) != 0) return false;
    return atomic_fetch_add(&calls, 1) + 1 == at;
}

void *malloc(size_t size) {
    if (fails("memory")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
    if (fails("memory")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size) {
    if (fails("memory")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_realloc(old, size);
}

#define NEXT(type, name) ((type)dlsym(RTLD_NEXT, name))

ssize_t write(int fd, const void *bytes, size_t size) {
    if (fd > 2 && fails("write")) {
        errno = ENOSPC;
        return -1;
    }
    return NEXT(ssize_t(*)(int, const void *, size_t), "write")(fd, bytes, size);
}

ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t offset) {
    if (fails("write")) {
        errno = ENOSPC;
        return -1;
    }
    return NEXT(ssize_t(*)(int, const void *, size_t, off64_t), "pwrite64")(fd, bytes, size,
                                                                            offset);
}

ssize_t pwrite(int fd, const void *bytes, size_t size, off_t offset) {
    return pwrite64(fd, bytes, size, offset);
}

int fsync(int fd) {
    if (fails("fsync")) {
        errno = EIO;
        return -1;
    }
    return NEXT(int (*)(int), "fsync")(fd);
}

int rename(const char *from, const char *to) {
    if (fails("rename")) {
        errno = EACCES;
        return -1;
    }
    return NEXT(int (*)(const char *, const char *), "rename")(from, to);
}

// NOLINTEND(bugprone-reserved-*,cert-dcl*,readability-inconsistent-*)

static void finish(void) {
    const char *path = getenv("MCV_FAULT_COUNT");
    const long count = calls;
    ready = false;
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "%ld\n", count);
    fclose(file);
}

__attribute__((constructor)) static void begin(void) {
    const char *number = getenv("MCV_FAULT_AT");
    kind = getenv("MCV_FAULT");
    at = number ? strtol(number, NULL, 10) : 0;
    atexit(finish);
    ready = kind != NULL;
}
