/* SPDX-License-Identifier: Apache-2.0 */
/* The glasses of lens files: by the names of their makers, as codes of index and Abbe number, or as
 * the user says. */
#include "lens/lens.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "lens/glass_codes.h"
#include "scene/params.h"
#include "scene/scene.h"
#include "scene/spectra.h"

/* N-BK7 is NBK7_SCHOTT elsewhere. */
static bool same_glass(const char *a, const char *b) {
    while (*a || *b) {
        while (*a == '-') ++a;
        while (*b == '-') ++b;
        if (*b == '_' || *b == '\0') return *a == '\0';
        if (toupper((unsigned char)*a++) != toupper((unsigned char)*b++)) return false;
    }
    return true;
}

/* 517642, 517.642, 516800.641673: n_d - 1 and V_d/100 by their digits; 1.5168, or with
 * V_d 1.5168:64.17. */
static bool read_code(mcv_lens_glass *glass) {
    const char *name = glass->name;
    const size_t digits = strspn(name, "0123456789");
    char *end;
    if (digits >= 3) {
        const char *rest = name + digits + (name[digits] == '.');
        const size_t abbe_digits = strspn(rest, "0123456789");
        if (rest[abbe_digits] != '\0' && rest[abbe_digits] != '_') return false;
        const size_t index_digits = digits == 6 && rest == name + digits ? 3 : digits;
        const double digits_of_index =
            floor(strtod(name, NULL) / pow(10, (double)(digits - index_digits)));
        glass->index = 1 + digits_of_index / pow(10, (double)index_digits);
        glass->abbe = index_digits < digits ? strtod(name + 3, NULL) / 10
                      : abbe_digits > 2 ? 100 * strtod(rest, NULL) / pow(10, (double)abbe_digits)
                      : abbe_digits > 0 ? strtod(rest, NULL)
                                        : 0;
        return index_digits < digits || name[digits] == '.';
    }
    if (!isdigit((unsigned char)*name) && *name != '.') return false;
    glass->index = strtod(name, &end);
    if (*end == ':') glass->abbe = strtod(end + 1, &end);
    return *end == '\0';
}

static mcv_result check_indices(const char *const *indices, size_t count, mcv_error *error) {
    for (size_t i = 0; i < count; ++i) {
        const char *equals = strchr(indices[i], '=');
        char *end = NULL;
        const double index = equals && equals > indices[i] ? strtod(equals + 1, &end) : 0;
        if (!(index >= 1 && index <= 10) || *end)
            return mcv_fail(error, MCV_USAGE, "--index %s: must be GLASS=N, an index from 1 to 10",
                            indices[i]);
    }
    return MCV_OK;
}

/* By its name: the renderer's catalogue first, for its dispersion formulas. */
static bool find_by_name(mcv_lens_glass *glass, const char *name) {
    static const char *const others[][2] = {
        {"SILICA", "fusedSilica"},       {"F_SILICA", "fusedSilica"}, {"SIO2", "fusedSilica"},
        {"FUSED_SILICA", "fusedSilica"}, {"ACRYLIC", "PMMA"},         {"POLYCARB", "polycarbonate"},
        {"POLYSTYR", "polystyrene"},     {"SAPPHIR", "sapphire"}};
    const char *const *names = mcv_param_options("glass");
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        if (mcv_lens_is(name, others[i][0])) name = others[i][1];
    for (int i = 1; names[i] && glass->catalogue == 0; ++i)
        if (same_glass(names[i], name)) glass->catalogue = i;
    if (glass->catalogue > 0) return true;
    for (const mcv_glass_code *code = mcv_glass_codes; code->name; ++code)
        if (same_glass(code->name, name)) {
            glass->index = code->index;
            glass->abbe = code->abbe;
            return true;
        }
    return false;
}

static mcv_result find_glass(mcv_lens *l, int surface, const char *const *indices, size_t count,
                             mcv_error *error) {
    mcv_lens_glass *glass = &l->surfaces[surface].glass;
    char lead_free[MCV_LENS_NAME + 2];
    for (size_t i = 0; i < count; ++i) {
        const size_t length = strcspn(indices[i], "=");
        if (strlen(glass->name) != length || strncasecmp(indices[i], glass->name, length) != 0)
            continue;
        glass->index = strtod(indices[i] + length + 1, NULL);
        glass->abbe = 0;
        return MCV_OK;
    }
    for (int i = 0; i < l->glass_count; ++i)
        if (mcv_lens_is(glass->name, l->glasses[i].name)) {
            *glass = l->glasses[i];
            return MCV_OK;
        }
    if (glass->index > 0 || find_by_name(glass, glass->name)) return MCV_OK;
    if (read_code(glass) && glass->index >= 1 && glass->index <= 10) return MCV_OK;
    snprintf(lead_free, sizeof lead_free, "N-%s",
             glass->name); /* SK16 is no longer made, N-SK16 has its n_d */
    if (find_by_name(glass, lead_free)) {
        if (!mcv_lens_is(glass->name, "BK7") && !mcv_lens_is(glass->name, "BK7_SCHOTT"))
            mcv_lens_warn(l, "%s: line %d: the glass %s is no longer made: N-%s replaces it",
                          l->path, l->surfaces[surface].line, glass->name, glass->name);
        return MCV_OK;
    }
    if (glass->stated_index > 0) {
        glass->index = glass->stated_index;
        glass->abbe = glass->stated_abbe;
        mcv_lens_warn(
            l,
            "%s: line %d: unknown glass %s: it gets the index %.6g of the same line; --index "
            "%s=N gives another",
            l->path, l->surfaces[surface].line, glass->name, glass->index, glass->name);
        return MCV_OK;
    }
    return mcv_lens_fail(l, l->surfaces[surface].line, surface, error,
                         "unknown glass \"%s\": give its index with --index %s=1.5", glass->name,
                         glass->name);
}

mcv_result mcv_lens_find_glasses(mcv_lens *l, const char *const *indices, size_t index_count,
                                 mcv_error *error) {
    MCV_TRY(check_indices(indices, index_count, error));
    for (int i = 0; i < l->count; ++i)
        if (*l->surfaces[i].glass.name) MCV_TRY(find_glass(l, i, indices, index_count, error));
    return MCV_OK;
}

/* On the line in 1/λ² through the two nearest wavelengths, on both sides if there are such. */
static double interpolate(const double *wavelengths, const double *indices, int count,
                          double wavelength) {
    int best[2] = {
        -1,
        -1}; /* from below and from above; the nearer ones of one side where the other has none */
    for (int side = 0; side < 2; ++side)
        for (int i = 0; i < count; ++i) {
            const double off = wavelengths[i] - wavelength;
            const bool here = side ? off > 0 : off <= 0;
            if (here && (best[side] < 0 || fabs(off) < fabs(wavelengths[best[side]] - wavelength)))
                best[side] = i;
        }
    const int a = best[0] >= 0 ? best[0] : best[1];
    int b = best[0] >= 0 ? best[1] : -1;
    for (int i = 0; b < 0 && i < count; ++i)
        if (wavelengths[i] != wavelengths[a]) b = i;
    if (b < 0) return indices[a];
    const double x = pow(wavelengths[a], -2), y = pow(wavelengths[b], -2);
    return indices[a] + (indices[b] - indices[a]) * (pow(wavelength, -2) - x) / (y - x);
}

bool mcv_lens_fit_glass(mcv_lens_glass *glass, const double *wavelengths, const double *indices,
                        int count) {
    for (int i = 0; i < count; ++i)
        if (!(wavelengths[i] > 0 && indices[i] >= 1 && indices[i] <= 10)) return false;
    const double index = interpolate(wavelengths, indices, count, 587.5618);
    const double dispersion = interpolate(wavelengths, indices, count, 486.1327) -
                              interpolate(wavelengths, indices, count, 656.2725);
    *glass =
        (mcv_lens_glass){.index = index, .abbe = dispersion > 1e-6 ? (index - 1) / dispersion : 0};
    return index >= 1 && index <= 10;
}

double mcv_lens_index(const mcv_lens_surface *s, double wavelength) {
    const mcv_lens_glass *glass = &s->glass;
    if (!*glass->name) return 1;
    if (glass->catalogue > 0) return mcv_glass_index(glass->catalogue, wavelength);
    return glass->abbe > 0 ? mcv_cauchy_index(glass->index, glass->abbe, wavelength) : glass->index;
}
