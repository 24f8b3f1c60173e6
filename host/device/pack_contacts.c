/* SPDX-License-Identifier: Apache-2.0 */
#include "device/pack_steps.h"

#include <float.h>
#include <math.h>

/* By how much the boxes are widened, over the extent of all bodies. Rays look some roundings far
 * for surfaces in contact, 10^4 times less, unless they graze. */
static const float reach_share = 1e-3F;

typedef struct box {
    float low[3], high[3];
} box;

static void include_point(box *b, const float *point) {
    for (int axis = 0; axis < 3; ++axis) {
        b->low[axis] = fminf(b->low[axis], point[axis]);
        b->high[axis] = fmaxf(b->high[axis], point[axis]);
    }
}

static const box nothing = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};

/* The medium that a triangle bounds, or 0. */
static uint32_t medium_of(const mcv_packed *packed, uint32_t triangle) {
    return packed->instances[packed->triangles[4 * (size_t)triangle + 3]].medium;
}

static box box_of(const mcv_packed *packed, uint32_t triangle) {
    box b = nothing;
    for (int corner = 0; corner < 3; ++corner)
        include_point(&b, packed->positions +
                              3 * (size_t)packed->triangles[4 * (size_t)triangle + (size_t)corner]);
    return b;
}

/* The triangle's medium comes near all cells that its widened box touches. */
static void mark(mcv_contact_grid *grid, const box *b, uint32_t medium) {
    uint32_t first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
        first[axis] =
            mcv_contact_cell(b->low[axis] - grid->reach, grid->low[axis], grid->scale[axis]);
        last[axis] =
            mcv_contact_cell(b->high[axis] + grid->reach, grid->low[axis], grid->scale[axis]);
    }
    for (uint32_t z = first[2]; z <= last[2]; ++z)
        for (uint32_t y = first[1]; y <= last[1]; ++y)
            for (uint32_t x = first[0]; x <= last[0]; ++x)
                grid->media[(z * MCV_CONTACT_CELLS + y) * MCV_CONTACT_CELLS + x] |= 1U
                                                                                    << (medium - 1);
}

mcv_result mcv_pack_contacts(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    bool failed = false;
    box all = nothing;
    float extent = 0;
    if (!(packed->features >> MCV_FEATURE_CONTACT & 1)) return MCV_OK;
    mcv_contact_grid *grid = packed->contact_grid =
        mcv_pack_allocate(1, sizeof *packed->contact_grid, &failed);
    if (failed)
        return mcv_fail(error, MCV_FAILED, "%s: no memory to find where bodies touch", scene->path);
    for (uint32_t i = 0; i < packed->triangle_count; ++i) {
        if (medium_of(packed, i) == 0) continue;
        const box b = box_of(packed, i);
        include_point(&all, b.low);
        include_point(&all, b.high);
    }
    for (int axis = 0; axis < 3; ++axis) {
        const float size = fmaxf(all.high[axis] - all.low[axis], 0);
        grid->low[axis] = size > 0 ? all.low[axis] : 0;
        grid->scale[axis] = size > 0 ? MCV_CONTACT_CELLS / size : 0;
        extent = fmaxf(extent, size);
    }
    grid->reach = reach_share * extent;
    for (uint32_t i = 0; i < packed->triangle_count; ++i) {
        const box b = box_of(packed, i);
        if (medium_of(packed, i) > 0) mark(grid, &b, medium_of(packed, i));
    }
    return MCV_OK;
}
