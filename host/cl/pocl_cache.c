/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/pocl_cache.h"

#include "core/basics.h"
#include "core/kernel_folder.h"

#include <dirent.h>
#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* Folders are looked at to this depth; the first ones are named by hashes. A compiled kernel has no
 * more bytes than LARGEST_FILE: those of the shipped scenes have up to 0.86 MB. */
enum { MAX_DEPTH = 8, HASHED = 2, LARGEST_FILE = 1 << 20, PIECE = 1 << 14 };

mcv_result mcv_pocl_check(mcv_error *error) {
    const char *folder = getenv("POCL_CACHE_DIR");
    if (!folder || folder[0]) return MCV_OK;
    return mcv_fail(error, MCV_DEVICE,
                    "POCL_CACHE_DIR is set and empty, on which the OpenCL driver PoCL ends the "
                    "process: unset it, or let it name a folder for compiled kernels");
}

static bool read_at(int fd, uint64_t offset, void *bytes, size_t size) {
    return pread(fd, bytes, size, (off_t)offset) == (ssize_t)size;
}

/* A shared library ends with, or behind, its table of sections. */
static bool is_whole_library(int fd, uint64_t size) {
    Elf64_Ehdr head;
    if (!read_at(fd, 0, &head, sizeof head) || memcmp(head.e_ident, ELFMAG, SELFMAG) != 0)
        return false;
    if (head.e_ident[EI_CLASS] != ELFCLASS64) return true; /* of another kind of machine */
    const uint64_t table = (uint64_t)head.e_shentsize * head.e_shnum;
    return head.e_shoff > 0 && head.e_shoff <= size && table <= size - head.e_shoff;
}

/* LLVM's bitcode is a row of blocks, each with its length. Source: LLVM Bitcode File Format,
 * "Primitives" and "Blocks". */
static bool is_whole_bitcode(int fd, uint64_t size) {
    enum { ENTER_SUBBLOCK = 1 }; /* the two lowest bits of a block's first word */
    uint32_t head[2];
    if (!read_at(fd, 0, head, sizeof head) || head[0] != 0xdec04342u) return false;
    uint64_t at = sizeof head[0];
    while (at < size) {
        if (!read_at(fd, at, head, sizeof head) || (head[0] & 3) != ENTER_SUBBLOCK) return false;
        at += sizeof head + 4 * (uint64_t)head[1];
    }
    return at == size && size > sizeof head;
}

static bool is_whole(const char *path) {
    struct stat status;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (fd < 0) return true; /* not ours to judge */
    bool whole = true;
    if (fstat(fd, &status) == 0 && S_ISREG(status.st_mode))
        whole = mcv_ends_in(path, ".so") ? is_whole_library(fd, (uint64_t)status.st_size)
                                         : is_whole_bitcode(fd, (uint64_t)status.st_size);
    close(fd);
    return whole;
}

/* PoCL writes a file under such a name and renames it when it is whole. Another process may be at
 * work on it: without its file, PoCL ends that process. */
static bool is_being_written(const char *name) { return strncmp(name, "tempfile", 8) == 0; }

/* A program's folder is named by its hash, in letters from A to P: two of them, and in that folder
 * the others. Other folders are not PoCL's: POCL_CACHE_DIR may name one that holds more. */
static bool may_be_hash(const char *name, int depth) {
    const size_t length = strspn(name, "ABCDEFGHIJKLMNOP");
    return name[length] == '\0' && (depth == 0 ? length == 2 : length >= 32);
}

/* Only what PoCL writes is looked at: libraries, and bitcode of programs. */
static void mend_folder(const char *folder, int depth) {
    DIR *directory = opendir(folder);
    if (!directory) return;
    for (const struct dirent *entry; (entry = readdir(directory));) {
        char path[MCV_KERNEL_FOLDER];
        if (entry->d_name[0] == '.' || is_being_written(entry->d_name) ||
            snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) >= (int)sizeof path)
            continue;
        if (entry->d_type == DT_DIR && depth < MAX_DEPTH &&
            (depth >= HASHED || may_be_hash(entry->d_name, depth)))
            mend_folder(path, depth + 1);
        else if (depth >= HASHED && entry->d_type == DT_REG &&
                 (mcv_ends_in(path, ".so") || strcmp(entry->d_name, "program.bc") == 0) &&
                 !is_whole(path))
            unlink(path);
    }
    closedir(directory);
}

void mcv_pocl_mend(void) {
    char path[MCV_KERNEL_FOLDER];
    if (mcv_kernel_folder(path)) mend_folder(path, 0);
}

/* --- why PoCL cannot work --- */

/* Makes the folder and those above it. */
static bool make_folder(char *path) {
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        const bool made = mkdir(path, 0700) == 0 || errno == EEXIST;
        *slash = '/';
        if (!made) return false;
    }
    return mkdir(path, 0700) == 0 || errno == EEXIST;
}

/* Writes a file as large as a compiled kernel, and removes it; errno tells why not. */
static bool takes_files(char *folder) {
    static const char zeros[PIECE];
    char path[MCV_KERNEL_FOLDER + 16];
    if (!make_folder(folder)) return false;
    snprintf(path, sizeof path, "%s/.mcvisi-XXXXXX", folder);
    const int fd = mkstemp(path);
    if (fd < 0) return false;
    unlink(path);
    bool written = true;
    errno = ENOSPC;
    for (size_t at = 0; at < LARGEST_FILE && written; at += PIECE)
        written = write(fd, zeros, PIECE) == PIECE;
    const int why = errno;
    close(fd);
    errno = why;
    return written;
}

mcv_result mcv_pocl_writes(const char *what, mcv_error *error) {
    struct rlimit limit;
    char folder[MCV_KERNEL_FOLDER];
    if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < LARGEST_FILE)
        return mcv_fail(error, MCV_DEVICE,
                        "%s: files may have at most %llu bytes (ulimit -f), but the OpenCL driver "
                        "PoCL writes kernels into files of up to a megabyte: raise the limit",
                        what, (unsigned long long)limit.rlim_cur);
    if (!mcv_kernel_folder(folder) || takes_files(folder)) return MCV_OK;
    return mcv_fail(error, MCV_DEVICE,
                    "%s: the OpenCL driver PoCL cannot write compiled kernels into the folder "
                    "\"%s\": %s; let POCL_CACHE_DIR name a folder that can be written",
                    what, folder, strerror(errno));
}
