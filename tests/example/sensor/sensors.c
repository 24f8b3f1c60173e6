
/* --- crossed slits: what the example adds to host/scene/sensors.c
 * ----------------------------------------------- */

/* Derives what follows from other parameters (here nothing), and refuses what the sensor cannot do;
 * ranges are checked already. */
mcv_result mcv_crossed_slits_resolve(mcv_crossed_slits_params *params, const mcv_json_path *place,
                                     mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "radiometry");
    if (params->radiometry == MCV_RADIOMETRY_RADIANCE) return MCV_OK;
    return mcv_fail_at(&here, error,
                       "a camera with slits has no aperture, so no irradiance: use \"radiance\"");
}

/* The device's struct, in double up to the last rounding. */
void mcv_crossed_slits_prepare(const mcv_crossed_slits_params *params, mcv_crossed_slits *device) {
    const mcv_readout readout = read_out(MCV_FILM(params));
    const double b = params->imageDistance, h = params->slitDistance;
    *device = (mcv_crossed_slits){
        .centre_x = centre(&readout, 0, readout.binning[0]),
        .centre_y = centre(&readout, 1, readout.binning[1]),
        .slope_x = (float)(readout.binning[0] * params->pixelSize[0] / b),
        .slope_y = (float)(readout.binning[1] * params->pixelSize[1] / (b + h)),
        .ahead = (float)h,
    };
}
