/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: begins a path at the sensor. writes ray, weight, throughput 1, radiance 0 */
#include "identity.h"
#include "path.h"
#include "sight.h"

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
#if MCV_WITH_AIM
        sight = mcv_aimed_sight(world, film, aperture);
#else
        sight = mcv_sensor_sample(world.sensor, film, aperture.x, aperture.y);
#endif
    }
    MCV_STORE(slot, weight, 0, sight.weight);
    MCV_STORE_COLOR(slot, radiance, mcv_grey(0.0f));
    if (!(sight.weight > 0.0f)) return 0;

    const mcv_ray ray = mcv_place_sight(world.frame, sight);
    MCV_STORE_3(slot, origin, ray.origin);
    MCV_STORE_3(slot, direction, ray.direction);
    MCV_STORE_COLOR(slot, throughput, mcv_grey(1.0f));
#if MCV_WITH_DIELECTRIC
    MCV_WORD(slot, media, 0) = world.frame->initial_media;
#endif
#if MCV_WITH_NEXT_EVENT
    MCV_STORE(slot, density, 0, 0.0f);
#endif
    return 1;
}
