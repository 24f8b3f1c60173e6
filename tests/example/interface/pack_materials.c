/* What the example adds to the switch of mcv_pack_material (host/device/pack_materials.c): the
 * device's numbers, in double up to the last rounding. Emitters are sampled on both sides. */
case MCV_MATERIAL_GROUND_GLASS:
out.as.ground_glass.passed = (float)(1 - material->as.ground_glass.diffuseReflectance);
out.scattering_sides = 2;
out.broad_lobe = 1;
break;
