/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/lens_file.h"

#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "output/file.h"
#include "scene/params.h"
#include "scene/surfaces.h"

enum { MOST_SURFACES = 200, NAME = 64, WORDS = 24 };

typedef struct surface {
    double curvature, conic, thickness, semi_diameter; /* in the file's unit; semi-diameter 0: not given */
    double asphere[MCV_ASPHERE_TERMS];
    char glass[NAME]; /* behind it; empty: air */
    double index;     /* of the glass, 0: by its name */
    bool stop, complete;
} surface;

typedef struct lens {
    const char *path;
    char name[NAME];
    double unit;     /* [m] */
    double aperture; /* diameter of the entrance pupil, in the unit; 0: not given */
    double field;    /* tangent of the largest field angle */
    bool radii;      /* CODE V: radii instead of curvatures */
    int count;
    surface surfaces[MOST_SURFACES];
} lens;

static mcv_result fail_surface(const lens *l, int number, mcv_error *error, const char *what, const char *word) {
    if (number < 0) return mcv_fail(error, MCV_BAD_INPUT, "%s: before the first surface: %s%s", l->path, what, word);
    return mcv_fail(error, MCV_BAD_INPUT, "%s: surface %d: %s%s", l->path, number, what, word);
}

/* --- text ------------------------------------------------------------------------------------------------------- */

/* UTF-16 with a byte order mark to bytes, what is not ASCII to '?'; the text ends with 0. */
static mcv_result read_text(const char *path, char **text, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    const bool little = size >= 2 && bytes[0] == 0xff && bytes[1] == 0xfe, big = size >= 2 && bytes[0] == 0xfe && bytes[1] == 0xff;
    char *out = malloc(size + 1);
    size_t n = 0;
    if (!out) {
        free(bytes);
        return mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    }
    for (size_t i = little || big ? 2 : 0; i + (little || big) < size; i += little || big ? 2 : 1) {
        const unsigned code = little ? bytes[i] | (unsigned)bytes[i + 1] << 8 : big ? bytes[i + 1] | (unsigned)bytes[i] << 8 : bytes[i];
        out[n++] = (char)(code > 0 && code < 128 ? code : '?');
    }
    out[n] = '\0';
    free(bytes);
    *text = out;
    return MCV_OK;
}

/* Cuts a statement into words, quoted ones as one; returns how many. */
static int split(char *statement, char *words[WORDS]) {
    int n = 0;
    while (n < WORDS) {
        while (isspace((unsigned char)*statement)) ++statement;
        if (!*statement) break;
        const bool quoted = *statement == '\'' || *statement == '"';
        const char quote = *statement;
        if (quoted) ++statement;
        words[n++] = statement;
        while (*statement && (quoted ? *statement != quote : !isspace((unsigned char)*statement))) ++statement;
        if (!*statement) break;
        *statement++ = '\0';
    }
    return n;
}

static bool is(const char *word, const char *other) { return strcasecmp(word, other) == 0; }

static mcv_result read_number(const lens *l, const char *word, double *value, mcv_error *error) {
    char *end;
    *value = strtod(word, &end);
    if (end != word && *end == '\0' && !isnan(*value)) return MCV_OK;
    return fail_surface(l, l->count - 1, error, "there must be a number in place of ", word);
}

static mcv_result new_surface(lens *l, mcv_error *error) {
    if (l->count == MOST_SURFACES) return mcv_fail(error, MCV_BAD_INPUT, "%s: more than %d surfaces", l->path, MOST_SURFACES);
    l->surfaces[l->count++] = (surface){0};
    return MCV_OK;
}

static mcv_result set_unit(lens *l, const char *word, mcv_error *error) {
    static const struct {
        const char *word;
        double unit;
    } units[] = {{"MM", 1e-3}, {"M", 1e-3}, {"CM", 1e-2}, {"C", 1e-2}, {"IN", 0.0254}, {"I", 0.0254}, {"METER", 1}};
    for (size_t i = 0; i < sizeof units / sizeof units[0]; ++i)
        if (is(word, units[i].word)) {
            l->unit = units[i].unit;
            return MCV_OK;
        }
    return mcv_fail(error, MCV_BAD_INPUT, "%s: the unit \"%s\" must be MM, CM, IN or METER", l->path, word);
}

/* --- Zemax ------------------------------------------------------------------------------------------------------ */

static mcv_result zemax_surface(lens *l, char **words, int n, mcv_error *error) {
    surface *s = l->surfaces + l->count - 1;
    const char *key = words[0], *first = n > 1 ? words[1] : "";
    double value;
    if (is(key, "TYPE") && !is(first, "STANDARD") && !is(first, "EVENASPH"))
        return fail_surface(l, l->count - 1, error, "only the types STANDARD and EVENASPH are known, not ", first);
    if (is(key, "STOP")) s->stop = true;
    if (is(key, "MIRR") || is(key, "SLAB") || n < 2) return MCV_OK;
    if (is(key, "CURV")) return read_number(l, first, &s->curvature, error);
    if (is(key, "CONI")) return read_number(l, first, &s->conic, error);
    if (is(key, "DIAM")) {
        s->complete = true; /* the last of what a surface needs */
        return read_number(l, first, &s->semi_diameter, error);
    }
    if (is(key, "DISZ")) return read_number(l, first, &s->thickness, error);
    if (is(key, "GLAS")) {
        if (is(first, "MIRROR")) return fail_surface(l, l->count - 1, error, "mirrors are not known in lens files: use a \"surface\"", "");
        snprintf(s->glass, sizeof s->glass, "%s", first);
        /* Of a model glass the file gives the index. */
        if (n > 4 && strcmp(words[2], "1") == 0) return read_number(l, words[4], &s->index, error);
        return MCV_OK;
    }
    if (is(key, "PARM") && n > 2) {
        const long term = strtol(first, NULL, 10);
        MCV_TRY(read_number(l, words[2], &value, error));
        if (value == 0) return MCV_OK;
        if (term < 2 || term > MCV_ASPHERE_TERMS + 1)
            return fail_surface(l, l->count - 1, error, "aspheres have terms from r^4 to r^18, not PARM ", first);
        s->asphere[term - 2] = value;
    }
    return MCV_OK;
}

static mcv_result read_zemax(lens *l, char *text, mcv_error *error) {
    char *rest = text, *line, *words[WORDS];
    while ((line = strsep(&rest, "\r\n"))) {
        const int n = split(line, words);
        if (n == 0) continue;
        if (is(words[0], "UNIT") && n > 1) MCV_TRY(set_unit(l, words[1], error));
        if (is(words[0], "NAME") && n > 1) snprintf(l->name, sizeof l->name, "%s", words[1]);
        if (is(words[0], "MODE") && n > 1 && !is(words[1], "SEQ"))
            return mcv_fail(error, MCV_BAD_INPUT, "%s: only sequential lenses are known (MODE SEQ), not %s", l->path, words[1]);
        if (is(words[0], "SURF"))
            MCV_TRY(new_surface(l, error));
        else if (l->count > 0)
            MCV_TRY(zemax_surface(l, words, n, error));
    }
    for (int i = 0; i < l->count; ++i)
        if (!l->surfaces[i].complete) return fail_surface(l, i, error, "has no DIAM: the file is truncated", "");
    return MCV_OK;
}

/* --- CODE V ----------------------------------------------------------------------------------------------------- */

static mcv_result codev_surface(lens *l, char **words, int n, mcv_error *error) {
    surface *s = l->surfaces + l->count - 1;
    double value = 0;
    if (n > 1) {
        MCV_TRY(read_number(l, words[1], &value, error));
        s->curvature = !l->radii ? value : value != 0 ? 1 / value : 0;
    }
    if (n > 2) MCV_TRY(read_number(l, words[2], &s->thickness, error));
    if (n > 3 && is(words[3], "REFL"))
        return fail_surface(l, l->count - 1, error, "mirrors are not known in lens files: use a \"surface\"", "");
    if (n > 3 && !is(words[3], "AIR")) snprintf(s->glass, sizeof s->glass, "%s", words[3]);
    return MCV_OK;
}

static mcv_result codev_statement(lens *l, char **words, int n, bool *ended, mcv_error *error) {
    static const char *const unknown[] = {"SPS", "XTO", "YTO", "CYL", "AAS", "GRT", "DAR", "XDE", "YDE", "ADE", "BDE", "SPL", "ZRN"};
    static const char *const unordered[] = {"RDY", "CUY", "THI", "GLA"};
    const char *key = words[0];
    double value = 0;
    for (size_t i = 0; i < sizeof unknown / sizeof unknown[0]; ++i)
        if (is(key, unknown[i])) return fail_surface(l, l->count - 1, error, "only spheres, conics and even aspheres are known, not ", key);
    for (size_t i = 0; i < sizeof unordered / sizeof unordered[0]; ++i)
        if (is(key, unordered[i]))
            return fail_surface(l, l->count - 1, error, "surfaces must be given as S radius thickness glass, not by ", key);
    if (is(key, "DIM") && n > 1) return set_unit(l, words[1], error);
    if (is(key, "RDM")) l->radii = n < 2 || !is(words[1], "N");
    if (is(key, "TITLE") && n > 1) snprintf(l->name, sizeof l->name, "%s", words[1]);
    if (is(key, "EPD") && n > 1) return read_number(l, words[1], &l->aperture, error);
    for (int i = 1; is(key, "YAN") && i < n; ++i) {
        MCV_TRY(read_number(l, words[i], &value, error));
        l->field = fmax(l->field, tan(fabs(value) * M_PI / 180));
    }
    if (is(key, "GO")) *ended = true;
    if (is(key, "SO") || is(key, "SI") || is(key, "S")) {
        MCV_TRY(new_surface(l, error));
        return codev_surface(l, words, n, error);
    }
    if (l->count == 0) return MCV_OK;
    surface *s = l->surfaces + l->count - 1;
    if (is(key, "STO")) s->stop = true;
    if (n < 2) return MCV_OK;
    if (is(key, "STO")) return fail_surface(l, l->count - 1, error, "STO must stand below its surface, not name ", words[1]);
    if (is(key, "CIR") && n > 2 && !is(words[1], "EDG"))
        return fail_surface(l, l->count - 1, error, "only the radius of a round aperture is known, not CIR ", words[1]);
    if (is(key, "K")) return read_number(l, words[1], &s->conic, error);
    if (is(key, "CIR")) return read_number(l, words[n - 1], &s->semi_diameter, error);
    if (strlen(key) == 1 && toupper((unsigned char)*key) >= 'A' && toupper((unsigned char)*key) < 'A' + MCV_ASPHERE_TERMS)
        return read_number(l, words[1], &s->asphere[toupper((unsigned char)*key) - 'A'], error);
    if (is(key, "J")) {
        MCV_TRY(read_number(l, words[1], &value, error));
        if (value != 0) return fail_surface(l, l->count - 1, error, "aspheres have terms from r^4 to r^18, A to H, not ", key);
    }
    return MCV_OK;
}

static mcv_result read_codev(lens *l, char *text, mcv_error *error) {
    char *rest = text, *line, *words[WORDS];
    bool ended = false;
    l->radii = true;
    while ((line = strsep(&rest, "\r\n"))) {
        line[strcspn(line, "!")] = '\0';
        for (char *statement; (statement = strsep(&line, ";"));) {
            const int n = split(statement, words);
            if (n > 0) MCV_TRY(codev_statement(l, words, n, &ended, error));
        }
    }
    return ended ? MCV_OK
                 : mcv_fail(error, MCV_BAD_INPUT, "%s: ends without GO after surface %d: the file is truncated", l->path, l->count - 1);
}

/* --- glass ------------------------------------------------------------------------------------------------------ */

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

/* The material: {"glass": …} or {"ior": …}. */
static mcv_result find_glass(const lens *l, int number, const char *const *indices, size_t count, json_t **material, mcv_error *error) {
    const surface *s = l->surfaces + number;
    const char *const *names = mcv_param_options("glass");
    double index = s->index;
    char *end;
    for (size_t i = 0; i < count; ++i) {
        const size_t length = strcspn(indices[i], "=");
        if (strlen(s->glass) == length && strncasecmp(indices[i], s->glass, length) == 0) index = strtod(indices[i] + length + 1, NULL);
    }
    for (int i = 1; index == 0 && names[i]; ++i)
        if (same_glass(names[i], s->glass)) {
            *material = json_pack("{s:s, s:s}", "type", "dielectric", "glass", names[i]);
            return MCV_OK;
        }
    if (index == 0 && (isdigit((unsigned char)s->glass[0]) ||
                       s->glass[0] == '.')) { /* 1.5168, or 517642, 517.642 and 516800.641673: n - 1, and Abbe's number */
        index = strtod(s->glass, &end);
        const size_t digits = strspn(s->glass, "0123456789");
        if (digits >= 3)
            index = 1 + floor(s->glass[digits] ? index : index / 1e3) / pow(10, s->glass[digits] ? (double)digits : (double)digits - 3);
    }
    if (index >= 1 && index <= 10) {
        *material = json_pack("{s:s, s:f}", "type", "dielectric", "ior", index);
        return MCV_OK;
    }
    return mcv_fail(error, MCV_BAD_INPUT, "%s: surface %d: unknown glass \"%s\": give its index with --index %s=1.5", l->path, number,
                    s->glass, s->glass);
}

static double index_of(json_t *material) {
    const json_t *ior = json_object_get(material, "ior");
    const char *const *names = mcv_param_options("glass");
    if (ior) return json_number_value(ior);
    for (int i = 1; names[i]; ++i)
        if (strcmp(names[i], json_string_value(json_object_get(material, "glass"))) == 0) return mcv_glass_index(i, 587.6e-9);
    return 1;
}

/* --- semi-diameters --------------------------------------------------------------------------------------------- */

/* Heights of a paraxial ray that begins with height y and slope u on the first surface. */
static void trace_paraxial(const lens *l, json_t *const *materials, int first, int end, double y, double u, double *heights) {
    double n = 1;
    for (int i = first; i < end; ++i) {
        const double next = materials[i] ? index_of(materials[i]) : 1;
        heights[i] = y;
        u = (n * u - y * l->surfaces[i].curvature * (next - n)) / next;
        y += l->surfaces[i].thickness * u;
        n = next;
    }
}

static mcv_result find_semi_diameters(lens *l, json_t *const *materials, int first, int end, mcv_error *error) {
    double axial[MOST_SURFACES], oblique[MOST_SURFACES];
    int stop = first;
    bool missing = false;
    for (int i = first; i < end; ++i) {
        if (l->surfaces[i].stop) stop = i;
        const bool dummy = !l->surfaces[i].stop && !materials[i] && !(i > first && materials[i - 1]);
        if (!dummy && !(l->surfaces[i].semi_diameter > 0)) missing = true;
    }
    if (!missing) return MCV_OK;
    if (!(l->aperture > 0))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: gives neither semi-diameters (DIAM, CIR) nor the diameter of the entrance pupil (EPD)",
                        l->path);
    trace_paraxial(l, materials, first, end, l->aperture / 2, 0, axial);
    trace_paraxial(l, materials, first, end, 0, l->field, oblique);
    for (int i = first; i < end; ++i) {
        surface *s = l->surfaces + i;
        if (s->semi_diameter > 0) continue;
        const double chief = oblique[i] - oblique[stop] / axial[stop] * axial[i];
        s->semi_diameter = i == stop && !materials[i] ? fabs(axial[i]) : 1.05 * (fabs(axial[i]) + fabs(chief));
    }
    return MCV_OK;
}

/* Both surfaces of a body end together, and before either is upright. */
static double largest_radius(const surface *s) {
    const double square = (1 + s->conic) * s->curvature * s->curvature;
    return square > 0 ? 0.95 / sqrt(square) : INFINITY;
}

static double sag(const surface *s, double r) {
    const double c = s->curvature;
    double z = c * r * r / (1 + sqrt(fmax(1 - (1 + s->conic) * c * c * r * r, 0)));
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i) z += s->asphere[i] * pow(r, 2 * i + 4);
    return z;
}

/* Whatever lies between two surfaces, glass or air, has a thickness up to their edges: an unvignetted bundle may ask for more. */
static void fit_semi_diameters(lens *l, json_t *const *materials, int first, int end, const bool *given) {
    for (int pass = 0; pass < 4; ++pass)
        for (int i = first; i + 1 < end; ++i) {
            surface *a = l->surfaces + i, *b = a + 1;
            if (given[i] || given[i + 1]) continue;
            double edge = materials[i] ? fmax(a->semi_diameter, b->semi_diameter) : fmin(a->semi_diameter, b->semi_diameter);
            if (materials[i]) edge = fmin(edge, fmin(largest_radius(a), largest_radius(b)));
            while (a->thickness + sag(b, edge) - sag(a, edge) < 0 && edge > 0) edge = edge > 1e-6 * a->semi_diameter ? 0.98 * edge : 0;
            a->semi_diameter = materials[i] ? edge : fmin(a->semi_diameter, fmax(edge, 0));
            b->semi_diameter = materials[i] ? edge : b->semi_diameter;
        }
}

/* --- glTF ------------------------------------------------------------------------------------------------------- */

static json_t *write_surface(const lens *l, const surface *s, int material) {
    json_t *out = json_object();
    int terms = 0;
    if (s->curvature != 0) json_object_set_new(out, "radius", json_real(l->unit / s->curvature));
    if (s->conic != 0) json_object_set_new(out, "conic", json_real(s->conic));
    for (int i = 0; i < MCV_ASPHERE_TERMS; ++i)
        if (s->asphere[i] != 0) terms = i + 1;
    if (terms > 0) {
        json_t *list = json_array();
        for (int i = 0; i < terms; ++i) json_array_append_new(list, json_real(s->asphere[i] * pow(l->unit, -2 * i - 3)));
        json_object_set_new(out, "asphere", list);
    }
    json_object_set_new(out, "semiDiameter", json_real(s->semi_diameter * l->unit));
    if (isfinite(s->thickness)) json_object_set_new(out, "thickness", json_real(s->thickness * l->unit));
    if (material >= 0) json_object_set_new(out, "material", json_integer(material));
    return out;
}

/* The surfaces first … end - 1, and stops that are none of a body; places count from the first glass. */
static json_t *write_scene(const lens *l, json_t *const *materials, int first, int end) {
    json_t *list = json_array(), *surfaces = json_array(), *bodies = json_array(), *nodes = json_array(), *children = json_array();
    double z = 0;
    for (int i = first; !materials[i]; ++i) z -= l->surfaces[i].thickness;
    for (int i = first; i < end; ++i) {
        const surface *s = l->surfaces + i;
        const bool of_body = materials[i] || (i > first && materials[i - 1]);
        if (s->stop && !of_body) {
            json_array_append_new(bodies,
                                  json_pack("{s:s, s:s, s:f, s:f, s:s}", "name", "stop", "type", "disc", "radius",
                                            3 * s->semi_diameter * l->unit, "holeRadius", s->semi_diameter * l->unit, "material", "black"));
            json_array_append_new(children, json_integer((json_int_t)json_array_size(children) + 1));
            json_array_append_new(nodes, json_pack("{s:s, s:[f,f,f], s:{s:{s:i}}}", "name", "stop", "translation", 0.0, 0.0, z * l->unit,
                                                   "extensions", "MCVISI_surfaces", "surface", (int)json_array_size(bodies)));
        }
        if (of_body) {
            surface next = *s;
            for (int k = i + 1; !materials[i] && k < end && !materials[k]; ++k)
                next.thickness += l->surfaces[k].thickness; /* past dummies */
            json_array_append_new(surfaces, write_surface(l, &next, materials[i] ? (int)json_array_size(list) : -1));
            if (materials[i])
                json_array_append_new(
                    list, json_pack("{s:s, s:{s:O}}", "name", l->surfaces[i].glass, "extensions", "MCVISI_materials", materials[i]));
        }
        z += s->thickness;
    }
    json_array_append_new(list, json_pack("{s:s, s:{s:{s:s}}}", "name", "black", "extensions", "MCVISI_materials", "type", "absorber"));
    json_array_insert_new(bodies, 0,
                          json_pack("{s:s, s:s, s:o}", "name", *l->name ? l->name : "lens", "type", "lens", "surfaces", surfaces));
    json_t *root = json_pack("{s:s, s:{s:{s:i}}}", "name", *l->name ? l->name : "lens", "extensions", "MCVISI_surfaces", "surface", 0);
    if (json_array_size(children) > 0)
        json_object_set_new(root, "children", children);
    else
        json_decref(children);
    json_array_insert_new(nodes, 0, root);
    return json_pack("{s:{s:s, s:s}, s:i, s:[{s:[i]}], s:[s,s], s:{s:{s:o}}, s:o, s:o}", "asset", "version", "2.0", "generator",
                     "mcvisi import", "scene", 0, "scenes", "nodes", 0, "extensionsUsed", "MCVISI_surfaces", "MCVISI_materials",
                     "extensions", "MCVISI_surfaces", "surfaces", bodies, "materials", list, "nodes", nodes);
}

static mcv_result check_indices(const char *const *indices, size_t count, mcv_error *error) {
    for (size_t i = 0; i < count; ++i) {
        const char *equals = strchr(indices[i], '=');
        const double index = equals && equals > indices[i] ? strtod(equals + 1, NULL) : 0;
        if (!(index >= 1 && index <= 10))
            return mcv_fail(error, MCV_USAGE, "--index %s: must be GLASS=N, an index from 1 to 10", indices[i]);
    }
    return MCV_OK;
}

static mcv_result convert(lens *l, const char *const *indices, size_t count, json_t **scene, mcv_error *error) {
    json_t *materials[MOST_SURFACES] = {0};
    bool given[MOST_SURFACES];
    int first = -1, end = 0;
    mcv_result result = MCV_OK;
    for (int i = 0; i < l->count && result == MCV_OK; ++i) {
        given[i] = l->surfaces[i].semi_diameter > 0;
        if (!*l->surfaces[i].glass) continue;
        if (first < 0) first = i;
        end = i + 2;
        result = i + 1 < l->count ? find_glass(l, i, indices, count, materials + i, error)
                                  : fail_surface(l, i, error, "its glass has no surface behind it: the file is truncated", "");
        if (result == MCV_OK && !(isfinite(l->surfaces[i].thickness) && l->surfaces[i].thickness >= 0))
            result = fail_surface(l, i, error, "the thickness of its glass must be 0 or more", "");
    }
    if (result == MCV_OK && first < 0) result = mcv_fail(error, MCV_BAD_INPUT, "%s: holds no surface with a glass: it is no lens", l->path);
    /* A stop before the first glass or behind the last belongs to the lens. */
    for (int i = 1; i < l->count && result == MCV_OK; ++i) {
        if (!l->surfaces[i].stop) continue;
        first = i < first ? i : first;
        end = i < end ? end : i + 1;
    }
    for (int i = first; i < end - 1 && result == MCV_OK; ++i)
        if (!isfinite(l->surfaces[i].thickness)) result = fail_surface(l, i, error, "the way to the next surface must be finite", "");
    if (result == MCV_OK) result = find_semi_diameters(l, materials, first, end, error);
    if (result == MCV_OK) {
        fit_semi_diameters(l, materials, first, end, given);
        *scene = write_scene(l, materials, first, end);
        if (!*scene) result = mcv_fail(error, MCV_FAILED, "%s: no memory to convert it", l->path);
    }
    for (int i = 0; i < l->count; ++i) json_decref(materials[i]);
    return result;
}

mcv_result mcv_lens_file_read(const char *path, const char *const *indices, size_t index_count, json_t **scene, mcv_error *error) {
    const bool zemax = mcv_ends_in(path, ".zmx"), codev = mcv_ends_in(path, ".seq");
    char *text = NULL;
    *scene = NULL;
    if (!zemax && !codev) return mcv_fail(error, MCV_BAD_INPUT, "%s: must be a .zmx or .seq file", path);
    MCV_TRY(check_indices(indices, index_count, error));
    MCV_TRY(read_text(path, &text, error));
    lens *l = calloc(1, sizeof *l);
    mcv_result result = l ? MCV_OK : mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    if (l) {
        l->path = path;
        l->unit = 1e-3;
        result = zemax ? read_zemax(l, text, error) : read_codev(l, text, error);
        if (result == MCV_OK) result = convert(l, indices, index_count, scene, error);
    }
    free(l);
    free(text);
    return result;
}
