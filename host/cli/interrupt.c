/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/interrupt.h"

#include "core/basics.h"
#include "core/kernel_folder.h"

#undef NDEBUG /* with it, <assert.h> does not declare what is defined below */
#include <assert.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

volatile sig_atomic_t mcv_interrupt;

/* A signal that follows the first one within this time is a part of it: programs such as timeout
 * send theirs to the process, and again to its group [ms]. */
static const long long together = 500;

static atomic_llong begun; /* when the first signal came [ms]; 0: none has */
static volatile sig_atomic_t is_saving;

static void receive(int number) {
    struct timespec time;
    long long before = 0;
    clock_gettime(CLOCK_MONOTONIC, &time);
    const long long now = 1000 * (long long)time.tv_sec + time.tv_nsec / 1000000 + 1;
    if (atomic_compare_exchange_strong(&begun, &before, now)) {
        mcv_interrupt = number;
    } else if (!is_saving && now - before > together) {
        signal(number, SIG_DFL);
        raise(number); /* comes when this returns */
    }
}

static void pass_over(int signal) { (void)signal; }

static sigset_t save_signals(void) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGUSR1);
    return set;
}

/* --- crashes --- */

static char last_words[MCV_KERNEL_FOLDER + 256];

/* The handler is gone when this runs: the signal comes again with its default action. */
static void break_off(int number) {
    const ssize_t ignored = write(STDERR_FILENO, last_words, strlen(last_words));
    (void)ignored;
    raise(number);
}

/* In place of the C library's: an assertion in a driver ends here, with the same words. The handler
 * would not run: LLVM in the driver has one of its own. */
/* NOLINTNEXTLINE(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */
void __assert_fail(const char *assertion, const char *file, unsigned line, const char *function) {
    fprintf(stderr, "mcvisi: %s:%u: %s: Assertion `%s' failed.\n", file, line,
            function ? function : "", assertion);
    signal(SIGABRT, SIG_DFL);
    break_off(SIGABRT);
    abort();
}

/* Handlers of sanitizers stay. */
static void watch_crashes(void) {
    static const int signals[] = {SIGABRT, SIGSEGV, SIGBUS, SIGILL, SIGFPE};
    char folder[MCV_KERNEL_FOLDER] = "";
    FILE *text = last_words[0] ? NULL : fmemopen(last_words, sizeof last_words - 1, "w");
    if (text && mcv_kernel_folder(folder)) {
        fputs("mcvisi: the OpenCL driver or this program broke off: if it does so again, a file of "
              "compiled kernels may be damaged: delete the folder ",
              text);
        mcv_print_plain(text, folder);
        fputc('\n', text);
    }
    if (text) fclose(text);
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i) {
        struct sigaction before, action = {.sa_handler = break_off, .sa_flags = (int)SA_RESETHAND};
        sigemptyset(&action.sa_mask);
        if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler == SIG_DFL)
            sigaction(signals[i], &action, NULL);
    }
}

void mcv_interrupt_prepare(void) {
    signal(SIGXFSZ, SIG_IGN);
    watch_crashes();
}

void mcv_interrupt_keep_saves(void) {
    const sigset_t set = save_signals();
    pthread_sigmask(SIG_BLOCK, &set, NULL);
}

bool mcv_interrupt_take_save(void) {
    const sigset_t set = save_signals();
    return sigtimedwait(&set, NULL, &(struct timespec){0, 0}) == SIGUSR1;
}

void mcv_interrupt_watch(bool saving) {
    static const int signals[] = {SIGINT, SIGTERM, SIGXCPU, SIGHUP};
    struct sigaction before, action = {.sa_handler = receive, .sa_flags = SA_RESTART};
    is_saving = saving;
    sigemptyset(&action.sa_mask);
    sigaction(SIGUSR1, &(struct sigaction){.sa_handler = pass_over, .sa_flags = SA_RESTART}, NULL);
    mcv_interrupt_prepare();
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i) {
        const bool ignored = signals[i] == SIGHUP && sigaction(SIGHUP, NULL, &before) == 0 &&
                             before.sa_handler == SIG_IGN;
        if (!ignored) sigaction(signals[i], &action, NULL);
    }
}

mcv_result mcv_interrupt_result(void) {
    const int signal = mcv_interrupt;
    return signal == 0 ? MCV_OK : signal == SIGTERM ? MCV_TERMINATED : MCV_INTERRUPTED;
}

int mcv_interrupt_code(mcv_result result, mcv_error *error) {
    const int signal = mcv_interrupt;
    const bool ended = result == MCV_INTERRUPTED || result == MCV_TERMINATED;
    if (signal == 0 || (!ended && result != MCV_DEVICE)) return (int)result;
    if (!ended) mcv_fail(error, result, "interrupted before the first sample");
    return 128 + signal;
}
