/* SPDX-License-Identifier: Apache-2.0 */
/* What stands between the public functions (mcvisi/mcvisi.h) and the rest. */
#ifndef MCVISI_HOST_API_BORDER_H
#define MCVISI_HOST_API_BORDER_H

#include "core/error.h"

#include <locale.h>

/*
 * Inside, numbers are read and written by the C locale, whatever the host program has set: enter
 * sets it for the calling thread and returns the host's, which leave sets again. Callbacks run
 * between leave and enter.
 */
locale_t mcv_border_enter(void);
void mcv_border_leave(locale_t host);

/* Calls a function inside. */
#define MCV_INSIDE(result, call) \
    do { \
        const locale_t mcv_host = mcv_border_enter(); \
        (result) = (call); \
        mcv_border_leave(mcv_host); \
    } while (0)

/* Leaves the function where an argument that must be there is NULL. */
#define MCV_NEED(argument) \
    do { \
        if (!(argument)) \
            return mcv_fail(error, MCV_USAGE, "%s: %s must not be NULL", __func__, #argument); \
    } while (0)

#endif
