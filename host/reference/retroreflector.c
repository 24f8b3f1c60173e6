/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/retroreflector.h"

static const double least_divergence = 1e-4;

static double largest(const double a[3]) { return fmax(a[0], fmax(a[1], a[2])); }

static double width(const mcv_retroreflector_params *p) {
    return tan(fmax(p->divergence, least_divergence));
}

double ref_retroreflector_efficiency(const mcv_retroreflector_params *p, ref_vec o) {
    return 1 / (1 + pow(hypot(o.x, o.y) / o.z / tan(p->entranceAngle), 4));
}

double ref_retroreflector_chance(const mcv_retroreflector_params *p, ref_vec o) {
    const double returned = largest(p->reflectance) * ref_retroreflector_efficiency(p, o);
    return returned > 0 ? returned / (returned + largest(p->diffuseReflectance)) : 0;
}

double ref_retroreflector_evaluate(const mcv_retroreflector_params *p, ref_vec o, ref_vec i,
                                   double value[3]) {
    value[0] = value[1] = value[2] = 0;
    if (i.z <= 0) return 0;
    const double off = ref_angle(o, i), a = width(p), chance = ref_retroreflector_chance(p, o);
    const double lobe =
        off < M_PI / 2 ? a * a / (M_PI * pow(a * a + pow(tan(off), 2), 2) * pow(cos(off), 3)) : 0;
    const double both =
        sqrt(ref_retroreflector_efficiency(p, o) * ref_retroreflector_efficiency(p, i));
    for (int channel = 0; channel < 3; ++channel)
        value[channel] = i.z * (p->reflectance[channel] * both * lobe / fmax(o.z, i.z) +
                                p->diffuseReflectance[channel] / M_PI);
    return chance * lobe + (1 - chance) * i.z / M_PI;
}

ref_vec ref_retroreflector_sample(const mcv_retroreflector_params *p, ref_vec o,
                                  ref_random *random) {
    const bool returns = ref_random_unit(random) < ref_retroreflector_chance(p, o);
    const double u = ref_random_unit(random), phi = 2 * M_PI * ref_random_unit(random);
    if (!returns) return (ref_vec){sqrt(u) * cos(phi), sqrt(u) * sin(phi), sqrt(1 - u)};
    const double off = atan(width(p) * sqrt(u / (1 - u)));
    ref_vec x, y;
    ref_frame(o, &x, &y);
    return ref_add(ref_scale(cos(off), o),
                   ref_add(ref_scale(sin(off) * cos(phi), x), ref_scale(sin(off) * sin(phi), y)));
}
