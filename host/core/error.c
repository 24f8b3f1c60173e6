/* SPDX-License-Identifier: Apache-2.0 */
#include "core/error.h"

#include "core/basics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char dots[] = "…";

/* Takes the bytes from `from` to `to` out of a text, and puts dots there. */
static void leave_out(char *from, const char *to) {
    memmove(from + sizeof dots - 1, to, strlen(to) + 1);
    memcpy(from, dots, sizeof dots - 1);
}

/* Users' values are the only long words: numbers with commas, names. The sentence about them
 * follows or stands before. */
static void shorten_words(char *text) {
    enum { LONGEST = 512, SHOWN = 64 };
    for (char *word = text; *word;) {
        size_t length = strcspn(word, " \"/");
        if (length > 0 && word[length] == ' ' && strchr(":;,", word[length - 1]))
            --length; /* of the sentence */
        if (length > LONGEST) {
            const size_t shown = (size_t)mcv_whole_characters(word, SHOWN);
            leave_out(word + shown, word + length);
            length = shown + sizeof dots - 1;
        }
        word += length;
        word += strcspn(word, " \"/");
        word += *word != '\0';
    }
}

/* A text of many words lacks its middle: place and reason stand at the ends. */
static void shorten_middle(char *text, size_t size) {
    const size_t length = strlen(text), head = size / 2;
    if (length < size) return;
    const char *tail = text + length - (size - head - sizeof dots);
    while (((unsigned char)*tail & 0xc0) == 0x80) ++tail;
    leave_out(text + mcv_whole_characters(text, (int)head), tail);
}

void mcv_write_sentence(mcv_error *error, bool lines, const char *place, const char *format,
                        va_list arguments) {
    const size_t size = sizeof error->text;
    mcv_error sentence = {""}; /* the arguments may point into error */
    char *text = NULL, *whole = NULL;
    va_list again;
    va_copy(again, arguments);
    snprintf(sentence.text, size, "%s", place);
    const size_t length = strlen(sentence.text);
    const int more = vsnprintf(sentence.text + length, size - length, format, arguments);
    const bool fits = more >= 0 && strlen(place) + (size_t)more < size;
    if (fits && !lines) shorten_words(sentence.text);
    if (!fits && !lines && vasprintf(&text, format, again) < 0) text = NULL;
    if (text && asprintf(&whole, "%s%s", place, text) >= 0) {
        shorten_words(whole);
        shorten_middle(whole, size);
        snprintf(sentence.text, size, "%s", whole);
        free(whole);
    }
    free(text);
    va_end(again);
    for (char *c = sentence.text; *c && !lines; ++c) /* a name may not begin a line of its own */
        if (*c == '\n' || *c == '\r') *c = ' ';
    *error = sentence;
}

mcv_result(mcv_fail)(mcv_error *error, mcv_result code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    mcv_write_sentence(error, code == MCV_DEVICE, "", format, arguments); /* compilers have lines */
    va_end(arguments);
    return code;
}

const char *mcv_version(void) { return MCV_VERSION; }
