/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Preloaded into the program: fails the call MCV_FAULT_AT of one kind of call (MCV_FAULT: memory,
 * own, write, fsync, rename), counted from 1, from main() on. At the end it writes how many there
 * were to MCV_FAULT_COUNT. Calls before main() are the dynamic linker's.
 *
 * Calls that jansson makes for the growing buffer of a string do not fail: its parser (2.14) does
 * not look whether they did, and reads beyond the buffer. mcv_json_parse is our answer.
 *
 * Nor do those of operator new: OpenEXR's reader (3.1.5) waits for ever for a task that it had no
 * memory to make.
 *
 * own: memory that the program itself or its JSON library asks for. OpenCL drivers end the process
 * where they have no memory, which is not ours to mend.
 */
#include <dlfcn.h>
#include <errno.h>
#include <link.h>
#include <stdint.h>
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

/* Addresses of the program and of the JSON library, and of the library of C++. */
typedef struct places {
    struct {
        uintptr_t begin, end;
    } parts[16];
    int count;
} places;
static places own, of_new;

static int find_places(struct dl_phdr_info *object, size_t size, void *user) {
    (void)size, (void)user;
    const bool program = object->dlpi_name[0] == '\0' || strstr(object->dlpi_name, "libjansson");
    if (!program && !strstr(object->dlpi_name, "libstdc++")) return 0;
    places *into = program ? &own : &of_new;
    for (int i = 0; i < object->dlpi_phnum && into->count < 16; ++i) {
        const ElfW(Phdr) *part = object->dlpi_phdr + i;
        if (part->p_type != PT_LOAD) continue;
        into->parts[into->count].begin = object->dlpi_addr + part->p_vaddr;
        into->parts[into->count].end = into->parts[into->count].begin + part->p_memsz;
        ++into->count;
    }
    return 0;
}

static bool is_in(const places *where, const void *caller) {
    const uintptr_t address = (uintptr_t)caller;
    for (int i = 0; i < where->count; ++i)
        if (address >= where->parts[i].begin && address < where->parts[i].end) return true;
    return false;
}

static bool fails(const char *of) {
    if (!ready || strcmp(kind, of) != 0) return false;
    return atomic_fetch_add(&calls, 1) + 1 == at;
}

static bool learning;
static const void *growth; /* the place in jansson that asks for the buffer of a longer string */

static bool fails_memory(const void *caller, size_t size) {
    enum { SECOND_BUFFER = 32 }; /* twice the first */
    if (learning && !growth && size == SECOND_BUFFER) growth = caller;
    if (!ready || (growth && caller == growth) || is_in(&of_new, caller) ||
        !(fails("memory") || (is_in(&own, caller) && fails("own"))))
        return false;
    errno = ENOMEM;
    return true;
}

void *malloc(size_t size) {
    return fails_memory(__builtin_return_address(0), size) ? NULL : __libc_malloc(size);
}

void *calloc(size_t nmemb, size_t size) {
    return fails_memory(__builtin_return_address(0), 0) ? NULL : __libc_calloc(nmemb, size);
}

void *realloc(void *ptr, size_t size) {
    return fails_memory(__builtin_return_address(0), 0) ? NULL : __libc_realloc(ptr, size);
}

#define NEXT(type, name) ((type)dlsym(RTLD_NEXT, name))

/* Whether the program itself calls: drivers write caches of theirs. */
static bool fails_file(const char *of, const void *caller) {
    return is_in(&own, caller) && fails(of);
}

ssize_t write(int fd, const void *buf, size_t n) {
    if (fd > 2 && fails_file("write", __builtin_return_address(0))) {
        errno = ENOSPC;
        return -1;
    }
    return NEXT(ssize_t(*)(int, const void *, size_t), "write")(fd, buf, n);
}

ssize_t pwrite(int fd, const void *buf, size_t n, off_t offset) {
    if (fails_file("write", __builtin_return_address(0))) {
        errno = ENOSPC;
        return -1;
    }
    return NEXT(ssize_t(*)(int, const void *, size_t, off_t), "pwrite")(fd, buf, n, offset);
}

int fsync(int fd) {
    if (fails_file("fsync", __builtin_return_address(0))) {
        errno = EIO;
        return -1;
    }
    return NEXT(int (*)(int), "fsync")(fd);
}

int rename(const char *old, const char *new) {
    if (fails_file("rename", __builtin_return_address(0))) {
        errno = EACCES;
        return -1;
    }
    return NEXT(int (*)(const char *, const char *), "rename")(old, new);
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
    dl_iterate_phdr(find_places, NULL);
    typedef void *(*parser)(const char *, size_t, void *);
    const parser json_loads = (parser)dlsym(RTLD_DEFAULT, "json_loads");
    learning = true; /* the tree is left: it is small */
    if (json_loads) json_loads("[\"a string of 28 letters, or so\"]", 0, NULL);
    learning = false;
    ready = kind != NULL;
}
