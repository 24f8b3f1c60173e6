/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sequences of CODE V: statements of words, of which the first three letters count. One stands on a
 * line, or several with ; between them. Those of a surface follow it or name it (THI S3 5).
 */
#include "lens/lens_codev.h"

#include "core/basics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_codev_fail(const mcv_codev *c, int surface, mcv_error *error, const char *what,
                          const char *word) {
    return mcv_lens_fail(c->l, c->l->line, surface, error, "%s%s", what, word);
}

static mcv_result set_unit(mcv_codev *c, const char *word, mcv_error *error) {
    const char letter = (char)toupper((unsigned char)*word);
    c->l->unit = letter == 'M' ? 1e-3 : letter == 'C' ? 1e-2 : letter == 'I' ? 0.0254 : 0;
    return c->l->unit > 0
               ? MCV_OK
               : mcv_codev_fail(c, -1, error, "DIM must be M (mm), C (cm) or I (inch), not ", word);
}

static mcv_result read_aperture_value(mcv_codev *c, const char *key, const mcv_codev_statement *s,
                                      mcv_error *error) {
    mcv_lens *l = c->l;
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    MCV_TRY(mcv_lens_number(l, s->words[0], &value, error));
    const double slope = tan(asin(fmin(fabs(value), 1)));
    l->aperture_is = mcv_codev_means(key, "EPD")   ? MCV_LENS_PUPIL_DIAMETER
                     : mcv_codev_means(key, "NAO") ? MCV_LENS_OBJECT_SLOPE
                                                   : MCV_LENS_WORKING_F_NUMBER;
    l->aperture = mcv_codev_means(key, "NAO")  ? slope
                  : mcv_codev_means(key, "NA") ? 1 / (2 * slope)
                                               : fabs(value);
    return MCV_OK;
}

/* XAN and YAN, XOB and YOB, XIM and YIM, XRI and YRI: the fields' coordinates. */
static mcv_result read_field(mcv_codev *c, const char *key, const mcv_codev_statement *s,
                             mcv_error *error) {
    mcv_lens *l = c->l;
    double value, *field = l->field + (toupper((unsigned char)key[0]) == 'Y');
    const char kind = (char)toupper((unsigned char)key[1]);
    const mcv_lens_field is = kind == 'A'   ? MCV_LENS_FIELD_TANGENT
                              : kind == 'O' ? MCV_LENS_OBJECT_HEIGHT
                                            : MCV_LENS_IMAGE_HEIGHT;
    if (is != l->field_is) l->field[0] = l->field[1] = 0;
    l->field_is = is;
    for (int i = 0; i < s->count; ++i) {
        MCV_TRY(mcv_lens_number(l, s->words[i], &value, error));
        *field = fmax(*field, is == MCV_LENS_FIELD_TANGENT ? tan(fmin(fabs(value), 89) * M_PI / 180)
                                                           : fabs(value));
    }
    return MCV_OK;
}

static mcv_result read_list(const mcv_codev *c, const mcv_codev_statement *s, double *values,
                            int *count, mcv_error *error) {
    *count = 0;
    for (int i = 0; i < s->count; ++i)
        MCV_TRY(mcv_lens_number(c->l, s->words[i], values + (*count)++, error));
    return MCV_OK;
}

/* In PRV … END: 'NAME' and its indices at the wavelengths of PWL. */
static mcv_result read_private_glass(mcv_codev *c, char **words, int n, mcv_error *error) {
    mcv_lens *l = c->l;
    const mcv_codev_statement values = {.words = words + 1, .count = n - 1};
    double indices[MCV_LENS_WORDS];
    int count;
    if (mcv_codev_means(words[0], "PWL"))
        return read_list(c, &values, c->private_wavelengths, &c->private_count, error);
    if (l->glass_count == MCV_LENS_GLASSES || n - 1 != c->private_count || n < 2) {
        mcv_lens_warn(
            l,
            "%s: line %d: the private glass %s is incomplete: it must have an index for each "
            "wavelength of PWL",
            l->path, l->line, words[0]);
        return MCV_OK;
    }
    MCV_TRY(read_list(c, &values, indices, &count, error));
    if (!mcv_lens_fit_glass(l->glasses + l->glass_count, c->private_wavelengths, indices, count))
        return mcv_codev_fail(
            c, -1, error,
            "its indices must be 1 to 10, its wavelengths above 0: the private glass ", words[0]);
    mcv_lens_copy_name(l->glasses[l->glass_count++].name, words[0]);
    return MCV_OK;
}

/* What does not change the shape of the lens. */
static const char ignored[] = " LEN INI WTW WTF VUX VUY VLX VLY DOR DER CCY CCX THC GLC GL1 GL2 KC "
                              "AC BC CC DC EC FC GC HC JC CUC UID TEM PRE CA SLB CWL POL PFR PTP "
                              "POR POF MLT MLC INS WID SPH CON ASP CRO DIN CUM DEN OFF COM RAO TPF "
                              "SET SSI SAV OUT VIE IN FRZ DEL WTA PRV END GO ZOO TOL DLF DLR "
                              "DLT DLN DLV TIR IRR BTI BTX BTY DSX DSY CMP HOM CYD INC SUR IMC AFI "
                              "VCC VIG RSI DDM XFO YFO NRF TOR CDC ATY AVA RAY TEM WTI PAR ";
static const char decentred[] = " XDE YDE ZDE ADE BDE CDE XOD YOD ZOD ";
static const char refused[] =
    " SPS XTO YTO CYL AAS GRT DIF HOE HCO SPL ZRN NSS GRI GRN RDX CUX MOD MFL UDS UD1 FRE LSN ";

static void note_unknown(mcv_codev *c, const char *word) {
    const size_t length = strlen(c->unknown);
    char key[8];
    snprintf(key, sizeof key, " %.4s", word);
    if (strstr(c->unknown, key) || length + 8 > sizeof c->unknown) return;
    for (const char *k = key + 1; *k; ++k)
        if (!isalnum((unsigned char)*k)) return;
    if (!*c->unknown) c->first_unknown = c->l->line;
    memcpy(c->unknown + length, key, strlen(key) + 1);
}

static mcv_result read_surface_statement(mcv_codev *c, const char *key,
                                         const mcv_codev_statement *s, mcv_error *error) {
    mcv_lens *l = c->l;
    double value = 0;
    if (mcv_codev_means_one_of(key, refused))
        return mcv_codev_fail(c, s->first, error,
                              "only spheres, conics and even aspheres are supported, not ", key);
    if (mcv_codev_means_one_of(key, decentred) || mcv_codev_means(key, "CUF")) {
        if (s->count > 0) MCV_TRY(mcv_lens_number(l, s->words[0], &value, error));
        return value == 0 ? MCV_OK
                          : mcv_codev_fail(c, s->first, error,
                                           "tilts, decentres and CUF are not supported: only "
                                           "centred lenses are, not ",
                                           key);
    }
    if (mcv_codev_means(key, "STO")) l->stop = s->first;
    if (mcv_codev_means(key, "RDY"))
        return mcv_codev_read_shape(c, s, MCV_LENS_SHAPE_RADIUS, error);
    if (mcv_codev_means(key, "CUY"))
        return mcv_codev_read_shape(c, s, MCV_LENS_SHAPE_CURVATURE, error);
    if (mcv_codev_means(key, "THI")) return mcv_codev_read_thickness(c, s, error);
    if (mcv_codev_means(key, "CIR")) return mcv_codev_read_aperture(c, s, error);
    if (mcv_codev_means(key, "PIM"))
        l->surfaces[s->named || !c->image ? s->first : l->count - 2].image_solve = true;
    if (mcv_codev_means(key, "GLA") || mcv_codev_means(key, "RMD")) {
        for (int i = s->first; s->count > 0 && i <= s->last; ++i)
            if (mcv_codev_means(key, "GLA") || mcv_codev_means(s->words[0], "REFL"))
                MCV_TRY(mcv_codev_set_glass(c, i, s->words[0], error));
        return MCV_OK;
    }
    if (strlen(key) == 1) return mcv_codev_read_coefficient(c, key, s, error);
    if (mcv_codev_means_one_of(key, " REX REY ELX ELY ADX ADY ARO CIG REG ELG "))
        mcv_lens_warn(l, "%s: line %d: only round, centred apertures are supported: %s is ignored",
                      l->path, l->line, key);
    return MCV_OK;
}

static mcv_result read_statement(mcv_codev *c, char **words, int n, mcv_error *error) {
    mcv_lens *l = c->l;
    const char *key = words[0];
    mcv_codev_statement s;
    if (mcv_codev_means(key, "END")) c->private_glasses = false;
    if (c->private_glasses) return read_private_glass(c, words, n, error);
    if (mcv_codev_means(key, "PRV")) c->private_glasses = true;
    if (mcv_codev_means(key, "RDM") && !c->forced)
        c->shape = n > 1 && toupper((unsigned char)words[1][0]) == 'N' ? MCV_LENS_SHAPE_CURVATURE
                                                                       : MCV_LENS_SHAPE_RADIUS;
    if (mcv_codev_means(key, "GO")) c->go = true;
    if (mcv_codev_means(key, "ZOO") && n == 2)
        mcv_lens_warn(l, "%s: line %d: only the first of its %s zoom positions is read", l->path,
                      l->line, words[1]);
    if (mcv_lens_is_one_of(key, " S SO SI ") ||
        (toupper((unsigned char)*key) == 'S' && isdigit((unsigned char)key[1])))
        return mcv_codev_read_surface(c, words, n, error);
    MCV_TRY(mcv_codev_read_target(c, words, n, &s, error));
    if (mcv_codev_means(key, "TIT") && s.count > 0 && !s.zoom)
        mcv_lens_copy_name(l->name, s.words[0]);
    if (mcv_codev_means(key, "DIM") && s.count > 0) return set_unit(c, s.words[0], error);
    if (mcv_codev_means(key, "WL"))
        return read_list(c, &s, c->wavelengths, &c->wavelength_count, error);
    if (mcv_codev_means(key, "REF") && s.count > 0 && !s.zoom)
        c->reference = (int)strtol(s.words[0], NULL, 10);
    if (mcv_codev_means(key, "EPD") || mcv_codev_means(key, "FNO") || mcv_codev_means(key, "NAO") ||
        mcv_codev_means(key, "NA"))
        return read_aperture_value(c, key, &s, error);
    if (mcv_codev_means_one_of(key, " XAN YAN XOB YOB XIM YIM XRI YRI "))
        return s.zoom ? MCV_OK : read_field(c, key, &s, error);
    if (mcv_codev_means_one_of(key, ignored) || mcv_codev_means_one_of(key, " RDM TIT REF "))
        return MCV_OK;
    const bool of_surface =
        mcv_codev_means_one_of(key, refused) || mcv_codev_means_one_of(key, decentred) ||
        mcv_codev_means_one_of(
            key, " CUF STO RDY CUY THI CIR PIM GLA RMD REX REY ELX ELY ADX ADY ARO CIG REG ELG ") ||
        (strlen(key) == 1 && strchr("ABCDEFGHJK", toupper((unsigned char)*key)));
    if (!of_surface) {
        note_unknown(c, key);
        return MCV_OK;
    }
    if (l->count == 0) return mcv_codev_fail(c, -1, error, "precedes the first surface, S: ", key);
    return read_surface_statement(c, key, &s, error);
}

mcv_result mcv_lens_codev_read(mcv_lens *l, mcv_lens_shape shape, char *text, mcv_error *error) {
    mcv_codev c = {.l = l, .shape = shape, .forced = shape != MCV_LENS_SHAPE_AUTO};
    char *rest = text, *line, *words[MCV_LENS_WORDS];
    for (int next_line = 1; (line = mcv_codev_next_statement(&rest, &l->line, &next_line));) {
        const int n = mcv_lens_split(line, words);
        if (n > 0) MCV_TRY(read_statement(&c, words, n, error));
    }
    if (l->count == 0)
        return mcv_lens_fail(l, 0, -1, error,
                             "has no surface (S): it is not a lens, or it is a macro of CODE V");
    if (!c.image) {
        if (!c.go)
            mcv_lens_warn(l, "%s: line %d: ends without SI and GO: it may be truncated", l->path,
                          l->line);
        MCV_TRY(
            mcv_lens_add_surface(l, error)); /* a lens of CODE V has an image from the beginning */
    }
    if (c.wavelength_count > 0) {
        const int reference = c.reference > 0 && c.reference <= c.wavelength_count
                                  ? c.reference - 1
                                  : c.wavelength_count / 2;
        if (!(c.wavelengths[reference] >= 1 && c.wavelengths[reference] < 1e6))
            return mcv_lens_fail(l, 0, -1, error, "its wavelengths (WL) must be above 0, in nm");
        l->wavelength = 1e-9 * c.wavelengths[reference];
    }
    if (*c.unknown)
        mcv_lens_warn(l, "%s: line %d: unknown statements are ignored:%s", l->path, c.first_unknown,
                      c.unknown);
    return MCV_OK;
}
