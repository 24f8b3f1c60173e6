/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The paths of a pixel by their routes: which surfaces they meet, what these do, and which emitter
 * they come from. A surface that scatters a path several times in a row counts once. Each route has
 * its share of the pixel's value, with its standard error.
 */
#ifndef MCVISI_HOST_EXPLAIN_ROUTES_H
#define MCVISI_HOST_EXPLAIN_ROUTES_H

#include "reference/explain.h"

/* So many routes are told apart. */
enum { MCV_ROUTE_REPLICATES = 16, MCV_MOST_ROUTES = 1 << 14, MCV_ROUTE_PIXELS = 16 };

/* A pixel of an emitter's image, and what it brings: from `sum - doubtful` to `sum`. */
typedef struct mcv_route_pixel {
    uint32_t pixel[2];
    double sum, doubtful;
} mcv_route_pixel;

typedef struct mcv_route {
    mcv_contribution strongest; /* the path that brings the most, of this route */
    double sums[MCV_ROUTE_REPLICATES];
    uint64_t hash;
    mcv_route_pixel pixels[MCV_ROUTE_PIXELS]; /* those that bring the most */
    /* From mcv_routes_finish: */
    double value, share, share_error; /* value: mean over the channels */
} mcv_route;

typedef struct mcv_routes {
    mcv_route *items; /* after mcv_routes_finish: the strongest first */
    size_t count, capacity;
    uint32_t *slots;  /* of a hash table: index + 1 of a route; 0: free */
    bool failed;      /* for want of memory */
    mcv_route others; /* routes beyond MCV_MOST_ROUTES, as one */
    double others_value;
    double value, value_error;
} mcv_routes;

/* Adds light; `user` is the mcv_routes (mcv_contribution_told). */
void mcv_routes_add(void *user, const mcv_contribution *contribution);

/* Computes values and shares from `samples` of each replicate, and sorts. MCV_FAILED if memory was
 * missing. */
mcv_result mcv_routes_finish(mcv_routes *routes, uint64_t samples, mcv_error *error);

/* "camera <- part scatters <- lamp"; of a list of names, to be freed; NULL without memory. */
char *mcv_route_words(const mcv_scene *scene, uint32_t sensor, const mcv_route *route);

/* The pixel of the emitter's image that brings the most, as far as is known, and its share of the
 * route's light at least; NULL where no pixel is told apart. */
const mcv_route_pixel *mcv_route_brightest(const mcv_route *route, double *share);

void mcv_routes_free(mcv_routes *routes);

/* explain_page.c: a page with the routes and drawings of the strongest paths; whole or not at all.
 */
mcv_result mcv_explain_page_write(const char *path, const mcv_scene *scene, uint32_t sensor,
                                  const uint32_t pixel[2], const mcv_routes *routes, size_t shown,
                                  mcv_error *error);

/* The drawing from the side alone, as SVG. The sensor's set-up must be known. */
mcv_result mcv_explain_drawing_write(const char *path, const mcv_scene *scene, uint32_t sensor,
                                     const mcv_routes *routes, size_t shown, mcv_error *error);

#endif
