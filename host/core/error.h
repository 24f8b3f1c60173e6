/* SPDX-License-Identifier: Apache-2.0 */
/* How functions inside fail; codes and sentences are those of the public header. */
#ifndef MCVISI_HOST_CORE_ERROR_H
#define MCVISI_HOST_CORE_ERROR_H

#include "mcvisi/mcvisi.h"

#include <stdarg.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writes the sentence (printf style) and returns code, so that a failing function ends in `return
 * mcv_fail(…)`. */
mcv_result mcv_fail(mcv_error *error, mcv_result code, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* Writes place and sentence. What does not fit is left out where it tells least: in long words,
 * then in the middle. If line feeds may stay, the end is left out. */
void mcv_write_sentence(mcv_error *error, bool lines, const char *place, const char *format,
                        va_list arguments)
#ifdef __GNUC__
    __attribute__((format(printf, 4, 0)))
#endif
    ;

/* clang's analyser sees by this that what fails does not return MCV_OK. */
#ifdef __clang_analyzer__
#define mcv_fail(error, code, ...) (mcv_fail(error, code, __VA_ARGS__), (code))
#endif

/* Leaves the calling function with a failed callee's code; the callee has written the sentence. */
#define MCV_TRY(call) \
    do { \
        const mcv_result mcv_try_result = (call); \
        if (mcv_try_result != MCV_OK) return mcv_try_result; \
    } while (0)

#ifdef __cplusplus
}
#endif
#endif
