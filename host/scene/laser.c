/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/laser.h"

#include "scene/texture.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>

/* The options of the choice `widthMeasure`. */
enum { MEASURE_NONE, MEASURE_E2, MEASURE_FWHM };

/* The model is paraxial: at this half-angle the tangent is 9 % more than the angle. */
static const double widest_divergence = 0.5;

/* 1/e² radius of a given diameter. */
static double radius_of(const mcv_laser_params *p, double diameter) {
    return p->widthMeasure == MEASURE_FWHM ? diameter / sqrt(2 * M_LN2) : diameter / 2;
}

mcv_laser_beam mcv_laser_beam_of(const mcv_laser_params *p) {
    mcv_laser_beam beam = {.is_line = !isnan(p->fanAngle)};
    for (int i = 0; i < 2; ++i) {
        beam.waist[i] = radius_of(p, beam.is_line ? p->lineThickness : p->beamDiameter[i]);
        beam.divergence[i] = p->M2[i] * p->wavelength / (M_PI * beam.waist[i]);
        beam.rayleigh[i] = beam.waist[i] / beam.divergence[i];
    }
    return beam;
}

/* A fan has a thickness, a beam a diameter; both say how they are measured. */
static mcv_result check_width(const mcv_laser_params *p, const mcv_json_path *place,
                              mcv_error *error) {
    const bool is_line = !isnan(p->fanAngle);
    const char *key = is_line ? "lineThickness" : "beamDiameter",
               *other = is_line ? "beamDiameter" : "lineThickness";
    const bool given = !isnan(is_line ? p->lineThickness : p->beamDiameter[0]),
               other_given = !isnan(is_line ? p->beamDiameter[0] : p->lineThickness);
    const mcv_json_path here = mcv_json_path_key(place, given ? "widthMeasure" : key);
    if (other_given)
        return mcv_fail_at(
            place, error, "has %s, but a %s: give %s", other,
            is_line ? "fanAngle makes it a line" : "laser without fanAngle is a beam", key);
    if (!given)
        return mcv_fail_at(&here, error, "is missing: a %s [m]",
                           is_line ? "line's thickness" : "beam's diameter");
    if (p->widthMeasure == MEASURE_NONE)
        return mcv_fail_at(&here, error,
                           "is missing: say what %s %g m is, \"1/e2\" or \"FWHM\"; 1/e2 is 1.70 "
                           "times FWHM",
                           key, is_line ? p->lineThickness : p->beamDiameter[0]);
    return MCV_OK;
}

static mcv_result check_fan(const mcv_laser_params *p, const mcv_json_path *place,
                            mcv_error *error) {
    const bool is_table = p->fanProfile == MCV_LASER_TABLE;
    const mcv_json_path image = mcv_json_path_key(place, "image"),
                        profile = mcv_json_path_key(place, "fanProfile"),
                        angle = mcv_json_path_key(place, "interBeamAngle");
    if (isnan(p->fanAngle) && (p->fanProfile != MCV_LASER_PLANE || p->straightness != 0))
        return mcv_fail_at(place, error,
                           "has %s, but draws no line: give fanAngle, or leave it out",
                           p->straightness != 0 ? "straightness" : "fanProfile");
    if (is_table && p->image == MCV_NONE)
        return mcv_fail_at(&image, error,
                           "is missing: the profile \"table\" takes the power per angle from it");
    if (!is_table && p->image != MCV_NONE)
        return mcv_fail_at(&profile, error, "must be \"table\" where an image is given");
    if (p->lineCount > 1 && p->interBeamAngle == 0)
        return mcv_fail_at(&angle, error, "must be above 0, or all %u lines lie on one another",
                           p->lineCount);
    const double outermost = (p->lineCount - 1) * p->interBeamAngle / 2;
    if (outermost < M_PI / 3) return MCV_OK;
    return mcv_fail_at(&angle, error,
                       "%g rad turns the outermost of %u lines by %g rad: at most 1.05 rad (60°)",
                       p->interBeamAngle, p->lineCount, outermost);
}

mcv_result mcv_laser_check(const mcv_laser_params *p, const mcv_json_path *place,
                           mcv_error *error) {
    MCV_TRY(check_width(p, place, error));
    MCV_TRY(check_fan(p, place, error));
    const mcv_laser_beam beam = mcv_laser_beam_of(p);
    for (int i = beam.is_line; i < 2; ++i)
        if (!(beam.divergence[i] <= widest_divergence))
            return mcv_fail_at(place, error,
                               "a waist of 1/e² radius %g m diverges by %g rad at M² %g: at most "
                               "%g rad, so make it wider",
                               beam.waist[i], beam.divergence[i], p->M2[i], widest_divergence);
    return MCV_OK;
}

bool mcv_scene_is_laser_lit(const mcv_scene *scene, double *wavelength, double *linewidth) {
    *wavelength = *linewidth = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *e = scene->emitters + i;
        const mcv_laser_params *p = &e->as.laser;
        if (!(e->radiance[0] + e->radiance[1] + e->radiance[2] > 0)) continue;
        if (e->type != MCV_EMITTER_LASER || (*wavelength > 0 && p->wavelength != *wavelength))
            return false;
        *wavelength = p->wavelength;
        *linewidth = fmax(*linewidth, p->linewidth);
    }
    return *wavelength > 0;
}

mcv_result mcv_scene_keep_lasers(mcv_scene *scene, mcv_error *error) {
    double power = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        mcv_emitter *e = scene->emitters + i;
        for (int k = 0; k < 3; ++k) {
            if (e->type != MCV_EMITTER_LASER) e->radiance[k] = 0;
            power += e->radiance[k];
        }
    }
    if (power > 0) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: has no laser with power, whose light alone makes speckle", scene->path);
}

double mcv_laser_tangent(const mcv_laser_params *p) {
    const mcv_laser_beam beam = mcv_laser_beam_of(p);
    /* Beyond 2.5 Θ, five standard deviations, lies exp(-25/2) of a round beam. */
    const double fan = beam.is_line ? p->fanAngle / 2 : 2.5 * beam.divergence[0],
                 across = 2.5 * beam.divergence[1] + (p->lineCount - 1) * p->interBeamAngle / 2;
    const double widest = hypot(fan, across);
    return widest < M_PI / 2 ? tan(widest) : INFINITY;
}

double mcv_laser_table(const mcv_texture *image, double *columns) {
    double decoded[256], sum = 0;
    mcv_srgb_table(decoded);
    for (uint32_t column = 0; column < image->width; ++column) {
        columns[column] = 0;
        for (uint32_t row = 0; row < image->height; ++row) {
            double rgb[3];
            mcv_texture_value(image, decoded, column, row, rgb);
            columns[column] += rgb[0] + rgb[1] + rgb[2];
        }
        sum += columns[column];
    }
    return sum;
}

mcv_result mcv_laser_check_table(const mcv_texture *image, const mcv_json_path *place,
                                 mcv_error *error) {
    double *columns = malloc(image->width * sizeof *columns);
    if (!columns) return mcv_fail_memory(place, error);
    const double sum = mcv_laser_table(image, columns);
    free(columns);
    if (sum > 0) return MCV_OK;
    return mcv_fail_at(place, error, "is black: no column sends light");
}

void mcv_laser_axes(const mcv_emitter *emitter, double axes[3][3]) {
    const mcv_laser_params *p = &emitter->as.laser;
    const double *m = emitter->to_world.m, x = tan(p->boresightX), y = tan(p->boresightY);
    double forward[3], up[3];
    const double aside[3] = {m[0], m[3], m[6]};
    for (int i = 0; i < 3; ++i) forward[i] = x * m[3 * i] + y * m[3 * i + 1] - m[3 * i + 2];
    mcv_normalize3(forward, axes[2]);
    mcv_cross3(aside, axes[2], up);
    mcv_normalize3(up, axes[1]);
    mcv_cross3(axes[2], axes[1], axes[0]);
}

/* q at φ = 0: the integral of the profile over the fan is 1. */
static double height_of(const mcv_laser_params *p, uint32_t columns) {
    switch (p->fanProfile) {
    case MCV_LASER_PLANE: /* per tangent, over which it is even */
        return 1 / (2 * tan(p->fanAngle / 2));
    case MCV_LASER_GAUSSIAN:
        return 2 / (p->fanAngle * sqrt(M_PI / 2) * erf(M_SQRT2));
    default:
        return columns / p->fanAngle;
    }
}

void mcv_laser_prepare(const mcv_scene *scene, uint32_t index, const double centre[3],
                       mcv_laser *device) {
    const mcv_emitter *emitter = scene->emitters + index;
    const mcv_laser_params *p = &emitter->as.laser;
    const mcv_laser_beam beam = mcv_laser_beam_of(p);
    const double step = p->interBeamAngle, first = -0.5 * (p->lineCount - 1) * step;
    double axes[3][3];
    mcv_laser_axes(emitter, axes);
    *device = (mcv_laser){.distance = (float)p->workingDistance,
                          .first = {(float)cos(first), (float)sin(first)},
                          .step = {(float)cos(step), (float)sin(step)},
                          .count = p->lineCount,
                          .profile = beam.is_line ? (uint32_t)p->fanProfile : MCV_LASER_BEAM,
                          .columns = 1};
    for (int i = 0; i < 3; ++i) {
        device->position[i] = (float)(emitter->to_world.m[9 + i] - centre[i]);
        device->x[i] = (float)axes[0][i];
        device->y[i] = (float)axes[1][i];
        device->forward[i] = (float)axes[2][i];
    }
    for (int i = 0; i < 2; ++i) {
        device->waist[i] = (float)beam.waist[i];
        device->slope[i] = (float)(beam.divergence[i] / 2);
        device->inverse_rayleigh[i] = (float)(1 / beam.rayleigh[i]);
    }
    if (!beam.is_line) return;
    if (p->fanProfile == MCV_LASER_TABLE) device->columns = scene->textures[p->image].width;
    device->edge = (float)tan(p->fanAngle / 2);
    device->inverse_half_fan = (float)(2 / p->fanAngle);
    device->bow = (float)(2 * tan(p->fanAngle / 2) * p->straightness);
    device->height = (float)height_of(p, device->columns);
}
