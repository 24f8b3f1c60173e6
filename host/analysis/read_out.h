/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From an image of light, as OpenEXR files have it, to the grey values of a camera: the scale from
 * light to electrons, the lens's modulation transfer and the exposure (analysis/camera.h).
 */
#ifndef MCVISI_HOST_ANALYSIS_READ_OUT_H
#define MCVISI_HOST_ANALYSIS_READ_OUT_H

#include "analysis/camera.h"
#include "io/exr.h"

/* A camera as users give it. Numbers that are 0 were not given. */
typedef struct mcv_camera_settings {
    double exposure_time;         /* t_exp [s] */
    double quantum_efficiency[3]; /* eta of red, green and blue */
    double wavelength[3];         /* of red, green and blue [m] */
    double electrons_per_unit[3]; /* mu_e for 1 W/m² or 1 W/(m² sr) */
    double expose_to;             /* what share of the full well bright parts shall have */
    double dark_current;          /* mu_I [e-/s] */
    const char *lens_mtf;         /* "diffraction", "none" or the path of a table */
    const char
        *speckle; /* the path of a picture of laser light (analysis/read_speckle.h), or NULL */
    const mcv_exr *speckle_light; /* that picture in memory; NULL: it is read from the path */
    double speckle_polarization;  /* degree of polarisation of the scattered light */
    double speckle_patterns;      /* independent patterns, apart from those of a spectrum */
    double speckle_roughness;     /* standard deviation of the surface's height [m] */
    uint32_t speckle_seed;
    uint32_t speckle_exposure; /* of a part that moves (analysis/speckle.h) */
    /* The rest; electrons_per_unit and dark_electrons follow from the above. gain 0: the full well
     * is the largest grey value. */
    mcv_camera camera;
} mcv_camera_settings;

/* Is there an exposure among the settings? */
bool mcv_camera_wanted(const mcv_camera_settings *settings);

/* Do the settings make a camera, and is the scale of light given once? MCV_USAGE names the option
 * that is wrong. */
mcv_result mcv_camera_check_settings(const mcv_camera_settings *settings, mcv_error *error);

typedef struct mcv_read_out {
    mcv_camera camera;
    mcv_exposure exposure;       /* owned: mcv_exposure_free */
    mcv_correlation correlation; /* of the light's errors, which the lens blurs as well */
    const char *unit;            /* of the light */
    char lens[128];              /* what blurs, in words; "" for nothing */
    double speckle;              /* contrast of the speckle before pixels average it; 0: none */
    double level; /* the uncertainty of the level that expose_to takes, relative to it; NaN where
                     none is known */
} mcv_read_out;

/*
 * Reads out the first part of an image of light as mcv_exr_read gives it, with the header's
 * attributes; the light is blurred in place. `path` is for messages. MCV_BAD_INPUT where the image
 * is no light or its header lacks what the settings need. After failure nothing is owned.
 */
mcv_result mcv_camera_read_out(const mcv_camera_settings *settings, const char *path, mcv_exr *exr,
                               mcv_read_out *out, mcv_error *error);

/* Width and height of a pixel of the image by its header [m]: of binned ones, all together. False
 * where the header does not say. */
bool mcv_camera_pixel_size(const mcv_exr *exr, double size[2]);

/*
 * What the lens does to the first part before: blurs it, and the part of its errors where there is
 * one. `words` gets what was done, "" for nothing. A light field image is not blurred: neighbouring
 * pixels see through different parts of the pupil. Nor is an image whose stop would fill it by
 * diffraction: that is the negligible stop of a glTF camera.
 */
mcv_result mcv_camera_blur(const mcv_camera_settings *settings, const char *path, mcv_exr *exr,
                           char words[128], mcv_correlation *correlation, mcv_error *error);

#endif
