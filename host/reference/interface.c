/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/interface.h"

ref_interaction ref_make_interaction(const ref_surface *surface, ref_vec direction) {
    ref_interaction interaction = {.direction = direction,
                                   .front = ref_dot(direction, surface->geometric) < 0};
    interaction.face = ref_scale(interaction.front ? 1 : -1, surface->geometric);
    interaction.normal = ref_scale(interaction.front ? 1 : -1, surface->normal);
    if (ref_dot(direction, interaction.normal) >= 0) interaction.normal = interaction.face;
    return interaction;
}

void ref_fresnel(double from, double to, double cosine, double *perpendicular, double *parallel) {
    const double sine =
        from / to * sqrt((1 - cosine) * (1 + cosine)); /* of the angle of refraction */
    *perpendicular = *parallel = 1;
    if (sine >= 1) return;
    const double other = sqrt((1 - sine) * (1 + sine));
    const double s = (from * cosine - to * other) / (from * cosine + to * other);
    const double p = (to * cosine - from * other) / (to * cosine + from * other);
    *perpendicular = s * s;
    *parallel = p * p;
}

double ref_reflectance(const ref_interaction *interaction, double from, double to) {
    double s, p;
    if (from == to) return 0;
    ref_fresnel(from, to, fmin(-ref_dot(interaction->direction, interaction->normal), 1), &s, &p);
    return 0.5 * (s + p);
}

double ref_coated(double bare, double coating, double from, double to) {
    const double normal = (from - to) * (from - to) / ((from + to) * (from + to));
    return coating > 0 ? fmax(0, coating + (1 - coating) * (bare - normal) / (1 - normal)) : bare;
}

static ref_vec reflect_at(ref_vec normal, ref_vec direction) {
    return ref_unit(ref_sub(direction, ref_scale(2 * ref_dot(direction, normal), normal)));
}

ref_vec ref_reflect(const ref_interaction *interaction) {
    const ref_vec reflected = reflect_at(interaction->normal, interaction->direction);
    return ref_dot(reflected, interaction->face) > 0
               ? reflected
               : reflect_at(interaction->face, interaction->direction);
}

/* Snell's law for the part along the surface, which keeps its digits near normal incidence.
 * Straight on under total reflection. */
static ref_vec refract_at(ref_vec normal, ref_vec direction, double ratio) {
    const ref_vec along =
        ref_scale(ratio, ref_sub(direction, ref_scale(ref_dot(direction, normal), normal)));
    const double squared = ref_dot(along, along);
    return squared < 1 ? ref_unit(ref_sub(along, ref_scale(sqrt(1 - squared), normal))) : direction;
}

ref_vec ref_refract(const ref_interaction *interaction, double from, double to) {
    if (from == to) return interaction->direction;
    const ref_vec refracted = refract_at(interaction->normal, interaction->direction, from / to);
    return ref_dot(refracted, interaction->face) < 0
               ? refracted
               : refract_at(interaction->face, interaction->direction, from / to);
}
