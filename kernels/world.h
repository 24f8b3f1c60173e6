/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What every stage reads: the frame, the sensor and the tables of the scene, as kernel arguments
 * from one list. Features that a scene lacks leave their buffers NULL.
 */
#ifndef MCVISI_KERNELS_WORLD_H
#define MCVISI_KERNELS_WORLD_H

#include "mcvisi/buffers.h"
#include "mcvisi/contact_grid.h"
#include "mcvisi/elements.h"
#include "mcvisi/features.h"
#include "mcvisi/tables.h"
#include "mcvisi/vector.h"
#include "mcvisi/sensors/sensor.h"
#include "mcvisi/emitters/emitter.h"
#include "mcvisi/materials/material.h"
#include "traverse/bvh8.h"

#define MCV_JOIN_3(a, b, c) a##b##c
#define MCV_JOIN(a, b, c) MCV_JOIN_3(a, b, c)

/* Light that enters a lens by itself, which no camera ray meets. */
#define MCV_HAS_BEAMS (MCV_WITH_BEAM || MCV_WITH_LASER)

/* An item of a list where the scene has a feature, MCV_WITH_…; else nothing. */
#define MCV_WHERE_0(item)
#define MCV_WHERE_1(item) item
#define MCV_WHERE(feature, item) MCV_JOIN(MCV_WHERE_, feature, )(item)

#if MCV_WITH_GLOSSY
#include "mcvisi/materials/microfacet.h"
#endif

/* MCV_SENSOR is the sensor's name: its struct and its sample function follow. */
typedef MCV_JOIN(mcv_, MCV_SENSOR, ) mcv_sensor;
#define mcv_sensor_sample MCV_JOIN(mcv_, MCV_SENSOR, _sample)
#if MCV_WITH_LIGHT_TRACING
#define mcv_sensor_invert MCV_JOIN(mcv_, MCV_SENSOR, _invert)
#define mcv_sensor_connect MCV_JOIN(mcv_, MCV_SENSOR, _connect)
#define mcv_sensor_footprint MCV_JOIN(mcv_, MCV_SENSOR, _footprint)
#endif
#if MCV_WITH_PUPIL_GUIDE
#define mcv_sensor_through MCV_JOIN(mcv_, MCV_SENSOR, _through)
#endif

#if MCV_WITH_MIXED
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#include "mcvisi/precise.h"
#define MCV_PRECISE_SOLID mcv_precise_solid
#define MCV_DOUBLE double
#else
#define MCV_PRECISE_SOLID uint
#define MCV_DOUBLE uint
#endif

#define MCV_WORLD_FIELD(space, type, name, what, bytes, data) space type *name;
#define MCV_WORLD_PARAMETER(space, type, name, what, bytes, data) space type *name,
#define MCV_WORLD_ARGUMENT(space, type, name, what, bytes, data) world.name = name;
#define MCV_WORLD_PARAMETERS MCV_BUFFERS(MCV_WORLD_PARAMETER)
#if MCV_WITH_MOVING
#define MCV_WORLD_AT_REST(world) world.pose = mcv_pose_at(&world.frame->part_motion, 0.0f);
#else
#define MCV_WORLD_AT_REST(world)
#endif
#define MCV_MAKE_WORLD(world) \
    mcv_world world; \
    MCV_BUFFERS(MCV_WORLD_ARGUMENT) \
    MCV_WORLD_AT_REST(world)

typedef struct mcv_world {
    MCV_BUFFERS(MCV_WORLD_FIELD)
#if MCV_WITH_MOVING
    mcv_pose pose; /* of the moving parts, at the time of a path (path/time.h) */
#endif
} mcv_world;

/* Whether a hit is on an exact surface, not on a triangle. */
MCV_LOOP_FUNCTION int mcv_is_exact(uint hit) { return MCV_WITH_SURFACES && hit >= MCV_EXACT; }

/* A colour has one channel or three. */
typedef struct mcv_color {
    float c[MCV_CHANNELS];
} mcv_color;

/* Unrolled: a loop within keeps a loop over paths from being vectorised. */
#define MCV_EACH_CHANNEL(i) _Pragma("unroll") for (int i = 0; i < MCV_CHANNELS; ++i)

/* Of a table. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_vec_at(__global const float *v) { return mcv_vec(v[0], v[1], v[2]); }

MCV_LOOP_FUNCTION mcv_color mcv_color_at(__global const float *values) {
    mcv_color color;
    MCV_EACH_CHANNEL(i) color.c[i] = values[i];
    return color;
}

MCV_FUNCTION mcv_color mcv_grey(float value) {
    mcv_color color;
    MCV_EACH_CHANNEL(i) color.c[i] = value;
    return color;
}

MCV_FUNCTION mcv_color mcv_tint(mcv_color a, mcv_color b) {
    MCV_EACH_CHANNEL(i) a.c[i] *= b.c[i];
    return a;
}

MCV_FUNCTION mcv_color mcv_dim(mcv_color a, float s) {
    MCV_EACH_CHANNEL(i) a.c[i] *= s;
    return a;
}

MCV_FUNCTION float mcv_brightest(mcv_color a) {
    float most = a.c[0];
    MCV_EACH_CHANNEL(i) most = a.c[i] > most ? a.c[i] : most;
    return most;
}

MCV_FUNCTION float mcv_average(mcv_color a) {
    float sum = 0.0f;
    MCV_EACH_CHANNEL(i) sum += a.c[i];
    return sum / (float)MCV_CHANNELS;
}

/* How a scattering surface responds to light from a direction. */
typedef struct mcv_response {
    mcv_color f_cos; /* f cosθ [1/sr]: the share that goes on towards the ray, of L/n² */
    float density;   /* with which mcv_scatter chooses the direction [1/sr] */
    uint media;      /* the light is in */
} mcv_response;

#endif
