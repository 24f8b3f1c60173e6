/* What the example adds to host/reference/path_surface.c: the model once more, from its formulas. o
 * and i are in the surface's frame, z its normal; light comes from below. It returns the density
 * with which sample_diffusing_film chooses i. */
static double evaluate_diffusing_film(const ref_scatterer *s, ref_vec i, double value[3]) {
    const mcv_diffusing_film_params *p = &s->material->as.diffusing_film;
    const double off = ref_angle(ref_scale(-1, s->o), i), a = tan(p->spread);
    const bool comes = i.z < 0 && off < M_PI / 2;
    const double density =
        comes ? a * a * cos(off) / (M_PI * pow(pow(a * cos(off), 2) + pow(sin(off), 2), 2)) : 0;
    for (int channel = 0; channel < 3; ++channel)
        value[channel] = p->transmittance[channel] * density * -i.z / fmax(s->o.z, -i.z);
    return density;
}

static ref_vec sample_diffusing_film(const ref_scatterer *s, ref_random *random) {
    const double u = ref_random_unit(random), phi = 2 * M_PI * ref_random_unit(random);
    const double off = atan(tan(s->material->as.diffusing_film.spread) * sqrt(u / (1 - u)));
    const ref_vec through = ref_scale(-1, s->o);
    ref_vec x, y;
    ref_frame(through, &x, &y);
    return ref_add(ref_scale(cos(off), through),
                   ref_add(ref_scale(sin(off) * cos(phi), x), ref_scale(sin(off) * sin(phi), y)));
}
