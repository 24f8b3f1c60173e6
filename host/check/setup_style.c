/* SPDX-License-Identifier: Apache-2.0 */
/* The style of a drawing of its own: rules of the page's style (check/setup.css) with the values of
 * their variables. */
#include "check/setup_drawing.h"
#include "io/embedded.h"

#include <string.h>

/* The value of a variable, "--ink" of `length` characters, in the style's first rule. */
static const char *value_of(const char *variable, size_t length, size_t *size) {
    for (const char *at = mcv_setup_css; (at = strstr(at, "--")); ++at) {
        if (strncmp(at, variable, length) != 0 || at[length] != ':') continue;
        *size = strcspn(at + length + 1, ";}");
        return at + length + 1;
    }
    *size = 0;
    return "";
}

/* A line of the style, "var(--ink)" replaced by its value. */
static void put_rules(FILE *out, const char *line, size_t length) {
    static const char variable[] = "var(";
    const char *end = line + length;
    while (line < end) {
        size_t size;
        if (strncmp(line, variable, sizeof variable - 1) != 0) {
            fputc(*line++, out);
            continue;
        }
        line += sizeof variable - 1;
        const size_t name = strcspn(line, ")");
        const char *value = value_of(line, name, &size);
        fwrite(value, 1, size, out);
        line += name + 1;
    }
    fputc('\n', out);
}

/* Rules of a drawing have lines of their own, which begin with a class or with svg. */
void mcv_put_drawing_style(FILE *out) {
    fputs("<style>svg{font-family:sans-serif}\n", out);
    for (const char *line = mcv_setup_css; *line;) {
        const size_t length = strcspn(line, "\n");
        if (*line == '.' || strncmp(line, "svg ", 4) == 0) put_rules(out, line, length);
        line += length + (line[length] == '\n');
    }
    /* Few programs draw a text's outline behind it. */
    fputs("svg text{stroke:none}</style>\n", out);
}
