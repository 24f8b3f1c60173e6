/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/program_start.h"

#include "core/basics.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* --- its words --- */

static const char *const kinds[] = {"exec(", "worker("};

bool mcv_program_named(const char *text) {
    return strncmp(text, kinds[0], strlen(kinds[0])) == 0 ||
           strncmp(text, kinds[1], strlen(kinds[1])) == 0;
}

/* Takes a word in place, without its quotes; *end follows it. NULL where quotes are not closed. */
static char *take_word(char *text, char **end) {
    char *to = text;
    bool quoted = false;
    for (; *text && (quoted || *text != ' '); ++text) {
        if (*text == '"')
            quoted = !quoted;
        else
            *to++ = *text;
    }
    *end = *text ? text + 1 : text;
    char *last = to;
    *last = '\0';
    return quoted ? NULL : to;
}

mcv_result mcv_program_read(const char *text, mcv_program *p, mcv_error *error) {
    *p = (mcv_program){.stays = text[0] == 'w', .input = -1, .output = -1, .errors = -1};
    const size_t begin = strlen(kinds[p->stays]), length = strlen(text);
    if (length <= begin || text[length - 1] != ')')
        return mcv_fail(error, MCV_USAGE, "%s: must end in ), as in exec(python3 judge.py)", text);
    p->text = strndup(text + begin, length - begin - 1);
    if (!p->text) return mcv_fail(error, MCV_FAILED, "no memory for %s", text);
    size_t count = 0;
    for (char *at = p->text, *end; at += strspn(at, " "), *at; at = end) {
        if (count == MCV_PROGRAM_WORDS)
            return mcv_fail(error, MCV_USAGE, "%s: has more than %d words", text,
                            MCV_PROGRAM_WORDS);
        p->words[count++] = at;
        if (!take_word(at, &end))
            return mcv_fail(error, MCV_USAGE, "%s: a quote \" is not closed", text);
    }
    for (size_t i = 0; i < 2 && i < count; ++i) {
        const size_t at = strlen(p->name);
        snprintf(p->name + at, sizeof p->name - at, "%s%.*s", i ? " " : "",
                 mcv_whole_characters(p->words[i], 30), p->words[i]);
    }
    return count ? MCV_OK
                 : mcv_fail(error, MCV_USAGE,
                            "%s: names no program: give its name and its words, as in "
                            "exec(python3 judge.py)",
                            text);
}

/* --- its process --- */

static void close_end(int *end) {
    if (*end >= 0) close(*end);
    *end = -1;
}

/* Signals as in a fresh process: a client may ignore some, or block them in its threads. */
static int prepare(posix_spawnattr_t *attributes) {
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    return posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF |
                                                    POSIX_SPAWN_SETSIGMASK) ||
           posix_spawnattr_setpgroup(attributes, 0) ||
           posix_spawnattr_setsigmask(attributes, &none) ||
           posix_spawnattr_setsigdefault(attributes, &all);
}

static int spawn(mcv_program *p, const int theirs[3]) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    if (posix_spawn_file_actions_init(&actions)) return ENOMEM;
    if (posix_spawnattr_init(&attributes)) {
        posix_spawn_file_actions_destroy(&actions);
        return ENOMEM;
    }
    int failed = prepare(&attributes) ? ENOMEM : 0;
    for (int i = 0; i < 3 && !failed; ++i)
        failed = posix_spawn_file_actions_adddup2(&actions, theirs[i], i);
    if (!failed)
        failed = posix_spawnp(&p->process, p->words[0], &actions, &attributes, p->words, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (failed) p->process = 0;
    return failed;
}

/* Its standard input is a socket: what is written after its end raises no signal here. */
mcv_result mcv_program_start(mcv_program *p, mcv_error *error) {
    int input[2] = {-1, -1}, output[2] = {-1, -1}, errors[2] = {-1, -1};
    int failed = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, input) ||
                         pipe2(output, O_CLOEXEC) || pipe2(errors, O_CLOEXEC)
                     ? errno
                     : 0;
    p->input = input[0];
    p->output = output[0];
    p->errors = errors[0];
    if (!failed) failed = spawn(p, (const int[3]){input[1], output[1], errors[1]});
    close_end(input + 1);
    close_end(output + 1);
    close_end(errors + 1);
    if (!failed) return MCV_OK;
    mcv_program_stop(p);
    return mcv_fail(error, MCV_FAILED, "cannot be started: %s", strerror(failed));
}

void mcv_program_stop(mcv_program *p) {
    close_end(&p->input);
    close_end(&p->output);
    close_end(&p->errors);
    if (p->process <= 0) return;
    kill(-p->process, SIGKILL);
    while (waitpid(p->process, NULL, 0) < 0 && errno == EINTR) continue;
    p->process = 0;
}

void mcv_program_free(mcv_program *p) {
    if (!p->text) return;
    mcv_program_stop(p);
    free(p->text);
    *p = (mcv_program){.input = -1, .output = -1, .errors = -1};
}
