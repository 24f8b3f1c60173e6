/* What the example adds to the switch of ref_meet_surface (host/reference/path_surface.c): the
 * model once more, from its formulas. interface_at knows the media of both sides; light that comes
 * from the side of the index s.from is on the path's side. `share` and `passed` are those of a
 * diffuse surface, and of L/n². */
case MCV_MATERIAL_GROUND_GLASS: {
    ref_scatterer s = interface_at(world, p, surface, hits, random, tally);
    const double passed =
        (1 - material->as.ground_glass.diffuseReflectance) * pow(fmin(s.from, s.to) / s.from, 2);
    for (int channel = 0; channel < 3; ++channel) {
        s.share[channel] = 1 - passed;
        s.passed[channel] = passed;
    }
    if (s.from != s.to) return ref_scatter(world, p, surface, &s, last, random, tally, radiance);
    p->media = s.far;
    return true;
}
