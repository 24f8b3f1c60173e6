/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/interrupt.h"

volatile sig_atomic_t mcv_interrupt;

static void receive(int signal) { mcv_interrupt = signal; }

void mcv_interrupt_watch(bool saving) {
    /* SA_RESETHAND: the handler runs once; the second signal has the default action, which ends the
     * program. */
    struct sigaction action = {.sa_handler = receive,
                               .sa_flags = SA_RESTART | (saving ? 0 : (int)SA_RESETHAND)};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

mcv_result mcv_interrupt_result(void) {
    const int signal = mcv_interrupt;
    return signal == 0 ? MCV_OK : signal == SIGTERM ? MCV_TERMINATED : MCV_INTERRUPTED;
}
