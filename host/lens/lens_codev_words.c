/* SPDX-License-Identifier: Apache-2.0 */
/* Statements of CODE V sequences as words, and the surfaces that they name. */
#include "lens/lens_codev.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

char *mcv_codev_next_statement(char **rest, int *line, int *next_line) {
    char *in = *rest, *out = *rest, *const begin = *rest, quote = '\0';
    if (!*in) return NULL;
    *line = *next_line;
    for (;; ++in) {
        if (*in == '\r') continue;
        if (*in == '!' && !quote) in += strcspn(in, "\n");
        if (*in == '&' && !quote) {
            char *after = in + 1 + strspn(in + 1, " \t\r");
            if (*after == '!') after += strcspn(after, "\n");
            if (*after == '\n') {
                ++*next_line;
                *out++ = ' ';
                in = after;
                continue;
            }
        }
        if (!*in || *in == '\n' || (*in == ';' && !quote)) break;
        if (quote ? *in == quote : *in == '\'' || *in == '"') quote = (char)(quote ? 0 : *in);
        *out++ = *in;
    }
    *next_line += *in == '\n';
    *rest = *in ? in + 1 : in;
    *out = '\0';
    return begin;
}

/* The surface that S3, SO, SI or SS names, SI being the image once it stands there; -1 if it is no
 * such word. */
static int surface_of(const mcv_codev *c, const char *word, char **end) {
    if (toupper((unsigned char)word[0]) != 'S') return -1;
    if (isdigit((unsigned char)word[1])) return (int)fmin((double)strtol(word + 1, end, 10), 1e6);
    *end = (char *)word + (word[1] ? 2 : 1);
    switch (toupper((unsigned char)word[1])) {
    case 'O':
        return 0;
    case 'I':
        return c->image ? c->l->count - 1 : 1000000;
    case 'S':
        return c->l->stop > 0 ? c->l->stop : 1;
    default:
        return -1;
    }
}

mcv_result mcv_codev_read_target(const mcv_codev *c, char **words, int n, mcv_codev_statement *s,
                                 mcv_error *error) {
    *s = (mcv_codev_statement){words + 1, n - 1, c->l->count - 1, c->l->count - 1, false, false};
    while (s->count > 0) {
        char *word = s->words[0], *end = word;
        const int surface = surface_of(c, word, &end);
        if (surface >= 0 && (*end == '\0' || strncmp(end, "..", 2) == 0)) {
            s->first = s->last = surface;
            if (*end) {
                char *to = end + 2, name[16];
                snprintf(name, sizeof name, "%s%.12s",
                         toupper((unsigned char)*to) == 'S' ? "" : "S", to);
                s->last = surface_of(c, name, &end);
            }
            if (s->last < s->first || s->last >= c->l->count)
                return mcv_codev_fail(c, -1, error, "there is no such surface yet: ", word);
            s->named = true;
        } else if (toupper((unsigned char)word[0]) == 'Z' && isdigit((unsigned char)word[1])) {
            s->zoom = strcmp(word + 1, "1") != 0;
        } else
            break;
        ++s->words;
        --s->count;
    }
    return MCV_OK;
}

bool mcv_codev_means(const char *word, const char *key) {
    return strncasecmp(word, key, 3) == 0 && (strlen(key) > 2 || strlen(word) == strlen(key));
}

bool mcv_codev_means_one_of(const char *word, const char *list) {
    char start[4];
    snprintf(start, sizeof start, "%.3s", word);
    return mcv_lens_is_one_of(start, list);
}
