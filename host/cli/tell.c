/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/tell.h"

#include "core/basics.h"

#include <stdio.h>

void mcv_tell(const char *severity, const char *text) {
    fprintf(stderr, "mcvisi: %s%s", severity ? severity : "", severity ? ": " : "");
    mcv_print_plain(stderr, text);
    fputc('\n', stderr);
}
