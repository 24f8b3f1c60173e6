/* SPDX-License-Identifier: Apache-2.0 */
/* Pages that need nothing else: no script, no network. */
#ifndef MCVISI_HOST_IO_HTML_H
#define MCVISI_HOST_IO_HTML_H

#include <stdio.h>

/* Text as HTML and as an attribute's value: names of others cannot run. */
void mcv_html_text(FILE *out, const char *text);

#endif
