/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/box.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* One place. The whole text is for messages. */
static mcv_result read_place(const char *what, const char *text, const char *place,
                             const mcv_image *image, mcv_pixel_box *box, mcv_error *error) {
    double n[4];
    char ignored[64];
    const char *rest;
    bool whole = !strchr(place, '=') && mcv_roi_numbers(place, 0, ignored, &rest, n, 4) == 4;
    for (int i = 0; whole && i < 4; ++i) whole = n[i] == floor(n[i]) && n[i] >= 0;
    if (!whole)
        return mcv_fail(error, MCV_USAGE, "%s %s must be [NAME=]X,Y,W,H in whole pixels", what,
                        text);
    if (n[0] + n[2] > image->width || n[1] + n[3] > image->height)
        return mcv_fail(error, MCV_USAGE,
                        "%s %s extends to column %g, row %g: the image has only %u x %u pixels",
                        what, text, n[0] + n[2], n[1] + n[3], image->width, image->height);
    if (n[2] < 8 || n[3] < 8)
        return mcv_fail(error, MCV_USAGE, "%s %s must be at least 8 pixels wide and high", what,
                        text);
    *box = (mcv_pixel_box){(uint32_t)n[0], (uint32_t)n[1], (uint32_t)n[2], (uint32_t)n[3]};
    return MCV_OK;
}

mcv_result mcv_boxes_parse(const char *what, const char *text, size_t number,
                           const mcv_image *image, size_t most, char name[64], mcv_pixel_box *boxes,
                           size_t *count, mcv_error *error) {
    const char *equals = strchr(text, '=');
    const char *rest = equals && equals > text ? equals + 1 : text;
    MCV_TRY(mcv_place_check_name(what, text, error));
    if (rest > text)
        snprintf(name, 64, "%.*s", (int)(equals - text), text);
    else
        snprintf(name, 64, "%zu", number);
    for (*count = 0;; ++*count) {
        char place[128];
        const size_t length = strcspn(rest, "+");
        if (*count == most)
            return mcv_fail(error, MCV_USAGE, "%s %s: has more than %zu place%s", what, text, most,
                            most == 1 ? "" : "s");
        if (length >= sizeof place)
            return mcv_fail(error, MCV_USAGE, "%s %s must be [NAME=]X,Y,W,H in whole pixels", what,
                            text);
        snprintf(place, sizeof place, "%.*s", (int)length, rest);
        MCV_TRY(read_place(what, text, place, image, boxes + *count, error));
        rest += length;
        if (*rest == '\0') break;
        ++rest;
    }
    ++*count;
    return MCV_OK;
}
