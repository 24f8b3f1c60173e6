/* SPDX-License-Identifier: Apache-2.0 */
#include "core/parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { MOST_THREADS = 64 };

typedef struct loop {
    atomic_size_t next;
    size_t count;
    void (*work)(void *user, size_t i);
    void *user;
} loop;

static void *run(void *argument) {
    loop *l = argument;
    for (size_t i; (i = atomic_fetch_add(&l->next, 1)) < l->count;) l->work(l->user, i);
    return NULL;
}

void mcv_in_parallel(size_t count, void (*work)(void *user, size_t i), void *user) {
    pthread_t threads[MOST_THREADS];
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    size_t wanted = cores > MOST_THREADS ? MOST_THREADS
                    : cores > 1          ? (size_t)cores
                                         : 1,
           started = 0;
    loop l = {.count = count, .work = work, .user = user};
    if (wanted > count) wanted = count;
    while (started + 1 < wanted && pthread_create(threads + started, NULL, run, &l) == 0) ++started;
    run(&l);
    for (size_t i = 0; i < started; ++i) pthread_join(threads[i], NULL);
}
