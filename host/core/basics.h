/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_CORE_BASICS_H
#define MCVISI_HOST_CORE_BASICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Several texts, none of which are owned. */
typedef struct mcv_texts {
    const char *const *items;
    size_t count;
} mcv_texts;

/* Seconds since some fixed time, which no change of the wall's clock disturbs. */
double mcv_seconds(void);

/* Whether a file's name has this ending, ".png", in capitals or not. */
bool mcv_ends_in(const char *path, const char *ending);

/* FNV-1a, 64 bits: continues a hash, at first MCV_HASH_BEGIN, by some bytes. */
#define MCV_HASH_BEGIN 0xcbf29ce484222325u
uint64_t mcv_hash_bytes(uint64_t hash, const void *data, size_t size);

/* How many bytes of a text, at most so many, end with a whole character of UTF-8: for "%.*s". */
int mcv_whole_characters(const char *text, int most);

/* Prints a name of others, or a text with one: control characters but line feeds (in UTF-8, U+0001
 * to U+001F and U+007F to U+009F) as JSON writes them, so that none steers a terminal. */
void mcv_print_plain(FILE *out, const char *text);

#endif
