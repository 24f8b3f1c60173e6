/* What the example adds to the switch of mcv_pack_material (host/device/pack_materials.c): the
 * device's numbers, in double up to the last rounding. */
case MCV_MATERIAL_LUNAR_LAMBERT:
value = material->as.lunar_lambert.reflectance;
out.as.lunar_lambert.lunar = (float)material->as.lunar_lambert.lunar;
out.scattering_sides = 1; /* emitters are sampled from the side that the path is on */
out.broad_lobe = 1;       /* there are no highlights */
break;
