/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Adds up the records of a render (kernels/stage/record_light.h) by pixel, element, replicate and
 * channel. Sums are integers of 128 bits, so that they do not depend on the records' order: the
 * same seed gives the same bits on each device and in both schedules.
 */
#ifndef MCVISI_HOST_TRANSPORT_GATHER_H
#define MCVISI_HOST_TRANSPORT_GATHER_H

#include "core/error.h"

typedef __int128 mcv_wide;

/* One element's light in one pixel. */
typedef struct mcv_gather_key {
    uint32_t pixel, element;
} mcv_gather_key;

typedef struct mcv_gather {
    uint32_t channels, replicates;
    int exponent;      /* sums are in units of 2^exponent */
    double scale;      /* 2^-exponent */
    size_t most_bytes; /* memory that it may take */
    size_t count, capacity;
    uint32_t *slots;      /* of a hash table of 2 capacity: index + 1 of an entry, 0: free */
    mcv_gather_key *keys; /* of the entries, in the order of their first records */
    mcv_wide *sums;       /* [entry][replicate][channel] */
} mcv_gather;

/*
 * An empty one. `brightest` is about the largest value of a pixel: the unit is 2^-72 of it, and a
 * sum has room for 2^54 of it.
 */
mcv_result mcv_gather_new(mcv_gather *gather, uint32_t channels, uint32_t replicates,
                          double brightest, size_t most_bytes, mcv_error *error);

/* Adds records; `user` is the gather (mcv_records_told). MCV_BAD_INPUT if they need more memory
 * than allowed. */
mcv_result mcv_gather_add(void *user, const uint32_t *records, size_t count, mcv_error *error);

void mcv_gather_free(mcv_gather *gather);

#endif
