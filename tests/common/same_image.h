/* SPDX-License-Identifier: Apache-2.0 */
/* Are two OpenEXR images the same, bit for bit? */
#ifndef MCVISI_TESTS_SAME_IMAGE_H
#define MCVISI_TESTS_SAME_IMAGE_H

#include "test.h"

#include <math.h>
#include <string.h>

#include "io/exr.h"

/* What a header may differ in: times; and the light that is missing, whose sum depends on the size
 * of launches in its last digits. */
static inline bool may_differ(const char *name) {
    return strcmp(name, "mcvisi:seconds") == 0 || strcmp(name, "mcvisi:lostEnergy") == 0;
}

static inline bool is_same_attribute(const mcv_attribute *p, const mcv_attribute *q) {
    if (p->text || q->text) return p->text && q->text && strcmp(p->text, q->text) == 0;
    return p->count == q->count &&
           (p->count == 0 || memcmp(p->numbers, q->numbers, p->count * sizeof *p->numbers) == 0);
}

/* Parts and attributes of both are the same. */
static inline void expect_same_image(const char *a, const char *b) {
    mcv_error error = {""};
    mcv_exr x = {0}, y = {0};
    if (mcv_exr_read(a, &x, &error) != MCV_OK || mcv_exr_read(b, &y, &error) != MCV_OK) {
        fail_msg("%s", error.text);
        return;
    }
    assert_int_equal(x.part_count, y.part_count);
    for (uint32_t i = 0; i < x.part_count; ++i) {
        const mcv_image *p = &x.parts[i].image, *q = &y.parts[i].image;
        assert_string_equal(x.parts[i].name, y.parts[i].name);
        assert_int_equal(p->width, q->width);
        assert_int_equal(p->height, q->height);
        assert_int_equal(p->channels, q->channels);
        const size_t count = (size_t)p->width * p->height * p->channels;
        for (size_t k = 0; k < count; ++k)
            if (memcmp(p->pixels + k, q->pixels + k, sizeof *p->pixels) != 0)
                fail_msg("%s and %s: part %s, value %zu: %.9g and %.9g", a, b, x.parts[i].name, k,
                         (double)p->pixels[k], (double)q->pixels[k]);
    }
    assert_int_equal(x.attribute_count, y.attribute_count);
    for (uint32_t i = 0; i < x.attribute_count; ++i) {
        const mcv_attribute *p = x.attributes + i, *q = mcv_exr_attribute(&y, p->name);
        if (!q)
            fail_msg("%s has no attribute %s", b, p->name);
        else if (!may_differ(p->name) && !is_same_attribute(p, q))
            fail_msg("%s and %s: %s differs: %s %g, %s %g", a, b, p->name, p->text ? p->text : "",
                     p->numbers[0], q->text ? q->text : "", q->numbers[0]);
    }
    mcv_exr_free(&x);
    mcv_exr_free(&y);
}

#endif
