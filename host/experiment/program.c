/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/program.h"

#include "core/basics.h"
#include "experiment/program_start.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* What goes to and fro while one question is answered. */
typedef struct talk {
    const char *question; /* what is left to be sent; then a line feed */
    size_t left;
    char *answer;
    size_t size, room;
    char said[512]; /* the end of standard error */
    size_t said_size;
    bool ended; /* standard output is closed */
} talk;

static void send_some(const mcv_program *p, talk *t) {
    const ssize_t sent = send(p->input, t->question, t->left, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EAGAIN || errno == EINTR)) return;
    /* A program that reads nothing may answer all the same. */
    t->left = sent < 0 ? 0 : t->left - (size_t)sent;
    t->question += sent < 0 ? 0 : sent;
    if (t->left == 0 && !p->stays) shutdown(p->input, SHUT_WR);
}

static mcv_result receive(const mcv_program *p, talk *t, mcv_error *error) {
    if (t->room - t->size < 4096) {
        char *more = t->room < MCV_PROGRAM_ANSWER ? realloc(t->answer, 2 * t->room + 8192) : NULL;
        if (!more)
            return mcv_fail(error, MCV_FAILED, "its answer is longer than %d bytes",
                            MCV_PROGRAM_ANSWER);
        t->answer = more;
        t->room = 2 * t->room + 8192;
    }
    const ssize_t got = read(p->output, t->answer + t->size, t->room - t->size - 1);
    if (got < 0) return MCV_OK; /* EINTR: once more */
    t->ended = got == 0;
    t->size += (size_t)got;
    t->answer[t->size] = '\0';
    return MCV_OK;
}

/* Keeps the last half of a full buffer. False at the end. */
static bool receive_error(const mcv_program *p, talk *t) {
    const size_t most = sizeof t->said - 1;
    if (t->said_size > most / 2) {
        memmove(t->said, t->said + t->said_size - most / 2, most / 2);
        t->said_size = most / 2;
    }
    const ssize_t got = read(p->errors, t->said + t->said_size, most - t->said_size);
    t->said_size += got > 0 ? (size_t)got : 0;
    t->said[t->said_size] = '\0';
    return got != 0;
}

static bool is_answered(const mcv_program *p, const talk *t) {
    return t->ended || (p->stays && t->size > 0 && memchr(t->answer, '\n', t->size));
}

static mcv_result talk_with(mcv_program *p, talk *t, double until,
                            mcv_program_interrupted *interrupted, void *user, mcv_error *error) {
    while (!is_answered(p, t)) {
        struct pollfd ends[3] = {
            {p->output, POLLIN, 0}, {p->errors, POLLIN, 0}, {t->left ? p->input : -1, POLLOUT, 0}};
        const mcv_result stopped = interrupted ? interrupted(user) : MCV_OK;
        if (stopped != MCV_OK) return mcv_fail(error, stopped, "interrupted");
        if (mcv_seconds() > until)
            return mcv_fail(error, MCV_FAILED, "gave no answer within %g s", p->limit);
        if (poll(ends, 3, 50) <= 0) continue;
        if (ends[2].revents) send_some(p, t);
        if (ends[1].revents && !receive_error(p, t)) {
            close(p->errors);
            p->errors = -1;
        }
        if (ends[0].revents) MCV_TRY(receive(p, t, error));
    }
    return MCV_OK;
}

/* The last line of standard error, as the reason. */
static const char *reason(talk *t) {
    while (t->said_size > 0 && strchr("\r\n ", t->said[t->said_size - 1]))
        t->said[--t->said_size] = '\0';
    const char *line = strrchr(t->said, '\n');
    return line ? line + 1 : t->said;
}

/* Waits for the end of a program that has closed its output. */
static mcv_result await_end(mcv_program *p, talk *t, double until, mcv_error *error) {
    int status = 0;
    while (waitpid(p->process, &status, WNOHANG) == 0) {
        if (mcv_seconds() > until)
            return mcv_fail(error, MCV_FAILED, "did not end within %g s", p->limit);
        usleep(2000);
    }
    if (p->errors >= 0) receive_error(p, t);
    p->process = 0;
    const char *why = reason(t), *between = *why ? ": " : "";
    if (WIFSIGNALED(status))
        return mcv_fail(error, MCV_FAILED, "was ended by signal %d%s%s", WTERMSIG(status), between,
                        why);
    if (WEXITSTATUS(status))
        return mcv_fail(error, MCV_FAILED, "ended with code %d%s%s", WEXITSTATUS(status), between,
                        why);
    return p->stays ? mcv_fail(error, MCV_FAILED, "ended without an answer%s%s", between, why)
                    : MCV_OK;
}

mcv_result mcv_program_ask(mcv_program *p, const char *question,
                           mcv_program_interrupted *interrupted, void *user, char **answer,
                           mcv_error *error) {
    const double until = mcv_seconds() + p->limit;
    mcv_error why = {""};
    talk t = {.question = question, .left = strlen(question)};
    *answer = NULL;
    mcv_result result = p->process ? MCV_OK : mcv_program_start(p, &why);
    if (result == MCV_OK) result = talk_with(p, &t, until, interrupted, user, &why);
    if (result == MCV_OK && t.ended) result = await_end(p, &t, until, &why);
    if (result != MCV_OK || !p->stays) mcv_program_stop(p);
    if (result == MCV_OK) {
        *answer = t.answer;
        return MCV_OK;
    }
    free(t.answer);
    return mcv_fail(error, result, "the program %s %s", p->name, why.text);
}
