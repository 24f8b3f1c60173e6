/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a scene says that is likely not meant: sentences for people, each with a severity, the place
 * in the scene that it is about, the number that shows it and a remedy. Each rule is sure in what
 * it says; a scene without a finding may still be wrong.
 */
#ifndef MCVISI_HOST_ANALYSIS_FINDINGS_H
#define MCVISI_HOST_ANALYSIS_FINDINGS_H

#include "scene/scene.h"

/*
 * X(severity, NAME). Error: the picture cannot be the one that is wanted. Warning: likely it is
 * not. Note: it may matter to a measurement.
 */
#define MCV_SEVERITIES(X) \
    X(note, NOTE) \
    X(warning, WARNING) \
    X(error, ERROR)

typedef enum mcv_severity {
#define MCV_X(severity, NAME) MCV_SEVERITY_##NAME,
    MCV_SEVERITIES(MCV_X)
#undef MCV_X
} mcv_severity;
extern const char *const mcv_severities[];

typedef struct mcv_finding {
    mcv_severity severity;
    char *path;     /* as in --set, sensors/cam/pixelSize; "": the whole scene */
    char *sentence; /* without a full stop */
} mcv_finding;

typedef struct mcv_findings {
    mcv_finding *items;
    size_t count;
} mcv_findings;

/*
 * X(name), in the order in which they are looked for; each is a function mcv_find_NAME
 * (check/find.h).
 *
 * - unlit: emitters, flat ones and spots, whose light meets no mesh and no lens of a sensor;
 *   others are not judged
 * - hidden: flat emitters behind a sensor, whose body would block their light; those whose back a
 *   sensor's axis meets
 * - bare_angle: cones of 0.1 rad or more, given as a number of one or two digits without a unit:
 *   degrees may be meant
 * - sees_nothing: sensors before which there is no mesh, without an environment
 * - outside: sensors with no part in their field though the scene has parts
 * - defocus: sensors for which all parts in their field are blurred over more than 3 pixels
 * - large_pixel: pixels above 0.1 mm whose field is more than 10 times as wide as the widest part
 * - unit: parts more than 100 times as wide as a field in focus; fields wider than 10 m; all parts
 *   together smaller than what a pixel sees of it
 * - open_body: nodes of a dielectric whose triangles have edges without a partner
 * - flat_glass: curved bodies of a dielectric with flat facets
 * - thin_body: closed meshes of a material that stands for a thin pane
 * - outline: meshes whose chords at an outline in the picture are off their curve by more than a
 *   tenth of a pixel
 * - growth: silhouettes before a backlight, by how much their edges grow (check/growth.h)
 * - extras: those of the scene's files, which nothing reads
 *
 * A part is an instance that neither emits nor belongs to a light.
 */
#define MCV_FINDINGS(X) \
    X(unlit) \
    X(hidden) \
    X(bare_angle) \
    X(sees_nothing) \
    X(outside) \
    X(defocus) \
    X(large_pixel) \
    X(unit) \
    X(open_body) \
    X(flat_glass) \
    X(thin_body) \
    X(outline) \
    X(growth) \
    X(extras)

/* The loader's warnings, then what the list above finds. Fails only without memory. Freed by
 * mcv_findings_free. */
mcv_result mcv_findings_of(const mcv_scene *scene, mcv_findings *findings, mcv_error *error);

/* Adds one: path kind/name/key; key may be NULL, and a name that is empty is left out. Fails only
 * without memory. */
mcv_result mcv_findings_add(mcv_findings *findings, mcv_severity severity, const char *kind,
                            const char *name, const char *key, mcv_error *error, const char *format,
                            ...) __attribute__((format(printf, 7, 8)));

void mcv_findings_free(mcv_findings *findings);

/* Counts the edges of instances [first, last), taken together, that have no partner. Fails only
 * without memory. */
mcv_result mcv_open_edges(const mcv_scene *scene, uint32_t first, uint32_t last, uint32_t *edges,
                          mcv_error *error);

/* An edge that two triangles of a mesh share, welded where positions are equal: each runs along it
 * the other way. */
typedef struct mcv_shared_edge {
    uint32_t triangles[2];
    uint32_t ends[2][2]; /* [triangle][from, to as the first runs]: vertices of the mesh */
} mcv_shared_edge;

/* *edges is malloc'ed. Edges of one triangle, or of more than two, are left out. Fails only without
 * memory. */
mcv_result mcv_shared_edges(const mcv_mesh *mesh, mcv_shared_edge **edges, size_t *count,
                            mcv_error *error);

#endif
