/* SPDX-License-Identifier: Apache-2.0 */
#include "api/border.h"

#include <stdlib.h>

/* The C library keeps the C locale: nothing is made, and nothing is to be freed. Where it cannot be
 * had, numbers are read as the host's locale says. */
locale_t mcv_border_enter(void) {
    const locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return uselocale(c);
}

void mcv_border_leave(locale_t host) {
    const locale_t c = uselocale(host);
    if (c != host && c != LC_GLOBAL_LOCALE) freelocale(c);
}

void mcv_text_free(char *text) { free(text); }
