/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/cache.h"

#include "core/basics.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_PATH = 1024 };

/* Continues a hash by a text and a separator that no text contains. */
static uint64_t hash_text(uint64_t hash, const char *text) {
    const unsigned char separator = 0xff;
    return mcv_hash_bytes(mcv_hash_bytes(hash, text, strlen(text)), &separator, 1);
}

/* The path in the cache folder, which is private and made if missing. PoCL and NVIDIA have caches
 * of their own. */
static bool cache_path(const mcv_cl *cl, const char *source, const char *options,
                       char path[MAX_PATH]) {
    if (strstr(cl->name, "Portable Computing Language") || strstr(cl->name, "NVIDIA")) return false;
    const char *base = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME");
    char folder[MAX_PATH / 2];
    int length;
    if (base && base[0] == '/')
        length = snprintf(folder, sizeof folder, "%s/mcvisi", base);
    else if (home && home[0] == '/')
        length = snprintf(folder, sizeof folder, "%s/.cache/mcvisi", home);
    else
        return false;
    if (length >= (int)sizeof folder) return false;

    struct stat status;
    if (mkdir(folder, 0700) != 0 && errno != EEXIST) return false;
    if (lstat(folder, &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != geteuid() ||
        (status.st_mode & 022) != 0)
        return false;

    const char *const parts[] = {mcv_version(), source, options, cl->name, cl->version};
    uint64_t low = MCV_HASH_BEGIN;
    uint64_t high = 0x84222325cbf29ce4u;
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        low = hash_text(low, parts[i]);
        high = hash_text(high, parts[i]);
    }
    return snprintf(path, MAX_PATH, "%s/%016llx%016llx.bin", folder, (unsigned long long)high,
                    (unsigned long long)low) < MAX_PATH;
}

static unsigned char *read_whole(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    struct stat status;
    unsigned char *bytes = NULL;
    if (fstat(fileno(file), &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0) {
        *size = (size_t)status.st_size;
        bytes = malloc(*size);
        if (bytes && fread(bytes, 1, *size, file) != *size) {
            free(bytes);
            bytes = NULL;
        }
    }
    fclose(file);
    return bytes;
}

bool mcv_cache_load(mcv_cl *cl, const char *source, const char *options, cl_program *program) {
    char path[MAX_PATH];
    size_t size;
    if (!cache_path(cl, source, options, path)) return false;
    unsigned char *binary = read_whole(path, &size);
    if (!binary) return false;
    cl_int status;
    cl_int code;
    const unsigned char *binaries[] = {binary};
    *program =
        clCreateProgramWithBinary(cl->context, 1, &cl->device, &size, binaries, &status, &code);
    free(binary);
    if (code == CL_SUCCESS && status == CL_SUCCESS &&
        clBuildProgram(*program, 1, &cl->device, options, NULL, NULL) == CL_SUCCESS)
        return true;
    if (*program) clReleaseProgram(*program);
    *program = NULL;
    return false;
}

void mcv_cache_store(mcv_cl *cl, const char *source, const char *options, cl_program program) {
    char path[MAX_PATH];
    char temporary[MAX_PATH + 32];
    size_t size = 0;
    if (!cache_path(cl, source, options, path)) return;
    if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, NULL) !=
            CL_SUCCESS ||
        size == 0)
        return;
    unsigned char *binary = malloc(size);
    if (!binary) return;
    unsigned char *binaries[] = {binary};
    snprintf(temporary, sizeof temporary, "%s.%ld", path, (long)getpid());
    FILE *file = NULL;
    if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof binaries, (void *)binaries, NULL) ==
        CL_SUCCESS)
        file = fopen(temporary, "wbx");
    if (file) {
        const bool written = fwrite(binary, 1, size, file) == size;
        const bool closed = fclose(file) == 0;
        if (!written || !closed || rename(temporary, path) != 0) remove(temporary);
    }
    free(binary);
}
