/* Faults that are armed from outside: the file ARMED has a line "call fault time", and at the first
 * such call at that time [s] or later the FMU does what it says. Calls: instantiate, initialise, set,
 * get, step, terminate, free. */
#ifdef ARMED
#define _GNU_SOURCE
#include <locale.h>
#include <fenv.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static void sleep_for(double s) {
    struct timespec left = {(time_t)s, (long)(1e9 * (s - (time_t)s))};
    while (nanosleep(&left, &left)) continue; /* after a signal */
}
static int overflow(volatile int n) {
    volatile char room[4096];
    room[n % 4096] = (char)n;
    return overflow(n + 1) + room[0];
}
static void *spin(void *stops) {
    while (!stops) continue;
    return NULL;
}
static void *work(void *unused) { sleep_for(600); return NULL; }

static void do_harm(const char *fault) {
    pthread_t thread;
#define IS(name) (!strcmp(fault, name))
    if (IS("segv")) *(volatile int *)0 = 1;
    if (IS("abort")) abort();
    if (IS("words")) { fputs("out of oil\n", stderr); abort(); }
    if (IS("trap")) __builtin_trap();
    if (IS("divide")) { volatile int zero = 0; zero = 10 / zero; }
    if (IS("overflow")) overflow(0);
    if (IS("heap")) { char *p = malloc(24); free(p); free(p); abort(); }
    if (IS("exit")) exit(0);
    if (IS("_exit")) _exit(0);
    if (IS("pthread_exit")) pthread_exit(NULL);
    if (IS("kill")) kill(getpid(), SIGKILL);
    if (IS("stop")) kill(getpid(), SIGSTOP);
    if (IS("spin")) spin(NULL);
    if (IS("sleep")) sleep_for(600);
    if (IS("nap")) sleep_for(0.02);
    if (IS("thread")) pthread_create(&thread, NULL, work, NULL);
    if (IS("fork") && !fork()) sleep_for(600), _exit(0);
    if (IS("fork_crash")) { if (!fork()) sleep_for(600), _exit(0); abort(); }
    if (IS("memory")) for (;;) memset(malloc(1 << 24), 1, 1 << 24);
    if (IS("print")) for (int k = 0; k < 20000; k++) printf("%d bottles on the wall\n", k);
    if (IS("close")) for (int k = 0; k < 64; k++) close(k);
    if (IS("litter")) { FILE *f = fopen("litter.txt", "w"); if (f) { fputs("x", f); fclose(f); } }
    if (IS("folder") && chdir("/")) abort();
    if (IS("rounding")) fesetround(FE_UPWARD);
    if (IS("locale")) setlocale(LC_ALL, "C");
}

static void trouble(const char *call, double t) {
    char where[32], fault[32];
    double time;
    static int done;
    FILE *file = done ? NULL : fopen(ARMED, "r");
    if (!file) return;
    const int found = fscanf(file, "%31s %31s %lf", where, fault, &time);
    fclose(file);
    if (found != 3 || strcmp(call, where) || t < time - 1e-9) return;
    done = 1;
    do_harm(fault);
}
#else
#define trouble(call, t)
#endif
