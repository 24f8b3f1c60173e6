/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/aperture.h"

#include "scene/params.h"

#include <math.h>
#include <string.h>

mcv_aperture_shape mcv_sensor_aperture(const mcv_sensor *sensor) {
    if (sensor->type == MCV_SENSOR_THIN_LENS) return MCV_APERTURE_SHAPE_OF(&sensor->as.thin_lens);
    if (sensor->type == MCV_SENSOR_TELECENTRIC)
        return MCV_APERTURE_SHAPE_OF(&sensor->as.telecentric);
    return (mcv_aperture_shape){.shape = MCV_APERTURE_DISC};
}

/* --- the code --- */

static bool is_residue(uint32_t order, uint32_t i) {
    for (uint32_t k = 1; k < order; ++k)
        if (k * k % order == i) return true;
    return false;
}

static bool is_prime(uint32_t n) {
    for (uint32_t k = 2; k * k <= n; ++k)
        if (n % k == 0) return false;
    return n > 1;
}

bool mcv_code_is_open(uint32_t order, uint32_t i, uint32_t j) {
    if (i == 0) return false;
    return j == 0 || is_residue(order, i) == is_residue(order, j);
}

/* --- shapes --- */

/* Half the side of the square of the code: it lies in the disc. */
static const double inscribed = M_SQRT1_2;

/* Area of the unit disc within 0 … x and 0 … y, negative where one of both is. */
static double quarter(double x, double y) {
    const double a = fmin(fabs(x), 1), b = fmin(fabs(y), 1), sign = x * y < 0 ? -1 : 1;
    if (a * a + b * b <= 1) return sign * a * b;
    /* Under the rim from √(1 - b²) to a. */
    const double c = sqrt(1 - b * b);
    return sign *
           (b * c + 0.5 * (a * sqrt(1 - a * a) + asin(a)) - 0.5 * (c * sqrt(1 - c * c) + asin(c)));
}

/* What cell (i, j) of a mask passes, by its area in the disc. */
static double passes(const mcv_mask *mask, uint32_t i, uint32_t j) {
    const double cell = 2.0 / mask->side, x = i * cell - 1, y = 1 - j * cell;
    return (double)mask->values[j * mask->side + i] *
           (quarter(x + cell, y) - quarter(x, y) - quarter(x + cell, y - cell) +
            quarter(x, y - cell));
}

static double mask_open(const mcv_mask *mask) {
    double sum = 0;
    for (uint32_t cell = 0; mask && cell < mask->side * mask->side; ++cell)
        sum += passes(mask, cell % mask->side, cell / mask->side);
    return sum / M_PI;
}

/* The shares of the cells' light, whether it lies in the disc or not. */
static void prepare_mask(const mcv_mask *mask, mcv_aperture *device) {
    const uint32_t cells = mask->side * mask->side;
    double all = 0, passed = 0;
    for (uint32_t cell = 0; cell < cells; ++cell) all += (double)mask->values[cell];
    for (uint32_t cell = 0; cell < cells; ++cell) {
        device->share[cell] = (float)(passed / all);
        passed += (double)mask->values[cell];
    }
    device->share[cells] = 1;
    device->count = mask->side;
    device->extent = 1;
    device->weight *= (float)(all * 4 / cells / (M_PI * (double)device->open));
}

double mcv_aperture_open(const mcv_aperture_shape *s) {
    const double n = s->blades, p = s->order, cell = 2 * inscribed / p;
    switch (s->shape) {
    case MCV_APERTURE_RING:
        return 1 - s->ratio * s->ratio;
    case MCV_APERTURE_HALF:
        return 0.5;
    case MCV_APERTURE_BLADES:
        return n * sin(2 * M_PI / n) / (2 * M_PI);
    case MCV_APERTURE_CODED:
        return (p * p - 1) / 2 * cell * cell / M_PI;
    case MCV_APERTURE_MASK:
        return mask_open(s->mask);
    default:
        return 1;
    }
}

bool mcv_aperture_is_valid(const mcv_aperture_shape *s) {
    switch (s->shape) {
    case MCV_APERTURE_RING:
        return s->ratio > 0 && s->ratio < 1;
    case MCV_APERTURE_HALF:
        return isfinite(s->rotation);
    case MCV_APERTURE_BLADES:
        return isfinite(s->rotation) && s->blades >= 3;
    case MCV_APERTURE_CODED:
        return s->order >= 3 && s->order < MCV_MASK_SIDE && is_prime(s->order);
    case MCV_APERTURE_MASK:
        return s->mask && mask_open(s->mask) > 0;
    default:
        return true;
    }
}

double mcv_aperture_border(const mcv_aperture_shape *s) {
    switch (s->shape) {
    case MCV_APERTURE_RING:
        return 1 / (1 - s->ratio);
    case MCV_APERTURE_HALF:
        return 1 + 2 / M_PI;
    case MCV_APERTURE_BLADES:
        return 1 / cos(M_PI / s->blades);
    case MCV_APERTURE_CODED:
        return s->order / (2 * inscribed);
    case MCV_APERTURE_MASK:
        return fmax(1, s->mask->side / 2.0);
    default:
        return 1;
    }
}

void mcv_aperture_prepare(const mcv_aperture_shape *s, bool irradiance, mcv_aperture *device) {
    const double rotation = isnan(s->rotation) ? 0 : s->rotation,
                 ratio = isnan(s->ratio) ? 0 : s->ratio, open = mcv_aperture_open(s),
                 turns = rotation / (2 * M_PI);
    *device = (mcv_aperture){
        .shape = (uint32_t)s->shape,
        .count = s->shape == MCV_APERTURE_CODED ? s->order : s->blades,
        .inner = (float)(ratio * ratio),
        .x = (float)cos(rotation),
        .y = (float)sin(rotation),
        .turns = (float)(turns - floor(turns)),
        .extent = (float)inscribed,
        .open = (float)open,
        .weight = (float)(irradiance ? open : 1),
    };
    if (s->shape == MCV_APERTURE_MASK) prepare_mask(s->mask, device);
    if (s->shape != MCV_APERTURE_CODED) return;
    const uint32_t p = s->order;
    uint32_t passed = 0;
    for (uint32_t cell = 0; cell < p * p; ++cell) {
        device->share[cell] = (float)(passed / ((p * p - 1) / 2.0));
        // NOLINTNEXTLINE(clang-analyzer-core.DivideZero): the order is a prime from 3 on
        passed += mcv_code_is_open(p, cell % p, cell / p);
    }
    device->share[p * p] = 1;
}

/* --- parameters --- */

/* A parameter is of one shape, or of two. */
static const struct {
    const char *key;
    int shapes[2];
    double usual;
} keys[] = {{"apertureRatio", {MCV_APERTURE_RING, MCV_APERTURE_RING}, 0.5},
            {"apertureRotation", {MCV_APERTURE_HALF, MCV_APERTURE_BLADES}, 0},
            {"apertureBlades", {MCV_APERTURE_BLADES, MCV_APERTURE_BLADES}, 6},
            {"apertureOrder", {MCV_APERTURE_CODED, MCV_APERTURE_CODED}, 13},
            {"apertureMask", {MCV_APERTURE_MASK, MCV_APERTURE_MASK}, 0}};

mcv_result mcv_sensor_resolve_aperture(mcv_sensor *sensor, const mcv_json_path *place,
                                       mcv_error *error) {
    const mcv_param_table table = mcv_sensor_table(sensor->type);
    const char *const *words = mcv_param_options("aperture");
    if (!mcv_params_find(table, "apertureRatio", &sensor->as)) return MCV_OK;
    const int shape = mcv_sensor_aperture(sensor).shape;
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i) {
        const mcv_json_path here = mcv_json_path_key(place, keys[i].key);
        void *field = mcv_params_find(table, keys[i].key, &sensor->as);
        const bool whole = i >= 2, has = shape == keys[i].shapes[0] || shape == keys[i].shapes[1],
                   given = whole ? *(uint32_t *)field != 0 : !isnan(*(double *)field);
        if (given && !has)
            return mcv_fail_at(&here, error, "is of the aperture \"%s\", not of \"%s\"",
                               words[keys[i].shapes[0]], words[shape]);
        if (given || !has) continue;
        if (whole)
            *(uint32_t *)field = (uint32_t)keys[i].usual;
        else
            *(double *)field = keys[i].usual;
    }
    const mcv_aperture_shape resolved = mcv_sensor_aperture(sensor);
    const mcv_json_path order = mcv_json_path_key(place, "apertureOrder"),
                        mask = mcv_json_path_key(place, "apertureMask");
    if (shape == MCV_APERTURE_MASK && resolved.mask->side == 0)
        return mcv_fail_at(&mask, error, "is missing: rows of numbers from 0 to 1");
    if (shape == MCV_APERTURE_MASK && !mcv_aperture_is_valid(&resolved))
        return mcv_fail_at(&mask, error, "lets no light through the disc");
    if (shape == MCV_APERTURE_CODED && !is_prime(resolved.order))
        return mcv_fail_at(&order, error, "%u must be a prime, such as 11, 13 or 17",
                           resolved.order);
    return MCV_OK;
}
