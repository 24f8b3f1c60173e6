/* SPDX-License-Identifier: Apache-2.0 */
/* Findings about meshes: whether they are closed, and how well their facets approximate curved
 * surfaces. */
#include "check/facets.h"
#include "check/find.h"
#include "scene/transform.h"
#include "scene/geometry.h"
#include "scene/materials.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* --- open_body, thin_body --- */

static const mcv_material *material_of(const mcv_scene *scene, uint32_t instance) {
    return scene->materials + scene->instances[instance].material;
}

/* Does it transmit light as a sheet without thickness? */
static bool is_thin(const mcv_material *material) {
    return material->type == MCV_MATERIAL_SHEET ||
           (material->type == MCV_MATERIAL_METALLIC_ROUGHNESS &&
            material->as.metallic_roughness.transmission > 0);
}

mcv_result mcv_find_open_body(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t first = 0, last; first < scene->instance_count; first = last) {
        bool dielectric = false;
        last = mcv_body_end(scene, first);
        for (uint32_t i = first; i < last; ++i)
            dielectric = dielectric || mcv_material_has_medium(material_of(scene, i)->type);
        if (!dielectric) continue;
        uint32_t edges;
        char label[MCV_LABEL];
        MCV_TRY(mcv_open_edges(scene, first, last, &edges, error));
        if (edges > 0)
            MCV_TRY(mcv_findings_add(findings, MCV_SEVERITY_WARNING, "nodes",
                                     scene->instances[first].name, NULL, error,
                                     "%s: its mesh is open at %u edges, but its material fills a "
                                     "volume: close it, or use a sheet",
                                     mcv_instance_label(scene, first, label), edges));
    }
    return MCV_OK;
}

mcv_result mcv_find_thin_body(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_material *material = material_of(scene, i);
        uint32_t edges;
        if (!is_thin(material) || scene->meshes[scene->instances[i].mesh].triangle_count == 0)
            continue;
        MCV_TRY(mcv_open_edges(scene, i, i + 1, &edges, error));
        if (edges > 0) continue;
        char label[MCV_LABEL];
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "materials", material->name, NULL, error,
            "%s is a closed body, but its material \"%s\" is a thin sheet, which does not "
            "refract: give the asset a dielectric of the rig, as in \"materials\": {\"%s\": "
            "\"glass\"}, or export it with KHR_materials_volume and a thicknessFactor above 0 "
            "(in Blender the input Thickness of the node group glTF Material Output)",
            mcv_instance_label(scene, i, label), material->name, material->name));
    }
    return MCV_OK;
}

/* --- flat_glass, rounded_edge --- */

/* Bends of one kind on a body of glass. */
typedef struct bends {
    uint32_t count;
    double most;   /* the largest angle [rad] */
    double crease; /* the crease angle that fits the body [degrees] */
} bends;

/* Those whose normals have a step, or none, from an angle on; none of a body that is not glass. */
static mcv_result find_bends(const mcv_scene *scene, uint32_t instance, mcv_bend_kind kind,
                             bool faceted, double least, bends *found, mcv_error *error) {
    mcv_facets f;
    *found = (bends){0};
    if (material_of(scene, instance)->type != MCV_MATERIAL_DIELECTRIC) return MCV_OK;
    MCV_TRY(mcv_facets_of(scene, instance, &f, error));
    for (size_t k = 0; k < f.bend_count; ++k) {
        const mcv_bend *b = f.bends + k;
        if (b->kind != kind || b->faceted != faceted || b->angle < least) continue;
        ++found->count;
        found->most = fmax(found->most, b->angle);
    }
    found->crease = mcv_crease_degrees(mcv_facets_range(&f));
    mcv_facets_free(&f);
    return MCV_OK;
}

mcv_result mcv_find_flat_glass(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        bends faceted;
        char label[MCV_LABEL];
        MCV_TRY(find_bends(scene, i, MCV_BEND_CURVED, true, 0, &faceted, error));
        if (faceted.count < MCV_LEAST_BENDS) continue;
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "nodes", scene->instances[i].name, NULL, error,
            "%s is curved glass made of flat facets, with angles of up to %.3g degrees at %u "
            "edges: it refracts like many prisms, not like a lens; give its asset "
            "\"creaseAngle\": \"%gdeg\", or export a .glb with vertex normals (shade smooth)",
            mcv_instance_label(scene, i, label), faceted.most * 180 / M_PI, faceted.count,
            faceted.crease));
    }
    return MCV_OK;
}

mcv_result mcv_find_rounded_edge(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        bends rounded;
        char label[MCV_LABEL];
        MCV_TRY(find_bends(scene, i, MCV_BEND_EDGE, false, mcv_least_edge, &rounded, error));
        if (rounded.count < MCV_LEAST_BENDS) continue;
        MCV_TRY(mcv_findings_add(
            findings, MCV_SEVERITY_WARNING, "nodes", scene->instances[i].name, NULL, error,
            "the normals of %s round %u of its edges, which are bent by up to %.3g degrees: flat "
            "faces beside them refract like lenses; give its asset \"creaseAngle\": \"%gdeg\", or "
            "export a .glb whose normals part at edges",
            mcv_instance_label(scene, i, label), rounded.count, rounded.most * 180 / M_PI,
            rounded.crease));
    }
    return MCV_OK;
}

/* --- outline --- */

static const double tolerated = 0.1; /* of a pixel */

/* The height of a triangle over one of its edges [m]. */
static double height_over(const mcv_facets *f, uint32_t triangle, const double from[3],
                          const double to[3]) {
    double corners[3][3], most = 0;
    const double along[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]},
                 length = sqrt(mcv_dot3(along, along));
    mcv_scene_corners(f->scene, f->instance, triangle, corners);
    for (int k = 0; k < 3; ++k) {
        const double to_corner[3] = {corners[k][0] - from[0], corners[k][1] - from[1],
                                     corners[k][2] - from[2]};
        double cross[3];
        mcv_cross3(along, to_corner, cross);
        most = fmax(most, sqrt(mcv_dot3(cross, cross)) / length);
    }
    return most;
}

/*
 * The deviation of chords from the curve that they replace, at a bend seen from its side: w θ/8 for
 * facets of width w and angle θ. In pixels; 0 if it is outside the image or not at an outline.
 */
static double chord_error(const mcv_facets *f, const mcv_view *view, const mcv_bend *b,
                          double *metres) {
    double from[3], to[3], middle[3], film[2], local[3], sight[3], cosine[2];
    const double *m = view->sensor->to_world.m;
    mcv_scene_vertex(f->scene, f->instance, b->ends[0], from);
    mcv_scene_vertex(f->scene, f->instance, b->ends[1], to);
    for (int k = 0; k < 3; ++k) middle[k] = 0.5 * (from[k] + to[k]);
    if (!mcv_view_project(view, middle, film)) return 0;
    for (int i = 0; i < 2; ++i)
        if (film[i] < view->film[i][0] || film[i] > view->film[i][1]) return 0;
    const double axis[3] = {-m[2], -m[5], -m[8]},
                 ray[3] = {middle[0] - m[9], middle[1] - m[10], middle[2] - m[11]};
    if (!mcv_normalize3(view->is_telecentric ? axis : ray, sight)) return 0;
    for (int side = 0; side < 2; ++side)
        cosine[side] = mcv_dot3(f->normals[b->triangles[side]], sight);
    /* One facet faces the sensor and the other does not; or both are edge-on, up to rounding. */
    if (cosine[0] * cosine[1] > 0 && fmin(fabs(cosine[0]), fabs(cosine[1])) > mcv_flat) return 0;
    const double width =
        fmin(height_over(f, b->triangles[0], from, to), height_over(f, b->triangles[1], from, to));
    mcv_view_point(view, middle, local);
    *metres = width * b->angle / 8;
    return *metres / mcv_view_pixel(view, local[2]);
}

/* The depth of the farthest light that the sensor sees. Outlines before it are likely to be
 * measured. */
static double backlight_depth(const mcv_scene *scene, const mcv_view *view) {
    double depth = -INFINITY;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        if (scene->emitters[i].instance == MCV_NONE) continue;
        const mcv_extent extent = mcv_view_extent(view, scene, scene->emitters[i].instance);
        if (mcv_view_shows(view, &extent)) depth = fmax(depth, extent.depth[0]);
    }
    return depth;
}

/* The worst of one sensor's outlines. */
typedef struct worst_outline {
    double pixels, metres;
    uint32_t instance, parts; /* number of parts above the tolerance */
    bool backlit;
} worst_outline;

static void judge_outline(const mcv_facets *f, const mcv_view *view, worst_outline *worst) {
    double most = 0, most_metres = 0, metres = 0;
    for (size_t k = 0; k < f->bend_count; ++k) {
        const double off =
            f->bends[k].kind == MCV_BEND_CURVED ? chord_error(f, view, f->bends + k, &metres) : 0;
        if (off <= most) continue;
        most = off;
        most_metres = metres;
    }
    if (!(most > tolerated)) return;
    const mcv_extent extent = mcv_view_extent(view, f->scene, f->instance);
    worst->backlit = worst->backlit || backlight_depth(f->scene, view) >= extent.depth[1];
    ++worst->parts;
    if (most <= worst->pixels) return;
    worst->pixels = most;
    worst->metres = most_metres;
    worst->instance = f->instance;
}

static mcv_result report_outline(const mcv_scene *scene, const mcv_view *view,
                                 const worst_outline *worst, mcv_findings *findings,
                                 mcv_error *error) {
    char label[MCV_LABEL], others[64] = "", text[2][32];
    if (worst->parts > 1)
        snprintf(others, sizeof others, ", and %u parts by more than a tenth of one", worst->parts);
    return mcv_findings_add(
        findings, worst->backlit ? MCV_SEVERITY_WARNING : MCV_SEVERITY_NOTE, "nodes",
        scene->instances[worst->instance].name, NULL, error,
        "in the image of sensor \"%s\" chords replace curved outlines: %s deviates by up to "
        "%s, %.2g pixels%s; for measurements, export with a chord tolerance of %s or less, a "
        "tenth of a pixel",
        view->sensor->name, mcv_instance_label(scene, worst->instance, label),
        mcv_length_in_words(worst->metres, text[0]), worst->pixels, others,
        mcv_length_in_words(tolerated * worst->metres / worst->pixels, text[1]));
}

/* Has the instance an outline to be judged? */
static bool has_triangles(const mcv_scene *scene, uint32_t instance) {
    return scene->meshes[scene->instances[instance].mesh].triangle_count > 0;
}

/* Does a sensor see a part before a light? Without that an outline is worth a note at most. */
static bool some_backlit(const mcv_scene *scene) {
    for (uint32_t s = 0; s < scene->sensor_count; ++s) {
        const mcv_view view = mcv_view_of(scene->sensors + s);
        const double depth = backlight_depth(scene, &view);
        for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end);
             i < scene->instance_count && depth > -INFINITY; i = mcv_next_part(scene, i + 1, &end))
            if (has_triangles(scene, i) && depth >= mcv_view_extent(&view, scene, i).depth[1])
                return true;
    }
    return false;
}

mcv_result mcv_find_outline(const mcv_scene *scene, mcv_findings *findings, mcv_error *error) {
    mcv_result result = MCV_OK;
    if (findings->least > MCV_SEVERITY_NOTE && !some_backlit(scene)) return MCV_OK;
    worst_outline *worst = calloc((size_t)scene->sensor_count + 1, sizeof *worst);
    if (!worst)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for what its sensors see", scene->path);
    for (uint32_t end = 0, i = mcv_next_part(scene, 0, &end);
         i < scene->instance_count && result == MCV_OK; i = mcv_next_part(scene, i + 1, &end)) {
        mcv_facets f;
        if (!has_triangles(scene, i)) continue;
        result = mcv_facets_of(scene, i, &f, error);
        if (result != MCV_OK) break;
        for (uint32_t s = 0; f.curved_count >= MCV_LEAST_BENDS && s < scene->sensor_count; ++s) {
            const mcv_view view = mcv_view_of(scene->sensors + s);
            judge_outline(&f, &view, worst + s);
        }
        mcv_facets_free(&f);
    }
    for (uint32_t s = 0; s < scene->sensor_count && result == MCV_OK; ++s) {
        const mcv_view view = mcv_view_of(scene->sensors + s);
        if (worst[s].parts > 0) result = report_outline(scene, &view, worst + s, findings, error);
    }
    free(worst);
    return result;
}
