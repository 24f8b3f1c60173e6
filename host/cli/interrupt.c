/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/interrupt.h"

volatile sig_atomic_t mcv_interrupt, mcv_save_request;

static void receive(int signal) { mcv_interrupt = signal; }

static void receive_save(int signal) {
    (void)signal;
    mcv_save_request = 1;
}

void mcv_interrupt_prepare(void) { signal(SIGXFSZ, SIG_IGN); }

void mcv_interrupt_watch_saves(void) {
    struct sigaction action = {.sa_handler = receive_save, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGUSR1, &action, NULL);
}

void mcv_interrupt_watch(bool saving) {
    static const int signals[] = {SIGINT, SIGTERM, SIGXCPU, SIGHUP};
    /* SA_RESETHAND: the handler runs once; the second signal has the default action, which ends the
     * program. */
    struct sigaction before,
        action = {.sa_handler = receive, .sa_flags = SA_RESTART | (saving ? 0 : (int)SA_RESETHAND)};
    sigemptyset(&action.sa_mask);
    mcv_interrupt_watch_saves();
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
