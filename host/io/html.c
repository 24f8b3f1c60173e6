/* SPDX-License-Identifier: Apache-2.0 */
#include "io/html.h"

#include "core/basics.h"
#include "core/output_file.h"
#include "io/embedded.h"

#include <stdlib.h>
#include <time.h>

void mcv_html_text(FILE *out, const char *text) {
    for (; *text; ++text) switch (*text) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        default:
            fputc(*text, out);
        }
}

void mcv_html_begin(FILE *out, const char *title, bool tables, const char *policy) {
    fprintf(out,
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
            "name=\"viewport\" content=\"width=device-width\">\n"
            "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
            "style-src '%s'",
            mcv_setup_css_hash);
    if (tables) fprintf(out, " '%s'", mcv_sweep_css_hash);
    fprintf(out, "%s\">\n<title>", policy);
    mcv_html_text(out, title);
    fprintf(out, "</title>\n<style>%s</style>", mcv_setup_css);
    if (tables) fprintf(out, "<style>%s</style>", mcv_sweep_css);
    fputs("</head><body>\n<h1>", out);
    mcv_html_text(out, title);
    fputs("</h1>\n", out);
}

void mcv_html_date(FILE *out) {
    const char *given = getenv("SOURCE_DATE_EPOCH");
    const time_t seconds = given ? (time_t)strtoll(given, NULL, 10) : time(NULL);
    struct tm day;
    char text[32] = "";
    if (gmtime_r(&seconds, &day)) strftime(text, sizeof text, "%Y-%m-%d", &day);
    fputs(text, out);
}

mcv_result mcv_html_write(const char *path, bool (*put)(FILE *out, void *user), void *user,
                          mcv_error *error) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    const bool written = out && put(out, user);
    if (!mcv_text_close(out, &text) || !written) {
        free(text);
        return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", path);
    }
    const mcv_result result = mcv_output_whole(path, text, size, error);
    free(text);
    return result;
}
