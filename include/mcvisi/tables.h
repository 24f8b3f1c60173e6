/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scene as the device sees it: float32, re-centred, in tables of 4-byte scalars.
 * host/device/pack.c fills them.
 */
#ifndef MCVISI_TABLES_H
#define MCVISI_TABLES_H

#include "mcvisi/dialect.h"
#include "mcvisi/elements.h"
#include "mcvisi/events.h"
#include "mcvisi/interface.h"
#if !MCV_ON_DEVICE || MCV_WITH_PUNCTUAL
#include "mcvisi/point_light.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_RECTANGLE
#include "mcvisi/rectangle.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_AREA
#include "mcvisi/surface_light.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_SURFACES
#include "mcvisi/surfaces/solid.h"
#endif

/* Media that can be told apart along one path. Medium 0 is the surrounding vacuum, bit i of a
 * path's set is medium i + 1. */
#define MCV_MAX_MEDIA 32

/* A ball around smooth surfaces that lie close together. */
typedef struct mcv_ball {
    float centre[3], radius; /* [m] */
} mcv_ball;

#define MCV_MAX_BALLS 16

/*
 * One pass: which paths to begin. A set is the samples of one replicate r of one pixel q, set = q R
 * + r; path p of the pass is sample first_sample + (p mod 2^k) of the set first_set + floor(p /
 * 2^k).
 */
typedef struct mcv_frame {
    uint width, height; /* of the image [pixels] */
    uint first_set;     /* pixels are numbered by 8 x 8 tiles */
    uint path_count;    /* of this pass */
    uint replicates;    /* R */
    uint log2_samples;  /* k: samples per replicate in this pass, as a power of two */
    uint first_sample;  /* of this pass, per replicate */
    uint seed;
    uint depth;                    /* surfaces a path may meet */
    uint emitter_count;            /* that next-event estimation chooses from */
    uint initial_media;            /* the set of media that surround the sensor */
    float sensor_index_squared[3]; /* n² of the medium the sensor lies in, by channel */
    float to_world[12];            /* row-major; of the optical frame (z towards the scene) */
    float environment[3];          /* its radiance, without an image */
    /* Random numbers belong to pixels of the whole film, whatever region is read out: pixel (0, 0)
     * of the image is that of the number … */
    uint first_pixel;
    uint row_pitch;           /* and the next row's begins so many further */
    uint environment_emitter; /* the environment with an image */
    /* Light paths: */
    uint light_cdf;    /* where in the table of cumulative shares those of the emitters begin from
                          which they start */
    uint log2_pixels;  /* the pixels, numbered by tiles, fit into so many bits */
    float splat_scale; /* units of the splats per pixel value: a power of two */
    uint solid_count;
    uint log2_thinning;      /* a light path starts for every 2^k-th pixel */
    float light_density;     /* π times the light paths per sample */
    float to_world_rest[12]; /* what rounding leaves of to_world */
    uint listed;             /* sets are of the pixels that a list gives, one after the other */
    uint ball_count;
    mcv_ball balls[MCV_MAX_BALLS]; /* around all smooth surfaces */
    uint triangle_count;
    uint instance_count;
    uint padding[10];
} mcv_frame;
MCV_ASSERT_SIZE(mcv_frame, 512);

typedef struct mcv_device_instance {
    uint material;
    uint emitter; /* or MCV_NONE */
    uint medium;  /* index of the medium that its surface bounds, 0: none */
    uint first_triangle;
    uint shading; /* MCV_SHADING_… */
} mcv_device_instance;
MCV_ASSERT_SIZE(mcv_device_instance, 20);

/*
 * Surfaces that do not emit, without texture: diffuse ones, of microfacets that have no direction,
 * of smooth bodies, and what absorbs all light. Where there are few emitters, the lamp of one whose
 * radiance depends on the angle alone is MCV_SHADING_BLACK and its number and 1 more. And all
 * others.
 */
enum {
    MCV_SHADING_ANY,
    MCV_SHADING_DIFFUSE,
    MCV_SHADING_GLOSS,
    MCV_SHADING_SMOOTH,
    MCV_SHADING_BLACK
};
#define MCV_MOST_LAMPS 16u

typedef struct mcv_device_material {
    uint type;      /* MCV_MATERIAL_… */
    uint texture;   /* or MCV_NONE */
    float value[3]; /* reflectance, transmittance, base colour; of a rough conductor what reflection
                       from facet to facet leaves */
    uint scattering_sides; /* on how many sides light from one direction leaves in many, so that
                              emitters are sampled from here; 0: smooth or black */
    float
        passed[3]; /* beam splitter, diffuse: transmittance; retroreflector: diffuse reflectance */
    float chance;  /* beam splitter, diffuse: with which it reflects */
    uint connectable;   /* 1: spreads light so evenly that light paths connect it to the lens; 0: a
                           lens would seldom lie in its highlights */
    uint near_specular; /* 1: spreads light so little that light paths go through it as if it were
                           smooth */
    union {
#define MCV_X(name, key, NAME) mcv_##name name;
#if !MCV_ON_DEVICE || MCV_WITH_REFLECTOR
        MCV_SCATTERERS(MCV_X)
#endif
#if !MCV_ON_DEVICE || MCV_WITH_SHEET
        MCV_PLATES(MCV_X)
#endif
#undef MCV_X
        uint words[8]; /* the most that one has */
    } as;
} mcv_device_material;
MCV_ASSERT_SIZE(mcv_device_material, 80);

/* What a glossy material has beyond the others, under the same index; kernels/bsdf/microfacet.h. */
typedef struct mcv_device_gloss {
    float roughness;    /* where no texture scales it */
    float anisotropy;   /* α_t = α + (1 - α) anisotropy; 0: the surface has no direction */
    float direction[2]; /* cosine and sine of the angle from the tangent */
    uint table; /* where its albedos begin, a block of means and rows per roughness; of a dielectric
                   the interface has it */
    uint azimuths;      /* rows of a block; 1: isotropic */
    uint roughnesses;   /* blocks, from 0 to `roughness`; 1: for just that */
    uint texture;       /* of roughness (green) and metallic (blue), or MCV_NONE */
    float metallic;     /* metallic-roughness … */
    float f0;           /* reflectance at normal incidence where it is no metal */
    float transmission; /* share of the light below the layer that passes a thin wall */
    float diffuse_transmission;
    float n[3], k[3]; /* conductor: refractive index n - ik */
    uint multiple;    /* where its tables of multiple scattering begin, one per roughness
                         (MCV_MULTIPLE_ROUGHNESSES); or MCV_NONE */
    uint padding[5];
} mcv_device_gloss;
MCV_ASSERT_SIZE(mcv_device_gloss, 96);

typedef struct mcv_device_medium {
    float absorption[3];         /* [1/m] */
    float inverse_index_squared; /* 1/n² */
} mcv_device_medium;
MCV_ASSERT_SIZE(mcv_device_medium, 16);

typedef struct mcv_device_emitter {
    uint type; /* MCV_EMITTER_…; a telecentric projector is a parallel emitter with a texture, all
                  of MCV_POINT_LIGHTS are point lights, all of MCV_SURFACE_LIGHTS area ones */
    uint instance; /* whose triangles emit, or MCV_NONE */
    uint texture;  /* or MCV_NONE */
    uint cdf; /* where its triangle_count + 1 entries begin in the table of cumulative shares, 2^31
                 = 1; an environment's, of pixels: kernels/light/environment.h */
    uint triangle_count;
    float probability; /* that next-event estimation chooses it */
    float radiance[3]; /* or irradiance or intensity, by its type */
    float middle[3];   /* of its box [m] */
    float area;        /* [m²] */
    float light_flux;  /* of a light path, over the radiance (irradiance, intensity) and what it is
                          aimed by; 0: none starts here */
    uint media;        /* set of the media that surround it */
    float light_aim;   /* about what that is [sr, m²]; 1: nothing */
    float radius;      /* about the middle [m]; negative: the emitter is nowhere in particular */
    float facing[3];   /* normal of a flat one, else 0 */
    float narrowest; /* of its light, and how it widens with the distance: kernels/light/selection.h
                        [m²] */
    float widening;
    float power; /* its share of all emitters' */
    uint padding;
#if !MCV_ON_DEVICE || MCV_WITH_PARALLEL
    mcv_parallel parallel;
#else
    uint no_parallel[8]; /* the size stays */
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
#if !MCV_ON_DEVICE || MCV_WITH_PUNCTUAL
    mcv_point_light light;
    mcv_directional directional;
#else
    uint no_punctual[16];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_AREA
    mcv_surface_light surface_light;
#else
    uint no_surface_light[4];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_RECTANGLE
    mcv_rectangle rectangle;
#else
    uint no_rectangle[24];
#endif
} mcv_device_emitter;
MCV_ASSERT_SIZE(mcv_device_emitter, 496);

typedef struct mcv_device_texture {
    uint width, height;
    uint first; /* texel */
    uint wrap_s, wrap_t, nearest;
    uint linear;         /* 1: a texel is three floats instead of one word of sRGB */
    uint first_texcoord; /* of vertex 0 in the set of texture coordinates that the image lies by */
    float transform[6];  /* mcv_texture */
    uint padding[2];
} mcv_device_texture;
MCV_ASSERT_SIZE(mcv_device_texture, 64);

/*
 * Where in the pupil, in its radii, a pixel's rays of sight meet a parallel emitter within its
 * cone, to first order: about centre + shift · (place in the pixel from its middle) in the ellipse
 * spread · (unit disk). Matrices row by row.
 */
typedef struct mcv_device_pupil_guide {
    float centre[2];
    float shift[4];
    float spread[4];
    float advantage; /* density of the points in the ellipse over that of the pupil's: 1/|det
                        spread|; 0: the pixel does not aim */
    uint padding;
} mcv_device_pupil_guide;
MCV_ASSERT_SIZE(mcv_device_pupil_guide, 48);

/* What a launch counts, per slice or in all, for the host to add up; lost energy in units of 2^-11
 * paths. */
#define MCV_COUNTERS(X) \
    X(paths) X(rays) X(shadow_rays) X(depth_cut) X(lost) X(nonfinite) X(unmatched) X(saturated)
enum {
#define MCV_X(name) MCV_COUNTER_##name,
    MCV_COUNTERS(MCV_X)
#undef MCV_X
        MCV_COUNTER_COUNT
};

/*
 * A traced ray to follow, and a vertex of its path (host/render/render.h says more). A rest is what
 * rounding to float leaves of the number before it; only with MIXED it is not 0.
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
    uint triangle;
    uint event;
    uint medium;
    float transmittance;
    float radiance;
    float distance_rest;
    float position_rest[3], normal_rest[3], direction_low[3];
    uint padding[3];
} mcv_device_vertex;
MCV_ASSERT_SIZE(mcv_device_vertex, 112);

/* So many emitters may be weighed against each other anew at each surface; of more, power alone
 * decides. */
#define MCV_MOST_REACHING 16

/* Samples that the device sums before the host goes on with the same binary tree. */
#define MCV_BLOCK 64

/*
 * What each branch of the samples of a block may have at most, so that their sum is a float:
 * 2^128 / 8 / MCV_BLOCK / 2, with room for 8 branches (MCV_SPLIT_BRANCHES is 4). More counts as not
 * finite.
 */
#define MCV_LARGEST_VALUE 0x1p118f

#endif
