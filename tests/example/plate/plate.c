/* What the example adds to the switch of ref_plate_at (host/reference/plate.c): the model once
 * more, from its formulas. `outside` is the index of the medium around the plate. */
case MCV_MATERIAL_FILTER_GLASS: {
    const mcv_filter_glass_params *p = &material->as.filter_glass;
    const double once = ref_reflectance(interaction, outside, p->ior),
                 sine = ref_length(ref_cross(interaction->direction, interaction->normal));
    const double behind = sqrt(fmax(1 - pow(outside / p->ior * sine, 2), 0)); /* cosθ' */
    for (int channel = 0; channel < 3 && once < 1; ++channel) {
        const double tau = pow(p->internalTransmittance[channel], 1 / behind);
        plate.passed[channel] = pow(1 - once, 2) * tau / (1 - pow(once * tau, 2));
        plate.reflected[channel] = once + plate.passed[channel] * once * tau;
    }
    for (int channel = 0; channel < 3 && once == 1; ++channel) plate.reflected[channel] = 1;
    break;
}
