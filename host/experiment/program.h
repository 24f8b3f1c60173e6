/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A program of the user that answers questions: a line of JSON on its standard input, a line of
 * JSON on its standard output. It is started by its words, without a shell, in a process group of
 * its own, which is killed where it takes too long.
 */
#ifndef MCVISI_HOST_EXPERIMENT_PROGRAM_H
#define MCVISI_HOST_EXPERIMENT_PROGRAM_H

#include "core/error.h"

#include <stdbool.h>
#include <sys/types.h>

enum { MCV_PROGRAM_WORDS = 64, MCV_PROGRAM_ANSWER = 1 << 20 };

/* Filled in by mcv_program_read; to be freed by mcv_program_free. */
typedef struct mcv_program {
    char *text;                         /* the words, each ended by '\0' */
    char *words[MCV_PROGRAM_WORDS + 1]; /* NULL at the end */
    char name[64];                      /* the first two words, for messages */
    bool stays;                /* it answers line after line, else it is started for each */
    double limit;              /* seconds for an answer */
    pid_t process;             /* 0: it does not run */
    int input, output, errors; /* our ends */
} mcv_program;

/* Asked some ten times a second while a program works: any result but MCV_OK ends it. */
typedef mcv_result mcv_program_interrupted(void *user);

/* Takes "exec(WORDS)", or "worker(WORDS)" of a program that stays, apart: blanks part words,
 * "quotes" hold some together. MCV_USAGE says what is wrong. */
mcv_result mcv_program_read(const char *text, mcv_program *program, mcv_error *error);
bool mcv_program_named(const char *text); /* whether it looks like one */

/*
 * Asks; *answer is freed by the caller. MCV_FAILED with a sentence where it cannot be started, ends
 * without an answer or with an exit code, or takes longer than its limit: it is killed then, and
 * started anew for the next question.
 */
mcv_result mcv_program_ask(mcv_program *program, const char *question,
                           mcv_program_interrupted *interrupted, void *user, char **answer,
                           mcv_error *error);

/* Ends and frees it. */
void mcv_program_free(mcv_program *program);

#endif
