/* SPDX-License-Identifier: Apache-2.0 */
/* Lens files of Zemax OpticStudio: one keyword and its values on a line, those of a surface below
 * SURF. */
#include "lens/lens.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"

/* What a surface has been given so far, and what one line of the header says of another. */
typedef struct zemax {
    mcv_lens *l;
    bool asphere, coordinate_break, has_thickness, has_diameter;
    int with_diameter;
    double wavelengths[64]; /* [µm] */
    int primary, field_type;
    double field[2];
} zemax;

enum { WAVELENGTHS = 64 };

static mcv_result fail_here(const mcv_lens *l, mcv_error *error, const char *what,
                            const char *word) {
    return mcv_lens_fail(l, l->line, l->count - 1, error, "%s%s", what, word);
}

static mcv_result begin_surface(zemax *z, mcv_error *error) {
    if (z->l->count > 0 && !z->has_thickness)
        return fail_here(z->l, error, "has no DISZ: the file is truncated", "");
    z->with_diameter += z->has_diameter;
    z->asphere = z->coordinate_break = z->has_thickness = z->has_diameter = false;
    return mcv_lens_add_surface(z->l, error);
}

static mcv_result read_type(zemax *z, const char *type, mcv_error *error) {
    z->asphere = mcv_lens_is(type, "EVENASPH");
    z->coordinate_break = mcv_lens_is(type, "COORDBRK");
    if (z->asphere || z->coordinate_break || mcv_lens_is(type, "STANDARD")) return MCV_OK;
    return fail_here(z->l, error, "only the types STANDARD and EVENASPH are supported, not ", type);
}

static mcv_result read_glass(mcv_lens *l, char **words, int n, mcv_error *error) {
    mcv_lens_glass *glass = &l->surfaces[l->count - 1].glass;
    if (mcv_lens_is(words[1], "MIRROR"))
        return fail_here(
            l, error,
            "mirrors in lens files are not supported: give them as a \"surface\" in the scene", "");
    mcv_lens_copy_name(glass->name, words[1]);
    if (n < 5) return MCV_OK;
    /* GLAS name solve pickup n_d V_d: of a model glass (solve 1) both count; else they may be what
     * an earlier model left. */
    double index, abbe = 0;
    MCV_TRY(mcv_lens_number(l, words[4], &index, error));
    if (n > 5) MCV_TRY(mcv_lens_number(l, words[5], &abbe, error));
    const bool model = strcmp(words[2], "1") == 0 || strncmp(words[1], "___BLANK", 8) == 0;
    if (!model) { /* 1.5 and 40 are what stands there when nothing is meant */
        glass->stated_index =
            index >= 1.2 && index <= 5 && (index != 1.5 || abbe != 40) ? index : 0;
        glass->stated_abbe = fmax(abbe, 0);
        return MCV_OK;
    }
    if (!(index >= 1 && index <= 10))
        return fail_here(l, error, "the index of a model glass must be 1 to 10, not ", words[4]);
    glass->index = index;
    glass->abbe = fmax(abbe, 0);
    return MCV_OK;
}

static mcv_result read_parameter(zemax *z, char **words, int n, mcv_error *error) {
    mcv_lens_surface *s = z->l->surfaces + z->l->count - 1;
    double value;
    if (n < 3 || !(z->asphere || z->coordinate_break)) return MCV_OK;
    MCV_TRY(mcv_lens_number(z->l, words[2], &value, error));
    const long term = strtol(words[1], NULL, 10);
    if (value == 0 || (z->coordinate_break && term > 5)) return MCV_OK;
    if (z->coordinate_break)
        return fail_here(
            z->l, error,
            "tilts and decentres (COORDBRK) are not supported: only centred lenses are", "");
    if (term < 2 || term > MCV_ASPHERE_TERMS + 1)
        return fail_here(z->l, error, "aspheres have terms from r^4 to r^18, not PARM ", words[1]);
    s->asphere[term - 2] = value;
    return MCV_OK;
}

static mcv_result read_surface(zemax *z, char **words, int n, mcv_error *error) {
    mcv_lens *l = z->l;
    mcv_lens_surface *s = l->surfaces + l->count - 1;
    const char *key = words[0];
    double value = 0;
    if (mcv_lens_is(key, "STOP")) l->stop = l->count - 1;
    if (n < 2) return MCV_OK;
    if (mcv_lens_is(key, "TYPE")) return read_type(z, words[1], error);
    if (mcv_lens_is(key, "CURV")) return mcv_lens_number(l, words[1], &s->curvature, error);
    if (mcv_lens_is(key, "CONI")) return mcv_lens_number(l, words[1], &s->conic, error);
    if (mcv_lens_is(key, "GLAS")) return read_glass(l, words, n, error);
    if (mcv_lens_is(key, "PARM")) return read_parameter(z, words, n, error);
    if (mcv_lens_is(key, "DISZ")) {
        z->has_thickness = true;
        return mcv_lens_distance(l, words[1], &s->thickness, error);
    }
    if (mcv_lens_is(key, "DIAM")) {
        z->has_diameter = true;
        MCV_TRY(mcv_lens_number(l, words[1], &s->semi_diameter, error));
        s->semi_diameter = fabs(s->semi_diameter);
        return MCV_OK;
    }
    if (mcv_lens_is(key, "OBSC"))
        return fail_here(
            l, error, "obscurations (OBSC) are not supported: give them as a \"disc\" in the scene",
            "");
    for (int i = 3; mcv_lens_is(key, "SCBD") && i < n; ++i) {
        MCV_TRY(mcv_lens_number(l, words[i], &value, error));
        if (value != 0)
            return fail_here(
                l, error, "tilts and decentres (SCBD) are not supported: only centred lenses are",
                "");
    }
    return MCV_OK;
}

static mcv_result set_unit(mcv_lens *l, const char *word, mcv_error *error) {
    l->unit = mcv_lens_is(word, "MM")                              ? 1e-3
              : mcv_lens_is(word, "CM")                            ? 1e-2
              : mcv_lens_is_one_of(word, " IN INCH ")              ? 0.0254
              : mcv_lens_is_one_of(word, " M METER METRE METERS ") ? 1
                                                                   : 0;
    if (l->unit > 0) return MCV_OK;
    return fail_here(l, error, "the UNIT must be MM, CM, IN or METER, not ", word);
}

static mcv_result set_aperture(mcv_lens *l, mcv_lens_aperture is, const char *word,
                               mcv_error *error) {
    l->aperture_is = is;
    return mcv_lens_number(l, word, &l->aperture, error);
}

static mcv_result read_wavelengths(zemax *z, char **words, int n, bool numbered, mcv_error *error) {
    for (int i = 1; i < (numbered ? (n < 3 ? 0 : 2) : n); ++i) {
        const long number = numbered ? strtol(words[1], NULL, 10) : i;
        if (number >= 1 && number < WAVELENGTHS)
            MCV_TRY(mcv_lens_number(z->l, words[numbered ? 2 : i], z->wavelengths + number, error));
    }
    return MCV_OK;
}

static mcv_result read_header(zemax *z, char **words, int n, mcv_error *error) {
    mcv_lens *l = z->l;
    const char *key = words[0], *first = n > 1 ? words[1] : "", *second = n > 2 ? words[2] : "0";
    double value;
    if (mcv_lens_is(key, "FLOA")) l->aperture_is = MCV_LENS_STOP_SIZE;
    if (n < 2) return MCV_OK;
    if (mcv_lens_is(key, "UNIT")) return set_unit(l, first, error);
    if (mcv_lens_is(key, "MODE") && !mcv_lens_is(first, "SEQ"))
        return fail_here(l, error, "only sequential lenses (MODE SEQ) are supported, not ", first);
    if (mcv_lens_is(key, "ENPD")) return set_aperture(l, MCV_LENS_PUPIL_DIAMETER, first, error);
    if (mcv_lens_is(key, "FNUM"))
        return set_aperture(
            l, strcmp(second, "1") == 0 ? MCV_LENS_WORKING_F_NUMBER : MCV_LENS_F_NUMBER, first,
            error);
    if (mcv_lens_is(key, "OBNA")) { /* n sin, or the half-angle in degrees */
        MCV_TRY(set_aperture(l, MCV_LENS_OBJECT_SLOPE, first, error));
        l->aperture = strcmp(second, "1") == 0 ? tan(l->aperture * M_PI / 180)
                                               : tan(asin(fmin(l->aperture, 1)));
        return MCV_OK;
    }
    if (mcv_lens_is(key, "EFFL")) return mcv_lens_number(l, first, &l->focal_length, error);
    if (mcv_lens_is(key, "WAVM")) return read_wavelengths(z, words, n, true, error);
    if (mcv_lens_is(key, "WAVL")) return read_wavelengths(z, words, n, false, error);
    if (mcv_lens_is(key, "PWAV")) z->primary = (int)strtol(first, NULL, 10);
    if (mcv_lens_is(key, "FTYP")) z->field_type = (int)strtol(first, NULL, 10);
    for (int i = 1; mcv_lens_is_one_of(key, " XFLN YFLN XFLD YFLD ") && i < n; ++i) {
        double *field = z->field + (key[0] == 'Y' || key[0] == 'y');
        MCV_TRY(mcv_lens_number(l, words[i], &value, error));
        *field = fmax(*field, fabs(value));
    }
    return MCV_OK;
}

/* What the header's lines say together. */
static void finish_header(zemax *z) {
    mcv_lens *l = z->l;
    if (z->primary >= 1 && z->primary < WAVELENGTHS && z->wavelengths[z->primary] > 0)
        l->wavelength = 1e-6 * z->wavelengths[z->primary];
    l->field_is = z->field_type == 1                         ? MCV_LENS_OBJECT_HEIGHT
                  : z->field_type == 2 || z->field_type == 3 ? MCV_LENS_IMAGE_HEIGHT
                                                             : MCV_LENS_FIELD_TANGENT;
    for (int i = 0; i < 2; ++i)
        l->field[i] = l->field_is == MCV_LENS_FIELD_TANGENT
                          ? tan(fmin(z->field[i], 89) * M_PI / 180)
                          : z->field[i];
}

/* NAME's text is all of its line. */
static void read_name(mcv_lens *l, char *line) {
    line += strspn(line, " \t");
    if (strncasecmp(line, "NAME ", 5) != 0) return;
    line += 5;
    line += strspn(line, " \t\"");
    mcv_lens_copy_name(l->name, line);
    for (size_t n = strlen(l->name); n > 0 && strchr(" \t\"", l->name[n - 1]); --n)
        l->name[n - 1] = '\0';
}

mcv_result mcv_lens_zemax_read(mcv_lens *l, char *text, mcv_error *error) {
    zemax z = {.l = l, .primary = 1};
    char *rest = text, *line, *words[MCV_LENS_WORDS];
    for (bool in_surface = false; (line = strsep(&rest, "\n")); ++l->line) {
        line[strcspn(line, "\r")] = '\0';
        read_name(l, line);
        const int n = mcv_lens_split(line, words);
        if (n == 0) continue;
        if (mcv_lens_is_one_of(words[0], " BLNK TOL MNUM MOFF "))
            in_surface = false; /* behind the last surface */
        if (mcv_lens_is(words[0], "MNUM") && n > 1 && strtol(words[1], NULL, 10) > 1)
            mcv_lens_warn(l, "%s: line %d: only the current one of its %s configurations is read",
                          l->path, l->line, words[1]);
        if (mcv_lens_is(words[0], "SURF")) {
            MCV_TRY(begin_surface(&z, error));
            in_surface = true;
        } else
            MCV_TRY(in_surface      ? read_surface(&z, words, n, error)
                    : l->count == 0 ? read_header(&z, words, n, error)
                                    : MCV_OK);
    }
    if (l->count == 0)
        return mcv_lens_fail(l, 0, -1, error,
                             "has no SURF: it is not a lens file, or it is truncated");
    const mcv_lens_surface *last = l->surfaces + l->count - 1;
    if (*last->glass.name || last->thickness != 0 ||
        (!z.has_diameter && z.with_diameter == l->count - 1 && l->count > 1))
        return mcv_lens_fail(l, last->line, l->count - 1, error,
                             "is the last one but no image surface: the file is truncated");
    finish_header(&z);
    return MCV_OK;
}
