/* What the example adds to host/reference/path_surface.c: the model once more, from its formulas. o
 * and i are in the surface's frame, z its normal. It returns the density of i: the cosine's, by
 * which the reference renderer chooses where a material says nothing else. */
static double evaluate_lunar_lambert(const ref_scatterer *s, ref_vec i, double value[3]) {
    const mcv_lunar_lambert_params *p = &s->material->as.lunar_lambert;
    for (int channel = 0; channel < 3; ++channel)
        value[channel] = i.z > 0 ? p->reflectance[channel] / M_PI * i.z *
                                       (p->lunar / (2 * (i.z + s->o.z)) + 1 - p->lunar)
                                 : 0;
    return fmax(i.z, 0) / M_PI;
}
