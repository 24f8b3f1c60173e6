/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of host/strict share. */
#ifndef MCVISI_HOST_STRICT_STRICT_PARTS_H
#define MCVISI_HOST_STRICT_STRICT_PARTS_H

#include "strict/strict.h"

#include "mcvisi/dialect.h"

typedef struct mcv_strict {
    mcv_strict_findings *findings;
    json_t *told; /* the same, to be looked up */
    mcv_json_path file;
    const json_t *root;
    bool is_glb;
    mcv_bytes binary;   /* the binary chunk; data is NULL without one */
    mcv_bytes *buffers; /* of buffers[i]; data is NULL where there is none, or it is wrong */
    uint64_t left;      /* bytes that may be read */
    bool no_memory;
} mcv_strict;

/* Adds a finding, unless it is there. */
void mcv_strict_find(mcv_strict *s, const char *code, const mcv_json_path *place,
                     const char *format, ...) __attribute__((format(printf, 4, 5)));

/* walk.c: types, required members, ranges, references and places of extensions, by rules.c. */
void mcv_strict_walk(mcv_strict *s);

/* Rules between members, of … */
void mcv_strict_data(mcv_strict *s);      /* data.c: buffers, images, textures; reads buffers */
void mcv_strict_accessors(mcv_strict *s); /* accessors.c: bufferViews, accessors, their values */
void mcv_strict_nodes(mcv_strict *s);     /* nodes.c: cameras, nodes, scenes, skins */
void mcv_strict_meshes(mcv_strict *s);    /* meshes.c */
void mcv_strict_animations(mcv_strict *s);

/* --- reading what may be wrong: walk.c has told what is --- */

/* An array of the root, or NULL; its element i if that is an object, or NULL. */
const json_t *mcv_strict_list(const mcv_strict *s, const char *name);
const json_t *mcv_strict_item(const mcv_strict *s, const char *name, size_t i);

/* The member as an integer from 0 on, or `usual` where it is none. */
uint64_t mcv_strict_uint(const json_t *object, const char *key, uint64_t usual);

/* The object that the member refers to; NULL where it does not exist. */
const json_t *mcv_strict_target(const mcv_strict *s, const json_t *object, const char *key,
                                const char *list);

/* "SCALAR" … "MAT4": numbers of an element, 0 for others; bytes of a component, 0 for others. */
unsigned mcv_strict_components(const json_t *accessor);
unsigned mcv_strict_component_bytes(uint64_t type);

/* Number k of element i, sparse values not counted; false where it cannot be read. */
bool mcv_strict_value(const mcv_strict *s, const json_t *accessor, uint64_t i, unsigned k,
                      double *value);

/* Has the accessor this type, and one of these component types ("f", "B" unsigned byte, "b", "H"
 * unsigned short, "h", "I"; upper case N behind: it must be normalized)? */
bool mcv_strict_has_format(const json_t *accessor, const char *type, const char *components);

#endif
