/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is probably wrong with a scene. A finding is a sentence for people, or a few: it names the
 * number that shows the fault, and a remedy. It also has a severity and a path into the scene. Each
 * rule is certain of its statement; a scene without findings may still be wrong.
 */
#ifndef MCVISI_HOST_CHECK_FINDINGS_H
#define MCVISI_HOST_CHECK_FINDINGS_H

#include "scene/scene.h"

/*
 * X(severity, NAME). Error: the image cannot be as intended. Warning: it probably is not. Note: it
 * may affect a measurement.
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
    char *sentence; /* without a full stop at the end */
} mcv_finding;

typedef struct mcv_findings {
    mcv_finding *items;
    size_t count;
    mcv_severity least; /* of what is looked for and kept */
} mcv_findings;

/*
 * X(name): the findings, in the order of the search. Each is a function mcv_find_NAME
 * (check/find.h).
 *
 * - unlit: flat emitters and spots whose light reaches no mesh and no lens of a sensor
 * - hidden: flat emitters behind a sensor, whose body would block their light; flat emitters whose
 *   back a sensor's axis hits
 * - bare_angle: cones of 0.1 rad or more, given as a number of one or two digits without a unit,
 *   which was probably meant in degrees
 * - sees_nothing: sensors with no mesh before them, in scenes without an environment
 * - outside: sensors with no part in their field, in scenes that have parts
 * - defocus: sensors for which all parts in their field are blurred over more than 3 pixels
 * - large_pixel: pixels above 0.1 mm whose field is more than 10 times as wide as the widest part
 * - unit: parts more than 100 times as wide as a field in focus; fields wider than 10 m; parts that
 *   all are smaller than one pixel
 * - open_body: nodes of a dielectric with edges that no other triangle shares
 * - flat_glass: curved bodies of a dielectric with flat facets
 * - rounded_edge: edges of a dielectric between its curves and flat faces, with normals that join
 *   them
 * - thin_body: closed meshes of a material for thin sheets
 * - outline: meshes whose chords, at an outline in the image, deviate from the curve by more than a
 *   tenth of a pixel
 * - small_defect: defects below two wavelengths, or below a hundredth of a pixel
 * - wavelength: beams of a flying spot scanner, or lasers as the only light, at another wavelength
 *   than the materials' indices
 * - layer: metallicRoughness whose layer lacks 2 % of the light or more, in even light or at 80°
 * - rough_glass: glass of α below 0.1, or brushed, off in single directions by more than 1 %
 * - head: laser triangulation heads whose scan would be refused, or whose heights would be none
 * - growth: silhouettes before a backlight, with the growth of their edges (check/growth.h)
 * - extras: extras of the scene's files, which are ignored
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
    X(rounded_edge) \
    X(thin_body) \
    X(outline) \
    X(small_defect) \
    X(wavelength) \
    X(layer) \
    X(rough_glass) \
    X(head) \
    X(growth) \
    X(extras)

/* The loader's warnings, then the findings of the list above. Fails only without memory. To be
 * freed by mcv_findings_free. */
mcv_result mcv_findings_of(const mcv_scene *scene, mcv_findings *findings, mcv_error *error);

/* The same without notes: what only notes would need is not computed, such as the outlines of parts
 * before no light. */
mcv_result mcv_warnings_of(const mcv_scene *scene, mcv_findings *findings, mcv_error *error);

/* Adds a finding with the path kind/name/key, if it is severe enough; key may be NULL, and an empty
 * name is omitted. Fails only without memory. */
mcv_result mcv_findings_add(mcv_findings *findings, mcv_severity severity, const char *kind,
                            const char *name, const char *key, mcv_error *error, const char *format,
                            ...) __attribute__((format(printf, 7, 8)));

void mcv_findings_free(mcv_findings *findings);

/* Counts the edges of the instances [first, last) together that no other triangle shares. Fails
 * only without memory. */
mcv_result mcv_open_edges(const mcv_scene *scene, uint32_t first, uint32_t last, uint32_t *edges,
                          mcv_error *error);

/* An edge that two triangles of a mesh share, in opposite directions. Vertices at equal positions
 * are welded. */
typedef struct mcv_shared_edge {
    uint32_t triangles[2];
    uint32_t ends[2][2]; /* [triangle][from, to, in the direction of the first one]: vertices of the
                            mesh */
} mcv_shared_edge;

/* *edges is malloc'ed. Edges of one triangle, or of more than two, are omitted. Fails only without
 * memory. */
mcv_result mcv_shared_edges(const mcv_mesh *mesh, mcv_shared_edge **edges, size_t *count,
                            mcv_error *error);

#endif
