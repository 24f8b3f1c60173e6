/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scene's triangles in the world, in double, under a binary tree of boxes. Those that move have
 * a tree of their own, for the time 0, to which rays are moved back.
 *
 * A ray crosses a closed surface inwards as often as outwards, even through its edges and vertices.
 * All triangles compute the same edge function for a shared edge, up to the sign. A zero counts as
 * if the ray were moved by an infinitesimal step, the same for all triangles. At equal distances
 * the lowest triangle index wins.
 */
#ifndef MCVISI_HOST_REFERENCE_GEOMETRY_H
#define MCVISI_HOST_REFERENCE_GEOMETRY_H

#include "reference/vector.h"
#include "scene/scene.h"

typedef struct ref_triangle {
    ref_vec corner[3];
    uint32_t instance, number; /* number: global in the scene */
} ref_triangle;                /* or a piece of a solid, without corners */

/* A leaf holds the triangles first … first + count - 1; an inner node (count 0) its children first
 * and first + 1. */
typedef struct ref_node {
    ref_vec low, high;
    uint32_t first, count;
} ref_node;

typedef struct ref_geometry {
    const mcv_scene *scene;
    ref_triangle *triangles; /* in the order of the tree */
    ref_node *nodes;         /* nodes[0] is the root; NULL for a scene without triangles */
    uint32_t moving;         /* the root of the triangles that move; 0: none do */
    double time;             /* at which rays are traced [s] */
    ref_triangle *pieces;    /* of the scene's solids */
    double touch; /* faces at most this far apart coincide: the rounding of float32 vertices [m] */
} ref_geometry;

typedef struct ref_hit {
    double distance;   /* along the ray, in units of its direction's length */
    double weights[3]; /* barycentric */
    const ref_triangle *triangle;
    ref_vec position; /* of a piece */
} ref_hit;

/* The triangles and pieces that a ray starts on. */
enum { REF_SKIPS = 16 };
typedef struct ref_skip {
    uint32_t count, numbers[REF_SKIPS];
} ref_skip;

/* The surface at a hit, for shading. */
typedef struct ref_surface {
    ref_vec position;
    ref_vec geometric; /* unit normal of the triangle, on its front side */
    ref_vec normal; /* unit, interpolated from the vertices, on the front side as the file has it */
    double texcoord[2][2]; /* of two sets; 0 where the mesh has none */
    ref_vec tangent;       /* unit, at right angles to the normal; zero where the mesh has none */
    double hand;           /* 1 or -1: the sign of the bitangent, from normal x tangent */
    uint32_t instance;
    uint32_t number; /* of the triangle */
} ref_surface;

/* Fails only without memory. The scene must outlive the geometry. */
mcv_result ref_geometry_new(const mcv_scene *scene, ref_geometry *geometry, mcv_error *error);
void ref_geometry_free(ref_geometry *geometry);

/* The closest hit with distance > 0, except on the triangle `skip`, where the ray starts (MCV_NONE:
 * none). */
bool ref_closest_hit(const ref_geometry *geometry, ref_vec origin, ref_vec direction, uint32_t skip,
                     ref_hit *hit);

/* The same, except on any of those triangles. */
bool ref_next_hit(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                  const ref_skip *skip, ref_hit *hit);

/*
 * The hits on dielectric bodies that coincide with the given one, which is the first of them, in
 * their order along the ray; returns their number. It is 1 if the given material is not a
 * dielectric.
 */
uint32_t ref_hits_together(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                           const ref_skip *skip, const ref_hit *hit, ref_hit hits[REF_SKIPS]);

/*
 * Adds to winding[i], for each instance i, the number of its surfaces that the ray leaves minus the
 * number that it enters. For closed surfaces this is how often they surround the origin, in any
 * direction.
 */
void ref_add_windings(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                      int *winding);

/* The geometry at a hit. */
ref_surface ref_surface_at(const ref_geometry *geometry, const ref_hit *hit);

#endif
