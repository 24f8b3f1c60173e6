/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/rays.h"

#include "core/output_file.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Does the line consist of the names of the columns, ignoring blanks? */
static bool is_header(const char *line) {
    const char *name = "x,y,z,dx,dy,dz";
    for (; *line; ++line)
        if (!isspace((unsigned char)*line) && tolower((unsigned char)*line) != *name++)
            return false;
    return *name == '\0';
}

static bool is_blank(const char *line) {
    line += strspn(line, " \t\r\n");
    return *line == '\0' || *line == '#';
}

static mcv_result parse_ray(const char *line, mcv_trace_ray *ray, const char *path, size_t number,
                            mcv_error *error) {
    static const char *const names[] = {"x", "y", "z", "dx", "dy", "dz"};
    const double *d = ray->direction;
    for (int i = 0; i < 6; ++i) {
        char *end;
        const double value = strtod(line, &end);
        if (end == line)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s:%zu: %s is missing or no number: a row must be x,y,z,dx,dy,dz",
                            path, number, names[i]);
        if (!isfinite(value))
            return mcv_fail(error, MCV_BAD_INPUT, "%s:%zu: %s must be finite", path, number,
                            names[i]);
        (i < 3 ? ray->origin : ray->direction)[i % 3] = value;
        end += strspn(end, " \t\r\n");
        if (*end != (i < 5 ? ',' : '\0'))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s:%zu: %s after %s: a row must be six numbers x,y,z,dx,dy,dz", path,
                            number, *end == '\0' ? "the row ends" : "something else stands",
                            names[i]);
        line = end + 1;
    }
    const double length = hypot(hypot(d[0], d[1]), d[2]);
    if (length > 0 && isfinite(length)) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s:%zu: the direction dx,dy,dz must not be 0", path,
                    number);
}

static mcv_result read_rays(FILE *file, const char *path, mcv_trace_ray **rays, size_t *count,
                            mcv_error *error) {
    char line[1024];
    size_t capacity = 0;
    bool first_row = true;
    for (size_t number = 1; fgets(line, sizeof line, file); ++number) {
        if (strlen(line) + 1 == sizeof line && line[sizeof line - 2] != '\n')
            return mcv_fail(
                error, MCV_BAD_INPUT,
                "%s:%zu: the line is longer than %zu bytes: a row must be x,y,z,dx,dy,dz", path,
                number, sizeof line - 2);
        if (line[0] == '\0' || (!strchr(line, '\n') && !feof(file)))
            return mcv_fail(error, MCV_BAD_INPUT, "%s:%zu: has a NUL byte: is it a text file?",
                            path, number);
        if (is_blank(line)) continue;
        const bool header = first_row && is_header(line);
        first_row = false;
        if (header) continue;
        if (*count == capacity) {
            capacity = capacity ? 2 * capacity : 1024;
            mcv_trace_ray *more = realloc(*rays, capacity * sizeof *more);
            if (!more)
                return mcv_fail(error, MCV_FAILED, "%s: no memory for %zu rays", path, capacity);
            *rays = more;
        }
        MCV_TRY(parse_ray(line, *rays + *count, path, number, error));
        ++*count;
    }
    if (ferror(file))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: cannot be read completely: %s", path,
                        strerror(errno));
    if (*count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: contains no ray: give rows x,y,z,dx,dy,dz",
                        path);
    return MCV_OK;
}

mcv_result mcv_rays_read(const char *path, mcv_trace_ray **rays, size_t *count, mcv_error *error) {
    *rays = NULL;
    *count = 0;
    FILE *file;
    uint64_t size;
    mcv_error why;
    if (mcv_file_open(path, &file, &size, &why) != MCV_OK)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: give a table of rays x,y,z,dx,dy,dz", why.text);
    const mcv_result result = read_rays(file, path, rays, count, error);
    fclose(file);
    if (result != MCV_OK) {
        free(*rays);
        *rays = NULL;
    }
    return result;
}
