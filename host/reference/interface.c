/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/interface.h"

void ref_fresnel(double from, double to, double cosine, double *perpendicular, double *parallel) {
    const double sine = from / to * sqrt((1 - cosine) * (1 + cosine)); /* of the angle of refraction */
    *perpendicular = *parallel = 1;
    if (sine >= 1) return;
    const double other = sqrt((1 - sine) * (1 + sine));
    const double s = (from * cosine - to * other) / (from * cosine + to * other);
    const double p = (to * cosine - from * other) / (to * cosine + from * other);
    *perpendicular = s * s;
    *parallel = p * p;
}

/* Snell with the tangential part, which keeps its digits near normal incidence. */
static ref_interface interface_by(ref_vec normal, ref_vec direction, double from, double to) {
    ref_interface result = {.normal = normal, .reflectance = 1};
    const double cosine = -ref_dot(direction, normal);
    result.reflected = ref_add(direction, ref_scale(2 * cosine, normal));
    const ref_vec tangential = ref_scale(from / to, ref_add(direction, ref_scale(cosine, normal)));
    const double squared = ref_dot(tangential, tangential);
    if (from == to) {
        result.reflectance = 0;
        result.refracted = direction;
    } else if (squared < 1) {
        double s, p;
        ref_fresnel(from, to, fmin(cosine, 1), &s, &p);
        result.reflectance = 0.5 * (s + p);
        result.refracted = ref_unit(ref_sub(tangential, ref_scale(sqrt(1 - squared), normal)));
    }
    return result;
}

static ref_vec toward(ref_vec normal, bool front) { return front ? normal : ref_scale(-1, normal); }

ref_interface ref_interface_at(const ref_surface *surface, ref_vec direction, double from, double to) {
    const bool front = ref_dot(direction, surface->geometric) < 0;
    const ref_vec geometric = toward(surface->geometric, front), normal = toward(surface->normal, front);
    ref_interface result = interface_by(normal, direction, from, to);
    if (ref_dot(direction, normal) >= 0 || ref_dot(result.reflected, geometric) <= 0 || ref_dot(result.refracted, geometric) > 0)
        result = interface_by(geometric, direction, from, to);
    result.front = front;
    return result;
}

ref_vec ref_facing_normal(const ref_surface *surface, ref_vec direction) {
    return toward(surface->normal, ref_dot(direction, surface->geometric) < 0);
}
