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

/* The character at the begin of a text and the bytes that it takes in UTF-8; 0 where they are
 * none. */
int mcv_character(const char *text, uint32_t *code);

/* Prints a text that may hold names from a file. Control characters except line feeds, and those
 * that turn the direction of writing, are printed as in JSON (\u001b), bytes that are not UTF-8 as
 * \x9b: they cannot control a terminal. mcv_print_line: a name, in which line feeds are so, too. */
void mcv_print_plain(FILE *out, const char *text);
void mcv_print_line(FILE *out, const char *text);

/* Closes a stream of open_memstream, or NULL. Where memory was missing the text is freed and NULL,
 * and the answer false: fclose does not tell when there was none for the last piece. */
bool mcv_text_close(FILE *stream, char **text);

#endif
