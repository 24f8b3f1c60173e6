/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Triangles with their own corners, while a defect refines them.
 *
 * All decisions about an edge depend on the positions of its ends alone. The triangles on either
 * side thus make the same ones without knowing each other, also across the seams of vertices and of
 * primitives: a mesh that is watertight stays so.
 */
#ifndef MCVISI_HOST_DEFECTS_FACETS_H
#define MCVISI_HOST_DEFECTS_FACETS_H

#include "defects/defects.h"

/* A vertex with all that a mesh may say of it, in the instance's frame. */
typedef struct mcv_corner {
    float position[3], normal[3], texcoord[2], texcoord1[2], tangent[4];
} mcv_corner;

typedef struct mcv_facet {
    mcv_corner corners[3];
    uint32_t instance;
    bool inside;   /* part of the surface that the defect lies on, not of what lies behind */
    bool within;   /* the outline */
    uint8_t fixed; /* bit k: corner k lies on the outline and must stay there */
} mcv_facet;

typedef struct mcv_facets {
    mcv_facet *items;
    size_t count, room;
} mcv_facets;

/* A triangle of an instance with its own corners, in the order of the mesh; with the normal of the
 * face where the mesh is flat. */
mcv_facet mcv_facet_take(const mcv_scene *scene, uint32_t instance, uint32_t triangle);

/* False without memory. */
bool mcv_facets_add(mcv_facets *facets, const mcv_facet *facet);

/* The ground that a defect lies on: its frame, and how far the surface there reaches along the
 * normal. */
typedef struct mcv_ground {
    const mcv_scene *scene;
    const mcv_defect *defect;
    mcv_footprint footprint;
    mcv_known_meshes *known;
    double low, high; /* along the normal, from the centre [m] */
} mcv_ground;

mcv_ground mcv_ground_of(const mcv_scene *scene, mcv_known_meshes *known, const mcv_defect *defect);

/* A position in the instance's frame as u, v and height above the tangent plane. */
void mcv_ground_point(const mcv_ground *ground, uint32_t instance, const float position[3],
                      double local[3]);

/* The distance in the tangent plane between the footprint's segment and that from a to b, or a
 * triangle. */
double mcv_ground_edge_distance(const mcv_ground *ground, const double a[3], const double b[3]);
double mcv_ground_triangle_distance(const mcv_ground *ground, const double corners[3][3]);

/* A quick look: is all that lies within `reach` of p farther than `beyond` from the footprint?
 * False may be wrong, true is not. */
bool mcv_ground_is_far(const mcv_ground *ground, const double p[3], double reach, double beyond);

/* Beyond the fine part edges may grow by this share of their distance. */
#define MCV_GRADING 0.5

/* Must the edge between two corners be halved? */
bool mcv_ground_splits(const mcv_ground *ground, uint32_t instance, const mcv_corner *a,
                       const mcv_corner *b);

/* The corner at the share t of the way from a to b. */
mcv_corner mcv_corner_between(const mcv_corner *a, const mcv_corner *b, double t);

/* -1, 0 or 1: an order of positions, in which both sides of an edge run along it. */
int mcv_corner_compare(const mcv_corner *a, const mcv_corner *b);

/* Whether no edge of the triangle need be halved, at a quick look: true is right. */
bool mcv_ground_spares(const mcv_ground *ground, uint32_t instance, uint32_t triangle);

/* The same of all edges in a box. */
bool mcv_ground_spares_box(const mcv_ground *ground, uint32_t instance, const mcv_box *box);

/* Halves edges of the facet until none is too long; appends what remains. MCV_BAD_INPUT where there
 * are more than a defect may have, or than the scene's memory has room for. */
mcv_result mcv_facets_refine(mcv_facets *facets, const mcv_ground *ground, const mcv_facet *facet,
                             const mcv_json_path *place, mcv_error *error);

/* Triangles of instances, in their order. */
typedef struct mcv_mark {
    uint32_t instance, triangle;
} mcv_mark;

typedef struct mcv_marks {
    mcv_mark *items;
    size_t count, room;
} mcv_marks;

/* False without memory. */
bool mcv_marks_add(mcv_marks *marks, uint32_t instance, uint32_t triangle);

/* The triangles of the defect's instances that its footprint reaches on its own surface are added
 * to marks, unless these are NULL. Fails where that surface turns away. Sets low and high. */
mcv_result mcv_ground_find(mcv_ground *ground, mcv_marks *marks, const mcv_json_path *place,
                           mcv_error *error);

/* outline.c: cuts the facets of the surface along the outline and tells which lie within. Fails
 * where what a cut takes away is no height over its face. */
mcv_result mcv_facets_cut(mcv_facets *facets, const mcv_ground *ground, const mcv_json_path *place,
                          mcv_error *error);

/* move.c: moves corner k of a facet as the defect does, and turns its normal. */
void mcv_facet_move(const mcv_ground *ground, mcv_facet *facet, int k);

/* inside.c: adds the exact surfaces of a defect inside of a body. */
mcv_result mcv_defect_embed(mcv_scene *scene, const mcv_defect *defect, mcv_error *error);

/* Replaces the mesh of an instance: its triangles without those that are marked, and the facets of
 * this instance; of a patch, those that are not within it. */
mcv_result mcv_facets_replace(const mcv_facets *facets, mcv_scene *scene, uint32_t instance,
                              const uint8_t *marks, const mcv_defect *defect,
                              const mcv_json_path *place, mcv_error *error);

/* patch.c: the facets of the instance within a patch become an instance behind it, of their own
 * material. Call it before mcv_facets_edit. `alone`: all other triangles are gone. Fails where
 * the patch would cover all of the instance, or lies on glass. */
mcv_result mcv_facets_add_patch(const mcv_facets *facets, mcv_scene *scene, uint32_t instance,
                                bool alone, const mcv_defect *defect, const mcv_json_path *place,
                                mcv_error *error);

/* edit.c: the same as mcv_facets_replace, with the marks of this instance, in the time of the
 * facets where the mesh has been replaced before. */
mcv_result mcv_facets_edit(const mcv_facets *facets, mcv_scene *scene, mcv_known_meshes *known,
                           uint32_t instance, const mcv_marks *marks, const mcv_defect *defect,
                           const mcv_json_path *place, mcv_error *error);

/* Makes a mesh, in the way of the instance's own, of its triangles without those that are marked
 * (NULL: of none), and of the facets of the instance that are (`of_patch`) or are not within the
 * patch. */
mcv_result mcv_facets_mesh(const mcv_facets *facets, const mcv_scene *scene, uint32_t instance,
                           const uint8_t *marks, bool patch, bool of_patch, mcv_mesh *mesh,
                           const mcv_json_path *place, mcv_error *error);

#endif
