/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_CORE_BASICS_H
#define MCVISI_HOST_CORE_BASICS_H

#include <stdbool.h>
#include <stddef.h>

/* Several texts, none of which are owned. */
typedef struct mcv_texts {
    const char *const *items;
    size_t count;
} mcv_texts;

/* Seconds since some fixed time, which no change of the wall's clock disturbs. */
double mcv_seconds(void);

/* Whether a file's name has this ending, ".png", in capitals or not. */
bool mcv_ends_in(const char *path, const char *ending);

/* How many bytes of a text, at most so many, end with a whole character of UTF-8: for "%.*s". */
int mcv_whole_characters(const char *text, int most);

#endif
