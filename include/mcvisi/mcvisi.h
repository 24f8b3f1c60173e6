/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MC ViSi: simulation of machine-vision systems. The public C API.
 *
 * Every function that can fail returns an mcv_result and writes one sentence into the caller's
 * mcv_error: what happened, where (file, JSON path, call), what would be right. No function exits
 * or prints. Units are SI.
 */
#ifndef MCVISI_MCVISI_H
#define MCVISI_MCVISI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* X(NAME, exit code, meaning): what functions return, and what the program exits with. */
#define MCV_RESULTS(X) \
    X(OK, 0, "done") \
    X(FAILED, 1, "the work failed") \
    X(USAGE, 2, "wrong usage") \
    X(BAD_INPUT, 3, "bad input") \
    X(DEVICE, 4, "device trouble") \
    X(INTERRUPTED, 130, "interrupted") \
    X(TERMINATED, 143, "terminated")

typedef enum mcv_result {
#define MCV_X(name, code, meaning) MCV_##name = (code),
    MCV_RESULTS(MCV_X)
#undef MCV_X
} mcv_result;

/* One sentence for the user; empty if nothing has failed. The caller owns it. */
typedef struct mcv_error {
    char text[2048];
} mcv_error;

/* Writes the sentence (printf style) and returns code, so that a failing function can end with
 * `return mcv_fail(…)`. */
mcv_result mcv_fail(mcv_error *error, mcv_result code, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* Returns from the calling function if `call` fails. The callee has written the sentence. */
#define MCV_TRY(call) \
    do { \
        const mcv_result mcv_try_result = (call); \
        if (mcv_try_result != MCV_OK) return mcv_try_result; \
    } while (0)

/* The version from project() in CMakeLists.txt, such as "0.2.0". */
const char *mcv_version(void);

#ifdef __cplusplus
}
#endif
#endif
