/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scene on the device: float32, re-centred, in tables of 4-byte scalars. host/device/pack.c
 * fills them.
 */
#ifndef MCVISI_TABLES_H
#define MCVISI_TABLES_H

#include "mcvisi/dialect.h"
#include "mcvisi/elements.h"
#include "mcvisi/events.h"
#include "mcvisi/interface.h"
#if !MCV_ON_DEVICE || MCV_WITH_MOTION
#include "mcvisi/motion.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_PUNCTUAL
#include "mcvisi/point_light.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_RECTANGLE
#include "mcvisi/rectangle.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_AREA
#include "mcvisi/surface_light.h"
#endif
#include "mcvisi/surfaces/solid.h"

/* The number of media that a path can distinguish. Medium 0 is the surrounding vacuum; bit i of a
 * path's set stands for medium i + 1. */
#define MCV_MAX_MEDIA 32

/* A bounding ball of smooth surfaces that lie close together. */
typedef struct mcv_ball {
    float centre[3], radius; /* [m] */
} mcv_ball;

#define MCV_MAX_BALLS 16

/*
 * One launch: the paths to start. A set consists of the samples of one replicate r of one pixel q;
 * set = q R + r. Path p of the launch is sample first_sample + (p mod 2^k) of the set first_set +
 * floor(p / 2^k).
 */
typedef struct mcv_frame {
    uint width, height; /* of the image [pixels] */
    uint first_set;     /* pixels are numbered by blocks of 8 x 8 */
    uint path_count;    /* of this launch */
    uint replicates;    /* R */
    uint log2_samples;  /* k: samples per replicate in this launch, as a power of two */
    uint first_sample;  /* of this launch, per replicate */
    uint seed;
    uint depth;                    /* the largest number of surfaces on a path */
    uint emitter_count;            /* emitters that next-event estimation chooses from */
    uint initial_media;            /* the set of media that surround the sensor */
    float sensor_index_squared[3]; /* n² of the medium around the sensor, by channel */
    float to_world[12];            /* row-major; of the optical frame (z towards the scene) */
    float environment[3];          /* radiance of an environment without image */
    /* Random numbers belong to pixels of the whole film, whatever region is read out. The number of
     * the image's pixel (0, 0) on the film … */
    uint first_pixel;
    uint row_pitch;           /* … and the difference between rows */
    uint environment_emitter; /* index of the environment with an image */
    uint light_cdf;    /* light paths: index of the CDF of the emitters, by which they start */
    uint log2_pixels;  /* number of bits of a pixel's number (by blocks) */
    float splat_scale; /* splat units per pixel value, a power of two */
    uint solid_count;
    uint log2_thinning;  /* k: one light path starts for every 2^k-th pixel */
    float light_density; /* π (pixels >> log2_thinning): π times the light paths that one sample
                            of every pixel starts; 0: there are none */
    float to_world_low[12]; /* to_world minus its rounding to float */
    uint listed;            /* 1: the sets belong to the pixels of a list, in its order */
    uint ball_count;
    mcv_ball balls[MCV_MAX_BALLS]; /* around all smooth surfaces */
    uint triangle_count;
    uint instance_count;
    uint
        light_tree_depth; /* steps from its root to an emitter at most; 0: there is no light tree */
    uint environment_element;         /* its number (kernels/light/emitter_element.h) */
    uint record_capacity;             /* records that a launch has room for; 0: it makes none */
    float splat_weight;               /* what a splat of 1 adds to a pixel's sum of samples */
    uint moving_nodes, moving_leaves; /* where the hierarchy of moving parts begins */
    uint padding[4];
#if !MCV_ON_DEVICE || MCV_WITH_MOTION
    mcv_motion motion;
    mcv_rigid_motion part_motion;
#endif
} mcv_frame;
#if !MCV_ON_DEVICE || MCV_WITH_MOTION
MCV_ASSERT_SIZE(mcv_frame, 512 + 80 + 40);
#else
MCV_ASSERT_SIZE(mcv_frame, 512);
#endif

typedef struct mcv_device_instance {
    uint material;
    uint emitter; /* or MCV_NONE */
    uint medium;  /* index of the medium inside its surface; 0: none */
    uint first_triangle;
    uint shading; /* MCV_SHADING_… */
    uint moves;   /* 1: it is in the hierarchy of moving parts */
} mcv_device_instance;
MCV_ASSERT_SIZE(mcv_device_instance, 24);

/*
 * Shading classes of surfaces that do not emit: diffuse ones that nothing passes, microfacets,
 * smooth bodies, absorbers. Scenes with few emitters have one more class per emitter:
 * MCV_SHADING_BLACK plus 1 plus the emitter's index is the surface of an emitter whose radiance
 * depends on the angle alone. All other surfaces are one class.
 */
enum {
    MCV_SHADING_ANY,
    MCV_SHADING_DIFFUSE,
    MCV_SHADING_GLOSSY,
    MCV_SHADING_SMOOTH,
    MCV_SHADING_BLACK
};
#define MCV_MOST_LAMPS 16u

typedef struct mcv_device_material {
    uint type;      /* MCV_MATERIAL_… */
    uint texture;   /* or MCV_NONE */
    float color[3]; /* reflectance, transmittance or base colour; rough conductor: share left after
                       reflection between microfacets */
    uint scattering_sides; /* number of sides on which scattered light leaves; emitters are sampled
                              from here. 0: smooth or black */
    float
        passed[3]; /* beam splitter, diffuse: transmittance; retroreflector: diffuse reflectance */
    float chance;  /* beam splitter, diffuse: probability of reflection */
    uint broad_lobe;    /* 1: scatters so broadly that light paths connect it to the lens even where
                           camera paths find the same light */
    uint near_specular; /* 1: scatters so little that light paths continue as at a smooth surface */
    union {
#define MCV_X(name, key, NAME) mcv_##name name;
#if !MCV_ON_DEVICE || MCV_WITH_REFLECTOR
        MCV_OWN_BSDFS(MCV_X)
#endif
#if !MCV_ON_DEVICE || MCV_WITH_SHEET
        MCV_PLATES(MCV_X)
#endif
#undef MCV_X
        uint words[8]; /* the most that one has */
    } as;
} mcv_device_material;
MCV_ASSERT_SIZE(mcv_device_material, 80);

/* What a glossy material has in addition, under the same index; kernels/bsdf/microfacet.h. */
typedef struct mcv_device_glossy {
    float roughness;    /* if no texture scales it */
    float anisotropy;   /* α_t = α + (1 - α) anisotropy; 0: isotropic */
    float direction[2]; /* cosine and sine of the angle from the tangent */
    uint table; /* where its albedos begin, a block of means and rows per roughness; a dielectric's
                   are stored with the interface */
    uint azimuths;      /* rows of a block; 1: isotropic */
    uint roughnesses;   /* blocks, from 0 to `roughness`; 1: only that roughness */
    uint texture;       /* of roughness (green) and metallic (blue), or MCV_NONE */
    float metallic;     /* metallic-roughness … */
    float f0;           /* reflectance at normal incidence of the non-metallic part */
    float transmission; /* share of the light below the layer that passes a thin wall */
    float diffuse_transmission;
    float n[3], k[3]; /* conductor: refractive index n - ik */
    uint multiple;    /* where its tables of multiple scattering begin, one per roughness
                         (MCV_MULTIPLE_ROUGHNESSES); or MCV_NONE */
    uint padding[5];
} mcv_device_glossy;
MCV_ASSERT_SIZE(mcv_device_glossy, 96);

typedef struct mcv_device_medium {
    float absorption[3];         /* [1/m] */
    float inverse_index_squared; /* 1/n² */
} mcv_device_medium;
MCV_ASSERT_SIZE(mcv_device_medium, 16);

typedef struct mcv_device_emitter {
    uint type; /* MCV_EMITTER_…; a telecentric projector is a parallel emitter with a texture; all
                  MCV_POINT_LIGHTS are MCV_EMITTER_POINT, all MCV_SURFACE_LIGHTS MCV_EMITTER_AREA */
    uint instance; /* instance whose triangles emit, or MCV_NONE */
    uint texture;  /* or MCV_NONE */
    uint cdf; /* where its triangle_count + 1 cumulative shares begin, 2^31 = 1; of an environment
                 those of its pixels, kernels/light/environment.h */
    uint triangle_count;
    float probability;       /* probability that next-event estimation chooses it */
    float radiance[3];       /* or irradiance or intensity, according to its type */
    float middle[3];         /* centre of its box [m] */
    float area;              /* [m²] */
    float light_inverse_pdf; /* of a light path's start, its choice among emitters included: over
                                the area [m²], of a projector over étendue [m² sr]; of a laser, a
                                point light and a directional one over the choice alone. 0: no light
                                paths */
    uint media;              /* set of the media that surround it */
    float light_aim;         /* estimate of the measure of their directions [sr, m²]; 1: none */
    float radius;            /* about the centre [m]; negative: the emitter has no place */
    float facing[3];         /* normal of a flat emitter, else 0 */
    float narrowest; /* width of its light and how it grows with distance: kernels/light/selection.h
                        [m²] */
    float widening;
    float power; /* its share of the power of all emitters */
    uint trail;  /* from the root of the light tree to it: bit i is the child at level i */
    uint first_emitter_element; /* its number (kernels/light/emitter_element.h) */
    uint emitter_element_width; /* pixels in a row of its image, each of which is an element; 0: it
                           is one element */
#if !MCV_ON_DEVICE || MCV_WITH_PARALLEL
    mcv_parallel parallel;
#else
    uint no_parallel[8]; /* keeps the size */
#endif
#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_FIELD
    mcv_light_field_emitter light_field;
#else
    uint no_light_field[12];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_PROJECTOR
    mcv_projector projector;
#else
    uint no_projector[12];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_ENVIRONMENT_IMAGE
    mcv_environment environment;
#else
    uint no_environment[12];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_BEAM
    mcv_collimated_beam beam;
#else
    uint no_beam[12];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_LASER
    mcv_laser laser;
#else
    uint no_laser[32];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_PUNCTUAL
    mcv_point_light light;
    mcv_directional directional;
#else
    uint no_punctual[16];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_AREA
    mcv_surface_light surface_light;
#else
    uint no_surface_light[6];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_RECTANGLE
    mcv_rectangle rectangle;
#else
    uint no_rectangle[24];
#endif
} mcv_device_emitter;
MCV_ASSERT_SIZE(mcv_device_emitter, 640);

/* A node of the light tree: emitters that are chosen together (kernels/light/tree.h). */
typedef struct mcv_light_node {
    float centre[3], radius; /* sphere around them [m]; negative: they have no place */
    float axis[3];           /* unit; of the cone that holds their normals … */
    float cosine, sine;      /* … its half-angle's */
    float widest;            /* cosine of the largest angle of light to a normal */
    float power;             /* as of emitters */
    float narrowest, widening;
    uint child;   /* index of the first of two that lie side by side; 0: it is one emitter, … */
    uint emitter; /* … this one, else MCV_NONE */
    uint padding;
} mcv_light_node;
MCV_ASSERT_SIZE(mcv_light_node, 64);

typedef struct mcv_device_texture {
    uint width, height;
    uint first; /* index of the first texel */
    uint wrap_s, wrap_t, nearest;
    uint linear;         /* 1: a texel is three floats; 0: one sRGB word */
    uint first_texcoord; /* of vertex 0, in the image's set of texture coordinates */
    float transform[6];  /* mcv_texture */
    uint padding[2];
} mcv_device_texture;
MCV_ASSERT_SIZE(mcv_device_texture, 64);

/*
 * Where in the pupil, in pupil radii, a pixel's rays meet a parallel emitter within its cone, to
 * first order: centre + shift · (position in the pixel, from its middle) + the ellipse spread ·
 * (unit disk). Matrices are stored row by row.
 */
typedef struct mcv_device_pupil_guide {
    float centre[2];
    float shift[4];
    float spread[4];
    float advantage; /* density of points in the ellipse over that in the pupil: 1/|det spread|; 0:
                        the pixel is not guided */
    uint padding;
} mcv_device_pupil_guide;
MCV_ASSERT_SIZE(mcv_device_pupil_guide, 48);

/* Counters of a launch, per slice or in all; the host adds them up. Lost energy is in units of
 * 2^-11 paths. */
#define MCV_COUNTERS(X) \
    X(paths) X(rays) X(shadow_rays) X(depth_cut) X(lost) X(nonfinite) X(unmatched) X(saturated)
enum {
#define MCV_X(name) MCV_COUNTER_##name,
    MCV_COUNTERS(MCV_X)
#undef MCV_X
        MCV_COUNTER_COUNT
};

/*
 * A traced ray with a vertex of its path (host/render/render.h says more). A `low` is the rounding
 * error of the float before it; it is 0 without MIXED.
 */
typedef struct mcv_device_ray {
    float origin[3], direction[3];
    float origin_low[3], direction_low[3];
    uint media;
    uint padding[3];
} mcv_device_ray;
MCV_ASSERT_SIZE(mcv_device_ray, 64);

typedef struct mcv_device_vertex {
    float position[3], normal[3], direction[3];
    float distance;
    uint primitive;
    uint event;
    uint medium;
    float transmittance;
    float radiance;
    float distance_low;
    float position_low[3], normal_low[3], direction_low[3];
    uint padding[3];
} mcv_device_vertex;
MCV_ASSERT_SIZE(mcv_device_vertex, 112);

/* A buffer of records (kernels/stage/record_light.h): their number, then cell, element and channels
 * of each. */
#define MCV_RECORD_COUNT_WORDS 4u
#define MCV_RECORD_WORDS(channels) (2u + (channels))

/* Up to this many emitters, each surface weighs all of them. With more, it chooses by the light
 * tree. */
#define MCV_MOST_REACHING 32

/* Samples that the device sums; the host continues the same binary tree. */
#define MCV_BLOCK 64

/* The size of a block in a launch of 2^log2_samples samples per set. */
MCV_FUNCTION uint mcv_block_size(uint log2_samples) {
    const uint samples = 1u << log2_samples;
    return samples < MCV_BLOCK ? samples : MCV_BLOCK;
}

/*
 * The largest value of a branch of a sample: the sum of a block is then a float. It is 2^128 / 8 /
 * MCV_BLOCK / 2, with room for 8 branches (MCV_SPLIT_BRANCHES is 4). Larger values count as not
 * finite.
 */
#define MCV_LARGEST_VALUE 0x1p118f

#endif
