/* What the example adds to the switch of mcv_pack_material (host/device/pack_materials.c): the
 * device's numbers, in double up to the last rounding. */
case MCV_MATERIAL_FILTER_GLASS: {
    const mcv_filter_glass_params *p = &material->as.filter_glass;
    out.as.filter_glass.eta = (float)(1 / p->ior);
    out.as.filter_glass.delta = (float)((p->ior - 1) * (p->ior + 1) / (p->ior * p->ior));
    for (int k = 0; k < 3; ++k)
        out.as.filter_glass.absorbance[k] = (float)fmin(-log(p->internalTransmittance[k]), 1e30);
    break;
}
