/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sequences of CODE V: statements of words, of which the first three letters count, one on a line
 * or several with ; between them. Those of a surface follow it or name it (THI S3 5).
 */
#include "lens/lens.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"

typedef struct codev {
    mcv_lens *l;
    mcv_lens_shape shape; /* what an S statement gives; AUTO: not known yet */
    bool forced;          /* by the user's option */
    bool image, go, private_glasses;
    double wavelengths[MCV_LENS_WORDS], private_wavelengths[MCV_LENS_WORDS]; /* [nm] */
    int wavelength_count, private_count, reference;
    char unknown[160]; /* words that were left out */
    int first_unknown;
} codev;

/* A statement's values, behind the words that say of what they are. */
typedef struct statement {
    char **words;
    int count, first, last; /* surfaces; -1: none named */
    bool named, zoom;
} statement;

static mcv_result fail_here(const codev *c, int surface, mcv_error *error, const char *what,
                            const char *word) {
    return mcv_lens_fail(c->l, c->l->line, surface, error, "%s%s", what, word);
}

/* --- words
 * ------------------------------------------------------------------------------------------------------
 */

/*
 * Ends the statement that begins at *rest, without comments (!) and joined where a line ends in &;
 * sets the line it begins in. NULL at the end of the text.
 */
static char *next_statement(char **rest, int *line, int *next_line) {
    char *in = *rest, *out = *rest, *const begin = *rest, quote = '\0';
    if (!*in) return NULL;
    *line = *next_line;
    for (;; ++in) {
        if (*in == '\r') continue;
        if (*in == '!' && !quote) in += strcspn(in, "\n");
        if (*in == '&' && !quote) {
            char *after = in + 1 + strspn(in + 1, " \t\r");
            if (*after == '!') after += strcspn(after, "\n");
            if (*after == '\n') {
                ++*next_line;
                *out++ = ' ';
                in = after;
                continue;
            }
        }
        if (!*in || *in == '\n' || (*in == ';' && !quote)) break;
        if (quote ? *in == quote : *in == '\'' || *in == '"') quote = (char)(quote ? 0 : *in);
        *out++ = *in;
    }
    *next_line += *in == '\n';
    *rest = *in ? in + 1 : in;
    *out = '\0';
    return begin;
}

/* The surface that S3, SO, SI or SS names, SI being the image once it stands there; -1 if it is no
 * such word. */
static int surface_of(const codev *c, const char *word, char **end) {
    if (toupper((unsigned char)word[0]) != 'S') return -1;
    if (isdigit((unsigned char)word[1])) return (int)fmin((double)strtol(word + 1, end, 10), 1e6);
    *end = (char *)word + (word[1] ? 2 : 1);
    switch (toupper((unsigned char)word[1])) {
    case 'O':
        return 0;
    case 'I':
        return c->image ? c->l->count - 1 : 1000000;
    case 'S':
        return c->l->stop > 0 ? c->l->stop : 1;
    default:
        return -1;
    }
}

/* Takes the surfaces S3 or S3..5 and the zoom position Z1 off a statement's head; without, the
 * current surface is meant. */
static mcv_result read_target(const codev *c, char **words, int n, statement *s, mcv_error *error) {
    *s = (statement){words + 1, n - 1, c->l->count - 1, c->l->count - 1, false, false};
    while (s->count > 0) {
        char *word = s->words[0], *end = word;
        const int surface = surface_of(c, word, &end);
        if (surface >= 0 && (*end == '\0' || strncmp(end, "..", 2) == 0)) {
            s->first = s->last = surface;
            if (*end) {
                char *to = end + 2, name[16];
                snprintf(name, sizeof name, "%s%.12s",
                         toupper((unsigned char)*to) == 'S' ? "" : "S", to);
                s->last = surface_of(c, name, &end);
            }
            if (s->last < s->first || s->last >= c->l->count)
                return fail_here(c, -1, error, "there is no such surface yet: ", word);
            s->named = true;
        } else if (toupper((unsigned char)word[0]) == 'Z' && isdigit((unsigned char)word[1])) {
            s->zoom = strcmp(word + 1, "1") != 0;
        } else
            break;
        ++s->words;
        --s->count;
    }
    return MCV_OK;
}

/* Whether a word means the statement `key`, by its first three letters. */
static bool means(const char *word, const char *key) {
    return strncasecmp(word, key, 3) == 0 && (strlen(key) > 2 || strlen(word) == strlen(key));
}

static bool means_one_of(const char *word, const char *list) {
    char start[4];
    snprintf(start, sizeof start, "%.3s", word);
    return mcv_lens_is_one_of(start, list);
}

/* --- surfaces
 * ---------------------------------------------------------------------------------------------------
 */

/* 0 and infinite values are planes. */
static void set_shape(mcv_lens_surface *s, double value, mcv_lens_shape shape) {
    if (fabs(value) > 1e30 || fabs(value) < 1e-30) value = 0;
    s->unsure = shape == MCV_LENS_SHAPE_AUTO && value != 0;
    s->curvature = shape != MCV_LENS_SHAPE_RADIUS ? value : value != 0 ? 1 / value : 0;
}

static mcv_result set_glass(codev *c, int surface, const char *name, mcv_error *error) {
    mcv_lens_glass *glass = &c->l->surfaces[surface].glass;
    if (means(name, "REFL"))
        return fail_here(
            c, surface, error,
            "mirrors are not known in lens files: give them as a \"surface\" in the scene", "");
    *glass = (mcv_lens_glass){0};
    if (!mcv_lens_is(name, "AIR") && !mcv_lens_is(name, "REFR"))
        mcv_lens_copy_name(glass->name, name);
    return MCV_OK;
}

/* S radius thickness glass; SO and SI, or by its number. */
static mcv_result read_surface(codev *c, char **words, int n, mcv_error *error) {
    mcv_lens *l = c->l;
    const char kind = (char)toupper((unsigned char)words[0][1]);
    const bool numbered = isdigit((unsigned char)kind);
    int number = numbered ? (int)fmin((double)strtol(words[0] + 1, NULL, 10), 1e6) : 0;
    double value = 0;
    if (l->count == 0 &&
        (numbered ? number != 0
                  : kind != 'O')) { /* the object is at infinity unless the file says another */
        MCV_TRY(mcv_lens_add_surface(l, error));
        l->surfaces[0].thickness = INFINITY;
    }
    if (!numbered && kind != 'O') number = l->count - (kind == 'I' && c->image);
    if (number > l->count)
        return fail_here(c, -1, error,
                         "surfaces must follow each other, which leaves one out: ", words[0]);
    if (number == l->count) {
        if (c->image)
            return fail_here(c, -1, error, "there is a surface behind the image, SI: ", words[0]);
        MCV_TRY(mcv_lens_add_surface(l, error));
    }
    mcv_lens_surface *s = l->surfaces + number;
    c->image = c->image || kind == 'I';
    if (n > 1) {
        MCV_TRY(mcv_lens_distance(l, words[1], &value, error));
        set_shape(s, value, c->shape);
    }
    if (n > 2) MCV_TRY(mcv_lens_distance(l, words[2], &s->thickness, error));
    for (int i = 3; i < n; ++i) MCV_TRY(set_glass(c, number, words[i], error));
    return MCV_OK;
}

/* Statements of a solve (THI PIM, CUY UMY -0.1) name a word where a value would stand: the value is
 * that of the S statement. */
static mcv_result read_shape(codev *c, const statement *s, mcv_lens_shape shape, mcv_error *error) {
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    for (int i = s->first; i <= s->last; ++i) {
        mcv_lens_surface *surface = c->l->surfaces + i;
        if (isalpha((unsigned char)s->words[0][0])) {
            if (surface->curvature == 0 && !means(s->words[0], "PIK"))
                return fail_here(c, i, error,
                                 "its curvature is solved, but no value stands in its S statement: "
                                 "save the lens from CODE V, solve ",
                                 s->words[0]);
            continue;
        }
        MCV_TRY(mcv_lens_distance(c->l, s->words[0], &value, error));
        set_shape(surface, value, shape);
    }
    return MCV_OK;
}

static mcv_result read_thickness(codev *c, const statement *s, mcv_error *error) {
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    for (int i = s->first; i <= s->last; ++i) {
        mcv_lens_surface *surface = c->l->surfaces + i;
        if (means(s->words[0], "PIM") ||
            (means(s->words[0], "HMY") && s->count > 1 && strtod(s->words[1], NULL) == 0))
            surface->image_solve = true;
        else if (!isalpha((unsigned char)s->words[0][0])) {
            MCV_TRY(mcv_lens_distance(c->l, s->words[0], &value, error));
            surface->thickness = value;
        }
    }
    return MCV_OK;
}

/* CIR radius, for the clear aperture (CLR) or the edge (EDG), the first of which counts. */
static mcv_result read_aperture(codev *c, const statement *s, mcv_error *error) {
    double value;
    int at = 0;
    bool edge = false;
    for (; at < s->count && isalpha((unsigned char)s->words[at][0]); ++at) {
        if (means(s->words[at], "OBS") || means(s->words[at], "HOL"))
            return fail_here(c, s->first, error,
                             "only the radius of a round aperture is known, not CIR ",
                             s->words[at]);
        edge = edge || means(s->words[at], "EDG");
    }
    if (at == s->count || s->zoom) return MCV_OK;
    MCV_TRY(mcv_lens_number(c->l, s->words[at], &value, error));
    for (int i = s->first; i <= s->last; ++i)
        if (!edge || c->l->surfaces[i].semi_diameter == 0)
            c->l->surfaces[i].semi_diameter = fabs(value);
    return MCV_OK;
}

/* K, and A to J of r^4 to r^20. */
static mcv_result read_coefficient(codev *c, const char *key, const statement *s,
                                   mcv_error *error) {
    const int letter = toupper((unsigned char)*key), term = letter - 'A' - (letter == 'J');
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    MCV_TRY(mcv_lens_number(c->l, s->words[0], &value, error));
    for (int i = s->first; i <= s->last; ++i) {
        if (letter == 'K')
            c->l->surfaces[i].conic = value;
        else if (term < MCV_ASPHERE_TERMS)
            c->l->surfaces[i].asphere[term] = value;
        else if (value != 0)
            return fail_here(c, i, error, "aspheres have terms from r^4 to r^18, A to H, not ",
                             key);
    }
    return MCV_OK;
}

/* --- statements
 * -------------------------------------------------------------------------------------------------
 */

static mcv_result set_unit(codev *c, const char *word, mcv_error *error) {
    const char letter = (char)toupper((unsigned char)*word);
    c->l->unit = letter == 'M' ? 1e-3 : letter == 'C' ? 1e-2 : letter == 'I' ? 0.0254 : 0;
    return c->l->unit > 0
               ? MCV_OK
               : fail_here(c, -1, error, "DIM must be M (mm), C (cm) or I (inch), not ", word);
}

static mcv_result read_aperture_value(codev *c, const char *key, const statement *s,
                                      mcv_error *error) {
    mcv_lens *l = c->l;
    double value;
    if (s->count == 0 || s->zoom) return MCV_OK;
    MCV_TRY(mcv_lens_number(l, s->words[0], &value, error));
    const double slope = tan(asin(fmin(fabs(value), 1)));
    l->aperture_is = means(key, "EPD")   ? MCV_LENS_PUPIL_DIAMETER
                     : means(key, "NAO") ? MCV_LENS_OBJECT_SLOPE
                                         : MCV_LENS_WORKING_F_NUMBER;
    l->aperture = means(key, "NAO") ? slope : means(key, "NA") ? 1 / (2 * slope) : fabs(value);
    return MCV_OK;
}

/* XAN and YAN, XOB and YOB, XIM and YIM, XRI and YRI: the fields' coordinates. */
static mcv_result read_field(codev *c, const char *key, const statement *s, mcv_error *error) {
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

static mcv_result read_list(const codev *c, const statement *s, double *values, int *count,
                            mcv_error *error) {
    *count = 0;
    for (int i = 0; i < s->count; ++i)
        MCV_TRY(mcv_lens_number(c->l, s->words[i], values + (*count)++, error));
    return MCV_OK;
}

/* In PRV … END: 'NAME' and its indices at the wavelengths of PWL. */
static mcv_result read_private_glass(codev *c, char **words, int n, mcv_error *error) {
    mcv_lens *l = c->l;
    const statement values = {.words = words + 1, .count = n - 1};
    double indices[MCV_LENS_WORDS];
    int count;
    if (means(words[0], "PWL"))
        return read_list(c, &values, c->private_wavelengths, &c->private_count, error);
    if (l->glass_count == MCV_LENS_GLASSES || n - 1 != c->private_count || n < 2) {
        mcv_lens_warn(l,
                      "%s: line %d: the private glass %s is not known: it must have an index for "
                      "each wavelength of PWL",
                      l->path, l->line, words[0]);
        return MCV_OK;
    }
    MCV_TRY(read_list(c, &values, indices, &count, error));
    if (!mcv_lens_fit_glass(l->glasses + l->glass_count, c->private_wavelengths, indices, count))
        return fail_here(c, -1, error,
                         "its indices must be 1 to 10, of wavelengths above 0: the private glass ",
                         words[0]);
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

static void note_unknown(codev *c, const char *word) {
    const size_t length = strlen(c->unknown);
    char key[8];
    snprintf(key, sizeof key, " %.4s", word);
    if (strstr(c->unknown, key) || length + 8 > sizeof c->unknown) return;
    for (const char *k = key + 1; *k; ++k)
        if (!isalnum((unsigned char)*k)) return;
    if (!*c->unknown) c->first_unknown = c->l->line;
    memcpy(c->unknown + length, key, strlen(key) + 1);
}

static mcv_result read_surface_statement(codev *c, const char *key, const statement *s,
                                         mcv_error *error) {
    mcv_lens *l = c->l;
    double value = 0;
    if (means_one_of(key, refused))
        return fail_here(c, s->first, error,
                         "only spheres, conics and even aspheres are known, not ", key);
    if (means_one_of(key, decentred) || means(key, "CUF")) {
        if (s->count > 0) MCV_TRY(mcv_lens_number(l, s->words[0], &value, error));
        return value == 0
                   ? MCV_OK
                   : fail_here(
                         c, s->first, error,
                         "tilts, decentres and CUF are not known: only centred lenses are, not ",
                         key);
    }
    if (means(key, "STO")) l->stop = s->first;
    if (means(key, "RDY")) return read_shape(c, s, MCV_LENS_SHAPE_RADIUS, error);
    if (means(key, "CUY")) return read_shape(c, s, MCV_LENS_SHAPE_CURVATURE, error);
    if (means(key, "THI")) return read_thickness(c, s, error);
    if (means(key, "CIR")) return read_aperture(c, s, error);
    if (means(key, "PIM"))
        l->surfaces[s->named || !c->image ? s->first : l->count - 2].image_solve = true;
    if (means(key, "GLA") || means(key, "RMD")) {
        for (int i = s->first; s->count > 0 && i <= s->last; ++i)
            if (means(key, "GLA") || means(s->words[0], "REFL"))
                MCV_TRY(set_glass(c, i, s->words[0], error));
        return MCV_OK;
    }
    if (strlen(key) == 1) return read_coefficient(c, key, s, error);
    if (means_one_of(key, " REX REY ELX ELY ADX ADY ARO CIG REG ELG "))
        mcv_lens_warn(l, "%s: line %d: only round, centred apertures are known: %s is left out",
                      l->path, l->line, key);
    return MCV_OK;
}

static mcv_result read_statement(codev *c, char **words, int n, mcv_error *error) {
    mcv_lens *l = c->l;
    const char *key = words[0];
    statement s;
    if (means(key, "END")) c->private_glasses = false;
    if (c->private_glasses) return read_private_glass(c, words, n, error);
    if (means(key, "PRV")) c->private_glasses = true;
    if (means(key, "RDM") && !c->forced)
        c->shape = n > 1 && toupper((unsigned char)words[1][0]) == 'N' ? MCV_LENS_SHAPE_CURVATURE
                                                                       : MCV_LENS_SHAPE_RADIUS;
    if (means(key, "GO")) c->go = true;
    if (means(key, "ZOO") && n == 2)
        mcv_lens_warn(l, "%s: line %d: of its %s zoom positions the first is read", l->path,
                      l->line, words[1]);
    if (mcv_lens_is_one_of(key, " S SO SI ") ||
        (toupper((unsigned char)*key) == 'S' && isdigit((unsigned char)key[1])))
        return read_surface(c, words, n, error);
    MCV_TRY(read_target(c, words, n, &s, error));
    if (means(key, "TIT") && s.count > 0 && !s.zoom) mcv_lens_copy_name(l->name, s.words[0]);
    if (means(key, "DIM") && s.count > 0) return set_unit(c, s.words[0], error);
    if (means(key, "WL")) return read_list(c, &s, c->wavelengths, &c->wavelength_count, error);
    if (means(key, "REF") && s.count > 0 && !s.zoom)
        c->reference = (int)strtol(s.words[0], NULL, 10);
    if (means(key, "EPD") || means(key, "FNO") || means(key, "NAO") || means(key, "NA"))
        return read_aperture_value(c, key, &s, error);
    if (means_one_of(key, " XAN YAN XOB YOB XIM YIM XRI YRI "))
        return s.zoom ? MCV_OK : read_field(c, key, &s, error);
    if (means_one_of(key, ignored) || means_one_of(key, " RDM TIT REF ")) return MCV_OK;
    const bool of_surface =
        means_one_of(key, refused) || means_one_of(key, decentred) ||
        means_one_of(
            key, " CUF STO RDY CUY THI CIR PIM GLA RMD REX REY ELX ELY ADX ADY ARO CIG REG ELG ") ||
        (strlen(key) == 1 && strchr("ABCDEFGHJK", toupper((unsigned char)*key)));
    if (!of_surface) {
        note_unknown(c, key);
        return MCV_OK;
    }
    if (l->count == 0) return fail_here(c, -1, error, "stands before the first surface, S: ", key);
    return read_surface_statement(c, key, &s, error);
}

mcv_result mcv_lens_codev_read(mcv_lens *l, mcv_lens_shape shape, char *text, mcv_error *error) {
    codev c = {.l = l, .shape = shape, .forced = shape != MCV_LENS_SHAPE_AUTO};
    char *rest = text, *line, *words[MCV_LENS_WORDS];
    for (int next_line = 1; (line = next_statement(&rest, &l->line, &next_line));) {
        const int n = mcv_lens_split(line, words);
        if (n > 0) MCV_TRY(read_statement(&c, words, n, error));
    }
    if (l->count == 0)
        return mcv_lens_fail(l, 0, -1, error,
                             "holds no surface (S): it is no lens, or a macro of CODE V");
    if (!c.image) {
        if (!c.go)
            mcv_lens_warn(l, "%s: line %d: ends without SI and GO: is it whole?", l->path, l->line);
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
        mcv_lens_warn(l, "%s: line %d: statements that are not known are left out:%s", l->path,
                      c.first_unknown, c.unknown);
    return MCV_OK;
}
