/* SPDX-License-Identifier: Apache-2.0 */
/* Single elements on the device (kernels/test/elements.cl), for the tests that see what the stages
 * see. */
#ifndef MCVISI_TESTS_ELEMENTS_H
#define MCVISI_TESTS_ELEMENTS_H

#include "scene_builder.h"
#include "device/features.h"

#include "cl/cl.h"
#include "reference/random.h"
#include "reference/sensor_ray.h"
#include "reference/vector.h"
#include "device/pack.h"
#include "render/render.h"
#include "scene/sensors.h"

static mcv_cl cl;

static inline int open_device(void **state) {
    (void)state;
    return mcv_cl_open(NULL, &cl, &builder_error) == MCV_OK ? 0 : -1;
}

static inline int close_device(void **state) {
    (void)state;
    mcv_cl_close(&cl);
    return 0;
}

static uint64_t element_features; /* that elements.cl is compiled for */

/* Runs a kernel of elements.cl over `count` cases, a multiple of 64. Without a first argument,
 * `first_bytes` is 0. */
static inline void run_elements(const char *kernel_name, uint32_t sensor_type, const void *first,
                                size_t first_bytes, size_t count, const void *in, size_t in_bytes,
                                void *out, size_t out_bytes) {
    static char built[2048]; /* what the program below is for */
    static cl_program program;
    char options[2048];
    cl_kernel kernel;
    cl_mem first_buffer = NULL;
    cl_mem in_buffer;
    cl_mem out_buffer;
    mcv_feature_defines(element_features, 1, sensor_type, MCV_SAMPLER_SOBOL, MCV_BLOCK, options,
                        sizeof options);
    if (strcmp(options, built) != 0) {
        if (program) clReleaseProgram(program);
        BUILD(mcv_cl_build(&cl, "test/elements", options, &program, &builder_error));
        strcpy(built, options);
    }
    BUILD(mcv_cl_kernel(program, kernel_name, &kernel, &builder_error));
    BUILD(mcv_cl_buffer(&cl, "cases", in_bytes, in, &in_buffer, &builder_error));
    BUILD(mcv_cl_buffer(&cl, "results", out_bytes, NULL, &out_buffer, &builder_error));
    if (first_bytes > 0) {
        BUILD(mcv_cl_buffer(&cl, "element", first_bytes, first, &first_buffer, &builder_error));
        BUILD(MCV_LAUNCH(&cl, kernel, count, 64, &builder_error, MCV_ARG(first_buffer),
                         MCV_ARG(in_buffer), MCV_ARG(out_buffer)));
    } else {
        BUILD(MCV_LAUNCH(&cl, kernel, count, 64, &builder_error, MCV_ARG(in_buffer),
                         MCV_ARG(out_buffer)));
    }
    BUILD(mcv_cl_read(&cl, out_buffer, 0, out_bytes, out, &builder_error));
    mcv_cl_release(&first_buffer);
    mcv_cl_release(&in_buffer);
    mcv_cl_release(&out_buffer);
    clReleaseKernel(kernel);
}

static inline float *floats(size_t count) {
    float *memory = malloc(count * sizeof *memory);
    assert_non_null(memory);
    return memory;
}

/* A direction with z from `least` to `most`, all alike. */
static inline ref_vec direction(ref_random *random, double least, double most) {
    const double z = least + (most - least) * ref_random_unit(random),
                 phi = 2 * M_PI * ref_random_unit(random), s = sqrt(1 - z * z);
    return (ref_vec){s * cos(phi), s * sin(phi), z};
}

/* Rounds a direction to float32. */
static inline ref_vec put(float *to, ref_vec v) {
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
    return (ref_vec){to[0], to[1], to[2]};
}

/* Runs a kernel whose first argument is a sensor. */
static inline void run_sensor(const char *kernel_name, const mcv_sensor *sensor, size_t count,
                              const void *cases, size_t case_bytes, void *results,
                              size_t result_bytes) {
    union {
#define MCV_X(name, key, NAME) mcv_##name name;
        MCV_SENSORS(MCV_X)
#undef MCV_X
    } device;
    memset(&device, 0, sizeof device);
    switch (sensor->type) {
#define MCV_X(name, key, NAME) \
    case MCV_SENSOR_##NAME: \
        mcv_##name##_prepare(&sensor->as.name, &device.name); \
        break;
        MCV_SENSORS(MCV_X)
#undef MCV_X
    default:
        fail_msg("sensor type %u is unknown", sensor->type);
    }
    run_elements(kernel_name, sensor->type, &device, sizeof device, count, cases,
                 case_bytes * count, results, result_bytes * count);
}

/* Camera rays of `count` cases: column, row, x, y, ξ, η as words, integers first; to origin,
 * direction, weight in the optical frame. */
static inline void device_sights(const mcv_sensor *sensor, size_t count, const uint32_t *cases,
                                 float *sights) {
    run_sensor("sample_sensor", sensor, count, cases, 6 * sizeof(uint32_t), sights,
               7 * sizeof(float));
}

/* The unit square to the unit disk as mcvisi/sampling.h documents it (Shirley and Chiu), in double:
 * radius and angle. */
static inline void concentric(double xi, double eta, double *radius, double *angle) {
    const double a = 2 * xi - 1;
    const double b = 2 * eta - 1;
    if (a == 0 && b == 0)
        *radius = *angle = 0;
    else if (fabs(a) > fabs(b))
        *radius = a, *angle = M_PI / 4 * b / a;
    else
        *radius = b, *angle = M_PI / 2 - M_PI / 4 * a / b;
}

/* The reference's camera ray for such a case. */
static inline ref_sensor_ray reference_sight(const mcv_sensor *sensor, const uint32_t in[6]) {
    double radius, angle;
    concentric(as_float(in[4]), as_float(in[5]), &radius, &angle);
    double turn = radius < 0 ? angle / (2 * M_PI) + 0.5 : angle / (2 * M_PI);
    turn -= floor(turn);
    const bool disk =
        sensor->type != MCV_SENSOR_LIGHT_FIELD; /* which takes the aperture sample as it is */
    return ref_sensor_ray_sample(sensor, in[0], in[1], as_float(in[2]), as_float(in[3]),
                                 disk ? radius * radius : (double)as_float(in[4]),
                                 disk ? turn : (double)as_float(in[5]));
}

/* Camera rays of one of the renderers in the world; directions need not be unit. */
static inline void sights_by(bool reference, const mcv_sensor *sensor, size_t count,
                             const uint32_t *cases, ref_sensor_ray *sights) {
    float *device = reference ? NULL : floats(7 * count);
    if (!reference) device_sights(sensor, count, cases, device);
    for (size_t i = 0; i < count; ++i) {
        if (reference) {
            sights[i] = reference_sight(sensor, cases + 6 * i);
            continue;
        }
        const float *s = device + 7 * i;
        double p[3], d[3];
        mcv_transform_point(&sensor->to_world, (const double[3]){s[0], s[1], -s[2]},
                            p); /* the node looks along its -z */
        mcv_transform_vector(&sensor->to_world, (const double[3]){s[3], s[4], -s[5]}, d);
        sights[i] =
            (ref_sensor_ray){.origin = ref_from(p), .direction = ref_from(d), .weight = s[6]};
    }
    free(device);
}

#endif
