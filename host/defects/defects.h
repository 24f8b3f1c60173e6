/* SPDX-License-Identifier: Apache-2.0 */
/* Defects on surfaces (mcvisi/defects.h): their parameters, their place and their mark in meshes.
 */
#ifndef MCVISI_HOST_DEFECTS_DEFECTS_H
#define MCVISI_HOST_DEFECTS_DEFECTS_H

#include "core/json_path.h"
#include "scene/defect_params.h"

/* Room for the parameters of any type. */
typedef struct mcv_defect_params {
    union {
        double number;
        char bytes[128];
    } any;
} mcv_defect_params;

/* Takes parsed and checked parameters, with the defaults that depend on the size. Fails where they
 * contradict each other. */
mcv_result mcv_defect_resolve(mcv_defect *defect, const mcv_defect_params *params,
                              const mcv_json_path *place, mcv_error *error);

/* What a type does to its part. */
typedef enum mcv_defect_kind {
    MCV_KIND_RELIEF, /* moves the surface along the normal, smoothly */
    MCV_KIND_PIT,    /* the same within a sharp outline */
    MCV_KIND_CUT,    /* moves what lies above a ball or a plane down to it */
    MCV_KIND_PATCH,  /* gives what lies within an outline another material */
    MCV_KIND_INSIDE  /* lies inside of a body, not on a surface */
} mcv_defect_kind;
mcv_defect_kind mcv_defect_kind_of(uint32_t type);
static inline bool mcv_defect_is_inside(uint32_t type) {
    return mcv_defect_kind_of(type) == MCV_KIND_INSIDE;
}

/* Must its entry name a material? */
bool mcv_defect_takes_material(uint32_t type);

/* How many bodies with exact surfaces a defect adds to its scene; 0 for one on a surface. */
uint32_t mcv_defect_bodies(const mcv_defect *defect);

/* --- sizes on drawings --- */

/* Does a text look like one of the notations below, not like a length? */
bool mcv_defect_is_notation(const char *text);

/*
 * The size [m] that a drawing states for a defect of this type, and how many there are; 0: not
 * said.
 *
 *     ISO 10110-7  "5/ N x A" of digs, stains and rough patches: each has the area A² in mm²;
 *                  "5/ L N x A" of scratches of the width A mm; "5/ E A" of chips that reach A mm
 *                  from an edge; several terms are separated by ";"
 *     ISO 10110-3  "1/ N x A" of bubbles and inclusions
 *     MIL-PRF-13830B  "S-D", as in "60-40": scratches of the width S/10 µm, digs and bubbles of the
 *                  diameter D/100 mm
 *
 * Fails for types without such a size and for other texts.
 */
mcv_result mcv_defect_read_notation(const char *text, uint32_t type, double *size, uint64_t *count,
                                    const mcv_json_path *place, mcv_error *error);

/* --- the relief --- */

/* Extent in the tangent plane: the points within `radius` of the segment from -half_length to
 * half_length on the u axis. Beyond it nothing changes. */
typedef struct mcv_footprint {
    double half_length, radius;
    double lowest;  /* along the normal: what lies below stays as it is [m] */
    double fine;    /* the radius within which the mesh has its smallest edges [m] */
    double edge;    /* of these edges, across [m] */
    double stretch; /* how much longer they may be along u */
} mcv_footprint;
mcv_footprint mcv_defect_footprint(const mcv_defect *defect);

/* h at (u, v) and its derivatives; beyond a sharp outline that of the law within. */
double mcv_defect_height(const mcv_defect *defect, double u, double v, double slope[2]);

/* Above 0 for points u, v and height within the outline of a pit, a cut or a patch; continuous. */
double mcv_defect_outline(const mcv_defect *defect, const double point[3]);

/* The height to which a cut moves what lies above (u, v), and the normal of its face there. */
double mcv_defect_cut(const mcv_defect *defect, double u, double v, double normal[3]);

/*
 * changed.c: has the defect changed the surface in this point of the world? Of a relief what is
 * higher than a hundredth of its depth counts, of a pit or patch what lies within the outline, of a
 * cut its face, of a defect inside of a body what lies within its outermost surface. The point must
 * lie on the surface of the instance.
 */
bool mcv_defect_changed(const mcv_defect *defect, uint32_t instance, const double world[3]);

/* --- meshes that are looked at again and again --- */

/* Of points in a mesh's frame. */
typedef struct mcv_box {
    float lower[3], upper[3];
} mcv_box;

/* Triangles of a run, which has a box: neighbours in a mesh mostly lie side by side. */
enum { MCV_BOX_TRIANGLES = 64 };

typedef struct mcv_mesh_boxes {
    mcv_box all, *items; /* of the mesh, and of its runs */
    size_t room;
    uint32_t triangles; /* that they hold */
} mcv_mesh_boxes;

/* What defects found out about the meshes of a scene, so that the next one need not. All 0 at
 * first. Valid while only mcv_defect_apply_known changes the meshes. */
typedef struct mcv_known_mesh {
    mcv_mesh_boxes boxes;
    uint8_t *gone; /* of each triangle, whether a defect has replaced it; NULL: none has yet */
    uint32_t gone_count;
    size_t vertex_room, triangle_room; /* with `gone`: of the mesh's arrays */
} mcv_known_mesh;
typedef struct mcv_known_meshes {
    mcv_known_mesh *items;
    size_t count;
    double **areas; /* of an instance: the sum of areas up to each triangle; or NULL */
    size_t area_count;
} mcv_known_meshes;
void mcv_known_meshes_free(mcv_known_meshes *known);

/* boxes.c: what is known of a mesh of the scene; NULL without memory. */
mcv_known_mesh *mcv_known_mesh_of(mcv_known_meshes *known, const mcv_scene *scene, uint32_t mesh);

static inline const uint8_t *mcv_known_gone(const mcv_known_meshes *known, uint32_t mesh) {
    return mesh < known->count ? known->items[mesh].gone : NULL;
}

/* boxes.c: those of a mesh of the scene, by its number; NULL without memory. */
const mcv_mesh_boxes *mcv_known_boxes(mcv_known_meshes *known, const mcv_scene *scene,
                                      uint32_t mesh);

/* What a box covers along three axes from an origin: the middle, and half of the extent, rounding
 * included. */
typedef struct mcv_spread {
    double middle[3], half[3];
} mcv_spread;
mcv_spread mcv_box_spread(const mcv_box *box, const mcv_transform *to_world, const double origin[3],
                          const double axes[3][3]);

/* --- the place --- */

/* Where a defect lies, as its entry says. */
typedef struct mcv_defect_site {
    const char *node;
    bool by_point;
    double at[3]; /* along the node's axes [m] */
    uint32_t triangle;
    double barycentric[3];
    double direction[3];        /* along the node's axes; 0: not given */
    const mcv_placement *found; /* the node, where it is known already; or NULL */
    mcv_known_meshes *known;    /* or NULL */
} mcv_defect_site;

/* Sets instances, centre and axes of a defect of known size. Fails where there is no such node or
 * the place is off its surface. */
mcv_result mcv_defect_locate(const mcv_scene *scene, const mcv_defect_site *site,
                             mcv_defect *defect, const mcv_json_path *place, mcv_error *error);

/* inside.c: the same of a defect inside of a body. Its material becomes the defect's `host`. Fails
 * where the point is not inside or the defect would reach out. */
mcv_result mcv_defect_locate_inside(const mcv_scene *scene, const mcv_defect_site *site,
                                    mcv_defect *defect, const mcv_json_path *place,
                                    mcv_error *error);

/* inside.c: the radius of the outermost surface of a defect inside of a body. */
double mcv_defect_outer_radius(const mcv_defect *defect);

/* What both use: the node of a site; its place in the world; the direction of the site in the
 * world, else the node's x axis. */
mcv_result mcv_defect_node(const mcv_scene *scene, const char *name, const mcv_placement **node,
                           const mcv_json_path *place, mcv_error *error);
/* The distance to the nearest triangle of the instances, infinite without any, and its instance. */
double mcv_defect_distance(const mcv_scene *scene, const uint32_t instances[2],
                           const double point[3], uint32_t *instance);

/* mean_normal.c: the mean of the unit normals over the surface of the instances within `radius` of
 * the point. False where they cancel. `known` may be NULL. */
bool mcv_defect_mean_normal(const mcv_scene *scene, mcv_known_meshes *known,
                            const uint32_t instances[2], const double point[3], double radius,
                            double normal[3]);

/* --- by chance --- */

/* How many, and where from. */
typedef struct mcv_chance {
    uint64_t count;          /* or 0: */
    double density;          /* [1/m²] */
    uint64_t state;          /* of the random numbers */
    mcv_known_meshes *known; /* or NULL */
} mcv_chance;

/* The number of defects: the count, or Poisson's of the density on the node's surface. */
mcv_result mcv_chance_count(const mcv_scene *scene, const char *node_name, mcv_chance *chance,
                            uint64_t *count, const mcv_json_path *place, mcv_error *error);

/* Locates the defect where it fits: evenly over the node's surface or, inside, over its volume.
 * The direction is by chance where the site has none. Fails where it fits nowhere. */
mcv_result mcv_chance_locate(const mcv_scene *scene, const mcv_defect_site *site,
                             mcv_chance *chance, mcv_defect *defect, const mcv_json_path *place,
                             mcv_error *error);

/* --- the meshes --- */

/* Whether mcv_defect_apply would find its surface turned away. */
mcv_result mcv_defect_fits(const mcv_scene *scene, mcv_known_meshes *known,
                           const mcv_defect *defect, const mcv_json_path *place, mcv_error *error);

/* Inside of a body: adds its exact surfaces to the scene. Else refines the meshes of the defect's
 * instances around it and moves their vertices, or makes a patch an instance of its own. Meshes
 * that other nodes use are copied first. Fails where the defect reaches round an edge, goes through
 * its part, lies on an emitter or would take too many triangles. */
mcv_result mcv_defect_apply(mcv_scene *scene, const mcv_defect *defect, const mcv_json_path *place,
                            mcv_error *error);

/* The same for one defect after the other, in the time of each. Meshes keep the triangles that are
 * gone until mcv_defects_finish, in edit.c, leaves them out. */
mcv_result mcv_defect_apply_known(mcv_scene *scene, mcv_known_meshes *known,
                                  const mcv_defect *defect, const mcv_json_path *place,
                                  mcv_error *error);
mcv_result mcv_defects_finish(mcv_scene *scene, mcv_known_meshes *known, const mcv_json_path *place,
                              mcv_error *error);

#endif
