/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi new: a rig around a part, with standard optics and a light, written for people to read and edit. */
#include "cli/options.h"
#include "core/basics.h"
#include "output/file.h"
#include "scene/load.h"
#include "scene/params.h"

#include <ctype.h>
#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A common film of 1.3 megapixels, 6.1 mm x 4.9 mm. */
enum { COLUMNS = 1280, ROWS = 1024, DIRECTIONS = 8 };
static const double pixel = 4.8e-6;
static const double margin = 1.15; /* field over part */

enum { TELECENTRIC, ENTOCENTRIC, LIGHT_FIELD };
static const char *const kinds[] = {"telecentric", "entocentric", "lightfield"};

/* The part as its file has it, in metres. */
typedef struct part {
    const char *path;
    const char *unit;
    bool stl;
    double lower[3], upper[3];
    uint32_t triangles;
} part;

/* What is chosen; lengths in metres. */
typedef struct rig {
    int kind;
    double centre[3], across[2], depth; /* of the part, as the camera sees it: the longer side is horizontal */
    double azimuth, elevation, roll;    /* of the camera [degrees] */
    double magnification, focal_length, working_distance, f_number;
    double field[2];
} rig;

/* --- the part --------------------------------------------------------------------------------------------------- */

static void add_points(part *p, const mcv_mesh *mesh, const mcv_transform *to_world, double unit) {
    for (size_t v = 0; v < mesh->vertex_count; ++v) {
        const float *from = mesh->positions + 3 * v;
        double world[3];
        mcv_transform_point(to_world, (const double[3]){from[0], from[1], from[2]}, world);
        for (int i = 0; i < 3; ++i) {
            p->lower[i] = fmin(p->lower[i], unit * world[i]);
            p->upper[i] = fmax(p->upper[i], unit * world[i]);
        }
    }
    p->triangles += mesh->triangle_count;
}

static mcv_result read_stl(part *p, double unit, mcv_error *error) {
    const mcv_place place = mcv_place_file(p->path);
    const mcv_transform identity = mcv_transform_identity();
    mcv_bytes bytes;
    uint32_t mesh;
    double size[3];
    mcv_scene *scene = mcv_scene_new(p->path);
    if (!scene) return mcv_fail_memory(&place, error);
    mcv_result result = mcv_file_read(p->path, &bytes, &place, error);
    if (result == MCV_OK) {
        result = mcv_load_stl(scene, bytes, "part", &mesh, size, &place, error);
        free(bytes.data);
    }
    if (result == MCV_OK) add_points(p, scene->meshes + mesh, &identity, unit);
    mcv_scene_free(scene);
    if (result == MCV_OK && !p->unit)
        return mcv_fail(error, MCV_USAGE,
                        "%s: an .stl file does not tell its unit: the part is %.4g x %.4g x %.4g of it; give --unit, most are in mm",
                        p->path, size[0], size[1], size[2]);
    return result;
}

static mcv_result read_gltf(part *p, double unit, mcv_error *error) {
    mcv_scene *scene;
    MCV_TRY(mcv_scene_load(p->path, (mcv_overrides){NULL, 0}, &scene, error));
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        add_points(p, scene->meshes + scene->instances[i].mesh, &scene->instances[i].to_world, unit);
    mcv_scene_free(scene);
    return p->triangles ? MCV_OK : mcv_fail(error, MCV_BAD_INPUT, "%s: holds no mesh to look at", p->path);
}

static mcv_result read_part(const mcv_command *command, part *p, mcv_error *error) {
    double unit = 1;
    char one[32];
    *p = (part){.path = command->second,
                .unit = command->unit,
                .stl = mcv_ends_in(command->second, ".stl"),
                .lower = {INFINITY, INFINITY, INFINITY},
                .upper = {-INFINITY, -INFINITY, -INFINITY}};
    if (!p->stl && !mcv_ends_in(p->path, ".glb") && !mcv_ends_in(p->path, ".gltf"))
        return mcv_fail(error, MCV_USAGE, "%s: must be a .gltf, .glb or .stl file: %s", p->path, mcv_conversion(p->path));
    if (p->unit) {
        snprintf(one, sizeof one, "1%.16s", p->unit);
        if (!isalpha((unsigned char)p->unit[0]) || !mcv_parse_quantity(one, MCV_PARAM_length, &unit))
            return mcv_fail(error, MCV_USAGE, "--unit %s: must be one of nm, um, mm, cm, m", p->unit);
    }
    MCV_TRY(p->stl ? read_stl(p, unit, error) : read_gltf(p, unit, error));
    double largest = 0;
    for (int i = 0; i < 3; ++i) largest = fmax(largest, p->upper[i] - p->lower[i]);
    return largest > 0 ? MCV_OK : mcv_fail(error, MCV_BAD_INPUT, "%s: all of it is one point", p->path);
}

/* --- choosing --------------------------------------------------------------------------------------------------- */

/* The next number of this series of a decade at or above x, or below it. */
static double standard(double x, bool above) {
    static const double series[] = {1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10};
    enum { COUNT = sizeof series / sizeof series[0] };
    const double decade = pow(10, floor(log10(x) + 1e-12));
    const double tiny = 1e-9; /* what is a member of the series but for rounding stays */
    for (int i = 0; i < COUNT && above; ++i)
        if (series[i] * decade >= x * (1 - tiny)) return series[i] * decade;
    for (int i = COUNT; i-- > 0 && !above;)
        if (series[i] * decade <= x * (1 + tiny)) return series[i] * decade;
    return above ? 10 * decade : decade;
}

/* Along the part's shortest side, so that the largest is seen; the longer of what is seen lies horizontally. */
static void look(rig *r, const part *p) {
    double size[3];
    int axis = 2;
    for (int i = 0; i < 3; ++i) {
        size[i] = p->upper[i] - p->lower[i];
        r->centre[i] = 0.5 * (p->lower[i] + p->upper[i]);
    }
    for (int i = 2; i >= 0; --i)
        if (size[i] < size[axis] * (1 - 1e-6)) axis = i;
    r->azimuth = axis == 0 ? 90 : 0;
    r->elevation = axis == 1 ? 90 : 0;
    const double horizontal = size[axis == 0 ? 2 : 0], vertical = size[axis == 1 ? 2 : 1];
    r->roll = vertical > horizontal ? 90 : 0;
    r->across[0] = fmax(horizontal, vertical);
    r->across[1] = fmin(horizontal, vertical);
    r->depth = size[axis];
}

/*
 * The smallest of the usual f-numbers at which all of the part is blurred by a pixel at most: a depth z from the plane in focus is
 * blurred by z m²/N in the image, to first order. The largest where none is enough.
 */
static double choose_f_number(const rig *r) {
    static const double usual[] = {4, 5.6, 8, 11, 16};
    enum { COUNT = sizeof usual / sizeof usual[0] };
    const double m = r->magnification;
    for (int i = 0; i < COUNT; ++i)
        if (0.5 * r->depth * m * m / usual[i] <= pixel) return usual[i];
    return usual[COUNT - 1];
}

static void choose_telecentric(rig *r) {
    r->magnification = standard(fmin(COLUMNS * pixel / r->field[0], ROWS * pixel / r->field[1]), false);
    r->field[0] = COLUMNS * pixel / r->magnification;
    r->field[1] = ROWS * pixel / r->magnification;
    r->working_distance = standard(fmax(2 * r->field[0], 2 * r->depth), true);
    r->focal_length = r->working_distance * r->magnification / (1 + r->magnification);
    r->f_number = choose_f_number(r);
}

/* The nearest face of the part must fit: the field there is (W - depth/2)/W of that in focus. */
static void choose_entocentric(rig *r) {
    static const double usual[] = {4e-3, 6e-3, 8e-3, 12e-3, 16e-3, 25e-3, 35e-3, 50e-3, 75e-3, 100e-3};
    enum { COUNT = sizeof usual / sizeof usual[0] };
    const double nearest = 3; /* fields away, for a mild perspective */
    const double scale = fmax(r->field[0] / (COLUMNS * pixel), r->field[1] / (ROWS * pixel));
    for (int i = 0; i < COUNT; ++i) {
        const double f = usual[i];
        /* W - depth/2 = scale b with b = W f/(W - f): the larger root of W² - (scale f + f + depth/2) W + f depth/2 = 0. */
        const double half = 0.5 * r->depth, p = 0.5 * (scale * f + f + half);
        r->focal_length = f;
        r->working_distance = p + sqrt(fmax(0, p * p - f * half));
        if (r->working_distance >= nearest * r->field[0] + r->depth) break;
    }
    r->magnification = r->focal_length / (r->working_distance - r->focal_length);
    r->field[0] = COLUMNS * pixel / r->magnification;
    r->field[1] = ROWS * pixel / r->magnification;
    r->f_number = r->kind == LIGHT_FIELD ? 4 : choose_f_number(r);
}

static mcv_result choose(rig *r, const part *p, mcv_error *error) {
    look(r, p);
    for (int i = 0; i < 2; ++i) r->field[i] = margin * fmax(r->across[i], 1e-3 * r->across[0]);
    if (r->kind == TELECENTRIC)
        choose_telecentric(r);
    else
        choose_entocentric(r);
    if (r->magnification > 1e-6 && r->magnification < 1e4 && r->working_distance - 0.5 * r->depth > r->focal_length) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s: no usual lens sees a part of %.3g m x %.3g m x %.3g m: is --unit right, which is %s?",
                    p->path, r->across[0], r->across[1], r->depth, p->unit ? p->unit : "m by default");
}

/* --- writing ---------------------------------------------------------------------------------------------------- */

/* "12.5mm": four digits in the unit that suits. Three of them are on their way to printf at most. */
static const char *length(double metres) {
    static char texts[4][32];
    static int next;
    char *text = texts[next++ % 4];
    const char *unit = metres >= 1 ? "m" : metres >= 1e-3 ? "mm" : "um";
    snprintf(text, sizeof texts[0], "%.4g%s", metres * (metres >= 1 ? 1 : metres >= 1e-3 ? 1e3 : 1e6), unit);
    return text;
}

static void print_sensor(FILE *out, const rig *r) {
    if (r->kind == TELECENTRIC)
        fprintf(out, "{\"name\": \"camera\", \"type\": \"telecentric\", \"magnification\": %.6g, \"workingDistance\": \"%s\", ",
                r->magnification, length(r->working_distance));
    else
        fprintf(out, "{\"name\": \"camera\", \"type\": \"%s\", \"focalLength\": \"%s\", \"focusDistance\": \"%s\", ",
                r->kind == LIGHT_FIELD ? "lightField" : "thinLens", length(r->focal_length), length(r->working_distance));
    if (r->kind == LIGHT_FIELD)
        fprintf(out, "\"fNumber\": %g,\n         \"spatialResolution\": [%d, %d], \"angularResolution\": [%d, %d], ", r->f_number,
                COLUMNS / DIRECTIONS, ROWS / DIRECTIONS, DIRECTIONS, DIRECTIONS);
    else
        fprintf(out, "\"fNumber\": %g,\n         \"resolution\": [%d, %d], ", r->f_number, COLUMNS, ROWS);
    fprintf(out, "\"pixelSize\": \"%s\", \"radiometry\": \"irradiance\"}", length(pixel));
}

/* Of a telecentric camera a backlight, whose cone is a little wider than what the camera takes in; else a ring about the view. */
static void print_emitter(FILE *out, const rig *r, double distance) {
    if (r->kind == TELECENTRIC) {
        const double degrees = asin(fmin(1, r->magnification / (2 * r->f_number))) * 57.29577951308232;
        fprintf(out,
                "{\"name\": \"light\", \"type\": \"parallel\", \"size\": [\"%s\", \"%s\"], \"halfAngle\": \"%.4gdeg\", \"radiance\": 1}",
                length(1.2 * r->field[0]), length(1.2 * r->field[1]), fmin(90, standard(1.2 * degrees, true)));
        return;
    }
    /* The view is a cone from the field to the lens. */
    const double field = hypot(r->field[0], r->field[1]);
    const double lens = r->focal_length * (1 + r->magnification) / r->f_number * (r->kind == LIGHT_FIELD ? 1.4142135623730951 : 1);
    const double share = distance / r->working_distance, inner = standard(1.1 * (field * (1 - share) + lens * share), true);
    fprintf(out, "{\"name\": \"light\", \"type\": \"ring\", \"innerDiameter\": \"%s\", \"outerDiameter\": \"%s\", \"radiance\": 1}",
            length(inner), length(1.6 * inner));
}

static void print_pose(FILE *out, double distance, double azimuth, double elevation, double roll) {
    fprintf(out, "\"MCVISI_pose\": {\"target\": \"centre\", \"distance\": \"%s\", \"azimuth\": \"%gdeg\", \"elevation\": \"%gdeg\"",
            length(distance), azimuth + 0.0, elevation + 0.0); /* + 0: no -0 */
    fprintf(out, ", \"roll\": \"%gdeg\"}", roll);
}

/* The uri: of a path, what is not plain is percent-encoded. */
static void print_uri(FILE *out, const char *path) {
    for (const unsigned char *c = (const unsigned char *)path; *c; ++c)
        if (isalnum(*c) || strchr("-._~/", *c))
            fputc(*c, out);
        else
            fprintf(out, "%%%02X", *c);
}

static void print_rig(FILE *out, const rig *r, const part *p, const char *uri) {
    static const char *const words[] = {
        "A telecentric camera before a backlight: silhouettes that do not grow with nearness, for measuring.",
        "A camera with a thin lens, and a ring light about its view.",
        "A light field camera: each macro pixel holds 8 x 8 directions; a ring light is about its view."};
    const bool back = r->kind == TELECENTRIC;
    const double light = back ? 0.5 * r->depth + 0.5 * r->field[0] : 0.5 * (r->working_distance + 0.5 * r->depth);
    fprintf(out, "{\n  \"asset\": {\"version\": \"2.0\", \"generator\": \"mcvisi new %s\", \"extras\": {\"note\": \"%s ", kinds[r->kind],
            words[r->kind]);
    fprintf(out, "The part is %s x %s across and %s deep, ", length(r->across[0]), length(r->across[1]), length(r->depth));
    fprintf(out, "the field in focus %s x %s. Lengths: metres, or texts with a unit.\"}},\n", length(r->field[0]), length(r->field[1]));
    fprintf(out, "  \"extensionsUsed\": [\"MCVISI_sensors\", \"MCVISI_emitters\", \"MCVISI_assets\", \"MCVISI_pose\"%s],\n",
            p->stl ? ", \"MCVISI_materials\"" : "");
    fprintf(out, "  \"extensions\": {\n    \"MCVISI_sensors\": {\n      \"sensors\": [\n        ");
    print_sensor(out, r);
    fprintf(out, "\n      ]\n    },\n    \"MCVISI_emitters\": {\n      \"emitters\": [\n        ");
    print_emitter(out, r, light);
    fprintf(out, "\n      ]\n    },\n    \"MCVISI_assets\": {\n      \"assets\": [\n        {\"name\": \"part\", \"uri\": \"");
    print_uri(out, uri);
    fprintf(out, "\"%s%s%s%s}\n      ]\n    }\n  },\n", p->unit ? ", \"unit\": \"" : "", p->unit ? p->unit : "", p->unit ? "\"" : "",
            p->stl ? ", \"material\": \"part\"" : "");
    if (p->stl)
        fprintf(out, "  \"materials\": [\n    {\"name\": \"part\", \"extensions\": {\"MCVISI_materials\": {\"type\": \"diffuse\", "
                     "\"reflectance\": 0.5}}}\n  ],\n");
    fprintf(out, "  \"scene\": 0,\n  \"scenes\": [\n    {\"nodes\": [0, 1, 2, 3]}\n  ],\n  \"nodes\": [\n");
    fprintf(out, "    {\"name\": \"part\", \"extensions\": {\"MCVISI_assets\": {\"asset\": 0}}},\n");
    fprintf(out, "    {\"name\": \"centre\", \"translation\": [%.9g, %.9g, %.9g], ", r->centre[0], r->centre[1], r->centre[2]);
    fprintf(out, "\"extras\": {\"note\": \"The middle of the part, at which camera and light look.\"}},\n");
    fprintf(out, "    {\"name\": \"camera\", \"extensions\": {\"MCVISI_sensors\": {\"sensor\": 0}, ");
    print_pose(out, r->working_distance, r->azimuth, r->elevation, r->roll);
    fprintf(out, "}},\n    {\"name\": \"light\", \"extensions\": {\"MCVISI_emitters\": {\"emitter\": 0}, ");
    print_pose(out, light, back && r->elevation == 0 ? r->azimuth - 180 : r->azimuth, back ? -r->elevation : r->elevation, r->roll);
    fprintf(out, "}}\n  ]\n}\n");
}

/* --- files ------------------------------------------------------------------------------------------------------ */

/* PART-telecentric.gltf beside the part, unless --output names it. */
static mcv_result plan_output(const mcv_command *command, int kind, char path[PATH_MAX], mcv_error *error) {
    const char *part_path = command->second, *dot = strrchr(part_path, '.');
    const int stem = (int)(dot ? dot - part_path : (long)strlen(part_path));
    const int length_of = command->rig ? snprintf(path, PATH_MAX, "%s", command->rig)
                                       : snprintf(path, PATH_MAX, "%.*s-%s.gltf", stem, part_path, kinds[kind]);
    if (length_of >= PATH_MAX) return mcv_fail(error, MCV_USAGE, "the path of the rig is longer than %d bytes", PATH_MAX);
    if (!mcv_ends_in(path, ".gltf")) return mcv_fail(error, MCV_USAGE, "%s: the name of a rig must end in .gltf", path);
    if (mcv_same_file(path, part_path)) return mcv_fail(error, MCV_USAGE, "%s is the part: give the rig another name", path);
    return mcv_output_check(path, error);
}

/* The part's path from the rig's folder, in or below which it must lie: a rig and its parts move together. */
static mcv_result find_uri(const char *rig_path, const char *part_path, char uri[PATH_MAX], mcv_error *error) {
    char copy[PATH_MAX], folder[PATH_MAX], file[PATH_MAX];
    snprintf(copy, sizeof copy, "%s", rig_path);
    if (!realpath(part_path, file)) return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", part_path, strerror(errno));
    if (!realpath(dirname(copy), folder)) return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", rig_path, strerror(errno));
    size_t start = strlen(folder);
    if (start > 1) ++start; /* but for the root, the slash comes behind it */
    if (strncmp(file, folder, start - 1) != 0 || file[start - 1] != '/')
        return mcv_fail(error, MCV_USAGE,
                        "%s does not lie in the folder of %s or below it: copy it there, or write the rig beside it by -o", part_path,
                        rig_path);
    snprintf(uri, PATH_MAX, "%s", file + start);
    return MCV_OK;
}

static void print_choice(const rig *r, const part *p, const char *path) {
    printf("%s\n  part            %s x %s x %s, %u triangles\n", path, length(r->across[0]), length(r->across[1]), length(r->depth),
           p->triangles);
    if (r->kind == TELECENTRIC)
        printf("  lens            telecentric, magnification %.4g, f/%g, working distance %s\n", r->magnification, r->f_number,
               length(r->working_distance));
    else
        printf("  lens            %s f/%g (working), focused at %s\n", length(r->focal_length), r->f_number, length(r->working_distance));
    printf("  field of view   %s x %s\n", length(r->field[0]), length(r->field[1]));
    if (r->magnification < 1e-3 || r->magnification > 100)
        fprintf(stderr, "mcvisi: warning: %s: a magnification of %.3g is unusual: is --unit right, which is %s?\n", p->path,
                r->magnification, p->unit ? p->unit : "m by default");
}

mcv_result mcv_verb_new(const mcv_command *command, mcv_error *error) {
    char path[PATH_MAX], uri[PATH_MAX] = "";
    part p;
    rig r = {.kind = -1};
    for (int i = 0; i < 3; ++i)
        if (strcmp(command->argument, kinds[i]) == 0) r.kind = i;
    if (r.kind < 0)
        return mcv_fail(error, MCV_USAGE, "new %s: must be `new telecentric`, `new entocentric` or `new lightfield`", command->argument);
    MCV_TRY(read_part(command, &p, error));
    MCV_TRY(plan_output(command, r.kind, path, error));
    MCV_TRY(find_uri(path, p.path, uri, error));
    MCV_TRY(choose(&r, &p, error));
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (!stream) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    print_rig(stream, &r, &p, uri);
    const bool written = fclose(stream) == 0;
    const mcv_result result =
        written ? mcv_output_whole(path, text, size, error) : mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    free(text);
    if (result == MCV_OK) print_choice(&r, &p, path);
    return result;
}
