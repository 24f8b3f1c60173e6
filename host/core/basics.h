/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_CORE_BASICS_H
#define MCVISI_HOST_CORE_BASICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Several texts; they are borrowed. */
typedef struct mcv_texts {
    const char *const *items;
    size_t count;
} mcv_texts;

/* Seconds since some fixed time; changes of the wall clock have no effect. */
double mcv_seconds(void);

/* Whether a file's name has this ending, ".png", in any case. */
bool mcv_ends_in(const char *path, const char *ending);

/* FNV-1a, 64 bits. Continues a hash with some bytes; the first hash is MCV_HASH_BEGIN. */
#define MCV_HASH_BEGIN 0xcbf29ce484222325u
uint64_t mcv_hash_bytes(uint64_t hash, const void *data, size_t size);

/* The largest number of bytes, at most `most`, that end with a whole UTF-8 character: for
 * "%.*s". */
int mcv_whole_characters(const char *text, int most);

/* Prints a name from a file, or a text with one. Control characters except line feeds (U+0001 to
 * U+001F and U+007F to U+009F) are printed as in JSON, so that they cannot control a terminal. */
void mcv_print_plain(FILE *out, const char *text);

#endif
