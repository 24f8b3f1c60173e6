/* SPDX-License-Identifier: Apache-2.0 */
/* For tests: how far rays followed in mixed precision are from the reference renderer's. */
#ifndef MCVISI_TESTS_AGREEMENT_H
#define MCVISI_TESTS_AGREEMENT_H

#include "exact_builder.h"
#include "reference/vector.h"
#include "scene/geometry.h"

/* What a ray is off by: place [m] and direction [rad]. */
typedef struct off_by {
    double place, way;
} off_by;

/*
 * What it may be off by beyond a surface, where numbers up to `largest` are rounded to the unit e.
 * The place where it meets the surface errs by the rounding of t, place and frame, and by what the
 * ray was off before, 1/cos i as much along the surface. A refracted direction errs by 4 e (1 + η
 * tan θ_t) and, turned by no more than 1 + η (1 + tan θ_t) times as much, by the incident one's
 * error and the normal's, which is 4 e and the place's error over the radius of curvature; a
 * reflected one (η = 0) by 4 e, the incident one's error and twice the normal's.
 */
static inline off_by off_beyond(off_by before, double e, double largest, double distance,
                                double cosine, double radius, double eta) {
    const double sine = eta * sqrt(fmax(0, 1 - cosine * cosine)),
                 tangent = sine / sqrt(fmax(0, 1 - sine * sine));
    const double place = (20 * e * largest + before.place + distance * before.way) / cosine,
                 normal = 4 * e + place / radius;
    if (eta == 0) return (off_by){place, 4 * e + before.way + 2 * normal};
    return (off_by){place, 4 * e * (1 + eta * tangent) +
                               (before.way + normal) * (1 + eta * (1 + tangent))};
}

/* The cosine between a vertex's face and the ray that comes from the one before. */
static inline double cosine_at(const mcv_scene *scene, const mcv_vertex *v) {
    ref_vec face = ref_from(v->normal);
    if (v->primitive < scene->triangle_count) {
        double normal[3];
        const uint32_t instance = mcv_scene_instance_of(scene, v->primitive);
        mcv_scene_face_normal(scene, instance,
                              v->primitive - scene->instances[instance].first_triangle, normal);
        face = ref_unit(ref_from(normal));
    }
    return fabs(ref_dot(face, ref_from(v[-1].direction)));
}

static inline double farther(const double a[3], const double b[3]) {
    return fmax(fmax(fabs(a[0] - b[0]), fabs(a[1] - b[1])), fabs(a[2] - b[2]));
}

typedef struct agreement {
    int met, beyond;  /* vertices, and rays that go beyond their bounds or other ways */
    off_by worst;     /* as a share of its bound */
    double first_two; /* vertices of each ray: the farthest [m] */
} agreement;

/* Radii of curvature are at least `radius`. */
static inline agreement agree(const mcv_scene *scene, const traced *rays, const traced *truth,
                              double e, double largest, double radius) {
    agreement found = {0};
    off_by bound = {0};
    bool lost = false;
    const mcv_vertex *b = truth->vertices, *end = b + truth->count;
    for (const mcv_vertex *a = rays->vertices; a < rays->vertices + rays->count; ++a) {
        while (b < end && (b->ray < a->ray || (b->ray == a->ray && b->index < a->index))) ++b;
        if (a->index == 0) {
            bound = (off_by){0, 3 * e};
            lost = false;
            continue;
        }
        if (lost) continue;
        lost = b == end || b->ray != a->ray || b->event != a->event || b->primitive != a->primitive;
        if (!lost && a->event != MCV_EVENT_MISS) {
            const double eta = a->event == MCV_EVENT_REFLECT ? 0 : b[-1].ior / b->ior;
            const off_by off = {farther(a->position, b->position),
                                farther(a->direction, b->direction)};
            bound = off_beyond(bound, e, largest, b->distance, cosine_at(scene, b), radius, eta);
            lost = !(off.place <= bound.place && off.way <= bound.way);
            if (a->index <= 2) found.first_two = fmax(found.first_two, off.place);
            if (!lost)
                found.worst = (off_by){fmax(found.worst.place, off.place / bound.place),
                                       fmax(found.worst.way, off.way / bound.way)};
            ++found.met;
        }
        found.beyond += lost;
    }
    return found;
}

/* The rays by single and mixed precision against the reference's: at most one of a thousand goes on
 * in single precision, as rounded. */
static inline void expect_agreement(const char *what, const mcv_scene *scene,
                                    const mcv_trace_ray *rays, int count, double largest,
                                    double radius) {
    const traced truth = follow(scene, BY_REFERENCE, rays, (size_t)count);
    const traced mixed = follow(scene, BY_MIXED, rays, (size_t)count),
                 single = follow(scene, BY_DEVICE, rays, (size_t)count);
    const agreement found = agree(scene, &mixed, &truth, 0x1p-48, largest, radius);
    const agreement rounded = agree(scene, &single, &truth, 0x1p-24, largest, radius);
    print_message("  %s: %d meetings, place %.2f of its bound, direction %.2f, %d rays beyond; "
                  "first two within %.2g m, single %.2g m\n",
                  what, found.met, found.worst.place, found.worst.way, found.beyond,
                  found.first_two, rounded.first_two);
    assert_true(found.met > count);
    if (found.beyond > count / 1000)
        fail_msg("%s: %d of %d rays are farther off than mixed precision rounds", what,
                 found.beyond, count);
    free(truth.vertices);
    free(mixed.vertices);
    free(single.vertices);
}

#endif
