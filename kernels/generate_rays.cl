/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: begins a path at the sensor. writes ray, weight, throughput 1, radiance 0 */
#include "identity.h"
#include "path.h"

/* The directions x, y, z of the optical frame, rows of world coordinates last. */
MCV_FUNCTION mcv_vec3 mcv_to_world(__constant const mcv_frame *frame, mcv_vec3 v) {
    __constant const float *m = frame->to_world;
    return mcv_vec(mcv_fma(m[0], v.x, mcv_fma(m[1], v.y, m[2] * v.z)), mcv_fma(m[3], v.x, mcv_fma(m[4], v.y, m[5] * v.z)),
                   mcv_fma(m[6], v.x, mcv_fma(m[7], v.y, m[8] * v.z)));
}

/* 1 if the path has begun. */
static int mcv_generate_ray(mcv_world world, mcv_slot slot, mcv_identity id) {
    mcv_film_sample film;
    mcv_sight sight;
    sight.weight = 0.0f;
    if (id.column < world.frame->width && id.row < world.frame->height) {
        const mcv_pair inside = mcv_sample_pair(id.stream, id.sample, MCV_PAIR_PIXEL);
        const mcv_pair aperture = mcv_sample_pair(id.stream, id.sample, MCV_PAIR_APERTURE);
        film.column = id.column;
        film.row = id.row;
        film.x = inside.x;
        film.y = inside.y;
        sight = mcv_sensor_sample(world.sensor, film, aperture.x, aperture.y);
    }
    MCV_STORE(slot, weight, 0, sight.weight);
    MCV_STORE_COLOR(slot, radiance, mcv_grey(0.0f));
    if (!(sight.weight > 0.0f)) return 0;

    __constant const float *m = world.frame->to_world;
    const mcv_vec3 origin = mcv_add(mcv_to_world(world.frame, sight.origin), mcv_vec(m[9], m[10], m[11]));
    const mcv_vec3 direction = mcv_normalize(mcv_to_world(world.frame, sight.direction));
    MCV_STORE_3(slot, origin, origin);
    MCV_STORE_3(slot, direction, direction);
    MCV_STORE_COLOR(slot, throughput, mcv_grey(1.0f));
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = world.frame->initial_media;
#endif
#if MCV_WITH_NEXT_EVENT
    MCV_STORE(slot, density, 0, 0.0f);
#endif
    return 1;
}
