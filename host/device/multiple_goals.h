/* SPDX-License-Identifier: Apache-2.0 */
/* What a microfacet of an interface sends towards all directions of a table: what quadrature
 * (multiple_two.c) and walks (multiple_walks.c) share; only the table (multiple_interface.c) needs
 * them. */
#ifndef MCVISI_HOST_DEVICE_MULTIPLE_GOALS_H
#define MCVISI_HOST_DEVICE_MULTIPLE_GOALS_H

#include <stdint.h>

#include "mcvisi/materials/microfacet.h"

enum { MCV_GOAL_NODES = MCV_INTERFACE_COSINES, MCV_GOAL_TURNS = MCV_INTERFACE_AZIMUTHS };

/* An interface between the indices of its two sides. scale, offset: of its coating (mcv_coat). */
typedef struct mcv_facet_interface {
    double alpha, n[2], scale[2], offset[2];
} mcv_facet_interface;

typedef struct mcv_goal_node {
    double cosine, sine, lambda;
} mcv_goal_node;

/* Directions of a table: nodes on the axis of cosines. x, y: the column's direction, of a row. */
typedef struct mcv_goals {
    uint32_t nodes;
    mcv_goal_node node[MCV_GOAL_NODES];
    float x[MCV_GOAL_NODES][MCV_GOAL_NODES][MCV_GOAL_TURNS],
        y[MCV_GOAL_NODES][MCV_GOAL_NODES][MCV_GOAL_TURNS];
} mcv_goals;

/* Sums for each cosine of a direction on each side, and the angle between two azimuths. */
typedef double mcv_goal_sums[2][MCV_GOAL_NODES][MCV_GOAL_TURNS];

/*
 * Light at a microfacet, in a frame in which its medium lies above. `here` is its weight by what
 * the microfacet does, 0 reflects, 1 passes, and by the goal's column. `there` is the density from
 * the other end over that from this end and the microfacet's lobe: the balance heuristic joins
 * both.
 */
typedef struct mcv_facet_light {
    double back[3]; /* direction it comes from */
    int side;       /* 0: the side where it started */
    float here[2][MCV_GOAL_NODES], there[2][MCV_GOAL_NODES];
} mcv_facet_light;

/* Grids of nodes x nodes x MCV_GOAL_TURNS directions. */
void mcv_goals_fill(double alpha, uint32_t nodes, mcv_goals *goals);

/* The entry of the angle between two azimuths, by |cos φ/2| and the sum of the cosines. */
double mcv_goal_entry(double half, double sum);

/* The share that a microfacet reflects of light from one side at a cosine; eta = n1/n2. */
float mcv_facet_reflects(const mcv_facet_interface *at, int side, float c);

/* Adds what the microfacet sends of light that began on the side `start` towards the goals of a
 * row: the BSDF over n² of the goal's side. */
void mcv_facet_send(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
                    const mcv_facet_light *light, mcv_goal_sums sums);

#endif
