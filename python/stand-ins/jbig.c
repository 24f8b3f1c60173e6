/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stands for libjbig in the wheel. Debian's libtiff calls it for JBIG, a compression of facsimiles,
 * but it is under the GPL and cannot be in a package under the Apache licence. Here each call
 * fails, so that libtiff refuses a file in JBIG and says why. Success would be 0 or 2.
 */
enum { FAILED = 0x60 };

#define NOTHING(name) \
    void *name(void); \
    void *name(void) { return 0; }

NOTHING(jbg_enc_init)
NOTHING(jbg_enc_out)
NOTHING(jbg_enc_free)
NOTHING(jbg_dec_init)
NOTHING(jbg_dec_getimage)
NOTHING(jbg_dec_getsize)
NOTHING(jbg_dec_free)

int jbg_newlen(void);
int jbg_newlen(void) { return FAILED; }

int jbg_dec_in(void);
int jbg_dec_in(void) { return FAILED; }

const char *jbg_strerror(void);
const char *jbg_strerror(void) { return "this package reads no JBIG"; }
