#define _POSIX_C_SOURCE 200809L
#include "report/parallel.h"

#include <pthread.h>
#include <unistd.h>

enum { MAX_THREADS = 64 };

typedef struct pool {
    pthread_mutex_t lock;
    int next, count;
    bool failed;
    bool (*work)(void *user, int i);
    void *user;
} pool;

static int take(pool *p, bool last_worked)
{
    pthread_mutex_lock(&p->lock);
    p->failed |= !last_worked;
    int i = p->next < p->count && !p->failed ? p->next++ : -1;
    pthread_mutex_unlock(&p->lock);
    return i;
}

static void *work_on(void *argument)
{
    pool *p = argument;
    for (int i = take(p, true); i >= 0;)
        i = take(p, p->work(p->user, i));
    return NULL;
}

int parallel_threads(void)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    return processors < 1 ? 1 : processors < MAX_THREADS ? (int)processors : MAX_THREADS;
}

bool parallel_each(int count, bool (*work)(void *user, int i), void *user)
{
    pthread_t threads[MAX_THREADS];
    pool p = { PTHREAD_MUTEX_INITIALIZER, 0, count, false, work, user };
    int started = 0, wanted = parallel_threads() - 1;
    while (started < wanted && started < count - 1 && pthread_create(&threads[started], NULL, work_on, &p) == 0)
        started++;
    work_on(&p);
    while (started > 0)
        pthread_join(threads[--started], NULL);
    pthread_mutex_destroy(&p.lock);
    return !p.failed;
}
