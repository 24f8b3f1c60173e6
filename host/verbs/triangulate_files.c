/* SPDX-License-Identifier: Apache-2.0 */
/* Profiles as files. */
#include "verbs/triangulate.h"

#include "core/basics.h"
#include "core/output_file.h"
#include "io/exr_make.h"
#include "io/npz.h"

#include <math.h>
#include <stdlib.h>

static size_t count_of(const mcv_profiles *p) { return (size_t)p->added * p->length; }

/* Writes what a function prints. */
static mcv_result write_text(const mcv_profiles *p, const char *path,
                             void (*print)(const mcv_profiles *, FILE *), mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out) print(p, out);
    if (!mcv_text_close(out, &text) || !text)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for its text", path);
    const mcv_result result = mcv_output_whole(path, text, size, error);
    free(text);
    return result;
}

/* A number, or nothing where there is none. */
static void print_cell(FILE *out, double value) {
    if (isfinite(value))
        fprintf(out, ",%.9g", value);
    else
        fputc(',', out);
}

static void print_table(const mcv_profiles *p, FILE *out) {
    fprintf(out, "profile,%s,state,place_px,u_place_px,peak,sum,sigma_px",
            p->command->line_across ? "row" : "column");
    fprintf(out, "%s\n", p->command->laser ? ",x_m,y_m,z_m,u_z_m" : "");
    for (size_t i = 0; i < count_of(p); ++i) {
        const mcv_profile_point *point = p->points + i;
        const mcv_line_place *line = &point->line;
        const double cells[] = {line->place,  point->uncertainty, line->peak,
                                line->sum,    line->sigma,        point->at[0],
                                point->at[1], point->at[2],       point->u_z};
        fprintf(out, "%zu,%zu,%s", i / p->length, i % p->length, mcv_line_states[line->state]);
        for (int k = 0; k < (p->command->laser ? 9 : 5); ++k) print_cell(out, cells[k]);
        fputc('\n', out);
    }
}

static void print_points(const mcv_profiles *p, FILE *out) {
    size_t count = 0;
    for (size_t i = 0; i < count_of(p); ++i) count += !isnan(p->points[i].at[2]);
    fprintf(out,
            "ply\nformat ascii 1.0\ncomment metres\nelement vertex %zu\nproperty double x\n"
            "property double y\nproperty double z\nproperty double intensity\nend_header\n",
            count);
    for (size_t i = 0; i < count_of(p); ++i) {
        const double *at = p->points[i].at;
        if (!isnan(at[2]))
            fprintf(out, "%.9g %.9g %.9g %.6g\n", at[0], at[1], at[2], p->points[i].line.peak);
    }
}

/* Members of a point that make maps. */
static double member(const mcv_profile_point *point, int which) {
    switch (which) {
    case 0:
        return point->at[2];
    case 1:
        return point->u_z;
    case 2:
        return point->at[0];
    case 3:
        return point->at[1];
    case 4:
        return point->line.place;
    default:
        return !isnan(point->at[2]);
    }
}

/* The part "error" is what other verbs take as the uncertainty of the first one. */
static mcv_result make_range(const mcv_profiles *p, mcv_exr *exr, mcv_error *error) {
    static const char *const names[] = {"image", "error", "x", "y", "place", "mask"};
    static const mcv_attribute own[] = {{.name = "mcvisi:quantity", .text = "height"},
                                        {.name = "mcvisi:unit", .text = "m"}};
    *exr = (mcv_exr){0};
    mcv_result result = MCV_OK;
    for (int k = 0; result == MCV_OK && k < 6; ++k) {
        mcv_image image;
        result = mcv_image_new(&image, p->length, p->added, 1, error);
        if (result != MCV_OK) break;
        for (size_t i = 0; i < count_of(p); ++i) image.pixels[i] = (float)member(p->points + i, k);
        result = mcv_exr_add_part(exr, names[k], image, NULL, error);
    }
    if (result == MCV_OK) result = mcv_exr_set_attributes(exr, own, 2, error);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}

static mcv_result write_range(const mcv_profiles *p, const char *path, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(make_range(p, &exr, error));
    const mcv_result result =
        mcv_exr_write(path, exr.parts, exr.part_count, exr.attributes, exr.attribute_count, error);
    mcv_exr_free(&exr);
    return result;
}

mcv_result mcv_profiles_picture(const mcv_profiles *p, mcv_picture **picture, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(make_range(p, &exr, error));
    return mcv_picture_of(&exr, "the profiles", picture, error);
}

static mcv_result write_arrays(const mcv_profiles *p, const char *path, mcv_error *error) {
    static const char *const names[] = {"z.npy", "u_z.npy", "x.npy", "y.npy", "place.npy"};
    enum { ARRAYS = 5 };
    mcv_npz_member members[ARRAYS];
    double *values = malloc((ARRAYS * count_of(p) + 1) * sizeof *values);
    if (!values) return mcv_fail(error, MCV_FAILED, "%s: no memory for its arrays", path);
    for (int k = 0; k < ARRAYS; ++k) {
        double *array = values + (size_t)k * count_of(p);
        for (size_t i = 0; i < count_of(p); ++i) array[i] = member(p->points + i, k);
        members[k] = (mcv_npz_member){.name = names[k],
                                      .dtype = "<f8",
                                      .shape = {p->added, p->length},
                                      .data = array,
                                      .bytes = count_of(p) * sizeof *array};
    }
    const mcv_result result = mcv_npz_write(path, members, ARRAYS, error);
    free(values);
    return result;
}

/* x, y, z, u(z) and place of each point. */
static mcv_result write_array(const mcv_profiles *p, const char *path, mcv_error *error) {
    static const int order[] = {2, 3, 0, 1, 4};
    enum { EACH = 5 };
    double *values = malloc((EACH * count_of(p) + 1) * sizeof *values);
    if (!values) return mcv_fail(error, MCV_FAILED, "%s: no memory for its array", path);
    for (size_t i = 0; i < EACH * count_of(p); ++i)
        values[i] = member(p->points + i / EACH, order[i % EACH]);
    const mcv_npz_member array = {.dtype = "<f8",
                                  .shape = {p->added, p->length, EACH},
                                  .data = values,
                                  .bytes = EACH * count_of(p) * sizeof *values};
    const mcv_result result = mcv_npy_write(path, &array, error);
    free(values);
    return result;
}

mcv_result mcv_profiles_write(const mcv_profiles *p, mcv_error *error) {
    const mcv_list *files = &p->command->profiles;
    for (size_t i = 0; i < files->count; ++i) {
        const char *path = files->items[i];
        if (mcv_ends_in(path, ".csv"))
            MCV_TRY(write_text(p, path, print_table, error));
        else if (mcv_ends_in(path, ".ply"))
            MCV_TRY(write_text(p, path, print_points, error));
        else if (mcv_ends_in(path, ".npz"))
            MCV_TRY(write_arrays(p, path, error));
        else if (mcv_ends_in(path, ".npy"))
            MCV_TRY(write_array(p, path, error));
        else
            MCV_TRY(write_range(p, path, error));
    }
    return MCV_OK;
}
