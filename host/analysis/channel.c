/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/channel.h"

#include <math.h>

mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image,
                              bool deviations, mcv_image *out, mcv_error *error) {
    if (chosen > image->channels && chosen > 1)
        return mcv_fail(error, MCV_USAGE, "%s has %u channel%s: leave out --channel", path,
                        image->channels, image->channels > 1 ? "s" : "");
    MCV_TRY(mcv_image_new(out, image->width, image->height, 1, error));
    const size_t plane = (size_t)image->width * image->height;
    for (size_t i = 0; i < plane; ++i) {
        double sum = 0;
        for (uint32_t c = 0; c < image->channels; ++c) {
            const double value = image->pixels[c * plane + i];
            if (chosen == 0 || chosen - 1 == c) sum += deviations ? value * value : value;
        }
        const double count = chosen == 0 ? image->channels : 1;
        out->pixels[i] = (float)((deviations ? sqrt(sum) : sum) / count);
    }
    return MCV_OK;
}
