/* SPDX-License-Identifier: Apache-2.0 */
/* The members of glTF's objects as tables: what walk.c checks of each object by itself. */
#ifndef MCVISI_HOST_STRICT_RULES_H
#define MCVISI_HOST_STRICT_RULES_H

#include <stdbool.h>

typedef enum mcv_rule_kind {
    MCV_RULE_BOOLEAN,
    MCV_RULE_INTEGER,
    MCV_RULE_NUMBER,
    MCV_RULE_STRING,
    MCV_RULE_OBJECT,  /* of type `of` */
    MCV_RULE_LIST,    /* of objects of type `of` */
    MCV_RULE_NUMBERS, /* least … most of them; most 0: any */
    MCV_RULE_STRINGS,
    MCV_RULE_INDEX,     /* into the root's array `to` */
    MCV_RULE_INDICES,   /* unlike each other */
    MCV_RULE_REFERENCES /* an object of indices: attributes */
} mcv_rule_kind;

typedef struct mcv_rule_type mcv_rule_type;

typedef struct mcv_rule {
    const char *key;
    mcv_rule_kind kind;
    bool required, above; /* above: more than `low`, not equal */
    double low, high;     /* of numbers; both 0: any */
    const mcv_rule_type *of;
    const char *to;
    unsigned least, most;
} mcv_rule;

/* Rules end with a key NULL. */
struct mcv_rule_type {
    const char *name;
    const mcv_rule *rules;
};

typedef struct mcv_rule_extension {
    const char *name;
    const mcv_rule_type *at; /* the objects that may have it; NULL: none */
    const mcv_rule *rules;   /* of the extension's object */
} mcv_rule_extension;

extern const mcv_rule_type mcv_rule_root;

/* Ends with a name NULL; an extension that several kinds of object may have stands several
 * times. */
extern const mcv_rule_extension mcv_rule_extensions[];

#endif
