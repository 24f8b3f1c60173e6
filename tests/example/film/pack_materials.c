/* What the example adds to the switch of mcv_pack_material (host/device/pack_materials.c): the
 * device's numbers, in double up to the last rounding. */
case MCV_MATERIAL_DIFFUSING_FILM:
value = material->as.diffusing_film.transmittance;
out.as.diffusing_film.spread = (float)tan(material->as.diffusing_film.spread);
out.scattering_sides = 2; /* emitters are sampled behind it, too */
break;
