/* SPDX-License-Identifier: Apache-2.0 */
/* The rays that the benchmarks follow. */
#include "workload.h"

#include <math.h>

#include "mcvisi/sampling.h"

const char *const ray_kind_names[RAY_KINDS] = {"primary", "diffuse", "glossy",
                                               "later",   "shadow",  "random"};

static const float camera[3] = {0.3f, 0.4f, 3.0f};

/* The pixels of a square image in Morton order. */
static void make_primary(uint32_t side, batch_ray *rays) {
    for (uint32_t i = 0; i < side * side; ++i) {
        uint32_t x = 0, y = 0;
        for (int bit = 0; bit < 16; ++bit) {
            x |= (i >> 2 * bit & 1) << bit;
            y |= (i >> (2 * bit + 1) & 1) << bit;
        }
        const float at[2] = {((float)x + 0.5f) / (float)side - 0.5f,
                             ((float)y + 0.5f) / (float)side - 0.5f};
        rays[i] = (batch_ray){
            {camera[0], camera[1], camera[2]}, INFINITY, {1.1f * at[0], 1.1f * at[1], -1.0f}, 0};
    }
}

/* A point of the surface and its normal, against the ray that has come there. */
typedef struct place {
    mcv_vec3 point, normal, incoming;
} place;

/* Where a ray has hit; one that misses is replaced by a point of any triangle that has an area. */
static place place_of(const mesh *m, const batch_ray *ray, mcv_hit hit, uint64_t *seed) {
    place at = {.incoming = mcv_vec(ray->direction[0], ray->direction[1], ray->direction[2])};
    for (;;) {
        mcv_vec3 p[3];
        if (hit.primitive == MCV_NONE) {
            hit.primitive = (uint32_t)(random_bits(seed) % m->triangle_count);
            hit.u = 0.5f * (float)random_unit(seed);
            hit.v = 0.5f * (float)random_unit(seed);
        }
        for (int k = 0; k < 3; ++k) {
            const float *q = m->positions + 3 * (size_t)m->indices[3 * (size_t)hit.primitive + k];
            p[k] = mcv_vec(q[0], q[1], q[2]);
        }
        at.normal = mcv_normalize(mcv_cross(mcv_sub(p[1], p[0]), mcv_sub(p[2], p[0])));
        at.point =
            mcv_along(mcv_along(mcv_scale(p[0], 1.0f - hit.u - hit.v), hit.u, p[1]), hit.v, p[2]);
        if (mcv_dot(at.normal, at.normal) > 0.5f) break;
        hit.primitive = MCV_NONE;
    }
    if (mcv_dot(at.normal, at.incoming) > 0.0f) at.normal = mcv_scale(at.normal, -1.0f);
    return at;
}

/* Far enough from the surface that Embree, which has no error bounds, does not hit it again. */
static batch_ray leave(const place *at, mcv_vec3 normal, mcv_vec3 d, float t_max) {
    const mcv_vec3 o = mcv_along(at->point, 1e-4f, normal);
    return (batch_ray){{o.x, o.y, o.z}, t_max, {d.x, d.y, d.z}, 0};
}

static mcv_vec3 cosine(mcv_vec3 normal, uint64_t *seed) {
    return mcv_from_frame(mcv_sample_cosine((float)random_unit(seed), (float)random_unit(seed)),
                          normal);
}

static void make_diffuse(const mesh *m, uint32_t count, const batch_ray *primary,
                         const mcv_hit *hits, batch_ray *rays) {
    uint64_t seed = 1;
    for (uint32_t i = 0; i < count; ++i) {
        place at = place_of(m, primary + i, hits[i], &seed);
        /* Half of them towards the inside, as into glass: outside a sphere most bounces would leave
         * the scene. */
        if (i % 2) at.normal = mcv_scale(at.normal, -1.0f);
        rays[i] = leave(&at, at.normal, cosine(at.normal, &seed), INFINITY);
    }
}

static void make_later(const mesh *m, uint32_t count, const batch_ray *diffuse, const mcv_hit *hits,
                       batch_ray *rays) {
    uint64_t seed = 3;
    for (uint32_t i = 0; i < count; ++i) {
        const place at = place_of(m, diffuse + i, hits[i], &seed);
        rays[i] = leave(&at, at.normal, cosine(at.normal, &seed), INFINITY);
    }
}

static void make_glossy(const mesh *m, uint32_t count, const batch_ray *primary,
                        const mcv_hit *hits, batch_ray *rays) {
    enum { TRIALS = 16 };
    uint64_t seed = 4;
    for (uint32_t i = 0; i < count; ++i) {
        const place at = place_of(m, primary + i, hits[i], &seed);
        mcv_vec3 d = at.normal;
        for (int trial = 0; trial < TRIALS; ++trial) {
            const float slope = 0.3f * sqrtf(-logf(1.0f - (float)random_unit(&seed))),
                        angle = 6.2831853f * (float)random_unit(&seed);
            const mcv_vec3 facet = mcv_normalize(
                mcv_from_frame(mcv_vec(slope * cosf(angle), slope * sinf(angle), 1.0f), at.normal));
            const mcv_vec3 reflected =
                mcv_along(at.incoming, -2.0f * mcv_dot(at.incoming, facet), facet);
            if (mcv_dot(reflected, at.normal) <= 0.0f) continue;
            d = reflected;
            break;
        }
        rays[i] = leave(&at, at.normal, d, INFINITY);
    }
}

static void make_shadow(const mesh *m, uint32_t count, const batch_ray *primary,
                        const mcv_hit *hits, batch_ray *rays) {
    uint64_t seed = 5;
    for (uint32_t i = 0; i < count; ++i) {
        const place at = place_of(m, primary + i, hits[i], &seed);
        const float angle = 6.2831853f * (float)random_unit(&seed);
        const mcv_vec3 light =
            mcv_vec(camera[0] + 1.2f * cosf(angle), camera[1] + 1.2f * sinf(angle), camera[2]);
        rays[i] = leave(&at, at.normal, mcv_sub(light, at.point), 1.0f);
    }
}

static void make_random(uint32_t count, batch_ray *rays) {
    uint64_t seed = 2;
    for (uint32_t i = 0; i < count; ++i) {
        rays[i].t_max = INFINITY;
        for (int k = 0; k < 3; ++k) rays[i].origin[k] = (float)(2.4 * random_unit(&seed) - 1.2);
        for (int k = 0; k < 3; ++k)
            rays[i].direction[k] = (float)(2.4 * random_unit(&seed) - 1.2) - rays[i].origin[k];
    }
}

/* Closest hits by one thread, which is there already. */
static void cast_all(RTCScene scene, const batch_ray *rays, uint32_t count, mcv_hit *hits) {
    embree_cast all = {scene, rays, count, 1, 1, false, hits, NULL};
    mcv_error error;
    (void)embree_run(&all, &error);
}

void workload_make_rays(const bench *b, const mesh *m, RTCScene scene, mcv_hit *hits,
                        workload_rays *made) {
    const uint32_t side = b->quick ? 128 : 512;
    made->count = side * side;
    make_primary(side, made->rays[PRIMARY]);
    cast_all(scene, made->rays[PRIMARY], made->count, hits);
    make_diffuse(m, made->count, made->rays[PRIMARY], hits, made->rays[DIFFUSE]);
    make_glossy(m, made->count, made->rays[PRIMARY], hits, made->rays[GLOSSY]);
    make_shadow(m, made->count, made->rays[PRIMARY], hits, made->rays[SHADOW]);
    cast_all(scene, made->rays[DIFFUSE], made->count, hits);
    make_later(m, made->count, made->rays[DIFFUSE], hits, made->rays[LATER]);
    make_random(made->count, made->rays[RANDOM]);
}
