/* SPDX-License-Identifier: Apache-2.0 */
#include "core/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static mcv_result open_regular(const char *path, int *fd, uint64_t *size,
                               const mcv_json_path *place, mcv_error *error) {
    struct stat status;
    const char *wrong = NULL;
    *size = 0;
    /* O_NONBLOCK: otherwise a pipe without a writer would block here. Regular files ignore it. */
    *fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (*fd < 0)
        return mcv_fail_at(place, error, "\"%s\" cannot be opened: %s", path, strerror(errno));
    if (fstat(*fd, &status) != 0)
        wrong = "cannot be read";
    else if (S_ISDIR(status.st_mode))
        wrong = "is a directory, but must be a file";
    else if (!S_ISREG(status.st_mode))
        wrong = "is a device or pipe, but must be a regular file";
    else
        *size = (uint64_t)status.st_size;
    if (!wrong) return MCV_OK;
    close(*fd);
    return mcv_fail_at(place, error, "\"%s\" %s", path, wrong);
}

static mcv_result read_part(int fd, const char *path, uint64_t first, uint64_t size, uint8_t *bytes,
                            const mcv_json_path *place, mcv_error *error) {
    for (uint64_t done = 0; done < size;) {
        const ssize_t n = pread(fd, bytes + done, size - done, (off_t)(first + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0)
            return mcv_fail_at(place, error, "\"%s\" cannot be read: %s", path,
                               n ? strerror(errno) : "it has become shorter");
        done += (uint64_t)n;
    }
    return MCV_OK;
}

mcv_result mcv_file_read(const char *path, mcv_bytes *bytes, const mcv_json_path *place,
                         mcv_error *error) {
    uint64_t size;
    int fd;
    *bytes = (mcv_bytes){NULL, 0};
    MCV_TRY(open_regular(path, &fd, &size, place, error));
    mcv_result result = MCV_OK;
    bytes->data = malloc(size ? size : 1);
    bytes->size = size;
    if (bytes->data)
        result = read_part(fd, path, 0, size, bytes->data, place, error);
    else
        result = mcv_fail_memory(place, error);
    close(fd);
    if (result == MCV_OK) return MCV_OK;
    free(bytes->data);
    *bytes = (mcv_bytes){NULL, 0};
    return result;
}

mcv_result mcv_file_size(const char *path, uint64_t *size, const mcv_json_path *place,
                         mcv_error *error) {
    int fd;
    MCV_TRY(open_regular(path, &fd, size, place, error));
    close(fd);
    return MCV_OK;
}

mcv_result mcv_file_read_part(const char *path, uint64_t first, uint64_t size, uint8_t *bytes,
                              const mcv_json_path *place, mcv_error *error) {
    uint64_t whole;
    int fd;
    MCV_TRY(open_regular(path, &fd, &whole, place, error));
    const mcv_result result = read_part(fd, path, first, size, bytes, place, error);
    close(fd);
    return result;
}

static int hex_digit(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* Decodes in place; false for a broken escape, NUL included. */
static bool decode_percent(char *text) {
    char *out = text;
    for (const char *c = text; *c; ++c) {
        if (*c != '%') {
            *out++ = *c;
            continue;
        }
        const int high = hex_digit(c[1]);
        const int low = high < 0 ? -1 : hex_digit(c[2]);
        if (low < 0 || high + low == 0) return false;
        *out++ = (char)(16 * high + low);
        c += 2;
    }
    *out = '\0';
    return true;
}

static bool has_parent_step(const char *path) {
    for (const char *c = path; *c; c += strcspn(c, "/"), c += *c == '/')
        if (c[0] == '.' && c[1] == '.' && (c[2] == '/' || c[2] == '\0')) return true;
    return false;
}

/* Links are followed: the real path must lie below the real directory. */
static bool lies_below(const char *path, const char *directory) {
    char *real_path = realpath(path, NULL), *real_directory = realpath(directory, NULL);
    const size_t length = real_directory ? strlen(real_directory) : 0;
    const bool below = real_path && real_directory &&
                       strncmp(real_path, real_directory, length) == 0 &&
                       (real_path[length] == '/' || (length && real_directory[length - 1] == '/'));
    free(real_path);
    free(real_directory);
    return below;
}

mcv_result mcv_file_resolve(const char *base, const char *uri, char **path,
                            const mcv_json_path *place, mcv_error *error) {
    const char *slash = strrchr(base, '/');
    const size_t prefix = slash ? (size_t)(slash - base) + 1 : 0;
    *path = NULL;
    /* A scheme is what stands before a colon in the first segment. */
    if (uri[strcspn(uri, ":/")] == ':')
        return mcv_fail_at(
            place, error,
            "\"%.64s\" has a scheme: only data: URIs and files beside the scene are read", uri);
    char *joined = malloc(prefix + strlen(uri) + 1);
    if (!joined) return mcv_fail_memory(place, error);
    char *relative = joined + prefix;
    memcpy(joined, base, prefix);
    strcpy(relative, uri);
    const char *wrong = NULL;
    if (!decode_percent(relative))
        wrong = "has a broken % escape";
    else if (!*relative)
        wrong = "is empty";
    else if (*relative == '/' || strchr(relative, '\\'))
        wrong = "is absolute or has a backslash: give it relative to the scene, with /";
    else if (has_parent_step(relative))
        wrong = "leads out of the scene's directory by ..";
    if (!wrong && access(joined, F_OK) == 0) {
        char *directory = prefix ? strndup(base, prefix) : strdup(".");
        if (!directory || !lies_below(joined, directory))
            wrong = "is a link that leads out of the scene's directory";
        free(directory);
    }
    if (!wrong) {
        *path = joined;
        return MCV_OK;
    }
    free(joined);
    return mcv_fail_at(place, error, "\"%.64s\" %s", uri, wrong);
}

bool mcv_file_is_same(const char *base, const char *uri, const char *other) {
    const mcv_json_path place = mcv_place_file(base);
    struct stat status[2];
    mcv_error ignored;
    char *path = NULL;
    for (int i = 0; i < 2; ++i) {
        if (mcv_file_resolve(base, i ? other : uri, &path, &place, &ignored) != MCV_OK)
            return false;
        const bool exists = path && stat(path, status + i) == 0;
        free(path);
        if (!exists) return false;
    }
    return status[0].st_dev == status[1].st_dev && status[0].st_ino == status[1].st_ino;
}

static uint32_t little_endian(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

enum {
    GLB_MAGIC = 0x46546c67,
    GLB_JSON = 0x4e4f534a,
    GLB_BINARY = 0x004e4942,
    GLB_HEADER = 12,
    GLB_CHUNK_HEADER = 8
};

mcv_result mcv_glb_split(mcv_bytes file, mcv_bytes *json, mcv_bytes *binary,
                         const mcv_json_path *place, mcv_error *error) {
    *json = file;
    *binary = (mcv_bytes){NULL, 0};
    if (file.size < 4 || little_endian(file.data) != GLB_MAGIC) return MCV_OK;
    if (file.size < GLB_HEADER)
        return mcv_fail_at(place, error, "the GLB header is truncated: %zu of 12 bytes", file.size);
    const uint32_t version = little_endian(file.data + 4), length = little_endian(file.data + 8);
    if (version != 2) return mcv_fail_at(place, error, "GLB version %u must be 2", version);
    if (length != file.size)
        return mcv_fail_at(place, error, "the GLB header says %u bytes, but the file has %zu",
                           length, file.size);
    size_t offset = GLB_HEADER;
    for (size_t chunk = 0; offset < file.size; ++chunk) {
        if (file.size - offset < GLB_CHUNK_HEADER)
            return mcv_fail_at(place, error, "the header of GLB chunk %zu is truncated", chunk);
        const uint32_t size = little_endian(file.data + offset),
                       type = little_endian(file.data + offset + 4);
        offset += GLB_CHUNK_HEADER;
        if (size > file.size - offset)
            return mcv_fail_at(place, error,
                               "GLB chunk %zu says %u bytes, but the file has %zu left", chunk,
                               size, file.size - offset);
        if (size % 4 != 0)
            return mcv_fail_at(place, error,
                               "GLB chunk %zu has %u bytes, but must have a multiple of 4", chunk,
                               size);
        if ((chunk == 0) != (type == GLB_JSON))
            return mcv_fail_at(place, error,
                               "the first GLB chunk must be JSON, and no other may be");
        if (type == GLB_BINARY && chunk != 1)
            return mcv_fail_at(place, error, "a binary GLB chunk must be the second chunk");
        if (chunk == 0) *json = (mcv_bytes){file.data + offset, size};
        if (type == GLB_BINARY) *binary = (mcv_bytes){file.data + offset, size};
        offset += size;
    }
    if (json->data == file.data) return mcv_fail_at(place, error, "the GLB has no chunk");
    if (!binary->data) *binary = (mcv_bytes){file.data + file.size, 0};
    return MCV_OK;
}
