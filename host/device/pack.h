/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A scene prepared for the device: world geometry, computed in double, re-centred and rounded once
 * to float32; the tables of mcvisi/tables.h; the features.
 */
#ifndef MCVISI_HOST_DEVICE_PACK_H
#define MCVISI_HOST_DEVICE_PACK_H

#include "mcvisi/contact_grid.h"
#include "mcvisi/features.h"
#include "mcvisi/precise.h"
#include "mcvisi/tables.h"
#include "scene/scene.h"

typedef struct mcv_box3d {
    double lower[3], upper[3]; /* [m]; lower > upper: empty */
} mcv_box3d;

/*
 * What a table of albedos is computed from: the indices of an interface, or none for a reflecting
 * surface. With `multiple` it is a table of multiple scattering, of a metal, or without n and k for
 * Schlick's reflectance.
 */
typedef struct mcv_albedo_source {
    double roughness, anisotropy, n_outside, n_inside, coating;
    double n[3], k[3];
    bool multiple;
    uint32_t azimuths, roughnesses, table; /* where they begin */
} mcv_albedo_source;

typedef struct mcv_packed {
    uint64_t features; /* bit MCV_FEATURE_… */
    uint32_t channels;
    mcv_box3d *boxes; /* of the instances in the world */
    bool moves;       /* some of the instances do */
    bool for_features_alone;
    double centre[3]; /* world point that is the device's origin, on a power-of-two grid */

    uint32_t vertex_count, triangle_count, instance_count, material_count, emitter_count,
        texture_count;
    uint32_t texcoord_sets; /* one after the other in texcoords */
    size_t texel_count, cdf_count;
    float *positions, *normals,
        *texcoords; /* 3, 3, 2 per vertex; normals and texcoords NULL where no feature needs them */
    mcv_device_solid *solids; /* solid_count; NULL without any */
    uint32_t solid_count;
    uint32_t *indices;   /* 3 per triangle, for the acceleration structure */
    uint32_t *triangles; /* 4 per triangle: the vertices and the instance */
    float *tangents; /* 4 per vertex: direction, handedness; NULL without anisotropic surfaces */
    mcv_device_instance *instances;
    mcv_device_material *materials;
    mcv_device_glossy *glossy; /* of each material, or NULL */
    float *albedos;
    size_t albedo_count;
    mcv_albedo_source *albedo_sources; /* of each table in it */
    uint32_t albedo_source_count;
    mcv_device_medium medium_table[3][MCV_MAX_MEDIA + 1]; /* by channel */
    mcv_device_interface interfaces[3][(MCV_MAX_MEDIA + 1) * (MCV_MAX_MEDIA + 1)];
    uint32_t interface_albedos[(MCV_MAX_MEDIA + 1) * (MCV_MAX_MEDIA + 1)];
    mcv_contact_grid *contact_grid; /* NULL where no bodies may touch */
    mcv_device_emitter *emitters;
    uint32_t *emitter_cdf; /* the first emitter_count + 1 entries choose an emitter; then those of
                              each emitter's triangles; then the choice of light paths */
    uint32_t light_cdf;    /* where the last ones begin */
    mcv_light_node *light_tree; /* NULL with few emitters */
    uint32_t light_node_count, light_tree_depth;
    mcv_ball balls[MCV_MAX_BALLS]; /* around all smooth surfaces */
    uint32_t ball_count;
    mcv_device_texture *textures;
    uint32_t *texels;             /* first 256 words: the sRGB decoding as floats */
    float environment[3];         /* radiance of an environment without image */
    uint32_t environment_emitter; /* index of an environment with an image */
    uint32_t environment_element; /* number of the environment's element */

    /* Only with MIXED: */
    float *position_lows, *normal_lows; /* rounding errors of positions and normals */
    mcv_precise_solid *precise_solids;
    double refractive_indices[3][MCV_MAX_MEDIA + 1]; /* of the media by channel */
} mcv_packed;

/*
 * Fails without memory, or with more than MCV_MAX_MEDIA overlapping bodies; *packed is then empty.
 * `earlier` is another scene whose albedos are reused if they are the same, or NULL.
 */
mcv_result mcv_pack(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                    mcv_error *error);
/* The same without the tables of microfacets, and without the colour of rough metals, which follows
 * from them: a table takes a tenth of a second. Features, channels and words of paths need none. */
mcv_result mcv_pack_for_features(const mcv_scene *scene, mcv_packed *packed, mcv_error *error);
void mcv_packed_free(mcv_packed *packed);

/* pack_solids.c: the exact surfaces, about packed->centre; and in double. */
void mcv_pack_solids(const mcv_scene *scene, mcv_packed *packed);
void mcv_pack_precise_solids(const mcv_scene *scene, mcv_packed *packed);

/* pack_rectangle.c: fills in the emitter's rectangle from its other fields; false if it is not a
 * rectangle. */
bool mcv_pack_rectangle(const mcv_scene *scene, const mcv_packed *packed,
                        mcv_device_emitter *emitter);

/* pack_precise.c: what the feature MIXED needs. To be called before the packed arrays are
 * freed. */
mcv_result mcv_pack_precise(const mcv_scene *scene, mcv_packed *packed, mcv_error *error);

/* Touching boxes overlap, with a tolerance for the rounding of coordinates. */
bool mcv_boxes_overlap(const mcv_box3d *a, const mcv_box3d *b);

/* A vertex's normal in the world, unit; or 0: the face's normal replaces it. */
void mcv_pack_normal(const mcv_scene *scene, uint32_t instance, uint32_t vertex, double n[3]);

/* Pixels of the image, filled up to whole blocks of 8 x 8, by which paths are numbered. A sample
 * has as many light paths. */
static inline uint64_t mcv_tiled_pixels(uint32_t width, uint32_t height) {
    return (((uint64_t)width + 7) & ~(uint64_t)7) * (((uint64_t)height + 7) & ~(uint64_t)7);
}

/* The set of media (bit i: medium i + 1) whose closed surfaces surround a world point. */
uint32_t mcv_media_around(const mcv_scene *scene, const mcv_packed *packed, const double point[3]);

/* The diagonal of the box around all instances [m]. */
double mcv_packed_size(const mcv_packed *packed);

/* Does next-event estimation sample it? It leaves out a constant environment: all directions are
 * equally good there. */
bool mcv_is_sampled(const mcv_emitter *emitter);

/* The elements of an emitter: the pixels of its image where these are told apart, else 1. They are
 * numbered emitter by emitter, row by row. */
uint32_t mcv_emitter_elements(const mcv_scene *scene, const mcv_emitter *emitter);

/* The placement of the sensor: from the optical frame to the re-centred world, and its rounding
 * error. */
void mcv_pack_placement(const mcv_packed *packed, const mcv_transform *to_world,
                        float placement[12], float low[12]);

#endif
