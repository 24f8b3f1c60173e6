/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters on the host: their parameters, images and radiometry. */
#include "scene/emitter_shape.h"

#include "scene/laser.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "scene/texture.h"

#include <float.h>

double mcv_emitter_half_angle(const mcv_emitter *emitter) {
    if (emitter->type == MCV_EMITTER_PARALLEL) return emitter->as.parallel.halfAngle;
    if (emitter->type == MCV_EMITTER_TELECENTRIC_PROJECTOR)
        return emitter->as.telecentric_projector.halfAngle;
    return (double)NAN;
}

bool mcv_emitter_is_point_light(uint32_t type) { return MCV_IS_EMITTER_OF(MCV_POINT_LIGHTS, type); }

bool mcv_emitter_has_place(uint32_t type) {
    return mcv_emitter_is_point_light(type) || type == MCV_EMITTER_LASER;
}

bool mcv_emitter_is_surface_light(uint32_t type) {
    return MCV_IS_EMITTER_OF(MCV_SURFACE_LIGHTS, type);
}

bool mcv_emitter_has_surface(uint32_t type) {
    return type != MCV_EMITTER_ENVIRONMENT && type != MCV_EMITTER_DIRECTIONAL &&
           !mcv_emitter_has_place(type);
}

mcv_result mcv_emitter_check(mcv_emitter *emitter, const mcv_json_path *place, mcv_error *error) {
    if (mcv_emitter_half_angle(emitter) == 0) {
        const mcv_json_path here = mcv_json_path_key(place, "halfAngle");
        return mcv_fail_at(
            &here, error,
            "0 is a collimated beam: use the type \"collimatedBeam\", or give an angle above 0");
    }
    MCV_TRY(mcv_params_check(mcv_emitter_table(emitter->type), &emitter->as, place, error));
    if (emitter->type == MCV_EMITTER_LASER)
        return mcv_laser_check(&emitter->as.laser, place, error);
    if (emitter->type == MCV_EMITTER_PROJECTOR) {
        mcv_projector_params *p = &emitter->as.projector;
        return mcv_lens_resolve((mcv_lens){p->focalLength, &p->imageDistance, &p->focusDistance,
                                           &p->lensDiameter, &p->fNumber},
                                place, error);
    }
    if (emitter->type == MCV_EMITTER_SCREEN)
        for (int i = 0; i < 2; ++i)
            if (!(emitter->as.screen.pixelGap[i] < emitter->as.screen.pixelPitch[i])) {
                const mcv_json_path here = mcv_json_path_key(place, "pixelGap");
                return mcv_fail_at(&here, error, "%g m must be below pixelPitch %g m",
                                   emitter->as.screen.pixelGap[i],
                                   emitter->as.screen.pixelPitch[i]);
            }
    if (emitter->type != MCV_EMITTER_SPOT ||
        emitter->as.spot.innerConeAngle <= emitter->as.spot.outerConeAngle)
        return MCV_OK;
    const mcv_json_path here = mcv_json_path_key(place, "innerConeAngle");
    return mcv_fail_at(&here, error, "%g rad must be at most outerConeAngle %g rad",
                       emitter->as.spot.innerConeAngle, emitter->as.spot.outerConeAngle);
}

static void *parameter(const mcv_emitter *emitter, const char *key) {
    return mcv_params_find(mcv_emitter_table(emitter->type), key, &emitter->as);
}

double *mcv_emitter_parameter(mcv_emitter *emitter, const char *key) {
    return parameter(emitter, key);
}

const double *mcv_emitter_range(const mcv_emitter *emitter) { return parameter(emitter, "range"); }

uint32_t *mcv_emitter_image(mcv_emitter *emitter) { return parameter(emitter, "image"); }

bool mcv_screen_has_structure(const mcv_emitter *emitter) {
    const mcv_screen_params *p = &emitter->as.screen;
    return emitter->type == MCV_EMITTER_SCREEN &&
           (p->falloffExponent > 0 || p->pixelGap[0] > 0 || p->pixelGap[1] > 0);
}

double mcv_screen_rise(const mcv_screen_params *p, double xi, double eta) {
    return p->sag[0] * xi * xi + p->sag[1] * eta * eta + p->twist * xi * eta +
           p->fourth[0] * pow(xi, 4) + p->fourth[1] * pow(eta, 4);
}

static void screen_resolution(const mcv_scene *scene, const mcv_screen_params *p,
                              uint32_t pixels[2]) {
    mcv_picture_resolution(&p->pattern, scene->textures + p->image, pixels);
}

void mcv_emitter_size(const mcv_scene *scene, const mcv_emitter *emitter, double size[2]) {
    const double *given = parameter(emitter, "size");
    if (emitter->type == MCV_EMITTER_SCREEN) {
        uint32_t pixels[2];
        screen_resolution(scene, &emitter->as.screen, pixels);
        for (int i = 0; i < 2; ++i) size[i] = pixels[i] * emitter->as.screen.pixelPitch[i];
        return;
    }
    for (int i = 0; i < 2; ++i)
        size[i] = emitter->type == MCV_EMITTER_PROJECTOR ? emitter->as.projector.lensDiameter
                  : given                                ? given[i]
                                                         : (double)NAN;
}

bool mcv_emitter_mirrors(const mcv_emitter *emitter) {
    const int *mirror = parameter(emitter, "mirror");
    return emitter->type == MCV_EMITTER_SCREEN || (mirror && *mirror);
}

static const struct {
    const char *key, *unit;
} brightnesses[] = {
    {"radiance", "W/(m² sr)"}, {"irradiance", "W/m²"}, {"intensity", "W/sr"}, {"power", "W"}};

const char *mcv_emitter_brightness(const mcv_emitter *emitter, const char **unit) {
    int i = 0;
    while (i < 3 && !parameter(emitter, brightnesses[i].key)) ++i;
    *unit = brightnesses[i].unit;
    return brightnesses[i].key;
}

mcv_pattern *mcv_emitter_pattern(mcv_emitter *emitter) { return parameter(emitter, "pattern"); }

uint32_t *mcv_emitter_index(mcv_emitter *emitter) { return parameter(emitter, "index"); }

mcv_result mcv_emitter_check_image(const mcv_scene *scene, const mcv_emitter *emitter,
                                   const mcv_json_path *place, mcv_error *error) {
    const uint32_t *image = parameter(emitter, "image");
    const mcv_json_path here = mcv_json_path_key(place, "image");
    if (!image || *image == MCV_NONE) return MCV_OK;
    if (*image >= scene->texture_count)
        return mcv_fail_at(&here, error, "texture %u does not exist", *image);
    if (emitter->type == MCV_EMITTER_LASER)
        return mcv_laser_check_table(scene->textures + *image, &here, error);
    if (!mcv_emitter_has_surface(emitter->type)) return MCV_OK;
    const mcv_mesh *mesh = scene->meshes + scene->instances[emitter->instance].mesh;
    if (emitter->type != MCV_EMITTER_SCREEN && (mesh->triangle_count != 2 || !mesh->texcoords))
        return mcv_fail_at(
            place, error,
            "an image must lie on a rectangle of two triangles with texture coordinates");
    if (emitter->type != MCV_EMITTER_LIGHT_FIELD_EMITTER) return MCV_OK;
    const mcv_light_field_emitter_params *p = &emitter->as.light_field_emitter;
    const mcv_texture *texture = scene->textures + *image;
    const uint64_t width = (uint64_t)p->spatialResolution[0] * p->angularResolution[0];
    const uint64_t height = (uint64_t)p->spatialResolution[1] * p->angularResolution[1];
    if (texture->width == width && texture->height == height) return MCV_OK;
    return mcv_fail_at(
        &here, error,
        "has %u x %u pixels, but must have %llu x %llu: spatial times angular resolution",
        texture->width, texture->height, (unsigned long long)width, (unsigned long long)height);
}

/* Area of the unit disk between its centre and (x, y), with the sign of x y; |x|, |y| <= 1. */
static double disk_share(double x, double y) {
    const double a = fabs(x), b = fabs(y),
                 edge = sqrt(1 - b * b); /* where the disk's edge meets y = b */
    if (a <= edge) return x * y;
    const double segment = 0.5 * (a * sqrt(1 - a * a) + asin(a) - edge * b -
                                  asin(edge)); /* below the edge, from there to a */
    return copysign(edge * b + segment, x * y);
}

/* Projected solid angle [sr] of the directions of a light field's angular pixel: its area within
 * the unit disk. */
static double direction_share(const mcv_light_field_emitter_params *p, uint32_t column,
                              uint32_t row) {
    const double j = p->angularResolution[0], k = p->angularResolution[1], a = p->angularRange;
    const double x0 = a * (2 * column / j - 1), x1 = a * (2 * (column + 1) / j - 1);
    const double y0 = a * (2 * row / k - 1), y1 = a * (2 * (row + 1) / k - 1);
    return disk_share(x1, y1) - disk_share(x0, y1) - disk_share(x1, y0) + disk_share(x0, y0);
}

static double clamped(double x) { return fmin(fmax(x, -1), 1); }

/* A pixel's share of the disk that a beam leaves; 1 for the whole rectangle. */
static double aperture_share(const mcv_collimated_beam_params *p, const mcv_texture *texture,
                             uint32_t column, uint32_t row) {
    const double radius = mcv_beam_radius(p), w = p->size[0] / (2 * radius),
                 h = p->size[1] / (2 * radius);
    if (isinf(radius)) return 1;
    const double x0 = clamped(w * (2.0 * column / texture->width - 1)),
                 x1 = clamped(w * (2.0 * (column + 1) / texture->width - 1));
    const double y0 = clamped(h * (2.0 * row / texture->height - 1)),
                 y1 = clamped(h * (2.0 * (row + 1) / texture->height - 1));
    return disk_share(x1, y1) - disk_share(x0, y1) - disk_share(x1, y0) + disk_share(x0, y0);
}

void mcv_picture_resolution(const mcv_pattern *pattern, const mcv_texture *texture,
                            uint32_t pixels[2]) {
    const bool shown = pattern->type != MCV_NONE;
    pixels[0] = shown ? pattern->resolution[0] : texture->width;
    pixels[1] = shown ? pattern->resolution[1] : texture->height;
}

void mcv_image_tangents(const mcv_projector_params *p, const mcv_texture *texture,
                        double tangents[2]) {
    uint32_t pixels[2];
    mcv_picture_resolution(&p->pattern, texture, pixels);
    for (int i = 0; i < 2; ++i) tangents[i] = pixels[i] * p->pixelSize[i] / (2 * p->imageDistance);
}

/* What a projector's lens sends of radiance 1 per area of the image over b²: 2π R²/(B (A + B)) at
 * the distance m from the axis. */
static double lens_share(const mcv_projector_params *p, double m_squared) {
    const double r = p->lensDiameter / 2, blur = mcv_kappa(p->focalLength, p->imageDistance) * r;
    const double a = 1 + m_squared - blur * blur, sum = 1 + m_squared + blur * blur;
    const double b = sqrt(sum * sum - 4 * m_squared * blur * blur);
    return 2 * M_PI * r * r / (b * (a + b));
}

/*
 * The same of the image's part [x0, x1] x [y0, y1], over b: Gauss's rule of 2 x 2 points in cells
 * of at most 0.02, in which the fourth derivatives, of the order of 100 times the value, leave 1e-8
 * of it at most.
 */
static double image_share(const mcv_projector_params *p, double x0, double x1, double y0,
                          double y1) {
    const double cell = 0.02, columns = fmax(ceil((x1 - x0) / cell), 1),
                 rows = fmax(ceil((y1 - y0) / cell), 1);
    const double width = (x1 - x0) / columns, height = (y1 - y0) / rows, off = sqrt(1 / 12.0);
    double sum = 0;
    for (double i = 0; i < columns; ++i)
        for (double j = 0; j < rows; ++j)
            for (int corner = 0; corner < 4; ++corner) {
                const double x = x0 + width * (i + 0.5 + (corner & 1 ? off : -off)),
                             y = y0 + height * (j + 0.5 + (corner & 2 ? off : -off));
                sum += lens_share(p, x * x + y * y);
            }
    return sum * width * height / 4;
}

/* What a pixel sends at equal values, in any unit. */
static double pixel_share(const mcv_emitter *emitter, const mcv_texture *texture, uint32_t column,
                          uint32_t row) {
    const mcv_light_field_emitter_params *p = &emitter->as.light_field_emitter;
    switch (emitter->type) {
    case MCV_EMITTER_LIGHT_FIELD_EMITTER:
        return direction_share(p, column % p->angularResolution[0], row % p->angularResolution[1]);
    case MCV_EMITTER_COLLIMATED_BEAM:
        return aperture_share(&emitter->as.collimated_beam, texture, column, row);
    case MCV_EMITTER_ENVIRONMENT: /* by solid angle */
        return sin((2.0 * row + 1) * M_PI / (2.0 * texture->height));
    case MCV_EMITTER_PROJECTOR: {
        double edge[2];
        mcv_image_tangents(&emitter->as.projector, texture, edge);
        const double width = 2 * edge[0] / texture->width, height = 2 * edge[1] / texture->height;
        return image_share(&emitter->as.projector, column * width - edge[0],
                           (column + 1) * width - edge[0], row * height - edge[1],
                           (row + 1) * height - edge[1]);
    }
    default:
        return 1;
    }
}

void mcv_emitter_image_mean(const mcv_scene *scene, const mcv_emitter *emitter, double mean[3]) {
    double sum[3] = {0, 0, 0}, total = 0, rgb[3], decoded[256];
    for (int i = 0; i < 3; ++i) mean[i] = 1;
    if (!parameter(emitter, "image") || emitter->texture == MCV_NONE) return;
    if (emitter->type == MCV_EMITTER_LASER) return; /* its table is normalised */
    const mcv_texture *texture = scene->textures + emitter->texture;
    mcv_srgb_table(decoded);
    for (uint32_t row = 0; row < texture->height; ++row)
        for (uint32_t column = 0; column < texture->width; ++column) {
            const double weight = pixel_share(emitter, texture, column, row);
            mcv_texture_value(texture, decoded, column, row, rgb);
            for (size_t i = 0; i < 3; ++i) sum[i] += weight * rgb[i];
            total += weight;
        }
    for (int i = 0; i < 3; ++i) mean[i] = sum[i] / total;
}

double mcv_emitter_solid_angle(const mcv_emitter *emitter) {
    if (emitter->type == MCV_EMITTER_PROJECTOR || emitter->type == MCV_EMITTER_LASER)
        return (double)NAN;
    if (mcv_emitter_is_surface_light(emitter->type)) return 2 * M_PI;
    if (emitter->type == MCV_EMITTER_ENVIRONMENT || emitter->type == MCV_EMITTER_POINT)
        return 4 * M_PI;
    if (emitter->type == MCV_EMITTER_COLLIMATED_BEAM || emitter->type == MCV_EMITTER_DIRECTIONAL)
        return 0;
    if (emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) {
        const double a = emitter->as.light_field_emitter.angularRange;
        /* The hemisphere without four caps, which no longer meet from a = sin 45° on. */
        if (2 * a * a >= 1) return 2 * M_PI - 4 * M_PI * (1 - a);
        return 8 * a * asin(a / sqrt(1 - a * a)) - 4 * atan(a * a / sqrt(1 - 2 * a * a));
    }
    const double s = sin((emitter->type == MCV_EMITTER_SPOT ? emitter->as.spot.outerConeAngle
                                                            : mcv_emitter_half_angle(emitter)) /
                         2);
    return 4 * M_PI * s * s;
}

double mcv_emitter_projected_solid_angle(const mcv_emitter *emitter) {
    if (emitter->type == MCV_EMITTER_PROJECTOR) return (double)NAN;
    if (emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) {
        const double a = emitter->as.light_field_emitter.angularRange;
        return 4 * disk_share(a, a);
    }
    if (emitter->type == MCV_EMITTER_SCREEN)
        return 2 * M_PI / (emitter->as.screen.falloffExponent + 2);
    const double beta = mcv_emitter_half_angle(emitter);
    return isnan(beta) ? M_PI : M_PI * sin(beta) * sin(beta);
}

/* A projector whose image is not known yet has one of a pixel. */
static void projector_tangents(const mcv_scene *scene, const mcv_emitter *emitter, double edge[2]) {
    const mcv_texture pixel = {.width = 1, .height = 1};
    mcv_image_tangents(&emitter->as.projector,
                       emitter->texture == MCV_NONE ? &pixel : scene->textures + emitter->texture,
                       edge);
}

static double projector_unit_power(const mcv_scene *scene, const mcv_emitter *emitter) {
    double edge[2];
    projector_tangents(scene, emitter, edge);
    return image_share(&emitter->as.projector, -edge[0], edge[0], -edge[1], edge[1]);
}

/* The share of a screen's area that is no gap. */
static double lit_share(const mcv_emitter *emitter) {
    const mcv_screen_params *p = &emitter->as.screen;
    return (1 - p->pixelGap[0] / p->pixelPitch[0]) * (1 - p->pixelGap[1] / p->pixelPitch[1]);
}

double mcv_emitter_unit_power(const mcv_scene *scene, const mcv_emitter *emitter) {
    const mcv_collimated_beam_params *beam = &emitter->as.collimated_beam;
    const mcv_spot_params *spot = &emitter->as.spot;
    switch (emitter->type) {
    case MCV_EMITTER_ENVIRONMENT:
    case MCV_EMITTER_DIRECTIONAL:
        return (double)NAN;
    case MCV_EMITTER_LASER:
        return 1; /* its brightness is its power */
    case MCV_EMITTER_POINT:
        return 4 * M_PI;
    case MCV_EMITTER_SPOT: /* 1 - cosθ = 2 sin²(θ/2) */
        return 4 * M_PI / 3 *
               (2 * mcv_half_sine_squared(spot->innerConeAngle) +
                mcv_half_sine_squared(spot->outerConeAngle));
    case MCV_EMITTER_PROJECTOR:
        return projector_unit_power(scene, emitter);
    case MCV_EMITTER_SCREEN:
        return mcv_emitter_projected_solid_angle(emitter) * emitter->area * lit_share(emitter);
    case MCV_EMITTER_COLLIMATED_BEAM:
        return beam->aperture == MCV_APERTURE_CIRCLE
                   ? M_PI * mcv_beam_radius(beam) * mcv_beam_radius(beam)
                   : emitter->area;
    default:
        return mcv_emitter_projected_solid_angle(emitter) * emitter->area;
    }
}

/* No lens comes near, and a sum over the cells of such an image (image_share) would not end. */
static mcv_result check_image_angle(const mcv_scene *scene, const mcv_emitter *emitter,
                                    const mcv_json_path *place, mcv_error *error) {
    double edge[2];
    if (emitter->type != MCV_EMITTER_PROJECTOR) return MCV_OK;
    projector_tangents(scene, emitter, edge);
    if (edge[0] <= 10 && edge[1] <= 10) return MCV_OK;
    return mcv_fail_at(place, error,
                       "its image reaches more than 84 degrees off the axis: check the units of "
                       "pixelSize and imageDistance");
}

mcv_result mcv_emitter_resolve(const mcv_scene *scene, mcv_emitter *emitter,
                               const mcv_json_path *place, mcv_error *error) {
    const char *unit, *key = mcv_emitter_brightness(emitter, &unit);
    const double *brightness = mcv_emitter_parameter(emitter, key);
    const double *power = mcv_emitter_parameter(emitter, "power");
    MCV_TRY(check_image_angle(scene, emitter, place, error));
    const bool has_power = power && power != brightness && !isnan(power[0]);
    if (isnan(brightness[0]) && !has_power)
        return mcv_fail_at(place, error, "needs %s [%s] or power [W]", key, unit);
    if (!isnan(brightness[0]) && has_power)
        return mcv_fail_at(place, error, "has both %s %g and power %g: give one, the other follows",
                           key, brightness[0], power[0]);
    if (!has_power) {
        memcpy(emitter->radiance, brightness, sizeof emitter->radiance);
        return MCV_OK;
    }
    double mean[3];
    mcv_emitter_image_mean(scene, emitter, mean);
    for (int i = 0; i < 3; ++i) {
        if (power[i] > 0 && mean[i] == 0)
            return mcv_fail_at(
                place, error,
                "its image is black in channel %c, so no %s gives a power of %g W there: give %s",
                "RGB"[i], key, power[i], key);
        emitter->radiance[i] =
            power[i] > 0 ? power[i] / (mcv_emitter_unit_power(scene, emitter) * mean[i]) : 0;
    }
    if (isfinite(emitter->radiance[0] + emitter->radiance[1] + emitter->radiance[2])) return MCV_OK;
    return mcv_fail_at(place, error,
                       "an area of %g m² with this cone is too small for a power of %g W",
                       emitter->area, power[0]);
}
