/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/interrupt.h"

#include <time.h>

volatile sig_atomic_t mcv_interrupt;

static void receive(int signal) { mcv_interrupt = signal; }

static void pass_over(int signal) { (void)signal; }

static sigset_t save_signals(void) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGUSR1);
    return set;
}

void mcv_interrupt_prepare(void) { signal(SIGXFSZ, SIG_IGN); }

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
    /* SA_RESETHAND: the handler runs once; the second signal has the default action, which ends the
     * program. */
    struct sigaction before,
        action = {.sa_handler = receive, .sa_flags = SA_RESTART | (saving ? 0 : (int)SA_RESETHAND)};
    sigemptyset(&action.sa_mask);
    sigaction(SIGUSR1, &(struct sigaction){.sa_handler = pass_over, .sa_flags = SA_RESTART}, NULL);
    mcv_interrupt_prepare();
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i) {
        if (mcv_interrupt && !saving) return;
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
