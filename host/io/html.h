/* SPDX-License-Identifier: Apache-2.0 */
/* Pages that need nothing else: no script, no network. */
#ifndef MCVISI_HOST_IO_HTML_H
#define MCVISI_HOST_IO_HTML_H

#include <stdbool.h>
#include <stdio.h>

#include "core/error.h"

/* Text as HTML and as an attribute's value: names of others cannot run. */
void mcv_html_text(FILE *out, const char *text);

/* All of a page's head, and its heading. `tables`: with the styles of tables and plots; `policy`:
 * what the page needs besides styles, as a content security policy says it ("; img-src data:"). */
void mcv_html_begin(FILE *out, const char *title, bool tables, const char *policy);

/* The day of SOURCE_DATE_EPOCH, for pages that are to be the same again, or today's. */
void mcv_html_date(FILE *out);

/* Writes a file by `put`, which returns false without memory; what stood there stays until the page
 * is whole. */
mcv_result mcv_html_write(const char *path, bool (*put)(FILE *out, void *user), void *user,
                          mcv_error *error);

#endif
