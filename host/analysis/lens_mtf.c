/* SPDX-License-Identifier: Apache-2.0 */
/* The MTF of a lens: that of diffraction, or a table from a file. */
#include "analysis/blur.h"
#include "core/output_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

double mcv_lens_modulation(const mcv_lens_mtf *mtf, double frequency) {
    if (mtf->row_count == 0) {
        const double s = frequency * mtf->wavelength * mtf->f_number;
        return s < 1 ? 2 / M_PI * (acos(s) - s * sqrt(1 - s * s)) : 0;
    }
    size_t i = 1,
           end = mtf->row_count; /* the first row from 1 on that is not below lies in i … end */
    while (i < end) {
        const size_t middle = (i + end) / 2;
        if (mtf->rows[middle].frequency < frequency)
            i = middle + 1;
        else
            end = middle;
    }
    if (i == mtf->row_count) return mtf->rows[i - 1].modulation;
    const mcv_mtf_row a = mtf->rows[i - 1], b = mtf->rows[i];
    return a.modulation +
           (b.modulation - a.modulation) * (frequency - a.frequency) / (b.frequency - a.frequency);
}

static mcv_result check_row(const char *path, unsigned line, const mcv_mtf_row *rows, size_t count,
                            mcv_error *error) {
    const mcv_mtf_row *row = rows + count;
    if (!(row->modulation >= 0 && row->modulation <= 1))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: line %u: a modulation of %g: must be from 0 to 1", path, line,
                        row->modulation);
    if (count == 0 && !(row->frequency == 0 && row->modulation == 1))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: line %u: the first row must be 0, 1: full modulation at frequency 0",
                        path, line);
    if (count > 0 && !(row->frequency > row[-1].frequency && isfinite(row->frequency)))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: line %u: frequencies must ascend, but %g follows %g", path, line,
                        row->frequency * 1e-3, row[-1].frequency * 1e-3);
    return MCV_OK;
}

mcv_result mcv_mtf_read(const char *path, mcv_mtf_row **rows, size_t *count, mcv_error *error) {
    enum { MAX_ROWS = 10000 };
    char text[256];
    mcv_result result = MCV_OK;
    FILE *file;
    uint64_t size;
    *count = 0;
    *rows = NULL;
    MCV_TRY(mcv_file_open(path, &file, &size, error));
    *rows = malloc(MAX_ROWS * sizeof **rows);
    if (!*rows) {
        fclose(file);
        return mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    }
    for (unsigned line = 1; result == MCV_OK && *count < MAX_ROWS && fgets(text, sizeof text, file);
         ++line) {
        mcv_mtf_row *row = *rows + *count;
        if (text[strspn(text, " \t\r\n")] == '\0' || text[0] == '#') continue;
        char *end, *start = text;
        row->frequency = 1e3 * strtod(start, &end);
        start = end + strspn(end, " \t,;");
        const bool first = end != text;
        row->modulation = strtod(start, &end);
        if (!first || end == start || end[strspn(end, " \t\r\n")] != '\0')
            result = mcv_fail(error, MCV_BAD_INPUT,
                              "%s: line %u must be `cycles per mm, modulation`, as in 40, 0.62",
                              path, line);
        else
            result = check_row(path, line, *rows, *count, error);
        ++*count;
    }
    if (result == MCV_OK && *count == MAX_ROWS)
        result =
            mcv_fail(error, MCV_BAD_INPUT, "%s: has %d rows or more: remove some", path, MAX_ROWS);
    if (result == MCV_OK && *count < 2)
        result = mcv_fail(error, MCV_BAD_INPUT, "%s: %zu rows make no MTF: at least 2 are needed",
                          path, *count);
    fclose(file);
    if (result == MCV_OK) return MCV_OK;
    free(*rows);
    *rows = NULL;
    return result;
}
