/* SPDX-License-Identifier: Apache-2.0 */
/* The facets of a mesh, and what it is bent at: curved surfaces, or edges of the part. */
#ifndef MCVISI_HOST_CHECK_FACETS_H
#define MCVISI_HOST_CHECK_FACETS_H

#include "scene/scene.h"

/* Up to this angle triangles are coplanar up to rounding [rad]. */
extern const double mcv_flat;

/* Below this angle an edge is rarely designed [rad]. */
extern const double mcv_least_edge;

enum { MCV_LEAST_BENDS = 8 }; /* of a curved surface; fewer may be real edges of a part */

/*
 * Curved: a facet bends there as it does elsewhere. Edge: it bends there by far more than
 * elsewhere, or nowhere else. Slight: it bends there by far less, as triangles at the pole of a
 * ball do.
 */
typedef enum mcv_bend_kind { MCV_BEND_CURVED, MCV_BEND_EDGE, MCV_BEND_SLIGHT } mcv_bend_kind;

/* Where two triangles meet under an angle of less than 31 degrees. */
typedef struct mcv_bend {
    uint32_t triangles[2];
    uint32_t ends[2];
    double angle; /* of the normals [rad] */
    mcv_bend_kind kind;
    bool faceted; /* and the shading normals have a step there too */
} mcv_bend;

/* Facets: connected coplanar triangles. */
typedef struct mcv_facets {
    const mcv_scene *scene;
    uint32_t instance;
    double (*normals)[3]; /* of the triangles, unit; 0 for those without area */
    uint32_t *parents;    /* of a triangle's facet: union-find */
    mcv_bend *bends;
    size_t bend_count, curved_count; /* all, and those of curved surfaces */
} mcv_facets;

/* The facets of an instance. MCV_FAILED without memory. */
mcv_result mcv_facets_of(const mcv_scene *scene, uint32_t instance, mcv_facets *facets,
                         mcv_error *error);
void mcv_facets_free(mcv_facets *facets);

/* The largest bend of curved surfaces, 0 if there is none, and the smallest edge of mcv_least_edge
 * or more, INFINITY if there is none [rad]. */
typedef struct mcv_bend_range {
    double curved, edge;
} mcv_bend_range;

/* The range of one mesh; that of several is the larger `curved` and the smaller `edge`. */
mcv_bend_range mcv_facets_range(const mcv_facets *facets);

/* A crease angle between curves and edges, at most 30 degrees, in whole degrees where there is
 * room. 30 where no angle lies between them. */
double mcv_crease_degrees(mcv_bend_range range);

#endif
