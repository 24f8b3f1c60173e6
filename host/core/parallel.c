/* SPDX-License-Identifier: Apache-2.0 */
#include "core/parallel.h"

#include <locale.h>
#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { MOST_THREADS = 64 };

typedef struct loop {
    atomic_size_t next;
    size_t count;
    void (*work)(void *user, size_t i);
    void *user;
    locale_t locale; /* the caller's: texts that are written must not depend on the thread */
} loop;

static void work(loop *l) {
    for (size_t i; (i = atomic_fetch_add(&l->next, 1)) < l->count;) l->work(l->user, i);
}

static void *run(void *argument) {
    loop *l = argument;
    uselocale(l->locale);
    work(l);
    return NULL;
}

void mcv_in_parallel(size_t count, void (*work_on)(void *user, size_t i), void *user) {
    pthread_t threads[MOST_THREADS];
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    size_t wanted = cores > MOST_THREADS ? MOST_THREADS
                    : cores > 1          ? (size_t)cores
                                         : 1,
           started = 0;
    loop l = {.count = count, .work = work_on, .user = user, .locale = uselocale((locale_t)0)};
    if (wanted > count) wanted = count;
    while (started + 1 < wanted && pthread_create(threads + started, NULL, run, &l) == 0) ++started;
    work(&l);
    for (size_t i = 0; i < started; ++i) pthread_join(threads[i], NULL);
}
