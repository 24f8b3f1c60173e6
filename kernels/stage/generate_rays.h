/* SPDX-License-Identifier: Apache-2.0 */
/* Stage: begins a path at the sensor. */
#ifndef MCVISI_KERNELS_GENERATE_RAYS_H
#define MCVISI_KERNELS_GENERATE_RAYS_H

#include "path/identity.h"
#include "path/camera_path.h"
#include "path/dispersion.h"
#include "path/sensor_ray.h"

/* The camera ray of a sample, in the sensor's frame, without weight beside the film. *time: when.
 */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_sample_sensor_ray(mcv_world world, mcv_identity id,
                                                       float *time) {
    const int on_film = id.column < world.frame->width && id.row < world.frame->height;
    const mcv_pair inside = mcv_sample_pair(id.stream, id.sample, MCV_PAIR_PIXEL);
    const mcv_pair aperture = mcv_sample_pair(id.stream, id.sample, MCV_PAIR_APERTURE);
    mcv_sensor_ray sensor_ray;
    mcv_film_sample film;
    film.column = on_film ? id.column : 0u;
    film.row = on_film ? id.row : 0u;
    film.x = inside.x;
    film.y = inside.y;
    *time = 0.0f;
#if MCV_WITH_MOTION
    const mcv_pair lot = mcv_sample_pair(id.stream, id.sample, MCV_PAIR_TIME);
    const mcv_moment moment = mcv_expose(&world.frame->motion, film.row, lot.x, lot.y);
    if (world.frame->motion.shutter == MCV_SHUTTER_LINE)
        film = mcv_on_line(film, world.sensor->centre_y, moment.stage);
    sensor_ray =
        mcv_moved(&world.frame->motion.sensor,
                  mcv_sensor_sample(world.sensor, film, aperture.x, aperture.y), moment.time);
    sensor_ray.weight *= moment.weight;
    *time = moment.time;
#elif MCV_WITH_PUPIL_GUIDE
    sensor_ray = mcv_guided_sensor_ray(world, film, aperture);
#else
    sensor_ray = mcv_sensor_sample(world.sensor, film, aperture.x, aperture.y);
#endif
    sensor_ray.weight = on_film ? sensor_ray.weight : 0.0f;
    return sensor_ray;
}

/* A camera ray becomes the path's, in the scene. */
MCV_LOOP_FUNCTION void mcv_store_sensor_ray(mcv_world world, mcv_slot slot,
                                            mcv_sensor_ray sensor_ray) {
#if MCV_WITH_MIXED
    const mcv_precise_ray precise = mcv_place_sensor_ray_precisely(world.frame, sensor_ray);
    const mcv_vec3 origin = mcv_narrow(precise.origin);
    const mcv_vec3 direction = mcv_narrow(precise.direction);
    MCV_STORE_3(slot, origin, origin);
    MCV_STORE_3(slot, direction, direction);
    MCV_STORE_3(slot, origin_low, mcv_low_of(precise.origin, origin));
    MCV_STORE_3(slot, direction_low, mcv_low_of(precise.direction, direction));
#else
    const mcv_ray ray = mcv_place_sensor_ray(world.frame, sensor_ray);
    MCV_STORE_3(slot, origin, ray.origin);
    MCV_STORE_3(slot, direction, ray.direction);
#endif
}

/* 1 if the path has begun. */
MCV_LOOP_FUNCTION int mcv_generate_ray(mcv_world world, mcv_slot slot, mcv_identity id) {
    float time;
    const mcv_sensor_ray sensor_ray = mcv_sample_sensor_ray(world, id, &time);
    mcv_store_sensor_ray(world, slot, sensor_ray);
    MCV_STORE(slot, weight, 0, sensor_ray.weight);
    MCV_EACH_CHANNEL(i) {
        MCV_STORE(slot, throughput, i, 1.0f);
        MCV_STORE(slot, radiance, i, 0.0f);
    }

#if MCV_WITH_DISPERSION
    /* A sensor within glass may look into that glass before it meets any. */
    if (world.frame->initial_media != 0u) {
        float chance;
        const uint kept = mcv_choose_channel(
            mcv_grey(1.0f), mcv_sample_pair(id.stream, id.sample, MCV_PAIR_CHANNEL).x, &chance);
        const mcv_color throughput = mcv_keep_channel(mcv_grey(1.0f), kept, chance);
        MCV_STORE_COLOR(slot, throughput, throughput);
    }
#endif
    if (MCV_WITH_DIELECTRIC) MCV_WORD(slot, media, 0) = world.frame->initial_media;
    if (MCV_WITH_SURFACES) MCV_WORD(slot, origin_surface, 0) = MCV_NONE;
    if (MCV_WITH_NEXT_EVENT) MCV_STORE(slot, density, 0, 0.0f);
    if (MCV_WITH_LIGHT_TRACING) MCV_WORD(slot, path_class, 0) = MCV_PATH_CLASS_STRAIGHT;
    if (MCV_WITH_SPLIT) MCV_WORD(slot, branch_number, 0) = 0u;
    if (MCV_WITH_RECORDS) MCV_WORD(slot, cell, 0) = id.cell;
#if MCV_WITH_MOVING
    MCV_STORE(slot, time, 0, time);
#endif
    MCV_WORD(slot, stream, 0) = id.stream;
    MCV_WORD(slot, sample, 0) = id.sample;
    return sensor_ray.weight > 0.0f;
}

#endif
