/* SPDX-License-Identifier: Apache-2.0 */
/* Whether large arrays have the same contents, without keeping them. */
#ifndef MCVISI_HOST_DEVICE_DIGEST_H
#define MCVISI_HOST_DEVICE_DIGEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Identifies contents: 128 bits and the number of bytes. */
typedef struct mcv_digest {
    uint64_t bytes, hash[2];
} mcv_digest;

/* Two sums of the bytes' words, each mixed by multiplication and shift; the order of the words
 * matters. */
static inline mcv_digest mcv_digest_of(const void *data, size_t bytes) {
    const unsigned char *from = data;
    mcv_digest d = {.bytes = bytes};
    for (size_t i = 0; i < bytes; i += 8) {
        uint64_t word = 0;
        memcpy(&word, from + i, bytes - i < 8 ? bytes - i : 8);
        d.hash[0] = (d.hash[0] ^ word) * 0x9e3779b97f4a7c15u;
        d.hash[0] ^= d.hash[0] >> 29;
        d.hash[1] = (d.hash[1] + word) * 0xc2b2ae3d27d4eb4fu;
        d.hash[1] ^= d.hash[1] >> 31;
    }
    return d;
}

static inline bool mcv_digest_same(const mcv_digest *a, const mcv_digest *b) {
    return a->bytes == b->bytes && a->hash[0] == b->hash[0] && a->hash[1] == b->hash[1];
}

#endif
