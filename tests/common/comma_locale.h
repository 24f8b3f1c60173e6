/* SPDX-License-Identifier: Apache-2.0 */
/* A locale whose numbers have a decimal comma, made on the spot: few machines have one. Include
 * behind cmocka.h. */
#ifndef MCVISI_TESTS_COMMA_LOCALE_H
#define MCVISI_TESTS_COMMA_LOCALE_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static const char comma_locale_definition[] =
    "LC_CTYPE\ncopy \"POSIX\"\nEND LC_CTYPE\n"
    "LC_COLLATE\ncopy \"POSIX\"\nEND LC_COLLATE\n"
    "LC_MONETARY\ncopy \"POSIX\"\nEND LC_MONETARY\n"
    "LC_MESSAGES\ncopy \"POSIX\"\nEND LC_MESSAGES\n"
    "LC_TIME\ncopy \"POSIX\"\nEND LC_TIME\n"
    "LC_NUMERIC\ndecimal_point \",\"\nthousands_sep \".\"\ngrouping 3;3\nEND LC_NUMERIC\n";

/* Sets LOCPATH to the working folder, where the locale "comma" then is. False without localedef. */
static inline bool make_comma_locale(void) {
    char folder[4096];
    FILE *file = fopen("comma.definition", "w");
    assert_non_null(file);
    assert_true(fputs(comma_locale_definition, file) >= 0);
    assert_int_equal(fclose(file), 0);
    /* It complains about the categories that are left out, and writes the locale. */
    if (system("localedef -c -i comma.definition ./comma >comma.log 2>&1") == -1 ||
        access("comma/LC_NUMERIC", R_OK) != 0)
        return false;
    return getcwd(folder, sizeof folder) && setenv("LOCPATH", folder, 1) == 0;
}

#endif
