/* SPDX-License-Identifier: Apache-2.0 */
/* Writes a rig as glTF that people can read and edit: one line per element. */
#include "rig/rig.h"

#include "core/basics.h"
#include "core/output_file.h"

#include <ctype.h>
#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const char *mcv_rig_length(double metres, int digits) {
    static _Thread_local char texts[4][48];
    static _Thread_local int next;
    char *text = texts[next++ % 4];
    const char *unit = metres >= 1 ? "m" : metres >= 1e-3 ? "mm" : "um";
    snprintf(text, sizeof texts[0], "%.*g%s", digits,
             metres * (metres >= 1      ? 1
                       : metres >= 1e-3 ? 1e3
                                        : 1e6),
             unit);
    return text;
}

enum { CHOSEN = 4, GIVEN = 9 }; /* digits of lengths */

static const char *length(double metres) { return mcv_rig_length(metres, CHOSEN); }

/* --- elements --- */

static bool is_light_field(const mcv_rig_design *r) {
    return r->wishes.kind == MCV_RIG_LIGHT_FIELD || r->wishes.kind == MCV_RIG_TRANSPARENT;
}

/* If the user wishes something of the lens, quantities that follow from it must not be rounded. */
static int lens_digits(const mcv_rig_design *r) {
    const mcv_rig_wishes *w = &r->wishes;
    return w->focal_length > 0 || w->working_distance > 0 || w->magnification > 0 ||
                   w->field_of_view > 0
               ? GIVEN
               : CHOSEN;
}

/* The node and the emitter. */
static const char *light_name(const mcv_rig_design *r) {
    return r->wishes.kind == MCV_RIG_LASER ? "laser" : "light";
}

/* Does the camera of a triangulation head look from below its laser? */
static bool is_below(const mcv_rig_design *r) { return r->elevation > 0; }

/* Heights are z: of the part where the light runs along its z, else of the laser. */
static bool has_heights(const mcv_rig_design *r) {
    const double degree = M_PI / 180;
    return fabs(cos(r->elevation * degree) * cos(r->azimuth * degree)) > M_SQRT1_2;
}

/* What `mcvisi scan` needs: a few profiles, as far apart as their points. */
static void print_head(FILE *out, const mcv_rig_design *r) {
    fprintf(
        out,
        ",\n         \"laser\": \"laser\", %s\"profiles\": 10, \"feed\": \"%s\", \"exposeTo\": 0.8",
        has_heights(r) ? "\"frame\": \"part\", " : "",
        mcv_rig_length(r->pixel / r->magnification, CHOSEN));
}

static void print_sensor(FILE *out, const mcv_rig_design *r) {
    const mcv_rig_wishes *w = &r->wishes;
    const int digits = lens_digits(r);
    if (w->kind == MCV_RIG_TELECENTRIC)
        fprintf(out,
                "{\"name\": \"camera\", \"type\": \"telecentric\", \"magnification\": %.*g, "
                "\"workingDistance\": \"%s\", ",
                digits == GIVEN ? GIVEN : 6, r->magnification,
                mcv_rig_length(r->working_distance, digits));
    else
        fprintf(out,
                "{\"name\": \"camera\", \"type\": \"%s\", \"focalLength\": \"%s\", "
                "\"focusDistance\": \"%s\", ",
                is_light_field(r)          ? "lightField"
                : w->kind == MCV_RIG_LASER ? "laserTriangulation"
                                           : "thinLens",
                mcv_rig_length(r->focal_length, digits),
                mcv_rig_length(r->working_distance, digits));
    if (is_light_field(r))
        fprintf(out,
                "\"fNumber\": %g,\n         \"spatialResolution\": [%u, %u], "
                "\"angularResolution\": [%u, %u], ",
                r->f_number, r->pixels[0] / r->directions, r->pixels[1] / r->directions,
                r->directions, r->directions);
    else
        fprintf(out, "\"fNumber\": %g,\n         \"resolution\": [%u, %u], ", r->f_number,
                r->pixels[0], r->pixels[1]);
    /* The plane of the light in focus: it goes through the axis, 90° - θ aside from the plane that
     * an upright film sees, and tan τ = m tan(90° - θ). */
    if (w->kind == MCV_RIG_LASER)
        fprintf(out, "\"tilt\": \"%.6gdeg\", \"tiltDirection\": \"%ddeg\", ",
                180 / M_PI * atan(r->magnification / tan(MCV_RIG_ANGLE * (M_PI / 180))),
                is_below(r) ? 180 : 0);
    fprintf(out, "\"pixelSize\": \"%s\", \"radiometry\": \"irradiance\"",
            mcv_rig_length(r->pixel, w->pixel_size > 0 ? GIVEN : CHOSEN));
    if (w->kind == MCV_RIG_LASER) print_head(out, r);
    fputc('}', out);
}

static void print_emitter(FILE *out, const mcv_rig_design *r) {
    const mcv_rig_light *light = &r->light;
    fprintf(out, "{\"name\": \"%s\", ", light_name(r));
    switch (light->type) {
    case MCV_RIG_LIGHT_LASER:
        fprintf(out,
                "\"type\": \"laser\", \"wavelength\": \"%s\", \"power\": 0.02,\n         "
                "\"lineThickness\": \"%s\", \"widthMeasure\": \"1/e2\", \"workingDistance\": "
                "\"%s\", \"fanAngle\": \"%.4gdeg\"}",
                length(MCV_RIG_WAVELENGTH), length(light->size[0]), length(light->distance),
                2 * light->half_angle);
        return;
    case MCV_RIG_LIGHT_BACKLIGHT:
        fprintf(out, "\"type\": \"%s\", \"size\": [\"%s\", \"%s\"], ",
                light->half_angle > 0 ? "parallel" : "area", length(light->size[0]),
                length(light->size[1]));
        if (light->half_angle > 0) fprintf(out, "\"halfAngle\": \"%.4gdeg\", ", light->half_angle);
        break;
    case MCV_RIG_LIGHT_COAXIAL:
        fprintf(out,
                "\"type\": \"coaxial\", \"size\": [\"%s\", \"%s\"], \"halfAngle\": \"%.4gdeg\", ",
                length(light->size[0]), length(light->size[1]), light->half_angle);
        break;
    case MCV_RIG_LIGHT_DOME:
        fprintf(out, "\"type\": \"dome\", \"diameter\": \"%s\", \"holeDiameter\": \"%s\", ",
                length(light->outer), length(light->inner));
        break;
    default:
        fprintf(out, "\"type\": \"ring\", \"innerDiameter\": \"%s\", \"outerDiameter\": \"%s\", ",
                length(light->inner), length(light->outer));
        if (light->tilt > 0) fprintf(out, "\"tilt\": \"%gdeg\", ", light->tilt);
        break;
    }
    fprintf(out, "\"radiance\": 1}");
}

static void print_pose(FILE *out, double distance, int digits, double azimuth, double elevation,
                       double roll) {
    fprintf(out,
            "\"MCVISI_pose\": {\"target\": \"centre\", \"distance\": \"%s\", \"azimuth\": "
            "\"%gdeg\", \"elevation\": \"%gdeg\"",
            mcv_rig_length(distance, digits), azimuth + 0.0, elevation + 0.0); /* + 0: no -0 */
    fprintf(out, ", \"roll\": \"%gdeg\"}", roll);
}

/* Prints a path as a URI; special characters are percent-encoded. */
static void print_uri(FILE *out, const char *path) {
    for (const unsigned char *c = (const unsigned char *)path; *c; ++c)
        if (isalnum(*c) || strchr("-._~/", *c))
            fputc(*c, out);
        else
            fprintf(out, "%%%02X", *c);
}

static void print_note(FILE *out, const mcv_rig_design *r) {
    static const char *const lights[MCV_RIG_LIGHT_COUNT] = {
        [MCV_RIG_LIGHT_BACKLIGHT] = "it is dark before a backlight",
        [MCV_RIG_LIGHT_RING] = "a ring light surrounds the view",
        [MCV_RIG_LIGHT_DARK_FIELD] =
            ("a low ring lights it at 7 to 23 degrees, so that edges, scratches and dust are "
             "bright"),
        [MCV_RIG_LIGHT_COAXIAL] =
            "a half mirror sends light along the view, so that flat polished faces are bright",
        [MCV_RIG_LIGHT_DOME] = "a dome lights it from all sides, with few highlights and shadows"};
    switch (r->wishes.kind) {
    case MCV_RIG_TELECENTRIC:
        fprintf(out, "A telecentric camera sees the part");
        break;
    case MCV_RIG_ENTOCENTRIC:
    case MCV_RIG_LASER:
        fprintf(out, "A camera with a thin lens sees the part");
        break;
    default:
        fprintf(out,
                "A light field camera, whose macro pixels hold %u x %u directions, sees the part",
                r->directions, r->directions);
        break;
    }
    if (r->wishes.kind == MCV_RIG_LASER)
        fprintf(out,
                " from %d degrees aside of a laser line, whose plane is in focus: `mcvisi "
                "scan` measures its heights. ",
                MCV_RIG_ANGLE);
    else if (r->wishes.kind == MCV_RIG_TRANSPARENT)
        fprintf(out, " before a parallel panel: what deflects light shows in `mcvisi lightfield "
                     "emd-gradient`. ");
    else if (r->wishes.kind == MCV_RIG_TELECENTRIC && r->light.type == MCV_RIG_LIGHT_BACKLIGHT)
        fprintf(
            out,
            " before a backlight: the size of its silhouette does not depend on the distance. ");
    else
        fprintf(out, "; %s. ", lights[r->light.type]);
    fprintf(out, "The part is %s x %s across and %s deep, ", length(r->across[0]),
            length(r->across[1]), length(r->depth));
    fprintf(out, "the field in focus %s x %s. Lengths are in metres, or strings with a unit.",
            length(r->field[0]), length(r->field[1]));
}

static void print_asset(FILE *out, const mcv_rig_design *r, const char *uri) {
    const char *unit = r->wishes.unit;
    fprintf(out, "{\"name\": \"part\", \"uri\": \"");
    print_uri(out, uri);
    fprintf(out, "\"%s%s%s%s", unit ? ", \"unit\": \"" : "", unit ? unit : "", unit ? "\"" : "",
            r->material[0] ? ", \"material\": \"part\"" : "");
    if (r->crease > 0) fprintf(out, ", \"creaseAngle\": \"%gdeg\"", r->crease);
    fputc('}', out);
}

/* The middle of the part along an axis, rounded to the precision of its single-precision
 * corners. */
static double known_middle(const mcv_rig_design *r, int axis) {
    const double largest = fmax(fabs(r->lower[axis]), fabs(r->upper[axis]));
    if (largest == 0) return 0;
    const double per_metre = pow(10, floor(-log10(largest * 0x1p-24)));
    return round(r->centre[axis] * per_metre) / per_metre + 0.0; /* + 0: no -0 */
}

static void print_rig(FILE *out, const mcv_rig_design *r, const char *uri) {
    const bool back = r->light.type == MCV_RIG_LIGHT_BACKLIGHT,
               is_laser = r->light.type == MCV_RIG_LIGHT_LASER;
    fprintf(out,
            "{\n  \"asset\": {\"version\": \"2.0\", \"generator\": \"mcvisi new %s\", \"extras\": "
            "{\"note\": \"",
            mcv_rig_kinds[r->wishes.kind]);
    print_note(out, r);
    fprintf(out,
            "\"}},\n  \"extensionsUsed\": [\"MCVISI_sensors\", \"MCVISI_emitters\", "
            "\"MCVISI_assets\", \"MCVISI_pose\"%s%s],\n",
            r->material[0] ? ", \"MCVISI_materials\"" : "",
            is_laser ? ", \"MCVISI_spectrum\"" : "");
    fprintf(out, "  \"extensions\": {\n    \"MCVISI_sensors\": {\n      \"sensors\": [\n        ");
    print_sensor(out, r);
    fprintf(out, "\n      ]\n    },\n    \"MCVISI_emitters\": {\n      \"emitters\": [\n        ");
    print_emitter(out, r);
    fprintf(out, "\n      ]\n    },\n    \"MCVISI_assets\": {\n      \"assets\": [\n        ");
    print_asset(out, r, uri);
    fprintf(out, "\n      ]\n    }");
    if (is_laser) /* metals and glass have its indices */
        fprintf(out, ",\n    \"MCVISI_spectrum\": {\"wavelengths\": \"%s\"}",
                length(MCV_RIG_WAVELENGTH));
    fprintf(out, "\n  },\n");
    if (r->material[0])
        fprintf(out,
                "  \"materials\": [\n    {\"name\": \"part\", \"extensions\": "
                "{\"MCVISI_materials\": %s}}\n  ],\n",
                r->material);
    fprintf(
        out,
        "  \"scene\": 0,\n  \"scenes\": [\n    {\"nodes\": [0, 1, 2, 3]}\n  ],\n  \"nodes\": [\n");
    fprintf(out,
            "    {\"name\": \"part\", \"extensions\": {\"MCVISI_assets\": {\"asset\": 0}}},\n");
    fprintf(out, "    {\"name\": \"centre\", \"translation\": [%.9g, %.9g, %.9g], ",
            known_middle(r, 0), known_middle(r, 1), known_middle(r, 2));
    fprintf(out, "\"extras\": {\"note\": \"The middle of the part, the target of camera and "
                 "light.\"}},\n");
    fprintf(out,
            "    {\"name\": \"camera\", \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}, ");
    const double aside = r->wishes.kind != MCV_RIG_LASER ? 0
                         : is_below(r)                   ? -MCV_RIG_ANGLE
                                                         : MCV_RIG_ANGLE;
    print_pose(out, r->working_distance, lens_digits(r), r->azimuth, r->elevation + aside, r->roll);
    fprintf(out,
            "}},\n    {\"name\": \"%s\", \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}, ",
            light_name(r));
    print_pose(out, r->light.distance, CHOSEN,
               back && fabs(r->elevation) < 90 ? r->azimuth - 180 : r->azimuth,
               back ? -r->elevation : r->elevation, r->roll);
    fprintf(out, "}}\n  ]\n}\n");
}

/* --- files --- */

static mcv_result check_output(const mcv_rig_design *r, const char *path, mcv_error *error) {
    if (strlen(path) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "the path of the rig is longer than %d bytes", PATH_MAX);
    if (!mcv_ends_in(path, ".gltf"))
        return mcv_fail(error, MCV_USAGE, "%s: the name of a rig must end in .gltf", path);
    if (mcv_same_file(path, r->wishes.part))
        return mcv_fail(error, MCV_USAGE, "%s is the part: give the rig another name", path);
    return mcv_output_check(path, error);
}

/* The part's path relative to the rig's folder, in or below which it must lie, so that a rig and
 * its parts move together. */
static mcv_result find_uri(const char *rig_path, const char *part_path, char uri[PATH_MAX],
                           mcv_error *error) {
    char copy[PATH_MAX], folder[PATH_MAX], file[PATH_MAX];
    snprintf(copy, sizeof copy, "%s", rig_path);
    if (!realpath(part_path, file))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", part_path, strerror(errno));
    if (!realpath(dirname(copy), folder))
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", rig_path, strerror(errno));
    size_t start = strlen(folder);
    if (start > 1) ++start; /* except for the root, the slash follows */
    if (strncmp(file, folder, start - 1) != 0 || file[start - 1] != '/')
        return mcv_fail(error, MCV_USAGE,
                        "%s does not lie in the folder of %s or below it: copy it there, or write "
                        "the rig beside it by -o",
                        part_path, rig_path);
    snprintf(uri, PATH_MAX, "%s", file + start);
    return MCV_OK;
}

/* A second `new` must not overwrite what people have edited. */
static mcv_result replace(const char *path, const char *text, size_t size, bool force,
                          mcv_error *error) {
    uint8_t *old;
    size_t old_size;
    if (!force && access(path, F_OK) == 0) {
        MCV_TRY(mcv_file_load(path, &old, &old_size, error));
        const bool same = old_size == size && memcmp(old, text, size) == 0;
        free(old);
        if (same) return MCV_OK;
        return mcv_fail(
            error, MCV_USAGE,
            "%s exists with other contents, perhaps edited: replace it by --force, or give "
            "another name by -o",
            path);
    }
    return mcv_output_whole(path, text, size, error);
}

mcv_result mcv_rig_text(const mcv_rig_design *r, const char *uri, char **text, size_t *size,
                        mcv_error *error) {
    *text = NULL;
    FILE *stream = open_memstream(text, size);
    if (stream) print_rig(stream, r, uri);
    if (mcv_text_close(stream, text)) return MCV_OK;
    mcv_fail(error, MCV_FAILED, "%s: no memory for a rig", r->wishes.part);
    return MCV_FAILED;
}

mcv_result mcv_rig_write(const mcv_rig_design *r, const char *path, bool force, mcv_error *error) {
    char uri[PATH_MAX] = "", *text;
    size_t size;
    MCV_TRY(check_output(r, path, error));
    MCV_TRY(find_uri(path, r->wishes.part, uri, error));
    MCV_TRY(mcv_rig_text(r, uri, &text, &size, error));
    const mcv_result result = replace(path, text, size, force, error);
    free(text);
    return result;
}
