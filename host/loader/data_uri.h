/* SPDX-License-Identifier: Apache-2.0 */
/* data: URIs (RFC 2397): base64, or bytes with %-escapes. */
#ifndef MCVISI_HOST_LOADER_DATA_URI_H
#define MCVISI_HOST_LOADER_DATA_URI_H

#include "core/input_file.h"

/* Media types of buffers, ended by NULL. */
extern const char *const mcv_buffer_types[];

/* The length of the data; an error where the URI is broken or of none of these types (ended by
 * NULL). */
mcv_result mcv_data_uri_length(const char *uri, const char *const *types, uint64_t *length,
                               const mcv_json_path *place, mcv_error *error);

/* Bytes first … first + size - 1 of the data of a URI that has been checked, and that has them. */
void mcv_data_uri_decode(const char *uri, uint64_t first, uint64_t size, uint8_t *bytes);

#endif
