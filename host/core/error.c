/* SPDX-License-Identifier: Apache-2.0 */
#include "core/error.h"

#include <stdarg.h>
#include <stdio.h>

mcv_result(mcv_fail)(mcv_error *error, mcv_result code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    for (char *c = error->text; *c && code != MCV_DEVICE; ++c) /* whose compiler has many lines */
        if (*c == '\n' || *c == '\r') *c = ' ';
    return code;
}

const char *mcv_version(void) { return MCV_VERSION; }
