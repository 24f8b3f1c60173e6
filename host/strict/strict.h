/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A glTF file against glTF 2.0 as a whole, also what no node places and this program does not read:
 * each finding has a code, which is the name that Khronos' validator gives it, and the JSON pointer
 * of its place. Rules of the extensions that rules.c lists are checked, too. What Khronos rates as
 * warning or less is not looked for.
 */
#ifndef MCVISI_HOST_STRICT_STRICT_H
#define MCVISI_HOST_STRICT_STRICT_H

#include "core/input_file.h"
#include "core/json.h"

typedef struct mcv_strict_finding {
    const char *code; /* a constant: UNRESOLVED_REFERENCE … */
    char *pointer;    /* RFC 6901: /accessors/0/byteOffset; "" is the file */
    char *text;       /* one sentence */
} mcv_strict_finding;

typedef struct mcv_strict_findings {
    mcv_strict_finding *items;
    size_t count;
} mcv_strict_findings;

/* MCV_OK with the findings, each place and code once; an error only where the file cannot be read,
 * or without memory. `most`: bytes of the file and of its buffers that are read. */
mcv_result mcv_strict_check(const char *path, uint64_t most, mcv_strict_findings *findings,
                            mcv_error *error);

/* The same of a document that is read, with the binary chunk of a GLB as mcv_glb_split gives it. */
mcv_result mcv_strict_check_document(const char *path, const json_t *root, mcv_bytes binary,
                                     uint64_t most, mcv_strict_findings *findings,
                                     mcv_error *error);
void mcv_strict_free(mcv_strict_findings *findings);

#endif
