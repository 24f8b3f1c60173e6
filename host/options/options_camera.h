/* SPDX-License-Identifier: Apache-2.0 */
/* The options of cameras, from light to grey values: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_CAMERA_H
#define MCVISI_HOST_OPTIONS_OPTIONS_CAMERA_H

#define MCV_CAMERA_OPTIONS(X) \
    X(time, exposure_time, "exposure-time", 0, "T", MCV_IN_EXPOSES, NULL, 0, 1e9, \
      "EMVA's t_exp [s], or with a unit, 10ms; together with eta, lambda and the pixel size " \
      "in the image's header it gives the electrons per irradiance; with --electrons-per-unit " \
      "or --expose-to instead, it only scales --dark-current") \
    X(channels, quantum_efficiency, "quantum-efficiency", 0, "ETA[,ETA,ETA]", MCV_IN_EXPOSES, \
      "0.6", 0, 1, "eta: electrons per photon, one number or those of red, green and blue") \
    X(lengths, wavelength, "wavelength", 0, "L[,L,L]", MCV_IN_EXPOSES, "550nm", 0, 1e-3, \
      "lambda [m], or with a unit, 630nm; one number or those of red, green and blue; a " \
      "photon has the energy h c / lambda") \
    X(channels, electrons_per_unit, "electrons-per-unit", 0, "N[,N,N]", MCV_IN_EXPOSES, NULL, 0, \
      1e30, "mean electrons mu_e for 1 W/m^2 of irradiance or 1 W/(m^2 sr) of radiance") \
    X(number, expose_to, "expose-to", 0, "F", MCV_IN_EXPOSES, NULL, 0, 1000, \
      "choose the exposure so that the bright parts of the image reach F times the full well " \
      "on average; their level is the brightness-weighted mean of the image or, if larger, " \
      "that of the brightest blocks of 16 x 16 pixels; it does not depend on the number of " \
      "samples") \
    X(number, full_well, "full-well", 0, "N", MCV_IN_EXPOSES, "10000", 0, 1e12, \
      "saturation capacity u_e.sat [e-]") \
    X(number, gain, "gain", 0, "K", MCV_IN_EXPOSES | MCV_IN_MEASURE, NULL, 0, 1e12, \
      "system gain K [DN/e-]; by default the full well is the largest grey value") \
    X(number, read_noise, "read-noise", 0, "N", MCV_IN_EXPOSES | MCV_IN_MEASURE, NULL, 0, 1e9, \
      "sigma_d0, the temporal dark noise without dark current [e-]; by default none") \
    X(number, dark_current, "dark-current", 0, "I", MCV_IN_EXPOSES, NULL, 0, 1e12, \
      "mu_I.dark [e-/s], multiplied by --exposure-time; by default none") \
    X(number, dsnu, "dsnu", 0, "N", MCV_IN_EXPOSES, NULL, 0, 1e9, \
      "DSNU1288: standard deviation of the pixels' offsets [e-]; by default none") \
    X(number, prnu, "prnu", 0, "F", MCV_IN_EXPOSES, NULL, 0, 1, \
      "PRNU1288: standard deviation of the pixels' sensitivities, as a fraction; by default " \
      "none") \
    X(count, camera_seed, "camera-seed", 0, "S", MCV_IN_GREY, "0", 0, UINT32_MAX, \
      "another specimen of the camera: other offsets and sensitivities of its pixels") \
    X(flag, noise_free, "noise-free", 0, NULL, MCV_IN_GREY, NULL, 0, 0, \
      "mean grey values, only rounded: no noise and no fixed pattern") \
    X(count, bits, "bits", 0, "B", MCV_IN_EXPOSES, "12", 1, 16, \
      "bits of a grey value, which ranges from 0 to 2^B - 1 DN") \
    X(count, black_level, "black-level", 0, "DN", MCV_IN_EXPOSES | MCV_IN_MEASURE, "0", 0, 65534, \
      "the mean grey value without light and without dark current") \
    X(choice, bayer, "bayer", 0, "none|RGGB|BGGR|GRBG|GBRG", MCV_IN_EXPOSES, "none", 0, 0, \
      "colours of the top-left 2 x 2 pixels; the output has one channel of grey values, as a " \
      "colour camera reads them") \
    X(text, lens_mtf, "lens-mtf", 0, "diffraction|none|F.csv", MCV_IN_EXPOSES, "diffraction", 0, \
      0, \
      "blur of the lens beyond geometrical optics: diffraction at the working f-number of the " \
      "image's header, if it has one; or a table with rows `cycles per mm on the sensor, " \
      "modulation`; not for light field images") \
    X(text, speckle, "speckle", 0, "F.exr", MCV_IN_CAMERA, NULL, 0, 0, \
      "speckle of a laser, before shot noise: F.exr is a render of the same scene by the laser " \
      "alone, `render --lasers Q`") \
    X(number, speckle_polarization, "speckle-polarization", 0, "P", MCV_IN_CAMERA | MCV_IN_SCAN, \
      "1", -1, 1, \
      "degree of polarisation of the scattered light: 1 for bare metal, 0 for paper, paint and " \
      "white plastic") \
    X(number, speckle_patterns, "speckle-patterns", 0, "M", MCV_IN_CAMERA | MCV_IN_SCAN, "1", 0, \
      1000, \
      "independent patterns that add up, such as those of several lasers or of motion: at least " \
      "1; the contrast is 1/sqrt(M)") \
    X(lengths, speckle_roughness, "speckle-roughness", 0, "H", MCV_IN_CAMERA | MCV_IN_SCAN, NULL, \
      0, 1e-2, \
      "standard deviation of the surface's height [m], or with a unit, 2um: with the laser's " \
      "linewidth it makes speckle fainter") \
    X(count, speckle_seed, "speckle-seed", 0, "S", MCV_IN_CAMERA | MCV_IN_SCAN, "0", 0, \
      UINT32_MAX, "another pattern of speckle; exposures of one part share theirs")

#endif
