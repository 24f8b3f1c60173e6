/* SPDX-License-Identifier: Apache-2.0 */
#include "io/colormap.h"

#include <math.h>

enum { VIRIDIS_CONTROLS = 33 };

/* Each eighth colour of viridis' table of 256, at n/32: S. van der Walt, N. Smith, mpl colormaps,
 * 2015, CC0. */
static const uint8_t viridis[VIRIDIS_CONTROLS][3] = {
    {68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},  {69, 54, 129},
    {66, 64, 134},  {63, 73, 137},  {59, 82, 139},  {55, 90, 141},  {51, 99, 141},  {47, 106, 142},
    {44, 114, 142}, {41, 122, 142}, {38, 129, 142}, {35, 137, 142}, {33, 144, 140}, {31, 152, 139},
    {31, 159, 136}, {33, 166, 133}, {40, 174, 128}, {49, 181, 123}, {62, 188, 116}, {76, 194, 108},
    {93, 201, 99},  {110, 206, 88}, {130, 211, 76}, {150, 216, 63}, {171, 220, 50}, {192, 223, 36},
    {213, 226, 26}, {234, 229, 26}, {253, 231, 37}};

static const uint8_t ends[2][3] = {{30, 75, 165}, {175, 25, 40}}; /* of the diverging colours */

uint32_t mcv_colormap_rgb(mcv_colormap map, double position) {
    const double clipped = position > 0 ? (position < 1 ? position : 1) : 0;
    const double at = clipped * (VIRIDIS_CONTROLS - 1);
    const int control = at < VIRIDIS_CONTROLS - 2 ? (int)at : VIRIDIS_CONTROLS - 2;
    uint32_t rgb = 0;
    for (int c = 0; c < 3; ++c) {
        double value = 255 * clipped;
        if (map == MCV_COLORMAP_VIRIDIS) {
            const double low = viridis[control][c], high = viridis[control + 1][c];
            value = low + (at - control) * (high - low);
        }
        if (map == MCV_COLORMAP_DIVERGING) {
            const double end = ends[clipped > 0.5][c];
            value = 255 - fabs(2 * clipped - 1) * (255 - end);
        }
        rgb = rgb << 8 | (uint32_t)(value + 0.5);
    }
    return rgb;
}
